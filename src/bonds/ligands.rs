//! Which bonds of metals are sticks and which are dashes, and the double bonds of oxides: one rule for all sources that
//! do not say it themselves (distance, CONECT, the dictionary's single bonds). A LINK of a metal is what mmCIF calls
//! `metalc`, and stays coordination.
//!
//! # The rule
//!
//! A ligand that brings one electron shares a pair with the metal: the bond is covalent. One that brings a pair, or spreads
//! over several atoms or metals, coordinates. (X and L ligands of the covalent bond classification: Green, J. Organomet.
//! Chem. 1995, 500, 127.) Told from the bonds alone, covalent are
//!
//! - hydrogen, and every partner of p-block metals that are no ions (tetramethyltin, aluminium in a zeolite);
//! - a terminal halogen, unless on a metal that gives its electron away altogether: group 1, calcium to radium (HgCl₂,
//!   TiCl₄, cisplatin's chlorines, WCl₆; not the sodium chloride molecule, nor halides that bridge);
//! - carbon bonded by σ to one metal: alkyls, aryls, alkynyls, Grignard's and lithium's. Not carbon monoxide, cyanide,
//!   isocyanides and carbenes between two nitrogens (they have a lone pair for the metal), nor carbon of
//!   which a neighbour is bonded to the same metal (alkenes, rings);
//! - terminal oxygen and sulfur no farther than a double bond goes ([`DOUBLE_RADII_PM`]): oxides of high-valent metals.
//!
//! All else coordinates: water, amines, imines, thiolates, alkoxides, carboxylates, phosphines, porphyrins. Thiolates and
//! carboxylates bring one electron too, but chemists draw their proteins, clusters and frameworks with dashes (and CSD
//! and CCD, which have only sticks, do not tell). Ions, residues of their own, coordinate whatever they touch.
//!
//! Oxides on one metal have double bonds as far as its highest oxidation state allows, the shortest first: four in OsO₄,
//! three in permanganate, two in chromate and molybdate, one in vanadate. The others are O⁻.
//!
//! Limits: nitrides, imides and carbenes have single bonds or dashes.

use super::metal;
use super::sites::{Role, Sites};
use crate::element::Element;
use crate::structure::{Bond, BondKind, BondOrder, BondSource, ByAtom, Cell, Structure};
use glam::Vec3;

/// Radii of metals in double bonds, in picometre: Pyykkö and Atsumi, Chem. Eur. J. 2009, 15, 12770.
const DOUBLE_RADII_PM: [(u8, u8); 29] = [
    (21, 116),
    (22, 117),
    (23, 112),
    (24, 111),
    (25, 105),
    (26, 109),
    (27, 103),
    (28, 101),
    (39, 130),
    (40, 127),
    (41, 125),
    (42, 121),
    (43, 120),
    (44, 114),
    (45, 110),
    (46, 117),
    (72, 128),
    (73, 126),
    (74, 120),
    (75, 119),
    (76, 116),
    (77, 115),
    (78, 112),
    (90, 143),
    (91, 138),
    (92, 134),
    (93, 136),
    (94, 135),
    (95, 135),
];
/// The same of oxygen and sulfur.
const DOUBLE_RADIUS_OF_OXYGEN_PM: u8 = 57;
const DOUBLE_RADIUS_OF_SULFUR_PM: u8 = 94;
/// How much longer a double bond may be, in ångström. Chosen: vanadate has 1.72 Å, 0.03 Å over the radii, molybdate and
/// tungstate 0.00–0.02 Å; hydroxide on iron(IV) and titanium has 1.77 and 1.85 Å, 0.11 Å over.
const LONGER_THAN_DOUBLE: f32 = 0.06;

/// Highest oxidation state that a metal has beside terminal oxygen.
fn highest_state(metal: Element) -> usize {
    match metal.z() {
        26 => 6, // ferrate
        27 | 28 | 46 => 4,
        45 | 77 | 78 => 6,
        90 => 4,
        91 => 5,
        92..=95 => 6,
        _ => usize::from(metal.group()),
    }
}

/// Length up to which a terminal atom on a metal has a double bond; `None` where none is known.
fn longest_double(metal: Element, other: Element) -> Option<f32> {
    let radius = match other {
        Element::O => DOUBLE_RADIUS_OF_OXYGEN_PM,
        Element::S => DOUBLE_RADIUS_OF_SULFUR_PM,
        _ => return None,
    };
    let (_, of_metal) = DOUBLE_RADII_PM.iter().find(|(z, _)| *z == metal.z())?;
    Some((f32::from(*of_metal) + f32::from(radius)) * 0.01 + LONGER_THAN_DOUBLE)
}

