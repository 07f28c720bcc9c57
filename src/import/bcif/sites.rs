//! `_atom_site` of a usual file, column by column: the columns are decoded at the same time, each becomes the structure's
//! at once and is freed, and a text is looked at once, not in every row that has it.
//!
//! Usual is what programs that write macromolecules have in common: one model, Cartesian coordinates in every row, names
//! and numbers of residues in every row, element symbols that are some. Of anything else, and of columns that cannot be
//! decoded, nothing is read here; then the rows are ([`AtomSites::from_table`]), which know all cases and say what is odd.
//! Where both can read a file, the result is the same; the tests compare them.

use super::super::cif::atoms::{AtomSites, Columns, ResidueLabel, code};
use super::super::cif::label::type_symbol;
use super::super::cif::table::{ABSENT, Column as Index};
use super::super::{Limits, is_plausible};
use super::column::{ABSENT_NUMBER, Column, meaning_at};
use super::encoding::{Budget, Data};
use crate::element::Element;
use crate::structure::{AtomColumns, NameId, Names, Points, StructureBuilder, atom_flags};
use glam::DVec3;

/// Name, data and mask of a column.
pub(super) type Encoded<'t, 'a> = (&'a [u8], &'t Data<'a>, Option<&'t Data<'a>>);

/// The atoms; `None` if the table is not a usual one.
pub(super) fn read(encoded: &[Encoded<'_, '_>], rows: usize, budget: &Budget, limits: &Limits) -> Option<AtomSites> {
    let find =
        |item: &str| encoded.iter().position(|(name, ..)| name.eq_ignore_ascii_case(item.as_bytes())).unwrap_or(ABSENT);
    let most = limits.atoms.min(u32::MAX as usize);
    let columns = Columns::find(find).filter(|columns| is_usual(columns) && (1..=most).contains(&rows))?;
    let table = Table { encoded, rows, budget };
    let model = table.optional(columns.model, Column::whole_numbers)?.unwrap_or_default();
    if model.iter().any(|&number| number != model[0] || number == ABSENT_NUMBER) {
        return None;
    }
    drop(model);
    let ((runs, names), (points, rest)) = rayon::join(
        || rayon::join(|| Runs::read(&table, &columns), || table.decode(columns.name[0])?.texts()),
        || rayon::join(|| positions(&table, &columns), || rest(&table, &columns)),
    );
    let (runs, (texts, indices), (points, decimals)) = (runs?, names?, points?);
    if indices.iter().any(|&index| index < 0) {
        return None;
    }
    let mut builder = StructureBuilder::new();
    let (labels, label_names) = runs.name(&mut builder, &texts, &indices);
    builder.set_columns(AtomColumns { points, ..rest? });
    Some(AtomSites::of_one_model(builder, labels, label_names, decimals, limits))
}

/// Whether the table has what is read here, and nothing that is not.
fn is_usual(columns: &Columns) -> bool {
    let needed = [columns.symbol, columns.name[0], columns.residue_name[0], columns.chain[0], columns.number[0]];
    let special = [columns.u_factor, columns.assembly, columns.group_of_disorder, columns.calculated];
    !columns.fractional && !needed.contains(&ABSENT) && special == [ABSENT; 4]
}

struct Table<'t, 'a> {
    encoded: &'t [Encoded<'t, 'a>],
    rows: usize,
    budget: &'t Budget,
}

impl<'a> Table<'_, 'a> {
    fn decode(&self, column: Index) -> Option<Column<'a>> {
        let (_, data, mask) = self.encoded.get(column)?;
        Column::decode(data, *mask, self.rows, self.budget).ok()
    }

    /// What `read` makes of a column; `Some(None)` if the table does not have it, or no value in it.
    fn optional<T>(&self, column: Index, read: impl Fn(Column<'a>) -> Option<T>) -> Option<Option<T>> {
        if column == ABSENT {
            return Some(None);
        }
        let column = self.decode(column)?;
        if column.is_void() { Some(None) } else { read(column).map(Some) }
    }
}

/// Texts, each with a number of its own, and which one each row has.
struct Coded<'a> {
    texts: Vec<&'a str>,
    /// The first of the texts that is the same, for each.
    same: Vec<u32>,
    indices: Vec<i32>,
}

impl<'a> Coded<'a> {
    fn of(column: Column<'a>) -> Option<Coded<'a>> {
        let (texts, indices) = column.texts()?;
        let mut first = std::collections::HashMap::new();
        let same = texts.iter().zip(0..).map(|(&text, number)| *first.entry(text).or_insert(number)).collect();
        Some(Coded { texts, same, indices })
    }

    /// One a row; one below all others for none, which is as the empty text.
    fn number(&self, row: usize) -> u32 {
        meaning_at(&self.same, self.indices[row])
            .filter(|&number| !self.texts[number as usize].is_empty())
            .unwrap_or(u32::MAX)
    }

    fn text(&self, row: usize) -> &'a str {
        meaning_at(&self.texts, self.indices[row]).unwrap_or("")
    }

