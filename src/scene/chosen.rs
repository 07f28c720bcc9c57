//! What of each structure is drawn, and how: switches, alternate locations, and selections.
//!
//! Of selections that say different things of an atom the last one counts. What is hidden is hidden, whatever else is shown.

use super::{AltlocChoice, Item, SceneOptions, Style};
use crate::bonds;
use crate::color::Srgb8;
use crate::element::Element;
use crate::select::{self, Scope, Selection};
use crate::structure::Structure;
use std::collections::HashMap;

/// What selections say.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BySelection {
    /// Only what one of these selects is drawn; everything if there are none.
    pub show: Vec<Selection>,
    /// What is not drawn.
    pub hide: Vec<Selection>,
    /// Colours in place of the scheme's.
    pub colors: Vec<(Selection, Srgb8)>,
    /// Styles in place of [`SceneOptions::style`].
    pub styles: Vec<(Selection, Style)>,
    /// Only what one of these selects has labels; everything if there are none.
    pub labels: Vec<Selection>,
}

impl BySelection {
    /// All selections, each with the flag that it is given by.
    pub fn all(&self) -> impl Iterator<Item = (&'static str, &Selection)> {
        (self.show.iter().map(|one| ("show", one)))
            .chain(self.hide.iter().map(|one| ("hide", one)))
            .chain(self.colors.iter().map(|(one, _)| ("color", one)))
            .chain(self.styles.iter().map(|(one, _)| ("style", one)))
            .chain(self.labels.iter().map(|one| ("label-only", one)))
    }

    /// The same with other selections in place of these.
    #[must_use]
    pub fn map(&self, new: impl Fn(&Selection) -> Selection) -> BySelection {
        BySelection {
            show: self.show.iter().map(&new).collect(),
            hide: self.hide.iter().map(&new).collect(),
            colors: self.colors.iter().map(|(one, color)| (new(one), *color)).collect(),
            styles: self.styles.iter().map(|(one, style)| (new(one), *style)).collect(),
            labels: self.labels.iter().map(&new).collect(),
        }
    }
}

/// What is drawn of one structure, and how.
pub(super) struct Chosen {
    /// Empty for all atoms.
    shown: Vec<bool>,
    /// One an atom.
    pub(super) colors: Vec<Srgb8>,
    /// For every atom the number of the selection that gives its colour, from 1; empty if none does.
    recolored: Vec<u32>,
    /// Empty where all have the same.
    styles: Vec<Style>,
    style: Style,
    /// Empty for all atoms.
    labelled: Vec<bool>,
}

impl Chosen {
    /// Whether an atom is drawn.
    pub(super) fn is_shown(&self, atom: usize) -> bool {
        self.shown.get(atom).is_none_or(|&is| is)
    }

    /// The style of an atom.
    pub(super) fn style(&self, atom: usize) -> Style {
        self.styles.get(atom).copied().unwrap_or(self.style)
    }

    /// The style of a bond: of its atoms' the one with the thinner sticks, so that what is drawn boldly ends with its own atoms, and
    /// the thin end is hidden in the thick one.
    pub(super) fn bond_style(&self, a: u32, b: u32) -> Style {
        self.style(a as usize).thinner(self.style(b as usize))
    }

    /// Whether an atom may have a label.
    pub(super) fn is_labelled(&self, atom: usize) -> bool {
        self.labelled.get(atom).is_none_or(|&is| is)
    }

    /// The number, from 0, of the selection that gives an atom its colour.
    pub(super) fn recolored(&self, atom: usize) -> Option<usize> {
        (self.recolored.get(atom).copied()? as usize).checked_sub(1)
    }
}

