//! The constants of one picture, the same bytes for both renderers, and the shading that is computed from them.
//!
//! Shading here is the definition; `shaders/shade.wgsl` holds its twin, function for function.

use super::settings::{Settings, View};
use super::sky::Reach;
use crate::color::{Srgb8, srgb_from_linear};
use crate::math::{Aabb, max, min};
use crate::scene::{Background, Camera, LightFrame, Outline, Ray, Scene};
use glam::{Affine3A, Vec3, Vec4};

/// Everything shading needs. Laid out as a WGSL uniform: rows of 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct FrameConstants {
    /// Columns of the world-from-view transform: x, y, z axis and eye; the fourth components are 0, 0, 0, 1.
    pub world_from_view: [[f32; 4]; 4],
    /// Unit direction to the key light in view space; w: its strength.
    pub key: [f32; 4],
    /// Unit direction to the fill light in view space; w: its strength.
    pub fill: [f32; 4],
    /// World up in view space; w: ambient light from above.
    pub up: [f32; 4],
    /// x: ambient light from below, y: strength of the highlight, z: log2 of its exponent, w: 1 for a transparent background.
    pub ambient: [f32; 4],
    /// Linear colour of the background; w: fog strength.
    pub background: [f32; 4],
    /// x, y: 0, z: near, w: far.
    pub depth: [f32; 4],
    /// How far into the fog a point of view space lies is its dot product with (x, y, z), plus w: 0 where fog starts, 1 where it is full.
    pub fog: [f32; 4],
    /// Linear colour of the ground; w: 1 if there is a ground.
    pub ground_color: [f32; 4],
    /// x: height, y: fade start, z: 1 / (fade end − fade start), w: 0.
    pub ground: [f32; 4],
    /// x, y: world x and z of the ground's centre; z: darkness of its shadow, w: darkness of its occlusion.
    pub ground_center: [f32; 4],
    /// The ground map: world x and z of its corner, texels per ångström, and its extents in `ground_map_size`.
    pub ground_map: [f32; 4],
    /// Ground map: width and height in texels; z: penumbra sharpness, w: reach of occlusion in ångström.
    pub ground_map_size: [f32; 4],
    /// Unit direction to the key light in world space; w: how much surfaces darken towards their silhouette.
    pub key_in_world: [f32; 4],
    /// The scene's box in world space, lower corner; w: 0.
    pub bounds_min: [f32; 4],
    /// The scene's box in world space, upper corner; w: 0.
    pub bounds_max: [f32; 4],
    /// x: plane units per pixel, y, z: centre of the full picture in pixels, w: 1 for orthographic projection.
    pub grid: [f32; 4],
    /// x: how much of the ambient light is left where no sky is seen, y: how much of the key light is taken away in its
    /// shadow, z: the part of the sky that is taken to be seen where it is not asked, w: how much of the square of the sky seen is
    /// taken in place of itself.
    pub sky: [f32; 4],
    /// Width of outlines: x: in ångström per ångström of depth (perspective), y: in ångström (orthographic), both 0 for none;
    /// z: how far behind the silhouette they lie, in radii; w: 0.
    pub outline: [f32; 4],
    /// Their linear colour; w: 0.
    pub outline_color: [f32; 4],
}

/// [`FrameConstants::fog`]: it grows from the front of the scene to its back.
///
/// Along the ground, though the camera looks down on it: what stands upright is as clear below as above. Where the camera looks down
/// (or up) by more than 30° fog begins to follow the view, and does so from 60° on (both chosen).
fn fog_in_view(camera: &Camera, bounds: Aabb) -> [f32; 4] {
    if bounds.is_empty() {
        return [0.0; 4];
    }
    let (forward, upright) = (camera.forward(), camera.forward().y);
    let steep = ((upright.abs() - 0.5) / (0.75f32.sqrt() - 0.5)).clamp(0.0, 1.0);
    let along = Vec3::new(forward.x, upright * steep, forward.z).normalize_or(forward);
    let (middle, reach) = (along.dot(bounds.center() - camera.eye), along.abs().dot(bounds.size() * 0.5));
    let over = 0.5 / reach.max(1e-6);
    let in_view = camera.world_from_view.inverse() * along * over;
    [in_view.x, in_view.y, in_view.z, (reach - middle) * over]
}

