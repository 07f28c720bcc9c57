//! `--from`: a picture or a session as the beginning of a command line, and what a picture keeps so that this can be.
//!
//! A session's settings become flags that stand before those that are typed, without those that are typed as well or that contradict them: so what is
//! typed counts. Its files are checked by their sums; files that are typed take their place unchecked, and a
//! note says so if they are others.

use super::args::RenderArgs;
use super::report::Report;
use super::size::PictureSize;
use crate::error::Error;
use crate::import::trajectory::{Input, inputs};
use crate::scene::{Pose, Viewpoint};
use crate::session::{File, Session, samples, sums};
use std::collections::HashSet;
use std::ffi::OsString;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

/// What of a session is no flag.
#[derive(Debug, Clone, Default)]
pub struct Origin {
    /// The frame of each file.
    pub frames: Vec<NonZeroU32>,
    /// Whether the view is the fitted one of that picture.
    pub fitted: bool,
    /// How the molecule stands where the camera is fitted anew.
    pub pose: Option<Pose>,
}

/// Flags that take the place of others when they are typed. What is typed itself always does.
const REPLACES: &[(&str, &[&str])] = &[
    ("camera", &["view", "axis", "projection"]),
    ("view", &["axis"]),
    ("axis", &["view"]),
    ("quality", &["samples", "ao"]),
    ("size", &["region"]),
    ("region", &["crop"]),
    ("crop", &["region"]),
    ("turntable", &["frames"]),
    ("frames", &["turntable", "frame"]),
];

/// The session that a command line begins with: that of `--from`, by its path; `None` if there is no such flag. `render` is the second word.
pub(super) fn named(arguments: &[OsString]) -> Option<PathBuf> {
    let mut words = arguments.iter().skip(2).take_while(|word| *word != "--");
    while let Some(word) = words.next() {
        if word == "--from" {
            return words.next().map(PathBuf::from);
        }
        if let Some(path) = word.to_str().and_then(|word| word.strip_prefix("--from=")) {
            return Some(PathBuf::from(path));
        }
    }
    None
}

/// The names of the flags that are typed, without their dashes.
fn typed(arguments: &[OsString]) -> HashSet<String> {
    let words = arguments.iter().skip(2).take_while(|word| *word != "--").filter_map(|word| word.to_str());
    let names = words.filter_map(|word| word.strip_prefix("--"));
    names.map(|name| name.split('=').next().unwrap_or(name).to_owned()).collect()
}

/// The command line with a session's flags before those that are typed: those that the command knows.
pub(super) fn expanded(arguments: &[OsString], session: &Session, knows: impl Fn(&str) -> bool) -> Vec<OsString> {
    let typed = typed(arguments);
    let replaced: HashSet<&str> = REPLACES
        .iter()
        .filter(|(name, _)| typed.contains(*name))
        .flat_map(|(_, others)| others.iter().copied())
        .collect();
    // The background of a look goes with it, unless another one was chosen.
    let of_look = crate::scene::Look::from_name(&session.look).unwrap_or_default().background().to_string();
    let goes_with_look = typed.contains("look") && session.background == of_look;
    let mut words: Vec<OsString> = arguments.iter().take(2).cloned().collect();
    for (name, value) in session.flags(true) {
        let is_gone = typed.contains(name) || replaced.contains(name) || (name == "background" && goes_with_look);
        if !is_gone && knows(name) {
            words.push(match value {
                Some(value) => format!("--{name}={value}").into(),
                None => format!("--{name}").into(),
            });
        }
    }
    words.extend(arguments.iter().skip(2).cloned());
    words
}