/// The bonds of the atoms with untold bonds: other atom and bond. Of all other atoms only the bonds to these are in it.
type Around = ByAtom<(u32, u32)>;

/// Gives every bond between a metal and a nonmetal its kind by the rule of this module, if its source does not say more
/// than that there is one; and, `with_orders`, oxides their double bonds.
pub(super) fn settle(
    structure: &Structure,
    positions: &[Vec3],
    cell: Option<&Cell>,
    bonds: &mut [Bond],
    with_orders: bool,
) {
    let elements = structure.elements();
    let at = |atom: u32| elements.get(atom as usize).copied().unwrap_or_default();
    // An untold bond has no order worth the name; hydrogen and p-block metals are settled. A link tells its kind, or that
    // it is covalent by its order.
    let is_untold = |bond: &Bond| {
        let is_told = match bond.source {
            BondSource::Link => bond.kind == BondKind::Coordination || bond.order > BondOrder::Unknown,
            _ => bond.order > BondOrder::Single,
        };
        matches!(bond.kind, BondKind::Covalent | BondKind::Coordination)
            && !is_told
            && !bond.aromatic
            && metal::is_coordination(at(bond.a), at(bond.b))
    };
    let untold: Vec<u32> = (0..bonds.len() as u32).filter(|&index| is_untold(&bonds[index as usize])).collect();
    if untold.is_empty() || positions.len() != elements.len() {
        return;
    }
    let mut is_asked = vec![false; elements.len()];
    for &index in &untold {
        is_asked[bonds[index as usize].a as usize] = true;
        is_asked[bonds[index as usize].b as usize] = true;
    }
    let asks = |atom: u32| is_asked.get(atom as usize).copied();
    let is_near = |bond: &Bond| matches!((asks(bond.a), asks(bond.b)), (Some(a), Some(b)) if a || b);
    let near = || (0u32..).zip(&*bonds).filter(|(_, bond)| bond.kind != BondKind::Hydrogen && is_near(bond));
    let ends = |(index, bond): (u32, &Bond)| [(bond.a, (bond.b, index)), (bond.b, (bond.a, index))];
    let around = Around::new(elements.len(), || near().flat_map(ends));
    let sites = Sites::new(structure);
    let lattice = cell.map(Cell::vectors);
    let length = |bond: &Bond| {
        let mut vector = positions[bond.b as usize] - positions[bond.a as usize];
        for (vectors, count) in lattice.iter().flat_map(|vectors| vectors.iter().zip(bond.image)) {
            vector += (*vectors * f64::from(count)).as_vec3();
        }
        vector.length()
    };
    // Metal, length and bond of every oxide.
    let mut oxides: Vec<(u32, f32, u32)> = Vec::new();
    for index in untold {
        let bond = bonds[index as usize];
        let (metal, other) = if at(bond.a).is_metal() { (bond.a, bond.b) } else { (bond.b, bond.a) };
        let is_ion = |atom: u32| sites.role(atom as usize) == Role::Ion;
        let is_terminal = around.of(other as usize).len() == 1;
        let length = length(&bond);
        let is_oxide = is_terminal && longest_double(at(metal), at(other)).is_some_and(|longest| length <= longest);
        let is_shared = !is_ion(metal)
            && !is_ion(other)
            && (is_oxide
                || is_terminal && at(other).is_halogen() && !gives_all(at(metal))
                || at(other) == Element::C && is_sigma_carbon(&around, &at, metal, other));
        let bond = &mut bonds[index as usize];
        bond.kind = if is_shared { BondKind::Covalent } else { BondKind::Coordination };
        bond.order = if is_shared { BondOrder::Single } else { bond.order };
        if is_shared && is_oxide {
            oxides.push((metal, length, index));
        }
    }
    if with_orders {
        oxides.sort_unstable_by(|one, other| {
            one.0.cmp(&other.0).then(one.1.total_cmp(&other.1)).then(one.2.cmp(&other.2))
        });
        for on_one in oxides.chunk_by(|one, other| one.0 == other.0) {
            let doubles = double_count(bonds, &around, &at, on_one[0].0, on_one.len());
            for &(_, _, index) in &on_one[..doubles.min(on_one.len())] {
                bonds[index as usize].order = BondOrder::Double;
            }
        }
    }
}