/// Texel grid of the ground map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundGrid {
    /// World x and z of the corner of texel (0, 0).
    pub corner: [f32; 2],
    /// Texels per ångström.
    pub texels_per_angstrom: f32,
    /// Texels in x and z.
    pub size: [u32; 2],
}

impl FrameConstants {
    /// The constants of a scene seen by a view.
    #[must_use]
    pub fn new(scene: &Scene, view: &View, settings: &Settings) -> FrameConstants {
        let camera = view.camera;
        let light = scene.lighting;
        let world_from_view = glam::Mat3::from_quat(camera.world_from_view);
        let up_in_view = world_from_view.transpose() * Vec3::Y;
        let to_world = match light.frame {
            LightFrame::Camera => world_from_view,
            LightFrame::World => glam::Mat3::from_quat(scene.world_from_view),
        };
        let key_in_world = to_world * light.key_in_view;
        let in_view = |v: Vec3| match light.frame {
            LightFrame::Camera => v,
            LightFrame::World => world_from_view.transpose() * (to_world * v),
        };
        let bounds = scene.bounds();
        let (background, transparent) = match scene.background {
            Background::Color(color) => (color, 0.0),
            Background::Transparent => (Srgb8::WHITE, 1.0),
        };
        // Fog spans the molecule. A small one needs none: it sets in at 15 Å and is full from 60 Å on, where the eye
        // begins to need help with what is in front.
        let large = ((bounds.size().length() - 15.0) / 45.0).clamp(0.0, 1.0);
        let fog = if transparent > 0.0 || bounds.is_empty() { 0.0 } else { light.fog * large };
        let [grid, ground_map, ground_map_size] = grids(scene, view, settings, key_in_world);
        let ground = scene.ground;
        let row = |v: Vec3, w: f32| Vec4::from((v, w)).to_array();
        let color = |c: Srgb8, w: f32| row(Vec3::from(c.to_linear()), w);
        let ground_color = ground.and_then(|ground| ground.color).unwrap_or(background);
        FrameConstants {
            world_from_view: [
                row(world_from_view.x_axis, 0.0),
                row(world_from_view.y_axis, 0.0),
                row(world_from_view.z_axis, 0.0),
                row(camera.eye, 1.0),
            ],
            key: row(in_view(light.key_in_view), light.key),
            fill: row(in_view(light.fill_in_view), light.fill),
            up: row(up_in_view, light.sky),
            ambient: [light.bounce, light.specular, light.gloss_log2 as f32, transparent],
            background: color(background, fog),
            depth: [0.0, 0.0, camera.near, camera.far],
            fog: fog_in_view(&camera, bounds),
            ground_color: color(ground_color, if ground.is_some() { 1.0 } else { 0.0 }),
            ground: ground
                .map_or([0.0; 4], |g| [g.height, g.fade_start, 1.0 / (g.fade_end - g.fade_start).max(1e-6), 0.0]),
            ground_center: ground.map_or([0.0; 4], |g| [g.center_xz[0], g.center_xz[1], g.shadow, g.occlusion]),
            ground_map,
            ground_map_size,
            key_in_world: row(key_in_world, light.rim),
            bounds_min: row(if bounds.is_empty() { Vec3::ZERO } else { bounds.min }, 0.0),
            bounds_max: row(if bounds.is_empty() { Vec3::ZERO } else { bounds.max }, 0.0),
            grid,
            sky: [light.ao_floor, light.shadow, light.open_unasked, light.ao_contrast],
            outline: outline(view, light.outline),
            outline_color: color(light.outline.color, 0.0),
        }
    }

    /// The same without outlines: they are no surfaces, so that ids, depths and normals know nothing of them.
    #[must_use]
    pub fn without_outlines(self) -> FrameConstants {
        FrameConstants { outline: [0.0; 4], ..self }
    }

