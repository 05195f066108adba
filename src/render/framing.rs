//! Where a camera has to stand to see all of a scene.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::camera::{Axes, Camera, Projection, UpAxis};
use super::extent::placed_corners;
use super::placed_shape::PlacedShape;
use super::scene::Scene;
use crate::mesh::Mesh;

/// How much further away than necessary the camera stands, as a share of its distance.
const MARGIN: f64 = 0.05;
/// The angle, in degrees, of the camera that sees what an orthographic one does: its rays are as good as parallel.
const PARALLEL_FOV: f64 = 1e-4;
/// A shadow longer than this many times the height of what casts it is not shown to its end.
const LONGEST_SHADOW: f32 = 2.0;

/// What a camera that finds its own place goes by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Framing {
    /// Upwards in the picture.
    pub up: UpAxis,
    /// The angle that the picture's height covers, in degrees; `None` for an orthographic camera.
    pub fov_degrees: Option<f64>,
    /// The picture's width over its height.
    pub aspect: f64,
    /// Towards the sun (unit length), if the shadows on the ground are to be seen as well.
    pub shadows_of: Option<Vec3>,
}

impl Framing {
    /// A camera that looks from above, in front and a little to the right, as near as shows
    /// everything.
    ///
    /// It goes by vertices and their normals, so flat and curved scenes of the same meshes are framed
    /// the same.
    pub fn camera(&self, scene: &Scene) -> Camera {
        let towards_eye = self.up.turn(DVec3::new(0.5, 0.42, 1.0)).normalize();
        let axes = Axes::new(-towards_eye, self.up.vector());
        let middle = scene.bounds().centre();
        let wedges = self.wedges(scene, &axes);
        let eye = wedges.eye(1.0 + MARGIN);
        // A single point, too, is looked at from somewhere.
        let least = (f64::from(f32::EPSILON) * middle.abs().max_element()).max(1e-30);
        let [x, y, z] = [eye[0], eye[1], eye[2].max(least)];
        let (distance, projection) = match self.fov_degrees {
            Some(fov_degrees) => (z, Projection::Perspective { fov_degrees }),
            None => {
                let height = 2.0 * self.slope() * z;
                let distance = wedges.nearest + height + least;
                (distance, Projection::Orthographic { height })
            }
        };
        let target = middle + x * axes.right + y * axes.up;
        Camera {
            eye: target + distance * towards_eye,
            target,
            up: self.up.vector(),
            projection,
        }
    }

    /// The slope of the picture's upper edge.
    fn slope(&self) -> f64 {
        let fov_degrees = self.fov_degrees.unwrap_or(PARALLEL_FOV);
        (0.5 * fov_degrees).to_radians().tan()
    }

    /// Around everything to be seen, from the middle of the scene's bounds.
    fn wedges(&self, scene: &Scene, axes: &Axes) -> Wedges {
        let slope = self.slope();
        let none = Wedges {
            slopes: [slope * self.aspect, slope],
            ..Wedges::NONE
        };
        let centre = (scene.bounds().centre() - scene.origin()).as_vec3();
        let shadows = self.shadows_of.map(|sun| self.shadows(scene, sun));
        let add = |wedges: Wedges, (p, radius): (Vec3, f32)| {
            wedges.including((p - centre).as_dvec3(), radius.into(), axes)
        };
        let add_both = |wedges: Wedges, (p, radius): (Vec3, f32)| match &shadows {
            Some(shadows) => add(add(wedges, (p, radius)), (shadows.of(p), radius)),
            None => add(wedges, (p, radius)),
        };
        let boxes = Boxes::of(scene);
        scene.outermost_first().fold(none, |around, (_, place)| {
            if let Some(bounding) = boxes.of_place(place) {
                let [a, b] = [around, bounding.into_iter().fold(around, add_both)];
                if a.touching == b.touching && a.nearest == b.nearest {
                    return around;
                }
            }
            let mesh = scene.shapes()[place.shape].mesh();
            let triangles = mesh.triangles().par_iter();
            triangles
                .fold(
                    || around,
                    |wedges, t| placed_balls(place, mesh, t).fold(wedges, add_both),
                )
                .reduce(|| around, Wedges::union)
        })
    }

    fn shadows(&self, scene: &Scene, towards_sun: Vec3) -> Shadows {
        let up = self.up.vector().as_vec3();
        let boxes = Boxes::of(scene);
        let bottom = |(p, radius): (Vec3, f32)| p.dot(up) - radius;
        let lowest = |least: f32, (_, place): (u32, &PlacedShape)| {
            if let Some(bounding) = boxes.of_place(place)
                && bounding.into_iter().all(|ball| bottom(ball) >= least)
            {
                return least;
            }
            let mesh = scene.shapes()[place.shape].mesh();
            let triangles = mesh.triangles().par_iter();
            let bottoms = triangles.flat_map_iter(|t| placed_balls(place, mesh, t).map(bottom));
            bottoms.reduce(|| least, f32::min)
        };
        let height = towards_sun.dot(up);
        let along = height * up - towards_sun;
        let least_height = along.length() / LONGEST_SHADOW;
        Shadows {
            up,
            ground: scene.outermost_first().fold(f32::INFINITY, lowest),
            slide: along / height.max(least_height).max(f32::MIN_POSITIVE),
        }
    }
}

