//! Our own JSON: everything about the atoms and bonds of one molecule, in file order, one atom or bond a line.
//!
//! ```json
//! {"title":"water","atoms":[
//! {"element":"O","position":[0.000,0.000,0.117],"charge":0},
//! {"element":"H","position":[0.000,0.757,-0.470],"charge":0}
//! ],"bonds":[
//! {"atoms":[0,1],"order":1,"kind":"covalent","aromatic":false,"source":"distance"}
//! ],"cell":null}
//! ```
//!
//! - Positions are in ångström and have as many decimals as the file they came from, so that they read back equal.
//! - An atom has `element` (`X` for what is no element), `position` and `charge` (formal); and, only where it differs
//!   from what is said here, `name`, `residue` (its name), `residue_number`, `insertion_code`, `chain`, `serial` (1-based
//!   index), `altloc`, `occupancy` (1), `b_factor` (0), `isotope` (natural mixture), `radical` (0), `partial_charge`,
//!   `hetero` (false), `particle` (lone pairs, dummies: true for `X`, false for all else).
//! - A bond has `atoms` (0-based), `order` (0 unknown or none, 1–4; aromatic bonds have that of a Kekulé form), `kind`
//!   (covalent, coordination, dative, hydrogen), `aromatic`, `source` (file, link, dictionary, distance); `image`
//!   only if it is not all 0: the cell vectors to add to the second atom.
//! - `cell` is null or has `a`, `b`, `c` (Å), `alpha`, `beta`, `gamma` (degrees); and `vectors`, the three vectors in
//!   ångström, which then hold, only where the six numbers do not give them to the last digit (**a** along x, **b** in the xy plane).
//! - `title` is there only if there is one.

use super::formats::{Part, StructureFormat, title};
use super::tidy;
use crate::element::Element;
use crate::structure::{Bond, Cell, Structure, atom_flags};
use std::fmt::Display;
use std::io::{self, Write};

/// The format's line in the table.
pub static FORMAT: StructureFormat = StructureFormat {
    name: "json",
    extensions: &["json"],
    description: "our own JSON: atoms, bonds, cell (first frame)",
    all_frames: false,
    holds: &[
        Part::Title,
        Part::Bonds,
        Part::CoordinationBonds,
        Part::DativeBonds,
        Part::HydrogenBonds,
        Part::PeriodicBonds,
        Part::Cell,
        Part::AtomNames,
        Part::Serials,
        Part::Residues,
        Part::AtomKinds,
        Part::Particles,
        Part::Altlocs,
        Part::Occupancies,
        Part::BFactors,
        Part::FormalCharges,
        Part::PartialCharges,
        Part::HydrogenIsotopes,
        Part::Isotopes,
        Part::Radicals,
    ],
    limits: super::formats::no_limits,
    write: |records, out| records.first().map_or(Ok(()), |structure| write(structure, out)),
};

/// Writes the first frame of a structure.
///
/// # Errors
/// What the writer returns, and `InvalidData` for a position that is not a number (JSON has none for it).
pub fn write(structure: &Structure, out: &mut dyn Write) -> io::Result<()> {
    out.write_all(b"{")?;
    let title = title(structure);
    if !title.is_empty() {
        write!(out, "\"title\":{},", Text(title))?;
    }
    out.write_all(b"\"atoms\":[")?;
    let has_serials = Part::Serials.is_in(structure);
    for atom in 0..structure.atom_count() {
        out.write_all(if atom == 0 { b"\n" } else { b",\n" })?;
        write_atom(structure, atom, has_serials, out)?;
    }
    out.write_all(b"\n],\"bonds\":[")?;
    for (index, bond) in structure.bonds().iter().enumerate() {
        out.write_all(if index == 0 { b"\n" } else { b",\n" })?;
        write_bond(bond, out)?;
    }
    out.write_all(b"\n],\"cell\":")?;
    match structure.cell() {
        Some(cell) => write_cell(cell, out)?,
        None => out.write_all(b"null")?,
    }
    out.write_all(b"}\n")
}

