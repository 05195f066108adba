//! Words for what an inspection found, with this program's options.

use curvetri::curved::Advice;

/// A sentence on one thing worth knowing.
pub fn sentence(advice: &Advice) -> String {
    let counted = |what: &str, count: u64, then: &str| format!("{what}: {count}; {then}.");
    match *advice {
        Advice::FlippedEdges(count) => counted(
            "Edges whose triangles do not agree on the front",
            count,
            "they stay straight; make the triangles wind one way",
        ),
        Advice::NonManifoldEdges(count) => counted(
            "Edges with three triangles or more",
            count,
            "they stay straight; remove inner walls and doubled triangles",
        ),
        Advice::BoundaryEdges(count) => counted(
            "Edges with one triangle only",
            count,
            "the surface is open there; fill the holes if it is meant to be closed",
        ),
        Advice::TJunctions(count) => counted(
            "Open edges with a vertex of others within them (T-junctions)",
            count,
            "holes open there where the surface curves; cut the long triangle at that vertex",
        ),
        Advice::DuplicateTriangles(count) => counted(
            "Triangles that lie where another does",
            count,
            "remove them unless both faces are meant",
        ),
        Advice::DegenerateTriangles(count) => counted(
            "Triangles without area",
            count,
            "no ray hits them, and they may be removed",
        ),
        Advice::SnappedVertices(count) => counted(
            "Vertices that lay a rounding beside another",
            count,
            "they were put there; merge such vertices when exporting",
        ),
        Advice::ClockwiseCorners(count) => counted(
            "Corners that wind clockwise as seen from the tip of their normal",
            count,
            "the surface follows the normals, but its front and back are the other way round",
        ),
        Advice::NormalsAgainstFront(count) => counted(
            "Corners whose normal points away from their triangle's front",
            count,
            "if the surface looks wrong there, --normals smooth makes all normals anew",
        ),
        Advice::UnusableNormals(count) => counted(
            "Corners whose normal is zero or not finite",
            count,
            "theirs were made",
        ),
        Advice::RenormalisedNormals(count) => counted(
            "Corners whose normal is not of unit length",
            count,
            "theirs were made so",
        ),
        Advice::FacetedNormals(count) => counted(
            "Corners with flat normals on what looks like a curved wall",
            count,
            "theirs were made smooth; --normals stored keeps them",
        ),
        Advice::AveragedNormals(count) => counted(
            "Corners whose normal is a plain average of large and small faces",
            count,
            "theirs were made so that large faces stay flat; --normals stored keeps them",
        ),
        Advice::ComputedNormals { hard_edges } => format!(
            "The normals were made, with hard edges: {hard_edges}; a greater --crease-angle makes fewer, \
             a smaller one more."
        ),
        Advice::FlatByBackNormal(count) => counted(
            "Triangles that stay flat because a normal points away from their front, or nearly so",
            count,
            "check the normals, or try --normals smooth",
        ),
        Advice::FlatByBend(count) => counted(
            "Triangles that stay flat because their normals bend too much within them",
            count,
            "use smaller ones there",
        ),
        Advice::FlatByFold(count) => counted(
            "Triangles that stay flat because the surface over them would fold",
            count,
            "use smaller ones there",
        ),
        Advice::FlatSlivers(count) => counted(
            "Triangles that stay flat because they are too thin to have a certain plane",
            count,
            "a remeshing tool makes better ones",
        ),
        Advice::SteepTriangle { triangle, share } => format!(
            "Triangle {triangle} bulges by {:.0} % of its longest edge; check its normals, or use smaller \
             triangles there.",
            100.0 * share
        ),
        Advice::SkippedElements(count) => counted(
            "Lines, points and faces of fewer than three corners",
            count,
            "they are no surface and were skipped",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_count_stands_between_what_was_found_and_what_to_do() {
        assert_eq!(
            sentence(&Advice::DegenerateTriangles(7)),
            "Triangles without area: 7; no ray hits them, and they may be removed."
        );
    }

    #[test]
    fn figures_are_in_the_sentence() {
        let steep = Advice::SteepTriangle {
            triangle: 5,
            share: 0.409,
        };
        assert!(sentence(&steep).starts_with("Triangle 5 bulges by 41 % of its longest"));
        let computed = Advice::ComputedNormals { hard_edges: 12 };
        assert!(sentence(&computed).contains("hard edges: 12; a greater --crease-angle"));
    }
}
