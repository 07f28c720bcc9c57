//! PDB files, format version 3.3.
//!
//! - Serial and residue numbers beyond the columns are hybrid-36. Serials are those of the structure, unless two atoms of
//!   it share one: then they are counted.
//! - CONECT is written for every bond but those that residue names say: inside standard amino acids, nucleotides and water,
//!   and C–N and O3'–P between them. A bond of order n is repeated n times in each direction. Of aromatic bonds the order is
//!   that of the Kekulé form, or one where none is known.
//! - Each frame is a MODEL, as is each record where there are more; a record's CONECT stands inside its MODEL then. CRYST1
//!   is repeated where the cell changes.
//! - Symmetry operations are REMARK 290, before the CRYST1 of their cell.
//! - Atoms without a name get their element and a number, atoms without residue are HETATM of `UNL` with the record's
//!   number.
//! - Chain names of more than one character get a character that is free; names too long are cut.
//!
//! Positions have three decimals; one that does not fit its eight columns is an error.

mod assembly;

use super::formats::{Part, StructureFormat};
use super::text::symbol_with_isotope;
use super::text::{
    AtomNames, Position, fits_decimals, invalid, is_standard, metals, one_line, parameters, plain_bonds,
};
use crate::element::Element;
use crate::structure::{Bond, BondKind, BondOrder, Cell, Frame, Residue, Structure, atom_flags};
use std::collections::{HashMap, HashSet};
use std::io::{self, Write};

/// The format's line in the table.
pub static FORMAT: StructureFormat = StructureFormat {
    name: "pdb",
    extensions: &["pdb", "ent"],
    description: "PDB 3.3 (all records and frames as models)",
    all_frames: true,
    holds: &[
        Part::Title,
        Part::Frames,
        Part::Bonds,
        Part::CoordinationBonds,
        Part::Cell,
        Part::FrameCells,
        Part::SpaceGroup,
        Part::SymmetryOperations,
        Part::Assemblies,
        Part::AtomNames,
        Part::Serials,
        Part::Residues,
        Part::AtomKinds,
        Part::Altlocs,
        Part::Occupancies,
        Part::BFactors,
        Part::FormalCharges,
        Part::HydrogenIsotopes,
        Part::Secondary,
    ],
    limits,
    write,
};

fn limits(structure: &Structure) -> Vec<&'static str> {
    let count = structure.atom_count();
    let any = |test: &dyn Fn(usize) -> bool| (0..count).any(test);
    let residue = |test: &dyn Fn(&str) -> bool| structure.residues().iter().any(|r| test(structure.name(r.name)));
    let cells = || structure.frames().iter().filter_map(|frame| frame.cell.as_ref());
    let rounded = |cell: &Cell| {
        let (lengths, angles) = parameters(cell);
        !lengths.iter().all(|&x| fits_decimals(x, 3)) || !angles.iter().all(|&x| fits_decimals(x, 2))
    };
    let fine = |value: f32| ((f64::from(value) * 100.0).round() / 100.0) as f32 != value;
    let no_order = |bond: &Bond| bond.kind == BondKind::Covalent && bond.order == BondOrder::Unknown;
    let to_metal = |bond: &Bond| bond.kind == BondKind::Covalent && metals(structure, bond) == 1;
    let found = [
        (
            structure.frames().iter().any(|frame| frame.positions.decimals() > 3),
            "digits of positions beyond the third decimal",
        ),
        (any(&|i| structure.atom_name(i).len() > 4), "atom names of more than four characters (cut)"),
        (residue(&|name| name.len() > 4), "residue names of more than four characters (cut)"),
        (structure.chains().any(|chain| chain.len() > 1), "chain names of more than one character (renamed)"),
        (has_repeated_serials(structure), "serial numbers that two atoms share (counted anew)"),
        (any(&|i| structure.formal_charge(i).unsigned_abs() > 9), "charges of more than nine (left out)"),
        (any(&|i| fine(structure.occupancy(i)) || fine(structure.b_factor(i))), "digits of occupancies or B factors"),
        (plain_bonds(structure).any(no_order), "bonds of unknown order (read back as single)"),
        (
            plain_bonds(structure).any(to_metal),
            "covalent bonds to metals (CONECT does not tell them from coordination)",
        ),
        (cells().any(rounded), "digits of the cell"),
        (cells().any(|cell| !is_standard(cell)), "the orientation of the cell"),
        (assembly::is_rounded(structure), "digits of the matrices of assemblies"),
        (!assembly::is_whole(structure), "assemblies of parts of chains (left out)"),
    ];
    found.into_iter().filter(|(found, _)| *found).map(|(_, phrase)| phrase).collect()
}

