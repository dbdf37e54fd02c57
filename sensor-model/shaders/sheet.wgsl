// Regions: what headlamp, daylight and glow show of a sheet, and what seams and spangles take away.
//
// Needs camera.wgsl. Regions are drawn as polygons; what a pixel sees is computed from the region's plane and the pixel's ray.

struct Region {
    // n, o
    plane: vec4<f32>,
    // albedo, specular, roughness, spangle
    look: vec4<f32>,
    // s of the sheet's texture, and the brightness of an open end
    texture_s: vec4<f32>,
    // t likewise, and pairs of places along the way, 0 where the middle alone stands for it
    texture_t: vec4<f32>,
    // how s, t and n change in the exposure
    sweep_s: vec4<f32>,
    sweep_t: vec4<f32>,
    turn: vec4<f32>,
    // first seam, number of seams, bits of the sheet's number, first node of the glow
    marks: vec4<u32>,
    // column and row of that node; columns, which are 0 where there is no glow, and rows
    nodes: vec4<i32>,
}

struct Seam {
    // ridge, width
    ridge: vec4<f32>,
    sweep: vec4<f32>,
}

@group(0) @binding(2) var<storage, read> regions: array<Region>;
@group(0) @binding(3) var<storage, read> seams: array<Seam>;
@group(0) @binding(4) var<storage, read> glow: array<f32>;

override GLOWING: bool = false;

// Pixels between two nodes of the glow.
const SPACING_PX: f32 = 16.0;

struct Sheet {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) plane: vec4<f32>,
    @location(1) @interpolate(flat) look: vec4<f32>,
    @location(2) @interpolate(flat) texture_s: vec4<f32>,
    @location(3) @interpolate(flat) texture_t: vec4<f32>,
    @location(4) @interpolate(flat) marks: vec4<u32>,
    @location(5) @interpolate(flat) nodes: vec4<i32>,
    @location(6) @interpolate(flat) item: u32,
}

@vertex
fn sheet_corner(corner: Corner) -> Sheet {
    let region = regions[corner.item];
    return Sheet(
        clip_position(corner), region.plane, region.look, region.texture_s, region.texture_t, region.marks, region.nodes,
        corner.item,
    );
}

fn glow_at(in: Sheet) -> f32 {
    let columns = in.nodes.z;
    if columns == 0 {
        return 0.0;
    }
    let at = (in.position.xy - (camera.margin_px + 0.5)) / SPACING_PX - vec2<f32>(in.nodes.xy);
    let node = clamp(vec2<i32>(floor(at)), vec2(0), in.nodes.zw - 2);
    let share = at - vec2<f32>(node);
    let first = in.marks.w + u32(node.y * columns + node.x);
    let above = mix(glow[first], glow[first + 1u], share.x);
    let below = mix(glow[first + u32(columns)], glow[first + u32(columns) + 1u], share.x);
    return max(mix(above, below, share.y), 0.0);
}

fn smooth_light(in: Sheet, ray: vec3<f32>) -> f32 {
    let cosine = dot(in.plane.xyz, ray) * inverseSqrt(dot(ray, ray));
    // The sheet is met at the distance o / cosine.
    let inverse_m = cosine / in.plane.w;
    let lamp = camera.headlamp * reflectance(in.look.xyz, cosine, cosine, cosine, 1.0) * cosine * inverse_m * inverse_m;
    var light = falloff(ray) * (lamp + camera.daylight * in.texture_s.w);
    if GLOWING {
        light += camera.glow * glow_at(in);
    }
    return min(light, BRIGHTEST);
}

struct Patterned {
    @location(0) light: vec2<f32>,
    // 1 - T
    @location(1) shade: f32,
}

// With a lens that distorts, what is in front of what is not to be had from a triangle's corners.
struct Bent {
    @location(0) light: vec2<f32>,
    @builtin(frag_depth) depth: f32,
}

struct BentPatterned {
    @location(0) light: vec2<f32>,
    @location(1) shade: f32,
    @builtin(frag_depth) depth: f32,
}

fn depth_at(in: Sheet, ray: vec3<f32>) -> f32 {
    return 1e-3 * dot(in.plane.xyz, ray) / in.plane.w;
}

@fragment
fn sheet(in: Sheet) -> @location(0) vec2<f32> {
    return vec2(0.0, smooth_light(in, pixel_ray(in.position).ray));
}

@fragment
fn patterned_sheet(in: Sheet) -> Patterned {
    let pixel = pixel_ray(in.position);
    return Patterned(vec2(0.0, smooth_light(in, pixel.ray)), camera.share * (1.0 - pattern(in, pixel)));
}

@fragment
fn bent_sheet(in: Sheet) -> Bent {
    let ray = pixel_ray(in.position).ray;
    return Bent(vec2(0.0, smooth_light(in, ray)), depth_at(in, ray));
}

@fragment
fn bent_patterned_sheet(in: Sheet) -> BentPatterned {
    let pixel = pixel_ray(in.position);
    let light = vec2(0.0, smooth_light(in, pixel.ray));
    return BentPatterned(light, camera.share * (1.0 - pattern(in, pixel)), depth_at(in, pixel.ray));
}

fn finalise(bits: u32) -> u32 {
    var x = bits;
    x ^= x >> 16u;
    x *= 0x7feb352du;
    x ^= x >> 15u;
    x *= 0x846ca68bu;
    return x ^ (x >> 16u);
}

