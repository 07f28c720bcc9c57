//! The device, and everything that can go wrong with it as an [`Error::Gpu`].
//!
//! Work runs inside error scopes; what escapes them and the loss of the device are recorded by callbacks and asked for
//! after every step. Waiting has an end: a device that is lost or stuck does not hang the program.

use super::adapter::{AdapterReport, Opened};
use crate::error::{Error, Result};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// One submission is a small part of a picture. One that takes this long will not come back; software adapters take
/// seconds for a million primitives.
const STUCK: Duration = Duration::from_secs(120);

/// Storage buffers that the culling of [`super::passes::cull`] reads and writes at once.
pub(super) const CULL_BUFFERS: u32 = 7;

/// What callbacks have told.
#[derive(Debug, Default)]
struct Trouble(Mutex<Option<String>>);

impl Trouble {
    fn record(&self, what: String) {
        let mut first = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        first.get_or_insert(what);
    }

    fn check(&self) -> Result<()> {
        match &*self.0.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(what) => Err(Error::Gpu(what.clone())),
            None => Ok(()),
        }
    }
}

/// What was made on the device so far: what can be done once should not be done again.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Work {
    /// Pipelines.
    pub pipelines: u64,
    /// Textures.
    pub textures: u64,
    /// Buffers.
    pub buffers: u64,
    /// Bytes that were written to them.
    pub bytes: u64,
}

/// A device ready to work.
#[derive(Debug)]
pub(super) struct Gpu {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    pub(super) limits: wgpu::Limits,
    /// What it runs on; `None` for the noop device of tests.
    pub(super) report: Option<AdapterReport>,
    trouble: Arc<Trouble>,
    work: Mutex<Work>,
    /// Whether a test has the device be out of memory.
    exhausted: Arc<AtomicBool>,
}

impl Gpu {
    pub(super) fn new(opened: Opened) -> (Gpu, wgpu::Adapter) {
        (Gpu::of(opened.device, opened.queue, Some(opened.report)), opened.adapter)
    }