fn write_atom(structure: &Structure, atom: usize, has_serials: bool, out: &mut dyn Write) -> io::Result<()> {
    let positions = structure.positions();
    let p = positions.written(atom);
    if !p.is_finite() {
        let message = format!("the position of atom {} is not a number, which JSON cannot hold", atom + 1);
        return Err(io::Error::new(io::ErrorKind::InvalidData, message));
    }
    let p = p + 0.0; // −0 to 0
    write!(out, "{{\"element\":\"{}\",\"position\":", structure.elements()[atom])?;
    match positions.decimals() {
        crate::structure::Positions::MAX_DECIMALS => write!(out, "[{},{},{}]", p.x, p.y, p.z)?,
        decimals => {
            let digits = usize::from(decimals);
            write!(out, "[{:.digits$},{:.digits$},{:.digits$}]", p.x, p.y, p.z)?;
        }
    }
    write!(out, ",\"charge\":{}", structure.formal_charge(atom))?;
    let mut optional = |present: bool, key: &str, value: &dyn Display| {
        if present { write!(out, ",\"{key}\":{value}") } else { Ok(()) }
    };
    let name = structure.atom_name(atom);
    optional(!name.is_empty(), "name", &Text(name))?;
    optional(has_serials, "serial", &structure.serial(atom))?;
    if let Some(residue) = structure.residue_index(atom).and_then(|index| structure.residues().get(index)) {
        let chain = structure.chains().nth(residue.chain as usize).unwrap_or("");
        optional(true, "residue", &Text(structure.name(residue.name)))?;
        optional(true, "residue_number", &residue.number)?;
        optional(residue.insertion_code != b' ', "insertion_code", &Code(residue.insertion_code))?;
        optional(true, "chain", &Text(chain))?;
    }
    optional(structure.altloc(atom) != b' ', "altloc", &Code(structure.altloc(atom)))?;
    optional(structure.occupancy(atom) != 1.0, "occupancy", &Number(structure.occupancy(atom)))?;
    optional(structure.b_factor(atom) != 0.0, "b_factor", &Number(structure.b_factor(atom)))?;
    optional(structure.isotope(atom) != 0, "isotope", &structure.isotope(atom))?;
    optional(structure.radical(atom) != 0, "radical", &structure.radical(atom))?;
    if let Some(charge) = structure.partial_charge(atom) {
        optional(true, "partial_charge", &Number(charge))?;
    }
    let flags = structure.flags(atom);
    optional(flags & atom_flags::HETERO != 0, "hetero", &true)?;
    // Readers take what has no element for a particle, and what has one for an atom.
    let particle = flags & atom_flags::PARTICLE != 0;
    optional(particle != (structure.elements()[atom] == Element::DUMMY), "particle", &particle)?;
    out.write_all(b"}")
}

fn write_bond(bond: &Bond, out: &mut dyn Write) -> io::Result<()> {
    let (a, b, order) = (bond.a, bond.b, bond.order.number());
    let (kind, aromatic, source) = (bond.kind.name(), bond.aromatic, bond.source.name());
    write!(
        out,
        "{{\"atoms\":[{a},{b}],\"order\":{order},\"kind\":\"{kind}\",\"aromatic\":{aromatic},\"source\":\"{source}\""
    )?;
    if bond.is_periodic() {
        let [h, k, l] = bond.image;
        write!(out, ",\"image\":[{h},{k},{l}]")?;
    }
    out.write_all(b"}")
}

