//! The wwPDB Chemical Component Dictionary: the atoms and bonds of every residue and ligand of the Protein Data Bank.
//!
//! `data/ccd.bin` is part of the program: 48,439 components in 3.7 MB. It is made from a text of the dictionary by the
//! ignored test `make_the_dictionary` (see `data/README.md`), and nothing of it is unpacked before it is asked for.
//!
//! # The format
//!
//! Numbers are little-endian; a *varint* has seven bits a byte, the lowest first.
//!
//! ```text
//! 8 bytes  b"bstkccd1"
//! u32 × 4  components, blocks, atom names, bytes of the deflated atom names
//! blocks × (5 bytes: the first component's id, filled with zeros; u32: where its block begins behind the names)
//! the atom names, most used first, each followed by a line feed, deflated
//! the blocks, each of 64 components in the order of their ids, deflated
//! ```
//!
//! Inside a block each kind of number has a stream of its own ([`Stream`]), as that compresses best: varints with the
//! lengths of the streams come first. What is usual is predicted and costs a byte that is always the same: a hydrogen
//! is named after the atom it is on, other names count on from the one before ([`model`]), and bonds are given with the
//! later of their atoms, as the distance back to the earlier one.
//!
//! Looking a component up takes a binary search over 757 blocks, and the first time at most 0.25 ms to unpack its block;
//! components that were asked for stay at hand.
//!
//! Source: wwPDB, <https://www.wwpdb.org/data/ccd>, public domain (CC0 1.0).

#[cfg(test)]
mod encode;
mod model;
#[cfg(test)]
mod tests;

use crate::element::Element;
use crate::structure::BondOrder;
use flate2::read::DeflateDecoder;
use model::{Namer, Reader, Stream};
use std::collections::HashMap;
use std::io::Read;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

/// An atom name of the dictionary: up to four bytes, filled with zeros.
pub(super) type AtomName = [u8; 4];
/// A component id: up to five bytes, filled with zeros.
type ComponentId = [u8; 5];

const MAGIC: &[u8; 8] = b"bstkccd1";
const HEADER_BYTES: usize = 24;
const INDEX_BYTES: usize = 9;
/// A block is some 12 kB unpacked; nothing that claims more is unpacked.
const MOST_BLOCK_BYTES: u64 = 1 << 20;
/// Components at hand before all are forgotten: more than any entry of the Protein Data Bank has.
const MOST_AT_HAND: usize = 1024;
/// The largest component has 440 atoms.
const MOST_ATOMS: u64 = 4096;

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
    names: Vec<AtomName>,
    /// [`INDEX_BYTES`] for each block.
    index: &'a [u8],
    blocks: &'a [u8],
    #[cfg(test)]
    component_count: usize,
}

