//! How large a picture is and which part of it is wanted: `--size`, `--dpi`, `--region`, `--crop`.

use super::values::Region;
use std::str::FromStr;

/// Longest side of the full picture in pixels: up to here sample positions are exact in f32, so that every part of a
/// picture is what it is in the whole ([`crate::render::settings::sample_offset`]).
pub const MAX_SIDE: u32 = 1 << 15;

/// Pixels an inch where lengths are given without `--dpi`: what journals ask of pictures in print.
const DEFAULT_DPI: u32 = 300;

/// Millimetres of an inch, exact since 1959.
const MM_PER_INCH: f64 = 25.4;

/// Height over width where only a width is given: that of the default size, 1920x1080.
const HEIGHT_OF_WIDTH: f64 = 9.0 / 16.0;

/// Free space around what is seen when nothing is said, in percent. Chosen: a shadow's end does not touch the edge.
const CROP_MARGIN_PERCENT: f64 = 2.0;

/// Width and height of the full picture in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// What `--size` says: pixels, or lengths that a resolution turns into pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PictureSize {
    /// In pixels.
    Pixels(Size),
    /// In print.
    Millimetres {
        /// Width in millimetres.
        width: f64,
        /// Height in millimetres.
        height: f64,
    },
}

impl PictureSize {
    /// The resolution of the picture in pixels an inch, given what `--dpi` says; `None` where nothing says one.
    #[must_use]
    pub fn dpi(self, dpi: Option<u32>) -> Option<u32> {
        match self {
            PictureSize::Pixels(_) => dpi,
            PictureSize::Millimetres { .. } => Some(dpi.unwrap_or(DEFAULT_DPI)),
        }
    }

    /// The size in pixels, given what `--dpi` says.
    ///
    /// # Errors
    /// If lengths give no pixel, or more than [`MAX_SIDE`].
    pub fn pixels(self, dpi: Option<u32>) -> Result<Size, String> {
        let (width, height) = match self {
            PictureSize::Pixels(size) => return Ok(size),
            PictureSize::Millimetres { width, height } => (width, height),
        };
        let dpi = dpi.unwrap_or(DEFAULT_DPI);
        let pixels = |mm: f64| (mm / MM_PER_INCH * f64::from(dpi)).round();
        let [width, height] = [width, height].map(pixels);
        let fits = |side: f64| (1.0..=f64::from(MAX_SIDE)).contains(&side);
        if !fits(width) || !fits(height) {
            return Err(format!(
                "--size {self} at {dpi} dpi is {width}x{height} pixels; a picture has 1 to {MAX_SIDE} a side"
            ));
        }
        Ok(Size { width: width as u32, height: height as u32 })
    }
}

impl std::fmt::Display for PictureSize {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            PictureSize::Pixels(size) => size.fmt(f),
            PictureSize::Millimetres { width, height } => write!(f, "{width}mmx{height}mm"),
        }
    }
}

impl FromStr for PictureSize {
    type Err = String;

    fn from_str(text: &str) -> Result<PictureSize, String> {
        let wrong = || {
            format!(
                "expected WIDTHxHEIGHT in pixels, such as 1920x1080, each from 1 to {MAX_SIDE}, or in print, such as \
                 85mmx60mm, 8cmx6cm, 3.3inx2.5in, or the width alone, such as 85mm"
            )
        };
        let Some((width, height)) = text.split_once(['x', 'X', '×']) else {
            let width = millimetres(text).ok_or_else(wrong)?;
            return Ok(PictureSize::Millimetres { width, height: width * HEIGHT_OF_WIDTH });
        };
        if let (Some(width), Some(height)) = (millimetres(width), millimetres(height)) {
            return Ok(PictureSize::Millimetres { width, height });
        }
        let side = |text: &str| text.trim().parse().ok().filter(|side| (1..=MAX_SIDE).contains(side));
        let size = Size { width: side(width).ok_or_else(wrong)?, height: side(height).ok_or_else(wrong)? };
        Ok(PictureSize::Pixels(size))
    }
}

/// A length with its unit.
fn millimetres(text: &str) -> Option<f64> {
    let text = text.trim().to_ascii_lowercase();
    let units = [("mm", 1.0), ("cm", 10.0), ("in", MM_PER_INCH)];
    let (number, unit) = units.iter().find_map(|&(name, mm)| Some((text.strip_suffix(name)?, mm)))?;
    let length = number.trim().parse::<f64>().ok()? * unit;
    (length.is_finite() && length > 0.0).then_some(length)
}

/// Checks that a region lies in the picture.
pub(super) fn check_region(size: Size, region: Region) -> Result<(), String> {
    let inside = |start: u32, length: u32, side: u32| start.checked_add(length).is_some_and(|end| end <= side);
    if inside(region.x, region.width, size.width) && inside(region.y, region.height, size.height) {
        return Ok(());
    }
    Err(format!("--region {region} is not inside the picture of {size} pixels"))
}

/// How much free space `--crop` leaves around what is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Crop {
    /// In pixels.
    Pixels(u32),
    /// In percent of the longer side of what is seen.
    Percent(f64),
}

