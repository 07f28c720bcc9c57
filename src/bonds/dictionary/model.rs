//! What is usual in a component: the contexts of its symbols, and guesses of its names.

use super::{AtomName, DictionaryBond};
use crate::element::Element;
use crate::structure::BondOrder;

/// What was met of a component, from which follows how probable is what comes: the contexts of its symbols.
#[derive(Debug, Default)]
pub(super) struct Contexts {
    /// Codes of the last two elements.
    elements: [u8; 2],
    /// The last two numbers of [`Contexts::parent`].
    parents: [u16; 2],
    /// The last number of [`Contexts::bond`].
    bond: u16,
    /// The last two guesses.
    guesses: [u8; 2],
    /// The parent's number of this atom, 0 if it has none.
    usual: u16,
}

/// Classes of elements: none or X, hydrogen, carbon, nitrogen, oxygen, phosphorus, sulfur, all others.
const CLASSES: usize = 8;
/// Numbers of parents that are told apart: the last one, and the one before that. These and those below are chosen: more
/// make the frequencies longer than they make the components shorter.
const PARENTS: [usize; 2] = [16, 8];
/// Numbers of bonds that are told apart.
const BONDS: usize = 32;
/// The guesses of [`Namer`], and none.
const GUESSES: usize = Namer::GUESSES as usize + 1;
/// Numbers of parents that are told apart for names.
const USUAL: usize = 4;

const ELEMENT: usize = Contexts::CHARGE + 1;
const PARENT: usize = ELEMENT + 256 * CLASSES;
const BOND: usize = PARENT + PARENTS[0] * PARENTS[1];
const GUESS: usize = BOND + CLASSES * CLASSES * BONDS;
const NAME: usize = GUESS + CLASSES * GUESSES * GUESSES * USUAL;

fn class(code: u8) -> usize {
    match code {
        0 => 0,
        1 | DEUTERIUM => 1,
        6 => 2,
        7 => 3,
        8 => 4,
        15 => 5,
        16 => 6,
        _ => 7,
    }
}

impl Contexts {
    /// The number of atoms.
    pub(super) const COUNT: usize = 0;
    /// How many atoms have a charge, then for each its number and the charge (zigzag).
    pub(super) const CHARGES: usize = 1;
    pub(super) const CHARGED: usize = 2;
    pub(super) const CHARGE: usize = 3;
    /// How many contexts there are.
    pub(super) const ALL: usize = NAME + CLASSES;

    /// Of an element ([`element_of`]), the first symbol of an atom.
    pub(super) fn element(&self) -> usize {
        ELEMENT + usize::from(self.elements[0]) * CLASSES + class(self.elements[1])
    }

    pub(super) fn met_element(&mut self, code: u8) {
        self.elements = [code, self.elements[0]];
        self.usual = 0;
    }

    /// Of a hydrogen's partner: 0 if it is not as usual, else how many atoms it is after that of the hydrogen before
    /// (zigzag), plus one.
    pub(super) fn parent(&self) -> usize {
        let [last, before] = self.parents.map(usize::from);
        PARENT + last.min(PARENTS[0] - 1) * PARENTS[1] + before.min(PARENTS[1] - 1)
    }

    pub(super) fn met_parent(&mut self, number: u16) {
        self.parents = [number, self.parents[0]];
        self.usual = number;
    }

    /// Of bonds to earlier atoms: three bits of order, above them how many atoms back; or, where it is not one, first of
    /// all how many, above three bits of zero.
    pub(super) fn bond(&self) -> usize {
        let [this, before] = self.elements.map(class);
        BOND + (this * CLASSES + before) * BONDS + usize::from(self.bond).min(BONDS - 1)
    }

    pub(super) fn met_bond(&mut self, number: u16) {
        self.bond = number;
    }

