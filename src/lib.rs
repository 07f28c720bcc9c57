//! ballstick (crate docs follow)

#[cfg(feature = "window")]
pub mod app;
pub mod bonds;
pub mod cli;
pub mod color;
pub mod element;
pub mod error;
pub mod export;
pub mod import;
pub mod math;
pub mod structure;

pub use error::{Error, Result};

pub mod render;
pub mod scene;
