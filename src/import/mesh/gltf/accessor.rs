//! Accessors: typed views of buffers. Whatever the file says about offsets, strides and counts, nothing outside its
//! buffers is read, and no more is made than there are bytes.

use crate::error::{Error, Result};
use gltf_json::Root;
use gltf_json::accessor::{Accessor, ComponentType, IndexComponentType, Type};
use gltf_json::validation::Checked;
use std::borrow::Cow;

/// The bytes of the file's buffers.
pub(super) struct Buffers<'a> {
    list: Vec<Cow<'a, [u8]>>,
    /// Most elements of an accessor that states only some of them.
    most_sparse: usize,
}

/// The elements of an accessor.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
    /// Bytes of one.
    element: usize,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(most_sparse: usize) -> Buffers<'a> {
        Buffers { list: Vec::new(), most_sparse }
    }

    pub(super) fn push(&mut self, bytes: Cow<'a, [u8]>) {
        self.list.push(bytes);
    }

    /// Vectors of `least` to 4 components as f32, integers scaled to 0–1 (or −1–1) where the accessor says so; the components
    /// that are not there are 1.
    pub(super) fn vectors(&self, root: &Root, index: usize, least: usize) -> Result<Vec<[f32; 4]>> {
        let accessor = accessor(root, index)?;
        let (component, components) = kind(index, accessor)?;
        if components < least || components > 4 {
            return Err(Error::input(
                None,
                format!("accessor {index}: expected {least} to 4 components, found {components}"),
            ));
        }
        let size = component.size();
        let vector = |bytes: &[u8]| {
            let mut vector = [1.0; 4];
            for (slot, bytes) in vector.iter_mut().zip(bytes.chunks_exact(size).take(components)) {
                *slot = number(bytes, component, accessor.normalized);
            }
            vector
        };
        let mut vectors: Vec<[f32; 4]> = match self.elements(root, index, accessor)? {
            Some(elements) => elements.iter().map(vector).collect(),
            None => {
                let zero = vector(&[0; 16][..size * components]);
                vec![zero; self.sparse_count(index, accessor)?]
            }
        };
        for (place, bytes) in self.replaced(root, index, accessor)? {
            if let Some(slot) = vectors.get_mut(place as usize) {
                *slot = vector(bytes);
            }
        }
        Ok(vectors)
    }

    /// Indices of vertices.
    pub(super) fn indices(&self, root: &Root, index: usize) -> Result<Vec<u32>> {
        let accessor = accessor(root, index)?;
        let read: fn(&[u8]) -> u32 = match kind(index, accessor)? {
            (component, 1) => whole_number(component)
                .ok_or_else(|| Error::input(None, format!("accessor {index}: expected whole numbers as indices")))?,
            _ => return Err(Error::input(None, format!("accessor {index}: expected whole numbers as indices"))),
        };
        let mut indices: Vec<u32> = match self.elements(root, index, accessor)? {
            Some(elements) => elements.iter().map(read).collect(),
            None => vec![0; self.sparse_count(index, accessor)?],
        };
        for (place, bytes) in self.replaced(root, index, accessor)? {
            if let Some(slot) = indices.get_mut(place as usize) {
                *slot = read(bytes);
            }
        }
        Ok(indices)
    }

    /// The bytes of a buffer view.
    pub(super) fn view(&self, root: &Root, index: usize) -> Result<&[u8]> {
        let wrong = |what: &str| Error::input(None, what);
        let view = root.buffer_views.get(index).ok_or_else(|| wrong("its buffer view is not there"))?;
        let buffer = self.list.get(view.buffer.value()).ok_or_else(|| wrong("its buffer is not there"))?;
        let part = || -> Option<&[u8]> {
            let start = usize::try_from(view.byte_offset.map_or(0, |offset| offset.0)).ok()?;
            buffer.get(start..start.checked_add(usize::try_from(view.byte_length.0).ok()?)?)
        };
        part().ok_or_else(|| wrong("it reaches beyond its buffer, or the buffer is cut off"))
    }

    /// The elements that an accessor states; `None` if it states only some, and all others are 0.
    fn elements(&self, root: &Root, index: usize, accessor: &Accessor) -> Result<Option<Elements<'_>>> {
        let Some(view) = &accessor.buffer_view else {
            return match accessor.sparse {
                Some(_) => Ok(None),
                None => Err(Error::input(None, format!("accessor {index}: it has no buffer view"))),
            };
        };
        let kind = kind(index, accessor)?;
        let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
        self.table(root, index, (view.value(), offset), accessor.count.0, kind).map(Some)
    }

    /// So many elements of a kind in a buffer view.
    fn table(
        &self,
        root: &Root,
        index: usize,
        (view, offset): (usize, u64),
        count: u64,
        (component, components): (ComponentType, usize),
    ) -> Result<Elements<'_>> {
        let wrong = |what: &str| Error::input(None, format!("accessor {index}: {what}"));
        let bytes = self.view(root, view).map_err(|error| wrong(&error.to_string()))?;
        let size = |value: u64| usize::try_from(value).ok();
        let beyond = || wrong("it reaches beyond its buffer, or the buffer is cut off");
        let bytes = size(offset).and_then(|offset| bytes.get(offset..)).ok_or_else(beyond)?;
        let element = component.size() * components;
        let stride = root.buffer_views.get(view).and_then(|view| view.byte_stride);
        let stride = stride.map_or(element, |stride| stride.0);
        let count = size(count).unwrap_or(usize::MAX);
        // Elements that overlap would make much of few bytes.
        let end = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(element));
        if stride < element || end.is_none_or(|end| end > bytes.len()) {
            return Err(wrong(&format!("expected {count} elements of {element} bytes, found {} bytes", bytes.len())));
        }
        Ok(Elements { bytes, stride, count, element })
    }

    /// How many elements there are where no bytes stand for them.
    fn sparse_count(&self, index: usize, accessor: &Accessor) -> Result<usize> {
        let count = usize::try_from(accessor.count.0).ok().filter(|&count| count <= self.most_sparse);
        count.ok_or_else(|| {
            let message = format!("accessor {index}: {} elements of which most are not stated", accessor.count.0);
            Error::limit(None, message)
        })
    }

    /// The places and bytes of the elements that a sparse accessor states.
    fn replaced(&self, root: &Root, index: usize, accessor: &Accessor) -> Result<Vec<(u32, &[u8])>> {
        let Some(sparse) = &accessor.sparse else { return Ok(Vec::new()) };
        let wrong =
            || Error::input(None, format!("accessor {index}: the places of its sparse elements are no numbers"));
        let Checked::Valid(IndexComponentType(places)) = sparse.indices.component_type else { return Err(wrong()) };
        let read = whole_number(places).ok_or_else(wrong)?;
        let at = (sparse.indices.buffer_view.value(), sparse.indices.byte_offset.0);
        let places = self.table(root, index, at, sparse.count.0, (places, 1))?;
        let at = (sparse.values.buffer_view.value(), sparse.values.byte_offset.0);
        let values = self.table(root, index, at, sparse.count.0, kind(index, accessor)?)?;
        Ok(places.iter().map(read).zip(values.iter()).collect())
    }
}

