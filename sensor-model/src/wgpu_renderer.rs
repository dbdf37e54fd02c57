//! The renderer on wgpu: one submission a frame, then the packed image is read back.

use ductloop_duct::network::Network;
use ductloop_nav::rig::Rig;

use crate::gpu::{FRAME_TIMEOUT, Gpu};
use crate::gpu_buffers::{CameraBlock, CcdBlock, FrameBuffer, LaserBlock, create, light_size_px};
use crate::gpu_scene::Scene;
use crate::light::FAN_MAX_DEG;
use crate::noise;
use crate::optics::Optics;
use crate::pipelines::{DEPTH_FORMAT, EXPOSE_GROUP, EXPOSE_ROWS, LIGHT_FORMAT, Pipelines};
use crate::renderer::{ImageMut, MAX_LASERS, RenderError, Renderer, View};
use crate::scenery::Scenery;
use crate::surface::Look;

/// Distance of two blocks in the uniform buffer: what every device accepts as a dynamic offset.
const BLOCK_BYTES: u64 = 256;

/// Renders on a graphics device, or on a software one such as lavapipe.
///
/// Its images are the same to the bit on the same adapter and driver.
#[derive(Debug)]
pub struct WgpuRenderer {
    gpu: Gpu,
    scenery: Scenery,
    scene: Scene,
    optics: Optics,
    seed: u64,
    width_px: usize,
    height_px: usize,
    /// The uniform blocks at nominal exposure and power, without a frame's keys.
    camera: CameraBlock,
    lasers: Vec<LaserBlock>,
    ccd: CcdBlock,
    pipelines: Pipelines,
    light: wgpu::TextureView,
    depth: wgpu::TextureView,
    /// The camera's block, then the CCD's, then the lasers'.
    uniforms: wgpu::Buffer,
    uniform_bytes: Vec<u8>,
    vertices: FrameBuffer,
    casters: FrameBuffer,
    planes: FrameBuffer,
    grey: wgpu::Buffer,
    read_back: wgpu::Buffer,
    light_group: wgpu::BindGroup,
    expose_group: wgpu::BindGroup,
}

