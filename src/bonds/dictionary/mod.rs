//! The wwPDB Chemical Component Dictionary: the atoms and bonds of every residue and ligand of the Protein Data Bank.
//!
//! `data/ccd.bin` is part of the program: 48,439 components in 3.2 MB. It is made from a text of the dictionary by the
//! ignored test `make_the_dictionary` (see `data/README.md`), and nothing of it is unpacked before it is asked for.
//!
//! # The format
//!
//! Numbers are little-endian.
//!
//! ```text
//! 8 bytes  b"bstkccd2"
//! u32 × 4  components, atom names, contexts, symbols
//! the atom names, most used first: 4 bytes, filled with zeros
//! (contexts + 1) × u32: where a context's symbols begin
//! the symbols: u16, and u16: the sum of the frequencies before it in its context
//! components × (5 bytes: the id, filled with zeros, in their order; u32: where it begins behind these)
//! the components
//! ```
//!
//! A component is a row of symbols, each coded in as many bits as it is surprising where it stands ([`coder`]). What is
//! usual is predicted: a hydrogen is named after the atom it is on, other names count on from the one before ([`model`]),
//! and bonds are given with the later of their atoms, as the distance back to the earlier one.
//!
//! Looking a component up takes a binary search over their ids, and the first time its decoding; components that were asked
//! for stay at hand. Measured for all components in random order, on one core of a shared Intel Xeon server of the 2020s: 21 µs
//! the first time on average (48 atoms), 19 µs in the median, 55 µs for 99 of 100.
//!
//! Source: wwPDB, <https://www.wwpdb.org/data/ccd>, public domain (CC0 1.0).

mod coder;
#[cfg(test)]
mod encode;
mod model;
#[cfg(test)]
mod tests;

use crate::element::Element;
use crate::structure::BondOrder;
use coder::{BEGIN_BYTES, Decoder, SYMBOL_BYTES, Tables};
use model::{Contexts, Namer};
use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

/// An atom name of the dictionary: up to four bytes, filled with zeros.
pub(super) type AtomName = [u8; 4];
/// A component id: up to five bytes, filled with zeros.
type ComponentId = [u8; 5];

const MAGIC: &[u8; 8] = b"bstkccd2";
const HEADER_BYTES: usize = 24;
const NAME_BYTES: usize = size_of::<AtomName>();
const INDEX_BYTES: usize = 9;
/// Components at hand before all are forgotten: more than any entry of the Protein Data Bank has.
const MOST_AT_HAND: usize = 1024;
/// The largest component has 440 atoms.
const MOST_ATOMS: u16 = 4096;

/// An atom of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ComponentAtom {
    pub(super) name: AtomName,
    /// Element; a dummy where the dictionary has X.
    pub(super) element: Element,
    /// Whether the dictionary has D for it.
    pub(super) deuterium: bool,
    pub(super) charge: i8,
}

/// A bond of a component, by the numbers of its atoms: `a < b`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct DictionaryBond {
    pub(super) a: u16,
    pub(super) b: u16,
    pub(super) order: BondOrder,
    pub(super) aromatic: bool,
}

/// A component: its atoms in the order of the dictionary, its bonds sorted by atoms.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Component {
    pub(super) atoms: Vec<ComponentAtom>,
    pub(super) bonds: Vec<DictionaryBond>,
}

/// Text in so many bytes, filled with zeros.
fn padded<const N: usize>(text: &[u8]) -> Option<[u8; N]> {
    let mut out = [0; N];
    out.get_mut(..text.len())?.copy_from_slice(text);
    (!text.is_empty() && !text.contains(&0)).then_some(out)
}

/// The component of an id; `None` if there is none of that id.
pub(super) fn component(id: &str) -> Option<Arc<Component>> {
    type AtHand = HashMap<ComponentId, Option<Arc<Component>>>;
    static AT_HAND: LazyLock<Mutex<AtHand>> = LazyLock::new(Mutex::default);
    let id: ComponentId = padded(id.as_bytes())?;
    let at_hand = || AT_HAND.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(found) = at_hand().get(&id) {
        return found.clone();
    }
    let found = EMBEDDED.as_ref().and_then(|dictionary| dictionary.find(id)).map(Arc::new);
    let mut at_hand = at_hand();
    if at_hand.len() >= MOST_AT_HAND {
        at_hand.clear();
    }
    at_hand.insert(id, found.clone());
    found
}

/// The dictionary that is part of the program.
static EMBEDDED: LazyLock<Option<Dictionary<'static>>> =
    LazyLock::new(|| Dictionary::open(include_bytes!("../../../data/ccd.bin")));

/// A dictionary in its packed form.
struct Dictionary<'a> {
    /// Atom names, the most used first.
    names: &'a [AtomName],
    tables: Tables<'a>,
    /// Id and beginning of each component.
    index: &'a [[u8; INDEX_BYTES]],
    components: &'a [u8],
}

