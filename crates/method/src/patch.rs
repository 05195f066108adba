//! One curved triangle: everything about it that does not depend on the ray.
//!
//! All lengths inside a patch are in units of its `size`, a power of two, with the first vertex as
//! the origin. Scaling by a power of two is exact, so what belongs to a side comes out bit-equal
//! in both triangles that share it.

use super::bounds::{self, HeightNet};
use super::choice::Choice;
use super::correction;
use super::flags::{BoundsKind, PatchFlags, Surface};
use super::folds;
use super::frame::{Frame, SLIVER_AREA};
use super::hull::Hull;
use super::outline::Outline;
use super::paraboloid;
use super::real::{Constant, Mask, Real, Scalar, each, three};
use super::record::PatchRecord;
use super::sides::{Plane, Side, sides};
use super::sphere::Sphere;
use super::vector::{Vector, vector};

/// Below this cosine between a vertex normal and the triangle's plane normal the method does not
/// take the triangle.
const MIN_NORMAL_COSINE: f64 = 0.1;

/// Why a triangle stays flat.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FlatReason {
    /// It was told to.
    Asked,
    /// Its surface lies in its plane anyway, to within rounding.
    Plane,
    /// So thin that its plane is uncertain.
    Sliver,
    /// A vertex normal points away from the plane's normal, or nearly so.
    BackNormal,
    /// The normals bend so much that a sphere of a vertex could be missed by the guide.
    Bend,
    /// The guide field would fold over near a side.
    Fold,
}

/// What a triangle turned out to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PatchKind {
    /// Curved, by the surface asked for.
    Curved,
    /// Curved by the angular rule, because the curvature tensor is too wild here.
    Fallback,
    /// Flat, with straight sides.
    Flat(FlatReason),
    /// No area or not finite: there is no surface, and no ray hits it.
    Degenerate,
}

/// How the curvature at a point follows from the sides' curvatures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    Angular,
    Tensor,
    Flat,
}

impl Rule {
    pub fn of(surface: Surface) -> Self {
        match surface {
            Surface::Angular => Rule::Angular,
            Surface::Tensor | Surface::Smooth => Rule::Tensor,
        }
    }
}

/// What a patch knows of a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex<S> {
    /// Normal times the plane's normal.
    pub normal: S,
    /// Normal times each side's inward perpendicular.
    pub inward: [S; 3],
    /// Scalar product of the two sides out of the vertex; on its own, since on thin triangles it
    /// drowns in a difference of squared lengths.
    pub between: S,
    /// One over the angle at the vertex, radians.
    pub inverse_angle: S,
}

/// The frame of the longest side: because on a needle the gradients' rounding would shift points along it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Base<S: Constant> {
    /// Which side that is.
    pub side: Choice<S>,
    /// Its first vertex.
    pub corner: Vector<S>,
    /// Its edge over its squared length.
    pub along: Vector<S>,
    /// The gradient of the opposite vertex's coordinate.
    pub across: Vector<S>,
    /// Its [`Side::foot`].
    pub foot: S,
}

/// A curved triangle, ready for rays.
///
/// `S` is `f32` or `f64`; the `f64` patch of the same vertices is the oracle for the `f32` one.
#[derive(Clone, Copy, Debug)]
pub struct Patch<S: Constant> {
    /// What rays are clipped to.
    pub(super) hull: Hull<S>,
    pub(super) origin: Vector<S>,
    pub(super) size: S,
    /// First to second and first to third vertex.
    pub(super) spokes: [Vector<S>; 2],
    /// `nc`: the plane's unit normal, turned to agree with the vertex normals.
    pub(super) normal: Vector<S>,
    /// +1 where `nc` is the normal of the vertices' counterclockwise order, else -1.
    pub(super) winding: S,
    /// Gradients of the three barycentric coordinates.
    pub(super) gradients: [Vector<S>; 3],
    pub(super) sides: [Side<S>; 3],
    pub(super) vertices: [Vertex<S>; 3],
    /// The frame in which rays are set up.
    pub(super) base: Base<S>,
    /// Twice the area.
    pub(super) area2: S,
    /// Least and greatest height of the surface over its plane.
    pub(super) slab: [S; 2],
    pub(super) rule: Rule,
    pub(super) any_obtuse: bool,
    pub(super) any_loose: bool,
    pub(super) kind: PatchKind,
    /// How far the surface's slope is off a paraboloid's at the most, as it is [kept](paraboloid::kept).
    pub(super) unevenness: S,
}

/// The vertex, or the side, after this one.
pub(super) const fn next(k: usize) -> usize {
    (k + 1) % 3
}

impl<S: Scalar> Patch<S> {
    /// The curved triangle over three positions with unit normals.
    ///
    /// A pure function of its arguments: any two calls give the same patch. Positions may be in
    /// any units; the patch's own rays and points are in the same ones. What the method cannot
    /// take becomes flat or degenerate; see [`Patch::kind`].
    pub fn new(positions: [Vector<S>; 3], normals: [Vector<S>; 3], flags: PatchFlags) -> Self {
        Self::with_net(positions, normals, flags).0
    }

