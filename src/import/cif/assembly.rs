//! `_pdbx_struct_assembly`, `_pdbx_struct_assembly_gen`, `_pdbx_struct_oper_list`: biological assemblies.
//!
//! A row of the second says: apply these operations (`oper_expression`) to these chains (`asym_id_list`, label identifiers). An
//! expression is lists of names and ranges of numbers, `1,2,5-8`; of several in parentheses, `(X0)(1-60)`, every operation of the left one
//! is applied behind every one of the right one (PDBx/mmCIF dictionary, `_pdbx_struct_assembly_gen.oper_expression`).

use super::atoms::ResidueLabel;
use super::block::one_line;
use super::table::{Block, Category, Row, Table};
use crate::import::text::{Repeated, shown};
use crate::structure::{Assembly, Diagnostics, Names, Structure, is_rigid};
use glam::{DAffine3, DMat3, DVec3};
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// Operations of all assemblies of an entry together, products written out. Chosen: the largest viruses have some 1,700
/// (60 × 28), and every one is 96 bytes.
const MAX_OPERATIONS: usize = 50_000;
/// Rows of `_pdbx_struct_assembly_gen` that are read. Chosen: entries have some tens.
const MAX_PARTS: usize = 1000;
/// Chains that all rows together may name.
const MAX_CHAINS: usize = 1_000_000;

/// What the file says of one assembly.
#[derive(Debug, Default)]
pub(super) struct Stated {
    id: String,
    description: String,
    /// Chains, and what is applied to them.
    parts: Vec<(Vec<String>, Vec<DAffine3>)>,
}

impl Stated {
    /// How much a record takes over.
    pub(super) fn cost(&self) -> usize {
        self.parts.iter().map(|(chains, operations)| 1 + chains.len() + operations.len()).sum()
    }
}

/// The assemblies of a block. What cannot be understood is left out with a warning, the whole assembly with it: half a
/// capsid would look like another one.
pub(super) fn read(block: &impl Block, diagnostics: &mut Diagnostics) -> Vec<Stated> {
    let Some(table) = block.table(Category::StructAssemblyGen) else { return Vec::new() };
    let mut odd = Repeated::default();
    let operations = operations(block, &mut odd);
    let mut stated = descriptions(block);
    let mut number_of: HashMap<String, usize> =
        stated.iter().enumerate().map(|(index, one)| (one.id.clone(), index)).collect();
    let mut is_spoilt: HashSet<usize> = HashSet::new();
    let (mut room, mut chain_room) = (MAX_OPERATIONS, MAX_CHAINS);
    let [id, expression, chains] = ["assembly_id", "oper_expression", "asym_id_list"].map(|item| table.column(item));
    for index in 0..table.row_count() {
        let row = table.row(index);
        let line = row.line().unwrap_or(0);
        let id = row.text(id).map_or_else(|| "1".to_owned(), |id| one_line(&id));
        let number = *number_of.entry(id.clone()).or_insert_with(|| {
            stated.push(Stated { id: id.clone(), ..Stated::default() });
            stated.len() - 1
        });
        let text = row.text(expression).unwrap_or_default().into_owned();
        let named = chain_list(&row.text(chains).unwrap_or_default());
        if index >= MAX_PARTS || named.len() > chain_room {
            odd.note(line, || "there are too many assemblies; the rest of them is left out".to_owned());
            is_spoilt.insert(number);
            break;
        }
        match expand(&text, &operations, room) {
            Ok(all) => {
                room -= all.len();
                chain_room -= named.len();
                stated[number].parts.push((named, all));
            }
            Err(why) => {
                is_spoilt.insert(number);
                odd.note(line, || format!("the assembly {} is left out: {why}", shown(id.as_bytes())));
            }
        }
    }
    odd.warn(diagnostics);
    let mut index = 0;
    stated.retain(|one| {
        index += 1;
        !is_spoilt.contains(&(index - 1)) && !one.parts.is_empty()
    });
    stated
}

