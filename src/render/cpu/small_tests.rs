use super::*;
use crate::render::View;
use crate::render::test_shapes::{Random, Shape, cylinder};
use crate::scene::{Camera, Projection};
use glam::{DVec3, Quat};

/// Place in the picture in pixels, and depth; `None` if the near plane is beyond.
fn seen(view: &View, point: DVec3) -> Option<([f64; 2], f64)> {
    let (grid, depth) = (view.pixel_grid(), -point.z);
    let over = 1.0 / f64::from(grid.plane_per_px) / if grid.orthographic { 1.0 } else { depth };
    let at = [f64::from(grid.center_px[0]) + point.x * over, f64::from(grid.center_px[1]) - point.y * over];
    (depth >= f64::from(view.camera.near)).then_some((at, depth))
}

#[test]
fn bounds_of_small_balls_and_sticks_hold_every_point_in_the_picture() {
    let mut random = Random(7);
    let mut small = 0;
    for number in 0..20_000 {
        let projection = match number % 3 {
            0 => Projection::Orthographic { height: 40.0 },
            1 => Projection::Perspective { fov_y_rad: 0.5 },
            _ => Projection::Perspective { fov_y_rad: 1.8 },
        };
        let camera = Camera {
            eye: Vec3::ZERO,
            world_from_view: Quat::IDENTITY,
            projection,
            near: 0.5,
            far: 2000.0,
            target: Vec3::NEG_Z,
            shift: [0.0; 2],
        };
        let view = View::new(camera, 640, 480);
        let framing = Framing::new(&view);
        let distance = random.log_between(1.0, 3000.0);
        // So that parallel rays meet it, too.
        let angle = if number % 3 == 0 { 15.0 / distance.max(15.0) } else { 1.2 };
        let center = random.in_view(distance, angle);
        let sphere = Sphere { center: center.as_vec3(), radius: random.log_between(0.01, 3.0) as f32 };
        let (axis, length) = (random.direction(), random.log_between(0.2, 4.0));
        let caps = [random.below(3), random.below(3)];
        let cylinder = cylinder(center, axis, length, f64::from(sphere.radius) * 0.5, caps).unwrap();
        let points = |p: Vec3| p.to_array().map(|x| [x; LANES]);
        let place = |p: Vec3, radius: f32| {
            let (at, reach, is_small) = framing.small_ones(&points(p), &[radius; LANES]);
            assert!(at.iter().chain([&reach]).all(|lanes| lanes.iter().all(|x| *x == lanes[0] || x.is_nan())));
            (is_small[0] != 0).then(|| (at.map(|axis| f64::from(axis[0])), f64::from(reach[0])))
        };
        let mut holds = |shape: &Shape, ends: [Vec3; 2], radius: f32| {
            let [Some((a, reach_a)), Some((b, reach_b))] = ends.map(|end| place(end, radius)) else { return };
            small += 1;
            let reach = reach_a.max(reach_b) + f64::from(SLACK);
            let nearest = Framing::no_nearer((-ends[0].z).min(-ends[1].z) - radius);
            for _ in 0..24 {
                let point = shape.point(&mut random, true);
                let Some((at, depth)) = seen(&view, point) else { continue };
                if !(0.0..640.0).contains(&at[0]) || !(0.0..480.0).contains(&at[1]) {
                    continue; // what lies beside the picture is stretched
                }
                assert!(f64::from(nearest) <= depth, "{point}: {nearest}, {depth}");
                for axis in 0..2 {
                    let (low, high) = (a[axis].min(b[axis]) - reach, a[axis].max(b[axis]) + reach);
                    assert!((low..=high).contains(&at[axis]), "{point}: {low}, {at:?}, {high}");
                }
            }
        };
        holds(&Shape::sphere(&sphere), [sphere.center; 2], sphere.radius);
        holds(&Shape::cylinder(&cylinder), cylinder.ends(), cylinder.radius);
    }
    assert!(small > 8000, "{small}");
}

#[test]
fn pixels_are_those_with_samples_between_two_places_and_hardly_any_more() {
    let mut random = Random(3);
    for (side, samples) in [(4u32, vec![[0.5f32; 2]]), (2, vec![[0.125, 0.125], [0.375, 0.625], [0.875, 0.375]])] {
        let range = |axis: usize| {
            let at = samples.iter().map(|sample| sample[axis]);
            [at.clone().fold(1.0, min), at.fold(0.0, max)]
        };
        let window =
            Window { corner: [300.0, 120.0], size: [64.0, 48.0], samples: [range(0), range(1)], is_simple: side == 4 };
        for _ in 0..2000 {
            let axis = random.below(2) as usize;
            let low: f32 = random.between(90.0, 400.0) as f32;
            let high = low + random.log_between(0.01, 90.0) as f32;
            let [from, to] = window.pixels(axis, &[low; LANES], &[high; LANES]).map(|lanes| lanes[7]);
            assert!(to <= window.size[axis] as u32 && from <= window.size[axis] as u32);
            for pixel in 0..window.size[axis] as u32 {
                let at = window.corner[axis] + pixel as f32;
                let has = |slack: f32| {
                    samples.iter().any(|sample| (low - slack..=high + slack).contains(&(at + sample[axis])))
                };
                let is_between =
                    at + window.samples[axis][1] >= low - 0.05 && at + window.samples[axis][0] <= high + 0.05;
                let is_in = (from..to).contains(&pixel);
                assert!(is_in || !has(0.0), "{low} {high}: {pixel} is missing");
                assert!(!is_in || is_between, "{low} {high}: {pixel} is too much");
            }
        }
    }
}
