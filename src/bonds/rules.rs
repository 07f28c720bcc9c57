//! Which two elements may bond at which distance, and how many partners an element takes.
//!
//! Lengths are compared as the *excess* over the sum of Cordero's covalent radii, so that bonds of different
//! elements can be ranked against each other.

use super::BondOptions;
use crate::element::Element;

/// Nearer than this are two images of one atom, never a bond: Open Babel and Jmol use the same 0.4 Å. The shortest bond
/// there is, H–H, has 0.74 Å, but side chains built without density (PDB entry 4HHB) have C–C from 0.58 Å.
const SHORTEST_BOND: f32 = 0.4;
/// Longest H–H bond: free H₂ has 0.741 Å (Huber and Herzberg 1979), H₂ as a ligand up to 0.9 Å (Kubas, Chem. Rev.
/// 2007, 107, 4152); hydrogens of one methyl group are 1.78 Å apart.
const LONGEST_H2: f32 = 0.9;
/// Metal–metal: for groups 3–11 and the f block. Gold has 2.88 Å in the metal, an excess of 0.16 Å, and up to 3.13 Å on
/// the surface of thiolate clusters (0.41 Å); its next shell starts at 4.08 Å.
const TRANSITION_METAL_TOLERANCE: f32 = 0.45;
/// Metal–metal: groups 1, 2 and 12–16. Lead has 3.50 Å (a = 4.951 Å), an excess of 0.58 Å, the largest of the
/// close-packed metals (aluminium 0.44 Å, potassium 0.48 Å).
const MAIN_GROUP_METAL_TOLERANCE: f32 = 0.6;

/// Longest bonds that the radii and the tolerance would put too far: two of these atoms are often that near without a
/// bond. O–O has 1.48 Å in peroxides and at most 1.52 Å in crystals, while oxygens of one molecule that is modelled
/// roughly come to 1.64 Å (three errors of 0.04 Å on top of 1.48 Å end below). P–P has 2.21 Å in diphosphines and
/// up to 2.37 Å between crowded ones; the phosphorus atoms of a bent diphosphate come to 2.46 Å.
const NARROW_PAIRS: [(Element, f32); 2] = [(Element::O, 1.62), (Element::P, 2.42)];

/// The sum of the covalent radii in ångström.
pub(super) fn radii(a: Element, b: Element) -> f32 {
    a.covalent_radius() + b.covalent_radius()
}

/// A metal of groups 1, 2 and 12–16.
fn is_main_group_metal(element: Element) -> bool {
    element.is_metal() && matches!(element.group(), 1 | 2 | 12..=16)
}

/// The longest distance at which two atoms of these elements may bond; `None` if they never do.
fn longest(a: Element, b: Element, options: &BondOptions) -> Option<f32> {
    if a == Element::DUMMY || b == Element::DUMMY {
        return None;
    }
    if a == Element::H && b == Element::H {
        return Some(LONGEST_H2);
    }
    for (gas, other) in [(a, b), (b, a)] {
        // Krypton is known with fluorine only (KrF₂); xenon with F, O, N, C and Cl. The other noble gases, the
        // radon of RnF₂ apart, have no bonds in a flask.
        let bonds = match gas.z() {
            36 | 86 => other == Element::F,
            54 => matches!(other, Element::F | Element::O | Element::N | Element::C | Element::CL),
            _ => !gas.is_noble_gas(),
        };
        if !bonds {
            return None;
        }
    }
    let tolerance = match (a.is_metal(), b.is_metal()) {
        (true, true) if is_main_group_metal(a) && is_main_group_metal(b) => MAIN_GROUP_METAL_TOLERANCE,
        (true, true) => TRANSITION_METAL_TOLERANCE,
        // Hydrides lie near the sum; the wider donor range would reach the hydrogens of ligands.
        (true, false) | (false, true) if a != Element::H && b != Element::H => options.metal_tolerance,
        _ => options.tolerance,
    };
    let narrow = NARROW_PAIRS.iter().find(|&&(element, _)| a == element && b == element);
    let longest = narrow.map_or(f32::INFINITY, |&(_, longest)| longest).min(radii(a, b) + tolerance);
    (longest > SHORTEST_BOND).then_some(longest)
}

/// Whether two atoms are too near to be bonded.
pub(super) fn is_too_near(distance: f32) -> bool {
    distance < SHORTEST_BOND
}

/// How many covalent partners a nonmetal takes, metals not counted; `None` for no limit. The numbers are those of real
/// molecules: NR₄⁺, H₃O⁺, Sb₂F₁₁⁻ (bridging F), SiF₆²⁻, PF₆⁻, SF₆, ClF₆⁺, BrF₆⁻, IF₇, TeF₈²⁻, XeF₈²⁻. Boron and its
/// neighbours in clusters are settled by the caller.
pub(super) fn valence_cap(element: Element) -> Option<u8> {
    Some(match element.z() {
        1 => 1,
        5..=7 => 4,
        8 => 3,
        9 => 2,
        14..=17 | 32..=35 => 6,
        36 | 86 => 2,
        51 => 7,
        52..=54 | 85 => 8,
        _ => return None,
    })
}

