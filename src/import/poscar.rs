//! VASP's POSCAR and CONTCAR, and XDATCAR with its frames.
//!
//! Specification: <https://www.vasp.at/wiki/index.php/POSCAR> (and `/CONTCAR`, `/XDATCAR`): a comment; the scale (one factor,
//! three of them, or minus the cell's volume); three lattice vectors; the elements (since VASP 5); how many atoms of
//! each; `Selective dynamics` or not; `Direct` or `Cartesian`; the positions; perhaps velocities. Lines are as follows:
//!
//! - Elements may carry a potential's name (`Ti_sv`, `Ti/5f5d8b`). Without their line (VASP 4) they are those of the
//!   comment, if it begins with as many symbols as there are counts, or those written behind the positions.
//! - Velocities, in Å/fs, become vectors; those in cell vectors a step are turned into Å a step. All zero they say nothing.
//! - What follows (lattice velocities apart, which stand before the velocities) is passed over, whatever it is.
//! - In XDATCAR `Direct configuration=` begins each frame, a new header may stand before it.
//!
//! The cell is periodic; constraints of selective dynamics are not kept.

use super::collect::Records;
use super::is_plausible;
use super::number::{next_f64, next_vector, parse_i64};
use super::symbol::{Label, LabelKind, read_label};
use super::text::{Lines, is_blank_line, lossy, next_word, shown, words};
use crate::element::Element;
use crate::error::{Error, Result};
use crate::structure::{AtomRecord, Cell, Diagnostics, Positions, StructureBuilder, VectorField, atom_flags};
use glam::{DMat3, DVec3};

/// Whether lines begin as a POSCAR does.
pub(super) fn is_poscar(lines: &[&[u8]]) -> bool {
    let [_, scale, vectors @ .., species, counts, mode] = (match lines.get(..8) {
        Some(lines) => lines,
        None => return false,
    }) else {
        return false;
    };
    let numbers = next_f64(scale).is_some() && vectors.iter().all(|line| next_vector(line).is_some());
    let in_mode =
        |line: &[u8]| matches!(line.trim_ascii().first(), Some(b's' | b'S' | b'd' | b'D' | b'c' | b'C' | b'k' | b'K'));
    let all_counts = |line: &[u8]| !read_counts(line).is_empty();
    let all_symbols = |line: &[u8]| words(line).next().is_some() && words(line).all(|word| symbol(word).is_some());
    // VASP 5 with its elements, or VASP 4, where the counts stand in their place.
    numbers && (all_symbols(species) && all_counts(counts) && in_mode(mode) || all_counts(species) && in_mode(counts))
}

pub(super) fn read(text: &[u8], records: &mut Records, diagnostics: &mut Diagnostics) -> Result<()> {
    let mut reader = Reader { lines: records.lines(text) };
    let mut header = reader.header()?;
    let total = header.total();
    let line = reader.lines.number();
    records.check_atoms(total.min(reader.lines.rest().len()), line)?;
    if total == 0 {
        return Err(Error::input(line, "the file has 0 atoms"));
    }
    let mut mode = reader.mode()?;
    let atoms = reader.positions(&header, &mode)?;
    header.find_elements(&atoms)?;
    let mut builder = StructureBuilder::new();
    let labels = header.species.iter().zip(&header.counts);
    for (&label, position) in labels.flat_map(|(label, &count)| std::iter::repeat_n(label, count)).zip(&atoms.points) {
        builder.push_atom(&AtomRecord {
            element: label.element,
            isotope: label.isotope,
            position: *position,
            flags: if label.particle { atom_flags::PARTICLE } else { 0 },
            ..AtomRecord::default()
        });
    }
    builder.set_decimals(atoms.decimals);
    builder.set_title(header.title.clone());
    builder.set_cell(Some(header.cell));
    if mode.configuration {
        builder.set_frame_title(mode.text.clone());
        reader.more_frames(&mut header, &mut mode, &mut builder, diagnostics)?;
    } else if let Some(vectors) = reader.velocities(&header, total) {
        let field = VectorField { name: "velocities".to_owned(), vectors };
        let _fits = builder.push_vectors(field);
    }
    reader.lines.check()?;
    records.push(builder.build(diagnostics));
    Ok(())
}

/// The element of a word of the line of elements.
fn symbol(word: &[u8]) -> Option<Label> {
    let end = word.iter().position(|&byte| byte == b'_' || byte == b'/').unwrap_or(word.len());
    Some(read_label(&word[..end])).filter(|label| {
        matches!(label.kind, LabelKind::Symbol | LabelKind::Name) && word.first().is_some_and(u8::is_ascii_alphabetic)
    })
}

