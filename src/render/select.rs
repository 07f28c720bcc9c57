//! Which renderer draws, and what happens when a device is lost: the only file that knows both renderers.

use super::cpu::CpuRenderer;
use super::{GBuffer, Image, Renderer, Settings, SkyVisibility, View};
use crate::error::{Error, Result};
use crate::scene::Scene;
use std::sync::Arc;

/// Which renderer is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Choice {
    /// A real GPU if there is one, else the CPU. Software adapters (lavapipe, llvmpipe, SwiftShader, WARP) never win:
    /// our own CPU renderer is faster.
    #[default]
    Auto,
    /// The CPU renderer.
    Cpu,
    /// A GPU adapter, a software one if there is no other; without any, the CPU renderer and a notice.
    Gpu,
}

impl Choice {
    /// All of them.
    pub const ALL: [Choice; 3] = [Choice::Auto, Choice::Cpu, Choice::Gpu];

    /// The name in flags.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Choice::Auto => "auto",
            Choice::Cpu => "cpu",
            Choice::Gpu => "gpu",
        }
    }

    /// The choice of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Choice> {
        Choice::ALL.into_iter().find(|choice| choice.name() == name)
    }
}

/// What is asked of a graphics device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DeviceLimits {
    /// Its own limits.
    #[default]
    Full,
    /// No more than what WebGL 2 has everywhere.
    Downlevel,
}

/// The renderer, and why it is the one.
pub struct Selection {
    /// Ready to draw.
    pub renderer: Box<dyn Renderer>,
    /// One sentence for people.
    pub reason: String,
}

/// Picks a renderer. A GPU that was asked for and is not there is no failure: the CPU renderer takes over, and
/// [`Renderer::take_notices`] says so; as it does when a device is lost later.
///
/// # Errors
/// None today; a later renderer may have no replacement.
pub fn select(choice: Choice) -> Result<Selection> {
    select_under(choice, DeviceLimits::Full)
}

/// The same with limits on what a device may be used for.
///
/// # Errors
/// As [`select`].
pub fn select_under(choice: Choice, limits: DeviceLimits) -> Result<Selection> {
    let cpu = |reason: String, notices: Vec<String>| {
        let renderer = WithFallback { gpu: None, cpu: CpuRenderer::new(), scene: None, notices };
        Selection { renderer: Box::new(renderer), reason }
    };
    if choice == Choice::Cpu {
        return Ok(cpu("the CPU renderer was asked for".to_owned(), Vec::new()));
    }
    Ok(match gpu(choice, limits) {
        Ok(renderer) => {
            let asked = if choice == Choice::Gpu { "was asked for" } else { "is a real GPU" };
            let reason = format!("{} {asked}", renderer.name());
            Selection { renderer: Box::new(WithFallback::around(renderer)), reason }
        }
        Err(error) if choice == Choice::Gpu => {
            let reason = format!("{error}; the CPU renderer takes over");
            cpu(reason.clone(), vec![reason])
        }
        Err(error) => cpu(format!("no real GPU to use ({error})"), Vec::new()),
    })
}

#[cfg(feature = "gpu")]
fn gpu(choice: Choice, limits: DeviceLimits) -> Result<Box<dyn Renderer>> {
    use super::gpu::{AdapterWish, GpuRenderer};
    let wish = if choice == Choice::Gpu { AdapterWish::Any } else { AdapterWish::Hardware };
    Ok(Box::new(match limits {
        DeviceLimits::Full => GpuRenderer::new(wish)?,
        DeviceLimits::Downlevel => GpuRenderer::downlevel(wish)?,
    }))
}

#[cfg(not(feature = "gpu"))]
fn gpu(_choice: Choice, _limits: DeviceLimits) -> Result<Box<dyn Renderer>> {
    Err(Error::Gpu("this build has no GPU renderer (feature \"gpu\")".to_owned()))
}

/// A GPU renderer with the CPU renderer behind it: what the device cannot draw, or no longer, the CPU draws.
struct WithFallback {
    gpu: Option<Box<dyn Renderer>>,
    cpu: CpuRenderer,
    scene: Option<Arc<Scene>>,
    notices: Vec<String>,
}

impl WithFallback {
    fn around(gpu: Box<dyn Renderer>) -> WithFallback {
        WithFallback { gpu: Some(gpu), cpu: CpuRenderer::new(), scene: None, notices: Vec::new() }
    }

