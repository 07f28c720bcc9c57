//! Frames of trajectories, decoded before they are shown: a thread works ahead in the direction in which frames were asked for last.
//!
//! What is decoded is kept in a ring that is bounded in bytes, whatever the number of frames or atoms. A frame that is not there yet is
//! decoded by whoever asks.

use crate::error::Result;
use crate::import::Document;
use crate::structure::Frame;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Bytes of decoded frames that are kept (chosen: 50 frames of 100,000 atoms).
const MOST_BYTES: usize = 64 << 20;
/// Frames that are decoded ahead at most (chosen: half a second at the highest speed).
const MOST_AHEAD: usize = 32;

/// A frame that was decoded.
struct Decoded {
    document: Arc<Document>,
    number: usize,
    frame: Arc<Frame>,
}

/// From where on, and which way.
#[derive(Clone)]
struct Wish {
    document: Arc<Document>,
    at: usize,
    is_forward: bool,
}

impl Wish {
    /// The frames that come next, those after the last being the first ones.
    fn next(&self) -> impl Iterator<Item = usize> {
        let count = self.document.frame_count().max(1);
        let (at, is_forward) = (self.at.min(count - 1), self.is_forward);
        (1..=MOST_AHEAD.min(count - 1)).map(move |by| (if is_forward { at + by } else { at + count - by }) % count)
    }

    fn is_of(&self, decoded: &Decoded) -> bool {
        Arc::ptr_eq(&self.document, &decoded.document)
    }
}

#[derive(Default)]
struct Ring {
    decoded: Vec<Decoded>,
    wish: Option<Wish>,
    is_running: bool,
    closing: bool,
}

impl Ring {
    fn find(&self, document: &Arc<Document>, number: usize) -> Option<&Decoded> {
        self.decoded.iter().find(|one| Arc::ptr_eq(&one.document, document) && one.number == number)
    }

    fn bytes(&self) -> usize {
        self.decoded.iter().map(|one| bytes_of(&one.frame)).sum()
    }

    /// What is to be decoded next; frames that are not soon shown make room for it.
    fn next(&mut self, most_bytes: usize) -> Option<(Arc<Document>, usize)> {
        let wish = self.wish.clone()?;
        let wanted: Vec<usize> = wish.next().collect();
        let missing = wanted.iter().position(|&number| self.find(&wish.document, number).is_none())?;
        // Two frames are kept whatever they take: the one that is shown and the one after it.
        let soon =
            |one: &Decoded| wish.is_of(one) && (one.number == wish.at || wanted[..missing].contains(&one.number));
        if self.decoded.iter().filter(|one| soon(one)).map(|one| bytes_of(&one.frame)).sum::<usize>() > most_bytes {
            return (missing == 0).then(|| (Arc::clone(&wish.document), wanted[missing]));
        }
        while self.bytes() > most_bytes {
            let Some(at) = self.decoded.iter().position(|one| !soon(one)) else { break };
            self.decoded.remove(at);
        }
        Some((Arc::clone(&wish.document), wanted[missing]))
    }

    fn keep(&mut self, document: &Arc<Document>, number: usize, frame: &Arc<Frame>) {
        if self.find(document, number).is_none() {
            self.decoded.push(Decoded { document: Arc::clone(document), number, frame: Arc::clone(frame) });
        }
    }
}

fn bytes_of(frame: &Frame) -> usize {
    let vectors: usize = frame.vectors.iter().map(|field| field.vectors.len()).sum();
    12 * (frame.positions.len() + vectors) + size_of::<Frame>()
}

/// The thread and its ring.
pub(super) struct Ahead {
    shared: Arc<(Mutex<Ring>, Condvar)>,
    most_bytes: usize,
}

impl Default for Ahead {
    fn default() -> Ahead {
        Ahead { shared: Arc::default(), most_bytes: MOST_BYTES }
    }
}

