//! The rays that are traced: the same for all forms.

use glam::Vec3;

use curvetri::curved::CurvedMesh;
use curvetri::embree::{QueryOptions, Ray, RayPacket, Scene};
use curvetri_bodies::SplitMix;

/// What rays are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RayKind {
    /// From a camera, in tiles of 4 by 4 pixels.
    Primary,
    /// From what the camera sees, one a pixel in the pixels' order, cosine-distributed.
    Bounce,
    /// From what the camera sees to a distant light, in the pixels' order: whether anything is hit.
    Shadow,
    /// Like bounces, a fifth of the mesh's diagonal long: whether anything is hit.
    AmbientOcclusion,
    /// From random triangles of the whole surface, cosine-distributed, in no order.
    Diffuse,
    /// From a sphere around the mesh towards points of its box, in no order.
    Random,
}

impl RayKind {
    /// All kinds.
    pub const ALL: [Self; 6] = [
        Self::Primary,
        Self::Bounce,
        Self::Shadow,
        Self::AmbientOcclusion,
        Self::Diffuse,
        Self::Random,
    ];

    /// As it appears in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Bounce => "bounce",
            Self::Shadow => "shadow",
            Self::AmbientOcclusion => "ambient-occlusion",
            Self::Diffuse => "diffuse",
            Self::Random => "random",
        }
    }

    /// Whether only occlusion is traced: if anything is hit.
    #[must_use]
    pub fn is_occlusion(self) -> bool {
        matches!(self, Self::Shadow | Self::AmbientOcclusion)
    }
}

/// Pixels a side of the picture that primary rays are of.
const SIDE: usize = 1024;
/// Pixels a side of the blocks that are traced of it ...
const BLOCK: usize = 32;
/// ... and of those of few rays, which would see little of the picture in large ones.
const SMALL_BLOCK: usize = 8;
/// How many blocks are to show the picture.
const ENOUGH_BLOCKS: usize = 64;
/// Pixels a side of the tiles that make a packet.
const TILE: usize = 4;
/// Rays a side of the picture by which the camera finds the mesh.
const PROBES: usize = 64;
/// The least share of primary rays that are to hit.
const LEAST_HITS: f64 = 0.7;
/// Length of ambient occlusion rays over the mesh's diagonal.
const NEAR: f32 = 0.2;
/// How far off the surface secondary rays start: over their triangle's longest edge, ...
const OFF_SIDE: f32 = 0.02;
/// ... and over the height of the curved surface there, so that they leave all forms.
const OFF_HEIGHT: f32 = 1.5;
/// Where the camera is, as seen from the mesh.
const VIEW: Vec3 = Vec3::new(0.5, -0.7, 0.55);
/// Where the light is.
const LIGHT: Vec3 = Vec3::new(0.9, -0.1, 0.6);

/// Makes rays for the curved form of a mesh.
pub(super) struct RayMaker<'a> {
    scene: &'a Scene,
    curved: &'a CurvedMesh,
    /// About how many rays of a kind.
    count: usize,
    random: SplitMix,
}

/// Where a secondary ray may start.
struct Start {
    point: Vec3,
    normal: Vec3,
}

impl<'a> RayMaker<'a> {
    pub fn new(scene: &'a Scene, curved: &'a CurvedMesh, count: usize) -> Self {
        Self {
            scene,
            curved,
            count,
            random: SplitMix::new(7),
        }
    }

    /// The rays of each kind, in the order of [`RayKind::ALL`].
    pub fn make(&mut self) -> Vec<Vec<Ray>> {
        let primary = self.primary();
        let seen = self.seen(&primary);
        let diagonal = self.diagonal();
        let bounce: Vec<Ray> = seen.iter().map(|start| self.scattered(start)).collect();
        let light = LIGHT.normalize();
        let facing = seen.iter().filter(|start| start.normal.dot(light) > 0.0);
        let shadow = facing.map(|start| Ray::new(start.point, light)).collect();
        let near = seen.iter().map(|start| self.scattered(start));
        let near = near.map(|ray| ray.between(0.0, NEAR * diagonal)).collect();
        let diffuse = self.diffuse();
        vec![primary, bounce, shadow, near, diffuse, self.random_rays()]
    }

    fn centre(&self) -> Vec3 {
        let bounds = self.scene.bounds();
        0.5 * (bounds.lower + bounds.upper)
    }

    fn diagonal(&self) -> f32 {
        let bounds = self.scene.bounds();
        (bounds.upper - bounds.lower).length()
    }

    /// Camera rays of as many blocks of the picture as are wanted, spread over it.
    fn primary(&self) -> Vec<Ray> {
        let camera = self.camera();
        let side = if self.count < ENOUGH_BLOCKS * BLOCK * BLOCK {
            SMALL_BLOCK
        } else {
            BLOCK
        };
        let blocks = SIDE / side;
        let wanted = (self.count / (side * side)).clamp(1, blocks * blocks);
        let mut rays = Vec::with_capacity(wanted * side * side);
        for n in 0..wanted {
            // a low-discrepancy choice of blocks, in rising order; of few none in a corner
            let block = (2 * n + 1) * blocks * blocks / (2 * wanted);
            let row = block / blocks;
            let column = (block % blocks + row * 13) % blocks;
            let tiles = side / TILE;
            for pixel in 0..side * side {
                let (tile, within) = (pixel / (TILE * TILE), pixel % (TILE * TILE));
                let x = column * side + tile % tiles * TILE + within % TILE;
                let y = row * side + tile / tiles * TILE + within / TILE;
                let at = |n: usize| 2.0 * (n as f32 + 0.5) / SIDE as f32 - 1.0;
                rays.push(camera.ray(at(x), at(y)));
            }
        }
        rays
    }

