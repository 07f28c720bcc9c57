//! `ballstick devices`: the graphics devices, and which renderer Auto picks and why.

use super::report::{Report, printable};
use std::io::Write;

/// What there is to draw with.
pub(super) struct Devices {
    /// Vector instructions of the CPU renderer.
    pub(super) simd: &'static str,
    /// Graphics adapters, best first.
    pub(super) adapters: Vec<Adapter>,
    /// Why there are none, or may be more.
    pub(super) note: Option<String>,
    /// Name of the renderer Auto picks and the reason; or why there is none.
    pub(super) choice: Result<(String, String), String>,
}

/// A graphics adapter.
pub(super) struct Adapter {
    pub(super) name: String,
    /// `Vulkan`, `Metal`, …
    pub(super) backend: String,
    /// `discrete GPU`, `software`, …
    pub(super) kind: String,
    /// Driver and its version, empty if it does not say.
    pub(super) driver: String,
}

pub(super) fn run(devices: &Devices, report: &Report) {
    let text = describe(devices);
    let mut out = std::io::stdout().lock();
    let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    match written {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            report.fail_with(&format!("cannot write -: {error}"));
        }
        _ => {}
    }
    if let Err(message) = &devices.choice {
        report.fail_with(message);
    }
}

fn describe(devices: &Devices) -> String {
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let mut lines = vec![format!("CPU renderer: {threads} threads, {}", devices.simd)];
    for adapter in &devices.adapters {
        let Adapter { name, backend, kind, driver } = adapter;
        let driver = if driver.is_empty() { String::new() } else { format!(", {driver}") };
        lines.push(format!("{backend}: {name} ({kind}{driver})"));
    }
    if devices.adapters.is_empty() {
        lines.push("No graphics adapter.".to_owned());
    }
    lines.extend(devices.note.clone());
    if let Ok((name, reason)) = &devices.choice {
        lines.push(format!("--renderer auto uses {name}: {reason}"));
    }
    lines.iter().map(|line| printable(line) + "\n").collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn adapters_and_the_choice_are_listed() {
        let adapter = Adapter {
            name: "llvmpipe".to_owned(),
            backend: "Vulkan".to_owned(),
            kind: "software".to_owned(),
            driver: "Mesa 25".to_owned(),
        };
        let choice = Ok(("cpu".to_owned(), "the only adapter is a software one".to_owned()));
        let text = describe(&Devices { simd: "avx2", adapters: vec![adapter], note: None, choice });
        assert!(text.starts_with("CPU renderer: ") && text.contains(" threads, avx2\n"), "{text}");
        assert!(text.contains("\nVulkan: llvmpipe (software, Mesa 25)\n"), "{text}");
        assert!(text.ends_with("--renderer auto uses cpu: the only adapter is a software one\n"));
    }
}