impl<'a> Dictionary<'a> {
    /// Reads what stands before the blocks; `None` if these bytes are no dictionary.
    fn open(bytes: &'a [u8]) -> Option<Dictionary<'a>> {
        let number = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?) as usize);
        if !bytes.starts_with(MAGIC) {
            return None;
        }
        let (block_count, name_count, name_bytes) = (number(12)?, number(16)?, number(20)?);
        let names_at = HEADER_BYTES.checked_add(block_count.checked_mul(INDEX_BYTES)?)?;
        let index = bytes.get(HEADER_BYTES..names_at)?;
        let (packed_names, blocks) = bytes.get(names_at..)?.split_at_checked(name_bytes)?;
        let text = inflated(packed_names)?;
        let names: Vec<AtomName> =
            text.split(|&byte| byte == b'\n').filter(|name| !name.is_empty()).map_while(padded).collect();
        (names.len() == name_count).then_some(Dictionary {
            names,
            index,
            blocks,
            #[cfg(test)]
            component_count: number(8)?,
        })
    }

    /// The component of an id.
    fn find(&self, id: ComponentId) -> Option<Component> {
        let entries = self.index.chunks_exact(INDEX_BYTES);
        let (mut low, mut high) = (0, entries.len());
        while low < high {
            let middle = usize::midpoint(low, high);
            let first = &self.index[middle * INDEX_BYTES..][..size_of::<ComponentId>()];
            if first <= id.as_slice() { low = middle + 1 } else { high = middle }
        }
        let mut found = None;
        self.read_block(low.checked_sub(1)?, |here, component| {
            found = (here == id).then(|| std::mem::take(component));
            here < id
        })?;
        found
    }

    /// Unpacks a block and hands its components over one by one, as long as `next` says so. `None` if it is damaged.
    fn read_block(&self, block: usize, mut next: impl FnMut(ComponentId, &mut Component) -> bool) -> Option<()> {
        let start_of = |block: usize| {
            let entry = self.index.get(block * INDEX_BYTES..(block + 1) * INDEX_BYTES)?;
            Some(u32::from_le_bytes(entry.get(size_of::<ComponentId>()..)?.try_into().ok()?) as usize)
        };
        let start = start_of(block)?;
        let end = start_of(block + 1).unwrap_or(self.blocks.len());
        let bytes = inflated(self.blocks.get(start..end)?)?;
        let mut reader = Reader::new(&bytes)?;
        let mut id = Vec::with_capacity(size_of::<ComponentId>());
        for _ in 0..reader.count {
            let lengths = reader.byte(Stream::Id)?;
            id.truncate(usize::from(lengths >> 4));
            for _ in 0..lengths & 15 {
                id.push(reader.byte(Stream::Id)?);
            }
            let mut component = read_component(&mut reader, &self.names)?;
            if !next(padded(&id)?, &mut component) {
                break;
            }
        }
        Some(())
    }
}

fn inflated(packed: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(packed.len().saturating_mul(4).min(1 << 16));
    DeflateDecoder::new(packed).take(MOST_BLOCK_BYTES).read_to_end(&mut bytes).ok()?;
    Some(bytes)
}

fn read_component(reader: &mut Reader<'_>, names: &[AtomName]) -> Option<Component> {
    let mut component = Component::default();
    let count = reader.number(Stream::Count)?;
    if count > MOST_ATOMS {
        return None;
    }
    let mut namer = Namer::default();
    let mut last_parent = 0i64;
    for atom in 0..count as u16 {
        let (element, deuterium) = model::element_of(reader.element()?)?;
        let first_bond = component.bonds.len();
        let mut bonds_in_general = true;
        if element == Element::H {
            // 0 is not as usual, else a single bond, so many atoms after the parent of the hydrogen before.
            let step = reader.number(Stream::Parent)?;
            if let Some(step) = step.checked_sub(1) {
                last_parent = last_parent.checked_add(model::unzigzag(step))?;
                let parent = u16::try_from(last_parent).ok().filter(|&parent| parent < atom)?;
                component.bonds.push(DictionaryBond { a: parent, b: atom, order: BondOrder::Single, aromatic: false });
                bonds_in_general = false;
            }
        }
        if bonds_in_general {
            // With a kind it is the only bond; without one it says how many there are.
            let first = reader.number(Stream::Bond)?;
            if first & 7 != 0 {
                component.bonds.push(model::bond(atom, first)?);
            } else {
                for _ in 0..first >> 3 {
                    component.bonds.push(model::bond(atom, reader.number(Stream::Bond)?)?);
                }
            }
        }
        let parent = (component.bonds.len() == first_bond + 1).then(|| component.bonds[first_bond].a);
        namer.next(element, parent);
        let name = match reader.byte(Stream::NameGuess)? {
            0 => {
                let low = reader.byte(Stream::NameLow)?;
                let high = reader.byte(Stream::NameHigh)?;
                *names.get(usize::from(u16::from_le_bytes([low, high])))?
            }
            guess if guess <= Namer::GUESSES => namer.guess(guess - 1, element, parent),
            _ => return None,
        };
        namer.named(name, element);
        component.atoms.push(ComponentAtom { name, element, deuterium, charge: 0 });
    }
    for _ in 0..reader.number(Stream::Charge)? {
        let atom = usize::try_from(reader.number(Stream::Charge)?).ok()?;
        let charge = i8::try_from(model::unzigzag(reader.number(Stream::Charge)?)).ok()?;
        component.atoms.get_mut(atom)?.charge = charge;
    }
    component.bonds.sort_unstable();
    Some(component)
}
