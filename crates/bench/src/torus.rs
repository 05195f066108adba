//! Bytes for the same error, on a torus whose true surface is known.

use std::sync::Arc;

use super::forms::{Cut, TracedForm};
use super::{BenchError, Clock, SurfaceErrors};
use curvetri::curved::{CurvedMesh, CurvedOptions};
use curvetri::embree::BuildQuality;
use curvetri_bodies::Body;

/// What a torus of 48 by 64 pieces takes as curved triangles, and what it takes to be as near to the
/// true torus with flat ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorusBytes {
    /// The errors, over the torus's ring radius.
    pub errors: SurfaceErrors,
    /// Into how many parts each edge is cut.
    pub parts: u32,
    /// Bytes of the curved triangles, all together.
    pub curved: u64,
    /// Of flat triangles.
    pub tessellated: u64,
    /// Of Embree's grids.
    pub grids: u64,
}

/// Measures it.
///
/// # Errors
/// If Embree fails.
pub fn torus_bytes() -> Result<TorusBytes, BenchError> {
    let body = Body::torus(48, 64);
    let mesh = Arc::new(body.mesh());
    let curved = CurvedMesh::new(mesh.clone(), &CurvedOptions::default());
    let errors = SurfaceErrors::of(&curved, |p| body.signed_distance(p));
    let parts = errors.parts();
    let plain = TracedForm::Curved {
        options: CurvedOptions::default(),
        device: "",
        compact: false,
        quality: BuildQuality::Medium,
    };
    let bytes = |form: TracedForm| {
        Ok::<_, BenchError>(form.build(&mesh, parts, Clock::Wall)?.bytes.total())
    };
    Ok(TorusBytes {
        errors,
        parts,
        curved: bytes(plain)?,
        tessellated: bytes(TracedForm::Tessellated(Cut::EqualError))?,
        grids: bytes(TracedForm::Grids(Cut::EqualError))?,
    })
}
