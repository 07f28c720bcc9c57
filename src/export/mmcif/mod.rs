//! mmCIF: one data block a record, all frames as models.
//!
//! Written are `_entry`, `_struct` (title), `_cell`, `_symmetry` with operations, `_pdbx_struct_assembly` ([`assembly`]), `_chem_comp_bond`, `_struct_conf`,
//! `_struct_sheet_range`, `_struct_conn` and `_atom_site` ([`bonds`] says which bond goes where). Positions have as many
//! decimals as the file they came from; other numbers read back equal. Values are quoted where they need it ([`value`]).
//!
//! Author and label identifiers are the same but for `label_seq_id`, which counts the residues of a chain that are
//! not hetero, and for `label_asym_id` where residues that follow one another have everything else in common.
//! Structures without residues become one residue UNL of chain A, atoms without a name get one from their
//! element, so that other programs can read the file and bonds can be told by names.

mod assembly;
mod bonds;
mod value;

use super::formats::{Part, StructureFormat, title};
use super::text::{AtomNames, Position, is_standard, metals, one_line, parameters, symbol_with_isotope};
use crate::structure::{
    Bond, BondKind, BondOrder, Frame, NameId, Names, StatedBonds, Structure, SymmetryOperation, atom_flags,
};
use bonds::Plan;
use std::collections::{HashMap, HashSet};
use std::io::{self, Write};
use value::{Code, Number, Value};

