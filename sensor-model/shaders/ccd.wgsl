// From light to grey values: point spread on light without stripes, speckle, CCD after EMVA 1288. The random numbers are those of noise.rs.
//
// A thread takes half a tile of 16 x 16 pixels: four columns and the four that are eight to their right, with which they share pairs
// of random numbers. The point spread is applied only in tiles that hold an edge between regions; all else is smooth. There a thread
// keeps the last seven rows, blurred along the row, in registers.

struct Ccd {
    // weights at 0, 1, 2, 3 pixels from the middle
    taps: vec4<f32>,
    rows: u32,
    // columns of tiles
    blocks: u32,
    // pixels about the image in the light's
    margin: u32,
    // number of the submission, written behind the image
    stamp: u32,
    // tiles that hold an edge, and tiles
    edge_tiles: u32,
    tiles: u32,
    shot_key: vec2<u32>,
    speckle_key: vec2<u32>,
    // (constant, slope) of the cube root of the speckle
    speckle: vec2<f32>,
    // columns and rows of the speckle's lattice
    lattice: vec2<u32>,
    // electrons and grey values of 8 bits
    electrons_per_dn: f32,
    dn_per_electron: f32,
    black_dn: f32,
    read_variance_e2: f32,
    full_well_e: f32,
    // grey values for one of 8 bits, and the largest
    levels_per_dn: f32,
    level_max: f32,
    exposure_s: f32,
    // of the dark current during the exposure
    dark_e: f32,
    // half of the share of surplus charge that stays on the column
    spilt: f32,
}

@group(0) @binding(0) var<uniform> ccd: Ccd;
@group(0) @binding(1) var light: texture_2d<f32>;
// 1 - T
@group(0) @binding(2) var shade: texture_2d<f32>;
@group(0) @binding(3) var<storage, read> gains: array<vec4<f32>>;
// hot pixels' dark current, in electrons a second
@group(0) @binding(4) var<storage, read> dark_rates: array<vec4<f32>>;
// DSNU, in electrons
@group(0) @binding(5) var<storage, read> dark_values: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> grey: array<u32>;
// light without stripes, if filter.wgsl has blurred it; then mean charge, if blooming is to move it
@group(0) @binding(7) var<storage, read_write> charge: array<vec4<f32>>;
// normal numbers of the speckle's lattice
@group(0) @binding(8) var<storage, read_write> nodes: array<f32>;
// for each column, then each row: node, weight, weight of the next
@group(0) @binding(9) var<storage, read> grain: array<vec4<f32>>;
// numbers of the tiles, row by row: first those that hold an edge
@group(0) @binding(10) var<storage, read> tiles: array<u32>;

override NOISE: bool = true;
override SPECKLED: bool = true;
// Whether grains of speckle are larger than a pixel.
override GRAINY: bool = false;
override DARK_TABLES: bool = false;
override PATTERNED: bool = false;
override DEFOCUSED: bool = false;
override BLOOMING: bool = false;
// Whether grey values have 16 bits.
override DEEP: bool = false;

// Pixels of a tile's side.
const TILE: u32 = 16u;
const TAU: f32 = 6.2831853;
// Light is cut here, before anything multiplies it: half floats that overflowed are infinite.
const BRIGHTEST: f32 = 60000.0;
const ROW_PLACES: u32 = 8192u;

// A value for each of a thread's eight columns.
struct Eight {
    left: vec4<f32>,
    right: vec4<f32>,
}

fn draw(counter: vec4<u32>, key: vec2<u32>) -> vec4<u32> {
    var x = counter ^ vec4(key.x);
    x ^= x >> vec4(16u);
    x *= 0x7feb352du;
    x ^= (x >> vec4(15u)) ^ vec4(key.y);
    x *= 0x846ca68bu;
    return x ^ (x >> vec4(16u));
}

// Box and Muller's pairs of four counters.
fn normals(counter: vec4<u32>, key: vec2<u32>) -> Eight {
    let bits = draw(counter, key);
    let radius = sqrt(max(-2.0 * log((vec4<f32>(bits >> vec4(12u)) + 0.5) * exp2(-20.0)), vec4(0.0)));
    let angle = (vec4<f32>(bits & vec4(0xfffu)) + 0.5) * (TAU * exp2(-12.0));
    return Eight(radius * cos(angle), radius * sin(angle));
}

