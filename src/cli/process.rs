//! The process that the commands run in: its threads, and what happens when it is told to end.
//!
//! - **Threads.** Work is shared out by rayon, which panics where the system gives no threads (`ulimit -u`, a full container).
//!   They are asked for one by one beforehand: as many as there are will do, and without any the first one works alone.
//! - **Signals** (Unix). Ctrl+C, `kill` and a closed terminal end the program at once, by the signal, so that a shell sees 130, 143 or 129;
//!   files that are not finished are taken away first. What the parent has told us to ignore (`nohup`) stays ignored.
//! - **Addresses** (Linux). Where there are few (`ulimit -v`), threads share one pool of memory.
//! - **Memory** (Linux). Of one picture what is freed is kept for what comes next: pages that go back to the system have to be cleared anew.
//! - **Stack** (Unix). The first thread has what the system gives it (`ulimit -s`); where that is little, another one does the work.
//! - **File sizes** (Unix). A file that grows past `ulimit -f` is an error of that file, not the end of the program.

use rayon::{ThreadBuilder, ThreadPoolBuilder};
use std::sync::mpsc::{Sender, channel};

/// Most threads of the pool, whatever `RAYON_NUM_THREADS` says: beyond this they only cost memory. Chosen; twice the threads of the
/// largest machines with two processors.
const MOST_THREADS: usize = 1024;

/// Makes ready for work, by threads of its own or without; done once, by the command line.
pub(super) fn prepare(has_threads: bool) {
    if has_threads {
        make_threads();
    }
    #[cfg(unix)]
    unix::watch_signals();
}

/// Begins the program anew with one pool of memory for all threads where addresses are few (`ulimit -v`): the system's C library
/// sets 64 MB of them aside for each thread (glibc; M_ARENA_MAX in mallopt(3)), and the program dies of what it never used.
#[cfg(target_os = "linux")]
pub(super) fn spare_addresses() {
    use rustix::process::{Resource, getrlimit};
    use std::os::unix::process::CommandExt;
    const ARENAS: &str = "MALLOC_ARENA_MAX";
    // Set by whoever began it, if not by this.
    if getrlimit(Resource::As).current.is_none() || std::env::var_os(ARENAS).is_some() {
        return;
    }
    let Ok(program) = std::env::current_exe() else { return };
    let mut arguments = std::env::args_os();
    let mut again = std::process::Command::new(program);
    if let Some(name) = arguments.next() {
        again.arg0(name);
    }
    // Comes back only if the system refuses: then it goes on as it is.
    drop(again.args(arguments).env(ARENAS, "1").exec());
}

/// Keeps memory that is freed, up to some bytes, for a program that ends with its work. The system's C library hands large pieces back at once,
/// and the next piece costs a fault for each of its pages (mallopt(3)). Measured on two cores, medians of seven: drafts of 1,000,000 and 100,000
/// atoms take 12 and 3 % less, stills of 10,000 as much as before; the peak of memory grows by a hundredth.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[expect(unsafe_code, reason = "the C library has no other way to say so")]
pub(super) fn keep_memory() {
    /// Pieces larger than this come from the system one by one: 1 GiB. Chosen.
    const LARGEST: libc::c_int = 1 << 30;
    /// What is asked of the system beyond what is needed: 1 MiB. Chosen.
    const MORE: libc::c_int = 1 << 20;
    let settings =
        [(libc::M_MMAP_THRESHOLD, LARGEST), (libc::M_TRIM_THRESHOLD, libc::c_int::MAX), (libc::M_TOP_PAD, MORE)];
    for (setting, value) in settings {
        // SAFETY: sets a number of the allocator, under its own lock; memory that was given stays as it is. What it refuses stays as it was.
        unsafe { libc::mallopt(setting, value) };
    }
}

/// See Linux: other C libraries have no such settings.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub(super) fn keep_memory() {}

/// See Linux: elsewhere threads share what there is.
#[cfg(not(target_os = "linux"))]
pub(super) fn spare_addresses() {}

