//! How aromatic bonds look: single sticks and a thin ring in the middle of each aromatic ring, or a dashed line inside, or one
//! Kekulé form.
//!
//! Rings are found among the aromatic bonds alone, the shortest ones through each bond (`bonds::small_rings`), so that fused rings
//! each have their own and the whole stays linear in the number of atoms. A ring that is not flat, and bonds that are in no
//! ring of five to seven atoms, have the dashed line.
//!
//! Two kinds of rings are drawn as chemists draw them, in a Kekulé form, where one is known: those with a double bond that leaves the ring
//! (the C=O of caffeine, of guanine, of a pyridone), and cages with five-membered rings of carbon between others (fullerenes,
//! corannulene), whose double bonds are those between six-membered rings.

use super::fit::eigen_symmetric;
use super::shapes::TorusInstance;
use crate::bonds;
use crate::color::Srgb8;
use crate::element::Element;
use crate::structure::{Bond, BondKind, BondOrder, Structure};
use glam::{DMat3, DVec3, Vec3};

/// How aromatic bonds are drawn; the names are those of `--aromatic`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Aromatic {
    /// A thin ring inside each flat ring of five to seven atoms; all else as [`Aromatic::Dashes`].
    #[default]
    Ring,
    /// A stick and a dashed one beside it, inside the ring.
    Dashes,
    /// Single and double bonds as one Kekulé form has them; two sticks where none is known.
    Kekule,
}

impl Aromatic {
    /// All of them.
    pub const ALL: [Aromatic; 3] = [Aromatic::Ring, Aromatic::Dashes, Aromatic::Kekule];

    /// The name in flags and settings.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Aromatic::Ring => "ring",
            Aromatic::Dashes => "dashes",
            Aromatic::Kekule => "kekule",
        }
    }

    /// The choice of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Aromatic> {
        Aromatic::ALL.into_iter().find(|choice| choice.name() == name)
    }

    /// The bond as its sticks are to look: aromatic only if that is a dashed stick beside a solid one.
    pub(super) fn as_drawn(self, bond: &Bond, shown: Shown) -> Bond {
        let (aromatic, order) = match (self, shown) {
            _ if !bond.aromatic => return *bond,
            (Aromatic::Kekule, _) if bond.order == BondOrder::Unknown => (false, BondOrder::Double),
            (Aromatic::Kekule, _) | (_, Shown::Order) => (false, bond.order),
            (_, Shown::Ring) => (false, BondOrder::Single),
            (_, Shown::Stick) => (true, BondOrder::Double),
        };
        Bond { aromatic, order, ..*bond }
    }
}

/// The least and the most atoms of a ring that has a ring inside. Smaller ones have no room, in larger ones it is far from the sticks.
const ATOMS: std::ops::RangeInclusive<usize> = 5..=7;
/// Root mean square distance from their plane up to which atoms count as flat, ångström: rings that a protein's refinement bends
/// stay below 0.05 Å, boats and chairs are above 0.2 Å.
const FLAT: f64 = 0.15;
/// Radius of the ring in distances of the atoms from its centre, by eye: near the sticks, and clear of them.
const PART: f32 = 0.6;
/// Room between the ring's tube and the sticks, ångström.
const ROOM: f32 = 0.1;
/// How much darker than the mean of its atoms a ring is, in linear light, so that it stands out from the sticks; by eye.
const DARKER: f32 = 0.6;

/// What says that a bond is aromatic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Shown {
    /// The bond itself.
    #[default]
    Stick,
    /// A ring beside it.
    Ring,
    /// Nothing: it is drawn as the Kekulé form has it.
    Order,
}

/// The rings that have a ring inside: which atoms they are, not where.
#[derive(Debug, Default)]
pub(super) struct Rings {
    list: Vec<Ring>,
    /// What shows each bond of the structure; empty if none is in a ring.
    shown: Vec<Shown>,
}