impl WgpuRenderer {
    /// A renderer of what `rig` sees in `network`; `looks` is indexed by surface, `seed` chooses the noise.
    ///
    /// # Errors
    /// When rig, optics or looks are out of their bounds, or the device refuses what is asked of it.
    pub fn new(gpu: &Gpu, network: &Network, rig: &Rig, optics: &Optics, looks: &[Look], seed: u64) -> Result<Self, RenderError> {
        rig.validate()?;
        optics.validate()?;
        if rig.lasers.len() > MAX_LASERS {
            return Err(RenderError::TooManyLasers(rig.lasers.len()));
        }
        for laser in &rig.lasers {
            let fan_deg = laser.fan_rad.to_degrees();
            if !(fan_deg > 0.0 && fan_deg <= FAN_MAX_DEG) {
                return Err(RenderError::Fan { laser: laser.name.clone(), fan_deg });
            }
        }
        let scenery = Scenery::new(network, looks)?;
        let scene = Scene::new(rig, optics, &scenery);

        let (width_px, height_px) = (rig.camera.width_px, rig.camera.height_px);
        let device = gpu.device();
        let limit_px = device.limits().max_texture_dimension_2d as usize;
        let [light_width, light_height] = light_size_px(&rig.camera);
        if light_width.max(light_height) > limit_px {
            return Err(RenderError::ImageTooLarge { width_px, height_px, limit_px });
        }
        let stride = width_px.div_ceil(4);
        let image_bytes = (stride * 4 * height_px) as u64;
        // The largest buffer holds a gain of four bytes for each pixel.
        let limit_mpx = device.limits().max_storage_buffer_binding_size / 4 / 1_000_000;
        if image_bytes > limit_mpx * 1_000_000 {
            return Err(RenderError::TooManyPixels { width_px, height_px, limit_mpx });
        }

        let target = |label, format, usage| {
            device
                .create_texture(&wgpu::TextureDescriptor {
                    label: Some(label),
                    size: wgpu::Extent3d { width: light_width as u32, height: light_height as u32, depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage,
                    view_formats: &[],
                })
                .create_view(&wgpu::TextureViewDescriptor::default())
        };
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let light = target("light", LIGHT_FORMAT, attachment | wgpu::TextureUsages::TEXTURE_BINDING);
        let depth = target("depth", DEPTH_FORMAT, attachment);

        let pipelines = Pipelines::new(device, optics.noise);
        let usages = wgpu::BufferUsages::STORAGE;
        let vertices = FrameBuffer::new(device, "vertices", wgpu::BufferUsages::VERTEX);
        let casters = FrameBuffer::new(device, "casters", usages);
        let planes = FrameBuffer::new(device, "planes", usages);
        let uniform_bytes = vec![0; (2 + MAX_LASERS) * BLOCK_BYTES as usize];
        let uniforms = create(device, "uniforms", wgpu::BufferUsages::UNIFORM, uniform_bytes.len() as u64);
        let gains = create(device, "gains", usages, image_bytes * 4);
        let grey = create(device, "grey", usages | wgpu::BufferUsages::COPY_SRC, image_bytes);
        let read_back = create(device, "read back", wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST, image_bytes);
        gpu.queue().write_buffer(&gains, 0, bytemuck::cast_slice(&padded_gains(seed, optics, width_px, height_px)));

        let light_group = light_group(device, &pipelines, &uniforms, &casters, &planes);
        let expose_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("expose"),
            layout: &pipelines.expose_layout,
            entries: &[
                block(&uniforms, 0, 1, size_of::<CcdBlock>()),
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&light) },
                wgpu::BindGroupEntry { binding: 2, resource: gains.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 3, resource: grey.as_entire_binding() },
            ],
        });
        gpu.check()?;

        let lasers = rig.lasers.iter().map(|laser| LaserBlock::new(laser, &rig.line, optics)).collect();
        Ok(Self {
            gpu: gpu.clone(),
            scenery,
            scene,
            optics: optics.clone(),
            seed,
            width_px,
            height_px,
            camera: CameraBlock::new(&rig.camera, &rig.line, optics),
            lasers,
            ccd: CcdBlock::new(&rig.camera, optics),
            pipelines,
            light,
            depth,
            uniforms,
            uniform_bytes,
            vertices,
            casters,
            planes,
            grey,
            read_back,
            light_group,
            expose_group,
        })
    }

    /// Sends this frame's geometry and numbers to the device.
    fn upload(&mut self, view: &View) {
        let exposure = view.exposure_s / self.optics.exposure_s;
        let mut put = |slot: usize, bytes: &[u8]| {
            let start = slot * BLOCK_BYTES as usize;
            self.uniform_bytes[start..start + bytes.len()].copy_from_slice(bytes);
        };
        put(0, bytemuck::bytes_of(&self.camera.scaled(view.headlamp_power * exposure)));
        put(1, bytemuck::bytes_of(&self.ccd.keyed(self.seed, view.frame)));
        for (i, laser) in self.lasers.iter().enumerate() {
            put(2 + i, bytemuck::bytes_of(&laser.scaled(view.laser_power[i] * exposure)));
        }
        let (device, queue) = (self.gpu.device(), self.gpu.queue());
        queue.write_buffer(&self.uniforms, 0, &self.uniform_bytes);
        self.vertices.write(device, queue, &self.scene.vertices);
        let casters_moved = self.casters.write(device, queue, &self.scene.casters);
        let planes_moved = self.planes.write(device, queue, &self.scene.planes);
        if casters_moved || planes_moved {
            self.light_group = light_group(device, &self.pipelines, &self.uniforms, &self.casters, &self.planes);
        }
    }

    /// The frame's one submission: draw the light, expose it, copy the image to where it can be mapped.
    fn submit(&self) -> wgpu::SubmissionIndex {
        let mut encoder = self.gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("light"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &self.light,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &self.depth,
                    depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                    stencil_ops: None,
                }),
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_vertex_buffer(0, self.vertices.buffer.slice(..));
            pass.set_pipeline(&self.pipelines.sheets);
            pass.set_bind_group(0, &self.light_group, &[2 * BLOCK_BYTES as u32]);
            pass.draw(self.scene.sheets.clone(), 0..1);
            pass.set_pipeline(&self.pipelines.strips);
            for (i, strips) in self.scene.strips.iter().enumerate() {
                if !strips.is_empty() {
                    pass.set_bind_group(0, &self.light_group, &[(2 + i as u32) * BLOCK_BYTES as u32]);
                    pass.draw(strips.clone(), 0..1);
                }
            }
        }
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipelines.expose);
            pass.set_bind_group(0, &self.expose_group, &[]);
            let columns = (self.width_px.div_ceil(4)).div_ceil(EXPOSE_GROUP[0]);
            let rows = self.height_px.div_ceil(EXPOSE_ROWS * EXPOSE_GROUP[1]);
            pass.dispatch_workgroups(columns as u32, rows as u32, 1);
        }
        encoder.copy_buffer_to_buffer(&self.grey, 0, &self.read_back, 0, self.read_back.size());
        self.gpu.queue().submit([encoder.finish()])
    }

    /// Waits for the submission and copies its image out.
    fn read(&self, submission: wgpu::SubmissionIndex, image: &mut [u8]) -> Result<(), RenderError> {
        let (tell, told) = std::sync::mpsc::sync_channel(1);
        self.read_back.map_async(wgpu::MapMode::Read, .., move |result| {
            // Nobody listens any more only if the wait below has given up.
            let _ = tell.send(result);
        });
        self.gpu.wait(submission)?;
        // Another thread that waits on this device may be the one that carries the news, and be a moment late.
        match told.recv_timeout(FRAME_TIMEOUT) {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(RenderError::Device(format!("the image could not be mapped for reading: {error}"))),
            Err(_) => return Err(RenderError::Hung(FRAME_TIMEOUT.as_secs_f64())),
        }
        {
            let view = self.read_back.get_mapped_range(..).map_err(|error| RenderError::Device(error.to_string()))?;
            let stride = self.width_px.div_ceil(4) * 4;
            for (row, packed) in image.chunks_exact_mut(self.width_px).zip(view.chunks_exact(stride)) {
                row.copy_from_slice(&packed[..self.width_px]);
            }
        }
        self.read_back.unmap();
        Ok(())
    }
}

