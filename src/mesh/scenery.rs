//! What else than meshes a file may hold: cameras and the sun.

use glam::DVec3;

/// Cameras and lights of a file, in the user's space and the order of the file's scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scenery {
    /// Perspective cameras.
    pub cameras: Vec<FileCamera>,
    /// Towards each light that is infinitely far; unit length.
    pub suns: Vec<DVec3>,
}

/// A perspective camera of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct FileCamera {
    /// Its name, or that of what carries it; may be empty.
    pub name: String,
    /// Where it is.
    pub eye: DVec3,
    /// The direction it looks; unit length.
    pub forward: DVec3,
    /// Upwards in its picture; unit length.
    pub up: DVec3,
    /// The angle that its picture's height covers, in degrees, above 0 and below 180.
    pub fov_degrees: f64,
}
