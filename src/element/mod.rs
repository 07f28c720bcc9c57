//! Chemical elements: symbols, radii, masses, colours.
//!
//! [`Element`] is one byte, so that a structure of a million atoms spends a megabyte on it. Atomic number 0
//! stands for everything that is not an element: dummy atoms, lone pairs, Drude particles, unknown symbols.

mod table;

use crate::color::Srgb8;
use table::{Row, TABLE};

/// An element by its atomic number, or [`Element::DUMMY`].
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Element(u8);

impl Element {
    /// A point that is no atom: dummy, lone pair, Drude particle, unknown symbol. Symbol `X`.
    pub const DUMMY: Element = Element(0);
    /// Hydrogen (deuterium and tritium are hydrogen with an isotope number).
    pub const H: Element = Element(1);
    /// Boron.
    pub const B: Element = Element(5);
    /// Carbon.
    pub const C: Element = Element(6);
    /// Nitrogen.
    pub const N: Element = Element(7);
    /// Oxygen.
    pub const O: Element = Element(8);
    /// Fluorine.
    pub const F: Element = Element(9);
    /// Phosphorus.
    pub const P: Element = Element(15);
    /// Sulfur.
    pub const S: Element = Element(16);
    /// Chlorine.
    pub const CL: Element = Element(17);
    /// The highest atomic number known: oganesson.
    pub const MAX_Z: u8 = 118;

    /// The element of atomic number `z`, 1–118; `None` outside.
    ///
    /// ```
    /// use ballstick::element::Element;
    /// assert_eq!(Element::from_z(26).map(Element::symbol), Some("Fe"));
    /// assert_eq!(Element::from_z(119), None);
    /// ```
    #[must_use]
    pub const fn from_z(z: u8) -> Option<Element> {
        if z >= 1 && z <= Self::MAX_Z { Some(Element(z)) } else { None }
    }

    /// The element of a symbol in any case (`Fe`, `FE`, `fe`); `None` for what is no symbol. `D` and `T` are
    /// hydrogen: use [`Element::from_symbol_isotope`] to keep which.
    #[must_use]
    pub fn from_symbol(symbol: &str) -> Option<Element> {
        Self::from_symbol_isotope(symbol).map(|(element, _)| element)
    }

    /// As [`Element::from_symbol`], with the mass number that the symbol itself says: 2 for `D`, 3 for `T`,
    /// else 0 (not stated).
    #[must_use]
    pub fn from_symbol_isotope(symbol: &str) -> Option<(Element, u16)> {
        Self::from_symbol_bytes(symbol.as_bytes())
    }

    /// As [`Element::from_symbol_isotope`], of the bytes of a text.
    #[must_use]
    #[inline]
    pub fn from_symbol_bytes(symbol: &[u8]) -> Option<(Element, u16)> {
        let (first, second) = match *symbol {
            [a] => (a.to_ascii_uppercase(), 0),
            [a, b] => (a.to_ascii_uppercase(), b.to_ascii_lowercase()),
            _ => return None,
        };
        match (first, second) {
            (b'D', 0) => return Some((Element::H, 2)),
            (b'T', 0) => return Some((Element::H, 3)),
            _ => {}
        }
        if !first.is_ascii_uppercase() || !(second == 0 || second.is_ascii_lowercase()) {
            return None;
        }
        let index = usize::from(first - b'A') * 27 + if second == 0 { 0 } else { usize::from(second - b'a') + 1 };
        match SYMBOL_TO_Z[index] {
            0 => None,
            z => Some((Element(z), 0)),
        }
    }

    /// Atomic number, 0 for a dummy.
    #[must_use]
    pub const fn z(self) -> u8 {
        self.0
    }

