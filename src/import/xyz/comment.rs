//! The comment line of extended XYZ: `key=value` pairs, the lattice, and what the columns mean.
//!
//! As the `libAtoms/extxyz` description has it: values bare, in double quotes, or in `{}` and `[]`; `Lattice` holds
//! the three cell vectors one after another; `Properties` lists `name:type:count` with types S, R, I, L. Accepted
//! beyond that: keys in any case, single quotes, lattices as nested arrays.

use super::super::number::{parse_f64, parse_i64};
use super::super::text::{lossy, shown};
use crate::structure::{Cell, Diagnostics};
use glam::DVec3;

/// What a comment line says.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Comment {
    pub(super) title: String,
    pub(super) cell: Option<Cell>,
    /// Empty where the file does not say: symbol x y z.
    pub(super) columns: Vec<Column>,
    /// All other pairs.
    pub(super) pairs: Vec<(String, String)>,
}

impl Comment {
    /// Names of the vector columns in their order.
    pub(super) fn vector_names(&self) -> impl Iterator<Item = String> {
        self.columns.iter().filter(|column| column.role == Role::Vector).map(|column| column.name.clone())
    }

    /// Whether it says of the columns nothing, or that they are a symbol and a position.
    pub(super) fn is_plain(&self) -> bool {
        match self.columns.as_slice() {
            [] => true,
            [symbol, position] => {
                (symbol.kind, symbol.count, symbol.role) == (b'S', 1, Role::Species) && position.role == Role::Position
            }
            _ => false,
        }
    }
}

/// One entry of `Properties`.
#[derive(Debug, PartialEq)]
pub(super) struct Column {
    pub(super) name: String,
    /// `S`, `R`, `I` or `L`.
    kind: u8,
    pub(super) count: usize,
    pub(super) role: Role,
}

/// What we take a column for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Species,
    AtomicNumber,
    Position,
    /// Three numbers an atom that are not its position: forces, velocities, …
    Vector,
    Charge,
    Other,
}

impl Column {
    /// Whether a word is a value of the column's type.
    pub(super) fn accepts(&self, word: &[u8]) -> bool {
        match self.kind {
            b'R' => parse_f64(word).is_some(),
            b'I' => parse_i64(word).is_some(),
            b'L' => {
                const VALUES: [&[u8]; 6] = [b"T", b"F", b"true", b"false", b".true.", b".false."];
                VALUES.iter().any(|value| word.eq_ignore_ascii_case(value))
            }
            _ => true,
        }
    }

    /// For messages.
    pub(super) fn expected(&self) -> String {
        let kind = match self.kind {
            b'R' => "number",
            b'I' => "integer",
            b'L' => "T or F",
            _ => "text",
        };
        format!("{} × {kind} in the column `{}`", self.count, self.name)
    }
}

/// Most columns an atom may have; more is no table that anyone wrote on purpose.
const MAX_COLUMNS: usize = 10_000;

/// Reads a comment line.
pub(super) fn read(line: &[u8], number: u64, diagnostics: &mut Diagnostics) -> Comment {
    let plain = || Comment { title: lossy(line.trim_ascii()).into_owned(), ..Comment::default() };
    if memchr::memchr(b'=', line).is_none() {
        return plain();
    }
    let pairs = split_pairs(line);
    let is = |name: &str, key: &[u8]| key.eq_ignore_ascii_case(name.as_bytes());
    if !pairs.iter().any(|(key, _)| is("lattice", key) || is("properties", key)) {
        return plain();
    }
    let mut comment = Comment::default();
    for (key, value) in pairs {
        let text = || unescaped(&lossy(value));
        if is("lattice", key) {
            comment.cell = lattice(value);
            if comment.cell.is_none() {
                let message = format!("`Lattice` should hold nine numbers that span a cell, found `{}`", shown(value));
                diagnostics.warn(Some(number), message);
            }
        } else if is("properties", key) {
            match columns(value) {
                Ok(columns) => comment.columns = columns,
                Err(why) => diagnostics.warn(
                    Some(number),
                    format!("`Properties` is not used ({why}); the columns are taken as symbol x y z"),
                ),
            }
        } else {
            if is("name", key) || is("title", key) || is("comment", key) {
                comment.title = text();
            }
            comment.pairs.push((lossy(key).into_owned(), text()));
        }
    }
    comment
}

