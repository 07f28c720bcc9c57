//! How coarse the CPU's pictures in motion are, so that they come fast enough to be seen as motion.
//!
//! A picture that takes too long is followed by one with larger pixels, one that would be fast enough with smaller ones by such. What takes long
//! for its many atoms and not for its pixels is not made coarser for nothing: a step that gains little is taken back, and tried again only after
//! a while.

/// So many times larger are the pixels, by step.
const COARSENESS: [f32; 5] = [1.0, 1.5, 2.0, 3.0, 4.0];
/// A picture in motion that takes longer than this is made coarser next time (seconds): motion is seen as such from 30 pictures a second on.
const SLOW: f32 = 0.033;
/// One that would take less than this part of [`SLOW`] even if all of its time were its pixels' is made finer: some way off, so that it does not
/// go to and fro.
const FAST: f32 = 0.8;
/// A coarser picture that takes more than this part of the one before has gained too little (chosen: what is not seen as faster).
const GAIN: f32 = 0.85;
/// So many pictures go by before such a step is tried again.
const PATIENCE: u32 = 100;

/// What is known of the last pictures.
#[derive(Debug, Default)]
pub(super) struct Pace {
    step: usize,
    /// How long the last picture took before a step was taken, seconds.
    before: Option<f32>,
    /// Pictures until a coarser one is tried again.
    patience: u32,
}

impl Pace {
    /// How many times larger the pixels of the next picture are.
    pub(super) fn coarseness(&self) -> f32 {
        COARSENESS[self.step]
    }

    /// Takes note of the seconds of a picture.
    pub(super) fn took(&mut self, seconds: f32) {
        self.patience = self.patience.saturating_sub(1);
        if let Some(before) = self.before.take()
            && seconds > before * GAIN
        {
            (self.step, self.patience) = (self.step - 1, PATIENCE);
            return;
        }
        let as_fine = self.step.checked_sub(1).map(|finer| (COARSENESS[self.step] / COARSENESS[finer]).powi(2));
        if seconds > SLOW && self.step + 1 < COARSENESS.len() && self.patience == 0 {
            self.before = Some(seconds);
            self.step += 1;
        } else if as_fine.is_some_and(|more| seconds * more < SLOW * FAST) {
            self.step -= 1;
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
            pace.took(fixed + pixels / pace.coarseness().powi(2));
            pace.step
        };
        (0..count).map(|_| next()).collect()
    }

    #[test]
    fn pictures_are_as_fine_as_the_machine_can_and_do_not_go_to_and_fro() {
        // Seconds, and the step that is enough.
        for (fixed, pixels, step) in [(0.002, 0.008, 0), (0.002, 0.060, 1), (0.002, 0.100, 2), (0.020, 0.040, 2)] {
            let course = course(40, fixed, pixels);
            assert!(course[8..].iter().all(|&at| at == step), "{course:?}");
        }
    }

    #[test]
    fn what_gains_nothing_is_not_made_coarser() {
        let course = course(4 * PATIENCE as usize, 0.080, 0.010);
        let coarse = course.iter().filter(|&&step| step > 0).count();
        assert!(coarse <= 5 && course.iter().all(|&step| step <= 1), "{coarse}");
    }

    #[test]
    fn what_gets_faster_gets_finer() {
        let mut pace = Pace { step: 4, ..Pace::default() };
        (0..10).for_each(|_| pace.took(0.005));
        assert_eq!(pace.step, 0);
    }
}
