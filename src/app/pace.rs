//! How coarse the CPU's pictures in motion are, so that they come fast enough to be seen as motion.
//!
//! When some pictures in a row take too long, the next have larger pixels; when one would be fast enough with smaller ones, by what the larger
//! were found to gain, the next have these again. What takes long for its many atoms and not for its pixels is not made coarser for nothing: a
//! step that gains little is taken back, and tried again only after a while.

/// So many times larger are the pixels, by step.
const COARSENESS: [f32; 5] = [1.0, 1.5, 2.0, 3.0, 4.0];
/// Pictures in motion that take longer than this are made coarser (seconds): motion is seen as such from 30 pictures a second on, of which the
/// window needs some two milliseconds each.
const SLOW: f32 = 0.031;
/// So many of them in a row: one may have had to wait for something else. Chosen.
const IN_A_ROW: u8 = 3;
/// One that would take less than this part of [`SLOW`] with smaller pixels is made finer: some way off, so that it does not go to and fro.
const FAST: f32 = 0.9;
/// A coarser picture that takes more than this part of those before has gained too little (chosen: what is not seen as faster).
const GAIN: f32 = 0.85;
/// So many pictures go by before such a step is tried again.
const PATIENCE: u32 = 100;

/// What is known of the last pictures.
#[derive(Debug, Default)]
pub(super) struct Pace {
    step: usize,
    /// How many of the last pictures in a row took too long, and how long the fastest of them took, seconds.
    slow: (u8, f32),
    /// How long the fastest of the pictures took for which the last step was taken, until it is known what that gained.
    before: Option<f32>,
    /// What part of the time before each step took, as far as steps were taken.
    gained: [Option<f32>; COARSENESS.len()],
    /// Pictures until a coarser one is tried again.
    patience: u32,
}

impl Pace {
    /// How many times larger the pixels of the next picture are.
    pub(super) fn coarseness(&self) -> f32 {
        COARSENESS[self.step]
    }

    /// Takes note of the seconds of a picture with so many times larger pixels. One that was asked for before the last step says nothing of it.
    pub(super) fn took(&mut self, seconds: f32, coarseness: f32) {
        if coarseness != self.coarseness() {
            return;
        }
        self.patience = self.patience.saturating_sub(1);
        if let Some(before) = self.before.take() {
            if seconds > before * GAIN {
                (self.step, self.patience) = (self.step - 1, PATIENCE);
                return;
            }
            self.gained[self.step] = Some(seconds / before);
        }
        let (count, fastest) = self.slow;
        self.slow = match seconds > SLOW {
            true => (count.saturating_add(1), if count == 0 { seconds } else { fastest.min(seconds) }),
            false => (0, 0.0),
        };
        if self.slow.0 >= IN_A_ROW && self.step + 1 < COARSENESS.len() && self.patience == 0 {
            self.before = Some(self.slow.1);
            self.slow = (0, 0.0);
            self.step += 1;
        } else if let Some(finer) = self.step.checked_sub(1) {
            // If nothing is known, all of its time is that of its pixels.
            let by_pixels = (COARSENESS[finer] / COARSENESS[self.step]).powi(2);
            if seconds / self.gained[self.step].unwrap_or(by_pixels) < SLOW * FAST {
                self.step = finer;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The steps of so many pictures of which a part takes as long as its pixels and a part does not.
    fn course(count: usize, fixed: f32, pixels: f32) -> Vec<usize> {
        let mut pace = Pace::default();
        let mut next = || {
            pace.took(fixed + pixels / pace.coarseness().powi(2), pace.coarseness());
            pace.step
        };
        (0..count).map(|_| next()).collect()
    }

    #[test]
    fn pictures_are_as_fine_as_the_machine_can_and_do_not_go_to_and_fro() {
        // Seconds, and the step that is enough.
        for (fixed, pixels, step) in [(0.002, 0.008, 0), (0.002, 0.060, 1), (0.002, 0.100, 2), (0.020, 0.040, 2)] {
            let course = course(40, fixed, pixels);
            assert!(course[12..].iter().all(|&at| at == step), "{course:?}");
        }
    }

    #[test]
    fn a_single_slow_picture_changes_nothing_and_some_only_for_a_while() {
        let mut pace = Pace::default();
        // As at 100,000 atoms: fast enough, but not by much, and more than a half of it is not the pixels' time.
        let calm = |pace: &Pace| 0.014 + 0.012 / pace.coarseness().powi(2);
        for number in 0..60 {
            pace.took(calm(&pace) + if number % 10 == 5 { 0.05 } else { 0.0 }, pace.coarseness());
            assert_eq!(pace.step, 0, "picture {number}");
        }
        for _ in 0..8 {
            pace.took(2.0 * calm(&pace), pace.coarseness());
        }
        assert!(pace.step > 0, "busy for a while");
        for _ in 0..8 {
            pace.took(calm(&pace), pace.coarseness());
        }
        assert_eq!(pace.step, 0, "as fine as before");
    }

    #[test]
    fn what_gains_nothing_is_not_made_coarser() {
        let course = course(4 * PATIENCE as usize, 0.080, 0.010);
        let coarse = course.iter().filter(|&&step| step > 0).count();
        assert!(coarse <= 5 && course.iter().all(|&step| step <= 1), "{coarse}");
    }

    #[test]
    fn a_picture_that_was_under_way_when_a_step_was_taken_is_not_taken_for_its_outcome() {
        let mut pace = Pace::default();
        (0..IN_A_ROW).for_each(|_| pace.took(0.05, 1.0));
        assert_eq!(pace.step, 1);
        pace.took(0.05, 1.0);
        assert_eq!((pace.step, pace.patience), (1, 0));
        pace.took(0.025, COARSENESS[1]);
        assert_eq!(pace.step, 1);
    }

    #[test]
    fn what_gets_faster_gets_finer() {
        let mut pace = Pace { step: 4, ..Pace::default() };
        (0..10).for_each(|_| pace.took(0.005, pace.coarseness()));
        assert_eq!(pace.step, 0);
    }
}
