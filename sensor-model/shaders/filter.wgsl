// The point spread on light without stripes where the lens may be out of focus: wider or narrower from pixel to pixel, as its depth
// asks, along the rows and then along the columns. What is farther out of focus than the last level is filtered as that one.

struct Filter {
    // columns, filled up to whole blocks, and rows of the image
    columns: u32,
    rows: u32,
    // pixels about the image in the light's
    margin: u32,
    levels: u32,
    // see `Blur` in strip.rs
    psf_px2: f32,
    defocus_px_m: f32,
    focus_1_m: f32,
    // standard deviation of the first level, and 1 / the difference of two, in pixels
    first_px: f32,
    per_level: f32,
}

@group(0) @binding(0) var<uniform> params: Filter;
@group(0) @binding(1) var light: texture_2d<f32>;
@group(0) @binding(2) var depth: texture_depth_2d;
// for each level: number of taps on one side, then the taps' weights from the middle outward
@group(0) @binding(3) var<storage, read> taps: array<f32>;
// filtered along the rows, in all rows of the light's image
@group(0) @binding(4) var<storage, read_write> half_way: array<f32>;
@group(0) @binding(5) var<storage, read_write> smoothed: array<f32>;

const TAPS_MAX: u32 = 12u;

// First entry of the level of the filter at a pixel of the light's image.
fn level(at: vec2<u32>) -> u32 {
    let inverse_m = textureLoad(depth, at, 0) * 1e3;
    let defocus = params.defocus_px_m * (inverse_m - params.focus_1_m);
    let sigma_px = sqrt(params.psf_px2 + defocus * defocus);
    let index = clamp((sigma_px - params.first_px) * params.per_level + 0.5, 0.0, f32(params.levels - 1u));
    return u32(index) * (TAPS_MAX + 2u);
}

@compute @workgroup_size(16, 4)
fn along_rows(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.columns || id.y >= params.rows + 2u * params.margin {
        return;
    }
    let at = vec2(id.x + params.margin, id.y);
    let first = level(at);
    var sum = taps[first + 1u] * textureLoad(light, at, 0).y;
    let reach = u32(taps[first]);
    for (var k = 1u; k <= reach; k++) {
        let both = textureLoad(light, at - vec2(k, 0u), 0).y + textureLoad(light, at + vec2(k, 0u), 0).y;
        sum += taps[first + 1u + k] * both;
    }
    half_way[id.y * params.columns + id.x] = sum;
}

@compute @workgroup_size(16, 4)
fn along_columns(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.columns || id.y >= params.rows {
        return;
    }
    let first = level(id.xy + params.margin);
    let middle = (id.y + params.margin) * params.columns + id.x;
    var sum = taps[first + 1u] * half_way[middle];
    let reach = u32(taps[first]);
    for (var k = 1u; k <= reach; k++) {
        sum += taps[first + 1u + k] * (half_way[middle - k * params.columns] + half_way[middle + k * params.columns]);
    }
    smoothed[id.y * params.columns + id.x] = sum;
}
