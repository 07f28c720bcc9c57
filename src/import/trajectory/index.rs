//! Where the frames of a trajectory begin.
//!
//! Frames of XTC and TRR files differ in length, so that the place of one is known only from all before it. The index goes over
//! their headers, as far as it is asked for, and notes every frame, then, when [`MOST_MARKS`] are full, every second, fourth, …:
//! its memory is bounded whatever the number of frames, and a frame between two marks is a few headers away.

use crate::error::Result;

/// Offsets that are kept at most (half a megabyte; a microsecond's simulation at every 10 ps has 100,000 frames, so that even there
/// only one header lies between two marks).
const MOST_MARKS: usize = 1 << 16;

/// What stands at a place of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    /// A frame up to this offset.
    Frame { end: u64 },
    /// A frame without positions up to this offset, which counts as none.
    Other { end: u64 },
    /// The end of the file.
    End,
    /// A frame that the file ends in.
    Cut,
    /// No frame of this trajectory.
    Damaged(&'static str),
}

/// Why the frames end where they do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ending {
    Clean,
    Cut,
    Damaged { offset: u64, what: &'static str },
}

/// The frames found so far.
#[derive(Debug)]
pub(super) struct Index {
    /// Offset of every `stride`-th frame.
    marks: Vec<u64>,
    stride: usize,
    count: usize,
    /// Where the next frame would begin.
    next: u64,
    ending: Option<Ending>,
    /// The frame that was asked for last, and its offset.
    last: (usize, u64),
    most_marks: usize,
}

impl Index {
    /// Nothing yet; the first frame begins at `start`.
    pub(super) fn new(start: u64) -> Index {
        Index {
            marks: Vec::new(),
            stride: 1,
            count: 0,
            next: start,
            ending: None,
            last: (usize::MAX, 0),
            most_marks: MOST_MARKS,
        }
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// How the frames end, once that is known.
    pub(super) fn ending(&self) -> Option<Ending> {
        self.ending
    }

    /// Goes on until `frames` are known, or all.
    pub(super) fn extend(&mut self, frames: usize, step: &dyn Fn(u64) -> Result<Step>) -> Result<()> {
        while self.count < frames && self.ending.is_none() {
            match step(self.next)? {
                // A header that leads nowhere would be met for ever.
                Step::Frame { end } | Step::Other { end } if end <= self.next => {
                    self.ending = Some(Ending::Damaged { offset: self.next, what: "a frame without length" });
                }
                Step::Frame { end } => {
                    if self.count.is_multiple_of(self.stride) {
                        self.mark();
                    }
                    self.count += 1;
                    self.next = end;
                }
                Step::Other { end } => self.next = end,
                Step::End => self.ending = Some(Ending::Clean),
                Step::Cut => self.ending = Some(Ending::Cut),
                Step::Damaged(what) => self.ending = Some(Ending::Damaged { offset: self.next, what }),
            }
        }
        Ok(())
    }

    fn mark(&mut self) {
        if self.marks.len() >= self.most_marks {
            let mut number = 0;
            self.marks.retain(|_| {
                number += 1;
                number % 2 == 1
            });
            self.stride *= 2;
            if !self.count.is_multiple_of(self.stride) {
                return;
            }
        }
        self.marks.push(self.next);
    }

    /// Where a frame begins; `None` if there is none of this number (as far as the index goes).
    pub(super) fn offset(&mut self, frame: usize, step: &dyn Fn(u64) -> Result<Step>) -> Result<Option<u64>> {
        if frame >= self.count {
            return Ok(None);
        }
        let mark = frame / self.stride;
        let Some(&marked) = self.marks.get(mark) else { return Ok(None) };
        let (mut at, mut offset) = (mark * self.stride, marked);
        if (at..=frame).contains(&self.last.0) {
            (at, offset) = self.last;
        }
        loop {
            match step(offset)? {
                Step::Frame { .. } if at == frame => {
                    self.last = (at, offset);
                    return Ok(Some(offset));
                }
                Step::Frame { end } => (at, offset) = (at + 1, end),
                Step::Other { end } => offset = end,
                // The file has changed since.
                Step::End | Step::Cut | Step::Damaged(_) => return Ok(None),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frame k has 10 + k % 7 bytes; every fifth thing is no frame; 1000 things.
    fn step(offset: u64) -> Result<Step> {
        let (mut at, mut thing) = (0, 0u64);
        while at < offset {
            at += 10 + thing % 7;
            thing += 1;
        }
        assert_eq!(at, offset, "only places where something begins are asked for");
        let end = at + 10 + thing % 7;
        Ok(match thing {
            1000 => Step::Cut,
            _ if thing % 5 == 4 => Step::Other { end },
            _ => Step::Frame { end },
        })
    }

    #[test]
    fn marks_are_few_and_every_frame_is_found() {
        let mut all = Index::new(0);
        all.extend(usize::MAX, &step).unwrap();
        assert_eq!((all.count(), all.ending()), (800, Some(Ending::Cut)));
        let mut few = Index { most_marks: 16, ..Index::new(0) };
        few.extend(10, &step).unwrap();
        assert_eq!((few.count(), few.ending()), (10, None));
        few.extend(usize::MAX, &step).unwrap();
        assert!(few.marks.len() <= 16 && few.count() == 800);
        for frame in (0..800).chain([799, 3, 400, 401, 399]) {
            assert_eq!(few.offset(frame, &step).unwrap(), Some(all.marks[frame]), "{frame}");
        }
        assert_eq!(few.offset(800, &step).unwrap(), None);
    }

    #[test]
    fn a_header_that_leads_nowhere_ends_the_frames() {
        let mut index = Index::new(5);
        index
            .extend(usize::MAX, &|offset| Ok(Step::Frame { end: if offset < 20 { offset + 5 } else { offset } }))
            .unwrap();
        assert_eq!(
            (index.count(), index.ending()),
            (3, Some(Ending::Damaged { offset: 20, what: "a frame without length" }))
        );
    }
}
