//! Whether there is memory for what is asked, said before it is used up: a program that runs out of memory can only be ended by the
//! system, in the middle and without a word about its file.
//!
//! What is needed is told low, so that nothing is refused that might have gone: what reading, drawing and the picture take at
//! the least. What there is, is the least of the limits of the process (`ulimit -v`, `ulimit -d`), of its control group (containers,
//! batch systems; version 2) and of the machine with its swap space.
//!
//! (With `ulimit -v` threads share one pool of memory, see [`super::process`]; else addresses that nobody uses would count.)
//!
//! Limits: what a packed file unpacks to is not known before; light from afar takes more than is counted here. Under a limit of the process
//! itself that costs one input only ([`super::apart`]). Only Linux tells
//! control group and machine; elsewhere the process' own limits count alone. Memory that others take meanwhile is not seen.

use super::values::Region;
use crate::error::{Error, Result};
use crate::export::picture::PictureFormat;
use std::path::Path;

/// Bytes of memory a byte of file takes at the least, while it is read, a thousandth each. A million atoms of mmCIF
/// take 1.96, of PDB 2.57, of XYZ 5.6.
const FILE_THOUSANDTHS: u64 = 1800;

/// Bytes an atom with its bonds takes from the structure to a picture without light from afar; a million atoms of a protein take 365.
const ATOM_BYTES: u64 = 250;

/// Pixels that are held at once: what [`super::strips`] makes a strip of.
const STRIP_PIXELS: u64 = 1 << 24;

/// Bytes of such a pixel (16,000,000 of them take 62 MB).
const PIXEL_BYTES: u64 = 4;

/// An upper bound of what there is, and where it comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Room {
    bytes: u64,
    bound: &'static str,
}

/// What any work takes beside the program itself: below this even an error could not be said. Chosen; where 3 MB were left, threads
/// could not be started.
const LEAST_BYTES: u64 = 8 << 20;

/// What a graphics driver may take of a process' own limit. Drivers do not look whether they get memory: Mesa's lavapipe ends the program by
/// signal 11 at 1.3 GB for any picture, and at 1.6 GB for one of 400,000 atoms (2 GB are enough); twice that.
const DRIVER_BYTES: u64 = 4 << 30;

/// Why no graphics device should be used: the process' own limits leave too little. The machine's memory is the driver's to ask for.
pub(super) fn too_little_for_drivers() -> Option<String> {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let limits = [(false, "ulimit -v"), (true, "ulimit -d")];
    let mut left = limits.into_iter().filter_map(|(data, name)| Some((process_limit(data, &status)?, name)));
    let (bytes, name) = left.find(|&(bytes, _)| bytes < DRIVER_BYTES)?;
    let (there, needed) = (bytes / 1_000_000, DRIVER_BYTES / 1_000_000);
    Some(format!(
        "{name} leaves {there} MB, and graphics drivers may end the program where they do not get {needed} MB"
    ))
}

/// The least limit of the process itself, whatever is used of it, and its name.
pub(super) fn process_bound() -> Option<(u64, &'static str)> {
    [(false, "ulimit -v"), (true, "ulimit -d")]
        .into_iter()
        .filter_map(|(data, name)| Some((process_limit(data, "")?, name)))
        .min()
}

/// Refuses any work where there is next to no memory.
///
/// # Errors
/// [`Error::Unsupported`] with what is needed and what there is.
pub(super) fn check_start() -> Result<()> {
    room().map_or(Ok(()), |room| fits("any work", LEAST_BYTES, room))
}

/// Refuses a file that cannot be read in the memory there is.
///
/// # Errors
/// [`Error::Unsupported`] with what is needed and what there is.
pub(super) fn check_file(path: &Path) -> Result<()> {
    let bytes = std::fs::metadata(path).map_or(0, |metadata| if metadata.is_file() { metadata.len() } else { 0 });
    check("reading it", bytes.saturating_mul(FILE_THOUSANDTHS) / 1000)
}

/// Refuses a picture that cannot be drawn in the memory there is.
///
/// # Errors
/// [`Error::Unsupported`] with what is needed and what there is.
pub(super) fn check_picture(atoms: usize, region: Region, format: PictureFormat) -> Result<()> {
    // A process of its own may be tried again with thin strips.
    let strip = if super::apart::own_input().is_some() { super::strips::SPARED_PIXELS.into() } else { STRIP_PIXELS };
    let pixels = u64::from(region.width) * u64::from(region.height);
    check("drawing it", picture_bytes(atoms as u64, (pixels, strip), format))
}

/// `strip` is how many of the pixels are held at once.
fn picture_bytes(atoms: u64, (pixels, strip): (u64, u64), format: PictureFormat) -> u64 {
    // Kept whole with what becomes of them, measured with 64,000,000 pixels.
    let whole = match format {
        PictureFormat::Jpeg => 3,
        PictureFormat::WebP => 7,
        _ => 0,
    };
    let strip = pixels.min(strip) * PIXEL_BYTES;
    atoms.saturating_mul(ATOM_BYTES).saturating_add(strip).saturating_add(pixels.saturating_mul(whole))
}

fn check(what: &str, needed: u64) -> Result<()> {
    // Nothing is asked for what any machine has.
    if needed < 16 << 20 {
        return Ok(());
    }
    match room() {
        Some(room) => fits(what, needed, room),
        None => Ok(()),
    }
}

