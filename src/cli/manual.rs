//! `ballstick manual` and `ballstick completions`: what the shell and `man` want to know, from the definition of the flags itself.
//!
//! Packages run them when they are built; a person may as well (`ballstick manual | man -l -`).

use super::args::Cli;
use super::report::Report;
use crate::error::Error;
use crate::export::atomic;
use clap::{Args, CommandFactory, ValueEnum};
use clap_mangen::Man;
use clap_mangen::roff::{Roff, roman};
use std::io;
use std::path::{Path, PathBuf};

/// `ballstick manual`.
#[derive(Debug, Clone, Args)]
pub struct ManualArgs {
    /// The page of a command; all of them are in the folder of --output
    #[arg(value_name = "COMMAND")]
    pub command: Option<String>,
    /// Write the pages of all commands into this folder, which is made if it is not there
    #[arg(short, long, value_name = "FOLDER", conflicts_with = "command")]
    pub output: Option<PathBuf>,
}

/// `ballstick completions`.
#[derive(Debug, Clone, Args)]
pub struct CompletionsArgs {
    /// The shell
    pub shell: ShellArg,
}

/// A shell that completes words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ShellArg {
    /// Bash
    Bash,
    /// Zsh
    Zsh,
    /// Fish
    Fish,
    /// PowerShell
    Powershell,
    /// Elvish
    Elvish,
}

/// What `--help` says behind the options.
pub(super) const AFTER_HELP: &str = "\
Examples:
  ballstick caffeine.sdf                     look at it in a window
  ballstick render 1crn.pdb -o figure.png    draw it into a file
  ballstick render *.cif -o pictures/        draw many
  ballstick info 1crn.pdb                    say what is in it
  ballstick convert 1crn.pdb crambin.json    write another format

A file that is called like a command is opened as ./render, or by
`ballstick view render`. Results go to standard output, everything else to
standard error; `-` is standard input or output.
Exit status: 0 done (also with warnings), 1 some inputs failed, 2 the command
line is wrong, 128 + N ended by signal N (130 is Ctrl+C). Files are written
whole or not at all.";

/// What a page says behind the options, by its command; the same sections on all pages come after it.
const EXAMPLES: [(&str, &[&str]); 4] = [
    (
        "ballstick",
        &[
            "ballstick caffeine.sdf",
            "ballstick render 1crn.pdb -o figure.png --size 3000x2000 --background transparent",
            "ballstick info --json structures/* | jq -r .formula",
            "ballstick convert 1crn.pdb crambin.json",
        ],
    ),
    (
        "ballstick-render",
        &[
            "ballstick render 1crn.pdb -o figure.png --quality high",
            "ballstick render *.pdb.gz -o pictures/",
            "ballstick render 5pti.cif -o site.png --show 'within 8 of ligand'",
            "ballstick render 1crn.pdb -o turn.gif --turntable=72 --size 640x480",
        ],
    ),
    ("ballstick-info", &["ballstick info 1crn.pdb", "ballstick info top.pdb run.xtc"]),
    ("ballstick-convert", &["ballstick convert in.pdb out.cif", "ballstick convert - - --to xyz < in.sdf"]),
];

/// An error is one of usage.
pub(super) fn run_manual(args: &ManualArgs, report: &Report) -> Result<(), String> {
    let pages = pages();
    if let Some(folder) = &args.output {
        let written = std::fs::create_dir_all(folder)
            .map_err(|source| Error::Io { action: "make the folder", path: folder.clone(), source })
            .and_then(|()| {
                pages.iter().try_for_each(|(name, page)| {
                    atomic::write(&folder.join(format!("{name}.1")), |out| out.write_all(page))
                })
            });
        if let Err(error) = written {
            report.fail(folder, &error);
        }
        return Ok(());
    }
    let wanted = args.command.as_ref().map_or_else(|| "ballstick".to_owned(), |command| format!("ballstick-{command}"));
    let Some((_, page)) = pages.iter().find(|(name, _)| *name == wanted) else {
        let names: Vec<&str> = pages.iter().filter_map(|(name, _)| name.strip_prefix("ballstick-")).collect();
        return Err(format!("there is no such command; they are {}", names.join(", ")));
    };
    print(page, report);
    Ok(())
}

pub(super) fn run_completions(args: &CompletionsArgs, report: &Report) {
    print(&completions(args.shell), report);
}

fn print(bytes: &[u8], report: &Report) {
    let written = atomic::write(Path::new("-"), |out| out.write_all(bytes));
    match written {
        Err(error) if !atomic::is_broken_pipe(&error) => report.fail(Path::new("-"), &error),
        _ => {}
    }
}

