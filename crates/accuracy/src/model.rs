//! What a triangle with vertex normals can be taken for.

use curvetri::curved::CurvedOptions;
use curvetri::method::Surface;

/// What a triangle with vertex normals is taken for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Model {
    /// Itself.
    Flat,
    /// The angular surface in the paper's own form: as rays find it within the sphere of greatest
    /// curvature by the iterative algorithm ([`CurvedOptions::paper`]).
    Paper,
    /// One of our surfaces.
    Curved(Surface),
    /// Another method's curved triangle.
    Peer(Peer),
}

/// Other methods' curved triangles of the same input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Peer {
    /// Curved PN triangles (Vlachos and others, 2001): a cubic.
    Pn,
    /// Phong tessellation (Boubekeur and Alexa, 2008): a quadratic; shape factor 3/4.
    Phong,
    /// Nagata's patch (2005): a quadratic.
    Nagata,
}

impl Model {
    /// The flat triangles, the paper's own form, and our surfaces.
    pub const OURS: [Model; 5] = [
        Model::Flat,
        Model::Paper,
        Model::Curved(Surface::Angular),
        Model::Curved(Surface::Tensor),
        Model::Curved(Surface::Smooth),
    ];

    /// The other methods' triangles.
    pub const PEERS: [Model; 3] = [
        Model::Peer(Peer::Pn),
        Model::Peer(Peer::Phong),
        Model::Peer(Peer::Nagata),
    ];

    /// How its mesh is curved; `None` if it is not one of our curved surfaces.
    pub(super) fn options(self) -> Option<CurvedOptions> {
        match self {
            Model::Flat | Model::Peer(_) => None,
            Model::Paper => Some(CurvedOptions::paper()),
            Model::Curved(surface) => Some(CurvedOptions {
                surface,
                ..CurvedOptions::default()
            }),
        }
    }

    /// The name it has in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Model::Flat => "flat",
            Model::Paper => "paper",
            Model::Curved(surface) => surface.name(),
            Model::Peer(Peer::Pn) => "pn",
            Model::Peer(Peer::Phong) => "phong",
            Model::Peer(Peer::Nagata) => "nagata",
        }
    }
}
