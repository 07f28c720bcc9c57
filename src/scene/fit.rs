//! How a molecule is turned and framed when nothing else is said.
//!
//! Its longest axis to X, its thinnest to Z (the camera sees the broadest side), the camera looking down by
//! 17°, everything in the picture with a small margin. Axes are those of the covariance of the atom positions.

use super::camera::{Camera, Projection};
use crate::math::direction_or;
use glam::{DMat3, DVec3, Mat3, Quat, Vec3};

/// How far the default camera looks down, radians: 17°.
pub const PITCH_RAD: f32 = 0.296_706;
/// Vertical opening angle of the default camera, radians: 24°, a short telephoto as in product photographs.
pub const FOV_Y_RAD: f32 = 0.418_879;
/// The ground has faded to the background at this many diagonals of the scene from its centre.
pub const GROUND_FADE_END: f32 = 6.0;
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
