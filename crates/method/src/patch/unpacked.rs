//! A patch, ready for rays.

use super::choice::Choice;
use super::clip_volume::ClipVolume;
use super::cyclic::next;
use super::edge::{Edge, edges};
use super::flags::PatchFlags;
use super::kind::{FlatReason, PatchKind, Rule};
use super::plane::TrianglePlane;
use super::sphere::Sphere;
use super::triangle_frame::TriangleFrame;
use crate::numbers::{Constant, Cursor, Fields, Mask, Real, Scalar, Vector, vector};

/// What a patch knows of a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex<S> {
    /// Normal times the plane's normal.
    pub normal: S,
    /// Normal times each edge's inward perpendicular.
    pub inward: [S; 3],
    /// Scalar product of the two edges out of the vertex; on its own, since on thin triangles it
    /// drowns in a difference of squared lengths.
    pub between: S,
    /// One over the angle at the vertex, radians.
    pub inverse_angle: S,
}

/// The frame of the longest edge: because on a needle the gradients' rounding would shift points along it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BaseFrame<S: Constant> {
    /// Which edge that is.
    pub edge: Choice<S>,
    /// Its first vertex.
    pub corner: Vector<S>,
    /// Its edge over its squared length.
    pub along: Vector<S>,
    /// The gradient of the opposite vertex's coordinate.
    pub across: Vector<S>,
    /// Its [`Edge::foot`].
    pub foot: S,
}

/// A curved triangle, ready for rays.
///
/// `S` is `f32` or `f64`; the `f64` patch of the same vertices is the oracle for the `f32` one.
///
/// ```
/// use curvetri_method::{Patch, PatchFlags, PatchKind, Ray, Solver, vector};
///
/// // A face of the regular tetrahedron in the unit sphere; each vertex is its own normal.
/// let c = 1.0 / 3f64.sqrt();
/// let vertices = [vector(c, c, c), vector(c, -c, -c), vector(-c, c, -c)];
/// let patch = Patch::new(vertices, vertices, PatchFlags::default());
/// assert_eq!(patch.kind(), PatchKind::Curved);
///
/// // A ray from outside towards the centre meets the sphere, not the plane.
/// let ray = Ray {
///     origin: vector(c, c, -c) * 5.0,
///     direction: vector(-c, -c, c),
///     tnear: 0.0,
///     tfar: f64::INFINITY,
/// };
/// let hit = patch.intersect(&ray, Solver::default());
/// assert!(hit.found && (hit.t - 4.0).abs() < 1e-9);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Patch<S: Constant> {
    /// What rays are clipped to.
    pub(crate) clip_volume: ClipVolume<S>,
    pub(crate) origin: Vector<S>,
    pub(crate) size: S,
    /// First to second and first to third vertex.
    pub(crate) spokes: [Vector<S>; 2],
    /// `nc`: the plane's unit normal, turned to agree with the vertex normals.
    pub(crate) normal: Vector<S>,
    /// +1 where `nc` is the normal of the vertices' counterclockwise order, else -1.
    pub(crate) winding: S,
    /// Gradients of the three barycentric coordinates.
    pub(crate) gradients: [Vector<S>; 3],
    pub(crate) edges: [Edge<S>; 3],
    pub(crate) vertices: [Vertex<S>; 3],
    /// The frame in which rays are set up.
    pub(crate) base: BaseFrame<S>,
    /// Twice the area.
    pub(crate) area2: S,
    /// Least and greatest height of the surface over its plane.
    pub(crate) slab: [S; 2],
    pub(crate) rule: Rule,
    pub(crate) any_obtuse: bool,
    pub(crate) any_loose: bool,
    pub(crate) kind: PatchKind,
    /// How far the surface's slope is off a paraboloid's at the most, rounded as it is packed.
    pub(crate) unevenness: S,
}

