//! The numbers of a glTF file: buffers, and accessors into them.
//!
//! The `gltf` crate reads the JSON. Its own accessors trust lengths and indices (and `import`
//! decodes all pictures), so numbers are taken out here, every range checked.

use std::borrow::Cow;
use std::path::Path;

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::buffer::{Buffer, View};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};

/// The bytes of all buffers.
pub(super) struct Buffers<'a> {
    root: &'a Root,
    bytes: Vec<Cow<'a, [u8]>>,
    /// How many numbers of accessors not met before may still be taken out: they may overlap or make
    /// zeros out of nothing, so that their length says nothing of what a file holds.
    left: usize,
    /// How many numbers may still be taken out of accessors again.
    again: usize,
    met: Vec<bool>,
}

/// Numbers that any file may have.
const MIN_NUMBERS: usize = 1 << 16;

/// Numbers that any file may use again.
const MAX_AGAIN: usize = 1 << 26;

impl<'a> Buffers<'a> {
    /// Gets all buffers: from the binary chunk, from the JSON itself, from files beside it.
    pub(super) fn load(
        root: &'a Root,
        mut binary: Option<Cow<'a, [u8]>>,
        path: &Path,
    ) -> Result<Buffers<'a>, String> {
        let mut bytes: Vec<Cow<'_, [u8]>> = Vec::with_capacity(root.buffers.len());
        for (index, buffer) in root.buffers.iter().enumerate() {
            let data = match &buffer.uri {
                Some(uri) => {
                    Cow::Owned(fetch(uri, path).map_err(|e| format!("buffer {index}: {e}"))?)
                }
                None => binary.take().ok_or_else(|| {
                    format!("buffer {index} has no data: neither a file nor a binary chunk")
                })?,
            };
            check_length(index, buffer, data.len())?;
            bytes.push(data);
        }
        let total: usize = bytes.iter().map(|b| b.len()).sum();
        Ok(Buffers {
            root,
            bytes,
            left: total.max(MIN_NUMBERS),
            again: MAX_AGAIN,
            met: vec![false; root.accessors.len()],
        })
    }

    /// The vectors of an accessor.
    pub(super) fn vectors(&mut self, index: Index<Accessor>) -> Result<Vec<[f64; 3]>, String> {
        self.take(index, Type::Vec3)
    }

    /// The indices of an accessor.
    pub(super) fn indices(&mut self, index: Index<Accessor>) -> Result<Vec<u32>, String> {
        let indices = self.take::<1>(index, Type::Scalar)?;
        // Whole numbers of 32 bits are exact in double precision.
        let index = |i: f64| (i >= 0.0).then_some(i as u32);
        let indices = indices.iter().map(|&[i]| index(i));
        indices
            .collect::<Option<_>>()
            .ok_or_else(|| "an index is negative".into())
    }

    fn take<const N: usize>(
        &mut self,
        index: Index<Accessor>,
        wanted: Type,
    ) -> Result<Vec<[f64; N]>, String> {
        let named = |what: String| format!("accessor {}: {what}", index.value());
        let accessor = self.root.get(index);
        let accessor = accessor.ok_or_else(|| named("there is no such accessor".into()))?;
        let count = usize::try_from(accessor.count.0).unwrap_or(usize::MAX);
        let met = std::mem::replace(&mut self.met[index.value()], true);
        let left = if met { &mut self.again } else { &mut self.left };
        *left = left.checked_sub(count.saturating_mul(N)).ok_or_else(|| {
            let what = if met {
                "too much when used again"
            } else {
                "more than the buffers have bytes"
            };
            named(format!("it promises {count} elements, {what}"))
        })?;
        self.elements(accessor, count, wanted).map_err(named)
    }

    fn elements<const N: usize>(
        &self,
        accessor: &Accessor,
        count: usize,
        wanted: Type,
    ) -> Result<Vec<[f64; N]>, String> {
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
        let mut elements = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.unwrap_or_default().0;
                self.column(view, offset, count, component)?
            }
            None if accessor.sparse.is_none() => return Err("it has no data".into()),
            None => vec![[0.0; N]; count],
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
            let indices: Vec<[f64; 1]> = self.column(at, offset, changed, plain)?;
            let (at, offset) = (sparse.values.buffer_view, sparse.values.byte_offset.0);
            let values = self.column(at, offset, changed, component)?;
            for ([index], value) in indices.into_iter().zip(values) {
                let element = elements.get_mut(index as usize);
                *element.ok_or("a sparse index is out of range")? = value;
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
    ) -> Result<Vec<[f64; N]>, String> {
        let (bytes, stride) = self.view(view)?;
        let size = N * component.size();
        let stride = stride.unwrap_or(size);
        let too_short = || "it reaches beyond its buffer view".to_owned();
        let offset = usize::try_from(offset).map_err(|_| too_short())?;
        if count == 0 {
            return Ok(Vec::new());
        }
        let end = (count - 1)
            .checked_mul(stride)
            .and_then(|end| end.checked_add(size)?.checked_add(offset));
        if stride == 0 || end.is_none_or(|end| end > bytes.len()) {
            return Err(too_short());
        }
        let element = |k: usize| {
            let at = offset + k * stride;
            std::array::from_fn(|i| component.read(&bytes[at + i * component.size()..]))
        };
        Ok((0..count).map(element).collect())
    }

    /// The bytes of a view and the distance of its elements, if it has one.
    fn view(&self, index: Index<View>) -> Result<(&[u8], Option<usize>), String> {
        let wrong = || format!("buffer view {} reaches beyond its buffer", index.value());
        let view = self.root.get(index).ok_or_else(wrong)?;
        let bytes = self.bytes.get(view.buffer.value()).ok_or_else(wrong)?;
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.checked_add(view.byte_length.0).ok_or_else(wrong)?;
        let [start, end] = [start, end].map(|at| usize::try_from(at).unwrap_or(usize::MAX));
        let bytes = bytes.get(start..end).ok_or_else(wrong)?;
        Ok((bytes, view.byte_stride.map(|stride| stride.0)))
    }
}

fn check_length(index: usize, buffer: &Buffer, length: usize) -> Result<(), String> {
    let promised = buffer.byte_length.0;
    if promised > length as u64 {
        return Err(format!(
            "buffer {index} has {length} bytes instead of {promised}"
        ));
    }
    Ok(())
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
    let file = path.with_file_name("").join(&*name);
    let refused = |what: String| format!("cannot read {}: {what}", file.display());
    // Devices and pipes may have no end.
    if file.exists() && !file.is_file() {
        return Err(refused("it is no file".into()));
    }
    std::fs::read(&file).map_err(|error| refused(error.to_string()))
}
