//! What is behind the primitives, and the finished pixels, a row of sixteen at a time: the vector twins of
//! [`super::shader::Shader::backdrop`] and [`crate::render::frame::resolve`].

use super::behind::Mask;
use super::lanes::{LANES, Lanes};
use super::shader::Shader;
use crate::color::{Srgb8, levels_from_linear};
use crate::render::frame::{ground_fade, resolve, shade_background};
use crate::scene::PixelGrid;
use glam::{Vec2, Vec4};

/// A row of pixels.
pub(super) struct Row<'a> {
    pub(super) shader: &'a Shader<'a>,
    pub(super) grid: &'a PixelGrid,
    /// Its first pixel in the full picture.
    pub(super) corner: [u32; 2],
    pub(super) samples: u32,
    /// The background's colour, opaque.
    pub(super) background: Srgb8,
}

/// What the samples of some pixels gave: sums of premultiplied linear red, green and blue, and how many saw a primitive.
pub(super) type Sums<'a> = [&'a [f32]; 4];

impl Row<'_> {
    /// Finishes pixels of which the samples are known.
    #[inline(always)]
    pub(super) fn finish(&self, sums: Sums<'_>, pixels: &mut [Srgb8]) {
        for (start, pixels) in (0..).step_by(LANES).zip(pixels.chunks_mut(LANES)) {
            let part = sums.map(|sums| &sums[start..start + pixels.len()]);
            self.finish_some(self.corner[0] + start as u32, part, pixels);
        }
    }

    /// Linear colour of ground or background in the pixels from `x` on.
    #[inline(always)]
    fn behind(&self, x: u32) -> [Lanes; 3] {
        let (mut u, mut v) = ([0.0f32; LANES], [0.0f32; LANES]);
        for lane in 0..LANES {
            u[lane] = ((x + lane as u32) as f32 + 0.5 - self.grid.center_px[0]) * self.grid.plane_per_px;
            v[lane] = (self.grid.center_px[1] - (self.corner[1] as f32 + 0.5)) * self.grid.plane_per_px;
        }
        opaque(self.shader, self.grid, &u, &v)
    }

    #[inline(always)]
    fn finish_some(&self, x: u32, sums: Sums<'_>, pixels: &mut [Srgb8]) {
        let all = self.samples as f32;
        let frame = self.shader.frame;
        let seen = sums[3];
        if frame.ambient[3] > 0.5 {
            // See-through ground: alpha takes a power, which is no vector code.
            for (i, pixel) in pixels.iter_mut().enumerate() {
                let mut sum = Vec4::from_array(sums.map(|sums| sums[i]));
                if sum.w < all {
                    let center = self.grid.plane((x + i as u32) as f32 + 0.5, self.corner[1] as f32 + 0.5);
                    sum += self.shader.backdrop(&self.grid.ray(center)) * (all - sum.w);
                }
                *pixel = resolve(sum, self.samples);
            }
            return;
        }
        let (mut least, mut most) = (all, 0.0f32);
        for &seen in seen {
            least = if seen < least { seen } else { least };
            most = if seen > most { seen } else { most };
        }
        if most == 0.0 && !frame.has_ground() {
            pixels.fill(self.background);
            return;
        }
        let behind = if least >= all { [[0.0; LANES]; 3] } else { self.behind(x) };
        let first = behind.map(|part| part[0]);
        if most == 0.0 && (0..3).all(|part| behind[part].iter().all(|&c| c == first[part])) {
            pixels.fill(Srgb8::from_linear(first, 1.0));
            return;
        }
        let mut unseen = [0.0f32; LANES];
        for (unseen, &seen) in unseen.iter_mut().zip(seen) {
            *unseen = all - seen;
        }
        let mut rgb = [[0.0f32; LANES]; 3];
        for part in 0..3 {
            let mut mean = [0.0f32; LANES];
            for (mean, &sum) in mean.iter_mut().zip(sums[part]) {
                *mean = sum;
            }
            for lane in 0..LANES {
                mean[lane] = (mean[lane] + behind[part][lane] * unseen[lane]) / all;
            }
            rgb[part] = mean;
        }
        pixels.iter_mut().zip(bytes(&rgb)).for_each(|(pixel, shown)| *pixel = shown);
    }
}

/// What is behind the primitives of a picture.
pub(super) struct Backdrop<'a> {
    shader: &'a Shader<'a>,
    grid: &'a PixelGrid,
    /// The background's colour.
    plain: Srgb8,
    /// The last colour of a whole group, and how it is shown.
    last: ([u32; 3], Srgb8),
    /// The background's colour as a group shows it.
    flat: Srgb8,
}

