//! The stage between light and CCD for a lens that may be out of focus: a point spread as wide as each pixel's depth asks.

use crate::gpu_buffers::{Slot, compute, create, group, group_layout, shader, table};
use crate::gpu_light::TILE_PX;
use crate::gpu_tiles::Tiles;
use crate::lens::Projection;
use crate::light::PSF_RADIUS;
use crate::strip::Blur;

/// Most taps on one side of the filter.
pub(crate) const RADIUS: usize = 12;

/// Widest filter, in pixels; what is farther out of focus is filtered as this (its stripes are as wide as they should be: they are
/// not filtered). Three of it are the radius.
const SIGMA_MAX_PX: f64 = crate::light::DEFOCUS_SIGMA_MAX_PX;

/// Filters between the lens' own point spread and the widest.
const LEVELS: usize = 512;

/// `Filter` of `filter.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct FilterBlock {
    columns: u32,
    rows: u32,
    margin: u32,
    levels: u32,
    psf_px2: f32,
    defocus_px_m: f32,
    focus_1_m: f32,
    first_px: f32,
    per_level: f32,
    edge_tiles: u32,
    tiles_about: u32,
    unused: u32,
}

/// The stage.
#[derive(Debug)]
pub(crate) struct FilterStage {
    along_rows: wgpu::ComputePipeline,
    along_columns: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    block: FilterBlock,
    params: wgpu::Buffer,
    /// Tiles that hold an edge, then those and the ones above and below.
    tiles: wgpu::Buffer,
}

/// What the stage reads and writes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FilterImages<'a> {
    pub(crate) light: &'a wgpu::TextureView,
    pub(crate) depth: &'a wgpu::TextureView,
    /// Takes a number for each pixel.
    pub(crate) smoothed: &'a wgpu::Buffer,
}

impl FilterStage {
    /// For images of `columns` pixels a row, whole tiles of the CCD's stage.
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        projection: &Projection,
        blur: &Blur,
        columns: usize,
        images: &FilterImages<'_>,
    ) -> Self {
        let rows = projection.camera.height_px;
        let first_px = blur.psf_px2.sqrt();
        let step_px = (SIGMA_MAX_PX - first_px) / (LEVELS - 1) as f64;
        let block = FilterBlock {
            columns: columns as u32,
            rows: rows as u32,
            margin: RADIUS as u32,
            levels: LEVELS as u32,
            psf_px2: blur.psf_px2 as f32,
            defocus_px_m: blur.defocus_px_m as f32,
            focus_1_m: blur.focus_1_m as f32,
            first_px: first_px as f32,
            per_level: (1.0 / step_px) as f32,
            edge_tiles: 0,
            tiles_about: 0,
            unused: 0,
        };
        let params = create(device, "filter", wgpu::BufferUsages::UNIFORM, size_of::<FilterBlock>() as u64);
        let tile_count = (columns / TILE_PX) * rows.div_ceil(TILE_PX);
        let tiles = create(device, "filtered tiles", wgpu::BufferUsages::STORAGE, (2 * tile_count * 4) as u64);
        let weights: Vec<f32> = (0..LEVELS).flat_map(|level| taps(first_px + step_px * level as f64)).collect();
        let bytes = (columns * (rows + 2 * RADIUS) * 4) as u64;
        let half_way = create(device, "filtered rows", wgpu::BufferUsages::STORAGE, bytes);
        let layout = group_layout(
            device,
            "filter",
            wgpu::ShaderStages::COMPUTE,
            &[Slot::Uniform, Slot::Image, Slot::Depth, Slot::Storage, Slot::Output, Slot::Output, Slot::Storage],
        );
        let module = shader(device, "filter", &[include_str!("../shaders/filter.wgsl")]);
        let group = group(
            device,
            &layout,
            &[
                params.as_entire_binding(),
                wgpu::BindingResource::TextureView(images.light),
                wgpu::BindingResource::TextureView(images.depth),
                table(device, queue, "taps", &weights).as_entire_binding(),
                half_way.as_entire_binding(),
                images.smoothed.as_entire_binding(),
                tiles.as_entire_binding(),
            ],
        );
        Self {
            along_rows: compute(device, &module, &layout, "along_rows", &[]),
            along_columns: compute(device, &module, &layout, "along_columns", &[]),
            group,
            block,
            params,
            tiles,
        }
    }

    /// Sends a frame's tiles.
    pub(crate) fn upload(&self, queue: &wgpu::Queue, tiles: &Tiles) {
        let edge_tiles = tiles.edged_count as u32;
        let block = FilterBlock { edge_tiles, tiles_about: tiles.columns_about.len() as u32, ..self.block };
        queue.write_buffer(&self.params, 0, bytemuck::bytes_of(&block));
        queue.write_buffer(&self.tiles, 0, bytemuck::cast_slice(&tiles.order[..tiles.edged_count]));
        let after = u64::from(edge_tiles) * 4;
        queue.write_buffer(&self.tiles, after, bytemuck::cast_slice(&tiles.columns_about));
    }

    /// Filters a frame.
    pub(crate) fn run(&self, pass: &mut wgpu::ComputePass<'_>, tiles: &Tiles) {
        if tiles.edged_count == 0 {
            return;
        }
        /// Workgroups along the first dimension, as in `filter.wgsl`: a dimension holds 65535.
        const GROUPS_MAX: u32 = 32_768;
        pass.set_bind_group(0, &self.group, &[]);
        for (pipeline, groups) in [(&self.along_rows, tiles.columns_about.len()), (&self.along_columns, tiles.edged_count)] {
            let groups = groups as u32;
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(groups.min(GROUPS_MAX), groups.div_ceil(GROUPS_MAX), 1);
        }
    }
}