    fn row(self) -> Option<&'static Row> {
        TABLE.get(usize::from(self.0).wrapping_sub(1))
    }

    /// Symbol in the usual case: `Fe`. `X` for a dummy.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        self.row().map_or("X", |row| row.symbol)
    }

    /// English name.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.row().map_or("dummy", |row| row.name)
    }

    /// Standard atomic weight in dalton, 0 for a dummy.
    #[must_use]
    pub fn mass(self) -> f32 {
        self.row().map_or(0.0, |row| row.mass)
    }

    /// Covalent single-bond radius in ångström (sources in the table's header), 0 for a dummy.
    #[must_use]
    pub fn covalent_radius(self) -> f32 {
        self.row().map_or(0.0, |row| row.covalent_radius)
    }

    /// Van der Waals radius in ångström (sources in the table's header). A dummy has 0.5: drawn small, but drawn.
    #[must_use]
    pub fn vdw_radius(self) -> f32 {
        self.row().map_or(0.5, |row| row.vdw_radius)
    }

    /// Jmol's colour of the element; hot pink, as in Jmol, for a dummy.
    #[must_use]
    pub fn color(self) -> Srgb8 {
        Srgb8::from_rgb_u32(self.row().map_or(0xFF_14_93, |row| row.color_rgb))
    }

    /// IUPAC group 1–18; 0 for the lanthanides and actinides that belong to none, and for a dummy.
    #[must_use]
    pub fn group(self) -> u8 {
        self.row().map_or(0, |row| row.group)
    }

    /// Period 1–7, 0 for a dummy.
    #[must_use]
    pub fn period(self) -> u8 {
        self.row().map_or(0, |row| row.period)
    }

    /// Whether the element is a metal. The metalloids B, Si, Ge, As, Sb, Te, At are not: they bond as nonmetals do.
    #[must_use]
    pub const fn is_metal(self) -> bool {
        !matches!(self.0, 0..=2 | 5..=10 | 14..=18 | 32..=36 | 51..=54 | 85..=86 | 117..=118)
    }

    /// Whether the element is a noble gas.
    #[must_use]
    pub const fn is_noble_gas(self) -> bool {
        matches!(self.0, 2 | 10 | 18 | 36 | 54 | 86 | 118)
    }

    /// Whether the element is a halogen.
    #[must_use]
    pub const fn is_halogen(self) -> bool {
        matches!(self.0, 9 | 17 | 35 | 53 | 85 | 117)
    }
}

impl std::fmt::Debug for Element {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.symbol())
    }
}

impl std::fmt::Display for Element {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.symbol())
    }
}

/// `27 * first letter + (0 or 1 + second letter)` to atomic number, 0 where there is no such symbol.
static SYMBOL_TO_Z: [u8; 26 * 27] = {
    let mut map = [0u8; 26 * 27];
    let mut i = 0;
    while i < TABLE.len() {
        let symbol = TABLE[i].symbol.as_bytes();
        let second = if symbol.len() == 2 { (symbol[1] - b'a') as usize + 1 } else { 0 };
        map[(symbol[0] - b'A') as usize * 27 + second] = (i + 1) as u8;
        i += 1;
    }
    map
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_complete_and_plausible() {
        for z in 1..=Element::MAX_Z {
            let element = Element(z);
            assert_eq!(Element::from_symbol(element.symbol()), Some(element));
            assert_eq!(Element::from_symbol(&element.symbol().to_uppercase()), Some(element));
            assert!((0.2..3.0).contains(&element.covalent_radius()), "{element} covalent radius");
            assert!((1.0..4.0).contains(&element.vdw_radius()), "{element} van der Waals radius");
            assert!(element.vdw_radius() > element.covalent_radius(), "{element} radii");
            assert!((1..=7).contains(&element.period()), "{element} period");
        }
    }

    #[test]
    fn isotopes_of_hydrogen_are_hydrogen() {
        assert_eq!(Element::from_symbol_isotope("D"), Some((Element::H, 2)));
        assert_eq!(Element::from_symbol_isotope("t"), Some((Element::H, 3)));
    }

    #[test]
    fn what_is_no_symbol_is_none() {
        for text in ["", "Q", "Xx", "Car", "1", "c1", "é", " C"] {
            assert_eq!(Element::from_symbol(text), None, "{text:?}");
        }
    }
}
