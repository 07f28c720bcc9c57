//! Which atoms are picked, and what there is to say of an atom or bond.

use super::state::State;
use super::work::AtomKey;
use crate::bonds;
use crate::crystal::Drawn;
use crate::scene::{AtomPlace, measured};
use crate::structure::{Bond, Structure};
use glam::{DVec3, Vec3};
use std::collections::HashSet;
use std::fmt::Write;
use std::sync::Arc;

/// What is under the pointer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Target {
    Atom(AtomKey),
    /// A bond of a layer, by its index.
    Bond(u32, u32),
}

/// What an id of the scene stands for.
pub(super) fn target(state: &State, id: u32) -> Option<Target> {
    let (item, copy, own) = state.built.scene.item_of(id)?;
    let (layer, drawn) = state.built.drawn.get(item)?;
    let atoms = u32::try_from(drawn.structure.atom_count()).ok()?;
    if own < atoms {
        return Some(Target::Atom(AtomKey { layer: *layer, atom: own.checked_add(copy.checked_mul(atoms)?)? }));
    }
    ((own - atoms) as usize).lt(&drawn.structure.bonds().len()).then_some(Target::Bond(*layer, own - atoms))
}

/// What is drawn of a layer.
pub(super) fn drawn(state: &State, layer: u32) -> Option<&Arc<Drawn>> {
    state.built.drawn.iter().find(|(id, _)| *id == layer).map(|(_, drawn)| drawn)
}

/// The id in the scene of an atom.
pub(super) fn id_of(state: &State, key: AtomKey) -> Option<u32> {
    let item = state.built.drawn.iter().position(|(id, _)| *id == key.layer)?;
    state.built.scene.id_of(AtomPlace { item: u32::try_from(item).ok()?, atom: key.atom })
}

/// Centre and radius of an atom's ball in the scene; `None` if it is not drawn.
pub(super) fn ball(state: &State, key: AtomKey) -> Option<(Vec3, f32)> {
    state.built.scene.ball(id_of(state, key)?)
}

/// Where an atom is in the file, with all digits.
fn position(state: &State, key: AtomKey) -> Option<DVec3> {
    drawn(state, key.layer)?.position(key.atom)
}

/// What two, three or four atoms measure.
pub(super) fn measure(state: &State, atoms: &[AtomKey]) -> Option<String> {
    let points: Option<Vec<DVec3>> = atoms.iter().map(|&key| position(state, key)).collect();
    measured(&points?)
}

/// The middle of the picked atoms.
pub(super) fn middle(state: &State) -> Option<Vec3> {
    let centers: Vec<Vec3> = state.work.picked.iter().filter_map(|&key| Some(ball(state, key)?.0)).collect();
    (!centers.is_empty()).then(|| centers.iter().sum::<Vec3>() / centers.len() as f32)
}

/// Picks one atom alone, or none; while measuring it is added.
pub(super) fn pick(state: &mut State, key: Option<AtomKey>) {
    match key {
        Some(key) if state.measuring => toggle(state, key),
        Some(key) => state.work.picked = Arc::new(vec![key]),
        None if state.measuring => {}
        None => state.work.picked = Arc::default(),
    }
}

/// Adds an atom, or takes it away. A fifth one begins a new measurement.
pub(super) fn toggle(state: &mut State, key: AtomKey) {
    let is_full = state.measuring && state.work.picked.len() >= 4;
    let picked = Arc::make_mut(&mut state.work.picked);
    match picked.iter().position(|other| *other == key) {
        Some(index) => {
            picked.remove(index);
        }
        None if is_full => *picked = vec![key],
        None => picked.push(key),
    }
}

/// The atoms that are drawn and of which something holds.
pub(super) fn keys(state: &State, mut of: impl FnMut(u32, &Structure, usize) -> bool) -> Vec<AtomKey> {
    let mut keys = Vec::new();
    for (layer, drawn) in &state.built.drawn {
        let atoms = (0..drawn.structure.atom_count()).filter(|&atom| of(*layer, &drawn.structure, atom));
        keys.extend(atoms.map(|atom| AtomKey { layer: *layer, atom: u32::try_from(atom).unwrap_or(u32::MAX) }));
    }
    keys
}