/// Ids and descriptions.
fn descriptions(block: &impl Block) -> Vec<Stated> {
    let Some(table) = block.table(Category::StructAssembly) else { return Vec::new() };
    let [id, details, oligomer] = ["id", "details", "oligomeric_details"].map(|item| table.column(item));
    let mut seen = HashSet::new();
    let stated = (0..table.row_count().min(MAX_PARTS)).filter_map(|index| {
        let row = table.row(index);
        let id = one_line(&row.text(id)?);
        let words = [details, oligomer].map(|column| row.text(column).map(|text| one_line(&text.replace('_', " "))));
        let description: Vec<String> = words.into_iter().flatten().filter(|text| !text.is_empty()).collect();
        let is_new = seen.insert(id.clone());
        is_new.then(|| Stated { id, description: description.join(", "), parts: Vec::new() })
    });
    stated.collect()
}

/// The operations by their names; one that is no rigid motion is left out with a warning, and so will be what asks for it.
fn operations(block: &impl Block, odd: &mut Repeated) -> HashMap<String, DAffine3> {
    let mut operations = HashMap::new();
    let Some(table) = block.table(Category::StructOperList) else { return operations };
    let id = table.column("id");
    let cell = |i: usize, j: usize| table.column(&format!("matrix[{i}][{j}]"));
    let columns = [1, 2, 3].map(|j| [1, 2, 3].map(|i| cell(i, j)));
    let shift = [1, 2, 3].map(|i| table.column(&format!("vector[{i}]")));
    for index in 0..table.row_count() {
        let row = table.row(index);
        let Some(id) = row.text(id) else { continue };
        let vector = |columns: [usize; 3]| {
            let [x, y, z] = columns.map(|column| row.number(column).map(|(value, _)| value));
            Some(DVec3::new(x?, y?, z?))
        };
        let [x, y, z] = columns.map(vector);
        let motion = x
            .zip(y)
            .zip(z)
            .zip(vector(shift))
            .map(|(((x, y), z), shift)| DAffine3 { matrix3: DMat3::from_cols(x, y, z), translation: shift });
        match motion.filter(is_rigid) {
            Some(motion) if operations.len() < MAX_OPERATIONS => {
                operations.entry(id.into_owned()).or_insert(motion);
            }
            Some(_) => odd.note(row.line().unwrap_or(0), || format!("only {MAX_OPERATIONS} operations are kept")),
            None => odd.note(row.line().unwrap_or(0), || {
                let name = shown(id.as_bytes());
                format!(
                    "operation {name} of _pdbx_struct_oper_list is no rotation or reflection with a shift (twelve numbers whose \
                     matrix keeps distances); it is left out"
                )
            }),
        }
    }
    operations
}

/// The chains of a list, each once.
fn chain_list(text: &str) -> Vec<String> {
    let mut seen = HashSet::new();
    let names = text.split(',').map(str::trim).filter(|name| !name.is_empty());
    names.filter(|name| seen.insert(*name)).map(str::to_owned).collect()
}

/// All operations of an expression, at most `room` of them.
fn expand(text: &str, known: &HashMap<String, DAffine3>, room: usize) -> Result<Vec<DAffine3>, String> {
    let odd = || {
        let found = shown(text.trim().as_bytes());
        format!("`{found}` is no list of operations (expected one like 1,2 or (1-60) or (X0)(1-5,7))")
    };
    let mut lists = Vec::new();
    let mut rest = text.trim();
    if !rest.starts_with('(') {
        lists.push(rest);
        rest = "";
    }
    while !rest.is_empty() {
        let (list, behind) = rest.strip_prefix('(').and_then(|rest| rest.split_once(')')).ok_or_else(odd)?;
        lists.push(list);
        rest = behind.trim_start();
    }
    let mut all = vec![DAffine3::IDENTITY];
    for list in lists {
        let own = names(list, known, room).ok_or_else(odd)??;
        if all.len().saturating_mul(own.len()) > room {
            return Err(format!("there are more than {MAX_OPERATIONS} operations in all"));
        }
        all = all.iter().flat_map(|left| own.iter().map(move |right| *left * *right)).collect();
    }
    Ok(all)
}

