//! Making `data/ccd.bin` from a text of the dictionary.
//!
//! The text has three lines a component:
//!
//! ```text
//! >ALA
//! N:N CA:C C:C …        atom name:element, and :charge where there is one
//! 0-1:1 1-2:1 2-3:2 …   two atoms by their places in the line above, order 1 to 3, * if aromatic
//! ```

use super::coder::SYMBOL_BYTES;
use super::coder::encode::{Frequencies, InContext};
use super::model::{self, Contexts, Namer};
use super::{Component, ComponentAtom, DictionaryBond, MAGIC, padded};
use crate::element::Element;
use crate::structure::BondOrder;
use std::collections::HashMap;

/// The components of a text, by their ids.
pub(super) fn parse(text: &str) -> Vec<(String, Component)> {
    let mut lines = text.lines();
    let mut out = Vec::new();
    while let Some(line) = lines.next() {
        let id = line.strip_prefix('>').expect("a line with an id").to_owned();
        let atoms = lines.next().expect("a line of atoms").split_whitespace().map(parse_atom).collect();
        let mut bonds: Vec<_> = lines.next().expect("a line of bonds").split_whitespace().map(parse_bond).collect();
        bonds.sort_unstable();
        out.push((id, Component { atoms, bonds }));
    }
    out.sort_by(|a, b| a.0.cmp(&b.0));
    out
}

fn parse_atom(text: &str) -> ComponentAtom {
    let (mut rest, mut last) = text.rsplit_once(':').expect("name:element");
    // A name may hold a colon itself; a charge is a number.
    let charge = last.parse().ok().filter(|_| rest.contains(':'));
    if charge.is_some() {
        (rest, last) = rest.rsplit_once(':').expect("name:element:charge");
    }
    let element = if last == "X" { Element::DUMMY } else { Element::from_symbol(last).expect("an element") };
    let name = padded(rest.as_bytes()).expect("a name of at most four bytes");
    ComponentAtom { name, element, deuterium: last == "D", charge: charge.unwrap_or(0) }
}

fn parse_bond(text: &str) -> DictionaryBond {
    let (atoms, order) = text.split_once(':').expect("atoms:order");
    let (a, b) = atoms.split_once('-').expect("atom-atom");
    let (a, b): (u16, u16) = (a.parse().expect("a number"), b.parse().expect("a number"));
    let aromatic = order.ends_with('*');
    let number = order.trim_end_matches('*').parse().expect("an order");
    DictionaryBond { a: a.min(b), b: a.max(b), order: BondOrder::from_number(number), aromatic }
}

/// The packed form.
pub(super) fn pack(components: &[(String, Component)]) -> Vec<u8> {
    let mut counts: HashMap<[u8; 4], usize> = HashMap::new();
    for atom in components.iter().flat_map(|(_, component)| &component.atoms) {
        *counts.entry(atom.name).or_default() += 1;
    }
    let mut names: Vec<_> = counts.into_iter().collect();
    names.sort_by_key(|&(name, count)| (std::cmp::Reverse(count), name));
    let ranks: HashMap<[u8; 4], u16> =
        names.iter().enumerate().map(|(rank, &(name, _))| (name, u16::try_from(rank).expect("65,536 names"))).collect();
    let rows: Vec<Vec<InContext>> = components.iter().map(|(_, component)| symbols(component, &ranks)).collect();
    let frequencies = Frequencies::count(Contexts::ALL, rows.iter().flatten());
    let [begins, table] = frequencies.tables();
    let (mut index, mut packed) = (Vec::new(), Vec::new());
    for ((id, _), row) in components.iter().zip(&rows) {
        index.extend(padded::<5>(id.as_bytes()).expect("an id of at most five bytes"));
        index.extend(u32::try_from(packed.len()).expect("4 GiB").to_le_bytes());
        packed.extend(frequencies.encode(row));
    }
    let mut out = MAGIC.to_vec();
    for number in [components.len(), names.len(), Contexts::ALL, table.len() / SYMBOL_BYTES] {
        out.extend(u32::try_from(number).expect("4 GiB").to_le_bytes());
    }
    let names: Vec<u8> = names.into_iter().flat_map(|(name, _)| name).collect();
    [out, names, begins, table, index, packed].concat()
}

/// The symbols of a component, in the order in which they are read.
fn symbols(component: &Component, ranks: &HashMap<[u8; 4], u16>) -> Vec<InContext> {
    let short = |number: usize| u16::try_from(number).expect("a small number");
    let mut out = vec![(Contexts::COUNT, short(component.atoms.len()))];
    let (mut contexts, mut namer) = (Contexts::default(), Namer::default());
    let mut last_parent = 0;
    for (number, atom) in component.atoms.iter().enumerate() {
        let code = model::element_code(atom.element, atom.deuterium);
        out.push((contexts.element(), u16::from(code)));
        contexts.met_element(code);
        let mut back: Vec<&DictionaryBond> =
            component.bonds.iter().filter(|bond| usize::from(bond.b) == number).collect();
        back.sort_by_key(|bond| std::cmp::Reverse(bond.a));
        let usual =
            atom.element == Element::H && back.len() == 1 && back[0].order == BondOrder::Single && !back[0].aromatic;
        if atom.element == Element::H {
            let step = if usual { model::zigzag(i32::from(back[0].a) - last_parent) + 1 } else { 0 };
            out.push((contexts.parent(), step));
            contexts.met_parent(step);
        }
        if usual {
            last_parent = i32::from(back[0].a);
        } else {
            let several = (back.len() != 1).then(|| short(back.len()) << 3);
            for number in several.into_iter().chain(back.iter().map(|bond| model::bond_number(bond))) {
                out.push((contexts.bond(), number));
                contexts.met_bond(number);
            }
        }
        let parent = (back.len() == 1).then(|| back[0].a);
        namer.next(atom.element, parent);
        let guessed = (0..Namer::GUESSES).find(|&guess| namer.guess(guess, atom.element, parent) == atom.name);
        let guess = guessed.map_or(0, |guess| guess + 1);
        out.push((contexts.guess(), u16::from(guess)));
        if guess == 0 {
            out.push((contexts.name(), ranks[&atom.name]));
        }
        contexts.met_guess(guess);
        namer.named(atom.name, atom.element);
    }
    let charges: Vec<_> = component.atoms.iter().enumerate().filter(|(_, atom)| atom.charge != 0).collect();
    out.push((Contexts::CHARGES, short(charges.len())));
    for (number, atom) in charges {
        out.push((Contexts::CHARGED, short(number)));
        out.push((Contexts::CHARGE, model::zigzag(i32::from(atom.charge))));
    }
    out
}