#[derive(Debug)]
struct Ring {
    atoms: Vec<u32>,
    color: Srgb8,
    /// Index of its first bond.
    first: u32,
    /// Radii of its sticks, and of the tube of the ring inside.
    radii: [f32; 2],
}

impl Rings {
    /// What says that a bond is aromatic, if it is.
    pub(super) fn shown(&self, bond: u32) -> Shown {
        self.shown.get(bond as usize).copied().unwrap_or_default()
    }

    /// What is drawn of them where the atoms are, each with the id of its first bond. A ring that has been bent since it was found keeps its
    /// ring inside, which would come and go otherwise.
    pub(super) fn tori(&self, positions: &[Vec3], id_of_bond: impl Fn(u32) -> u32) -> Vec<TorusInstance> {
        let torus = |ring: &Ring| {
            let points: Vec<Vec3> = ring.atoms.iter().map(|&atom| positions[atom as usize]).collect();
            let (center, axis, _) = plane(&points)?;
            let [_, tube_radius] = ring.radii;
            let ring_radius = inner_radius(&points, center, ring.radii).max(2.0 * tube_radius);
            Some(TorusInstance {
                center: center.to_array(),
                ring_radius,
                axis: axis.to_array(),
                tube_radius,
                color: ring.color,
                id: id_of_bond(ring.first),
                reserved: [0; 2],
            })
        };
        self.list.iter().filter_map(torus).collect()
    }
}

/// Finds them among the bonds that are drawn. `radii` gives for the atoms of a ring that of a single bond's stick and that of the ring's
/// tube; `None` where there are no sticks.
pub(super) fn rings(
    structure: &Structure,
    colors: &[Srgb8],
    radii: impl Fn(&[u32]) -> Option<[f32; 2]>,
    is_drawn: impl Fn(&Bond) -> bool,
) -> Rings {
    let is_aromatic = |bond: &Bond| bond.aromatic && bond.kind == BondKind::Covalent && is_drawn(bond);
    let (indices, aromatic): (Vec<u32>, Vec<Bond>) = (0u32..)
        .zip(structure.bonds())
        .filter(|(_, bond)| is_aromatic(bond))
        .map(|(index, bond)| (index, *bond))
        .unzip();
    let mut rings = Rings::default();
    if aromatic.is_empty() {
        return rings;
    }
    let positions = structure.positions().relative();
    let mut found = bonds::small_rings(structure, &aromatic, *ATOMS.end());
    found.retain(|ring| ATOMS.contains(&ring.atoms.len()));
    let has_kekule = has_kekule(structure, &aromatic, &found, is_drawn);
    rings.shown.resize(structure.bonds().len(), Shown::default());
    for (ring, _) in found.iter().zip(&has_kekule).filter(|(_, has_kekule)| **has_kekule) {
        ring.bonds.iter().for_each(|&bond| rings.shown[indices[bond as usize] as usize] = Shown::Order);
    }
    for (ring, _) in found.into_iter().zip(has_kekule).filter(|(_, has_kekule)| !has_kekule) {
        let Some(radii) = radii(&ring.atoms) else { continue };
        let points: Vec<Vec3> = ring.atoms.iter().map(|&atom| positions[atom as usize]).collect();
        let Some((center, _, is_flat)) = plane(&points) else { continue };
        if !is_flat || inner_radius(&points, center, radii) < 3.0 * radii[1] {
            continue;
        }
        let first = ring.bonds.iter().map(|&bond| indices[bond as usize]).min().unwrap_or(0);
        for bond in ring.bonds {
            rings.shown[indices[bond as usize] as usize] = Shown::Ring;
        }
        let color = mean(ring.atoms.iter().map(|&atom| colors[atom as usize]));
        rings.list.push(Ring { atoms: ring.atoms, color, first, radii });
    }
    rings
}

