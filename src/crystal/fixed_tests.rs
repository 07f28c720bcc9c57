use super::*;
use crate::crystal::draw;
use crate::element::Element;
use crate::structure::{AtomRecord, Diagnostics, Positions, StructureBuilder};
use glam::Vec3;

fn structure(atoms: &[(Element, DVec3)], cell: Option<Cell>) -> Structure {
    let mut builder = StructureBuilder::new();
    for &(element, position) in atoms {
        builder.push_atom(&AtomRecord { element, position, ..AtomRecord::default() });
    }
    builder.set_cell(cell);
    builder.build(&mut Diagnostics::default())
}

fn frame(points: &[DVec3], cell: Option<Cell>) -> Frame {
    let points: Vec<Vec3> = points.iter().map(|point| point.as_vec3()).collect();
    let positions = Positions::from_relative(points, 3);
    Frame { positions, cell, title: String::new(), vectors: Vec::new(), time_ps: Some(1.0) }
}

/// A skew cell, and propane in it: three carbons in a row of 1.5 Å with their hydrogens left out, so that the row is what counts.
fn row(start: DVec3, along: DVec3) -> [DVec3; 3] {
    [start, start + along * 1.5, start + along * 3.0]
}

fn skew() -> Cell {
    let cell = Cell::from_parameters([11.0, 12.0, 10.0], [80.0, 95.0, 105.0]);
    cell.unwrap()
}

fn wrapped(points: &[DVec3], cell: &Cell) -> Vec<DVec3> {
    let inside = |&point: &DVec3| {
        let at = cell.fractional_from_cartesian() * point;
        cell.cartesian_from_fractional() * (at - at.floor())
    };
    points.iter().map(inside).collect()
}

#[test]
fn molecules_are_whole_in_every_frame_wherever_they_are_cut() {
    let cell = skew();
    let first = row(DVec3::splat(4.0), DVec3::X);
    let atoms: Vec<(Element, DVec3)> = first.iter().map(|&at| (Element::C, at)).collect();
    let fixed = Fixed::new(structure(&atoms, Some(cell)), &CrystalOptions::default());
    let mut cut = 0;
    for step in 0..40 {
        let angle = f64::from(step) * 0.4;
        let along = DVec3::new(angle.cos(), angle.sin() * 0.8, angle.sin() * 0.6);
        let whole = row(DVec3::new(0.7, 0.3, -0.2) * f64::from(step), along);
        let points = wrapped(&whole, &cell);
        cut += usize::from(points.windows(2).any(|pair| pair[0].distance(pair[1]) > 2.0));
        let drawn = fixed.draw(frame(&points, Some(cell))).unwrap();
        let at = |atom: usize| drawn.structure.positions().get(atom);
        // The first atom stays where the file has it.
        assert!(at(0).distance(points[0]) < 1e-4);
        for atom in 1..3 {
            assert!((at(atom) - at(0) - (whole[atom] - whole[0])).length() < 1e-4, "step {step}");
        }
        assert_eq!((drawn.structure.bonds().len(), drawn.stubs.len(), drawn.kind), (2, 0, fixed.kind));
        assert_eq!(drawn.structure.frames()[0].time_ps, Some(1.0));
    }
    assert!(cut > 5, "{cut} frames are cut");
}

#[test]
fn bonds_do_not_break_and_are_those_of_the_structure_cut_or_not() {
    let cell = skew();
    let whole = row(cell.cartesian_from_fractional() * DVec3::new(0.93, 0.5, 0.5), DVec3::X);
    let points = wrapped(&whole, &cell);
    assert!(points[0].distance(points[1]) > 5.0);
    let atoms: Vec<(Element, DVec3)> = points.iter().map(|&at| (Element::C, at)).collect();
    let fixed = Fixed::new(structure(&atoms, Some(cell)), &CrystalOptions::default());
    // Drawn out to 3 Å a bond in the second frame.
    let far = [whole[0], whole[0] + DVec3::X * 3.0, whole[0] + DVec3::X * 6.0];
    for (points, cell) in [(wrapped(&far, &cell), Some(cell)), (far.to_vec(), None)] {
        let drawn = fixed.draw(frame(&points, cell)).unwrap();
        assert_eq!(drawn.structure.bonds().len(), 2);
        let at = |atom: usize| drawn.structure.positions().get(atom);
        assert!((at(1).distance(at(0)) - 3.0).abs() < 1e-4 && (at(2).distance(at(1)) - 3.0).abs() < 1e-4);
    }
    assert!(fixed.draw(frame(&far[..2], None)).unwrap_err().to_string().contains("2 atoms, the molecule 3"));
}

#[test]
fn a_network_without_end_is_drawn_as_without_frames() {
    // Diamond, its conventional cell.
    let cell = Cell::from_parameters([3.567; 3], [90.0; 3]).unwrap();
    let corners = [[0.0, 0.0, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [0.5, 0.5, 0.0]];
    let inner = corners.map(|at| at.map(|x| x + 0.25));
    let points: Vec<DVec3> = corners.iter().chain(&inner).map(|&at| DVec3::from(at) * 3.567).collect();
    let atoms: Vec<(Element, DVec3)> = points.iter().map(|&at| (Element::C, at)).collect();
    let diamond = structure(&atoms, Some(cell));
    let fixed = Fixed::new(diamond.clone(), &CrystalOptions::default());
    // All atoms moved together, and wrapped elsewhere.
    let moved: Vec<DVec3> = points.iter().map(|&point| point + DVec3::new(2.0, -1.0, 0.6)).collect();
    for points in [points, wrapped(&moved, &cell)] {
        let drawn = fixed.draw(frame(&points, Some(cell))).unwrap();
        let atoms: Vec<(Element, DVec3)> = points.iter().map(|&at| (Element::C, at)).collect();
        let alone = draw(structure(&atoms, Some(cell)), &CrystalOptions::default()).unwrap();
        assert_eq!(drawn.structure.atom_count(), alone.structure.atom_count());
        assert_eq!(drawn.structure.bonds().len(), alone.structure.bonds().len());
        assert_eq!((drawn.stubs.len(), drawn.kind), (alone.stubs.len(), 0));
    }
}

#[test]
fn hydrogen_bonds_are_those_of_the_frame() {
    let water = |at: DVec3| [(Element::O, at), (Element::H, at + DVec3::X * 0.96), (Element::H, at + DVec3::Y * 0.96)];
    let atoms: Vec<(Element, DVec3)> = water(DVec3::ZERO).into_iter().chain(water(DVec3::X * 2.8)).collect();
    let bonds = BondOptions { hydrogen_bonds: true, ..BondOptions::default() };
    let fixed = Fixed::new(structure(&atoms, None), &CrystalOptions { bonds, ..CrystalOptions::default() });
    let count = |apart: f64| {
        let points: Vec<DVec3> =
            atoms.iter().enumerate().map(|(n, &(_, at))| if n < 3 { at } else { at + DVec3::X * apart }).collect();
        fixed.draw(frame(&points, None)).unwrap().structure.bonds().len()
    };
    assert_eq!([count(0.0), count(3.0), count(0.1)], [5, 4, 5]);
}

#[test]
fn names_of_the_choices_come_back() {
    for choice in BondsPerFrame::ALL {
        assert_eq!(BondsPerFrame::from_name(choice.name()), Some(choice));
    }
    let fixed = |choice: BondsPerFrame| [choice.is_fixed(false), choice.is_fixed(true)];
    assert_eq!(BondsPerFrame::ALL.map(fixed), [[false, true], [false, false], [true, true]]);
}
