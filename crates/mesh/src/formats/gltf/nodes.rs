//! Where the nodes of a glTF file are.

use glam::{DAffine3, DMat4, DQuat, DVec3};
use gltf::json::{self, Index, Node, Root};

/// The nodes of the scene and where they are.
pub(super) fn place(root: &Root) -> Result<Vec<(usize, DAffine3)>, String> {
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
            let parents = parents(root);
            let is_top = |&node: &usize| parents[node].is_none();
            Ok((0..root.nodes.len()).filter(is_top).collect())
        }
    }
}

/// The first parent of each node.
fn parents(root: &Root) -> Vec<Option<usize>> {
    let mut parents = vec![None; root.nodes.len()];
    for (number, node) in root.nodes.iter().enumerate() {
        for child in node.children.iter().flatten() {
            if let Some(parent) = parents.get_mut(child.value()) {
                parent.get_or_insert(number);
            }
        }
    }
    parents
}

/// From the space of each node to that of the top, also of nodes that the scene does not show:
/// joints of a skin may be among them.
pub(super) struct WorldTransforms<'a> {
    root: &'a Root,
    parents: Vec<Option<usize>>,
    known: Vec<Option<DAffine3>>,
}

impl<'a> WorldTransforms<'a> {
    pub(super) fn new(root: &'a Root, placed: &[(usize, DAffine3)]) -> WorldTransforms<'a> {
        let mut known = vec![None; root.nodes.len()];
        for &(node, to_scene) in placed {
            known[node] = Some(to_scene);
        }
        WorldTransforms {
            root,
            parents: parents(root),
            known,
        }
    }

    pub(super) fn of(&mut self, node: usize) -> Result<DAffine3, String> {
        if node >= self.known.len() {
            return Err(format!("there is no node {node}"));
        }
        // Up to a node that is known or at the top, and down again.
        let mut way = Vec::new();
        let mut next = Some(node);
        while let Some(node) = next
            && self.known[node].is_none()
        {
            if way.len() == self.known.len() {
                return Err(format!("node {node} is its own parent"));
            }
            way.push(node);
            next = self.parents[node];
        }
        let mut to_world = next.map_or(DAffine3::IDENTITY, |node| {
            self.known[node].unwrap_or(DAffine3::IDENTITY)
        });
        for node in way.into_iter().rev() {
            to_world *= transform(&self.root.nodes[node]);
            self.known[node] = Some(to_world);
        }
        Ok(to_world)
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