/// For each ring whether it is drawn in its Kekulé form: see the module. `aromatic` are the bonds that the rings' indices stand for.
fn has_kekule(
    structure: &Structure,
    aromatic: &[Bond],
    rings: &[bonds::Ring],
    is_drawn: impl Fn(&Bond) -> bool,
) -> Vec<bool> {
    let mut has_double = vec![false; structure.atom_count()];
    let doubles = structure.bonds().iter().filter(|bond| {
        !bond.aromatic && bond.kind == BondKind::Covalent && bond.order == BondOrder::Double && is_drawn(bond)
    });
    doubles.for_each(|bond| (has_double[bond.a as usize], has_double[bond.b as usize]) = (true, true));
    let mut rings_of_bond = vec![0u8; aromatic.len()];
    for bond in rings.iter().flat_map(|ring| &ring.bonds) {
        rings_of_bond[*bond as usize] = rings_of_bond[*bond as usize].saturating_add(1);
    }
    let is_known = |ring: &bonds::Ring| {
        ring.bonds.iter().all(|&bond| matches!(aromatic[bond as usize].order, BondOrder::Single | BondOrder::Double))
    };
    let elements = structure.elements();
    let is_inside = |ring: &bonds::Ring| {
        ring.atoms.len() == 5
            && ring.atoms.iter().all(|&atom| elements[atom as usize] == Element::C)
            && ring.bonds.iter().all(|&bond| rings_of_bond[bond as usize] > 1)
    };
    // From five-membered rings inside a cage to all that are joined to it.
    let mut in_cage = vec![false; aromatic.len()];
    let mut is_cage: Vec<bool> = rings.iter().map(|ring| is_known(ring) && is_inside(ring)).collect();
    let mut is_growing = is_cage.contains(&true);
    while is_growing {
        is_growing = false;
        for (ring, is_cage) in rings.iter().zip(&mut is_cage) {
            let joins = *is_cage || ring.bonds.iter().any(|&bond| in_cage[bond as usize]) && is_known(ring);
            if joins {
                is_growing |= ring.bonds.iter().any(|&bond| !in_cage[bond as usize]);
                ring.bonds.iter().for_each(|&bond| in_cage[bond as usize] = true);
            }
            *is_cage = joins;
        }
    }
    let leaves = |ring: &bonds::Ring| ring.atoms.iter().any(|&atom| has_double[atom as usize]);
    rings.iter().zip(is_cage).map(|(ring, is_cage)| is_cage || (leaves(ring) && is_known(ring))).collect()
}

/// Radius of the ring inside a ring of atoms.
fn inner_radius(points: &[Vec3], center: Vec3, [stick_radius, tube_radius]: [f32; 2]) -> f32 {
    let count = points.len();
    let reach = points.iter().map(|point| point.distance(center)).sum::<f32>() / count as f32;
    let nearest = (0..count).map(|i| ((points[i] + points[(i + 1) % count]) * 0.5).distance(center));
    let free = nearest.fold(f32::INFINITY, f32::min) - stick_radius - ROOM - tube_radius;
    (PART * reach).min(free)
}

/// Centre and normal of the plane that fits points best, and whether they are flat; `None` if they are nowhere.
fn plane(points: &[Vec3]) -> Option<(Vec3, Vec3, bool)> {
    let count = points.len() as f64;
    let center = points.iter().map(|point| point.as_dvec3()).sum::<DVec3>() / count;
    let mut covariance = DMat3::ZERO;
    for point in points {
        let d = point.as_dvec3() - center;
        covariance += DMat3::from_cols(d * d.x, d * d.y, d * d.z) * (1.0 / count);
    }
    // The mean square distance from the plane is the least eigenvalue.
    let (values, axes) = eigen_symmetric(covariance);
    let least = (0..3).min_by(|&i, &j| values[i].total_cmp(&values[j]))?;
    let is_flat = values[least] <= FLAT * FLAT;
    center.is_finite().then(|| (center.as_vec3(), axes[least].as_vec3().normalize_or(Vec3::Z), is_flat))
}