impl<'a> Dictionary<'a> {
    /// Finds the parts; `None` if these bytes are no dictionary.
    fn open(bytes: &'a [u8]) -> Option<Dictionary<'a>> {
        let number = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?) as usize);
        if !bytes.starts_with(MAGIC) || number(16)? != Contexts::ALL {
            return None;
        }
        let mut rest = bytes.get(HEADER_BYTES..)?;
        let mut part = |count: usize, size: usize| {
            let (part, behind) = rest.split_at_checked(count.checked_mul(size)?)?;
            rest = behind;
            Some(part)
        };
        let names = part(number(12)?, NAME_BYTES)?.as_chunks().0;
        let begins = part(Contexts::ALL + 1, BEGIN_BYTES)?;
        let symbols = part(number(20)?, SYMBOL_BYTES)?;
        let index = part(number(8)?, INDEX_BYTES)?.as_chunks().0;
        Some(Dictionary { names, tables: Tables { begins, symbols }, index, components: rest })
    }

    /// The component of an id.
    fn find(&self, id: ComponentId) -> Option<Component> {
        self.read(self.index.binary_search_by(|entry| id_of(entry).cmp(&id)).ok()?)
    }

    /// The component of a number; `None` if it is damaged.
    fn read(&self, number: usize) -> Option<Component> {
        let begin = |number: usize| {
            let [.., a, b, c, d] = *self.index.get(number)?;
            Some(u32::from_le_bytes([a, b, c, d]) as usize)
        };
        let end = begin(number + 1).unwrap_or(self.components.len());
        read_component(&mut Decoder::new(self.components.get(begin(number)?..end)?, self.tables)?, self.names)
    }
}

fn id_of(entry: &[u8; INDEX_BYTES]) -> ComponentId {
    let [a, b, c, d, e, ..] = *entry;
    [a, b, c, d, e]
}

fn read_component(decoder: &mut Decoder<'_>, names: &[AtomName]) -> Option<Component> {
    let count = decoder.symbol(Contexts::COUNT).filter(|&count| count <= MOST_ATOMS)?;
    let room = usize::from(count);
    let mut component = Component { atoms: Vec::with_capacity(room), bonds: Vec::with_capacity(room) };
    let (mut contexts, mut namer) = (Contexts::default(), Namer::default());
    let mut last_parent = 0i32;
    for atom in 0..count {
        let code = u8::try_from(decoder.symbol(contexts.element())?).ok()?;
        contexts.met_element(code);
        let (element, deuterium) = model::element_of(code)?;
        let first_bond = component.bonds.len();
        let mut bonds_in_general = true;
        if element == Element::H {
            // 0 is not as usual, else a single bond, so many atoms after the parent of the hydrogen before.
            let step = decoder.symbol(contexts.parent())?;
            contexts.met_parent(step);
            if let Some(step) = step.checked_sub(1) {
                last_parent = last_parent.checked_add(model::unzigzag(step))?;
                let parent = u16::try_from(last_parent).ok().filter(|&parent| parent < atom)?;
                component.bonds.push(DictionaryBond { a: parent, b: atom, order: BondOrder::Single, aromatic: false });
                bonds_in_general = false;
            }
        }
        if bonds_in_general {
            let mut next = || {
                let number = decoder.symbol(contexts.bond())?;
                contexts.met_bond(number);
                Some(number)
            };
            // With a kind it is the only bond; without one it says how many there are.
            let first = next()?;
            if first & 7 != 0 {
                component.bonds.push(model::bond(atom, first)?);
            } else {
                for _ in 0..first >> 3 {
                    component.bonds.push(model::bond(atom, next()?)?);
                }
            }
        }
        let parent = (component.bonds.len() == first_bond + 1).then(|| component.bonds[first_bond].a);
        namer.next(element, parent);
        let guess = u8::try_from(decoder.symbol(contexts.guess())?).ok()?;
        let name = match guess {
            0 => *names.get(usize::from(decoder.symbol(contexts.name())?))?,
            guess if guess <= Namer::GUESSES => namer.guess(guess - 1, element, parent),
            _ => return None,
        };
        contexts.met_guess(guess);
        namer.named(name, element);
        component.atoms.push(ComponentAtom { name, element, deuterium, charge: 0 });
    }
    for _ in 0..decoder.symbol(Contexts::CHARGES)? {
        let atom = usize::from(decoder.symbol(Contexts::CHARGED)?);
        let charge = i8::try_from(model::unzigzag(decoder.symbol(Contexts::CHARGE)?)).ok()?;
        component.atoms.get_mut(atom)?.charge = charge;
    }
    component.bonds.sort_unstable();
    Some(component)
}