// Counters of the pairs that a thread's columns share.
fn pairs(column: u32, row: u32) -> vec4<u32> {
    let place = row * ROW_PLACES + column;
    return (((place >> 4u) << 3u) | (place & 7u)) + vec4(0u, 1u, 2u, 3u);
}

// The normal numbers of the speckle's lattice.
@compute @workgroup_size(64)
fn draw_nodes(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= ccd.lattice.x {
        return;
    }
    let place = id.y * ROW_PLACES + id.x;
    let drawn = normals(vec4(((place >> 4u) << 3u) | (place & 7u)), ccd.speckle_key);
    nodes[id.y * ccd.lattice.x + id.x] = select(drawn.left.x, drawn.right.x, (place & 8u) != 0u);
}

// The speckle's normal number of a pixel.
fn grainy(column: u32, row: u32) -> f32 {
    let u = grain[column];
    let v = grain[ccd.blocks * TILE + row];
    let above = u32(v.x) * ccd.lattice.x + u32(u.x);
    let below = above + ccd.lattice.x;
    return v.y * (u.y * nodes[above] + u.z * nodes[above + 1u]) + v.z * (u.y * nodes[below] + u.z * nodes[below + 1u]);
}

fn grainy_four(column: u32, row: u32) -> vec4<f32> {
    return vec4(grainy(column, row), grainy(column + 1u, row), grainy(column + 2u, row), grainy(column + 3u, row));
}

// Factors of the lasers' light.
fn speckle(column: u32, row: u32) -> Eight {
    var normal: Eight;
    if GRAINY {
        normal = Eight(grainy_four(column, row), grainy_four(column + 8u, row));
    } else {
        normal = normals(pairs(column, row), ccd.speckle_key);
    }
    let left = max(ccd.speckle.x + ccd.speckle.y * normal.left, vec4(0.0));
    let right = max(ccd.speckle.x + ccd.speckle.y * normal.right, vec4(0.0));
    return Eight(left * left * left, right * right * right);
}

// Four columns of the light.
struct Light {
    laser: vec4<f32>,
    smooth_light: vec4<f32>,
}

fn light_four(at: vec2<u32>) -> Light {
    let a = textureLoad(light, at, 0).xy;
    let b = textureLoad(light, at + vec2(1u, 0u), 0).xy;
    let c = textureLoad(light, at + vec2(2u, 0u), 0).xy;
    let d = textureLoad(light, at + vec2(3u, 0u), 0).xy;
    return Light(min(vec4(a.x, b.x, c.x, d.x), vec4(BRIGHTEST)), vec4(a.y, b.y, c.y, d.y));
}

fn lasers(column: u32, row: u32) -> Eight {
    let at = vec2(column, row) + ccd.margin;
    return Eight(light_four(at).laser, light_four(at + vec2(8u, 0u)).laser);
}

fn bright_four(at: vec2<u32>) -> vec4<f32> {
    return max(1.0 - vec4(
        textureLoad(shade, at, 0).x,
        textureLoad(shade, at + vec2(1u, 0u), 0).x,
        textureLoad(shade, at + vec2(2u, 0u), 0).x,
        textureLoad(shade, at + vec2(3u, 0u), 0).x,
    ), vec4(0.0));
}

