//! Many pictures in one run: which of them are made here, on which cores, and what is said in the end.
//!
//! Small files are drawn several at a time, each on one thread: no core waits for another one. What is large is drawn by all cores, one
//! after the other, when the small ones are done. A graphics device draws one after the other as well: there is one. The pictures are the
//! same to the last bit either way. One bad file costs its own picture only, and memory does not grow with the number of files.

use super::picture::Draw;
use super::plan::{Picture, Plan};
use super::report::Report;
use crate::error::{Error, Result};
use crate::export::atomic;
use clap::Args;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Instant, SystemTime};

/// Bytes of a file from which on all cores draw it together. Chosen: some 100,000 atoms of a PDB file, whose picture keeps a core
/// busy for a second; several at a time of larger ones would take as many times the memory.
const LARGE_BYTES: u64 = 8 << 20;
/// The same of packed files, which hold about four times as much.
const LARGE_PACKED_BYTES: u64 = LARGE_BYTES / 4;
/// Pixels of a picture from which on all cores draw it together: those of a 4K screen. Chosen: 16 samples of as many take a core seconds.
const LARGE_PIXELS: u64 = 3840 * 2160;

/// Stack of a thread that draws alone: what the first thread of a program usually has.
const STACK_BYTES: usize = 8 << 20;

/// Which of many pictures are made.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct BatchArgs {
    /// Make no picture that is there: whole, and not older than its file. So a run that was stopped goes on where it was
    #[arg(long, help_heading = "Running")]
    pub skip_existing: bool,
    /// Make only the I-th of N shares of the pictures, counted from 1: every N-th one from the I-th on, in the order of the FILEs.
    /// For job arrays: each job the same command with a number of its own
    #[arg(long, value_name = "I/N", help_heading = "Running")]
    pub shard: Option<Shard>,
}

/// One of several shares.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// From 0.
    index: usize,
    count: usize,
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Shard, String> {
        let expected = || "expected I/N, such as 1/8: the first of eight shares".to_owned();
        let (index, count) = text.split_once('/').ok_or_else(expected)?;
        let number = |text: &str| text.trim().parse::<u32>().map_err(|_| expected());
        let (index, count) = (number(index)?, number(count)?);
        if index == 0 || index > count {
            return Err(format!("{}, with I from 1 to N", expected()));
        }
        Ok(Shard { index: index as usize - 1, count: count as usize })
    }
}

/// What became of the pictures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Tally {
    drawn: usize,
    skipped: usize,
    failed: usize,
}

/// Leaves only what is to be made here in the plan, and says how many are skipped. An error is one of usage.
pub(super) fn choose(plan: &mut Plan, args: BatchArgs, also: &[PathBuf]) -> Result<usize, String> {
    if let Some(Shard { index, count }) = args.shard {
        if !plan.is_each {
            return Err("--shard needs one picture of each FILE: -o a folder, or a name with {stem}".to_owned());
        }
        let mut place = 0;
        plan.pictures.retain(|_| {
            place += 1;
            (place - 1) % count == index
        });
        // What is wrong with the list is said once.
        if index > 0 {
            plan.clashes.clear();
        }
    }
    let before = plan.pictures.len();
    if args.skip_existing {
        plan.pictures.retain(|picture| !is_there(picture, also));
    }
    Ok(before - plan.pictures.len())
}

/// Whether a picture is there, whole, and not older than what it is made of.
fn is_there(picture: &Picture, also: &[PathBuf]) -> bool {
    if atomic::is_stdout(&picture.output) || !is_whole(&picture.output).unwrap_or(false) {
        return false;
    }
    let time = |path: &Path| -> Option<SystemTime> { std::fs::metadata(path).ok()?.modified().ok() };
    let Some(made) = time(&picture.output) else { return false };
    let files = picture.inputs.iter().flat_map(|input| std::iter::once(&input.structure).chain(&input.trajectories));
    files.chain(also).all(|file| match time(file) {
        Some(changed) => changed <= made,
        // The program's own molecules never change; of anything else that is not there the error is wanted.
        None => crate::session::samples::of_path(file).is_some(),
    })
}