/// Writes all frames of all records.
///
/// # Errors
/// What the writer returns, and `InvalidData` for positions and numbers that do not fit their columns.
pub fn write(records: &[Structure], out: &mut dyn Write) -> io::Result<()> {
    let Some(first) = records.first() else { return Ok(()) };
    write_title(&one_line(super::formats::title(first)), out)?;
    assembly::write(first, out)?;
    for structure in records {
        write_secondary(structure, out)?;
    }
    let models: usize = records.iter().map(|record| record.frames().len()).sum();
    let mut number = 0usize;
    let mut crystal = None;
    for (record, structure) in records.iter().enumerate() {
        let atoms = Atoms::new(structure, record);
        for (index, frame) in structure.frames().iter().enumerate() {
            // Without any cell there is no CRYST1; behind one, the unit cell of 1 Å says that there is none any more.
            let this = (frame.cell.as_ref(), structure.symmetry());
            if crystal.map_or(frame.cell.is_some(), |last| last != this) {
                write_symmetry(structure, frame.cell.as_ref(), out)?;
                write_cell(structure, frame.cell.as_ref(), out)?;
                crystal = Some(this);
            }
            number += 1;
            if models > 1 {
                writeln!(out, "MODEL     {:>4}", number % 10_000)?;
            }
            atoms.write(frame, out)?;
            if records.len() > 1 && index == 0 {
                atoms.write_bonds(out)?;
            }
            if models > 1 {
                writeln!(out, "ENDMDL")?;
            }
        }
        if records.len() == 1 {
            atoms.write_bonds(out)?;
        }
    }
    writeln!(out, "END")
}

/// TITLE in lines of 80 columns, broken at blanks.
fn write_title(title: &str, out: &mut dyn Write) -> io::Result<()> {
    const ROOM: usize = 69;
    let mut rest = title.trim();
    let mut line = 1;
    while !rest.is_empty() {
        let mut end = rest.len();
        if rest.len() > ROOM {
            end = (0..=ROOM).rev().find(|&at| rest.is_char_boundary(at)).unwrap_or(ROOM);
            end = rest[..end].rfind(' ').filter(|&at| at > 0).unwrap_or(end);
        }
        let (head, tail) = rest.split_at(end);
        match line {
            1 => writeln!(out, "TITLE     {head}")?,
            2..=99 => writeln!(out, "TITLE   {line:2} {head}")?,
            _ => return Ok(()), // no title has six thousand characters
        }
        rest = tail.trim_start();
        line += 1;
    }
    Ok(())
}

fn write_cell(structure: &Structure, cell: Option<&Cell>, out: &mut dyn Write) -> io::Result<()> {
    let Some(cell) = cell else {
        return writeln!(out, "CRYST1    1.000    1.000    1.000  90.00  90.00  90.00 P 1           1");
    };
    let ([a, b, c], [alpha, beta, gamma]) = parameters(cell);
    if [a, b, c].iter().any(|&length| length >= 99_999.999_5) {
        return Err(invalid(format!(
            "the cell of {a} × {b} × {c} Å does not fit the nine columns PDB has for a length"
        )));
    }
    let group = structure.symmetry().map_or("", |symmetry| symmetry.space_group.as_str());
    let group: String = one_line(group).chars().take(11).collect();
    let line = format!("CRYST1{a:9.3}{b:9.3}{c:9.3}{alpha:7.2}{beta:7.2}{gamma:7.2} {group}");
    writeln!(out, "{}", line.trim_end())
}

/// REMARK 290: rotations and translations for positions in ångström.
fn write_symmetry(structure: &Structure, cell: Option<&Cell>, out: &mut dyn Write) -> io::Result<()> {
    let (Some(cell), Some(symmetry)) = (cell, structure.symmetry()) else { return Ok(()) };
    let (to_fractional, from_fractional) = (cell.fractional_from_cartesian(), cell.cartesian_from_fractional());
    for (index, operation) in symmetry.operations.iter().enumerate() {
        let rotation = from_fractional * operation.rotation * to_fractional;
        let translation = from_fractional * operation.translation;
        for axis in 0..3 {
            // Without the sign of what rounds to zero.
            let row = rotation.row(axis).map(|factor| (factor * 1e6).round() / 1e6 + 0.0);
            let along = (translation[axis] * 1e5).round() / 1e5 + 0.0;
            let number = index + 1;
            let [x, y, z] = row.to_array();
            writeln!(out, "REMARK 290   SMTRY{}{number:>4}{x:10.6}{y:10.6}{z:10.6}{along:15.5}", axis + 1)?;
        }
    }
    Ok(())
}