/// Stack of the first thread that is enough for all commands, in bytes: what Rust gives all other threads. (With 64 KiB reading the command
/// line overflowed.)
#[cfg(unix)]
const STACK_ENOUGH: u64 = 2 << 20;

/// Does `work` on this thread if its stack is large enough, else on one whose stack is; on this one as well if there are no threads.
#[cfg(unix)]
pub(super) fn on_stack_enough<T: Send>(work: impl Fn() -> T + Sync) -> T {
    use rustix::process::{Resource, getrlimit};
    if getrlimit(Resource::Stack).current.is_none_or(|bytes| bytes >= STACK_ENOUGH) {
        return work();
    }
    let done = std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK_ENOUGH as usize);
        let started = thread.spawn_scoped(scope, &work).ok()?;
        Some(started.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    });
    done.unwrap_or_else(work)
}

/// Does `work`; the first thread's stack is as large as the program says (Windows).
#[cfg(not(unix))]
pub(super) fn on_stack_enough<T: Send>(work: impl Fn() -> T + Sync) -> T {
    work()
}

/// Threads as asked for by `RAYON_NUM_THREADS`, else one a core.
fn wanted() -> usize {
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.parse::<usize>().ok());
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    asked.filter(|&asked| asked > 0).unwrap_or_else(cores).min(MOST_THREADS)
}

/// Starts a thread that waits for its part of the pool.
fn start_thread(number: usize) -> std::io::Result<Sender<ThreadBuilder>> {
    let (give, get) = channel::<ThreadBuilder>();
    let wait = move || {
        if let Ok(part) = get.recv() {
            part.run();
        }
    };
    std::thread::Builder::new().name(format!("worker {number}")).spawn(wait)?;
    Ok(give)
}

fn make_threads() {
    let mut threads: Vec<Sender<ThreadBuilder>> = Vec::new();
    for number in 0..wanted() {
        match start_thread(number) {
            Ok(thread) => threads.push(thread),
            Err(_) => break,
        }
    }
    let made = if threads.is_empty() {
        ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()
    } else {
        let count = threads.len();
        let mut threads = threads.into_iter();
        let give = move |part: ThreadBuilder| {
            let thread = threads.next().ok_or_else(|| std::io::Error::other("there are no more threads"))?;
            thread.send(part).map_err(|_| std::io::Error::other("the thread has ended"))
        };
        ThreadPoolBuilder::new().num_threads(count).spawn_handler(give).build_global()
    };
    // There is one already where a program calls this twice, as tests do.
    drop(made);
}

#[cfg(unix)]
mod unix {
    use crate::export::unfinished;
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::iterator::Signals;
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    pub(super) fn watch_signals() {
        // With a handler that does nothing the write fails in place of the program.
        drop(signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false))));
        let ignored = ignored();
        let wanted: Vec<i32> =
            [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|&signal| !ignores(ignored, signal)).collect();
        // The handler is set by the thread itself: without it signals must keep their usual effect.
        let watch = move || {
            let Ok(mut signals) = Signals::new(wanted) else { return };
            if let Some(signal) = signals.forever().next() {
                unfinished::abandon();
                drop(signal_hook::low_level::emulate_default_handler(signal));
                std::process::exit(128 + signal); // if the signal did not end it
            }
        };
        drop(std::thread::Builder::new().name("signals".to_owned()).spawn(watch));
    }

    /// The signals that the parent told us to ignore, as Linux shows them; none where it does not.
    fn ignored() -> u64 {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
    }

    fn ignores(mask: u64, signal: i32) -> bool {
        u32::try_from(signal - 1).is_ok_and(|bit| mask.checked_shr(bit).unwrap_or(0) & 1 == 1)
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn the_mask_has_signal_1_in_its_lowest_bit() {
            assert!(ignores(0b1, SIGHUP) && ignores(0b10, SIGINT) && !ignores(0b1, SIGINT));
            assert!(!ignores(0, SIGTERM) && ignores(1 << 14, SIGTERM));
        }
    }
}
