//! The clip of one ray at one curved triangle, with the three edges in SIMD lanes. Most single rays miss, and
//! this is all that is computed for them.

use fearless_simd::{f32x4, prelude::*, u8x16};

use super::clip::{Crossing, RayInterval};
use super::ray::{Ray, localized};
use crate::numbers::{Constant, Mask, Quad, Real, Vector, inlined, vector};
use crate::patch::{BoundsKind, Choice, HalfSpace, TriangleFrame, TriangleVertices};
use crate::store::PackedTriangle;

/// The bytes of the lanes 1, 2, 0 and 3: each edge's next in its place.
const NEXT: [u8; 16] = [4, 5, 6, 7, 8, 9, 10, 11, 0, 1, 2, 3, 12, 13, 14, 15];
/// The lane behind the edges'.
const LAST: usize = 3;

/// A curved triangle's frame and the planes around it.
pub(crate) struct EdgesInLanes<S: Simd> {
    pub frame: TriangleFrame<f32>,
    /// Through the edges; in the last lane the one below.
    planes: HalfSpace<Quad<S>>,
    /// The offset of the one above.
    above: f32,
}

impl PackedTriangle<'_> {
    /// The least and the greatest height, where the surface is curved and these bound it.
    #[inline(always)]
    pub(crate) fn single_slab(&self) -> Option<[f32; 2]> {
        let packed = self.packed();
        let bounded = packed.is_curved() && packed.flags().bounds() == BoundsKind::Tight;
        bounded.then_some(self.slab)
    }
}

impl<S: Simd> EdgesInLanes<S> {
    /// Of a triangle with such a [slab](PackedTriangle::single_slab).
    #[inline(always)]
    pub fn new(simd: S, vertices: &TriangleVertices, [least, most]: [f32; 2]) -> Self {
        let normals = in_lanes(simd, &vertices.normals);
        let positions = in_lanes(simd, &vertices.positions);
        let edge_vectors = next(simd, positions) - positions;
        let lanes = edge_vectors.x;
        let [a, b, c, _] = numbers(edge_vectors.max_abs());
        let extent = a.greater(b).greater(c);
        let size = extent.power_of_two();
        let edge_vectors = edge_vectors * lanes.splat(size.per_power_of_two());
        let lengths2 = edge_vectors.dot(edge_vectors);
        // Of each edge with the next one.
        let crosses = vectors(edge_vectors.cross(next(simd, edge_vectors)));
        let [a, b, c, _] = numbers(lengths2);
        let longest = Choice::longest([a, b, c]);
        let cross = longest.pick_vector([crosses[1], crosses[2], crosses[0]]);
        let frame = TriangleFrame {
            origin: vertices.positions[0],
            size,
            edge_vectors: vectors(edge_vectors),
            lengths2: [a, b, c],
            longest,
            cross,
            area2: cross.length(),
            winding: 1.0,
        };
        let frame = frame.oriented(&vertices.normals);
        let guides = normals + next(simd, normals);
        let up = frame.cross * frame.winding;
        let (winding, area2) = (lanes.splat(frame.winding), lanes.splat(frame.area2));
        let planes = HalfSpace::of_edge(
            edge_vectors,
            guides,
            Vector::splat(lanes, up),
            winding,
            lanes.two() * lengths2.sqrt(),
        );
        // Those of the first and the third edge go through the origin.
        let way = Vector::splat(lanes, frame.edge_vectors[0]);
        let lane = f32x4::from_slice(simd, &[0.0, 1.0, 2.0, 3.0]);
        let lane = Quad(lane);
        let second = lanes.half().less(lane) & lane.less(lanes.constant(1.5));
        let edges = lane.less(lanes.constant(2.5));
        let offset = Quad::select(second, planes.through(way).offset, planes.offset);
        let level = HalfSpace::level(
            Vector::splat(lanes, up),
            lanes.splat(-least * frame.area2),
            area2,
        );
        Self {
            planes: HalfSpace {
                normal: vector(
                    Quad::select(edges, planes.normal.x, level.normal.x),
                    Quad::select(edges, planes.normal.y, level.normal.y),
                    Quad::select(edges, planes.normal.z, level.normal.z),
                ),
                offset: Quad::select(edges, offset, level.offset),
                distance_tolerance: Quad::select(
                    edges,
                    planes.distance_tolerance,
                    level.distance_tolerance,
                ),
            },
            above: most * frame.area2,
            frame,
        }
    }

    /// The same as [`ClipVolume::clip`](crate::patch::ClipVolume::clip).
    #[inline(always)]
    pub fn clip(&self, ray: &Ray<f32>) -> RayInterval<f32> {
        let [from, along] = localized(ray, self.frame.origin, self.frame.size.per_power_of_two());
        let distance = from.max_abs();
        let planes = &self.planes;
        let lanes = planes.offset;
        let value = planes.value(Vector::splat(lanes, from), lanes.splat(distance));
        let rate = planes.normal.dot(Vector::splat(lanes, along));
        let four = Crossing::new(value, rate);
        let endless = lanes.constant(f64::INFINITY);
        let (entries, exits) = (numbers(four.entry(-endless)), numbers(four.exit(endless)));
        // The plane above has the normal of the one below, turned round.
        let tolerance = numbers(planes.distance_tolerance)[LAST];
        let value = tolerance.mul_add(distance, self.above) - self.up().dot(from);
        let above = Crossing::new(value, -numbers(rate)[LAST]);
        let (mut lo, mut hi) = (ray.search_start(), f32::INFINITY);
        for n in 0..4 {
            lo = entries[n].greater(lo);
            hi = exits[n].lesser(hi);
        }
        lo = above.entry(lo).greater(lo);
        hi = above.exit(hi).lesser(hi);
        RayInterval::between(lo, hi, four.passes.all() & above.passes, ray.tfar)
    }

    #[inline(always)]
    fn up(&self) -> Vector<f32> {
        self.frame.cross * self.frame.winding
    }
}

/// Three vectors, one a lane; the first once more in the last.
#[inline(always)]
fn in_lanes<S: Simd>(simd: S, [a, b, c]: &[Vector<f32>; 3]) -> Vector<Quad<S>> {
    let quad = inlined(
        #[inline(always)]
        |of: [f32; 4]| Quad(f32x4::from_slice(simd, &of)),
    );
    vector(
        quad([a.x, b.x, c.x, a.x]),
        quad([a.y, b.y, c.y, a.y]),
        quad([a.z, b.z, c.z, a.z]),
    )
}

/// What belongs to the next edge, in each edge's place.
#[inline(always)]
fn next<S: Simd>(simd: S, of: Vector<Quad<S>>) -> Vector<Quad<S>> {
    let turned = inlined(
        #[inline(always)]
        |of: Quad<S>| Quad(of.0.swizzle_dyn(u8x16::from_slice(simd, &NEXT))),
    );
    vector(turned(of.x), turned(of.y), turned(of.z))
}

#[inline(always)]
fn numbers<S: Simd>(of: Quad<S>) -> [f32; 4] {
    let mut numbers = [0.0; 4];
    of.0.store_slice(&mut numbers);
    numbers
}

/// The edges' vectors.
#[inline(always)]
fn vectors<S: Simd>(of: Vector<Quad<S>>) -> [Vector<f32>; 3] {
    let (x, y, z) = (numbers(of.x), numbers(of.y), numbers(of.z));
    three!(|k| vector(x[k], y[k], z[k]))
}
