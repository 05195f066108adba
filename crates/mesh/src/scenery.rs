//! What else than meshes a file may hold: cameras and lights.

use glam::DVec3;

/// Cameras and lights of a file, in the user's space and the order of the file's scene.
///
/// ```no_run
/// let scenery = curvetri_mesh::Loader::new().load("scene.glb")?.scenery;
/// println!("{} cameras, {} suns", scenery.cameras.len(), scenery.suns.len());
/// # Ok::<(), curvetri_mesh::LoadError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scenery {
    /// Perspective cameras.
    pub cameras: Vec<FileCamera>,
    /// Towards each light that is infinitely far; unit length.
    pub suns: Vec<DVec3>,
    /// Lights at a point.
    pub lamps: Vec<FileLamp>,
}

impl Scenery {
    /// Puts what another file has behind this.
    pub fn append(&mut self, other: Scenery) {
        self.cameras.extend(other.cameras);
        self.suns.extend(other.suns);
        self.lamps.extend(other.lamps);
    }
}

/// A light of a file that shines from a point.
///
/// ```
/// use curvetri_mesh::FileLamp;
/// use glam::DVec3;
///
/// let lamp = FileLamp { position: DVec3::Y, intensity: DVec3::splat(100.0), range: None, cone: None };
/// assert!(lamp.cone.is_none(), "it shines all around");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FileLamp {
    /// Where it is.
    pub position: DVec3,
    /// Its luminous intensity in candela, times its colour, linear: none below 0, one above.
    pub intensity: DVec3,
    /// Where its light ends, if it does: the distance, above 0.
    pub range: Option<f64>,
    /// The cone that it shines in; all around without.
    pub cone: Option<FileCone>,
}

/// A spot light's cone.
///
/// ```
/// use curvetri_mesh::FileCone;
/// use glam::DVec3;
///
/// let cone = FileCone { axis: -DVec3::Y, angles: [0.3, 0.5] };
/// assert!(cone.angles[0] <= cone.angles[1]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FileCone {
    /// Where it shines to; unit length.
    pub axis: DVec3,
    /// The angles to the axis within which it is full and beyond which it is dark, in radians: 0 or
    /// more, the second not below the first and at most a right angle.
    pub angles: [f64; 2],
}

/// A perspective camera of a file.
///
/// ```
/// use curvetri_mesh::FileCamera;
/// use glam::DVec3;
///
/// let camera = FileCamera {
///     name: "front".into(),
///     eye: 5.0 * DVec3::Z,
///     forward: -DVec3::Z,
///     up: DVec3::Y,
///     fov_degrees: 40.0,
/// };
/// assert_eq!(camera.forward.dot(camera.up), 0.0);
/// ```
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