impl<S: Constant> BaseFrame<S> {
    #[inline(always)]
    fn new(frame: &TriangleFrame<S>, plane: &TrianglePlane<S>, edges: &[Edge<S>; 3]) -> Self {
        let (edge, zero) = (frame.longest, frame.area2.zero());
        let ([a, b, c], [first, second, third]) = (frame.edge_vectors, plane.gradients);
        Self {
            edge,
            corner: edge.pick_vector([vector(zero, zero, zero), a, -c]),
            along: edge.pick_vector([a, b, c]) * edge.pick(plane.per_length2),
            across: edge.pick_vector([third, first, second]),
            foot: edge.pick([edges[0].foot, edges[1].foot, edges[2].foot]),
        }
    }
}

impl<S: Scalar> Patch<S> {
    /// What the triangle turned out to be.
    pub fn kind(&self) -> PatchKind {
        self.kind
    }

    /// The unit of length inside: a power of two, at most the longest edge.
    pub fn size(&self) -> S {
        self.size
    }

    /// The plane's unit normal, turned to agree with the vertex normals.
    pub fn plane_normal(&self) -> Vector<S> {
        self.normal
    }

    /// Least and greatest height of the surface over the triangle's plane, in the units of the
    /// positions. Conservative.
    pub fn heights(&self) -> [S; 2] {
        self.slab.map(|z| z * self.size)
    }

    /// The sphere that bounds the patch, if it was [requested](PatchFlags::with_bounds) and the patch is
    /// not flat.
    pub fn sphere(&self) -> Option<&Sphere<S>> {
        self.clip_volume.sphere.as_ref()
    }

    /// The slab of heights, unless the patch is plane.
    pub(crate) fn curved_slab(&self) -> Option<[S; 2]> {
        (self.rule != Rule::Flat).then_some(self.slab)
    }

    /// Makes the surface the plane triangle itself.
    pub(crate) fn flatten(&mut self, reason: FlatReason) {
        let zero = S::from_f64(0.0);
        self.kind = PatchKind::Flat(reason);
        self.rule = Rule::Flat;
        self.any_obtuse = false;
        self.slab = [zero; 2];
        for edge in &mut self.edges {
            edge.lean = zero;
            edge.tilt = zero;
            edge.bend = [zero; 2];
            edge.damping = zero;
            edge.correction = [zero; 3];
        }
    }
}

impl<S: Constant> Patch<S> {
    /// A patch without area.
    #[inline(always)]
    pub(crate) fn empty(origin: Vector<S>) -> Self {
        let (zero, one) = (origin.x.zero(), origin.x.one());
        let none = vector(zero, zero, zero);
        let edge = Edge {
            length2: zero,
            height: zero,
            per_height: zero,
            foot: zero,
            lean: zero,
            tilt: zero,
            rise: [zero; 2],
            obtuse: zero.mask(false),
            bend: [zero; 2],
            bulge: zero,
            damping: zero,
            correction: [zero; 3],
            loose: [false; 2],
        };
        let vertex = Vertex {
            normal: zero,
            inward: [zero; 3],
            between: zero,
            inverse_angle: zero,
        };
        Self {
            clip_volume: ClipVolume::empty(origin),
            origin,
            size: one,
            spokes: [none; 2],
            normal: none,
            winding: one,
            gradients: [none; 3],
            edges: [edge; 3],
            vertices: [vertex; 3],
            base: BaseFrame {
                edge: Choice::only(zero, 0),
                corner: none,
                along: none,
                across: none,
                foot: zero,
            },
            area2: zero,
            slab: [zero; 2],
            rule: Rule::Flat,
            any_obtuse: false,
            any_loose: false,
            kind: PatchKind::Degenerate,
            unevenness: zero.constant(f64::INFINITY),
        }
    }

