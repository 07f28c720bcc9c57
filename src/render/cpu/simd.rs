//! The widest vector instructions the machine has, chosen at run time; the program's only unsafe code.
//!
//! The loops over lanes are plain Rust that the compiler turns into vector code. Compiled for x86-64's baseline they
//! get 4 lanes and no blends; with AVX2 the same loops get 8, with AVX-512 all 16 (the gain is in the benches,
//! `cpu_frame`). Only the width changes: fused multiply-add stays off, so every level gives the same bits.
#![expect(
    unsafe_code,
    reason = "instructions that were just found to be there, and loads whose bounds were just checked"
)]

/// Something to run. `run` must be `#[inline(always)]`, and so must what it calls: what is not inlined stays at the baseline
/// (a closure would be inlined only as the compiler sees fit).
pub(super) trait Work {
    /// Does it.
    fn run(self);
}

/// Runs `work`, compiled for the best instructions there are.
#[inline]
pub(super) fn widest(work: impl Work) {
    #[cfg(target_arch = "x86_64")]
    {
        let has_avx512 = std::arch::is_x86_feature_detected!("avx512f")
            && std::arch::is_x86_feature_detected!("avx512dq")
            && std::arch::is_x86_feature_detected!("avx512vl")
            && std::arch::is_x86_feature_detected!("avx512bw");
        if has_avx512 {
            // SAFETY: the machine has all four parts of AVX-512.
            return unsafe { avx512(work) };
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the machine has AVX2.
            return unsafe { avx2(work) };
        }
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
