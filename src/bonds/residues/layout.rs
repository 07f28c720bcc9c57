//! One residue's atoms laid over a template: which of them are bonded, and which are still short of a partner.
//!
//! A residue is what a template says if at least four of five of its atoms other than hydrogen have a name and an element of
//! it, and most of its lengths are plausible ([`super`]). A ligand that a user called LIG, INH or DRG, and an ion whose
//! name is that of another molecule in the dictionary, do not fit and are bonded by distance.
//!
//! Two atoms of one name are alternate locations of one atom, or, without such, not to be told apart: these are left
//! to the distances.

use super::super::{metal, rules};
use super::names;
use super::template::Template;
use crate::element::Element;
use crate::structure::{BondKind, BondOrder, Structure, atom_flags};
use std::ops::Range;

/// Of a residue's atoms other than hydrogen so many must have a name and element of the template: 4/5. Our choice: a
/// terminal glycine (N, CA, C, O and OXT) with one oxygen of a foreign name has 4 of 5 left and is still glycine.
const FIT: (usize, usize) = (4, 5);
/// How much longer than the covalent radii say a bond of the dictionary may be, in ångström. Our choice: it keeps the
/// distorted side chains of PDB entry 4HHB together (C–C of up to 2.48 Å, 0.96 Å over), and parts a molecule that a
/// periodic boundary has cut, whose bonds are as long as the box.
const LONGEST_EXCESS: f32 = 1.2;
/// From this on a length speaks against the whole residue: 1,3-partners, 2.3 to 2.6 Å apart, taken for bonded ones.
const DOUBTFUL_EXCESS: f32 = 0.75;
/// The same for bonds of hydrogen: as for distances. A hydrogen that has the name of another then goes to its nearest.
const LONGEST_HYDROGEN_EXCESS: f32 = 0.45;
/// The same for metals. Chosen: usual lengths are up to 0.3 Å beyond the radii (the axial water of copper), and a donor that
/// the dictionary names stays one in a rough model, 0.75 Å further away.
const LONGEST_METAL_EXCESS: f32 = 1.05;

/// A bond inside a residue, by the places of its atoms in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct LayoutBond {
    pub(super) a: u32,
    pub(super) b: u32,
    pub(super) order: BondOrder,
    pub(super) kind: BondKind,
    pub(super) aromatic: bool,
    /// Whether one of the atoms is hydrogen.
    pub(super) hydrogen: bool,
    /// Square of the longest plausible length.
    pub(super) longest_squared: f32,
    /// Square of the length from which on it speaks against the residue.
    pub(super) doubtful_squared: f32,
}

/// What is known of an atom: [`Standing::UNKNOWN`], or how many of the partners that its template gives it are not there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::bonds) struct Standing(u8);

impl Standing {
    /// No template knows the atom.
    pub(in crate::bonds) const UNKNOWN: Standing = Standing(0);
    const MISSING: u8 = 0x3f;
    const CARBON: u8 = 0x40;
    const KNOWN: u8 = 0x80;

    fn new(missing: usize, carbon_without_hydrogens: bool) -> Standing {
        let carbon = if carbon_without_hydrogens { Self::CARBON } else { 0 };
        Standing(Self::KNOWN | carbon | missing.min(usize::from(Self::MISSING)) as u8)
    }

    /// Whether a template knows the atom.
    pub(in crate::bonds) fn is_known(self) -> bool {
        self != Self::UNKNOWN
    }

    /// Whether all the partners that the template gives it are there.
    pub(in crate::bonds) fn is_full(self) -> bool {
        self.is_known() && self.0 & Self::MISSING == 0
    }

    /// A carbon that is short of nothing but hydrogens.
    pub(in crate::bonds) fn lacks_only_hydrogens_of_carbon(self) -> bool {
        self.0 & Self::CARBON != 0
    }

    /// The same with one partner less.
    pub(super) fn without_partner(self) -> Standing {
        let may_grow = self.is_known() && self.0 & Self::MISSING != Self::MISSING;
        if may_grow { Standing((self.0 + 1) & !Self::CARBON) } else { self }
    }

