//! `--assembly`: which biological assembly is drawn or written, and what is said where there is none.

use super::report::Report;
use crate::crystal::{AssemblyId, Drawn};
use crate::error::{Error, Result};
use crate::structure::{Assembly, Structure};
use clap::Args;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;

/// Which assembly.
#[derive(Debug, Clone, Copy, Args)]
pub struct AssemblyArgs {
    /// Take this biological assembly of files that state any (mmCIF, BinaryCIF, PDB), by its id; info lists them. Pictures draw it from
    /// one copy of its atoms, and neither --cell nor --supercell counts
    #[arg(long, value_name = "ID", default_value = "none", value_parser = wish, help_heading = "Crystal")]
    pub assembly: Wish,
}

/// An assembly or none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wish(pub Option<AssemblyId>);

fn wish(text: &str) -> Result<Wish, String> {
    match text {
        "none" => Ok(Wish(None)),
        id => AssemblyId::new(id).map(|id| Wish(Some(id))).ok_or_else(|| {
            format!("expected the id of an assembly, such as 1, of at most {} letters", AssemblyId::MOST)
        }),
    }
}

/// An error if a file has assemblies, but not the one that is asked for.
pub(super) fn check<'a>(asked: Option<AssemblyId>, records: impl Iterator<Item = &'a Structure>) -> Result<()> {
    let Some(id) = asked else { return Ok(()) };
    let mut there: Vec<String> = Vec::new();
    for assembly in records.flat_map(Structure::assemblies) {
        if assembly.id == id.as_str() {
            return Ok(());
        }
        if there.len() < 20 && !there.contains(&assembly.id) {
            there.push(assembly.id.clone());
        }
    }
    match there.as_slice() {
        [] => Ok(()),
        ids => Err(Error::input(None, format!("there is no assembly {id}; the file has {}", ids.join(", ")))),
    }
}

/// Says that a file has no assemblies, if one is asked for.
pub(super) fn warn_of_none(drawn: &[Drawn], asked: Option<AssemblyId>, path: &Path, report: &Report) {
    if let Some(id) = asked.filter(|_| drawn.iter().all(|drawn| drawn.copies.is_none())) {
        report.warn(path, &format!("--assembly {id} has no effect: the file states no assemblies"));
    }
}

/// What `info` says of an assembly.
#[derive(Debug, Serialize)]
pub(super) struct AssemblyInfo {
    id: String,
    description: String,
    /// Names of the chains that have atoms in it.
    chains: Vec<String>,
    /// Distinct operations.
    copies: usize,
    /// Atoms in all copies together.
    atoms: usize,
}

impl AssemblyInfo {
    pub(super) fn all(structure: &Structure) -> Vec<AssemblyInfo> {
        structure.assemblies().iter().map(|assembly| AssemblyInfo::of(structure, assembly)).collect()
    }

    fn of(structure: &Structure, assembly: &Assembly) -> AssemblyInfo {
        let (sets, set_of) = assembly.sets(structure.atom_count());
        let mut is_in = vec![false; structure.chains().len()];
        for residue in structure.residues() {
            let has_place = set_of.get(residue.first_atom as usize).is_some_and(|&set| (set as usize) < sets.len());
            if let Some(is_in) = is_in.get_mut(residue.chain as usize) {
                *is_in |= has_place;
            }
        }
        let chains = structure.chains().zip(is_in).filter(|(_, is_in)| *is_in).map(|(name, _)| name.to_owned());
        AssemblyInfo {
            id: assembly.id.clone(),
            description: assembly.description.clone(),
            chains: chains.collect(),
            copies: assembly.operations.len(),
            atoms: assembly.atom_count(structure.atom_count()),
        }
    }

    /// In a line for people.
    pub(super) fn words(&self) -> String {
        /// Chains that are named.
        const MOST: usize = 12;
        let copies = if self.copies == 1 { "1 copy".to_owned() } else { format!("{} copies", self.copies) };
        let mut text = format!("{}: {copies}, {} atoms; chains {}", self.id, self.atoms, {
            self.chains.iter().take(MOST).map(String::as_str).collect::<Vec<_>>().join(", ")
        });
        if self.chains.len() > MOST {
            let _ = write!(text, " and {} more", self.chains.len() - MOST); // writing to a String cannot fail
        }
        if !self.description.is_empty() {
            let _ = write!(text, "; {}", self.description);
        }
        super::report::printable(&text)
    }
}

/// The records with the atoms of the assembly, copied, where they have it.
pub(super) fn written(
    records: Vec<Structure>,
    asked: Option<AssemblyId>,
    (path, report): (&Path, &Report),
) -> Result<Vec<Structure>> {
    let Some(id) = asked else { return Ok(records) };
    check(asked, records.iter())?;
    /// As many as pictures draw.
    const MOST: usize = 50_000_000;
    let copied = |record: Structure| match record.assembly(id.as_str()) {
        Some(assembly) => {
            let atoms = assembly.atom_count(record.atom_count());
            if atoms > MOST {
                return Err(Error::limit(None, format!("assembly {id} has {atoms} atoms, more than {MOST}")));
            }
            if record.frames().len() > 1 {
                report.warn(path, "of an assembly the first frame is written; --frame N chooses another");
            }
            Ok(record.assembled(assembly))
        }
        None => {
            report.warn(path, &format!("--assembly {id} has no effect: the file states no assemblies"));
            Ok(record)
        }
    };
    records.into_iter().map(copied).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::{AtomRecord, Diagnostics, StructureBuilder};
    use glam::{DAffine3, DVec3};

    fn structure() -> Structure {
        let mut builder = StructureBuilder::new();
        for chain in ["A", "B"] {
            builder.push_atom(&AtomRecord { residue: Some((chain, 1, b' ', "GLY")), ..AtomRecord::default() });
        }
        let mut structure = builder.build(&mut Diagnostics::default());
        let mut pair = Assembly::new("PAIR", "two of them");
        pair.push(vec![0..1], &[DAffine3::IDENTITY, DAffine3::from_translation(DVec3::X)]);
        structure.assemblies = vec![pair];
        structure
    }

    #[test]
    fn an_assembly_that_is_not_there_is_an_error_where_there_are_others() {
        let asked = |id: &str| check(AssemblyId::new(id), std::iter::once(&structure()));
        assert!(asked("PAIR").is_ok() && check(None, std::iter::once(&structure())).is_ok());
        assert!(asked("2").unwrap_err().to_string().contains("no assembly 2; the file has PAIR"));
        assert!(check(AssemblyId::new("2"), std::iter::empty()).is_ok());
        assert!(wish("").is_err() && wish("none") == Ok(Wish(None)));
    }

    #[test]
    fn info_names_chains_copies_and_atoms() {
        let structure = structure();
        let words: Vec<String> = AssemblyInfo::all(&structure).iter().map(AssemblyInfo::words).collect();
        assert_eq!(words, ["PAIR: 2 copies, 2 atoms; chains A; two of them"]);
    }
}
