//! Giving up long work: a flag that one thread sets and the work of others looks at between its steps.
//!
//! Work that is told to stop ends early with whatever it has, which is nobody's: who began it asks the flag
//! ([`Stop::check`]) before looking at the result. So the steps themselves need no second way out, and what they had
//! set aside is freed on the way that they take anyway.

use crate::error::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A handle by which work can be given up, and by which the work sees that. Clones are handles of the same flag. The default is never set, and
/// costs nothing to ask.
///
/// ```
/// use ballstick::import::{ImportOptions, read_bytes};
/// use ballstick::stop::Stop;
/// let stop = Stop::new();
/// let options = ImportOptions { stop: stop.clone(), ..ImportOptions::default() };
/// stop.set();
/// let error = read_bytes(b"1\nargon\nAr 0 0 0\n", "argon.xyz", &options).unwrap_err();
/// assert!(matches!(error, ballstick::Error::Stopped));
/// ```
#[derive(Debug, Clone, Default)]
pub struct Stop(Option<Arc<Flag>>);

#[derive(Debug, Default)]
struct Flag {
    is_set: AtomicBool,
    #[cfg(test)]
    asked: tests::Asked,
}

impl Stop {
    /// A flag that is not set yet.
    #[must_use]
    pub fn new() -> Stop {
        Stop(Some(Arc::default()))
    }

    /// A flag that nobody sets: the default.
    #[must_use]
    pub fn never() -> Stop {
        Stop(None)
    }

    /// Tells the work to end. It cannot be taken back; [`Stop::never`] is never set.
    pub fn set(&self) {
        if let Some(flag) = &self.0 {
            flag.is_set.store(true, Ordering::Relaxed);
        }
    }

    /// Whether the work is to end.
    #[inline]
    #[must_use]
    pub fn is_set(&self) -> bool {
        self.0.as_deref().is_some_and(|flag| {
            #[cfg(test)]
            flag.asked.note(&flag.is_set);
            flag.is_set.load(Ordering::Relaxed)
        })
    }

    /// An error if the work is to end.
    ///
    /// # Errors
    /// [`Error::Stopped`].
    pub fn check(&self) -> Result<()> {
        if self.is_set() { Err(Error::Stopped) } else { Ok(()) }
    }
}

/// Handles of the same flag are equal, as are those that are never set.
impl PartialEq for Stop {
    fn eq(&self, other: &Stop) -> bool {
        match (&self.0, &other.0) {
            (Some(one), Some(other)) => Arc::ptr_eq(one, other),
            (one, other) => one.is_none() && other.is_none(),
        }
    }
}

impl Eq for Stop {}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    /// How often a flag was asked, so that tests can set it in the middle of work without a clock.
    #[derive(Debug)]
    pub(super) struct Asked {
        count: AtomicUsize,
        /// The question from which on it is set.
        set_at: usize,
    }

    impl Default for Asked {
        fn default() -> Asked {
            Asked { count: AtomicUsize::new(0), set_at: usize::MAX }
        }
    }

    impl Asked {
        pub(super) fn note(&self, is_set: &AtomicBool) {
            if self.count.fetch_add(1, Ordering::Relaxed) + 1 >= self.set_at {
                is_set.store(true, Ordering::Relaxed);
            }
        }
    }

    impl Stop {
        /// One that sets itself when it is asked for the `question`th time, from 1.
        pub(crate) fn at_question(question: usize) -> Stop {
            let asked = Asked { count: AtomicUsize::new(0), set_at: question };
            Stop(Some(Arc::new(Flag { is_set: AtomicBool::new(false), asked })))
        }

        /// How often it was asked.
        pub(crate) fn questions(&self) -> usize {
            self.0.as_ref().map_or(0, |flag| flag.asked.count.load(Ordering::Relaxed))
        }

        /// How many handles of it there are.
        pub(crate) fn handles(&self) -> usize {
            self.0.as_ref().map_or(0, Arc::strong_count)
        }
    }

    #[test]
    fn all_handles_see_that_it_is_set_and_the_default_never_is() {
        let (stop, never) = (Stop::new(), Stop::default());
        let other = stop.clone();
        assert!(!other.is_set() && stop == other && stop != Stop::new() && never == Stop::never());
        stop.set();
        never.set();
        assert!(other.is_set() && !never.is_set());
        assert!(matches!(other.check(), Err(Error::Stopped)) && never.check().is_ok());
        let third = Stop::at_question(3);
        assert_eq!([(); 4].map(|()| third.is_set()), [false, false, true, true]);
        assert_eq!((third.questions(), third.handles()), (4, 1));
    }
}
