//! The widest vector instructions the machine has, chosen at run time; the program's only unsafe code.
//!
//! The loops over lanes are plain Rust that the compiler turns into vector code. Compiled for x86-64's baseline they
//! get 4 lanes and no blends; with AVX2 the same loops get 8, with AVX-512 all 16 (the gain is in the benches,
//! `cpu_frame`). Only the width changes: fused multiply-add stays off, so every level gives the same bits.
#![expect(
    unsafe_code,
    reason = "instructions that were just found to be there, and loads whose bounds were just checked"
)]

use std::sync::OnceLock;

/// Something to run. `run` must be `#[inline(always)]`, and so must what it calls: what is not inlined stays at the baseline
/// (a closure would be inlined only as the compiler sees fit).
pub(super) trait Work {
    /// Does it.
    fn run(self);
}

/// The environment variable that names the level to use; for comparing levels, which all draw the same.
pub const VARIABLE: &str = "BALLSTICK_SIMD";

/// Which vector instructions are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Those that every machine of the architecture has.
    Baseline,
    /// AVX2 (x86-64).
    Avx2,
    /// AVX-512 F, DQ, VL and BW (x86-64).
    Avx512,
}

impl Level {
    /// All of them.
    pub const ALL: [Level; 3] = [Level::Baseline, Level::Avx2, Level::Avx512];

    /// The name in [`VARIABLE`].
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Level::Baseline => "baseline",
            Level::Avx2 => "avx2",
            Level::Avx512 => "avx512",
        }
    }

    /// The level that is used: the best that the machine has, and no better than [`VARIABLE`] says. What that holds beside a name counts for
    /// nothing.
    #[must_use]
    pub fn used() -> Level {
        static USED: OnceLock<Level> = OnceLock::new();
        *USED.get_or_init(|| {
            let asked = std::env::var(VARIABLE).ok();
            let most = Level::ALL.into_iter().find(|level| asked.as_deref() == Some(level.name()));
            most.unwrap_or(Level::Avx512).min(Level::of_machine())
        })
    }

    /// What [`VARIABLE`] holds if that is the name of no level; it counts for nothing.
    #[must_use]
    pub fn unknown() -> Option<String> {
        let asked = std::env::var_os(VARIABLE)?.to_string_lossy().into_owned();
        let is_known = asked.is_empty() || Level::ALL.into_iter().any(|level| asked == level.name());
        (!is_known).then_some(asked)
    }

    #[cfg(target_arch = "x86_64")]
    fn of_machine() -> Level {
        let has_avx512 = std::arch::is_x86_feature_detected!("avx512f")
            && std::arch::is_x86_feature_detected!("avx512dq")
            && std::arch::is_x86_feature_detected!("avx512vl")
            && std::arch::is_x86_feature_detected!("avx512bw");
        match (has_avx512, std::arch::is_x86_feature_detected!("avx2")) {
            (true, _) => Level::Avx512,
            (false, true) => Level::Avx2,
            (false, false) => Level::Baseline,
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn of_machine() -> Level {
        Level::Baseline
    }
}

/// Runs `work`, compiled for the level that is used.
#[inline]
pub(super) fn widest(work: impl Work) {
    #[cfg(target_arch = "x86_64")]
    match Level::used() {
        // SAFETY: the machine has all four parts of AVX-512: no level is used that it has not.
        Level::Avx512 => return unsafe { avx512(work) },
        // SAFETY: the machine has AVX2, likewise.
        Level::Avx2 => return unsafe { avx2(work) },
        Level::Baseline => {}
    }
    work.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2(work: impl Work) {
    work.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw")]
fn avx512(work: impl Work) {
    work.run();
}
