//! The visible surface of one sample: every primitive a quad that bounds it tightly, an exact intersection a fragment.

use super::frame::Frame;
use super::{Parts, cleared, layout, module, pipeline, set_part, uniform};
use crate::error::Result;
use crate::render::gpu::device::Gpu;
use crate::render::gpu::instances::Instances;
use crate::render::gpu::layout::{
    CONE_ATTRIBUTES, CYLINDER_ATTRIBUTES, DEPTH_FORMAT, KINDS, PlacementConstants, SPHERE_ATTRIBUTES, SURFACE_FORMAT,
    TORUS_ATTRIBUTES, TRIANGLE_ATTRIBUTES,
};
use crate::render::gpu::targets::Targets;
use crate::scene::{ConeInstance, CylinderInstance, Region, SphereInstance, TorusInstance, TriangleInstance};

/// A pipeline for each kind of primitive.
#[derive(Debug)]
pub(in crate::render::gpu) struct Geometry {
    pipelines: [wgpu::RenderPipeline; KINDS],
    /// Group 1: a placement, by dynamic offset.
    pub(in crate::render::gpu) placement_layout: wgpu::BindGroupLayout,
}

impl Geometry {
    pub(super) fn new(gpu: &Gpu, frame: &Frame) -> Result<Geometry> {
        let placement_layout = layout(gpu, "placement", &[uniform(0, size_of::<PlacementConstants>(), true)]);
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
        let depth = wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            // Reversed depth; of equals the first drawn stays, as the reference has it.
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        };
        let pipelines = kinds.map(|(label, module, instances)| {
            let entries = [format!("vs_{label}"), format!("fs_{label}")];
            let parts = Parts {
                label,
                module: &module,
                entries: [&entries[0], &entries[1]],
                format: SURFACE_FORMAT,
                groups: &[&frame.layout, &placement_layout],
                instances: Some(instances),
                depth: Some(depth.clone()),
            };
            pipeline(gpu, parts)
        });
        Ok(Geometry { pipelines, placement_layout })
    }

    pub(in crate::render::gpu) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        instances: Option<&Instances>,
        targets: &Targets,
        region: Region,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("geometry"),
            color_attachments: &[Some(cleared(&targets.surface_view))],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        });
        set_part(&mut pass, region);
        pass.set_bind_group(0, &frame.group, &[]);
        if let Some(instances) = instances {
            instances.draw(&self.pipelines, &mut pass);
        }
    }
}
