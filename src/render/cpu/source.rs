//! Where the primitives of a picture come from: all of them found in view space beforehand, or pack by pack as they are
//! needed ([`super::packs`]).

use super::binning::{Bins, Candidate};
use super::facts::Fact;
use super::tile::{Place, Tile};
use crate::render::outline::Outline;
use crate::render::settings::View;
use crate::render::solids::{Primitive, Solids};

/// What can be drawn tile by tile.
pub(super) trait Source: Facts {
    /// Whether nothing reaches into a tile.
    fn is_empty(&self, tile: usize) -> bool;

    /// Finds what is seen in tile `number`; `candidates` is room to work in.
    fn see(&self, tile: &mut Tile, candidates: &mut Vec<Candidate>, place: &Place<'_>, number: usize);
}

/// What is told of what was seen. A trait of its own: shading is compiled once for all sources, and asks by a table of these.
pub(super) trait Facts: Sync {
    /// What is neither ball, stick nor ring as the shader's solids number it.
    fn of_shader(&self, index: u32) -> u32;

    /// Whether tiles are told what balls, sticks and rings look like as they are drawn ([`Tile::normal`]).
    fn tells_looks(&self) -> bool;

    /// What shading needs of a ball, stick or ring.
    fn fact(&self, index: u32) -> Fact;

    /// How far behind its silhouette the line of a primitive lies.
    fn behind(&self, outline: &Outline, index: u32) -> f32;

    /// A primitive as the only one of solids; `None` where the shader's solids have all, under the same numbers.
    fn alone(&self, index: u32) -> Option<Solids>;
}

/// All primitives, in view space.
pub(super) struct Listed<'a> {
    solids: &'a Solids,
    bins: Bins,
}

impl<'a> Listed<'a> {
    pub(super) fn new(solids: &'a Solids, outline: Option<&Outline>, view: &View, tile: u32) -> Listed<'a> {
        Listed { solids, bins: Bins::new(solids, outline, view, tile) }
    }
}

impl Source for Listed<'_> {
    fn is_empty(&self, tile: usize) -> bool {
        self.bins.is_empty(tile)
    }

    #[inline(always)]
    fn see(&self, tile: &mut Tile, candidates: &mut Vec<Candidate>, place: &Place<'_>, number: usize) {
        self.bins.of_tile(number, candidates);
        tile.see(place, self.solids, candidates);
    }
}

impl Facts for Listed<'_> {
    fn of_shader(&self, index: u32) -> u32 {
        index
    }

    fn tells_looks(&self) -> bool {
        false
    }

    fn fact(&self, index: u32) -> Fact {
        match self.solids.primitive(index as usize) {
            Primitive::Sphere(i) => Fact::of_sphere(&self.solids.spheres[i], self.solids.sphere_looks[i].0),
            Primitive::Cylinder(i) => {
                let (a, b, _) = self.solids.cylinder_looks[i];
                Fact::of_cylinder(&self.solids.cylinders[i], [a, b])
            }
            Primitive::Torus(i) => Fact::of_torus(&self.solids.tori[i], self.solids.torus_looks[i].0),
            // Found one by one.
            Primitive::Cone(_) | Primitive::Triangle(_) => Fact::Other,
        }
    }

    fn behind(&self, outline: &Outline, index: u32) -> f32 {
        outline.behind(self.solids, index as usize)
    }

    fn alone(&self, _index: u32) -> Option<Solids> {
        None
    }
}