    /// A camera that sees as much of the mesh as it can while most rays hit.
    fn camera(&self) -> PrimaryCamera {
        let (centre, diagonal) = (self.centre(), self.diagonal());
        let eye = centre + 2.0 * diagonal * VIEW.normalize();
        let whole = PrimaryCamera::new(eye, centre, 0.25);
        let hits = |column: usize, row: usize| {
            let at = |n: usize| 2.0 * (n as f32 + 0.5) / PROBES as f32 - 1.0;
            let ray = whole.ray(at(column), at(row));
            let hit = self.scene.intersect1(&ray, &QueryOptions::default());
            hit.is_some()
        };
        let window = largest_window(hits).unwrap_or(ProbeWindow {
            corner: [0, 0],
            side: PROBES,
        });
        let share = window.side as f32 / PROBES as f32;
        let middle = |n: usize| 2.0 * n as f32 / PROBES as f32 + share - 1.0;
        let target = whole.ray(middle(window.corner[0]), middle(window.corner[1]));
        PrimaryCamera::new(eye, target.at(1.0), share * whole.reach)
    }

    /// Where primary rays hit, in their order.
    fn seen(&self, rays: &[Ray]) -> Vec<Start> {
        let mut seen = Vec::new();
        for rays in rays.chunks(16) {
            let mut packet = RayPacket::<16>::from_rays(rays);
            self.scene.intersect(&mut packet, &QueryOptions::COHERENT);
            for (lane, ray) in rays.iter().enumerate() {
                let Some(hit) = packet.hit(lane) else {
                    continue;
                };
                let normal = hit.ng.normalize_or(-ray.direction);
                let towards = if normal.dot(ray.direction) > 0.0 {
                    -normal
                } else {
                    normal
                };
                seen.push(self.start(hit.prim_id, ray.at(hit.t), towards));
            }
        }
        seen
    }

    fn start(&self, triangle: u32, point: Vec3, normal: Vec3) -> Start {
        let [a, b, c] = self.curved.mesh().triangle_positions(triangle as usize);
        let plane = (b - a).cross(c - a).normalize_or_zero();
        let height = (point - a).dot(plane).abs();
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        Start {
            point: point + normal * (OFF_HEIGHT * height + OFF_SIDE * longest),
            normal,
        }
    }

    /// A ray in a cosine-distributed direction.
    fn scattered(&mut self, start: &Start) -> Ray {
        let aside = self.random.direction();
        let direction = (start.normal + 0.999 * aside).normalize_or(start.normal);
        Ray::new(start.point, direction)
    }

    fn diffuse(&mut self) -> Vec<Ray> {
        let triangles = self.curved.mesh().triangles().len();
        let mut rays = Vec::with_capacity(self.count);
        for _ in 0..self.count {
            let triangle = self.random.below(triangles) as u32;
            let [_, u, v] = self.random.barycentric();
            let point = self.curved.patch(triangle).point(u, v);
            let (position, normal) = (Vec3::from(point.position), Vec3::from(point.normal));
            if position.is_finite() && normal.is_finite() {
                let start = self.start(triangle, position, normal);
                rays.push(self.scattered(&start));
            }
        }
        rays
    }

    fn random_rays(&mut self) -> Vec<Ray> {
        let (bounds, centre) = (self.scene.bounds(), self.centre());
        let count = self.count;
        let radius = 0.75 * self.diagonal();
        let mut ray = || {
            let origin = centre + radius * self.random.direction();
            let share = Vec3::from_array([(); 3].map(|()| self.random.unit_f32()));
            let target = bounds.lower + share * (bounds.upper - bounds.lower);
            Ray::new(origin, (target - origin).normalize_or(Vec3::Z))
        };
        (0..count).map(|_| ray()).collect()
    }
}

/// A square of the probes.
struct ProbeWindow {
    /// Column and row of its first probe.
    corner: [usize; 2],
    side: usize,
}

/// The largest square of which [`LEAST_HITS`] hit, of those of one size the one that hits most.
fn largest_window(hits: impl Fn(usize, usize) -> bool) -> Option<ProbeWindow> {
    // how many hit in the rows and columns before
    let mut before = vec![[0_u32; PROBES + 1]; PROBES + 1];
    for row in 0..PROBES {
        for column in 0..PROBES {
            before[row + 1][column + 1] = before[row][column + 1] + before[row + 1][column]
                - before[row][column]
                + u32::from(hits(column, row));
        }
    }
    let count = |[x, y]: [usize; 2], side: usize| {
        before[y + side][x + side] + before[y][x] - before[y][x + side] - before[y + side][x]
    };
    (1..=PROBES).rev().find_map(|side| {
        let places = 0..=PROBES - side;
        let corners = places
            .clone()
            .flat_map(|y| places.clone().map(move |x| [x, y]));
        let corner = corners.max_by_key(|corner| count(*corner, side))?;
        let enough = f64::from(count(corner, side)) >= LEAST_HITS * (side * side) as f64;
        enough.then_some(ProbeWindow { corner, side })
    })
}

struct PrimaryCamera {
    eye: Vec3,
    forward: Vec3,
    right: Vec3,
    up: Vec3,
    /// Tangent of half the angle of view.
    reach: f32,
}

impl PrimaryCamera {
    fn new(eye: Vec3, target: Vec3, reach: f32) -> Self {
        let forward = (target - eye).normalize();
        let right = forward.cross(Vec3::Z).normalize_or(Vec3::X);
        Self {
            eye,
            forward,
            right,
            up: right.cross(forward),
            reach,
        }
    }

    /// The ray through a place of the picture, -1 to 1.
    fn ray(&self, x: f32, y: f32) -> Ray {
        let aside = x * self.right - y * self.up;
        Ray::new(self.eye, (self.forward + self.reach * aside).normalize())
    }
}
