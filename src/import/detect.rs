//! Which format a file is in: by its content, then by its name's extension.
//!
//! Content decides where it is unmistakable (a JSON bracket, PDB records, a V2000 counts line, an atom count with
//! atom lines below). Formats that are known but not read are named, so that the message helps.

use super::number::{parse_f64, parse_i64};
use super::text::{Lines, columns, is_blank_line, words};
use super::{Format, cube, gro, poscar, sdf};
use crate::error::{Error, Result};
use crate::structure::Diagnostics;

/// How far into a file its format must show.
const LOOK_BYTES: usize = 64 << 10;

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Detected {
    Format(Format),
    /// JSON of a dialect that shows when it is parsed.
    Json,
}

/// The format of normalised text.
pub(super) fn detect(text: &[u8], name_hint: &str, diagnostics: &mut Diagnostics) -> Result<Detected> {
    let by_name = format_of_name(name_hint);
    if text.trim_ascii().is_empty() {
        return Err(Error::input(None, "the file is empty"));
    }
    let by_content = by_content(text)?;
    match (by_content, by_name) {
        (Some(Detected::Json), _) => Ok(Detected::Json),
        (Some(found @ Detected::Format(format)), _) => {
            warn_of_name(format, name_hint, diagnostics);
            Ok(found)
        }
        (None, Some(named)) if named.is_json() => {
            Err(Error::input(1, "the name says JSON, but the content does not begin with `{`"))
        }
        (None, Some(Format::BinaryCif)) => {
            Err(Error::input(None, "the name says BinaryCIF, but the content does not begin as such a file does"))
        }
        (None, _) if looks_binary(text) => {
            Err(Error::input(None, "this is a binary file, not a molecule file in text form"))
        }
        (None, Some(named)) => Ok(Detected::Format(named)),
        (None, None) => Err(Error::input(
            None,
            "neither the content nor the name tells the format; name it (pdb, mmcif, bcif, cif, xyz, sdf, mol2, poscar, cube, gro, json, …)",
        )),
    }
}

/// Warns if the name says another format than the content.
pub(super) fn warn_of_name(format: Format, name_hint: &str, diagnostics: &mut Diagnostics) {
    // Both kinds of CIF go by the extension `cif`.
    let cif = |format| matches!(format, Format::Cif | Format::Mmcif);
    let odd = |&named: &Format| named != format && !(cif(named) && cif(format));
    if let Some(named) = format_of_name(name_hint).filter(odd) {
        diagnostics.warn(None, format!("the name says {named}, but the content is {format} and is read as that"));
    }
}

/// The format of a file name: by its extension, below those of compression, or as VASP names its files (`POSCAR`,
/// `CONTCAR.relaxed`, `bulk_POSCAR`).
fn format_of_name(name: &str) -> Option<Format> {
    let name = name.to_ascii_lowercase();
    let name = [".gz", ".gzip", ".zst", ".zstd"].iter().find_map(|end| name.strip_suffix(end)).unwrap_or(&name);
    let by_extension = name.rsplit_once('.').and_then(|(_, extension)| Format::from_name(extension));
    by_extension.or_else(|| {
        let of_vasp =
            ["poscar", "contcar", "xdatcar"].iter().any(|word| name.starts_with(word) || name.ends_with(word));
        of_vasp.then_some(Format::Poscar)
    })
}

fn looks_binary(text: &[u8]) -> bool {
    let head = &text[..text.len().min(4096)];
    let odd = head.iter().filter(|&&byte| byte < 0x20 && !byte.is_ascii_whitespace()).count();
    odd * 50 > head.len() // one in fifty: text has none, random bytes have one in nine
}

