//! What to render of a scene.

use glam::{DVec3, Vec3};

use super::camera::{Camera, CameraError, Lens, UpAxis};
use super::light::Lighting;
use super::material::Material;
use super::scene::Scene;
use super::shading::Shading;
use super::vicinity::Vicinity;
use crate::mesh::Bounds;

/// What to render of a scene.
///
/// ```
/// use curvetri::render::{Camera, Crop, Material, Picture, Projection, Shading, UpAxis};
/// use glam::DVec3;
///
/// let projection = Projection::Perspective { fov_degrees: 35.0 };
/// let camera = Camera { eye: DVec3::Z, target: DVec3::ZERO, up: DVec3::Y, projection };
/// let picture = Picture {
///     crop: Some(Crop { x: 100, y: 50, width: 320, height: 240 }),
///     material: Material::Glass { index: 1.5 },
///     shading: Shading::Interpolated,
///     ..Picture::new(800, 600, camera, UpAxis::Y)
/// };
/// assert_eq!(picture.samples, 16);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The part to render; all without.
    pub crop: Option<Crop>,
    /// Camera rays a pixel, spread evenly over its square.
    pub samples: u32,
    /// Other seeds give other noise; the same one the same picture.
    pub seed: u32,
    /// How light is found.
    pub integrator: Integrator,
    /// The camera.
    pub camera: Camera,
    /// The lights.
    pub lighting: Lighting,
    /// What the meshes are made of.
    pub material: Material,
    /// Share of light that diffuse surfaces reflect, 0 to 1.
    pub albedo: f32,
    /// What flat triangles are lit by.
    pub shading: Shading,
    /// The ground.
    pub ground: Ground,
    /// Whether the sky is seen where nothing else is: such pixels are covered.
    pub show_sky: bool,
}

/// A part of a picture, in pixels from its upper left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// Its first column.
    pub x: usize,
    /// Its first row.
    pub y: usize,
    /// Its columns, 1 or more.
    pub width: usize,
    /// Its rows, 1 or more.
    pub height: usize,
}

/// How the light of a picture is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Integrator {
    /// Only what comes straight from sun, lamp and sky.
    Direct {
        /// Whether surfaces hide the sky from each other, which makes noise.
        sky_shadows: bool,
    },
    /// No lights: white, darker where the directions above a surface are not open (ambient
    /// occlusion).
    AmbientOcclusion {
        /// How far away what hides counts, in the units of the meshes; may be infinite.
        distance: f32,
    },
    /// All light, also by way of other surfaces.
    Path {
        /// How many surfaces light hits at most, 1 or more; with 1 it is the direct
        /// light, with the sky's shadows.
        depth: u32,
    },
}

/// A plane under the meshes that takes their shadows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Ground {
    /// No ground.
    #[default]
    None,
    /// An endless plane through the surface's lowest point that fades into the background.
    Plane,
    /// Such a plane where another scene has it: see [`Ground::under`].
    Fixed(FixedGround),
}

/// Where the ground begins to fade, and where it ends, in radii of what lies on it.
pub(super) const GROUND_FADES: [f64; 2] = [2.0, 12.0];

/// A ground that stays in its place whatever the scene, in the user's space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedGround {
    /// Its height along the sky's up vector.
    pub(super) height: f64,
    /// The middle of what lies on it.
    pub(super) centre: DVec3,
    /// How far that reaches from its middle.
    pub(super) radius: f64,
}

impl Ground {
    /// The ground that [`Ground::Plane`] is for this scene, so that others may lie on it as well. `up`
    /// is the sky's up vector.
    pub fn under(scene: &Scene, up: Vec3) -> Self {
        Self::Fixed(FixedGround::under(scene, up))
    }
}

impl FixedGround {
    pub(super) fn under(scene: &Scene, up: Vec3) -> Self {
        let (centre, radius) = Self::ball(scene);
        Self {
            height: f64::from(scene.lowest(up)) + scene.origin().dot(up.as_dvec3()),
            centre,
            radius,
        }
    }

    /// The middle and the radius of what lies on the ground, without the search for its height.
    fn ball(scene: &Scene) -> (DVec3, f64) {
        (scene.bounds().centre(), 0.5 * scene.bounds().diagonal())
    }
}

impl Default for Integrator {
    fn default() -> Self {
        Self::Direct { sky_shadows: false }
    }
}

impl Picture {
    /// The least size of one of its pixels on what is within a box, in the user's units; see
    /// [`Camera::least_pixel`].
    pub fn least_pixel(&self, bounds: &Bounds) -> f32 {
        self.camera.least_pixel(bounds, self.width, self.height) as f32
    }

    /// A picture of this size by daylight, of 16 samples a pixel, without a ground.
    pub fn new(width: usize, height: usize, camera: Camera, up: UpAxis) -> Self {
        Self {
            width,
            height,
            crop: None,
            samples: 16,
            seed: 0,
            integrator: Integrator::default(),
            camera,
            lighting: Lighting::daylight(up),
            material: Material::default(),
            albedo: 0.7,
            shading: Shading::default(),
            ground: Ground::default(),
            show_sky: false,
        }
    }

    /// The camera, prepared for a scene.
    pub(crate) fn lens(&self, scene: &Scene) -> Result<Lens, CameraError> {
        let lens = self.camera.lens(scene.origin(), self.width, self.height)?;
        let vicinity = Vicinity::of(scene.bounds());
        let ground = match self.ground {
            Ground::None => return Ok(lens.near(vicinity)),
            Ground::Plane => FixedGround::ball(scene),
            Ground::Fixed(ground) => (ground.centre, ground.radius),
        };
        let (centre, radius) = ground;
        Ok(lens.near(vicinity.including(centre, GROUND_FADES[1] * radius)))
    }

    /// The part to render.
    ///
    /// # Panics
    /// If it has no pixel or is not within the picture.
    pub(super) fn window(&self) -> Window {
        let full = [self.width, self.height];
        let crop = self.crop.unwrap_or(Crop {
            x: 0,
            y: 0,
            width: self.width,
            height: self.height,
        });
        let (corner, size) = ([crop.x, crop.y], [crop.width, crop.height]);
        for axis in [0, 1] {
            let end = corner[axis].checked_add(size[axis]);
            let within = end.is_some_and(|end| end <= full[axis]);
            assert!(size[axis] > 0 && within, "{crop:?} of {full:?} pixels");
        }
        Window { full, corner, size }
    }
}

/// The rendered part of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Window {
    /// The whole picture's width and height.
    pub full: [usize; 2],
    /// The part's upper left corner in it.
    pub corner: [usize; 2],
    /// The part's own width and height.
    pub size: [usize; 2],
}

impl Window {
    /// All of a picture.
    pub fn all(full: [usize; 2]) -> Self {
        Self {
            full,
            corner: [0; 2],
            size: full,
        }
    }

    /// How many pixels it has.
    pub fn count(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Where a square with this many pixels a side covers it: the places of each row's pixels in the
    /// square, and in the window.
    pub fn rows_of(
        self,
        corner: [usize; 2],
        side: usize,
    ) -> impl Iterator<Item = (std::ops::Range<usize>, usize)> {
        let [columns, rows] = [0, 1].map(|axis| {
            let end = self.corner[axis] + self.size[axis];
            corner[axis].max(self.corner[axis])..(corner[axis] + side).min(end)
        });
        rows.map(move |y| {
            let from = (y - corner[1]) * side + columns.start - corner[0];
            let at = (y - self.corner[1]) * self.size[0] + columns.start - self.corner[0];
            (from..from + columns.len(), at)
        })
    }
}