/// Picks all atoms.
pub(super) fn all(state: &mut State) {
    state.work.picked = Arc::new(keys(state, |_, _, _| true));
}

/// From atoms to their residues, to their chains, to all; without residues at once to all.
pub(super) fn more(state: &mut State) {
    let picked: HashSet<AtomKey> = state.work.picked.iter().copied().collect();
    if picked.is_empty() {
        return;
    }
    let group = |structure: &Structure, atom: usize, by_chain: bool| {
        let residue = structure.residue_index(atom)?;
        Some(if by_chain { structure.residues()[residue].chain as usize } else { residue })
    };
    for by_chain in [false, true] {
        // With their copies: what is picked in one of them stays in it.
        let mut groups: HashSet<(u32, u32, usize)> = HashSet::new();
        let mut copies: HashSet<(u32, u32)> = HashSet::new();
        for (layer, drawn) in &state.built.drawn {
            for key in picked.iter().filter(|key| key.layer == *layer) {
                let Some((copy, own)) = drawn.own_atom(key.atom) else { continue };
                if let Some(group) = group(&drawn.structure, own, by_chain) {
                    groups.insert((*layer, copy, group));
                    copies.insert((*layer, copy));
                }
            }
        }
        let mut more = Vec::new();
        for (layer, drawn) in &state.built.drawn {
            let count = drawn.structure.atom_count();
            for &(_, copy) in copies.iter().filter(|(of, _)| of == layer) {
                let is_in = |atom: usize| {
                    group(&drawn.structure, atom, by_chain).is_some_and(|group| groups.contains(&(*layer, copy, group)))
                };
                let atoms = (0..count).filter(|&atom| is_in(atom)).map(|atom| copy as usize * count + atom);
                more.extend(atoms.filter_map(|atom| Some(AtomKey { layer: *layer, atom: u32::try_from(atom).ok()? })));
            }
        }
        more.sort_unstable();
        if more.len() > picked.len() {
            state.work.picked = Arc::new(more);
            return;
        }
    }
    all(state);
}

/// Lets go of picked atoms and measurements that are not there any more.
pub(super) fn keep_what_is_there(state: &mut State) {
    // Those of hidden layers wait for them to come back.
    let is_there = |key: &AtomKey| drawn(state, key.layer).is_none_or(|drawn| drawn.own_atom(key.atom).is_some());
    let kept: Vec<AtomKey> = state.work.picked.iter().copied().filter(is_there).collect();
    let measured: Vec<bool> = state.work.measurements.iter().map(|atoms| atoms.iter().all(is_there)).collect();
    if kept.len() < state.work.picked.len() {
        state.work.picked = Arc::new(kept);
    }
    let mut measured = measured.into_iter();
    state.work.measurements.retain(|_| measured.next().unwrap_or(false));
}

/// As [`short_name`], of an atom of the picture: `CA of GLY 12 in chain A, copy 2`.
pub(super) fn name_of(state: &State, key: AtomKey) -> Option<String> {
    let drawn = drawn(state, key.layer)?;
    let (copy, own) = drawn.own_atom(key.atom)?;
    let name = short_name(&drawn.structure, own);
    Some(if copy == 0 { name } else { format!("{name}, copy {}", copy + 1) })
}

/// An atom in a few words: `CA of GLY 12 in chain A`, `C3`.
pub(super) fn short_name(structure: &Structure, atom: usize) -> String {
    let symbol = structure.elements().get(atom).map_or("?", |element| element.symbol());
    match structure.residue_index(atom).and_then(|index| structure.residues().get(index)) {
        Some(residue) => {
            let name = structure.atom_name(atom).trim();
            let name = if name.is_empty() { symbol } else { name };
            let mut text = format!("{name} of {} {}", structure.name(residue.name), residue.number);
            if residue.insertion_code != b' ' {
                text.push(char::from(residue.insertion_code));
            }
            let chain = structure.chains().nth(residue.chain as usize).unwrap_or("").trim().to_owned();
            if !chain.is_empty() {
                let _ = write!(text, " in chain {chain}");
            }
            text
        }
        None => format!("{symbol}{}", atom + 1),
    }
}