/// The operations of a list such as `1,2,5-8`; `None` for what is no list, an error for a name that means nothing.
fn names(list: &str, known: &HashMap<String, DAffine3>, room: usize) -> Option<Result<Vec<DAffine3>, String>> {
    let mut found = Vec::new();
    let mut add = |name: &str| match known.get(name) {
        Some(_) if found.len() >= room => Err(format!("there are more than {MAX_OPERATIONS} operations in all")),
        Some(operation) => {
            found.push(*operation);
            Ok(())
        }
        None => Err(format!("there is no operation {} in _pdbx_struct_oper_list", shown(name.as_bytes()))),
    };
    for part in list.split(',').map(str::trim) {
        if part.is_empty() || part.contains(['(', ')']) {
            return None;
        }
        let range = part
            .split_once('-')
            .and_then(|(first, last)| Some((first.trim().parse::<u32>().ok()?, last.trim().parse::<u32>().ok()?)));
        let outcome = match range {
            // A name with a dash is a name where there is one.
            Some((first, last)) if !known.contains_key(part) => {
                (first..=last).try_for_each(|number| add(&number.to_string()))
            }
            _ => add(part),
        };
        if let Err(why) = outcome {
            return Some(Err(why));
        }
    }
    Some(Ok(found))
}

/// The assemblies of a structure. Residues without a label belong to the chain that they are shown in.
pub(super) fn resolve(
    stated: &[Stated],
    structure: &Structure,
    labels: &[ResidueLabel],
    label_names: &Names,
) -> Vec<Assembly> {
    if stated.is_empty() {
        return Vec::new();
    }
    let mut runs: HashMap<&str, Vec<Range<u32>>> = HashMap::new();
    let residues = structure.residues();
    let chains: Vec<&str> = structure.chains().collect();
    let atom_count = u32::try_from(structure.atom_count()).unwrap_or(u32::MAX);
    for (index, residue) in residues.iter().enumerate() {
        let label = labels.get(index).map_or("", |label| label_names.get(label.chain));
        let own = || chains.get(residue.chain as usize).copied().unwrap_or("");
        let chain = if label.is_empty() { own() } else { label };
        let end = residues.get(index + 1).map_or(atom_count, |next| next.first_atom);
        let runs = runs.entry(chain).or_default();
        match runs.last_mut() {
            Some(last) if last.end == residue.first_atom => last.end = end,
            _ => runs.push(residue.first_atom..end),
        }
    }
    let resolved = stated.iter().map(|one| {
        let mut assembly = Assembly::new(&one.id, &one.description);
        for (chains, operations) in &one.parts {
            let mut atoms: Vec<Range<u32>> =
                chains.iter().filter_map(|chain| runs.get(chain.as_str())).flatten().cloned().collect();
            atoms.sort_unstable_by_key(|run| run.start);
            atoms.dedup_by(|next, last| {
                let joins = last.end == next.start;
                last.end = if joins { next.end } else { last.end };
                joins
            });
            assembly.push(atoms, operations);
        }
        assembly
    });
    resolved.filter(|assembly| !assembly.parts.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::{Document, ImportOptions};

    const HEAD: &str = "data_x\nloop_\n_atom_site.group_PDB\n_atom_site.type_symbol\n_atom_site.label_atom_id\n\
        _atom_site.label_comp_id\n_atom_site.label_asym_id\n_atom_site.label_seq_id\n_atom_site.auth_asym_id\n_atom_site.Cartn_x\n\
        _atom_site.Cartn_y\n_atom_site.Cartn_z\nATOM N N GLY A 1 X 1 2 3\nATOM C CA GLY A 1 X 2 2 3\nATOM N N GLY B 1 Y 5 2 3\n\
        HETATM O O HOH C . X 9 2 3\n#\nloop_\n_pdbx_struct_oper_list.id\n_pdbx_struct_oper_list.type\n";

    fn with(operations: &str, rows: &str) -> Document {
        let mut text = HEAD.to_owned();
        for i in 1..=3 {
            for j in 1..=3 {
                text += &format!("_pdbx_struct_oper_list.matrix[{i}][{j}]\n");
            }
            text += &format!("_pdbx_struct_oper_list.vector[{i}]\n");
        }
        text += operations;
        text += "#\nloop_\n_pdbx_struct_assembly.id\n_pdbx_struct_assembly.details\n_pdbx_struct_assembly.oligomeric_details\n\
            1 author_defined_assembly dimeric\n2 'complete point assembly' ?\n#\nloop_\n_pdbx_struct_assembly_gen.assembly_id\n\
            _pdbx_struct_assembly_gen.oper_expression\n_pdbx_struct_assembly_gen.asym_id_list\n";
        text += rows;
        crate::import::read_bytes(text.as_bytes(), "x.cif", &ImportOptions::default()).unwrap()
    }

    /// 1 is the identity, 2 to 4 shift by 10 to 30 Å along x, P turns by 180° about z.
    const OPERATIONS: &str = "1 'identity operation' 1 0 0 0 0 1 0 0 0 0 1 0\n2 p 1 0 0 10 0 1 0 0 0 0 1 0\n\
        3 p 1 0 0 20 0 1 0 0 0 0 1 0\n4 p 1 0 0 30 0 1 0 0 0 0 1 0\nP p -1 0 0 0 0 -1 0 0 0 0 1 0\n";

    #[test]
    fn chains_are_those_of_labels_and_products_apply_the_right_one_first() {
        let document = with(OPERATIONS, "1 1,2 A,C\n1 1 B\n2 '(P)(1-3)' 'A, B'\n");
        let structure = &document.records[0];
        let [one, two] = structure.assemblies() else { panic!("{:?}", structure.assemblies()) };
        assert_eq!((one.id.as_str(), one.description.as_str()), ("1", "author defined assembly, dimeric"));
        let atoms: Vec<_> = one.parts.iter().map(|part| (part.atoms.clone(), part.operations.clone())).collect();
        assert_eq!(atoms, [(vec![0..2, 3..4], vec![0, 1]), (vec![2..3], vec![0])]);
        assert_eq!((two.parts[0].atoms.clone(), two.operations.len()), (vec![0..3], 3));
        // Shifted by 10 Å first, then turned.
        assert_eq!(two.operations[1].transform_point3(DVec3::new(1.0, 2.0, 3.0)), DVec3::new(-11.0, -2.0, 3.0));
        assert!(document.diagnostics.is_empty());
    }

    #[test]
    fn expressions_of_all_shapes() {
        let known: HashMap<String, DAffine3> = (["X0", "1-a"].map(str::to_owned).into_iter())
            .chain((1..=60).map(|n: u32| n.to_string()))
            .map(|name| (name, DAffine3::IDENTITY))
            .collect();
        let count = |text: &str| expand(text, &known, 1000).map(|all| all.len());
        for (text, number) in [
            ("1", 1),
            ("1,2, 5", 3),
            ("(1-60)", 60),
            ("1-5", 5),
            ("(X0)(1-5,7)", 6),
            ("(1,2)(3-6) (X0)", 8),
            ("1-a", 1),
        ] {
            assert_eq!(count(text), Ok(number), "{text}");
        }
        for (text, word) in [
            ("", "expected"),
            ("()", "expected"),
            ("(1", "expected"),
            ("1)", "expected"),
            ("(1),2", "expected"),
            ("(1-60)(1-60)", "more than"),
            ("1-4000000000", "no operation 61"),
            ("Q", "no operation Q"),
        ] {
            let why = count(text).unwrap_err();
            assert!(why.contains(word), "{text}: {why}");
        }
    }

    #[test]
    fn what_cannot_be_made_is_left_out_whole_and_said() {
        let document = with(OPERATIONS, "1 1 A\n1 9 B\n2 1 B\n");
        let ids: Vec<&str> = document.records[0].assemblies().iter().map(|one| one.id.as_str()).collect();
        assert_eq!((ids, document.diagnostics.len()), (vec!["2"], 1));
        assert!(document.diagnostics[0].message.contains("no operation 9"));
        let sheared = OPERATIONS.replace("2 p 1 0 0 10", "2 p 1 0.5 0 10");
        let document = with(&sheared, "1 2 A\n2 1 B\n");
        assert!(document.diagnostics[0].message.contains("operation 2"), "{:?}", document.diagnostics);
        assert_eq!(document.records[0].assemblies().len(), 1);
    }
}
