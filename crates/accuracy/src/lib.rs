//! How far the surfaces are from the truth: the paper's Table 1, for bodies whose true surface is
//! known.
//!
//! The error is the paper's: from a point of the surface along its guide to the true surface, over
//! the body's largest diameter. Beside it stand the angle of the surface's own geometric normal to
//! the true one, and its jump across edges.
//!
//! Surfaces are measured *unchecked* ([`unchecked`](curvetri::curved::CurvedOptions::unchecked)): curved as the method has them,
//! also where our own test of validity would keep a triangle flat. The paper's torus of 6 by 8
//! pieces is so coarse that half of its triangles fail that test; the paper's figures for it are
//! those of the curved form. [`BodyRow::flat_by_default`] counts such triangles, so that nobody takes
//! the figures for what the renderer shows there.
//!
//! Beside ours stand other methods' curved triangles ([`SurfaceModel::PEERS`]). They have no guides: their
//! error is the distance to the nearest point of the true surface, which is a little smaller. Where
//! the cuts get finer, [`order`] and [`triangles_needed`] tell how fast a model closes in on the truth.
//!
//! [`measure`] computes in `f64` from the vertices; [`measure_traced`] shoots rays along the guides
//! through Embree and the `f32` kernel. [`SurfaceModel::Paper`] has the same surface as `angular`, and is
//! measured by rays in both: in `f64` as well its points are those that the paper's algorithm finds,
//! to 24 binary digits of the way through its sphere.

mod bezier;
mod facet;
mod model;
mod needed;
mod probe;
mod sampling;
mod shared_edges;
mod traced;

use std::sync::Arc;

use rayon::prelude::*;

use curvetri::curved::CurvedMesh;
use curvetri::embree::{Device, Error};
use curvetri_bodies::Body;
use facet::ModelFacets;
use probe::{SurfaceProbe, Tally};

pub use model::{Peer, SurfaceModel};
pub use needed::{Measure, Needed, order, triangles_needed};

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AccuracyOptions {
    /// Points a body, shared equally by its triangles; each gets [`LEAST_SAMPLES`] at the least.
    pub samples: usize,
    /// Where the points lie: the same seed gives the same figures.
    pub seed: u64,
}

impl Default for AccuracyOptions {
    fn default() -> Self {
        Self {
            samples: 100_000,
            seed: 1,
        }
    }
}

/// Points of a triangle at the least; an edge has half as many.
pub const LEAST_SAMPLES: usize = 8;

/// What was measured of one body by one model.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyRow {
    /// The body's name.
    pub body: String,
    /// Triangles of its cut.
    pub triangles: usize,
    /// What the triangles were taken for.
    pub model: SurfaceModel,
    /// Greatest error over the body's largest diameter, edges included.
    pub max: f64,
    /// Mean error over the body's largest diameter, of as many points on each triangle, uniform over
    /// its area.
    pub mean: f64,
    /// Mean angle of the geometric normal to the true one, degrees.
    pub normal_deg: f64,
    /// Mean jump of the geometric normal across the edges where two triangles share both vertex
    /// normals, degrees, of as many points on each edge; `None` where there is no such edge.
    pub jump_deg: Option<f64>,
    /// Triangles that a [`CurvedMesh`] keeps flat by default.
    pub flat_by_default: usize,
    /// Points that were measured.
    pub points: usize,
    /// Points that could not be: no ray hit there, or the guide passes the true surface by.
    pub missed: usize,
}

/// The bodies of the table: the paper's Table 1, then finer cuts of its torus.
#[must_use]
pub fn bodies() -> Vec<Body> {
    let mut bodies = Body::table_1();
    bodies.extend(Body::torus_series().into_iter().skip(1));
    bodies
}

/// Measures a model on a body in `f64`.
#[must_use]
pub fn measure(body: &Body, model: SurfaceModel, options: &AccuracyOptions) -> BodyRow {
    let facets = ModelFacets::new(body.triangles(), model);
    row(body, model, &facets, options)
}

/// Measures one of our surfaces, or the flat triangles themselves, by rays through Embree: the curved mesh is a user geometry and its kernel computes in `f32`; flat triangles are Embree's own.
///
/// Each ray runs along a guide, starts outside and close to the surface, and takes the first hit.
/// For the jump, rays along the guides of an edge's points are traced against each of its two triangles.
///
/// # Errors
/// What Embree reports, such as too little memory.
///
/// # Panics
/// If the model is one of the peers: rays are traced against our own surfaces only.
pub fn measure_traced(
    device: &Device,
    body: &Body,
    model: SurfaceModel,
    options: &AccuracyOptions,
) -> Result<BodyRow, Error> {
    let traced = traced::TracedBody::new(device, body, model)?;
    Ok(row(body, model, &traced, options))
}

fn row(
    body: &Body,
    model: SurfaceModel,
    probe: &impl SurfaceProbe,
    options: &AccuracyOptions,
) -> BodyRow {
    let count = body.triangles().len();
    let samples = (options.samples / count).max(LEAST_SAMPLES);
    // Added up in the triangles' order, so that the sums do not depend on the threads.
    let tallies: Vec<Tally> = (0..count)
        .into_par_iter()
        .map(|t| probe::measure_triangle(body, probe, t, samples, options.seed))
        .collect();
    let total = tallies.into_iter().fold(Tally::default(), Tally::add);
    BodyRow {
        body: body.name().to_owned(),
        triangles: count,
        model,
        max: total.max / body.diameter(),
        mean: total.mean_error() / body.diameter(),
        normal_deg: total.mean_angle().to_degrees(),
        jump_deg: shared_edges::mean_jump(body, probe, samples / 2, options.seed)
            .map(f64::to_degrees),
        flat_by_default: flat_by_default(body, model),
        points: total.measured,
        missed: total.missed,
    }
}

fn flat_by_default(body: &Body, model: SurfaceModel) -> usize {
    let Some(options) = model.options() else {
        return 0;
    };
    CurvedMesh::new(Arc::new(body.mesh()), &options)
        .kinds()
        .flat()
}