/// Whole numbers up to something else (a comment).
fn read_counts(line: &[u8]) -> Vec<usize> {
    words(line).map_while(|word| parse_i64(word).and_then(|count| usize::try_from(count).ok())).collect()
}

/// The first six or seven lines.
struct Header {
    title: String,
    /// One for each of `counts`; empty where the file does not say.
    species: Vec<Label>,
    counts: Vec<usize>,
    cell: Cell,
    /// Scale of Cartesian positions.
    scale: DVec3,
    /// Decimals that scale and lattice have together; of the scale alone.
    cell_decimals: u8,
    scale_decimals: u8,
}

/// What stands before the positions.
struct Mode {
    text: String,
    selective: bool,
    direct: bool,
    /// A frame of an XDATCAR.
    configuration: bool,
}

struct Atoms {
    points: Vec<DVec3>,
    decimals: u8,
    /// The element written behind each position, as long as there is one.
    labels: Vec<Label>,
}

struct Reader<'a> {
    lines: Lines<'a>,
}

impl<'a> Reader<'a> {
    fn next(&mut self) -> Result<&'a [u8]> {
        let line = self.lines.next();
        self.lines.check()?;
        line.ok_or_else(|| Error::input(self.lines.number(), "the file ends before its last atom"))
    }

    fn expected(&self, what: &str, line: &[u8]) -> Error {
        Error::input(self.lines.number(), format!("expected {what}, found `{}`", shown(line)))
    }

    fn header(&mut self) -> Result<Header> {
        let title = lossy(self.next()?.trim_ascii()).into_owned();
        let line = self.next()?;
        let mut scales = Vec::new();
        let mut rest = line;
        let mut scale_decimals = 0;
        while scales.len() < 3
            && let Some((value, decimals, after)) = next_f64(rest)
        {
            scales.push(value);
            scale_decimals = scale_decimals.max(decimals);
            rest = after;
        }
        let mut vectors = [DVec3::ZERO; 3];
        let mut cell_decimals = 0;
        let scale_line = self.lines.number();
        for (vector, what) in vectors.iter_mut().zip(["first", "second", "third"]) {
            let line = self.next()?;
            let read = next_vector(line).ok_or_else(|| self.expected(&format!("the {what} lattice vector"), line))?;
            *vector = read.0;
            cell_decimals = cell_decimals.max(read.1);
        }
        let volume = DMat3::from_cols_array_2d(&vectors.map(|v| v.to_array())).determinant().abs();
        let scale = match *scales.as_slice() {
            [x, y, z] if x > 0.0 && y > 0.0 && z > 0.0 => DVec3::new(x, y, z),
            [scale, ..] if scale > 0.0 => DVec3::splat(scale),
            [scale, ..] if scale < 0.0 && volume > 0.0 => {
                scale_decimals = Positions::MAX_DECIMALS; // a cube root
                DVec3::splat((-scale / volume).cbrt())
            }
            _ => {
                let what = "the scale (a factor, three of them, or minus the cell's volume)";
                return Err(Error::input(scale_line, format!("expected {what}, found `{}`", shown(line))));
            }
        };
        if scale == DVec3::ONE {
            scale_decimals = 0;
        }
        let [a, b, c] = vectors.map(|vector| vector * scale);
        let Some(cell) = Cell::from_vectors(a, b, c) else {
            return Err(Error::input(self.lines.number(), "the three lattice vectors span no cell"));
        };
        let (species, counts) = self.species()?;
        let cell_decimals = cell_decimals.saturating_add(scale_decimals);
        Ok(Header { title, species, counts, cell, scale, cell_decimals, scale_decimals })
    }

    /// The elements, if there is a line of them, and the counts.
    fn species(&mut self) -> Result<(Vec<Label>, Vec<usize>)> {
        let line = self.next()?;
        let counts = read_counts(line);
        if !counts.is_empty() {
            return Ok((Vec::new(), counts));
        }
        let names: Vec<&[u8]> = words(line).take_while(|word| !matches!(word[0], b'!' | b'#')).collect();
        let counts_line = self.next()?;
        let mut counts = read_counts(counts_line);
        if counts.is_empty() || names.is_empty() {
            return Err(self.expected("the number of atoms of each element", counts_line));
        }
        // More counts than elements are a comment.
        counts.truncate(names.len());
        if counts.len() < names.len() {
            let (elements, found) = (names.len(), counts.len());
            return Err(
                self.expected(&format!("{elements} numbers of atoms, one for each element, not {found}"), counts_line)
            );
        }
        let meaning = |name: &&[u8]| {
            symbol(name).ok_or_else(|| {
                let message = format!("expected the elements' symbols, found `{}`", shown(name));
                Error::input(self.lines.number() - 1, message)
            })
        };
        Ok((names.iter().map(meaning).collect::<Result<_>>()?, counts))
    }

    /// The line that says what the positions are, and that of selective dynamics before it.
    fn mode(&mut self) -> Result<Mode> {
        let mut line = self.next()?;
        let first = |line: &[u8]| line.trim_ascii().first().map(u8::to_ascii_lowercase);
        let selective = first(line) == Some(b's');
        if selective {
            line = self.next()?;
        }
        // VASP looks at the first letter alone; anything but these is direct, too, but hardly meant.
        let direct = match first(line) {
            Some(b'c' | b'k') => false,
            Some(b'd' | b'f') | None => true,
            Some(_) => return Err(self.expected("`Direct` or `Cartesian`", line)),
        };
        let text = lossy(line.trim_ascii()).into_owned();
        let configuration = memchr::memmem::find(&line.to_ascii_lowercase(), b"configuration").is_some();
        Ok(Mode { text, selective, direct, configuration })
    }

    fn positions(&mut self, header: &Header, mode: &Mode) -> Result<Atoms> {
        let total = header.total();
        let matrix = header.cell.cartesian_from_fractional();
        let mut atoms = Atoms { points: Vec::new(), decimals: 0, labels: Vec::new() };
        let first_line = self.lines.number() + 1;
        for index in 0..total {
            let line = match self.next() {
                Err(Error::Input { line, .. }) => {
                    let message = format!("expected {total} atoms from line {first_line} on, found {index}");
                    return Err(Error::input(line, message));
                }
                line => line?,
            };
            let Some((read, decimals, mut rest)) = next_vector(line) else {
                return Err(self.expected(&format!("the position of atom {} of {total}", index + 1), line));
            };
            let point = if mode.direct { matrix * read } else { read * header.scale };
            if !is_plausible(point) {
                return Err(self.expected("a position inside or near the cell", line));
            }
            atoms.points.push(point);
            atoms.decimals = atoms.decimals.max(decimals);
            if atoms.labels.len() == index && header.species.is_empty() {
                for _ in 0..if mode.selective { 3 } else { 0 } {
                    rest = next_word(rest).map_or(rest, |(_, rest)| rest);
                }
                atoms.labels.extend(next_word(rest).and_then(|(word, _)| symbol(word)));
            }
        }
        // A product has the decimals of its factors together.
        let more = if mode.direct { header.cell_decimals } else { header.scale_decimals };
        atoms.decimals = atoms.decimals.saturating_add(more).min(Positions::MAX_DECIMALS);
        Ok(atoms)
    }

    /// The frames behind the first one of an XDATCAR.
    fn more_frames(
        &mut self,
        header: &mut Header,
        mode: &mut Mode,
        builder: &mut StructureBuilder,
        diagnostics: &mut Diagnostics,
    ) -> Result<()> {
        loop {
            let mut ahead = self.lines.clone();
            let Some(line) = ahead.find(|line| !is_blank_line(line)) else { return Ok(()) };
            let is_frame = line.trim_ascii().to_ascii_lowercase().starts_with(b"direct configuration");
            let mut step = || {
                if is_frame {
                    self.lines.by_ref().find(|line| !is_blank_line(line));
                    mode.text = lossy(line.trim_ascii()).into_owned();
                } else {
                    let next = self.header()?;
                    if next.counts != header.counts {
                        let message = "the numbers of atoms differ from those of the first frame";
                        return Err(Error::input(self.lines.number(), message));
                    }
                    *header = next;
                    *mode = self.mode()?;
                }
                self.positions(header, mode)
            };
            match step() {
                Ok(atoms) => {
                    let _fits = builder.push_frame(&atoms.points, Some(header.cell), mode.text.clone());
                }
                Err(Error::Input { line, message }) => {
                    diagnostics.error(line, format!("{message}; this frame and what follows it are left out"));
                    return Ok(());
                }
                Err(limit) => return Err(limit),
            }
        }
    }

    /// The velocities behind the positions, if there are as many and not all are zero.
    fn velocities(&mut self, header: &Header, total: usize) -> Option<Vec<glam::Vec3>> {
        let mut line = self.lines.next()?;
        if line.trim_ascii().to_ascii_lowercase().starts_with(b"lattice velocities") {
            // Its state, the lattice's velocities, and the lattice again.
            line = self.lines.by_ref().nth(7)?;
        }
        let direct = matches!(line.trim_ascii().first(), Some(b'd' | b'D'));
        let matrix = header.cell.cartesian_from_fractional();
        let mut vectors = Vec::new();
        for _ in 0..total {
            let (velocity, ..) = next_vector(self.lines.next()?)?;
            let velocity = if direct { matrix * velocity } else { velocity };
            vectors.push(velocity.as_vec3());
        }
        let finite = vectors.iter().all(|vector| vector.is_finite());
        (finite && vectors.iter().any(|&vector| vector != glam::Vec3::ZERO)).then_some(vectors)
    }
}