/// The format's line in the table.
pub static FORMAT: StructureFormat = StructureFormat {
    name: "mmcif",
    extensions: &["cif", "mmcif"],
    description: "mmCIF (all records and frames)",
    all_frames: true,
    holds: &[
        Part::Title,
        Part::Frames,
        Part::Bonds,
        Part::CoordinationBonds,
        Part::HydrogenBonds,
        Part::Cell,
        Part::SpaceGroup,
        Part::SymmetryOperations,
        Part::Assemblies,
        Part::Components,
        Part::AtomNames,
        Part::Serials,
        Part::Residues,
        Part::AtomKinds,
        Part::Particles,
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
    let residues = Residues::new(structure);
    let plan = Plan::new(structure, &residues);
    let is_whole = structure.stated_bonds() == StatedBonds::Complete && structure.atom_count() > 1;
    let mut has_partner = vec![!is_whole; structure.atom_count()];
    for atom in structure.bonds().iter().flat_map(|bond| [bond.a, bond.b]) {
        has_partner[atom as usize] = true;
    }
    let alone = has_partner.contains(&false);
    let turned = structure.cell().is_some_and(|cell| !is_standard(cell));
    [
        (plan.unnamed, "bonds of atoms that share their name and residue with others (left out)"),
        (plan.unordered, "aromatic bonds and bonds of unknown order where residues of one name differ (written as single or double)"),
        (alone, "that atoms are without any partner (distances may give them some when the file is read)"),
        (turned, "unit cells whose first vector is not along x or whose second is not in the xy plane (written as lengths and angles)"),
        (!assembly::is_whole(structure, &residues), "assemblies of parts of chains (left out)"),
        (!residues.has_unique_serials, "serial numbers that repeat (counted anew)"),
    ]
    .into_iter()
    .filter_map(|(is_so, phrase)| is_so.then_some(phrase))
    .collect()
}

/// Writes all records.
///
/// # Errors
/// What the writer returns, and `InvalidData` for a position that is not a number.
pub fn write(records: &[Structure], out: &mut dyn Write) -> io::Result<()> {
    let mut taken = HashSet::new();
    for (index, structure) in records.iter().enumerate() {
        let mut id = block_name(title(structure));
        if !taken.insert(id.to_ascii_lowercase()) {
            id = format!("{id}_{}", index + 1);
        }
        write_block(structure, &id, out)?;
    }
    Ok(())
}

/// What may stand behind `data_`, of the title's first word.
fn block_name(title: &str) -> String {
    let word = title.split_whitespace().next().unwrap_or("");
    let name: String =
        word.chars().map(|c| if c.is_ascii_alphanumeric() || "-.".contains(c) { c } else { '_' }).take(40).collect();
    if name.is_empty() { "structure".to_owned() } else { name }
}

fn write_block(structure: &Structure, id: &str, out: &mut dyn Write) -> io::Result<()> {
    let residues = Residues::new(structure);
    let plan = Plan::new(structure, &residues);
    writeln!(out, "data_{id}\n#\n_entry.id {id}\n#")?;
    let title = one_line(title(structure));
    if !title.is_empty() {
        writeln!(out, "_struct.entry_id {id}\n_struct.title {}\n#", Value(&title))?;
    }
    write_crystal(structure, id, out)?;
    assembly::write(structure, &residues, out)?;
    write_components(&plan, out)?;
    write_secondary(structure, out)?;
    write_links(structure, &residues, &plan, out)?;
    write_atoms(structure, &residues, out)
}

fn write_crystal(structure: &Structure, id: &str, out: &mut dyn Write) -> io::Result<()> {
    if let Some(cell) = structure.cell() {
        let ([a, b, c], [alpha, beta, gamma]) = parameters(cell);
        writeln!(out, "_cell.entry_id {id}\n_cell.length_a {a}\n_cell.length_b {b}\n_cell.length_c {c}")?;
        writeln!(out, "_cell.angle_alpha {alpha}\n_cell.angle_beta {beta}\n_cell.angle_gamma {gamma}\n#")?;
    }
    let Some(symmetry) = structure.symmetry() else { return Ok(()) };
    let group = one_line(&symmetry.space_group);
    writeln!(out, "_symmetry.entry_id {id}\n_symmetry.space_group_name_H-M {}\n#", Value(&group))?;
    if !symmetry.operations.is_empty() {
        out.write_all(b"loop_\n_space_group_symop.id\n_space_group_symop.operation_xyz\n")?;
        for (index, operation) in symmetry.operations.iter().enumerate() {
            writeln!(out, "{} {}", index + 1, triplet(operation))?;
        }
        out.write_all(b"#\n")?;
    }
    Ok(())
}

/// An operation as `-x,y+1/2,-z`.
fn triplet(operation: &SymmetryOperation) -> String {
    let part = |row: usize| {
        let mut text = String::new();
        for (axis, letter) in ["x", "y", "z"].iter().enumerate() {
            let factor = operation.rotation.col(axis)[row];
            let sign = if factor < 0.0 {
                "-"
            } else if text.is_empty() {
                ""
            } else {
                "+"
            };
            match factor.abs() {
                0.0 => {}
                1.0 => text.push_str(&format!("{sign}{letter}")),
                size => text.push_str(&format!("{sign}{size}*{letter}")),
            }
        }
        let shift = operation.translation[row];
        if shift != 0.0 || text.is_empty() {
            let sign = if shift < 0.0 {
                "-"
            } else if text.is_empty() {
                ""
            } else {
                "+"
            };
            // The translations of all conventional settings are multiples of a 24th.
            let fraction = [1, 2, 3, 4, 6, 8, 12, 24].iter().find_map(|&below| {
                let above = shift.abs() * f64::from(below);
                let is_whole = (above - above.round()).abs() < 1e-9 && above.round() / f64::from(below) == shift.abs();
                is_whole.then(|| if below == 1 { format!("{above}") } else { format!("{}/{below}", above.round()) })
            });
            text.push_str(&format!("{sign}{}", fraction.unwrap_or_else(|| shift.abs().to_string())));
        }
        text
    };
    [0, 1, 2].map(part).join(",")
}

fn write_components(plan: &Plan, out: &mut dyn Write) -> io::Result<()> {
    if plan.components.iter().all(|component| component.bonds.is_empty()) {
        return Ok(());
    }
    out.write_all(b"loop_\n")?;
    for item in ["comp_id", "atom_id_1", "atom_id_2", "value_order", "pdbx_aromatic_flag"] {
        writeln!(out, "_chem_comp_bond.{item}")?;
    }
    for component in &plan.components {
        for bond in &component.bonds {
            let order = match bond.order {
                BondOrder::Single => "SING",
                BondOrder::Double => "DOUB",
                BondOrder::Triple => "TRIP",
                BondOrder::Quadruple => "QUAD",
                BondOrder::Unknown if bond.aromatic => "AROM",
                BondOrder::Unknown => "DELO",
            };
            let flag = if bond.aromatic { 'Y' } else { 'N' };
            writeln!(out, "{} {} {} {order} {flag}", Value(&component.name), Value(&bond.a), Value(&bond.b))?;
        }
    }
    out.write_all(b"#\n")
}

fn write_secondary(structure: &Structure, out: &mut dyn Write) -> io::Result<()> {
    for helix in [true, false] {
        let elements: Vec<_> = structure.secondary().iter().filter(|element| element.helix == helix).collect();
        if elements.is_empty() {
            continue;
        }
        let category = if helix { "_struct_conf" } else { "_struct_sheet_range" };
        let ids: &[&str] = if helix { &["conf_type_id", "id"] } else { &["sheet_id", "id"] };
        writeln!(out, "loop_")?;
        for item in ids {
            writeln!(out, "{category}.{item}")?;
        }
        for end in ["beg", "end"] {
            for item in
                [format!("{end}_auth_asym_id"), format!("{end}_auth_seq_id"), format!("pdbx_{end}_PDB_ins_code")]
            {
                writeln!(out, "{category}.{item}")?;
            }
        }
        for (index, element) in elements.iter().enumerate() {
            let number = index + 1;
            if helix {
                write!(out, "HELX_P HELX_P{number}")?;
            } else {
                write!(out, "A {number}")?;
            }
            for (number, code) in [element.first, element.last] {
                write!(out, " {} {number} {}", Value(&one_line(&element.chain)), Code(code))?;
            }
            writeln!(out)?;
        }
        out.write_all(b"#\n")?;
    }
    Ok(())
}

/// The type of a row of `_struct_conn`.
fn type_of(structure: &Structure, residues: &Residues<'_>, bond: &Bond) -> &'static str {
    let sulfur = |atom: u32| {
        let residue = residues.name(residues.index(atom as usize));
        structure.elements()[atom as usize] == crate::element::Element::S && residues.text(residue) == "CYS"
    };
    match bond.kind {
        BondKind::Coordination => "metalc",
        BondKind::Dative if metals(structure, bond) == 1 => "metalc",
        BondKind::Hydrogen => "hydrog",
        _ if sulfur(bond.a) && sulfur(bond.b) => "disulf",
        _ => "covale",
    }
}

fn write_links(structure: &Structure, residues: &Residues<'_>, plan: &Plan, out: &mut dyn Write) -> io::Result<()> {
    if plan.rows.is_empty() {
        return Ok(());
    }
    let mut counts: HashMap<&str, usize> = HashMap::new();
    out.write_all(b"loop_\n_struct_conn.id\n_struct_conn.conn_type_id\n")?;
    for end in ["1", "2"] {
        for item in [
            format!("ptnr{end}_label_asym_id"),
            format!("ptnr{end}_label_comp_id"),
            format!("ptnr{end}_label_seq_id"),
            format!("ptnr{end}_label_atom_id"),
            format!("pdbx_ptnr{end}_label_alt_id"),
            format!("pdbx_ptnr{end}_PDB_ins_code"),
            format!("ptnr{end}_auth_asym_id"),
            format!("ptnr{end}_auth_comp_id"),
            format!("ptnr{end}_auth_seq_id"),
            format!("ptnr{end}_symmetry"),
        ] {
            writeln!(out, "_struct_conn.{item}")?;
        }
    }
    out.write_all(b"_struct_conn.pdbx_value_order\n")?;
    for &index in &plan.rows {
        let bond = structure.bonds()[index];
        let kind = type_of(structure, residues, &bond);
        let count = counts.entry(kind).or_default();
        *count += 1;
        write!(out, "{kind}{count} {kind}")?;
        for atom in [bond.a, bond.b].map(|atom| atom as usize) {
            let residue = residues.index(atom);
            let (chain, name) = (Value(residues.chain(residue)), Value(residues.text(residues.name(residue))));
            write!(
                out,
                " {} {name} {}",
                Value(residues.label_chain(residue)),
                Sequence(residues.label_number(residue))
            )?;
            write!(out, " {} {}", Value(residues.text(residues.atom_name(atom))), Code(structure.altloc(atom)))?;
            let (number, insertion_code) = residues.number(residue);
            write!(out, " {} {chain} {name} {number} 1_555", Code(insertion_code))?;
        }
        let order = match (bond.kind, bond.order) {
            (BondKind::Covalent | BondKind::Dative, BondOrder::Single) => "sing",
            (_, BondOrder::Double) => "doub",
            (_, BondOrder::Triple) => "trip",
            (_, BondOrder::Quadruple) => "quad",
            _ => "?",
        };
        writeln!(out, " {order}")?;
    }
    out.write_all(b"#\nloop_\n_struct_conn_type.id\n_struct_conn_type.criteria\n_struct_conn_type.reference\n")?;
    let mut kinds: Vec<&str> = counts.into_keys().collect();
    kinds.sort_unstable();
    for kind in kinds {
        writeln!(out, "{kind} ? ?")?;
    }
    out.write_all(b"#\n")
}

/// `label_seq_id`, `.` for hetero residues.
struct Sequence(Option<u32>);

impl std::fmt::Display for Sequence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            Some(number) => number.fmt(f),
            None => f.write_str("."),
        }
    }
}