impl Crop {
    /// What is seen and the space around it, as far as the picture goes.
    #[must_use]
    pub fn around(self, seen: Region, full: Size) -> Region {
        let margin = match self {
            Crop::Pixels(pixels) => pixels,
            Crop::Percent(percent) => (f64::from(seen.width.max(seen.height)) * percent / 100.0).round() as u32,
        };
        let grown = |start: u32, length: u32, side: u32| {
            let end = start.saturating_add(length).saturating_add(margin).min(side);
            let start = start.saturating_sub(margin);
            (start, end.saturating_sub(start).max(1))
        };
        let (x, width) = grown(seen.x, seen.width, full.width);
        let (y, height) = grown(seen.y, seen.height, full.height);
        Region { x, y, width, height }
    }
}

impl std::fmt::Display for Crop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Crop::Pixels(pixels) => write!(f, "auto,{pixels}"),
            Crop::Percent(percent) => write!(f, "auto,{percent}%"),
        }
    }
}

impl FromStr for Crop {
    type Err = String;

    fn from_str(text: &str) -> Result<Crop, String> {
        let wrong = || "expected auto, or auto and the space left around in pixels or percent: auto,20 or auto,5%";
        let lower = text.trim().to_ascii_lowercase();
        let margin = lower.strip_prefix("auto").ok_or_else(wrong)?;
        if margin.is_empty() {
            return Ok(Crop::Percent(CROP_MARGIN_PERCENT));
        }
        let margin = margin.strip_prefix(',').ok_or_else(wrong)?.trim();
        if let Some(percent) = margin.strip_suffix('%') {
            let percent = percent.trim().parse().ok().filter(|percent| (0.0..=100.0).contains(percent));
            return percent.map(Crop::Percent).ok_or_else(|| wrong().to_owned());
        }
        let pixels = margin.strip_suffix("px").unwrap_or(margin).trim().parse().ok();
        pixels.filter(|&pixels| pixels <= MAX_SIDE).map(Crop::Pixels).ok_or_else(|| wrong().to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::super::values::tests::check;
    use super::*;

    fn region(x: u32, y: u32, width: u32, height: u32) -> Region {
        Region { x, y, width, height }
    }

    #[test]
    fn sizes_are_pixels_or_lengths_with_their_unit() {
        let size = |width, height| PictureSize::Pixels(Size { width, height });
        let print = |width, height| PictureSize::Millimetres { width, height };
        check(
            &[
                ("1920x1080", size(1920, 1080)),
                ("1X1", size(1, 1)),
                ("3000×2000", size(3000, 2000)),
                ("32768x1", size(32768, 1)),
                ("85mmx60mm", print(85.0, 60.0)),
                ("8cm x 6 cm", print(80.0, 60.0)),
                ("0.5inX1IN", print(12.7, 25.4)),
                ("160mm", print(160.0, 90.0)),
            ],
            &[
                "",
                "x",
                "1920",
                "0x5",
                "5x0",
                "-1x5",
                "5x5x5",
                "32769x1",
                "1x32769",
                "1.5x2",
                "99999999999999999999x1",
                "85mmx60",
                "85x60mm",
                "0mmx1mm",
                "-1cmx1cm",
                "nanmmx1mm",
                "1e400mmx1mm",
                "mmxmm",
                "1kmx1km",
            ],
        );
    }

    #[test]
    fn lengths_become_pixels_at_the_resolution_and_300_without_one() {
        let size: PictureSize = "85mmx60mm".parse().unwrap();
        assert_eq!(size.pixels(Some(300)), Ok(Size { width: 1004, height: 709 }));
        assert_eq!((size.pixels(None), size.dpi(None)), (size.pixels(Some(300)), Some(300)));
        assert_eq!("2inx1in".parse::<PictureSize>().unwrap().pixels(Some(600)), Ok(Size { width: 1200, height: 600 }));
        let error = "90mmx60mm".parse::<PictureSize>().unwrap().pixels(Some(9600)).unwrap_err();
        assert!(error.contains("34016x22677") && error.contains("32768"), "{error}");
        let pixels: PictureSize = "10x20".parse().unwrap();
        assert_eq!((pixels.pixels(Some(600)), pixels.dpi(None)), (Ok(Size { width: 10, height: 20 }), None));
        assert!("0.01mmx1mm".parse::<PictureSize>().unwrap().pixels(None).unwrap_err().contains("0x12 pixels"));
    }

    #[test]
    fn regions_are_inside_the_picture() {
        let size = Size { width: 100, height: 50 };
        assert!(check_region(size, region(90, 40, 10, 10)).is_ok());
        assert!(check_region(size, region(91, 40, 10, 10)).is_err());
        assert!(check_region(size, region(u32::MAX, 0, u32::MAX, 1)).is_err());
    }

    #[test]
    fn crops_and_their_margin() {
        check(
            &[
                ("auto", Crop::Percent(2.0)),
                ("AUTO,5%", Crop::Percent(5.0)),
                ("auto,0", Crop::Pixels(0)),
                ("auto, 20px", Crop::Pixels(20)),
            ],
            &["", "auto,", "auto20", "none", "auto,-1", "auto,1.5", "auto,200%", "auto,nan%", "auto,1,2", "20"],
        );
        let full = Size { width: 1000, height: 500 };
        assert_eq!(Crop::Percent(2.0).around(region(100, 100, 200, 50), full), region(96, 96, 208, 58));
        assert_eq!(Crop::Pixels(30).around(region(10, 480, 980, 20), full), region(0, 450, 1000, 50));
        assert_eq!(Crop::Pixels(0).around(region(7, 8, 1, 1), full), region(7, 8, 1, 1));
    }
}
