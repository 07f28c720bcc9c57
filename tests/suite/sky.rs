//! Sky visibility (`--channel ao`) against rays in f64, one after the other through the whole scene, along the same directions from
//! 10,000 random visible points of each scene; from both renderers, and by a program that was started for it.

use crate::scenes;
use ballstick::import::{ImportOptions, read_path};
use ballstick::render::cpu::{CpuRenderer, reference};
use ballstick::render::sky::{START_OFFSET, directions};
use ballstick::render::solids::{Cone, Cylinder, Solids, Torus, Triangle};
use ballstick::render::{GBuffer, Renderer, SkyVisibility, View};
use ballstick::scene::{Item, Scene, SceneOptions, Style};
use glam::{Affine3A, DVec2, DVec3};
use rayon::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

const DIRECTIONS: u32 = 64;
const POINTS: usize = 10_000;

/// Whether a ray from `p` along a unit direction meets a ball.
fn meets_ball(center: DVec3, radius: f64, p: DVec3, d: DVec3) -> bool {
    let to = center - p;
    let along = to.dot(d);
    let away = to.length_squared();
    away < radius * radius || (along > 0.0 && away - along * along < radius * radius)
}

/// Along the axis from the middle, and across it.
fn split(axis: DVec3, v: DVec3) -> (f64, DVec3) {
    let y = v.dot(axis);
    (y, v - axis * y)
}

/// The crossings of a ray with a capped round solid whose radius at `y` of `-h..h` is `middle + slope * y`; `caps` says which ends are
/// closed by a disc, and `round` by a ball.
fn meets_round(
    (center, axis, h): (DVec3, DVec3, f64),
    (middle, slope): (f64, f64),
    (discs, balls): ([bool; 2], [bool; 2]),
    p: DVec3,
    d: DVec3,
) -> bool {
    let ((qy, qa), (dy, da)) = (split(axis, p - center), split(axis, d));
    let radius = |y: f64| middle + slope * y;
    let is_closed = discs.into_iter().zip(balls).all(|(disc, ball)| disc || ball);
    if is_closed && qy.abs() < h && qa.length() < radius(qy) {
        return true; // a solid hides light from what is inside
    }
    let (rho, sigma) = (radius(qy), slope * dy);
    let (a, b, c) = (da.length_squared() - sigma * sigma, qa.dot(da) - sigma * rho, qa.length_squared() - rho * rho);
    let root = (b * b - a * c).sqrt();
    let on_side = |t: &f64| *t > 0.0 && (qy + dy * t).abs() <= h && rho + sigma * t >= 0.0;
    if [(-b - root) / a, (-b + root) / a].iter().any(on_side) {
        return true;
    }
    [-1.0, 1.0].into_iter().zip(discs.into_iter().zip(balls)).any(|(sign, (disc, ball))| {
        let t = (sign * h - qy) / dy;
        let on_disc = disc && t > 0.0 && (qa + da * t).length() <= radius(sign * h);
        // Of a ball the half that sticks out: its other half is inside, or nothing where the stick is open.
        let out = axis * sign;
        let to = center + out * h - p;
        let (along, end) = (to.dot(d), radius(sign * h));
        let root = (end * end - (to.length_squared() - along * along)).sqrt();
        let on_ball = |t: &f64| *t > 0.0 && (d * *t - to).dot(out) >= 0.0;
        on_disc || (ball && [along - root, along + root].iter().any(on_ball))
    })
}

fn meets_stick(stick: &Cylinder, p: DVec3, d: DVec3) -> bool {
    let kind = |kind: u32| [stick.caps & 3 == kind, stick.caps >> 2 & 3 == kind];
    let place = (stick.center.as_dvec3(), stick.axis().as_dvec3(), f64::from(stick.half_length));
    meets_round(place, (f64::from(stick.radius), 0.0), (kind(1), kind(2)), p, d)
}

fn meets_cone(cone: &Cone, p: DVec3, d: DVec3) -> bool {
    let [a, b] = cone.radii.map(f64::from);
    let h = f64::from(cone.half_length);
    let place = (cone.center.as_dvec3(), cone.axis().as_dvec3(), h);
    meets_round(place, ((a + b) / 2.0, (b - a) / (2.0 * h)), ([true; 2], [false; 2]), p, d)
}

/// By a march whose steps are the distance.
fn meets_torus(torus: &Torus, p: DVec3, d: DVec3) -> bool {
    let (center, axis) = (torus.center.as_dvec3(), torus.axis().as_dvec3());
    let (ring, tube) = (f64::from(torus.ring_radius), f64::from(torus.tube_radius));
    if !meets_ball(center, ring + tube, p, d) {
        return false;
    }
    let end = (center - p).dot(d) + ring + tube;
    let mut t = 0.0;
    while t < end {
        let (y, across) = split(axis, p + d * t - center);
        let distance = DVec2::new(across.length() - ring, y).length() - tube;
        if distance < 1e-7 {
            return true;
        }
        t += distance;
    }
    false
}

