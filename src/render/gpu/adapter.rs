//! Which adapters there are, in which order they are tried, and the limits asked of them.

use super::device::CULL_BUFFERS;
use crate::error::{Error, Result};

/// Which adapters will do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AdapterWish {
    /// Real GPUs only.
    Hardware,
    /// Real GPUs first, then software adapters (lavapipe, llvmpipe, SwiftShader, WARP).
    Any,
    /// Only what OpenGL reaches, software too: for tests of that way. `WGPU_BACKEND=gl` makes [`AdapterWish::Any`] the same.
    OpenGl,
}

/// What an adapter is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AdapterReport {
    /// Name of the device.
    pub name: String,
    /// Interface it is reached by: `vulkan`, `metal`, `dx12`, `gl`.
    pub backend: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`.
    pub device_type: String,
    /// Name of the driver.
    pub driver: String,
    /// Version of the driver, as it tells it.
    pub driver_info: String,
    /// Whether it computes on the CPU.
    pub is_software: bool,
    /// Longest side of a texture in pixels.
    pub max_texture_2d: u32,
    /// Largest buffer in bytes.
    pub max_buffer_bytes: u64,
}

impl AdapterReport {
    fn new(adapter: &wgpu::Adapter) -> AdapterReport {
        let info = adapter.get_info();
        let limits = adapter.limits();
        let is_software = is_software(&info);
        let device_type = match info.device_type {
            _ if is_software => "software",
            wgpu::DeviceType::DiscreteGpu => "discrete",
            wgpu::DeviceType::IntegratedGpu => "integrated",
            wgpu::DeviceType::VirtualGpu => "virtual",
            _ => "other",
        };
        AdapterReport {
            name: info.name,
            backend: info.backend.to_string(),
            device_type: device_type.to_owned(),
            driver: info.driver,
            driver_info: info.driver_info,
            is_software,
            max_texture_2d: limits.max_texture_dimension_2d,
            max_buffer_bytes: limits.max_buffer_size,
        }
    }
}

impl std::fmt::Display for AdapterReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}, {}", self.name, self.backend)?;
        if self.driver_info.is_empty() { Ok(()) } else { write!(f, ", {}", self.driver_info) }
    }
}

/// All adapters of this machine, best first; none is an empty list.
#[must_use]
pub fn adapters() -> Vec<AdapterReport> {
    let Some(instance) = instance(None) else { return Vec::new() };
    ranked(&instance).iter().map(AdapterReport::new).collect()
}

/// Whether the system can have a real GPU at all. On Linux every driver of one shows a device file; without any there is no
/// need to load the graphics drivers, which takes a tenth of a second, and of which some write to standard error.
///
/// # Errors
/// [`Error::Gpu`] if there is none.
pub(super) fn check_for_hardware() -> Result<()> {
    // Mesa and AMD: dri; NVIDIA's own driver: nvidia0; Windows' subsystem for Linux: dxg; Adreno and Mali: kgsl, mali.
    const FILES: [&str; 5] = ["/dev/dri", "/dev/nvidia0", "/dev/dxg", "/dev/kgsl-3d0", "/dev/mali0"];
    if cfg!(target_os = "linux") && !FILES.iter().any(|file| std::path::Path::new(file).exists()) {
        return Err(Error::Gpu("the system shows no graphics device under /dev".to_owned()));
    }
    Ok(())
}

/// What a window is shown on. OpenGL draws only to windows of the display that it was opened with.
pub(super) type Display = Box<dyn wgpu::wgt::WgpuHasDisplayHandle>;

/// The way to all backends of this build; `None` if it has none. `WGPU_BACKEND` narrows them.
pub(super) fn instance(display: Option<Display>) -> Option<wgpu::Instance> {
    if wgpu::Instance::enabled_backend_features().is_empty() {
        return None;
    }
    let descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    Some(wgpu::Instance::new(wgpu::InstanceDescriptor { display, ..descriptor }))
}

/// Adapters, best first. A function of what the adapters say, so the same machine always gives the same order.
fn ranked(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    adapters.sort_by_key(|adapter| rank(&adapter.get_info()));
    adapters
}

/// Smaller is better: kind of device, then interface (OpenGL last).
fn rank(info: &wgpu::AdapterInfo) -> (u8, u8) {
    let device = match info.device_type {
        _ if is_software(info) => 4,
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        _ => 3,
    };
    let backend = match info.backend {
        wgpu::Backend::Vulkan | wgpu::Backend::Metal => 0,
        wgpu::Backend::Dx12 => 1,
        wgpu::Backend::Gl => 2,
        _ => 3,
    };
    (device, backend)
}

/// Whether it computes on the CPU. The name is asked too: not every interface tells the kind of device.
fn is_software(info: &wgpu::AdapterInfo) -> bool {
    let name = info.name.to_ascii_lowercase();
    let known = ["llvmpipe", "lavapipe", "softpipe", "swiftshader", "microsoft basic render", "warp"];
    info.device_type == wgpu::DeviceType::Cpu || known.iter().any(|known| name.contains(known))
}

/// What [`open`] hands back.
pub(super) struct Opened {
    pub(super) adapter: wgpu::Adapter,
    pub(super) report: AdapterReport,
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
}

/// The first adapter that fulfils the wish, can draw to the surface, and gives a device. `limits` replaces those asked for.
///
/// # Errors
/// [`Error::Gpu`] with every adapter that was tried and why it would not do.
pub(super) fn open(
    wish: AdapterWish,
    instance: &wgpu::Instance,
    surface: Option<&wgpu::Surface<'_>>,
    limits: Option<&wgpu::Limits>,
) -> Result<Opened> {
    let mut tried = Vec::new();
    for adapter in ranked(instance) {
        let report = AdapterReport::new(&adapter);
        if wish == AdapterWish::Hardware && report.is_software {
            tried.push(format!("{report}: a software adapter, slower than drawing on the CPU"));
            continue;
        }
        if wish == AdapterWish::OpenGl && adapter.get_info().backend != wgpu::Backend::Gl {
            tried.push(format!("{report}: not OpenGL"));
            continue;
        }
        if surface.is_some_and(|surface| !adapter.is_surface_supported(surface)) {
            tried.push(format!("{report}: cannot draw to this window"));
            continue;
        }
        let wanted = limits.cloned().unwrap_or_else(|| wanted_limits(&adapter.limits(), computing(&adapter)));
        match pollster::block_on(adapter.request_device(&device_descriptor(wanted))) {
            Ok((device, queue)) => return Ok(Opened { adapter, report, device, queue }),
            Err(error) => tried.push(format!("{report}: {error}")),
        }
    }
    if tried.is_empty() {
        return Err(Error::Gpu("no adapter found: no graphics driver (Vulkan, Metal, DirectX 12, OpenGL)".to_owned()));
    }
    Err(Error::Gpu(format!("no adapter that will do; tried {}", tried.join("; "))))
}

pub(super) fn device_descriptor(required_limits: wgpu::Limits) -> wgpu::DeviceDescriptor<'static> {
    wgpu::DeviceDescriptor {
        label: Some("ballstick"),
        required_features: wgpu::Features::empty(),
        required_limits,
        ..wgpu::DeviceDescriptor::default()
    }
}

/// Whether an adapter can make lists of what is drawn. In GLSL the depth cannot be read.
fn computing(adapter: &wgpu::Adapter) -> bool {
    let needed = wgpu::DownlevelFlags::COMPUTE_SHADERS
        | wgpu::DownlevelFlags::VERTEX_STORAGE
        | wgpu::DownlevelFlags::INDIRECT_EXECUTION;
    adapter.get_info().backend != wgpu::Backend::Gl && adapter.get_downlevel_capabilities().flags.contains(needed)
}

/// What WebGL2-class devices have is enough; larger textures and buffers are taken where there are any, and what culling computes with.
fn wanted_limits(adapter: &wgpu::Limits, computes: bool) -> wgpu::Limits {
    let mut floor = wgpu::Limits::downlevel_webgl2_defaults();
    if computes && adapter.max_storage_buffers_per_shader_stage >= CULL_BUFFERS {
        floor = wgpu::Limits {
            max_storage_buffers_per_shader_stage: CULL_BUFFERS,
            max_storage_buffer_binding_size: adapter.max_storage_buffer_binding_size,
            max_compute_workgroup_storage_size: adapter.max_compute_workgroup_storage_size,
            max_compute_invocations_per_workgroup: adapter.max_compute_invocations_per_workgroup,
            max_compute_workgroup_size_x: adapter.max_compute_workgroup_size_x,
            max_compute_workgroup_size_y: adapter.max_compute_workgroup_size_y,
            max_compute_workgroup_size_z: adapter.max_compute_workgroup_size_z,
            max_compute_workgroups_per_dimension: adapter.max_compute_workgroups_per_dimension,
            ..floor
        };
    }
    wgpu::Limits {
        max_texture_dimension_2d: adapter.max_texture_dimension_2d,
        max_buffer_size: adapter.max_buffer_size.max(floor.max_buffer_size),
        ..floor
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info(name: &str, device_type: wgpu::DeviceType, backend: wgpu::Backend) -> wgpu::AdapterInfo {
        wgpu::AdapterInfo { name: name.to_owned(), ..wgpu::AdapterInfo::new(device_type, backend) }
    }

    #[test]
    fn real_gpus_come_before_software_and_opengl_last() {
        use wgpu::{Backend, DeviceType};
        let mut all = [
            info("llvmpipe (LLVM 15, 256 bits)", DeviceType::Cpu, Backend::Vulkan),
            info("Microsoft Basic Render Driver", DeviceType::Other, Backend::Dx12),
            info("card", DeviceType::DiscreteGpu, Backend::Gl),
            info("chip", DeviceType::IntegratedGpu, Backend::Vulkan),
            info("card", DeviceType::DiscreteGpu, Backend::Vulkan),
        ];
        all.sort_by_key(rank);
        let names: Vec<_> = all.iter().map(|info| (info.name.as_str(), info.backend)).collect();
        assert_eq!(names[..3], [("card", Backend::Vulkan), ("card", Backend::Gl), ("chip", Backend::Vulkan)]);
        assert!(all[3..].iter().all(is_software) && !all[..3].iter().any(is_software));
    }

    #[test]
    fn listing_adapters_never_panics() {
        for report in adapters() {
            assert!(report.max_texture_2d > 0, "{report}");
        }
    }
}
