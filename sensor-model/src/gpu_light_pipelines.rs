//! The pipelines that draw light, compiled for what there is of the model's effects.

use crate::gpu_buffers::{flag, pipeline_layout, shader};
use crate::gpu_mesh::{PointVertex, Vertex};
use crate::lens::Projection;
use crate::light::PSF_RADIUS;
use crate::optics::Optics;
use crate::strip::Blur;
use crate::surface::Look;

/// Format of the light's image, red for lasers and green for all else: half floats, good to 0.06 DN at a stripe's peak, which every
/// device can add into.
pub(crate) const LIGHT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg16Float;
/// Format of what seams and spangles take away.
pub(crate) const SHADE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;
/// Format of its depth.
pub(crate) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Which of the model's effects there are at all; what is not there is left out of the shaders.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effects {
    /// Seams or spangles.
    pub(crate) patterned: bool,
    /// Something may be out of focus.
    pub(crate) defocused: bool,
    /// Some surface mirrors.
    shiny: bool,
    /// Light that varies slowly.
    glowing: bool,
}

impl Effects {
    pub(crate) fn of(optics: &Optics, looks: &[Look]) -> Self {
        Self {
            patterned: looks.iter().any(|look| look.seam_m > 0.0 || look.spangle > 0.0),
            defocused: optics.lens.aperture_m > 0.0,
            shiny: looks.iter().any(|look| look.specular > 0.0),
            glowing: optics.bounce || optics.ghosts || optics.ambient_dn > 0.0,
        }
    }

    /// Pixels about the image from which light may still spread into it.
    pub(crate) fn margin_px(&self) -> usize {
        if self.defocused { crate::gpu_filter::RADIUS } else { PSF_RADIUS }
    }
}

/// What the stage's pipelines are made of.
pub(crate) struct LightPipelines<'a> {
    pub(crate) device: &'a wgpu::Device,
    pub(crate) layout: &'a wgpu::BindGroupLayout,
    pub(crate) blur: &'a Blur,
    pub(crate) projection: &'a Projection,
    pub(crate) effects: Effects,
}

/// What a pipeline runs, and on what.
struct Entries<'a> {
    vertex: &'a str,
    fragment: &'a str,
    vertices: Vertices,
}

/// What is drawn.
enum Vertices {
    /// Corners of triangles, [`Vertex`].
    Triangles,
    /// Pixels, [`PointVertex`].
    Points,
    /// A triangle that covers the image and knows its own corners.
    None,
}

/// Light adds up.
const ADDED: wgpu::BlendState = {
    let component = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    wgpu::BlendState { color: component, alpha: component }
};