fn mean(colors: impl ExactSizeIterator<Item = Srgb8>) -> Srgb8 {
    let part = DARKER / colors.len().max(1) as f32;
    let mut sum = [0.0; 3];
    for color in colors {
        for (sum, x) in sum.iter_mut().zip(color.to_linear()) {
            *sum += part * x;
        }
    }
    Srgb8::from_linear(sum, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Item, Scene, SceneOptions, Style};
    use crate::structure::{AtomRecord, BondSource, Diagnostics, StructureBuilder};
    use std::f32::consts::FRAC_PI_3;

    /// Aromatic carbons.
    fn molecule(points: &[Vec3], pairs: &[(u32, u32)]) -> Structure {
        let mut builder = StructureBuilder::new();
        for point in points {
            let position = point.as_dvec3();
            builder.push_atom(&AtomRecord { element: Element::C, position, ..AtomRecord::default() });
        }
        for (index, &(a, b)) in pairs.iter().enumerate() {
            let order = if index % 2 == 0 { BondOrder::Double } else { BondOrder::Single };
            builder.push_bond(Bond { aromatic: true, ..Bond::new(a, b, order, BondSource::File) });
        }
        builder.build(&mut Diagnostics::default())
    }

    fn polygon(atoms: u32, lifted: f32) -> Structure {
        let radius = 0.695 / (std::f32::consts::PI / atoms as f32).sin();
        let points: Vec<Vec3> = (0..atoms)
            .map(|i| {
                let angle = i as f32 * std::f32::consts::TAU / atoms as f32;
                Vec3::new(radius * angle.cos() + 3.0, radius * angle.sin(), if i % 2 == 0 { lifted } else { -lifted })
            })
            .collect();
        molecule(&points, &(0..atoms).map(|i| (i, (i + 1) % atoms)).collect::<Vec<_>>())
    }

    fn drawn(structure: &Structure, aromatic: Aromatic, style: Style) -> (usize, Vec<TorusInstance>) {
        let scene = Scene::new(&[Item::of(structure)], &SceneOptions { aromatic, style, ..SceneOptions::default() });
        (scene.cylinder_count(), scene.blocks[0].tori.clone())
    }

    #[test]
    fn rings_of_five_to_seven_atoms_have_a_ring_clear_of_their_sticks() {
        for atoms in 5..=7 {
            let structure = polygon(atoms, 0.0);
            for style in [Style::BallAndStick, Style::Licorice, Style::Wireframe] {
                let (sticks, tori) = drawn(&structure, Aromatic::Ring, style);
                assert_eq!((sticks, tori.len()), (atoms as usize, 1), "{style:?}");
                let torus = tori[0];
                assert!((Vec3::from(torus.center) - Vec3::X * 3.0).length() < 1e-5);
                assert!(torus.axis[2].abs() > 0.999 && torus.id == atoms + 1);
                let side = 0.695 / (std::f32::consts::PI / atoms as f32).tan();
                let stick = style.stick_radius(BondKind::Covalent).unwrap();
                let room = side - stick - torus.ring_radius - torus.tube_radius;
                assert!(room > 0.099 && torus.ring_radius > 0.4, "{atoms} {style:?}: {room} {torus:?}");
            }
        }
    }

    #[test]
    fn other_rings_and_bonds_without_one_have_dashes_inside() {
        let chain = molecule(&[Vec3::ZERO, Vec3::X * 1.4, Vec3::new(2.1, 1.2, 0.0)], &[(0, 1), (1, 2)]);
        for (structure, bonds) in [(polygon(6, 0.25), 6), (polygon(8, 0.0), 8), (polygon(4, 0.0), 4), (chain, 2)] {
            let (sticks, tori) = drawn(&structure, Aromatic::Ring, Style::BallAndStick);
            assert!(tori.is_empty() && sticks > 2 * bonds, "{bonds}: {sticks}");
            assert_eq!(sticks, drawn(&structure, Aromatic::Dashes, Style::BallAndStick).0);
        }
        // Flat within the noise of a refinement.
        assert_eq!(drawn(&polygon(6, 0.1), Aromatic::Ring, Style::BallAndStick).1.len(), 1);
    }

    #[test]
    fn a_kekule_form_has_its_double_bonds_and_no_more() {
        let (sticks, tori) = drawn(&polygon(6, 0.0), Aromatic::Kekule, Style::BallAndStick);
        assert_eq!((sticks, tori.len()), (9, 0));
        assert!(drawn(&polygon(6, 0.0), Aromatic::Ring, Style::SpaceFilling).1.is_empty());
    }

    #[test]
    fn a_ring_with_a_double_bond_to_the_outside_has_its_kekule_form() {
        // p-Benzoquinone with aromatic bonds in the ring, as dictionaries have pyridones: C=O on atoms 0 and 3.
        let out = |k: f32, far: f32| Vec3::new((k * FRAC_PI_3).cos(), (k * FRAC_PI_3).sin(), 0.0) * far;
        let mut points: Vec<Vec3> = (0..6).map(|k| out(k as f32, 1.4)).collect();
        points.extend([out(0.0, 2.62), out(3.0, 2.62)]);
        let build = |orders: [BondOrder; 6]| {
            let mut builder = StructureBuilder::new();
            for point in &points {
                let position = point.as_dvec3();
                builder.push_atom(&AtomRecord { element: Element::C, position, ..AtomRecord::default() });
            }
            for (k, order) in (0u32..).zip(orders) {
                let bond = Bond::new(k, (k + 1) % 6, order, BondSource::File);
                builder.push_bond(Bond { aromatic: true, ..bond });
            }
            builder.push_bond(Bond::new(0, 6, BondOrder::Double, BondSource::File));
            builder.push_bond(Bond::new(3, 7, BondOrder::Double, BondSource::File));
            builder.build(&mut Diagnostics::default())
        };
        let (one, two) = (BondOrder::Single, BondOrder::Double);
        let known = build([one, two, one, one, two, one]);
        // Four single bonds, two double ones in the ring and two that leave it.
        assert_eq!(drawn(&known, Aromatic::Ring, Style::BallAndStick).0, 12);
        assert!(drawn(&known, Aromatic::Ring, Style::BallAndStick).1.is_empty());
        // Where no form is known the ring stands for it.
        let unknown = build([BondOrder::Unknown; 6]);
        assert_eq!(drawn(&unknown, Aromatic::Ring, Style::BallAndStick).1.len(), 1);
    }

    #[test]
    fn fused_rings_have_one_each_the_inner_one_too() {
        // Coronene's carbons: a hexagon in the middle, six around.
        let unit = |k: u32| {
            let angle = k as f32 * std::f32::consts::TAU / 6.0;
            Vec3::new(angle.cos(), angle.sin(), 0.0) * 1.42
        };
        let mut points: Vec<Vec3> = (0..6).map(unit).collect();
        points.extend((0..6).map(|k| unit(k) * 2.0));
        for k in 0..6 {
            points.push(unit(k) * 2.0 + unit(k + 1));
            points.push(unit(k + 1) * 2.0 + unit(k));
        }
        let mut pairs: Vec<(u32, u32)> = (0..6).flat_map(|k| [(k, (k + 1) % 6), (k, k + 6)]).collect();
        for k in 0..6 {
            pairs.extend([(6 + k, 12 + 2 * k), (12 + 2 * k, 13 + 2 * k), (13 + 2 * k, 6 + (k + 1) % 6)]);
        }
        let coronene = molecule(&points, &pairs);
        assert!(
            coronene
                .bonds()
                .iter()
                .all(|bond| { (points[bond.a as usize].distance(points[bond.b as usize]) - 1.42).abs() < 1e-4 })
        );
        let (sticks, tori) = drawn(&coronene, Aromatic::Ring, Style::BallAndStick);
        assert_eq!((sticks, tori.len()), (30, 7));
    }
}
