// From light to grey values: point spread, speckle, CCD after EMVA 1288, four pixels packed to a word.
//
// A thread takes a strip of 4 columns and ROWS rows, and keeps the last seven rows, blurred along the row, in registers.

struct Ccd {
    // weights at 0, 1, 2, 3 pixels from the middle
    taps: vec4<f32>,
    width: u32,
    height: u32,
    // words a row
    stride: u32,
    radius_key: u32,
    angle_key: u32,
    black_dn: f32,
    dn_per_electron: f32,
    read_variance_e2: f32,
    // (constant, slope) of the cube root of the speckle
    speckle: vec2<f32>,
}

@group(0) @binding(0) var<uniform> ccd: Ccd;
@group(0) @binding(1) var light: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> gains: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> grey: array<u32>;

override NOISE: bool = true;

const ROWS: u32 = 16u;
const TAU: f32 = 6.2831853;

// Four pixels of a row: the lasers' light and the headlamp's.
struct Row {
    laser: vec4<f32>,
    lamp: vec4<f32>,
}

fn along_row(t: array<f32, 10>) -> vec4<f32> {
    return ccd.taps.x * vec4(t[3], t[4], t[5], t[6])
        + ccd.taps.y * (vec4(t[2], t[3], t[4], t[5]) + vec4(t[4], t[5], t[6], t[7]))
        + ccd.taps.z * (vec4(t[1], t[2], t[3], t[4]) + vec4(t[5], t[6], t[7], t[8]))
        + ccd.taps.w * (vec4(t[0], t[1], t[2], t[3]) + vec4(t[6], t[7], t[8], t[9]));
}

// A row of the light's image, which is 3 pixels larger than the camera's on every side.
fn blurred_row(at: vec2<u32>) -> Row {
    let t0 = textureLoad(light, at, 0).xy;
    let t1 = textureLoad(light, at + vec2(1u, 0u), 0).xy;
    let t2 = textureLoad(light, at + vec2(2u, 0u), 0).xy;
    let t3 = textureLoad(light, at + vec2(3u, 0u), 0).xy;
    let t4 = textureLoad(light, at + vec2(4u, 0u), 0).xy;
    let t5 = textureLoad(light, at + vec2(5u, 0u), 0).xy;
    let t6 = textureLoad(light, at + vec2(6u, 0u), 0).xy;
    let t7 = textureLoad(light, at + vec2(7u, 0u), 0).xy;
    let t8 = textureLoad(light, at + vec2(8u, 0u), 0).xy;
    let t9 = textureLoad(light, at + vec2(9u, 0u), 0).xy;
    return Row(
        along_row(array(t0.x, t1.x, t2.x, t3.x, t4.x, t5.x, t6.x, t7.x, t8.x, t9.x)),
        along_row(array(t0.y, t1.y, t2.y, t3.y, t4.y, t5.y, t6.y, t7.y, t8.y, t9.y)),
    );
}

fn finalise(bits: vec4<u32>) -> vec4<u32> {
    var x = bits;
    x ^= x >> vec4(16u);
    x *= 0x7feb352du;
    x ^= x >> vec4(15u);
    x *= 0x846ca68bu;
    return x ^ (x >> vec4(16u));
}

// Grey values of the four pixels from `column` on, not yet rounded.
fn exposed(laser: vec4<f32>, lamp: vec4<f32>, column: u32, row: u32) -> vec4<f32> {
    if !NOISE {
        return ccd.black_dn + laser + lamp;
    }
    let pixel = vec4(row * ccd.width + column) + vec4(0u, 1u, 2u, 3u);
    let radius_share = (vec4<f32>(finalise(pixel ^ vec4(ccd.radius_key)) >> vec4(8u)) + 0.5) * exp2(-24.0);
    let radius = sqrt(max(-2.0 * log(radius_share), vec4(0.0)));
    let angle = vec4<f32>(finalise(pixel ^ vec4(ccd.angle_key)) >> vec4(8u)) * (TAU * exp2(-24.0));

    let root = max(ccd.speckle.x + ccd.speckle.y * (radius * sin(angle)), vec4(0.0));
    let mean_dn = (laser * (root * root * root) + lamp) * gains[row * ccd.stride + column / 4u];
    let deviation_e = sqrt(mean_dn / ccd.dn_per_electron + ccd.read_variance_e2);
    return ccd.black_dn + mean_dn + ccd.dn_per_electron * deviation_e * (radius * cos(angle));
}

@compute @workgroup_size(16, 2)
fn expose(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= ccd.stride {
        return;
    }
    let column = id.x * 4u;
    let top = id.y * ROWS;
    let bottom = min(top + ROWS, ccd.height);
    var r0 = blurred_row(vec2(column, top));
    var r1 = blurred_row(vec2(column, top + 1u));
    var r2 = blurred_row(vec2(column, top + 2u));
    var r3 = blurred_row(vec2(column, top + 3u));
    var r4 = blurred_row(vec2(column, top + 4u));
    var r5 = blurred_row(vec2(column, top + 5u));
    for (var row = top; row < bottom; row++) {
        let r6 = blurred_row(vec2(column, row + 6u));
        let laser = ccd.taps.x * r3.laser + ccd.taps.y * (r2.laser + r4.laser)
            + ccd.taps.z * (r1.laser + r5.laser) + ccd.taps.w * (r0.laser + r6.laser);
        let lamp = ccd.taps.x * r3.lamp + ccd.taps.y * (r2.lamp + r4.lamp)
            + ccd.taps.z * (r1.lamp + r5.lamp) + ccd.taps.w * (r0.lamp + r6.lamp);
        let dn = vec4<u32>(clamp(exposed(laser, lamp, column, row) + 0.5, vec4(0.0), vec4(255.0)));
        grey[row * ccd.stride + id.x] = dn.x | (dn.y << 8u) | (dn.z << 16u) | (dn.w << 24u);
        r0 = r1;
        r1 = r2;
        r2 = r3;
        r3 = r4;
        r4 = r5;
        r5 = r6;
    }
}
