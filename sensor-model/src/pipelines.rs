//! The two stages on the graphics device: light is drawn into an image, then exposed and packed by a compute shader.
//!
//! Light is drawn as polygons, not cast as rays through the cells: a fragment knows its plane, so nothing is looked up, and the
//! costly light of a slit is computed only on the strips about its plane. Walls shadow exactly, since the strips are cut to what
//! the laser's source sees; only solids are tested in the shader.

use crate::gpu_scene::Vertex;

/// Format of the light's image: half floats, good to 0.06 DN at a stripe's peak, which every device can add into.
pub(crate) const LIGHT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg16Float;
/// Format of its depth.
pub(crate) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Rows that a thread of `ccd.wgsl` takes, and its workgroup's size.
pub(crate) const EXPOSE_ROWS: usize = 16;
pub(crate) const EXPOSE_GROUP: [usize; 2] = [16, 2];

/// The compiled stages.
#[derive(Debug)]
pub(crate) struct Pipelines {
    /// Sheets under the headlamp.
    pub(crate) sheets: wgpu::RenderPipeline,
    /// Strips of sheets near a slit's plane, added to them.
    pub(crate) strips: wgpu::RenderPipeline,
    /// Point spread and CCD.
    pub(crate) expose: wgpu::ComputePipeline,
    /// What the first two read.
    pub(crate) light_layout: wgpu::BindGroupLayout,
    /// What the last one reads and writes.
    pub(crate) expose_layout: wgpu::BindGroupLayout,
}

impl Pipelines {
    /// `noise` is compiled into the CCD's shader.
    pub(crate) fn new(device: &wgpu::Device, noise: bool) -> Self {
        let light = device.create_shader_module(wgpu::include_wgsl!("../shaders/light.wgsl"));
        let ccd = device.create_shader_module(wgpu::include_wgsl!("../shaders/ccd.wgsl"));

        let drawing = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let light_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("light"),
            entries: &[
                entry(0, drawing, uniform(false)),
                entry(1, drawing, uniform(true)),
                entry(2, wgpu::ShaderStages::FRAGMENT, storage(true)),
                entry(3, wgpu::ShaderStages::FRAGMENT, storage(true)),
            ],
        });
        let image = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let expose_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("expose"),
            entries: &[
                entry(0, wgpu::ShaderStages::COMPUTE, uniform(false)),
                entry(1, wgpu::ShaderStages::COMPUTE, image),
                entry(2, wgpu::ShaderStages::COMPUTE, storage(true)),
                entry(3, wgpu::ShaderStages::COMPUTE, storage(false)),
            ],
        });

        let drawn = pipeline_layout(device, &light_layout);
        let expose = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("expose"),
            layout: Some(&pipeline_layout(device, &expose_layout)),
            module: &ccd,
            entry_point: Some("expose"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &[("NOISE", f64::from(u8::from(noise)))],
                ..wgpu::PipelineCompilationOptions::default()
            },
            cache: None,
        });
        Self {
            sheets: drawing_pipeline(device, &light, &drawn, "sheet", wgpu::CompareFunction::Greater, None),
            strips: drawing_pipeline(device, &light, &drawn, "strip", wgpu::CompareFunction::GreaterEqual, Some(ADDED)),
            expose,
            light_layout,
            expose_layout,
        }
    }
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

fn drawing_pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    fragment: &str,
    nearer: wgpu::CompareFunction,
    blend: Option<wgpu::BlendState>,
) -> wgpu::RenderPipeline {
    let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Float32x4, 3 => Uint32x2];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("corner"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Vertex>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &attributes,
            })],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(blend.is_none()),
            depth_compare: Some(nearer),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState { format: LIGHT_FORMAT, blend, write_mask: wgpu::ColorWrites::ALL })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn pipeline_layout(device: &wgpu::Device, group: &wgpu::BindGroupLayout) -> wgpu::PipelineLayout {
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(group)],
        immediate_size: 0,
    })
}

fn entry(binding: u32, visibility: wgpu::ShaderStages, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
}

fn uniform(has_dynamic_offset: bool) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty: wgpu::BufferBindingType::Uniform, has_dynamic_offset, min_binding_size: None }
}

fn storage(read_only: bool) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only },
        has_dynamic_offset: false,
        min_binding_size: None,
    }
}
