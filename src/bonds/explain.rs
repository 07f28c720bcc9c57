//! Why there is a bond, and why there is none, in words.

use super::grid::Grid;
use super::residues::Known;
use super::rules::{self, PairTable};
use super::sites::{Role, Sites};
use super::{BondMode, BondOptions, find_all, hbonds, links};
use crate::element::Element;
use crate::structure::{Bond, BondKind, BondOrder, BondSource, Cell, StatedBonds, Structure, atom_flags};
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// A bond and why it is one.
#[derive(Debug, Clone, PartialEq)]
pub struct Explained {
    /// The bond.
    pub bond: Bond,
    /// Its length in ångström.
    pub length: f32,
    /// Who says so, and why: `dictionary: HEM`, `distance: 1.54 Å ≤ 0.76+0.76+0.45`.
    pub reason: String,
}

/// Two atoms that are near enough for a bond and have none.
#[derive(Debug, Clone, PartialEq)]
pub struct NotBonded {
    /// One atom, the lower index.
    pub a: u32,
    /// The other.
    pub b: u32,
    /// How far apart they are in ångström.
    pub length: f32,
    /// Why there is no bond.
    pub reason: &'static str,
}

/// The bonds that [`super::find`] gives, each with its reason.
#[must_use]
pub fn explain(structure: &Structure, frame: usize, options: &BondOptions) -> Vec<Explained> {
    let (bonds, known) = find_all(structure, frame, options);
    let Some(frame) = structure.frames().get(frame) else { return Vec::new() };
    let positions = frame.positions.relative();
    let own: HashMap<_, &Bond> = structure.bonds().iter().map(|bond| (bond.key(), bond)).collect();
    // The way from each hydrogen to the atom that it is on, for the angles of hydrogen bonds.
    let mut donors = HashMap::new();
    for bond in bonds.iter().filter(|bond| options.hydrogen_bonds && bond.kind != BondKind::Hydrogen) {
        for atom in [bond.a, bond.b] {
            if structure.elements()[atom as usize] == Element::H {
                donors.insert(atom, way(positions, frame.cell.as_ref(), bond, atom));
            }
        }
    }
    let context = Context { structure, positions, cell: frame.cell.as_ref(), known: &known, options, donors };
    let explained = |bond: &Bond| {
        let length = way(positions, frame.cell.as_ref(), bond, bond.a).length();
        let stated = own.get(&bond.key()).copied();
        let reason = reason(&context, bond, stated, length);
        Explained { bond: *bond, length, reason }
    };
    bonds.iter().map(explained).collect()
}

/// Length of a bond in the first frame, in ångström; to its image where it goes to one.
#[must_use]
pub fn length(structure: &Structure, bond: &Bond) -> f64 {
    let [a, b] = [bond.a, bond.b].map(|atom| structure.positions().get(atom as usize));
    (b + image_shift(structure.cell(), bond)).distance(a)
}

/// How far the image of the second atom is from itself.
fn image_shift(cell: Option<&Cell>, bond: &Bond) -> DVec3 {
    let [a, b, c] = cell.filter(|_| bond.is_periodic()).map_or([DVec3::ZERO; 3], Cell::vectors);
    let [i, j, k] = bond.image.map(f64::from);
    a * i + b * j + c * k
}

/// What kind of bond it is and of which order, for a sentence: `single`, `aromatic`, `hydrogen bond`.
#[must_use]
pub fn order_in_words(bond: &Bond) -> &'static str {
    match (bond.kind, bond.aromatic, bond.order) {
        (BondKind::Covalent, true, _) => "aromatic",
        (BondKind::Covalent, false, BondOrder::Unknown) => "of unknown order",
        (BondKind::Covalent, false, order) => order_name(order),
        (BondKind::Coordination, ..) => "coordination",
        (BondKind::Dative, ..) => "dative",
        (BondKind::Hydrogen, ..) => "hydrogen bond",
    }
}

