//! What to do about what an inspection finds, in plain sentences.

use super::Inspection;

/// Heights beyond this share of a triangle's longest side are out of the ordinary: a ball of four
/// triangles has 0.41.
const STEEP: f64 = 0.3;

impl Inspection {
    /// A sentence for each thing worth knowing, the worst first; none if all is well.
    #[must_use]
    pub fn advice(&self) -> Vec<String> {
        let mut advice = Vec::new();
        self.on_sides(&mut advice);
        self.on_normals(&mut advice);
        self.on_kinds(&mut advice);
        self.on_the_rest(&mut advice);
        advice
    }

    fn on_sides(&self, advice: &mut Vec<String>) {
        let sides = &self.topology;
        let mut say = |count: u64, what: &str, then: &str| tell(advice, count, what, then);
        say(
            sides.flipped,
            "Sides whose triangles do not agree on the front",
            "they stay straight; make the triangles wind one way",
        );
        say(
            sides.non_manifold,
            "Sides with three triangles or more",
            "they stay straight; remove inner walls and doubled triangles",
        );
        say(
            sides.boundary,
            "Sides with one triangle only",
            "the surface is open there; fill the holes if it is meant to be closed",
        );
        say(
            self.t_junctions,
            "Open sides with a vertex of others within them (T-junctions)",
            "holes open there where the surface curves; cut the long triangle at that vertex",
        );
        say(
            sides.duplicate_triangles,
            "Triangles that lie where another does",
            "remove them unless both faces are meant",
        );
        say(
            sides.degenerate_triangles,
            "Triangles without area",
            "no ray hits them, and they may be removed",
        );
        say(
            self.report.snapped,
            "Vertices that lay a rounding beside another",
            "they were put there; merge such vertices when exporting",
        );
    }

    fn on_normals(&self, advice: &mut Vec<String>) {
        let normals = &self.report.normals;
        let corners = 3 * self.triangles;
        let mut say = |count: u64, what: &str, then: &str| tell(advice, count, what, then);
        if 2 * normals.against_face > corners {
            say(
                normals.against_face,
                "Corners that wind clockwise as seen from their normal's side",
                "the surface follows the normals, but its front and back are the other way round",
            );
        } else {
            say(
                normals.against_face,
                "Corners whose normal points away from their triangle's front",
                "if the surface looks wrong there, --normals smooth makes all normals anew",
            );
        }
        say(
            normals.unusable,
            "Corners whose normal is zero or not finite",
            "theirs were made",
        );
        say(
            normals.renormalised,
            "Corners whose normal is not of unit length",
            "theirs were made so",
        );
        say(
            normals.faceted,
            "Corners with flat normals on what looks like a curved wall",
            "theirs were made smooth; --normals stored keeps them",
        );
        if normals.stored == 0 && normals.faceted == 0 {
            advice.push(format!(
                "The normals were made, with hard edges: {}; a greater --crease-angle makes fewer, a \
                 smaller one more.",
                self.topology.hard
            ));
        }
    }

    fn on_kinds(&self, advice: &mut Vec<String>) {
        let kinds = &self.kinds;
        let mut say = |count: usize, why: &str, then: &str| {
            let what = format!("Triangles that stay flat because {why}");
            tell(advice, count as u64, &what, then);
        };
        say(
            kinds.flat_back_normal,
            "a normal points away from their front, or nearly so",
            "check the normals, or try --normals smooth",
        );
        say(
            kinds.flat_bend,
            "their normals bend too much within them",
            "use smaller ones there",
        );
        say(
            kinds.flat_fold,
            "the surface over them would fold",
            "use smaller ones there",
        );
        say(
            kinds.flat_sliver,
            "they are too thin to have a certain plane",
            "a remeshing tool makes better ones",
        );
    }