/// Metals of electronegativity 1.0 and less by Pauling's scale, which have ions and no shared pairs beside halogens.
fn gives_all(metal: Element) -> bool {
    metal.group() == 1 || matches!(metal.z(), 20 | 38 | 56 | 88)
}

/// Whether a carbon holds a metal by one electron of its own.
fn is_sigma_carbon(around: &Around, at: &impl Fn(u32) -> Element, metal: u32, carbon: u32) -> bool {
    let mut hetero = 0;
    let mut count = 0;
    for &(other, _) in around.of(carbon as usize) {
        if at(other).is_metal() {
            if other != metal {
                return false; // a bridge
            }
            continue;
        }
        // A neighbour on the same metal: an alkene or a ring. Hydrogens that the metal draws near do not count.
        if at(other) != Element::H && around.of(other as usize).iter().any(|&(beside, _)| beside == metal) {
            return false;
        }
        count += 1;
        hetero += usize::from(matches!(at(other), Element::N | Element::O | Element::S));
    }
    // Carbon monoxide, cyanide; a carbene between two nitrogens.
    count >= 4 || hetero == 0 || hetero < count
}

/// How many of so many oxides on a metal have double bonds. Up to four neighbours all bonds count in the oxidation state;
/// of more, some are but loosely held (the aqua ligands of uranyl, the bridges of polyoxometalates).
fn double_count(bonds: &[Bond], around: &Around, at: &impl Fn(u32) -> Element, metal: u32, oxides: usize) -> usize {
    let all: Vec<(u32, u32)> =
        around.of(metal as usize).iter().copied().filter(|&(other, _)| !at(other).is_metal()).collect();
    let brings_one = |&&(other, index): &&(u32, u32)| {
        let bond = &bonds[index as usize];
        let is_bridge = matches!(at(other), Element::O | Element::S) && around.of(other as usize).len() > 1;
        bond.kind == BondKind::Covalent || is_bridge
    };
    let others = all.iter().filter(brings_one).count().saturating_sub(oxides);
    let others = if all.len() <= 4 { others } else { 0 };
    highest_state(at(metal)).saturating_sub(oxides + others).clamp(1, oxides.max(1))
}

#[cfg(test)]
mod tests {
    use super::super::{BondOptions, find};
    use super::*;
    use crate::structure::{AtomRecord, Diagnostics, StatedBonds, StructureBuilder};
    use glam::DVec3;

