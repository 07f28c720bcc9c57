//! `ballstick render`: from files to picture files, one after another.
//!
//! The renderer uses all cores for each picture. One bad file never stops the others; even a panic costs only its
//! own picture. Drawing itself is behind [`Draw`], so that this module knows neither scene nor renderer.

use super::args::{Channel, Named, RenderArgs};
use super::load::{LoadSeconds, load_for_picture};
use super::plan::{Picture, Plan, plan};
use super::report::Report;
use super::values::{RecordChoice, check_size};
use crate::crystal::Drawn;
use crate::error::{Error, Result};
use crate::export::atomic;
use crate::export::picture::{self, Content, PictureFormat, PictureOptions};
use crate::render::image::{GBuffer, Image};
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// What a renderer hands back.
pub(super) enum Pixels {
    Image(Image),
    Surface(GBuffer),
}

/// A picture and what it took.
pub(super) struct Drawing {
    pub(super) drawn: Pixels,
    /// The renderer's name.
    pub(super) renderer: String,
    /// What the user should know of it.
    pub(super) notices: Vec<String>,
    /// What was chosen for the user.
    pub(super) notes: Vec<String>,
    pub(super) scene_seconds: f64,
    pub(super) render_seconds: f64,
}

/// Draws structures as the arguments ask.
pub(super) trait Draw {
    /// `side_by_side` says that the structures are to stand next to one another, not where their files put them.
    fn draw(&mut self, drawn: &[Drawn], side_by_side: bool, args: &RenderArgs) -> Result<Drawing>;

    /// Forgets what a panic may have left half done.
    fn reset(&mut self);
}

/// One line of `--timings`: seconds, bytes, counts.
#[derive(Debug, Serialize)]
struct Timings<'a> {
    output: String,
    read: f64,
    bonds: f64,
    scene: f64,
    render: f64,
    encode: f64,
    total: f64,
    peak_memory: Option<u64>,
    atom_count: usize,
    bond_count: usize,
    renderer: &'a str,
}

/// An error is one of usage.
pub(super) fn run(args: &RenderArgs, report: &mut Report, draw: &mut dyn Draw) -> Result<(), String> {
    let Plan { pictures, clashes, new_folder, format } = plan(&args.files, &args.output, args.to.as_deref())?;
    check_size(args.size, args.region)?;
    if args.channel != Channel::Color && !format.holds_channels() {
        let (channel, name) = (args.channel.name(), format.extensions()[0]);
        return Err(format!("--channel {channel} needs a .png or .npy file: {name} holds no channels"));
    }
    let side = args.region.map_or(args.size.width.max(args.size.height), |r| r.width.max(r.height));
    if side > format.max_side() {
        let (name, limit) = (format.extensions()[0], format.max_side());
        return Err(format!("--size {}: {name} has at most {limit} pixels a side; use png", args.size));
    }
    if args.look.background.0.is_none() && args.channel == Channel::Color && !format.holds_alpha() {
        let name = format.extensions()[0];
        report.warn(&args.output, &format!("{name} cannot be transparent; the background is white"));
    }
    if let Some(folder) = new_folder
        && let Err(source) = std::fs::create_dir_all(&folder)
    {
        report.fail(&folder.clone(), &Error::Io { action: "make the folder", path: folder, source });
        return Ok(());
    }
    for clash in clashes {
        report.fail_with(&format!(
            "{}: not drawn, as {} is the picture of {} already; choose another folder or pattern for one of them",
            clash.input.display(),
            clash.output.display(),
            clash.earlier.display()
        ));
    }
    report.start(pictures.len());
    for (index, picture) in pictures.iter().enumerate() {
        report.step(index, &picture.output.to_string_lossy());
        let mut finished = false;
        let result = super::guarded(|| {
            let result = one_picture(args, picture, format, report, draw);
            finished = true;
            result
        });
        if !finished {
            draw.reset();
        }
        match result {
            Ok(()) => {}
            Err(error) if atomic::is_broken_pipe(&error) => return Ok(()),
            Err(error) => report.fail(&picture.inputs[0], &error),
        }
    }
    Ok(())
}

