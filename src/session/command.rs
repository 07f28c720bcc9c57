//! The flags of a session, and the command line that draws its picture.

use super::{Session, Settings, TRANSPARENT};
use crate::bonds::BondOptions;
use crate::crystal::CrystalOptions;
use crate::render::Quality;
use crate::scene::SceneOptions;
use crate::select::Selection;
use std::borrow::Cow;

/// A flag without its dashes, and what it is set to; `None` for a switch.
pub type Flag = (&'static str, Option<String>);

impl Session {
    /// `ballstick render …` for a picture of this size, with the flags that differ from the usual; quoted for a POSIX shell. Frames are
    /// said if all files show the same one: there is one flag for all.
    #[must_use]
    pub fn command_line(&self, [width, height]: [u32; 2]) -> String {
        let mut words: Vec<String> = vec!["ballstick".to_owned(), "render".to_owned()];
        let shown: Vec<_> = self.files.iter().filter(|file| file.visible).collect();
        for file in &shown {
            for path in std::iter::once(&file.path).chain(&file.trajectories) {
                let path = path.to_string_lossy();
                // A name that begins with a dash is no flag.
                words.push(if path.starts_with('-') { format!("./{path}") } else { path.into_owned() });
            }
        }
        words.extend(["-o".to_owned(), "picture.png".to_owned(), "--size".to_owned(), format!("{width}x{height}")]);
        let mut flags = self.flags(false);
        // A view that was written down brings its projection.
        flags.retain(|(name, _)| self.camera.is_none() || *name != "projection");
        let frame = shown.first().map_or(1, |file| file.frame);
        if frame != 1 && shown.iter().all(|file| file.frame == frame) {
            flags.push(("frame", Some(frame.to_string())));
        }
        if let Some(camera) = &self.camera {
            flags.push(("camera", Some(camera.clone())));
        }
        // Switches last, as people write them.
        flags.sort_by_key(|(_, value)| value.is_none());
        for (name, value) in flags {
            match value {
                // Alone it is a switch.
                Some(value) if name == "bonds-per-frame" => words.push(format!("--{name}={value}")),
                value => {
                    words.push(format!("--{name}"));
                    words.extend(value);
                }
            }
        }
        let quoted: Vec<Cow<'_, str>> = words.iter().map(|word| quoted(word)).collect();
        quoted.join(" ")
    }

    /// The flags that stand for its settings, those that are as usual as well if `all` are wanted; neither files nor their frames, nor
    /// the camera.
    #[must_use]
    pub fn flags(&self, all: bool) -> Vec<Flag> {
        let usual = Session::of(&Settings {
            scene: SceneOptions::default(),
            crystal: CrystalOptions { bonds: BondOptions::default(), ..CrystalOptions::default() },
            cell_box: None,
            quality: Quality::default(),
            viewpoint: None,
        });
        let mut flags: Vec<Flag> = Vec::new();
        let mut flag = |name, value: &str, is_usual: bool| {
            if all || !is_usual {
                flags.push((name, Some(value.to_owned())));
            }
        };
        let [a, b, c] = self.supercell;
        flag("style", &self.style, self.style == usual.style);
        // Files are counted as they are named here.
        let place = |file: u32| {
            let is_shown = self.files.get(file.checked_sub(1)? as usize)?.visible;
            let before = self.files.iter().take(file as usize - 1).filter(|file| file.visible).count();
            is_shown.then(|| u32::try_from(before + 1).unwrap_or(u32::MAX))
        };
        let renumbered = |text: &str| match Selection::parse(text) {
            Ok(selection) if self.files.iter().any(|file| !file.visible) => selection.with_files(place).to_string(),
            _ => text.to_owned(),
        };
        for (name, all) in [("show", &self.show), ("hide", &self.hide), ("label-only", &self.label_only)] {
            all.iter().for_each(|text| flag(name, &renumbered(text), false));
        }
        for (name, all) in [("style", &self.styles), ("color", &self.color)] {
            for (atoms, value) in all.iter().filter_map(|text| text.rsplit_once('=')) {
                flag(name, &format!("{}={value}", renumbered(atoms)), false);
            }
        }
        flag("ball-scale", &self.ball_scale.to_string(), self.ball_scale == usual.ball_scale);
        flag("stick-scale", &self.stick_scale.to_string(), self.stick_scale == usual.stick_scale);
        flag("color-by", &self.color_by, self.color_by == usual.color_by);
        flag("look", &self.look, self.look == usual.look);
        flag("light", &self.light, self.light == usual.light);
        let of_look = crate::scene::Look::from_name(&self.look).unwrap_or_default().background().to_string();
        flag("background", &self.background, self.background == of_look && self.background != TRANSPARENT);
        flag("projection", &self.projection, self.projection == usual.projection);
        flag("altloc", &self.altloc, self.altloc == usual.altloc);
        flag("aromatic", &self.aromatic, self.aromatic == usual.aromatic);
        flag("vectors", &self.vectors, self.vectors == usual.vectors);
        let labels = if self.label.is_empty() { "none".to_owned() } else { self.label.join(",") };
        flag("label", &labels, self.label.is_empty());
        flag("label-size", &self.label_size.to_string(), self.label_size == usual.label_size);
        flag("bonds", &self.bonds, self.bonds == usual.bonds);
        flag("cell", &self.cell, self.cell == usual.cell);
        flag("supercell", &format!("{a}x{b}x{c}"), self.supercell == usual.supercell);
        flag("quality", &self.quality, self.quality == usual.quality);
        flag("bonds-per-frame", &self.bonds_per_frame, self.bonds_per_frame == usual.bonds_per_frame);
        // What is said or not.
        let mut flag = |name, value: Option<String>| flags.extend(value.map(|value| (name, Some(value))));
        let text = |value: Option<f32>| value.map(|value| value.to_string());
        flag("assembly", self.assembly.clone());
        flag("fog", text(self.fog));
        flag("outline", text(self.outline));
        flag("outline-color", self.outline_color.clone());
        flag("depth-of-field", text(self.depth_of_field));
        flag("focus", text(self.focus.filter(|_| self.depth_of_field.is_some())));
        flag("vector-scale", text(self.vector_scale));
        let has_overlay = !self.overlay.is_empty();
        for mesh in &self.overlay {
            flag("overlay", Some(mesh.path.to_string_lossy().into_owned()));
        }
        flag("overlay-opacity", text(self.overlay_opacity.filter(|_| has_overlay)));
        flag("overlay-color", self.overlay_color.clone().filter(|_| has_overlay));
        for measurement in &self.measurements {
            flag("measure", self.measure(measurement));
        }
        if let Some(picture) = &self.picture {
            flag("size", Some(picture.size.clone()));
            flag("dpi", picture.dpi.map(|dpi| dpi.to_string()));
            flag("region", picture.region.clone());
            flag("crop", picture.crop.clone());
            flag("samples", Some(picture.samples.to_string()));
            flag("ao", Some(picture.ao.to_string()));
            flag("channel", Some(picture.channel.clone()));
            flag("renderer", Some(picture.renderer.clone()));
            flag("view", picture.view.clone());
            flag("axis", picture.axis.clone());
            flag("record", picture.record.clone());
            flag("turntable", picture.turntable.map(|count| count.to_string()));
            flag("frames", picture.frames.clone());
            flag("fps", picture.fps.map(|fps| fps.to_string()));
        }
        let switches = [
            ("ground", all && self.ground),
            ("no-ground", !self.ground),
            ("no-hydrogens", !self.hydrogens),
            ("no-water", !self.water),
            ("no-ions", !self.ions),
            ("haptic", self.haptic),
            ("axes", self.axes),
            ("legend", self.legend),
            ("scale-bar", self.scale_bar),
            ("hbonds", self.hbonds),
            ("overlay-wireframe", self.overlay_wireframe && has_overlay),
            ("cell-box", self.cell_box == Some(true)),
            ("no-cell-box", self.cell_box == Some(false)),
        ];
        flags.extend(switches.iter().filter(|(_, on)| *on).map(|&(name, _)| (name, None)));
        flags
    }
}

impl Session {
    /// What `--measure` says of a measurement; `None` if some of its atoms are not shown.
    fn measure(&self, atoms: &[super::Atom]) -> Option<String> {
        // Records that stand side by side are counted one by one.
        let has_records = self.picture.as_ref().is_some_and(|picture| picture.record.is_some());
        let place = |&[file, atom]: &super::Atom| {
            let is_shown = self.files.get(file.checked_sub(1)? as usize).is_some_and(|file| file.visible);
            // Files are counted as they are named in the command line.
            let before = self.files.iter().take(file as usize - 1).filter(|file| file.visible).count();
            let number = if has_records { file as usize } else { before + 1 };
            (is_shown || has_records).then(|| if number == 1 { atom.to_string() } else { format!("{number}:{atom}") })
        };
        Some(atoms.iter().map(place).collect::<Option<Vec<String>>>()?.join(","))
    }
}

/// A word as a shell reads it.
fn quoted(word: &str) -> Cow<'_, str> {
    let is_plain = |c: char| c.is_alphanumeric() || "-_=+./:,@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return Cow::Borrowed(word);
    }
    Cow::Owned(format!("'{}'", word.replace('\'', r"'\''")))
}
