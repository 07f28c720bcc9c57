//! Flags that take back what others ask for: a later one beats an earlier one, so that what a picture or session says (`--from`), or an alias of
//! the shell, can be undone.

use clap::Args;

/// The other sides of switches that are off, or on, unless said.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct OppositeArgs {
    /// Draw hydrogens (the default): takes --no-hydrogens back, here or in --from
    #[arg(long, overrides_with = "no_hydrogens", help_heading = "Molecule", hide_short_help = true)]
    pub hydrogens: bool,
    /// Draw water (the default): takes --no-water back
    #[arg(long, overrides_with = "no_water", help_heading = "Molecule", hide_short_help = true)]
    pub water: bool,
    /// Draw ions (the default): takes --no-ions back
    #[arg(long, overrides_with = "no_ions", help_heading = "Molecule", hide_short_help = true)]
    pub ions: bool,
    /// A stick to each atom of a ring (the default): takes --haptic back
    #[arg(long, overrides_with = "haptic", help_heading = "Molecule", hide_short_help = true)]
    pub no_haptic: bool,
    /// No directions of axes (the default): takes --axes back
    #[arg(long, overrides_with = "axes", help_heading = "Look", hide_short_help = true)]
    pub no_axes: bool,
    /// Fill the triangles of overlays (the default): takes --overlay-wireframe back
    #[arg(long, overrides_with = "overlay_wireframe", help_heading = "Overlay", hide_short_help = true)]
    pub no_overlay_wireframe: bool,
    /// No legend (the default): takes --legend back
    #[arg(long, overrides_with = "legend", help_heading = "Text", hide_short_help = true)]
    pub no_legend: bool,
    /// No scale bar (the default): takes --scale-bar back
    #[arg(long, overrides_with = "scale_bar", help_heading = "Text", hide_short_help = true)]
    pub no_scale_bar: bool,
}

impl OppositeArgs {
    /// Their names, which sessions need not keep.
    #[cfg(test)]
    pub(super) const NAMES: [&str; 9] = [
        "hydrogens",
        "water",
        "ions",
        "no-haptic",
        "no-axes",
        "no-overlay-wireframe",
        "no-legend",
        "no-scale-bar",
        "no-hbonds",
    ];
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::args::{Cli, Command};
    use clap::Parser;

    #[test]
    fn the_later_of_two_opposites_holds() {
        for name in OppositeArgs::NAMES {
            let other = name.strip_prefix("no-").map_or_else(|| format!("no-{name}"), str::to_owned);
            let on = |flags: [&str; 2]| {
                let line = ["ballstick", "render", "a.pdb", "-o", "a.png", "--overlay", "a.obj"];
                let flags = flags.map(|flag| format!("--{flag}"));
                let cli = Cli::try_parse_from(line.map(str::to_owned).into_iter().chain(flags)).unwrap();
                let Some(Command::Render(args)) = cli.command else { panic!("no render") };
                let look = &args.look;
                match name {
                    "hydrogens" => !look.no_hydrogens,
                    "water" => !look.no_water,
                    "ions" => !look.no_ions,
                    "no-haptic" => !look.haptic,
                    "no-axes" => !look.axes,
                    "no-overlay-wireframe" => !look.overlay_wireframe,
                    "no-legend" => !look.text.legend,
                    "no-scale-bar" => !look.text.scale_bar,
                    _ => !args.bonds.hbonds,
                }
            };
            assert!(on([&other, name]), "{name} takes {other} back");
            assert!(!on([name, &other]), "{other} takes {name} back");
        }
    }
}