    fn is_whole(&self) -> bool {
        self.indices.iter().all(|&index| index >= 0)
    }
}

/// The residues: what the row says in which each begins (until those are known, what each row says).
struct Runs<'a> {
    chain: Coded<'a>,
    name: Coded<'a>,
    label_chain: Option<Coded<'a>>,
    number: Vec<i32>,
    label_number: Option<Vec<i32>>,
    insertion_code: Option<Vec<u8>>,
    begins: Vec<u32>,
}

impl<'a> Runs<'a> {
    fn read(table: &Table<'_, 'a>, columns: &Columns) -> Option<Runs<'a>> {
        let own_label = columns.label_number != columns.number[0];
        let label_column = if own_label { columns.label_number } else { ABSENT };
        let insertion_code = |column: Column<'a>| column.meanings(b' ', |text| Some(code(text).unwrap_or(b' ')));
        let ((chain, name), ((number, label_number), (label_chain, insertion_code))) = rayon::join(
            || {
                rayon::join(
                    || Coded::of(table.decode(columns.chain[0])?),
                    || Coded::of(table.decode(columns.residue_name[0])?),
                )
            },
            || {
                rayon::join(
                    || {
                        rayon::join(
                            || table.decode(columns.number[0])?.whole_numbers(),
                            || table.optional(label_column, Column::whole_numbers),
                        )
                    },
                    || {
                        rayon::join(
                            || table.optional(columns.label_chain, Coded::of),
                            || table.optional(columns.insertion_code, insertion_code),
                        )
                    },
                )
            },
        );
        let mut runs = Runs {
            chain: chain.filter(Coded::is_whole)?,
            name: name.filter(Coded::is_whole)?,
            label_chain: label_chain?,
            number: number.filter(|numbers| !numbers.contains(&ABSENT_NUMBER))?,
            label_number: label_number?,
            insertion_code: insertion_code?,
            begins: Vec::new(),
        };
        runs.begins = runs.find_begins(table.rows);
        runs.forget_the_rest();
        Some(runs)
    }

    /// The rows that differ from the one before in anything that tells residues apart.
    fn find_begins(&self, rows: usize) -> Vec<u32> {
        fn mark<T: PartialEq>(begins: &mut [bool], value: impl Fn(usize) -> T) {
            let mut before = value(0);
            for (row, begins) in begins.iter_mut().enumerate() {
                let here = value(row);
                *begins |= here != before;
                before = here;
            }
        }
        let mut begins = vec![false; rows];
        begins[0] = true;
        mark(&mut begins, |row| self.number[row]);
        for coded in [Some(&self.chain), Some(&self.name), self.label_chain.as_ref()].into_iter().flatten() {
            // Almost always the number says it already: then the texts are the same.
            mark(&mut begins, |row| coded.number(row));
        }
        if let Some(numbers) = &self.label_number {
            mark(&mut begins, |row| numbers[row]);
        }
        if let Some(codes) = &self.insertion_code {
            mark(&mut begins, |row| codes[row]);
        }
        begins.iter().zip(0..).filter(|(begins, _)| **begins).map(|(_, row)| row).collect()
    }

    /// Keeps the rows in which residues begin.
    fn forget_the_rest(&mut self) {
        fn keep<T: Copy>(values: &mut Vec<T>, rows: &[u32]) {
            *values = rows.iter().map(|&row| values[row as usize]).collect();
        }
        let begins = &self.begins;
        for coded in [Some(&mut self.chain), Some(&mut self.name), self.label_chain.as_mut()].into_iter().flatten() {
            keep(&mut coded.indices, begins);
        }
        for numbers in [Some(&mut self.number), self.label_number.as_mut()].into_iter().flatten() {
            keep(numbers, begins);
        }
        if let Some(codes) = &mut self.insertion_code {
            keep(codes, begins);
        }
    }

    /// Gives the builder residues and the names of their atoms, which become its names in the order in which rows
    /// would have them met; returns the residues' labels.
    fn name(self, builder: &mut StructureBuilder, texts: &[&str], indices: &[i32]) -> (Vec<ResidueLabel>, Names) {
        let mut label_names = Names::default();
        let mut labels = Vec::with_capacity(self.begins.len());
        let mut ids: Vec<Option<NameId>> = vec![None; texts.len()];
        for (number, &first) in self.begins.iter().enumerate() {
            let first = first as usize;
            let end = self.begins.get(number + 1).map_or(indices.len(), |&row| row as usize);
            let label_chain = self.label_chain.as_ref().map_or("", |coded| coded.text(number));
            let label_number = self.label_number.as_ref().map(|numbers| numbers[number]);
            labels.push(ResidueLabel {
                chain: label_names.intern(label_chain),
                number: label_number.filter(|&label| label != ABSENT_NUMBER).map(i64::from),
            });
            let insertion_code = self.insertion_code.as_ref().map_or(b' ', |codes| codes[number]);
            let residue = (self.chain.text(number), self.number[number], insertion_code, self.name.text(number));
            builder.push_residue_names(residue, end - first, |builder, atom| {
                let index = indices[first + atom] as usize;
                *ids[index].get_or_insert_with(|| builder.name_id(texts[index].as_bytes()))
            });
        }
        (labels, label_names)
    }
}