    /// Of which guess of [`Namer`] is the name, from 1; 0 for none.
    pub(super) fn guess(&self) -> usize {
        let [last, before] = self.guesses.map(|guess| usize::from(guess).min(GUESSES - 1));
        let names = (class(self.elements[0]) * GUESSES + last) * GUESSES + before;
        GUESS + names * USUAL + usize::from(self.usual).min(USUAL - 1)
    }

    pub(super) fn met_guess(&mut self, guess: u8) {
        self.guesses = [guess, self.guesses[0]];
    }

    /// Of a name that was not guessed: its place in the list of names.
    pub(super) fn name(&self) -> usize {
        NAME + class(self.elements[0])
    }
}

/// The code of an element: its atomic number, 0 for X, and deuterium.
const DEUTERIUM: u8 = 255;

/// The element that a code stands for, and whether it is deuterium.
pub(super) fn element_of(code: u8) -> Option<(Element, bool)> {
    match code {
        0 => Some((Element::DUMMY, false)),
        DEUTERIUM => Some((Element::H, true)),
        z => Some((Element::from_z(z)?, false)),
    }
}

/// The inverse of [`element_of`].
#[cfg(test)]
pub(super) fn element_code(element: Element, deuterium: bool) -> u8 {
    if deuterium { DEUTERIUM } else { element.z() }
}

/// 0, −1, 1, −2, … for 0, 1, 2, 3, …
pub(super) fn unzigzag(number: u16) -> i32 {
    i32::from(number >> 1) ^ -i32::from(number & 1)
}

/// The inverse of [`unzigzag`].
#[cfg(test)]
pub(super) fn zigzag(number: i32) -> u16 {
    u16::try_from((number << 1) ^ (number >> 31)).expect("a small number")
}

/// Orders of bonds, 1 and up: single, double, triple, and the same aromatic.
const ORDERS: [BondOrder; 3] = [BondOrder::Single, BondOrder::Double, BondOrder::Triple];

/// The bond of an atom that a number of [`Contexts::bond`] stands for.
pub(super) fn bond(atom: u16, number: u16) -> Option<DictionaryBond> {
    let kind = (number & 7) as usize;
    let back = number >> 3;
    let order = *ORDERS.get(kind.checked_sub(1)? % 3)?;
    let a = atom.checked_sub(back).filter(|_| back > 0)?;
    (kind <= 6).then_some(DictionaryBond { a, b: atom, order, aromatic: kind > 3 })
}

/// The inverse of [`bond`].
#[cfg(test)]
pub(super) fn bond_number(bond: &DictionaryBond) -> u16 {
    (bond.b - bond.a) << 3 | u16::from(bond.order.number() + 3 * u8::from(bond.aromatic))
}

/// Guesses the names of a component's atoms, one after the other.
#[derive(Debug, Default)]
pub(super) struct Namer {
    names: Vec<AtomName>,
    elements: Vec<Element>,
    /// Hydrogens so far on each atom.
    hydrogens: Vec<u8>,
    /// The last atom of each element, newest first.
    last: Vec<(Element, AtomName)>,
}

impl Namer {
    /// How many guesses there are.
    pub(super) const GUESSES: u8 = 9;

    /// Tells that the next atom is a hydrogen, if it is, on this one; before its guesses are asked for.
    pub(super) fn next(&mut self, element: Element, parent: Option<u16>) {
        let parent = parent.filter(|_| element == Element::H);
        if let Some(count) = parent.and_then(|parent| self.hydrogens.get_mut(usize::from(parent))) {
            *count = count.saturating_add(1);
        }
    }