    /// The same with one partner more.
    pub(in crate::bonds) fn with_partner(self) -> Standing {
        if self.is_known() && !self.is_full() { Standing(self.0 - 1) } else { self }
    }
}

/// How residues of one name, atom names, elements and alternate locations are bonded inside.
#[derive(Debug)]
pub(super) struct Layout {
    /// The number of the template among those of all names; `None` if none fits.
    pub(super) template: Option<u32>,
    /// Sorted by `(a, b)`.
    pub(super) bonds: Vec<LayoutBond>,
    /// One an atom; empty if no template fits.
    pub(super) standing: Vec<Standing>,
}

/// The atoms of a residue, as far as a layout depends on them.
pub(super) struct Atoms<'a> {
    structure: &'a Structure,
    range: Range<usize>,
}

impl<'a> Atoms<'a> {
    pub(super) fn new(structure: &'a Structure, range: Range<usize>) -> Atoms<'a> {
        Atoms { structure, range }
    }

    fn len(&self) -> usize {
        self.range.len()
    }

    pub(super) fn name(&self, place: usize) -> &'a str {
        self.structure.atom_name(self.range.start + place)
    }

    fn element(&self, place: usize) -> Element {
        self.structure.elements()[self.range.start + place]
    }

    fn altloc(&self, place: usize) -> u8 {
        self.structure.altloc(self.range.start + place)
    }

    fn is_particle(&self, place: usize) -> bool {
        self.structure.flags(self.range.start + place) & atom_flags::PARTICLE != 0
    }

    fn is_heavy(&self, place: usize) -> bool {
        !self.is_particle(place) && self.element(place) != Element::H
    }
}

/// The layout of a residue over the template that fits best. `first` is the number of the first template.
pub(super) fn lay_out(atoms: &Atoms<'_>, templates: &[Template], first: u32) -> Layout {
    let mut best: Option<(i64, u32, Match)> = None;
    for (number, template) in (first..).zip(templates) {
        let Some((score, found)) = fit(atoms, template) else { continue };
        if best.as_ref().is_none_or(|(high, ..)| score > *high) {
            let is_own = template.source == crate::structure::BondSource::File;
            best = Some((score, number, found));
            if is_own {
                break;
            }
        }
    }
    match best {
        Some((_, number, found)) => found.layout(atoms, &templates[(number - first) as usize], number),
        None => Layout { template: None, bonds: Vec::new(), standing: Vec::new() },
    }
}

/// Which atoms of a residue stand for which of a template.
struct Match {
    /// The template's atom for each place.
    of_place: Vec<Option<u32>>,
    /// The places of each of the template's atoms.
    places: Vec<Vec<u32>>,
}

/// How well a template fits, if it does.
fn fit(atoms: &Atoms<'_>, template: &Template) -> Option<(i64, Match)> {
    if template.bonds.is_empty() {
        return None;
    }
    let mut found = Match { of_place: vec![None; atoms.len()], places: vec![Vec::new(); template.elements.len()] };
    let fits = |place: usize, number: u32| {
        template.elements[number as usize].is_none_or(|element| element == atoms.element(place))
    };
    for place in (0..atoms.len()).filter(|&place| !atoms.is_particle(place)) {
        if let Some(&number) = template.names.get(atoms.name(place)).filter(|&&number| fits(place, number)) {
            found.places[number as usize].push(place as u32);
        }
    }
    let exact: Vec<bool> = found.places.iter().map(|places| !places.is_empty()).collect();
    let mut rest: Vec<bool> = (0..atoms.len()).map(|place| !atoms.is_particle(place)).collect();
    for &place in found.places.iter().flatten() {
        rest[place as usize] = false;
    }
    for place in (0..atoms.len()).filter(|&place| rest[place]) {
        let known = names::variants(atoms.name(place), atoms.element(place));
        let number = known.iter().filter_map(|name| template.names.get(name.as_str()).copied()).find(|&number| {
            // All atoms that have the place already have one name.
            let first = found.places[number as usize].first();
            let taken = first.is_some_and(|&other| atoms.name(other as usize) != atoms.name(place));
            !exact[number as usize] && !taken && fits(place, number)
        });
        if let Some(number) = number {
            found.places[number as usize].push(place as u32);
        }
    }
    for (number, places) in (0u32..).zip(&mut found.places) {
        let codes = |place: u32| atoms.altloc(place as usize);
        let distinct = places.len() < 2
            || places.len() < 256
                && places.iter().enumerate().all(|(i, &place)| {
                    codes(place) != b' ' && places[..i].iter().all(|&other| codes(other) != codes(place))
                });
        if distinct {
            for &place in places.iter() {
                found.of_place[place as usize] = Some(number);
            }
        } else {
            places.clear();
        }
    }
    let heavy = (0..atoms.len()).filter(|&place| atoms.is_heavy(place));
    let matched = heavy.clone().filter(|&place| found.of_place[place].is_some()).count();
    if matched == 0 || matched * FIT.1 < heavy.count() * FIT.0 {
        return None;
    }
    let is_missing = |number: usize| found.places[number].is_empty() && !template.hydrogen[number];
    let missing = (0..template.elements.len()).filter(|&number| is_missing(number)).count();
    // An atom that has its place counts more than all that may be missing.
    Some((matched as i64 * 10_000 - missing as i64, found))
}

