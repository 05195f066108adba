//! What moves the vertices of a mesh before its node places it: morph targets and skins.

use std::rc::Rc;

use glam::{DAffine3, DMat4, DVec3};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::{Index, Mesh, Node, Root};

use super::attribute;
use super::buffers::{Buffers, Elements};
use super::nodes::WorldTransforms;
use crate::model::{normal_matrix, turn_normal};

/// The pose of a mesh at a node.
#[derive(Default)]
pub(super) struct Pose {
    /// The weights of morph targets; empty if all are zero.
    pub(super) weights: Vec<f64>,
    pub(super) skin: Option<Skin>,
}

/// What places the vertices of a mesh with a skin.
pub(super) struct Skin {
    pub(super) number: usize,
    /// Of its joints, from the mesh's space to the scene's.
    pub(super) matrices: Rc<[DAffine3]>,
    /// From the node's space to the scene's: for primitives that no joint moves.
    pub(super) node: DAffine3,
}

/// The weights of a mesh's morph targets at a node: the node's own or the mesh's; empty if all are
/// zero.
pub(super) fn weights(node: &Node, mesh: &Mesh) -> Vec<f64> {
    let weights = node.weights.as_ref().or(mesh.weights.as_ref());
    let weights = weights.map_or(&[][..], |weights| weights);
    if weights.iter().all(|&weight| weight == 0.0) {
        return Vec::new();
    }
    weights.iter().copied().map(f64::from).collect()
}

/// Whether a primitive says which joints move it.
pub(super) fn has_joints(primitive: &Primitive) -> bool {
    attribute(primitive, Semantic::Joints(0)).is_some()
        && attribute(primitive, Semantic::Weights(0)).is_some()
}

/// The matrices of a skin's joints: each joint's way to the scene, behind its inverse bind matrix.
pub(super) fn joint_matrices(
    root: &Root,
    skin: usize,
    buffers: &Buffers<'_>,
    world: &mut WorldTransforms<'_>,
) -> Result<Rc<[DAffine3]>, String> {
    let index = skin;
    let named = |what: String| format!("skin {index}: {what}");
    let skin = root.skins.get(index);
    let skin = skin.ok_or_else(|| format!("there is no skin {index}"))?;
    let inverse_bind = match skin.inverse_bind_matrices {
        Some(accessor) => Some(
            buffers
                .elements::<16>(accessor, Type::Mat4)
                .map_err(named)?,
        ),
        None => None,
    };
    if let Some(matrices) = &inverse_bind
        && matrices.len() < skin.joints.len()
    {
        return Err(named(format!(
            "it has {} inverse bind matrices for {} joints",
            matrices.len(),
            skin.joints.len()
        )));
    }
    (skin.joints.iter().enumerate())
        .map(|(number, joint)| {
            let to_scene = world.of(joint.value()).map_err(named)?;
            let to_joint = inverse_bind
                .as_ref()
                .map_or(DAffine3::IDENTITY, |matrices| {
                    DAffine3::from_mat4(DMat4::from_cols_array(&matrices.get(number)))
                });
            Ok(to_scene * to_joint)
        })
        .collect()
}

/// Displacements of a morph target, and how much of them is added.
pub(super) struct Displacement<'a> {
    pub(super) weight: f64,
    pub(super) positions: Option<Rc<Elements<'a, 3>>>,
    pub(super) normals: Option<Rc<Elements<'a, 3>>>,
}

/// Which joints move the vertices of a primitive, and how much.
pub(super) struct Influences<'a> {
    /// Four joints a vertex, and their weights, in as many sets as there are. Without any the first
    /// matrix moves all.
    sets: Vec<[Elements<'a, 4>; 2]>,
    matrices: Rc<[DAffine3]>,
}

impl<'a> Influences<'a> {
    /// Those of a primitive of so many vertices.
    pub(super) fn new(
        primitive: &Primitive,
        vertices: usize,
        matrices: Rc<[DAffine3]>,
        buffers: &'a Buffers<'a>,
    ) -> Result<Influences<'a>, String> {
        let mut sets = Vec::new();
        for [joints, weights] in influence_accessors(primitive) {
            let set = [
                buffers.elements(joints, Type::Vec4)?,
                buffers.elements(weights, Type::Vec4)?,
            ];
            if set.iter().any(|elements| elements.len() != vertices) {
                let [joints, weights] = set.map(|elements| elements.len());
                return Err(format!(
                    "it has {joints} joints and {weights} weights for {vertices} positions"
                ));
            }
            sets.push(set);
        }
        Ok(Influences { sets, matrices })
    }

    /// The weighted mean of the matrices of a vertex's joints.
    pub(super) fn matrix(&self, vertex: usize) -> Result<DAffine3, String> {
        let mut sum = DAffine3::ZERO;
        let mut total = 0.0;
        for [joints, weights] in &self.sets {
            for (joint, weight) in joints.get(vertex).into_iter().zip(weights.get(vertex)) {
                if weight != 0.0 {
                    let matrix = self.joint(vertex, joint)?;
                    sum.matrix3 += weight * matrix.matrix3;
                    sum.translation += weight * matrix.translation;
                    total += weight;
                }
            }
        }
        if total == 0.0 {
            // Nothing moves it: it stays with the first joint.
            let first = self
                .sets
                .first()
                .map_or(0.0, |[joints, _]| joints.get(vertex)[0]);
            return self.joint(vertex, first);
        }
        // Whole numbers for weights add up to one only nearly.
        sum.matrix3 *= 1.0 / total;
        sum.translation /= total;
        Ok(sum)
    }

    fn joint(&self, vertex: usize, joint: f64) -> Result<DAffine3, String> {
        let matrix = self.matrices.get(joint as usize).copied();
        matrix.ok_or_else(|| {
            format!(
                "vertex {vertex} names joint {joint}, but its skin has only {} (0 is the first)",
                self.matrices.len()
            )
        })
    }
}

/// The accessors of joints and weights, in as many sets as there are both of.
pub(super) fn influence_accessors(
    primitive: &Primitive,
) -> impl Iterator<Item = [Index<gltf::json::Accessor>; 2]> {
    (0..).map_while(|set| {
        let joints = attribute(primitive, Semantic::Joints(set))?;
        let weights = attribute(primitive, Semantic::Weights(set))?;
        Some([joints, weights])
    })
}

/// A normal under a matrix, as long as it was.
pub(super) fn turn(matrix: &DAffine3, normal: DVec3) -> DVec3 {
    turn_normal(normal_matrix(matrix.matrix3), normal)
}
