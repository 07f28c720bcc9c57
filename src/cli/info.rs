//! `ballstick info`: what is in a file, for people or as one JSON object a line.
//!
//! Atoms, bonds and the rest are those of the first record as listed: its first frame, all alternate locations.
//! `frames` counts those of all records, or, where a trajectory follows its structure, of that (`trajectories` says more). `bond_orders` counts covalent bonds of order 1 to 3,
//! aromatic ones only as that. `--explain-bonds` adds the reason of every bond.

use super::apart;
use super::args::InfoArgs;
use super::assembly::AssemblyInfo;
use super::explain::Explanations;
use super::load::{bond_options, count_orders};
use super::report::{Report, printable};
use crate::element::Element;
use crate::error::{Error, Result};
use crate::export::tidy;
use crate::import::trajectory::{Input, Trajectory, inputs, read_input};
use crate::import::{Document, ImportOptions};
use crate::session::samples;
use crate::structure::{Bond, Diagnostic, Severity, Structure};
use crate::{bonds, export::atomic};
use serde::Serialize;
use std::collections::{BTreeMap, HashSet};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// The keys of `info --json`, in this order.
#[derive(Debug, Serialize)]
struct Info {
    path: String,
    format: &'static str,
    title: String,
    atoms: usize,
    bonds: usize,
    bond_orders: Orders,
    elements: BTreeMap<&'static str, usize>,
    formula: String,
    chains: usize,
    residues: usize,
    frames: usize,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    trajectories: Vec<TrajectoryInfo>,
    cell: Option<CellInfo>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    assemblies: Vec<AssemblyInfo>,
    diagnostics: Vec<DiagnosticInfo>,
    #[serde(flatten)]
    explanations: Option<Explanations>,
    #[serde(skip)]
    records: usize,
}

/// A trajectory of the structure. Times are in picoseconds, those of the first and the last frame.
#[derive(Debug, Serialize)]
struct TrajectoryInfo {
    path: String,
    format: &'static str,
    frames: usize,
    first_ps: Option<f64>,
    last_ps: Option<f64>,
}

impl TrajectoryInfo {
    fn of(trajectory: &Trajectory) -> TrajectoryInfo {
        let frames = trajectory.known_frames();
        // Single precision's own digits: 0.1, not 0.10000000149011612.
        let short = |time: f64| match f64::from(time as f32) == time {
            true => (time as f32).to_string().parse().unwrap_or(time),
            false => tidy(time),
        };
        let time = |frame: usize| trajectory.time_ps(frame).ok().flatten().map(short);
        TrajectoryInfo {
            path: trajectory.path().to_string_lossy().into_owned(),
            format: trajectory.format().name(),
            frames,
            first_ps: time(0),
            last_ps: time(frames.saturating_sub(1)),
        }
    }
}

#[derive(Debug, Serialize)]
struct Orders {
    #[serde(rename = "1")]
    single: usize,
    #[serde(rename = "2")]
    double: usize,
    #[serde(rename = "3")]
    triple: usize,
    aromatic: usize,
}

#[derive(Debug, Serialize)]
struct CellInfo {
    a: f64,
    b: f64,
    c: f64,
    alpha: f64,
    beta: f64,
    gamma: f64,
}

#[derive(Debug, Serialize)]
struct DiagnosticInfo {
    severity: &'static str,
    line: Option<u64>,
    message: String,
}

/// What `info --json` prints for a file that cannot be read.
#[derive(Debug, Serialize)]
struct Failure {
    path: String,
    error: FailureReason,
}

#[derive(Debug, Serialize)]
struct FailureReason {
    line: Option<u64>,
    message: String,
}

pub(super) fn run(args: &InfoArgs, report: &mut Report) {
    let inputs = inputs(&args.files);
    report.start(inputs.len());
    let is_apart = apart::is_wanted();
    // How another process ended that was to do it.
    let mut ended = None;
    for (index, input) in inputs.iter().enumerate() {
        let path = &input.structure;
        if apart::own_input().is_some_and(|own| own != index) {
            continue;
        }
        report.step(index, &path.to_string_lossy());
        if is_apart {
            let files = std::iter::once(&input.structure).chain(&input.trajectories);
            let files: Vec<&Path> = files.map(PathBuf::as_path).collect();
            match apart::run(index, &files, None, report) {
                Ok(_) => continue,
                Err(error) => ended = Some(error),
            }
        }
        let read = || ended.take().map_or_else(|| read(input, args, report), Err);
        let text = match super::guarded(read) {
            Ok(info) if args.json => json_line(&info),
            Ok(info) => people_text(&info),
            Err(error) => {
                report.fail(path, &error);
                if !args.json {
                    continue;
                }
                json_line(&failure(path, &error))
            }
        };
        if let Err(error) = print(&text) {
            if !atomic::is_broken_pipe(&error) {
                report.fail(path, &error);
            }
            return; // nobody listens
        }
    }
}

fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    written.map_err(|source| Error::Io { action: "write", path: PathBuf::from("-"), source })
}

fn read(input: &Input, args: &InfoArgs, report: &Report) -> Result<Info> {
    let path = &input.structure;
    super::memory::check_file(path)?;
    let options = ImportOptions::default();
    let mut document =
        if samples::of_path(path).is_some() { samples::read(path, &options)? } else { read_input(input, &options)? };
    let trajectories = document.trajectories.clone();
    for trajectory in &trajectories {
        let was_counted = trajectory.is_counted();
        trajectory.count_frames(|| true)?;
        if let Some(problem) = trajectory.problem().filter(|_| !was_counted) {
            let message = format!("{}: {problem}", trajectory.path().display());
            document.diagnostics.push(Diagnostic { severity: Severity::Warning, line: None, message });
        }
    }
    if !args.json {
        // In JSON they are in the object.
        for diagnostic in &document.diagnostics {
            report.diagnostic(path, diagnostic);
        }
    }
    let structure = document.records.first().ok_or_else(|| Error::input(None, "there is no molecule in it"))?;
    let bonds = bonds::find(structure, 0, &bond_options(args.bonds));
    let mut info = summary(path, &document, structure, &bonds);
    info.trajectories = trajectories.iter().map(|trajectory| TrajectoryInfo::of(trajectory)).collect();
    info.explanations = args.explain_bonds.then(|| Explanations::new(structure, args.bonds));
    Ok(info)
}

fn summary(path: &Path, document: &Document, structure: &Structure, bonds: &[Bond]) -> Info {
    let mut counts = [0usize; 256];
    for element in structure.elements() {
        counts[usize::from(element.z())] += 1;
    }
    let present = (0u8..=Element::MAX_Z).filter(|&z| counts[usize::from(z)] > 0);
    let elements: BTreeMap<&'static str, usize> =
        present.map(|z| (Element::from_z(z).unwrap_or(Element::DUMMY).symbol(), counts[usize::from(z)])).collect();
    let [single, double, triple, aromatic] = count_orders(bonds);
    let residues: HashSet<_> =
        structure.residues().iter().map(|r| (r.chain, r.number, r.insertion_code, r.name)).collect();
    let title = match structure.title() {
        "" => structure.frames().first().map_or("", |frame| &frame.title),
        title => title,
    };
    Info {
        path: path.to_string_lossy().into_owned(),
        format: document.format.name(),
        title: title.to_owned(),
        atoms: structure.atom_count(),
        bonds: bonds.len(),
        bond_orders: Orders { single, double, triple, aromatic },
        formula: hill_formula(&elements),
        elements,
        chains: structure.chains().len(),
        residues: residues.len(),
        frames: document.frame_count(),
        trajectories: Vec::new(),
        cell: structure.cell().map(|cell| {
            let ([a, b, c], [alpha, beta, gamma]) = (cell.lengths().map(tidy), cell.angles_deg().map(tidy));
            CellInfo { a, b, c, alpha, beta, gamma }
        }),
        assemblies: AssemblyInfo::all(structure),
        diagnostics: document
            .diagnostics
            .iter()
            .map(|d| DiagnosticInfo { severity: d.severity.name(), line: d.line, message: d.message.clone() })
            .collect(),
        explanations: None,
        records: document.records.len(),
    }
}

/// Hill's order (J. Am. Chem. Soc. 1900, 22, 478): with carbon, C, H, then the rest by letter; without, all by letter.
/// What is no element is left out.
fn hill_formula(elements: &BTreeMap<&'static str, usize>) -> String {
    let first: &[&str] = if elements.contains_key("C") { &["C", "H"] } else { &[] };
    let rest = elements.keys().copied().filter(|symbol| !first.contains(symbol) && *symbol != "X");
    let mut formula = String::new();
    for symbol in first.iter().copied().chain(rest) {
        match elements.get(symbol) {
            Some(1) => formula.push_str(symbol),
            Some(count) => drop(write!(formula, "{symbol}{count}")), // writing to a String cannot fail
            None => {}
        }
    }
    formula
}

fn failure(path: &Path, error: &Error) -> Failure {
    let message = match error {
        // The line has a key of its own.
        Error::Input { message, .. } | Error::Limit { message, .. } => message.clone(),
        other => other.to_string(),
    };
    Failure { path: path.to_string_lossy().into_owned(), error: FailureReason { line: error.line(), message } }
}

