//! The atoms of one frame.

use super::super::is_plausible;
use super::super::number::{next_vector, parse_f64};
use super::super::symbol::{LabelKind, read_label};
use super::super::text::{Repeated, lossy, next_word, shown, words};
use super::comment::{Column, Comment, Role};
use crate::element::Element;
use crate::structure::{AtomRecord, Diagnostics, Structure, StructureBuilder, VectorField};
use glam::DVec3;

/// What is noticed from atom to atom, in all frames.
#[derive(Debug, Default)]
pub(super) struct Notes {
    /// Most decimals seen; all frames are written back with as many.
    pub(super) decimals: u8,
    unknown: Repeated,
    guessed: Repeated,
    lost: Repeated,
}

impl Notes {
    /// Takes over those of later lines.
    pub(super) fn absorb(&mut self, later: Notes) {
        self.decimals = self.decimals.max(later.decimals);
        self.unknown.absorb(later.unknown);
        self.guessed.absorb(later.guessed);
        self.lost.absorb(later.lost);
    }

    pub(super) fn report(&self, diagnostics: &mut Diagnostics) {
        self.unknown.warn(diagnostics);
        self.guessed.warn(diagnostics);
        self.lost.error(diagnostics);
    }
}

/// A frame being read.
pub(super) struct Frame {
    pub(super) builder: StructureBuilder,
    vectors: Vec<VectorField>,
    /// Number of columns behind the position that are read as XMol means them; 0, 3 or 4.
    plain_extra: usize,
    /// Whether the first atom's columns were looked at.
    begun: bool,
}

impl Frame {
    pub(super) fn new(comment: &Comment) -> Frame {
        let vectors = comment.vector_names().map(|name| VectorField { name, vectors: Vec::new() }).collect();
        Frame { builder: StructureBuilder::new(), vectors, plain_extra: 0, begun: false }
    }

    /// Reads one atom. The error says what was expected.
    #[inline]
    pub(super) fn atom(
        &mut self,
        line: &[u8],
        number: u64,
        comment: &Comment,
        notes: &mut Notes,
    ) -> Result<(), String> {
        if !comment.columns.is_empty() {
            return self.atom_of_columns(line, number, &comment.columns, notes);
        }
        let plain = || "an atom (symbol x y z)".to_owned();
        let (label, rest) = next_word(line).ok_or_else(plain)?;
        let (position, decimals, rest) = next_vector(rest).ok_or_else(plain)?;
        let mut charge = None;
        if !self.begun {
            self.begin_plain_extra(rest);
        }
        if !rest.is_empty() {
            charge = self.plain_extra(rest);
        }
        self.push(label, position, decimals, charge, number, notes);
        Ok(())
    }

    /// Whether the atoms of this frame are known to have nothing behind their positions.
    pub(super) fn expects_nothing_more(&self, comment: &Comment) -> bool {
        (self.begun || !comment.columns.is_empty()) && self.plain_extra == 0 && self.vectors.is_empty()
    }

    /// A later part of a frame that begins as `first` does.
    pub(super) fn part_of(first: &Frame, comment: &Comment) -> Frame {
        let mut frame = Frame::new(comment);
        frame.vectors =
            first.vectors.iter().map(|field| VectorField { vectors: Vec::new(), ..field.clone() }).collect();
        Frame { plain_extra: first.plain_extra, begun: first.begun, ..frame }
    }

    /// Looks at the first atom of a frame without reading it; `false` if it is none.
    pub(super) fn begin(&mut self, line: &[u8], comment: &Comment) -> bool {
        if !comment.columns.is_empty() {
            return true;
        }
        let rest = next_word(line).and_then(|(_, rest)| next_vector(rest)).map(|(_, _, rest)| rest);
        rest.inspect(|rest| self.begin_plain_extra(rest)).is_some()
    }

    /// Adds a later part of the same frame; `false` if what follows the positions is not the same in both.
    pub(super) fn append(&mut self, later: Frame) -> bool {
        let fits = self.is_like(&later);
        self.builder.append(later.builder, false);
        for (field, more) in self.vectors.iter_mut().zip(later.vectors) {
            field.vectors.extend_from_slice(&more.vectors);
        }
        fits
    }

    /// Whether the same follows the positions in both.
    pub(super) fn is_like(&self, other: &Frame) -> bool {
        self.plain_extra == other.plain_extra && self.vectors.len() == other.vectors.len()
    }

    /// Looks at what follows the first atom's position.
    fn begin_plain_extra(&mut self, rest: &[u8]) {
        self.begun = true;
        let count = words(rest).count();
        let numbers = words(rest).all(|word| parse_f64(word).is_some());
        if numbers && (count == 3 || count == 4) {
            self.plain_extra = count;
            self.vectors.push(VectorField { name: "vector".to_owned(), vectors: Vec::new() });
        }
    }

