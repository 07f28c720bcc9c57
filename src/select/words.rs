//! The words of the language: the one table that the parser, `--help` and completions are made of.

use crate::element::Element;
use crate::error::slips;

/// Atoms that a word alone names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Set {
    All,
    None,
    Protein,
    Nucleic,
    Polymer,
    Backbone,
    Sidechain,
    Ligand,
    Water,
    Ion,
    Metal,
    Hydrogen,
    Hetero,
    Helix,
    Strand,
}

/// What a list of names is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NameOf {
    Chain,
    Residue,
    Atom,
    Altloc,
}

/// What a list of whole numbers is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NumberOf {
    Index,
    Drawn,
    Serial,
    File,
}

/// What is less or more than a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Number(NumberOf),
    Residue,
    BFactor,
    Occupancy,
    Charge,
    PartialCharge,
    X,
    Y,
    Z,
}

/// Which side of a distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Near {
    Within,
    Around,
    Beyond,
}

/// What atoms are widened to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    Residue,
    Chain,
    Molecule,
}

/// What a word does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meaning {
    Set(Set),
    Names(NameOf),
    Elements,
    Residues,
    Numbers(NumberOf),
    Quantity(Quantity),
    Near(Near),
    Bonded,
    /// `same residue as …`.
    Same,
    /// `byres …`.
    By(Group),
    Not,
    And,
    Or,
}

/// A word, what else it may be called, how it is used, and what it finds.
#[derive(Debug)]
pub(super) struct Word {
    pub(super) name: &'static str,
    pub(super) aliases: &'static [&'static str],
    pub(super) usage: &'static str,
    pub(super) help: &'static str,
    pub(super) meaning: Meaning,
}

const fn word(
    name: &'static str,
    aliases: &'static [&'static str],
    usage: &'static str,
    help: &'static str,
    meaning: Meaning,
) -> Word {
    Word { name, aliases, usage, help, meaning }
}