// Four columns of a row of the light's image, three pixels larger than the camera's on every side, blurred along it.
fn blurred_four(at: vec2<u32>) -> vec4<f32> {
    let t0 = textureLoad(light, at, 0).y;
    let t1 = textureLoad(light, at + vec2(1u, 0u), 0).y;
    let t2 = textureLoad(light, at + vec2(2u, 0u), 0).y;
    let t3 = textureLoad(light, at + vec2(3u, 0u), 0).y;
    let t4 = textureLoad(light, at + vec2(4u, 0u), 0).y;
    let t5 = textureLoad(light, at + vec2(5u, 0u), 0).y;
    let t6 = textureLoad(light, at + vec2(6u, 0u), 0).y;
    let t7 = textureLoad(light, at + vec2(7u, 0u), 0).y;
    let t8 = textureLoad(light, at + vec2(8u, 0u), 0).y;
    let t9 = textureLoad(light, at + vec2(9u, 0u), 0).y;
    return ccd.taps.x * vec4(t3, t4, t5, t6)
        + ccd.taps.y * (vec4(t2, t3, t4, t5) + vec4(t4, t5, t6, t7))
        + ccd.taps.z * (vec4(t1, t2, t3, t4) + vec4(t5, t6, t7, t8))
        + ccd.taps.w * (vec4(t0, t1, t2, t3) + vec4(t6, t7, t8, t9));
}

fn blurred(column: u32, row: u32) -> Eight {
    return Eight(blurred_four(vec2(column, row)), blurred_four(vec2(column + 8u, row)));
}

// Grey values of four columns, from mean charges and normal numbers; `four` is their place in the tables.
fn digital(mean_e: vec4<f32>, normal: vec4<f32>, four: u32) -> vec4<u32> {
    var electrons = mean_e;
    if NOISE {
        electrons += sqrt(mean_e + ccd.read_variance_e2) * normal;
        if DARK_TABLES {
            electrons += dark_values[four];
        }
    }
    let dn = (ccd.black_dn + ccd.dn_per_electron * min(electrons, vec4(ccd.full_well_e))) * ccd.levels_per_dn;
    return vec4<u32>(clamp(floor(dn + 0.5), vec4(0.0), vec4(ccd.level_max)));
}

fn put(level: vec4<u32>, four: u32) {
    if DEEP {
        grey[2u * four] = level.x | (level.y << 16u);
        grey[2u * four + 1u] = level.z | (level.w << 16u);
    } else {
        grey[four] = level.x | (level.y << 8u) | (level.z << 16u) | (level.w << 24u);
    }
}

// Reads a row of charges out.
fn read_row(mean_e: Eight, column: u32, row: u32) {
    let four = (row * ccd.blocks * TILE + column) / 4u;
    var noise = Eight(vec4(0.0), vec4(0.0));
    if NOISE {
        noise = normals(pairs(column, row), ccd.shot_key);
    }
    put(digital(mean_e.left, noise.left, four), four);
    put(digital(mean_e.right, noise.right, four + 2u), four + 2u);
}

// Mean charges of eight columns.
fn mean_charge(column: u32, row: u32, laser_light: Eight, smooth_light: Eight) -> Eight {
    let at = vec2(column, row) + ccd.margin;
    var laser = laser_light;
    let four = (row * ccd.blocks * TILE + column) / 4u;
    if SPECKLED {
        let factor = speckle(column, row);
        laser = Eight(laser.left * factor.left, laser.right * factor.right);
    }
    var all = Eight(laser.left + smooth_light.left, laser.right + smooth_light.right);
    if PATTERNED {
        all = Eight(all.left * bright_four(at), all.right * bright_four(at + vec2(8u, 0u)));
    }
    var electrons = Eight(all.left * ccd.electrons_per_dn, all.right * ccd.electrons_per_dn);
    if NOISE {
        electrons = Eight(electrons.left * gains[four], electrons.right * gains[four + 2u]);
        if DARK_TABLES {
            electrons.left += ccd.exposure_s * dark_rates[four];
            electrons.right += ccd.exposure_s * dark_rates[four + 2u];
        }
    }
    return Eight(electrons.left + ccd.dark_e, electrons.right + ccd.dark_e);
}

// Mean charges of eight columns of a row: kept for blooming to move, or read out.
fn collect(mean_e: Eight, column: u32, row: u32) {
    if BLOOMING {
        let four = (row * ccd.blocks * TILE + column) / 4u;
        charge[four] = mean_e.left;
        charge[four + 2u] = mean_e.right;
    } else {
        read_row(mean_e, column, row);
    }
}

