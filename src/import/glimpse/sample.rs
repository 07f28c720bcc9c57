//! Lines of many small blocks of a file.

use crate::import::file::read_exact_at;
use std::fs::File;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Bytes of a block: a page of most systems.
const BLOCK_BYTES: usize = 4 << 10;
/// Blocks as a power of two (chosen: a disk that takes 0.1 ms for each gives them in 0.2 s, one after another).
const BLOCKS_LOG2: u32 = 11;
/// Threads that read them (chosen: disks that take longest for one block take many at once).
const READERS: usize = 16;
/// With fewer blocks there is no picture (chosen: a sixteenth of them; what is missing is missed evenly).
const LEAST_BLOCKS: usize = 1 << (BLOCKS_LOG2 - 4);
/// What has no more bytes is read as a whole.
pub(super) const WHOLE_BYTES: u64 = (BLOCK_BYTES as u64) << BLOCKS_LOG2;
/// At most about so many atoms are kept (chosen: a closed surface in a window, drawn in no time).
pub(super) const MOST_ATOMS: usize = 50_000;
/// So many lines without an atom are not among atoms any more.
const MOST_OTHERS: usize = 8;
/// Bytes that are searched at a time.
const SEARCHED_BYTES: usize = 1 << 20;

/// Bytes that can be read at any place.
pub(super) trait Bytes: Sync {
    fn len(&self) -> u64;

    /// Fills `bytes` from a place on; `None` if there are not as many.
    fn read(&self, offset: u64, bytes: &mut [u8]) -> Option<()>;

    /// So many bytes from a place on, or all that there are.
    fn some(&self, offset: u64, most: usize) -> Option<Vec<u8>> {
        let there = usize::try_from(self.len().checked_sub(offset)?).unwrap_or(usize::MAX);
        let mut bytes = vec![0; most.min(there)];
        self.read(offset, &mut bytes)?;
        Some(bytes)
    }
}

/// A file as it was when it was opened.
pub(super) struct FileBytes {
    file: File,
    size: u64,
}

impl FileBytes {
    pub(super) fn new(file: File, size: u64) -> FileBytes {
        FileBytes { file, size }
    }
}

impl Bytes for FileBytes {
    fn len(&self) -> u64 {
        self.size
    }

    fn read(&self, offset: u64, bytes: &mut [u8]) -> Option<()> {
        read_exact_at(&self.file, bytes, offset).ok()
    }
}

/// What a line is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Line {
    Atom,
    Other,
    /// Behind the atoms.
    End,
}

/// Atom lines of a file.
#[derive(Debug, Default)]
pub(super) struct Sample {
    pub(super) text: Vec<u8>,
    /// How many they are.
    pub(super) atoms: usize,
    /// How many were seen.
    pub(super) seen: usize,
    /// Bytes of the lines that were seen.
    bytes: u64,
    /// Where they end, as far as was seen.
    pub(super) end: u64,
}

impl Sample {
    /// Bytes that an atom takes, with the lines between.
    pub(super) fn bytes_an_atom(&self) -> f64 {
        self.bytes as f64 / self.seen as f64
    }
}

pub(super) fn is_late(deadline: Option<Instant>) -> bool {
    deadline.is_some_and(|deadline| Instant::now() > deadline)
}

/// Takes lines of a part of a file that begins where a line does. `None` if there is no atom, or it takes too long.
pub(super) fn sample(
    source: &dyn Bytes,
    part: Range<u64>,
    deadline: Option<Instant>,
    mut judge: impl FnMut(&[u8]) -> Line,
) -> Option<Sample> {
    let length = part.end.checked_sub(part.start)?;
    let mut blocks: Vec<(u64, Vec<u8>)> = Vec::new();
    if length <= WHOLE_BYTES {
        blocks.push((part.start, source.some(part.start, usize::try_from(length).ok()?)?));
    } else {
        let step = (length - BLOCK_BYTES as u64) / ((1 << BLOCKS_LOG2) - 1);
        blocks = read_blocks(source, |number| part.start + number * step, deadline);
        if blocks.len() < LEAST_BLOCKS {
            return None;
        }
        blocks.sort_unstable_by_key(|(offset, _)| *offset);
    }
    let most = if length <= WHOLE_BYTES { MOST_ATOMS } else { MOST_ATOMS >> BLOCKS_LOG2 };
    let mut sample = Sample { end: part.end, ..Sample::default() };
    for (offset, block) in blocks {
        if let Some(at) = sample.take(&block, offset == part.start, most, &mut judge) {
            sample.end = offset + at as u64;
            break;
        }
    }
    (sample.atoms > 0).then_some(sample)
}