/// The number of covalent partners from which an atom has no lone pair left to give to a metal: C and N with 4
/// (methyl, ammonium), O with 3 (oxonium), the heavier ones with 4 (phosphate, sulfate, perchlorate, silyl).
pub(super) fn is_saturated(element: Element, covalent_partners: usize) -> bool {
    match element.z() {
        6 | 7 | 14..=17 | 32..=35 => covalent_partners >= 4,
        8 => covalent_partners >= 3,
        _ => false,
    }
}

/// The rules for the elements of one structure, by small species numbers: a table that stays in the cache.
pub(super) struct PairTable {
    species_of_z: [u8; 256],
    count: usize,
    /// Square of the longest bond of two species, −1 where there is none; `count × count`.
    longest_squared: Vec<f32>,
    /// The longest bond of each species with any, 0 for none.
    reach: Vec<f32>,
    metal: Vec<bool>,
}

impl PairTable {
    /// The table for the elements that occur.
    pub(super) fn new(elements: &[Element], options: &BondOptions) -> PairTable {
        let mut seen = [false; 256];
        for element in elements {
            seen[usize::from(element.z())] = true;
        }
        let mut species_of_z = [0u8; 256];
        let mut present = Vec::new();
        for z in 0..=Element::MAX_Z {
            if seen[usize::from(z)] {
                species_of_z[usize::from(z)] = present.len() as u8; // at most 119
                present.push(Element::from_z(z).unwrap_or(Element::DUMMY));
            }
        }
        let limit = |a, b| longest(a, b, options).map_or(-1.0, |d| d * d);
        let longest_squared: Vec<f32> =
            present.iter().flat_map(|&a| present.iter().map(move |&b| limit(a, b))).collect();
        let metal = present.iter().map(|element| element.is_metal()).collect();
        let reach = (longest_squared.chunks(present.len().max(1)))
            .map(|row| row.iter().fold(0.0f32, |longest, &squared| longest.max(squared)).sqrt())
            .collect();
        PairTable { species_of_z, count: present.len(), longest_squared, reach, metal }
    }

    /// The species number of an element of the structure.
    pub(super) fn species(&self, element: Element) -> u8 {
        self.species_of_z[usize::from(element.z())]
    }

    /// The squared longest bonds of a species with every species, −1 for none.
    pub(super) fn row(&self, species: u8) -> &[f32] {
        let start = usize::from(species) * self.count;
        &self.longest_squared[start..start + self.count]
    }

    /// The longest bond of a species with any, 0 for none.
    pub(super) fn reach(&self, species: u8) -> f32 {
        self.reach[usize::from(species)]
    }

    /// Whether a species is a metal.
    pub(super) fn is_metal(&self, species: u8) -> bool {
        self.metal[usize::from(species)]
    }

    /// The longest bond of all, with or without those of metals; 0 if there is none.
    pub(super) fn longest(&self, with_metals: bool) -> f32 {
        let mut longest = 0.0f32;
        for (i, &squared) in self.longest_squared.iter().enumerate() {
            if with_metals || !(self.metal[i / self.count] || self.metal[i % self.count]) {
                longest = longest.max(squared);
            }
        }
        longest.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limit(a: &str, b: &str) -> Option<f32> {
        let element = |symbol| Element::from_symbol(symbol).unwrap();
        longest(element(a), element(b), &BondOptions::default())
    }

    #[test]
    fn known_lengths_are_in_range_and_known_contacts_are_not() {
        // Gas-phase and crystal lengths in ångström.
        for (a, b, length) in [
            ("C", "C", 1.54),
            ("F", "F", 1.41),
            ("N", "N", 1.86), // N₂O₃, the weakest bond that a chemist draws
            ("O", "F", 1.58),
            ("S", "S", 2.05),
            ("Xe", "F", 1.98),
            ("Pb", "S", 2.97),
            ("Pb", "Pb", 3.50),
            ("Na", "Cl", 2.82),
            ("Ca", "O", 2.6),
        ] {
            assert!(limit(a, b).unwrap() >= length, "{a}-{b}");
        }
        for (a, b, contact) in [
            ("O", "O", 2.4),
            ("F", "F", 2.16),
            ("C", "C", 2.15),
            ("H", "H", 1.5),
            ("I", "N", 2.7),
            ("O", "O", 1.64),
            ("P", "P", 2.46),
        ] {
            assert!(limit(a, b).unwrap() < contact, "{a}-{b}");
        }
        for (a, b) in [("He", "H"), ("Ar", "F"), ("Xe", "Xe"), ("Kr", "O"), ("Ne", "Na")] {
            assert_eq!(limit(a, b), None, "{a}-{b}");
        }
    }

    #[test]
    fn the_table_gives_what_the_rules_say() {
        let elements: Vec<Element> = ["O", "H", "Fe"].map(|symbol| Element::from_symbol(symbol).unwrap()).to_vec();
        let table = PairTable::new(&elements, &BondOptions::default());
        let (h, o, fe) = (table.species(elements[1]), table.species(elements[0]), table.species(elements[2]));
        assert_eq!(table.row(h)[usize::from(h)], LONGEST_H2 * LONGEST_H2);
        assert!((table.longest(false) - 1.62).abs() < 1e-5); // O–O
        assert!((table.longest(true) - 3.49).abs() < 1e-5); // Fe–Fe
        assert_eq!(table.reach(fe), table.longest(true));
        assert_eq!([h, o, fe].map(|species| table.is_metal(species)), [false, false, true]);
    }
}
