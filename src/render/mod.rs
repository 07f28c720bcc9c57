//! render (docs follow)
pub mod image;
