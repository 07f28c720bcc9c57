//! One molecule of a MOL2 file: from its `@<TRIPOS>MOLECULE` to the next.

use super::super::collect::Records;
use super::super::is_plausible;
use super::super::number::{parse_f64, parse_i64};
use super::super::symbol::LabelKind;
use super::super::text::{Repeated, lossy, shown, words};
use super::{MOLECULE, Peekable, atom_type};
use crate::error::{Error, Result};
use crate::structure::{
    AtomRecord, Bond, BondKind, BondOrder, BondSource, Cell, Diagnostics, StatedBonds, Structure, StructureBuilder,
    atom_flags,
};
use glam::DVec3;
use std::borrow::Cow;
use std::collections::HashMap;

/// Reads the molecule whose first line is the next one.
pub(super) fn read(lines: &mut Peekable<'_>, records: &Records, diagnostics: &mut Diagnostics) -> Result<Structure> {
    let first_line = lines.number();
    lines.skip();
    let outcome = Molecule::default().read(lines, first_line, records, diagnostics);
    // What is left of it after an error.
    while lines.peek().is_some_and(|(_, line)| !line.starts_with(MOLECULE)) {
        lines.skip();
    }
    outcome
}

/// An atom line.
struct Atom<'a> {
    id: i64,
    name: Cow<'a, [u8]>,
    position: DVec3,
    kind: Cow<'a, [u8]>,
    /// Identifier and name of its substructure.
    substructure: Option<(i64, Cow<'a, [u8]>)>,
    charge: Option<f32>,
    line: u64,
}

/// What SUBSTRUCTURE says.
#[derive(Debug, Default)]
struct Substructure {
    chain: String,
    /// The residue's own name, without its number.
    name: String,
}

#[derive(Default)]
struct Molecule<'a> {
    title: &'a [u8],
    /// Line of the counts, atoms, bonds.
    counts: Option<(u64, usize, usize)>,
    no_charges: bool,
    atoms: Vec<Atom<'a>>,
    /// Two atoms, type, line.
    bonds: Vec<(i64, i64, Vec<u8>, u64)>,
    substructures: HashMap<i64, Substructure>,
    formal_charges: Vec<(i64, i64, u64)>,
    cell: Option<Cell>,
    decimals: u8,
    odd: Repeated,
    bad_bond: Repeated,
    unknown: Repeated,
}

impl<'a> Molecule<'a> {
    fn read(
        mut self,
        lines: &mut Peekable<'a>,
        first_line: u64,
        records: &Records,
        diagnostics: &mut Diagnostics,
    ) -> Result<Structure> {
        self.head(lines, first_line)?;
        while let Some((number, line)) = lines.peek() {
            if line.starts_with(MOLECULE) {
                break;
            }
            lines.skip();
            match line.trim_ascii_end() {
                b"@<TRIPOS>ATOM" => self.atoms(lines, records)?,
                b"@<TRIPOS>BOND" => self.bonds(lines)?,
                b"@<TRIPOS>SUBSTRUCTURE" => self.substructures(lines),
                b"@<TRIPOS>UNITY_ATOM_ATTR" => self.attributes(lines),
                b"@<TRIPOS>CRYSIN" => self.crystal(lines, number, diagnostics),
                _ => {}
            }
        }
        lines.check()?;
        self.build(lines.number(), diagnostics)
    }

    /// The lines of MOLECULE: name, counts, molecule type, charge type; each may be all blank but the counts.
    fn head(&mut self, lines: &mut Peekable<'a>, first_line: u64) -> Result<()> {
        let mut next = || loop {
            let (number, line) = lines.in_section()?;
            if !line.starts_with(b"#") {
                return Some((number, line));
            }
        };
        let (_, title) = next().unwrap_or_default();
        let title = title.trim_ascii();
        self.title = if title == b"****" { b"" } else { title };
        let (number, counts) = next().unwrap_or((first_line, b""));
        let mut numbers = words(counts).map(|word| parse_i64(word).and_then(|count| usize::try_from(count).ok()));
        let atoms = numbers.next().flatten();
        let bonds = numbers.next().unwrap_or(Some(0));
        let (Some(atoms), Some(bonds)) = (atoms, bonds) else {
            let message = format!("expected the numbers of atoms and bonds, found `{}`", shown(counts));
            return Err(Error::input(number, message));
        };
        self.counts = Some((number, atoms, bonds));
        let _kind = next();
        self.no_charges = next().is_some_and(|(_, line)| line.trim_ascii() == b"NO_CHARGES");
        while next().is_some() {} // status bits and comment
        Ok(())
    }