/// Number of taps on one side, then their weights from the middle outward: the Gaussian integrated over each pixel, as
/// [`crate::light::psf_taps`], as far as it reaches three standard deviations.
fn taps(sigma_px: f64) -> [f32; RADIUS + 2] {
    let reach = ((3.0 * sigma_px).ceil() as usize).clamp(PSF_RADIUS, RADIUS);
    let below = |x_px: f64| 0.5 * libm::erfc(-x_px / (sigma_px.max(1e-3) * std::f64::consts::SQRT_2));
    let mut weights = [0.0; RADIUS + 1];
    for (i, weight) in weights.iter_mut().enumerate().take(reach + 1) {
        *weight = below(i as f64 + 0.5) - below(i as f64 - 0.5);
    }
    let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    let mut level = [reach as f32; RADIUS + 2];
    for (entry, weight) in level[1..].iter_mut().zip(weights) {
        *entry = (weight / sum) as f32;
    }
    level
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn in_focus_the_taps_are_those_of_the_point_spread() {
        for sigma_px in [0.0, 0.6, 0.9] {
            let wanted = crate::light::psf_taps(sigma_px);
            for (tap, wanted) in taps(sigma_px)[1..].iter().zip(wanted) {
                assert!((f64::from(*tap) - wanted).abs() < 1e-7, "{sigma_px}: {tap} against {wanted}");
            }
        }
    }

    #[test]
    fn no_light_is_lost_and_the_spread_is_the_one_asked_for() {
        for sigma_px in [1.5, 3.0, SIGMA_MAX_PX] {
            let taps = taps(sigma_px).map(f64::from);
            let (mut sum, mut variance) = (taps[1], 0.0);
            for (i, tap) in taps[2..].iter().enumerate() {
                let off = (i + 1) as f64;
                sum += 2.0 * tap;
                variance += 2.0 * tap * off * off;
            }
            assert!((sum - 1.0).abs() < 1e-6);
            // The Gaussian's own and the pixel's; cut at three sigma at the widest, where it lacks 3 %.
            let wanted = sigma_px * sigma_px + 1.0 / 12.0;
            assert!((variance / wanted - 1.0).abs() < 0.04, "{sigma_px}: {variance} against {wanted}");
        }
    }
}