    /// The patch of a triangle, without the correction, the slab and the unevenness.
    #[inline(always)]
    pub(crate) fn from_frame(
        frame: &TriangleFrame<S>,
        normals: &[Vector<S>; 3],
        flags: PatchFlags,
    ) -> Self {
        let zero = frame.area2.zero();
        let plane = TrianglePlane::new(frame);
        let edges = edges(frame, &plane, normals, flags);
        let vertices = three!(|i| Vertex {
            normal: normals[i].dot(plane.normal),
            inward: three!(|k| normals[i].dot(plane.inward[k])),
            between: -frame.edge_vectors[i].dot(frame.edge_vectors[next(next(i))]),
            inverse_angle: zero,
        });
        let mut patch = Self {
            clip_volume: ClipVolume::empty(frame.origin),
            origin: frame.origin,
            size: frame.size,
            spokes: [frame.edge_vectors[0], -frame.edge_vectors[2]],
            normal: plane.normal,
            winding: frame.winding,
            gradients: plane.gradients,
            any_obtuse: (edges[0].obtuse | edges[1].obtuse | edges[2].obtuse).any(),
            any_loose: (0..3).any(|k| flags.is_straight(k)),
            edges,
            vertices,
            base: BaseFrame::new(frame, &plane, &edges),
            area2: frame.area2,
            slab: [zero; 2],
            rule: Rule::of(flags.surface()),
            kind: PatchKind::Curved,
            unevenness: zero.constant(f64::INFINITY),
        };
        each!(|k| {
            // Over twice the normals' mean cosine, near enough for a guess.
            let upright = patch.vertices[k].normal + patch.vertices[next(k)].normal;
            let quarter = zero.constant(0.25);
            patch.edges[k].bulge = patch.mean_bend(k) * (upright * quarter - zero.one());
        });
        patch
    }

    /// Sets the angles at the vertices, which only the angular rule needs.
    #[inline(always)]
    pub(crate) fn set_angles(&mut self) {
        for vertex in &mut self.vertices {
            let angle = Real::atan2(self.area2, vertex.between);
            vertex.inverse_angle = angle.one() / angle;
        }
    }

    /// The bend of an edge as the vertex opposite to it sees it: its two ends' mean.
    #[inline(always)]
    pub(crate) fn mean_bend(&self, edge: usize) -> S {
        let [first, second] = self.edges[edge].bend;
        (first + second) * first.half()
    }
}

impl<S: Constant> Fields<S> for Vertex<S> {
    const COUNT: usize = 5;

    #[inline(always)]
    fn visit(&mut self, cursor: &mut impl Cursor<S>) {
        cursor.number(&mut self.normal);
        cursor.number(&mut self.inward[0]);
        cursor.number(&mut self.inward[1]);
        cursor.number(&mut self.inward[2]);
        cursor.number(&mut self.between);
    }
}

impl<S: Constant> Fields<S> for BaseFrame<S> {
    const COUNT: usize = Choice::<S>::COUNT + 3 * 3 + 1;

    #[inline(always)]
    fn visit(&mut self, cursor: &mut impl Cursor<S>) {
        self.edge.visit(cursor);
        cursor.vector(&mut self.corner);
        cursor.vector(&mut self.along);
        cursor.vector(&mut self.across);
        cursor.number(&mut self.foot);
    }
}

/// All numbers that rays need of a curved patch by the tensor's rule, without loose ends.
impl<S: Constant> Fields<S> for Patch<S> {
    const COUNT: usize = 3
        + 1
        + 2 * 3
        + 3
        + 3 * (3 + Edge::<S>::COUNT + Vertex::<S>::COUNT)
        + BaseFrame::<S>::COUNT
        + 2
        + 1;

    #[inline(always)]
    fn visit(&mut self, cursor: &mut impl Cursor<S>) {
        cursor.vector(&mut self.origin);
        cursor.number(&mut self.size);
        cursor.vector(&mut self.spokes[0]);
        cursor.vector(&mut self.spokes[1]);
        cursor.vector(&mut self.normal);
        self.visit_part(0, cursor);
        self.visit_part(1, cursor);
        self.visit_part(2, cursor);
        self.base.visit(cursor);
        cursor.number(&mut self.slab[0]);
        cursor.number(&mut self.slab[1]);
        cursor.number(&mut self.unevenness);
    }
}

impl<S: Constant> Patch<S> {
    /// The numbers of a vertex, its gradient and the edge from there.
    #[inline(always)]
    fn visit_part(&mut self, k: usize, cursor: &mut impl Cursor<S>) {
        cursor.vector(&mut self.gradients[k]);
        self.edges[k].visit(cursor);
        self.vertices[k].visit(cursor);
    }
}
