//! The first stage on the graphics device: the light of regions and strips is drawn into an image.
//!
//! Light is drawn as polygons, not cast as rays: a fragment knows its plane, so nothing is looked up, and the costly light of a
//! slit is computed only in the bands where there is some. Regions hide each other by depth. Strips have their shadows and what is in
//! front of them in their own closed form, and add up. An exposure in parts is drawn part by part, and added.

use crate::gpu_blocks::{CameraBlock, Lamps};
use crate::gpu_buffers::{FrameBuffer, Slot, create, group, group_layout, texture, view};
use crate::gpu_frame::FrameData;
use crate::gpu_light_pipelines::{DEPTH_FORMAT, Effects, LIGHT_FORMAT, LightPipelines, SHADE_FORMAT};
use crate::lens::Projection;
use crate::strip::Blur;

/// Pixels of a side of the tiles in which the CCD's stage works, to whole ones of which rows are filled up.
pub(crate) const TILE_PX: usize = 16;

/// Images of the light: the frame's, and for exposures in parts a part's.
#[derive(Debug)]
struct Target {
    light: wgpu::TextureView,
    shade: wgpu::TextureView,
}

/// The stage.
#[derive(Debug)]
pub(crate) struct LightStage {
    sheets: wgpu::RenderPipeline,
    strips: wgpu::RenderPipeline,
    ghosts: wgpu::RenderPipeline,
    soft_edges: wgpu::RenderPipeline,
    add: wgpu::RenderPipeline,
    effects: Effects,
    layout: wgpu::BindGroupLayout,
    whole: Target,
    part: Target,
    depth: wgpu::TextureView,
    rays: wgpu::TextureView,
    camera: CameraBlock,
    camera_buffer: wgpu::Buffer,
    vertices: [FrameBuffer; 3],
    soft: FrameBuffer,
    regions: FrameBuffer,
    seams: FrameBuffer,
    glow: FrameBuffer,
    strip_blocks: FrameBuffer,
    edges: FrameBuffer,
    holes: FrameBuffer,
    sheet_group: wgpu::BindGroup,
    strip_group: wgpu::BindGroup,
    add_group: wgpu::BindGroup,
}

/// Size of the light's image: the camera's, its rows filled up to whole tiles, and the margin on every side.
pub(crate) fn light_size_px(projection: &Projection, margin_px: usize) -> [usize; 2] {
    let camera = &projection.camera;
    [camera.width_px.next_multiple_of(TILE_PX), camera.height_px].map(|n| n + 2 * margin_px)
}

