//! Reading accessors: every offset, count and stride is checked before a byte is read.

use std::borrow::Cow;

use ::gltf::json;
use ::gltf::json::accessor::{Accessor, ComponentType, Type};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Index, buffer};

use crate::error::SceneError;

/// Elements that an accessor without a buffer view (all zeros) may have: 16 Mi.
const MAX_ZEROS: u64 = 1 << 24;

/// The buffers of a file with the views and accessors into them.
#[derive(Clone, Copy)]
pub(super) struct Data<'a> {
    pub(super) root: &'a json::Root,
    pub(super) buffers: &'a [Cow<'a, [u8]>],
}

/// Equally long elements in a buffer: all of them are there.
#[derive(Clone, Copy)]
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Elements<'a> {
    fn iter(self) -> impl Iterator<Item = &'a [u8]> {
        (0..self.count).map(move |i| &self.bytes[i * self.stride..][..self.size])
    }
}

/// The shape of an accessor.
#[derive(Clone, Copy)]
struct Shape {
    component: ComponentType,
    components: usize,
}

impl<'a> Data<'a> {
    /// All elements of an accessor of `N` floats each; integers are converted, and divided by
    /// their largest value where the file says normalized.
    pub(super) fn floats<const N: usize>(
        &self,
        index: Index<Accessor>,
        what: &str,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let (accessor, shape) = self.shape::<N>(index, what)?;
        let normalized = accessor.normalized;
        let decode = |bytes: &[u8]| -> [f32; N] {
            let size = bytes.len() / N;
            std::array::from_fn(|i| {
                to_f32(
                    &bytes[i * size..(i + 1) * size],
                    shape.component,
                    normalized,
                )
            })
        };
        self.read(accessor, shape, [0.0; N], what, decode)
    }

    /// All elements of an accessor of `N` unsigned integers each.
    pub(super) fn integers<const N: usize>(
        &self,
        index: Index<Accessor>,
        what: &str,
    ) -> Result<Vec<[u32; N]>, SceneError> {
        let (accessor, shape) = self.shape::<N>(index, what)?;
        use ComponentType::{U8, U16, U32};
        if !matches!(shape.component, U8 | U16 | U32) {
            return Err(SceneError::invalid(
                what,
                "it must have unsigned integer components",
            ));
        }
        let decode = |bytes: &[u8]| -> [u32; N] {
            let size = bytes.len() / N;
            std::array::from_fn(|i| to_u32(&bytes[i * size..(i + 1) * size]))
        };
        self.read(accessor, shape, [0; N], what, decode)
    }