impl Header {
    fn total(&self) -> usize {
        self.counts.iter().fold(0, |total: usize, &count| total.saturating_add(count))
    }

    /// VASP 4: the elements from the comment, or from behind the positions.
    fn find_elements(&mut self, atoms: &Atoms) -> Result<()> {
        let groups = self.counts.len();
        if self.species.len() == groups {
            return Ok(());
        }
        let of_comment: Vec<Label> =
            words(self.title.as_bytes()).map_while(symbol).filter(|label| label.element != Element::DUMMY).collect();
        // `TiO2` is no list of elements, and neither is a sentence that begins with one.
        if of_comment.len() == groups || of_comment.len() > groups && groups > 1 {
            self.species = of_comment;
            self.species.truncate(groups);
            return Ok(());
        }
        if atoms.labels.len() == atoms.points.len() {
            let mut species = Vec::new();
            let mut at = 0;
            for &count in &self.counts {
                let group = &atoms.labels[at..at + count];
                species.push(group.first().copied().unwrap_or(read_label(b"X")));
                at += count;
            }
            self.species = species;
            return Ok(());
        }
        let message = format!(
            "the file does not say which elements its {groups} groups of atoms are (it is in the format of VASP 4); \
             add a line with their symbols above line 6, such as `Ti O`"
        );
        Err(Error::input(6, message))
    }
}

