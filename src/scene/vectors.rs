//! Vectors on atoms (forces, velocities, displacements) as arrows from the balls outwards, one colour a field.

use super::arrows::ArrowShape;
use super::{Block, Item, SceneOptions};
use crate::color::Srgb8;
use crate::error::{Error, Result};
use crate::structure::{Structure, VectorField};
use glam::Vec3;

/// Which vectors of a file are drawn.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum VectorChoice {
    /// None.
    #[default]
    None,
    /// All that the file has.
    Auto,
    /// Those of this name, in any case.
    Named(String),
}

impl VectorChoice {
    /// `none`, `auto`, or the name of a field.
    #[must_use]
    pub fn from_name(name: &str) -> VectorChoice {
        match name {
            "none" => VectorChoice::None,
            "auto" => VectorChoice::Auto,
            name => VectorChoice::Named(name.to_owned()),
        }
    }

    /// The name in flags and settings.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            VectorChoice::None => "none",
            VectorChoice::Auto => "auto",
            VectorChoice::Named(name) => name,
        }
    }

    /// An error, which names those that there are, if a field is asked for by name and none of the structures has it.
    ///
    /// # Errors
    /// [`Error::Input`].
    pub fn check<'a>(&self, structures: impl Iterator<Item = &'a Structure> + Clone) -> Result<()> {
        let VectorChoice::Named(name) = self else { return Ok(()) };
        if structures.clone().any(|structure| self.fields(structure).next().is_some()) {
            return Ok(());
        }
        let mut there: Vec<&str> = Vec::new();
        for field in structures.flat_map(Structure::vectors) {
            if !there.contains(&field.name.as_str()) {
                there.push(&field.name);
            }
        }
        let there = match there.as_slice() {
            [] => "the file has no vectors on its atoms".to_owned(),
            names => format!("the file has {}", names.join(", ")),
        };
        Err(Error::input(None, format!("there are no vectors called {name}: {there}")))
    }

    /// The fields of a structure that are drawn.
    fn fields<'a>(&'a self, structure: &'a Structure) -> impl Iterator<Item = &'a VectorField> {
        structure.vectors().iter().filter(move |field| match self {
            VectorChoice::None => false,
            VectorChoice::Auto => true,
            VectorChoice::Named(name) => field.name.eq_ignore_ascii_case(name),
        })
    }
}

/// How long the vectors of one name are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct VectorScale {
    /// The name of the field.
    pub name: String,
    /// Ångström that one unit of the file is drawn long; 0 if all vectors are zero.
    pub scale: f64,
    /// The longest vector, in the file's units.
    pub longest: f64,
}

/// Length of the longest arrow where no scale is given, ångström (chosen): longer than a bond, so that it is not lost between
/// balls, and short beside a molecule.
const LONGEST: f64 = 2.0;
/// The longest arrow that is drawn, ångström; longer ones are cut (chosen: as large as the largest virus).
const MOST: f64 = 1000.0;

/// A stick half as thick as a bond's (0.13 Å) and a head wider than a bond; by eye.
const SHAPE: ArrowShape = ArrowShape { shaft_radius: 0.065, head_radius: 0.16, head_length: 0.38 };

/// One a field: green, purple, red-orange and sky blue, which no common element has (Okabe and Ito, "Color Universal Design",
/// 2008).
const COLORS: [Srgb8; 4] = [
    Srgb8::from_rgb_u32(0x00_9E_73),
    Srgb8::from_rgb_u32(0xCC_79_A7),
    Srgb8::from_rgb_u32(0xD5_5E_00),
    Srgb8::from_rgb_u32(0x56_B4_E9),
];

