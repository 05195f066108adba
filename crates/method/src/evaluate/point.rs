//! The surface at given barycentric coordinates: point, tangents, geometric normal.

use super::guide::Foot;
use crate::numbers::{Constant, Dual, Real, Vector, inlined, vector};
use crate::patch::{Patch, Rule, next};

/// How far from a vertex derivatives are taken at the least, in barycentric coordinates: 84 epsilons, so that
/// differences of coordinates there keep six binary digits. Measured: normals at vertices are the given ones to
/// within 0.1 degrees.
const OFF_VERTEX: f64 = 1e-5;

/// A point of the curved surface.
///
/// ```
/// use curvetri_method::{Patch, PatchFlags, vector};
///
/// let c = 1.0 / 3f64.sqrt();
/// let vertices = [vector(c, c, c), vector(c, -c, -c), vector(-c, c, -c)];
/// let point = Patch::new(vertices, vertices, PatchFlags::default()).point(0.2, 0.3);
/// assert!((point.position.length() - 1.0).abs() < 1e-12);
/// assert!(point.normal.dot(point.position) > 0.999);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint<V> {
    /// Position, in the space of the patch's positions.
    pub position: Vector<V>,
    /// Derivative of the position by `u = b2`.
    pub tangent_u: Vector<V>,
    /// Derivative of the position by `v = b3`.
    pub tangent_v: Vector<V>,
    /// The surface's own geometric normal: unit, on the side from which the vertices run
    /// counterclockwise, as for Embree's flat triangles. That is also the side of the vertex
    /// normals, unless the mesh contradicts itself.
    pub normal: Vector<V>,
}

impl<S: Constant> Patch<S> {
    /// The surface over the plane point with barycentric coordinates `(1 - u - v, u, v)`.
    ///
    /// Analytic: derivatives are carried through the very source that computes the height. On a
    /// median, where the guide field has a kink, they are those of one side.
    #[inline(always)]
    pub(crate) fn surface_point<V: Real<Scalar = S>>(&self, u: V, v: V) -> SurfacePoint<V> {
        let foot = self.foot_at::<V, V>([u.one() - u - v, u, v]);
        let h = self.height(&foot);
        let [to_second, to_third] = Vector::splat_both(u, self.spokes);
        let local = to_second * u + to_third * v + self.guide(&foot) * h;
        let [tangent_u, tangent_v] = self.tangents(u, v);
        let across = tangent_u.cross(tangent_v);
        let size = u.splat(self.size);
        SurfacePoint {
            position: local * size + Vector::splat(u, self.origin),
            tangent_u: tangent_u * size,
            tangent_v: tangent_v * size,
            normal: across.normalize(),
        }
    }

    /// The surface's own geometric normal at barycentric coordinates `(1 - u - v, u, v)`:
    /// [`SurfacePoint::normal`] without the rest.
    #[inline(always)]
    pub(crate) fn geometric_normal<V: Real<Scalar = S>>(&self, u: V, v: V) -> Vector<V> {
        if self.rule == Rule::Flat {
            return Vector::splat(u, self.normal * self.winding);
        }
        let [tangent_u, tangent_v] = self.tangents(u, v);
        tangent_u.cross(tangent_v).normalize()
    }

    /// The guide `g` over the plane point with barycentric coordinates `(1 - u - v, u, v)`: the way
    /// from the plane to the surface, of equation (1), scaled so that its part along
    /// [`Patch::plane_normal`] is 1.
    #[inline(always)]
    pub(crate) fn guide_vector<V: Real<Scalar = S>>(&self, u: V, v: V) -> Vector<V> {
        self.guide(&self.foot_at::<V, V>([u.one() - u - v, u, v]))
    }

    #[inline(always)]
    fn guide<V: Real<Scalar = S>>(&self, foot: &Foot<V, V>) -> Vector<V> {
        Vector::splat(foot.lean, self.normal) + self.inward(foot) * foot.lean
    }

    /// Derivatives of the position by u and v, in units of the patch's size.
    #[inline(always)]
    fn tangents<V: Real<Scalar = S>>(&self, u: V, v: V) -> [Vector<V>; 2] {
        let (foot, h) = self.raised(off_vertex(u, v));
        let out = foot.lean * h;
        let (normal, inward) = (Vector::splat(u, self.normal), self.inward(&foot));
        let spokes = Vector::splat_both(u, self.spokes);
        let tangent = inlined(
            #[inline(always)]
            |n: usize| inward.mul_add(out.parts[n], normal.mul_add(h.parts[n], spokes[n])),
        );
        [tangent(0), tangent(1)]
    }

    /// The foot and the height over it, with their derivatives by u and v.
    #[inline(always)]
    fn raised<V: Real<Scalar = S>>(&self, [u, v]: [V; 2]) -> (Foot<V, Dual<V, 2>>, Dual<V, 2>) {
        let b2 = Dual::<V, 2>::variable(u, 0);
        let b3 = Dual::<V, 2>::variable(v, 1);
        let one = Dual {
            value: u.one(),
            parts: [u.zero(); 2],
        };
        let foot = self.foot_at::<V, _>([one - b2 - b3, b2, b3]);
        let h = self.height(&foot);
        (foot, h)
    }

    /// The inward perpendicular of the foot's edge.
    #[inline(always)]
    fn inward<V: Real<Scalar = S>, T>(&self, foot: &Foot<V, T>) -> Vector<V> {
        let of = inlined(
            #[inline(always)]
            |component: fn(Vector<S>) -> S| {
                foot.choice
                    .constant(|k| component(self.gradients[next(next(k))]) * self.edges[k].height)
            },
        );
        vector(of(|g| g.x), of(|g| g.y), of(|g| g.z))
    }
}

/// Moves a point that lies on a vertex off it by a trifle: at the vertex itself the direction to
/// the plane point, and with it the derivative, is undefined; its limit is the same from all sides.
#[inline(always)]
fn off_vertex<V: Real>(u: V, v: V) -> [V; 2] {
    let trifle = u.constant(OFF_VERTEX);
    let (third, one) = (u.constant(1.0 / 3.0), u.one());
    let greatest = u.greater(v).greater(one - u - v);
    let near = (one - trifle).less(greatest);
    let share = V::select(near, trifle, u.zero());
    [u + (third - u) * share, v + (third - v) * share]
}