// `spangle_node` of noise.rs.
fn spangle_node(at: vec2<i32>, sheet_bits: u32) -> f32 {
    let node = vec2<u32>(at);
    let x = finalise((node.x * 0x8da6b343u) ^ (node.y * 0xd8163841u) ^ sheet_bits);
    let halves = (x & 0x00ff00ffu) + ((x >> 8u) & 0x00ff00ffu);
    return f32(i32((halves & 0xffffu) + (halves >> 16u)) - 510) / 147.80054;
}

// The weights of a node and the next, of which one is (1 - smoothstep, smoothstep) over the root of the sum of their squares.
fn weights(share: f32) -> vec2<f32> {
    let next = share * share * (3.0 - 2.0 * share);
    let pair = vec2(1.0 - next, next);
    return pair * inverseSqrt(dot(pair, pair));
}

fn spangle(at: vec2<f32>, sheet_bits: u32) -> f32 {
    let node = vec2<i32>(floor(at));
    let along_s = weights(at.x - floor(at.x));
    let along_t = weights(at.y - floor(at.y));
    let before = vec2(spangle_node(node, sheet_bits), spangle_node(node + vec2(1, 0), sheet_bits));
    let after = vec2(spangle_node(node + vec2(0, 1), sheet_bits), spangle_node(node + vec2(1, 1), sheet_bits));
    return along_t.x * dot(along_s, before) + along_t.y * dot(along_s, after);
}

// Distance of the two places of Gauss' rule from the middle of a part.
const GAUSS: f32 = 0.28867513;

// A shorter way, in pixels, is taken as this one, so that nothing is divided by 0; what it adds is taken from the pixel's own blur.
const WAY_MIN_PX: f32 = 0.5;

// The integral of Phi.
fn phi_integral(z: f32) -> f32 {
    return z * phi(z) + 0.39894228 * exp(-0.5 * z * z);
}

// What a gap takes at the distance `across` from its middle, moved along `way` and blurred.
fn smeared(across: f32, half: f32, way: f32, softness: f32) -> f32 {
    let far = phi_integral((across + half + 0.5 * way) * softness) - phi_integral((across + half - 0.5 * way) * softness);
    let near = phi_integral((across - half + 0.5 * way) * softness) - phi_integral((across - half - 0.5 * way) * softness);
    return (far - near) / (way * softness);
}

// T of a pixel.
fn pattern(in: Sheet, pixel: PixelRay) -> f32 {
    let inverse = 1.0 / dot(in.plane.xyz, pixel.ray);
    let blur_px2 = lens_px2(1.0 / (in.plane.w * inverse)) + BOX_PX2;
    let softness = inverseSqrt(blur_px2);
    var bright = 1.0;
    for (var i = in.marks.x; i < in.marks.x + in.marks.y; i++) {
        let seam = seams[i].ridge;
        let sweep = seams[i].sweep.xyz;
        let off_m = dot(seam.xyz, pixel.ray) * inverse;
        let slope = ((seam.xy - in.plane.xy * off_m) * inverse) * pixel.per_pixel;
        let per_px = inverseSqrt(dot(slope, slope));
        let across = off_m * per_px;
        let half = 0.5 * seam.w * per_px;
        if any(sweep != vec3(0.0)) {
            let moved = abs(dot(sweep, pixel.ray) * inverse * per_px);
            let way = max(moved, WAY_MIN_PX);
            bright *= 1.0 - smeared(across, half, way, inverseSqrt(blur_px2 - (way * way - moved * moved) * BOX_PX2));
        } else {
            bright *= 1.0 - phi((across + half) * softness) + phi((across - half) * softness);
        }
    }
    if in.look.w == 0.0 {
        return bright;
    }
    let s = dot(in.texture_s.xyz, pixel.ray) * inverse;
    let t = dot(in.texture_t.xyz, pixel.ray) * inverse;
    let slope_s = ((in.texture_s.xy - in.plane.xy * s) * inverse) * pixel.per_pixel;
    let slope_t = ((in.texture_t.xy - in.plane.xy * t) * inverse) * pixel.per_pixel;
    // 2 SPANGLE_SLOPE2 of noise.rs
    let lost = 1.0 + 6.744356 * blur_px2 * vec2(dot(slope_s, slope_s), dot(slope_t, slope_t));
    let strength = in.look.w * inverseSqrt(sqrt(lost.x * lost.y));
    let pairs = in.texture_t.w;
    if pairs == 0.0 {
        return bright * max(1.0 + strength * spangle(vec2(s, t), in.marks.z), 0.0);
    }
    let swept = vec2(dot(regions[in.item].sweep_s.xyz, pixel.ray), dot(regions[in.item].sweep_t.xyz, pixel.ray));
    let part = (swept - vec2(s, t) * dot(regions[in.item].turn.xyz, pixel.ray)) * (inverse / pairs);
    var sum = 0.0;
    for (var middle = 0.5 - 0.5 * pairs; middle < 0.5 * pairs; middle += 1.0) {
        sum += spangle(vec2(s, t) + (middle - GAUSS) * part, in.marks.z) + spangle(vec2(s, t) + (middle + GAUSS) * part, in.marks.z);
    }
    return bright * max(1.0 + strength * sum / (2.0 * pairs), 0.0);
}