fn by_content(text: &[u8]) -> Result<Option<Detected>> {
    if matches!(text.trim_ascii_start().first(), Some(b'{' | b'[')) {
        return Ok(Some(Detected::Json));
    }
    let head = &text[..text.len().min(LOOK_BYTES)];
    let lines: Vec<&[u8]> = Lines::new(head, LOOK_BYTES).collect();
    if let Some(format) = cif_kind(&lines) {
        return Ok(Some(Detected::Format(format)));
    }
    if lines.iter().take(12).any(|line| sdf::is_counts_line(line)) {
        return Ok(Some(Detected::Format(Format::Sdf)));
    }
    if lines.iter().any(|line| line.starts_with(b"@<TRIPOS>")) {
        return Ok(Some(Detected::Format(Format::Mol2)));
    }
    if let Some(format) = unread_format(&lines) {
        return Err(Error::Unsupported(format!("this is a file in {format} format, which is not read")));
    }
    // Before XYZ: a GRO file without a title has its number of atoms first as well.
    if gro::is_gro(&lines) {
        return Ok(Some(Detected::Format(Format::Gro)));
    }
    if cube::is_cube(&lines) {
        return Ok(Some(Detected::Format(Format::Cube)));
    }
    if poscar::is_poscar(&lines) {
        return Ok(Some(Detected::Format(Format::Poscar)));
    }
    if is_xyz(&lines) {
        return Ok(Some(Detected::Format(Format::Xyz)));
    }
    if lines.iter().any(|line| is_atom_line(line)) || begins_as_pdb(&lines) {
        return Ok(Some(Detected::Format(Format::Pdb)));
    }
    Ok(None)
}

/// A PDB atom line with its coordinates in place.
fn is_atom_line(line: &[u8]) -> bool {
    (line.starts_with(b"ATOM  ") || line.starts_with(b"HETATM"))
        && [30, 38, 46].iter().all(|&at| parse_f64(columns(line, at, at + 8).trim_ascii()).is_some())
}

fn begins_as_pdb(lines: &[&[u8]]) -> bool {
    const RECORDS: [&[u8]; 16] = [
        b"HEADER ", b"OBSLTE ", b"TITLE  ", b"COMPND ", b"REMARK ", b"CRYST1 ", b"MODEL  ", b"NUMMDL ", b"EXPDTA ",
        b"AUTHOR ", b"ATOM  ", b"HETATM", b"CAVEAT ", b"SPLIT  ", b"ORIGX1 ", b"SEQRES ",
    ];
    let first = lines.iter().find(|line| !is_blank_line(line));
    first
        .is_some_and(|line| RECORDS.iter().any(|record| line.starts_with(record) || **line == *record.trim_ascii_end()))
}

/// A CIF begins with `data_`, comments aside. The names of macromolecular ones have a dot; the reader tells the kind
/// for sure.
fn cif_kind(lines: &[&[u8]]) -> Option<Format> {
    let first = lines.iter().find(|line| !is_blank_line(line) && !line.trim_ascii_start().starts_with(b"#"))?;
    let block = first.trim_ascii_start().get(..5)?;
    if !block.eq_ignore_ascii_case(b"data_") {
        return None;
    }
    let name = lines.iter().filter_map(|line| words(line).next()).find(|word| word.starts_with(b"_"));
    Some(if name.is_some_and(|name| name.contains(&b'.')) { Format::Mmcif } else { Format::Cif })
}

/// An atom count alone on its line, and atoms two lines below (or nothing, in a file that was cut there).
fn is_xyz(lines: &[&[u8]]) -> bool {
    let Some(first) = lines.iter().position(|line| !is_blank_line(line)) else { return false };
    if parse_i64(lines[first].trim_ascii()).is_none_or(|count| count < 0) {
        return false;
    }
    lines.get(first + 2).is_none_or(|line| words(line).count() >= 4)
}