/// All of them, in the order of the help.
pub(super) const WORDS: &[Word] = &[
    word(
        "chain",
        &["segid"],
        "chain A,B",
        "chains by their letters, upper and lower case apart",
        Meaning::Names(NameOf::Chain),
    ),
    word(
        "residue",
        &["resi", "resid"],
        "residue 10-20,52A",
        "residues by number; without its letter an insertion's too",
        Meaning::Residues,
    ),
    word("resname", &["resn"], "resname ALA,HE*", "residues by name", Meaning::Names(NameOf::Residue)),
    word("name", &["atomname"], "name CA,C*", "atoms by name", Meaning::Names(NameOf::Atom)),
    word("element", &["elem", "symbol"], "element Fe,Zn", "atoms of elements", Meaning::Elements),
    word(
        "index",
        &[],
        "index 1-10",
        "atoms by their number in the file, from 1, as labels show it",
        Meaning::Numbers(NumberOf::Index),
    ),
    word(
        "drawn",
        &[],
        "drawn 1-10",
        "atoms by their number among those drawn, copies in a crystal counted",
        Meaning::Numbers(NumberOf::Drawn),
    ),
    word(
        "serial",
        &["id"],
        "serial 1-10",
        "atoms by the serial number that the file gives",
        Meaning::Numbers(NumberOf::Serial),
    ),
    word(
        "file",
        &["model"],
        "file 2",
        "all of a file, by its place on the command line",
        Meaning::Numbers(NumberOf::File),
    ),
    word(
        "altloc",
        &["alt"],
        "altloc A",
        "alternate locations by their letter; \"\" is none",
        Meaning::Names(NameOf::Altloc),
    ),
    word("all", &["everything"], "all", "every atom", Meaning::Set(Set::All)),
    word("none", &["nothing"], "none", "no atom", Meaning::Set(Set::None)),
    word("protein", &["peptide"], "protein", "amino acids of chains", Meaning::Set(Set::Protein)),
    word("nucleic", &["dna", "rna"], "nucleic", "nucleotides of chains", Meaning::Set(Set::Nucleic)),
    word("polymer", &[], "polymer", "protein and nucleic", Meaning::Set(Set::Polymer)),
    word(
        "backbone",
        &["mainchain"],
        "backbone",
        "N, CA, C, O of a protein, sugar and phosphate, with their hydrogens",
        Meaning::Set(Set::Backbone),
    ),
    word("sidechain", &[], "sidechain", "the rest of a polymer", Meaning::Set(Set::Sidechain)),
    word("ligand", &["ligands"], "ligand", "what is neither polymer nor water nor ion", Meaning::Set(Set::Ligand)),
    word("water", &["waters", "solvent"], "water", "water molecules", Meaning::Set(Set::Water)),
    word("ion", &["ions"], "ion", "single ions, sulfate, phosphate and the like", Meaning::Set(Set::Ion)),
    word("metal", &["metals"], "metal", "metal atoms", Meaning::Set(Set::Metal)),
    word("hydrogen", &["hydrogens", "hydro"], "hydrogen", "hydrogen atoms", Meaning::Set(Set::Hydrogen)),
    word("hetero", &["het", "hetatm"], "hetero", "what the file lists as HETATM", Meaning::Set(Set::Hetero)),
    word("helix", &["helices"], "helix", "helices that the file states", Meaning::Set(Set::Helix)),
    word("strand", &["sheet", "strands"], "strand", "strands that the file states", Meaning::Set(Set::Strand)),
    word(
        "bfactor",
        &["beta", "b_factor", "tempfactor"],
        "bfactor > 30",
        "by temperature factor, Å²; < <= > >= = !=",
        Meaning::Quantity(Quantity::BFactor),
    ),
    word("occupancy", &["occ"], "occupancy < 1", "by occupancy", Meaning::Quantity(Quantity::Occupancy)),
    word("charge", &["formal_charge"], "charge > 0", "by formal charge", Meaning::Quantity(Quantity::Charge)),
    word(
        "partial_charge",
        &["partialcharge"],
        "partial_charge < -0.3",
        "by partial charge, where the file gives it",
        Meaning::Quantity(Quantity::PartialCharge),
    ),
    word("x", &[], "x < 5", "by coordinate in the file, Å", Meaning::Quantity(Quantity::X)),
    word("y", &[], "y < 5", "the same", Meaning::Quantity(Quantity::Y)),
    word("z", &[], "z < 5", "the same", Meaning::Quantity(Quantity::Z)),
    word(
        "within",
        &[],
        "within 5 of ligand",
        "not farther than 5 Å from these, they among them",
        Meaning::Near(Near::Within),
    ),
    word("around", &["exwithin"], "around 5 of ligand", "the same without them", Meaning::Near(Near::Around)),
    word("beyond", &[], "beyond 5 of ligand", "farther than 5 Å from all of these", Meaning::Near(Near::Beyond)),
    word("bonded", &["bound_to", "neighbor"], "bonded to element Fe", "what has a bond to these", Meaning::Bonded),
    word("same", &[], "same residue as name SG", "whole residues of these; also chain, molecule", Meaning::Same),
    word("byres", &["byresidue"], "byres name SG", "short for same residue as", Meaning::By(Group::Residue)),
    word("bychain", &[], "bychain name SG", "short for same chain as", Meaning::By(Group::Chain)),
    word(
        "bymolecule",
        &["bymol"],
        "bymolecule index 1",
        "short for same molecule as: all that bonds join",
        Meaning::By(Group::Molecule),
    ),
    word("not", &[], "not water", "all others; binds closer than and, as within, bonded and same do", Meaning::Not),
    word("and", &[], "chain A and ligand", "what is both; binds closer than or", Meaning::And),
    word("or", &[], "ligand or metal", "what is one of the two; parentheses group", Meaning::Or),
];

/// The groups of `same … as`.
pub(super) const GROUPS: [(&str, Group); 4] = [
    ("residue", Group::Residue),
    ("chain", Group::Chain),
    ("molecule", Group::Molecule),
    ("fragment", Group::Molecule),
];

