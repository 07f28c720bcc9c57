//! Files that change on the disk are read again by themselves, with the same view.
//!
//! Once a second the time and the size of every open file are looked at, which costs some microseconds and draws nothing. A file
//! is read when it has stayed as it is from one look to the next, so that one which is still being written is waited for; if it is cut
//! short all the same, what was shown stays and the file is tried again.

use super::state::State;
use super::work::Source;
use std::collections::HashMap;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime};

/// Time between two looks.
const PAUSE: Duration = Duration::from_secs(1);
/// A file that cannot be read so often in a row is said to be broken.
const TRIES: u32 = 3;

/// What tells whether a file is another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stamp {
    time: Option<SystemTime>,
    bytes: u64,
}

impl Stamp {
    /// That of a file; `None` while there is none, or no regular one.
    fn of(path: &Path) -> Option<Stamp> {
        let metadata = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
        Some(Stamp { time: metadata.modified().ok(), bytes: metadata.len() })
    }
}

/// What is known of one file.
#[derive(Debug, Clone, Copy)]
struct Seen {
    /// What was read.
    read: Option<Stamp>,
    /// What was there at the last look.
    last: Option<Stamp>,
    /// How often it could not be read since.
    failures: u32,
}

/// What is known of the open files, by the numbers of their layers.
#[derive(Debug, Default)]
pub(super) struct Watch {
    seen: HashMap<u32, Seen>,
    next: Option<Instant>,
}

impl Watch {
    /// Notes that a layer shows what is in its file now.
    pub(super) fn was_read(&mut self, layer: u32, path: &Path) {
        let stamp = Stamp::of(path);
        self.seen.insert(layer, Seen { read: stamp, last: stamp, failures: 0 });
    }

    /// Whether a file that was read anew by itself and is broken is to be tried again, and not spoken of.
    pub(super) fn is_tried_again(&mut self, layer: u32) -> bool {
        let Some(seen) = self.seen.get_mut(&layer) else { return false };
        seen.failures += 1;
        if seen.failures < TRIES {
            // As if it had never been read: the next look finds it new.
            seen.read = None;
        }
        seen.failures < TRIES
    }

    /// When to look next.
    pub(super) fn next(&self) -> Option<Instant> {
        self.next
    }
}

/// Looks at the files if it is time, and has those read that are others than they were. Whether anything began.
pub(super) fn look(state: &mut State, now: Instant) -> bool {
    if !state.preferences.reloads || state.work.layers.is_empty() {
        state.watch.next = None;
        return false;
    }
    if state.watch.next.is_some_and(|next| now < next) {
        return false;
    }
    state.watch.next = Some(now + PAUSE);
    let mut changed = Vec::new();
    for layer in &state.work.layers {
        let Source::File(input) = &layer.source else { continue };
        let stamp = Stamp::of(&input.structure);
        let seen = state.watch.seen.entry(layer.id).or_insert(Seen { read: stamp, last: stamp, failures: 0 });
        let rests = std::mem::replace(&mut seen.last, stamp) == stamp;
        // What is gone stays on the screen: programs that save often take the old file away first.
        if rests && stamp.is_some() && seen.read != stamp {
            seen.read = stamp;
            changed.push(layer.id);
        }
    }
    let open: Vec<u32> = state.work.layers.iter().map(|layer| layer.id).collect();
    state.watch.seen.retain(|id, _| open.contains(id));
    for id in &changed {
        state.reload_one(*id);
    }
    !changed.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::action::Action;
    use crate::app::state::tests::{settle, state};
    use std::path::PathBuf;

    const TWO: &str = "2\n\nO 0 0 0\nO 3 0 0\n";
    const THREE: &str = "3\n\nO 0 0 0\nO 3 0 0\nO 0 3 0\n";

    /// A file of two atoms, in a folder of its own, that is open.
    fn opened() -> (tempfile::TempDir, PathBuf, State) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.xyz");
        std::fs::write(&file, TWO).unwrap();
        let mut state = state();
        state.apply(Action::Open(file.clone()));
        state.wait_for_files();
        (folder, file, state)
    }

    /// Looks as often as it takes, in time that does not pass.
    fn look_twice(state: &mut State) -> bool {
        let begun = [PAUSE, PAUSE * 2].map(|later| look(state, Instant::now() + later * 1000));
        state.watch.next = None;
        state.wait_for_files();
        settle(state);
        begun.contains(&true)
    }

    fn look_now(state: &mut State) -> bool {
        state.watch.next = None;
        look(state, Instant::now())
    }

    #[test]
    fn a_changed_file_is_read_again_and_a_half_written_one_waited_for() {
        let (_folder, file, mut state) = opened();
        state.apply(Action::Turn(2, 0));
        let eye = state.work.camera.eye;
        assert!(!look_now(&mut state) && !look_now(&mut state), "nothing has changed");
        // In the middle of being written: other sizes from look to look.
        std::fs::write(&file, &THREE[..12]).unwrap();
        assert!(!look_now(&mut state));
        std::fs::write(&file, &THREE[..20]).unwrap();
        assert!(!look_now(&mut state), "it still grows");
        // Then it stops there: it is tried, and what was shown stays.
        assert!(look_now(&mut state));
        state.wait_for_files();
        settle(&mut state);
        assert_eq!((state.built.scene.sphere_count(), state.notices.len()), (2, 0), "{:?}", state.notices);
        std::fs::write(&file, THREE).unwrap();
        assert!(look_twice(&mut state));
        assert_eq!((state.built.scene.sphere_count(), state.work.camera.eye), (3, eye));
        assert!(state.notices[0].text.contains("a.xyz has changed") && !state.notices[0].is_error);
        assert!(!look_twice(&mut state), "once is enough");
    }

    #[test]
    fn a_file_that_stays_broken_is_said_once_and_one_that_is_gone_stays_on_the_screen() {
        let (_folder, file, mut state) = opened();
        std::fs::remove_file(&file).unwrap();
        assert!(!look_twice(&mut state) && state.notices.is_empty());
        std::fs::write(&file, "no molecule").unwrap();
        for _ in 0..5 {
            look_twice(&mut state);
        }
        assert_eq!((state.notices.len(), state.built.scene.sphere_count()), (1, 2), "{:?}", state.notices);
        assert!(state.notices[0].is_error);
        state.apply(Action::Reloads(false));
        std::fs::write(&file, THREE).unwrap();
        assert!(!look_twice(&mut state), "it can be turned off");
    }
}
