//! How a molecule is turned and framed when nothing else is said.
//!
//! Its longest axis to X, its thinnest to Z (the camera sees the broadest side), the camera looking down by
//! 17°, everything in the picture with a small margin. A small one whose atoms would hide one another is turned aside. Axes are those of the covariance of the atom positions.

use super::camera::{Camera, Projection};
use crate::math::direction_or;
use glam::{DMat3, DVec3, Mat3, Quat, Vec3};

/// How far the default camera looks down, radians: 17°.
pub const PITCH_RAD: f32 = 0.296_706;
/// Vertical opening angle of the default camera, radians: 24°, a short telephoto as in product photographs.
pub const FOV_Y_RAD: f32 = 0.418_879;
/// The ground is fully there up to this many diagonals of the scene from its centre: shadows fade before a picture that the scene fills
/// ends, those under its far ends are still there.
pub const GROUND_FADE_START: f32 = 0.25;
/// The ground has faded to the background at this many diagonals of the scene from its centre.
pub const GROUND_FADE_END: f32 = 0.8;
/// Free part of the picture on each side.
pub const MARGIN: f32 = 0.06;

/// Directions from which a turning scene is framed: between two of them 7.5° away nothing reaches out by more than 1 % (1 − cos 7.5°),
/// which the margin has room for.
pub(super) const TURNS: u32 = 24;

/// The rotation that turns the longest principal axis of the points to X and the thinnest to Z. Signs are chosen by
/// the third moments, so that the result does not depend on the order of the atoms; equal axes keep the file's.
#[must_use]
pub fn principal_rotation(points: impl Iterator<Item = Vec3> + Clone) -> Quat {
    let count = points.clone().count().max(1) as f64;
    let mean = points.clone().map(|p| p.as_dvec3()).sum::<DVec3>() / count;
    let mut covariance = DMat3::ZERO;
    for point in points.clone() {
        let d = point.as_dvec3() - mean;
        covariance += DMat3::from_cols(d * d.x, d * d.y, d * d.z);
    }
    let (mut values, mut axes) = eigen_symmetric(covariance * (1.0 / count));
    // Longest first; stable, so that a cube or a sphere stays as it is.
    let scale = values[0].max(values[1]).max(values[2]).max(1e-12);
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if values[j] > values[i] + 1e-6 * scale {
            values.swap(i, j);
            axes.swap(i, j);
        }
    }
    let mut skew = [0.0f64; 2];
    for point in points {
        let d = point.as_dvec3() - mean;
        skew[0] += d.dot(axes[0]).powi(3);
        skew[1] += d.dot(axes[1]).powi(3);
    }
    let significant = 1e-4 * count * scale.powf(1.5);
    for (axis, skew) in axes.iter_mut().zip(skew) {
        let first = axis.to_array().into_iter().find(|x| x.abs() > 1e-6).unwrap_or(1.0);
        // More mass to the left and below: the long tail of a molecule points right and up.
        if skew < -significant || (skew.abs() <= significant && first < 0.0) {
            *axis = -*axis;
        }
    }
    axes[2] = axes[0].cross(axes[1]);
    let world_from_block = DMat3::from_cols(axes[0], axes[1], axes[2]).transpose();
    Quat::from_mat3(&Mat3::from_cols_array(&world_from_block.to_cols_array().map(|x| x as f32))).normalize()
}

/// Whether points turned so are a sheet: thinner than a quarter of their second extent.
#[must_use]
pub fn is_flat(points: impl Iterator<Item = Vec3>, turn: Quat) -> bool {
    let (low, high) = points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), point| {
        let point = turn * point;
        (low.min(point), high.max(point))
    });
    high.z - low.z < 0.25 * (high.y - low.y)
}

/// Of small molecules whose atoms hide one another, the turn aside that shows more of them; else none.
///
/// Symmetric ones (a sandwich complex, the corner of a crystal) stand with their atoms in rows when their axes are those of the picture. Asked
/// are 10°, 20° and 30° to both sides: less than half of what a face is seen from. The least of those is taken that hides nearly as
/// little as the best, and none unless it hides much less than no turn. The balls are turned by `turn` before, and looked down
/// on by [`PITCH_RAD`], in parallel.
#[must_use]
pub fn turn_aside(balls: impl Iterator<Item = (Vec3, f32)>, turn: Quat) -> Quat {
    let balls: Vec<(Vec3, f32)> = balls.take(MOST_ASIDE + 1).collect();
    if balls.len() > MOST_ASIDE {
        return Quat::IDENTITY;
    }
    let hidden = |angle_rad: f32| {
        let in_view = Quat::from_rotation_x(PITCH_RAD) * Quat::from_rotation_y(angle_rad) * turn;
        let seen: Vec<(Vec3, f32)> = balls.iter().map(|&(center, radius)| (in_view * center, radius)).collect();
        hidden_part(&seen)
    };
    let unturned = hidden(0.0);
    if unturned < 0.1 {
        return Quat::IDENTITY;
    }
    let turns = [10.0f32, -10.0, 20.0, -20.0, 30.0, -30.0].map(f32::to_radians).map(|angle| (angle, hidden(angle)));
    let least = turns.iter().fold(unturned, |least, turn| least.min(turn.1));
    if least > 0.6 * unturned {
        return Quat::IDENTITY;
    }
    let nearly = turns.iter().find(|turn| turn.1 <= least + 0.15 * unturned);
    nearly.map_or(Quat::IDENTITY, |turn| Quat::from_rotation_y(turn.0))
}

