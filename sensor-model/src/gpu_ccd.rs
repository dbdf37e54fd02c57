//! The last stage on the graphics device: the light's image becomes grey values, packed into words that can be read back.

use ductloop_nav::rig::Camera;

use crate::gpu_buffers::{SMALLEST_BYTES, Slot, compute, create, flag, group, group_layout, shader, table};
use crate::gpu_light::TILE_PX;
use crate::gpu_light_pipelines::Effects;
use crate::gpu_tiles::Tiles;
use crate::light::psf_taps;
use crate::noise::{self, Stream};
use crate::optics::{Bits, Optics};
use crate::renderer::View;

/// Size of the workgroups of `ccd.wgsl`.
const GROUP: u32 = 32;

/// `Ccd` of `ccd.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct CcdBlock {
    taps: [f32; 4],
    rows: u32,
    blocks: u32,
    margin: u32,
    stamp: u32,
    edge_tiles: u32,
    tiles: u32,
    shot_key: [u32; 2],
    speckle_key: [u32; 2],
    speckle: [f32; 2],
    lattice: [u32; 2],
    electrons_per_dn: f32,
    dn_per_electron: f32,
    black_dn: f32,
    read_variance_e2: f32,
    full_well_e: f32,
    levels_per_dn: f32,
    level_max: f32,
    exposure_s: f32,
    dark_e: f32,
    spilt: f32,
}

/// The stage.
#[derive(Debug)]
pub(crate) struct CcdStage {
    /// Tiles that hold an edge, and all others.
    expose_edges: wgpu::ComputePipeline,
    expose_smooth: wgpu::ComputePipeline,
    /// The speckle's lattice, where grains are larger than a pixel.
    draw_nodes: Option<wgpu::ComputePipeline>,
    /// Blooming, and what is left to do after it.
    bloom: Option<[wgpu::ComputePipeline; 2]>,
    group: wgpu::BindGroup,
    block: CcdBlock,
    params: wgpu::Buffer,
    grey: wgpu::Buffer,
    charge: wgpu::Buffer,
    tiles: wgpu::Buffer,
    seed: u64,
    dark_e_s: f64,
}

/// Bytes of a row of grey values, padding included, and of a whole image with the stamp behind it.
pub(crate) fn image_bytes(camera: &Camera, bits: Bits) -> (usize, usize) {
    let row = camera.width_px.next_multiple_of(TILE_PX) * bytes_per_pixel(bits);
    (row, row * camera.height_px + 4)
}

fn bytes_per_pixel(bits: Bits) -> usize {
    if bits == Bits::Eight { 1 } else { 2 }
}

