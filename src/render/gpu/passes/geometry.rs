//! The visible surface of one sample: every primitive a quad that bounds it tightly, an exact intersection a fragment.
//!
//! Where lists are kept (see [`super::cull`]), it is two passes over the same targets: what was seen last time, then what else is, and the
//! pixels that small balls and sticks have: those are no quads, but pixels that a compute pass has given them.

use super::cull::Cull;
use super::frame::Frame;
use super::pyramid::Pyramid;
use super::{Parts, Passes, cleared, layout, module, pipeline, set_part, uniform};
use crate::error::Result;
use crate::render::gpu::device::Gpu;
use crate::render::gpu::instances::{Culling, Instances};
use crate::render::gpu::layout::{
    CONE_ATTRIBUTES, CYLINDER_ATTRIBUTES, DEPTH_FORMAT, KINDS, LISTED_ATTRIBUTES, PlacementConstants,
    SPHERE_ATTRIBUTES, SURFACE_FORMAT, TORUS_ATTRIBUTES, TRIANGLE_ATTRIBUTES,
};
use crate::render::gpu::targets::Targets;
use crate::scene::{ConeInstance, CylinderInstance, Region, SphereInstance, TorusInstance, TriangleInstance};

/// A pipeline for each kind of primitive.
#[derive(Debug)]
pub(in crate::render::gpu) struct Geometry {
    pub(in crate::render::gpu) pipelines: [wgpu::RenderPipeline; KINDS],
    /// Of the balls and sticks that a list names, where the device can list them.
    pub(in crate::render::gpu) listed: Option<[wgpu::RenderPipeline; 2]>,
    late: Option<Late>,
    /// Group 1: a placement, by dynamic offset.
    pub(in crate::render::gpu) placement_layout: wgpu::BindGroupLayout,
}

/// Pipelines of what is drawn late: a ball that is as near as a stick is seen, as if it had been drawn before.
#[derive(Debug)]
pub(in crate::render::gpu) struct Late {
    /// Of balls and sticks that a list names.
    pub(in crate::render::gpu) listed: [wgpu::RenderPipeline; 2],
    /// Of the pixels that small ones have.
    pub(in crate::render::gpu) small: [wgpu::RenderPipeline; 2],
}

impl Geometry {
    pub(super) fn placement_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
        layout(gpu, "placement", &[uniform(gpu, 0, size_of::<PlacementConstants>(), true)])
    }

    pub(super) fn new(
        gpu: &Gpu,
        frame: &Frame,
        placement_layout: wgpu::BindGroupLayout,
        cull: Option<(&Cull, &Pyramid)>,
    ) -> Result<Geometry> {
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
                constants: &[],
            };
            pipeline(gpu, parts)
        });
        let (mut listed, mut late) = (None, None);
        if let Some((cull, pyramid)) = cull {
            let kinds = ["sphere", "cylinder"];
            let of = |kind: usize, way: &str, compare| {
                let is_small = way == "small";
                let (label, file) = (format!("{way} {}s", kinds[kind]), format!("{}_{way}.wgsl", kinds[kind]));
                let vertex = if is_small { "vs_small".to_owned() } else { format!("vs_{}_{way}", kinds[kind]) };
                let fragment = format!("fs_{}{}", kinds[kind], if is_small { "_small" } else { "" });
                let groups = [&frame.layout, &placement_layout, &cull.drawn_layout, &pyramid.owners_layout];
                let parts = Parts {
                    label: &label,
                    module: &module(gpu, &file)?,
                    entries: [&vertex, &fragment],
                    format: SURFACE_FORMAT,
                    groups: if is_small { &groups } else { &groups[..3] },
                    instances: (!is_small).then(|| instances(size_of::<u32>(), &LISTED_ATTRIBUTES)),
                    depth: Some(wgpu::DepthStencilState { depth_compare: Some(compare), ..depth.clone() }),
                    constants: &[],
                };
                Ok(pipeline(gpu, parts))
            };
            use wgpu::CompareFunction::{Greater, GreaterEqual};
            let sticks = of(1, "listed", Greater)?;
            listed = Some([of(0, "listed", Greater)?, sticks.clone()]);
            late = Some(Late {
                listed: [of(0, "listed", GreaterEqual)?, sticks],
                small: [of(0, "small", GreaterEqual)?, of(1, "small", Greater)?],
            });
        }
        Ok(Geometry { pipelines, listed, late, placement_layout })
    }

    /// Draws a sample of a part of the picture.
    pub(in crate::render::gpu) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        passes: &Passes,
        (instances, culling): (Option<&Instances>, Culling),
        targets: &Targets,
        region: Region,
    ) {
        let Passes { frame, cull, pyramid, .. } = passes;
        let listed = instances.map_or(&[][..], |instances| instances.listed(culling));
        let frustum = frame.frustum(region).filter(|_| culling >= Culling::Frustum);
        let lists = match (instances, cull, pyramid, &targets.pyramid) {
            (Some(instances), Some(cull), Some(pyramid), Some(over)) if !listed.is_empty() => {
                Some((instances, cull, pyramid, over))
            }
            _ => None,
        };
        if let Some((instances, cull, _, over)) = lists {
            over.clear(encoder);
            cull.recall(encoder, frame, (instances, listed), &over.pixels_group);
        }
        self.draw(encoder, frame, targets, region, (true, lists.is_none()), |pass| {
            // What is no ball or stick comes after all of these.
            let kinds = if lists.is_some() { 0..2 } else { 0..KINDS };
            let listed = if lists.is_some() { listed } else { &[] };
            if let Some(instances) = instances {
                instances.draw(self, pass, kinds, (frustum.as_ref(), listed));
            }
        });
        if let Some((instances, cull, pyramid, over)) = lists {
            pyramid.record(encoder, over);
            cull.find(encoder, frame, (instances, listed), [&over.group, &over.pixels_group]);
            self.draw(encoder, frame, targets, region, (false, true), |pass| {
                if let Some(late) = &self.late {
                    instances.draw_late(late, &over.owners_group, pass, listed);
                }
                instances.draw(self, pass, 2..KINDS, (None, listed));
            });
        }
    }

    /// One pass over the targets, which may be the first, which clears them, and the last, after which depth is not needed.
    fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        targets: &Targets,
        region: Region,
        (is_first, is_last): (bool, bool),
        draw: impl FnOnce(&mut wgpu::RenderPass<'_>),
    ) {
        let mut attachment = cleared(&targets.surface_view);
        if !is_first {
            attachment.ops.load = wgpu::LoadOp::Load;
        }
        let load = if is_first { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load };
        let store = if is_last { wgpu::StoreOp::Discard } else { wgpu::StoreOp::Store };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("geometry"),
            color_attachments: &[Some(attachment)],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depth,
                depth_ops: Some(wgpu::Operations { load, store }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        });
        set_part(&mut pass, region);
        pass.set_bind_group(0, &frame.group, &[]);
        draw(&mut pass);
    }
}
