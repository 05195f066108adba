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
    /// Adds what was found when one mesh of the file was made.
    pub(crate) fn add(&mut self, of_mesh: &LoadReport) {
        self.normals = self.normals.add(of_mesh.normals);
        self.snapped += of_mesh.snapped;
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
        ];
        let sentences = (counted.iter())
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}"));
        self.warnings.splice(0..0, sentences);
    }
}