    /// What is kept of the patch, and its box.
    pub(super) fn prepared(
        positions: [Vector<S>; 3],
        normals: [Vector<S>; 3],
        flags: PatchFlags,
    ) -> (PatchRecord, [Vector<S>; 2]) {
        let (patch, net) = Self::with_net(positions, normals, flags);
        (patch.record(flags), patch.bounds_by(net.as_ref()))
    }

    /// The patch and what bounds its heights, unless it is flat.
    fn with_net(
        positions: [Vector<S>; 3],
        normals: [Vector<S>; 3],
        flags: PatchFlags,
    ) -> (Self, Option<HeightNet<S>>) {
        let Some(frame) = Frame::new(&positions, &normals) else {
            return (Self::empty(positions[0]), None);
        };
        let mut patch = Self::laid(&frame, &normals, flags);
        let mut sphere = None;
        let net = match patch.curve(&normals, flags) {
            Ok(net) => {
                if flags.bounds() == BoundsKind::Sphere {
                    sphere = Some(Sphere::around(&frame, &patch, &net));
                }
                patch.slab = net.slab();
                if !flags.is_unchecked() {
                    let kept = paraboloid::kept(patch.unevenness(&normals));
                    patch.unevenness = S::from_f64(paraboloid::unkept(kept).into());
                }
                Some(net)
            }
            Err(reason) => {
                patch.flatten(reason);
                None
            }
        };
        patch.hull = Hull::new(&frame, &normals, patch.curved_slab(), sphere);
        (patch, net)
    }

    /// The patch of these vertices, from what [`Patch::record`] kept of it.
    pub fn from_record(
        positions: [Vector<S>; 3],
        normals: [Vector<S>; 3],
        record: &PatchRecord,
    ) -> Self {
        Outline::new(positions, normals, record).complete()
    }

    /// What the triangle turned out to be.
    pub fn kind(&self) -> PatchKind {
        self.kind
    }

    /// The unit of length inside: a power of two, at most the longest side.
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

    /// The sphere that bounds the patch, if it was [asked](PatchFlags::with_bounds) for and the patch is
    /// not flat.
    pub fn sphere(&self) -> Option<&Sphere<S>> {
        self.hull.sphere.as_ref()
    }

    /// Why the triangle has to be flat whatever it would be curved to.
    fn flat_reason(&self, normals: &[Vector<S>; 3], flags: PatchFlags) -> Option<FlatReason> {
        if flags.is_plane() {
            Some(FlatReason::Plane)
        } else if flags.is_flat() {
            Some(FlatReason::Asked)
        } else if self.area2 < S::from_f64(SLIVER_AREA) {
            Some(FlatReason::Sliver)
        } else if !self.agrees(normals) {
            Some(FlatReason::BackNormal)
        } else {
            None
        }
    }

    /// Chooses the rule, adds the correction, and bounds the heights.
    fn curve(
        &mut self,
        normals: &[Vector<S>; 3],
        flags: PatchFlags,
    ) -> Result<HeightNet<S>, FlatReason> {
        if let Some(reason) = self.flat_reason(normals, flags) {
            return Err(reason);
        }
        if self.rule == Rule::Angular {
            self.set_angles();
        }
        let mut looked_at = self.look();
        if !flags.is_unchecked() {
            if self.rule == Rule::Tensor && !(looked_at.tame & looked_at.low) {
                self.rule = Rule::Angular;
                self.kind = PatchKind::Fallback;
                self.set_angles();
                looked_at = self.look();
            }
            if !(looked_at.reaches & looked_at.low) || folds::shears(self) {
                return Err(FlatReason::Bend);
            }
            if folds::folds(self) {
                return Err(FlatReason::Fold);
            }
        }
        if flags.surface() == Surface::Smooth {
            self.correct(flags);
        }
        Ok(looked_at.net.corrected(self))
    }

    /// As [`Patch::looked_at`]; asked for twice, but there once.
    #[inline(never)]
    fn look(&self) -> LookedAt<S> {
        self.looked_at()
    }

    /// The slab of heights, unless the patch is plane.
    pub(super) fn curved_slab(&self) -> Option<[S; 2]> {
        (self.rule != Rule::Flat).then_some(self.slab)
    }

    /// Makes the surface the plane triangle itself.
    pub(super) fn flatten(&mut self, reason: FlatReason) {
        let zero = S::from_f64(0.0);
        self.kind = PatchKind::Flat(reason);
        self.rule = Rule::Flat;
        self.any_obtuse = false;
        self.slab = [zero; 2];
        for side in &mut self.sides {
            side.lean = zero;
            side.tilt = zero;
            side.bend = [zero; 2];
            side.damping = zero;
            side.correction = [zero; 3];
        }
    }
}

