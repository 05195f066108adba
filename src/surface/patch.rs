//! One curved triangle: everything about it that does not depend on the ray.
//!
//! All lengths inside a patch are in units of its `size`, a power of two, with the first vertex as
//! the origin. Scaling by a power of two is exact, so what belongs to a side comes out bit-equal
//! in both triangles that share it.

use super::bounds::{self, HeightNet};
use super::correction;
use super::flags::{BoundsKind, PatchFlags, Surface};
use super::outline::Outline;
use super::real::{Real, Scalar, three};
use super::record::PatchRecord;
use super::sphere::Sphere;
use super::vector::{Vector, vector};

/// Below this cosine between a vertex normal and the triangle's plane normal the method does not
/// take the triangle.
const MIN_NORMAL_COSINE: f64 = 0.1;
/// Twice the area over the squared size, below which there is no plane to speak of ...
const DEGENERATE_AREA: f64 = 1e-12;
/// ... and below which its normal is too uncertain in `f32` to build a curved surface on.
const SLIVER_AREA: f64 = 1e-4;
/// The centroid's foot on a side must lie this far inside it, as a share of the side's length, for
/// the paper's planes to bound a sub-triangle; else the side takes the ramp of obtuse triangles.
const MIN_CENTROID_FOOT: f64 = 0.1;

/// Why a triangle stays flat.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FlatReason {
    /// It was told to.
    Asked,
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

/// What a patch knows of a side, in the side's frame: x along the side from its first vertex, y
/// along the inward in-plane perpendicular.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side<S> {
    /// Squared length.
    pub length2: S,
    /// Height of the opposite vertex over the side.
    pub height: S,
    /// Foot of the opposite vertex, as a share of the side's length.
    pub foot: S,
    /// The guide on the side is `nc + lean w`: the paper's side plane (5).
    pub lean: S,
    /// `lean / height`.
    pub tilt: S,
    /// One over three times the centroid's foot as a share of the length, from either end.
    pub rise: [S; 2],
    /// Whether the ramp of obtuse triangles takes the place of the paper's planes.
    pub obtuse: bool,
    /// `2 n.(other - own)` at the side's two ends: reference curvature times squared length.
    pub bend: [S; 2],
    /// Four times the damping of this side.
    pub damping: S,
    /// Coefficients of the correction's slope, a quadratic along the side.
    pub correction: [S; 3],
    /// Whether the other side at either end is straight, though the vertex's normal leans along
    /// it: there the surface cannot keep the vertex's tangent plane, and the slope does not vanish.
    pub loose: [bool; 2],
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

