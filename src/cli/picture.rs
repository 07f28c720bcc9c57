//! `ballstick render`: from files to picture files, one after another.
//!
//! Many files are shared out among the cores ([`super::batch`]); a large picture is drawn by all of them, strip by strip ([`super::strips`]). One bad file never stops the others; even
//! a panic costs only its own picture. Drawing itself is behind [`Draw`], so that this module knows neither scene nor renderer.

use super::animate;
use super::apart;
use super::args::{Channel, Named, RenderArgs, SelectArgs};
use super::batch;
use super::load::{LoadSeconds, load_for_picture};
use super::plan::{Picture, Plan, plan};
use super::record::{Sums, metadata};
use super::report::Report;
use super::size::{Size, check_region};
use super::strips::{self, Target};
use super::values::{RecordChoice, Region};
use crate::crystal::Drawn;
use crate::error::{Error, Result};
use crate::export::atomic;
use crate::export::picture::{PictureFormat, PictureOptions};
use crate::import::trajectory::Input;
use crate::render::image::{GBuffer, Image, SkyVisibility};
use crate::scene::Viewpoint;
use serde::Serialize;
use std::time::Instant;

/// What a renderer hands back.
pub(super) enum Pixels {
    Image(Image),
    Surface(GBuffer),
    Sky(SkyVisibility),
}

/// Draws structures as the arguments ask.
pub(super) trait Draw {
    /// Takes what the next picture shows. `side_by_side` says that the structures are to stand next to one another,
    /// not where their files put them.
    fn load(&mut self, drawn: &[Drawn], side_by_side: bool, args: &RenderArgs, size: Size) -> Result<()>;

    /// Draws a part of the picture.
    fn part(&mut self, region: Region, channel: Channel) -> Result<Pixels>;

    /// The part of the picture that is not background; `None` if there is none.
    fn seen(&mut self) -> Result<Option<Region>>;

    /// Who draws, once something is drawn.
    fn renderer(&self) -> String;

    /// Bytes of what is loaded.
    fn scene_memory(&self) -> usize {
        0
    }

    /// The view of what is loaded.
    fn viewpoint(&self) -> Option<Viewpoint> {
        None
    }

    /// Takes what is loaded for a film of its turn; `fitted` finds the camera anew that has all of it in the picture.
    fn turntable(&mut self, _fitted: bool, _size: Size) {}

    /// Turns what is loaded by so much from where it was.
    fn turn(&mut self, _angle_rad: f32) {}

    /// What the user should know since the last call.
    fn notices(&mut self) -> Vec<String>;

    /// What was chosen for the user.
    fn notes(&mut self) -> Vec<String> {
        Vec::new()
    }

    /// Forgets what a panic may have left half done.
    fn reset(&mut self);

    /// What makes others of its kind for other threads; `None` if pictures are to be drawn one after the other.
    fn workers(&mut self) -> Option<Box<dyn Fn() -> Box<dyn Draw> + Sync>> {
        None
    }
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
    structure_memory: usize,
    scene_memory: usize,
    atom_count: usize,
    bond_count: usize,
    renderer: &'a str,
}

/// An error is one of usage.
pub(super) fn run(args: &RenderArgs, report: &mut Report, draw: &mut dyn Draw) -> Result<(), String> {
    if let Some(format) = animate::wanted(args)? {
        return animate::run(args, format, report, draw);
    }
    let begun = Instant::now();
    let (mut plan, format) = plan(&args.files, &args.output, args.to.as_deref())?;
    let size = args.size.pixels(args.dpi)?;
    if let Some(region) = args.region {
        check_region(size, region)?;
    }
    if args.channel != Channel::Color && !format.holds_channels() {
        let (channel, name) = (args.channel.name(), format.extensions()[0]);
        return Err(format!("--channel {channel} needs a .png or .npy file: {name} holds no channels"));
    }
    if args.channel == Channel::Ao && args.ao == Some(0) {
        return Err("--channel ao needs directions to ask: --ao 1 to 256".to_owned());
    }
    let side = args.region.map_or(size.width.max(size.height), |r| r.width.max(r.height));
    if side > format.max_side() && args.crop.is_none() {
        let (name, limit) = (format.extensions()[0], format.max_side());
        return Err(format!("--size {size}: {name} has at most {limit} pixels a side; use png"));
    }
    if args.look.depth_of_field.is_some() && !args.look.is_perspective() {
        return Err("--depth-of-field needs --projection perspective: parallel rays have no focus".to_owned());
    }
    if args.dpi.is_some() && !format.holds_resolution() {
        let name = format.extensions()[0];
        report.warn(&args.output, &format!("{name} has no place for the resolution; png and jpg have"));
    }
    if args.look.backdrop().0.is_none() && args.channel == Channel::Color && !format.holds_alpha() {
        let name = format.extensions()[0];
        report.warn(&args.output, &format!("{name} cannot be transparent; the background is white"));
    }
    let places = plan.apart();
    let skipped = match apart::own_input() {
        Some(_) => 0,
        None => batch::choose(&mut plan, args.batch, &args.look.overlay)?,
    };
    report.start(plan.pictures.len());
    let (report, pixels) = (&*report, u64::from(size.width) * u64::from(size.height));
    let make = |picture: &Picture, report: &Report, draw: &mut dyn Draw| match &places {
        Some(places) => picture.made_apart(places, &args.look.overlay, report),
        None => {
            report.speak();
            one_picture(args, size, (picture, format), report, draw)
        }
    };
    let tally = batch::run(&plan, pixels, skipped, (report, draw), &make);
    if tally.is_batch() {
        report.line(&format!("ballstick: {}", tally.words(begun)));
    }
    Ok(())
}