    type Site = (&'static str, [f64; 3]);

    fn kinds_with(sites: &[Site], stated: &[(u32, u32)]) -> Vec<(BondKind, u8)> {
        let mut builder = StructureBuilder::new();
        for &(symbol, position) in sites {
            let element = Element::from_symbol(symbol).unwrap();
            builder.push_atom(&AtomRecord { element, position: DVec3::from(position), ..AtomRecord::default() });
        }
        for &(a, b) in stated {
            builder.push_bond(Bond::new(a, b, BondOrder::Single, BondSource::File));
        }
        if !stated.is_empty() {
            builder.set_stated_bonds(StatedBonds::Partial);
        }
        let structure = builder.build(&mut Diagnostics::default());
        let of_metal =
            |bond: &&Bond| [bond.a, bond.b].iter().any(|&atom| structure.elements()[atom as usize].is_metal());
        let bonds = find(&structure, 0, &BondOptions::default());
        bonds.iter().filter(of_metal).map(|bond| (bond.kind, bond.order.number())).collect()
    }

    fn kinds(sites: &[Site]) -> Vec<(BondKind, u8)> {
        kinds_with(sites, &[])
    }

    /// Corners of a tetrahedron at a distance from a metal in the origin.
    fn tetrahedron(metal: &'static str, end: &'static str, length: f64) -> Vec<Site> {
        let corners = [[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]];
        let mut sites = vec![(metal, [0.0; 3])];
        sites.extend(corners.map(|corner| (end, corner.map(|along| along * length / 3f64.sqrt()))));
        sites
    }

    const SHARED: (BondKind, u8) = (BondKind::Covalent, 1);
    const GIVEN: (BondKind, u8) = (BondKind::Coordination, 0);

    #[test]
    fn terminal_halogens_and_alkyls_share_a_pair_on_every_metal_but_the_most_electropositive() {
        for (metal, end, length) in
            [("Ti", "Cl", 2.17), ("Zn", "Cl", 2.27), ("Cu", "Cl", 2.25), ("Sn", "Cl", 2.28), ("Ti", "C", 2.05)]
        {
            assert_eq!(kinds(&tetrahedron(metal, end, length)), [SHARED; 4], "{metal}{end}");
        }
        assert_eq!(kinds(&[("Cl", [-2.28, 0.0, 0.0]), ("Hg", [0.0; 3]), ("Cl", [2.28, 0.0, 0.0])]), [SHARED; 2]);
        assert_eq!(kinds(&[("Na", [0.0; 3]), ("Cl", [2.36, 0.0, 0.0])]), [GIVEN]);
        // Methyllithium, and a Grignard compound with two ethers: carbon and bromine share.
        assert_eq!(kinds(&[("Li", [0.0; 3]), ("C", [1.96, 0.0, 0.0])]), [SHARED]);
        let grignard = [
            ("Mg", [0.0; 3]),
            ("C", [2.1, 0.0, 0.0]),
            ("Br", [-1.1, 2.2, 0.0]),
            ("O", [-1.0, -1.0, 1.45]),
            ("O", [-1.0, -1.0, -1.45]),
        ];
        assert_eq!(kinds(&grignard), [SHARED, SHARED, GIVEN, GIVEN]);
    }

    #[test]
    fn lone_pairs_and_bridges_coordinate() {
        // Cisplatin; aqua ligands; a chlorine between two coppers; cyanide; ethene by both carbons.
        let cisplatin = [
            ("Pt", [0.0; 3]),
            ("Cl", [2.33, 0.0, 0.0]),
            ("Cl", [0.0, 2.33, 0.0]),
            ("N", [-2.02, 0.0, 0.0]),
            ("N", [0.0, -2.02, 0.0]),
        ];
        assert_eq!(kinds(&cisplatin), [SHARED, SHARED, GIVEN, GIVEN]);
        assert_eq!(kinds(&tetrahedron("Fe", "O", 2.1)), [GIVEN; 4]);
        let bridge = [("Cu", [1.7, 0.0, 0.0]), ("Cu", [-1.7, 0.0, 0.0]), ("Cl", [0.0, 1.5, 0.0])];
        assert_eq!(kinds(&bridge), [GIVEN; 2]);
        assert_eq!(kinds(&[("Ag", [0.0; 3]), ("C", [2.05, 0.0, 0.0]), ("N", [3.2, 0.0, 0.0])]), [GIVEN]);
        assert_eq!(kinds(&[("Pt", [0.0; 3]), ("C", [2.02, 0.7, 0.0]), ("C", [2.02, -0.7, 0.0])]), [GIVEN; 2]);
        // Thiolate on zinc.
        assert_eq!(kinds(&[("Zn", [0.0; 3]), ("S", [2.3, 0.0, 0.0]), ("C", [2.9, 1.7, 0.0])]), [GIVEN]);
    }

    #[test]
    fn conect_says_no_more_of_the_kind_than_the_distance() {
        let listed = kinds_with(&tetrahedron("Ti", "Cl", 2.17), &[(0, 1), (0, 2), (0, 3), (0, 4)]);
        assert_eq!(listed, [SHARED; 4]);
    }

    #[test]
    fn oxides_have_double_bonds_as_far_as_the_oxidation_state_goes() {
        let double = (BondKind::Covalent, 2);
        assert_eq!(kinds(&tetrahedron("Mn", "O", 1.63)), [double, double, double, SHARED]);
        assert_eq!(kinds(&tetrahedron("Os", "O", 1.71)), [double; 4]);
        let mut uranyl = vec![("U", [0.0; 3]), ("O", [0.0, 0.0, 1.77]), ("O", [0.0, 0.0, -1.77])];
        uranyl.extend(
            (0..5)
                .map(|i| f64::from(i) * 72f64.to_radians())
                .map(|turn| ("O", [2.41 * turn.cos(), 2.41 * turn.sin(), 0.0])),
        );
        assert_eq!(kinds(&uranyl), [double, double, GIVEN, GIVEN, GIVEN, GIVEN, GIVEN]);
        // Vanadium oxytrichloride; a porphyrin's iron(IV) oxide, and hydroxide instead.
        let mut chloride = tetrahedron("V", "Cl", 2.14);
        chloride[1] = ("O", [0.906, 0.906, 0.906]);
        assert_eq!(kinds(&chloride), [double, SHARED, SHARED, SHARED]);
        assert_eq!(kinds(&[("Fe", [0.0; 3]), ("O", [1.65, 0.0, 0.0])]), [double]);
        assert_eq!(kinds(&[("Fe", [0.0; 3]), ("O", [1.9, 0.0, 0.0])]), [GIVEN]);
    }
}
