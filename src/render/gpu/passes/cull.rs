//! Which balls and sticks a sample draws. Two-pass: what was seen last time is drawn first, then the others are asked against the depth that
//! it left (see [`super::pyramid`]), and drawn where it does not hide them: the small by the compute pass itself, pixel by pixel, which also
//! tells exactly which of them are seen; the others as lists for indirect draws.
//!
//! On lavapipe (benches/gpu_frame.rs, a million atoms and bonds, processor time of a frame) the limit of 12 pixels for what is small is as
//! good as 8 or 20; beyond, sticks that are long and thin waste more pixels of their boxes than of their quads.
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

/// Workgroups that visit clusters, each one after the other. Chosen: enough for a large device, and few where there is little to do.
const VISITORS: u32 = 1024;

/// The steps, and the layouts of what they read and write.
#[derive(Debug)]
pub(in crate::render::gpu) struct Cull {
    recall: wgpu::ComputePipeline,
    ask: wgpu::ComputePipeline,
    /// Of balls and of sticks.
    lay: [wgpu::ComputePipeline; 2],
    find: [wgpu::ComputePipeline; 2],
    claim: [wgpu::ComputePipeline; 2],
    scan: wgpu::ComputePipeline,
    scatter: wgpu::ComputePipeline,
    lists_layout: wgpu::BindGroupLayout,
    /// Group 2 of what draws a list: the instances, the arguments.
    pub(in crate::render::gpu) drawn_layout: wgpu::BindGroupLayout,
}

impl Cull {
    pub(super) fn new(gpu: &Gpu, frame: &Frame, placement: &wgpu::BindGroupLayout, pyramid: &Pyramid) -> Result<Cull> {
        let compute = wgpu::ShaderStages::COMPUTE;
        let entries = [true, true, false, false, false, false];
        let entries: Vec<_> =
            (0..).zip(entries).map(|(binding, read_only)| storage(binding, compute, read_only)).collect();
        let lists_layout = layout(gpu, "lists", &entries);
        let drawn = [
            storage(0, wgpu::ShaderStages::VERTEX_FRAGMENT, true),
            storage(1, wgpu::ShaderStages::VERTEX_FRAGMENT, true),
        ];
        let drawn_layout = layout(gpu, "listed", &drawn);
        let module = module(gpu, "cull.wgsl")?;
        let step = |entry: &str, last: Option<&wgpu::BindGroupLayout>| {
            let groups = [Some(&frame.layout), Some(placement), Some(&lists_layout), last];
            compute_pipeline(gpu, &module, entry, &groups[..3 + usize::from(last.is_some())])
        };
        // The depth buffer is not there before the first draws.
        let kinds = |task: &str, last| ["spheres", "cylinders"].map(|kind| step(&format!("{task}_{kind}"), Some(last)));
        Ok(Cull {
            recall: step("recall", None),
            ask: step("ask", Some(&pyramid.layout)),
            lay: kinds("lay", &pyramid.pixels_layout),
            find: kinds("find", &pyramid.layout),
            claim: kinds("claim", &pyramid.pixels_layout),
            scan: step("scan", None),
            scatter: step("scatter", None),
            lists_layout,
            drawn_layout,
        })
    }

    /// Group 2 of a list: instances, boxes, masks, starts, the list, arguments of its draw.
    pub(in crate::render::gpu) fn group(&self, gpu: &Gpu, buffers: [&wgpu::Buffer; 6]) -> wgpu::BindGroup {
        bound(gpu, &self.lists_layout, &buffers)
    }

    /// Group 2 of what draws a list: its instances and arguments.
    pub(in crate::render::gpu) fn drawn_group(&self, gpu: &Gpu, buffers: [&wgpu::Buffer; 2]) -> wgpu::BindGroup {
        bound(gpu, &self.drawn_layout, &buffers)
    }

    /// Draws what was seen last time if it is small, and lists the rest of it.
    pub(in crate::render::gpu) fn recall(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        (instances, listed): (&Instances, &[Listed]),
        pixels: &wgpu::BindGroup,
    ) {
        listed.iter().for_each(|listed| listed.clear(encoder));
        let mut pass = begin(encoder, "recall", frame);
        pass.set_bind_group(3, pixels, &[]);
        for listed in listed {
            self.bind(&mut pass, instances, listed);
            each_cluster(&mut pass, &self.recall, listed);
            visit(&mut pass, &self.lay, listed);
            self.list(&mut pass, listed);
        }
    }

    /// Finds what is seen now and was not before, and gives the small their pixels.
    pub(in crate::render::gpu) fn find(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        (instances, listed): (&Instances, &[Listed]),
        [pyramid, pixels]: [&wgpu::BindGroup; 2],
    ) {
        listed.iter().for_each(|listed| listed.clear(encoder));
        let mut pass = begin(encoder, "find", frame);
        pass.set_bind_group(3, pyramid, &[]);
        for listed in listed {
            self.bind(&mut pass, instances, listed);
            each_cluster(&mut pass, &self.ask, listed);
            visit(&mut pass, &self.find, listed);
        }
        // When all are laid down.
        pass.set_bind_group(3, pixels, &[]);
        for listed in listed {
            self.bind(&mut pass, instances, listed);
            visit(&mut pass, &self.claim, listed);
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
        each_cluster(pass, &self.scatter, listed);
    }
}

/// An invocation a cluster.
fn each_cluster(pass: &mut wgpu::ComputePass<'_>, pipeline: &wgpu::ComputePipeline, listed: &Listed) {
    pass.set_pipeline(pipeline);
    pass.dispatch_workgroups(listed.clusters().div_ceil(64), 1, 1);
}

/// An invocation an instance of the clusters that were gathered.
fn visit(pass: &mut wgpu::ComputePass<'_>, pipelines: &[wgpu::ComputePipeline; 2], listed: &Listed) {
    pass.set_pipeline(&pipelines[listed.kind()]);
    pass.dispatch_workgroups(listed.clusters().min(VISITORS), 1, 1);
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
