//! ballstick (crate docs follow)

pub mod bonds;
pub mod color;
pub mod element;
pub mod error;
pub mod math;
pub mod structure;

pub use error::{Error, Result};

pub mod render;
pub mod scene;