impl Renderer for WgpuRenderer {
    fn render(&mut self, view: &View, image: ImageMut<'_>) -> Result<(), RenderError> {
        image.check(self.width_px * self.height_px, self.optics.ccd.bits)?;
        let ImageMut::Grey8(image) = image else { return Err(RenderError::BufferBits { bits: 8 }) };
        view.validate()?;
        self.gpu.check()?;
        if !self.scene.build(&self.scenery, &view.world_from_camera, |laser| view.laser_power[laser] > 0.0) {
            return Err(view.outside_network());
        }
        self.upload(view);
        let submission = self.submit();
        self.read(submission, image)
    }
}

fn light_group(
    device: &wgpu::Device,
    pipelines: &Pipelines,
    uniforms: &wgpu::Buffer,
    casters: &FrameBuffer,
    planes: &FrameBuffer,
) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("light"),
        layout: &pipelines.light_layout,
        entries: &[
            block(uniforms, 0, 0, size_of::<CameraBlock>()),
            block(uniforms, 1, 0, size_of::<LaserBlock>()),
            wgpu::BindGroupEntry { binding: 2, resource: casters.buffer.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 3, resource: planes.buffer.as_entire_binding() },
        ],
    })
}

/// Binds `bytes` of the uniform buffer, from block `slot` on.
fn block(uniforms: &wgpu::Buffer, binding: u32, slot: u64, bytes: usize) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry {
        binding,
        resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: uniforms,
            offset: slot * BLOCK_BYTES,
            size: wgpu::BufferSize::new(bytes as u64),
        }),
    }
}

/// The pixels' gains, each row filled up to whole words of four pixels.
fn padded_gains(seed: u64, optics: &Optics, width_px: usize, height_px: usize) -> Vec<f32> {
    let stride = width_px.next_multiple_of(4);
    let mut table = vec![1.0; stride * height_px];
    for (pixel, gain) in noise::gains(seed, optics.ccd.prnu, width_px * height_px).enumerate() {
        table[pixel / width_px * stride + pixel % width_px] = gain as f32;
    }
    table
}
