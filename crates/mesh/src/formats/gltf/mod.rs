//! Reads glTF 2.0 files, JSON and binary.
//!
//! A mesh that is placed several times is read once; the model holds its placements.

mod buffers;
mod scenery;

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{self, Index, Node, Root};

use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::Parsed;
use crate::error::Fault;
use crate::instances::Placement;
use crate::model::Model;
use crate::normals::NO_NORMAL;
use crate::raw_mesh::RawMesh;
use crate::report::LoadReport;
use buffers::Buffers;

/// Extensions that say nothing of the surface's shape, or nothing that is not read.
const HARMLESS: [&str; 10] = [
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_animation_",
    "KHR_xmp",
    "KHR_mesh_quantization",
    "MSFT_texture_",
    "ADOBE_materials_",
];

/// Reads a glTF file, JSON or binary; `path` is for the files it names.
pub(super) fn read(bytes: &[u8], path: &Path) -> Result<Parsed, Fault> {
    let (json, binary) = split(bytes)?;
    let root = Root::from_slice(&json).map_err(|error| {
        let has_line = binary.is_none() && error.line() > 0;
        Fault::Caused {
            line: has_line.then(|| error.line()),
            what: "the glTF's JSON is wrong".into(),
            source: error.into(),
        }
    })?;
    read_model(&root, binary, path).map_err(Fault::Content)
}

/// A part of the file.
type Chunk<'a> = Cow<'a, [u8]>;

/// The JSON and the binary chunk.
fn split(bytes: &[u8]) -> Result<(Chunk<'_>, Option<Chunk<'_>>), Fault> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes.into(), None));
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

fn read_model(root: &Root, binary: Option<Cow<'_, [u8]>>, path: &Path) -> Result<Parsed, String> {
    let mut report = LoadReport::default();
    check_extensions(root, &mut report)?;
    let mut buffers = Buffers::load(root, binary, path)?;
    let nodes = place_nodes(root)?;
    let scenery = scenery::read(root, &nodes, &mut report)?;
    let mut model = Model::default();
    let mut part_of: HashMap<Shape, usize> = HashMap::new();
    for &(node, to_user) in &nodes {
        let Some(index) = root.nodes[node].mesh else {
            continue;
        };
        let mesh = root.get(index);
        let mesh = mesh.ok_or_else(|| format!("there is no mesh {}", index.value()))?;
        let shape = shape(mesh);
        let part = match part_of.get(&shape) {
            Some(&part) => part,
            None => {
                let part = read_mesh(index.value(), mesh, &mut buffers, &mut report)?;
                model.parts.push(part);
                part_of.insert(shape, model.parts.len() - 1);
                model.parts.len() - 1
            }
        };
        model.placements.push(Placement { part, to_user });
    }
    warn_of_poses(root, &nodes, &mut report);
    Ok(Parsed {
        model,
        scenery,
        report,
    })
}

fn check_extensions(root: &Root, report: &mut LoadReport) -> Result<(), String> {
    let is_harmless = |name: &str| HARMLESS.iter().any(|start| name.starts_with(start));
    for name in &root.extensions_required {
        if !is_harmless(name) {
            return Err(format!(
                "it needs the glTF extension {name}, which is not read; export it without"
            ));
        }
    }
    if root
        .extensions_used
        .iter()
        .any(|e| e == "EXT_mesh_gpu_instancing")
    {
        let what = "copies made by EXT_mesh_gpu_instancing are not read";
        report.warnings.push(what.into());
    }
    Ok(())
}

/// Warns of what the file says about its meshes' pose and is not read.
fn warn_of_poses(root: &Root, nodes: &[(usize, DAffine3)], report: &mut LoadReport) {
    let used = || nodes.iter().map(|&(node, _)| &root.nodes[node]);
    if used().any(|node| node.mesh.is_some() && node.skin.is_some()) {
        let what = "the mesh has a skeleton; it is read as it was built, without its pose";
        report.warnings.push(what.into());
    }
    let is_morphed = |node: &Node| {
        let mesh = node.mesh.and_then(|mesh| root.get(mesh));
        let weights = node.weights.as_ref();
        let weights = weights.or(mesh.and_then(|mesh| mesh.weights.as_ref()));
        weights.is_some_and(|weights| weights.iter().any(|&w| w != 0.0))
    };
    if used().any(is_morphed) {
        let what = "the mesh has morph targets; it is read without them";
        report.warnings.push(what.into());
    }
}

