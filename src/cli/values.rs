//! Values of flags: regions, directions, lattice axes, records. Each parser says what it expected and what it found.

use std::num::NonZeroU32;
use std::str::FromStr;

pub use crate::scene::Region;

/// A direction in the file's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Direction(pub [f64; 3]);

impl Direction {
    /// Directions by name: the side of the molecule that is seen.
    pub const NAMED: [(&'static str, [f64; 3]); 6] = [
        ("front", [0.0, 0.0, -1.0]),
        ("back", [0.0, 0.0, 1.0]),
        ("left", [1.0, 0.0, 0.0]),
        ("right", [-1.0, 0.0, 0.0]),
        ("top", [0.0, -1.0, 0.0]),
        ("bottom", [0.0, 1.0, 0.0]),
    ];
}

impl std::fmt::Display for Direction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "{x},{y},{z}")
    }
}

impl FromStr for Direction {
    type Err = String;

    fn from_str(text: &str) -> Result<Direction, String> {
        let lower = text.trim().to_ascii_lowercase();
        if let Some((_, direction)) = Direction::NAMED.iter().find(|(name, _)| *name == lower) {
            return Ok(Direction(*direction));
        }
        let numbers: Option<Vec<f64>> = lower.split(',').map(|number| number.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[x, y, z]) => {
                let length = x.hypot(y).hypot(z);
                let usable = length.is_finite() && length > 1e-30;
                usable.then_some(Direction([x, y, z])).ok_or_else(|| format!("{text} points nowhere"))
            }
            _ => Err("expected front, back, left, right, top, bottom, or x,y,z such as 0,0,-1".to_owned()),
        }
    }
}

/// A lattice direction \[uvw\].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Axis(pub [i32; 3]);

impl std::fmt::Display for Axis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [u, v, w] = self.0;
        write!(f, "{u},{v},{w}")
    }
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Axis, String> {
        let inner = text.trim().trim_start_matches('[').trim_end_matches(']');
        let indices: Option<Vec<i32>> = if inner.contains([',', ' ']) {
            inner.split([',', ' ']).filter(|part| !part.is_empty()).map(|part| part.parse().ok()).collect()
        } else {
            single_digits(inner)
        };
        match indices.as_deref() {
            Some(&[0, 0, 0]) => Err("[000] points nowhere".to_owned()),
            Some(&[u, v, w]) if [u, v, w].iter().all(|index| index.unsigned_abs() <= 1000) => Ok(Axis([u, v, w])),
            _ => Err("expected three indices [uvw] up to 1000, such as 111, 1-10 or 1,-1,0".to_owned()),
        }
    }
}

/// How many cells along **a**, **b** and **c**.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Supercell(pub [u32; 3]);

impl Supercell {
    /// Whether it is more than one cell.
    #[must_use]
    pub fn is_several(self) -> bool {
        self.0 != [1; 3]
    }
}

impl std::fmt::Display for Supercell {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [a, b, c] = self.0;
        write!(f, "{a}x{b}x{c}")
    }
}

impl FromStr for Supercell {
    type Err = String;

    fn from_str(text: &str) -> Result<Supercell, String> {
        let counts: Option<Vec<u32>> = text
            .split(['x', 'X', '×', ','])
            .map(|part| part.trim().parse().ok().filter(|n| (1..=10_000).contains(n)))
            .collect();
        match counts.as_deref() {
            Some(&[a, b, c]) => Ok(Supercell([a, b, c])),
            _ => Err("expected three numbers of cells from 1 to 10000, such as 2x2x1".to_owned()),
        }
    }
}

/// `1-10` as 1, −1, 0.
fn single_digits(text: &str) -> Option<Vec<i32>> {
    let mut indices = Vec::new();
    let mut sign = 1;
    for character in text.chars() {
        match character {
            '-' | '−' if sign == 1 => sign = -1,
            digit => {
                indices.push(sign * i32::try_from(digit.to_digit(10)?).ok()?);
                sign = 1;
            }
        }
    }
    (sign == 1).then_some(indices)
}

/// `--measure`: atoms as number of the file and number of the atom, both from 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MeasureArg(pub Vec<[u32; 2]>);

impl FromStr for MeasureArg {
    type Err = String;

    fn from_str(text: &str) -> Result<MeasureArg, String> {
        let number = |text: &str| text.trim().parse().ok().filter(|&n: &u32| n > 0);
        let atom = |part: &str| match part.split_once(':') {
            Some((file, atom)) => Some([number(file)?, number(atom)?]),
            None => Some([1, number(part)?]),
        };
        let atoms: Option<Vec<[u32; 2]>> = text.split(',').map(atom).collect();
        atoms
            .filter(|atoms| (2..=4).contains(&atoms.len()))
            .map(MeasureArg)
            .ok_or_else(|| "expected two, three or four numbers of atoms, from 1, such as 1,5 or 2:7,2:9".to_owned())
    }
}

