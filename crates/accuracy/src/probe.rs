//! Measuring a triangle, whatever tells where its surface is.

use glam::DVec3;

use super::sampling;
use curvetri_bodies::Body;

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct ProbedPoint {
    pub position: DVec3,
    /// The surface's geometric normal; any length but zero.
    pub normal: DVec3,
    /// Along which the distance to the true surface is taken, of any length but zero; without it the
    /// distance is that to the nearest point.
    pub line: Option<DVec3>,
}

/// What tells where the surface of a body's triangle is.
pub(super) trait SurfaceProbe: Sync {
    /// The surface over the barycentric coordinates (u, v) of a triangle, if it is found there.
    fn at(&self, triangle: usize, at: [f64; 2]) -> Option<ProbedPoint>;

    /// The normal of that triangle's own surface over a point on one of its edges.
    fn normal_on_edge(&self, triangle: usize, at: [f64; 2]) -> Option<DVec3>;
}

/// Sums over points.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    pub measured: usize,
    pub missed: usize,
    /// Greatest distance to the true surface.
    pub max: f64,
    /// Points inside triangles, which the means are over.
    inside: usize,
    error: f64,
    angle: f64,
}

impl Tally {
    pub fn add(self, other: Self) -> Self {
        Self {
            measured: self.measured + other.measured,
            missed: self.missed + other.missed,
            max: self.max.max(other.max),
            inside: self.inside + other.inside,
            error: self.error + other.error,
            angle: self.angle + other.angle,
        }
    }

    /// NaN if nothing was measured.
    pub fn mean_error(&self) -> f64 {
        self.error / self.inside as f64
    }

    /// Radians; NaN if nothing was measured.
    pub fn mean_angle(&self) -> f64 {
        self.angle / self.inside as f64
    }

    /// Counts a point for the maximum; its error and angle if it could be measured.
    fn meet(&mut self, body: &Body, point: Option<ProbedPoint>) -> Option<[f64; 2]> {
        let deviation = point.and_then(|point| deviation(body, &point));
        match deviation {
            Some([error, _]) => {
                self.measured += 1;
                self.max = self.max.max(error);
            }
            None => self.missed += 1,
        }
        deviation
    }
}

/// Measures one triangle at this many points, uniform over its area, and for the maximum also along
/// its edges, where the greatest error often is.
pub(super) fn measure_triangle(
    body: &Body,
    probe: &impl SurfaceProbe,
    triangle: usize,
    samples: usize,
    seed: u64,
) -> Tally {
    let mut tally = Tally::default();
    for at in sampling::points(samples, seed, triangle) {
        if let Some([error, angle]) = tally.meet(body, probe.at(triangle, at)) {
            tally.inside += 1;
            tally.error += error;
            tally.angle += angle;
        }
    }
    for at in sampling::around(samples) {
        tally.meet(body, probe.at(triangle, at));
    }
    tally
}

/// Distance to the true surface, and angle to the true normal.
fn deviation(body: &Body, point: &ProbedPoint) -> Option<[f64; 2]> {
    let distance = match point.line {
        Some(line) => (body.true_parameter(point.position, line)? * line).length(),
        None => body.signed_distance(point.position).abs(),
    };
    let angle = angle(point.normal, body.normal(point.position));
    (distance.is_finite() && angle.is_finite()).then_some([distance, angle])
}

/// The angle between two vectors in radians, exact for small ones.
pub(super) fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}
