//! Meshes apart from where they are used.

use glam::DAffine3;

use super::Mesh;

/// Meshes, each once, and all their uses.
#[derive(Debug, Clone, Default)]
pub struct Parts {
    /// The meshes, each in a space of its own.
    pub meshes: Vec<Mesh>,
    /// Where they are used.
    pub placements: Vec<Placement>,
}

/// One use of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// The mesh's number among the parts.
    pub part: usize,
    /// From the mesh's space ([`Mesh::origin`] taken into account) to the user's. It may mirror: a
    /// triangle's front stays its front.
    pub to_user: DAffine3,
}

impl Placement {
    /// A part that is in the user's space as it is.
    pub fn in_place(part: usize) -> Placement {
        Placement {
            part,
            to_user: DAffine3::IDENTITY,
        }
    }

    /// Whether the part is in the user's space as it is.
    pub fn is_in_place(&self) -> bool {
        self.to_user == DAffine3::IDENTITY
    }
}

impl Parts {
    /// Puts other parts behind these.
    pub fn append(&mut self, other: Parts) {
        let first = self.meshes.len();
        self.meshes.extend(other.meshes);
        let placements = other.placements.into_iter().map(|placement| Placement {
            part: first + placement.part,
            ..placement
        });
        self.placements.extend(placements);
    }
}

impl From<Vec<Mesh>> for Parts {
    /// Meshes in the user's space, each used once.
    fn from(meshes: Vec<Mesh>) -> Parts {
        Parts {
            placements: (0..meshes.len()).map(Placement::in_place).collect(),
            meshes,
        }
    }
}

impl From<Mesh> for Parts {
    /// A mesh in the user's space.
    fn from(mesh: Mesh) -> Parts {
        vec![mesh].into()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn appended_parts_keep_their_meshes() {
        let mesh = |size: f64| {
            let positions = vec![DVec3::ZERO, size * DVec3::X, size * DVec3::Y];
            Mesh::new(positions, None, vec![[0, 1, 2]]).unwrap()
        };
        let mut parts = Parts::from(vec![mesh(1.0), mesh(2.0)]);
        let mut other = Parts::from(mesh(3.0));
        other.placements.push(Placement {
            part: 0,
            to_user: DAffine3::from_scale(DVec3::NEG_ONE),
        });
        parts.append(other);
        let of: Vec<_> = (parts.placements.iter())
            .map(|p| (parts.meshes[p.part].positions()[1].x, p.is_in_place()))
            .collect();
        assert_eq!(of, [(1.0, true), (2.0, true), (3.0, true), (3.0, false)]);
    }
}