fn write_atoms(structure: &Structure, residues: &Residues<'_>, out: &mut dyn Write) -> io::Result<()> {
    let particles = Part::Particles.is_in(structure);
    out.write_all(b"loop_\n")?;
    for item in [
        "group_PDB",
        "id",
        "type_symbol",
        "label_atom_id",
        "label_alt_id",
        "label_comp_id",
        "label_asym_id",
        "label_entity_id",
        "label_seq_id",
        "pdbx_PDB_ins_code",
        "Cartn_x",
        "Cartn_y",
        "Cartn_z",
        "occupancy",
        "B_iso_or_equiv",
        "pdbx_formal_charge",
        "auth_seq_id",
        "auth_comp_id",
        "auth_asym_id",
        "auth_atom_id",
        "pdbx_PDB_model_num",
    ] {
        writeln!(out, "_atom_site.{item}")?;
    }
    if particles {
        out.write_all(b"_atom_site.calc_flag\n")?;
    }
    // Numbers of further models go on behind those of the first.
    let serials = (0..structure.atom_count()).map(|atom| i64::from(structure.serial(atom)));
    let (low, high) = serials.fold((i64::MAX, 0), |(low, high), serial| (low.min(serial), high.max(serial)));
    let span = if residues.has_unique_serials {
        high.saturating_sub(low).saturating_add(1)
    } else {
        structure.atom_count() as i64
    };
    for (model, frame) in structure.frames().iter().enumerate() {
        let shift = i64::try_from(model).unwrap_or(0).saturating_mul(span);
        for atom in 0..structure.atom_count() {
            write_atom(structure, frame, residues, (model + 1, shift), atom, out)?;
            if particles {
                let particle = structure.flags(atom) & atom_flags::PARTICLE != 0;
                out.write_all(if particle { b" dum" } else { b" ." })?;
            }
            out.write_all(b"\n")?;
        }
    }
    out.write_all(b"#\n")
}