impl std::fmt::Display for MeasureArg {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let atoms: Vec<String> = self.0.iter().map(|[file, atom]| format!("{file}:{atom}")).collect();
        f.write_str(&atoms.join(","))
    }
}

/// A number of what is counted from 1.
pub(super) fn counted_from_1(text: &str) -> Result<NonZeroU32, String> {
    text.parse().map_err(|_| "expected a number; frames are counted from 1".to_owned())
}

/// The size of text.
pub(super) fn text_size(text: &str) -> Result<f64, String> {
    let size = text.parse().ok().filter(|size| (0.2..=5.0).contains(size));
    size.ok_or_else(|| "expected a number from 0.2 to 5; 1 is the usual size".to_owned())
}

/// A finite number above 0.
pub(super) fn positive(text: &str) -> Result<f32, String> {
    let number = text.trim().parse().ok().filter(|&x: &f32| x.is_finite() && x > 0.0);
    number.ok_or_else(|| "expected a number above 0, such as 0.5".to_owned())
}

/// Frames a second of a film.
pub(super) fn frame_rate(text: &str) -> Result<f64, String> {
    let most = crate::export::animation::MOST_FPS;
    let wrong = || format!("expected a number of frames a second, from 0.1 to {most}");
    text.parse().ok().filter(|fps| (0.1..=most).contains(fps)).ok_or_else(wrong)
}

/// Width of outlines in thousandths of the picture's height.
pub(super) fn outline_width(text: &str) -> Result<f32, String> {
    let width = text.trim().parse().ok().filter(|x: &f32| (0.0..=50.0).contains(x));
    width.ok_or_else(|| "expected thousandths of the picture's height from 0 (no lines) to 50, such as 2".to_owned())
}

/// Blur of what is out of focus, in thousandths of the picture's height.
pub(super) fn blur(text: &str) -> Result<f32, String> {
    let width = text.trim().parse().ok().filter(|x: &f32| *x > 0.0 && *x <= 200.0);
    width.ok_or_else(|| "expected thousandths of the picture's height above 0 and up to 200, such as 15".to_owned())
}

/// A part of a whole.
pub(super) fn part(text: &str) -> Result<f32, String> {
    let part = text.trim().parse().ok().filter(|x: &f32| (0.0..=1.0).contains(x));
    part.ok_or_else(|| "expected a number from 0 to 1, such as 0.5".to_owned())
}

/// Strength of the fog.
pub(super) fn fog(text: &str) -> Result<f32, String> {
    let amount = text.trim().parse().ok().filter(|x: &f32| (0.0..=1.0).contains(x));
    amount.ok_or_else(|| "expected a number from 0 (no fog) to 1 (the farthest point vanishes), such as 0.5".to_owned())
}

/// A number from 0 to 1.
pub(super) fn opacity(text: &str) -> Result<f32, String> {
    let number = text.trim().parse().ok().filter(|x: &f32| (0.0..=1.0).contains(x));
    number.ok_or_else(|| "expected a number from 0 (invisible) to 1 (opaque), such as 0.5".to_owned())
}

/// A colour.
pub(super) fn color(text: &str) -> Result<crate::color::Srgb8, String> {
    let wrong = || {
        let instead = crate::color::Srgb8::instead_of(text);
        format!("expected #rrggbb, #rgb, or a name such as steelblue or marine{instead}")
    };
    crate::color::Srgb8::parse(text).ok_or_else(wrong)
}

/// Which record of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordChoice {
    /// This one, counted from 1.
    Number(NonZeroU32),
    /// All, side by side.
    All,
}

impl FromStr for RecordChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<RecordChoice, String> {
        if text.eq_ignore_ascii_case("all") {
            return Ok(RecordChoice::All);
        }
        text.parse().map(RecordChoice::Number).map_err(|_| "expected a number from 1 on, or all".to_owned())
    }
}

impl std::fmt::Display for RecordChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            RecordChoice::Number(number) => number.fmt(f),
            RecordChoice::All => f.write_str("all"),
        }
    }
}

/// Which alternate locations are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Altloc {
    /// In each residue the one with the highest occupancy.
    Highest,
    /// All.
    All,
    /// This one where there is one, else the highest.
    Code(u8),
}

impl FromStr for Altloc {
    type Err = String;

    fn from_str(text: &str) -> Result<Altloc, String> {
        match (text.to_ascii_lowercase().as_str(), text.as_bytes()) {
            ("highest", _) => Ok(Altloc::Highest),
            ("all", _) => Ok(Altloc::All),
            (_, &[code]) if code.is_ascii_graphic() => Ok(Altloc::Code(code)),
            _ => Err("expected highest, all, or one character such as B".to_owned()),
        }
    }
}

