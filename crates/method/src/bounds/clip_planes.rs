//! The planes of the volume that a ray is clipped to.

use crate::numbers::{Constant, Real, Scalar, Vector};
use crate::patch::{ClipVolume, HalfSpace, Sphere, TriangleFrame, roots};

/// How far beyond its edges a patch is still searched, in barycentric coordinates, before the
/// ray's own rounding: a guard, so that no ray slips between neighbours. 256 epsilons are 3.1e-5.
///
/// Measured, not derived: a quarter of it lost no more rays at shared edges, and counted no fewer twice
/// (docs/decisions/0009).
pub(crate) const OVERLAP_EPSILONS: f64 = 256.0;

/// What a ray from one unit away moves by rounding, in units of epsilon.
///
/// Derived: with u half an epsilon, a component of `(o - p) + t d` is off by at most 3 u of the distance: one
/// for the difference, one for the sum with the product, one for t itself. Over three components that is
/// `3 sqrt(3) u`, 2.6 epsilons; the planes' own rounding takes the rest of the 4.
pub(crate) const RAY_EPSILONS: f64 = 4.0;

impl<S: Constant> ClipVolume<S> {
    /// The hull of a patch with these least and greatest heights, or with a sphere in their place; of a
    /// plane triangle, not a thin one, without heights.
    #[inline(always)]
    pub fn around(
        frame: &TriangleFrame<S>,
        normals: &[Vector<S>; 3],
        slab: Option<[S; 2]>,
        sphere: Option<Sphere<S>>,
    ) -> Self {
        let lanes = frame.area2;
        let up = frame.cross * frame.winding;
        // Of the guides below.
        let longest_guide = match slab {
            Some(_) => lanes.two(),
            None => frame.area2,
        };
        let lengths = roots(frame.lengths2);
        let [first, second, third] = three!(|k| {
            // The guides' plane through the edge; it stands upright where the triangle is flat.
            let guide = match slab {
                Some(_) => normals[k] + normals[(k + 1) % 3],
                None => up,
            };
            let reach = longest_guide * lengths[k];
            HalfSpace::of_edge(frame.edge_vectors[k], guide, up, frame.winding, reach)
        });
        // A flat triangle's slab has no thickness: there the crossing of its plane decides.
        let [below, above] = match slab {
            Some([least, most]) if sphere.is_none() => [-least * frame.area2, most * frame.area2],
            _ => [lanes.constant(f64::INFINITY); 2],
        };
        Self {
            origin: frame.origin,
            unit: frame.size.per_power_of_two(),
            planes: [
                first,
                second.through(frame.edge_vectors[0]),
                third,
                HalfSpace::level(up, below, frame.area2),
                HalfSpace::level(-up, above, frame.area2),
            ],
            sphere,
            thin: None,
            exists: true,
        }
    }
}

impl<V: Real> HalfSpace<V> {
    /// Through an edge that begins at the origin, along a guide of the edge of any length; `up` is the
    /// triangle's normal, twice its area long, and `reach` is about as long as the normal will be.
    #[inline(always)]
    pub fn of_edge(
        edge_vector: Vector<V>,
        guide: Vector<V>,
        up: Vector<V>,
        winding: V,
        reach: V,
    ) -> Self {
        // The value at the opposite vertex: a barycentric coordinate of 1.
        let whole = guide.dot(up);
        Self {
            normal: guide.cross(edge_vector) * winding,
            offset: whole * whole.constant(V::Scalar::PRECISION * OVERLAP_EPSILONS),
            distance_tolerance: reach * reach.constant(V::Scalar::PRECISION * RAY_EPSILONS),
        }
    }

    /// The same where the edge begins elsewhere.
    #[inline(always)]
    pub fn through(self, way: Vector<V>) -> Self {
        Self {
            offset: self.offset - self.normal.dot(way),
            ..self
        }
    }

    /// Across the triangle's normal or its opposite, that far from the origin times twice the area.
    #[inline(always)]
    pub fn level(normal: Vector<V>, offset: V, area2: V) -> Self {
        Self {
            normal,
            offset,
            distance_tolerance: area2 * area2.constant(V::Scalar::PRECISION * RAY_EPSILONS),
        }
    }
}

impl<S: Scalar> ClipVolume<S> {
    /// The same of a plane triangle of any height as well.
    #[inline(always)]
    pub fn new(
        frame: &TriangleFrame<S>,
        normals: &[Vector<S>; 3],
        slab: Option<[S; 2]>,
        sphere: Option<Sphere<S>>,
    ) -> Self {
        Self {
            thin: (slab.is_none() && frame.is_thin()).then_some(frame.area2),
            ..Self::around(frame, normals, slab, sphere)
        }
    }
}