/// Puts in place what of the session is no flag. An error is one of the session or its files.
pub(super) fn complete(
    args: &mut RenderArgs,
    arguments: &[OsString],
    (path, session): (&Path, &Session),
    report: &Report,
) -> Result<(), String> {
    let typed = typed(arguments);
    let origin = (path, arguments.get(1).is_some_and(|word| word == "convert"));
    let shown: Vec<&File> = session.files.iter().filter(|file| file.visible).collect();
    if shown.is_empty() && args.files.is_empty() {
        return Err(format!("{}: the session shows no files", path.display()));
    }
    let mut is_another = false;
    if args.files.is_empty() {
        for file in &shown {
            args.files.push(found(file, origin)?);
            for trajectory in &file.trajectories {
                // Too large to have sums.
                let own = File { path: trajectory.clone(), ..File::default() };
                args.files.push(found(&own, origin)?);
            }
        }
    } else if inputs(&args.files).len() != shown.len() {
        return Err(format!(
            "{} shows {} molecules, and {} are named in their place: name as many, or none",
            path.display(),
            shown.len(),
            inputs(&args.files).len()
        ));
    } else {
        for (Input { structure: named, .. }, file) in inputs(&args.files).iter().zip(&shown) {
            // What cannot be read is said when it is read.
            let sum = sums::of_file(named).ok().flatten();
            if file.sha256.is_some() && sum.is_some() && sum != file.sha256 {
                is_another = true;
                report.note(named, &format!("it is another file than {} was made of", path.display()));
            }
        }
    }
    let overlays: Vec<(&Path, &Option<String>)> =
        session.overlay.iter().map(|mesh| (mesh.path.as_path(), &mesh.sha256)).collect();
    if !typed.contains("overlay") {
        for (mesh, sum) in overlays {
            check(mesh, sum.as_deref()).map_err(|problem| problem.said(mesh, origin, "--overlay "))?;
        }
    }
    let typed_any = |names: &[&str]| names.iter().any(|name| typed.contains(*name));
    let keeps_shape =
        !typed_any(&["size", "dpi"]) || session.picture.as_ref().is_some_and(|picture| shape(args, &picture.size));
    // A fitted view is fitted anew to what is new; one that was chosen stays.
    // A session that is in no picture fitted the shape of a window.
    let is_refitted =
        session.fitted && (is_another || !keeps_shape || typed.contains("projection") || session.picture.is_none());
    let viewpoint = session.camera.as_deref().and_then(|text| text.parse::<Viewpoint>().ok());
    match viewpoint {
        Some(_) if typed_any(&["camera", "view", "axis"]) => {}
        Some(viewpoint) if is_refitted => args.origin.pose = Some(viewpoint.pose).filter(|_| !is_another),
        Some(viewpoint) if typed.contains("projection") => {
            let perspective = args.look.projection == super::args::ProjectionArg::Perspective;
            args.look.camera = Some(viewpoint.in_perspective(perspective));
        }
        viewpoint => args.look.camera = args.look.camera.or(viewpoint),
    }
    if !typed_any(&["frame", "frames"]) {
        args.origin.frames = shown.iter().filter_map(|file| NonZeroU32::new(file.frame)).collect();
    }
    args.origin.fitted = session.fitted && args.look.camera.is_some();
    Ok(())
}

/// Whether the size of the arguments has the shape of this one, to a pixel's part.
fn shape(args: &RenderArgs, size: &str) -> bool {
    let of = |size: PictureSize| size.pixels(args.dpi).ok().map(|size| f64::from(size.width) / f64::from(size.height));
    let before = size.parse::<PictureSize>().ok().and_then(of);
    before.zip(of(args.size)).is_some_and(|(before, now)| (before / now - 1.0).abs() < 1e-3)
}

/// The command that takes another file in the place of one of the picture's; of a mesh the picture comes first.
fn again(file: &str, picture: &impl std::fmt::Display, is_mesh: bool) -> String {
    match is_mesh {
        true => format!(
            "ballstick render {file} --from {picture} -o NEW.png, and convert that: ballstick convert NEW.png -o OUT"
        ),
        false => format!("ballstick render {file} --from {picture} -o OUT"),
    }
}

/// What is wrong with a file.
enum Problem {
    Missing,
    Changed { was: String, is: String },
    Other(Error),
}

impl Problem {
    /// In words; `flag` stands before a name on the command line.
    fn said(&self, file: &Path, (picture, is_mesh): (&Path, bool), flag: &str) -> String {
        let (file_name, picture) = (file.display(), picture.display());
        let short = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
        let again = |place: &str| again(&format!("{flag}{place}"), &picture, is_mesh);
        match self {
            Problem::Missing => format!(
                "{picture} was made of {file_name}, which is not there; if it was moved, say where it is: {}",
                again(&format!("NEW/PLACE/{short}"))
            ),
            Problem::Changed { was, is } => format!(
                "{file_name} has changed since {picture} was made: its SHA-256 sum was {was} and is {is}; to draw it as it is now, name it: {}",
                again(&file_name.to_string())
            ),
            Problem::Other(error) => error.to_string(),
        }
    }
}

fn check(file: &Path, sum: Option<&str>) -> Result<(), Problem> {
    if samples::of_path(file).is_none() && !file.exists() {
        return Err(Problem::Missing);
    }
    // A pipe would be waited for, a device has no end: neither was what the session is of.
    if std::fs::metadata(file).is_ok_and(|metadata| !metadata.is_file()) {
        return Err(Problem::Other(Error::Unsupported(format!("{} is named, which is no file", file.display()))));
    }
    let Some(was) = sum else { return Ok(()) };
    match sums::of_file(file).map_err(Problem::Other)? {
        Some(is) if is != was => Err(Problem::Changed { was: was.to_owned(), is }),
        _ => Ok(()),
    }
}

