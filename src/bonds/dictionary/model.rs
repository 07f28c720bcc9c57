//! What is usual in a component, and the streams that hold what is not.

use super::{AtomName, DictionaryBond};
use crate::element::Element;
use crate::structure::BondOrder;

/// The streams of a block. All are varints, but for those of bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stream {
    /// Bytes. Ids: four bits of how many bytes are as before, four of how many follow, these.
    Id,
    /// The number of atoms.
    Count,
    /// Elements ([`element_code`]), two bytes a run: which, and how many atoms in a row.
    Element,
    /// How many atoms the partner of a hydrogen is after that of the hydrogen before (zigzag), plus one.
    Parent,
    /// Bonds to earlier atoms: three bits of order, above them how many atoms back.
    Bond,
    /// Bytes. Which guess of [`Namer`] is the name, from 1; 0 for none.
    NameGuess,
    /// Bytes. The lower half of the name's number.
    NameLow,
    /// Bytes. The upper half of the name's number.
    NameHigh,
    /// How many atoms have a charge, then for each its number and the charge (zigzag).
    Charge,
}

impl Stream {
    pub(super) const COUNT: usize = 9;
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
pub(super) fn unzigzag(number: u64) -> i64 {
    ((number >> 1) as i64) ^ -((number & 1) as i64)
}

/// The inverse of [`unzigzag`].
#[cfg(test)]
pub(super) fn zigzag(number: i64) -> u64 {
    ((number << 1) ^ (number >> 63)) as u64
}

/// Orders of bonds, 1 and up: single, double, triple, and the same aromatic.
const ORDERS: [BondOrder; 3] = [BondOrder::Single, BondOrder::Double, BondOrder::Triple];

/// The bond of an atom that a number in [`Stream::Bond`] stands for.
pub(super) fn bond(atom: u16, number: u64) -> Option<DictionaryBond> {
    let kind = (number & 7) as usize;
    let back = u16::try_from(number >> 3).ok()?;
    let order = *ORDERS.get(kind.checked_sub(1)? % 3)?;
    let a = atom.checked_sub(back).filter(|_| back > 0)?;
    (kind <= 6).then_some(DictionaryBond { a, b: atom, order, aromatic: kind > 3 })
}

/// The inverse of [`bond`].
#[cfg(test)]
pub(super) fn bond_number(bond: &DictionaryBond) -> u64 {
    u64::from(bond.b - bond.a) << 3 | u64::from(bond.order.number() + 3 * u8::from(bond.aromatic))
}

/// Reads the streams of a block.
pub(super) struct Reader<'a> {
    streams: [&'a [u8]; Stream::COUNT],
    /// Components of the block.
    pub(super) count: u64,
    /// The run of elements being read: code, and how many are left.
    run: (u8, u8),
}

impl<'a> Reader<'a> {
    /// Finds the streams; `None` if the lengths do not fit.
    pub(super) fn new(mut bytes: &'a [u8]) -> Option<Reader<'a>> {
        let count = varint(&mut bytes)?;
        let mut lengths = [0; Stream::COUNT];
        for length in &mut lengths {
            *length = usize::try_from(varint(&mut bytes)?).ok()?;
        }
        let mut streams: [&[u8]; Stream::COUNT] = [&[]; Stream::COUNT];
        for (stream, length) in streams.iter_mut().zip(lengths) {
            (*stream, bytes) = bytes.split_at_checked(length)?;
        }
        Some(Reader { streams, count, run: (0, 0) })
    }

    /// The next byte of a stream.
    pub(super) fn byte(&mut self, stream: Stream) -> Option<u8> {
        let stream = &mut self.streams[stream as usize];
        let (&byte, rest) = stream.split_first()?;
        *stream = rest;
        Some(byte)
    }

    /// The next varint of a stream.
    pub(super) fn number(&mut self, stream: Stream) -> Option<u64> {
        varint(&mut self.streams[stream as usize])
    }

    /// The code of the next atom's element.
    pub(super) fn element(&mut self) -> Option<u8> {
        if self.run.1 == 0 {
            self.run = (self.byte(Stream::Element)?, self.byte(Stream::Element)?.checked_sub(1)?);
        } else {
            self.run.1 -= 1;
        }
        Some(self.run.0)
    }
}

fn varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut number = 0;
    for shift in (0..63).step_by(7) {
        let (&byte, rest) = bytes.split_first()?;
        *bytes = rest;
        number |= u64::from(byte & 127) << shift;
        if byte < 128 {
            return Some(number);
        }
    }
    None
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
