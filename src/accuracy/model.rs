//! What a triangle with vertex normals can be taken for.

use crate::surface::Surface;

/// What a triangle with vertex normals is taken for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Model {
    /// Itself.
    Flat,
    /// One of our surfaces.
    Curved(Surface),
}

impl Model {
    /// The flat triangles and our surfaces.
    pub const OURS: [Model; 4] = [
        Model::Flat,
        Model::Curved(Surface::Angular),
        Model::Curved(Surface::Tensor),
        Model::Curved(Surface::Smooth),
    ];

    /// The name it has in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Model::Flat => "flat",
            Model::Curved(surface) => surface.name(),
        }
    }
}
