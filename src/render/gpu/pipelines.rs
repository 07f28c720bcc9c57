//! Bind group layouts and pipelines: all there are, built once.

use super::device::Gpu;
use super::layout::{
    CONE_ATTRIBUTES, CYLINDER_ATTRIBUTES, DEPTH_FORMAT, FRAME_BYTES, FieldConstants, GROUND_FORMAT, IMAGE_FORMAT,
    KINDS, PlacementConstants, SPHERE_ATTRIBUTES, SUM_FORMAT, SURFACE_FORMAT, SampleConstants, TORUS_ATTRIBUTES,
    TRIANGLE_ATTRIBUTES,
};
use super::shaders;
use crate::error::Result;
use crate::scene::{ConeInstance, CylinderInstance, SphereInstance, TorusInstance, TriangleInstance};
use std::num::NonZeroU64;

/// Immutable for the life of the device.
#[derive(Debug)]
pub(super) struct Pipelines {
    /// Group 0 of every pass: frame and sample constants.
    pub(super) frame_layout: wgpu::BindGroupLayout,
    /// Group 1 of the geometry pass: a placement, by dynamic offset.
    pub(super) placement_layout: wgpu::BindGroupLayout,
    /// Group 1 of the shade pass: surfaces and the sum before.
    pub(super) shade_layout: wgpu::BindGroupLayout,
    /// Group 1 of the resolve pass: sums and the ground's light.
    pub(super) resolve_layout: wgpu::BindGroupLayout,
    /// Group 1 of the pass to a window: the same, and the text.
    pub(super) present_layout: wgpu::BindGroupLayout,
    /// Group 1 of the ground pass: the distance field.
    pub(super) field_layout: wgpu::BindGroupLayout,
    /// Group 2 of the shade pass: tubes and directions of the sky and of the key light, and the primitives.
    pub(super) sky_layout: wgpu::BindGroupLayout,
    /// Surfaces of each kind of primitive.
    pub(super) surfaces: [wgpu::RenderPipeline; KINDS],
    pub(super) ground_map: wgpu::RenderPipeline,
    pub(super) shade: wgpu::RenderPipeline,
    pub(super) resolve: wgpu::RenderPipeline,
}

fn uniform(binding: u32, bytes: u64, has_dynamic_offset: bool) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset,
            min_binding_size: NonZeroU64::new(bytes),
        },
        count: None,
    }
}

fn texture(binding: u32, sample_type: wgpu::TextureSampleType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    }
}

impl Pipelines {
    pub(super) fn new(gpu: &Gpu) -> Result<Pipelines> {
        gpu.guard("building the pipelines", || Pipelines::build(gpu))
    }