/// What is drawn of each item, and the flags whose selections find no atom in any.
pub(super) fn choose(items: &[Item<'_>], options: &SceneOptions) -> (Vec<Chosen>, Vec<String>) {
    let by = &options.by_selection;
    let count = by.all().count();
    let mut has_found = vec![false; count];
    let chosen =
        (items.iter().enumerate()).map(|(index, item)| of_item(item, index, options, &mut has_found)).collect();
    let missing = by.all().zip(has_found).filter(|(_, has_found)| !has_found && !items.is_empty());
    (chosen, missing.map(|((flag, selection), _)| format!("--{flag} {selection}")).collect())
}

fn of_item(item: &Item<'_>, index: usize, options: &SceneOptions, has_found: &mut [bool]) -> Chosen {
    let structure = item.structure;
    let by = &options.by_selection;
    let place = u32::try_from(index + 1).unwrap_or(u32::MAX);
    let scope = Scope { structure, listed: item.listed, file: item.file.unwrap_or(place) };
    // In the order of `BySelection::all`.
    let mut found = has_found.iter_mut();
    let mut atoms = |selection: &Selection| {
        let atoms = selection.atoms(scope);
        if let Some(found) = found.next() {
            *found |= atoms.contains(&true);
        }
        atoms
    };
    let mut any = |selections: &[Selection]| {
        let mut all: Vec<bool> = Vec::new();
        for selection in selections {
            let own = atoms(selection);
            if all.is_empty() {
                all = own;
            } else {
                all.iter_mut().zip(own).for_each(|(is, own)| *is |= own);
            }
        }
        all
    };
    let mut shown = shown_atoms(structure, options).unwrap_or_default();
    let wanted = any(&by.show);
    let unwanted = any(&by.hide);
    if !(wanted.is_empty() && unwanted.is_empty()) {
        shown.resize(structure.atom_count(), true);
        wanted.into_iter().zip(&mut shown).for_each(|(wanted, shown)| *shown &= wanted);
        unwanted.into_iter().zip(&mut shown).for_each(|(unwanted, shown)| *shown &= !unwanted);
    }
    let mut colors = options.color_by.colors(structure);
    let mut recolored = Vec::new();
    for ((selection, color), number) in by.colors.iter().zip(1u32..) {
        recolored.resize(structure.atom_count(), 0);
        for (atom, _) in any(std::slice::from_ref(selection)).into_iter().enumerate().filter(|&(_, is)| is) {
            (colors[atom], recolored[atom]) = (*color, number);
        }
    }
    let mut styles = Vec::new();
    for (selection, style) in &by.styles {
        styles.resize(structure.atom_count(), options.style);
        for (own, _) in styles.iter_mut().zip(any(std::slice::from_ref(selection))).filter(|&(_, is)| is) {
            *own = *style;
        }
    }
    let labelled = any(&by.labels);
    Chosen { shown, colors, recolored, styles, style: options.style, labelled }
}

/// Which atoms are drawn; `None` for all of them.
pub(super) fn shown_atoms(structure: &Structure, options: &SceneOptions) -> Option<Vec<bool>> {
    let mut shown = chosen_altlocs(structure, options.altloc);
    if !options.water {
        let all = || vec![true; structure.atom_count()];
        let waters = bonds::waters(structure);
        shown.get_or_insert_with(all).iter_mut().zip(waters).for_each(|(shown, water)| *shown &= !water);
    }
    if !options.ions {
        let all = || vec![true; structure.atom_count()];
        let ions = select::ions(structure);
        shown.get_or_insert_with(all).iter_mut().zip(ions).for_each(|(shown, ion)| *shown &= !ion);
    }
    if !options.hydrogens {
        let all = || vec![true; structure.atom_count()];
        let elements = structure.elements();
        shown.get_or_insert_with(all).iter_mut().zip(elements).for_each(|(shown, &e)| *shown &= e != Element::H);
    }
    shown
}

/// Whether each atom is of the chosen alternate location; `None` if all are.
fn chosen_altlocs(structure: &Structure, choice: AltlocChoice) -> Option<Vec<bool>> {
    if choice == AltlocChoice::All || !structure.has_altlocs() {
        return None;
    }
    // One alternate a residue position: mixing them atom by atom would join halves of different conformers.
    let site = |atom: usize| {
        structure.residue_index(atom).map(|index| {
            let residue = structure.residues()[index];
            (residue.chain, residue.number, residue.insertion_code)
        })
    };
    let mut occupancy: HashMap<_, Vec<(u8, f64)>> = HashMap::new();
    for atom in (0..structure.atom_count()).filter(|&atom| structure.altloc(atom) != b' ') {
        let codes = occupancy.entry(site(atom)).or_default();
        let code = structure.altloc(atom);
        let weight = f64::from(structure.occupancy(atom));
        match codes.iter_mut().find(|(other, _)| *other == code) {
            Some((_, sum)) => *sum += weight,
            None => codes.push((code, weight)),
        }
    }
    let chosen: HashMap<_, u8> = occupancy
        .into_iter()
        .map(|(site, mut codes)| {
            codes.sort_by(|(code_a, sum_a), (code_b, sum_b)| sum_b.total_cmp(sum_a).then(code_a.cmp(code_b)));
            let wanted = codes.iter().map(|&(code, _)| code).find(|&code| choice == AltlocChoice::Code(code));
            (site, wanted.unwrap_or(codes[0].0))
        })
        .collect();
    let shown =
        |atom: usize| structure.altloc(atom) == b' ' || chosen.get(&site(atom)) == Some(&structure.altloc(atom));
    Some((0..structure.atom_count()).map(shown).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::structure::{AtomRecord, Diagnostics, StructureBuilder};

    fn altloc_structure() -> Structure {
        let mut builder = StructureBuilder::new();
        let residue = Some(("A", 7, b' ', "SER"));
        for (name, altloc, occupancy) in
            [("CA", b' ', 1.0), ("CB", b'A', 0.4), ("CB", b'B', 0.6), ("OG", b'A', 0.4), ("OG", b'B', 0.6)]
        {
            builder.push_atom(&AtomRecord {
                element: Element::C,
                name,
                altloc,
                occupancy,
                residue,
                ..AtomRecord::default()
            });
        }
        builder.build(&mut Diagnostics::default())
    }

    #[test]
    fn one_alternate_location_is_drawn() {
        let structure = altloc_structure();
        let options = |altloc| SceneOptions { altloc, ..SceneOptions::default() };
        let shown = |altloc| shown_atoms(&structure, &options(altloc)).unwrap();
        assert_eq!(shown(AltlocChoice::Highest), [true, false, true, false, true]);
        assert_eq!(shown(AltlocChoice::Code(b'A')), [true, true, false, true, false]);
        assert_eq!(shown(AltlocChoice::Code(b'Z')), [true, false, true, false, true]);
        assert_eq!(shown_atoms(&structure, &options(AltlocChoice::All)), None);
    }

    #[test]
    fn water_and_hydrogens_can_be_left_out() {
        let text = b"8\n\nO 0 0 0\nH 0.96 0 0\nH -0.24 0.93 0\nC 5 0 0\nH 6.09 0 0\nH 4.64 1.03 0\nH 4.64 -0.51 0.89\nH 4.64 -0.51 -0.89\n";
        let document = crate::import::read_bytes(text, "a.xyz", &Default::default()).unwrap();
        let structure = crate::bonds::assign(document.records[0].clone(), &Default::default());
        let shown = |hydrogens, water| {
            let options = SceneOptions { hydrogens, water, ..SceneOptions::default() };
            let shown = shown_atoms(&structure, &options).unwrap();
            (0..8).filter(|&atom| shown[atom]).collect::<Vec<_>>()
        };
        assert_eq!(shown(true, false), [3, 4, 5, 6, 7]);
        assert_eq!(shown(false, true), [0, 3]);
        assert_eq!(shown(false, false), [3]);
        let peptide = b"\
ATOM      1  CA  GLY A   1       0.000   0.000   0.000  1.00 10.00           C  \n\
HETATM    2  O   HOH A   2       9.000   0.000   0.000  1.00 10.00           O  \n";
        let document = crate::import::read_bytes(peptide, "a.pdb", &Default::default()).unwrap();
        assert_eq!(crate::bonds::waters(&document.records[0]), [false, true]);
    }

    fn selection(text: &str) -> Selection {
        Selection::parse(text).unwrap()
    }

    fn ethanol() -> Structure {
        let text = b"4\n\nC 0 0 0\nC 1.52 0 0\nO 2.02 1.34 0\nNa 9 0 0\n";
        let document = crate::import::read_bytes(text, "a.xyz", &Default::default()).unwrap();
        bonds::assign(document.records[0].clone(), &Default::default())
    }

    fn scene(by_selection: BySelection) -> Scene {
        let structure = ethanol();
        Scene::new(&[Item::of(&structure)], &SceneOptions { by_selection, ..SceneOptions::default() })
    }

    #[test]
    fn only_what_is_to_be_shown_and_not_hidden_is_drawn() {
        let ids = |show: &[&str], hide: &[&str]| {
            let of = |texts: &[&str]| texts.iter().map(|text| selection(text)).collect();
            let scene = scene(BySelection { show: of(show), hide: of(hide), ..BySelection::default() });
            (scene.blocks[0].spheres.iter().map(|ball| ball.id).collect::<Vec<_>>(), scene.cylinder_count())
        };
        assert_eq!(ids(&[], &[]), (vec![1, 2, 3, 4], 2));
        assert_eq!(ids(&["element C"], &[]), (vec![1, 2], 1));
        assert_eq!(ids(&["index 1", "element O"], &[]), (vec![1, 3], 0));
        assert_eq!(ids(&["element C,O"], &["index 1", "index 4"]), (vec![2, 3], 1));
        assert_eq!(ids(&[], &["all"]).0.len(), 0);
    }

    #[test]
    fn the_last_colour_and_style_of_an_atom_count_and_a_bond_is_as_thin_as_its_thinner_end() {
        let red = Srgb8::rgb(255, 0, 0);
        let drawn = scene(BySelection {
            colors: vec![(selection("element C"), Srgb8::WHITE), (selection("index 2"), red)],
            styles: vec![(selection("all"), Style::Licorice), (selection("index 3"), Style::Wireframe)],
            ..BySelection::default()
        });
        let [first, second, oxygen, sodium] = drawn.blocks[0].spheres[..] else { panic!("four balls") };
        assert_eq!((first.color, second.color), (Srgb8::WHITE, red));
        assert_eq!(oxygen.color, Element::O.color());
        let stick = |style: Style| style.stick_radius(crate::structure::BondKind::Covalent).unwrap();
        assert_eq!([first.radius, oxygen.radius], [stick(Style::Licorice), stick(Style::Wireframe)]);
        assert!(sodium.radius > stick(Style::Licorice), "an atom alone keeps its ball");
        let radii: Vec<f32> = drawn.blocks[0].cylinders.iter().map(|stick| stick.radius).collect();
        assert_eq!(radii, [stick(Style::Licorice), stick(Style::Wireframe)]);
        let half = &drawn.blocks[0].cylinders[0];
        assert_eq!((half.color_a, half.color_b), (Srgb8::WHITE, red));
    }

    #[test]
    fn between_full_spheres_and_sticks_there_is_a_stick() {
        let one = |style| scene(BySelection { styles: vec![(selection("index 1"), style)], ..BySelection::default() });
        assert_eq!(one(Style::SpaceFilling).cylinder_count(), 2);
        let both =
            BySelection { styles: vec![(selection("element C"), Style::SpaceFilling)], ..BySelection::default() };
        assert_eq!(scene(both).cylinder_count(), 1);
    }

    #[test]
    fn what_finds_nothing_is_said_with_its_flag() {
        let drawn = scene(BySelection {
            hide: vec![selection("chain Q"), selection("element O")],
            labels: vec![selection("residue 3")],
            ..BySelection::default()
        });
        assert_eq!(drawn.unmatched, ["--hide chain Q", "--label-only residue 3"]);
    }

    #[test]
    fn the_legend_has_the_scheme_and_then_the_selections_in_their_order() {
        let text = crate::scene::OverlayOptions { legend: true, ..Default::default() };
        let colors = vec![(selection("index 3"), Srgb8::WHITE), (selection("index 1"), Srgb8::BLACK)];
        let by_selection = BySelection { colors, ..BySelection::default() };
        let structure = ethanol();
        let scene =
            Scene::new(&[Item::of(&structure)], &SceneOptions { by_selection, text, ..SceneOptions::default() });
        let names: Vec<String> = scene.overlay.legend.iter().map(|row| row.names.join(", ")).collect();
        assert_eq!(names, ["C", "Na", "index 3", "index 1"]);
    }

    #[test]
    fn ions_can_be_left_out() {
        let shown = shown_atoms(&ethanol(), &SceneOptions { ions: false, ..SceneOptions::default() });
        assert_eq!(shown, Some(vec![true, true, true, false]));
    }
}
