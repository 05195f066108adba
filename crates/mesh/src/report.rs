//! What was found while a file was read, and the sentences that tell it to the user.

use crate::normals::NormalsReport;

/// What was found in a file.
///
/// ```
/// use curvetri_mesh::Loader;
///
/// let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\n";
/// let report = Loader::new().load_bytes(obj.into(), "a.obj")?.report;
/// assert_eq!((report.polygons, report.skipped_elements), (1, 1));
/// assert!(report.warnings[0].contains("were skipped"));
/// # Ok::<(), curvetri_mesh::LoadError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LoadReport {
    /// Polygons of three corners or more.
    pub polygons: u64,
    /// The triangles that they were cut into.
    pub triangles: u64,
    /// Triangles without area: two corners in one place, or all three on a line as far as single
    /// precision shows. No ray hits them.
    pub degenerate_triangles: u64,
    /// Triangles so small, and so far from the mesh's [origin](crate::Mesh::origin), that single
    /// precision moves their corners by more than a fiftieth of their longest edge.
    pub imprecise_triangles: u64,
    /// Vertices that no face names. They decide nothing and are left out.
    pub unused_vertices: u64,
    /// Faces, corners' normals, facets and primitives that are wrong and were skipped. Only a
    /// [lenient](crate::Loader::lenient) loader skips them.
    pub skipped_faults: u64,
    /// Lines, points and faces of fewer than three corners. They are no surface and are skipped.
    pub skipped_elements: u64,
    /// Vertices that lay so near to another that they were moved onto it.
    pub snapped: u64,
    /// Where the normals come from.
    pub normals: NormalsReport,
    /// Sentences for the user on what was skipped or mended.
    pub warnings: Vec<String>,
}

impl LoadReport {
    /// Whether there are triangles, none of which has an area.
    #[must_use]
    pub fn is_without_area(&self) -> bool {
        self.triangles > 0 && self.degenerate_triangles == self.triangles
    }

    /// Adds what was found when one mesh of the file was made.
    pub(crate) fn add(&mut self, of_mesh: &LoadReport) {
        self.normals = self.normals.add(of_mesh.normals);
        self.snapped += of_mesh.snapped;
        self.triangles += of_mesh.triangles;
        self.degenerate_triangles += of_mesh.degenerate_triangles;
        self.imprecise_triangles += of_mesh.imprecise_triangles;
        self.unused_vertices += of_mesh.unused_vertices;
    }

    /// Puts sentences for what was counted before the reader's own.
    pub(crate) fn warn(&mut self) {
        let normals = &self.normals;
        let counted = [
            (
                self.skipped_elements,
                "lines, points, curves or faces of fewer than three corners are no surface and \
                 were skipped",
            ),
            (
                self.unused_vertices,
                if self.unused_vertices == 1 {
                    "vertex is in no face and was left out"
                } else {
                    "vertices are in no face and were left out"
                },
            ),
            (
                self.imprecise_triangles,
                if self.imprecise_triangles == 1 {
                    "triangle lies so far from the rest that single precision does not hold its \
                     shape; move the parts nearer to each other, or load them one at a time"
                } else {
                    "triangles lie so far from the rest that single precision does not hold \
                     their shape; move the parts nearer to each other, or load them one at a time"
                },
            ),
            (
                self.snapped,
                "vertices lay less than a millionth of an edge, or rounding, beside another and were \
                 put there",
            ),
            (
                normals.unusable,
                "triangle corners have a normal that is zero or not finite; theirs were made",
            ),
            (
                normals.faceted,
                "triangle corners have flat normals on what looks like a curved wall; theirs were \
                 made smooth",
            ),
            (
                normals.averaged,
                "triangle corners have a normal that is a plain average of large and small faces; theirs \
                 were made so that large faces stay flat",
            ),
        ];
        let sentences = (counted.iter())
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}"));
        let mut sentences: Vec<String> = sentences.collect();
        if self.is_without_area() {
            sentences.push(format!(
                "none of the {} triangles has an area: there is nothing to see",
                self.triangles
            ));
        }
        self.warnings.splice(0..0, sentences);
    }
}