fn write_atom(
    structure: &Structure,
    frame: &Frame,
    residues: &Residues<'_>,
    (model, shift): (usize, i64),
    atom: usize,
    out: &mut dyn Write,
) -> io::Result<()> {
    let residue = residues.index(atom);
    let group = if structure.flags(atom) & atom_flags::HETERO != 0 { "HETATM" } else { "ATOM  " };
    let serial = if residues.has_unique_serials { i64::from(structure.serial(atom)) } else { atom as i64 + 1 };
    let symbol = symbol_with_isotope(structure, atom).to_ascii_uppercase();
    let (name, altloc) = (Value(residues.text(residues.atom_name(atom))), Code(structure.altloc(atom)));
    let (comp, chain) = (Value(residues.text(residues.name(residue))), Value(residues.chain(residue)));
    let (number, insertion_code) = residues.number(residue);
    write!(out, "{group} {} {symbol} {name} {altloc} {comp} ", serial.saturating_add(shift))?;
    write!(out, "{} ? {} ", Value(residues.label_chain(residue)), Sequence(residues.label_number(residue)))?;
    let [x, y, z] = Position::new(&frame.positions, atom)?.numbers(0);
    write!(out, "{} {x} {y} {z} ", Code(insertion_code))?;
    write!(out, "{} {} ", Number(structure.occupancy(atom)), Number(structure.b_factor(atom)))?;
    match structure.formal_charge(atom) {
        0 => out.write_all(b"?")?,
        charge => write!(out, "{charge}")?,
    }
    write!(out, " {number} {comp} {chain} {name} {model}")
}

/// Residues and names as they are written: those of the structure, or made up where it has none.
#[derive(Debug)]
pub(super) struct Residues<'a> {
    structure: &'a Structure,
    /// Names of the structure and those made up.
    names: Names,
    atom_names: Vec<NameId>,
    /// The name of the one residue of a structure without.
    own: Option<NameId>,
    label_chains: Vec<String>,
    label_numbers: Vec<Option<u32>>,
    /// Whether the atom can be told by its names.
    unique: Vec<bool>,
    has_unique_serials: bool,
}

