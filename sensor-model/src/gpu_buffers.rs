//! Memory that the processor and the graphics device share, and the layout of the uniform blocks in it.

use ductloop_nav::rig::{Camera, Laser, LineWidth};
use nalgebra::Vector3;

use crate::light::{FAN_FADE_RAD, Fan, PSF_RADIUS, headlamp_strength, laser_strength, psf_taps};
use crate::noise::{self, Stream};
use crate::optics::Optics;

/// Nothing nearer to the camera than this is drawn, in metres.
const NEAR_M: f64 = 1e-3;

/// `Camera` of `light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct CameraBlock {
    clip_x: [f32; 2],
    clip_y: [f32; 2],
    ray_scale: [f32; 2],
    ray_start: [f32; 2],
    /// In DN m^2.
    headlamp: f32,
    near_m: f32,
    line_width_m: f32,
    line_growth: f32,
}

/// `Laser` of `light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct LaserBlock {
    normal: [f32; 3],
    offset_m: f32,
    source: [f32; 3],
    /// In DN m^2.
    strength: f32,
    along: [f32; 3],
    half_rad: f32,
    across: [f32; 3],
    fan_exponent: f32,
    fade: f32,
    unused: [f32; 3],
}

/// `Ccd` of `ccd.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct CcdBlock {
    taps: [f32; 4],
    width: u32,
    height: u32,
    pub(crate) stride: u32,
    radius_key: u32,
    angle_key: u32,
    black_dn: f32,
    dn_per_electron: f32,
    read_variance_e2: f32,
    speckle: [f32; 2],
    unused: [f32; 2],
}

/// Size of the light's image in pixels: the camera's, its width rounded up to whole words of four, and the point spread's margin
/// on every side.
pub(crate) fn light_size_px(camera: &Camera) -> [usize; 2] {
    [camera.width_px.next_multiple_of(4), camera.height_px].map(|n| n + 2 * PSF_RADIUS)
}

impl CameraBlock {
    /// The block at nominal exposure and power.
    pub(crate) fn new(camera: &Camera, line: &LineWidth, optics: &Optics) -> Self {
        let size = light_size_px(camera).map(|n| n as f64);
        // Where the principal point is in the light's image, whose pixel centres are at halves.
        let centre = camera.centre_px.map(|c| c + 0.5 + PSF_RADIUS as f64);
        let focal = camera.focal_px;
        let clip = |axis: usize| [2.0 * focal[axis] / size[axis], 2.0 * centre[axis] / size[axis] - 1.0];
        let single = |pair: [f64; 2]| pair.map(|v| v as f32);
        Self {
            clip_x: single(clip(0)),
            clip_y: single(clip(1).map(|v| -v)),
            ray_scale: single([1.0 / focal[0], 1.0 / focal[1]]),
            ray_start: single([-centre[0] / focal[0], -centre[1] / focal[1]]),
            headlamp: headlamp_strength(optics) as f32,
            near_m: NEAR_M as f32,
            line_width_m: line.width_m as f32,
            line_growth: line.growth_rad as f32,
        }
    }

    /// The block with `factor` times the light.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self { headlamp: (f64::from(self.headlamp) * factor) as f32, ..self }
    }
}

impl LaserBlock {
    /// The block at nominal exposure and power.
    pub(crate) fn new(laser: &Laser, line: &LineWidth, optics: &Optics) -> Self {
        let fan = Fan::of(laser, optics.fan_profile);
        let single = |v: &Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32];
        Self {
            normal: single(&laser.normal_in_camera),
            offset_m: laser.offset_m as f32,
            source: single(&laser.source_in_camera.coords),
            strength: laser_strength(optics, line) as f32,
            along: single(&fan.along),
            half_rad: fan.reach_rad as f32,
            across: single(&fan.across),
            fan_exponent: fan.exponent as f32,
            fade: (1.0 / FAN_FADE_RAD) as f32,
            unused: [0.0; 3],
        }
    }

    /// The block with `factor` times the light.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self { strength: (f64::from(self.strength) * factor) as f32, ..self }
    }
}

impl CcdBlock {
    /// The block without a frame's keys.
    pub(crate) fn new(camera: &Camera, optics: &Optics) -> Self {
        Self {
            taps: psf_taps(optics.lens.psf_sigma_px).map(|tap| tap as f32),
            width: camera.width_px as u32,
            height: camera.height_px as u32,
            stride: camera.width_px.div_ceil(4) as u32,
            radius_key: 0,
            angle_key: 0,
            black_dn: optics.ccd.black_level_dn as f32,
            dn_per_electron: optics.ccd.dn_per_electron() as f32,
            read_variance_e2: (optics.ccd.read_noise_e * optics.ccd.read_noise_e) as f32,
            speckle: noise::speckle_terms(optics.speckle_contrast).map(|term| term as f32),
            unused: [0.0; 2],
        }
    }

    /// The block with the keys of a frame.
    pub(crate) fn keyed(self, seed: u64, frame: u64) -> Self {
        let [radius_key, angle_key] = [Stream::Radius, Stream::Angle].map(|stream| noise::key(seed, stream, frame));
        Self { radius_key, angle_key, ..self }
    }
}

/// A buffer that is written anew each frame and grows when a frame needs more.
#[derive(Debug)]
pub(crate) struct FrameBuffer {
    pub(crate) buffer: wgpu::Buffer,
    label: &'static str,
}

impl FrameBuffer {
    /// Bytes at first: enough for an elbow in view.
    const FIRST_BYTES: u64 = 1 << 16;

    pub(crate) fn new(device: &wgpu::Device, label: &'static str, usage: wgpu::BufferUsages) -> Self {
        Self { buffer: create(device, label, usage, Self::FIRST_BYTES), label }
    }

    /// Writes `data` at the start. Returns whether the buffer had to be replaced by a larger one.
    pub(crate) fn write<T: bytemuck::Pod>(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, data: &[T]) -> bool {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let grow = bytes.len() as u64 > self.buffer.size();
        if grow {
            self.buffer = create(device, self.label, self.buffer.usage(), (bytes.len() as u64).next_power_of_two());
        }
        if !bytes.is_empty() {
            queue.write_buffer(&self.buffer, 0, bytes);
        }
        grow
    }
}

/// A buffer of `size` bytes.
pub(crate) fn create(device: &wgpu::Device, label: &'static str, usage: wgpu::BufferUsages, size: u64) -> wgpu::Buffer {
    let usage = if usage.contains(wgpu::BufferUsages::MAP_READ) { usage } else { usage | wgpu::BufferUsages::COPY_DST };
    device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
}
