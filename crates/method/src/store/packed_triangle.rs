//! A triangle as a mesh holds it: its vertices and the packed patch over them.

use fearless_simd::{f32x8, prelude::*};

use super::columns::{Columns, in_columns, load_lanes};
use super::packed_patch::PackedPatch;
use crate::bounds::DirectionalBounds;
use crate::numbers::{Cursor, Fields, Patches, Real, to_array};
use crate::patch::TriangleVertices;

/// A curved triangle's vertices and its packed patch.
///
/// ```
/// use curvetri_method::{
///     BuiltPatch, PackedTriangle, PatchFlags, Ray, Solver, TriangleVertices, vector,
/// };
///
/// let c = 1.0 / 3f32.sqrt();
/// let positions = [vector(c, c, c), vector(c, -c, -c), vector(-c, c, -c)];
/// let vertices = TriangleVertices { positions, normals: positions };
/// let built = BuiltPatch::new(&vertices, PatchFlags::default());
/// let triangle = PackedTriangle::new(vertices, &built.packed);
/// let ray = Ray {
///     origin: vector(c, c, -c) * 5.0,
///     direction: vector(-c, -c, c),
///     tnear: 0.0,
///     tfar: f32::INFINITY,
/// };
/// let (hit, normal) = triangle.intersect(&ray, Solver::default(), true);
/// assert!(hit.found && (hit.t - 4.0).abs() < 1e-5);
/// assert!(normal.dot(ray.direction) < -0.999);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct PackedTriangle<'a> {
    pub(crate) vertices: TriangleVertices,
    /// The record's, so that the record is read when the vertices are.
    pub(crate) slab: [f32; 2],
    packed: &'a PackedPatch,
}

impl<'a> PackedTriangle<'a> {
    /// The patch over these vertices whose [packed form](crate::Patch::pack) this is.
    #[inline(always)]
    pub fn new(vertices: TriangleVertices, packed: &'a PackedPatch) -> Self {
        Self {
            vertices,
            slab: packed.slab,
            packed,
        }
    }

    pub(crate) fn vertices(&self) -> &TriangleVertices {
        &self.vertices
    }

    pub(crate) fn packed(&self) -> &'a PackedPatch {
        self.packed
    }
}

/// Triangles with the least and the greatest height of their surfaces.
#[derive(Clone, Copy)]
pub(crate) struct VerticesAndSlab<V> {
    pub vertices: TriangleVertices<V>,
    pub slab: [V; 2],
}

impl<V: Real> VerticesAndSlab<V> {
    #[inline(always)]
    pub fn blank(zero: V) -> Self {
        Self {
            vertices: TriangleVertices::blank(zero),
            slab: [zero; 2],
        }
    }
}

impl<V: Real> Fields<V> for VerticesAndSlab<V> {
    const COUNT: usize = TriangleVertices::<V>::COUNT + 2;

    #[inline(always)]
    fn visit(&mut self, cursor: &mut impl Cursor<V>) {
        self.vertices.visit(cursor);
        cursor.number(&mut self.slab[0]);
        cursor.number(&mut self.slab[1]);
    }
}

impl<S: Simd> DirectionalBounds<Patches<S>> {
    /// Of eight triangles, none without area, one a lane.
    #[inline(always)]
    pub fn of_patches<'a>(simd: S, of: impl Fn(usize) -> PackedTriangle<'a>) -> Self {
        const COUNT: usize = VerticesAndSlab::<f32>::COUNT;
        let columns: Columns<COUNT> = in_columns(
            #[inline(always)]
            |n| {
                let triangle = of(n);
                let (vertices, slab) = (triangle.vertices, triangle.packed.slab());
                let slab = slab.unwrap_or([0.0; 2]);
                to_array(VerticesAndSlab { vertices, slab }, 0.0)
            },
        );
        let blank = VerticesAndSlab::blank(Patches(f32x8::splat(simd, 0.0)));
        let VerticesAndSlab { vertices, slab } = load_lanes(simd, &columns, blank);
        Self::new(vertices.positions, &vertices.normals, slab)
    }
}