fn completions(shell: ShellArg) -> Vec<u8> {
    use clap_complete::{Shell, generate};
    let shell = match shell {
        ShellArg::Bash => Shell::Bash,
        ShellArg::Zsh => Shell::Zsh,
        ShellArg::Fish => Shell::Fish,
        ShellArg::Powershell => Shell::PowerShell,
        ShellArg::Elvish => Shell::Elvish,
    };
    let mut text = Vec::new();
    generate(shell, &mut Cli::command(), "ballstick", &mut text);
    text
}

/// The pages of all commands with their names.
fn pages() -> Vec<(String, Vec<u8>)> {
    // Lines of any width: `man` breaks them itself.
    let mut all = Cli::command().disable_help_subcommand(true).term_width(0);
    all.build();
    let mut pages = vec![("ballstick".to_owned(), page(&all, "ballstick"))];
    for command in all.get_subcommands().filter(|command| !command.is_hide_set()) {
        let name = format!("ballstick-{}", command.get_name());
        let named = command.clone().display_name(name.clone());
        pages.push((name.clone(), page(&named, &name)));
    }
    // Writing to memory cannot fail.
    pages.into_iter().filter_map(|(name, page)| Some((name, page.ok()?))).collect()
}

fn page(command: &clap::Command, name: &str) -> io::Result<Vec<u8>> {
    let man = Man::new(command.clone()).title(name.to_uppercase()).manual("ballstick");
    let mut page = Vec::new();
    man.render_title(&mut page)?;
    man.render_name_section(&mut page)?;
    man.render_synopsis_section(&mut page)?;
    man.render_description_section(&mut page)?;
    man.render_options_section(&mut page)?;
    if command.has_subcommands() {
        man.render_subcommands_section(&mut page)?;
    }
    let mut rest = Roff::new();
    // Tables keep their columns.
    if let Some(extra) = command.get_after_long_help().or(command.get_after_help()) {
        rest.control("SH", ["NOTES"]);
        rest.control("nf", []);
        for line in extra.to_string().lines() {
            rest.text([roman(line)]);
        }
        rest.control("fi", []);
    }
    if let Some((_, examples)) = EXAMPLES.iter().find(|(of, _)| *of == name) {
        rest.control("SH", ["EXAMPLES"]);
        rest.control("nf", []);
        for line in *examples {
            rest.text([roman(*line)]);
        }
        rest.control("fi", []);
    }
    rest.control("SH", ["EXIT STATUS"]);
    for (status, meaning) in super::STATUSES {
        rest.control("TP", []);
        rest.text([roman(*status)]);
        rest.text([roman(*meaning)]);
    }
    rest.control("SH", ["ENVIRONMENT"]);
    for (name, meaning) in super::ENVIRONMENT {
        rest.control("TP", []);
        rest.text([roman(*name)]);
        rest.text([roman(*meaning)]);
    }
    rest.to_writer(&mut page)?;
    if command.get_version().is_some() {
        man.render_version_section(&mut page)?;
    }
    Ok(page)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_page_with_all_its_flags() {
        let pages = pages();
        let names: Vec<&str> = pages.iter().map(|(name, _)| name.as_str()).collect();
        for command in ["ballstick", "ballstick-view", "ballstick-render", "ballstick-info", "ballstick-convert"] {
            assert!(names.contains(&command), "{names:?}");
        }
        let render = Cli::command();
        let render = render.find_subcommand("render").unwrap();
        let (_, page) = pages.iter().find(|(name, _)| name == "ballstick-render").unwrap();
        let page = String::from_utf8(page.clone()).unwrap().replace('\\', "");
        for flag in render.get_arguments().filter_map(clap::Arg::get_long) {
            assert!(page.contains(&format!("--{flag}")), "--{flag}");
        }
        assert!(page.contains(".SH EXAMPLES") && page.contains("near_angstrom"));
    }

    #[test]
    fn every_shell_learns_the_flags() {
        for shell in ShellArg::value_variants() {
            let text = String::from_utf8(completions(*shell)).unwrap();
            assert!(text.contains("ballstick") && text.contains("color-by") && text.contains("turntable"), "{shell:?}");
        }
    }

    #[test]
    fn examples_are_command_lines_of_this_program() {
        for (_, lines) in EXAMPLES {
            for line in lines {
                let line = line.split(['|', '<']).next().unwrap_or(line).replace('\'', "");
                let words = line.replace("within 8 of ligand", "ligand");
                let parsed = <Cli as clap::Parser>::try_parse_from(words.split_whitespace());
                assert!(parsed.is_ok(), "{line}: {parsed:?}");
            }
        }
    }
}
