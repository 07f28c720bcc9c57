//! Accessors: typed views of buffers. Whatever the file says about offsets, strides and counts, nothing outside its
//! buffers is read, and no more is made than there are bytes.

use crate::error::{Error, Result};
use gltf_json::Root;
use gltf_json::accessor::{Accessor, ComponentType, Type};
use gltf_json::validation::Checked;
use std::borrow::Cow;

/// The bytes of the file's buffers.
#[derive(Default)]
pub(super) struct Buffers<'a> {
    list: Vec<Cow<'a, [u8]>>,
}

/// The elements of an accessor.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
    component: ComponentType,
    components: usize,
}

impl<'a> Buffers<'a> {
    pub(super) fn push(&mut self, bytes: Cow<'a, [u8]>) {
        self.list.push(bytes);
    }

    /// Vectors of `least` to 4 components as f32, integers scaled to 0–1 (or −1–1) where the accessor says so; the components
    /// that are not there are 1.
    pub(super) fn vectors(&self, root: &Root, index: usize, least: usize) -> Result<Vec<[f32; 4]>> {
        let accessor = accessor(root, index)?;
        let elements = self.elements(root, index, accessor)?;
        if elements.components < least || elements.components > 4 {
            let found = elements.components;
            return Err(Error::input(
                None,
                format!("accessor {index}: expected {least} to 4 components, found {found}"),
            ));
        }
        let size = elements.component.size();
        let vector = |bytes: &[u8]| {
            let mut vector = [1.0; 4];
            for (slot, bytes) in vector.iter_mut().zip(bytes.chunks_exact(size).take(elements.components)) {
                *slot = component(bytes, elements.component, accessor.normalized);
            }
            vector
        };
        Ok(elements.iter().map(vector).collect())
    }

    /// Indices of vertices.
    pub(super) fn indices(&self, root: &Root, index: usize) -> Result<Vec<u32>> {
        let accessor = accessor(root, index)?;
        let elements = self.elements(root, index, accessor)?;
        let read: fn(&[u8]) -> u32 = match (elements.component, elements.components) {
            (ComponentType::U8, 1) => |bytes| bytes.first().map_or(0, |&byte| u32::from(byte)),
            (ComponentType::U16, 1) => |bytes| bytes.first_chunk().map_or(0, |&two| u32::from(u16::from_le_bytes(two))),
            (ComponentType::U32, 1) => |bytes| bytes.first_chunk().map_or(0, |&four| u32::from_le_bytes(four)),
            _ => return Err(Error::input(None, format!("accessor {index}: expected whole numbers as indices"))),
        };
        Ok(elements.iter().map(read).collect())
    }

    fn elements(&self, root: &Root, index: usize, accessor: &Accessor) -> Result<Elements<'_>> {
        let wrong = |what: &str| Error::input(None, format!("accessor {index}: {what}"));
        if accessor.sparse.is_some() {
            return Err(Error::Unsupported(format!(
                "accessor {index} of the glTF file is sparse, which is not read; export the mesh without that"
            )));
        }
        let (Checked::Valid(component), Checked::Valid(type_)) = (&accessor.component_type, &accessor.type_) else {
            return Err(wrong("its component type or type is none of glTF"));
        };
        let components = match type_ {
            Type::Scalar => 1,
            Type::Vec2 => 2,
            Type::Vec3 => 3,
            Type::Vec4 => 4,
            Type::Mat2 | Type::Mat3 | Type::Mat4 => return Err(wrong("expected numbers or vectors, found matrices")),
        };
        let Some(view) = &accessor.buffer_view else { return Err(wrong("it has no buffer view")) };
        let view = root.buffer_views.get(view.value()).ok_or_else(|| wrong("its buffer view is not there"))?;
        let buffer = self.list.get(view.buffer.value()).ok_or_else(|| wrong("its buffer is not there"))?;
        let size = |value: u64| usize::try_from(value).ok();
        let part = || -> Option<&[u8]> {
            let start = size(view.byte_offset.map_or(0, |offset| offset.0))?;
            let bytes = buffer.get(start..start.checked_add(size(view.byte_length.0)?)?)?;
            bytes.get(size(accessor.byte_offset.map_or(0, |offset| offset.0))?..)
        };
        let bytes = part().ok_or_else(|| wrong("it reaches beyond its buffer, or the buffer is cut off"))?;
        let element = component.0.size() * components;
        let stride = view.byte_stride.map_or(element, |stride| stride.0);
        let count = size(accessor.count.0).unwrap_or(usize::MAX);
        // Elements that overlap would make much of few bytes.
        let end = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(element));
        if stride < element || end.is_none_or(|end| end > bytes.len()) {
            return Err(wrong(&format!("expected {count} elements of {element} bytes, found {} bytes", bytes.len())));
        }
        Ok(Elements { bytes, stride, count, component: component.0, components })
    }
}

impl Elements<'_> {
    fn iter(&self) -> impl Iterator<Item = &[u8]> {
        let element = self.component.size() * self.components;
        (0..self.count).map(move |index| &self.bytes[index * self.stride..index * self.stride + element])
    }
}

fn accessor(root: &Root, index: usize) -> Result<&Accessor> {
    root.accessors.get(index).ok_or_else(|| Error::input(None, format!("accessor {index} is not there")))
}

/// One number (glTF 2.0, section 3.11 for normalised integers).
fn component(bytes: &[u8], kind: ComponentType, normalized: bool) -> f32 {
    let (value, most) = match (kind, bytes) {
        (ComponentType::I8, &[byte]) => (f32::from(byte as i8), 127.0),
        (ComponentType::U8, &[byte]) => (f32::from(byte), 255.0),
        (ComponentType::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), 32_767.0),
        (ComponentType::U16, &[a, b]) => (f32::from(u16::from_le_bytes([a, b])), 65_535.0),
        (ComponentType::U32, &[a, b, c, d]) => (u32::from_le_bytes([a, b, c, d]) as f32, 4_294_967_295.0),
        (ComponentType::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]),
        _ => return f32::NAN,
    };
    if normalized { (value / most).max(-1.0) } else { value }
}