/// The positions and the decimals they are written with.
fn positions(table: &Table<'_, '_>, columns: &Columns) -> Option<(Points, u8)> {
    let [x, y, z] = columns.position;
    let (x, (y, z)) = rayon::join(|| table.decode(x), || rayon::join(|| table.decode(y), || table.decode(z)));
    let axes = [x?, y?, z?];
    let mut decimals = 0;
    for axis in &axes {
        decimals = decimals.max(axis.decimals()?);
    }
    let fill = |first: usize, points: &mut [DVec3]| {
        let mut values = [[0.0; 256]; 3];
        for (start, some) in (first..).step_by(256).zip(points.chunks_mut(256)) {
            for (axis, values) in axes.iter().zip(&mut values) {
                if axis.numbers(start, &mut values[..some.len()]).is_none() {
                    return false;
                }
            }
            for (row, point) in some.iter_mut().enumerate() {
                *point = DVec3::new(values[0][row], values[1][row], values[2][row]);
            }
            if !some.iter().all(|&point| is_plausible(point)) {
                return false;
            }
        }
        true
    };
    Some((Points::filled(table.rows, fill)?, decimals))
}

/// All that is said of the atoms beside names, residues and positions.
fn rest(table: &Table<'_, '_>, columns: &Columns) -> Option<AtomColumns> {
    let flag =
        |column: Column<'_>| column.meanings(0, |text| Some(if text == "HETATM" { atom_flags::HETERO } else { 0 }));
    // The rows say of which it was that only the first letter is kept.
    let altloc =
        |column: Column<'_>| column.meanings(b' ', |text| (text.len() <= 1).then(|| code(text).unwrap_or(b' ')));
    let serial = |column: Column<'_>| column.whole_numbers().filter(|serials| !serials.contains(&ABSENT_NUMBER));
    let ((elements, (flags, altloc)), (serial, (occupancy, b_factor))) = rayon::join(
        || {
            rayon::join(
                || elements(table, columns),
                || rayon::join(|| table.optional(columns.group, flag), || table.optional(columns.altloc, altloc)),
            )
        },
        || {
            rayon::join(
                || table.optional(columns.id, serial),
                || {
                    rayon::join(
                        || table.optional(columns.occupancy, |column| column.singles(1.0)),
                        || table.optional(columns.b_factor, |column| column.singles(0.0)),
                    )
                },
            )
        },
    );
    Some(AtomColumns {
        serial: serial?,
        flags: flags?.unwrap_or_default(),
        altloc: altloc?.unwrap_or_default(),
        occupancy: occupancy?.unwrap_or_default(),
        b_factor: b_factor?.unwrap_or_default(),
        ..elements?
    })
}

/// Elements, isotopes and charges.
fn elements(table: &Table<'_, '_>, columns: &Columns) -> Option<AtomColumns> {
    let (texts, indices) = table.decode(columns.symbol)?.texts()?;
    let meanings: Vec<_> = texts.into_iter().map(type_symbol).collect();
    let known: Vec<Option<Element>> = meanings.iter().map(|meaning| Some(meaning.as_ref()?.element)).collect();
    let mut element: Vec<Element> = Vec::with_capacity(table.rows);
    for &index in &indices {
        element.push(meaning_at(&known, index)??);
    }
    // Each row has a symbol that is known.
    let isotopes: Vec<u16> = meanings.iter().map(|meaning| meaning.as_ref().map_or(0, |one| one.isotope)).collect();
    let charges: Vec<i8> = meanings.iter().map(|meaning| meaning.as_ref().map_or(0, |one| one.charge)).collect();
    let isotope = if isotopes.iter().any(|&isotope| isotope != 0) {
        indices.iter().map(|&index| isotopes[index as usize]).collect()
    } else {
        Vec::new()
    };
    let stated = table.optional(columns.charge, Column::whole_numbers)?;
    let formal_charge = match stated {
        Some(stated) => {
            let charge = |(&index, charge): (&i32, i32)| i8::try_from(charge).unwrap_or(charges[index as usize]);
            indices.iter().zip(stated).map(charge).collect()
        }
        None if charges.iter().any(|&charge| charge != 0) => {
            indices.iter().map(|&index| charges[index as usize]).collect()
        }
        None => Vec::new(),
    };
    Some(AtomColumns { element, isotope, formal_charge, ..AtomColumns::default() })
}