/// HELIX and SHEET.
fn write_secondary(structure: &Structure, out: &mut dyn Write) -> io::Result<()> {
    let chains = ChainNames::new(structure);
    let mut names: HashMap<(&str, i32, u8), &str> = HashMap::new();
    if !structure.secondary().is_empty() {
        let all: Vec<&str> = structure.chains().collect();
        for residue in structure.residues() {
            let chain = all.get(residue.chain as usize).copied().unwrap_or("");
            let key = (chain, residue.number, residue.insertion_code);
            names.entry(key).or_insert_with(|| structure.name(residue.name));
        }
    }
    let (mut helices, mut strands) = (0, 0);
    for element in structure.secondary() {
        let end = |(number, code): (i32, u8), blank: &str| -> io::Result<String> {
            let name = names.get(&(element.chain.as_str(), number, code)).copied().unwrap_or("UNK");
            let number = number_in_columns(number, 4)
                .ok_or_else(|| invalid(format!("residue number {number} does not fit the four columns PDB has")))?;
            let (chain, code) = (char::from(chains.of(&element.chain)), char::from(code));
            Ok(format!("{:>3} {chain}{blank}{number}{code}", cut(name, 3)))
        };
        if element.helix {
            helices = helices % 999 + 1;
            let (first, last) = (end(element.first, " ")?, end(element.last, " ")?);
            writeln!(out, "HELIX  {helices:3} {helices:>3} {first} {last} 1")?;
        } else {
            strands = strands % 999 + 1;
            let (first, last) = (end(element.first, "")?, end(element.last, "")?);
            writeln!(out, "SHEET  {strands:3}   A 1 {first} {last} 0")?;
        }
    }
    Ok(())
}

/// One character for each chain name.
struct ChainNames<'a> {
    by_name: HashMap<&'a str, u8>,
}

impl<'a> ChainNames<'a> {
    fn new(structure: &'a Structure) -> ChainNames<'a> {
        const FREE: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789";
        let mut by_name = HashMap::new();
        let mut taken = HashSet::new();
        for chain in structure.chains() {
            let byte = match chain.as_bytes() {
                [] => b' ',
                &[byte] if byte.is_ascii_graphic() => byte,
                _ => continue,
            };
            by_name.insert(chain, byte);
            taken.insert(byte);
        }
        let mut free = FREE.iter().filter(|byte| !taken.contains(byte));
        for chain in structure.chains() {
            // With more chains than characters the last of them have none.
            by_name.entry(chain).or_insert_with(|| free.next().copied().unwrap_or(b' '));
        }
        ChainNames { by_name }
    }

    fn of(&self, chain: &str) -> u8 {
        self.by_name.get(chain).copied().unwrap_or(b' ')
    }
}

/// As many characters as fit, what is not ASCII as `_`.
fn cut(text: &str, width: usize) -> String {
    text.chars().take(width).map(|c| if c.is_ascii_graphic() { c } else { '_' }).collect()
}

/// A number in so many columns, hybrid-36 where it has too many digits; `None` where that has too few as well.
fn number_in_columns(number: i32, width: usize) -> Option<String> {
    let text = format!("{number:>width$}");
    if text.len() <= width {
        return Some(text);
    }
    // The description of hybrid-36 by Grosse-Kunstleve, <http://cci.lbl.gov/hybrid_36/>: upper-case numbers that begin
    // with a letter follow the decimals, lower-case ones follow those.
    let exponent = u32::try_from(width).ok()?;
    let block = 36i64.pow(exponent - 1);
    let mut rest = i64::from(number) - 10i64.pow(exponent);
    if rest < 0 {
        return None; // a negative number too long
    }
    let lower = rest >= 26 * block;
    rest -= if lower { 26 * block } else { 0 };
    if rest >= 26 * block {
        return None;
    }
    rest += 10 * block;
    let mut digits = vec![b'0'; width];
    for digit in digits.iter_mut().rev() {
        let value = (rest % 36) as u8;
        *digit = match value {
            0..=9 => b'0' + value,
            _ if lower => b'a' + value - 10,
            _ => b'A' + value - 10,
        };
        rest /= 36;
    }
    String::from_utf8(digits).ok()
}

fn has_repeated_serials(structure: &Structure) -> bool {
    let mut seen = HashSet::new();
    Part::Serials.is_in(structure)
        && (0..structure.atom_count()).any(|atom| {
            let serial = structure.serial(atom);
            number_in_columns(serial, 5).is_none() || !seen.insert(serial)
        })
}

/// A number in a column, with as many of its decimals as fit.
fn value_in_columns(value: f32, width: usize, decimals: usize) -> String {
    for decimals in (0..=decimals).rev() {
        let text = format!("{value:width$.decimals$}");
        if text.len() <= width {
            return text;
        }
    }
    " ".repeat(width)
}

/// The atoms of one record, all but their positions.
struct Atoms<'a> {
    structure: &'a Structure,
    chains: Vec<u8>,
    /// Number of the residue of atoms that have none: by record, or molecules of the same atoms would pass for models of one.
    nameless_number: i32,
    /// Serials are counted, not the structure's.
    counted: bool,
}

