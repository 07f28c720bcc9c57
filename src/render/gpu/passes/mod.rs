//! The passes that make a picture, each with its pipelines and the layouts of what it reads; all built once, immutable for the
//! life of the device. What they read from picture to picture belongs to [`super::instances`], [`super::ground`], [`super::sky`] and
//! [`super::targets`].
//!
//! | pass | shader | reads | writes | when |
//! |---|---|---|---|---|
//! | [`ground_map`] | `ground_map.wgsl` | the distance field | light on the ground | scene, light or ground changed |
//! | [`geometry`] | `sphere.wgsl`, … | instances, placements, what [`cull`] drew | id, depth, normal, colour of one sample | every sample |
//! | [`pyramid`] | `pyramid.wgsl` | the depth so far | the farthest of every 16, 256, 4096 pixels | every sample, where the device computes |
//! | [`cull`] | `cull.wgsl` | boxes of clusters, instances, that | small balls and sticks, lists of the others for [`geometry`] | every sample, twice, where the device computes |
//! | [`shade`] | `shade_pass.wgsl` | that, tubes of sky and key light, the sum before | the sum | every sample |
//! | [`resolve`] | `resolve.wgsl` | the sum, light on the ground, text | pixels | once shown |
//!
//! The light of the sky and the shadow of the key light have no pass of their own: each sample asks its share of their directions where
//! it is shaded, so that they converge with the samples.

pub(super) mod cull;
pub(super) mod frame;
pub(super) mod geometry;
pub(super) mod ground_map;
pub(super) mod pyramid;
pub(super) mod resolve;
pub(super) mod shade;

use super::device::Gpu;
use super::shaders;
use crate::error::Result;
use crate::scene::Region;
use cull::Cull;
use frame::Frame;
use geometry::Geometry;
use ground_map::GroundMapPass;
use pyramid::Pyramid;
use resolve::Resolve;
use shade::Shade;
use std::num::NonZeroU64;

/// All of them.
#[derive(Debug)]
pub(super) struct Passes {
    pub(super) frame: Frame,
    pub(super) ground_map: GroundMapPass,
    pub(super) geometry: Geometry,
    pub(super) shade: Shade,
    pub(super) resolve: Resolve,
    /// Where the device computes.
    pub(super) cull: Option<Cull>,
    pub(super) pyramid: Option<Pyramid>,
}

impl Passes {
    pub(super) fn new(gpu: &Gpu) -> Result<Passes> {
        gpu.guard("building the pipelines", || {
            let frame = Frame::new(gpu);
            let placement = Geometry::placement_layout(gpu);
            let (mut cull, mut pyramid) = (None, None);
            if gpu.can_cull() {
                let levels = Pyramid::new(gpu)?;
                cull = Some(Cull::new(gpu, &frame, &placement, &levels)?);
                pyramid = Some(levels);
            }
            Ok(Passes {
                ground_map: GroundMapPass::new(gpu, &frame)?,
                geometry: Geometry::new(gpu, &frame, placement, cull.as_ref().zip(pyramid.as_ref()))?,
                cull,
                pyramid,
                shade: Shade::new(gpu, &frame)?,
                resolve: Resolve::new(gpu, &frame)?,
                frame,
            })
        })
    }
}

/// Integers, or floats in their bits.
const WORDS: wgpu::TextureSampleType = wgpu::TextureSampleType::Uint;
/// Floats that are only loaded.
const FLOATS: wgpu::TextureSampleType = wgpu::TextureSampleType::Float { filterable: false };

fn layout(gpu: &Gpu, label: &str, entries: &[wgpu::BindGroupLayoutEntry]) -> wgpu::BindGroupLayout {
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
}

/// A uniform of all stages that the device has.
fn uniform(gpu: &Gpu, binding: u32, bytes: usize, has_dynamic_offset: bool) -> wgpu::BindGroupLayoutEntry {
    let compute = if gpu.can_cull() { wgpu::ShaderStages::COMPUTE } else { wgpu::ShaderStages::NONE };
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT | compute,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset,
            min_binding_size: NonZeroU64::new(bytes as u64),
        },
        count: None,
    }
}

fn storage(binding: u32, visibility: wgpu::ShaderStages, read_only: bool) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    }
}