fn one_picture(
    args: &RenderArgs,
    picture: &Picture,
    format: PictureFormat,
    report: &Report,
    draw: &mut dyn Draw,
) -> Result<()> {
    let started = Instant::now();
    let mut seconds = LoadSeconds::default();
    let mut drawn = Vec::new();
    let mut drawn_inputs: Vec<&PathBuf> = Vec::new();
    for input in &picture.inputs {
        match super::guarded(|| load_for_picture(input, &args.select, (args.bonds, args.crystal), report, &mut seconds))
        {
            Ok(loaded) => {
                drawn.extend(loaded);
                drawn_inputs.push(input);
            }
            Err(error) => report.fail(input, &error),
        }
    }
    if drawn_inputs.is_empty() {
        return Ok(()); // said above, input by input
    }
    let side_by_side = args.select.record == Some(RecordChoice::All);
    let drawing = draw.draw(&drawn, side_by_side, args)?;
    for notice in &drawing.notices {
        report.warn(&picture.output, notice);
    }
    for note in &drawing.notes {
        report.note(&picture.output, note);
    }
    let encoding = Instant::now();
    let options = PictureOptions {
        background: args.look.solid_background(),
        texts: metadata(args, &drawn_inputs, &drawn, &drawing.renderer),
    };
    let content = match (&drawing.drawn, args.channel) {
        (Pixels::Image(image), Channel::Color) => Content::Color(image),
        (Pixels::Surface(surface), Channel::Depth) => Content::Depth(surface),
        (Pixels::Surface(surface), Channel::Normal) => Content::Normal(surface),
        (Pixels::Surface(surface), Channel::Id) => Content::Id(surface),
        _ => return Err(Error::Unsupported("the renderer drew another channel than asked for".to_owned())),
    };
    atomic::write(&picture.output, |out| picture::write(content, format, &options, out))?;
    let timings = Timings {
        output: picture.output.to_string_lossy().into_owned(),
        read: seconds.read,
        bonds: seconds.bonds,
        scene: drawing.scene_seconds,
        render: drawing.render_seconds,
        encode: encoding.elapsed().as_secs_f64(),
        total: started.elapsed().as_secs_f64(),
        peak_memory: peak_memory(),
        atom_count: drawn.iter().map(|drawn| drawn.structure.atom_count()).sum(),
        bond_count: drawn.iter().map(|drawn| drawn.structure.bonds().len()).sum(),
        renderer: &drawing.renderer,
    };
    if args.timings {
        report.line(&serde_json::to_string(&timings).unwrap_or_default());
    }
    Ok(())
}

/// What is needed to make the picture again. No dates: the same command gives the same bytes.
fn metadata(args: &RenderArgs, inputs: &[&PathBuf], drawn: &[Drawn], renderer: &str) -> Vec<(String, String)> {
    let mut texts = vec![("Software".to_owned(), concat!("ballstick ", env!("CARGO_PKG_VERSION")).to_owned())];
    let title = drawn.first().map_or("", |drawn| drawn.structure.title());
    if !title.is_empty() {
        texts.push(("Title".to_owned(), super::report::printable(title)));
    }
    texts.push(("ballstick-renderer".to_owned(), renderer.to_owned()));
    texts.push(("ballstick-settings".to_owned(), settings(args, inputs).to_string()));
    texts
}

