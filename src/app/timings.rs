//! How long what the window does takes, for `ballstick view --timings`: told as one JSON object when it is closed.
//!
//! Every stage keeps its latest [`KEPT`] durations, so that a window that is open for a day takes no more memory than one open for a minute.
//! Without the flag nothing is kept.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// What is timed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    /// egui and what it asks of the state: input, layout, tessellation.
    Interface,
    /// From asking for a picture in motion to when its drawing begins.
    Wait,
    /// Drawing a picture in motion.
    Render,
    /// From when it is drawn to when the window takes it.
    Wake,
    /// Putting picture and interface into the window's pixels.
    Paint,
    /// Handing these to the system, its part of the work included where it makes the window wait.
    Present,
    /// Between pictures in motion that follow one another within [`PAUSE`].
    Frame,
    /// From the event that moves something to when a picture that shows it was handed over.
    Latency,
    /// Drawing a finished picture.
    Still,
}

impl Stage {
    const ALL: [(Stage, &'static str); 9] = [
        (Stage::Interface, "interface"),
        (Stage::Wait, "wait"),
        (Stage::Render, "render"),
        (Stage::Wake, "wake"),
        (Stage::Paint, "paint"),
        (Stage::Present, "present"),
        (Stage::Frame, "frame"),
        (Stage::Latency, "latency"),
        (Stage::Still, "still"),
    ];
}

/// Durations kept of each stage.
const KEPT: usize = 1 << 14;
/// Pictures further apart than this are not part of one motion.
const PAUSE: Duration = Duration::from_millis(500);

/// Counts and durations.
#[derive(Debug, Default)]
pub(super) struct Timings {
    is_on: bool,
    /// Milliseconds, by stage.
    spent: [VecDeque<f32>; Stage::ALL.len()],
    /// How often the window's pixels were handed to the system.
    presented: u64,
    /// How many of them had a new picture in motion, and a finished one.
    pictures: [u64; 2],
    /// How many in motion were drawn with larger pixels than the window's.
    coarser: u64,
    /// How often egui was run.
    interfaces: u64,
    last_picture: Option<Instant>,
    /// What has drawn, in order.
    drawn_by: Vec<&'static str>,
    /// Events whose effect is not to be seen yet, with the version of the picture that shows it.
    awaited: VecDeque<(u64, Instant)>,
}

impl Timings {
    /// Keeps what it is told only if it is `on`.
    pub(super) fn new(on: bool) -> Timings {
        Timings { is_on: on, ..Timings::default() }
    }

    /// Adds a duration.
    pub(super) fn spent(&mut self, stage: Stage, duration: Duration) {
        if !self.is_on {
            return;
        }
        if stage == Stage::Interface {
            self.interfaces += 1;
        }
        let spent = &mut self.spent[stage as usize];
        if spent.len() == KEPT {
            spent.pop_front();
        }
        spent.push_back(duration.as_secs_f32() * 1e3);
    }

    /// A picture in motion was drawn with larger pixels than the window's.
    pub(super) fn coarser(&mut self) {
        self.coarser += u64::from(self.is_on);
    }

    /// Another renderer draws, or still the same.
    pub(super) fn drawn_by(&mut self, name: &'static str) {
        if self.is_on && self.drawn_by.last() != Some(&name) {
            self.drawn_by.push(name);
        }
    }

    /// An event of this moment changed the picture to this version.
    pub(super) fn awaits(&mut self, version: u64, since: Instant) {
        if self.is_on && self.awaited.len() < KEPT && self.awaited.back().is_none_or(|(last, _)| *last < version) {
            self.awaited.push_back((version, since));
        }
    }

    /// The window's pixels were handed over, with a new picture of this version (and whether that is the finished one) or with the one
    /// before.
    pub(super) fn presented(&mut self, picture: Option<(u64, bool)>) {
        if !self.is_on {
            return;
        }
        self.presented += 1;
        let Some((version, is_fine)) = picture else { return };
        self.pictures[usize::from(is_fine)] += 1;
        let now = Instant::now();
        while let Some((_, since)) = self.awaited.pop_front_if(|(awaited, _)| *awaited <= version) {
            self.spent(Stage::Latency, now.saturating_duration_since(since));
        }
        if is_fine {
            self.last_picture = None;
        } else if let Some(last) = self.last_picture.replace(now) {
            let between = now.saturating_duration_since(last);
            if between < PAUSE {
                self.spent(Stage::Frame, between);
            }
        }
    }

    /// One line of JSON: counts, and of each stage how many, median, 90th percentile and the longest, in milliseconds.
    pub(super) fn line(&self) -> Option<String> {
        let mut stages = serde_json::Map::new();
        for (stage, name) in Stage::ALL {
            let mut sorted: Vec<f32> = self.spent[stage as usize].iter().copied().collect();
            sorted.sort_by(f32::total_cmp);
            let part = |share: usize| sorted.get((sorted.len() * share / 100).min(sorted.len().saturating_sub(1)));
            let rounded = |ms: Option<&f32>| (f64::from(ms.copied().unwrap_or(0.0)) * 100.0).round() / 100.0;
            if !sorted.is_empty() {
                let entry = serde_json::json!({
                    "count": sorted.len(),
                    "median_ms": rounded(part(50)),
                    "p90_ms": rounded(part(90)),
                    "most_ms": rounded(sorted.last()),
                });
                stages.insert(name.to_owned(), entry);
            }
        }
        let line = serde_json::json!({
            "renderers": self.drawn_by,
            "presented": self.presented,
            "pictures_in_motion": self.pictures[0],
            "with_larger_pixels": self.coarser,
            "finished_pictures": self.pictures[1],
            "interfaces": self.interfaces,
            "stages": stages,
        });
        self.is_on.then(|| line.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_waits_until_a_picture_shows_it() {
        let mut timings = Timings::new(true);
        let now = Instant::now();
        timings.awaits(3, now);
        timings.awaits(3, now);
        timings.awaits(5, now);
        timings.presented(None);
        timings.presented(Some((2, false)));
        assert_eq!(timings.spent[Stage::Latency as usize].len(), 0);
        timings.presented(Some((4, false)));
        assert_eq!((timings.spent[Stage::Latency as usize].len(), timings.awaited.len()), (1, 1));
        timings.presented(Some((5, true)));
        let line: serde_json::Value = serde_json::from_str(&timings.line().unwrap()).unwrap();
        assert_eq!(
            (&line["presented"], &line["pictures_in_motion"], &line["finished_pictures"]),
            (&4.into(), &2.into(), &1.into())
        );
        assert_eq!(line["stages"]["latency"]["count"], 2);
    }

    #[test]
    fn what_is_kept_is_bounded_and_nothing_is_without_the_flag() {
        let mut timings = Timings::new(true);
        (0..2 * KEPT).for_each(|ms| timings.spent(Stage::Paint, Duration::from_millis(ms as u64)));
        assert_eq!(timings.spent[Stage::Paint as usize].len(), KEPT);
        assert_eq!(timings.spent[Stage::Paint as usize][0], KEPT as f32);
        let mut off = Timings::new(false);
        off.spent(Stage::Paint, Duration::from_millis(1));
        off.presented(Some((1, false)));
        assert_eq!((off.line(), off.presented, off.spent[Stage::Paint as usize].len()), (None, 0, 0));
    }
}