fn write_cell(cell: &Cell, out: &mut dyn Write) -> io::Result<()> {
    let [a, b, c] = cell.lengths().map(tidy);
    let [alpha, beta, gamma] = cell.angles_deg().map(tidy);
    write!(out, "{{\"a\":{a},\"b\":{b},\"c\":{c},\"alpha\":{alpha},\"beta\":{beta},\"gamma\":{gamma}")?;
    if Cell::from_parameters([a, b, c], [alpha, beta, gamma]).as_ref() != Some(cell) {
        let [a, b, c] = cell.vectors().map(|v| format!("[{},{},{}]", v.x, v.y, v.z));
        write!(out, ",\"vectors\":[{a},{b},{c}]")?;
    }
    out.write_all(b"}")
}

/// A JSON string.
pub(super) struct Text<'a>(pub(super) &'a str);

impl Display for Text<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&serde_json::to_string(self.0).map_err(|_| std::fmt::Error)?)
    }
}

/// A one-character code as a JSON string.
struct Code(u8);

impl Display for Code {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        Text(char::from(self.0).encode_utf8(&mut [0; 4])).fmt(f)
    }
}

/// A JSON number, null for what JSON has no number for.
pub(super) struct Number(pub(super) f32);

impl Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0.is_finite() { self.0.fmt(f) } else { f.write_str("null") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::tests::written;
    use crate::structure::{AtomRecord, BondKind, BondOrder, BondSource, Diagnostics, StructureBuilder};
    use glam::DVec3;
    use serde_json::{Value, json};

    fn text(structure: &Structure) -> String {
        written(|out| write(structure, out))
    }

    fn value(structure: &Structure) -> Value {
        serde_json::from_str(&text(structure)).unwrap()
    }

    #[test]
    fn a_plain_molecule_has_the_plain_keys_and_its_own_digits() {
        let mut builder = StructureBuilder::new();
        builder.set_decimals(3);
        builder.push_atom(&AtomRecord {
            element: Element::O,
            position: DVec3::new(1.5, -0.0, 0.117),
            ..AtomRecord::default()
        });
        builder.push_atom(&AtomRecord { element: Element::H, formal_charge: 1, ..AtomRecord::default() });
        builder.push_bond(Bond {
            kind: BondKind::Dative,
            aromatic: true,
            ..Bond::new(1, 0, BondOrder::Double, BondSource::Link)
        });
        let text = text(&builder.build(&mut Diagnostics::default()));
        let expected = concat!(
            "{\"atoms\":[\n",
            "{\"element\":\"O\",\"position\":[1.500,0.000,0.117],\"charge\":0},\n",
            "{\"element\":\"H\",\"position\":[0.000,0.000,0.000],\"charge\":1}\n",
            "],\"bonds\":[\n",
            "{\"atoms\":[0,1],\"order\":2,\"kind\":\"dative\",\"aromatic\":true,\"source\":\"link\"}\n",
            "],\"cell\":null}\n"
        );
        assert_eq!(text, expected);
    }

    #[test]
    fn nothing_at_all_is_still_valid() {
        let empty = StructureBuilder::new().build(&mut Diagnostics::default());
        assert_eq!(value(&empty), json!({"atoms": [], "bonds": [], "cell": null}));
    }

    #[test]
    fn everything_a_file_can_say_of_an_atom_is_there() {
        let mut builder = StructureBuilder::new();
        builder.set_title("a \"quoted\"\nname");
        builder.set_decimals(7);
        builder.push_atom(&AtomRecord {
            element: Element::C,
            position: DVec3::new(0.1, 1e-7, 12_345.678_9),
            name: "CA",
            serial: Some(42),
            residue: Some(("A", -3, b'B', "ALA")),
            flags: atom_flags::HETERO | atom_flags::PARTICLE,
            altloc: b'B',
            occupancy: 0.35,
            b_factor: 12.5,
            formal_charge: -2,
            partial_charge: Some(-0.125),
            isotope: 13,
            radical: 2,
        });
        let got = value(&builder.build(&mut Diagnostics::default()));
        let expected = json!({
            "title": "a \"quoted\"\nname",
            "atoms": [{
                "element": "C", "position": [0.1, 1e-7, 12345.6789], "charge": -2, "name": "CA", "serial": 42,
                "residue": "ALA", "residue_number": -3, "chain": "A", "insertion_code": "B", "altloc": "B",
                "occupancy": 0.35, "b_factor": 12.5, "isotope": 13, "radical": 2, "partial_charge": -0.125,
                "hetero": true, "particle": true
            }],
            "bonds": [], "cell": null
        });
        assert_eq!(got, expected);
    }