impl<S: Constant> Base<S> {
    #[inline(always)]
    fn new(frame: &Frame<S>, plane: &Plane<S>, sides: &[Side<S>; 3]) -> Self {
        let (side, zero) = (frame.longest, frame.area2.constant(0.0));
        let ([a, b, c], [first, second, third]) = (frame.edges, plane.gradients);
        Self {
            side,
            corner: side.pick_vector([vector(zero, zero, zero), a, -c]),
            along: side.pick_vector([a, b, c]) * side.pick(plane.per_length2),
            across: side.pick_vector([third, first, second]),
            foot: side.pick([sides[0].foot, sides[1].foot, sides[2].foot]),
        }
    }
}

impl<S: Constant> Patch<S> {
    /// A patch without area.
    #[inline(always)]
    pub(super) fn empty(origin: Vector<S>) -> Self {
        let (zero, one) = (origin.x.constant(0.0), origin.x.constant(1.0));
        let none = vector(zero, zero, zero);
        let side = Side {
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
            hull: Hull::empty(origin),
            origin,
            size: one,
            spokes: [none; 2],
            normal: none,
            winding: one,
            gradients: [none; 3],
            sides: [side; 3],
            vertices: [vertex; 3],
            base: Base {
                side: Choice::only(zero, 0),
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
    pub(super) fn laid(frame: &Frame<S>, normals: &[Vector<S>; 3], flags: PatchFlags) -> Self {
        let zero = frame.area2.constant(0.0);
        let plane = Plane::new(frame);
        let sides = sides(frame, &plane, normals, flags);
        let vertices = three(
            #[inline(always)]
            |i| Vertex {
                normal: normals[i].dot(plane.normal),
                inward: three(
                    #[inline(always)]
                    |k| normals[i].dot(plane.inward[k]),
                ),
                between: -frame.edges[i].dot(frame.edges[next(next(i))]),
                inverse_angle: zero,
            },
        );
        let mut patch = Self {
            hull: Hull::empty(frame.origin),
            origin: frame.origin,
            size: frame.size,
            spokes: [frame.edges[0], -frame.edges[2]],
            normal: plane.normal,
            winding: frame.winding,
            gradients: plane.gradients,
            any_obtuse: (sides[0].obtuse | sides[1].obtuse | sides[2].obtuse).any(),
            any_loose: (0..3).any(|k| flags.is_straight(k)),
            sides,
            vertices,
            base: Base::new(frame, &plane, &sides),
            area2: frame.area2,
            slab: [zero; 2],
            rule: Rule::of(flags.surface()),
            kind: PatchKind::Curved,
            unevenness: zero.constant(f64::INFINITY),
        };
        each(
            #[inline(always)]
            |k| {
                // Over twice the normals' mean cosine, near enough for a guess.
                let upright = patch.vertices[k].normal + patch.vertices[next(k)].normal;
                let quarter = zero.constant(0.25);
                patch.sides[k].bulge =
                    patch.mean_bend(k) * (upright * quarter - zero.constant(1.0));
            },
        );
        patch
    }

    /// Sets the angles at the vertices, which only the angular rule asks for.
    #[inline(always)]
    pub(super) fn set_angles(&mut self) {
        for vertex in &mut self.vertices {
            let angle = Real::atan2(self.area2, vertex.between);
            vertex.inverse_angle = angle.constant(1.0) / angle;
        }
    }

    /// Whether all vertex normals are on the plane's side.
    #[inline(always)]
    pub(super) fn agrees(&self, normals: &[Vector<S>; 3]) -> S::Mask {
        let (zero, least) = (
            self.area2.constant(0.0),
            self.area2.constant(MIN_NORMAL_COSINE),
        );
        let mut agrees = zero.mask(true);
        each(
            #[inline(always)]
            |i| {
                // Zero times what is not finite is no number, which fails any comparison.
                let Vector { x, y, z } = normals[i] * zero;
                let finite = (x + y + z).at_most(zero);
                agrees = agrees & least.less(self.vertices[i].normal) & finite;
            },
        );
        agrees
    }

    /// What the bounds say of the surface by the present rule.
    #[inline(always)]
    pub(super) fn looked_at(&self) -> LookedAt<S> {
        let spread = bounds::spread(self);
        let net = HeightNet::new(self, &spread);
        LookedAt {
            tame: spread.is_tame(),
            reaches: spread.reaches(),
            low: net.is_low(self),
            net,
        }
    }

    /// Adds the correction.
    #[inline(always)]
    pub(super) fn correct(&mut self, flags: PatchFlags) {
        correction::fit(self, flags);
        self.round_correction();
    }
}

/// What bounds say of a surface.
pub(super) struct LookedAt<S: Constant> {
    /// Whether the curvature tensor may be used.
    pub tame: S::Mask,
    /// Whether every guide meets every sphere.
    pub reaches: S::Mask,
    /// Whether it stays near to the triangle.
    pub low: S::Mask,
    /// The heights, without the correction.
    pub net: HeightNet<S>,
}
