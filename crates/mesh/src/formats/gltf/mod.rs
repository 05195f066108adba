//! Reads glTF 2.0 files, JSON and binary.
//!
//! A mesh that is placed several times is read once; the model holds its placements. A mesh with a
//! skin or morph targets is read once for each pose, as the file has it: by the joints' nodes and the
//! default weights.

mod buffers;
mod extensions;
mod meshes;
mod nodes;
mod pose;
mod scenery;

use std::borrow::Cow;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

use glam::DAffine3;
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{self, Accessor, Index, Root};

use super::Parsed;
use super::text::length_without_padding;
use crate::error::{Fault, MeshError};
use crate::instances::Placement;
use crate::model::Model;
use crate::report::LoadReport;
use crate::skipped::Skipped;
use buffers::Buffers;
use meshes::MeshReader;
use nodes::WorldTransforms;
use pose::{Pose, Skin};

/// Reads a glTF file, JSON or binary; `path` is for the files it names.
pub(super) fn read(bytes: &[u8], path: &Path, skipped: Skipped) -> Result<Parsed, Fault> {
    let (json, binary) = split(bytes)?;
    // Exporters fill up with zeros, and write a mark within a GLB file too.
    let json = &json[..length_without_padding(&json)];
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let root = match Root::from_slice(json) {
        Ok(root) if is_read(&root.asset.version) => root,
        Ok(root) => return Err(Fault::Content(wrong_version(&root.asset.version))),
        Err(error) => return Err(json_fault(json, binary.is_some(), error)),
    };
    read_model(&root, binary, path, skipped)
}

/// A part of the file.
type Chunk<'a> = Cow<'a, [u8]>;

/// The JSON and the binary chunk.
fn split(bytes: &[u8]) -> Result<(Chunk<'_>, Option<Chunk<'_>>), Fault> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes.into(), None));
    }
    if bytes[4..].starts_with(&1u32.to_le_bytes()) {
        return Err(Fault::Content(wrong_version("1.0")));
    }
    // The crate takes the header's own length off the length it names.
    let length = bytes.get(8..12).and_then(|b| b.first_chunk());
    if length.is_none_or(|&length| u32::from_le_bytes(length) < 12) {
        return Err(Fault::Content("the GLB file is cut off".into()));
    }
    let glb = gltf::Glb::from_slice(bytes);
    let glb = glb.map_err(|error| Fault::Caused {
        line: None,
        what: "the GLB file is wrong".into(),
        source: error.into(),
    })?;
    Ok((glb.json, glb.bin))
}

fn is_read(version: &str) -> bool {
    version.split('.').next() == Some("2")
}

fn wrong_version(version: &str) -> String {
    let convert = if version.starts_with('1') {
        "; convert it by `gltf-pipeline`, or open and export it anew"
    } else {
        ""
    };
    format!("this is glTF {version:.20}, but only glTF 2.0 is read{convert}")
}

/// Why the JSON is not glTF 2.0.
fn json_fault(json: &[u8], is_binary: bool, error: json::Error) -> Fault {
    let value: Option<json::Value> = json::deserialize::from_slice(json).ok();
    let asset = value.as_ref().map(|value| value.get("asset"));
    let version = asset.and_then(|asset| asset?.get("version"));
    // Some write it as a number.
    let version = version.map(|version| version.to_string().replace('"', ""));
    if let Some(version) = version
        && !is_read(&version)
    {
        return Fault::Content(wrong_version(&version));
    }
    // In version 1.0 what is listed has names in place of numbers, and the version may be missing.
    let list = |name| value.as_ref().and_then(|value| value.get(name));
    let mut lists = ["meshes", "nodes", "accessors"]
        .into_iter()
        .filter_map(list);
    if lists.any(json::Value::is_object) {
        return Fault::Content(wrong_version("1.0"));
    }
    if asset == Some(None) {
        let what = "this is JSON, but no glTF: it has no \"asset\"";
        return Fault::Content(what.into());
    }
    let has_line = !is_binary && error.line() > 0;
    Fault::Caused {
        line: has_line.then(|| error.line()),
        what: "the glTF's JSON is wrong".into(),
        source: error.into(),
    }
}