    fn atoms(&mut self, lines: &mut Peekable<'a>, records: &Records) -> Result<()> {
        while let Some((number, line)) = lines.data() {
            let read = match lines.joined(line) {
                None => Atom::read(line, number),
                Some(joined) => Atom::read(&joined, number).map(|(atom, decimals)| (atom.into_owned(), decimals)),
            };
            let Some((atom, decimals)) = read else {
                let message = format!("expected an atom (number, name, x, y, z, type), found `{}`", shown(line));
                return Err(Error::input(number, message));
            };
            if !is_plausible(atom.position) {
                return Err(Error::input(number, format!("the position {} cannot be used", atom.position)));
            }
            self.decimals = self.decimals.max(decimals);
            self.atoms.push(atom);
            records.check_atoms(self.atoms.len(), number)?;
        }
        Ok(())
    }

    fn bonds(&mut self, lines: &mut Peekable<'a>) -> Result<()> {
        while let Some((number, line)) = lines.data() {
            let joined = lines.joined(line);
            let line = joined.as_deref().unwrap_or(line);
            let mut words = words(line);
            let fields = (|| {
                words.next()?;
                Some((parse_i64(words.next()?)?, parse_i64(words.next()?)?, words.next()?.to_ascii_lowercase()))
            })();
            let Some((a, b, kind)) = fields else {
                let message = format!("expected a bond (number, two atoms, type), found `{}`", shown(line));
                return Err(Error::input(number, message));
            };
            self.bonds.push((a, b, kind, number));
        }
        Ok(())
    }

    /// `id name root [type [dictionary [chain [residue …]]]]`.
    fn substructures(&mut self, lines: &mut Peekable<'a>) {
        while let Some((_, line)) = lines.data() {
            let joined = lines.joined(line);
            let line = joined.as_deref().unwrap_or(line);
            let mut words = words(line);
            let Some(id) = words.next().and_then(parse_i64) else { continue };
            let text = |word: Option<&[u8]>| match word {
                Some(b"****") | None => String::new(),
                Some(word) => lossy(word).into_owned(),
            };
            let mut rest = words.skip(4);
            let (chain, name) = (text(rest.next()), text(rest.next()));
            self.substructures.insert(id, Substructure { chain, name });
        }
    }

    /// Per atom: `id n`, then n lines `name value`.
    fn attributes(&mut self, lines: &mut Peekable<'a>) {
        while let Some((_, line)) = lines.data() {
            let mut head = words(line).map(parse_i64);
            let (Some(Some(atom)), Some(Some(count))) = (head.next(), head.next()) else { continue };
            for _ in 0..count.clamp(0, 1000) {
                let Some((number, line)) = lines.data() else { return };
                let mut words = words(line);
                if words.next().is_some_and(|name| name.eq_ignore_ascii_case(b"charge"))
                    && let Some(charge) = words.next().and_then(parse_i64)
                {
                    self.formal_charges.push((atom, charge, number));
                }
            }
        }
    }

    /// `a b c alpha beta gamma group setting`.
    fn crystal(&mut self, lines: &mut Peekable<'a>, number: u64, diagnostics: &mut Diagnostics) {
        let Some((number, line)) = lines.data() else {
            diagnostics.warn(Some(number), "CRYSIN holds no cell");
            return;
        };
        let values: Vec<f64> = words(line).map_while(parse_f64).map(|(value, _)| value).collect();
        let cell = match *values.as_slice() {
            [a, b, c, alpha, beta, gamma, ..] => Cell::from_parameters([a, b, c], [alpha, beta, gamma]),
            _ => None,
        };
        if cell.is_none() {
            let message = format!("CRYSIN should hold six numbers that span a cell, found `{}`", shown(line));
            diagnostics.warn(Some(number), message);
            return;
        }
        self.cell = cell;
    }

