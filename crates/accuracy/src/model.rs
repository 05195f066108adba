//! What a triangle with vertex normals can be taken for.

use curvetri::curved::CurvedOptions;
use curvetri::method::Surface;

/// What a triangle with vertex normals is taken for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SurfaceModel {
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

impl SurfaceModel {
    /// The flat triangles, the paper's own form, and our surfaces.
    pub const OURS: [SurfaceModel; 5] = [
        SurfaceModel::Flat,
        SurfaceModel::Paper,
        SurfaceModel::Curved(Surface::Angular),
        SurfaceModel::Curved(Surface::Tensor),
        SurfaceModel::Curved(Surface::Smooth),
    ];

    /// The other methods' triangles.
    pub const PEERS: [SurfaceModel; 3] = [
        SurfaceModel::Peer(Peer::Pn),
        SurfaceModel::Peer(Peer::Phong),
        SurfaceModel::Peer(Peer::Nagata),
    ];

    /// How its mesh is curved; `None` if it is not one of our curved surfaces.
    pub(super) fn options(self) -> Option<CurvedOptions> {
        match self {
            SurfaceModel::Flat | SurfaceModel::Peer(_) => None,
            SurfaceModel::Paper => Some(CurvedOptions::paper()),
            SurfaceModel::Curved(surface) => Some(CurvedOptions {
                surface,
                ..CurvedOptions::default()
            }),
        }
    }

    /// The name it has in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            SurfaceModel::Flat => "flat",
            SurfaceModel::Paper => "paper",
            SurfaceModel::Curved(surface) => surface.name(),
            SurfaceModel::Peer(Peer::Pn) => "pn",
            SurfaceModel::Peer(Peer::Phong) => "phong",
            SurfaceModel::Peer(Peer::Nagata) => "nagata",
        }
    }
}
