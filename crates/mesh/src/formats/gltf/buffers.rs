//! The numbers of a glTF file: buffers, and accessors into them.
//!
//! The `gltf` crate reads the JSON. Its own accessors trust lengths and indices (and `import`
//! decodes all pictures), so numbers are taken out here, every range checked. They are taken out
//! one by one where they are needed: many primitives may share an accessor and use few of its
//! elements each.

use std::borrow::Cow;
use std::cell::Cell;
use std::collections::HashMap;
use std::path::Path;

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::buffer::{Buffer, View};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};

use super::extensions;
use crate::formats::beside;

/// Numbers that any file may have.
const MIN_NUMBERS: usize = 1 << 16;

/// Corners that any file may use again. Larger files may use as many as they have bytes.
const MIN_AGAIN: usize = 1 << 24;

/// The bytes of all buffers.
pub(super) struct Buffers<'a> {
    root: &'a Root,
    /// `None` for a buffer that the file has no data for.
    bytes: Vec<Option<Cow<'a, [u8]>>>,
    /// Of each accessor the first that is the same.
    first_same: Vec<usize>,
    /// How many elements' numbers may still be looked up: accessors may overlap or make zeros out of
    /// nothing, so that their length says nothing of what a file holds.
    left: Cell<usize>,
    /// How many corners may still be made of indices that have been used.
    again: Cell<usize>,
}