/// Whether a file is a picture from its beginning to its end. Ours always are, as they get their name last; this is for those of
/// others, and of disks that lost their power.
fn is_whole(path: &Path) -> std::io::Result<bool> {
    let mut file = std::fs::File::open(path)?;
    let length = file.metadata()?.len();
    let mut head = [0; 12];
    if length < 16 || file.metadata()?.is_dir() {
        return Ok(false);
    }
    file.read_exact(&mut head)?;
    let mut tail = [0; 12];
    file.seek(SeekFrom::End(-12))?;
    file.read_exact(&mut tail)?;
    Ok(match &head {
        [0x89, b'P', b'N', b'G', ..] => tail[4..8] == *b"IEND",
        [0xFF, 0xD8, ..] => tail[10..] == [0xFF, 0xD9],
        [b'R', b'I', b'F', b'F', size @ ..] => {
            let [a, b, c, d, ..] = *size;
            u64::from(u32::from_le_bytes([a, b, c, d])) + 8 <= length
        }
        // A GIF ends with a semicolon.
        [b'G', b'I', b'F', ..] => tail[11] == b';',
        _ => true,
    })
}

/// Makes one picture; `false` if none came of it, which was said.
pub(super) type Make<'a> = &'a (dyn Fn(&Picture, &Report, &mut dyn Draw) -> Result<bool> + Sync);

/// Makes what is planned: what fails is said, and the others are made. A reader that has gone ends it.
pub(super) fn run(
    plan: &Plan,
    pixels: u64,
    skipped: usize,
    (report, draw): (&Report, &mut dyn Draw),
    make: Make<'_>,
) -> Tally {
    let mut tally = Tally { skipped, failed: plan.clashes.len(), ..Tally::default() };
    if let Some(folder) = &plan.new_folder
        && !plan.pictures.is_empty()
        && let Err(source) = std::fs::create_dir_all(folder)
    {
        report.fail(folder, &Error::Io { action: "make the folder", path: folder.clone(), source });
        tally.failed += plan.pictures.len();
        return tally;
    }
    for clash in &plan.clashes {
        report.fail_with(&clash.to_string());
    }
    let batch =
        Batch { report, make, done: AtomicUsize::new(0), drawn: AtomicUsize::new(0), ended: AtomicBool::new(false) };
    // Without room for threads not even those of the pool are begun.
    let threads = if super::apart::is_tight() { 1 } else { rayon::current_num_threads() };
    let (alone, large): (Vec<&Picture>, Vec<&Picture>) =
        plan.pictures.iter().partition(|picture| pixels <= LARGE_PIXELS && is_small(picture));
    // A few are done sooner by all cores.
    let workers = if threads > 1 && alone.len() > threads { draw.workers() } else { None };
    let together = match workers {
        Some(new) => {
            batch.at_once(&alone, threads, new.as_ref());
            large
        }
        None => plan.pictures.iter().collect(),
    };
    for notice in draw.notices() {
        report.line(&format!("ballstick: warning: {notice}"));
    }
    for picture in together {
        batch.one(picture, draw);
    }
    tally.drawn = batch.drawn.into_inner();
    tally.failed += plan.pictures.len() - tally.drawn;
    tally
}

/// Whether a picture is one for a single core.
fn is_small(picture: &Picture) -> bool {
    let size = |path: &PathBuf| std::fs::metadata(path).map_or(0, |metadata| metadata.len());
    let is_packed = |path: &Path| {
        let extension = path.extension().unwrap_or_default();
        ["gz", "zst", "bcif"].iter().any(|packed| extension.eq_ignore_ascii_case(packed))
    };
    picture.inputs.iter().all(|input| {
        let most = if is_packed(&input.structure) { LARGE_PACKED_BYTES } else { LARGE_BYTES };
        // Trajectories are read frame by frame.
        size(&input.structure) < most
    })
}

struct Batch<'a> {
    report: &'a Report,
    make: Make<'a>,
    done: AtomicUsize,
    drawn: AtomicUsize,
    /// Whether nobody reads what is written.
    ended: AtomicBool,
}

impl Batch<'_> {
    fn one(&self, picture: &Picture, draw: &mut dyn Draw) {
        if self.ended.load(Ordering::Relaxed) {
            return;
        }
        self.report.step(self.done.load(Ordering::Relaxed), &picture.output.to_string_lossy());
        let mut finished = false;
        let result = super::guarded(|| {
            let result = (self.make)(picture, self.report, draw);
            finished = true;
            result
        });
        if !finished {
            draw.reset();
        }
        match result {
            Ok(drawn) => drop(self.drawn.fetch_add(usize::from(drawn), Ordering::Relaxed)),
            Err(error) if atomic::is_broken_pipe(&error) => self.ended.store(true, Ordering::Relaxed),
            Err(error) => self.report.fail(&picture.inputs[0].structure, &error),
        }
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    /// As many pictures at a time as there are threads, each drawn by its own.
    fn at_once(&self, pictures: &[&Picture], threads: usize, new: &(dyn Fn() -> Box<dyn Draw> + Sync)) {
        let next = AtomicUsize::new(0);
        let work = || {
            // What is shared out inside of a picture stays on this thread.
            let builder = rayon::ThreadPoolBuilder::new().num_threads(1).stack_size(STACK_BYTES);
            let Ok(pool) = builder.build() else { return };
            pool.install(|| {
                let mut draw = new();
                while let Some(picture) = pictures.get(next.fetch_add(1, Ordering::Relaxed)) {
                    self.one(picture, draw.as_mut());
                }
            });
        };
        std::thread::scope(|scope| {
            for _ in 1..threads {
                // Where the system gives no more threads the others do its share.
                let _ = std::thread::Builder::new().name("batch".to_owned()).spawn_scoped(scope, work);
            }
            work();
        });
        // Where not one could be had.
        let mut draw = new();
        while let Some(picture) = pictures.get(next.fetch_add(1, Ordering::Relaxed)) {
            self.one(picture, draw.as_mut());
        }
    }
}

