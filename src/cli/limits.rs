//! `--limits`: what is asked of a graphics device.

use crate::render::DeviceLimits;
use clap::{Args, ValueEnum};

/// What is asked of a graphics device.
#[derive(Debug, Clone, Copy, Args)]
pub struct LimitsArgs {
    /// What is asked of a graphics device: all that it has, or no more than the weakest ones have (WebGL 2: textures of 2048
    /// pixels a side), to see what a picture looks like there, or to get by with a driver that has trouble with more
    #[arg(long, value_name = "WHAT", default_value = "full", help_heading = "Running")]
    pub limits: LimitsArg,
}

impl LimitsArgs {
    /// What it stands for.
    #[must_use]
    pub fn of_device(self) -> DeviceLimits {
        match self.limits {
            LimitsArg::Full => DeviceLimits::Full,
            LimitsArg::Downlevel => DeviceLimits::Downlevel,
        }
    }
}

/// `--limits`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LimitsArg {
    /// All that the device has
    Full,
    /// What the weakest devices have
    Downlevel,
}
