//! The bytes of a glTF file and the numbers that its accessors find in them.

use std::borrow::Cow;
use std::io;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use gltf_json::accessor::{Accessor, ComponentType, Type};
use gltf_json::validation::Checked;
use gltf_json::{Buffer, Index, Root};
use percent_encoding::percent_decode_str;

use crate::formats::polygons::PolygonError;

/// All buffers: the file's own, those written into it, and those beside it.
pub(super) struct Buffers<'a> {
    root: &'a Root,
    bytes: Vec<Cow<'a, [u8]>>,
}

impl<'a> Buffers<'a> {
    pub(super) fn read(
        root: &'a Root,
        binary: Option<&'a [u8]>,
        open: &dyn Fn(&str) -> io::Result<Vec<u8>>,
    ) -> Result<Self, PolygonError> {
        let bytes = |buffer: &Buffer| match &buffer.uri {
            None => binary
                .map(Cow::Borrowed)
                .ok_or_else(|| malformed(&"it has no binary part")),
            Some(uri) => named(uri, open).map(Cow::Owned),
        };
        Ok(Self {
            root,
            bytes: root.buffers.iter().map(bytes).collect::<Result<_, _>>()?,
        })
    }

    /// Vectors of three numbers in single precision.
    pub(super) fn vectors(&self, accessor: Index<Accessor>) -> Result<Vec<DVec3>, PolygonError> {
        let vector = |bytes: &[u8]| {
            let number = |place: usize| f32::from_le_bytes([0, 1, 2, 3].map(|byte| bytes[4 * place + byte]));
            DVec3::from_array([0, 1, 2].map(|place| f64::from(number(place))))
        };
        let (items, component) = self.items(accessor, Type::Vec3)?;
        match component {
            ComponentType::F32 => Ok(items.map(vector).collect()),
            _ => Err(malformed(&"vectors are not of single precision")),
        }
    }

    /// Numbers of vertices.
    pub(super) fn indices(&self, accessor: Index<Accessor>) -> Result<Vec<u32>, PolygonError> {
        let number = |bytes: &[u8]| {
            bytes
                .iter()
                .rev()
                .fold(0, |number, &byte| number << 8 | u32::from(byte))
        };
        let (items, component) = self.items(accessor, Type::Scalar)?;
        match component {
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => Ok(items.map(number).collect()),
            _ => Err(malformed(&"numbers of vertices are no whole numbers")),
        }
    }

    /// The bytes of each item of an accessor, and what numbers those are.
    fn items(
        &self,
        accessor: Index<Accessor>,
        kind: Type,
    ) -> Result<(impl Iterator<Item = &[u8]>, ComponentType), PolygonError> {
        let accessor = self
            .root
            .get(accessor)
            .ok_or_else(|| malformed(&"an accessor is not there"))?;
        let Checked::Valid(component) = accessor.component_type else {
            return Err(malformed(&"an accessor has numbers of no kind"));
        };
        if accessor.sparse.is_some() || accessor.type_ != Checked::Valid(kind) {
            return Err(malformed(
                &"an accessor is sparse, or not of the kind that belongs there",
            ));
        }
        let size = component.0.size() * kind.multiplicity();
        let view = accessor.buffer_view.and_then(|view| self.root.get(view));
        let view = view.ok_or_else(|| malformed(&"an accessor has no buffer view"))?;
        let stride = view.byte_stride.map_or(size, |stride| stride.0);
        let bytes = self.bytes.get(view.buffer.value()).map(AsRef::as_ref);
        let bytes =
            bytes.and_then(|bytes| part(bytes, view.byte_offset.map_or(0, |offset| offset.0), view.byte_length.0));
        let count = usize::try_from(accessor.count.0).ok().filter(|_| stride >= size);
        let length = count.and_then(|count| stride.checked_mul(count.checked_sub(1)?)?.checked_add(size));
        let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
        let used = bytes
            .zip(length)
            .and_then(|(bytes, length)| part(bytes, offset, length as u64));
        let used = used.ok_or_else(|| malformed(&"an accessor goes beyond its buffer"))?;
        Ok((used.chunks(stride).map(move |item| &item[..size]), component.0))
    }
}

fn part(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let [offset, length] = [usize::try_from(offset).ok()?, usize::try_from(length).ok()?];
    bytes.get(offset..)?.get(..length)
}

fn named(uri: &str, open: &dyn Fn(&str) -> io::Result<Vec<u8>>) -> Result<Vec<u8>, PolygonError> {
    if let Some((kind, text)) = uri.split_once(";base64,")
        && kind.starts_with("data:")
    {
        return STANDARD.decode(text).map_err(|error| malformed(&error));
    }
    let path = percent_decode_str(uri)
        .decode_utf8()
        .map_err(|error| malformed(&error))?;
    open(&path).map_err(|error| malformed(&format!("{path}: {error}")))
}

pub(super) fn malformed(reason: &impl ToString) -> PolygonError {
    PolygonError::Malformed {
        format: "glTF",
        reason: reason.to_string(),
    }
}
