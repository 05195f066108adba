//! How fast the models close in on the truth, and how many triangles they take for it.

use std::collections::BTreeMap;

use super::facet::ModelFacets;
use super::model::SurfaceModel;
use super::probe::{Tally, measure_triangle};
use curvetri_bodies::Body;

/// Torus cuts tried at most: up to this many times 3 by 4 pieces.
const FINEST: usize = 256;
/// Points a triangle at the least, so that the maximum is not a matter of luck.
const LEAST_POINTS: usize = 32;
/// Points of a cut, shared by its triangles.
const POINTS: usize = 20_000;

/// Which error is to become small.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Measure {
    /// The mean over the surface.
    Mean,
    /// The greatest on the surface.
    Max,
}

impl Measure {
    /// The name it has in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Measure::Mean => "mean",
            Measure::Max => "max",
        }
    }
}

/// The coarsest torus of 3k by 4k pieces on which a model is as good as it has to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Needed {
    /// What the triangles were taken for.
    pub model: SurfaceModel,
    /// Which error.
    pub measure: Measure,
    /// How small it was to be, over the torus's largest diameter.
    pub error: f64,
    /// Pieces around the axis and around the tube; `None` if none of the cuts tried is fine enough.
    pub pieces: Option<[usize; 2]>,
}

impl Needed {
    /// Triangles of the cut.
    #[must_use]
    pub fn triangles(&self) -> Option<usize> {
        self.pieces.map(|[ring, tube]| 2 * ring * tube)
    }
}

/// The observed order of convergence: the power of the triangles' size that the error follows, from
/// its values before and after all sizes were halved.
#[must_use]
pub fn order(coarse: f64, fine: f64) -> f64 {
    (coarse / fine).log2()
}

/// How many triangles a model needs on the torus for each of these errors, mean and greatest, over
/// cuts of 3k by 4k pieces.
///
/// The search doubles k until the error is small enough and then bisects: errors are taken to fall
/// with k.
#[must_use]
pub fn triangles_needed(model: SurfaceModel, errors: &[f64], seed: u64) -> Vec<Needed> {
    let mut cuts = Cuts {
        model,
        seed,
        measured: BTreeMap::new(),
    };
    let mut needed = Vec::new();
    for measure in [Measure::Mean, Measure::Max] {
        for &error in errors {
            let k = cuts.coarsest(measure, error);
            needed.push(Needed {
                model,
                measure,
                error,
                pieces: k.map(|k| [3 * k, 4 * k]),
            });
        }
    }
    needed
}

/// Torus cuts of 3k by 4k pieces and their errors, mean and greatest, by k.
struct Cuts {
    model: SurfaceModel,
    seed: u64,
    measured: BTreeMap<usize, [f64; 2]>,
}

impl Cuts {
    fn coarsest(&mut self, measure: Measure, error: f64) -> Option<usize> {
        let mut fine = 1;
        while self.error(fine, measure) > error {
            fine *= 2;
            if fine > FINEST {
                return None;
            }
        }
        let mut coarse = fine / 2;
        while fine - coarse > 1 {
            let middle = coarse.midpoint(fine);
            if self.error(middle, measure) > error {
                coarse = middle;
            } else {
                fine = middle;
            }
        }
        Some(fine)
    }

    fn error(&mut self, k: usize, measure: Measure) -> f64 {
        let (model, seed) = (self.model, self.seed);
        let errors = self.measured.entry(k).or_insert_with(|| {
            let body = Body::torus(3 * k, 4 * k);
            errors(&body, 8 * k, model, seed)
        });
        match measure {
            Measure::Mean => errors[0],
            Measure::Max => errors[1],
        }
    }
}

/// Mean and greatest error over the body's first triangles, those of one piece of the ring: it is
/// like all the others. Infinite where the surface cannot be measured.
fn errors(body: &Body, triangles: usize, model: SurfaceModel, seed: u64) -> [f64; 2] {
    let facets = ModelFacets::new(&body.triangles()[..triangles], model);
    let samples = (POINTS / triangles).max(LEAST_POINTS);
    let total = (0..triangles)
        .map(|t| measure_triangle(body, &facets, t, samples, seed))
        .fold(Tally::default(), Tally::add);
    if total.missed > 0 {
        return [f64::INFINITY; 2];
    }
    [total.mean_error(), total.max].map(|error| error / body.diameter())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halving_the_size_of_a_cubic_error_is_order_three() {
        assert!((order(8e-3, 1e-3) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn the_cut_found_is_the_coarsest_that_is_fine_enough() {
        let model = SurfaceModel::Flat;
        let [mean, max] = triangles_needed(model, &[2e-3], 1).try_into().unwrap();
        let error = |k: usize| errors(&Body::torus(3 * k, 4 * k), 8 * k, model, 1);
        for (needed, which) in [(mean, 0), (max, 1)] {
            let k = needed.pieces.unwrap()[0] / 3;
            assert!(error(k)[which] <= 2e-3 && error(k - 1)[which] > 2e-3, "{k}");
            assert_eq!(needed.triangles(), Some(24 * k * k));
        }
    }

    #[test]
    fn one_piece_of_the_ring_stands_for_all() {
        let body = Body::torus(12, 16);
        for model in SurfaceModel::OURS.into_iter().chain(SurfaceModel::PEERS) {
            let (piece, all) = (errors(&body, 32, model, 1), errors(&body, 384, model, 1));
            for (piece, all) in piece.into_iter().zip(all) {
                assert!((piece / all - 1.0).abs() < 0.02, "{model:?}: {piece} {all}");
            }
        }
    }
}