    fn build(mut self, end: u64, diagnostics: &mut Diagnostics) -> Result<Structure> {
        let found = self.atoms.len();
        let (counts_line, atoms, bonds) = self.counts.unwrap_or_default();
        if found < atoms {
            let message = format!("expected {atoms} atoms as the counts say, found {found}");
            return Err(Error::input(end, message));
        }
        if found == 0 {
            return Err(Error::input(counts_line, "the molecule has 0 atoms"));
        }
        if found > atoms {
            diagnostics.warn(Some(counts_line), format!("the counts say {atoms} atoms, but there are {found}"));
        }
        if self.bonds.len() < bonds {
            let listed = self.bonds.len();
            diagnostics.error(Some(end), format!("expected {bonds} bonds as the counts say, found {listed}"));
        }
        let mut builder = StructureBuilder::new();
        builder.set_title(lossy(self.title));
        builder.set_decimals(self.decimals);
        builder.set_cell(self.cell);
        builder.set_stated_bonds(StatedBonds::Complete);
        let indices = self.push_atoms(&mut builder)?;
        for &(atom, charge, line) in &self.formal_charges {
            match (indices.get(&atom), i8::try_from(charge)) {
                (Some(&index), Ok(charge)) => builder.set_formal_charge(index as usize, charge),
                _ => self.odd.note(line, || format!("a charge of {charge} for atom {atom} cannot be; it is ignored")),
            }
        }
        self.push_bonds(&mut builder, &indices, diagnostics);
        self.bad_bond.error(diagnostics);
        self.unknown.warn(diagnostics);
        self.odd.warn(diagnostics);
        Ok(builder.build(diagnostics))
    }

    /// Adds the atoms; returns their indices by number.
    fn push_atoms(&mut self, builder: &mut StructureBuilder) -> Result<HashMap<i64, u32>> {
        let foreign = self.atoms.iter().any(|atom| atom_type::is_foreign(&atom.kind));
        let mut indices = HashMap::with_capacity(self.atoms.len());
        for atom in &self.atoms {
            let label = atom_type::element(&atom.kind, &atom.name, foreign);
            if label.kind == LabelKind::Unknown {
                self.unknown.note(atom.line, || {
                    let (kind, name) = (shown(&atom.kind), shown(&atom.name));
                    format!("neither type `{kind}` nor name `{name}` tells the element; kept without one")
                });
            }
            let name = lossy(&atom.name);
            let residue = atom.substructure.as_ref().and_then(|(id, text)| self.residue(*id, text));
            let index = builder.push_atom(&AtomRecord {
                element: label.element,
                position: atom.position,
                name: &name,
                serial: i32::try_from(atom.id).ok(),
                residue: residue.as_ref().map(|r| (r.chain.as_str(), r.number, r.insertion_code, r.name.as_str())),
                flags: if label.particle { atom_flags::PARTICLE } else { 0 },
                partial_charge: atom.charge.filter(|_| !self.no_charges),
                isotope: label.isotope,
                ..AtomRecord::default()
            });
            if indices.insert(atom.id, index).is_some() {
                return Err(Error::input(atom.line, format!("two atoms have the number {}", atom.id)));
            }
        }
        Ok(indices)
    }

    /// The residue of a substructure: of `ALA12` the number is 12; where there are no digits it is the
    /// substructure's own. `None` for a substructure that has no name and stands in no section.
    fn residue(&self, id: i64, text: &[u8]) -> Option<Named> {
        let stated = self.substructures.get(&id);
        let text = if text == b"****" { b"".as_slice() } else { text };
        if text.is_empty() && stated.is_none() {
            return None;
        }
        let chain = stated.map_or_else(String::new, |stated| stated.chain.clone());
        let named = |name: &[u8], number: Option<i32>, insertion_code: u8| {
            let number = number.unwrap_or(i32::try_from(id).unwrap_or(0));
            Some(Named { chain, number, insertion_code, name: lossy(name).into_owned() })
        };
        let number_of = |text: &[u8]| parse_i64(text).and_then(|number| i32::try_from(number).ok());
        // The section knows where the name ends: `HOH2` may be residue 2 of HOH, and `SO4` is no residue 4.
        let own = stated.map(|stated| stated.name.as_bytes()).filter(|name| !name.is_empty());
        if let Some((name, rest)) = own.and_then(|name| Some((name, text.strip_prefix(name)?))) {
            return match *rest {
                [ref digits @ .., code] if code.is_ascii_alphabetic() && number_of(digits).is_some() => {
                    named(name, number_of(digits), code)
                }
                _ => named(name, number_of(rest), b' '),
            };
        }
        let digits = text.iter().rev().take_while(|byte| byte.is_ascii_digit()).count();
        let (mut head, tail) = text.split_at(text.len() - digits);
        let mut number = number_of(tail);
        if let (Some(value), [rest @ .., b'-']) = (number, head) {
            (number, head) = (Some(-value), rest); // `ALA-3`
        }
        match number {
            Some(number) if !head.is_empty() => named(head, Some(number), b' '),
            // Digits alone are a name.
            _ => named(text, None, b' '),
        }
    }