fn compute_pipeline(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    entry: &str,
    groups: &[Option<&wgpu::BindGroupLayout>],
) -> wgpu::ComputePipeline {
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(entry),
        bind_group_layouts: groups,
        immediate_size: 0,
    });
    gpu.count(|work| work.pipelines += 1);
    gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(&layout),
        module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    })
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

/// A bind group of textures, in the order of their bindings.
fn textures(gpu: &Gpu, label: &str, layout: &wgpu::BindGroupLayout, views: &[&wgpu::TextureView]) -> wgpu::BindGroup {
    let entry = |(binding, &view)| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) };
    let entries: Vec<_> = (0..).zip(views).map(entry).collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}

fn module(gpu: &Gpu, name: &str) -> Result<wgpu::ShaderModule> {
    let source = shaders::source(name)?;
    Ok(gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(name),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    }))
}

/// What differs from pipeline to pipeline.
struct Parts<'a> {
    label: &'a str,
    module: &'a wgpu::ShaderModule,
    /// Vertex and fragment stage.
    entries: [&'a str; 2],
    /// Of the one target.
    format: wgpu::TextureFormat,
    groups: &'a [&'a wgpu::BindGroupLayout],
    /// Drawn as strips, an instance each, with depth; without them one triangle covers the target.
    instances: Option<wgpu::VertexBufferLayout<'a>>,
    depth: Option<wgpu::DepthStencilState>,
    /// Values of the fragment stage's overrides.
    constants: &'a [(&'a str, f64)],
}

fn pipeline(gpu: &Gpu, parts: Parts<'_>) -> wgpu::RenderPipeline {
    let Parts { label, module, entries, format, groups, instances, depth, constants } = parts;
    let groups: Vec<_> = groups.iter().map(|&group| Some(group)).collect();
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &groups,
        immediate_size: 0,
    });
    let topology = match instances {
        Some(_) => wgpu::PrimitiveTopology::TriangleStrip,
        None => wgpu::PrimitiveTopology::TriangleList,
    };
    let buffers: Vec<_> = instances.into_iter().map(Some).collect();
    gpu.count(|work| work.pipelines += 1);
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(label),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(entries[0]),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState { topology, ..wgpu::PrimitiveState::default() },
        depth_stencil: depth,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(entries[1]),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants,
                ..wgpu::PipelineCompilationOptions::default()
            },
            targets: &[Some(wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// A pipeline that draws one triangle over a target; `groups` come after that of the frame, `constants` are values of overrides.
fn fullscreen_pipeline(
    gpu: &Gpu,
    frame: &Frame,
    [file, entry]: [&str; 2],
    format: wgpu::TextureFormat,
    groups: &[&wgpu::BindGroupLayout],
    constants: &[(&str, f64)],
) -> Result<wgpu::RenderPipeline> {
    let groups: Vec<_> = std::iter::once(&frame.layout).chain(groups.iter().copied()).collect();
    let (label, entries, module) = (entry, ["vs_fullscreen", entry], &module(gpu, file)?);
    let (groups, instances, depth) = (&groups, None, None);
    Ok(pipeline(gpu, Parts { label, module, entries, format, groups, instances, depth, constants }))
}

/// Records a triangle over the part of the target that the region takes; the rest is cleared.
fn fullscreen(
    encoder: &mut wgpu::CommandEncoder,
    frame: &Frame,
    (label, pipeline): (&str, &wgpu::RenderPipeline),
    groups: &[&wgpu::BindGroup],
    target: &wgpu::TextureView,
    region: Region,
) {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(cleared(target))],
        ..wgpu::RenderPassDescriptor::default()
    });
    set_part(&mut pass, region);
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &frame.group, &[]);
    for (index, group) in (1..).zip(groups) {
        pass.set_bind_group(index, *group, &[]);
    }
    pass.draw(0..3, 0..1);
}

fn cleared(view: &wgpu::TextureView) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store },
    }
}

fn set_part(pass: &mut wgpu::RenderPass<'_>, region: Region) {
    pass.set_viewport(0.0, 0.0, region.width as f32, region.height as f32, 0.0, 1.0);
    pass.set_scissor_rect(0, 0, region.width, region.height);
}
