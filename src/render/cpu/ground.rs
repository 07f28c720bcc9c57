//! The ground's map, of sixteen texels at a time.
//!
//! Neighbouring texels walk through nearly the same nodes of the field's hierarchy: a node is entered if what is in it may darken any of
//! the sixteen. Light and sky of each are those that [`Field::ground_map`] finds one by one, within rounding.
//!
//! What is see-through, and what is drawn from copies, is asked one by one. Where the ground has faded nothing is asked.

use super::lanes::{LANES, Lanes, low_of};
use super::simd::{Work, widest};
use crate::math::{Aabb, max, min};
use crate::render::field::{Field, GroundMap, OCCLUSION_TAPS, QUICK_SHADOW, Way, eased};
use crate::render::frame::{FrameConstants, ground_fade};
use crate::render::hierarchy::WIDTH;
use crate::render::solids::{Cylinder, Primitive, Sphere};
use glam::Vec3;
use rayon::prelude::*;

/// Texels on a side of what is found together.
const SIDE: usize = 4;

/// [`Field::ground_map`].
pub(super) fn ground_map(field: &Field, frame: &FrameConstants) -> GroundMap {
    let Some(way) = way(field, frame, 0.0) else { return field.ground_map(frame) };
    map_of(frame, |p| [light(field, way, p), open(field, frame, p)])
}

/// [`Field::quick_ground_map`], for pictures in motion: the open sky is interpolated from a map of it.
pub(super) fn quick_ground_map(field: &Field, frame: &FrameConstants, sky: &(FrameConstants, GroundMap)) -> GroundMap {
    let Some(way) = way(field, frame, QUICK_SHADOW) else { return field.quick_ground_map(frame, sky) };
    let open = |[x, z]: &[Lanes; 2]| {
        std::array::from_fn(|lane| sky.1.at(&sky.0, Vec3::new(x[lane], frame.ground[0], z[lane]))[1])
    };
    map_of(frame, |p| [light(field, way, p), open(p)])
}

/// The way from the ground to the light, if what hides it can be asked by many.
fn way(field: &Field, frame: &FrameConstants, slack: f32) -> Option<Way> {
    let solids = field.solids();
    let is_simple = frame.has_ground() && !solids.is_empty() && !solids.see_through;
    Way::to_light(frame, Vec3::new(0.0, frame.ground[0], 0.0), slack).filter(|_| is_simple)
}

/// What `of` finds of the key light and of the sky, for world x and z of sixteen texels.
fn map_of(frame: &FrameConstants, of: impl Fn(&[Lanes; 2]) -> [Lanes; 2] + Sync) -> GroundMap {
    let grid = frame.ground_grid();
    let [width, height] = grid.size.map(|side| side as usize);
    let step = 1.0 / grid.texels_per_angstrom;
    let [across, down] = [width.div_ceil(SIDE), height.div_ceil(SIDE)];
    let groups = (0..across * down).into_par_iter().map(|group| {
        let corner = [group % across * SIDE, group / across * SIDE];
        let at = |axis: usize, texel: usize| grid.corner[axis] + (texel as f32 + 0.5) * step;
        let x = std::array::from_fn(|lane| at(0, corner[0] + lane % SIDE));
        let z = std::array::from_fn(|lane| at(1, corner[1] + lane / SIDE));
        // Seen is what lies between texels: where these have faded, those next to them may not.
        let next = [-step, 0.0, step];
        let is_seen = |lane: usize| {
            next.iter().any(|dx| next.iter().any(|dz| ground_fade(frame, x[lane] + dx, z[lane] + dz) > 0.0))
        };
        if (0..LANES).any(is_seen) { of(&[x, z]) } else { [[1.0; LANES]; 2] }
    });
    let groups: Vec<[Lanes; 2]> = groups.collect();
    let texel = |x: usize, z: usize| {
        let of_group = &groups[z / SIDE * across + x / SIDE];
        [0, 1].map(|kind| of_group[kind][z % SIDE * SIDE + x % SIDE])
    };
    let texels = (0..height).flat_map(|z| (0..width).map(move |x| [x, z])).map(|[x, z]| texel(x, z)).collect();
    GroundMap { size: grid.size, texels }
}

/// How much of the key light reaches sixteen points of the ground; `way` is that of one of them.
fn light(field: &Field, way: Way, p: &[Lanes; 2]) -> Lanes {
    let mut ways = Ways { field, p: *p, way, light: [1.0; LANES] };
    widest(Walk(field, &mut ways));
    ways.light.map(eased)
}