/// Blocks at the places of numbers below the number of blocks, on several threads, as disks serve many readers faster than one. Those
/// that cannot be read are missing.
fn read_blocks(
    source: &dyn Bytes,
    place: impl Fn(u64) -> u64 + Sync,
    deadline: Option<Instant>,
) -> Vec<(u64, Vec<u8>)> {
    let (turns, blocks) = (AtomicU64::new(0), Mutex::new(Vec::new()));
    let read = || {
        let mut own = Vec::new();
        loop {
            let turn = turns.fetch_add(1, Ordering::Relaxed);
            if turn >= 1 << BLOCKS_LOG2 || is_late(deadline) {
                break;
            }
            // Every second one after every fourth one, and so on: whenever it ends they are spread evenly.
            let offset = place(turn.reverse_bits() >> (u64::BITS - BLOCKS_LOG2));
            let mut block = vec![0; BLOCK_BYTES];
            if source.read(offset, &mut block).is_some() {
                own.push((offset, block));
            }
        }
        blocks.lock().unwrap_or_else(PoisonError::into_inner).append(&mut own);
    };
    std::thread::scope(|scope| {
        for _ in 1..READERS {
            // This thread reads as well, and alone if there are no others to be had.
            let _ = std::thread::Builder::new().name("glimpse".to_owned()).spawn_scoped(scope, read);
        }
        read();
    });
    blocks.into_inner().unwrap_or_else(PoisonError::into_inner)
}

impl Sample {
    /// Takes lines of a block, so many at most; where the atoms end if they do.
    fn take(
        &mut self,
        block: &[u8],
        is_first: bool,
        most: usize,
        judge: &mut impl FnMut(&[u8]) -> Line,
    ) -> Option<usize> {
        let start = match (is_first, memchr::memchr(b'\n', block)) {
            (true, _) => 0,
            (false, Some(end)) => end + 1,
            (false, None) => return None,
        };
        let (mut atoms, mut others, mut at, mut is_over) = (Vec::new(), 0, start, false);
        for end in memchr::memchr_iter(b'\n', &block[start..]).map(|end| start + end) {
            match judge(&block[at..end]) {
                Line::Atom => atoms.push(at..=end),
                Line::Other => others += 1,
                Line::End => {
                    is_over = true;
                    break;
                }
            }
            at = end + 1;
        }
        self.seen += atoms.len();
        self.bytes += (at - start) as u64;
        let stride = atoms.len().div_ceil(most).max(1);
        for line in atoms.iter().step_by(stride) {
            self.text.extend_from_slice(&block[line.clone()]);
            self.atoms += 1;
        }
        (is_over || atoms.is_empty() && others >= MOST_OTHERS).then_some(at)
    }
}

/// Where one of some texts is found first, each behind a line's end.
pub(super) enum Found {
    At(u64),
    Nowhere,
    /// It took too long.
    Late,
}

/// Looks for lines with these beginnings from a place on, in the line after it at the earliest.
pub(super) fn find(source: &dyn Bytes, from: u64, beginnings: &[&[u8]], deadline: Option<Instant>) -> Found {
    let longest = beginnings.iter().map(|text| text.len()).max().unwrap_or(0);
    let mut offset = from;
    loop {
        let Some(bytes) = source.some(offset, SEARCHED_BYTES) else { return Found::Nowhere };
        let is_it = |line: &[u8]| beginnings.iter().any(|beginning| line.starts_with(beginning));
        if let Some(end) = memchr::memchr_iter(b'\n', &bytes).find(|end| is_it(&bytes[end + 1..])) {
            return Found::At(offset + end as u64 + 1);
        }
        let is_last = offset + bytes.len() as u64 >= source.len();
        if is_last {
            return Found::Nowhere;
        }
        if is_late(deadline) {
            return Found::Late;
        }
        // What the pieces' border cuts is whole in the next one.
        offset += (bytes.len() - (longest + 1).min(bytes.len() - 1)) as u64;
    }
}
