// The light of one part of an exposure, added to the frame's.

@group(0) @binding(0) var light: texture_2d<f32>;
@group(0) @binding(1) var shade: texture_2d<f32>;

// A triangle that covers the image.
@vertex
fn everywhere(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4(corner * 2.0 - 1.0, 0.0, 1.0);
}

@fragment
fn add(@builtin(position) position: vec4<f32>) -> @location(0) vec2<f32> {
    return textureLoad(light, vec2<i32>(position.xy), 0).xy;
}

struct Patterned {
    @location(0) light: vec2<f32>,
    @location(1) shade: f32,
}

@fragment
fn add_patterned(@builtin(position) position: vec4<f32>) -> Patterned {
    let at = vec2<i32>(position.xy);
    return Patterned(textureLoad(light, at, 0).xy, textureLoad(shade, at, 0).x);
}