// First column and row of half a tile.
fn half_tile(index: u32) -> vec2<u32> {
    let tile = tiles[index / 2u];
    return vec2(tile % ccd.blocks * TILE + index % 2u * 4u, tile / ccd.blocks * TILE);
}

// Tiles that hold an edge: the point spread, and all that follows.
@compute @workgroup_size(32)
fn expose_edges(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= 2u * ccd.edge_tiles {
        return;
    }
    let start = half_tile(id.x);
    let column = start.x;
    let bottom = min(start.y + TILE, ccd.rows);
    if DEFOCUSED {
        for (var row = start.y; row < bottom; row++) {
            let four = (row * ccd.blocks * TILE + column) / 4u;
            collect(mean_charge(column, row, lasers(column, row), Eight(charge[four], charge[four + 2u])), column, row);
        }
        return;
    }
    var r0 = blurred(column, start.y);
    var r1 = blurred(column, start.y + 1u);
    var r2 = blurred(column, start.y + 2u);
    var r3 = blurred(column, start.y + 3u);
    var r4 = blurred(column, start.y + 4u);
    var r5 = blurred(column, start.y + 5u);
    for (var row = start.y; row < bottom; row++) {
        let r6 = blurred(column, row + 6u);
        let smooth_light = Eight(
            ccd.taps.x * r3.left + ccd.taps.y * (r2.left + r4.left) + ccd.taps.z * (r1.left + r5.left) + ccd.taps.w * (r0.left + r6.left),
            ccd.taps.x * r3.right + ccd.taps.y * (r2.right + r4.right) + ccd.taps.z * (r1.right + r5.right)
                + ccd.taps.w * (r0.right + r6.right),
        );
        r0 = r1;
        r1 = r2;
        r2 = r3;
        r3 = r4;
        r4 = r5;
        r5 = r6;
        collect(mean_charge(column, row, lasers(column, row), smooth_light), column, row);
    }
}

// All other tiles.
@compute @workgroup_size(32)
fn expose_smooth(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x == 0u {
        grey[arrayLength(&grey) - 1u] = ccd.stamp;
    }
    let index = id.x + 2u * ccd.edge_tiles;
    if index >= 2u * ccd.tiles {
        return;
    }
    let start = half_tile(index);
    let column = start.x;
    for (var row = start.y; row < min(start.y + TILE, ccd.rows); row++) {
        let at = vec2(column, row) + ccd.margin;
        let left = light_four(at);
        let right = light_four(at + vec2(8u, 0u));
        let smooth_light = Eight(left.smooth_light, right.smooth_light);
        collect(mean_charge(column, row, Eight(left.laser, right.laser), smooth_light), column, row);
    }
}

fn spill(four: u32, lost: vec4<f32>, carried: vec4<f32>) -> vec4<f32> {
    let room = max(ccd.full_well_e - charge[four], vec4(0.0));
    let taken = min(carried, room);
    charge[four] += taken;
    return carried - taken + lost;
}

// Charge beyond the full well fills the pixels below and above it. A thread takes four columns.
@compute @workgroup_size(16)
fn bloom(@builtin(global_invocation_id) id: vec3<u32>) {
    let stride = ccd.blocks * 4u;
    if id.x >= stride {
        return;
    }
    let full = vec4(ccd.full_well_e);
    var carried = vec4(0.0);
    for (var row = 0u; row < ccd.rows; row++) {
        let four = row * stride + id.x;
        carried = spill(four, ccd.spilt * max(charge[four] - full, vec4(0.0)), carried);
    }
    carried = vec4(0.0);
    for (var row = ccd.rows; row > 0u; row--) {
        let four = (row - 1u) * stride + id.x;
        carried = spill(four, ccd.spilt * max(charge[four] - full, vec4(0.0)), carried);
    }
}

// What blooming has moved, to grey values.
@compute @workgroup_size(32)
fn read_out(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= 2u * ccd.tiles {
        return;
    }
    let start = half_tile(id.x);
    for (var row = start.y; row < min(start.y + TILE, ccd.rows); row++) {
        let four = (row * ccd.blocks * TILE + start.x) / 4u;
        read_row(Eight(charge[four], charge[four + 2u]), start.x, row);
    }
}