#[cfg(test)]
mod tests {
    use crate::import::{Document, Format, ImportOptions, read_bytes};
    use crate::structure::{Severity, Structure};
    use glam::DVec3;

    fn read(text: &str) -> crate::Result<Document> {
        let document = read_bytes(text.as_bytes(), "", &ImportOptions::default())?;
        assert_eq!(document.format, Format::Poscar);
        Ok(document)
    }

    fn elements(structure: &Structure) -> String {
        structure.elements().iter().map(|element| element.symbol()).collect::<Vec<_>>().join(" ")
    }

    const LATTICE: &str = "4.0 0 0\n0 4.0 0\n0.0 0 3.0\n";
    const POSITIONS: &str = "0.0 0.0 0.0\n0.5 0.5 0.5\n0.305 0.305 0.0\n";

    #[test]
    fn a_plain_file_of_vasp_5() {
        let text = format!("rutile\n 1.0\n{LATTICE} Ti_sv O/1a2b\n 1 2\nDirect\n{POSITIONS}");
        let document = read(&text).unwrap();
        let rutile = &document.records[0];
        assert_eq!((rutile.title(), elements(rutile)), ("rutile", "Ti O O".to_owned()));
        assert_eq!(rutile.positions().written(2), DVec3::new(1.22, 1.22, 0.0));
        assert_eq!(rutile.cell().unwrap().lengths(), [4.0, 4.0, 3.0]);
        assert!(document.diagnostics.is_empty());
    }

    #[test]
    fn the_scale_is_a_factor_three_of_them_or_a_volume() {
        for (scale, lengths, position) in [
            ("2.0", [8.0, 8.0, 6.0], [1.0, 1.0, 1.0]),
            ("1.0 2.0 3.0", [4.0, 8.0, 9.0], [0.5, 1.0, 1.5]),
            ("-384.0", [8.0, 8.0, 6.0], [1.0, 1.0, 1.0]),
        ] {
            let text = format!("x\n{scale}\n{LATTICE}H\n1\nCartesian\n0.5 0.5 0.5\n");
            let document = read(&text).unwrap();
            let got = document.records[0].cell().unwrap().lengths();
            assert!(got.iter().zip(lengths).all(|(got, want)| (got - want).abs() < 1e-12), "{scale}: {got:?}");
            let got = document.records[0].positions().get(0);
            assert!((got - DVec3::from_array(position)).length() < 1e-12, "{scale}: {got}");
        }
        for scale in ["0", "x", "-1 2 3 4 x", "nan"] {
            let options = ImportOptions { format: Some(Format::Poscar), ..ImportOptions::default() };
            let text = format!("x\n{scale}\n0 0 0\n0 0 0\n0 0 0\nH\n1\nC\n0.5 0.5 0.5\n");
            assert!(read_bytes(text.as_bytes(), "", &options).is_err(), "{scale}");
        }
    }