/// The type of an accessor's numbers, and how many make an element.
fn kind(index: usize, accessor: &Accessor) -> Result<(ComponentType, usize)> {
    let wrong = |what: &str| Error::input(None, format!("accessor {index}: {what}"));
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
    Ok((component.0, components))
}

/// How whole numbers of a type are read.
fn whole_number(component: ComponentType) -> Option<fn(&[u8]) -> u32> {
    match component {
        ComponentType::U8 => Some(|bytes| bytes.first().map_or(0, |&byte| u32::from(byte))),
        ComponentType::U16 => Some(|bytes| bytes.first_chunk().map_or(0, |&two| u32::from(u16::from_le_bytes(two)))),
        ComponentType::U32 => Some(|bytes| bytes.first_chunk().map_or(0, |&four| u32::from_le_bytes(four))),
        _ => None,
    }
}

impl<'a> Elements<'a> {
    fn iter(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let (bytes, stride, element) = (self.bytes, self.stride, self.element);
        (0..self.count).map(move |index| &bytes[index * stride..index * stride + element])
    }
}

fn accessor(root: &Root, index: usize) -> Result<&Accessor> {
    root.accessors.get(index).ok_or_else(|| Error::input(None, format!("accessor {index} is not there")))
}

/// One number (glTF 2.0, section 3.11 for normalised integers).
fn number(bytes: &[u8], kind: ComponentType, normalized: bool) -> f32 {
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
