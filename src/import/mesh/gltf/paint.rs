//! Materials: what a vertex's colour is of factor, texture and its own.

use super::super::texture::{Texture, Wrap};
use super::super::{Reading, UNCOLORED};
use super::accessor::Buffers;
use crate::color::{Srgb8, linear_from_srgb};
use gltf_json::Root;
use gltf_json::material::AlphaMode;
use gltf_json::mesh::Primitive;
use gltf_json::texture::{Info, WrappingMode};
use gltf_json::validation::Checked;
use serde_json::Value;
use std::collections::HashMap;

/// What a material makes of the colours of vertices; linear.
pub(super) struct Paint {
    factor: [f32; 4],
    mode: AlphaMode,
    cutoff: f32,
    pub(super) texture: Option<TextureUse>,
}

/// A picture and how it lies on a mesh.
pub(super) struct TextureUse {
    /// The number of its image.
    image: usize,
    /// The set of places in it that vertices have.
    pub(super) set: u32,
    wraps: [Wrap; 2],
    /// `KHR_texture_transform`: offset, rotation in radians, scale.
    offset: [f32; 2],
    rotation_rad: f32,
    scale: [f32; 2],
}

pub(super) fn of(root: &Root, primitive: &Primitive, has_colors: bool) -> Paint {
    let material = primitive.material.as_ref().and_then(|index| root.materials.get(index.value()));
    match material {
        Some(material) => {
            let pbr = &material.pbr_metallic_roughness;
            let mode = match material.alpha_mode {
                Checked::Valid(mode) => mode,
                Checked::Invalid => AlphaMode::Opaque,
            };
            let cutoff = material.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0);
            let texture = pbr.base_color_texture.as_ref().and_then(|info| texture_use(root, info));
            Paint { factor: pbr.base_color_factor.0, mode, cutoff, texture }
        }
        None if has_colors => Paint { factor: [1.0; 4], mode: AlphaMode::Blend, cutoff: 0.5, texture: None },
        None => {
            let Srgb8 { r, g, b, .. } = UNCOLORED;
            let [r, g, b] = [r, g, b].map(|byte| linear_from_srgb(f32::from(byte) / 255.0));
            Paint { factor: [r, g, b, 1.0], mode: AlphaMode::Opaque, cutoff: 0.5, texture: None }
        }
    }
}

fn texture_use(root: &Root, info: &Info) -> Option<TextureUse> {
    let texture = root.textures.get(info.index.value())?;
    let sampler = texture.sampler.as_ref().and_then(|index| root.samplers.get(index.value()));
    let wrap = |mode: Option<Checked<WrappingMode>>| match mode {
        Some(Checked::Valid(WrappingMode::ClampToEdge)) => Wrap::Clamp,
        Some(Checked::Valid(WrappingMode::MirroredRepeat)) => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    let transform = info.extensions.as_ref().and_then(|extensions| extensions.others.get("KHR_texture_transform"));
    let number = |value: Option<&Value>, usual: f32| value.and_then(Value::as_f64).map_or(usual, |x| x as f32);
    let field = |name: &str| transform.and_then(|transform| transform.get(name));
    let pair = |name: &str, usual: f32| [0, 1].map(|i| number(field(name).and_then(|pair| pair.get(i)), usual));
    let set = field("texCoord").and_then(Value::as_u64).and_then(|set| u32::try_from(set).ok());
    Some(TextureUse {
        image: texture.source.value(),
        set: set.unwrap_or(info.tex_coord),
        wraps: [wrap(sampler.map(|sampler| sampler.wrap_s)), wrap(sampler.map(|sampler| sampler.wrap_t))],
        offset: pair("offset", 0.0),
        rotation_rad: number(field("rotation"), 0.0),
        scale: pair("scale", 1.0),
    })
}

impl Paint {
    pub(super) fn color(&self, vertex: Option<[f32; 4]>, texel: Option<[f32; 4]>) -> Srgb8 {
        let (vertex, texel) = (vertex.unwrap_or([1.0; 4]), texel.unwrap_or([1.0; 4]));
        let [r, g, b, a] = [0, 1, 2, 3].map(|i| self.factor[i] * vertex[i] * texel[i]);
        let alpha = match self.mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask => f32::from(u8::from(a >= self.cutoff)),
            AlphaMode::Blend => a,
        };
        Srgb8::from_linear([r, g, b], alpha)
    }
}

/// The pictures that were asked for, each read once.
#[derive(Default)]
pub(super) struct Pictures {
    list: Vec<Texture>,
    number_of: HashMap<usize, Option<usize>>,
}

impl Pictures {
    /// The number of a picture, which is read if it was not yet; `None` if it cannot be, which is said once.
    pub(super) fn number(
        &mut self,
        root: &Root,
        texture: &TextureUse,
        buffers: &Buffers<'_>,
        reading: &mut Reading<'_>,
    ) -> Option<usize> {
        if let Some(&number) = self.number_of.get(&texture.image) {
            return number;
        }
        let number = match read(root, texture.image, buffers, reading) {
            Ok(picture) => {
                self.list.push(picture);
                Some(self.list.len() - 1)
            }
            Err(why) => {
                let message = format!("image {} is left out: {why}; the material's own colour is taken", texture.image);
                reading.diagnostics.warn(None, message);
                None
            }
        };
        self.number_of.insert(texture.image, number);
        number
    }

    pub(super) fn sample(&self, number: usize, texture: &TextureUse, [u, v]: [f32; 2]) -> [f32; 4] {
        let Some(picture) = self.list.get(number) else { return [1.0; 4] };
        let (sin, cos) = texture.rotation_rad.sin_cos();
        let [x, y] = [u * texture.scale[0], v * texture.scale[1]];
        let [dx, dy] = texture.offset;
        // Turned as the extension's matrices are.
        picture.sample([cos * x + sin * y + dx, -sin * x + cos * y + dy], texture.wraps)
    }
}

fn read(root: &Root, image: usize, buffers: &Buffers<'_>, reading: &mut Reading<'_>) -> Result<Texture, String> {
    let image = root.images.get(image).ok_or("it is not there")?;
    let text = |error: crate::Error| error.to_string();
    let bytes = match (&image.buffer_view, &image.uri) {
        (Some(view), _) => buffers.view(root, view.value()).map_err(text)?.to_vec(),
        (None, Some(uri)) => match uri.strip_prefix("data:") {
            Some(data) => super::data_uri(data).ok_or("it is no base64 data URI")?,
            None => reading.folder.read(&super::percent_decoded(uri)).map_err(text)?,
        },
        (None, None) => return Err("it has neither a buffer view nor a URI".to_owned()),
    };
    Texture::decode(&bytes, &mut reading.picture_bytes)
}