/// Makes what is planned, one after the other: what fails is said, and the next one is made. A reader that has gone ends it.
pub(super) fn each_of(
    plan: Plan,
    report: &mut Report,
    draw: &mut dyn Draw,
    make: &mut dyn FnMut(&Picture, &mut Report, &mut dyn Draw) -> Result<()>,
) {
    if let Some(folder) = plan.new_folder
        && let Err(source) = std::fs::create_dir_all(&folder)
    {
        report.fail(&folder.clone(), &Error::Io { action: "make the folder", path: folder, source });
        return;
    }
    for clash in plan.clashes {
        report.fail_with(&clash.to_string());
    }
    for picture in &plan.pictures {
        let mut finished = false;
        let result = super::guarded(|| {
            let result = make(picture, report, draw);
            finished = true;
            result
        });
        if !finished {
            draw.reset();
        }
        match result {
            Ok(()) => {}
            Err(error) if atomic::is_broken_pipe(&error) => return,
            Err(error) => report.fail(&picture.inputs[0].structure, &error),
        }
    }
}

/// Draws one picture; `false` if none of its inputs could be read.
fn one_picture(
    args: &RenderArgs,
    size: Size,
    (picture, format): (&Picture, PictureFormat),
    report: &Report,
    draw: &mut dyn Draw,
) -> Result<bool> {
    let started = Instant::now();
    let mut seconds = LoadSeconds::default();
    let mut drawn = Vec::new();
    let mut drawn_inputs: Vec<(&Input, SelectArgs)> = Vec::new();
    let sums = Sums::begin(picture.inputs.iter().map(|input| &input.structure).chain(&args.look.overlay));
    for (index, input) in picture.inputs.iter().enumerate() {
        // Each file of a session has a frame of its own.
        let frame = args.select.frame.or(args.origin.frames.get(index).copied());
        let select = SelectArgs { frame, ..args.select };
        match super::guarded(|| load_for_picture(input, &select, (args.bonds, args.crystal), report, &mut seconds)) {
            Ok(loaded) => {
                drawn.extend(loaded);
                drawn_inputs.push((input, select));
            }
            Err(error) => report.fail(&input.structure, &error),
        }
    }
    if drawn_inputs.is_empty() {
        return Ok(false); // said above, input by input
    }
    let mut named =
        drawn_inputs.iter().flat_map(|(input, _)| std::iter::once(&input.structure).chain(&input.trajectories));
    if let Some(name) = named.find(|path| path.to_str().is_none()) {
        report.note(name, "the name is not text in UTF-8, so that the picture cannot say what it was made of (--from)");
    }
    let side_by_side = args.select.record == Some(RecordChoice::All);
    let part = args.region.unwrap_or(Region { x: 0, y: 0, width: size.width, height: size.height });
    let atoms = drawn.iter().map(|drawn| drawn.structure.atom_count()).sum();
    super::memory::check_picture(atoms, part, format)?;
    let loading = Instant::now();
    draw.load(&drawn, side_by_side, args, size)?;
    let scene_seconds = loading.elapsed().as_secs_f64();
    let finding = Instant::now();
    let region = match args.crop {
        None => args.region,
        Some(crop) => {
            let seen = draw.seen()?;
            if seen.is_none() {
                report.warn(&picture.output, "nothing is seen in the picture; --crop leaves it as it is");
            }
            seen.map(|seen| crop.around(seen, size))
        }
    };
    let finding_seconds = finding.elapsed().as_secs_f64();
    let Size { width, height } = size;
    let region = region.unwrap_or(Region { x: 0, y: 0, width, height });
    let target = Target { region, channel: args.channel, format, path: &picture.output };
    let sums = sums.finish();
    let options = |draw: &dyn Draw| PictureOptions {
        alpha: args.look.backdrop().0.is_none() && args.channel == Channel::Color,
        background: args.look.solid_background(),
        dpi: args.size.dpi(args.dpi),
        texts: metadata(args, &picture.output, &drawn_inputs, &drawn, draw, &sums),
    };
    let name = picture.output.to_string_lossy();
    let progress = |done: f64| report.within_step(&format!("{name} {:.0} %", done * 100.0));
    let written = strips::write(draw, &target, options, progress);
    for notice in draw.notices() {
        report.warn(&picture.output, &notice);
    }
    for note in draw.notes() {
        report.note(&picture.output, &note);
    }
    let written = written?;
    let timings = Timings {
        output: picture.output.to_string_lossy().into_owned(),
        read: seconds.read,
        bonds: seconds.bonds,
        scene: scene_seconds,
        render: finding_seconds + written.render,
        encode: written.encode,
        total: started.elapsed().as_secs_f64(),
        peak_memory: peak_memory(),
        structure_memory: drawn.iter().map(|drawn| drawn.structure.memory()).sum(),
        scene_memory: draw.scene_memory(),
        atom_count: drawn.iter().map(|drawn| drawn.counts()[0]).sum(),
        bond_count: drawn.iter().map(|drawn| drawn.counts()[1]).sum(),
        renderer: &draw.renderer(),
    };
    if args.timings {
        report.line(&serde_json::to_string(&timings).unwrap_or_default());
    }
    Ok(true)
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

    /// Draws every pixel with a red that is the number of atoms; refuses boron and panics at gold.
    #[derive(Default)]
    struct Fake {
        red: u8,
        resets: usize,
    }

    impl Draw for Fake {
        fn load(&mut self, drawn: &[Drawn], _: bool, _: &RenderArgs, _: Size) -> Result<()> {
            let elements: Vec<&str> =
                drawn.iter().flat_map(|drawn| drawn.structure.elements()).map(|e| e.symbol()).collect();
            if elements.contains(&"B") {
                return Err(Error::Gpu("device lost".to_owned()));
            }
            assert!(!elements.contains(&"Au"), "a bug");
            self.red = elements.len() as u8;
            Ok(())
        }

        fn part(&mut self, Region { width, height, y, .. }: Region, channel: Channel) -> Result<Pixels> {
            let pixels = (width * height) as usize;
            Ok(if channel == Channel::Ao {
                Pixels::Sky(SkyVisibility { width, height, open: vec![0.5; pixels] })
            } else if channel == Channel::Color {
                if y > 0 && self.red == 2 {
                    return Err(Error::Gpu("lost in the middle".to_owned()));
                }
                Pixels::Image(Image { width, height, rgba: [self.red, 0, 0, 255].repeat(pixels) })
            } else {
                // A depth that grows from strip to strip.
                let (id, depth, normal) =
                    (vec![1; pixels], vec![2.0 + y as f32; pixels], vec![[0.0, 0.0, 1.0]; pixels]);
                Pixels::Surface(GBuffer { width, height, id, depth, normal })
            })
        }

        fn seen(&mut self) -> Result<Option<Region>> {
            Ok((self.red == 1).then_some(Region { x: 10, y: 20, width: 30, height: 5 }))
        }

        fn renderer(&self) -> String {
            "fake".to_owned()
        }

        fn notices(&mut self) -> Vec<String> {
            Vec::new()
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
            ("gold-free.xyz", "3\nthree\nC 0 0 0\nO 1.2 0 0\nO -1.2 0 0\n"),
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
        if !flags.iter().any(|flag| flag.starts_with("--size") || flag.starts_with("--region")) {
            line.push("--size=1x1".into());
        }
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
    fn a_large_picture_is_drawn_in_strips_and_one_that_fails_in_the_middle_leaves_nothing() {
        let large = |file, name| run_in_folder(&[file], name, &["--size=8192x4096"]);
        let ppm = large("one.xyz", "out/a.ppm").read("a.ppm");
        let pixels = ppm.strip_prefix(b"P6\n8192 4096\n255\n").unwrap();
        assert_eq!(pixels.len(), 8192 * 4096 * 3);
        assert!(pixels.chunks_exact(3).all(|pixel| pixel == [1, 0, 0]));
        let run = large("two.xyz", "out/a.ppm");
        assert_eq!((run.failures, run.names().len()), (1, 0));
    }

    #[test]
    fn depths_of_all_strips_have_one_scale() {
        let run = run_in_folder(&["one.xyz"], "out/d.png", &["--channel=depth", "--size=4096x2048"]);
        let file = run.read("d.png");
        let mut reader = ::png::Decoder::new(std::io::Cursor::new(&file)).read_info().unwrap();
        let texts = reader.info().uncompressed_latin1_text.clone();
        let text = |key: &str| texts.iter().find(|text| text.keyword == key).map(|text| text.text.clone()).unwrap();
        assert_eq!((text("near_angstrom").as_str(), text("far_angstrom").as_str()), ("2", "1026"));
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut data).unwrap();
        assert_eq!((&data[..2], &data[data.len() - 2..]), (&[255, 255][..], &[0, 1][..]));
    }

    #[test]
    fn a_crop_is_what_is_seen_and_its_margin_and_an_empty_picture_stays_whole() {
        let size = |file: &str, flags: &[&str]| {
            let run = run_in_folder(&[file], "out/a.ppm", flags);
            assert_eq!((run.usage.is_ok(), run.failures), (true, 0));
            String::from_utf8_lossy(&run.read("a.ppm")[3..9]).into_owned()
        };
        assert_eq!(size("one.xyz", &["--size=99x50", "--crop=auto,3"]), "36 11\n");
        assert_eq!(size("gold-free.xyz", &["--size=99x50", "--crop=auto"]), "99 50\n");
    }

    #[test]
    fn channels_go_into_png_and_npy_and_nothing_else() {
        assert!(run_in_folder(&["one.xyz"], "out/d.npy", &["--channel=depth"]).read("d.npy").ends_with(&[0, 0, 0, 64]));
        assert!(run_in_folder(&["one.xyz"], "out/a.npy", &["--channel=ao"]).read("a.npy").ends_with(&[0, 0, 0, 63]));
        let run = run_in_folder(&["one.xyz"], "out/d.jpg", &["--channel=depth"]);
        assert!(run.usage.unwrap_err().contains(".npy"));
        let run = run_in_folder(&["one.xyz"], "out/a.npy", &["--channel=ao", "--ao=0"]);
        assert!(run.usage.unwrap_err().contains("--ao 1"));
    }

    #[test]
    fn what_cannot_be_is_found_before_anything_is_read() {
        for (output, flags, says) in [
            ("out/a.tif", &[][..], ".tif"),
            ("out/a.png", &["--region=1900,0,100,100"], "not inside"),
            ("out/a.webp", &["--size=20000x10"], "16383"),
            ("out/a.png", &["--size=20cmx1cm", "--dpi=9600"], "32768"),
        ] {
            let run = run_in_folder(&["none.xyz"], output, flags);
            assert!(run.usage.unwrap_err().contains(says));
            assert_eq!(run.failures, 0);
        }
    }

    #[test]
    fn pictures_say_how_they_were_made_and_are_the_same_every_time() {
        let png = || run_in_folder(&["one.xyz"], "out/a.png", &["--style=licorice", "--view=1,1,1"]).read("a.png");
        let file = png();
        let reader = ::png::Decoder::new(std::io::Cursor::new(&file)).read_info().unwrap();
        let texts = reader.info().uncompressed_latin1_text.clone();
        let text = |key: &str| texts.iter().find(|text| text.keyword == key).map(|text| text.text.clone()).unwrap();
        assert!(text("Software").starts_with("ballstick "));
        assert_eq!(text("ballstick-renderer"), "fake");
        let session: serde_json::Value = serde_json::from_str(&text("ballstick-session")).unwrap();
        assert_eq!((&session["style"], &session["picture"]["view"]), (&"licorice".into(), &"1,1,1".into()));
        let file = &session["files"][0];
        assert!(file["path"].as_str().unwrap().ends_with("one.xyz"));
        assert_eq!(file["sha256"], crate::session::sums::of_bytes(b"1\none\nC 0 0 0\n"));
        assert_eq!(session["picture"]["axis"], serde_json::Value::Null);
    }

    #[test]
    fn the_system_tells_the_peak_memory() {
        if Path::new("/proc/self/status").exists() {
            assert!(peak_memory().unwrap() > 1 << 20);
        }
    }
}