    /// What a surface point receives where nobody asks.
    #[must_use]
    pub fn unasked(&self) -> Reach {
        Reach { open: self.sky[2], key: 1.0 }
    }

    /// From view to world space.
    #[must_use]
    pub fn world_from_view(&self) -> Affine3A {
        let column = |i: usize| Vec4::from(self.world_from_view[i]).truncate();
        Affine3A::from_cols(column(0).into(), column(1).into(), column(2).into(), column(3).into())
    }

    /// Unit direction to the key light in world space.
    #[must_use]
    pub fn key_in_world(&self) -> Vec3 {
        Vec4::from(self.key_in_world).truncate()
    }

    /// The texel grid of the ground map.
    #[must_use]
    pub fn ground_grid(&self) -> GroundGrid {
        GroundGrid {
            corner: [self.ground_map[0], self.ground_map[1]],
            texels_per_angstrom: self.ground_map[2],
            size: [self.ground_map_size[0] as u32, self.ground_map_size[1] as u32],
        }
    }

    /// These constants with the ground map of a key light straight above, which is the same however the light turns, with twice the texels
    /// a side: others are interpolated from it.
    #[must_use]
    pub fn lit_from_above(&self, scene: &Scene, view: &View, settings: &Settings) -> FrameConstants {
        let settings = &Settings { ground_texels: settings.ground_texels * 2, ..*settings };
        let [_, ground_map, ground_map_size] = grids(scene, view, settings, Vec3::Y);
        let [x, y, z] = Vec3::Y.to_array();
        FrameConstants { ground_map, ground_map_size, key_in_world: [x, y, z, self.key_in_world[3]], ..*self }
    }

    /// Whether the ground maps of the two are the same, for one set of primitives.
    #[must_use]
    pub fn same_ground_map(&self, other: &FrameConstants) -> bool {
        // Where it fades, nothing is asked.
        self.ground == other.ground
            && self.ground_center[..2] == other.ground_center[..2]
            && self.ground_map == other.ground_map
            && self.ground_map_size == other.ground_map_size
            && self.key_in_world() == other.key_in_world()
            && self.bounds_min == other.bounds_min
            && self.bounds_max == other.bounds_max
    }

    /// Whether there is a ground, and light that can reach it from above.
    #[must_use]
    pub fn has_ground(&self) -> bool {
        self.ground_color[3] > 0.5
    }
}

/// Width of outlines and how far back they lie. As a part of the picture's height they are as wide at every size.
fn outline(view: &View, outline: Outline) -> [f32; 4] {
    let grid = view.pixel_grid();
    let width = outline.width.max(0.0) * view.height as f32 * grid.plane_per_px;
    if grid.orthographic { [0.0, width, outline.behind, 0.0] } else { [width, 0.0, outline.behind, 0.0] }
}

/// Pixel grid, ground map placement, ground map size.
fn grids(scene: &Scene, view: &View, settings: &Settings, key_in_world: Vec3) -> [[f32; 4]; 3] {
    let pixels = view.pixel_grid();
    let grid =
        [pixels.plane_per_px, pixels.center_px[0], pixels.center_px[1], if pixels.orthographic { 1.0 } else { 0.0 }];
    let Some(ground) = scene.ground else { return [grid, [0.0; 4], [0.0; 4]] };
    let bounds = scene.bounds();
    // The shadow of the box, its penumbra, and the reach of occlusion around its footprint. A light that grazes the
    // ground would throw a shadow without end: it is cut where the ground has faded.
    let rise = key_in_world.y.max(0.05);
    let (low, high) = (bounds.min.y - ground.height, bounds.max.y - ground.height);
    let (mut min, mut max) = (glam::Vec2::INFINITY, glam::Vec2::NEG_INFINITY);
    let foot_min = glam::Vec2::new(bounds.min.x, bounds.min.z);
    let foot_max = glam::Vec2::new(bounds.max.x, bounds.max.z);
    for height in [low, high] {
        let shift = -glam::Vec2::new(key_in_world.x, key_in_world.z) * (height / rise);
        let penumbra = height / rise / ground.sharpness;
        min = min.min(foot_min + shift - penumbra);
        max = max.max(foot_max + shift + penumbra);
    }
    min = min.min(foot_min - ground.occlusion_reach);
    max = max.max(foot_max + ground.occlusion_reach);
    let center = glam::Vec2::from(ground.center_xz);
    min = min.max(center - ground.fade_end);
    max = max.min(center + ground.fade_end);
    let extent = (max - min).max(glam::Vec2::splat(1e-3));
    let texels = settings.ground_texels.clamp(16, 2046) as f32;
    let per_angstrom = texels / extent.max_element();
    // One texel of free border on each side: outside the map the ground is in full light.
    let size = (extent * per_angstrom).ceil() + 2.0;
    let corner = min - 1.0 / per_angstrom;
    [grid, [corner.x, corner.y, per_angstrom, 0.0], [size.x, size.y, ground.sharpness, ground.occlusion_reach]]
}

