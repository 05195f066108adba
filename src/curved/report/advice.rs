//! What is worth knowing of a mesh that was inspected.

use super::inspection::Inspection;

/// Heights beyond this share of a triangle's longest edge are out of the ordinary: a ball of four
/// triangles has 0.41.
const STEEP: f64 = 0.3;

/// Something worth knowing of a mesh, with its figures. Counts are above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Advice {
    /// So many edges lie between triangles that do not agree on the front. They stay straight.
    FlippedEdges(u64),
    /// So many edges have three triangles or more. They stay straight.
    NonManifoldEdges(u64),
    /// So many edges have one triangle only: the surface is open there.
    BoundaryEdges(u64),
    /// So many open edges have a vertex of others within them. Holes open there where the surface curves.
    TJunctions(u64),
    /// So many triangles lie where another does.
    DuplicateTriangles(u64),
    /// So many triangles are without area. No ray hits them.
    DegenerateTriangles(u64),
    /// So many vertices lay a rounding beside another and were moved there.
    SnappedVertices(u64),
    /// So many corners, more than half of all, wind clockwise as seen from their normal. The surface follows
    /// the normals, but its front and back are the other way round.
    ClockwiseCorners(u64),
    /// The normals of so many corners, no more than half of all, point away from their triangle's front.
    NormalsAgainstFront(u64),
    /// The normals of so many corners are zero or not finite. New ones were computed.
    UnusableNormals(u64),
    /// The normals of so many corners are not of unit length. They were normalised.
    RenormalisedNormals(u64),
    /// So many corners had flat normals on what looks like a curved wall. Smooth ones were computed.
    FacetedNormals(u64),
    /// So many corners had a plain average of large and small faces for a normal. Better ones were computed.
    AveragedNormals(u64),
    /// There were no normals; they were computed, with so many hard edges.
    ComputedNormals {
        /// Edges at which the normals of the two triangles differ. May be 0.
        hard_edges: u64,
    },
    /// So many triangles stay flat because a normal points away from their front, or nearly so.
    FlatByBackNormal(u64),
    /// So many triangles stay flat because their normals bend too much within them.
    FlatByBend(u64),
    /// So many triangles stay flat because the surface over them would fold.
    FlatByFold(u64),
    /// So many triangles stay flat because they are too thin to have a certain plane.
    FlatSlivers(u64),
    /// The triangle that bulges most does so by more than is usual.
    SteepTriangle {
        /// Its number.
        triangle: u32,
        /// The height of its surface over its longest edge.
        share: f64,
    },
    /// So many lines, points and faces of fewer than three corners are no surface and were skipped.
    SkippedElements(u64),
}

/// A count, and what it means where it is not 0.
type Counted = (u64, fn(u64) -> Advice);

impl Inspection {
    /// What is worth knowing, the worst first; nothing if all is well.
    #[must_use]
    pub fn advice(&self) -> Vec<Advice> {
        let advice = |(count, advice): Counted| (count > 0).then(|| advice(count));
        let counted = (self.on_edges().into_iter()).chain(self.on_normals());
        let counted = counted.filter_map(advice);
        let flat = self.on_flat_triangles().into_iter().filter_map(advice);
        let skipped = self.report.skipped_elements;
        (counted.chain(self.on_computed_normals()))
            .chain(flat)
            .chain(self.on_heights())
            .chain((skipped > 0).then_some(Advice::SkippedElements(skipped)))
            .collect()
    }

    fn on_edges(&self) -> [Counted; 7] {
        let edges = &self.topology;
        [
            (edges.flipped, Advice::FlippedEdges),
            (edges.non_manifold, Advice::NonManifoldEdges),
            (edges.boundary, Advice::BoundaryEdges),
            (self.t_junctions, Advice::TJunctions),
            (edges.duplicate_triangles, Advice::DuplicateTriangles),
            (edges.degenerate_triangles, Advice::DegenerateTriangles),
            (self.report.snapped, Advice::SnappedVertices),
        ]
    }

    fn on_normals(&self) -> [Counted; 5] {
        let normals = &self.report.normals;
        let corners = 3 * self.triangles;
        let against: fn(u64) -> Advice = if 2 * normals.against_face > corners {
            Advice::ClockwiseCorners
        } else {
            Advice::NormalsAgainstFront
        };
        [
            (normals.against_face, against),
            (normals.unusable, Advice::UnusableNormals),
            (normals.renormalised, Advice::RenormalisedNormals),
            (normals.faceted, Advice::FacetedNormals),
            (normals.averaged, Advice::AveragedNormals),
        ]
    }

