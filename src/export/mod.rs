//! Files out: pictures, channels and structure formats, each written whole or not at all.
//!
//! [`atomic`] owns every write, and [`unfinished`] what a run that ends early must not leave behind. [`picture`] turns what a renderer hands back into a picture file, [`animation`] many of them into a film; [`formats`] is
//! the table of structure formats, one module each ([`json`], [`mmcif`], [`cjson`], [`mol2`], [`pdb`], [`sdf`], [`xyz`]). Writers take any [`std::io::Write`] and
//! stream: none builds the file in memory. What a format cannot hold is named by `losses`, never dropped silently. [`solid`] writes scenes as triangles
//! for other programs.

pub mod animation;
pub mod atomic;
pub mod cjson;
pub mod formats;
pub mod json;
pub mod mmcif;
pub mod mol2;
mod npy;
pub mod pdb;
pub mod picture;
mod png;
pub mod sdf;
pub mod solid;
mod text;
pub mod unfinished;
pub mod xyz;

/// Rounds to six decimals where that changes a number by no more than 1e-9 of it: edge lengths and angles
/// that went through cell vectors come back as 11.500000000000002, which is 11.5 (rounding errors of f64 are some 1e-16 of the number).
#[must_use]
pub fn tidy(x: f64) -> f64 {
    let rounded = (x * 1e6).round() / 1e6;
    if (x - rounded).abs() <= 1e-9 * x.abs() { rounded } else { x }
}

#[cfg(test)]
mod tests {
    use super::tidy;
    use std::io;

    /// What a writer writes, as text: for the tests of the formats.
    pub(super) fn written(write: impl FnOnce(&mut dyn io::Write) -> io::Result<()>) -> String {
        let mut bytes = Vec::new();
        write(&mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    #[test]
    fn tidy_removes_rounding_errors_and_nothing_else() {
        assert_eq!(tidy(11.500_000_000_000_002), 11.5);
        assert_eq!(tidy(1.234_567_89), 1.234_567_89);
        assert_eq!(tidy(0.0), 0.0);
        assert_eq!(tidy(1e-7), 1e-7);
    }
}
