//! The renderer on wgpu: one submission a frame, then the packed image is read back.

use ductloop_duct::network::Network;
use ductloop_nav::rig::Rig;

use crate::cpu::raster::Raster;
use crate::cpu::tables::RayTable;
use crate::exposure_parts::{parts, whole};
use crate::frame_geometry::FrameGeometry;
use crate::gpu::{FRAME_TIMEOUT, Gpu};
use crate::gpu_blocks::Lamps;
use crate::gpu_buffers::create;
use crate::gpu_ccd::{CcdStage, image_bytes};
use crate::gpu_filter::{FilterImages, FilterStage};
use crate::gpu_frame::FrameData;
use crate::gpu_light::{LightStage, TILE_PX, light_size_px};
use crate::gpu_light_pipelines::Effects;
use crate::gpu_tiles::Tiles;
use crate::light::{headlamp_strength, laser_strength};
use crate::optics::Optics;
use crate::renderer::{ImageMut, MAX_LASERS, RenderError, Renderer, View, check_parameters};
use crate::scenery::Scenery;
use crate::soft_edges::SoftEdges;
use crate::surface::Look;

/// Renders on a graphics device, or on a software one such as lavapipe.
///
/// Its images are the same to the bit on the same adapter and driver.
#[derive(Debug)]
pub struct WgpuRenderer {
    gpu: Gpu,
    scenery: Scenery,
    geometry: FrameGeometry,
    frame: FrameData,
    rays: RayTable,
    raster: Raster,
    soft: SoftEdges,
    optics: Optics,
    /// DN m^2 at nominal exposure and power.
    laser_strength: f64,
    width_px: usize,
    height_px: usize,
    light: LightStage,
    filter: Option<FilterStage>,
    ccd: CcdStage,
    read_back: wgpu::Buffer,
    /// Number of the last submission.
    stamp: u32,
}

impl WgpuRenderer {
    /// A renderer of what `rig` sees in `network`; `looks` is indexed by surface, `seed` chooses the noise.
    ///
    /// # Errors
    /// When rig, optics or looks are out of their bounds, or the device refuses what is asked of it.
    pub fn new(gpu: &Gpu, network: &Network, rig: &Rig, optics: &Optics, looks: &[Look], seed: u64) -> Result<Self, RenderError> {
        check_parameters(rig, optics)?;
        let scenery = Scenery::new(network, looks)?;
        let geometry = FrameGeometry::new(rig, optics)?;
        let effects = Effects::of(optics, looks);
        let (device, queue) = (gpu.device(), gpu.queue());
        let bytes = checked_image_bytes(&device.limits(), &geometry, &effects, optics)?;

        let (projection, blur) = (geometry.projection(), geometry.blur());
        let light = LightStage::new(device, queue, projection, blur, effects);
        let columns = rig.camera.width_px.next_multiple_of(TILE_PX);
        let ccd = CcdStage::new(device, queue, &rig.camera, optics, &effects, seed, light.images());
        let images = FilterImages { light: light.images()[0], depth: light.depth(), smoothed: ccd.smoothed() };
        let filter = effects.defocused.then(|| FilterStage::new(device, queue, projection, blur, columns, &images));
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let read_back = create(device, "read back", usage, bytes as u64);
        gpu.check()?;
        let rays = RayTable::new(projection, effects.margin_px());
        Ok(Self {
            rays,
            raster: Raster::default(),
            soft: SoftEdges::default(),
            gpu: gpu.clone(),
            scenery,
            geometry,
            frame: FrameData::new(Tiles::new(rig.camera.width_px, rig.camera.height_px, effects.margin_px())),
            laser_strength: laser_strength(optics, &rig.line),
            optics: optics.clone(),
            width_px: rig.camera.width_px,
            height_px: rig.camera.height_px,
            light,
            filter,
            ccd,
            read_back,
            stamp: 0,
        })
    }

    /// Makes the frame's geometry and sends it to the device.
    fn upload(&mut self, view: &View) -> Result<(), RenderError> {
        let lens = &self.optics.lens;
        self.geometry.build(&self.scenery, &whole(view, lens), &view.laser_power)?;
        let sweeps = parts(view, lens, &self.geometry);
        let share = 1.0 / sweeps.len() as f64;
        let exposure = view.exposure_s / self.optics.exposure_s * share;
        let strengths = view.laser_power.map(|power| self.laser_strength * power * exposure);
        self.frame.clear();
        if sweeps.len() == 1 {
            self.add_part(view, &strengths);
        } else {
            for sweep in sweeps {
                self.geometry.build(&self.scenery, &sweep, &view.laser_power)?;
                self.add_part(view, &strengths);
            }
        }
        let lamps = Lamps {
            headlamp: headlamp_strength(&self.optics) * view.headlamp_power * exposure,
            daylight: self.optics.ambient_dn * exposure,
            glow: exposure,
            share,
        };
        self.frame.tiles.sort();
        let (device, queue) = (self.gpu.device(), self.gpu.queue());
        self.light.upload(device, queue, &self.frame, &lamps);
        self.stamp = self.stamp.wrapping_add(1).max(1);
        if let Some(filter) = &self.filter {
            filter.upload(queue, &self.frame.tiles);
        }
        self.ccd.upload(queue, view, &self.frame.tiles, self.stamp);
        Ok(())
    }