/// Larger molecules are not turned aside: whichever way, half of them is behind the rest.
const MOST_ASIDE: usize = 256;

/// How much of balls is behind nearer ones, looking along −z: 0 where none is, 1 where only one is seen. Of two balls by how far
/// they overlap along the line between their centres.
fn hidden_part(balls: &[(Vec3, f32)]) -> f32 {
    let hidden = balls.iter().map(|&(center, radius)| {
        let in_front = balls.iter().filter(|other| other.0.z > center.z + 1e-3);
        let cover = in_front.map(|&(other, other_radius)| {
            let apart = (other - center).truncate().length();
            ((radius + other_radius - apart) / (2.0 * radius.min(other_radius)).max(1e-6)).clamp(0.0, 1.0)
        });
        cover.sum::<f32>().min(1.0)
    });
    hidden.sum::<f32>() / balls.len().max(1) as f32
}

/// The rotation that turns a cell so that **c** is up and **a** comes to the viewer, less 25° to the left, so that
/// rows of atoms do not hide one another.
#[must_use]
pub fn cell_rotation([a, b, c]: [Vec3; 3]) -> Quat {
    let up = direction_or(c, Vec3::Y);
    // Perpendicular to the bc face, on the side of **a**, whichever hand the vectors are of.
    let back = direction_or(b.cross(c) * b.cross(c).dot(a).signum(), up.any_orthonormal_vector());
    let world_from_cell = Mat3::from_cols(up.cross(back), up, back).transpose();
    (Quat::from_rotation_y(-YAW_RAD) * Quat::from_mat3(&world_from_cell)).normalize()
}

/// How far a drawn cell is turned from its face, radians: 25°.
const YAW_RAD: f32 = 0.436_332;