impl<'a> Backdrop<'a> {
    #[inline(always)]
    pub(super) fn new(shader: &'a Shader<'a>, grid: &'a PixelGrid) -> Backdrop<'a> {
        let background = shade_background(shader.frame);
        let plain = resolve(background, 1);
        let last = (
            background.truncate().to_array().map(f32::to_bits),
            Srgb8::from_linear(background.truncate().to_array(), 1.0),
        );
        Backdrop { shader, grid, plain, last, flat: last.1 }
    }

    /// Whether it is one colour everywhere.
    #[inline(always)]
    pub(super) fn is_plain(&self) -> bool {
        !self.shader.frame.has_ground()
    }

    /// That colour.
    #[inline(always)]
    pub(super) fn plain(&self) -> Srgb8 {
        self.plain
    }

    /// The background's colour if nothing else is behind all these pixels of the full picture (left, top, right, bottom): no ground, or one
    /// that looks like it, in full light. `None` if that is not sure.
    #[inline(always)]
    pub(super) fn flat_in(&self, [left, top, right, bottom]: [u32; 4]) -> Option<Srgb8> {
        let (frame, ground_map) = (self.shader.frame, self.shader.ground_map);
        if frame.ambient[3] > 0.5 || frame.ground_color[..3] != frame.background[..3] {
            return None;
        }
        let PixelGrid { center_px, plane_per_px, orthographic, .. } = *self.grid;
        let [left, right] = [left, right].map(|x| (x as f32 - center_px[0]) * plane_per_px);
        let [top, bottom] = [top, bottom].map(|y| (center_px[1] - y as f32) * plane_per_px);
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        let (mut some, mut all) = (false, true);
        let m = &frame.world_from_view;
        for (u, v) in [(left, top), (right, top), (left, bottom), (right, bottom)] {
            let turned = |axis: usize| m[0][axis] * u + m[1][axis] * v;
            // From where the corner's ray starts, and where it goes: linear in the plane, so that what holds at the corners holds between.
            let (origin, fall) =
                if orthographic { (m[3][1] + turned(1), -m[2][1]) } else { (m[3][1], turned(1) - m[2][1]) };
            let (above, falls) = (origin > frame.ground[0], fall < 0.0);
            (some, all) = (some | (above & falls), all & above & (fall <= -1e-6));
            let depth = (frame.ground[0] - origin) / fall;
            let aside = if orthographic { 1.0 } else { depth };
            let at = |axis: usize| turned(axis) * aside - m[2][axis] * depth + m[3][axis];
            let at = Vec2::new(at(0), at(2));
            (low, high) = (low.min(at), high.max(at));
        }
        if !some {
            return Some(self.flat);
        }
        let (grid, [width, height]) = (frame.ground_grid(), ground_map.size);
        let corner = Vec2::from(grid.corner);
        let end = corner + Vec2::new(width as f32, height as f32) / grid.texels_per_angstrom;
        // The light is that of the map from half a texel inside of it on.
        let beside = high.cmplt(corner).any() || low.cmpgt(end).any();
        (all && beside).then_some(self.flat)
    }

    /// Pixels in which nothing is seen; `u`, `v` are the plane coordinates of their centres.
    #[inline(always)]
    pub(super) fn alone(&mut self, [u, v]: [&Lanes; 2]) -> [Srgb8; LANES] {
        if self.shader.frame.ambient[3] > 0.5 {
            return self.under(&[[0.0; LANES]; 3], &[0; LANES], [u, v]);
        }
        let color = opaque(self.shader, self.grid, u, v);
        let mut differ = 0u32;
        for part in &color {
            for &light in part {
                differ |= light.to_bits() ^ part[0].to_bits();
            }
        }
        if differ == 0 {
            let first = color.map(|part| part[0]);
            let key = first.map(f32::to_bits);
            if key != self.last.0 {
                self.last = (key, Srgb8::from_linear(first, 1.0));
            }
            return [self.last.1; LANES];
        }
        bytes(&color)
    }

    /// Pixels of one sample: the linear light of what is seen, what is behind it where nothing is. `u`, `v` are the plane
    /// coordinates of their centres.
    #[inline(always)]
    pub(super) fn under(&self, light: &[Lanes; 3], seen: &Mask, [u, v]: [&Lanes; 2]) -> [Srgb8; LANES] {
        if self.shader.frame.ambient[3] > 0.5 {
            let mut pixels = [self.plain; LANES];
            // See-through ground: alpha takes a power, which is no vector code.
            for (lane, pixel) in pixels.iter_mut().enumerate() {
                let behind = || self.shader.backdrop(&self.grid.ray((u[lane], v[lane])));
                let light = Vec4::new(light[0][lane], light[1][lane], light[2][lane], 1.0);
                *pixel = resolve(if seen[lane] != 0 { light } else { behind() }, 1);
            }
            return pixels;
        }
        let mut color = *light;
        if seen.contains(&0) {
            let behind = opaque(self.shader, self.grid, u, v);
            for part in 0..3 {
                for lane in 0..LANES {
                    color[part][lane] = if seen[lane] != 0 { light[part][lane] } else { behind[part][lane] };
                }
            }
        }
        bytes(&color)
    }
}

/// Linear colours as they are shown.
#[inline(always)]
fn bytes(color: &[Lanes; 3]) -> [Srgb8; LANES] {
    let [red, green, blue] = color;
    let mut differ = 0;
    for lane in 0..LANES {
        differ |= (red[lane].to_bits() ^ green[lane].to_bits()) | (red[lane].to_bits() ^ blue[lane].to_bits());
    }
    let red = levels_from_linear(red);
    // The ground mostly is grey.
    let [green, blue] = if differ == 0 { [red; 2] } else { [levels_from_linear(green), levels_from_linear(blue)] };
    let mut pixels = [0u32; LANES];
    for lane in 0..LANES {
        pixels[lane] = (red[lane] | green[lane] << 8 | blue[lane] << 16 | 0xFF00_0000).to_le();
    }
    bytemuck::cast(pixels)
}

/// Linear colour of ground or background at plane coordinates.
#[inline(always)]
fn opaque(shader: &Shader<'_>, grid: &PixelGrid, u: &Lanes, v: &Lanes) -> [Lanes; 3] {
    let frame = shader.frame;
    let background = shade_background(frame).to_array();
    let mut color: [Lanes; 3] = std::array::from_fn(|part| [background[part]; LANES]);
    if !frame.has_ground() {
        return color;
    }
    let t = shader.ground_beyond(grid.orthographic, u, v);
    if t.iter().all(|&t| t == f32::INFINITY) {
        return color;
    }
    let m = &frame.world_from_view;
    let (mut px, mut pz) = ([0.0f32; LANES], [0.0f32; LANES]);
    for lane in 0..LANES {
        let depth = if t[lane] < f32::INFINITY { t[lane] } else { 0.0 };
        // The ray's point is (u, v, 0) − t z with parallel rays, t (u, v, −1) otherwise.
        let aside = if grid.orthographic { 1.0 } else { depth };
        let at = |axis: usize| m[0][axis] * (u[lane] * aside) + m[1][axis] * (v[lane] * aside) - m[2][axis] * depth;
        (px[lane], pz[lane]) = (at(0) + m[3][0], at(2) + m[3][2]);
    }
    let light = shader.ground_map.light(frame, &px, &pz);
    for lane in 0..LANES {
        let fade = ground_fade(frame, px[lane], pz[lane]);
        let fade = if t[lane] < f32::INFINITY { fade } else { 0.0 };
        for part in 0..3 {
            color[part][lane] = background[part] + (frame.ground_color[part] * light[lane] - background[part]) * fade;
        }
    }
    color
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::field::Field;
    use crate::render::frame::FrameConstants;
    use crate::render::solids::Solids;
    use crate::render::test_shapes::Random;
    use crate::render::{Settings, View};
    use crate::scene::{Block, Camera, Placement, Projection, Scene, SphereInstance};
    use glam::{Affine3A, Quat, Vec3};

    #[test]
    fn what_is_said_to_be_flat_is_the_background_in_every_pixel() {
        let ball = SphereInstance { center: [0.0; 3], radius: 2.0, color: Srgb8::WHITE, id: 1 };
        let placement = Placement { block: 0, world_from_block: Affine3A::IDENTITY, first_id: 0 };
        let block = Block { spheres: vec![ball], id_count: 1, ..Block::default() };
        let mut scene = Scene::from_blocks(vec![block], vec![placement]);
        scene.set_ground(true);
        let (field, solids) = (Field::new(&scene), Solids::default());
        let settings = Settings { samples: 1, ground_texels: 64, ao: 0, shadow: false };
        let mut random = Random(21);
        let (mut flat, mut not) = (0, 0);
        for number in 0..60 {
            let turn = random.between(0.0, 6.0) as f32;
            let tilt = random.between(-1.2, 0.3) as f32;
            let world_from_view = Quat::from_rotation_y(turn) * Quat::from_rotation_x(tilt);
            let projection = match number % 3 {
                0 => Projection::Orthographic { height: 60.0 },
                _ => Projection::Perspective { fov_y_rad: 1.0 },
            };
            let eye = world_from_view * Vec3::new(0.0, 0.0, 30.0);
            let camera = Camera {
                eye,
                world_from_view,
                projection,
                near: 0.1,
                far: 1000.0,
                target: Vec3::ZERO,
                shift: [0.0; 2],
            };
            let view = View::new(camera, 96, 64);
            let frame = FrameConstants::new(&scene, &view, &settings);
            let (map, grid) = (field.ground_map(&frame), view.pixel_grid());
            let shader = Shader::new(&frame, &solids, &map);
            let mut backdrop = Backdrop::new(&shader, &grid);
            for y in (0..64).step_by(4) {
                for x in [0, 32, 64] {
                    let Some(color) = backdrop.flat_in([x, y, x + 32, y + 4]) else {
                        not += 1;
                        continue;
                    };
                    flat += 1;
                    for (x, y) in (x..x + 32).flat_map(|x| (y..y + 4).map(move |y| (x, y))) {
                        let (u, v) = grid.plane(x as f32 + 0.5, y as f32 + 0.5);
                        let seen = backdrop.alone([&[u; LANES], &[v; LANES]])[0];
                        assert_eq!(seen, color, "view {number}, pixel {x} {y}");
                    }
                }
            }
        }
        assert!(flat > 300 && not > 300, "{flat} {not}");
    }
}