/// How much of the sky sixteen points of the ground see.
fn open(field: &Field, frame: &FrameConstants, p: &[Lanes; 2]) -> Lanes {
    let reach = frame.ground_map_size[3];
    let mut above = Above { field, p: *p, y: 0.0, distance: [f32::INFINITY; LANES] };
    let (mut closed, mut below) = ([0.0f32; LANES], 0.0);
    for tap in OCCLUSION_TAPS {
        let height = tap * reach;
        // The field grows by no more than the way. (A thousandth more, for rounding.)
        above.distance = above.distance.map(|bound| min(height, 1.001 * (bound + (height - below))));
        (above.y, below) = (frame.ground[0] + height, height);
        widest(Walk(field, &mut above));
        for (closed, distance) in closed.iter_mut().zip(above.distance) {
            *closed += (height - distance) / height;
        }
    }
    closed.map(|closed| 1.0 - closed / OCCLUSION_TAPS.len() as f32)
}

/// What sixteen points ask the primitives of a field.
trait Asks {
    /// Whether what is in a box of the field's hierarchy, by its number, can change anything, and how near it may be.
    fn nearest_to(&self, number: usize) -> Option<f32>;
    /// Takes note of a sphere.
    fn pass_sphere(&mut self, sphere: &Sphere);
    /// Takes note of a cylinder.
    fn pass_cylinder(&mut self, cylinder: &Cylinder);
    /// Takes note of any other primitive.
    fn pass_slow(&mut self, index: u32);
}

/// A walk through the hierarchy of a field, as work for [`widest`].
struct Walk<'w, 'a, A>(&'a Field, &'w mut A);

impl<A: Asks> Work for Walk<'_, '_, A> {
    #[inline(always)]
    fn run(self) {
        let Walk(field, asks) = self;
        let (hierarchy, solids) = (field.hierarchy(), field.solids());
        let Some(top) = hierarchy.depth().checked_sub(1) else { return };
        let mut waiting = vec![(top, 0usize)];
        while let Some((level, node)) = waiting.pop() {
            // What was found since may have left nothing to change.
            if asks.nearest_to(hierarchy.levels[level] as usize + node).is_none() {
                continue;
            }
            if level == 0 {
                let first = node * WIDTH;
                for &index in &hierarchy.order[first..(first + WIDTH).min(hierarchy.order.len())] {
                    match solids.primitive(index as usize) {
                        Primitive::Sphere(i) => asks.pass_sphere(&solids.spheres[i]),
                        Primitive::Cylinder(i) => asks.pass_cylinder(&solids.cylinders[i]),
                        Primitive::Cone(_) | Primitive::Torus(_) | Primitive::Triangle(_) => asks.pass_slow(index),
                    }
                }
                continue;
            }
            let (start, end) = (hierarchy.levels[level - 1] as usize, hierarchy.levels[level] as usize);
            let first = waiting.len();
            let mut keys = [0.0f32; WIDTH];
            for child in node * WIDTH..((node + 1) * WIDTH).min(end - start) {
                if let Some(key) = asks.nearest_to(start + child) {
                    // The nearest is to be the last.
                    let mut at = waiting.len();
                    waiting.push((level - 1, child));
                    while at > first && keys[at - first - 1] < key {
                        keys[at - first] = keys[at - first - 1];
                        waiting.swap(at, at - 1);
                        at -= 1;
                    }
                    keys[at - first] = key;
                }
            }
        }
    }
}

/// Ways from sixteen points of the ground to the light.
struct Ways<'a> {
    field: &'a Field,
    /// World x and z.
    p: [Lanes; 2],
    /// All else is that of this one.
    way: Way,
    /// How much light is let through by what was found, before it is eased.
    light: Lanes,
}

impl Ways<'_> {
    /// How near to any way what is in a ball may be; `None` if it darkens none.
    #[inline(always)]
    fn nearest_ball(&self, center: Vec3, radius: f32) -> Option<f32> {
        let Way { p, to_light: d, sharpness, slack, .. } = self.way;
        let (mut least, mut any) = ([f32::INFINITY; LANES], [0u32; LANES]);
        for lane in 0..LANES {
            let to = center - Vec3::new(self.p[0][lane], p.y, self.p[1][lane]);
            let t = to.x * d.x + to.y * d.y + to.z * d.z;
            let off = to - d * t;
            let beside = (off.x * off.x + off.y * off.y + off.z * off.z).sqrt() - radius;
            let farthest = t + radius;
            let light = self.light[lane] - slack;
            let darkens = (light > 0.0) & (farthest > 0.0) & (sharpness * beside < light * farthest);
            any[lane] = if darkens { u32::MAX } else { 0 };
            least[lane] = if darkens { beside } else { f32::INFINITY };
        }
        let is_any = any.iter().fold(0, |any, lane| any | lane) != 0;
        is_any.then(|| least.into_iter().fold(f32::INFINITY, min))
    }
}

