//! The surface at given barycentric coordinates: point, tangents, geometric normal.

use super::dual::Dual;
use super::guide::Foot;
use super::patch::{Patch, next};
use super::real::{Real, Scalar};
use super::vector::{Vector, vector};

/// A point of the curved surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint<V> {
    /// Position, in the space of the patch's positions.
    pub position: Vector<V>,
    /// Derivative of the position by `u = b2`.
    pub tangent_u: Vector<V>,
    /// Derivative of the position by `v = b3`.
    pub tangent_v: Vector<V>,
    /// The surface's own geometric normal: unit, on the side of the vertex normals.
    pub normal: Vector<V>,
}

impl<S: Scalar> Patch<S> {
    /// The surface over the plane point with barycentric coordinates `(1 - u - v, u, v)`.
    ///
    /// Analytic: derivatives are carried through the very source that computes the height. On a
    /// median, where the guide field has a kink, they are those of one side.
    #[inline(always)]
    pub fn point<V: Real<Scalar = S>>(&self, u: V, v: V) -> SurfacePoint<V> {
        let b2 = Dual::<V, 2>::variable(u, 0);
        let b3 = Dual::<V, 2>::variable(v, 1);
        let one = Dual { value: V::constant(1.0), parts: [V::constant(0.0); 2] };
        let foot = self.foot_at::<V, _>([one - b2 - b3, b2, b3]);
        let h = self.height(&foot);
        let inward = self.inward(&foot);
        let normal = Vector::<V>::splat(self.normal);
        let [to_second, to_third] = self.spokes.map(Vector::<V>::splat);
        let out = foot.lean * h;
        let local = to_second * u + to_third * v + normal * h.value + inward * out.value;
        let tangent = |n: usize, spoke: Vector<V>| {
            spoke + normal * h.parts[n] + inward * out.parts[n]
        };
        let (tangent_u, tangent_v) = (tangent(0, to_second), tangent(1, to_third));
        let across = tangent_u.cross(tangent_v) * V::splat(self.winding);
        let size = V::splat(self.size);
        SurfacePoint {
            position: local * size + Vector::splat(self.origin),
            tangent_u: tangent_u * size,
            tangent_v: tangent_v * size,
            normal: across.normalize(),
        }
    }

    /// The inward perpendicular of the foot's side.
    #[inline(always)]
    fn inward<V: Real<Scalar = S>, T>(&self, foot: &Foot<V, T>) -> Vector<V> {
        let of = |component: fn(Vector<S>) -> S| {
            foot.choice.constant(|k| {
                component(self.gradients[next(next(k))]) * self.sides[k].height
            })
        };
        vector(of(|g| g.x), of(|g| g.y), of(|g| g.z))
    }
}