fn meets_triangle(triangle: &Triangle, p: DVec3, d: DVec3) -> bool {
    let [a, b, c] = triangle.corners.map(|corner| triangle.center.as_dvec3() + corner.as_dvec3() - p);
    let volumes = [d.dot(b.cross(c)), d.dot(c.cross(a)), d.dot(a.cross(b))];
    let same_side = volumes.iter().all(|v| *v >= 0.0) || volumes.iter().all(|v| *v <= 0.0);
    same_side && a.dot((b - a).cross(c - a)) / d.dot((b - a).cross(c - a)) > 0.0
}

/// Whether anything that is more there than not stands in the way.
fn is_free(solids: &Solids, p: DVec3, d: DVec3) -> bool {
    let spheres = solids.spheres.len();
    let counts = [spheres, solids.cylinders.len(), solids.cones.len(), solids.tori.len()];
    let mut first = 0;
    let starts = counts.map(|count| {
        let start = first;
        first += count;
        start
    });
    let hides = |index: usize| solids.opacity(index) >= 128;
    let any =
        |start: usize, count: usize, meets: &dyn Fn(usize) -> bool| (0..count).any(|i| meets(i) && hides(start + i));
    let ball = |i: usize| {
        let sphere = &solids.spheres[i];
        meets_ball(sphere.center.as_dvec3(), f64::from(sphere.radius), p, d)
    };
    !(any(0, spheres, &ball)
        || any(starts[1], solids.cylinders.len(), &|i| meets_stick(&solids.cylinders[i], p, d))
        || any(starts[2], solids.cones.len(), &|i| meets_cone(&solids.cones[i], p, d))
        || any(starts[3], solids.tori.len(), &|i| meets_torus(&solids.tori[i], p, d))
        || any(first, solids.triangles.len(), &|i| meets_triangle(&solids.triangles[i], p, d)))
}

/// Pixels whose surface is a primitive's, drawn at random, and what rays find there.
fn by_rays(scene: &Scene, view: &View, seen: &GBuffer) -> Vec<(usize, f64)> {
    let is_primitive = |i: &usize| !matches!(seen.id[*i], GBuffer::BACKGROUND | GBuffer::GROUND);
    let covered: Vec<usize> = (0..seen.id.len()).filter(is_primitive).collect();
    assert!(covered.len() > POINTS / 2, "only {} pixels show anything", covered.len());
    // Lehmer's generator: the same points every time.
    let mut state = 42u64;
    let mut pixels: Vec<usize> = (0..POINTS)
        .map(|_| {
            state = state * 48_271 % 0x7fff_ffff;
            covered[state as usize % covered.len()]
        })
        .collect();
    pixels.sort_unstable();
    let (solids, grid) = (Solids::new(scene, Affine3A::IDENTITY), view.pixel_grid());
    let world_from_view = view.camera.view_from_world().inverse();
    let sky: Vec<DVec3> = directions(DIRECTIONS).into_iter().map(|d| d.as_dvec3().normalize()).collect();
    let open = |pixel: &usize| {
        let (x, y) = ((pixel % seen.width as usize) as f32, (pixel / seen.width as usize) as f32);
        let ray = grid.ray(grid.plane(x + 0.5, y + 0.5));
        let point = world_from_view.transform_point3(ray.origin + ray.direction * seen.depth[*pixel]).as_dvec3();
        let n = world_from_view.transform_vector3(seen.normal[*pixel].into()).as_dvec3().normalize();
        // As far above the surface as rays start, and as the point is rounded.
        let start = point + n * f64::from(START_OFFSET.max(1e-6 * seen.depth[*pixel]));
        let (mut free, mut all) = (0.0, 0.0);
        for &d in &sky {
            let weight = n.dot(d).max(0.0);
            all += weight;
            free += if weight > 0.0 && is_free(&solids, start, d) { weight } else { 0.0 };
        }
        (*pixel, free / all)
    };
    pixels.par_iter().map(open).collect()
}

fn rms(want: &[(usize, f64)], got: &SkyVisibility) -> f64 {
    let squares: f64 = want.iter().map(|&(pixel, open)| (f64::from(got.open[pixel]) - open).powi(2)).sum();
    (squares / want.len() as f64).sqrt()
}

fn molecule(file: &str, options: &SceneOptions) -> (Scene, View) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data").join(file);
    let molecule = read_path(&path, &ImportOptions::default()).unwrap().records.remove(0);
    let molecule = ballstick::bonds::assign(molecule, &Default::default());
    let scene = Scene::new(&[Item::of(&molecule)], options);
    let view = View::new(scene.fitted_camera(16.0 / 9.0), 640, 360);
    (scene, view)
}

