//! Which format a file is in: by its content, then by its name's extension.
//!
//! Content decides where it is unmistakable (a JSON bracket, PDB records, a V2000 counts line, an atom count with
//! atom lines below). Formats that are known but not read are named, so that the message helps.

use super::number::{parse_f64, parse_i64};
use super::text::{Lines, columns, is_blank_line, words};
use super::{Format, sdf};
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
    let by_name = extension(name_hint).and_then(|extension| Format::from_name(&extension));
    if text.trim_ascii().is_empty() {
        return Err(Error::input(None, "the file is empty"));
    }
    let by_content = by_content(text)?;
    match (by_content, by_name) {
        (Some(Detected::Json), _) => Ok(Detected::Json),
        (Some(found @ Detected::Format(format)), named) => {
            // Both kinds of CIF go by the extension `cif`.
            let cif = |format| matches!(format, Format::Cif | Format::Mmcif);
            if let Some(named) = named.filter(|&named| named != format && !(cif(named) && cif(format))) {
                diagnostics
                    .warn(None, format!("the name says {named}, but the content is {format} and is read as that"));
            }
            Ok(found)
        }
        (None, Some(named)) if named.is_json() => {
            Err(Error::input(1, "the name says JSON, but the content does not begin with `{`"))
        }
        (None, _) if looks_binary(text) => {
            Err(Error::input(None, "this is a binary file, not a molecule file in text form"))
        }
        (None, Some(named)) => Ok(Detected::Format(named)),
        (None, None) => Err(Error::input(
            None,
            "neither the content nor the name tells the format; name it (pdb, xyz, sdf, mol2, mmcif, cif, json, cjson, …)",
        )),
    }
}

/// The extension, in lower case, below those of compression.
fn extension(name: &str) -> Option<String> {
    let name = name.to_ascii_lowercase();
    let name = [".gz", ".gzip", ".zst"].iter().find_map(|end| name.strip_suffix(end)).unwrap_or(&name);
    name.rsplit_once('.').map(|(_, extension)| extension.to_owned())
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
