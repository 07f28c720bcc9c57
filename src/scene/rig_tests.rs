//! Moved scenes are what scenes made anew would be.

use super::*;
use crate::bonds::{self, BondOptions};
use crate::scene::Scene;
use crate::structure::{Frame, Positions};

fn molecule(name: &str) -> Structure {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name);
    let document = crate::import::read_path(&path, &Default::default()).unwrap();
    bonds::assign(document.records[0].clone(), &BondOptions { hydrogen_bonds: true, ..BondOptions::default() })
}

/// Every atom somewhere else: all turned and moved, and each a little by itself.
fn moved(structure: &Structure, step: f32) -> Structure {
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.3 * step, 0.2, -0.5 * step);
    let place = |(atom, &point): (usize, &Vec3)| {
        let own = Vec3::new((atom as f32).sin(), (atom as f32 * 1.7).cos(), (atom as f32 * 0.6).sin());
        turn * point + Vec3::splat(step) + own * 0.03
    };
    let points = structure.positions().relative().iter().enumerate().map(place).collect();
    let frame = structure.frames()[0].clone();
    structure.with_frame(Frame { positions: Positions::from_relative(points, 3), ..frame })
}

fn item(structure: &Structure) -> Item<'_> {
    Item { kind: 7, ..Item::of(structure) }
}

#[test]
fn a_moved_scene_is_the_one_made_anew() {
    for name in ["caffeine.sdf", "aspirin.sdf", "1crn.pdb", "ferrocene.xyz"] {
        let molecule = molecule(name);
        for style in Style::ALL {
            for aromatic in Aromatic::ALL {
                let options = SceneOptions {
                    style,
                    aromatic,
                    haptic: aromatic == Aromatic::Ring,
                    hydrogens: style != Style::Licorice,
                    measurements: vec![Measurement {
                        atoms: [0, 3].map(|atom| crate::scene::AtomPlace { item: 0, atom }).into(),
                    }],
                    ..SceneOptions::default()
                };
                let first = [item(&molecule)];
                let rig = Rig::new(&first, &options);
                let options = SceneOptions { pose: Some(rig.scene(&first, &options).pose), ..options };
                for step in [1.0, 2.0] {
                    let structure = moved(&molecule, step);
                    let items = [item(&structure)];
                    assert!(rig.fits(&items, &options));
                    assert!(
                        rig.scene(&items, &options) == Scene::new(&items, &options),
                        "{name} {style:?} {aromatic:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn only_frames_of_the_same_molecule_with_the_same_bonds_and_options_fit() {
    let molecule = molecule("aspirin.sdf");
    let options = SceneOptions::default();
    let item = |structure, kind| Item { kind, ..Item::of(structure) };
    let rig = Rig::new(&[item(&molecule, 7)], &options);
    assert!(rig.fits(&[item(&molecule, 7)], &options));
    let fewer = molecule.clone().with_bonds(molecule.bonds()[1..].to_vec());
    assert!(
        !rig.fits(&[item(&molecule, 8)], &options)
            && !rig.fits(&[item(&fewer, 7)], &options)
            && !rig.fits(&[], &options)
    );
    assert!(!rig.fits(&[item(&molecule, 7)], &SceneOptions { style: Style::Licorice, ..options.clone() }));
    let plain = Rig::new(&[Item::of(&molecule)], &options);
    assert!(!plain.fits(&[Item::of(&molecule)], &options), "nothing is known of it");
}