/// The nodes of the scene and where they are.
fn place_nodes(root: &Root) -> Result<Vec<(usize, DAffine3)>, String> {
    let mut left: Vec<(usize, DAffine3)> = Vec::new();
    left.extend(
        roots(root)?
            .into_iter()
            .rev()
            .map(|n| (n, DAffine3::IDENTITY)),
    );
    let mut seen = vec![false; root.nodes.len()];
    let mut placed = Vec::new();
    while let Some((index, parent)) = left.pop() {
        let node = root.nodes.get(index);
        let node = node.ok_or_else(|| format!("there is no node {index}"))?;
        if std::mem::replace(&mut seen[index], true) {
            return Err(format!("node {index} has two parents or is its own"));
        }
        let to_scene = parent * transform(node);
        placed.push((index, to_scene));
        let children = node.children.iter().flatten().rev();
        left.extend(children.map(|child| (child.value(), to_scene)));
    }
    Ok(placed)
}

/// The nodes at the top: those of the default scene, or the first, or those without a parent.
fn roots(root: &Root) -> Result<Vec<usize>, String> {
    let scene = root.scene.map_or(0, |scene| scene.value());
    let values = |nodes: &[Index<Node>]| nodes.iter().map(|n| n.value()).collect();
    match root.scenes.get(scene) {
        Some(scene) => Ok(values(&scene.nodes)),
        None if root.scene.is_some() => Err(format!("there is no scene {scene}")),
        None => {
            let mut is_child = vec![false; root.nodes.len()];
            for child in root.nodes.iter().flat_map(|n| n.children.iter().flatten()) {
                if let Some(mark) = is_child.get_mut(child.value()) {
                    *mark = true;
                }
            }
            Ok((0..root.nodes.len()).filter(|&n| !is_child[n]).collect())
        }
    }
}

/// From a node's space to its parent's.
fn transform(node: &Node) -> DAffine3 {
    if let Some(matrix) = &node.matrix {
        return DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from)));
    }
    let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let scale = node.scale.map_or(DVec3::ONE, vector);
    let rotation = node
        .rotation
        .map_or(DQuat::IDENTITY, |json::scene::UnitQuaternion(q)| {
            let q = DQuat::from_array(q.map(f64::from));
            // A file's four single-precision numbers are of length one only nearly.
            if q.length_squared() > 0.0 {
                q.normalize()
            } else {
                DQuat::IDENTITY
            }
        });
    let translation = node.translation.map_or(DVec3::ZERO, vector);
    DAffine3::from_scale_rotation_translation(scale, rotation, translation)
}

/// What makes a primitive's shape: accessors of positions, normals and indices, and the mode.
type Shape = Vec<([Option<usize>; 3], Option<u32>)>;

/// The shape of a mesh. Meshes that differ by material only have the same.
fn shape(mesh: &json::Mesh) -> Shape {
    let of = |primitive: &Primitive| {
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let accessors = [
            attribute(Semantic::Positions),
            attribute(Semantic::Normals),
            primitive.indices,
        ];
        let mode = match primitive.mode {
            Checked::Valid(mode) => Some(mode.as_gl_enum()),
            Checked::Invalid => None,
        };
        (accessors.map(|a| a.map(|a| a.value())), mode)
    };
    mesh.primitives.iter().map(of).collect()
}

/// Reads a mesh with all its primitives. Primitives may share their vertices.
fn read_mesh(
    index: usize,
    mesh: &json::Mesh,
    buffers: &mut Buffers<'_>,
    report: &mut LoadReport,
) -> Result<RawMesh, String> {
    let mut builder = PartBuilder::default();
    for (number, primitive) in mesh.primitives.iter().enumerate() {
        let named = |what: String| {
            let name = mesh.name.as_deref().unwrap_or_default();
            format!("mesh {index} {name:?}, primitive {number}: {what}")
        };
        builder.add(primitive, buffers, report).map_err(named)?;
    }
    Ok(builder.finish())
}