impl CcdStage {
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        camera: &Camera,
        optics: &Optics,
        effects: &Effects,
        seed: u64,
        [light, shade]: [&wgpu::TextureView; 2],
    ) -> Self {
        let ccd = &optics.ccd;
        let columns = camera.width_px.next_multiple_of(TILE_PX);
        let pixels = columns * camera.height_px;
        let speckled = optics.noise && optics.speckle_contrast > 0.0;
        let spacing_px = optics.speckle_grain_px;
        let grainy = speckled && spacing_px > 1.0;
        let dark_tables = optics.noise && (ccd.dsnu_e > 0.0 || ccd.hot_pixels > 0.0);
        let blooming = ccd.blooming > 0.0;
        let [lattice_columns, lattice_rows] = [columns, camera.height_px].map(|n| noise::grain(n - 1, spacing_px).0 + 2);

        let padded = |values: &mut dyn Iterator<Item = f64>| pad(values, camera.width_px, pixels);
        let gains =
            if optics.noise { padded(&mut noise::gains(seed, ccd.prnu, camera.width_px, camera.height_px)) } else { Vec::new() };
        let (mut dark_rates, mut dark_values) = (Vec::new(), Vec::new());
        if dark_tables {
            dark_values = padded(&mut noise::dark_values(seed, ccd.dsnu_e, camera.width_px, camera.height_px));
            dark_rates = vec![0.0; pixels];
            let hot = noise::hot_pixels(seed, ccd.hot_pixels, ccd.hot_pixel_e_s, camera.width_px, camera.height_px);
            for (column, row, rate) in hot {
                dark_rates[row * columns + column] = rate as f32;
            }
        }
        let grains: Vec<[f32; 4]> = if grainy { grain_table(columns, camera.height_px, spacing_px) } else { Vec::new() };
        let tables = [("gains", &gains), ("dark rates", &dark_rates), ("dark values", &dark_values)]
            .map(|(label, values)| table(device, queue, label, values));
        let sized = |label, used: bool, bytes: usize| {
            create(device, label, wgpu::BufferUsages::STORAGE, if used { bytes as u64 } else { SMALLEST_BYTES })
        };
        let params = create(device, "ccd", wgpu::BufferUsages::UNIFORM, size_of::<CcdBlock>() as u64);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let grey = create(device, "grey", usage, image_bytes(camera, ccd.bits).1 as u64);
        let charge = sized("charge", blooming || effects.defocused, pixels * 4);
        let nodes = sized("speckle", grainy, (lattice_columns * lattice_rows) as usize * 4);
        let count = (columns / TILE_PX) * camera.height_px.div_ceil(TILE_PX);
        let tiles = sized("tiles", true, count * 4);
        let layout = group_layout(
            device,
            "ccd",
            wgpu::ShaderStages::COMPUTE,
            &[
                Slot::Uniform,
                Slot::Image,
                Slot::Image,
                Slot::Storage,
                Slot::Storage,
                Slot::Storage,
                Slot::Output,
                Slot::Output,
                Slot::Output,
                Slot::Storage,
                Slot::Storage,
            ],
        );
        let group = group(
            device,
            &layout,
            &[
                params.as_entire_binding(),
                wgpu::BindingResource::TextureView(light),
                wgpu::BindingResource::TextureView(shade),
                tables[0].as_entire_binding(),
                tables[1].as_entire_binding(),
                tables[2].as_entire_binding(),
                grey.as_entire_binding(),
                charge.as_entire_binding(),
                nodes.as_entire_binding(),
                table(device, queue, "grain", &grains).as_entire_binding(),
                tiles.as_entire_binding(),
            ],
        );
        let constants = [
            ("NOISE", flag(optics.noise)),
            ("SPECKLED", flag(speckled)),
            ("GRAINY", flag(grainy)),
            ("DARK_TABLES", flag(dark_tables)),
            ("PATTERNED", flag(effects.patterned)),
            ("DEFOCUSED", flag(effects.defocused)),
            ("BLOOMING", flag(blooming)),
            ("DEEP", flag(ccd.bits != Bits::Eight)),
        ];
        let module = shader(device, "ccd", &[include_str!("../shaders/ccd.wgsl")]);
        let pipeline = |entry_point| compute(device, &module, &layout, entry_point, &constants);
        Self {
            expose_edges: pipeline("expose_edges"),
            expose_smooth: pipeline("expose_smooth"),
            draw_nodes: grainy.then(|| pipeline("draw_nodes")),
            bloom: blooming.then(|| [pipeline("bloom"), pipeline("read_out")]),
            group,
            block: CcdBlock {
                taps: psf_taps(optics.lens.psf_sigma_px).map(|tap| tap as f32),
                rows: camera.height_px as u32,
                blocks: (columns / TILE_PX) as u32,
                margin: effects.margin_px() as u32,
                stamp: 0,
                edge_tiles: 0,
                tiles: count as u32,
                shot_key: [0; 2],
                speckle_key: [0; 2],
                speckle: noise::speckle_terms(optics.speckle_contrast).map(|term| term as f32),
                lattice: [lattice_columns, lattice_rows],
                electrons_per_dn: (1.0 / ccd.dn_per_electron()) as f32,
                dn_per_electron: ccd.dn_per_electron() as f32,
                black_dn: ccd.black_level_dn as f32,
                read_variance_e2: (ccd.read_noise_e * ccd.read_noise_e) as f32,
                full_well_e: ccd.full_well_e as f32,
                levels_per_dn: (f64::from(ccd.bits.max_dn()) / 255.0) as f32,
                level_max: ccd.bits.max_dn() as f32,
                exposure_s: 0.0,
                dark_e: 0.0,
                spilt: (ccd.blooming / 2.0) as f32,
            },
            params,
            grey,
            charge,
            tiles,
            seed,
            dark_e_s: ccd.dark_current_e_s,
        }
    }

    /// Sends a frame's keys and tiles; `stamp` will stand behind its image.
    pub(crate) fn upload(&self, queue: &wgpu::Queue, view: &View, tiles: &Tiles, stamp: u32) {
        let [shot_key, speckle_key] = [Stream::Shot, Stream::Speckle].map(|stream| noise::key(self.seed, stream, view.frame));
        let block = CcdBlock {
            stamp,
            edge_tiles: tiles.edged_count as u32,
            shot_key,
            speckle_key,
            exposure_s: view.exposure_s as f32,
            dark_e: (self.dark_e_s * view.exposure_s) as f32,
            ..self.block
        };
        queue.write_buffer(&self.params, 0, bytemuck::bytes_of(&block));
        queue.write_buffer(&self.tiles, 0, bytemuck::cast_slice(&tiles.order));
    }

    /// Makes a frame's grey values.
    pub(crate) fn run(&self, pass: &mut wgpu::ComputePass<'_>, tiles: &Tiles) {
        pass.set_bind_group(0, &self.group, &[]);
        let mut run = |pipeline: &wgpu::ComputePipeline, [columns, rows]: [u32; 2]| {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(columns, rows, 1);
        };
        if let Some(draw_nodes) = &self.draw_nodes {
            let [columns, rows] = self.block.lattice;
            run(draw_nodes, [columns.div_ceil(64), rows]);
        }
        // Two threads a tile.
        let edge_tiles = tiles.edged_count as u32;
        let groups = |tiles: u32| [(2 * tiles).div_ceil(GROUP), 1];
        if edge_tiles > 0 {
            run(&self.expose_edges, groups(edge_tiles));
        }
        // At least one group: it leaves the stamp.
        run(&self.expose_smooth, groups((self.block.tiles - edge_tiles).max(1)));
        if let Some([bloom, read_out]) = &self.bloom {
            run(bloom, [(self.block.blocks * 4).div_ceil(16), 1]);
            run(read_out, groups(self.block.tiles));
        }
    }

    /// Where a stage before this one puts light without stripes, a number for each pixel.
    pub(crate) fn smoothed(&self) -> &wgpu::Buffer {
        &self.charge
    }

    /// The packed image, with the stamp behind it.
    pub(crate) fn grey(&self) -> &wgpu::Buffer {
        &self.grey
    }
}

/// A value for each pixel, each row filled up to whole tiles.
fn pad(values: &mut dyn Iterator<Item = f64>, width_px: usize, pixels: usize) -> Vec<f32> {
    let columns = width_px.next_multiple_of(TILE_PX);
    let mut padded = vec![0.0; pixels];
    for (pixel, value) in values.enumerate() {
        padded[pixel / width_px * columns + pixel % width_px] = value as f32;
    }
    padded
}

/// For each column, then each row: its node in the speckle's lattice, and the weights of that and the next.
fn grain_table(columns: usize, rows: usize, spacing_px: f64) -> Vec<[f32; 4]> {
    let places = (0..columns).chain(0..rows);
    places
        .map(|at_px| {
            let (node, weights) = noise::grain(at_px, spacing_px);
            [node as f32, weights[0] as f32, weights[1] as f32, 0.0]
        })
        .collect()
}
