// Strips: a laser's light on a piece of a sheet, blurred by the lens, with soft edges (strip.rs, coverage.rs), added up.
//
// Needs camera.wgsl.

struct Strip {
    // n, o
    plane: vec4<f32>,
    // g, and its brightness in DN m^2
    ridge: vec4<f32>,
    // motion of g, and half the angle of the fan up to its fading edge
    sweep: vec4<f32>,
    // source, and the light's width there
    source: vec4<f32>,
    // middle of the fan, and the growth of the width
    along: vec4<f32>,
    // square to it, and the exponent along the fan
    across: vec4<f32>,
    // albedo, specular, roughness, 1 / angle over which the fan's edge fades
    look: vec4<f32>,
    // m, and offset
    mirror: vec4<f32>,
    // specular, standard deviation of the lobe, 1 where the view is mirrored and 0 where the light is
    gloss: vec4<f32>,
    // first edge, edges, first hole, holes
    cuts: vec4<u32>,
    // first edge of the mirror's window, its edges
    window: vec4<u32>,
}

@group(0) @binding(2) var<storage, read> strips: array<Strip>;
@group(0) @binding(3) var<storage, read> edges: array<vec4<f32>>;
// first edge, edges
@group(0) @binding(4) var<storage, read> holes: array<vec2<u32>>;

// Whether these strips are seen by way of a mirror.
override MIRRORED: bool = false;

const SQRT_TAU: f32 = 2.5066283;
const FWHM_PER_SIGMA: f32 = 2.3548200;
// Narrowest softness of an edge, in pixels.
const SOFT_MIN_PX: f32 = 0.05;

struct Band {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) plane: vec4<f32>,
    @location(1) @interpolate(flat) ridge: vec4<f32>,
    @location(2) @interpolate(flat) sweep: vec4<f32>,
    @location(3) @interpolate(flat) source: vec4<f32>,
    @location(4) @interpolate(flat) along: vec4<f32>,
    @location(5) @interpolate(flat) across: vec4<f32>,
    @location(6) @interpolate(flat) look: vec4<f32>,
    @location(7) @interpolate(flat) mirror: vec4<f32>,
    @location(8) @interpolate(flat) gloss: vec4<f32>,
    @location(9) @interpolate(flat) cuts: vec4<u32>,
    @location(10) @interpolate(flat) window: vec4<u32>,
}

@vertex
fn strip_corner(corner: Corner) -> Band {
    let strip = strips[corner.item];
    return Band(
        clip_position(corner), strip.plane, strip.ridge, strip.sweep, strip.source, strip.along, strip.across, strip.look, strip.mirror,
        strip.gloss, strip.cuts, strip.window,
    );
}

// The ridge as the edges' formula sees it.
struct Ridge {
    across_px: f32,
    normal: vec2<f32>,
    // rho
    share: f32,
    // p
    blur_px: f32,
}

// The ridge for edges after which the light is blurred by a variance, of all that widens it.
fn softened(across_px: f32, normal: vec2<f32>, blur_px2: f32, all_px2: f32) -> Ridge {
    return Ridge(across_px, normal, 1.0 - blur_px2 / all_px2, sqrt(blur_px2));
}

// What two edges keep that alone keep the shares a and b and whose normals have this cosine.
fn together(a: f32, b: f32, cosine: f32) -> f32 {
    let c2 = cosine * cosine;
    let weight = abs(cosine) * (0.64 + 0.36 * (c2 * c2) * (c2 * c2));
    let parallel = select(min(a, b), max(a + b - 1.0, 0.0), cosine < 0.0);
    return a * b + weight * (parallel - a * b);
}

// Share of the light that a convex piece keeps.
fn coverage(ridge: Ridge, pixel: PixelRay, first: u32, count: u32) -> f32 {
    var kept = 1.0;
    var narrowest = vec2(0.0);
    let root_share = sqrt(max(ridge.share, 0.0));
    for (var i = first; i < first + count; i++) {
        let edge = edges[i].xyz;
        let slope = edge.xy * pixel.per_pixel;
        let per_px = inverseSqrt(dot(slope, slope));
        let distance = dot(edge, pixel.ray) * per_px;
        let inward = slope * per_px;
        let facing = dot(inward, ridge.normal);
        let along = ridge.normal.x * inward.y - ridge.normal.y * inward.x;
        // The normal where the scatter is round; its length is the edge's softness over p.
        let round = vec2(along, facing * root_share);
        let length_px = length(round);
        let z = (distance - (1.0 - ridge.share) * ridge.across_px * facing) / max(ridge.blur_px * length_px, SOFT_MIN_PX);
        let direction = round / max(length_px, 1e-9);
        let share = phi(z);
        let both = together(kept, share, dot(narrowest, direction));
        narrowest = select(narrowest, direction, share < kept);
        kept = both;
    }
    return kept;
}