/// Where a file of a session is: in its place, or, if it is not there, under its name beside the session.
fn found(file: &File, (picture, is_mesh): (&Path, bool)) -> Result<PathBuf, String> {
    if file.path.as_os_str() == "-" {
        let picture = picture.display();
        return Err(format!(
            "{picture} was made of standard input; name the file that it was: {}",
            again("FILE", &picture, is_mesh)
        ));
    }
    match check(&file.path, file.sha256.as_deref()) {
        Ok(()) => Ok(file.path.clone()),
        Err(problem @ Problem::Missing) => {
            let beside = file.path.file_name().map(|name| picture.with_file_name(name));
            // Of the same name alone it might be anything.
            let same = |path: &PathBuf| file.sha256.is_some() && check(path, file.sha256.as_deref()).is_ok();
            beside.filter(same).ok_or_else(|| problem.said(&file.path, (picture, is_mesh), ""))
        }
        Err(problem) => Err(problem.said(&file.path, (picture, is_mesh), "")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::args::Cli;
    use clap::CommandFactory;

    fn words(line: &str) -> Vec<OsString> {
        line.split(' ').map(OsString::from).collect()
    }

    #[test]
    fn the_session_of_a_command_line_is_found() {
        assert_eq!(named(&words("ballstick render --from a.png -o b.png")), Some("a.png".into()));
        assert_eq!(named(&words("ballstick render -o b.png --from=a.png")), Some("a.png".into()));
        assert_eq!(named(&words("ballstick render a.pdb -o b.png")), None);
        assert_eq!(named(&words("ballstick render -o b.png -- --from a.png")), None);
    }

    /// A flag that a session does not keep would make `--from` draw another picture.
    #[test]
    fn every_flag_of_a_picture_is_one_of_the_session() {
        // Where to and how, not what; what `Origin` has; and the other side of a switch that is off unless said.
        let others = ["output", "to", "timings", "skip-existing", "shard", "from", "help", "frame", "camera", "limits"];
        let selection = || crate::select::Selection::parse("water").unwrap();
        let mut session: Session = crate::session::Session::of(&crate::session::Settings {
            scene: crate::scene::SceneOptions {
                hydrogens: false,
                water: false,
                ions: false,
                by_selection: crate::scene::BySelection {
                    show: vec![selection()],
                    hide: vec![selection()],
                    colors: vec![(selection(), crate::color::Srgb8::WHITE)],
                    styles: vec![(selection(), Default::default())],
                    labels: vec![selection()],
                },
                haptic: true,
                axes: true,
                vector_scale: Some(1.0),
                fog: Some(1.0),
                outline: Some(1.0),
                outline_color: Some(crate::color::Srgb8::WHITE),
                depth_of_field: Some(crate::scene::DepthOfField { blur: 0.1, focus: 0.5 }),
                overlay_opacity: Some(0.5),
                overlay_wireframe: true,
                overlay_color: Some(crate::color::Srgb8::WHITE),
                text: crate::scene::OverlayOptions { legend: true, scale_bar: true, ..Default::default() },
                ..Default::default()
            },
            crystal: crate::crystal::CrystalOptions {
                bonds: crate::bonds::BondOptions { hydrogen_bonds: true, ..Default::default() },
                assembly: crate::crystal::AssemblyId::new("1"),
                ..Default::default()
            },
            cell_box: Some(true),
            quality: Default::default(),
            viewpoint: None,
        });
        let some = || Some("1".to_owned());
        session.picture = Some(crate::session::Picture {
            size: "1x1".to_owned(),
            dpi: Some(1),
            region: some(),
            crop: some(),
            samples: 1,
            ao: 1,
            channel: "color".to_owned(),
            renderer: "cpu".to_owned(),
            view: some(),
            axis: some(),
            record: some(),
            turntable: Some(1),
            frames: some(),
            fps: Some(1.0),
        });
        session.overlay = vec![crate::session::Overlay { path: "a.obj".into(), sha256: None }];
        session.files = vec![File { path: "a.pdb".into(), frame: 1, visible: true, ..File::default() }];
        session.measurements = vec![vec![[1, 1], [1, 2]]];
        let mut kept: HashSet<&str> = session.flags(true).into_iter().map(|(name, _)| name).collect();
        (session.ground, session.cell_box) = (false, Some(false));
        kept.extend(session.flags(true).into_iter().map(|(name, _)| name));
        let command = Cli::command();
        let render = command.find_subcommand("render").unwrap();
        let flags: Vec<&str> = render.get_arguments().filter_map(|argument| argument.get_long()).collect();
        assert!(flags.len() > 40);
        let is_other =
            |flag: &&str| others.contains(flag) || super::super::opposite::OppositeArgs::NAMES.contains(flag);
        let missing: Vec<&&str> = flags.iter().filter(|flag| !kept.contains(*flag) && !is_other(flag)).collect();
        assert!(missing.is_empty(), "a session must keep {missing:?} (src/session/command.rs)");
        let unknown: Vec<_> = kept.iter().filter(|name| !flags.contains(name)).collect();
        assert!(unknown.is_empty(), "render does not know {unknown:?}");
    }
}