    /// Draws with the GPU if there is one and it can; from its first failure on with the CPU.
    fn draw<R>(&mut self, draw: impl Fn(&mut dyn Renderer) -> Result<R>) -> Result<R> {
        if let Some(gpu) = &mut self.gpu {
            match draw(gpu.as_mut()) {
                Err(error @ Error::Gpu(_)) => {
                    self.notices.push(format!("{error}; the CPU renderer takes over"));
                    self.gpu = None;
                    if let Some(scene) = &self.scene {
                        self.cpu.load(Arc::clone(scene))?;
                    }
                }
                done => return done,
            }
        }
        draw(&mut self.cpu)
    }
}

impl Renderer for WithFallback {
    fn name(&self) -> String {
        self.gpu.as_ref().map_or_else(|| self.cpu.name(), |gpu| gpu.name())
    }

    fn load(&mut self, scene: Arc<Scene>) -> Result<()> {
        self.scene = Some(Arc::clone(&scene));
        self.draw(|renderer| renderer.load(Arc::clone(&scene)))
    }

    fn image(&mut self, view: &View, settings: &Settings) -> Result<Image> {
        self.draw(|renderer| renderer.image(view, settings))
    }

    fn gbuffer(&mut self, view: &View) -> Result<GBuffer> {
        self.draw(|renderer| renderer.gbuffer(view))
    }

    fn sky_visibility(&mut self, view: &View, directions: u32) -> Result<SkyVisibility> {
        self.draw(|renderer| renderer.sky_visibility(view, directions))
    }