/// Bonds of an atom that are told; a metal in a lattice has more than fit a tooltip.
const MOST_BONDS: usize = 8;

/// What there is to say of an atom: a heading, and facts by name.
pub(super) fn about_atom(drawn: &Drawn, atom: u32) -> Option<(String, Vec<(String, String)>)> {
    let (place, (copy, atom)) = (drawn.position(atom)?, drawn.own_atom(atom)?);
    let structure = &drawn.structure;
    let mut facts = Vec::new();
    let mut fact = |name: &str, value: String| facts.push((name.to_owned(), value));
    let element = structure.elements()[atom];
    let charge = structure.formal_charge(atom);
    let charged = match charge {
        0 => String::new(),
        -1 => "−".to_owned(),
        1 => "+".to_owned(),
        n if n < 0 => format!("{}−", n.unsigned_abs()),
        n => format!("{n}+"),
    };
    let heading = format!("{} {}{charged}", element.name(), element.symbol());
    if let Some(residue) = structure.residue_index(atom).and_then(|index| structure.residues().get(index)) {
        let name = structure.atom_name(atom).trim();
        if !name.is_empty() {
            fact("Name", name.to_owned());
        }
        let code = Some(char::from(residue.insertion_code)).filter(|code| *code != ' ');
        let code = code.map(String::from).unwrap_or_default();
        fact("Residue", format!("{} {}{code}", structure.name(residue.name), residue.number));
        let chain = structure.chains().nth(residue.chain as usize).unwrap_or("").trim();
        if !chain.is_empty() {
            fact("Chain", chain.to_owned());
        }
    }
    let listed = drawn.listed.get(atom).map_or(atom, |&listed| listed as usize);
    fact("Number", (listed + 1).to_string());
    if let Some(copies) = &drawn.copies {
        fact("Copy", format!("{} of {}", copy + 1, copies.operations.len()));
    }
    fact("Position", format!("{:.3}  {:.3}  {:.3} Å", place.x, place.y, place.z));
    if structure.altloc(atom) != b' ' {
        let altloc = char::from(structure.altloc(atom));
        fact("Location", format!("{altloc}, occupancy {:.2}", structure.occupancy(atom)));
    }
    if let Some(charge) = structure.partial_charge(atom) {
        fact("Charge", format!("{charge:+.3}"));
    }
    let index = u32::try_from(atom).unwrap_or(u32::MAX);
    let own: Vec<&Bond> = structure.bonds().iter().filter(|bond| bond.a == index || bond.b == index).collect();
    for bond in own.iter().take(MOST_BONDS) {
        let other = if bond.a == index { bond.b } else { bond.a } as usize;
        let partner = short_name(structure, other);
        let length = bonds::length(structure, bond);
        fact(
            "Bond",
            format!("{partner}: {length:.3} Å, {}, {}", bonds::order_in_words(bond), bonds::source_in_words(bond)),
        );
    }
    if own.len() > MOST_BONDS {
        fact("", format!("and {} more bonds", own.len() - MOST_BONDS));
    }
    Some((heading, facts))
}

/// What there is to say of a bond.
pub(super) fn about_bond(drawn: &Drawn, bond: usize) -> Option<(String, Vec<(String, String)>)> {
    let structure = &drawn.structure;
    let bond = structure.bonds().get(bond)?;
    let [a, b] = [bond.a, bond.b].map(|atom| short_name(structure, atom as usize));
    let facts = vec![
        ("Length".to_owned(), format!("{:.3} Å", bonds::length(structure, bond))),
        ("Order".to_owned(), bonds::order_in_words(bond).to_owned()),
        ("Known".to_owned(), bonds::source_in_words(bond).to_owned()),
    ];
    Some((format!("{a} – {b}"), facts))
}
