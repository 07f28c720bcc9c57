//! `ballstick render` for films: the frames of a trajectory, or a turn about the upright axis.
//!
//! Every frame is a picture as any other, drawn when the file wants it ([`crate::export::animation`]). Files are read once. The camera stays: it is the
//! fitted one of the first frame, or of the whole turn.

use super::args::{Channel, RenderArgs};
use super::frames::FrameRange;
use super::load::{self, Molecules};
use super::picture::{Draw, Pixels, each_of};
use super::record::{Sums, metadata};
use super::report::Report;
use super::size::{Size, check_region};
use super::values::{RecordChoice, Region};
use super::{args::SelectArgs, plan};
use crate::crystal::{CrystalOptions, Drawn};
use crate::error::{Error, Result};
use crate::export::animation::{self, AnimationFormat, AnimationOptions};
use crate::import::trajectory::Input;
use crate::import::{Document, Format};
use crate::render::Image;
use std::cell::Cell;
use std::num::NonZeroU32;
use std::path::Path;

/// Frames of a turn where nothing is said: 4 seconds of 25.
const TURN_FRAMES: u32 = 100;

/// The format of the film that is asked for; `None` if a picture is. An error is one of usage.
pub(super) fn wanted(args: &RenderArgs) -> std::result::Result<Option<AnimationFormat>, String> {
    let by_name = match &args.to {
        Some(name) => AnimationFormat::from_name(name),
        None => AnimationFormat::from_path(&args.output),
    };
    let is_asked = args.turntable.is_some() || args.frames.is_some();
    let is_png = || {
        let by_flag = args.to.as_deref().map(|name| name.eq_ignore_ascii_case("png"));
        by_flag.unwrap_or_else(|| args.output.extension().is_some_and(|name| name.eq_ignore_ascii_case("png")))
    };
    match by_name {
        None if is_asked && is_png() => Ok(Some(AnimationFormat::Apng)),
        None if is_asked => Err("--turntable and --frames make a film: -o NAME.gif, .apng or .mp4".to_owned()),
        None if args.fps.is_some() => Err("--fps is for films: -o NAME.gif, .apng or .mp4".to_owned()),
        format => Ok(format),
    }
}

/// Draws films. An error is one of usage.
pub(super) fn run(
    args: &RenderArgs,
    format: AnimationFormat,
    report: &mut Report,
    draw: &mut dyn Draw,
) -> std::result::Result<(), String> {
    let size = args.size.pixels(args.dpi)?;
    let region = args.region.unwrap_or(Region { x: 0, y: 0, width: size.width, height: size.height });
    check_region(size, region)?;
    let (name, limit) = (format.extension(), format.max_side());
    if args.channel != Channel::Color {
        return Err("--channel is for pictures: a film shows colours".to_owned());
    }
    if args.crop.is_some() {
        return Err("--crop is for pictures: what is seen changes from frame to frame; use --region".to_owned());
    }
    if args.frames.is_some() && args.select.record == Some(RecordChoice::All) {
        return Err("--frames goes through one record: give --record N, or none".to_owned());
    }
    if region.width.max(region.height) > limit {
        return Err(format!("--size {size}: {name} has at most {limit} pixels a side"));
    }
    if args.look.depth_of_field.is_some() && !args.look.is_perspective() {
        return Err("--depth-of-field needs --projection perspective: parallel rays have no focus".to_owned());
    }
    let mut plan = plan::outputs(&args.files, &args.output, name)?;
    let places = plan.apart();
    if super::apart::own_input().is_none() {
        super::batch::choose(&mut plan, args.batch, &args.look.overlay)?;
    }
    if args.look.backdrop().0.is_none() {
        if !format.holds_alpha() {
            report.warn(&args.output, &format!("{name} cannot be transparent; the background is white"));
        } else if format == AnimationFormat::Gif && args.look.has_ground() {
            report.note(&args.output, "in a gif a pixel is there or not: of the ground's shadow only the dark part stays; --no-ground leaves it out");
        }
    }
    each_of(plan, report, draw, &mut |picture, report, draw| {
        if let Some(places) = &places {
            return picture.made_apart(places, &args.look.overlay, report).map(drop);
        }
        report.speak();
        one(args, (size, region, format), (&picture.inputs, &picture.output), report, draw)
    });
    Ok(())
}

/// A file of a film.
struct Reel<'a> {
    input: &'a Input,
    select: SelectArgs,
    document: Document,
    molecules: Molecules,
}

impl Reel<'_> {
    /// How many frames it has.
    fn frames(&self) -> usize {
        match self.record() {
            Some(record) => self.document.records.get(record).map_or(0, |record| record.frames().len()),
            None => self.document.frame_count(),
        }
    }

    /// The record that is asked for, from 0.
    fn record(&self) -> Option<usize> {
        match self.select.record {
            Some(RecordChoice::Number(number)) => Some(number.get() as usize - 1),
            _ => None,
        }
    }

    /// What is drawn of a frame, from 0; `None` for what is drawn of the file alone.
    fn drawn(&mut self, frame: Option<usize>, options: &CrystalOptions) -> Result<Vec<Drawn>> {
        let number = frame.and_then(|frame| NonZeroU32::new(u32::try_from(frame + 1).ok()?));
        let select = SelectArgs { frame: number.or(self.select.frame), ..self.select };
        load::drawn_of(&self.document, &select, options, &mut self.molecules)
    }
}