/// Scenes with every kind of primitive, in the open and deep inside.
fn all_scenes() -> Vec<(String, Scene, View)> {
    let style = |style| SceneOptions { style, ..SceneOptions::default() };
    let mut all: Vec<(String, Scene, View)> = [
        ("caffeine.sdf", style(Style::BallAndStick)),
        ("caffeine.sdf", style(Style::SpaceFilling)),
        ("1crn.pdb", style(Style::BallAndStick)),
        ("1crn.pdb", SceneOptions { perspective: false, ..style(Style::Licorice) }),
    ]
    .into_iter()
    .map(|(file, options)| {
        let (scene, view) = molecule(file, &options);
        (format!("{file} {}", options.style.name()), scene, view)
    })
    .collect();
    for case in scenes::all() {
        let names = ["all_primitives_on_ground", "cones_truncated", "tori", "see_through_half", "sticks_mixed_caps"];
        if names.contains(&case.name) {
            let view = View { width: 4 * case.view.width, height: 4 * case.view.height, ..case.view };
            all.push((case.name.to_owned(), case.scene, view));
        }
    }
    all
}

#[test]
fn both_renderers_see_as_much_of_the_sky_as_rays_do() {
    let mut cpu = CpuRenderer::new();
    #[cfg(feature = "gpu")]
    let mut gpu = crate::parity::gpu();
    for (name, scene, view) in all_scenes() {
        let scene = Arc::new(scene);
        cpu.load(Arc::clone(&scene)).unwrap();
        let seen = cpu.gbuffer(&view).unwrap();
        let want = by_rays(&scene, &view, &seen);
        let mean = want.iter().map(|(_, open)| open).sum::<f64>() / want.len() as f64;
        let by_cpu = cpu.sky_visibility(&view, DIRECTIONS).unwrap();
        let off = rms(&want, &by_cpu);
        println!("{name}: {mean:.3} of the sky in the mean; rms {off:.5} by the CPU");
        assert!(off <= 0.03 && mean > 0.05 && mean < 0.999, "{name}: {off}, mean {mean}");
        let is_nothing = |i: &usize| matches!(seen.id[*i], GBuffer::BACKGROUND | GBuffer::GROUND);
        assert!((0..seen.id.len()).filter(is_nothing).all(|i| by_cpu.open[i] == 1.0), "{name}");
        #[cfg(feature = "gpu")]
        if let Some(gpu) = &mut gpu {
            gpu.load(Arc::clone(&scene)).unwrap();
            let by_gpu = gpu.sky_visibility(&view, DIRECTIONS).unwrap();
            // At the rim of a primitive the two may see different ones.
            let ids = gpu.gbuffer(&view).unwrap().id;
            let same: Vec<(usize, f64)> =
                want.iter().copied().filter(|(pixel, _)| ids[*pixel] == seen.id[*pixel]).collect();
            assert!(same.len() * 1000 > want.len() * 995, "{name}: {} of {} ids", same.len(), want.len());
            let off = rms(&same, &by_gpu);
            let apart = by_cpu.open.iter().zip(&by_gpu.open).zip(ids.iter().zip(&seen.id));
            let apart: Vec<f64> =
                apart.filter(|(_, (a, b))| a == b).map(|((a, b), _)| f64::from(a - b).powi(2)).collect();
            let between = (apart.iter().sum::<f64>() / apart.len() as f64).sqrt();
            println!("{name}: rms {off:.5} by the GPU, {between:.5} between the two");
            assert!(off <= 0.03 && between <= 0.01, "{name}: {off} {between}");
        }
    }
}

#[test]
fn the_reference_sees_the_same() {
    for (name, scene, view) in all_scenes().into_iter().filter(|(name, ..)| !name.starts_with("1crn")) {
        let view = View { width: view.width / 4, height: view.height / 4, ..view };
        let mut cpu = CpuRenderer::new();
        cpu.load(Arc::new(scene.clone())).unwrap();
        let (want, got) =
            (reference::sky_visibility(&scene, &view, DIRECTIONS), cpu.sky_visibility(&view, DIRECTIONS).unwrap());
        assert_eq!((want.width, want.height), (got.width, got.height));
        let squares: f64 = want.open.iter().zip(&got.open).map(|(a, b)| f64::from(a - b).powi(2)).sum();
        let off = (squares / want.open.len() as f64).sqrt();
        println!("{name}: rms {off:.5}");
        assert!(off < 0.005, "{name}: {off}");
    }
}

#[test]
fn the_program_writes_what_the_renderer_sees() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("ao.npy");
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_ballstick"))
        .args(["render", "--renderer", "cpu", "--size", "640x360", "--channel", "ao", "-o"])
        .arg(&out)
        .arg(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/caffeine.sdf"))
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let file = std::fs::read(out).unwrap();
    let values: Vec<f32> = file[file.len() - 640 * 360 * 4..]
        .chunks_exact(4)
        .map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()))
        .collect();
    let (scene, view) = molecule("caffeine.sdf", &SceneOptions::default());
    let mut cpu = CpuRenderer::new();
    cpu.load(Arc::new(scene.clone())).unwrap();
    let want = by_rays(&scene, &view, &cpu.gbuffer(&view).unwrap());
    let off = rms(&want, &SkyVisibility { width: 640, height: 360, open: values });
    assert!(off <= 0.03, "{off}");
}