/// Eigenvalues and unit eigenvectors of a symmetric matrix, by cyclic Jacobi rotations.
pub(super) fn eigen_symmetric(matrix: DMat3) -> ([f64; 3], [DVec3; 3]) {
    let mut m = matrix.to_cols_array_2d();
    let mut v = DMat3::IDENTITY.to_cols_array_2d(); // v[k] is the k-th vector
    for _ in 0..32 {
        let off = m[0][1].abs() + m[0][2].abs() + m[1][2].abs();
        if off <= 1e-15 * (m[0][0].abs() + m[1][1].abs() + m[2][2].abs()) {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if m[p][q] == 0.0 {
                continue;
            }
            let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for row in &mut m {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            for k in 0..3 {
                (m[p][k], m[q][k]) = (c * m[p][k] - s * m[q][k], s * m[p][k] + c * m[q][k]);
                (v[p][k], v[q][k]) = (c * v[p][k] - s * v[q][k], s * v[p][k] + c * v[q][k]);
            }
        }
    }
    ([m[0][0], m[1][1], m[2][2]], v.map(DVec3::from_array))
}

/// The camera that has all spheres in the picture, as near as the margin allows, looking along `world_from_view`'s −z.
///
/// Perspective: each side of the frustum is pushed until it touches the spheres; the eye is where they meet.
#[must_use]
pub fn frame(
    spheres: impl Iterator<Item = (Vec3, f32)> + Clone,
    world_from_view: Quat,
    perspective: bool,
    aspect: f32,
) -> Camera {
    let view_from_world = Mat3::from_quat(world_from_view).transpose();
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for (center, radius) in spheres.clone() {
        let center = view_from_world * center;
        low = low.min(center - radius);
        high = high.max(center + radius);
    }
    if !low.cmple(high).all() {
        (low, high) = (Vec3::NEG_ONE, Vec3::ONE);
    }
    let middle = (low + high) * 0.5;
    let size = (high - low).max(Vec3::splat(1e-3));
    let fill = 1.0 - 2.0 * MARGIN;
    let eye_in_view;
    let projection;
    if perspective {
        let half_y = (FOV_Y_RAD * 0.5).tan() * fill;
        let half_x = half_y * aspect;
        // Side i holds the spheres if n·(c − eye) ≥ r for its inward normal n; `reach` is the tightest n·c − r.
        let mut reach = [f32::INFINITY; 4];
        let normal = |slope: f32| 1.0 / (1.0 + slope * slope).sqrt();
        let (nx, ny) = (normal(half_x), normal(half_y));
        for (center, radius) in spheres {
            let c = view_from_world * center - middle; // small numbers: scenes are centred
            reach[0] = reach[0].min(nx * (c.x - half_x * c.z) - radius);
            reach[1] = reach[1].min(nx * (-c.x - half_x * c.z) - radius);
            reach[2] = reach[2].min(ny * (c.y - half_y * c.z) - radius);
            reach[3] = reach[3].min(ny * (-c.y - half_y * c.z) - radius);
        }
        if reach.iter().any(|r| !r.is_finite()) {
            reach = [-1.0; 4];
        }
        // n·eye = reach on both sides of a pair gives the depth that the pair needs and the centre across.
        let depth_x = -(reach[0] + reach[1]) / (2.0 * nx * half_x);
        let depth_y = -(reach[2] + reach[3]) / (2.0 * ny * half_y);
        let across_x = (reach[0] - reach[1]) / (2.0 * nx);
        let across_y = (reach[2] - reach[3]) / (2.0 * ny);
        // The near plane stays in front of the nearest sphere.
        let z = depth_x.max(depth_y).max(size.z * 0.5 + 0.1 * size.length());
        eye_in_view = middle + Vec3::new(across_x, across_y, z);
        projection = Projection::Perspective { fov_y_rad: FOV_Y_RAD };
    } else {
        let height = size.y.max(size.x / aspect) / fill;
        eye_in_view = middle + Vec3::new(0.0, 0.0, size.z * 0.5 + size.length());
        projection = Projection::Orthographic { height };
    }
    let far = eye_in_view.z - low.z;
    Camera {
        eye: world_from_view * eye_in_view,
        world_from_view,
        projection,
        near: 1e-3 * size.length(),
        far: far + GROUND_FADE_END * size.length(),
        target: world_from_view * middle,
        shift: [0.0; 2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn extent(points: &[Vec3], rotation: Quat) -> Vec3 {
        let turned: Vec<Vec3> = points.iter().map(|&p| rotation * p).collect();
        let low = turned.iter().copied().reduce(Vec3::min).unwrap();
        let high = turned.iter().copied().reduce(Vec3::max).unwrap();
        high - low
    }

    #[test]
    fn the_longest_axis_comes_to_x_and_the_thinnest_to_z() {
        let mut points = Vec::new();
        for i in 0..200 {
            let f = i as f32;
            points.push(Vec3::new((f * 0.7).sin() * 1.0, (f * 1.3).sin() * 9.0, (f * 2.1).sin() * 4.0));
        }
        let tilt = Quat::from_euler(glam::EulerRot::XYZ, 0.4, 1.1, -0.8);
        let tilted: Vec<Vec3> = points.iter().map(|&p| tilt * p + Vec3::splat(50.0)).collect();
        let size = extent(&tilted, principal_rotation(tilted.iter().copied()));
        assert!((size - Vec3::new(18.0, 8.0, 2.0)).abs().max_element() < 0.7, "{size}");
    }

    #[test]
    fn what_hides_itself_is_turned_aside_and_nothing_else() {
        // Two rings face to face along X, as in a sandwich complex: from the front each is a row of balls behind balls.
        let rings = (0..10).map(|i| {
            let angle = (i % 5) as f32 * 72.0f32.to_radians();
            (Vec3::new(if i < 5 { -1.66 } else { 1.66 }, 1.22 * angle.cos(), 1.22 * angle.sin()), 0.42)
        });
        let turn = turn_aside(rings.clone(), Quat::IDENTITY);
        let angle_deg = turn.to_axis_angle().1.to_degrees();
        assert!((9.0..31.0).contains(&angle_deg) && (turn * Vec3::Y - Vec3::Y).length() < 1e-6, "{angle_deg}");
        let hidden = |turn: Quat| {
            let in_view = Quat::from_rotation_x(PITCH_RAD) * turn;
            hidden_part(&rings.clone().map(|(center, radius)| (in_view * center, radius)).collect::<Vec<_>>())
        };
        assert!(hidden(turn) <= 0.6 * hidden(Quat::IDENTITY));
        // The same rings upright to the viewer hide nothing.
        assert_eq!(turn_aside(rings, Quat::from_rotation_y(std::f32::consts::FRAC_PI_2 - 0.6)), Quat::IDENTITY);
        // Nor does a flat ring, or nothing at all; a large heap stays as it is.
        let flat = (0..6).map(|i| (Quat::from_rotation_z(i as f32 * 1.047) * Vec3::X * 1.4, 0.42));
        assert_eq!(turn_aside(flat, Quat::IDENTITY), Quat::IDENTITY);
        assert_eq!(turn_aside(std::iter::empty(), Quat::IDENTITY), Quat::IDENTITY);
        let heap = (0..1000).map(|i| (Vec3::new((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32), 0.4));
        assert_eq!(turn_aside(heap, Quat::IDENTITY), Quat::IDENTITY);
    }

    #[test]
    fn balls_behind_others_count_as_far_as_they_overlap() {
        let ball = |x: f32, z: f32| (Vec3::new(x, 0.0, z), 0.5);
        assert_eq!(hidden_part(&[ball(0.0, 0.0), ball(0.0, 3.0)]), 0.5);
        assert_eq!(hidden_part(&[ball(0.0, 0.0), ball(0.5, 3.0)]), 0.25);
        assert_eq!(hidden_part(&[ball(0.0, 0.0), ball(1.0, 3.0)]), 0.0);
        assert_eq!(hidden_part(&[]), 0.0);
    }

    #[test]
    fn a_cell_stands_on_its_base_with_a_to_the_viewer() {
        let turn = cell_rotation([Vec3::new(3.0, 0.0, 0.0), Vec3::new(-1.5, 2.6, 0.0), Vec3::new(0.0, 0.0, 5.0)]);
        assert!((turn * Vec3::Z - Vec3::Y).length() < 1e-6);
        // **b** in the plane of the picture but for the 25°, so that the bc face looks at the viewer.
        let (a, b) = (turn * Vec3::X, turn * Vec3::new(-0.5, 0.75f32.sqrt(), 0.0));
        assert!(a.z > 0.5 && b.x > 0.9 && a.y.abs() < 1e-6, "{a} {b}");
        let left_handed = cell_rotation([Vec3::NEG_X, Vec3::Y, Vec3::Z]);
        assert!((left_handed * Vec3::NEG_X).z > 0.9 && left_handed.is_normalized());
        assert!(is_flat([Vec3::ZERO, Vec3::X * 9.0, Vec3::Y * 9.0, Vec3::Z].into_iter(), Quat::IDENTITY));
        assert!(!is_flat([Vec3::ZERO, Vec3::X * 9.0, Vec3::Y * 3.0, Vec3::Z].into_iter(), Quat::IDENTITY));
    }

    #[test]
    fn degenerate_clouds_give_a_rotation() {
        for points in
            [vec![], vec![Vec3::ONE], vec![Vec3::ONE; 5], vec![Vec3::ZERO, Vec3::Z], vec![Vec3::NEG_Y, Vec3::Y]]
        {
            let rotation = principal_rotation(points.iter().copied());
            assert!(rotation.is_finite() && rotation.is_normalized(), "{points:?}");
        }
        let rotation = principal_rotation([Vec3::NEG_Z, Vec3::Z].into_iter());
        assert!((rotation * Vec3::Z).x.abs() > 0.999);
    }

    #[test]
    fn everything_is_in_the_picture_and_fills_it() {
        let spheres: Vec<(Vec3, f32)> = (0..60)
            .map(|i| (Vec3::new(i as f32 * 0.8, (i as f32).sin() * 7.0, (i as f32 * 2.0).cos() * 9.0), 1.5))
            .collect();
        for perspective in [true, false] {
            for aspect in [0.5f32, 1.0, 16.0 / 9.0, 4.0] {
                let camera = frame(spheres.iter().copied(), Quat::from_rotation_x(-0.3), perspective, aspect);
                let view = camera.view_from_world();
                let grid = camera.pixel_grid((aspect * 1000.0) as u32, 1000);
                let mut largest = 0.0f32;
                for &(center, radius) in &spheres {
                    let c = view.transform_point3(center);
                    let depth = if grid.orthographic { 1.0 } else { -c.z };
                    assert!(-c.z - radius > camera.near);
                    assert!(-c.z + radius < camera.far);
                    for (x, half) in [(c.x, grid.center_px[0]), (c.y, grid.center_px[1])] {
                        let edge = (x.abs() + radius) / depth / grid.plane_per_px / half;
                        assert!(edge < 1.0, "{perspective} {aspect}: {edge}");
                        largest = largest.max(edge);
                    }
                }
                assert!(largest > 0.8, "{perspective} {aspect}: {largest}");
            }
        }
    }
}