impl LightStage {
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        projection: &Projection,
        blur: &Blur,
        effects: Effects,
    ) -> Self {
        let margin_px = effects.margin_px();
        let size_px = light_size_px(projection, margin_px);
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let read = attachment | wgpu::TextureUsages::TEXTURE_BINDING;
        let target = |label| Target {
            light: view(&texture(device, label, size_px, LIGHT_FORMAT, read)),
            shade: view(&texture(device, label, if effects.patterned { size_px } else { [1, 1] }, SHADE_FORMAT, read)),
        };
        let (whole, part) = (target("light"), target("light of a part"));
        let rays = ray_texture(device, queue, projection, size_px, margin_px);

        let layout = group_layout(
            device,
            "light",
            wgpu::ShaderStages::VERTEX_FRAGMENT,
            &[Slot::Uniform, Slot::Image, Slot::Storage, Slot::Storage, Slot::Storage],
        );
        let add_layout = group_layout(device, "add", wgpu::ShaderStages::FRAGMENT, &[Slot::Image, Slot::Image]);
        let pipelines = LightPipelines { device, layout: &layout, blur, projection, effects };
        let storage = |label| FrameBuffer::new(device, label, wgpu::BufferUsages::STORAGE);
        let corners = |label| FrameBuffer::new(device, label, wgpu::BufferUsages::VERTEX);
        let camera_buffer = create(device, "camera", wgpu::BufferUsages::UNIFORM, size_of::<CameraBlock>() as u64);
        let (regions, seams, glow) = (storage("regions"), storage("seams"), storage("glow"));
        let (strip_blocks, edges, holes) = (storage("strips"), storage("edges"), storage("holes"));
        Self {
            sheets: pipelines.sheets(),
            strips: pipelines.strips(false),
            ghosts: pipelines.strips(true),
            soft_edges: pipelines.soft_edges(),
            add: pipelines.add(&add_layout),
            effects,
            depth: view(&texture(device, "depth", size_px, DEPTH_FORMAT, read)),
            camera: CameraBlock::new(projection, blur, size_px, margin_px),
            vertices: [corners("sheets"), corners("strips"), corners("ghosts")],
            soft: corners("soft edges"),
            sheet_group: drawing_group(device, &layout, &camera_buffer, &rays, [&regions, &seams, &glow]),
            strip_group: drawing_group(device, &layout, &camera_buffer, &rays, [&strip_blocks, &edges, &holes]),
            add_group: group(
                device,
                &add_layout,
                &[wgpu::BindingResource::TextureView(&part.light), wgpu::BindingResource::TextureView(&part.shade)],
            ),
            layout,
            whole,
            part,
            rays,
            camera_buffer,
            regions,
            seams,
            glow,
            strip_blocks,
            edges,
            holes,
        }
    }

    /// The frame's light, and its shade (1 - T).
    pub(crate) fn images(&self) -> [&wgpu::TextureView; 2] {
        [&self.whole.light, &self.whole.shade]
    }

    /// Its depth.
    pub(crate) fn depth(&self) -> &wgpu::TextureView {
        &self.depth
    }

    /// Sends a frame's geometry and lamps to the device.
    pub(crate) fn upload(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, frame: &FrameData, lamps: &Lamps) {
        let camera = self.camera.lit(lamps);
        queue.write_buffer(&self.camera_buffer, 0, bytemuck::bytes_of(&camera));
        for (buffer, mesh) in self.vertices.iter_mut().zip([&frame.sheets, &frame.strips, &frame.ghosts]) {
            buffer.write(device, queue, &mesh.vertices);
        }
        self.soft.write(device, queue, &frame.soft);
        let moved = [
            self.regions.write(device, queue, &frame.region_blocks),
            self.seams.write(device, queue, &frame.seams),
            self.glow.write(device, queue, &frame.glow),
        ];
        if moved.contains(&true) {
            let tables = [&self.regions, &self.seams, &self.glow];
            self.sheet_group = drawing_group(device, &self.layout, &self.camera_buffer, &self.rays, tables);
        }
        let moved = [
            self.strip_blocks.write(device, queue, &frame.strip_blocks),
            self.edges.write(device, queue, &frame.edges),
            self.holes.write(device, queue, &frame.holes),
        ];
        if moved.contains(&true) {
            let tables = [&self.strip_blocks, &self.edges, &self.holes];
            self.strip_group = drawing_group(device, &self.layout, &self.camera_buffer, &self.rays, tables);
        }
    }

    /// Draws a frame.
    pub(crate) fn draw(&self, encoder: &mut wgpu::CommandEncoder, frame: &FrameData) {
        let clear = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
        if let [sheets] = &frame.parts[..] {
            let mut pass = self.pass(encoder, &self.whole, clear, true);
            self.draw_sheets(&mut pass, sheets);
            self.draw_strips(&mut pass, frame);
            return;
        }
        for (index, sheets) in frame.parts.iter().enumerate() {
            self.draw_sheets(&mut self.pass(encoder, &self.part, clear, true), sheets);
            let load = if index == 0 { clear } else { wgpu::LoadOp::Load };
            let mut pass = self.pass(encoder, &self.whole, load, false);
            pass.set_pipeline(&self.add);
            pass.set_bind_group(0, &self.add_group, &[]);
            pass.draw(0..3, 0..1);
        }
        self.draw_strips(&mut self.pass(encoder, &self.whole, wgpu::LoadOp::Load, true), frame);
    }

    fn pass<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
        target: &Target,
        load: wgpu::LoadOp<wgpu::Color>,
        with_depth: bool,
    ) -> wgpu::RenderPass<'a> {
        let colour = |view| {
            let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
            Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
        };
        let colours = [colour(&target.light), colour(&target.shade)];
        let keep = if self.effects.defocused { wgpu::StoreOp::Store } else { wgpu::StoreOp::Discard };
        // Depth is kept where strips are drawn after the sheets' passes; it means nothing to them.
        let depth_load = if matches!(load, wgpu::LoadOp::Load) && self.effects.defocused {
            wgpu::LoadOp::Load
        } else {
            wgpu::LoadOp::Clear(0.0)
        };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("light"),
            color_attachments: &colours[..if self.effects.patterned { 2 } else { 1 }],
            depth_stencil_attachment: with_depth.then_some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations { load: depth_load, store: keep }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        })
    }

    fn draw_sheets(&self, pass: &mut wgpu::RenderPass<'_>, [corners, soft]: &[std::ops::Range<u32>; 2]) {
        pass.set_pipeline(&self.sheets);
        pass.set_bind_group(0, &self.sheet_group, &[]);
        pass.set_vertex_buffer(0, self.vertices[0].buffer.slice(..));
        pass.draw(corners.clone(), 0..1);
        if !soft.is_empty() {
            pass.set_pipeline(&self.soft_edges);
            pass.set_vertex_buffer(0, self.soft.buffer.slice(..));
            pass.draw(soft.clone(), 0..1);
        }
    }

    fn draw_strips(&self, pass: &mut wgpu::RenderPass<'_>, frame: &FrameData) {
        pass.set_bind_group(0, &self.strip_group, &[]);
        let kinds = [(&self.strips, &frame.strips), (&self.ghosts, &frame.ghosts)];
        for ((pipeline, mesh), corners) in kinds.into_iter().zip(&self.vertices[1..]) {
            if !mesh.vertices.is_empty() {
                pass.set_pipeline(pipeline);
                pass.set_vertex_buffer(0, corners.buffer.slice(..));
                pass.draw(0..mesh.vertices.len() as u32, 0..1);
            }
        }
    }
}