impl<'a> Buffers<'a> {
    /// Gets all buffers: from the binary chunk, from the JSON itself, from files beside it.
    pub(super) fn load(
        root: &'a Root,
        mut binary: Option<Cow<'a, [u8]>>,
        path: &Path,
    ) -> Result<Buffers<'a>, String> {
        let mut bytes: Vec<Option<Cow<'_, [u8]>>> = Vec::with_capacity(root.buffers.len());
        for (index, buffer) in root.buffers.iter().enumerate() {
            let data = match &buffer.uri {
                Some(uri) => {
                    let data = fetch(uri, path).map_err(|e| format!("buffer {index}: {e}"))?;
                    Some(Cow::Owned(data))
                }
                // What nothing uses need not be there.
                None => binary.take(),
            };
            if let Some(data) = &data {
                check_length(index, buffer, data)?;
            }
            bytes.push(data);
        }
        let total: usize = bytes.iter().flatten().map(|b| b.len()).sum();
        Ok(Buffers {
            root,
            bytes,
            first_same: first_same(&root.accessors),
            left: Cell::new(total.max(MIN_NUMBERS)),
            again: Cell::new(total.max(MIN_AGAIN)),
        })
    }

    /// The number of the first accessor that is the same.
    pub(super) fn first_same(&self, index: Index<Accessor>) -> usize {
        let index = index.value();
        self.first_same.get(index).copied().unwrap_or(index)
    }

    /// Allows for a table of this many elements with so many numbers each.
    pub(super) fn allow(&self, elements: usize, numbers: usize) -> Result<(), String> {
        let left = self
            .left
            .get()
            .checked_sub(elements.saturating_mul(numbers));
        self.left.set(left.ok_or_else(|| {
            format!("it promises {elements} elements, more than the buffers have bytes")
        })?);
        Ok(())
    }

    /// Allows for so many corners of indices that have been used before.
    pub(super) fn allow_again(&self, corners: usize) -> Result<(), String> {
        let left = self.again.get().checked_sub(corners);
        self.again.set(left.ok_or_else(|| {
            format!("it uses {corners} corners again, too many for a file of this size")
        })?);
        Ok(())
    }

    /// The elements of an accessor that holds this type, of so many numbers.
    pub(super) fn elements<const N: usize>(
        &self,
        index: Index<Accessor>,
        wanted: Type,
    ) -> Result<Elements<'_, N>, String> {
        let named = |what: String| format!("accessor {}: {what}", index.value());
        let accessor = self.root.get(index);
        let accessor = accessor.ok_or_else(|| named("there is no such accessor".into()))?;
        self.of_accessor(accessor, wanted).map_err(named)
    }

    fn of_accessor<const N: usize>(
        &self,
        accessor: &Accessor,
        wanted: Type,
    ) -> Result<Elements<'_, N>, String> {
        if accessor.type_ != Checked::Valid(wanted) {
            return Err(format!(
                "it does not hold {wanted:?} elements, as it should"
            ));
        }
        let Checked::Valid(component) = accessor.component_type else {
            return Err("its component type is unknown".into());
        };
        let component = Component {
            kind: component.0,
            normalized: accessor.normalized,
        };
        let count = usize::try_from(accessor.count.0).unwrap_or(usize::MAX);
        let column = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.unwrap_or_default().0;
                Some(self.column(view, offset, count, component)?)
            }
            None if accessor.sparse.is_none() => {
                return Err(match extensions::compression(self.root) {
                    Some(name) => extensions::is_compressed(name),
                    None => "it has no data".into(),
                });
            }
            None => None,
        };
        let mut elements = Elements {
            count,
            column,
            replaced: HashMap::new(),
        };
        if let Some(sparse) = &accessor.sparse {
            let changed = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
            let Checked::Valid(kind) = sparse.indices.component_type else {
                return Err("the component type of its sparse indices is unknown".into());
            };
            let plain = Component {
                kind: kind.0,
                normalized: false,
            };
            let (at, offset) = (sparse.indices.buffer_view, sparse.indices.byte_offset.0);
            let indices: Column<'_, 1> = self.column(at, offset, changed, plain)?;
            let (at, offset) = (sparse.values.buffer_view, sparse.values.byte_offset.0);
            let values: Column<'_, N> = self.column(at, offset, changed, component)?;
            self.allow(changed, N)?;
            for k in 0..changed {
                let [index] = indices.get(k);
                if index < 0.0 || index >= count as f64 {
                    return Err("a sparse index is out of range".into());
                }
                elements.replaced.insert(index as usize, values.get(k));
            }
        }
        Ok(elements)
    }

    /// Elements that lie in a view, at equal distances.
    fn column<const N: usize>(
        &self,
        view: Index<View>,
        offset: u64,
        count: usize,
        component: Component,
    ) -> Result<Column<'_, N>, String> {
        let (bytes, stride) = self.view(view)?;
        let size = N * component.size();
        let stride = stride.unwrap_or(size);
        let too_short = || "it reaches beyond its buffer view".to_owned();
        let offset = usize::try_from(offset).map_err(|_| too_short())?;
        let last = count.saturating_sub(1);
        let end = last
            .checked_mul(stride)
            .and_then(|end| end.checked_add(size)?.checked_add(offset));
        if count > 0 && (stride == 0 || end.is_none_or(|end| end > bytes.len())) {
            return Err(too_short());
        }
        Ok(Column {
            bytes: bytes.get(offset..).unwrap_or_default(),
            stride,
            component,
        })
    }

    /// The bytes of a view and the distance of its elements, if it has one.
    fn view(&self, index: Index<View>) -> Result<(&[u8], Option<usize>), String> {
        let wrong = || format!("buffer view {} reaches beyond its buffer", index.value());
        let view = self.root.get(index).ok_or_else(wrong)?;
        let buffer = view.buffer.value();
        let bytes = self.bytes.get(buffer).ok_or_else(wrong)?;
        let bytes = bytes.as_ref().ok_or_else(|| {
            let what = format!("buffer {buffer} has no data: neither a file nor a binary chunk");
            match extensions::compression(self.root) {
                Some(name) => format!("{what}; {}", extensions::is_compressed(name)),
                None => what,
            }
        })?;
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.checked_add(view.byte_length.0).ok_or_else(wrong)?;
        let [start, end] = [start, end].map(|at| usize::try_from(at).unwrap_or(usize::MAX));
        let bytes = bytes.get(start..end).ok_or_else(wrong)?;
        Ok((bytes, view.byte_stride.map(|stride| stride.0)))
    }
}

/// Of each accessor the number of the first that is the same: exporters repeat them.
fn first_same(accessors: &[Accessor]) -> Vec<usize> {
    let mut known = HashMap::new();
    (accessors.iter().enumerate())
        .map(|(number, accessor)| {
            let (Checked::Valid(component), Checked::Valid(type_), Some(view), None) = (
                accessor.component_type,
                accessor.type_,
                accessor.buffer_view,
                &accessor.sparse,
            ) else {
                return number;
            };
            let key = (
                view.value(),
                accessor.byte_offset.unwrap_or_default().0,
                accessor.count.0,
                component.0.as_gl_enum(),
                type_.multiplicity(),
                accessor.normalized,
            );
            *known.entry(key).or_insert(number)
        })
        .collect()
}