    /// A name that the next atom may have, by its number below [`Namer::GUESSES`]; some are the same or empty. `parent` is
    /// its only earlier partner.
    pub(super) fn guess(&self, which: u8, element: Element, parent: Option<u16>) -> AtomName {
        let before = self.names.last().copied().unwrap_or_default();
        let parent = parent.map(usize::from).filter(|&parent| parent < self.names.len());
        if let Some(parent) = parent.filter(|_| element == Element::H) {
            return self.hydrogen(which, parent, before);
        }
        let like = || (self.last.iter().find(|last| last.0 == element)).map_or([0; 4], |last| last.1);
        let numbered = |step: u32| match number_of(before) {
            Some(number) => joined(element.symbol().to_ascii_uppercase().as_bytes(), number + step),
            None => [0; 4],
        };
        match which {
            0 => counted_on(before),
            1 => stepped(before),
            2 => counted_on(like()),
            3 => stepped(like()),
            4 => numbered(1),
            5 => numbered(0),
            _ => [0; 4],
        }
    }

    /// A hydrogen is called H, as the atom it is on without its element, and maybe its number or letter there.
    fn hydrogen(&self, which: u8, parent: usize, before: AtomName) -> AtomName {
        let name = trimmed(&self.names[parent]);
        let suffix = name.get(self.elements[parent].symbol().len()..).unwrap_or_default();
        let count = self.hydrogens[parent].max(1);
        let digit = |n: u8| if n < 10 { b'0' + n } else { b'0' };
        let letter = |n: u8| b'A' + n % 26;
        let named = |stem: &[u8], end: &[u8]| {
            let mut out = [0; 4];
            for (slot, &byte) in out.iter_mut().zip([b"H", stem, end].into_iter().flatten()) {
                *slot = byte;
            }
            out
        };
        match which {
            0 => named(suffix, &[]),
            1 => named(suffix, &[digit(count)]),
            2 => named(suffix, &[digit(count.saturating_add(1))]),
            3 => named(name, &[]),
            4 => named(name, &[digit(count)]),
            5 => named(suffix, &[letter(count - 1)]),
            6 if count < 2 => named(suffix, &[]),
            6 => named(suffix, &[letter(count - 2)]),
            7 => counted_on(before),
            8 => stepped(before),
            _ => [0; 4],
        }
    }

    /// Tells the name of the atom that was next.
    pub(super) fn named(&mut self, name: AtomName, element: Element) {
        self.names.push(name);
        self.elements.push(element);
        self.hydrogens.push(0);
        self.last.retain(|last| last.0 != element);
        self.last.insert(0, (element, name));
    }
}

fn trimmed(name: &AtomName) -> &[u8] {
    &name[..name.iter().position(|&byte| byte == 0).unwrap_or(name.len())]
}

/// Where the last number of a name is.
fn digits(name: &[u8]) -> Option<std::ops::Range<usize>> {
    let end = name.iter().rposition(u8::is_ascii_digit)? + 1;
    let start = name[..end].iter().rposition(|byte| !byte.is_ascii_digit()).map_or(0, |at| at + 1);
    Some(start..end)
}

fn value(digits: &[u8]) -> u32 {
    digits.iter().fold(0, |value, digit| value * 10 + u32::from(digit - b'0'))
}

fn number_of(name: AtomName) -> Option<u32> {
    let name = trimmed(&name);
    digits(name).map(|range| value(&name[range]))
}

/// A text and a number, cut to four bytes.
fn joined(text: &[u8], number: u32) -> AtomName {
    let mut out = [0; 4];
    for (slot, byte) in out.iter_mut().zip(text.iter().copied().chain(number.to_string().bytes())) {
        *slot = byte;
    }
    out
}

/// The name with its last number one higher; empty if it has none or gets too long.
fn counted_on(name: AtomName) -> AtomName {
    let name = trimmed(&name);
    let Some(range) = digits(name) else { return [0; 4] };
    let next = (value(&name[range.clone()]) + 1).to_string();
    let text = [&name[..range.start], next.as_bytes(), &name[range.end..]].concat();
    super::padded(&text).unwrap_or_default()
}

/// The name with its last byte one higher.
fn stepped(mut name: AtomName) -> AtomName {
    let length = trimmed(&name).len();
    if let Some(last) = length.checked_sub(1) {
        name[last] = name[last].wrapping_add(1);
    }
    name
}