impl LightPipelines<'_> {
    pub(crate) fn sheets(&self) -> wgpu::RenderPipeline {
        let module =
            shader(self.device, "sheets", &[include_str!("../shaders/camera.wgsl"), include_str!("../shaders/sheet.wgsl")]);
        let constants = [self.common().as_slice(), &[("GLOWING", flag(self.effects.glowing))]].concat();
        let fragment = match (self.projection.is_pinhole(), self.effects.patterned) {
            (true, false) => "sheet",
            (true, true) => "patterned_sheet",
            (false, false) => "bent_sheet",
            (false, true) => "bent_patterned_sheet",
        };
        let depth = depth_state(wgpu::CompareFunction::Greater, true);
        let entries = Entries { vertex: "sheet_corner", fragment, vertices: Vertices::Triangles };
        self.pipeline(&module, entries, &constants, self.layout, Some(depth), &self.targets(None, true))
    }

    pub(crate) fn soft_edges(&self) -> wgpu::RenderPipeline {
        let module =
            shader(self.device, "edges", &[include_str!("../shaders/camera.wgsl"), include_str!("../shaders/soft_edge.wgsl")]);
        let depth = depth_state(wgpu::CompareFunction::Always, false);
        let entries = Entries { vertex: "soft_point", fragment: "soft_pixel", vertices: Vertices::Points };
        self.pipeline(&module, entries, &[], self.layout, Some(depth), &self.targets(Some(ADDED), false))
    }

    pub(crate) fn strips(&self, mirrored: bool) -> wgpu::RenderPipeline {
        let module =
            shader(self.device, "strips", &[include_str!("../shaders/camera.wgsl"), include_str!("../shaders/strip.wgsl")]);
        let constants = [self.common().as_slice(), &[("MIRRORED", flag(mirrored))]].concat();
        let depth = depth_state(wgpu::CompareFunction::Always, false);
        let targets = self.targets(Some(ADDED), false);
        let entries = Entries { vertex: "strip_corner", fragment: "strip", vertices: Vertices::Triangles };
        self.pipeline(&module, entries, &constants, self.layout, Some(depth), &targets)
    }

    pub(crate) fn add(&self, layout: &wgpu::BindGroupLayout) -> wgpu::RenderPipeline {
        let module = shader(self.device, "add", &[include_str!("../shaders/add.wgsl")]);
        let fragment = if self.effects.patterned { "add_patterned" } else { "add" };
        let entries = Entries { vertex: "everywhere", fragment, vertices: Vertices::None };
        self.pipeline(&module, entries, &[], layout, None, &self.targets(Some(ADDED), true))
    }

    fn common(&self) -> [(&'static str, f64); 3] {
        [
            ("DISTORTED", flag(!self.projection.is_pinhole())),
            ("VIGNETTING", flag(self.blur.vignetting)),
            ("SHINY", flag(self.effects.shiny)),
        ]
    }

    /// Light, and where there is a pattern its shade, which strips leave alone.
    fn targets(&self, blend: Option<wgpu::BlendState>, shading: bool) -> Vec<Option<wgpu::ColorTargetState>> {
        let target = |format, write_mask| Some(wgpu::ColorTargetState { format, blend, write_mask });
        let shade = if shading { wgpu::ColorWrites::ALL } else { wgpu::ColorWrites::empty() };
        let mut targets = vec![target(LIGHT_FORMAT, wgpu::ColorWrites::ALL)];
        if self.effects.patterned {
            targets.push(target(SHADE_FORMAT, shade));
        }
        targets
    }

    fn pipeline(
        &self,
        module: &wgpu::ShaderModule,
        entries: Entries<'_>,
        constants: &[(&str, f64)],
        layout: &wgpu::BindGroupLayout,
        depth_stencil: Option<wgpu::DepthStencilState>,
        targets: &[Option<wgpu::ColorTargetState>],
    ) -> wgpu::RenderPipeline {
        let Entries { vertex, fragment, vertices } = entries;
        let attributes = wgpu::vertex_attr_array![0 => Float32x2, 1 => Float32, 2 => Uint32];
        let (bytes, attributes) = match vertices {
            Vertices::Triangles => (size_of::<Vertex>(), &attributes[..]),
            Vertices::Points => (size_of::<PointVertex>(), &attributes[..2]),
            Vertices::None => (0, &[][..]),
        };
        let step_mode = wgpu::VertexStepMode::Vertex;
        let buffers = [Some(wgpu::VertexBufferLayout { array_stride: bytes as u64, step_mode, attributes })];
        let topology = match vertices {
            Vertices::Points => wgpu::PrimitiveTopology::PointList,
            _ => wgpu::PrimitiveTopology::TriangleList,
        };
        let options = wgpu::PipelineCompilationOptions { constants, ..wgpu::PipelineCompilationOptions::default() };
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(fragment),
            layout: Some(&pipeline_layout(self.device, layout)),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(vertex),
                compilation_options: options.clone(),
                buffers: if bytes > 0 { &buffers } else { &[] },
            },
            primitive: wgpu::PrimitiveState { topology, ..wgpu::PrimitiveState::default() },
            depth_stencil,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState { module, entry_point: Some(fragment), compilation_options: options, targets }),
            multiview_mask: None,
            cache: None,
        })
    }
}

fn depth_state(nearer: wgpu::CompareFunction, write: bool) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(write),
        depth_compare: Some(nearer),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}