fn check_length(index: usize, buffer: &Buffer, data: &[u8]) -> Result<(), String> {
    let (promised, length) = (buffer.byte_length.0, data.len());
    if promised > length as u64 {
        let hint = if data.starts_with(b"version https://git-lfs") {
            ": it is a Git LFS pointer in place of the file; `git lfs pull` fetches the file itself"
        } else {
            ""
        };
        return Err(format!(
            "buffer {index} has {length} bytes instead of {promised}{hint}"
        ));
    }
    Ok(())
}

/// The elements of an accessor, each of so many numbers.
pub(super) struct Elements<'a, const N: usize> {
    count: usize,
    /// `None` for zeros.
    column: Option<Column<'a, N>>,
    /// Elements in place of those of the column.
    replaced: HashMap<usize, [f64; N]>,
}

impl<const N: usize> Elements<'_, N> {
    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// One of them.
    ///
    /// # Panics
    ///
    /// If there are not so many.
    pub(super) fn get(&self, index: usize) -> [f64; N] {
        assert!(index < self.count, "element {index} of {}", self.count);
        if !self.replaced.is_empty()
            && let Some(element) = self.replaced.get(&index)
        {
            return *element;
        }
        (self.column.as_ref()).map_or([0.0; N], |column| column.get(index))
    }
}

/// Elements at equal distances. Their range has been checked.
struct Column<'a, const N: usize> {
    bytes: &'a [u8],
    stride: usize,
    component: Component,
}

impl<const N: usize> Column<'_, N> {
    fn get(&self, index: usize) -> [f64; N] {
        let bytes = &self.bytes[index * self.stride..];
        let size = self.component.size();
        std::array::from_fn(|i| self.component.read(&bytes[i * size..]))
    }
}

/// How the numbers of an element are stored.
#[derive(Clone, Copy)]
struct Component {
    kind: ComponentType,
    /// Whether whole numbers stand for shares of their type's greatest.
    normalized: bool,
}

impl Component {
    fn size(self) -> usize {
        self.kind.size()
    }

    /// Reads a number from the start of bytes that are long enough.
    fn read(self, bytes: &[u8]) -> f64 {
        let (value, greatest): (f64, f64) = match self.kind {
            ComponentType::I8 => (i8::from_le_bytes(start(bytes)).into(), 127.0),
            ComponentType::U8 => (u8::from_le_bytes(start(bytes)).into(), 255.0),
            ComponentType::I16 => (i16::from_le_bytes(start(bytes)).into(), 32767.0),
            ComponentType::U16 => (u16::from_le_bytes(start(bytes)).into(), 65535.0),
            ComponentType::U32 => (u32::from_le_bytes(start(bytes)).into(), 4294967295.0),
            ComponentType::F32 => return f32::from_le_bytes(start(bytes)).into(),
        };
        if self.normalized {
            (value / greatest).max(-1.0)
        } else {
            value
        }
    }
}

fn start<const N: usize>(bytes: &[u8]) -> [u8; N] {
    *bytes.first_chunk().expect("the range has been checked")
}

/// The bytes of a buffer that is named by a URI.
fn fetch(uri: &str, path: &Path) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (head, data) = data.split_once(',').ok_or("its data URI has no data")?;
        if !head.ends_with(";base64") {
            return Ok(percent_encoding::percent_decode_str(data).collect());
        }
        let config =
            GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
        let decoder = GeneralPurpose::new(&base64::alphabet::STANDARD, config);
        return decoder
            .decode(data)
            .map_err(|error| format!("its base64 data is wrong: {error}"));
    }
    let name = match uri.strip_prefix("file://") {
        Some(name) => name,
        None if uri.contains("://") => return Err(format!("{uri} is not on this machine")),
        None => uri,
    };
    let name = percent_encoding::percent_decode_str(name).decode_utf8_lossy();
    let file = beside(path, &name);
    let refused = |what: String| format!("cannot read {}: {what}", file.display());
    // Devices and pipes may have no end.
    if file.exists() && !file.is_file() {
        return Err(refused("it is no file".into()));
    }
    std::fs::read(&file).map_err(|error| refused(error.to_string()))
}
