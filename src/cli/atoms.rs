//! The flags that say which atoms: shown, hidden, coloured, in a style of their own, labelled.

use super::args::{Named, StyleArg};
use crate::color::Srgb8;
use crate::scene::{BySelection, Style};
use crate::select::Selection;
use clap::{Args, ValueEnum};
use std::str::FromStr;

/// Which atoms there are.
#[derive(Debug, Clone, Default, Args)]
pub struct ShowArgs {
    /// Only these atoms, as in "chain A" or "within 5 of ligand"; given several times, all that one of them selects.
    /// `ballstick render --help` says how atoms are selected
    #[arg(long, value_name = "SELECTION", value_parser = selection, help_heading = "Molecule")]
    pub show: Vec<Selection>,
    /// Leave these atoms out; may be given several times
    #[arg(long, value_name = "SELECTION", value_parser = selection, help_heading = "Molecule")]
    pub hide: Vec<Selection>,
}

/// How atoms look.
#[derive(Debug, Clone, Args)]
pub struct AtomArgs {
    /// Which there are.
    #[command(flatten)]
    pub shown: ShowArgs,
    /// Representation: ball-and-stick, licorice, space-filling or wireframe; with a selection that of some atoms, as in
    /// "ligand=space-filling"; may be given several times, and the last one of an atom counts [default: ball-and-stick]
    #[arg(long, value_name = "[SELECTION=]STYLE", help_heading = "Look")]
    pub style: Vec<StyleOf>,
    /// Colour of some atoms, #rrggbb or a name, in place of the scheme's, as in "chain A=steelblue"; may be given several
    /// times, and the last one of an atom counts
    #[arg(long, value_name = "SELECTION=COLOR", help_heading = "Look")]
    pub color: Vec<ColorOf>,
    /// Size of balls in times of the usual one, 0.1 to 10
    #[arg(long, value_name = "X", value_parser = times, default_value = "1", help_heading = "Look")]
    pub ball_scale: f32,
    /// Thickness of sticks in times of the usual one, 0.1 to 10
    #[arg(long, value_name = "X", value_parser = times, default_value = "1", help_heading = "Look")]
    pub stick_scale: f32,
    /// Label only these atoms, and residues with one of them; may be given several times
    #[arg(long, value_name = "SELECTION", value_parser = selection, help_heading = "Text")]
    pub label_only: Vec<Selection>,
}

impl AtomArgs {
    /// The style of all atoms that no selection gives one.
    #[must_use]
    pub fn style(&self) -> StyleArg {
        let plain = self.style.iter().rev().find(|StyleOf(atoms, _)| atoms.is_none());
        plain.map_or(StyleArg::BallAndStick, |&StyleOf(_, style)| style)
    }

    /// The styles of selected atoms.
    pub fn styles(&self) -> impl Iterator<Item = (&Selection, StyleArg)> {
        self.style.iter().filter_map(|StyleOf(atoms, style)| Some((atoms.as_ref()?, *style)))
    }

    /// What selections say.
    #[must_use]
    pub fn by_selection(&self) -> BySelection {
        BySelection {
            show: self.shown.show.clone(),
            hide: self.shown.hide.clone(),
            colors: self.color.iter().map(|ColorOf(atoms, color)| (atoms.clone(), *color)).collect(),
            styles: self.styles().map(|(atoms, arg)| (atoms.clone(), style(arg))).collect(),
            labels: self.label_only.clone(),
        }
    }
}

/// The style that a name of the flag stands for.
pub(super) fn style(arg: StyleArg) -> Style {
    Style::from_name(&arg.name()).unwrap_or_default()
}

/// A size in times of the usual one.
fn times(text: &str) -> Result<f32, String> {
    let times = text.trim().parse().ok().filter(|x: &f32| (0.1..=10.0).contains(x));
    times.ok_or_else(|| "expected a number from 0.1 to 10, such as 1.5".to_owned())
}

/// Atoms by words.
fn selection(text: &str) -> Result<Selection, String> {
    Selection::parse(text).map_err(|error| error.to_string())
}

/// The two sides of the last `=`.
fn of_selection<'t>(text: &'t str, such_as: &str) -> Result<(Selection, &'t str), String> {
    let (atoms, value) =
        text.rsplit_once('=').ok_or_else(|| format!("expected a selection, = and a value, such as {such_as}"))?;
    Ok((selection(atoms)?, value.trim()))
}

/// A colour of selected atoms: `SELECTION=COLOR`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColorOf(pub Selection, pub Srgb8);

impl FromStr for ColorOf {
    type Err = String;

    fn from_str(text: &str) -> Result<ColorOf, String> {
        let (atoms, value) = of_selection(text, "\"chain A=steelblue\"")?;
        match Srgb8::parse(value) {
            Some(color) if color.a == 255 => Ok(ColorOf(atoms, color)),
            _ => {
                let instead = Srgb8::instead_of(value);
                Err(format!("expected #rrggbb, #rgb, or a name such as steelblue behind the =, found {value}{instead}"))
            }
        }
    }
}

impl std::fmt::Display for ColorOf {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}={}", self.0, self.1)
    }
}

/// A style, of all atoms or of selected ones: `STYLE` or `SELECTION=STYLE`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StyleOf(pub Option<Selection>, pub StyleArg);

impl FromStr for StyleOf {
    type Err = String;

    fn from_str(text: &str) -> Result<StyleOf, String> {
        let style = |name: &str| StyleArg::from_str(name.trim(), true);
        if !text.contains('=') {
            let all: Vec<String> = StyleArg::value_variants().iter().map(Named::name).collect();
            return style(text)
                .map(|style| StyleOf(None, style))
                .map_err(|_| format!("expected {}, or SELECTION=STYLE such as \"ligand=licorice\"", all.join(", ")));
        }
        let (atoms, value) = of_selection(text, "\"ligand=licorice\"")?;
        match style(value) {
            Ok(style) => Ok(StyleOf(Some(atoms), style)),
            Err(_) => {
                let all: Vec<String> = StyleArg::value_variants().iter().map(Named::name).collect();
                Err(format!("expected {} behind the =, found {value}", all.join(", ")))
            }
        }
    }
}

impl std::fmt::Display for StyleOf {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.0 {
            Some(atoms) => write!(f, "{atoms}={}", self.1.name()),
            None => f.write_str(&self.1.name()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::values::tests::check;

    #[test]
    fn colours_and_styles_of_selections() {
        let atoms = |text: &str| Selection::parse(text).unwrap();
        check(
            &[
                ("chain A=red", ColorOf(atoms("chain A"), Srgb8::rgb(255, 0, 0))),
                ("bfactor = 30 = #102030", ColorOf(atoms("bfactor = 30"), Srgb8::rgb(16, 32, 48))),
            ],
            &["", "red", "chain A", "chain A=reddish", "=red", "chian A=red", "chain A=#10203040"],
        );
        check(
            &[
                ("licorice", StyleOf(None, StyleArg::Licorice)),
                ("occupancy=1=space-filling", StyleOf(Some(atoms("occupancy=1")), StyleArg::SpaceFilling)),
            ],
            &["", "cartoon", "ligand=", "ligand=cartoon", "=licorice", "ligant=licorice"],
        );
        let error = "chain A adn water=red".parse::<ColorOf>().unwrap_err();
        assert!(error.contains("did you mean `and`?") && error.ends_with("        ^^^"), "{error}");
        assert!(times("0").is_err() && times("nan").is_err() && times("1.5") == Ok(1.5));
    }
}