/// The primitives of a mesh on their way into one.
#[derive(Default)]
struct PartBuilder {
    raw: RawMesh,
    normal_corners: Vec<[u32; 3]>,
    /// Where the elements of an accessor start, and how many there are.
    positions: HashMap<usize, (u32, usize)>,
    normals: HashMap<usize, (u32, usize)>,
}

impl PartBuilder {
    fn add(
        &mut self,
        primitive: &Primitive,
        buffers: &mut Buffers<'_>,
        report: &mut LoadReport,
    ) -> Result<(), String> {
        let mode = match primitive.mode {
            Checked::Valid(mode) => mode,
            Checked::Invalid => return Err("its mode is unknown".into()),
        };
        if !matches!(
            mode,
            Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
        ) {
            report.skipped_elements += 1;
            return Ok(());
        }
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let positions = attribute(Semantic::Positions).ok_or("it has no positions")?;
        let (first, count) = append(
            positions,
            &mut self.positions,
            &mut self.raw.positions,
            buffers,
        )?;
        let own = &self.raw.positions[first as usize..][..count];
        if let Some((vertex, DVec3 { x, y, z })) =
            own.iter().enumerate().find(|(_, p)| !p.is_finite())
        {
            return Err(format!("vertex {vertex} is not finite: {x} {y} {z}"));
        }
        let normals = match attribute(Semantic::Normals) {
            Some(normals) => Some(append(
                normals,
                &mut self.normals,
                &mut self.raw.normals,
                buffers,
            )?),
            None => None,
        };
        if let Some((_, normals)) = normals
            && normals != count
        {
            return Err(format!("it has {normals} normals for {count} positions"));
        }
        let order = match primitive.indices {
            Some(indices) => buffers.indices(indices)?,
            None => (0..count as u32).collect(),
        };
        if let Some(index) = order.iter().find(|&&i| i as usize >= count) {
            return Err(format!(
                "it names vertex {index}, but there are only {count} (0 is the first)"
            ));
        }
        if mode == Mode::Triangles && order.len() % 3 != 0 {
            return Err(format!(
                "its {} corners are no whole triangles",
                order.len()
            ));
        }
        for t in triangles(mode, &order) {
            self.raw.corners.push(t.map(|i| first + i));
            self.normal_corners
                .push(t.map(|i| normals.map_or(NO_NORMAL, |(n, _)| n + i)));
            report.polygons += 1;
        }
        Ok(())
    }

    fn finish(self) -> RawMesh {
        let mut raw = self.raw;
        raw.normal_corners = (!raw.normals.is_empty()).then_some(self.normal_corners);
        raw
    }
}

/// Puts an accessor's vectors behind those there are, once.
fn append(
    accessor: Index<json::Accessor>,
    known: &mut HashMap<usize, (u32, usize)>,
    vectors: &mut Vec<DVec3>,
    buffers: &mut Buffers<'_>,
) -> Result<(u32, usize), String> {
    if let Some(&range) = known.get(&accessor.value()) {
        return Ok(range);
    }
    let new = buffers.vectors(accessor)?;
    let first = u32::try_from(vectors.len());
    let first = first.map_err(|_| "the mesh has too many vertices".to_owned())?;
    let range = (first, new.len());
    vectors.extend(new.into_iter().map(DVec3::from));
    known.insert(accessor.value(), range);
    Ok(range)
}

/// The triangles of vertices in a row.
fn triangles(mode: Mode, order: &[u32]) -> Vec<[u32; 3]> {
    let windows = || order.windows(3).enumerate();
    match mode {
        Mode::TriangleStrip => windows()
            .map(|(k, w)| {
                if k % 2 == 0 {
                    [w[0], w[1], w[2]]
                } else {
                    [w[1], w[0], w[2]]
                }
            })
            // Two equal corners only turn the strip.
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect(),
        Mode::TriangleFan => order
            .get(1..)
            .unwrap_or_default()
            .windows(2)
            .map(|w| [order[0], w[0], w[1]])
            .collect(),
        _ => order.as_chunks::<3>().0.to_vec(),
    }
}

#[cfg(test)]
mod tests;