    fn push_bonds(
        &mut self,
        builder: &mut StructureBuilder,
        indices: &HashMap<i64, u32>,
        diagnostics: &mut Diagnostics,
    ) {
        let mut pairs = Vec::with_capacity(self.bonds.len());
        for (a, b, kind, line) in &self.bonds {
            let (Some(&first), Some(&second)) = (indices.get(a).filter(|_| a != b), indices.get(b)) else {
                let count = self.atoms.len();
                self.bad_bond
                    .note(*line, || format!("a bond between atoms {a} and {b} of {count} cannot be; it is left out"));
                continue;
            };
            let (order, aromatic) = match kind.as_slice() {
                b"1" | b"am" => (BondOrder::Single, false),
                b"2" => (BondOrder::Double, false),
                b"3" => (BondOrder::Triple, false),
                b"4" => (BondOrder::Quadruple, false), // no type of the format, but programs write it
                b"ar" => (BondOrder::Unknown, true),
                b"du" | b"un" => (BondOrder::Unknown, false),
                b"nc" => continue,
                _ => {
                    let message = || format!("bond type `{}` is not known; taken as of unknown order", shown(kind));
                    self.odd.note(*line, message);
                    (BondOrder::Unknown, false)
                }
            };
            let is_metal = |atom: u32| builder.elements()[atom as usize].is_metal();
            let coordination = order <= BondOrder::Single && !aromatic && is_metal(first) != is_metal(second);
            let bond = if coordination {
                let bond = Bond::new(first, second, BondOrder::Unknown, BondSource::File);
                Bond { kind: BondKind::Coordination, ..bond }
            } else {
                Bond { aromatic, ..Bond::new(first, second, order, BondSource::File) }
            };
            pairs.push((bond.a, bond.b));
            builder.push_bond(bond);
        }
        pairs.sort_unstable();
        let listed = pairs.len();
        pairs.dedup();
        if pairs.len() < listed {
            let message = format!("{} bonds are listed twice; the first of each is used", listed - pairs.len());
            diagnostics.warn(None, message);
        }
    }
}

/// A residue.
struct Named {
    chain: String,
    number: i32,
    insertion_code: u8,
    name: String,
}

impl<'a> Atom<'a> {
    /// `id name x y z type [substructure [name [charge [status]]]]`, and the position's decimals.
    fn read(line: &'a [u8], number: u64) -> Option<(Atom<'a>, u8)> {
        let mut words = words(line);
        let id = parse_i64(words.next()?)?;
        let name = words.next()?;
        let mut coordinate = || parse_f64(words.next()?);
        let ((x, dx), (y, dy), (z, dz)) = (coordinate()?, coordinate()?, coordinate()?);
        let kind = words.next()?;
        let id_of = words.next().and_then(parse_i64);
        let name_of = words.next();
        let charge = words.next().and_then(parse_f64).map(|(charge, _)| charge as f32).filter(|c| c.is_finite());
        let substructure = id_of.map(|id| (id, Cow::Borrowed(name_of.unwrap_or_default())));
        let name = Cow::Borrowed(if name == b"****" { b"".as_slice() } else { name });
        let (position, kind) = (DVec3::new(x, y, z), Cow::Borrowed(kind));
        let atom = Atom { id, name, position, kind, substructure, charge, line: number };
        Some((atom, dx.max(dy).max(dz)))
    }

    /// The same for a line that does not stay.
    fn into_owned(self) -> Atom<'static> {
        let owned = |text: Cow<'_, [u8]>| Cow::Owned(text.into_owned());
        Atom {
            id: self.id,
            name: owned(self.name),
            position: self.position,
            kind: owned(self.kind),
            substructure: self.substructure.map(|(id, text)| (id, owned(text))),
            charge: self.charge,
            line: self.line,
        }
    }
}
