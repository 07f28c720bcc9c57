//! The integration tests: one binary, since wgpu links slowly.
//!
//! Where a new test goes: what one module does is tested beside its code; what several do together here, by topic.
//! `layering` the order of the modules and the size of files; `corpus` real files with independent truth; `mmcif` files written and read again; `bad_input` truncated
//! and corrupted ones; `golden` small pictures, one idea each; `parity` CPU against GPU; `shaders` WGSL without a GPU; `cli` the program
//! as a user runs it; `window` the window under a virtual display.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

mod bad_input;
mod cli;
mod corpus;
mod golden;
mod layering;
mod mmcif;
#[cfg(feature = "gpu")]
mod parity;
mod scenes;
#[cfg(feature = "gpu")]
mod shaders;
#[cfg(feature = "window")]
mod window;