impl<'a> Residues<'a> {
    fn new(structure: &'a Structure) -> Residues<'a> {
        let mut names = structure.names.clone();
        let mut made = AtomNames::new(structure);
        let atom_names: Vec<NameId> = (0..structure.atom_count())
            .map(|atom| match (made.next(atom), structure.atom_name.get(atom)) {
                (_, Some(&id)) if !structure.name(id).is_empty() => id,
                (name, _) => names.intern(&name),
            })
            .collect();
        let own = structure.residues().is_empty().then(|| names.intern("UNL"));
        let serials: HashSet<i32> = (0..structure.atom_count()).map(|atom| structure.serial(atom)).collect();
        let mut residues = Residues {
            structure,
            names,
            atom_names,
            own,
            label_chains: Vec::new(),
            label_numbers: Vec::new(),
            unique: Vec::new(),
            has_unique_serials: serials.len() == structure.atom_count(),
        };
        residues.label();
        residues.find_unique();
        residues
    }

    /// Label identifiers: see the module.
    fn label(&mut self) {
        let mut counts: HashMap<u32, u32> = HashMap::new();
        for residue in 0..self.count() {
            let hetero = self.atoms(residue).all(|atom| self.structure.flags(atom) & atom_flags::HETERO != 0);
            let chain = self.chain(residue).to_owned();
            let Some(this) = self.structure.residues().get(residue as usize) else {
                self.label_chains.push(chain);
                self.label_numbers.push(None);
                continue;
            };
            let count = counts.entry(this.chain).or_default();
            *count += u32::from(!hetero);
            self.label_numbers.push((!hetero).then_some(*count));
            let twin = |last: &crate::structure::Residue| {
                (last.chain, last.number, last.insertion_code, last.name)
                    == (this.chain, this.number, this.insertion_code, this.name)
            };
            let last = residue.checked_sub(1).map(|last| last as usize);
            let follows = last.and_then(|last| self.structure.residues().get(last)).is_some_and(twin);
            let same_label = follows && last.is_some_and(|last| self.label_chains[last] == chain);
            self.label_chains.push(if same_label { format!("{chain}-2") } else { chain });
        }
    }

    fn find_unique(&mut self) {
        // Chains, residue, atom: what a row of `_struct_conn` says.
        type Key<'k> = ((&'k str, &'k str), (i32, u8, NameId), (NameId, u8));
        let mut seen: HashMap<Key<'_>, u32> = HashMap::new();
        let mut unique = vec![true; self.structure.atom_count()];
        for (atom, &name) in self.atom_names.iter().enumerate() {
            let residue = self.index(atom);
            let (number, code) = self.number(residue);
            let chains = (self.chain(residue), self.label_chain(residue));
            let altloc = self.structure.altloc(atom);
            let key = (chains, (number, code, self.name(residue)), (name, altloc));
            if let Some(&first) = seen.get(&key) {
                unique[first as usize] = false;
                unique[atom] = false;
            } else {
                seen.insert(key, u32::try_from(atom).unwrap_or(u32::MAX));
            }
        }
        self.unique = unique;
    }

    fn count(&self) -> u32 {
        u32::try_from(self.structure.residues().len().max(1)).unwrap_or(u32::MAX)
    }

    fn index(&self, atom: usize) -> u32 {
        u32::try_from(self.structure.residue_index(atom).unwrap_or(0)).unwrap_or(0)
    }

    fn atoms(&self, residue: u32) -> std::ops::Range<usize> {
        let all = self.structure.residues();
        let start = |index: usize| all.get(index).map(|residue| residue.first_atom as usize);
        let first = start(residue as usize).unwrap_or(0);
        first..start(residue as usize + 1).unwrap_or(self.structure.atom_count())
    }

    fn text(&self, id: NameId) -> &str {
        self.names.get(id)
    }

    fn find(&self, text: &str) -> Option<NameId> {
        self.names.find(text)
    }

    fn name(&self, residue: u32) -> NameId {
        let own = self.own.unwrap_or_default();
        self.structure.residues().get(residue as usize).map_or(own, |residue| residue.name)
    }

    fn atom_name(&self, atom: usize) -> NameId {
        self.atom_names[atom]
    }

    fn chain(&self, residue: u32) -> &str {
        let residue = self.structure.residues().get(residue as usize);
        residue.map_or("A", |residue| {
            self.structure.chains.get(residue.chain as usize).map_or("", |&id| self.structure.name(id))
        })
    }

    fn number(&self, residue: u32) -> (i32, u8) {
        self.structure
            .residues()
            .get(residue as usize)
            .map_or((1, b' '), |residue| (residue.number, residue.insertion_code))
    }

    fn label_chain(&self, residue: u32) -> &str {
        self.label_chains.get(residue as usize).map_or("", String::as_str)
    }

    fn label_number(&self, residue: u32) -> Option<u32> {
        self.label_numbers.get(residue as usize).copied().flatten()
    }

    /// Whether two atoms are in the same alternative, or at least one of them in all.
    fn may_meet(&self, a: u32, b: u32) -> bool {
        let [a, b] = [a, b].map(|atom| self.structure.altloc(atom as usize));
        a == b || a == b' ' || b == b' '
    }

    fn is_unique(&self, atom: usize) -> bool {
        self.unique.get(atom).copied().unwrap_or(false)
    }
}

#[cfg(test)]
mod tests;