    #[test]
    fn files_of_vasp_4_say_their_elements_elsewhere_or_nowhere() {
        let text = |comment: &str, label: &str| {
            let positions =
                POSITIONS.replace("0.0\n", &format!("0.0 {label}\n")).replace("5\n", &format!("5 {label}\n"));
            format!("{comment}\n1.0\n{LATTICE}1 2\nSelective dynamics\nDirect\n{}", positions)
        };
        assert_eq!(elements(&read(&text("Ti O", "T T F")).unwrap().records[0]), "Ti O O");
        assert_eq!(elements(&read(&text("some thing", "T T F Si")).unwrap().records[0]), "Si Si Si");
        let error = read(&text("some thing", "T T T")).unwrap_err().to_string();
        assert!(error.contains("add a line with their symbols"), "{error}");
    }

    #[test]
    fn velocities_are_vectors_and_what_follows_is_passed_over() {
        let velocities = "\n 0.0 0.0 0.5\n 0.0 0.0 0.0\n 0.0 0.0 1.0E-03\n\n 1\n 3.0 junk\n";
        let text = format!("x\n1.0\n{LATTICE}Ti O\n1 2\nDirect\n{POSITIONS}{velocities}");
        let document = read(&text).unwrap();
        assert_eq!(document.records[0].vectors()[0].vectors[2].to_array(), [0.0, 0.0, 1e-3]);
        let lattice = format!("Lattice velocities and vectors\n 1\n{}", "0 0 0\n".repeat(6));
        let document = read(&format!("x\n1.0\n{LATTICE}Ti O\n1 2\nDirect\n{POSITIONS}{lattice}Direct{velocities}"));
        assert_eq!(document.unwrap().records[0].vectors()[0].vectors[0].to_array(), [0.0, 0.0, 1.5]);
        for junk in ["\n0 0 0\n0 0 0\n0 0 0\n", "\nany\n", "\n1 1 1\n", ""] {
            let document = read(&format!("x\n1.0\n{LATTICE}Ti O\n1 2\nDirect\n{POSITIONS}{junk}")).unwrap();
            assert!(document.records[0].vectors().is_empty(), "{junk:?}");
        }
    }

    #[test]
    fn xdatcar_has_frames_with_or_without_cells_of_their_own() {
        let head = |c: f64| format!("x\n1.0\n4.0 0 0\n0 4.0 0\n0 0 {c}\nTi O\n1 2\n");
        let frame = |n: usize| format!("Direct configuration=     {n}\n{POSITIONS}");
        let document = read(&format!("{}{}{}", head(3.0), frame(1), frame(2))).unwrap();
        let frames = document.records[0].frames();
        assert_eq!((frames.len(), frames[1].title.as_str()), (2, "Direct configuration=     2"));
        let document = read(&[head(3.0), frame(1), head(6.0), frame(2)].concat()).unwrap();
        let frames = document.records[0].frames();
        assert_eq!(frames[1].positions.get(1).z, 3.0);
        assert_eq!(frames[1].cell.unwrap().lengths()[2], 6.0);
        let cut = [head(3.0), frame(1), frame(2)[..40].to_owned()].concat();
        let document = read(&cut).unwrap();
        assert_eq!((document.frame_count(), document.diagnostics[0].severity), (1, Severity::Error));
    }

    #[test]
    fn counts_are_claims() {
        let error = read(&format!("x\n1.0\n{LATTICE}Ti O\n1 99999999999\nDirect\n{POSITIONS}")).unwrap_err();
        assert!(error.to_string().contains("found 3"), "{error}");
        assert!(read(&format!("x\n1.0\n{LATTICE}Ti O\n18446744073709551615 9\nDirect\n{POSITIONS}")).is_err());
        assert!(read(&format!("x\n1.0\n{LATTICE}Ti\n0\nDirect\n{POSITIONS}")).is_err());
    }
}
