// Light that reaches each pixel, before lens and CCD: red is the lasers' light, green the headlamp's, in grey values above black.
//
// Walls are drawn as polygons; what a pixel sees is then computed from the polygon's plane and the pixel's ray, not interpolated.

struct Camera {
    // (a, b): clip coordinate = a * x + b * z
    clip_x: vec2<f32>,
    clip_y: vec2<f32>,
    // pixel to ray: (u, v) * scale + start
    ray_scale: vec2<f32>,
    ray_start: vec2<f32>,
    // DN m^2
    headlamp: f32,
    near_m: f32,
    line_width_m: f32,
    line_growth: f32,
}

struct Laser {
    normal: vec3<f32>,
    offset_m: f32,
    source: vec3<f32>,
    // DN m^2
    strength: f32,
    // middle of the fan, and half its angle
    along: vec3<f32>,
    half_rad: f32,
    across: vec3<f32>,
    // exponent of the profile along the fan for angle^2
    fan_exponent: f32,
    // 1 / angle over which its edge fades
    fade: f32,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<uniform> laser: Laser;
// first plane, number of planes
@group(0) @binding(2) var<storage, read> casters: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> planes: array<vec4<f32>>;

struct Fragment {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) plane: vec4<f32>,
    @location(1) @interpolate(flat) albedo: f32,
    @location(2) @interpolate(flat) casters: vec2<u32>,
}

struct Shaded {
    @location(0) light: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

// Light is cut here, so that four lasers on one spot stay below what a 16-bit float holds (65504): infinity times an empty tap of
// the point spread is not a number. It is far beyond saturation, since the point spread carries what no pixel shows to its
// neighbours: a lower cut would dim the skirts of a bright stripe.
const BRIGHTEST: f32 = 15000.0;

// 4 ln 2: exponent of the Gaussian across a slit for (distance / full width at half maximum)^2.
const ACROSS_EXPONENT: f32 = 2.7725887;

@vertex
fn corner(
    @location(0) position: vec3<f32>,
    @location(1) albedo: f32,
    @location(2) plane: vec4<f32>,
    @location(3) caster_range: vec2<u32>,
) -> Fragment {
    let x = dot(camera.clip_x, position.xz);
    let y = dot(camera.clip_y, position.yz);
    // Depth is near / z: 1 at the near plane, 0 at infinity.
    return Fragment(vec4(x, y, camera.near_m, position.z), plane, albedo, caster_range);
}

fn ray_of(position: vec4<f32>) -> vec3<f32> {
    return vec3(position.xy * camera.ray_scale + camera.ray_start, 1.0);
}

// A sheet under the headlamp.
@fragment
fn sheet(in: Fragment) -> Shaded {
    let ray = ray_of(in.position);
    let approach = dot(in.plane.xyz, ray);
    // The sheet is met at z = offset / approach; cos(incidence) / distance^2 from there.
    let inverse = inverseSqrt(dot(ray, ray));
    let cosine = approach * inverse;
    let inverse_m = cosine / in.plane.w;
    let light = camera.headlamp * in.albedo * cosine * inverse_m * inverse_m;
    return Shaded(vec4(0.0, min(light, BRIGHTEST), 0.0, 0.0), camera.near_m * approach / in.plane.w);
}

// Whether any of a range of bodies stands between the laser's source and a point.
fn shadowed(point: vec3<f32>, range: vec2<u32>) -> bool {
    let way = point - laser.source;
    for (var i = range.x; i < range.x + range.y; i++) {
        let caster = casters[i];
        var enter = 0.0;
        var leave = 1.0;
        for (var j = caster.x; j < caster.x + caster.y; j++) {
            let plane = planes[j];
            let approach = dot(plane.xyz, way);
            let distance = dot(plane.xyz, laser.source) - plane.w;
            if approach < 0.0 {
                enter = max(enter, -distance / approach);
            } else if approach > 0.0 {
                leave = min(leave, -distance / approach);
            } else if distance > 0.0 {
                leave = -1.0;
            }
        }
        // A lit face is entered at 1; 1e-5 of the way is single precision's rounding.
        if enter < leave && enter < 0.99999 {
            return true;
        }
    }
    return false;
}

// The strip of a sheet near a slit's plane.
@fragment
fn strip(in: Fragment) -> Shaded {
    let ray = ray_of(in.position);
    let approach = dot(in.plane.xyz, ray);
    let point = ray * (in.plane.w / approach);

    let way = point - laser.source;
    let inverse_m = inverseSqrt(dot(way, way));
    let width_m = camera.line_width_m + camera.line_growth / inverse_m;
    let off = (dot(laser.normal, point) - laser.offset_m) / width_m;
    let angle = atan2(dot(laser.across, way), dot(laser.along, way));
    let profile = exp(laser.fan_exponent * angle * angle - ACROSS_EXPONENT * off * off);
    let fade = saturate(1.0 - (abs(angle) - laser.half_rad) * laser.fade);
    let cosine = max(dot(in.plane.xyz, way) * inverse_m, 0.0);
    var light = laser.strength * in.albedo * cosine * profile * fade * inverse_m / width_m;
    if in.casters.y > 0u && shadowed(point, in.casters) {
        light = 0.0;
    }
    // The strip lies on its sheet: a hundred-thousandth nearer, so that rounding does not hide it.
    return Shaded(vec4(min(light, BRIGHTEST), 0.0, 0.0, 0.0), camera.near_m * 1.00001 * approach / in.plane.w);
}