impl<'a> Atoms<'a> {
    fn new(structure: &'a Structure, record: usize) -> Atoms<'a> {
        let names = ChainNames::new(structure);
        let chains = structure.chains().map(|chain| names.of(chain)).collect();
        let nameless_number = i32::try_from(record % 9999 + 1).unwrap_or(1);
        Atoms { structure, chains, nameless_number, counted: has_repeated_serials(structure) }
    }

    fn serial(&self, atom: usize) -> io::Result<String> {
        let counted = i32::try_from(atom + 1).unwrap_or(i32::MAX);
        let serial = if self.counted { counted } else { self.structure.serial(atom) };
        number_in_columns(serial, 5)
            .ok_or_else(|| invalid(format!("serial number {serial} does not fit the five columns PDB has")))
    }

    fn residue(&self, atom: usize) -> Option<&Residue> {
        self.structure.residue_index(atom).and_then(|index| self.structure.residues().get(index))
    }

    fn write(&self, frame: &Frame, out: &mut dyn Write) -> io::Result<()> {
        let structure = self.structure;
        let mut names = AtomNames::new(structure);
        let mut polymer: Option<u32> = None;
        for atom in 0..structure.atom_count() {
            let residue = self.residue(atom);
            let hetero = structure.flags(atom) & atom_flags::HETERO != 0 || residue.is_none();
            // The chain of a polymer has ended.
            if polymer.is_some_and(|chain| hetero || residue.is_none_or(|residue| residue.chain != chain)) {
                writeln!(out, "TER")?;
                polymer = None;
            }
            let name = residue.map_or("UNL", |residue| structure.name(residue.name));
            if !hetero && is_polymer(name) {
                polymer = residue.map(|residue| residue.chain);
            }
            let record = if hetero { "HETATM" } else { "ATOM  " };
            let (number, code) =
                residue.map_or((self.nameless_number, b' '), |residue| (residue.number, residue.insertion_code));
            let number = number_in_columns(number, 4)
                .ok_or_else(|| invalid(format!("residue number {number} does not fit the four columns PDB has")))?;
            let chain = residue.and_then(|r| self.chains.get(r.chain as usize)).copied().unwrap_or(b' ');
            let altloc = char::from(structure.altloc(atom));
            let (chain, code) = (char::from(chain), char::from(code));
            let serial = self.serial(atom)?;
            let symbol = symbol_with_isotope(structure, atom);
            let atom_name = aligned(&cut(&names.next(atom), 4), structure.elements()[atom]);
            let residue_name = if name.len() == 4 { cut(name, 4) } else { format!("{:>3} ", cut(name, 3)) };
            write!(out, "{record}{serial} {atom_name}{altloc}{residue_name}{chain}{number}{code}   ")?;
            let p = Position::new(&frame.positions, atom)?.point();
            for x in p.to_array() {
                let x = if x.abs() < 0.000_5 { 0.0 } else { x };
                let text = format!("{x:8.3}");
                if text.len() > 8 {
                    let message = format!(
                        "atom {} lies at {x} Å, which does not fit the eight columns PDB has for a coordinate (-999.999 to \
                         9999.999); move the molecule or write mmCIF or JSON",
                        atom + 1
                    );
                    return Err(invalid(message));
                }
                out.write_all(text.as_bytes())?;
            }
            let occupancy = value_in_columns(structure.occupancy(atom), 6, 2);
            let b_factor = value_in_columns(structure.b_factor(atom), 6, 2);
            let charge = match structure.formal_charge(atom) {
                charge @ 1..=9 => format!("{charge}+"),
                charge @ -9..=-1 => format!("{}-", -charge),
                _ => "  ".to_owned(),
            };
            writeln!(out, "{occupancy}{b_factor}          {:>2}{charge}", symbol.to_ascii_uppercase())?;
        }
        if polymer.is_some() {
            writeln!(out, "TER")?;
        }
        Ok(())
    }

    /// CONECT, each bond from both its atoms.
    fn write_bonds(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for bond in plain_bonds(self.structure).filter(|bond| !self.follows_from_names(bond)) {
            for _ in 0..bond.order.number().max(1) {
                pairs.extend([(bond.a, bond.b), (bond.b, bond.a)]);
            }
        }
        pairs.sort_unstable();
        for bonds in pairs.chunk_by(|a, b| a.0 == b.0) {
            for line in bonds.chunks(4) {
                write!(out, "CONECT{}", self.serial(line[0].0 as usize)?)?;
                for (_, to) in line {
                    write!(out, "{}", self.serial(*to as usize)?)?;
                }
                out.write_all(b"\n")?;
            }
        }
        Ok(())
    }

    /// Whether residue and atom names say that there is this bond.
    fn follows_from_names(&self, bond: &Bond) -> bool {
        let structure = self.structure;
        let [a, b] = [bond.a as usize, bond.b as usize];
        let (Some(first), Some(second)) = (self.residue(a), self.residue(b)) else { return false };
        let [a_name, b_name] = [a, b].map(|atom| structure.atom_name(atom));
        let standard = |residue: &Residue| is_standard_residue(structure.name(residue.name));
        if a_name.is_empty() || b_name.is_empty() || !standard(first) || !standard(second) {
            return false;
        }
        if structure.residue_index(a) == structure.residue_index(b) {
            return true;
        }
        let link = |from: &str, to: &str| (from, to) == ("C", "N") || (from, to) == ("O3'", "P");
        first.chain == second.chain && (link(a_name, b_name) || link(b_name, a_name))
    }
}

/// A name in its four columns: the symbol of the element ends in the second, unless the name needs all.
fn aligned(name: &str, element: Element) -> String {
    let starts =
        name.len() >= element.symbol().len() && name[..element.symbol().len()].eq_ignore_ascii_case(element.symbol());
    if name.len() < 4 && (element.symbol().len() < 2 || !starts) { format!(" {name:<3}") } else { format!("{name:<4}") }
}

const AMINO_ACIDS: [&str; 22] = [
    "ALA", "ARG", "ASN", "ASP", "CYS", "GLN", "GLU", "GLY", "HIS", "ILE", "LEU", "LYS", "MET", "PHE", "PRO", "SER",
    "THR", "TRP", "TYR", "VAL", "ASX", "GLX",
];
const NUCLEOTIDES: [&str; 8] = ["A", "C", "G", "U", "DA", "DC", "DG", "DT"];

fn is_polymer(residue: &str) -> bool {
    AMINO_ACIDS.contains(&residue) || NUCLEOTIDES.contains(&residue)
}

/// Residues whose bonds the format leaves to their names (wwPDB: no CONECT for standard residues and water).
fn is_standard_residue(residue: &str) -> bool {
    is_polymer(residue) || matches!(residue, "HOH" | "DOD" | "WAT")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::tests::written;
    use crate::structure::{AtomRecord, BondSource, Diagnostics, SecondaryElement, StructureBuilder, Symmetry};
    use glam::DVec3;

    fn text(records: &[Structure]) -> String {
        written(|out| write(records, out))
    }

    fn build(builder: StructureBuilder) -> Structure {
        builder.build(&mut Diagnostics::default())
    }

    #[test]
    fn every_field_is_in_its_columns() {
        let mut builder = StructureBuilder::new();
        builder.set_title("a title");
        builder.set_decimals(3);
        builder.set_cell(Cell::from_parameters([10.0, 20.5, 30.0], [90.0, 99.34, 90.0]));
        builder.set_symmetry(Some(Symmetry { space_group: "P 1 21 1".to_owned(), operations: Vec::new() }));
        builder.push_secondary(SecondaryElement {
            helix: true,
            chain: "A".into(),
            first: (-3, b'B'),
            last: (-3, b'B'),
        });
        builder.push_secondary(SecondaryElement {
            helix: false,
            chain: "A".into(),
            first: (-3, b'B'),
            last: (9, b' '),
        });
        builder.push_atom(&AtomRecord {
            element: Element::C,
            position: DVec3::new(-11.5, 0.0001, 9999.999),
            name: "CA",
            serial: Some(100_000),
            residue: Some(("A", -3, b'B', "ALA")),
            altloc: b'A',
            occupancy: 0.5,
            b_factor: 1234.5,
            formal_charge: -1,
            ..AtomRecord::default()
        });
        builder.push_atom(&AtomRecord {
            element: Element::from_z(20).unwrap(),
            name: "CA",
            serial: Some(7),
            residue: Some(("long", 10_000, b' ', "CA")),
            flags: atom_flags::HETERO,
            formal_charge: 2,
            ..AtomRecord::default()
        });
        builder.push_bond(Bond::new(0, 1, BondOrder::Double, BondSource::File));
        let expected = concat!(
            "TITLE     a title\n",
            "HELIX    1   1 ALA A   -3B ALA A   -3B 1\n",
            "SHEET    1   A 1 ALA A  -3B UNK A   9  0\n",
            "CRYST1   10.000   20.500   30.000  90.00  99.34  90.00 P 1 21 1\n",
            "ATOM  A0000  CA AALA A  -3B    -11.500   0.0009999.999  0.501234.5           C1-\n",
            "TER\n",
            "HETATM    7 CA    CA BA000       0.000   0.000   0.000  1.00  0.00          CA2+\n",
            "CONECTA0000    7    7\n",
            "CONECT    7A0000A0000\n",
            "END\n",
        );
        assert_eq!(text(&[build(builder)]), expected);
    }

    #[test]
    fn hybrid36_goes_on_where_the_digits_end() {
        for (number, width, text) in [
            (99_999, 5, "99999"),
            (100_000, 5, "A0000"),
            (43_770_015, 5, "ZZZZZ"),
            (43_770_016, 5, "a0000"),
            (87_440_031, 5, "zzzzz"),
            (10_000, 4, "A000"),
            (-999, 4, "-999"),
        ] {
            assert_eq!(number_in_columns(number, width).as_deref(), Some(text));
        }
        assert_eq!((number_in_columns(-1000, 4), number_in_columns(87_440_032, 5)), (None, None));
    }

    #[test]
    fn positions_that_do_not_fit_are_an_error_and_never_run_together() {
        for x in [10_000.0, -1000.0, f64::NAN] {
            let mut builder = StructureBuilder::new();
            builder.push_atom(&AtomRecord { position: DVec3::new(0.0, x, 0.0), ..AtomRecord::default() });
            let error = write(&[build(builder)], &mut Vec::new()).unwrap_err();
            assert!(error.to_string().contains("atom 1"), "{error}");
        }
    }

    #[test]
    fn standard_residues_need_no_conect() {
        let mut builder = StructureBuilder::new();
        for (number, name) in [(1, "N"), (1, "C"), (2, "N"), (2, "SG")] {
            let residue = Some(("A", number, b' ', "CYS"));
            builder.push_atom(&AtomRecord { element: Element::C, name, residue, ..AtomRecord::default() });
        }
        for (a, b) in [(0, 1), (1, 2), (0, 3)] {
            builder.push_bond(Bond::new(a, b, BondOrder::Single, BondSource::Dictionary));
        }
        let text = text(&[build(builder)]);
        let conect: Vec<&str> = text.lines().filter(|line| line.starts_with("CONECT")).collect();
        assert_eq!(conect, ["CONECT    1    4", "CONECT    4    1"]);
    }

    #[test]
    fn what_is_cut_is_named_and_titles_go_on() {
        let mut builder = StructureBuilder::new();
        builder.set_decimals(5);
        builder.push_atom(&AtomRecord {
            name: "LONGER",
            residue: Some(("AB", 1, b' ', "A1LU6")),
            ..AtomRecord::default()
        });
        builder.set_title("word ".repeat(30));
        let record = build(builder);
        let losses = FORMAT.losses(std::slice::from_ref(&record)).join("\n");
        for what in ["third decimal", "atom names", "residue names", "chain names"] {
            assert!(losses.contains(what), "{losses}");
        }
        let text = text(&[record]);
        assert!(text.lines().all(|line| line.len() <= 80) && text.matches("TITLE").count() == 3, "{text}");
    }
}
