//! Colour schemes: one colour an atom.

use crate::color::Srgb8;
use crate::structure::Structure;

/// What an atom's colour says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColorBy {
    /// Its element, in Jmol's colours.
    #[default]
    Element,
    /// Its chain.
    Chain,
    /// The name of its residue.
    Residue,
}

impl ColorBy {
    /// All of them.
    pub const ALL: [ColorBy; 3] = [ColorBy::Element, ColorBy::Chain, ColorBy::Residue];

    /// The name in flags and settings.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            ColorBy::Element => "element",
            ColorBy::Chain => "chain",
            ColorBy::Residue => "residue",
        }
    }

    /// The scheme of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<ColorBy> {
        ColorBy::ALL.into_iter().find(|scheme| scheme.name() == name)
    }

    /// Colours of all atoms. Atoms without residues are coloured by element in every scheme.
    #[must_use]
    pub fn colors(self, structure: &Structure) -> Vec<Srgb8> {
        let by_element = structure.elements().iter().map(|element| element.color());
        if self == ColorBy::Element || structure.residues().is_empty() {
            return by_element.collect();
        }
        let of_residue: Vec<Srgb8> = structure
            .residues()
            .iter()
            .map(|residue| match self {
                ColorBy::Chain => PALETTE[residue.chain as usize % PALETTE.len()],
                _ => residue_color(structure.name(residue.name)),
            })
            .collect();
        by_element
            .enumerate()
            .map(|(atom, color)| structure.residue_index(atom).map_or(color, |residue| of_residue[residue]))
            .collect()
    }
}

/// Twelve colours that stay apart for most readers: Okabe and Ito's eight without black ("Color Universal Design",
/// 2008), then five of Paul Tol's muted scheme ("Colour Schemes", SRON/EPS/TN/09-002, 2021).
const PALETTE: [Srgb8; 12] = [
    Srgb8::from_rgb_u32(0x00_72_B2),
    Srgb8::from_rgb_u32(0xE6_9F_00),
    Srgb8::from_rgb_u32(0x00_9E_73),
    Srgb8::from_rgb_u32(0xCC_79_A7),
    Srgb8::from_rgb_u32(0x56_B4_E9),
    Srgb8::from_rgb_u32(0xD5_5E_00),
    Srgb8::from_rgb_u32(0xF0_E4_42),
    Srgb8::from_rgb_u32(0x33_22_88),
    Srgb8::from_rgb_u32(0x88_22_55),
    Srgb8::from_rgb_u32(0x99_99_33),
    Srgb8::from_rgb_u32(0x44_AA_99),
    Srgb8::from_rgb_u32(0xCC_66_77),
];

/// Amino acids in RasMol's "amino" colours (RasMol manual, section Amino Colours), bases by a colour of the palette
/// each, water pale blue, everything else by a number made of its name, so that it is the same in every file.
fn residue_color(name: &str) -> Srgb8 {
    let rgb = match name {
        "ASP" | "GLU" => 0xE6_0A_0A,
        "CYS" | "CYX" | "CYM" | "MET" | "MSE" => 0xE6_E6_00,
        "LYS" | "ARG" => 0x14_5A_FF,
        "SER" | "THR" => 0xFA_96_00,
        "PHE" | "TYR" => 0x32_32_AA,
        "ASN" | "GLN" => 0x00_DC_DC,
        "GLY" => 0xEB_EB_EB,
        "LEU" | "VAL" | "ILE" => 0x0F_82_0F,
        "ALA" => 0xC8_C8_C8,
        "TRP" => 0xB4_5A_B4,
        "HIS" | "HID" | "HIE" | "HIP" | "HSD" | "HSE" | "HSP" => 0x82_82_D2,
        "PRO" => 0xDC_96_82,
        "HOH" | "WAT" | "DOD" | "H2O" | "SOL" | "TIP" | "TIP3" | "TP3" => 0xA0_C8_E6,
        "A" | "DA" => return PALETTE[4],
        "C" | "DC" => return PALETTE[1],
        "G" | "DG" => return PALETTE[2],
        "T" | "DT" => return PALETTE[3],
        "U" | "DU" => return PALETTE[5],
        other => {
            let number = other.bytes().fold(7usize, |sum, byte| sum.wrapping_mul(31).wrapping_add(usize::from(byte)));
            return PALETTE[number % PALETTE.len()];
        }
    };
    Srgb8::from_rgb_u32(rgb)
}