    /// Charge and vector behind a position, of every atom or of none.
    fn plain_extra(&mut self, rest: &[u8]) -> Option<f64> {
        if self.plain_extra == 0 {
            return None;
        }
        let mut values = [0.0; 4];
        let mut count = 0;
        for word in words(rest) {
            let (Some(slot), Some((value, _))) = (values.get_mut(count), parse_f64(word)) else {
                count = usize::MAX;
                break;
            };
            *slot = value;
            count += 1;
        }
        if count != self.plain_extra {
            self.plain_extra = 0;
            self.vectors.clear();
            return None;
        }
        let at = count - 3;
        let vector = DVec3::new(values[at], values[at + 1], values[at + 2]).as_vec3();
        self.vectors[0].vectors.push(vector);
        (at == 1).then_some(values[0])
    }

    fn atom_of_columns(
        &mut self,
        line: &[u8],
        number: u64,
        columns: &[Column],
        notes: &mut Notes,
    ) -> Result<(), String> {
        let mut rest = line;
        let (mut label, mut by_number): (&[u8], &[u8]) = (b"", b"");
        let (mut position, mut decimals) = (DVec3::NAN, 0);
        let mut charge = None;
        let mut vector_index = 0;
        for column in columns {
            let bad = || column.expected();
            if matches!(column.role, Role::Position | Role::Vector) {
                let (vector, vector_decimals, after) = next_vector(rest).ok_or_else(bad)?;
                rest = after;
                if column.role == Role::Position {
                    (position, decimals) = (vector, vector_decimals);
                } else {
                    self.vectors[vector_index].vectors.push(vector.as_vec3());
                    vector_index += 1;
                }
                continue;
            }
            for _ in 0..column.count {
                let (word, after) = next_word(rest).ok_or_else(bad)?;
                rest = after;
                if !column.accepts(word) {
                    return Err(bad());
                }
                match column.role {
                    Role::Species => label = word,
                    Role::AtomicNumber => by_number = word,
                    Role::Charge => charge = parse_f64(word).map(|(value, _)| value),
                    Role::Position | Role::Vector | Role::Other => {}
                }
            }
        }
        let label = if label.is_empty() { by_number } else { label };
        self.push(label, position, decimals, charge, number, notes);
        Ok(())
    }

    #[inline]
    fn push(
        &mut self,
        label: &[u8],
        position: DVec3,
        decimals: u8,
        charge: Option<f64>,
        number: u64,
        notes: &mut Notes,
    ) {
        if !is_plausible(position) {
            notes.lost.note(number, || format!("the position {position} cannot be used; the atom is left out"));
            for field in &mut self.vectors {
                field.vectors.truncate(self.builder.atom_count());
            }
            return;
        }
        notes.decimals = notes.decimals.max(decimals);
        let meaning = read_label(label);
        let mut record = AtomRecord {
            element: meaning.element,
            isotope: meaning.isotope,
            position,
            partial_charge: charge.map(|charge| charge as f32).filter(|charge| charge.is_finite()),
            ..AtomRecord::default()
        };
        if meaning.kind == LabelKind::Symbol && !meaning.particle {
            self.builder.push_atom(&record);
            return;
        }
        let symbol = meaning.element.symbol();
        match meaning.kind {
            LabelKind::Unknown => notes.unknown.note(number, || {
                format!("`{}` is no element symbol; the atom is kept without an element", shown(label))
            }),
            LabelKind::Guess => notes.guessed.note(number, || {
                format!("`{}` is no element symbol; taken as {symbol} from its first letters", shown(label))
            }),
            LabelKind::Symbol | LabelKind::Name => {}
        }
        if meaning.particle {
            record.flags = crate::structure::atom_flags::PARTICLE;
        }
        let name = lossy(label);
        if meaning.kind != LabelKind::Symbol || meaning.element == Element::DUMMY {
            record.name = &name;
        }
        self.builder.push_atom(&record);
    }

    /// The frame as a structure; its positions are written with so many decimals.
    pub(super) fn build(self, comment: Comment, decimals: u8, diagnostics: &mut Diagnostics) -> Structure {
        let mut builder = self.builder;
        builder.set_decimals(decimals);
        builder.set_frame_title(comment.title.clone());
        builder.set_title(comment.title);
        builder.set_cell(comment.cell);
        for field in self.vectors {
            if !builder.push_vectors(field) {
                diagnostics.warn(None, "vectors that only some atoms have are left out");
            }
        }
        for (name, value) in comment.pairs {
            builder.push_property(name, value);
        }
        builder.build(diagnostics)
    }
}