/// The settings by the names of their flags.
fn settings(args: &RenderArgs, inputs: &[&PathBuf]) -> serde_json::Value {
    let RenderArgs { look, select, .. } = args;
    let text = |value: Option<&dyn std::fmt::Display>| value.map(ToString::to_string);
    let inputs: Vec<_> = inputs.iter().map(|input| input.to_string_lossy()).collect();
    serde_json::json!({
        "files": inputs,
        "size": args.size.to_string(),
        "region": text(args.region.as_ref().map(|r| r as _)),
        "quality": args.quality.name(),
        "samples": args.samples,
        "channel": args.channel.name(),
        "style": look.style.name(),
        "color-by": look.color_by.name(),
        "background": look.background.to_string(),
        "ground": look.has_ground(),
        "projection": look.projection.name(),
        "view": text(look.view.as_ref().map(|v| v as _)),
        "axis": text(look.axis.as_ref().map(|a| a as _)),
        "aromatic": look.aromatic.name(),
        "vectors": look.vectors,
        "vector-scale": look.vector_scale,
        "axes": look.axes,
        "overlay": look.overlay.iter().map(|path| path.to_string_lossy()).collect::<Vec<_>>(),
        "overlay-opacity": look.overlay_opacity,
        "overlay-wireframe": look.overlay_wireframe,
        "overlay-color": text(look.overlay_color.as_ref().map(|c| c as _)),
        "altloc": look.altloc.to_string(),
        "bonds": args.bonds.bonds.name(),
        "hbonds": args.bonds.hbonds,
        "frame": select.frame,
        "record": text(select.record.as_ref().map(|r| r as _)),
    })
}