fn fits(what: &str, needed: u64, room: Room) -> Result<()> {
    if needed <= room.bytes {
        return Ok(());
    }
    let megabytes = |bytes: u64| bytes.div_ceil(1_000_000);
    let (needed, there, bound) = (megabytes(needed), room.bytes / 1_000_000, room.bound);
    Err(Error::Unsupported(format!("{what} needs at least {needed} MB of memory, and {bound} leaves {there} MB")))
}

/// The least of all bounds that the system tells.
fn room() -> Option<Room> {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let machine = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let free =
        kibibytes(&machine, "MemAvailable:").map(|memory| memory + kibibytes(&machine, "SwapFree:").unwrap_or(0));
    let bounds = [
        process_limit(false, &status).map(|bytes| Room { bytes, bound: "the limit of this process (ulimit -v)" }),
        process_limit(true, &status).map(|bytes| Room { bytes, bound: "the limit of this process (ulimit -d)" }),
        group_room().map(|bytes| Room { bytes, bound: "the limit of this container or batch job" }),
        free.map(|bytes| Room { bytes, bound: "this machine" }),
    ];
    bounds.into_iter().flatten().min_by_key(|room| room.bytes)
}

/// A number of kibibytes that a file of the system has behind a key, in bytes.
fn kibibytes(text: &str, key: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// What the limit of addresses, or that of data, leaves.
#[cfg(unix)]
fn process_limit(data: bool, status: &str) -> Option<u64> {
    use rustix::process::{Resource, getrlimit};
    let (resource, key) = if data { (Resource::Data, "VmData:") } else { (Resource::As, "VmSize:") };
    let limit = getrlimit(resource).current?;
    Some(limit.saturating_sub(kibibytes(status, key).unwrap_or(0)))
}

#[cfg(not(unix))]
fn process_limit(_data: bool, _status: &str) -> Option<u64> {
    None
}

/// What the control groups leave, the own one and all that it is in (batch systems limit one of those).
fn group_room() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let own = groups.lines().find_map(|line| line.strip_prefix("0::/"))?;
    room_under(Path::new("/sys/fs/cgroup"), Path::new(own))
}

/// The least that any group from the root's child down to `own` leaves; what a group keeps of files counts as free. `None` where
/// none has a limit.
fn room_under(root: &Path, own: &Path) -> Option<u64> {
    let room = |group: &Path| {
        let folder = root.join(group);
        let limit: u64 = std::fs::read_to_string(folder.join("memory.max")).ok()?.trim().parse().ok()?;
        let used = std::fs::read_to_string(folder.join("memory.stat")).ok()?;
        let used: u64 = used.lines().find_map(|line| line.strip_prefix("anon "))?.trim().parse().ok()?;
        Some(limit.saturating_sub(used))
    };
    own.ancestors().filter_map(room).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_said_with_both_numbers_and_whose_limit_it_is() {
        let room = Room { bytes: 100_000_000, bound: "this machine" };
        assert!(fits("reading it", 100_000_000, room).is_ok());
        let error = fits("reading it", 100_000_001, room).unwrap_err().to_string();
        assert_eq!(error, "reading it needs at least 101 MB of memory, and this machine leaves 100 MB");
    }

    #[test]
    fn only_pictures_that_are_gathered_grow_with_all_their_pixels() {
        let bytes = |pixels, format| picture_bytes(0, (pixels, STRIP_PIXELS), format);
        assert_eq!(bytes(1 << 30, PictureFormat::Png), bytes(1 << 24, PictureFormat::Png));
        assert_eq!(bytes(1 << 30, PictureFormat::Jpeg) - bytes(1 << 30, PictureFormat::Png), 3 << 30);
        assert_eq!(picture_bytes(1_000_000, (0, 0), PictureFormat::Png), 250_000_000);
        assert_eq!(picture_bytes(u64::MAX, (u64::MAX, STRIP_PIXELS), PictureFormat::WebP), u64::MAX);
    }

    #[test]
    fn the_tightest_group_counts_whichever_it_is() {
        let root = tempfile::tempdir().unwrap();
        let own = Path::new("job/step/task");
        std::fs::create_dir_all(root.path().join(own)).unwrap();
        let limit = |group: &str, limit: &str, used: u64| {
            let folder = root.path().join(group);
            std::fs::write(folder.join("memory.max"), format!("{limit}\n")).unwrap();
            std::fs::write(folder.join("memory.stat"), format!("anon {used}\nfile 900\n")).unwrap();
        };
        assert_eq!(room_under(root.path(), own), None);
        limit("job/step/task", "max", 10);
        assert_eq!(room_under(root.path(), own), None);
        limit("job", "5000", 1000);
        assert_eq!(room_under(root.path(), own), Some(4000));
        limit("job/step", "4000", 500);
        assert_eq!(room_under(root.path(), own), Some(3500));
        limit("job/step/task", "100", 200);
        assert_eq!(room_under(root.path(), own), Some(0));
    }

    #[test]
    fn numbers_of_the_system_are_found_by_their_key() {
        let text = "MemTotal:       24000000 kB\nMemAvailable:   20971520 kB\n";
        assert_eq!(kibibytes(text, "MemAvailable:"), Some(20 << 30));
        assert_eq!((kibibytes(text, "SwapFree:"), kibibytes("SwapFree: many kB", "SwapFree:")), (None, None));
    }
}