    /// The bytes of a buffer view.
    pub(super) fn view(
        &self,
        index: Index<buffer::View>,
        what: &str,
    ) -> Result<&'a [u8], SceneError> {
        let view = self.root.buffer_views.get(index.value());
        let Some((view, buffer)) =
            view.and_then(|view| Some((view, self.buffers.get(view.buffer.value())?)))
        else {
            let why = format!("buffer view {} or its buffer does not exist", index.value());
            return Err(SceneError::invalid(what, why));
        };
        let start = view.byte_offset.map_or(0, |offset| offset.0);
        range(buffer, start, view.byte_length.0).ok_or_else(|| {
            SceneError::invalid(
                what,
                format!(
                    "buffer view {} spans bytes {start} to {} of a buffer of {} bytes",
                    index.value(),
                    start.saturating_add(view.byte_length.0),
                    buffer.len()
                ),
            )
        })
    }

    fn shape<const N: usize>(
        &self,
        index: Index<Accessor>,
        what: &str,
    ) -> Result<(&'a Accessor, Shape), SceneError> {
        let Some(accessor) = self.root.accessors.get(index.value()) else {
            let why = format!("accessor {} does not exist", index.value());
            return Err(SceneError::invalid(what, why));
        };
        let (Checked::Valid(component), Checked::Valid(kind)) =
            (accessor.component_type, accessor.type_)
        else {
            return Err(SceneError::invalid(
                what,
                "its accessor has an unknown type",
            ));
        };
        let (components, name) = match N {
            1 => (Type::Scalar, "SCALAR"),
            2 => (Type::Vec2, "VEC2"),
            3 => (Type::Vec3, "VEC3"),
            4 => (Type::Vec4, "VEC4"),
            _ => (Type::Mat4, "MAT4"),
        };
        if kind != components {
            return Err(SceneError::invalid(
                what,
                format!("accessor {} must have the type {name}", index.value()),
            ));
        }
        let shape = Shape {
            component: component.0,
            components: N,
        };
        Ok((accessor, shape))
    }

    fn read<T: Copy>(
        &self,
        accessor: &Accessor,
        shape: Shape,
        zero: T,
        what: &str,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, SceneError> {
        let size = shape.components * shape.component.size();
        let count = accessor.count.0;
        let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
        let mut values: Vec<T> = match accessor.buffer_view {
            Some(view) => self
                .elements(view, offset, count, size, what)?
                .iter()
                .map(&decode)
                .collect(),
            None if count <= MAX_ZEROS => vec![zero; count as usize],
            None => {
                let why = format!("an accessor without data has {count} elements");
                return Err(SceneError::invalid(what, why));
            }
        };
        if let Some(sparse) = &accessor.sparse {
            let Checked::Valid(index_type) = sparse.indices.component_type else {
                return Err(SceneError::invalid(what, "its sparse indices have no type"));
            };
            let (places, replaced) = (&sparse.indices, &sparse.values);
            let places = self.elements(
                places.buffer_view,
                places.byte_offset.0,
                sparse.count.0,
                index_type.0.size(),
                what,
            )?;
            let replaced = self.elements(
                replaced.buffer_view,
                replaced.byte_offset.0,
                sparse.count.0,
                size,
                what,
            )?;
            for (place, bytes) in places.iter().zip(replaced.iter()) {
                let place = to_u32(place);
                let Some(value) = values.get_mut(place as usize) else {
                    let why = format!("sparse index {place} is out of range, count is {count}");
                    return Err(SceneError::invalid(what, why));
                };
                *value = decode(bytes);
            }
        }
        Ok(values)
    }

    fn elements(
        &self,
        view: Index<buffer::View>,
        offset: u64,
        count: u64,
        size: usize,
        what: &str,
    ) -> Result<Elements<'a>, SceneError> {
        let bytes = self.view(view, what)?;
        let stride = self.root.buffer_views[view.value()]
            .byte_stride
            .map_or(size, |stride| stride.0);
        if stride < size {
            let why = format!("its elements of {size} bytes overlap: the stride is {stride}");
            return Err(SceneError::invalid(what, why));
        }
        let length = match count.checked_sub(1) {
            None => Some(0),
            Some(steps) => steps
                .checked_mul(stride as u64)
                .and_then(|bytes| bytes.checked_add(size as u64)),
        };
        let Some(bytes) = length.and_then(|length| range(bytes, offset, length)) else {
            let why = format!(
                "{count} elements of {size} bytes from byte {offset} on do not fit into buffer \
                 view {} of {} bytes; export the file again",
                view.value(),
                bytes.len()
            );
            return Err(SceneError::invalid(what, why));
        };
        Ok(Elements {
            bytes,
            stride,
            size,
            count: count as usize,
        })
    }
}

fn range(bytes: &[u8], start: u64, length: u64) -> Option<&[u8]> {
    let end = usize::try_from(start.checked_add(length)?).ok()?;
    bytes.get(usize::try_from(start).ok()?..end)
}

fn to_u32(bytes: &[u8]) -> u32 {
    match *bytes {
        [a] => u32::from(a),
        [a, b] => u32::from(u16::from_le_bytes([a, b])),
        [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
        _ => 0,
    }
}

/// glTF 2.0, section 3.11: signed values are symmetric.
fn to_f32(bytes: &[u8], component: ComponentType, normalized: bool) -> f32 {
    let bits = to_u32(bytes);
    let (value, largest) = match component {
        ComponentType::F32 => return f32::from_bits(bits),
        ComponentType::U8 | ComponentType::U32 => (bits as f32, 255.0),
        ComponentType::U16 => (bits as f32, 65535.0),
        ComponentType::I8 => (f32::from(bits as u8 as i8), 127.0),
        ComponentType::I16 => (f32::from(bits as u16 as i16), 32767.0),
    };
    if normalized {
        (value / largest).max(-1.0)
    } else {
        value
    }
}