/// A visible point of the molecule, in view space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Depth along the view axis.
    pub depth: f32,
    /// Unit normal.
    pub normal: Vec3,
    /// Linear colour.
    pub albedo: Vec3,
}

/// Visible points of the molecule, one after the other: see [`Surface`] and [`Reach`].
#[derive(Debug, Clone, Copy)]
pub struct Surfaces<'a, const N: usize> {
    /// x, y and z of the points, view space.
    pub position: &'a [[f32; N]; 3],
    /// x, y and z of the unit normals.
    pub normal: &'a [[f32; N]; 3],
    /// Red, green and blue, linear.
    pub albedo: &'a [[f32; N]; 3],
    /// Part of the sky that reaches each point.
    pub open: &'a [f32; N],
    /// Part of the key light.
    pub key: &'a [f32; N],
    /// x and y of the rays' directions; z is −1.
    pub direction: &'a [[f32; N]; 2],
}

/// Light from a point of the molecule, given what reaches it from afar; the ray that sees it is in view space, as in [`Surfaces`].
#[must_use]
pub fn shade_surface(frame: &FrameConstants, surface: &Surface, reach: Reach, ray: &Ray) -> Vec3 {
    let one = |v: Vec3| v.to_array().map(|x| [x]);
    let points = Surfaces {
        position: &one(ray.origin + ray.direction * surface.depth),
        normal: &one(surface.normal),
        albedo: &one(surface.albedo),
        open: &[reach.open],
        key: &[reach.key],
        direction: &[[ray.direction.x], [ray.direction.y]],
    };
    Vec3::from(shade_surfaces(frame, &points).map(|[part]| part))
}