/// The word of a name or alias, in any case.
pub(super) fn find(text: &str) -> Option<&'static Word> {
    WORDS.iter().find(|word| word.names().any(|name| name.eq_ignore_ascii_case(text)))
}

impl Word {
    /// Its name, then what else it is called.
    pub(super) fn names(&self) -> impl Iterator<Item = &'static str> {
        std::iter::once(self.name).chain(self.aliases.iter().copied())
    }

    /// Whether it joins terms, and so stands where one is over.
    pub(super) fn is_joint(&self) -> bool {
        matches!(self.meaning, Meaning::And | Meaning::Or)
    }
}

/// What was likely meant by a word that is none.
pub(super) fn likely(text: &str) -> Option<String> {
    if super::kinds::is_residue_name(text) {
        return Some(format!("resname {text}"));
    }
    let mut letters = text.chars();
    let is_symbol = letters.next().is_some_and(|c| c.is_ascii_uppercase())
        && letters.all(|c| c.is_ascii_lowercase())
        && text.len() <= 2;
    if is_symbol && let Some(element) = Element::from_symbol(text) {
        return Some(format!("element {element}"));
    }
    // One slip in a short word, two in a long one.
    let most = if text.chars().count() <= 4 { 1 } else { 2 };
    let lower = text.to_ascii_lowercase();
    let names = WORDS.iter().flat_map(Word::names).filter(|name| name.len() > 1);
    let nearest = names.map(|name| (slips(&lower, name), name)).min_by_key(|&(count, _)| count);
    match nearest {
        Some((count, name)) if count <= most => Some(name.to_owned()),
        _ if text.starts_with(|c: char| c.is_ascii_digit()) => Some(format!("residue {text}")),
        _ if text.len() == 1 => Some(format!("chain {text}")),
        _ => None,
    }
}

/// Columns of the help: what any terminal shows.
const COLUMNS: usize = 78;

/// The language in lines that a person can read: for `--help` and the window.
#[must_use]
pub fn help() -> String {
    let mut text = String::from(
        "Selections name atoms by words, joined by and, or, not and parentheses, in\n\
         any case. Names take * and ? for any letters, and quotes where they have\n\
         blanks or are words of the language:\n",
    );
    let width = WORDS.iter().map(|word| word.usage.len()).max().unwrap_or(0);
    for word in WORDS {
        let mut line = format!("  {:width$} ", word.usage);
        let also = match word.aliases {
            [] => String::new(),
            aliases => format!(" (also {})", aliases.join(", ")),
        };
        for part in format!("{}{also}", word.help).split(' ') {
            if line.chars().count() + 1 + part.chars().count() > COLUMNS {
                text.push_str(&line);
                text.push('\n');
                line = " ".repeat(width + 3);
            }
            line.push(' ');
            line.push_str(part);
        }
        text.push_str(&line);
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_word_stands_for_two_things_and_every_usage_is_a_selection() {
        let mut names: Vec<&str> = WORDS.iter().flat_map(Word::names).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
        for word in WORDS {
            assert!(super::super::Selection::parse(word.usage).is_ok(), "{}", word.usage);
            assert!(help().contains(word.usage) && !word.help.is_empty(), "{}", word.name);
        }
        assert!(help().lines().all(|line| line.chars().count() <= COLUMNS));
    }

    #[test]
    fn slips_of_the_keyboard_are_seen_through() {
        for (typed, meant) in [
            ("resnmae", "resname"),
            ("chian", "chain"),
            ("watr", "water"),
            ("lignd", "ligand"),
            ("PROTIEN", "protein"),
            ("Fe", "element Fe"),
            ("HEM", "resname HEM"),
            ("GLY", "resname GLY"),
            ("12", "residue 12"),
            ("B", "element B"),
            ("Q", "chain Q"),
        ] {
            assert_eq!(likely(typed).as_deref(), Some(meant), "{typed}");
        }
        assert_eq!(likely("xyzzy"), None);
    }
}