/// Formats that show but are not read.
fn unread_format(lines: &[&[u8]]) -> Option<&'static str> {
    let first = lines.iter().find(|line| !is_blank_line(line) && !line.starts_with(b"#"))?;
    let starts = |word: &[u8]| first.get(..word.len()).is_some_and(|head| head.eq_ignore_ascii_case(word));
    if starts(b"$RXN") || starts(b"$MDL") {
        return Some("MDL reaction or Rgroup");
    }
    if starts(b"<?xml") || starts(b"<") {
        return Some("XML");
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(text: &str, name: &str) -> Result<Detected> {
        detect(text.as_bytes(), name, &mut Diagnostics::default())
    }

    const ATOM: &str = "ATOM      1  N   ALA A   1      11.104   6.134  -6.504  1.00  0.00           N  \n";
    const XYZ: &str = "1\n\nC 0.0 0.0 0.0\n";
    const MOL: &str = "2244\n prog\n\n  1  0  0  0  0  0  0  0  0  0999 V2000\n";

    #[test]
    fn content_goes_before_the_name() {
        let mol2 = "# from somewhere\n\n@<TRIPOS>MOLECULE\n";
        for (text, format) in [(ATOM, Format::Pdb), (XYZ, Format::Xyz), (MOL, Format::Sdf), (mol2, Format::Mol2)] {
            for name in ["", "a.pdb", "a.xyz.gz", "a.json"] {
                assert_eq!(run(text, name).unwrap(), Detected::Format(format), "{text} {name}");
            }
        }
        let gro = "\n1\n    1SOL     OW    1   0.126   1.624   1.679\n1 1 1\n";
        assert_eq!(run(gro, "a.xyz").unwrap(), Detected::Format(Format::Gro));
        let poscar = "rutile\n1.0\n4 0 0\n0 4 0\n0 0 3\nTi O\n1 2\nDirect\n0 0 0\n";
        assert_eq!(run(poscar, "a.xyz").unwrap(), Detected::Format(Format::Poscar));
        assert_eq!(run(&poscar.replace("Ti O\n", ""), "").unwrap(), Detected::Format(Format::Poscar));
        let cube = "a\nb\n1 0 0 0\n2 1 0 0\n2 0 1 0\n2 0 0 1\n1 1.0 0 0 0\n";
        assert_eq!(run(cube, "").unwrap(), Detected::Format(Format::Cube));
        assert_eq!(run(" {\"atoms\": []}", "a.pdb").unwrap(), Detected::Json);
        for (text, format) in [
            ("# x\n\nDATA_1abc\n_entry.id 1abc\n", Format::Mmcif),
            ("data_x\nloop_\n_publ_author_name\na\n", Format::Cif),
        ] {
            assert_eq!(run(text, "").unwrap(), Detected::Format(format), "{text}");
        }
        assert_eq!(run("REMARK only\nATOM\n", "").unwrap(), Detected::Format(Format::Pdb));
    }

    #[test]
    fn a_contradicting_name_is_warned_of() {
        let mut diagnostics = Diagnostics::default();
        detect(ATOM.as_bytes(), "a.xyz", &mut diagnostics).unwrap();
        assert_eq!(diagnostics.into_list().len(), 1);
    }

    #[test]
    fn the_name_decides_where_the_content_is_open() {
        assert_eq!(run("odd", "a.ent.GZ").unwrap(), Detected::Format(Format::Pdb));
        for name in ["POSCAR", "CONTCAR.relaxed", "bulk_POSCAR.gz", "a.vasp", "XDATCAR"] {
            assert_eq!(run("odd", name).unwrap(), Detected::Format(Format::Poscar), "{name}");
        }
        assert!(run("odd", "a.txt").is_err());
        assert!(run("odd", "a.json").is_err());
    }

    #[test]
    fn what_is_not_read_is_named() {
        for (text, word) in [("$RXN\n", "reaction"), ("<?xml ?>", "XML")] {
            let error = run(text, "a.pdb").unwrap_err();
            assert!(matches!(&error, Error::Unsupported(message) if message.contains(word)), "{error}");
        }
        assert!(run("\0\0\0\0\0\0\u{1}\u{2}", "a.pdb").is_err());
        assert!(run(" \n \n", "a.pdb").is_err());
    }
}