fn order_name(order: BondOrder) -> &'static str {
    match order {
        BondOrder::Unknown => "none",
        BondOrder::Single => "single",
        BondOrder::Double => "double",
        BondOrder::Triple => "triple",
        BondOrder::Quadruple => "quadruple",
    }
}

/// Who says that there is a bond, for a sentence.
#[must_use]
pub fn source_in_words(bond: &Bond) -> &'static str {
    match bond.source {
        BondSource::File => "from the file",
        BondSource::Link => "a link of the file",
        BondSource::Dictionary => "from the dictionary",
        BondSource::Distance => "by distance",
    }
}

/// From one atom of a bond to the other, an image where the bond goes to one.
fn way(positions: &[Vec3], cell: Option<&Cell>, bond: &Bond, from: u32) -> Vec3 {
    let apart = positions[bond.b as usize] - positions[bond.a as usize] + image_shift(cell, bond).as_vec3();
    if from == bond.a { apart } else { -apart }
}

/// What reasons are made of.
struct Context<'a> {
    structure: &'a Structure,
    positions: &'a [Vec3],
    cell: Option<&'a Cell>,
    known: &'a Known,
    options: &'a BondOptions,
    donors: HashMap<u32, Vec3>,
}

fn reason(context: &Context<'_>, bond: &Bond, stated: Option<&Bond>, length: f32) -> String {
    let Context { structure, positions, cell, known, options, donors } = context;
    let residue = structure.residue_index(bond.a as usize);
    let inside = residue.filter(|_| residue == structure.residue_index(bond.b as usize));
    let component = inside.and_then(|residue| known.component(residue));
    let of_component = || match (component, inside) {
        (Some((id, _)), Some(residue)) => {
            let name = structure.name(structure.residues()[residue].name);
            if id == name { id.to_owned() } else { format!("{id}, which {name} stands for") }
        }
        _ => String::new(),
    };
    // The file says that there is a bond, the dictionary of which order.
    let order_too = || match stated {
        Some(stated) if stated.order != bond.order || stated.aromatic != bond.aromatic => {
            format!("; order from dictionary: {}", of_component())
        }
        _ => String::new(),
    };
    match bond.source {
        BondSource::File if structure.stated_bonds() == StatedBonds::Complete => "file: bond list".to_owned(),
        BondSource::File if stated.is_none() => "file: _chem_comp_bond".to_owned(),
        BondSource::File => format!("file: CONECT{}", order_too()),
        BondSource::Link => format!("link: LINK/SSBOND/_struct_conn{}", order_too()),
        BondSource::Dictionary if inside.is_some() => format!("dictionary: {}", of_component()),
        BondSource::Dictionary => match links::of(structure, bond) {
            links::Link::Peptide => "dictionary: peptide link".to_owned(),
            links::Link::Phosphodiester => "dictionary: phosphodiester link".to_owned(),
        },
        BondSource::Distance if bond.kind == BondKind::Hydrogen => {
            let is_hydrogen = |atom: &u32| structure.elements().get(*atom as usize) == Some(&Element::H);
            let hydrogen = [bond.a, bond.b].into_iter().find(is_hydrogen);
            match hydrogen.and_then(|atom| Some((*donors.get(&atom)?, way(positions, *cell, bond, atom)))) {
                Some((to_donor, to_acceptor)) => {
                    let apart = to_donor.distance(to_acceptor);
                    let angle = hbonds::angle_deg(to_donor, to_acceptor);
                    format!("hydrogen bond: D···A {apart:.2} Å ≤ 3.5, D–H···A {angle:.0}° ≥ 120°")
                }
                None => format!("hydrogen bond: D···A {length:.2} Å ≤ 3.5, no hydrogens in the model"),
            }
        }
        BondSource::Distance => {
            let [a, b] = [bond.a, bond.b].map(|atom| structure.elements()[atom as usize]);
            let (one, other) = (a.covalent_radius(), b.covalent_radius());
            match rules::longest(a, b, options) {
                Some(_) if a == Element::H && b == Element::H => {
                    format!("distance: {length:.2} Å, a hydrogen molecule")
                }
                Some(longest) => {
                    format!("distance: {length:.2} Å ≤ {one:.2}+{other:.2}+{:.2}", longest - one - other)
                }
                None => format!("distance: {length:.2} Å"),
            }
        }
    }
}