/// [`shade_surface`] for many points. Written as short loops over numbers: the form that becomes vector code.
#[inline(always)]
#[must_use]
pub fn shade_surfaces<const N: usize>(frame: &FrameConstants, points: &Surfaces<'_, N>) -> [[f32; N]; 3] {
    let [key_x, key_y, key_z, key_strength] = frame.key;
    let [fill_x, fill_y, fill_z, fill_strength] = frame.fill;
    let [up_x, up_y, up_z, from_above] = frame.up;
    let [from_below, specular, gloss_log2, _] = frame.ambient;
    let (rim_strength, [floor, shadow, _, contrast]) = (frame.key_in_world[3], frame.sky);
    let [nx, ny, nz] = points.normal;
    let [dx, dy] = points.direction;
    // What the colour is multiplied with, and the highlight.
    let (mut light, mut highlight) = ([0.0f32; N], [0.0f32; N]);
    let mut half_way = [0.0f32; N];
    for i in 0..N {
        let over = 1.0 / (dx[i] * dx[i] + dy[i] * dy[i] + 1.0).sqrt();
        let (ex, ey, ez) = (-dx[i] * over, -dy[i] * over, over);
        // The fill stands for light from all around, so what hides the sky hides it.
        let seen = points.open[i] * (1.0 - contrast + contrast * points.open[i]);
        let open = floor + (1.0 - floor) * seen;
        let lit = 1.0 - shadow * (1.0 - points.key[i]);
        let to_key = nx[i] * key_x + ny[i] * key_y + nz[i] * key_z;
        let to_fill = nx[i] * fill_x + ny[i] * fill_y + nz[i] * fill_z;
        let key_light = key_strength * max(to_key, 0.0) * lit;
        let fill_light = fill_strength * max(to_fill, 0.0) * open;
        let facing_up = 0.5 + 0.5 * (nx[i] * up_x + ny[i] * up_y + nz[i] * up_z);
        let ambient = (from_below + (from_above - from_below) * facing_up) * open;
        // Towards its silhouette a surface darkens, so that white atoms stay round on a white page.
        let facing = nx[i] * ex + ny[i] * ey + nz[i] * ez;
        let aside = 1.0 - min(max(facing, 0.0), 1.0);
        let rim = 1.0 - rim_strength * aside * aside;
        light[i] = (ambient + (key_light + fill_light)) * rim;
        let (hx, hy, hz) = (key_x + ex, key_y + ey, key_z + ez);
        let half = (nx[i] * hx + ny[i] * hy + nz[i] * hz) / max(hx * hx + hy * hy + hz * hz, 1e-12).sqrt();
        // A surface turned from the light has no highlight.
        half_way[i] = if to_key > 0.0 { max(half, 0.0) } else { 0.0 };
        highlight[i] = specular * lit;
    }
    // The power is made of squares: exact on every device, and fast.
    for _ in 0..gloss_log2 as u32 {
        for gloss in &mut half_way {
            *gloss *= *gloss;
        }
    }
    let mut color = [[0.0f32; N]; 3];
    for (part, color) in color.iter_mut().enumerate() {
        let (background, fog_strength) = (frame.background[part], frame.background[3]);
        let albedo = &points.albedo[part];
        for i in 0..N {
            let [x, y, z] = [points.position[0][i], points.position[1][i], points.position[2][i]];
            let behind = into_fog(frame, [x, y, z]);
            let shaded = albedo[i] * light[i] + highlight[i] * half_way[i];
            color[i] = shaded + (background - shaded) * (fog_strength * behind * behind);
        }
    }
    color
}

/// How far into the fog a point of view space lies, 0–1.
#[inline(always)]
fn into_fog(frame: &FrameConstants, [x, y, z]: [f32; 3]) -> f32 {
    let [fx, fy, fz, start] = frame.fog;
    min(max(fx * x + fy * y + (fz * z + start), 0.0), 1.0)
}

/// Colour of an outline at a point of view space.
#[inline(always)]
#[must_use]
pub fn shade_outline(frame: &FrameConstants, position: Vec3) -> Vec3 {
    let behind = into_fog(frame, position.to_array());
    let (line, background) = (Vec4::from(frame.outline_color).truncate(), Vec4::from(frame.background).truncate());
    line + (background - line) * (frame.background[3] * behind * behind)
}

/// How much of the ground there is at a world point, 0–1.
#[inline(always)]
#[must_use]
pub fn ground_fade(frame: &FrameConstants, x_in_world: f32, z_in_world: f32) -> f32 {
    let dx = x_in_world - frame.ground_center[0];
    let dz = z_in_world - frame.ground_center[1];
    let far = (((dx * dx + dz * dz).sqrt() - frame.ground[1]) * frame.ground[2]).clamp(0.0, 1.0);
    1.0 - far * far * (3.0 - 2.0 * far)
}

/// The part of its colour that the ground shows where these parts of the key light (`visible`) and of the sky (`open`) reach it.
#[inline(always)]
#[must_use]
pub fn ground_light(frame: &FrameConstants, visible: f32, open: f32) -> f32 {
    (1.0 - frame.ground_center[2] * (1.0 - visible)) * (1.0 - frame.ground_center[3] * (1.0 - open))
}

