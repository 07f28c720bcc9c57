//! Symbols as bytes and back: an asymmetric numeral system, by ranges (rANS).
//!
//! Duda, "Asymmetric numeral systems: entropy coding combining speed of Huffman coding with compression rate of
//! arithmetic coding", arXiv:1311.2540 (2013). Each symbol has a frequency in its context; a number that holds all
//! symbols so far grows by one over that frequency, and its low bytes go out as it passes 2³¹. What was coded last is
//! decoded first, so that the encoder goes backwards. The frequencies are those of the whole dictionary and stand in
//! front of it; hence any component can be decoded alone.

/// The frequencies in a context add up to 2 to this power.
const SCALE_BITS: u32 = 14;
const SCALE: u32 = 1 << SCALE_BITS;
/// The least number between two symbols.
const LOW: u32 = 1 << 23;

/// Where the symbols of a context begin: a u32.
pub(super) const BEGIN_BYTES: usize = 4;
/// A symbol and the sum of the frequencies before it: two u16.
pub(super) const SYMBOL_BYTES: usize = 4;

/// The symbols of all contexts with their frequencies.
#[derive(Clone, Copy)]
pub(super) struct Tables<'a> {
    /// [`BEGIN_BYTES`] for each context, and the end of the last.
    pub(super) begins: &'a [u8],
    /// [`SYMBOL_BYTES`] for each symbol.
    pub(super) symbols: &'a [u8],
}

impl<'a> Tables<'a> {
    fn of(&self, context: usize) -> Option<&'a [[u8; SYMBOL_BYTES]]> {
        let begin = |context: usize| Some(u32::from_le_bytes(*self.begins.as_chunks().0.get(context)?) as usize);
        self.symbols.as_chunks().0.get(begin(context)?..begin(context + 1)?)
    }
}

/// Reads symbols.
pub(super) struct Decoder<'a> {
    number: u32,
    rest: &'a [u8],
    tables: Tables<'a>,
}

impl<'a> Decoder<'a> {
    pub(super) fn new(bytes: &'a [u8], tables: Tables<'a>) -> Option<Decoder<'a>> {
        let (number, rest) = bytes.split_first_chunk()?;
        Some(Decoder { number: u32::from_be_bytes(*number), rest, tables })
    }

    /// The next symbol, which was coded in this context; `None` if the bytes are damaged.
    #[inline]
    pub(super) fn symbol(&mut self, context: usize) -> Option<u16> {
        let symbols = self.tables.of(context)?;
        let before = |[_, _, low, high]: &[u8; SYMBOL_BYTES]| u32::from(u16::from_le_bytes([*low, *high]));
        let slot = self.number & (SCALE - 1);
        let at = symbols.partition_point(|symbol| before(symbol) <= slot).checked_sub(1)?;
        let frequency = symbols.get(at + 1).map_or(SCALE, before).checked_sub(before(&symbols[at]))?;
        let high = frequency.wrapping_mul(self.number >> SCALE_BITS);
        self.number = high.wrapping_add(slot - before(&symbols[at]));
        while self.number < LOW {
            let (&byte, rest) = self.rest.split_first()?;
            self.number = self.number << 8 | u32::from(byte);
            self.rest = rest;
        }
        Some(u16::from_le_bytes([symbols[at][0], symbols[at][1]]))
    }
}

#[cfg(test)]
pub(super) mod encode {
    use super::{LOW, SCALE, SCALE_BITS, SYMBOL_BYTES};
    use std::collections::BTreeMap;

    /// A symbol and the context it stands in.
    pub(in super::super) type InContext = (usize, u16);

    /// Sum of the frequencies before, and the frequency, of each symbol in a context.
    #[derive(Default)]
    pub(in super::super) struct Frequencies(Vec<BTreeMap<u16, (u32, u32)>>);

    impl Frequencies {
        /// Counts how often each symbol stands in each of so many contexts.
        pub(in super::super) fn count<'s>(
            contexts: usize,
            symbols: impl Iterator<Item = &'s InContext>,
        ) -> Frequencies {
            let mut all = vec![BTreeMap::<u16, (u32, u32)>::new(); contexts];
            for &(context, symbol) in symbols {
                all[context].entry(symbol).or_default().1 += 1;
            }
            for context in &mut all {
                let total: u64 = context.values().map(|&(_, count)| u64::from(count)).sum();
                // One each, and of the rest in proportion.
                let rest = u64::from(SCALE) - context.len() as u64;
                let share = |count: u32| 1 + (u64::from(count) * rest / total) as u32;
                context.values_mut().for_each(|(_, count)| *count = share(*count));
                let given: u32 = context.values().map(|&(_, frequency)| frequency).sum();
                if let Some((_, most)) = context.values_mut().max_by_key(|(_, frequency)| *frequency) {
                    *most += SCALE - given;
                }
                let mut sum = 0;
                for (before, frequency) in context.values_mut() {
                    *before = sum;
                    sum += *frequency;
                }
            }
            Frequencies(all)
        }

        /// The two parts of [`super::Tables`].
        pub(in super::super) fn tables(&self) -> [Vec<u8>; 2] {
            let (mut begins, mut symbols) = (Vec::new(), Vec::new());
            for context in &self.0 {
                begins.extend(((symbols.len() / SYMBOL_BYTES) as u32).to_le_bytes());
                for (symbol, (before, _)) in context {
                    symbols.extend(symbol.to_le_bytes());
                    symbols.extend(u16::try_from(*before).expect("below the scale").to_le_bytes());
                }
            }
            begins.extend(((symbols.len() / SYMBOL_BYTES) as u32).to_le_bytes());
            [begins, symbols]
        }

        pub(in super::super) fn encode(&self, symbols: &[InContext]) -> Vec<u8> {
            let (mut number, mut out) = (LOW, Vec::new());
            for (context, symbol) in symbols.iter().rev() {
                let (before, frequency) = self.0[*context][symbol];
                while number >= ((LOW >> SCALE_BITS) << 8) * frequency {
                    out.push(number as u8);
                    number >>= 8;
                }
                number = ((number / frequency) << SCALE_BITS) + number % frequency + before;
            }
            out.extend(number.to_le_bytes());
            out.reverse();
            out
        }
    }
}

#[cfg(test)]
mod tests {
    use super::encode::Frequencies;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn symbols_come_back(symbols in proptest::collection::vec((0usize..3, prop_oneof![Just(7u16), 0u16..2000]), 0..500)) {
            let frequencies = Frequencies::count(3, symbols.iter());
            let [begins, table] = frequencies.tables();
            let bytes = frequencies.encode(&symbols);
            let mut decoder = Decoder::new(&bytes, Tables { begins: &begins, symbols: &table }).unwrap();
            for &(context, symbol) in &symbols {
                prop_assert_eq!(decoder.symbol(context), Some(symbol));
            }
            prop_assert!(decoder.rest.is_empty() && decoder.number == LOW);
        }
    }
}
