//! The ground's map for pictures in motion: [`Field::quick_ground_map`], of sixteen texels at a time.
//!
//! Neighbouring texels walk through nearly the same nodes of the field's hierarchy: a node is entered if what is in it may darken any of
//! the sixteen. The light of each is the least that any primitive lets through, within [`QUICK_SHADOW`], as that of one by one is.
//!
//! What is see-through, and what is drawn from copies, is asked one by one.

use super::lanes::{LANES, Lanes};
use super::simd::{Work, widest};
use crate::math::{max, min};
use crate::render::field::{Field, GroundMap, QUICK_SHADOW, Way, eased};
use crate::render::frame::FrameConstants;
use crate::render::hierarchy::WIDTH;
use crate::render::solids::{Cylinder, Primitive, Sphere};
use glam::Vec3;
use rayon::prelude::*;

/// Texels on a side of what is found together.
const SIDE: usize = 4;

/// The ground's map: the open sky is interpolated from a map of it.
pub(super) fn quick_ground_map(field: &Field, frame: &FrameConstants, sky: &(FrameConstants, GroundMap)) -> GroundMap {
    let solids = field.solids();
    let is_simple = frame.has_ground() && !solids.is_empty() && !solids.see_through;
    let origin = Vec3::new(0.0, frame.ground[0], 0.0);
    let Some(way) = Way::to_light(frame, origin, QUICK_SHADOW).filter(|_| is_simple) else {
        return field.quick_ground_map(frame, sky);
    };
    let grid = frame.ground_grid();
    let [width, height] = grid.size.map(|side| side as usize);
    let step = 1.0 / grid.texels_per_angstrom;
    let [across, down] = [width.div_ceil(SIDE), height.div_ceil(SIDE)];
    let place =
        |x: usize, z: usize| [grid.corner[0] + (x as f32 + 0.5) * step, grid.corner[1] + (z as f32 + 0.5) * step];
    let groups = (0..across * down).into_par_iter().map(|group| {
        let corner = [group % across * SIDE, group / across * SIDE];
        let at = |lane: usize| place(corner[0] + lane % SIDE, corner[1] + lane / SIDE);
        let p: [[f32; 2]; LANES] = std::array::from_fn(at);
        let p = [0, 1].map(|axis| p.map(|p| p[axis]));
        let mut ways = Ways { field, p, way, light: [1.0; LANES] };
        widest(Walk(&mut ways));
        ways.light
    });
    let groups: Vec<Lanes> = groups.collect();
    let mut texels = Vec::with_capacity(width * height);
    for z in 0..height {
        for x in 0..width {
            let key = eased(groups[z / SIDE * across + x / SIDE][z % SIDE * SIDE + x % SIDE]);
            let [world_x, world_z] = place(x, z);
            texels.push([key, sky.1.at(&sky.0, Vec3::new(world_x, frame.ground[0], world_z))[1]]);
        }
    }
    GroundMap { size: grid.size, texels }
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

/// The walk through the hierarchy, as work for [`widest`].
struct Walk<'w, 'a>(&'w mut Ways<'a>);

impl Work for Walk<'_, '_> {
    #[inline(always)]
    fn run(self) {
        self.0.walk();
    }
}

impl Ways<'_> {
    #[inline(always)]
    fn walk(&mut self) {
        let (hierarchy, solids) = (self.field.hierarchy(), self.field.solids());
        let Some(top) = hierarchy.depth().checked_sub(1) else { return };
        let mut waiting = vec![(top, 0usize)];
        while let Some((level, node)) = waiting.pop() {
            // What was found since may have left nothing to darken.
            if self.nearest_to(hierarchy.levels[level] as usize + node).is_none() {
                continue;
            }
            if level == 0 {
                let first = node * WIDTH;
                for &index in &hierarchy.order[first..(first + WIDTH).min(hierarchy.order.len())] {
                    match solids.primitive(index as usize) {
                        Primitive::Sphere(i) => self.pass_sphere(&solids.spheres[i]),
                        Primitive::Cylinder(i) => self.pass_cylinder(&solids.cylinders[i]),
                        Primitive::Cone(_) | Primitive::Torus(_) | Primitive::Triangle(_) => self.pass_slow(index),
                    }
                }
                continue;
            }
            let (start, end) = (hierarchy.levels[level - 1] as usize, hierarchy.levels[level] as usize);
            let first = waiting.len();
            let mut keys = [0.0f32; WIDTH];
            for child in node * WIDTH..((node + 1) * WIDTH).min(end - start) {
                if let Some(key) = self.nearest_to(start + child) {
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

    /// How near to any way what is in a box of the field's hierarchy may be; `None` if it darkens none.
    #[inline(always)]
    fn nearest_to(&self, number: usize) -> Option<f32> {
        let (b, least) = (&self.field.hierarchy().boxes[number], self.field.least_light_in(number));
        // What is see-through there leaves more than there is left anywhere.
        if least > 0.0 && !self.light.iter().any(|&light| least < light - self.way.slack) {
            return None;
        }
        let (center, radius) = ((b.min + b.max) * 0.5, (b.max - b.min).length() * 0.5);
        self.nearest_ball(center, radius)
    }

    /// As [`Ways::nearest_to`], of a ball.
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

    /// Takes note of what a sphere lets through: where the way is nearest to its centre.
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

    /// Takes note of what a cylinder lets through: where the way is nearest to its axis, as [`Field`] has it.
    #[inline(always)]
    fn pass_cylinder(&mut self, cylinder: &Cylinder) {
        let Way { p, to_light: d, start, sharpness, .. } = self.way;
        let (axis, half_length) = (cylinder.axis(), cylinder.half_length);
        let cosine = d.dot(axis);
        let sine_squared = 1.0 - cosine * cosine;
        // Parallel: every point of the axis is as near as the middle.
        let over = if sine_squared > 1e-6 { 1.0 / sine_squared } else { 0.0 };
        let [round_a, round_b] = [cylinder.caps & 3 == 2, cylinder.caps >> 2 & 3 == 2];
        for lane in 0..LANES {
            let to = cylinder.center - Vec3::new(self.p[0][lane], p.y, self.p[1][lane]);
            let along = to.x * d.x + to.y * d.y + to.z * d.z;
            let on_axis = to.x * axis.x + to.y * axis.y + to.z * axis.z;
            let s = min(max((cosine * along - on_axis) * over, -half_length), half_length);
            let t = max(along + cosine * s, start);
            let off = d * t - to;
            let up = off.x * axis.x + off.y * axis.y + off.z * axis.z;
            let aside = off - axis * up;
            let across = (aside.x * aside.x + aside.y * aside.y + aside.z * aside.z).sqrt();
            let beyond = up.abs() - half_length;
            let (over_end, out) = (max(beyond, 0.0), across - cylinder.radius);
            let round = (across * across + over_end * over_end).sqrt() - cylinder.radius;
            let beside = max(out, 0.0);
            let flat = min(max(out, beyond), 0.0) + (beside * beside + over_end * over_end).sqrt();
            let is_round = if up > 0.0 { round_b } else { round_a };
            let distance = if is_round { round } else { flat };
            self.light[lane] = min(self.light[lane], max(sharpness * distance / t, 0.0));
        }
    }

    /// Takes note of what any other primitive lets through, one way after the other.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Srgb8;
    use crate::render::settings::{Settings, View};
    use crate::render::test_shapes::Random;
    use crate::scene::{
        Block, Camera, ConeInstance, CylinderInstance, Placement, Projection, Scene, SphereInstance, TorusInstance,
        TriangleInstance,
    };
    use glam::{Affine3A, Quat};

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
        let world_from_view = Quat::from_rotation_y(turn) * Quat::from_rotation_x(-0.2);
        let camera = Camera {
            eye: world_from_view * Vec3::new(0.0, 0.0, 100.0),
            world_from_view,
            projection: Projection::Perspective { fov_y_rad: 0.5 },
            near: 0.1,
            far: 300.0,
            target: Vec3::ZERO,
            shift: [0.0; 2],
        };
        let settings = Settings { ground_texels, ..Settings::default() };
        let view = View::new(camera, 64, 64);
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
    fn what_is_see_through_is_asked_one_by_one() {
        let scene = scene(100);
        let field = Field::new(&scene);
        let (frame, sky) = seen(&scene, &field, 0.3, 40);
        assert_eq!(quick_ground_map(&field, &frame, &sky), field.quick_ground_map(&frame, &sky));
    }
}
