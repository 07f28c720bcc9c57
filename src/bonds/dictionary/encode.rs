//! Making `data/ccd.bin` from a text of the dictionary.
//!
//! The text has three lines a component:
//!
//! ```text
//! >ALA
//! N:N CA:C C:C …        atom name:element, and :charge where there is one
//! 0-1:1 1-2:1 2-3:2 …   two atoms by their places in the line above, order 1 to 3, * if aromatic
//! ```

use super::model::{self, Namer, Stream};
use super::{Component, ComponentAtom, DictionaryBond, MAGIC, padded};
use crate::element::Element;
use crate::structure::BondOrder;
use flate2::{Compression, write::DeflateEncoder};
use std::collections::HashMap;
use std::io::Write;

const BLOCK: usize = 64;

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
    let mut text = Vec::new();
    for (name, _) in &names {
        text.extend(name.iter().copied().filter(|&byte| byte != 0));
        text.push(b'\n');
    }
    let text = deflated(&text);
    let mut index = Vec::new();
    let mut blocks = Vec::new();
    for block in components.chunks(BLOCK) {
        index.extend(padded::<5>(block[0].0.as_bytes()).expect("an id of at most five bytes"));
        index.extend(u32::try_from(blocks.len()).expect("4 GiB").to_le_bytes());
        blocks.extend(deflated(&pack_block(block, &ranks)));
    }
    let mut out = MAGIC.to_vec();
    for number in [components.len(), components.len().div_ceil(BLOCK), names.len(), text.len()] {
        out.extend(u32::try_from(number).expect("4 GiB").to_le_bytes());
    }
    [out, index, text, blocks].concat()
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes).expect("memory");
    encoder.finish().expect("memory")
}

fn varint(out: &mut Vec<u8>, mut number: u64) {
    while number >= 128 {
        out.push(number as u8 & 127 | 128);
        number >>= 7;
    }
    out.push(number as u8);
}

fn pack_block(components: &[(String, Component)], ranks: &HashMap<[u8; 4], u16>) -> Vec<u8> {
    let mut streams: [Vec<u8>; Stream::COUNT] = Default::default();
    let mut before = "";
    let mut run = (0, 0);
    for (id, component) in components {
        let same = id.bytes().zip(before.bytes()).take_while(|(a, b)| a == b).count();
        streams[Stream::Id as usize].push((same << 4 | (id.len() - same)) as u8);
        streams[Stream::Id as usize].extend(&id.as_bytes()[same..]);
        before = id;
        pack_component(component, ranks, &mut run, &mut streams);
    }
    end_run(run, &mut streams);
    let mut out = Vec::new();
    varint(&mut out, components.len() as u64);
    for stream in &streams {
        varint(&mut out, stream.len() as u64);
    }
    out.extend(streams.concat());
    out
}

fn end_run(run: (u8, u8), streams: &mut [Vec<u8>; Stream::COUNT]) {
    if run.1 > 0 {
        streams[Stream::Element as usize].extend([run.0, run.1]);
    }
}

fn pack_component(
    component: &Component,
    ranks: &HashMap<[u8; 4], u16>,
    run: &mut (u8, u8),
    streams: &mut [Vec<u8>; Stream::COUNT],
) {
    varint(&mut streams[Stream::Count as usize], component.atoms.len() as u64);
    let mut namer = Namer::default();
    let mut last_parent = 0;
    for (number, atom) in component.atoms.iter().enumerate() {
        let code = model::element_code(atom.element, atom.deuterium);
        if run.0 == code && (1..255).contains(&run.1) {
            run.1 += 1;
        } else {
            end_run(*run, streams);
            *run = (code, 1);
        }
        let mut back: Vec<&DictionaryBond> =
            component.bonds.iter().filter(|bond| usize::from(bond.b) == number).collect();
        back.sort_by_key(|bond| std::cmp::Reverse(bond.a));
        let usual =
            atom.element == Element::H && back.len() == 1 && back[0].order == BondOrder::Single && !back[0].aromatic;
        if usual {
            let step = i64::from(back[0].a) - last_parent;
            varint(&mut streams[Stream::Parent as usize], model::zigzag(step) + 1);
            last_parent = i64::from(back[0].a);
        } else {
            if atom.element == Element::H {
                varint(&mut streams[Stream::Parent as usize], 0);
            }
            let stream = &mut streams[Stream::Bond as usize];
            if back.len() != 1 {
                varint(stream, (back.len() as u64) << 3);
            }
            for bond in &back {
                varint(stream, model::bond_number(bond));
            }
        }
        let parent = (back.len() == 1).then(|| back[0].a);
        namer.next(atom.element, parent);
        match (0..Namer::GUESSES).find(|&guess| namer.guess(guess, atom.element, parent) == atom.name) {
            Some(guess) => streams[Stream::NameGuess as usize].push(guess + 1),
            None => {
                streams[Stream::NameGuess as usize].push(0);
                let [low, high] = ranks[&atom.name].to_le_bytes();
                streams[Stream::NameLow as usize].push(low);
                streams[Stream::NameHigh as usize].push(high);
            }
        }
        namer.named(atom.name, atom.element);
    }
    let charges: Vec<_> = component.atoms.iter().enumerate().filter(|(_, atom)| atom.charge != 0).collect();
    let stream = &mut streams[Stream::Charge as usize];
    varint(stream, charges.len() as u64);
    for (number, atom) in charges {
        varint(stream, number as u64);
        varint(stream, model::zigzag(i64::from(atom.charge)));
    }
}
