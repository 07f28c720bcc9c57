//! Which renderer draws: the only file that knows both.

use super::Renderer;
use super::cpu::CpuRenderer;
use crate::error::Result;

/// Which renderer is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Choice {
    /// A real GPU if there is one, else the CPU. Software adapters (lavapipe, llvmpipe, SwiftShader, WARP) never win:
    /// our own CPU renderer is faster.
    #[default]
    Auto,
    /// The CPU renderer.
    Cpu,
    /// A GPU adapter, a software one if there is no other; an error if there is none.
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

/// The renderer, and why it is the one.
pub struct Selection {
    /// Ready to draw.
    pub renderer: Box<dyn Renderer>,
    /// One sentence for people.
    pub reason: String,
}

/// Picks a renderer.
///
/// # Errors
/// Only for [`Choice::Gpu`], if there is no adapter or its device cannot be had.
pub fn select(choice: Choice) -> Result<Selection> {
    let cpu = |reason: String| Selection { renderer: Box::new(CpuRenderer::new()), reason };
    match choice {
        Choice::Cpu => Ok(cpu("the CPU renderer was asked for".to_owned())),
        #[cfg(feature = "gpu")]
        Choice::Gpu => {
            let renderer = super::gpu::GpuRenderer::new(super::gpu::AdapterWish::Any)?;
            let reason = format!("{} was asked for", renderer.name());
            Ok(Selection { renderer: Box::new(renderer), reason })
        }
        #[cfg(feature = "gpu")]
        Choice::Auto => Ok(match super::gpu::GpuRenderer::new(super::gpu::AdapterWish::Hardware) {
            Ok(renderer) => {
                let reason = format!("{} is a real GPU", renderer.name());
                Selection { renderer: Box::new(renderer), reason }
            }
            Err(error) => cpu(format!("no real GPU to use ({error})")),
        }),
        #[cfg(not(feature = "gpu"))]
        Choice::Gpu => Err(crate::Error::Unsupported(
            "this build has no GPU renderer; build with the feature \"gpu\" or use --renderer cpu".to_owned(),
        )),
        #[cfg(not(feature = "gpu"))]
        Choice::Auto => Ok(cpu("this build has no GPU renderer".to_owned())),
    }
}
