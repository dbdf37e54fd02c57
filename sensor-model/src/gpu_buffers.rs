//! Memory that the processor and the graphics device share.

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

/// A storage buffer of `size` bytes that holds `data` at its start. Never empty: a stage that does not read it binds it all the same.
pub(crate) fn table<T: bytemuck::Pod>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    label: &'static str,
    data: &[T],
) -> wgpu::Buffer {
    let bytes: &[u8] = bytemuck::cast_slice(data);
    let buffer = create(device, label, wgpu::BufferUsages::STORAGE, (bytes.len() as u64).max(SMALLEST_BYTES));
    queue.write_buffer(&buffer, 0, bytes);
    buffer
}

/// Size of a buffer that is bound but not read: room for one value of any kind.
pub(crate) const SMALLEST_BYTES: u64 = 16;

/// An image of one sample a pixel, without mip levels.
pub(crate) fn texture(
    device: &wgpu::Device,
    label: &'static str,
    size_px: [usize; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: size_px[0] as u32, height: size_px[1] as u32, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// The whole of a texture.
pub(crate) fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// What a shader binds at one number.
#[derive(Clone, Copy)]
pub(crate) enum Slot {
    Uniform,
    /// Read only.
    Storage,
    /// Read and written.
    Output,
    /// Read pixel by pixel.
    Image,
    /// A depth image, likewise.
    Depth,
}

/// The layout of one group of bindings, numbered from 0, seen by these stages.
pub(crate) fn group_layout(
    device: &wgpu::Device,
    label: &'static str,
    visibility: wgpu::ShaderStages,
    slots: &[Slot],
) -> wgpu::BindGroupLayout {
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let image = |sample_type| wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let entries: Vec<_> = slots
        .iter()
        .zip(0..)
        .map(|(slot, binding)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility,
            ty: match slot {
                Slot::Uniform => buffer(wgpu::BufferBindingType::Uniform),
                Slot::Storage => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
                Slot::Output => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
                Slot::Image => image(wgpu::TextureSampleType::Float { filterable: false }),
                Slot::Depth => image(wgpu::TextureSampleType::Depth),
            },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// A group of bindings, numbered from 0.
pub(crate) fn group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource<'_>],
) -> wgpu::BindGroup {
    let entries: Vec<_> = resources
        .iter()
        .zip(0..)
        .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// A pipeline's layout with one group.
pub(crate) fn pipeline_layout(device: &wgpu::Device, group: &wgpu::BindGroupLayout) -> wgpu::PipelineLayout {
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(group)],
        immediate_size: 0,
    })
}

/// A shader made of these files, one after the other.
pub(crate) fn shader(device: &wgpu::Device, label: &'static str, files: &[&str]) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(files.concat().into()),
    })
}

/// A compute pipeline; `constants` are the shader's overrides.
pub(crate) fn compute(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layout: &wgpu::BindGroupLayout,
    entry_point: &'static str,
    constants: &[(&str, f64)],
) -> wgpu::ComputePipeline {
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry_point),
        layout: Some(&pipeline_layout(device, layout)),
        module,
        entry_point: Some(entry_point),
        compilation_options: wgpu::PipelineCompilationOptions { constants, ..wgpu::PipelineCompilationOptions::default() },
        cache: None,
    })
}

/// An override's value.
pub(crate) fn flag(on: bool) -> f64 {
    f64::from(u8::from(on))
}