    #[test]
    fn what_is_not_usual_of_particles_and_images_is_said() {
        let mut builder = StructureBuilder::new();
        builder.push_atom(&AtomRecord::default());
        builder.push_atom(&AtomRecord { flags: atom_flags::PARTICLE, ..AtomRecord::default() });
        let bond = Bond::new(0, 1, BondOrder::Single, BondSource::Distance);
        builder.push_bond(Bond { image: [0, -1, 2], ..bond });
        let got = value(&builder.build(&mut Diagnostics::default()));
        assert_eq!((&got["atoms"][0]["particle"], got["atoms"][1].get("particle")), (&json!(false), None));
        assert_eq!(got["bonds"][0]["image"], json!([0, -1, 2]));
    }

    #[test]
    fn ten_decimals_survive() {
        let mut builder = StructureBuilder::new();
        builder.set_decimals(10);
        let position = DVec3::new(0.123_456_789_1, -98.765_432_101_2, 3.0);
        builder.push_atom(&AtomRecord { element: Element::C, position, ..AtomRecord::default() });
        let text = text(&builder.build(&mut Diagnostics::default()));
        assert!(text.contains("[0.1234567891,-98.7654321012,3.0000000000]"), "{text}");
    }

    #[test]
    fn a_cell_in_standard_orientation_is_six_numbers_and_any_other_has_its_vectors() {
        let with_cell = |cell: Option<Cell>| {
            let mut builder = StructureBuilder::new();
            builder.set_cell(cell);
            value(&builder.build(&mut Diagnostics::default()))["cell"].clone()
        };
        let standard = Cell::from_parameters([10.0, 11.5, 7.25], [92.5, 101.25, 118.0]);
        let expected = json!({"a": 10.0, "b": 11.5, "c": 7.25, "alpha": 92.5, "beta": 101.25, "gamma": 118.0});
        let as_numbers = |value: &Value| -> Vec<f64> {
            ["a", "b", "c", "alpha", "beta", "gamma"].iter().map(|key| value[key].as_f64().unwrap()).collect()
        };
        let got = with_cell(standard);
        assert_eq!(as_numbers(&got), as_numbers(&expected));
        assert!(got.get("vectors").is_none());
        // Primitive face-centred cell: no vector along x.
        let (a, b, c) = (DVec3::new(0.0, 2.0, 2.0), DVec3::new(2.0, 0.0, 2.0), DVec3::new(2.0, 2.0, 0.0));
        let got = with_cell(Cell::from_vectors(a, b, c));
        let vectors = json!([[0, 2, 2], [2, 0, 2], [2, 2, 0]]);
        assert_eq!(got["vectors"], vectors);
        assert_eq!(got["alpha"].as_f64(), Some(60.0));
        // Left-handed, though its lengths and angles are those of a cube.
        assert!(with_cell(Cell::from_vectors(DVec3::X, DVec3::Y, DVec3::NEG_Z)).get("vectors").is_some());
    }

    #[test]
    fn a_position_that_is_no_number_is_an_error_and_never_bad_json() {
        let mut builder = StructureBuilder::new();
        let position = DVec3::new(f64::NAN, 0.0, 0.0);
        builder.push_atom(&AtomRecord { position, ..AtomRecord::default() });
        let structure = builder.build(&mut Diagnostics::default());
        let error = write(&structure, &mut Vec::new()).unwrap_err();
        assert!(error.to_string().contains("atom 1"), "{error}");
    }
}
