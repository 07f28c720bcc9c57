//! The biological assemblies that can be chosen.

use super::state::State;
use crate::crystal::AssemblyId;
use crate::structure::Structure;

/// Assemblies that a list offers (chosen: viruses have about ten).
const MOST: usize = 50;

/// None, and the assemblies of the files in words, each id once; with the one that is asked for, even if no file has it.
pub(super) fn known(state: &State) -> Vec<(Option<AssemblyId>, String)> {
    let mut known = vec![(None, "None".to_owned())];
    let structures = || state.work.layers.iter().filter_map(|layer| layer.document.records.first());
    let is_another = |structure: &Structure| {
        structure.assemblies().iter().any(|assembly| !assembly.is_as_listed(structure.atom_count()))
    };
    let asked = state.work.crystal.assembly;
    // Where all of them are the atoms as listed there is nothing to choose.
    if asked.is_none() && !structures().any(is_another) {
        return known;
    }
    for assembly in structures().flat_map(Structure::assemblies) {
        let id = AssemblyId::new(&assembly.id);
        if id.is_some() && !known.iter().any(|(other, _)| *other == id) {
            let copies = assembly.operations.len();
            let copies = if copies == 1 { "1 copy".to_owned() } else { format!("{copies} copies") };
            known.push((id, format!("{}: {copies}", assembly.id)));
        }
        if known.len() > MOST {
            break;
        }
    }
    if let Some(id) = asked.filter(|_| !known.iter().any(|(other, _)| *other == asked)) {
        known.push((asked, format!("{id}: in no file")));
    }
    known
}
