//! Undo and redo: whole states of the work, which share what is large.
//!
//! Molecules that were closed, or read again, stay as long as a step has them; so that a window in which one file after the other is looked
//! at does not grow, there are never more than [`MOST_CLOSED`] of them, nor more than [`MOST_BYTES`] but for the last.

use super::work::Work;
use crate::import::Document;
use crate::structure::Structure;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Steps that are kept; what they hold of molecules is shared, so that only closed files cost memory.
const MOST_STEPS: usize = 200;
/// Closed molecules that undo can bring back (chosen: more than anybody goes back to).
const MOST_CLOSED: usize = 8;
/// What they may take together; the one closed last may take more.
const MOST_BYTES: usize = 256 << 20;
/// Changes of one kind are one step if no more than this lies between them (chosen: a pause that is felt as one).
const PAUSE: Duration = Duration::from_millis(700);

struct Step {
    work: Work,
    name: &'static str,
}

/// What was, and what was undone.
#[derive(Default)]
pub(super) struct History {
    past: Vec<Step>,
    future: Vec<Step>,
    last: Option<(&'static str, Instant)>,
}

impl History {
    /// Notes the state before a change.
    pub(super) fn push(&mut self, before: Work, name: &'static str, merges_as: Option<&'static str>) {
        let now = Instant::now();
        let merges =
            matches!((self.last, merges_as), (Some((last, at)), Some(kind)) if last == kind && now - at < PAUSE);
        self.last = merges_as.map(|kind| (kind, now));
        self.future.clear();
        if !merges || self.past.is_empty() {
            self.past.push(Step { work: before, name });
            if self.past.len() > MOST_STEPS {
                self.past.remove(0);
            }
            self.forget_closed();
        }
    }

    /// Drops the oldest steps, if those have too many molecules that are not open any more.
    fn forget_closed(&mut self) {
        let (mut closed, mut bytes) = (0, 0);
        let Some((newest, older)) = self.past.split_last() else { return };
        let mut known: Vec<*const Document> = newest.work.layers.iter().map(|l| Arc::as_ptr(&l.document)).collect();
        let mut first = 0;
        'steps: for (index, step) in older.iter().enumerate().rev() {
            for layer in &step.work.layers {
                let document = Arc::as_ptr(&layer.document);
                if known.contains(&document) {
                    continue;
                }
                known.push(document);
                closed += 1;
                bytes += layer.document.records.iter().map(Structure::memory).sum::<usize>();
                if closed > MOST_CLOSED || (closed > 1 && bytes > MOST_BYTES) {
                    first = index + 1;
                    break 'steps;
                }
            }
        }
        self.past.drain(..first);
    }

    /// What undo and redo would undo and redo.
    pub(super) fn names(&self) -> [Option<&'static str>; 2] {
        [self.past.last().map(|step| step.name), self.future.last().map(|step| step.name)]
    }

    /// The state before, in exchange for this one; `None` if there is none.
    pub(super) fn undo(&mut self, now: &Work) -> Option<Work> {
        Self::exchange(&mut self.past, &mut self.future, now, &mut self.last)
    }

    /// The state that was undone.
    pub(super) fn redo(&mut self, now: &Work) -> Option<Work> {
        Self::exchange(&mut self.future, &mut self.past, now, &mut self.last)
    }

    fn exchange(
        from: &mut Vec<Step>,
        to: &mut Vec<Step>,
        now: &Work,
        last: &mut Option<(&'static str, Instant)>,
    ) -> Option<Work> {
        *last = None;
        let step = from.pop()?;
        to.push(Step { work: now.clone(), name: step.name });
        Some(step.work)
    }
}
