//! Measuring a triangle, whatever tells where its surface is.

use glam::DVec3;

use super::sampling;
use crate::bodies::Body;

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub position: DVec3,
    /// The surface's geometric normal; any length but zero.
    pub normal: DVec3,
    /// Along which the distance to the true surface is taken; any length but zero.
    pub line: DVec3,
}

/// What tells where the surface of a body's triangle is.
pub(super) trait Probe: Sync {
    /// The surface over the barycentric coordinates (u, v) of a triangle, if it is found there.
    fn at(&self, triangle: usize, at: [f64; 2]) -> Option<Point>;

    /// The normal of that triangle's own surface over a point on one of its sides.
    fn normal_on_side(&self, triangle: usize, at: [f64; 2]) -> Option<DVec3>;
}

/// Sums over points.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    pub points: usize,
    pub missed: usize,
    /// Greatest distance to the true surface.
    pub max: f64,
    area: f64,
    error: f64,
    angle: f64,
}

impl Tally {
    pub fn add(self, other: Self) -> Self {
        Self {
            points: self.points + other.points,
            missed: self.missed + other.missed,
            max: self.max.max(other.max),
            area: self.area + other.area,
            error: self.error + other.error,
            angle: self.angle + other.angle,
        }
    }

    /// NaN if nothing was measured.
    pub fn mean_error(&self) -> f64 {
        self.error / self.area
    }

    /// Radians; NaN if nothing was measured.
    pub fn mean_angle(&self) -> f64 {
        self.angle / self.area
    }
}

/// Measures one triangle at this many points.
pub(super) fn measure_triangle(
    body: &Body,
    probe: &impl Probe,
    triangle: usize,
    samples: usize,
    seed: u64,
) -> Tally {
    let [a, b, c] = body.triangles()[triangle].positions;
    // Each point stands for as much of the body's area.
    let share = (b - a).cross(c - a).length() / samples as f64;
    let mut tally = Tally::default();
    for at in sampling::points(samples, seed, triangle) {
        match probe.at(triangle, at).and_then(|p| deviation(body, &p)) {
            Some([error, angle]) => {
                tally.points += 1;
                tally.max = tally.max.max(error);
                tally.area += share;
                tally.error += error * share;
                tally.angle += angle * share;
            }
            None => tally.missed += 1,
        }
    }
    tally
}

/// Distance to the true surface along the point's line, and angle to the true normal.
fn deviation(body: &Body, point: &Point) -> Option<[f64; 2]> {
    let t = body.true_parameter(point.position, point.line)?;
    let distance = (t * point.line).length();
    let angle = angle(point.normal, body.normal(point.position));
    (distance.is_finite() && angle.is_finite()).then_some([distance, angle])
}

/// The angle between two vectors in radians, exact for small ones.
pub(super) fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}