impl Asks for Ways<'_> {
    #[inline(always)]
    fn nearest_to(&self, number: usize) -> Option<f32> {
        let b = &self.field.hierarchy().boxes[number];
        let (center, radius) = ((b.min + b.max) * 0.5, (b.max - b.min).length() * 0.5);
        self.nearest_ball(center, radius)
    }

    /// Where the way is nearest to its centre.
    #[inline(always)]
    fn pass_sphere(&mut self, sphere: &Sphere) {
        let Way { p, to_light: d, start, sharpness, .. } = self.way;
        for lane in 0..LANES {
            let to = sphere.center - Vec3::new(self.p[0][lane], p.y, self.p[1][lane]);
            let t = max(to.x * d.x + to.y * d.y + to.z * d.z, start);
            let off = to - d * t;
            let distance = (off.x * off.x + off.y * off.y + off.z * off.z).sqrt() - sphere.radius;
            self.light[lane] = min(self.light[lane], max(sharpness * distance / t, 0.0));
        }
    }

    /// Where the way is nearest to its axis, as [`Field`] has it.
    #[inline(always)]
    fn pass_cylinder(&mut self, cylinder: &Cylinder) {
        let Way { p, to_light: d, start, sharpness, .. } = self.way;
        let (axis, half_length) = (cylinder.axis(), cylinder.half_length);
        let cosine = d.dot(axis);
        let sine_squared = 1.0 - cosine * cosine;
        // Parallel: every point of the axis is as near as the middle.
        let over = if sine_squared > 1e-6 { 1.0 / sine_squared } else { 0.0 };
        let sides = Sides::of(cylinder);
        for lane in 0..LANES {
            let to = cylinder.center - Vec3::new(self.p[0][lane], p.y, self.p[1][lane]);
            let along = to.x * d.x + to.y * d.y + to.z * d.z;
            let on_axis = to.x * axis.x + to.y * axis.y + to.z * axis.z;
            let s = min(max((cosine * along - on_axis) * over, -half_length), half_length);
            let t = max(along + cosine * s, start);
            let distance = sides.distance(d * t - to);
            self.light[lane] = min(self.light[lane], max(sharpness * distance / t, 0.0));
        }
    }

    /// One way after the other.
    #[inline(always)]
    fn pass_slow(&mut self, index: u32) {
        let (center, radius) = self.field.ball(index as usize);
        if self.nearest_ball(center, radius).is_none() {
            return;
        }
        for lane in 0..LANES {
            let way = Way { p: Vec3::new(self.p[0][lane], self.way.p.y, self.p[1][lane]), ..self.way };
            let mut darkest = (self.light[lane], None);
            self.field.darken_by(&way, index, &mut darkest);
            self.light[lane] = darkest.0;
        }
    }
}

/// Sixteen points above the ground.
struct Above<'a> {
    field: &'a Field,
    /// World x and z.
    p: [Lanes; 2],
    /// World y.
    y: f32,
    /// How far it is at most to the nearest of what was found, not below 0.
    distance: Lanes,
}

impl Above<'_> {
    #[inline(always)]
    fn point(&self, lane: usize) -> Vec3 {
        Vec3::new(self.p[0][lane], self.y, self.p[1][lane])
    }
}

