//! A data block to records: what stands around the atoms.

use super::atoms::AtomSites;
use super::table::{Block, Category, Row, Table};
use super::{assembly, component, crystal, links};
use crate::error::{Error, Result};
use crate::import::collect::Records;
use crate::import::text::Repeated;
use crate::structure::{
    Cell, ComponentBonds, Diagnostics, SecondaryElement, StatedBonds, Structure, StructureBuilder, Symmetry,
};

/// Rows that all records of one block together may take over or look at (helices, bonds, operations): a file of models
/// that all differ must not cost models times rows.
const MAX_COPIES: usize = 10_000_000;
/// Characters of a title that are kept.
const MAX_TITLE: usize = 1000;
/// Decimals kept at least of positions computed from fractional coordinates, in ångström.
const LEAST_DECIMALS: u8 = 6;

/// Puts a block's atoms and everything around them into records: models of the same atoms are frames of one. A block
/// with neither atoms nor components gives nothing.
///
/// # Errors
/// Atoms that cannot be placed, and limits.
pub(in crate::import) fn finish(
    block: &impl Block,
    mut sites: AtomSites,
    records: &mut Records,
    diagnostics: &mut Diagnostics,
) -> Result<()> {
    if sites.is_empty() {
        return match sites.no_position() {
            Some((line, message)) => Err(Error::input((line > 0).then_some(line), message)),
            None => component::read_ligands(block, records, diagnostics),
        };
    }
    sites.report(diagnostics);
    let cell = crystal::cell(block, sites.fractional, diagnostics);
    if sites.fractional {
        let Some(cell) = &cell else {
            return Err(Error::input(
                None,
                "the coordinates are fractional, but the file has no unit cell to place them in",
            ));
        };
        place(&mut sites, cell)?;
    }
    let mut around = Around {
        title: title(block),
        symmetry: crystal::symmetry(block, sites.fractional, diagnostics),
        secondary: secondary(block),
        components: component::bonds(block, diagnostics),
        assemblies: assembly::read(block, diagnostics),
        links: links::read(block, diagnostics),
        states_bonds: block.table(Category::StructConn).is_some() || block.table(Category::ChemCompBond).is_some(),
        copies: MAX_COPIES,
        missing: Repeated::default(),
    };
    let mut record = None;
    for mut model in sites.models {
        if model.builder.atom_count() == 0 {
            continue;
        }
        let mut builder = std::mem::replace(&mut model.builder, StructureBuilder::new());
        builder.set_decimals(sites.decimals);
        builder.set_title(around.title.clone());
        builder.set_cell(cell);
        let structure = builder.build(diagnostics);
        match record {
            None => {
                let structure = around.dress(structure, &model);
                record = records.push_record(structure);
            }
            Some(last) => {
                // What a further frame says beside its positions is what the first one says.
                let Some(index) = records.push_frame(structure) else { continue };
                if index != last {
                    records.update(index, |structure| around.dress(structure, &model));
                    record = Some(index);
                }
            }
        }
    }
    around.missing.warn(diagnostics);
    Ok(())
}

/// Fractional coordinates to ångström.
fn place(sites: &mut AtomSites, cell: &Cell) -> Result<()> {
    let matrix = cell.cartesian_from_fractional();
    // A fraction's last digit is a few hundredths of an ångström over its power of ten: two more digits keep it.
    sites.decimals = sites.decimals.saturating_add(2).max(LEAST_DECIMALS);
    for model in &mut sites.models {
        if !model.builder.map_positions(|fraction| matrix * fraction, crate::import::is_plausible) {
            return Err(Error::input(None, "atoms lie absurdly far away: cell or fractional coordinates are wrong"));
        }
    }
    Ok(())
}

/// What a block says beside its atoms.
struct Around {
    title: String,
    symmetry: Option<Symmetry>,
    secondary: Vec<SecondaryElement>,
    components: Vec<ComponentBonds>,
    assemblies: Vec<assembly::Stated>,
    links: Vec<links::Link>,
    states_bonds: bool,
    copies: usize,
    missing: Repeated,
}