fn json_line(value: &impl Serialize) -> String {
    // Strings and numbers in structs: this cannot fail.
    serde_json::to_string(value).map_or_else(|_| String::new(), |text| text + "\n")
}

fn people_text(info: &Info) -> String {
    let mut lines = vec![match info.title.as_str() {
        "" => info.path.clone(),
        title => format!("{}: {title}", info.path),
    }];
    let mut row = |name: &str, value: String| lines.push(format!("  {name:<9} {value}"));
    row("format", info.format.to_owned());
    row("atoms", format!("{}  {}", info.atoms, info.formula).trim_end().to_owned());
    let orders = &info.bond_orders;
    let mut kinds = vec![
        (orders.single, "single"),
        (orders.double, "double"),
        (orders.triple, "triple"),
        (orders.aromatic, "aromatic"),
    ];
    let other = info.bonds - kinds.iter().map(|(count, _)| count).sum::<usize>().min(info.bonds);
    kinds.push((other, "other"));
    let kinds: Vec<String> =
        kinds.iter().filter(|(count, _)| *count > 0).map(|(count, name)| format!("{count} {name}")).collect();
    let kinds = if kinds.is_empty() { String::new() } else { format!("  ({})", kinds.join(", ")) };
    row("bonds", format!("{}{kinds}", info.bonds));
    if info.residues > 0 {
        row("residues", info.residues.to_string());
        row("chains", info.chains.to_string());
    }
    if info.records > 1 {
        row("records", format!("{} (this is the first)", info.records));
    }
    if info.frames > 1 || !info.trajectories.is_empty() {
        row("frames", info.frames.to_string());
    }
    for TrajectoryInfo { path, format, frames, first_ps, last_ps } in &info.trajectories {
        let times = match (first_ps, last_ps) {
            (Some(first), Some(last)) => format!(", {} to {} ps", round(*first, 1e3), round(*last, 1e3)),
            _ => String::new(),
        };
        row(format, format!("{path}: {frames} frames{times}"));
    }
    if let Some(CellInfo { a, b, c, alpha, beta, gamma }) = &info.cell {
        let lengths = [a, b, c].map(|x| round(*x, 1e4).to_string()).join(" ");
        let angles = [alpha, beta, gamma].map(|x| round(*x, 1e3).to_string()).join(" ");
        row("cell", format!("{lengths} Å, {angles}°"));
    }
    /// Assemblies that are listed; JSON has all of them.
    const MOST: usize = 20;
    for assembly in info.assemblies.iter().take(MOST) {
        row("assembly", assembly.words());
    }
    if info.assemblies.len() > MOST {
        row("", format!("and {} more assemblies", info.assemblies.len() - MOST));
    }
    let text: String = lines.iter().map(|line| printable(line) + "\n").collect();
    text + &info.explanations.as_ref().map_or_else(String::new, Explanations::text)
}

fn round(x: f64, scale: f64) -> f64 {
    (x * scale).round() / scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_are_in_hill_order() {
        let formula = |text: &str| {
            let mut elements = BTreeMap::new();
            for symbol in text.split(' ') {
                *elements.entry(Element::from_symbol(symbol).map_or("X", Element::symbol)).or_insert(0) += 1;
            }
            hill_formula(&elements)
        };
        assert_eq!(formula("O H C H Br"), "CH2BrO");
        assert_eq!(formula("O H H"), "H2O");
        assert_eq!(formula("Na Cl"), "ClNa");
        assert_eq!(formula("C"), "C");
        assert_eq!(formula("N H H H B"), "BH3N");
        assert_eq!(formula("? C"), "C");
    }

    #[test]
    fn a_failure_keeps_line_and_message_apart() {
        let failure = failure(Path::new("a.pdb"), &Error::input(7, "expected a number"));
        let expected = "{\"path\":\"a.pdb\",\"error\":{\"line\":7,\"message\":\"expected a number\"}}\n";
        assert_eq!(json_line(&failure), expected);
    }

    #[test]
    fn text_for_people_cannot_steer_their_terminal() {
        let text = b"1\nbad \x1b[2J title\nC 0 0 0\n";
        let document = crate::import::read_bytes(text, "a.xyz", &ImportOptions::default()).unwrap();
        let info = summary(Path::new("a.xyz"), &document, &document.records[0], &[]);
        let text = people_text(&info);
        assert!(text.contains("[2J title") && !text.contains('\x1b'), "{text:?}");
    }
}
