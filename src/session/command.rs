//! The command line that draws a session's picture.

use super::{Session, Settings, TRANSPARENT};
use crate::bonds::BondOptions;
use crate::crystal::CrystalOptions;
use crate::render::Quality;
use crate::scene::SceneOptions;
use crate::select::Selection;
use std::borrow::Cow;

impl Session {
    /// `ballstick render …` for a picture of this size, with the flags that differ from the usual; quoted for a POSIX shell. Frames are
    /// said if all files show the same one: there is one flag for all.
    #[must_use]
    pub fn command_line(&self, [width, height]: [u32; 2]) -> String {
        let usual = Session::of(&Settings {
            scene: SceneOptions::default(),
            crystal: CrystalOptions { bonds: BondOptions::default(), ..CrystalOptions::default() },
            cell_box: None,
            quality: Quality::default(),
            viewpoint: None,
        });
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
        let mut flag = |name: &str, value: &str, is_usual: bool| {
            if !is_usual {
                words.extend([format!("--{name}"), value.to_owned()]);
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
        let number = |value: Option<f32>| value.map(|value| value.to_string()).unwrap_or_default();
        flag("light", &self.light, self.light == usual.light);
        flag("fog", &number(self.fog), self.fog.is_none());
        flag("outline", &number(self.outline), self.outline.is_none());
        flag("outline-color", self.outline_color.as_deref().unwrap_or_default(), self.outline_color.is_none());
        flag("depth-of-field", &number(self.depth_of_field), self.depth_of_field.is_none());
        flag("focus", &number(self.focus), self.depth_of_field.is_none() || self.focus.is_none());
        let of_look = crate::scene::Look::from_name(&self.look).unwrap_or_default().background().to_string();
        flag("background", &self.background, self.background == of_look && self.background != TRANSPARENT);
        flag("projection", &self.projection, self.camera.is_some() || self.projection == usual.projection);
        flag("altloc", &self.altloc, self.altloc == usual.altloc);
        flag("aromatic", &self.aromatic, self.aromatic == usual.aromatic);
        flag("vectors", &self.vectors, self.vectors == usual.vectors);
        let scale = self.vector_scale.map(|scale| scale.to_string());
        flag("vector-scale", scale.as_deref().unwrap_or_default(), scale.is_none());
        flag("label", &self.label.join(","), self.label.is_empty());
        flag("label-size", &self.label_size.to_string(), self.label_size == usual.label_size);
        flag("bonds", &self.bonds, self.bonds == usual.bonds);
        flag("cell", &self.cell, self.cell == usual.cell);
        flag("supercell", &format!("{a}x{b}x{c}"), self.supercell == usual.supercell);
        flag("quality", &self.quality, self.quality == usual.quality);
        let frame = shown.first().map_or(1, |file| file.frame);
        let same = shown.iter().all(|file| file.frame == frame);
        flag("frame", &frame.to_string(), frame == 1 || !same);
        for measurement in &self.measurements {
            let atom = |&[file, atom]: &[u32; 2]| match place(file)? {
                1 => Some(atom.to_string()),
                number => Some(format!("{number}:{atom}")),
            };
            if let Some(atoms) = measurement.iter().map(atom).collect::<Option<Vec<String>>>() {
                flag("measure", &atoms.join(","), false);
            }
        }
        flag("camera", self.camera.as_deref().unwrap_or_default(), self.camera.is_none());
        let switches = [
            ("no-ground", !self.ground),
            ("no-hydrogens", !self.hydrogens),
            ("no-water", !self.water),
            ("no-ions", !self.ions),
            ("haptic", self.haptic),
            ("axes", self.axes),
            ("legend", self.legend),
            ("scale-bar", self.scale_bar),
            ("hbonds", self.hbonds),
            ("cell-box", self.cell_box == Some(true)),
            ("no-cell-box", self.cell_box == Some(false)),
        ];
        if self.bonds_per_frame != usual.bonds_per_frame {
            words.push(format!("--bonds-per-frame={}", self.bonds_per_frame));
        }
        words.extend(switches.iter().filter(|(_, on)| *on).map(|(name, _)| format!("--{name}")));
        let quoted: Vec<Cow<'_, str>> = words.iter().map(|word| quoted(word)).collect();
        quoted.join(" ")
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