@fragment
fn strip(in: Band) -> @location(0) vec2<f32> {
    let pixel = pixel_ray(in.position);
    let ray = pixel.ray;
    let approach = dot(in.plane.xyz, ray);
    let inverse = 1.0 / approach;
    let off_m = dot(in.ridge.xyz, ray) * inverse;
    let slope = ((in.ridge.xy - in.plane.xy * off_m) * inverse) * pixel.per_pixel;
    let per_px = inverseSqrt(dot(slope, slope));

    let point = ray * (in.plane.w * inverse);
    let way = point - in.source.xyz;
    let inverse_m = inverseSqrt(dot(way, way));
    let distance_m = 1.0 / inverse_m;
    let sigma_m = (in.source.w + in.along.w * distance_m) / FWHM_PER_SIGMA;
    // What the mirror's lobe adds: to the light's thickness in metres, or to the lens' blur in pixels.
    var lobe_m = 0.0;
    var lobe_px = 0.0;
    var mirrored = 1.0;
    if MIRRORED {
        let by_light = in.gloss.z == 0.0;
        let m_way = dot(in.mirror.xyz, way);
        let before_light = saturate((in.mirror.w - dot(in.mirror.xyz, in.source.xyz)) / m_way);
        let before_view = saturate(in.mirror.w / dot(in.mirror.xyz, point));
        lobe_m = select(0.0, in.gloss.y * distance_m * (1.0 - before_light), by_light);
        lobe_px = select(in.gloss.y * camera.focal_mean_px * (1.0 - before_view), 0.0, by_light);
        let cosine_light = abs(m_way) * inverse_m;
        let cosine_view = abs(dot(in.mirror.xyz, ray)) * inverseSqrt(dot(ray, ray));
        mirrored = fresnel(in.gloss.x, select(cosine_view, cosine_light, by_light));
    }

    let wide_m = sqrt(sigma_m * sigma_m + lobe_m * lobe_m);
    let sigma_px = wide_m * per_px;
    let moved_px = dot(in.sweep.xyz, ray) * inverse * per_px;
    let inward = slope * per_px;
    let extent = abs(inward);
    let narrow = min(extent.x, extent.y);
    let half = 0.5 * max(extent.x, extent.y);
    let blur_px2 = lens_px2(1.0 / point.z);
    let after_px2 = blur_px2 + lobe_px * lobe_px;
    let spread_px2 = sigma_px * sigma_px + after_px2 + (moved_px * moved_px + narrow * narrow) * BOX_PX2;
    let softness = inverseSqrt(spread_px2);
    let across_px = off_m * per_px;
    let integral = phi((across_px + half) * softness) - phi((across_px - half) * softness);

    let angle = atan2(dot(in.across.xyz, way), dot(in.along.xyz, way));
    let fade = saturate(1.0 - (abs(angle) - in.sweep.w) * in.look.w);
    let fan = exp(in.across.w * angle * angle) * fade;
    let cos_light = max(dot(in.plane.xyz, way) * inverse_m, 0.0);
    let view_m = inverseSqrt(dot(ray, ray));
    let half_way = normalize(way * inverse_m + ray * view_m);
    let shine = reflectance(
        in.look.xyz, cos_light, approach * view_m, dot(in.plane.xyz, half_way), dot(half_way, ray) * view_m,
    );
    let peak = mirrored * fan * cos_light * shine * falloff(ray) * inverse_m / (wide_m * FWHM_PER_SIGMA);
    var light = in.ridge.w * peak * SQRT_TAU * sigma_px * integral / (2.0 * half);

    let all_px2 = sigma_px * sigma_px + after_px2 + BOX_PX2;
    let ridge = softened(across_px, inward, after_px2 + BOX_PX2, all_px2);
    light *= coverage(ridge, pixel, in.cuts.x, in.cuts.y);
    if MIRRORED {
        let before_lens_px = lobe_m * per_px;
        let window = softened(across_px, inward, blur_px2 + before_lens_px * before_lens_px + BOX_PX2, all_px2);
        light *= coverage(window, pixel, in.window.x, in.window.y);
    }
    for (var i = in.cuts.z; i < in.cuts.z + in.cuts.w; i++) {
        let hole = holes[i];
        light *= 1.0 - coverage(ridge, pixel, hole.x, hole.y);
    }
    // Nothing from behind the camera, and no number that is none.
    return vec2(select(0.0, min(light, BRIGHTEST), light > 0.0 && approach > 0.0), 0.0);
}
