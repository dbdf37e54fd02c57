//! The stage between light and CCD for a lens that may be out of focus: a point spread as wide as each pixel's depth asks.

use crate::gpu_buffers::{Slot, compute, create, group, group_layout, shader, table};
use crate::lens::Projection;
use crate::light::PSF_RADIUS;
use crate::strip::Blur;

/// Most taps on one side of the filter.
pub(crate) const RADIUS: usize = 12;

/// Widest filter, in pixels; what is farther out of focus is filtered as this (its stripes are as wide as they should be: they are
/// not filtered). Two and a half of it are the radius.
const SIGMA_MAX_PX: f64 = 4.8;

/// Filters between the lens' own point spread and the widest.
const LEVELS: usize = 64;

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
    unused: [f32; 3],
}

/// The stage.
#[derive(Debug)]
pub(crate) struct FilterStage {
    along_rows: wgpu::ComputePipeline,
    along_columns: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    columns: u32,
    rows: u32,
}

impl FilterStage {
    /// For images of `columns` pixels a row, whole tiles of the CCD's stage; `smoothed` takes a number for each pixel.
    #[allow(clippy::too_many_arguments)] // called once, with what the other stages are called
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        projection: &Projection,
        blur: &Blur,
        columns: usize,
        light: &wgpu::TextureView,
        depth: &wgpu::TextureView,
        smoothed: &wgpu::Buffer,
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
            unused: [0.0; 3],
        };
        let params = create(device, "filter", wgpu::BufferUsages::UNIFORM, size_of::<FilterBlock>() as u64);
        queue.write_buffer(&params, 0, bytemuck::bytes_of(&block));
        let weights: Vec<f32> = (0..LEVELS).flat_map(|level| taps(first_px + step_px * level as f64)).collect();
        let bytes = (columns * (rows + 2 * RADIUS) * 4) as u64;
        let half_way = create(device, "filtered rows", wgpu::BufferUsages::STORAGE, bytes);
        let layout = group_layout(
            device,
            "filter",
            wgpu::ShaderStages::COMPUTE,
            &[Slot::Uniform, Slot::Image, Slot::Depth, Slot::Storage, Slot::Output, Slot::Output],
        );
        let module = shader(device, "filter", &[include_str!("../shaders/filter.wgsl")]);
        let group = group(
            device,
            &layout,
            &[
                params.as_entire_binding(),
                wgpu::BindingResource::TextureView(light),
                wgpu::BindingResource::TextureView(depth),
                table(device, queue, "taps", &weights).as_entire_binding(),
                half_way.as_entire_binding(),
                smoothed.as_entire_binding(),
            ],
        );
        Self {
            along_rows: compute(device, &module, &layout, "along_rows", &[]),
            along_columns: compute(device, &module, &layout, "along_columns", &[]),
            group,
            columns: columns as u32,
            rows: rows as u32,
        }
    }

    /// Filters a frame.
    pub(crate) fn run(&self, pass: &mut wgpu::ComputePass<'_>) {
        /// Workgroup of `filter.wgsl`.
        const GROUP: [u32; 2] = [16, 4];
        pass.set_bind_group(0, &self.group, &[]);
        for (pipeline, rows) in [(&self.along_rows, self.rows + 2 * RADIUS as u32), (&self.along_columns, self.rows)] {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(self.columns.div_ceil(GROUP[0]), rows.div_ceil(GROUP[1]), 1);
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
            // The Gaussian's own and the pixel's; cut at 2.5 sigma at the widest, where it lacks a tenth.
            let wanted = sigma_px * sigma_px + 1.0 / 12.0;
            assert!((variance / wanted - 1.0).abs() < 0.1, "{sigma_px}: {variance} against {wanted}");
        }
    }
}