fn read_model(
    root: &Root,
    binary: Option<Chunk<'_>>,
    path: &Path,
    skipped: Skipped,
) -> Result<Parsed, Fault> {
    let mut report = LoadReport::default();
    extensions::check(root, &mut report).map_err(Fault::Content)?;
    let buffers = Buffers::load(root, binary, path).map_err(Fault::Content)?;
    let nodes = nodes::place(root).map_err(Fault::Content)?;
    let scenery = scenery::read(root, &nodes, &mut report).map_err(Fault::Content)?;
    let mut reader = MeshReader::new(&buffers, skipped);
    reader.report = report;
    let model = read_meshes(root, &nodes, &buffers, &mut reader)?;
    if reader.points > 0 && reader.report.polygons == 0 && reader.skipped.count() == 0 {
        return Err(MeshError::NoFaces {
            points: reader.points,
        }
        .into());
    }
    let mut report = reader.report.clone();
    report.unused_vertices = reader.unused_vertices();
    let parsed = Parsed {
        model,
        scenery,
        report,
    };
    parsed.with_skipped(reader.skipped)
}

/// Reads what the scene's nodes have, each mesh once in each pose.
fn read_meshes(
    root: &Root,
    nodes: &[(usize, DAffine3)],
    buffers: &Buffers<'_>,
    reader: &mut MeshReader<'_>,
) -> Result<Model, Fault> {
    let mut model = Model::default();
    let mut part_of: HashMap<Vec<u64>, usize> = HashMap::new();
    let mut world = WorldTransforms::new(root, nodes);
    let mut skins = HashMap::new();
    let mut without_joints = 0_u64;
    for &(number, to_user) in nodes {
        let node = &root.nodes[number];
        let Some(index) = node.mesh else {
            continue;
        };
        let mesh = root.get(index);
        let mesh =
            mesh.ok_or_else(|| Fault::Content(format!("there is no mesh {}", index.value())))?;
        let mut pose = Pose {
            weights: pose::weights(node, mesh),
            skin: None,
        };
        // The node's own transform does not matter then.
        let mut placement = to_user;
        match node.skin.map(|skin| skin.value()) {
            Some(skin) if mesh.primitives.iter().any(pose::has_joints) => {
                let matrices = match skins.entry(skin) {
                    Entry::Occupied(known) => known.into_mut(),
                    Entry::Vacant(new) => {
                        let matrices = pose::joint_matrices(root, skin, buffers, &mut world);
                        new.insert(matrices.map_err(Fault::Content)?)
                    }
                };
                pose.skin = Some(Skin {
                    number: skin,
                    matrices: matrices.clone(),
                    node: to_user,
                });
                placement = DAffine3::IDENTITY;
            }
            Some(_) => without_joints += 1,
            None => {}
        }
        let shape = shape(mesh, &pose, buffers);
        let part = match part_of.get(&shape) {
            Some(&part) => part,
            None => {
                model.parts.push(reader.read(index.value(), mesh, &pose)?);
                part_of.insert(shape, model.parts.len() - 1);
                model.parts.len() - 1
            }
        };
        model.placements.push(Placement {
            part,
            to_user: placement,
        });
    }
    if without_joints > 0 {
        reader.report.warnings.push(format!(
            "{without_joints} meshes with a skin do not say which joints move them; they are where \
             their nodes are"
        ));
    }
    Ok(model)
}

/// The accessor of an attribute.
fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<Index<Accessor>> {
    let attributes = &primitive.attributes;
    attributes.get(&Checked::Valid(semantic)).copied()
}

/// What makes the shape of a mesh in a pose: the accessors and modes of its primitives. Meshes that
/// differ by material only have the same.
fn shape(mesh: &json::Mesh, pose: &Pose, buffers: &Buffers<'_>) -> Vec<u64> {
    const NONE: u64 = u64::MAX;
    let number = |accessor: Option<Index<Accessor>>| {
        accessor.map_or(NONE, |accessor| buffers.first_same(accessor) as u64)
    };
    let mut shape = vec![(pose.skin.as_ref()).map_or(NONE, |skin| skin.number as u64)];
    shape.push(pose.weights.len() as u64);
    shape.extend(pose.weights.iter().map(|weight| weight.to_bits()));
    for primitive in &mesh.primitives {
        shape.extend([
            number(attribute(primitive, Semantic::Positions)),
            number(attribute(primitive, Semantic::Normals)),
            number(primitive.indices),
            match primitive.mode {
                Checked::Valid(mode) => mode.as_gl_enum().into(),
                Checked::Invalid => NONE,
            },
        ]);
        if !pose.weights.is_empty() {
            let targets = primitive.targets.iter().flatten();
            shape.extend(targets.flat_map(|t| [t.positions, t.normals].map(number)));
            shape.push(NONE);
        }
        if let Some(skin) = &pose.skin {
            if !pose::has_joints(primitive) {
                shape.extend(skin.node.to_cols_array().map(f64::to_bits));
            }
            let influences = pose::influence_accessors(primitive);
            shape.extend(influences.flat_map(|both| both.map(|a| number(Some(a)))));
            shape.push(NONE);
        }
    }
    shape
}

#[cfg(test)]
mod tests;