    fn on_computed_normals(&self) -> Option<Advice> {
        let normals = &self.report.normals;
        (normals.stored + normals.faceted + normals.averaged == 0).then_some(
            Advice::ComputedNormals {
                hard_edges: self.topology.hard,
            },
        )
    }

    fn on_flat_triangles(&self) -> [Counted; 4] {
        let kinds = &self.kinds;
        [
            (kinds.flat_back_normal as u64, Advice::FlatByBackNormal),
            (kinds.flat_bend as u64, Advice::FlatByBend),
            (kinds.flat_fold as u64, Advice::FlatByFold),
            (kinds.flat_sliver as u64, Advice::FlatSlivers),
        ]
    }

    fn on_heights(&self) -> Option<Advice> {
        let heights = &self.heights;
        (heights.steepest > STEEP).then_some(Advice::SteepTriangle {
            triangle: heights.steepest_at,
            share: heights.steepest,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curved::CurvedOptions;
    use crate::mesh::Loader;

    fn advice(text: &str) -> Vec<Advice> {
        let bytes = text.as_bytes().to_vec();
        let loaded = Loader::new().load_bytes(bytes, "x.obj").unwrap();
        Inspection::new(loaded, &CurvedOptions::default()).advice()
    }

    const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

    fn with(rest: &str) -> Vec<Advice> {
        advice(&format!("{CORNERS}{rest}"))
    }

    #[test]
    fn a_good_mesh_needs_none_but_for_its_heights() {
        let n = 1.0 / 3f64.sqrt();
        let ball = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]];
        let lines = ball.map(|p| {
            let normal = p.map(|x| (f64::from(x) * n).to_string()).join(" ");
            format!("v {} {} {}\nvn {normal}\n", p[0], p[1], p[2])
        });
        let faces = "f 1//1 2//2 3//3\nf 1//1 3//3 4//4\nf 1//1 4//4 2//2\nf 2//2 4//4 3//3\n";
        let advice = advice(&format!("{}{faces}", lines.concat()));
        let [Advice::SteepTriangle { triangle: 0, share }] = advice[..] else {
            panic!("{advice:?}");
        };
        assert!((share - 0.41).abs() < 0.005, "{share}");
    }

    #[test]
    fn each_problem_is_found() {
        let one = "f 1 2 3\n";
        for (faces, expected) in [
            ("", Advice::BoundaryEdges(3)),
            ("f 1 2 3\n", Advice::DuplicateTriangles(1)),
            ("f 1 2 4\n", Advice::FlippedEdges(1)),
            ("f 2 1 4\nf 1 2 4\n", Advice::NonManifoldEdges(1)),
            ("f 2 2 4\n", Advice::DegenerateTriangles(1)),
            ("v 0.5 0 0\nf 5 1 4\n", Advice::TJunctions(1)),
            ("", Advice::ComputedNormals { hard_edges: 0 }),
            ("l 1 2\n", Advice::SkippedElements(1)),
            ("vn 0 1 0\nf 1//1 2//1 4\n", Advice::NormalsAgainstFront(2)),
            ("vn 0 0 0\nf 1//1 2//1 4\n", Advice::UnusableNormals(2)),
            ("vn 0 -2 0\nf 1//1 2//1 4\n", Advice::RenormalisedNormals(2)),
        ] {
            let found = with(&format!("{one}{faces}"));
            assert!(found.contains(&expected), "{faces:?}: {found:?}");
        }
    }

    #[test]
    fn clockwise_winding_is_found_once() {
        let found = with("vn 0 0 -1\nf 1//1 2//1 3//1\n");
        assert!(found.contains(&Advice::ClockwiseCorners(3)), "{found:?}");
        let against = |advice: &Advice| matches!(advice, Advice::NormalsAgainstFront(_));
        assert!(!found.iter().any(against), "{found:?}");
    }

    #[test]
    fn flat_triangles_are_found_with_their_reason() {
        let found = with("vn 0 0 1\nvn 0 0.98 -0.2\nf 1//1 2//1 3//2\n");
        assert!(found.contains(&Advice::FlatByBackNormal(1)), "{found:?}");
    }
}