    /// Adds the part of the exposure that the geometry shows.
    fn add_part(&mut self, view: &View, strengths: &[f64; MAX_LASERS]) {
        let Self { geometry, scenery, rays, raster, soft, optics, .. } = self;
        raster.build(geometry, rays);
        soft.build(geometry, raster, rays, &scenery.looks, optics, view);
        self.frame.add_part(geometry, soft, &scenery.looks, strengths);
    }

    /// The frame's one submission: draw the light, expose it, copy the image to where it can be mapped.
    fn submit(&self) -> wgpu::SubmissionIndex {
        let mut encoder = self.gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.light.draw(&mut encoder, &self.frame);
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            if let Some(filter) = &self.filter {
                filter.run(&mut pass, &self.frame.tiles);
            }
            self.ccd.run(&mut pass, &self.frame.tiles);
        }
        encoder.copy_buffer_to_buffer(self.ccd.grey(), 0, &self.read_back, 0, self.read_back.size());
        self.gpu.queue().submit([encoder.finish()])
    }

    /// Waits for the submission and copies its image out.
    fn read(&self, submission: wgpu::SubmissionIndex, image: ImageMut<'_>) -> Result<(), RenderError> {
        let (tell, told) = std::sync::mpsc::sync_channel(1);
        self.read_back.map_async(wgpu::MapMode::Read, .., move |result| {
            // Nobody listens any more only if the wait below has given up.
            let _ = tell.send(result);
        });
        self.gpu.wait(submission)?;
        // Another thread that waits on this device may be the one that carries the news, and be a moment late.
        match told.recv_timeout(FRAME_TIMEOUT) {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(self.gpu.fault_or(format!("the image could not be mapped for reading: {error}"))),
            Err(_) => return Err(RenderError::Hung(FRAME_TIMEOUT.as_secs_f64())),
        }
        let copied = self.copy(image);
        self.read_back.unmap();
        copied
    }

    /// Copies the mapped image, if it is that of the last submission.
    fn copy(&self, image: ImageMut<'_>) -> Result<(), RenderError> {
        let view = self.read_back.get_mapped_range(..).map_err(|error| RenderError::Device(error.to_string()))?;
        let (packed, stamp) = view.split_at(view.len() - 4);
        // What no shader of this submission has written is no image, even if nobody reported a fault.
        if stamp != self.stamp.to_le_bytes() {
            return Err(self.gpu.fault_or("it gave back a frame that it has not drawn".to_owned()));
        }
        let row_bytes = packed.len() / self.height_px;
        match image {
            ImageMut::Grey8(image) => {
                for (row, packed) in image.chunks_exact_mut(self.width_px).zip(packed.chunks_exact(row_bytes)) {
                    row.copy_from_slice(&packed[..self.width_px]);
                }
            }
            ImageMut::Grey16(image) => {
                for (row, packed) in image.chunks_exact_mut(self.width_px).zip(packed.chunks_exact(row_bytes)) {
                    for (value, bytes) in row.iter_mut().zip(packed.chunks_exact(2)) {
                        *value = u16::from_le_bytes([bytes[0], bytes[1]]);
                    }
                }
            }
        }
        Ok(())
    }
}

impl Renderer for WgpuRenderer {
    fn render(&mut self, view: &View, image: ImageMut<'_>) -> Result<(), RenderError> {
        image.check(self.width_px * self.height_px, self.optics.ccd.bits)?;
        view.validate()?;
        self.gpu.check()?;
        self.upload(view)?;
        let submission = self.submit();
        self.read(submission, image)
    }
}

/// Bytes of an image on the device, if it has room for all that a frame needs.
fn checked_image_bytes(
    limits: &wgpu::Limits,
    geometry: &FrameGeometry,
    effects: &Effects,
    optics: &Optics,
) -> Result<usize, RenderError> {
    let camera = &geometry.projection().camera;
    let (width_px, height_px) = (camera.width_px, camera.height_px);
    let limit_px = limits.max_texture_dimension_2d as usize;
    let [light_width, light_height] = light_size_px(geometry.projection(), effects.margin_px());
    if light_width.max(light_height) > limit_px {
        return Err(RenderError::ImageTooLarge { width_px, height_px, limit_px });
    }
    // The largest buffers hold a number of four bytes for each pixel of the light.
    let limit_mpx = limits.max_storage_buffer_binding_size / 4 / 1_000_000;
    if (light_width * light_height) as u64 > limit_mpx * 1_000_000 {
        return Err(RenderError::TooManyPixels { width_px, height_px, limit_mpx });
    }
    Ok(image_bytes(camera, optics.ccd.bits).1)
}