/// Premultiplied linear colour and alpha of the ground at a world point, given how much of the key light (`visible`) and
/// of the sky (`open`) reach it.
#[must_use]
pub fn shade_ground(frame: &FrameConstants, point_in_world: Vec3, visible: f32, open: f32) -> Vec4 {
    let fade = ground_fade(frame, point_in_world.x, point_in_world.z);
    let light = ground_light(frame, visible, open);
    let background = Vec4::from(frame.background).truncate();
    let ground = Vec4::from(frame.ground_color).truncate();
    if frame.ambient[3] > 0.5 {
        // Nothing but the shadow: black, as dense as the light is missing. Others lay pictures over one another in sRGB, not in
        // linear light: with this alpha the shadow on white is the one of a picture with a white background.
        return Vec4::new(0.0, 0.0, 0.0, 1.0 - srgb_from_linear(1.0 - fade * (1.0 - light)));
    }
    Vec4::from((background + (ground * light - background) * fade, 1.0))
}

/// What is seen where there is neither molecule nor ground: premultiplied linear colour and alpha.
#[must_use]
pub fn shade_background(frame: &FrameConstants) -> Vec4 {
    if frame.ambient[3] > 0.5 { Vec4::ZERO } else { Vec4::from((Vec4::from(frame.background).truncate(), 1.0)) }
}

/// Where a view ray meets the ground from above: its `t`, infinity if it does not. `origin` and `direction` are the ray's in world space.
#[must_use]
pub fn ground_t(frame: &FrameConstants, origin: Vec3, direction: Vec3) -> f32 {
    if !frame.has_ground() || direction.y > -1e-6 || origin.y <= frame.ground[0] {
        return f32::INFINITY;
    }
    let t = (frame.ground[0] - origin.y) / direction.y;
    if t >= frame.depth[2] { t } else { f32::INFINITY }
}