/// A curved triangle, ready for rays.
///
/// `S` is `f32` or `f64`; the `f64` patch of the same vertices is the oracle for the `f32` one.
#[derive(Clone, Copy, Debug)]
pub struct Patch<S> {
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
    /// The longest side: the frame in which rays are set up, because on a needle the gradients'
    /// rounding would shift points along it.
    pub(super) base: usize,
    /// The longest side's edge over its squared length.
    pub(super) along_base: Vector<S>,
    /// Twice the area.
    pub(super) area2: S,
    /// Least and greatest height of the surface over its plane.
    pub(super) slab: [S; 2],
    /// What rays are clipped to in the slab's place, and what the box is of, where it was asked for.
    pub(super) sphere: Option<Sphere<S>>,
    pub(super) rule: Rule,
    pub(super) any_obtuse: bool,
    pub(super) any_loose: bool,
    pub(super) kind: PatchKind,
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
        let mut patch = Self::framed(positions, normals, flags);
        if let PatchKind::Flat(reason) = patch.kind {
            patch.flatten(reason);
        }
        if patch.rule == Rule::Flat {
            return patch;
        }
        let net = match patch.curve(flags) {
            Ok(net) => net,
            Err(reason) => {
                patch.flatten(reason);
                return patch;
            }
        };
        patch.slab = net.slab();
        if flags.bounds() == BoundsKind::Sphere {
            patch.sphere = Some(Sphere::around(&patch, &net));
        }
        patch
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
        self.sphere.as_ref()
    }

    /// Everything that follows from the vertices without looking at the surface.
    fn framed(positions: [Vector<S>; 3], normals: [Vector<S>; 3], flags: PatchFlags) -> Self {
        let mut patch = Self::empty(positions[0]);
        let Some(edges) = patch.lay_out(positions, normals) else {
            return patch;
        };
        patch.kind = patch.classify(normals, flags);
        patch.rule = Rule::of(flags.surface());
        patch.lay_surface(edges, normals, flags);
        patch.set_angles();
        patch
    }

    /// Sets the plane and the side planes, all that a ray is clipped to but for the slab; gives the
    /// edges, or nothing where there is no area.
    #[inline(always)]
    pub(super) fn lay_out(
        &mut self,
        positions: [Vector<S>; 3],
        normals: [Vector<S>; 3],
    ) -> Option<[Vector<S>; 3]> {
        let spokes = [positions[1] - positions[0], positions[2] - positions[0]];
        let opposite = positions[2] - positions[1];
        let extent = spokes[0]
            .max_abs()
            .greater(spokes[1].max_abs())
            .greater(opposite.max_abs());
        let tiny = S::from_f64(1e-30);
        if !(tiny.less(extent) && extent < S::HUGE && positions[0].is_finite()) {
            return None;
        }
        self.size = extent.power_of_two();
        let unit = S::from_f64(1.0) / self.size;
        self.spokes = [spokes[0] * unit, spokes[1] * unit];
        // Every side by direct subtraction of its ends, never as a sum of other sides.
        let edges = [
            self.spokes[0],
            opposite * unit,
            (positions[0] - positions[2]) * unit,
        ];
        if !self.lay_plane(positions, edges, normals) {
            return None;
        }
        for k in 0..3 {
            self.lay_side(k, edges[k], normals);
        }
        Some(edges)
    }

    /// Sets what the surface itself follows from.
    #[inline(always)]
    pub(super) fn lay_surface(
        &mut self,
        edges: [Vector<S>; 3],
        normals: [Vector<S>; 3],
        flags: PatchFlags,
    ) {
        for k in 0..3 {
            self.bend_side(k, edges[k], normals, flags);
        }
        for i in 0..3 {
            self.vertices[i] = self.vertex(i, edges, normals[i]);
        }
        self.any_obtuse = self.sides.iter().any(|side| side.obtuse);
        self.any_loose = self.sides.iter().any(|side| side.loose.contains(&true));
    }

    /// Sets the angles at the vertices, which only the angular rule asks for.
    pub(super) fn set_angles(&mut self) {
        for vertex in &mut self.vertices {
            let angle = Real::atan2(self.area2, vertex.between);
            vertex.inverse_angle = S::from_f64(1.0) / angle;
        }
    }

    /// A patch without area.
    pub(super) fn empty(origin: Vector<S>) -> Self {
        let zero = S::from_f64(0.0);
        let none = vector(zero, zero, zero);
        let side = Side {
            length2: zero,
            height: zero,
            foot: zero,
            lean: zero,
            tilt: zero,
            rise: [zero; 2],
            obtuse: false,
            bend: [zero; 2],
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
            origin,
            size: S::from_f64(1.0),
            spokes: [none; 2],
            normal: none,
            winding: S::from_f64(1.0),
            gradients: [none; 3],
            sides: [side; 3],
            vertices: [vertex; 3],
            base: 0,
            along_base: none,
            area2: zero,
            slab: [zero; 2],
            sphere: None,
            rule: Rule::Flat,
            any_obtuse: false,
            any_loose: false,
            kind: PatchKind::Degenerate,
        }
    }

    /// Sets the plane's normal, area and gradients; false where there is no area.
    #[inline(always)]
    fn lay_plane(
        &mut self,
        positions: [Vector<S>; 3],
        edges: [Vector<S>; 3],
        normals: [Vector<S>; 3],
    ) -> bool {
        // The two shortest sides give the most certain vector product.
        let lengths = three(|k| edges[k].dot(edges[k]));
        let longest = (0..3).fold(
            0,
            |best, k| if lengths[best] < lengths[k] { k } else { best },
        );
        self.base = longest;
        self.along_base = edges[longest] * (S::from_f64(1.0) / lengths[longest]);
        let cross = edges[next(longest)].cross(edges[next(next(longest))]);
        self.area2 = cross.length();
        let mut geometric = cross * (S::from_f64(1.0) / self.area2);
        if !(S::from_f64(SLIVER_AREA) < self.area2) {
            match self.thin_plane(positions) {
                Some(precise) => geometric = precise,
                None => return false,
            }
        }
        let agreement = geometric.dot(normals[0] + normals[1] + normals[2]);
        self.winding = S::from_f64(if agreement < S::from_f64(0.0) {
            -1.0
        } else {
            1.0
        });
        self.normal = geometric * self.winding;
        for k in 0..3 {
            let inward = geometric.cross(edges[k]);
            self.gradients[next(next(k))] = inward * (S::from_f64(1.0) / self.area2);
        }
        true
    }

    /// Sets the area and gives the normal of a thin triangle, whose vector product would drown in
    /// rounding. Its plane has to be right all the same: rays may meet it at a grazing angle.
    #[inline(never)]
    fn thin_plane(&mut self, positions: [Vector<S>; 3]) -> Option<Vector<S>> {
        let unit = 1.0 / self.size.to_f64();
        let [a, b, c] = positions.map(Vector::to_f64);
        let cross = ((b - a) * unit).cross((c - a) * unit);
        let area2 = cross.length();
        self.area2 = S::from_f64(area2);
        (DEGENERATE_AREA < area2).then(|| Vector::from_f64(cross * (1.0 / area2)))
    }

    /// Whether the method may try this triangle.
    fn classify(&self, normals: [Vector<S>; 3], flags: PatchFlags) -> PatchKind {
        let least = S::from_f64(MIN_NORMAL_COSINE);
        if flags.is_flat() {
            PatchKind::Flat(FlatReason::Asked)
        } else if self.area2 < S::from_f64(SLIVER_AREA) {
            PatchKind::Flat(FlatReason::Sliver)
        } else if normals
            .iter()
            .any(|n| !(least < n.dot(self.normal)) || !n.is_finite())
        {
            // A NaN fails the comparison and ends here as well.
            PatchKind::Flat(FlatReason::BackNormal)
        } else {
            PatchKind::Curved
        }
    }

    /// Sets a side's frame and its plane.
    #[inline(always)]
    fn lay_side(&mut self, k: usize, edge: Vector<S>, normals: [Vector<S>; 3]) {
        let length2 = edge.dot(edge);
        let length = length2.sqrt();
        let height = self.area2 / length;
        let inward = self.gradients[next(next(k))] * height;
        let sum = normals[k] + normals[next(k)];
        let lean = sum.dot(inward) / sum.dot(self.normal);
        // Where the opposite vertex stands over the side: from the spoke out of the first vertex.
        let to_opposite = match k {
            0 => self.spokes[1],
            1 => -self.spokes[0],
            _ => self.spokes[0] - self.spokes[1],
        };
        let side = &mut self.sides[k];
        side.length2 = length2;
        side.height = height;
        side.foot = to_opposite.dot(edge) / length2;
        side.lean = lean;
        side.tilt = lean / height;
    }

    /// Sets how the guides turn and how the surface bends along a side.
    #[inline(always)]
    fn bend_side(&mut self, k: usize, edge: Vector<S>, normals: [Vector<S>; 3], flags: PatchFlags) {
        let (zero, one) = (S::from_f64(0.0), S::from_f64(1.0));
        let (first, second) = (normals[k], normals[next(k)]);
        let (length, foot) = (self.sides[k].length2.sqrt(), self.sides[k].foot);
        let sum = first + second;
        let centroid = (one + foot) * S::from_f64(1.0 / 3.0);
        let margin = S::from_f64(MIN_CENTROID_FOOT);
        let obtuse = !(margin < centroid && centroid < one - margin);
        let third = S::from_f64(1.0 / 3.0);
        let rise = if obtuse {
            [one; 2]
        } else {
            [third / centroid, third / (one - centroid)]
        };
        let straight = flags.is_straight(k);
        let two = S::from_f64(2.0);
        let bend = [first.dot(edge) * two, -(second.dot(edge) * two)];
        let damped = flags.surface() == Surface::Smooth && !straight;
        let damping = (sum.dot(edge).abs() / length).lesser(S::from_f64(0.9));
        let side = &mut self.sides[k];
        side.rise = rise;
        side.obtuse = obtuse;
        side.bend = if straight { [zero; 2] } else { bend };
        side.damping = if damped {
            damping * S::from_f64(4.0)
        } else {
            zero
        };
        side.loose = [next(next(k)), next(k)].map(|other| !straight && flags.is_straight(other));
    }

    #[inline(always)]
    fn vertex(&self, i: usize, edges: [Vector<S>; 3], normal: Vector<S>) -> Vertex<S> {
        let inward = three(|k| normal.dot(self.gradients[next(next(k))]) * self.sides[k].height);
        let between = -edges[i].dot(edges[next(next(i))]);
        Vertex {
            normal: normal.dot(self.normal),
            inward,
            between,
            inverse_angle: S::from_f64(0.0),
        }
    }

    /// Chooses the rule, adds the correction, and bounds the heights.
    fn curve(&mut self, flags: PatchFlags) -> Result<HeightNet<S>, FlatReason> {
        if self.rule == Rule::Tensor && !flags.is_unchecked() {
            let spread = bounds::spread(self);
            if !(spread.is_tame() && HeightNet::new(self, &spread).is_low(self)) {
                self.rule = Rule::Angular;
                self.kind = PatchKind::Fallback;
            }
        }
        let spread = bounds::spread(self);
        if !flags.is_unchecked() {
            if !(spread.reaches() && HeightNet::new(self, &spread).is_low(self))
                || bounds::shears(self)
            {
                return Err(FlatReason::Bend);
            }
            if bounds::folds(self) {
                return Err(FlatReason::Fold);
            }
        }
        if flags.surface() == Surface::Smooth {
            correction::fit(self, flags);
            self.round_correction();
        }
        Ok(HeightNet::new(self, &spread))
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