    fn take_notices(&mut self) -> Vec<String> {
        let mut notices = self.gpu.as_mut().map_or_else(Vec::new, |gpu| gpu.take_notices());
        notices.append(&mut self.notices);
        notices
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws once, then is lost.
    struct Failing(u32);

    impl Failing {
        fn spend(&mut self) -> Result<()> {
            self.0 = self.0.checked_sub(1).ok_or_else(|| Error::Gpu("the device was lost".to_owned()))?;
            Ok(())
        }
    }

    impl Renderer for Failing {
        fn name(&self) -> String {
            "failing".to_owned()
        }

        fn load(&mut self, _scene: Arc<Scene>) -> Result<()> {
            Ok(())
        }

        fn image(&mut self, view: &View, _settings: &Settings) -> Result<Image> {
            self.spend()?;
            Ok(Image { width: view.width, height: view.height, rgba: Vec::new() })
        }

        fn gbuffer(&mut self, _view: &View) -> Result<GBuffer> {
            Err(Error::Gpu("the device was lost".to_owned()))
        }

        fn sky_visibility(&mut self, _view: &View, _directions: u32) -> Result<SkyVisibility> {
            Err(Error::Gpu("the device was lost".to_owned()))
        }
    }

    #[test]
    fn a_lost_device_is_reported_once_and_the_cpu_draws_the_scene() {
        let mut renderer = WithFallback::around(Box::new(Failing(1)));
        let scene = Arc::new(Scene::from_blocks(Vec::new(), Vec::new()));
        renderer.load(Arc::clone(&scene)).unwrap();
        let view = View::new(scene.fitted_camera(1.0), 4, 4);
        let settings = Settings { samples: 1, ground_texels: 16, ao: 0, shadow: false };
        assert!(renderer.image(&view, &settings).unwrap().rgba.is_empty());
        assert_eq!((renderer.name().as_str(), renderer.take_notices().len()), ("failing", 0));
        assert_eq!(renderer.image(&view, &settings).unwrap().rgba.len(), 64, "drawn by the CPU");
        let notices = renderer.take_notices();
        assert_eq!(notices, ["GPU: the device was lost; the CPU renderer takes over"]);
        assert!(renderer.gbuffer(&view).is_ok());
        assert_eq!(renderer.sky_visibility(&view, 4).unwrap().open, [1.0; 16]);
        assert_eq!((renderer.name().as_str(), renderer.take_notices().len()), ("cpu", 0));
    }

    /// The device is destroyed under the renderer, as a driver's reset does; one that draws nothing is enough for that.
    #[cfg(feature = "gpu")]
    #[test]
    fn a_device_that_is_destroyed_leaves_its_pictures_to_the_cpu() {
        fails_at_any_moment("lost", || {
            let (gpu, lose) = crate::render::gpu::GpuRenderer::with_loss().unwrap();
            (Box::new(gpu), Box::new(lose))
        });
    }

    /// wgpu hands this error over at the end of a scope, whatever was asked for in it.
    #[cfg(feature = "gpu")]
    #[test]
    fn a_device_that_is_out_of_memory_leaves_its_pictures_to_the_cpu() {
        fails_at_any_moment("the device is out of memory", || {
            let (gpu, exhaust) = crate::render::gpu::GpuRenderer::with_exhaustion().unwrap();
            (Box::new(gpu), Box::new(exhaust))
        });
    }

    /// A device of which each picture asks too much.
    #[cfg(all(unix, feature = "gpu"))]
    struct Overfull(crate::render::gpu::GpuRenderer);

    #[cfg(all(unix, feature = "gpu"))]
    impl Renderer for Overfull {
        fn name(&self) -> String {
            self.0.name()
        }

        fn load(&mut self, scene: Arc<Scene>) -> Result<()> {
            self.0.load(scene)
        }

        fn image(&mut self, view: &View, settings: &Settings) -> Result<Image> {
            self.0.take_gibibytes(64)?;
            self.0.image(view, settings)
        }

        fn gbuffer(&mut self, view: &View) -> Result<GBuffer> {
            self.0.gbuffer(view)
        }

        fn sky_visibility(&mut self, view: &View, directions: u32) -> Result<SkyVisibility> {
            self.0.sky_visibility(view, directions)
        }
    }

    /// One ball, and how it is drawn.
    #[cfg(feature = "gpu")]
    fn ball() -> (Arc<Scene>, View, Settings) {
        let ball = b"1\n\nC 0 0 0\n";
        let document = crate::import::read_bytes(ball, "c.xyz", &Default::default()).unwrap();
        let items = [crate::scene::Item::of(&document.records[0])];
        let scene = Arc::new(Scene::new(&items, &Default::default()));
        let view = View::new(scene.fitted_camera(1.0), 16, 16);
        (scene, view, Settings { samples: 1, ground_texels: 16, ao: 4, shadow: true })
    }

    /// Not a test: what the next one runs under a limit of memory.
    #[cfg(all(unix, feature = "gpu"))]
    #[test]
    #[ignore = "needs a limit of memory, which a test sets that starts it"]
    fn draws_with_an_overfull_device() {
        use crate::render::gpu::{AdapterWish, GpuRenderer};
        let Ok(gpu) = GpuRenderer::new(AdapterWish::Any) else {
            println!("there is no device");
            return;
        };
        let (scene, view, settings) = ball();
        let mut renderer = WithFallback::around(Box::new(Overfull(gpu)));
        renderer.load(Arc::clone(&scene)).unwrap();
        let image = renderer.image(&view, &settings).unwrap();
        let mut cpu = CpuRenderer::new();
        cpu.load(scene).unwrap();
        assert!(image == cpu.image(&view, &settings).unwrap());
        println!("{:?}", renderer.take_notices());
    }

    /// The driver itself refuses: lavapipe gives what the system gives, and of 64 GiB of addresses a limit of 16 GB leaves none.
    #[cfg(all(target_os = "linux", feature = "gpu"))]
    #[test]
    fn a_driver_that_refuses_memory_leaves_the_picture_to_the_cpu() {
        let program = std::env::current_exe().unwrap();
        let line = format!(
            "ulimit -v 16000000 && exec '{}' --ignored --exact --nocapture render::select::tests::draws_with_an_overfull_device",
            program.display()
        );
        let output = std::process::Command::new("sh").args(["-c", &line]).output().unwrap();
        let [out, err] = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
        assert!(output.status.success(), "{:?}\n{out}\n{err}", output.status);
        if out.contains("there is no device") {
            assert!(std::env::var("BALLSTICK_GPU").as_deref() != Ok("require"), "lavapipe is not installed");
            println!("SKIP there is no device");
            return;
        }
        let said = "GPU: filling the memory: the device is out of memory; the CPU renderer takes over";
        assert!(out.contains(said), "{out}\n{err}");
    }

    #[cfg(feature = "gpu")]
    fn fails_at_any_moment(how: &str, made: impl Fn() -> (Box<dyn Renderer>, Box<dyn Fn()>)) {
        let (scene, view, settings) = ball();
        let mut cpu = CpuRenderer::new();
        cpu.load(Arc::clone(&scene)).unwrap();
        let expected = cpu.image(&view, &settings).unwrap();
        for moment in ["before the scene", "before the picture", "after a picture"] {
            let (gpu, lose) = made();
            let mut renderer = WithFallback::around(gpu);
            if moment == "before the scene" {
                lose();
            }
            renderer.load(Arc::clone(&scene)).unwrap();
            if moment == "before the picture" {
                lose();
            }
            let first = renderer.image(&view, &settings).unwrap();
            lose();
            let second = renderer.image(&view, &settings).unwrap();
            assert!(second == expected && (moment == "after a picture" || first == expected), "{moment}");
            let notices = renderer.take_notices();
            assert!(
                matches!(notices.as_slice(), [said] if said.contains(how) && said.contains("CPU renderer takes over")),
                "{moment}: {notices:?}"
            );
            assert_eq!(renderer.name(), "cpu", "{moment}");
        }
    }
}