/// The mean of samples (premultiplied linear colour and alpha) as a straight sRGB pixel.
#[must_use]
pub fn resolve(sum: Vec4, samples: u32) -> Srgb8 {
    let mean = sum / samples as f32;
    let straight = if mean.w > 0.0 { mean.truncate() / mean.w } else { Vec3::ZERO };
    Srgb8::from_linear(straight.to_array(), mean.w)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Block, Placement, SphereInstance};
    use glam::Quat;

    /// Balls in a row of so many ångström along z.
    fn row(length: f32) -> Scene {
        let ball = |z: f32| SphereInstance { center: [0.0, 0.0, z], radius: 0.5, color: Srgb8::WHITE, id: 1 };
        let block = Block { spheres: vec![ball(-length * 0.5), ball(length * 0.5)], id_count: 2, ..Block::default() };
        Scene::from_blocks(vec![block], vec![Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 }])
    }

    fn frame_of(scene: &Scene, turn: Quat) -> FrameConstants {
        let mut camera = scene.fitted_camera(1.0);
        camera.world_from_view = turn;
        camera.eye = camera.target - camera.forward() * 200.0;
        FrameConstants::new(scene, &View::new(camera, 64, 64), &Settings::default())
    }

    #[test]
    fn a_ground_that_fades_elsewhere_has_another_map() {
        let mut scene = row(10.0);
        scene.set_ground(true);
        let before = frame_of(&scene, Quat::IDENTITY);
        assert!(before.same_ground_map(&before));
        if let Some(ground) = &mut scene.ground {
            // Too far for the map to end there, both times.
            (ground.fade_end, ground.center_xz) = (1e4, [0.0; 2]);
        }
        let before = frame_of(&scene, Quat::IDENTITY);
        if let Some(ground) = &mut scene.ground {
            ground.center_xz[0] += 1.0;
        }
        let after = frame_of(&scene, Quat::IDENTITY);
        assert!(before.ground_map == after.ground_map && !before.same_ground_map(&after));
    }

    #[test]
    fn lights_turn_with_the_camera_or_stay_with_the_molecule() {
        let turn = Quat::from_rotation_y(1.0);
        let mut scene = row(10.0);
        let (before, after) = (frame_of(&scene, Quat::IDENTITY), frame_of(&scene, turn));
        assert_eq!((before.key, before.fill), (after.key, after.fill));
        assert!((after.key_in_world() - turn * before.key_in_world()).length() < 1e-6);
        scene.lighting.frame = LightFrame::World;
        let (before, after) = (frame_of(&scene, Quat::IDENTITY), frame_of(&scene, turn));
        assert_eq!(before.key_in_world, after.key_in_world);
        let in_view = |frame: &FrameConstants| Vec4::from(frame.key).truncate();
        assert!((turn * in_view(&after) - in_view(&before)).length() < 1e-6);
        // The default view looks the same.
        scene.lighting.frame = LightFrame::Camera;
        let same = frame_of(&scene, Quat::IDENTITY);
        assert!((in_view(&same) - in_view(&before)).length() < 1e-6);
    }

    #[test]
    fn fog_goes_from_the_front_to_the_back_of_what_is_large() {
        let scene = row(80.0);
        let frame = frame_of(&scene, Quat::IDENTITY);
        let seen = |depth: f32| shade_outline(&frame, Vec3::NEG_Z * depth);
        let (line, background) = (Vec3::from(scene.lighting.outline.color.to_linear()), Vec3::ONE);
        // The eye is 200 Å from the middle, the row reaches from 159.5 to 240.5.
        assert!((seen(159.5) - line).length() < 1e-5 && (seen(120.0) - line).length() < 1e-5);
        let back = line + (background - line) * scene.lighting.fog;
        assert!((seen(240.5) - back).length() < 1e-4 && (seen(300.0) - back).length() < 1e-5);
        // From the side the same row is shallow, and all fog lies in that.
        let aside = frame_of(&scene, Quat::from_rotation_y(std::f32::consts::FRAC_PI_2));
        assert!((shade_outline(&aside, Vec3::NEG_Z * 200.5) - back).length() < 1e-4);
        assert!(frame_of(&row(5.0), Quat::IDENTITY).background[3] == 0.0);
    }

    #[test]
    fn fog_lies_along_the_ground_until_one_looks_down_on_it() {
        let ball = |[x, y, z]: [f32; 3]| SphereInstance { center: [x, y, z], radius: 0.5, color: Srgb8::WHITE, id: 1 };
        let ends = [[-30.0, -30.0, -30.0], [30.0, 30.0, 30.0]];
        let block = Block { spheres: ends.map(ball).to_vec(), id_count: 2, ..Block::default() };
        let place = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
        let scene = Scene::from_blocks(vec![block], vec![place]);
        for (pitch, along_the_ground) in
            [(0.0f32, 1.0f32), (17.0, 1.0), (29.0, 1.0), (45.0, 0.5), (60.0, 0.0), (90.0, 0.0)]
        {
            let turn = Quat::from_rotation_x(-pitch.to_radians());
            let frame = frame_of(&scene, turn);
            let fog = |world: Vec3| {
                let eye = Vec3::from_slice(&frame.world_from_view[3][..3]);
                into_fog(&frame, (turn.inverse() * (world - eye)).to_array())
            };
            let above = fog(Vec3::Y * 20.0) - fog(Vec3::NEG_Y * 20.0);
            let of_the_view = fog(turn * Vec3::Z * 10.0) - fog(turn * Vec3::NEG_Z * 10.0);
            if along_the_ground == 1.0 {
                assert!(above.abs() < 1e-5 && (fog(Vec3::Z * 30.5) < 1e-5) && fog(Vec3::NEG_Z * 30.5) > 1.0 - 1e-5);
            } else {
                assert!(above < -0.05, "{pitch}: {above}");
            }
            if along_the_ground == 0.0 {
                assert!((fog(turn * Vec3::X * 20.0) - fog(turn * Vec3::Y * 20.0)).abs() < 1e-5, "{pitch}");
            }
            assert!(of_the_view < -0.1, "{pitch}: {of_the_view}");
        }
    }
}