fn drawing_group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    camera: &wgpu::Buffer,
    rays: &wgpu::TextureView,
    tables: [&FrameBuffer; 3],
) -> wgpu::BindGroup {
    let [a, b, c] = tables.map(|table| table.buffer.as_entire_binding());
    group(device, layout, &[camera.as_entire_binding(), wgpu::BindingResource::TextureView(rays), a, b, c])
}

/// The rays of the light's image, one a pixel; of a pinhole, which needs none, a single one.
fn ray_texture(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    projection: &Projection,
    size_px: [usize; 2],
    margin_px: usize,
) -> wgpu::TextureView {
    let [width, height] = if projection.is_pinhole() { [1, 1] } else { size_px };
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
    let rays = texture(device, "rays", [width, height], wgpu::TextureFormat::Rg32Float, usage);
    // Beyond the margin, in the columns that fill up the last block, rays need not exist: they are those of the margin.
    let last = [projection.camera.width_px, projection.camera.height_px].map(|n| (n - 1 + margin_px) as f64);
    let at = |index: usize, axis: usize| (index as f64 - margin_px as f64).min(last[axis]);
    let pixels = (0..height).flat_map(|row| (0..width).map(move |column| [at(column, 0), at(row, 1)]));
    let table: Vec<[f32; 2]> = pixels.map(|pixel| projection.ray(pixel).map(|v| v as f32)).collect();
    queue.write_texture(
        rays.as_image_copy(),
        bytemuck::cast_slice(&table),
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(8 * width as u32), rows_per_image: None },
        rays.size(),
    );
    view(&rays)
}