impl Asks for Above<'_> {
    #[inline(always)]
    fn nearest_to(&self, number: usize) -> Option<f32> {
        let Aabb { min: low, max: high } = self.field.hierarchy().boxes[number];
        let up = max(max(low.y - self.y, self.y - high.y), 0.0);
        let (mut any, mut least) = (0, [f32::INFINITY; LANES]);
        for (lane, least) in least.iter_mut().enumerate() {
            let x = max(max(low.x - self.p[0][lane], self.p[0][lane] - high.x), 0.0);
            let z = max(max(low.z - self.p[1][lane], self.p[1][lane] - high.z), 0.0);
            let squared = x * x + up * up + z * z;
            any |= u32::from(squared < self.distance[lane] * self.distance[lane]);
            *least = squared;
        }
        (any != 0).then(|| low_of(&least))
    }

    #[inline(always)]
    fn pass_sphere(&mut self, sphere: &Sphere) {
        for lane in 0..LANES {
            let off = self.point(lane) - sphere.center;
            let distance = (off.x * off.x + off.y * off.y + off.z * off.z).sqrt() - sphere.radius;
            self.distance[lane] = min(self.distance[lane], max(distance, 0.0));
        }
    }

    #[inline(always)]
    fn pass_cylinder(&mut self, cylinder: &Cylinder) {
        let sides = Sides::of(cylinder);
        for lane in 0..LANES {
            let distance = sides.distance(self.point(lane) - cylinder.center);
            self.distance[lane] = min(self.distance[lane], max(distance, 0.0));
        }
    }

    #[inline(always)]
    fn pass_slow(&mut self, index: u32) {
        let (center, radius) = self.field.ball(index as usize);
        for lane in 0..LANES {
            let p = self.point(lane);
            if center.distance(p) - radius < self.distance[lane] {
                self.distance[lane] = min(self.distance[lane], max(self.field.distance(index as usize, p), 0.0));
            }
        }
    }
}

/// A cylinder, for the distances of many points.
struct Sides {
    axis: Vec3,
    half_length: f32,
    radius: f32,
    /// Whether its ends are round.
    round: [bool; 2],
}

impl Sides {
    #[inline(always)]
    fn of(cylinder: &Cylinder) -> Sides {
        let round = [cylinder.caps & 3 == 2, cylinder.caps >> 2 & 3 == 2];
        Sides { axis: cylinder.axis(), half_length: cylinder.half_length, radius: cylinder.radius, round }
    }