impl Around {
    /// Gives a record all of it.
    fn dress(&mut self, mut structure: Structure, model: &super::atoms::Model) -> Structure {
        let operations = self.symmetry.as_ref().map_or(0, |symmetry| symmetry.operations.len());
        let bonds: usize = self.components.iter().map(|component| component.bonds.len()).sum();
        let assemblies: usize = self.assemblies.iter().map(assembly::Stated::cost).sum();
        let cost = self.secondary.len() + bonds + self.links.len() + operations + assemblies;
        if cost > self.copies {
            self.missing.note(0, || {
                "too many differing models: bonds, helices, symmetry and assemblies of the later ones are left out"
                    .to_owned()
            });
            return structure;
        }
        self.copies -= cost;
        structure.symmetry = self.symmetry.clone();
        structure.secondary = self.secondary.clone();
        structure.components = self.components.clone();
        structure.assemblies = assembly::resolve(&self.assemblies, &structure, &model.labels, &model.label_names);
        if self.states_bonds {
            structure.stated_bonds = StatedBonds::Partial;
        }
        let bonds = links::resolve(&self.links, &structure, &model.labels, &model.label_names, &mut self.missing);
        structure.with_bonds(bonds)
    }
}

/// A text of perhaps many lines as one, not too long.
pub(super) fn one_line(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    words.join(" ").chars().take(MAX_TITLE).collect()
}

fn title(block: &impl Block) -> String {
    let candidates = [
        (Category::Struct, "title"),
        (Category::Chemical, "name_common"),
        (Category::Chemical, "name_mineral"),
        (Category::Chemical, "name_systematic"),
        (Category::Entry, "id"),
    ];
    let found = candidates.iter().find_map(|&(category, item)| {
        let table = block.table(category).filter(|table| table.row_count() > 0)?;
        let text = one_line(&table.row(0).text(table.column(item))?);
        (!matches!(text.as_str(), "" | "?" | ".")).then_some(text)
    });
    found.unwrap_or_else(|| one_line(&block.name()))
}

/// Helices of `_struct_conf` (where programs list strands as well) and strands of `_struct_sheet_range`.
fn secondary(block: &impl Block) -> Vec<SecondaryElement> {
    let mut elements = Vec::new();
    for category in [Category::StructConf, Category::StructSheetRange] {
        let Some(table) = block.table(category) else { continue };
        let kind = table.column("conf_type_id");
        let [chain, label_chain] = ["beg_auth_asym_id", "beg_label_asym_id"].map(|item| table.column(item));
        let ends = ["beg", "end"].map(|end| {
            [format!("{end}_auth_seq_id"), format!("{end}_label_seq_id"), format!("pdbx_{end}_PDB_ins_code")]
                .map(|item| table.column(&item))
        });
        for index in 0..table.row_count() {
            let row = table.row(index);
            let helix = match category {
                Category::StructConf => match row.text(kind).map(|kind| kind.to_ascii_uppercase()) {
                    Some(kind) if kind.starts_with("HELX") => true,
                    Some(kind) if kind.starts_with("STRN") => false,
                    _ => continue, // turns and bends
                },
                _ => false,
            };
            let [first, last] = ends.map(|[number, label, insertion]| {
                let number = row.integer(number).or_else(|| row.integer(label))?;
                let code = row.text(insertion).and_then(|code| code.bytes().next()).unwrap_or(b' ');
                Some((i32::try_from(number).ok()?, code))
            });
            let chain = row.text(chain).or_else(|| row.text(label_chain));
            if let (Some(first), Some(last), Some(chain)) = (first, last, chain) {
                elements.push(SecondaryElement { helix, chain: chain.into_owned(), first, last });
            }
        }
    }
    elements
}