/// A value with `\"`, `\\` and `\n` as what they stand for; any other backslash is one.
fn unescaped(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        let meant = match rest.peek() {
            Some('n') if c == '\\' => Some('\n'),
            Some(&next @ ('"' | '\'' | '\\')) if c == '\\' => Some(next),
            _ => None,
        };
        plain.push(meant.unwrap_or(c));
        if meant.is_some() {
            rest.next();
        }
    }
    plain
}

/// `key=value` pairs; a bare key has the value `T`.
fn split_pairs(line: &[u8]) -> Vec<(&[u8], &[u8])> {
    let mut pairs = Vec::new();
    let mut rest = line.trim_ascii();
    while !rest.is_empty() {
        let (key, after) = split_token(rest, true);
        let (value, after) = match after.strip_prefix(b"=") {
            Some(after) => split_token(after.trim_ascii_start(), false),
            None => (b"T".as_slice(), after),
        };
        if !key.is_empty() {
            pairs.push((key, value));
        }
        let next = after.trim_ascii_start();
        // A stray `=` or bracket must not stop the walk.
        rest = if next.len() == rest.len() { &next[1..] } else { next };
    }
    pairs
}

/// One token, quoted, bracketed or bare, and what follows it.
fn split_token(text: &[u8], is_key: bool) -> (&[u8], &[u8]) {
    let close = match text.first() {
        Some(&quote @ (b'"' | b'\'')) => quote,
        Some(b'{') if !is_key => b'}',
        Some(b'[') if !is_key => b']',
        _ => {
            let ends = |byte: &u8| byte.is_ascii_whitespace() || (is_key && *byte == b'=');
            return text.split_at(text.iter().position(ends).unwrap_or(text.len()));
        }
    };
    let open = text[0];
    let mut depth = 0usize;
    let mut index = 0;
    while index < text.len() {
        let byte = text[index];
        if byte == b'\\' {
            index += 1;
        } else if byte == close && (depth <= 1) && index > 0 {
            return (&text[1..index], &text[index + 1..]);
        } else if byte == close && index > 0 {
            depth -= 1;
        } else if byte == open {
            depth += 1;
        }
        index += 1;
    }
    (&text[1..], &[]) // never closed
}

fn lattice(value: &[u8]) -> Option<Cell> {
    let mut numbers = Vec::with_capacity(9);
    let separates = |byte: &u8| byte.is_ascii_whitespace() || matches!(byte, b',' | b'[' | b']' | b'{' | b'}');
    for word in value.split(separates).filter(|word| !word.is_empty()) {
        if numbers.len() == 9 {
            return None;
        }
        numbers.push(parse_f64(word)?.0);
    }
    let vectors: &[f64; 9] = numbers.as_slice().try_into().ok()?;
    let [a, b, c] = [0, 3, 6].map(|at| DVec3::new(vectors[at], vectors[at + 1], vectors[at + 2]));
    Cell::from_vectors(a, b, c)
}