/// For each shape that has instances, the box of its balls' middles and the largest radius: a look at
/// it spares one at the balls of most instances.
struct Boxes(Vec<Option<([Vec3; 2], f32)>>);

impl Boxes {
    fn of(scene: &Scene) -> Self {
        let mut boxes = vec![None; scene.shapes().len()];
        for (_, place) in scene.outermost_first() {
            if place.instance.is_some() && boxes[place.shape].is_none() {
                boxes[place.shape] = Some(box_of_balls(scene.shapes()[place.shape].mesh()));
            }
        }
        Self(boxes)
    }

    /// Balls whose hull holds all balls of an instance.
    fn of_place(&self, place: &PlacedShape) -> Option<[(Vec3, f32); 8]> {
        let instance = place.instance.as_ref()?;
        let (bounds, radius) = self.0[place.shape]?;
        let radius = radius * instance.stretch();
        Some(placed_corners(instance, bounds).map(|p| (p, radius)))
    }
}

fn box_of_balls(mesh: &Mesh) -> ([Vec3; 2], f32) {
    let none = ([Vec3::INFINITY, Vec3::NEG_INFINITY], 0_f32);
    let balls = mesh
        .triangles()
        .par_iter()
        .flat_map_iter(|t| balls(mesh, t));
    let around = balls.map(|(p, radius)| ([p, p], radius));
    around.reduce(
        || none,
        |(a, r), (b, s)| ([a[0].min(b[0]), a[1].max(b[1])], r.max(s)),
    )
}

/// The [balls] of a triangle where it is put.
fn placed_balls(
    place: &PlacedShape,
    mesh: &Mesh,
    triangle: &[u32; 3],
) -> impl Iterator<Item = (Vec3, f32)> + use<> {
    let balls = balls(mesh, triangle);
    let placed = match &place.instance {
        None => balls,
        Some(instance) => {
            let stretch = instance.stretch();
            balls.map(|(p, radius)| (instance.to_scene.transform_point3(p), radius * stretch))
        }
    };
    placed.into_iter()
}

/// Balls that hold the curved surface of a triangle, roughly: around its vertices and around where
/// its edges' middles and its centroid are lifted to, as far as the vertices' tangent planes say.
fn balls(mesh: &Mesh, triangle: &[u32; 3]) -> [(Vec3, f32); 7] {
    let [a, b, c] = triangle.map(|v| mesh.positions()[v as usize]);
    let [na, nb, nc] = triangle.map(|v| mesh.normals()[v as usize]);
    // The edge of a patch on a sphere lies this much above its ends' tangent planes.
    let rise = |p: Vec3, n: Vec3, q: Vec3, m: Vec3| 0.5 * (n - m).dot(p - q);
    let middle = |p: Vec3, n: Vec3, q: Vec3, m: Vec3| {
        0.5 * (p + q) + rise(p, n, q, m) / 3.0 * (n + m).normalize_or_zero()
    };
    let rises = [rise(a, na, b, nb), rise(b, nb, c, nc), rise(c, nc, a, na)];
    let lift = 0.5 / 3.0 * (rises[0] + rises[1] + rises[2]);
    let centroid = (a + b + c) / 3.0 + lift * (na + nb + nc).normalize_or_zero();
    let radius = rises
        .iter()
        .map(|rise| 0.125 * rise.abs())
        .fold(0.0, f32::max);
    [
        a,
        b,
        c,
        middle(a, na, b, nb),
        middle(b, nb, c, nc),
        middle(c, nc, a, na),
        centroid,
    ]
    .map(|p| (p, radius))
}

/// Where points cast their shadows on the ground.
struct Shadows {
    up: Vec3,
    /// The ground's height along `up`.
    ground: f32,
    /// How far a shadow lies from the foot of what casts it, for each unit of height.
    slide: Vec3,
}

impl Shadows {
    fn of(&self, p: Vec3) -> Vec3 {
        p + (p.dot(self.up) - self.ground) * (self.slide - self.up)
    }
}

/// Where the four planes through the picture's edges touch something, in the camera's axes around a
/// centre: per picture axis the greatest of `position + slope * nearness` on either side.
#[derive(Clone, Copy)]
struct Wedges {
    slopes: [f64; 2],
    touching: [[f64; 2]; 2],
    nearest: f64,
}

impl Wedges {
    /// Around nothing.
    const NONE: Self = Self {
        slopes: [1.0; 2],
        touching: [[f64::NEG_INFINITY; 2]; 2],
        nearest: f64::NEG_INFINITY,
    };

    /// Around a ball as well.
    fn including(mut self, p: DVec3, radius: f64, axes: &Axes) -> Self {
        let near = -p.dot(axes.forward);
        for (n, axis) in [axes.right, axes.up].into_iter().enumerate() {
            let slope = self.slopes[n];
            let (at, reach) = (p.dot(axis), radius * slope.hypot(1.0));
            let [positive, negative] = &mut self.touching[n];
            *positive = positive.max(at + slope * near + reach);
            *negative = negative.max(-at + slope * near + reach);
        }
        self.nearest = self.nearest.max(near + radius);
        self
    }