fn lock(mutex: &Mutex<Ring>) -> MutexGuard<'_, Ring> {
    // A panic of the other side leaves plain data behind, which is still good.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Ahead {
    /// A frame of the trajectories of a document; those after it in the same direction are made ready.
    pub(super) fn frame(&self, document: &Arc<Document>, number: usize) -> Result<Arc<Frame>> {
        let ready = lock(&self.shared.0).find(document, number).map(|one| Arc::clone(&one.frame));
        let frame = match ready {
            Some(frame) => frame,
            None => Arc::new(document.trajectory_frame(number)?),
        };
        let mut ring = lock(&self.shared.0);
        ring.keep(document, number, &frame);
        let is_forward = match &ring.wish {
            // One back is back; from the first to the last, too.
            Some(wish) if Arc::ptr_eq(&wish.document, document) => match number as i64 - wish.at as i64 {
                0 => wish.is_forward,
                1 => true,
                -1 => false,
                by => by < 0,
            },
            _ => true,
        };
        ring.wish = Some(Wish { document: Arc::clone(document), at: number, is_forward });
        if !std::mem::replace(&mut ring.is_running, true) {
            let shared = Arc::clone(&self.shared);
            let most_bytes = self.most_bytes;
            let work = move || run(&shared, most_bytes);
            // Without a thread each frame is decoded when it is asked for.
            let _ = std::thread::Builder::new().name("frames".to_owned()).spawn(work);
        }
        self.shared.1.notify_one();
        Ok(frame)
    }

    /// Forgets frames of documents that are closed.
    pub(super) fn forget(&self, is_open: impl Fn(&Arc<Document>) -> bool) {
        let mut ring = lock(&self.shared.0);
        ring.decoded.retain(|one| is_open(&one.document));
        ring.wish.take_if(|wish| !is_open(&wish.document));
    }
}

impl Drop for Ahead {
    fn drop(&mut self) {
        lock(&self.shared.0).closing = true;
        self.shared.1.notify_one();
    }
}

fn run((ring, turn): &(Mutex<Ring>, Condvar), most_bytes: usize) {
    let mut state = lock(ring);
    while !state.closing {
        let Some((document, number)) = state.next(most_bytes) else {
            state = turn.wait(state).unwrap_or_else(PoisonError::into_inner);
            continue;
        };
        drop(state);
        let frame = super::loader::guarded(|| document.trajectory_frame(number));
        state = lock(ring);
        match frame {
            Ok(frame) => state.keep(&document, number, &Arc::new(frame)),
            // Whoever asks for it is told why; nothing behind it is looked at until then.
            Err(_) => state.wish = None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::trajectory::{Input, read_input};
    use std::time::{Duration, Instant};

    fn document() -> Arc<Document> {
        let path = |name: &str| std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/trajectories").join(name);
        let input = Input { structure: path("box.gro"), trajectories: vec![path("water.xtc")] };
        let document = read_input(&input, &Default::default()).unwrap();
        document.trajectories[0].count_frames(|| true).unwrap();
        Arc::new(document)
    }

    fn ready(ahead: &Ahead) -> Vec<usize> {
        let mut numbers: Vec<usize> = lock(&ahead.shared.0).decoded.iter().map(|one| one.number).collect();
        numbers.sort_unstable();
        numbers
    }

    fn wait_for(ahead: &Ahead, wanted: &[usize]) {
        let started = Instant::now();
        while ready(ahead) != wanted {
            assert!(started.elapsed() < Duration::from_secs(20), "{:?}, expected {wanted:?}", ready(ahead));
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    #[test]
    fn all_frames_of_a_small_file_are_made_ready_and_are_the_files() {
        let (ahead, document) = (Ahead::default(), document());
        ahead.frame(&document, 0).unwrap();
        wait_for(&ahead, &[0, 1, 2, 3, 4, 5]);
        for number in 0..6 {
            assert_eq!(*ahead.frame(&document, number).unwrap(), document.trajectory_frame(number).unwrap());
        }
        assert!(ahead.frame(&document, 6).is_err());
        ahead.forget(|_| false);
        assert!(ready(&ahead).is_empty());
    }

    #[test]
    fn the_ring_is_bounded_and_follows_the_direction() {
        let document = document();
        let one = bytes_of(&document.trajectory_frame(0).unwrap());
        let ahead = Ahead { most_bytes: one * 2, shared: Arc::default() };
        ahead.frame(&document, 2).unwrap();
        wait_for(&ahead, &[2, 3, 4]);
        ahead.frame(&document, 1).unwrap();
        wait_for(&ahead, &[0, 1, 5]);
    }
}
