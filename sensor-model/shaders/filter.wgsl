// The point spread on light without stripes where the lens may be out of focus: wider or narrower from pixel to pixel, as its depth
// asks, along the rows and then along the columns. What is farther out of focus than the last level is filtered as that one. Done in
// tiles of 16 x 16 pixels that hold an edge; rows also in those above and below.

struct Filter {
    // columns, filled up to whole tiles, and rows of the image
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
    // tiles that hold an edge, and those with the ones above and below
    edge_tiles: u32,
    tiles_about: u32,
}

@group(0) @binding(0) var<uniform> params: Filter;
@group(0) @binding(1) var light: texture_2d<f32>;
@group(0) @binding(2) var depth: texture_depth_2d;
// for each level: number of taps on one side, then the taps' weights from the middle outward
@group(0) @binding(3) var<storage, read> taps: array<f32>;
// filtered along the rows, in all rows of the light's image
@group(0) @binding(4) var<storage, read_write> half_way: array<f32>;
@group(0) @binding(5) var<storage, read_write> smoothed: array<f32>;

// Tiles that hold an edge, then those and the ones above and below.
@group(0) @binding(6) var<storage, read> tiles: array<u32>;

const TAPS_MAX: u32 = 12u;
const TILE: u32 = 16u;
// Workgroups along the first dimension.
const GROUPS_MAX: u32 = 32768u;

// First entry of the level of the filter at a pixel of the light's image.
fn level(at: vec2<u32>) -> u32 {
    let inverse_m = textureLoad(depth, at, 0) * 1e3;
    let defocus = params.defocus_px_m * (inverse_m - params.focus_1_m);
    let sigma_px = sqrt(params.psf_px2 + defocus * defocus);
    let index = clamp((sigma_px - params.first_px) * params.per_level + 0.5, 0.0, f32(params.levels - 1u));
    return u32(index) * (TAPS_MAX + 2u);
}

// A pixel of the tile of a workgroup; the first row of the image above and the last below it are filled up to whole tiles.
fn pixel_of(tile: u32, local: vec3<u32>) -> vec2<i32> {
    let across = params.columns / TILE;
    return vec2<i32>(vec2(tile % across, tile / across) * TILE + local.xy);
}

fn filter_row(row: i32, column: u32) {
    let at = vec2(column + params.margin, u32(row + i32(params.margin)));
    let first = level(at);
    var sum = taps[first + 1u] * textureLoad(light, at, 0).y;
    let reach = u32(taps[first]);
    for (var k = 1u; k <= reach; k++) {
        let both = textureLoad(light, at - vec2(k, 0u), 0).y + textureLoad(light, at + vec2(k, 0u), 0).y;
        sum += taps[first + 1u + k] * both;
    }
    half_way[at.y * params.columns + column] = sum;
}

@compute @workgroup_size(16, 16)
fn along_rows(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let index = group.x + group.y * GROUPS_MAX;
    if index >= params.tiles_about {
        return;
    }
    let at = pixel_of(tiles[params.edge_tiles + index], local);
    let rows = i32(params.rows);
    if at.y < rows {
        filter_row(at.y, u32(at.x));
    }
    // The margin above the first tile and below the last.
    if at.y < i32(params.margin) {
        filter_row(at.y - i32(params.margin), u32(at.x));
    }
    if at.y < rows && at.y >= rows - i32(params.margin) {
        filter_row(at.y + i32(params.margin), u32(at.x));
    }
}

@compute @workgroup_size(16, 16)
fn along_columns(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let index = group.x + group.y * GROUPS_MAX;
    if index >= params.edge_tiles {
        return;
    }
    let at = vec2<u32>(pixel_of(tiles[index], local));
    if at.y >= params.rows {
        return;
    }
    let first = level(at + params.margin);
    let middle = (at.y + params.margin) * params.columns + at.x;
    var sum = taps[first + 1u] * half_way[middle];
    let reach = u32(taps[first]);
    for (var k = 1u; k <= reach; k++) {
        sum += taps[first + 1u + k] * (half_way[middle - k * params.columns] + half_way[middle + k * params.columns]);
    }
    smoothed[at.y * params.columns + at.x] = sum;
}
