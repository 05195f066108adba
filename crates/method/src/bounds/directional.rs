//! How far curved triangles reach along any direction, from their vertices and least and greatest heights.

use crate::numbers::{Constant, Vector, inlined, vector};
use crate::patch::TriangleFrame;

/// Below this cosine between a vertex normal and the plane's, guides may lean more than can be said ...
const MIN_COSINE: f64 = 0.05;
/// ... which is this much.
const ANY_LEAN: f64 = 1e6;

/// A triangle in its plane and what its surface may stand out from there, for its box along any direction.
#[derive(Clone, Copy, Debug)]
pub struct DirectionalBounds<V> {
    corners: [Vector<V>; 3],
    normal: Vector<V>,
    heights: [V; 2],
    /// How far a guide leans beside the normal at the most, for a unit of height.
    lean: V,
}

impl<V: Constant> DirectionalBounds<V> {
    /// Of a triangle over three positions with unit normals, with a surface within these least and greatest
    /// heights in units of the [size](crate::Patch::size). Of a plane triangle both are zero.
    #[inline(always)]
    pub fn new(positions: [Vector<V>; 3], normals: &[Vector<V>; 3], slab: [V; 2]) -> Self {
        let frame = TriangleFrame::of_sound(&positions, normals);
        let (zero, one) = (frame.area2.zero(), frame.area2.one());
        let has_plane = zero.less(frame.area2);
        let per_area = frame.winding / V::select(has_plane, frame.area2, one);
        let plane = frame.cross * per_area;
        let either = inlined(
            #[inline(always)]
            |a: V, b: V| V::select(has_plane, a, b),
        );
        let beside = normals[0];
        let normal = vector(
            either(plane.x, beside.x),
            either(plane.y, beside.y),
            either(plane.z, beside.z),
        );
        let [a, b, c] = three!(|i| normals[i].dot(normal));
        // A guide stands on a sum of normals, which leans no more than they do.
        let least = a.lesser(b).lesser(c);
        let known = one.constant(MIN_COSINE).less(least);
        let sine = (one - least * least).greater(zero).sqrt();
        let lean = V::select(known, sine, one.constant(ANY_LEAN)) / V::select(known, least, one);
        Self {
            corners: positions,
            normal,
            heights: [slab[0] * frame.size, slab[1] * frame.size],
            lean,
        }
    }

    /// The plane's unit normal, turned to agree with the vertex normals.
    #[inline(always)]
    pub fn normal(&self) -> Vector<V> {
        self.normal
    }

    /// The ways from vertex to vertex.
    #[inline(always)]
    pub fn edges(&self) -> [Vector<V>; 3] {
        let [a, b, c] = self.corners;
        [b - a, c - b, a - c]
    }

    /// Whether the triangle's lower end along a direction is more of an edge than of a corner: there are two
    /// vertices nearby.
    #[inline(always)]
    pub fn has_edge_below(&self, direction: Vector<V>) -> V::Mask {
        let [a, b, c] = three!(|i| direction.dot(self.corners[i] - self.corners[0]));
        let ends = a.lesser(b).lesser(c) + a.greater(b).greater(c);
        // The vertex between them is below their middle.
        (a + b + c).less(ends * ends.constant(1.5))
    }

    /// The least and the greatest value that the scalar product with a direction takes over the surface, seen
    /// from a point; but for rounding.
    #[inline(always)]
    pub fn along(&self, direction: Vector<V>, from: Vector<V>) -> [V; 2] {
        let [a, b, c] = three!(|i| direction.dot(self.corners[i] - from));
        let zero = a.zero();
        let upright = direction.dot(self.normal);
        let sideways = (direction.dot(direction) - upright * upright).greater(zero);
        let beside = sideways.sqrt() * self.lean;
        let [least, most] = self.heights;
        let (near, far) = (upright - beside, upright + beside);
        let [p, q, r, s] = [least * near, least * far, most * near, most * far];
        // Heights are zero at the corners.
        [
            a.lesser(b).lesser(c) + zero.lesser(p).lesser(q).lesser(r).lesser(s),
            a.greater(b).greater(c) + zero.greater(p).greater(q).greater(r).greater(s),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::BuiltPatch;
    use crate::patch::{PatchFlags, PatchKind, Surface, TriangleVertices};
    use crate::store::PackedTriangle;
    use crate::tests::{Random, rounded};

    #[test]
    fn no_point_of_a_surface_is_out_of_reach() {
        let mut random = Random(41);
        let (mut points, mut widest) = (0, 0f32);
        for n in 0..2000 {
            let (positions, normals) = random.triangle([2.0, 10.0, 25.0, 50.0][n % 4], 0.6);
            let corners = TriangleVertices {
                positions: rounded(positions),
                normals: rounded(normals),
            };
            let packed = BuiltPatch::new(&corners, PatchFlags::new(Surface::ALL[n % 3])).packed;
            let triangle = PackedTriangle::new(corners, &packed);
            if packed.kind() == PatchKind::Degenerate {
                continue;
            }
            let slab = packed.slab().unwrap_or([0.0; 2]);
            let reach = DirectionalBounds::new(corners.positions, &corners.normals, slab);
            let (patch, from) = (triangle.unpack(), corners.positions[n % 3]);
            let direction = Vector::from_f64(random.direction());
            let [lower, upper] = reach.along(direction, from);
            let tolerance = 1e-5 * patch.size();
            for _ in 0..20 {
                let [u, v] = random.inside();
                let at = patch.point(u as f32, v as f32).position;
                let value = direction.dot(at - from);
                assert!(
                    lower - tolerance < value && value < upper + tolerance,
                    "{corners:?}"
                );
                points += 1;
            }
            if n % 4 == 0 {
                let flat = corners.positions.map(|corner| direction.dot(corner - from));
                let least = flat.into_iter().fold(f32::INFINITY, f32::min);
                let most = flat.into_iter().fold(f32::NEG_INFINITY, f32::max);
                widest = widest.max(((upper - lower) - (most - least)) / patch.size());
            }
        }
        println!("{points} points, of surfaces that bend little {widest} beyond the triangle");
        assert!(points > 20_000 && widest < 0.1, "{points} {widest}");
    }
}