/// The most memory the process has had so far, in bytes; `None` where the system does not tell.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::args::{Cli, Command};
    use clap::Parser;
    use std::path::Path;

    /// Draws every picture as one pixel whose red is the number of atoms; refuses boron and panics at gold.
    #[derive(Default)]
    struct Fake {
        resets: usize,
    }

    impl Draw for Fake {
        fn draw(&mut self, drawn: &[Drawn], _: bool, args: &RenderArgs) -> Result<Drawing> {
            let elements: Vec<&str> =
                drawn.iter().flat_map(|drawn| drawn.structure.elements()).map(|e| e.symbol()).collect();
            if elements.contains(&"B") {
                return Err(Error::Gpu("device lost".to_owned()));
            }
            assert!(!elements.contains(&"Au"), "a bug");
            let drawn = if args.channel == Channel::Color {
                Pixels::Image(Image { width: 1, height: 1, rgba: vec![elements.len() as u8, 0, 0, 255] })
            } else {
                let (id, depth, normal) = (vec![1], vec![2.0], vec![[0.0, 0.0, 1.0]]);
                Pixels::Surface(GBuffer { width: 1, height: 1, id, depth, normal })
            };
            Ok(Drawing {
                drawn,
                renderer: "fake".to_owned(),
                notices: Vec::new(),
                notes: Vec::new(),
                scene_seconds: 0.0,
                render_seconds: 0.0,
            })
        }

        fn reset(&mut self) {
            self.resets += 1;
        }
    }

    struct Run {
        folder: tempfile::TempDir,
        usage: Result<(), String>,
        failures: usize,
        resets: usize,
    }

    impl Run {
        fn names(&self) -> Vec<String> {
            let entries = std::fs::read_dir(self.folder.path().join("out")).unwrap();
            let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
            names.sort();
            names
        }

        fn read(&self, name: &str) -> Vec<u8> {
            std::fs::read(self.folder.path().join("out").join(name)).unwrap()
        }
    }

    fn run_in_folder(files: &[&str], output: &str, flags: &[&str]) -> Run {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).into_os_string();
        for (name, text) in [
            ("one.xyz", "1\none\nC 0 0 0\n"),
            ("two.xyz", "2\ntwo\nC 0 0 0\nO 1.2 0 0\n"),
            ("bad.xyz", "no molecule at all\n"),
            ("boron.xyz", "1\n\nB 0 0 0\n"),
            ("gold.xyz", "1\n\nAu 0 0 0\n"),
        ] {
            std::fs::write(path(name), text).unwrap();
        }
        std::fs::create_dir(path("out")).unwrap();
        std::fs::create_dir(path("again")).unwrap();
        std::fs::write(path("again/one.xyz"), "1\n\nN 0 0 0\n").unwrap();
        let mut line = vec!["ballstick".into(), "render".into()];
        line.extend(files.iter().map(|name| path(name)));
        line.extend(["-o".into(), path(output)]);
        line.extend(flags.iter().map(Into::into));
        let Some(Command::Render(args)) = Cli::try_parse_from(line).unwrap().command else { panic!("not render") };
        let mut report = Report::default();
        let mut fake = Fake::default();
        let usage = run(&args, &mut report, &mut fake);
        Run { usage, failures: report.failures(), resets: fake.resets, folder }
    }

    #[test]
    fn one_bad_file_and_even_a_panic_cost_only_their_own_picture() {
        let run = run_in_folder(&["bad.xyz", "one.xyz", "gold.xyz", "boron.xyz", "none.xyz", "two.xyz"], "out/", &[]);
        assert_eq!(run.names(), ["one.png", "two.png"]);
        assert_eq!((run.usage.is_ok(), run.failures, run.resets), (true, 4, 1));
    }

    #[test]
    fn a_file_takes_all_that_can_be_read() {
        let run = run_in_folder(&["one.xyz", "bad.xyz", "two.xyz"], "out/all.ppm", &[]);
        assert_eq!(run.failures, 1);
        assert!(run.read("all.ppm").ends_with(&[3, 0, 0]));
        let run = run_in_folder(&["bad.xyz"], "out/all.ppm", &[]);
        assert_eq!((run.failures, run.names().len()), (1, 0));
    }

    #[test]
    fn the_second_picture_of_a_name_is_not_drawn_over_the_first() {
        let run = run_in_folder(&["one.xyz", "again/one.xyz", "two.xyz"], "out/{stem}.ppm", &[]);
        assert_eq!((run.failures, run.names()), (1, vec!["one.ppm".to_owned(), "two.ppm".to_owned()]));
    }

    #[test]
    fn channels_go_into_png_and_npy_and_nothing_else() {
        assert!(run_in_folder(&["one.xyz"], "out/d.npy", &["--channel=depth"]).read("d.npy").ends_with(&[0, 0, 0, 64]));
        let run = run_in_folder(&["one.xyz"], "out/d.jpg", &["--channel=depth"]);
        assert!(run.usage.unwrap_err().contains(".npy"));
    }

    #[test]
    fn what_cannot_be_is_found_before_anything_is_read() {
        for (output, flags, says) in [
            ("out/a.tif", &[][..], ".tif"),
            ("out/a.png", &["--region=1900,0,100,100"], "not inside"),
            ("out/a.webp", &["--size=20000x10"], "16383"),
        ] {
            let run = run_in_folder(&["none.xyz"], output, flags);
            assert!(run.usage.unwrap_err().contains(says));
            assert_eq!(run.failures, 0);
        }
    }

    #[test]
    fn pictures_say_how_they_were_made_and_are_the_same_every_time() {
        let png = || run_in_folder(&["one.xyz"], "out/a.png", &["--style=licorice", "--axis=111"]).read("a.png");
        let file = png();
        let reader = ::png::Decoder::new(std::io::Cursor::new(&file)).read_info().unwrap();
        let texts = reader.info().uncompressed_latin1_text.clone();
        let text = |key: &str| texts.iter().find(|text| text.keyword == key).map(|text| text.text.clone()).unwrap();
        assert!(text("Software").starts_with("ballstick "));
        assert_eq!(text("ballstick-renderer"), "fake");
        let settings: serde_json::Value = serde_json::from_str(&text("ballstick-settings")).unwrap();
        assert_eq!((&settings["style"], &settings["axis"]), (&"licorice".into(), &"1,1,1".into()));
        assert!(settings["files"][0].as_str().unwrap().ends_with("one.xyz"));
        assert_eq!(settings["view"], serde_json::Value::Null);
    }

    #[test]
    fn the_system_tells_the_peak_memory() {
        if Path::new("/proc/self/status").exists() {
            assert!(peak_memory().unwrap() > 1 << 20);
        }
    }
}