    /// As [`crate::render::distance::cylinder_distance`], of a point so far from its centre.
    #[inline(always)]
    fn distance(&self, off: Vec3) -> f32 {
        let up = off.x * self.axis.x + off.y * self.axis.y + off.z * self.axis.z;
        let aside = off - self.axis * up;
        let across = (aside.x * aside.x + aside.y * aside.y + aside.z * aside.z).sqrt();
        let beyond = up.abs() - self.half_length;
        let (over_end, out) = (max(beyond, 0.0), across - self.radius);
        let round = (across * across + over_end * over_end).sqrt() - self.radius;
        let beside = max(out, 0.0);
        let flat = min(max(out, beyond), 0.0) + (beside * beside + over_end * over_end).sqrt();
        let is_round = if up > 0.0 { self.round[1] } else { self.round[0] };
        if is_round { round } else { flat }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Srgb8;
    use crate::render::settings::{Settings, View};
    use crate::render::test_shapes::{Random, camera_around};
    use crate::scene::{
        Block, ConeInstance, CylinderInstance, Placement, Scene, SphereInstance, TorusInstance, TriangleInstance,
    };
    use glam::Affine3A;

    /// Many of every kind, `opacity` 0–255.
    fn scene(opacity: u8) -> Scene {
        let mut random = Random(31);
        let color = Srgb8 { a: opacity, ..Srgb8::WHITE };
        let mut block = Block::default();
        for i in 0..300u32 {
            let mut point =
                |reach: f64| Vec3::from_array(std::array::from_fn(|_| random.between(-reach, reach) as f32));
            let (center, to) = (point(10.0), point(2.0));
            let (near, other) = ((center + to).to_array(), (center + point(2.0)).to_array());
            let (center, id) = (center.to_array(), 1 + i);
            let width = random.between(0.1, 0.6) as f32;
            match i % 12 {
                0 => {
                    let ring = TorusInstance {
                        axis: to.to_array(),
                        ring_radius: 1.2,
                        tube_radius: 0.1,
                        center,
                        color,
                        id,
                        reserved: [0; 2],
                    };
                    block.tori.push(ring);
                }
                1 => block.cones.push(ConeInstance {
                    a: center,
                    b: near,
                    radius_a: width,
                    radius_b: 0.0,
                    color,
                    id,
                    reserved: [0; 2],
                }),
                2 => {
                    let corners = [center, near, other];
                    block.triangles.push(TriangleInstance {
                        corners,
                        normals: [[0.0; 3]; 3],
                        colors: [color; 3],
                        id,
                        reserved: [0; 2],
                    });
                }
                3..6 => block.spheres.push(SphereInstance { center, radius: width, color, id }),
                kind => block.cylinders.push(CylinderInstance {
                    a: center,
                    b: near,
                    radius: width,
                    color_a: color,
                    color_b: color,
                    caps: if kind % 2 == 0 { 1 | 2 << 2 } else { 1 | 1 << 2 },
                    hidden: 0,
                    id,
                }),
            }
        }
        block.id_count = 300;
        let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
        let mut scene = Scene::from_blocks(vec![block], vec![placement]);
        scene.set_ground(true);
        scene
    }

    /// The constants of a view from around, those for the sky, and the sky's map.
    fn seen(
        scene: &Scene,
        field: &Field,
        turn: f32,
        ground_texels: u32,
    ) -> (FrameConstants, (FrameConstants, GroundMap)) {
        let settings = Settings { ground_texels, ..Settings::default() };
        let view = View::new(camera_around(turn), 64, 64);
        let frame = FrameConstants::new(scene, &view, &settings);
        let above = frame.lit_from_above(scene, &view, &settings);
        (frame, (above, field.sky_map(&above)))
    }

    #[test]
    fn sixteen_texels_together_have_the_shadow_of_each() {
        let scene = scene(255);
        let field = Field::new(&scene);
        let (mut shaded, mut partly, mut worst) = (0, 0, 0.0f32);
        for (turn, texels) in [(0.0, 48), (0.7, 47), (2.5, 33)] {
            let (frame, sky) = seen(&scene, &field, turn, texels);
            let (map, exact) = (quick_ground_map(&field, &frame, &sky), field.ground_map(&frame));
            let by_ones = field.quick_ground_map(&frame, &sky);
            assert_eq!((map.size, map.texels.len()), (exact.size, exact.texels.len()));
            for ((own, one), exact) in map.texels.iter().zip(&by_ones.texels).zip(&exact.texels) {
                shaded += u32::from(exact[0] < 0.1);
                partly += u32::from(exact[0] > 0.1 && exact[0] < 0.9);
                assert!(own[0] >= exact[0] - 1e-4, "never darker: {own:?}, {exact:?}");
                assert_eq!(own[1], one[1], "the sky is another's");
                worst = worst.max(own[0] - exact[0]);
            }
        }
        assert!(shaded > 100 && partly > 100 && worst <= 1.5 * QUICK_SHADOW + 1e-4, "{shaded} {partly} {worst}");
    }

    #[test]
    fn sixteen_texels_together_have_the_light_and_the_sky_of_each() {
        let scene = scene(255);
        let field = Field::new(&scene);
        let (mut shaded, mut closed, mut faded) = (0, 0, 0);
        for (turn, texels) in [(0.0, 48), (0.7, 47), (2.5, 33)] {
            let (frame, _) = seen(&scene, &field, turn, texels);
            let (map, exact) = (ground_map(&field, &frame), field.ground_map(&frame));
            assert_eq!((map.size, map.texels.len()), (exact.size, exact.texels.len()));
            let grid = frame.ground_grid();
            let step = 1.0 / grid.texels_per_angstrom;
            for (index, (own, exact)) in (0..).zip(map.texels.iter().zip(&exact.texels)) {
                let at = [index % grid.size[0], index / grid.size[0]];
                let [x, z] = [0, 1].map(|axis| grid.corner[axis] + (at[axis] as f32 + 0.5) * step);
                let is_near = [-step, 0.0, step]
                    .iter()
                    .any(|dx| [-step, 0.0, step].iter().any(|dz| ground_fade(&frame, x + dx, z + dz) > 0.0));
                shaded += u32::from(exact[0] < 0.9);
                closed += u32::from(exact[1] < 0.9);
                let is_same = (own[0] - exact[0]).abs() < 1e-4 && (own[1] - exact[1]).abs() < 1e-4;
                assert!(is_same || !is_near && *own == [1.0, 1.0], "{own:?} {exact:?}");
                faded += u32::from(!is_same);
            }
        }
        assert!(shaded > 200 && closed > 200 && faded > 0, "{shaded} {closed} {faded}");
    }

    #[test]
    fn what_is_see_through_is_asked_one_by_one() {
        let scene = scene(100);
        let field = Field::new(&scene);
        let (frame, sky) = seen(&scene, &field, 0.3, 40);
        assert_eq!(quick_ground_map(&field, &frame, &sky), field.quick_ground_map(&frame, &sky));
        assert_eq!(ground_map(&field, &frame), field.ground_map(&frame));
    }
}
