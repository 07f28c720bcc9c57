//! The atoms as BinaryCIF, encoded as writers do it: fixed-point coordinates as packed differences, runs for what repeats.

use super::{atoms, residue};

/// A MessagePack array or map of up to fifteen entries.
fn head(out: &mut Vec<u8>, kind: u8, count: usize) {
    out.push(kind | count as u8);
}

fn text(out: &mut Vec<u8>, text: &str) {
    out.push(0xd9);
    out.push(text.len() as u8);
    out.extend(text.as_bytes());
}

fn number(out: &mut Vec<u8>, key: &str, value: usize) {
    text(out, key);
    out.push(0xd2);
    out.extend((value as i32).to_be_bytes());
}

fn bytes(out: &mut Vec<u8>, key: &str, bytes: &[u8]) {
    text(out, key);
    out.push(0xc6);
    out.extend((bytes.len() as u32).to_be_bytes());
    out.extend(bytes);
}

fn kind(out: &mut Vec<u8>, name: &str, more: usize) {
    head(out, 0x80, 1 + more);
    text(out, "kind");
    text(out, name);
}

/// Packed differences as two bytes each; they are small here but for the first, which is the origin.
fn differences(out: &mut Vec<u8>, values: &[i32], factor: Option<usize>) {
    let mut packed = Vec::with_capacity(values.len() * 2);
    let mut before = values.first().copied().unwrap_or(0);
    for &value in values {
        let mut rest = value - before;
        before = value;
        let limit = if rest < 0 { i16::MIN } else { i16::MAX };
        while rest <= i32::from(i16::MIN) || rest >= i32::from(i16::MAX) {
            packed.extend(limit.to_le_bytes());
            rest -= i32::from(limit);
        }
        packed.extend((rest as i16).to_le_bytes());
    }
    head(out, 0x80, 2);
    bytes(out, "data", &packed);
    text(out, "encoding");
    head(out, 0x90, 3 + usize::from(factor.is_some()));
    if let Some(factor) = factor {
        kind(out, "FixedPoint", 2);
        number(out, "factor", factor);
        number(out, "srcType", 33);
    }
    kind(out, "Delta", 2);
    number(out, "srcType", 3);
    text(out, "origin");
    out.push(0xd2);
    out.extend(values.first().copied().unwrap_or(0).to_be_bytes());
    kind(out, "IntegerPacking", 3);
    number(out, "byteCount", 2);
    number(out, "srcSize", values.len());
    text(out, "isUnsigned");
    out.push(0xc2);
    kind(out, "ByteArray", 1);
    number(out, "type", 2);
}

/// Texts of a few letters, each once.
fn texts(out: &mut Vec<u8>, values: &[&str]) {
    let mut unique: Vec<&str> = Vec::new();
    let mut indices = Vec::with_capacity(values.len());
    for value in values {
        let index = unique.iter().position(|other| other == value).unwrap_or_else(|| {
            unique.push(value);
            unique.len() - 1
        });
        indices.push(index as u8);
    }
    let mut offsets = vec![0u8];
    for text in &unique {
        offsets.push(offsets[offsets.len() - 1] + text.len() as u8);
    }
    let plain = |out: &mut Vec<u8>, key: &str| {
        text(out, key);
        head(out, 0x90, 1);
        kind(out, "ByteArray", 1);
        number(out, "type", 4);
    };
    head(out, 0x80, 2);
    bytes(out, "data", &indices);
    text(out, "encoding");
    head(out, 0x90, 1);
    kind(out, "StringArray", 4);
    plain(out, "dataEncoding");
    text(out, "stringData");
    text(out, &unique.concat());
    plain(out, "offsetEncoding");
    bytes(out, "offsets", &offsets);
}

fn column(out: &mut Vec<u8>, name: &str) {
    head(out, 0x80, 2);
    text(out, "name");
    text(out, name);
    text(out, "data");
}

/// The file.
pub(crate) fn file(count: usize) -> Vec<u8> {
    let atoms = atoms(count);
    let mut out = Vec::new();
    head(&mut out, 0x80, 1);
    text(&mut out, "dataBlocks");
    head(&mut out, 0x90, 1);
    head(&mut out, 0x80, 2);
    text(&mut out, "header");
    text(&mut out, "BENCH");
    text(&mut out, "categories");
    head(&mut out, 0x90, 1);
    head(&mut out, 0x80, 3);
    text(&mut out, "name");
    text(&mut out, "_atom_site");
    number(&mut out, "rowCount", count);
    text(&mut out, "columns");
    head(&mut out, 0x90, 9);
    let symbols: Vec<&str> = atoms.iter().map(|atom| atom.0).collect();
    for name in ["type_symbol", "label_atom_id"] {
        column(&mut out, name);
        texts(&mut out, &symbols);
    }
    for (name, value) in [("label_comp_id", "UNL"), ("auth_asym_id", "A")] {
        column(&mut out, name);
        texts(&mut out, &vec![value; count]);
    }
    for (axis, name) in ["Cartn_x", "Cartn_y", "Cartn_z"].into_iter().enumerate() {
        let values: Vec<i32> = atoms.iter().map(|atom| (atom.1[axis] * 1000.0).round() as i32).collect();
        column(&mut out, name);
        differences(&mut out, &values, Some(1000));
    }
    column(&mut out, "id");
    differences(&mut out, &(1..=count as i32).collect::<Vec<_>>(), None);
    column(&mut out, "auth_seq_id");
    differences(&mut out, &(0..count).map(|n| residue(n) as i32).collect::<Vec<_>>(), None);
    out
}
