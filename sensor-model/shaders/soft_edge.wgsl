// What pixels that an edge between regions crosses have in excess of what their centres see: a point a pixel (soft_edges.rs).
//
// Needs camera.wgsl.

struct SoftPixel {
    // (u, v)
    @location(0) pixel: vec2<f32>,
    // at nominal exposure
    @location(1) light: f32,
}

struct SoftPoint {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) light: f32,
}

@vertex
fn soft_point(in: SoftPixel) -> SoftPoint {
    return SoftPoint(vec4(in.pixel * camera.clip_scale + camera.clip_start, 0.5, 1.0), in.light);
}

@fragment
fn soft_pixel(in: SoftPoint) -> @location(0) vec2<f32> {
    // The exposure and the part's share of it.
    return vec2(0.0, camera.glow * in.light);
}