/// The pairs that are near enough for a bond and are none of those that [`super::find`] gives, with the reason. Pairs of
/// one dictionary residue are not among them, as all of its bonds are listed. Empty where distances are not asked.
#[must_use]
pub fn not_bonded(structure: &Structure, frame: usize, options: &BondOptions) -> Vec<NotBonded> {
    let asks_distances = match options.mode {
        BondMode::Auto => structure.stated_bonds() != StatedBonds::Complete,
        BondMode::Perceive => true,
        BondMode::File | BondMode::None => false,
    };
    let (bonds, known) = find_all(structure, frame, options);
    let Some(frame) = structure.frames().get(frame).filter(|_| asks_distances) else { return Vec::new() };
    let (positions, elements) = (frame.positions.relative(), structure.elements());
    let sites = Sites::new(structure);
    let table = PairTable::new(elements, &options.sane());
    let is_atom = |atom: usize| {
        elements[atom] != Element::DUMMY
            && structure.flags(atom) & atom_flags::PARTICLE == 0
            && table.reach(table.species(elements[atom])) > 0.0
    };
    let mut bonded = vec![false; elements.len()];
    for atom in bonds.iter().filter(|bond| bond.kind != BondKind::Hydrogen).flat_map(|bond| [bond.a, bond.b]) {
        bonded[atom as usize] = true;
    }
    let grid = Grid::new(positions, elements, &table, is_atom);
    let near = grid.pairs(|a, b, length| {
        let is_bond = bonds.binary_search_by_key(&(a, b, [0; 3]), Bond::key).is_ok();
        (!is_bond).then_some((a, b, length))
    });
    let reason = |a: u32, b: u32, length: f32| -> Option<&'static str> {
        let (one, other) = (a as usize, b as usize);
        let known = [known.standing(one), known.standing(other)];
        let same_residue = structure.residue_index(one) == structure.residue_index(other);
        if known.iter().all(|standing| standing.is_known()) && same_residue {
            return None;
        }
        let role = [sites.role(one), sites.role(other)];
        let metal = elements[one].is_metal() || elements[other].is_metal();
        let hydrogen = [one, other].iter().any(|&atom| elements[atom] == Element::H && bonded[atom]);
        Some(match () {
            () if rules::is_too_near(length) => "nearer than any two atoms can be",
            () if sites.are_alternatives(one, other) => "alternate locations",
            () if role.contains(&Role::Water) => "water stays apart",
            () if hydrogen => "the hydrogen has its bond",
            () if !metal && known.iter().any(|standing| standing.is_full()) => {
                "valence full: all partners of the dictionary are there"
            }
            () if metal && role.contains(&Role::Ion) => "an ion floats unless it has three donors",
            () if metal => "no free electron pair towards the metal, or a nearer atom of the same group",
            () => "valence full, or too narrow an angle",
        })
    };
    let mut out: Vec<NotBonded> = (near.into_iter())
        .filter_map(|(a, b, length)| reason(a, b, length).map(|reason| NotBonded { a, b, length, reason }))
        .collect();
    out.sort_unstable_by_key(|pair| (pair.a, pair.b));
    out
}

impl Explained {
    /// The order as a word: `single`, `double`, …, `none` for coordination and hydrogen bonds, with `aromatic` where it is.
    #[must_use]
    pub fn order_name(&self) -> &'static str {
        match (self.bond.aromatic, self.bond.order) {
            (true, BondOrder::Double) => "aromatic double",
            (true, BondOrder::Single) => "aromatic single",
            (true, _) => "aromatic",
            (false, order) => order_name(order),
        }
    }
}