fn one(
    args: &RenderArgs,
    (size, region, format): (Size, Region, AnimationFormat),
    (inputs, output): (&[Input], &Path),
    report: &mut Report,
    draw: &mut dyn Draw,
) -> Result<()> {
    let sums = Sums::begin(inputs.iter().map(|input| &input.structure).chain(&args.look.overlay));
    let mut read = Vec::new();
    for (index, input) in inputs.iter().enumerate() {
        let frame = args.select.frame.or(args.origin.frames.get(index).copied());
        let read_all = || {
            let document = load::read_input(input, report)?;
            for trajectory in &document.trajectories {
                trajectory.count_frames(|| true)?;
            }
            Ok(document)
        };
        match super::guarded(read_all) {
            Ok(document) => {
                let (select, molecules) = (SelectArgs { frame, ..args.select }, Molecules::new());
                read.push(Reel { input, select, document, molecules });
            }
            Err(error) => report.fail(&input.structure, &error),
        }
    }
    if read.is_empty() {
        return Ok(()); // said above
    }
    let most = read.iter().map(Reel::frames).max().unwrap_or(0);
    // A trajectory plays, anything else turns.
    let plays = args.turntable.is_none() && (args.frames.is_some() || (most > 1 && args.select.frame.is_none()));
    let frames = match plays {
        true => args.frames.unwrap_or(FrameRange::ALL).of(most).map_err(|message| Error::input(None, message))?,
        false => Vec::new(),
    };
    let mut args = args.clone();
    (args.turntable, args.frames) = match plays {
        true => (None, Some(args.frames.unwrap_or(FrameRange::ALL))),
        false => (Some(args.turntable.unwrap_or(TURN_FRAMES)), None),
    };
    let count =
        if plays { u32::try_from(frames.len()).unwrap_or(u32::MAX) } else { args.turntable.unwrap_or(TURN_FRAMES) };
    let total = animation::drawn_frames(format, count);
    report.start(total as usize);
    let report = &*report;
    let side_by_side = args.select.record == Some(RecordChoice::All);
    let chosen: Vec<(&Input, SelectArgs)> = read.iter().map(|reel| (reel.input, reel.select)).collect();
    let sources: Vec<(&Path, Format)> =
        read.iter().map(|reel| (reel.input.structure.as_path(), reel.document.format)).collect();
    let options = load::crystal_options(args.bonds, args.crystal);
    // The frame of each file: the one of the film where it has several, else its own.
    let mut drawn_at = |frame: Option<usize>| -> Result<Vec<Vec<Drawn>>> {
        let drawn = |reel: &mut Reel<'_>| {
            // A shorter trajectory stays at its end.
            let last = reel.frames().saturating_sub(1);
            reel.drawn(frame.filter(|_| last > 0).map(|frame| frame.min(last)), &options)
        };
        read.iter_mut().map(drawn).collect()
    };
    let first = drawn_at(frames.first().copied())?;
    for (drawn, source) in first.iter().zip(sources) {
        load::warn_of_cells(drawn, source, args.crystal, report);
    }
    let first = first.concat();
    draw.load(&first, side_by_side, &args, size)?;
    if !plays {
        draw.turntable(args.look.camera.is_none() || args.origin.fitted, size);
    }
    let viewpoint = draw.viewpoint();
    let fitted = args.look.camera.is_none() || args.origin.fitted;
    // Who draws is known after the first frame only, and texts come before it: one pixel tells.
    draw.part(Region { width: 1, height: 1, ..region }, Channel::Color)?;
    let film = AnimationOptions {
        size: (region.width, region.height),
        frames: count,
        fps: args.fps.unwrap_or(animation::FPS),
        alpha: args.look.backdrop().0.is_none() && format.holds_alpha(),
        background: args.look.solid_background(),
        texts: metadata(&args, output, &chosen, &first, draw, &sums.finish()),
    };
    drop(first);
    // The first frame's place for all.
    (args.look.camera, args.origin.fitted) = (viewpoint, fitted);
    let name = output.to_string_lossy();
    let done = Cell::new(0);
    let mut current = frames.first().copied();
    let mut frame = |index: u32| -> Result<Image> {
        report.step(done.get(), &name);
        done.set(done.get() + 1);
        if plays {
            let asked = frames.get(index as usize).copied();
            if asked != current {
                draw.load(&drawn_at(asked)?.concat(), side_by_side, &args, size)?;
                current = asked;
            }
        } else {
            draw.turn((f64::from(index) / f64::from(count) * std::f64::consts::TAU) as f32);
        }
        match draw.part(region, Channel::Color)? {
            Pixels::Image(image) => Ok(image),
            _ => Err(Error::Unsupported("the renderer drew another channel than asked for".to_owned())),
        }
    };
    let written = animation::write(output, format, &film, &mut frame);
    for notice in draw.notices() {
        report.warn(output, &notice);
    }
    for note in draw.notes() {
        report.note(output, &note);
    }
    written
}