impl Tally {
    /// One line for people.
    pub(super) fn words(self, since: Instant) -> String {
        let seconds = since.elapsed().as_secs_f64();
        let Tally { drawn, skipped, failed } = self;
        let rate = (drawn + failed) as f64 / seconds.max(1e-3);
        format!("{drawn} drawn, {skipped} skipped, {failed} failed in {seconds:.1} s ({rate:.1} files/s)")
    }

    /// Whether there is anything to sum up.
    pub(super) fn is_batch(self) -> bool {
        self.drawn + self.skipped + self.failed > 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::plan;

    fn files(count: usize) -> Vec<PathBuf> {
        (1..=count).map(|n| PathBuf::from(format!("{n}.xyz"))).collect()
    }

    #[test]
    fn shares_are_disjoint_and_together_everything() {
        let mut all = Vec::new();
        for share in 1..=3 {
            let (mut plan, _) = plan::plan(&files(10), Path::new("o/"), None).unwrap();
            let args = BatchArgs { shard: Some(format!("{share}/3").parse().unwrap()), ..BatchArgs::default() };
            assert_eq!(choose(&mut plan, args, &[]), Ok(0));
            assert_eq!(plan.pictures[0].output, Path::new("o").join(format!("{share}.png")));
            all.extend(plan.pictures.into_iter().map(|picture| picture.output));
        }
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 10);
        for wrong in ["0/3", "4/3", "1", "1/0", "a/b", "-1/2"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
        let (mut plan, _) = plan::plan(&files(2), Path::new("o.png"), None).unwrap();
        let args = BatchArgs { shard: "1/2".parse().ok(), ..BatchArgs::default() };
        assert!(choose(&mut plan, args, &[]).unwrap_err().contains("--shard"));
    }

    #[test]
    fn only_what_is_whole_and_newer_is_skipped() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let png = b"\x89PNG\r\n\x1a\n and so on \0\0\0\0IEND\xaeB\x60\x82";
        let hour = std::time::Duration::from_secs(3600);
        let now = SystemTime::now();
        let write = |name: &str, bytes: &[u8], time: SystemTime| {
            std::fs::write(path(name), bytes).unwrap();
            std::fs::File::options().write(true).open(path(name)).unwrap().set_modified(time).unwrap();
        };
        for name in ["whole", "cut", "old", "missing"] {
            write(&format!("{name}.xyz"), b"1\n\nC 0 0 0\n", now - hour);
        }
        write("whole.png", png, now);
        write("cut.png", &png[..png.len() - 1], now);
        write("old.png", png, now - 2 * hour);
        write("gone.png", png, now);
        let names: Vec<PathBuf> = ["whole", "cut", "old", "missing", "gone"].map(|n| path(&format!("{n}.xyz"))).into();
        let left = |also: &[PathBuf]| {
            let (mut plan, _) = plan::plan(&names, folder.path(), None).unwrap();
            let skipped = choose(&mut plan, BatchArgs { skip_existing: true, shard: None }, also).unwrap();
            (skipped, plan.pictures.len())
        };
        assert_eq!(left(&[]), (1, 4));
        write("mesh.obj", b"", now + hour);
        assert_eq!(left(&[path("mesh.obj")]), (0, 5));
    }

    #[test]
    fn a_tally_says_what_became_of_all() {
        let tally = Tally { drawn: 3, skipped: 2, failed: 1 };
        assert!(tally.words(Instant::now()).starts_with("3 drawn, 2 skipped, 1 failed in 0.0 s ("));
        assert!(tally.is_batch() && !Tally { drawn: 1, ..Tally::default() }.is_batch());
    }
}