    pub(super) fn of(device: wgpu::Device, queue: wgpu::Queue, report: Option<AdapterReport>) -> Gpu {
        let trouble = Arc::new(Trouble::default());
        let on_error = Arc::clone(&trouble);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| on_error.record(error.to_string())));
        let on_loss = Arc::clone(&trouble);
        device.set_device_lost_callback(move |reason, message| {
            on_loss.record(format!("the device is lost ({reason:?}): {message}"));
        });
        let limits = device.limits();
        Gpu { device, queue, limits, report, trouble, work: Mutex::default(), exhausted: Arc::default() }
    }

    /// Whether the device computes, with what [`super::passes::cull`] needs: seven storage buffers, lists as vertices, indirect draws. It has
    /// these limits only if all that is there.
    pub(super) fn can_cull(&self) -> bool {
        self.limits.max_storage_buffers_per_shader_stage >= CULL_BUFFERS
            && self.limits.max_compute_invocations_per_workgroup >= 256
    }

    /// What was made so far.
    pub(super) fn work(&self) -> Work {
        *self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn count(&self, add: impl FnOnce(&mut Work)) {
        add(&mut self.work.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// From now on every scope of errors that is closed has one of memory in it.
    pub(super) fn exhaust(&self) {
        self.exhausted.store(true, Ordering::Relaxed);
    }

    /// What does that while something else has this.
    #[cfg(test)]
    pub(super) fn exhausting(&self) -> impl Fn() + use<> {
        let exhausted = Arc::clone(&self.exhausted);
        move || exhausted.store(true, Ordering::Relaxed)
    }

    /// Makes every later step fail with this.
    pub(super) fn record(&self, what: String) {
        self.trouble.record(what);
    }

    /// Does `work`; an error of the device in it, or before it outside of all scopes, is the result.
    pub(super) fn guard<T>(&self, what: &str, work: impl FnOnce() -> Result<T>) -> Result<T> {
        self.trouble.check()?;
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let internal = self.device.push_error_scope(wgpu::ErrorFilter::Internal);
        let done = work();
        let mut errors = [
            pollster::block_on(internal.pop()),
            pollster::block_on(validation.pop()),
            pollster::block_on(memory.pop()),
        ];
        if self.exhausted.load(Ordering::Relaxed) {
            errors[2] = Some(wgpu::Error::OutOfMemory { source: "a test says so".into() });
        }
        // Callbacks run in polls only: without one a loss would show a step late.
        self.poll(wgpu::PollType::Poll).ok();
        // A lost device refuses all that is made on it: the loss is what to tell.
        self.trouble.check()?;
        match errors.into_iter().flatten().next() {
            Some(error) => Err(failure(what, &error)),
            None => done,
        }
    }

    /// A command encoder, filled and submitted.
    pub(super) fn submit(&self, label: &str, fill: impl FnOnce(&mut wgpu::CommandEncoder)) -> wgpu::SubmissionIndex {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(label) });
        fill(&mut encoder);
        self.queue.submit([encoder.finish()])
    }

    /// Waits for a submission.
    pub(super) fn wait(&self, submission: &wgpu::SubmissionIndex) -> Result<()> {
        let start = Instant::now();
        loop {
            self.trouble.check()?;
            let slice = wgpu::PollType::Wait {
                submission_index: Some(submission.clone()),
                timeout: Some(Duration::from_millis(500)),
            };
            match self.poll(slice) {
                Ok(_) => return self.trouble.check(),
                Err(Some(wgpu::PollError::Timeout)) if start.elapsed() < STUCK => {}
                Err(Some(error)) => return Err(Error::Gpu(format!("waiting for the device: {error}"))),
                Err(None) => return Err(Error::Gpu("the device was lost while waiting for it".to_owned())),
            }
        }
    }

    /// Polls; `Err(None)` is a panic of wgpu-core 30, which has no other answer where a poll finds the device lost.
    fn poll(&self, how: wgpu::PollType) -> std::result::Result<wgpu::PollStatus, Option<wgpu::PollError>> {
        let polled = catch_unwind(AssertUnwindSafe(|| self.device.poll(how)));
        if polled.is_err() {
            self.trouble.record("the device is lost".to_owned());
        }
        polled.map_err(|_| None)?.map_err(Some)
    }

    /// The bytes of a buffer that `submission` fills.
    pub(super) fn read(&self, buffer: &wgpu::Buffer, submission: &wgpu::SubmissionIndex) -> Result<wgpu::BufferView> {
        const PENDING: u8 = 0;
        const MAPPED: u8 = 1;
        const FAILED: u8 = 2;
        let state = Arc::new(AtomicU8::new(PENDING));
        let told = Arc::clone(&state);
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            told.store(if result.is_ok() { MAPPED } else { FAILED }, Ordering::Release);
        });
        let start = Instant::now();
        loop {
            self.wait(submission)?;
            match state.load(Ordering::Acquire) {
                MAPPED => break,
                PENDING if start.elapsed() < STUCK => std::thread::yield_now(),
                _ => return Err(Error::Gpu("the device did not hand the picture back".to_owned())),
            }
        }
        buffer.get_mapped_range(..).map_err(|error| Error::Gpu(format!("reading the picture back: {error}")))
    }

    /// A buffer with these bytes, which are at most the limit of a buffer.
    pub(super) fn buffer(&self, label: &str, usage: wgpu::BufferUsages, bytes: &[u8]) -> wgpu::Buffer {
        let buffer = self.empty_buffer(label, usage, bytes.len() as u64);
        self.write(&buffer, bytes);
        buffer
    }

    /// Writes to the start of a buffer.
    pub(super) fn write(&self, buffer: &wgpu::Buffer, bytes: &[u8]) {
        self.count(|work| work.bytes += bytes.len() as u64);
        self.queue.write_buffer(buffer, 0, bytes);
    }

    /// A buffer to write to.
    pub(super) fn empty_buffer(&self, label: &str, usage: wgpu::BufferUsages, size: u64) -> wgpu::Buffer {
        self.count(|work| work.buffers += 1);
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: size.next_multiple_of(4).max(4),
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    /// A two-dimensional texture.
    pub(super) fn texture(
        &self,
        label: &str,
        size: [u32; 2],
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
    ) -> wgpu::Texture {
        self.count(|work| work.textures += 1);
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width: size[0].max(1), height: size[1].max(1), depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    }
}

/// What the device refused, in words.
fn failure(what: &str, error: &wgpu::Error) -> Error {
    match error {
        wgpu::Error::OutOfMemory { .. } => Error::Gpu(format!("{what}: the device is out of memory")),
        error => Error::Gpu(format!("{what}: {error}")),
    }
}

/// All of a texture.
pub(super) fn view_of(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::gpu::adapter::device_descriptor;

    fn noop() -> Gpu {
        let (device, queue) = wgpu::Device::noop(&device_descriptor(wgpu::Limits::downlevel_webgl2_defaults()));
        Gpu::of(device, queue, None)
    }

    #[test]
    fn a_refused_resource_is_an_error_and_the_next_step_works() {
        let gpu = noop();
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let make = |side: u32| {
            gpu.guard("making a texture", || {
                Ok(gpu.texture("large", [side, 1], super::super::layout::SUM_FORMAT, usage))
            })
        };
        let message = make(1 << 20).unwrap_err().to_string();
        assert!(message.contains("making a texture"), "{message}");
        assert!(make(16).is_ok());
    }

    #[test]
    fn a_device_out_of_memory_is_an_error_like_any_other() {
        let error = failure("drawing", &wgpu::Error::OutOfMemory { source: "the driver says so".into() });
        assert!(matches!(&error, Error::Gpu(said) if said == "drawing: the device is out of memory"), "{error}");
    }

    #[test]
    fn a_lost_device_is_an_error_and_does_not_hang() {
        let gpu = noop();
        let buffer = gpu.empty_buffer("read", wgpu::BufferUsages::MAP_READ, 16);
        let submission = gpu.submit("nothing", |_| ());
        gpu.device.destroy();
        assert!(gpu.read(&buffer, &submission).is_err());
        assert!(gpu.guard("anything", || Ok(())).is_err());
    }
}