/// The fields that are drawn of these structures, each name once, and at which scale: the one that the options give, else
/// such that the longest vector of that name is 2 Å.
#[must_use]
pub fn vector_scales(items: &[Item<'_>], options: &SceneOptions) -> Vec<VectorScale> {
    let mut scales: Vec<VectorScale> = Vec::new();
    for field in items.iter().flat_map(|item| options.vectors.fields(item.structure)) {
        let lengths = field.vectors.iter().map(|vector| vector.as_dvec3().length());
        let longest = lengths.filter(|length| length.is_finite()).fold(0.0, f64::max);
        match scales.iter_mut().find(|scale| scale.name == field.name) {
            Some(scale) => scale.longest = scale.longest.max(longest),
            None => scales.push(VectorScale { name: field.name.clone(), scale: 0.0, longest }),
        }
    }
    for scale in scales.iter_mut().filter(|scale| scale.longest > 0.0) {
        scale.scale = options.vector_scale.map_or(LONGEST / scale.longest, f64::from);
    }
    scales
}

/// Adds the arrows of one structure to its block, from the balls that are in it.
pub(super) fn draw(block: &mut Block, structure: &Structure, options: &SceneOptions, scales: &[VectorScale]) {
    for field in options.vectors.fields(structure) {
        let Some(number) = scales.iter().position(|scale| scale.name == field.name) else { continue };
        let color = COLORS[number % COLORS.len()];
        for ball in &block.spheres {
            let Some(vector) = field.vectors.get((ball.id as usize).wrapping_sub(1)) else { continue };
            let vector = (vector.as_dvec3() * scales[number].scale).clamp_length_max(MOST).as_vec3();
            // Shorter ones would be dots.
            if vector == Vec3::ZERO || vector.length() < 1e-3 {
                continue;
            }
            if let Some((stick, cone)) = SHAPE.arrow(ball.center.into(), ball.radius, vector, color, ball.id) {
                block.cylinders.push(stick);
                block.cones.push(cone);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn structure(name: &str, forces: &str) -> Structure {
        let text =
            format!("3\nProperties=species:S:1:pos:R:3:{name}:R:3\nO 0 0 0 {forces}\nH 0 0 1 0 0 0\nH 0 1 0 0 -1 0\n");
        let document = crate::import::read_bytes(text.as_bytes(), "a.xyz", &Default::default()).unwrap();
        document.records[0].clone()
    }

    fn options(vectors: &str, vector_scale: Option<f32>) -> SceneOptions {
        SceneOptions { vectors: VectorChoice::from_name(vectors), vector_scale, ..SceneOptions::default() }
    }

    #[test]
    fn the_longest_vector_is_two_angstrom_and_a_zero_one_is_nothing() {
        let water = structure("forces", "4 0 0");
        for (choice, scale, longest) in [("auto", None, 2.0), ("Forces", None, 2.0), ("forces", Some(0.25), 1.0)] {
            let options = options(choice, scale);
            let scene = Scene::new(&[Item::of(&water)], &options);
            let cones = &scene.blocks[0].cones;
            assert_eq!(cones.len(), 2, "{choice}");
            let radius = scene.blocks[0].spheres[0].radius;
            let tip = Vec3::from(cones[0].b) - Vec3::from(scene.blocks[0].spheres[0].center);
            assert!((tip.length() - radius - longest).abs() < 1e-5, "{tip} {radius}");
            assert_eq!((cones[0].id, cones[1].id), (1, 3));
            assert!((vector_scales(&[Item::of(&water)], &options)[0].scale * 4.0 - f64::from(longest)).abs() < 1e-9);
        }
        assert!(Scene::new(&[Item::of(&water)], &options("none", None)).blocks[0].cones.is_empty());
    }

    #[test]
    fn one_scale_holds_for_all_structures_and_fields_have_colours_of_their_own() {
        let (one, other, third) =
            (structure("forces", "4 0 0"), structure("forces", "8 0 0"), structure("velo", "1e30 0 0"));
        let items = [Item::of(&one), Item::of(&other), Item::of(&third)];
        let scene = Scene::new(&items, &options("auto", None));
        let length = |block: usize| {
            let sphere = scene.blocks[block].spheres[0];
            Vec3::from(scene.blocks[block].cones[0].b).distance(sphere.center.into()) - sphere.radius
        };
        assert!((length(0) - 1.0).abs() < 1e-4 && (length(1) - 2.0).abs() < 1e-4 && (length(2) - 2.0).abs() < 1e-4);
        let color = |block: usize| scene.blocks[block].cones[0].color;
        assert!(color(0) == color(1) && color(0) != color(2));
        let huge = Scene::new(&items, &options("velo", Some(1e30)));
        assert!(huge.fitted_camera(1.0).eye.is_finite() && huge.bounds().size().max_element() < 2000.0);
    }

    #[test]
    fn an_unknown_name_is_an_error_with_those_that_there_are() {
        let water = structure("forces", "4 0 0");
        let check = |name: &str| VectorChoice::from_name(name).check([&water].into_iter());
        assert!(check("forces").is_ok() && check("FORCES").is_ok() && check("auto").is_ok() && check("none").is_ok());
        assert!(check("velocities").unwrap_err().to_string().contains("the file has forces"));
        let bare = crate::import::read_bytes(b"1\n\nO 0 0 0\n", "a.xyz", &Default::default()).unwrap();
        let error = VectorChoice::from_name("x").check(bare.records.iter()).unwrap_err();
        assert!(error.to_string().contains("no vectors on its atoms"));
    }
}
