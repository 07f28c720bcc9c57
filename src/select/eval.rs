//! From what a selection means to the atoms of a structure.
//!
//! A term is a list of one truth an atom. Names are compared once each, not once an atom, and kinds of residues found once a
//! selection, so that each term is one pass over the atoms.

use super::Scope;
use super::kinds::{self, ResidueKind};
use super::near;
use super::parse::{Expr, Pattern};
use super::token::Compare;
use super::words::{Group, NameOf, Near, NumberOf, Quantity, Set};
use crate::bonds;
use crate::element::Element;
use crate::structure::{BondKind, NameId, Structure, atom_flags};
use std::cell::OnceCell;

/// What several terms ask for, found when first asked.
pub(super) struct Context<'a> {
    scope: Scope<'a>,
    structure: &'a Structure,
    kinds: OnceCell<Vec<ResidueKind>>,
}

impl<'a> Context<'a> {
    pub(super) fn new(scope: Scope<'a>) -> Context<'a> {
        Context { scope, structure: scope.structure, kinds: OnceCell::new() }
    }

    fn count(&self) -> usize {
        self.structure.atom_count()
    }

    fn each(&self, is_it: impl Fn(usize) -> bool) -> Vec<bool> {
        (0..self.count()).map(is_it).collect()
    }

    fn kinds(&self) -> &[ResidueKind] {
        self.kinds.get_or_init(|| kinds::residue_kinds(self.structure))
    }

    fn of_kind(&self, is_it: impl Fn(ResidueKind) -> bool) -> Vec<bool> {
        kinds::of_kind(self.structure, self.kinds(), is_it)
    }

    /// The atoms.
    pub(super) fn atoms(&self, expr: &Expr) -> Vec<bool> {
        match expr {
            Expr::Set(set) => self.set(*set),
            Expr::Names(of, patterns) => self.named(*of, patterns),
            Expr::Elements(elements) => {
                let own = self.structure.elements();
                let is_it = |atom: usize| {
                    let isotope = self.structure.isotope(atom);
                    elements.iter().any(|&(element, mass)| own[atom] == element && (mass == 0 || mass == isotope))
                };
                self.each(is_it)
            }
            Expr::Residues(ranges) => self.residues(|number, code| {
                ranges.iter().any(|(first, last)| {
                    let from = (first.number, first.code.unwrap_or(0));
                    let to = (last.number, last.code.unwrap_or(u8::MAX));
                    (from..=to).contains(&(number, code))
                })
            }),
            Expr::Numbers(of, ranges, _) => {
                self.each(|atom| ranges.iter().any(|range| range.contains(&self.number(*of, atom))))
            }
            Expr::Compare(Quantity::Residue, compare, limit) => {
                self.residues(|number, _| holds(f64::from(number), *compare, *limit))
            }
            Expr::Compare(quantity, compare, limit) => self.compared(*quantity, *compare, *limit),
            Expr::Near(near, reach, of) => self.near(*near, *reach, &self.atoms(of)),
            Expr::Bonded(to) => self.bonded(&self.atoms(to)),
            Expr::Same(group, of) => self.same(*group, self.atoms(of)),
            Expr::Not(inner) => {
                let mut all = self.atoms(inner);
                all.iter_mut().for_each(|is| *is = !*is);
                all
            }
            Expr::And(terms) => self.joined(terms, |one, other| one & other),
            Expr::Or(terms) => self.joined(terms, |one, other| one | other),
        }
    }

    fn joined(&self, terms: &[Expr], join: impl Fn(bool, bool) -> bool) -> Vec<bool> {
        let mut terms = terms.iter();
        let mut all = terms.next().map_or_else(|| vec![false; self.count()], |first| self.atoms(first));
        for term in terms {
            all.iter_mut().zip(self.atoms(term)).for_each(|(is, other)| *is = join(*is, other));
        }
        all
    }

    fn set(&self, set: Set) -> Vec<bool> {
        let structure = self.structure;
        let is_polymer = |kind| matches!(kind, ResidueKind::Protein | ResidueKind::Nucleic);
        match set {
            Set::All => vec![true; self.count()],
            Set::None => vec![false; self.count()],
            Set::Protein => self.of_kind(|kind| kind == ResidueKind::Protein),
            Set::Nucleic => self.of_kind(|kind| kind == ResidueKind::Nucleic),
            Set::Polymer => self.of_kind(is_polymer),
            Set::Backbone => kinds::backbone(structure, self.kinds()),
            Set::Sidechain => {
                let mut all = self.of_kind(is_polymer);
                let backbone = kinds::backbone(structure, self.kinds());
                all.iter_mut().zip(backbone).for_each(|(is, backbone)| *is &= !backbone);
                all
            }
            Set::Ligand if structure.residues().is_empty() => {
                let (waters, ions) = (bonds::waters(structure), kinds::ions(structure));
                self.each(|atom| !waters[atom] && !ions[atom])
            }
            Set::Ligand => self.of_kind(|kind| kind == ResidueKind::Other),
            Set::Water => bonds::waters(structure),
            Set::Ion if structure.residues().is_empty() => kinds::ions(structure),
            Set::Ion => self.of_kind(|kind| kind == ResidueKind::Ion),
            Set::Metal => structure.elements().iter().map(|element| element.is_metal()).collect(),
            Set::Hydrogen => structure.elements().iter().map(|&element| element == Element::H).collect(),
            Set::Hetero => self.each(|atom| structure.flags(atom) & atom_flags::HETERO != 0),
            Set::Helix => self.secondary(true),
            Set::Strand => self.secondary(false),
        }
    }

    fn secondary(&self, helix: bool) -> Vec<bool> {
        let chains: Vec<&str> = self.structure.chains().collect();
        let elements: Vec<_> = self.structure.secondary().iter().filter(|element| element.helix == helix).collect();
        let is_it: Vec<bool> = (self.structure.residues().iter())
            .map(|residue| {
                let at = (residue.number, residue.insertion_code);
                let chain = chains.get(residue.chain as usize).copied().unwrap_or_default();
                elements.iter().any(|element| element.chain == chain && element.first <= at && at <= element.last)
            })
            .collect();
        self.of_residues(&is_it)
    }

    fn of_residues(&self, is_it: &[bool]) -> Vec<bool> {
        self.each(|atom| self.structure.residue_index(atom).is_some_and(|residue| is_it[residue]))
    }

    /// The atoms of residues by number and insertion code.
    fn residues(&self, is_it: impl Fn(i32, u8) -> bool) -> Vec<bool> {
        let residues = self.structure.residues().iter();
        let is_it: Vec<bool> = residues.map(|residue| is_it(residue.number, residue.insertion_code)).collect();
        self.of_residues(&is_it)
    }

    fn named(&self, of: NameOf, patterns: &[Pattern]) -> Vec<bool> {
        let structure = self.structure;
        if of == NameOf::Altloc {
            return self.each(|atom| {
                let code = [structure.altloc(atom)];
                let own = std::str::from_utf8(&code).unwrap_or_default().trim();
                patterns.iter().any(|pattern| pattern.fits(own, true))
            });
        }
        // Chains are told apart by case; nobody calls two atoms so.
        let exact = of == NameOf::Chain;
        let fits = |text: &str| patterns.iter().any(|pattern| pattern.fits(text.trim(), exact));
        let fitting: Vec<bool> = structure.names.texts().map(fits).collect();
        let has = |name: NameId| fitting.get(name.index()).is_some_and(|&fits| fits);
        match of {
            NameOf::Atom => {
                let names = structure.atom_names();
                let elements = structure.elements();
                // Where the file gives no names, labels show the element.
                self.each(|atom| names.get(atom).map_or_else(|| fits(elements[atom].symbol()), |&name| has(name)))
            }
            NameOf::Residue => {
                let is_it: Vec<bool> = structure.residues().iter().map(|residue| has(residue.name)).collect();
                self.of_residues(&is_it)
            }
            NameOf::Chain | NameOf::Altloc => {
                let chains: Vec<bool> = structure.chains().map(fits).collect();
                let is_it: Vec<bool> =
                    structure.residues().iter().map(|residue| chains[residue.chain as usize]).collect();
                self.of_residues(&is_it)
            }
        }
    }

    fn number(&self, of: NumberOf, atom: usize) -> i64 {
        match of {
            NumberOf::Index => self.scope.listed.get(atom).map_or(atom as i64, |&listed| i64::from(listed)) + 1,
            NumberOf::Drawn => atom as i64 + 1,
            NumberOf::Serial => i64::from(self.structure.serial(atom)),
            NumberOf::File => i64::from(self.scope.file),
        }
    }

    fn compared(&self, quantity: Quantity, compare: Compare, limit: f64) -> Vec<bool> {
        let structure = self.structure;
        let place = |axis: usize| self.each(|atom| holds(structure.positions().get(atom)[axis], compare, limit));
        match quantity {
            Quantity::Number(of) => self.each(|atom| holds(self.number(of, atom) as f64, compare, limit)),
            // Written with few digits, kept in f32: compared as such.
            Quantity::BFactor => self.each(|atom| holds_f32(structure.b_factor(atom), compare, limit)),
            Quantity::Occupancy => self.each(|atom| holds_f32(structure.occupancy(atom), compare, limit)),
            Quantity::Charge => self.each(|atom| holds(f64::from(structure.formal_charge(atom)), compare, limit)),
            Quantity::PartialCharge => {
                self.each(|atom| structure.partial_charge(atom).is_some_and(|charge| holds_f32(charge, compare, limit)))
            }
            Quantity::X => place(0),
            Quantity::Y => place(1),
            Quantity::Z => place(2),
            Quantity::Residue => self.residues(|number, _| holds(f64::from(number), compare, limit)),
        }
    }

    fn near(&self, near: Near, reach: f64, of: &[bool]) -> Vec<bool> {
        let mut all = near::within(self.structure.positions().relative(), of, reach);
        match near {
            Near::Within => {}
            Near::Around => all.iter_mut().zip(of).for_each(|(is, own)| *is &= !own),
            Near::Beyond => all.iter_mut().for_each(|is| *is = !*is),
        }
        all
    }

    fn bonded(&self, to: &[bool]) -> Vec<bool> {
        let mut all = vec![false; self.count()];
        for bond in self.structure.bonds().iter().filter(|bond| bond.kind != BondKind::Hydrogen) {
            let [a, b] = [bond.a as usize, bond.b as usize];
            all[a] |= to[b];
            all[b] |= to[a];
        }
        all
    }

    fn same(&self, group: Group, of: Vec<bool>) -> Vec<bool> {
        let structure = self.structure;
        match group {
            Group::Molecule => molecules(structure, of),
            // Without residues each molecule is its own.
            _ if structure.residues().is_empty() => molecules(structure, of),
            Group::Residue | Group::Chain => {
                let group_of = |atom: usize| {
                    let residue = structure.residue_index(atom)?;
                    Some(if group == Group::Chain { structure.residues()[residue].chain as usize } else { residue })
                };
                let mut is_it = vec![false; structure.residues().len().max(structure.chains().len())];
                for atom in (0..self.count()).filter(|&atom| of[atom]) {
                    if let Some(group) = group_of(atom) {
                        is_it[group] = true;
                    }
                }
                self.each(|atom| group_of(atom).is_some_and(|group| is_it[group]))
            }
        }
    }
}

/// All that bonds join to these atoms.
pub(super) fn molecules(structure: &Structure, of: Vec<bool>) -> Vec<bool> {
    let count = structure.atom_count();
    // Each atom leads to another one of its molecule, the first of all to itself.
    let mut leads: Vec<u32> = (0..count as u32).collect(); // a structure has fewer than 2^32 atoms
    fn first(leads: &mut [u32], mut atom: u32) -> u32 {
        while leads[atom as usize] != atom {
            leads[atom as usize] = leads[leads[atom as usize] as usize];
            atom = leads[atom as usize];
        }
        atom
    }
    for bond in structure.bonds().iter().filter(|bond| bond.kind != BondKind::Hydrogen) {
        let [a, b] = [bond.a, bond.b].map(|atom| first(&mut leads, atom));
        leads[a.max(b) as usize] = a.min(b);
    }
    let mut is_it = vec![false; count];
    for atom in (0..count).filter(|&atom| of[atom]) {
        is_it[first(&mut leads, atom as u32) as usize] = true;
    }
    (0..count).map(|atom| is_it[first(&mut leads, atom as u32) as usize]).collect()
}

fn holds(value: f64, compare: Compare, limit: f64) -> bool {
    match compare {
        Compare::Less => value < limit,
        Compare::LessOrEqual => value <= limit,
        Compare::Greater => value > limit,
        Compare::GreaterOrEqual => value >= limit,
        Compare::Equal => value == limit,
        Compare::Different => value != limit,
    }
}

fn holds_f32(value: f32, compare: Compare, limit: f64) -> bool {
    holds(f64::from(value), compare, f64::from(limit as f32))
}

impl Pattern {
    /// Whether a name is of this pattern.
    fn fits(&self, name: &str, exact: bool) -> bool {
        if !self.is_wild {
            return if exact { self.text == name } else { self.text.eq_ignore_ascii_case(name) };
        }
        // Names of nucleic acids had stars for primes.
        let same = |a: u8, b: u8| a == b || !exact && a.eq_ignore_ascii_case(&b);
        let (pattern, name) = (self.text.as_bytes(), name.as_bytes());
        let (mut p, mut n) = (0, 0);
        let mut last_star = None;
        while n < name.len() {
            match pattern.get(p) {
                Some(b'*') => {
                    last_star = Some((p, n));
                    p += 1;
                }
                Some(&letter) if letter == b'?' || same(letter, name[n]) => {
                    (p, n) = (p + 1, n + 1);
                }
                // The last star takes one letter more.
                _ => match last_star {
                    Some((star, at)) => {
                        last_star = Some((star, at + 1));
                        (p, n) = (star + 1, at + 1);
                    }
                    None => return false,
                },
            }
        }
        pattern[p..].iter().all(|&letter| letter == b'*')
    }
}
