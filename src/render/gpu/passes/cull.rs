//! Which balls and sticks a sample draws, as lists for indirect draws. Two-pass: what was seen last time is drawn first, then the others
//! are asked against the depth that it left (see [`super::pyramid`]), and drawn where it does not hide them.
//!
//! Wants a device that computes. A list keeps the order of the instances, and of a ball and a stick at the very same depth the ball is seen,
//! as without lists. Limits: of two balls or two sticks at the same depth the one that was seen last time is, whichever comes first: a
//! pixel in some millions where balls overlap.

use super::frame::Frame;
use super::pyramid::Pyramid;
use super::{compute_pipeline, layout, module, storage};
use crate::error::Result;
use crate::render::gpu::device::Gpu;
use crate::render::gpu::instances::Instances;
use crate::render::gpu::listed::Listed;

/// The steps, and the layouts of what they read and write.
#[derive(Debug)]
pub(in crate::render::gpu) struct Cull {
    recall: wgpu::ComputePipeline,
    find: [wgpu::ComputePipeline; 2],
    scan: wgpu::ComputePipeline,
    scatter: wgpu::ComputePipeline,
    lists_layout: wgpu::BindGroupLayout,
    /// Group 2 of what draws a list: the instances.
    pub(in crate::render::gpu) drawn_layout: wgpu::BindGroupLayout,
}

impl Cull {
    pub(super) fn new(gpu: &Gpu, frame: &Frame, placement: &wgpu::BindGroupLayout, pyramid: &Pyramid) -> Result<Cull> {
        let compute = wgpu::ShaderStages::COMPUTE;
        let entries = [true, true, false, false, false, false];
        let entries: Vec<_> =
            (0..).zip(entries).map(|(binding, read_only)| storage(binding, compute, read_only)).collect();
        let lists_layout = layout(gpu, "lists", &entries);
        let drawn_layout = layout(gpu, "listed", &[storage(0, wgpu::ShaderStages::VERTEX, true)]);
        let module = module(gpu, "cull.wgsl")?;
        let groups = [Some(&frame.layout), Some(placement), Some(&lists_layout), Some(&pyramid.layout)];
        let asking = |entry| compute_pipeline(gpu, &module, entry, &groups);
        // The others do not know the depth, which need not be there yet.
        let step = |entry| compute_pipeline(gpu, &module, entry, &groups[..3]);
        Ok(Cull {
            recall: step("recall"),
            find: [asking("find_spheres"), asking("find_cylinders")],
            scan: step("scan"),
            scatter: step("scatter"),
            lists_layout,
            drawn_layout,
        })
    }

    /// Group 2 of a list: instances, boxes, masks, starts, the list, arguments of its draw.
    pub(in crate::render::gpu) fn group(&self, gpu: &Gpu, buffers: [&wgpu::Buffer; 6]) -> wgpu::BindGroup {
        bound(gpu, &self.lists_layout, &buffers)
    }

    /// Group 2 of what draws a list of these instances.
    pub(in crate::render::gpu) fn drawn_group(&self, gpu: &Gpu, instances: &wgpu::Buffer) -> wgpu::BindGroup {
        bound(gpu, &self.drawn_layout, &[instances])
    }

    /// Lists what was seen last time.
    pub(in crate::render::gpu) fn recall(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        (instances, listed): (&Instances, &[Listed]),
    ) {
        let mut pass = begin(encoder, "recall", frame);
        for listed in listed {
            self.bind(&mut pass, instances, listed);
            pass.set_pipeline(&self.recall);
            pass.dispatch_workgroups(listed.clusters().div_ceil(64), 1, 1);
            self.list(&mut pass, listed);
        }
    }

    /// Lists what is seen now and was not before.
    pub(in crate::render::gpu) fn find(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        (instances, listed): (&Instances, &[Listed]),
        pyramid: &wgpu::BindGroup,
    ) {
        let mut pass = begin(encoder, "find", frame);
        pass.set_bind_group(3, pyramid, &[]);
        for listed in listed {
            self.bind(&mut pass, instances, listed);
            pass.set_pipeline(&self.find[listed.kind()]);
            pass.dispatch_workgroups(listed.clusters(), 1, 1);
            self.list(&mut pass, listed);
        }
    }

    fn bind(&self, pass: &mut wgpu::ComputePass<'_>, instances: &Instances, listed: &Listed) {
        let (group, offset) = instances.placement(listed.placement());
        pass.set_bind_group(1, group, &offset);
        pass.set_bind_group(2, &listed.cull_group, &[]);
    }

    fn list(&self, pass: &mut wgpu::ComputePass<'_>, listed: &Listed) {
        pass.set_pipeline(&self.scan);
        pass.dispatch_workgroups(1, 1, 1);
        pass.set_pipeline(&self.scatter);
        pass.dispatch_workgroups(listed.clusters(), 1, 1);
    }
}

fn begin<'a>(encoder: &'a mut wgpu::CommandEncoder, label: &str, frame: &Frame) -> wgpu::ComputePass<'a> {
    let mut pass =
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(label), timestamp_writes: None });
    pass.set_bind_group(0, &frame.group, &[]);
    pass
}

fn bound(gpu: &Gpu, layout: &wgpu::BindGroupLayout, buffers: &[&wgpu::Buffer]) -> wgpu::BindGroup {
    let resources = buffers.iter().map(|buffer| buffer.as_entire_binding());
    let entries: Vec<_> =
        (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("lists"), layout, entries: &entries })
}
