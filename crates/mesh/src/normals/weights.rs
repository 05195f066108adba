//! What each face at a vertex counts in the vertex's normal.

use glam::DVec3;

/// Up to this ratio of the greatest to the least area around a vertex, angles alone weigh the faces.
pub(super) const LEAST_RATIO: f64 = 8.0;

/// From this ratio on, the square of the area counts in full.
const GREATEST_RATIO: f64 = 64.0;

/// A face at a vertex.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Face {
    /// The unit normal; zero for a triangle too thin to have one.
    pub normal: DVec3,
    /// The angle at the vertex; zero for a triangle too thin to have a normal.
    pub angle: f64,
    /// Twice the area; zero for a triangle too thin to have a normal.
    pub area: f64,
}

/// The averages that programs write out as normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NaiveWeight {
    Plain,
    Angle,
    Area,
    AngleArea,
}

impl NaiveWeight {
    pub const ALL: [Self; 4] = [Self::Plain, Self::Angle, Self::Area, Self::AngleArea];

    /// The sum of the normals of these faces.
    pub fn sum(self, faces: impl Iterator<Item = Face>) -> DVec3 {
        let weigh = |face: Face| match self {
            Self::Plain => 1.0,
            Self::Angle => face.angle,
            Self::Area => face.area,
            Self::AngleArea => face.angle * face.area,
        };
        faces.map(|face| weigh(face) * face.normal).sum()
    }
}

/// The least and the greatest area of faces that have a plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Areas {
    least: f64,
    greatest: f64,
}

impl Areas {
    pub const NONE: Self = Self {
        least: f64::INFINITY,
        greatest: 0.0,
    };

    pub fn of(faces: impl Iterator<Item = Face>) -> Self {
        faces.fold(Self::NONE, |areas, face| areas.with(face))
    }

    pub fn with(self, face: Face) -> Self {
        if face.area == 0.0 {
            return self;
        }
        Self {
            least: self.least.min(face.area),
            greatest: self.greatest.max(face.area),
        }
    }

    /// The greatest over the least; 0 without faces.
    pub fn ratio(&self) -> f64 {
        self.greatest / self.least
    }

    /// What a face of these counts: its angle, which serves organic shapes best, and the more the areas differ,
    /// its area too, so that a large panel beside narrow chamfers stays flat.
    pub fn weight(&self, face: Face) -> f64 {
        if face.area == 0.0 {
            return 0.0;
        }
        let beyond = (self.ratio() / LEAST_RATIO).ln() / (GREATEST_RATIO / LEAST_RATIO).ln();
        face.angle * (face.area / self.greatest).powf(2.0 * beyond.clamp(0.0, 1.0))
    }

    /// The sum of the normals of these faces, by their weights.
    pub fn sum(&self, faces: impl Iterator<Item = Face>) -> DVec3 {
        faces.map(|face| self.weight(face) * face.normal).sum()
    }
}