impl std::fmt::Display for Altloc {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Altloc::Highest => f.write_str("highest"),
            Altloc::All => f.write_str("all"),
            Altloc::Code(code) => char::from(*code).fmt(f),
        }
    }
}

/// What is behind the molecule: a colour, or nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Backdrop(pub Option<crate::color::Srgb8>);

impl FromStr for Backdrop {
    type Err = String;

    fn from_str(text: &str) -> Result<Backdrop, String> {
        if text.eq_ignore_ascii_case("transparent") {
            return Ok(Backdrop(None));
        }
        match crate::color::Srgb8::parse(text) {
            Some(color) if color.a == 255 => Ok(Backdrop(Some(color))),
            Some(_) => Err("a background is opaque or transparent, nothing between".to_owned()),
            None => {
                let instead = crate::color::Srgb8::instead_of(text);
                Err(format!("expected transparent, #rrggbb, #rgb, or a name such as white or steelblue{instead}"))
            }
        }
    }
}

impl std::fmt::Display for Backdrop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            Some(color) => color.fmt(f),
            None => f.write_str("transparent"),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::color::Srgb8;

    /// What is accepted reads back from how it is printed; the rest is refused.
    pub(in crate::cli) fn check<T: FromStr + PartialEq + std::fmt::Debug + std::fmt::Display>(
        good: &[(&str, T)],
        bad: &[&str],
    ) {
        for (text, value) in good {
            assert_eq!(text.parse().ok().as_ref(), Some(value), "{text}");
            assert_eq!(value.to_string().parse().ok().as_ref(), Some(value), "{value}");
        }
        for text in bad {
            assert!(text.parse::<T>().is_err(), "{text:?}");
        }
    }

    #[test]
    fn regions() {
        let region = |x, y, width, height| Region { x, y, width, height };
        check(
            &[("0,0,640,360", region(0, 0, 640, 360)), ("5, 6,7,8", region(5, 6, 7, 8))],
            &["", "1,2,3", "1,2,0,4", "1,2,3,-4", "1,2,3,4,5", "a,b,c,d"],
        );
    }

    #[test]
    fn directions() {
        check(
            &[
                ("front", Direction([0.0, 0.0, -1.0])),
                ("TOP", Direction([0.0, -1.0, 0.0])),
                ("1,-2,0.5", Direction([1.0, -2.0, 0.5])),
            ],
            &["", "0,0,0", "1,2", "1,2,3,4", "nan,0,1", "inf,0,0", "up", "1e400,0,0"],
        );
    }

    #[test]
    fn lattice_axes() {
        check(
            &[
                ("111", Axis([1, 1, 1])),
                ("1-10", Axis([1, -1, 0])),
                ("-110", Axis([-1, 1, 0])),
                ("1,-1,0", Axis([1, -1, 0])),
                ("[1 1 -12]", Axis([1, 1, -12])),
            ],
            &["", "0,0,0", "000", "11", "1111", "1--10", "11-", "a11", "1,2,9999", "1,1,99999999999"],
        );
    }

    #[test]
    fn measurements() {
        check(
            &[
                ("1,5", MeasureArg(vec![[1, 1], [1, 5]])),
                ("2:7, 3,1:4,9", MeasureArg(vec![[2, 7], [1, 3], [1, 4], [1, 9]])),
            ],
            &["", "1", "0,1", "1,2,3,4,5", "1:,2", "a,b", "-1,2"],
        );
    }

    #[test]
    fn numbers_with_bounds_and_colours() {
        assert_eq!((positive("0.5"), opacity("0"), opacity("1")), (Ok(0.5), Ok(0.0), Ok(1.0)));
        for text in ["0", "-1", "nan", "inf", "", "x"] {
            assert!(positive(text).is_err(), "{text}");
        }
        for text in ["-0.1", "1.01", "nan", "", "50%"] {
            assert!(opacity(text).is_err(), "{text}");
        }
        assert_eq!(color("#f00"), Ok(Srgb8::rgb(255, 0, 0)));
        assert!(color("reddish").is_err());
    }

    #[test]
    fn records_altlocs_backgrounds() {
        assert_eq!(counted_from_1("7").map(NonZeroU32::get), Ok(7));
        for text in ["0", "-1", "", "one"] {
            assert!(counted_from_1(text).unwrap_err().contains("counted from 1"), "{text}");
        }
        let one = NonZeroU32::MIN;
        check(&[("1", RecordChoice::Number(one)), ("ALL", RecordChoice::All)], &["", "0", "-1", "some"]);
        check(&[("highest", Altloc::Highest), ("all", Altloc::All), ("B", Altloc::Code(b'B'))], &["", "AB", " ", "é"]);
        check(
            &[("transparent", Backdrop(None)), ("#102030", Backdrop(Some(Srgb8::rgb(16, 32, 48))))],
            &["", "whit", "#10203040"],
        );
    }
}