    fn build(gpu: &Gpu) -> Result<Pipelines> {
        let layout = |label: &str, entries: &[wgpu::BindGroupLayoutEntry]| {
            gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        let words = wgpu::TextureSampleType::Uint;
        let floats = wgpu::TextureSampleType::Float { filterable: false };
        let frame_layout =
            layout("frame", &[uniform(0, FRAME_BYTES, false), uniform(1, size_of::<SampleConstants>() as u64, false)]);
        let placement_layout = layout("placement", &[uniform(0, size_of::<PlacementConstants>() as u64, true)]);
        let shade_layout = layout("shade", &[texture(0, words), texture(1, words)]);
        let resolve_layout = layout("resolve", &[texture(0, words), texture(1, words)]);
        let present_layout = layout("present", &[texture(0, words), texture(1, words), texture(2, words)]);
        let field_layout = layout(
            "field",
            &[uniform(0, size_of::<FieldConstants>() as u64, false), texture(1, floats), texture(2, floats)],
        );

        let sky_layout = layout(
            "sky",
            &[texture(0, words), texture(1, floats), texture(2, words), texture(3, floats), texture(4, floats)],
        );

        let instances = |array_stride: usize, attributes: &'static [wgpu::VertexAttribute]| wgpu::VertexBufferLayout {
            array_stride: array_stride as u64,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes,
        };
        let kinds = [
            ("sphere", module(gpu, "sphere.wgsl")?, instances(size_of::<SphereInstance>(), &SPHERE_ATTRIBUTES)),
            ("cylinder", module(gpu, "cylinder.wgsl")?, instances(size_of::<CylinderInstance>(), &CYLINDER_ATTRIBUTES)),
            ("cone", module(gpu, "cone.wgsl")?, instances(size_of::<ConeInstance>(), &CONE_ATTRIBUTES)),
            ("torus", module(gpu, "torus.wgsl")?, instances(size_of::<TorusInstance>(), &TORUS_ATTRIBUTES)),
            ("triangle", module(gpu, "triangle.wgsl")?, instances(size_of::<TriangleInstance>(), &TRIANGLE_ATTRIBUTES)),
        ];
        let groups = [&frame_layout, &placement_layout];
        let surfaces = kinds.each_ref().map(|(kind, module, buffer)| {
            let entries = [format!("vs_{kind}"), format!("fs_{kind}")];
            pipeline(gpu, kind, module, [&entries[0], &entries[1]], Some(buffer.clone()), SURFACE_FORMAT, &groups)
        });

        let full = |label: &str, file: &str, entry: &str, format, own: &[&wgpu::BindGroupLayout]| {
            let groups: Vec<_> = std::iter::once(&frame_layout).chain(own.iter().copied()).collect();
            let module = module(gpu, file)?;
            Ok::<_, crate::Error>(pipeline(gpu, label, &module, ["vs_fullscreen", entry], None, format, &groups))
        };
        Ok(Pipelines {
            surfaces,
            ground_map: full("ground map", "ground_map.wgsl", "fs_ground_map", GROUND_FORMAT, &[&field_layout])?,
            shade: full("shade", "shade_pass.wgsl", "fs_shade", SUM_FORMAT, &[&shade_layout, &sky_layout])?,
            resolve: full("resolve", "resolve.wgsl", "fs_resolve", IMAGE_FORMAT, &[&resolve_layout])?,
            sky_layout,
            frame_layout,
            placement_layout,
            shade_layout,
            resolve_layout,
            present_layout,
            field_layout,
        })
    }

    /// The pipeline that writes to a window's surface of this format.
    pub(super) fn present(&self, gpu: &Gpu, format: wgpu::TextureFormat) -> Result<wgpu::RenderPipeline> {
        gpu.guard("building the window's pipeline", || {
            let entry = if format.is_srgb() { "fs_present_linear" } else { "fs_present" };
            let module = module(gpu, "resolve.wgsl")?;
            let groups = [&self.frame_layout, &self.present_layout];
            Ok(pipeline(gpu, "present", &module, ["vs_fullscreen", entry], None, format, &groups))
        })
    }
}

fn module(gpu: &Gpu, name: &str) -> Result<wgpu::ShaderModule> {
    let source = shaders::source(name)?;
    Ok(gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(name),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    }))
}

/// A pipeline that draws instances with depth where it has an instance buffer, else one triangle over the target.
fn pipeline(
    gpu: &Gpu,
    label: &str,
    module: &wgpu::ShaderModule,
    entries: [&str; 2],
    instances: Option<wgpu::VertexBufferLayout<'_>>,
    format: wgpu::TextureFormat,
    groups: &[&wgpu::BindGroupLayout],
) -> wgpu::RenderPipeline {
    let groups: Vec<_> = groups.iter().map(|&group| Some(group)).collect();
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &groups,
        immediate_size: 0,
    });
    let is_geometry = instances.is_some();
    let buffers: Vec<_> = instances.into_iter().map(Some).collect();
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(label),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(entries[0]),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState {
            topology: if is_geometry {
                wgpu::PrimitiveTopology::TriangleStrip
            } else {
                wgpu::PrimitiveTopology::TriangleList
            },
            ..wgpu::PrimitiveState::default()
        },
        depth_stencil: is_geometry.then(|| wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            // Reversed depth; of equals the first drawn stays, as the reference has it.
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(entries[1]),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL })],
        }),
        multiview_mask: None,
        cache: None,
    })
}