impl Match {
    fn layout(&self, atoms: &Atoms<'_>, template: &Template, number: u32) -> Layout {
        let count = template.elements.len();
        // Of each atom: partners that are not there, and whether any of these is no hydrogen.
        let (mut missing, mut heavy) = (vec![0usize; count], vec![false; count]);
        for bond in &template.bonds {
            for (atom, partner) in [(bond.a, bond.b), (bond.b, bond.a)] {
                let (atom, partner) = (usize::from(atom), usize::from(partner));
                if self.places[partner].is_empty() {
                    missing[atom] += 1;
                    heavy[atom] |= !template.hydrogen[partner];
                }
            }
        }
        let standing = |atom: usize| {
            let is_carbon = self.places[atom].first().is_some_and(|&place| atoms.element(place as usize) == Element::C);
            Standing::new(missing[atom], is_carbon && !heavy[atom])
        };
        let of_template: Vec<Standing> = (0..count).map(standing).collect();
        let standing =
            self.of_place.iter().map(|number| number.map_or(Standing::UNKNOWN, |number| of_template[number as usize]));
        let mut bonds = Vec::new();
        for bond in &template.bonds {
            for &one in &self.places[usize::from(bond.a)] {
                for &other in &self.places[usize::from(bond.b)] {
                    let (code, other_code) = (atoms.altloc(one as usize), atoms.altloc(other as usize));
                    if code != other_code && code != b' ' && other_code != b' ' {
                        continue;
                    }
                    let elements = [atoms.element(one as usize), atoms.element(other as usize)];
                    // A dictionary gives coordination as single bonds; a terminal oxide has two.
                    let is_coordination =
                        metal::is_coordination(elements[0], elements[1]) && bond.order <= BondOrder::Single;
                    let hydrogen = elements.contains(&Element::H);
                    let excess = match () {
                        () if hydrogen => LONGEST_HYDROGEN_EXCESS,
                        () if elements.iter().any(|element| element.is_metal()) => LONGEST_METAL_EXCESS,
                        () => LONGEST_EXCESS,
                    };
                    bonds.push(LayoutBond {
                        a: one.min(other),
                        b: one.max(other),
                        order: if is_coordination { BondOrder::Unknown } else { bond.order },
                        kind: if is_coordination { BondKind::Coordination } else { BondKind::Covalent },
                        aromatic: bond.aromatic,
                        hydrogen,
                        longest_squared: (rules::radii(elements[0], elements[1]) + excess).powi(2),
                        doubtful_squared: (rules::radii(elements[0], elements[1]) + excess.min(DOUBTFUL_EXCESS))
                            .powi(2),
                    });
                }
            }
        }
        bonds.sort_unstable_by_key(|bond| (bond.a, bond.b));
        bonds.dedup_by_key(|bond| (bond.a, bond.b));
        Layout { template: Some(number), bonds, standing: standing.collect() }
    }
}