fn columns(value: &[u8]) -> Result<Vec<Column>, String> {
    let parts: Vec<&[u8]> = value.split(|&byte| byte == b':').collect();
    let mut columns: Vec<Column> = Vec::new();
    let mut total = 0usize;
    for entry in parts.chunks(3) {
        let &[name, kind, count] = entry else { return Err("it is not a list of name:type:count".to_owned()) };
        let count = parse_i64(count).and_then(|count| usize::try_from(count).ok()).filter(|&count| count > 0);
        let &[kind @ (b'S' | b'R' | b'I' | b'L')] = kind else {
            return Err(format!("type `{}` is none of S, R, I, L", shown(kind)));
        };
        let Some(count) = count else { return Err(format!("`{}` has no number of values", shown(name))) };
        total = total.saturating_add(count);
        if total > MAX_COLUMNS {
            return Err(format!("it has more than {MAX_COLUMNS} columns"));
        }
        let name = lossy(name).into_owned();
        let has = |role| columns.iter().any(|column| column.role == role);
        let role = match (name.to_ascii_lowercase().as_str(), kind, count) {
            ("species" | "element" | "elements" | "symbol", b'S', 1) if !has(Role::Species) => Role::Species,
            ("z" | "numbers" | "atomic_number" | "atomic_numbers", b'I', 1) => Role::AtomicNumber,
            ("species" | "element", b'I', 1) => Role::AtomicNumber,
            ("pos" | "position" | "positions", b'R', 3) if !has(Role::Position) => Role::Position,
            ("charge" | "charges" | "initial_charges" | "partial_charge", b'R', 1) => Role::Charge,
            (_, b'R', 3) => Role::Vector,
            _ => Role::Other,
        };
        columns.push(Column { name, kind, count, role });
    }
    let has = |role| columns.iter().any(|column| column.role == role);
    if !has(Role::Position) {
        return Err("it has no pos:R:3".to_owned());
    }
    if !has(Role::Species) && !has(Role::AtomicNumber) {
        return Err("it has neither species:S:1 nor Z:I:1".to_owned());
    }
    Ok(columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(line: &str) -> (Comment, usize) {
        let mut diagnostics = Diagnostics::default();
        let comment = read(line.as_bytes(), 2, &mut diagnostics);
        (comment, diagnostics.into_list().len())
    }

    #[test]
    fn a_comment_that_is_not_extended_is_a_title() {
        assert_eq!(run(" water, E = -76.4 ").0.title, "water, E = -76.4");
        assert_eq!(run("").0, Comment::default());
    }

    #[test]
    fn pairs_are_split_as_quoted() {
        let text =
            r#"a=1 b="x y" bare c={1 2} d=[[1, 2], [3, 4]] "e f"='q' g="say \"hi\"" Lattice="1 0 0 0 1 0 0 0 1""#;
        let (comment, notes) = run(text);
        let pairs: Vec<_> = comment.pairs.iter().map(|(key, value)| (key.as_str(), value.as_str())).collect();
        let want = [
            ("a", "1"),
            ("b", "x y"),
            ("bare", "T"),
            ("c", "1 2"),
            ("d", "[1, 2], [3, 4]"),
            ("e f", "q"),
            ("g", "say \"hi\""),
        ];
        assert_eq!(pairs, want);
        assert!(comment.cell.is_some());
        assert_eq!(notes, 0);
    }

    #[test]
    fn lattices_in_all_their_spellings() {
        for value in ["\"1 0 0 0 2 0 0 0 3\"", "{1 0 0 0 2 0 0 0 3}", "[[1,0,0],[0,2,0],[0,0,3]]"] {
            let (comment, notes) = run(&format!("lattice={value}"));
            assert_eq!(comment.cell.map(|cell| cell.lengths()), Some([1.0, 2.0, 3.0]), "{value}");
            assert_eq!(notes, 0);
        }
        for value in ["\"1 0 0 0 2 0 0 0\"", "\"1 0 0 0 2 0 0 0 x\"", "\"0 0 0 0 0 0 0 0 0\""] {
            let (comment, notes) = run(&format!("Lattice={value}"));
            assert_eq!((comment.cell, notes), (None, 1), "{value}");
        }
    }

    #[test]
    fn columns_in_any_order_have_their_roles() {
        let (comment, _) = run("Properties=id:I:1:pos:R:3:species:S:1:forces:R:3:charge:R:1:type:S:1");
        let roles: Vec<_> = comment.columns.iter().map(|column| column.role).collect();
        assert_eq!(roles, [Role::Other, Role::Position, Role::Species, Role::Vector, Role::Charge, Role::Other]);
        assert_eq!(comment.vector_names().collect::<Vec<_>>(), ["forces"]);
    }

    #[test]
    fn properties_that_make_no_sense_are_warned_of() {
        for value in ["species:S:1", "species:S:1:pos:R:2", "pos:R:3", "species:S:1:pos:R", "pos:R:3:a:S:99999999999"] {
            let (comment, notes) = run(&format!("Properties={value}"));
            assert!(comment.columns.is_empty() && notes == 1, "{value}");
        }
    }

    #[test]
    fn stray_signs_do_not_hang() {
        for text in ["=", "==", "Lattice=", "Lattice=\"", "Lattice={ [", "a==b Lattice", "\" = Lattice="] {
            run(text);
        }
    }
}