    fn on_the_rest(&self, advice: &mut Vec<String>) {
        if self.heights.steepest > STEEP {
            advice.push(format!(
                "Triangle {} bulges by {:.0} % of its longest side; check its normals, or use \
                 smaller triangles there.",
                self.heights.steepest_at,
                100.0 * self.heights.steepest
            ));
        }
        tell(
            advice,
            self.report.skipped_elements,
            "Lines, points and faces of fewer than three corners",
            "they are no surface and were skipped",
        );
    }
}

/// A sentence on how many of something there are, if any, and what of it.
fn tell(advice: &mut Vec<String>, count: u64, what: &str, then: &str) {
    if count > 0 {
        advice.push(format!("{what}: {count}; {then}."));
    }
}

#[cfg(test)]
mod tests {
    use crate::curved::{CurvedOptions, Inspection};
    use crate::mesh::Loader;

    fn advice(text: &str) -> String {
        let bytes = text.as_bytes().to_vec();
        let loaded = Loader::new().load_bytes(bytes, "x.obj").unwrap();
        let advice = Inspection::new(loaded, &CurvedOptions::default()).advice();
        advice.join("\n")
    }

    const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

    fn with(rest: &str) -> String {
        advice(&format!("{CORNERS}{rest}"))
    }

    #[test]
    fn a_good_mesh_needs_none() {
        let n = 1.0 / 3f64.sqrt();
        let ball = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]];
        let lines = ball.map(|p| {
            let normal = p.map(|x| (f64::from(x) * n).to_string()).join(" ");
            format!("v {} {} {}\nvn {normal}\n", p[0], p[1], p[2])
        });
        let faces = "f 1//1 2//2 3//3\nf 1//1 3//3 4//4\nf 1//1 4//4 2//2\nf 2//2 4//4 3//3\n";
        assert_eq!(
            advice(&format!("{}{faces}", lines.concat())),
            "Triangle 0 bulges by 41 % of its longest side; check its normals, or use smaller \
             triangles there."
        );
    }

    #[test]
    fn each_problem_has_its_sentence() {
        let one = "f 1 2 3\n";
        for (faces, sentence) in [
            (
                "",
                "Sides with one triangle only: 3; the surface is open there",
            ),
            ("f 1 2 3\n", "Triangles that lie where another does: 1;"),
            (
                "f 1 2 4\n",
                "Sides whose triangles do not agree on the front: 1;",
            ),
            (
                "f 2 1 4\nf 1 2 4\n",
                "Sides with three triangles or more: 1;",
            ),
            ("f 2 2 4\n", "Triangles without area: 1;"),
            (
                "v 0.5 0 0\nf 5 1 4\n",
                "Open sides with a vertex of others within them (T-junctions): 1; holes open",
            ),
            ("", "The normals were made, with hard edges: 0;"),
            (
                "l 1 2\n",
                "Lines, points and faces of fewer than three corners: 1;",
            ),
            (
                "vn 0 1 0\nf 1//1 2//1 4\n",
                "Corners whose normal points away from their triangle's front: 2;",
            ),
            (
                "vn 0 0 0\nf 1//1 2//1 4\n",
                "Corners whose normal is zero or not finite: 2;",
            ),
            (
                "vn 0 -2 0\nf 1//1 2//1 4\n",
                "Corners whose normal is not of unit length: 2;",
            ),
        ] {
            let text = with(&format!("{one}{faces}"));
            assert!(text.contains(sentence), "{faces:?}: {text}");
        }
    }

    #[test]
    fn clockwise_winding_is_told_once() {
        let text = with("vn 0 0 -1\nf 1//1 2//1 3//1\n");
        assert!(
            text.contains("Corners that wind clockwise as seen from their normal's side: 3;"),
            "{text}"
        );
        assert!(!text.contains("points away"), "{text}");
    }

    #[test]
    fn flat_triangles_are_told_with_their_reason() {
        let text = with("vn 0 0 1\nvn 0 0.98 -0.2\nf 1//1 2//1 3//2\n");
        assert!(
            text.contains("Triangles that stay flat because a normal points away"),
            "{text}"
        );
    }
}