    /// Around both, of the same slopes.
    fn union(self, other: Self) -> Self {
        let [a, b] = [self.touching, other.touching];
        Self {
            slopes: self.slopes,
            touching: [0, 1].map(|n| [0, 1].map(|side| a[n][side].max(b[n][side]))),
            nearest: self.nearest.max(other.nearest),
        }
    }

    /// The nearest place from which all is within the planes, this much further away: to the right,
    /// up and back.
    fn eye(&self, margin: f64) -> [f64; 3] {
        let [[right, left], [top, bottom]] = self.touching;
        let back = [
            (right + left) / self.slopes[0],
            (top + bottom) / self.slopes[1],
        ]
        .into_iter()
        .fold(self.nearest, |back, both| back.max(0.5 * both));
        [0.5 * (right - left), 0.5 * (top - bottom), margin * back]
    }
}

#[cfg(test)]
mod tests {
    use super::super::shape::Form;
    use super::*;

    fn scene(positions: Vec<DVec3>) -> Scene {
        let triangles = (2..positions.len() as u32).map(|i| [0, i - 1, i]).collect();
        let mesh = Mesh::new(positions, None, triangles).unwrap();
        Scene::new(&crate::linked::device().unwrap(), vec![mesh], Form::Flat).unwrap()
    }

    fn framing(up: UpAxis, aspect: f64) -> Framing {
        Framing {
            up,
            fov_degrees: Some(35.0),
            aspect,
            shadows_of: None,
        }
    }

    #[test]
    fn framed_vertices_are_in_the_picture_and_nearly_fill_it() {
        let offset = DVec3::new(3e5, 1.0, 2.0);
        let corners = [
            DVec3::ZERO,
            DVec3::new(9.0, 0.0, 1.0),
            DVec3::new(8.0, 3.0, 0.0),
        ];
        let scene = scene(corners.map(|p| p + offset).to_vec());
        for up in [UpAxis::Y, UpAxis::Z] {
            for size in [[300_usize, 100], [100, 300]] {
                let aspect = size[0] as f64 / size[1] as f64;
                for fov_degrees in [Some(35.0), None] {
                    let framing = Framing {
                        fov_degrees,
                        ..framing(up, aspect)
                    };
                    let camera = framing.camera(&scene);
                    let lens = camera.lens(scene.origin(), size[0], size[1]).unwrap();
                    let seen = scene.shapes()[0].mesh().positions().iter();
                    let seen: Vec<_> = seen.map(|&p| lens.seen_at(p).unwrap()).collect();
                    let shares = [0, 1].map(|axis| {
                        let of = |fold: fn(f32, f32) -> f32, start| {
                            seen.iter()
                                .map(|p| p[axis] / size[axis] as f32)
                                .fold(start, fold)
                        };
                        [of(f32::min, 1.0), of(f32::max, 0.0)]
                    });
                    assert!(
                        shares.iter().all(|[low, high]| *low > 0.0 && *high < 1.0),
                        "{shares:?}"
                    );
                    let fills = shares.iter().any(|[low, high]| high - low > 0.85);
                    assert!(fills, "{shares:?}");
                }
            }
        }
    }

    #[test]
    fn a_scene_of_one_point_is_looked_at_from_somewhere() {
        for fov_degrees in [Some(35.0), None] {
            let framing = Framing {
                fov_degrees,
                ..framing(UpAxis::Y, 1.0)
            };
            let camera = framing.camera(&scene(vec![DVec3::ONE; 3]));
            assert!(camera.lens(DVec3::ZERO, 9, 9).is_ok(), "{camera:?}");
        }
    }

    #[test]
    fn shadows_are_in_the_picture_too() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::new(0.0, 3.0, 0.0)];
        let scene = scene(corners.to_vec());
        let sun = Vec3::new(-1.0, 1.0, 1.0).normalize();
        // The top's shadow: three to the right, three to the back, on the ground.
        let shadow = Vec3::new(3.0, 0.0, -3.0);
        let framed = |shadows_of: Option<Vec3>| {
            let camera = Framing {
                shadows_of,
                ..framing(UpAxis::Y, 1.0)
            }
            .camera(&scene);
            let lens = camera.lens(scene.origin(), 100, 100).unwrap();
            let [x, y] = lens.seen_at(shadow).unwrap();
            (0.0..100.0).contains(&x) && (0.0..100.0).contains(&y)
        };
        assert!(framed(Some(sun)));
        assert!(
            !framed(None),
            "the test needs a shadow that leaves the picture"
        );
        // A sun at the horizon, or below it, still gives a picture.
        for low in [Vec3::X, Vec3::NEG_Y, Vec3::new(0.8, -0.6, 0.0)] {
            let camera = Framing {
                shadows_of: Some(low),
                ..framing(UpAxis::Y, 1.0)
            };
            assert!(camera.camera(&scene).eye.is_finite());
        }
    }
}
