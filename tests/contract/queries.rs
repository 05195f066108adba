//! What the contract's tests share: curved geometries, rays of all kinds, and packets of every width
//! set beside single rays.

use std::sync::{Arc, Mutex};

use curvetri::curved::{CurvedMesh, CurvedOptions, Primitives};
use curvetri::embree::{
    Candidate, Device, Filter, Geometry, GeometryBuilder, Hit, QueryOptions, Ray, RayPacket, Scene,
    SceneBuilder, Traced, Width,
};
use curvetri::method::{BoundsKind, Solver};
use glam::Vec3;

use curvetri_bodies::SplitMix;
use curvetri_test_support::Body;

/// Every surface as it is by default, the paper's own form, and the default with the paper's root
/// finder, or its bounds and primitives.
pub fn all_options() -> Vec<CurvedOptions> {
    let mut all = curvetri_test_support::all_forms();
    all.push(CurvedOptions {
        solver: Solver::ITA,
        ..CurvedOptions::default()
    });
    all.push(CurvedOptions {
        bounds: BoundsKind::Sphere,
        primitives: Primitives::Triangles,
        ..CurvedOptions::default()
    });
    all
}

pub fn geometry(device: &Device, body: &Body, options: &CurvedOptions) -> GeometryBuilder {
    let curved = CurvedMesh::new(body.mesh.clone(), options);
    Geometry::user(device, Arc::new(curved)).unwrap()
}

/// A scene of some geometries that takes query filters.
pub fn scene_of(device: &Device, geometries: impl IntoIterator<Item = GeometryBuilder>) -> Scene {
    let mut builder = SceneBuilder::new(device).unwrap().query_filters(true);
    for geometry in geometries {
        builder.attach(&geometry.commit().unwrap());
    }
    builder.commit().unwrap()
}

/// A scene of one body.
pub fn scene(body: &Body, options: &CurvedOptions) -> Scene {
    let device = curvetri::linked::device().unwrap();
    scene_of(&device, [geometry(&device, body, options)])
}

/// The bodies that show the most for their size: coarse and round, with hard rims, irregular.
pub fn few_bodies() -> Vec<Body> {
    let wanted = [
        "sphere of 4 triangles",
        "torus",
        "capped cylinder",
        "blob with a rim",
    ];
    let mut bodies = curvetri_test_support::made_bodies();
    bodies.retain(|body| wanted.contains(&body.name.as_str()));
    assert_eq!(bodies.len(), wanted.len());
    bodies
}

/// Rays towards somewhere within the bounds of a scene, from outside and from within, with directions of
/// all lengths, some from further along and some cut short there.
pub fn rays(scene: &Scene, count: usize, seed: u64) -> Vec<Ray> {
    let mut random = SplitMix::new(seed);
    let bounds = scene.bounds();
    let centre = (bounds.lower + bounds.upper) * 0.5;
    let half = (bounds.upper - bounds.lower) * 0.5;
    let ray = |n| {
        let target = centre + half * random.in_cube();
        let origin = match n % 4 {
            0 => centre + half * random.in_cube(),
            _ => target - random.direction() * (half.length() * 3.0),
        };
        let length = (4.0 * random.unit_f32() - 2.0).exp2();
        let ray = Ray::new(origin, (target - origin) * length);
        match n % 8 {
            3 => ray.between(1.0 / length, f32::INFINITY),
            5 => ray.between(0.0, 1.0 / length),
            _ => ray,
        }
    };
    (0..count).map(ray).collect()
}

/// What a scene says of rays: their nearest hits, and which are occluded.
#[derive(Clone, PartialEq)]
pub struct Said {
    pub hits: Vec<Option<Hit>>,
    pub occluded: Vec<bool>,
}

/// Asks ray by ray.
pub fn singly(scene: &Scene, rays: &[Ray], filter: Option<&Filter<'_>>) -> Said {
    let options = QueryOptions {
        coherent: false,
        filter,
    };
    Said {
        hits: rays
            .iter()
            .map(|ray| scene.intersect1(ray, &options))
            .collect(),
        occluded: rays
            .iter()
            .map(|ray| scene.occluded1(ray, &options))
            .collect(),
    }
}

/// Asks by packets of N: each once for some of its lanes, any number of them, and once for the others.
pub fn by_packets<const N: usize>(scene: &Scene, rays: &[Ray], options: &QueryOptions<'_>) -> Said
where
    Width<N>: Traced,
{
    let mut said = Said {
        hits: vec![None; rays.len()],
        occluded: vec![false; rays.len()],
    };
    for (n, chunk) in rays.chunks(N).enumerate() {
        let some = (n as u32).wrapping_mul(0x9e37_79b9) >> 7;
        for lanes in [some, !some] {
            let mut packet = RayPacket::<N>::from_rays(chunk);
            packet.set_active(packet.active() & lanes);
            let (active, mut shadows) = (packet.active(), packet.clone());
            scene.intersect(&mut packet, options);
            let occluded = scene.occluded(&mut shadows, options);
            assert_eq!(occluded & !active, 0, "a lane that is not traced");
            for (lane, ray) in chunk.iter().enumerate() {
                if active & 1 << lane != 0 {
                    said.hits[n * N + lane] = packet.hit(lane);
                    said.occluded[n * N + lane] = occluded & 1 << lane != 0;
                } else {
                    assert_eq!(packet.hit(lane), None);
                    assert_eq!((packet.ray(lane), shadows.ray(lane)), (*ray, *ray));
                }
            }
        }
    }
    said
}

/// What packets of every width say, coherent and not, with what they are.
pub fn by_all_packets(
    scene: &Scene,
    rays: &[Ray],
    filter: Option<&Filter<'_>>,
) -> Vec<(String, Said)> {
    let mut all = Vec::new();
    for coherent in [false, true] {
        let options = QueryOptions { coherent, filter };
        let said = [
            (1, by_packets::<1>(scene, rays, &options)),
            (4, by_packets::<4>(scene, rays, &options)),
            (8, by_packets::<8>(scene, rays, &options)),
            (16, by_packets::<16>(scene, rays, &options)),
        ];
        all.extend(said.map(|(n, said)| (format!("packets of {n}, coherent: {coherent}"), said)));
    }
    all
}

/// How often two ways of asking about the same rays gave different bits.
#[derive(Default)]
pub struct Agreement {
    rays: usize,
    ties: usize,
}

impl Agreement {
    /// Sets another answer beside single rays': the same bit for bit, but for ties, where t is within 4
    /// units in the last place.
    pub fn compare(&mut self, single: &Said, other: &Said, what: &str) {
        assert!(single.occluded == other.occluded, "{what}: occluded");
        self.rays += single.hits.len();
        for (a, b) in single.hits.iter().zip(&other.hits) {
            if a.as_ref().map(bits) == b.as_ref().map(bits) {
                continue;
            }
            let close = match (a, b) {
                (Some(a), Some(b)) => (a.t - b.t).abs() <= 4.0 * f32::EPSILON * a.t.abs(),
                _ => false,
            };
            assert!(close, "{what}: {a:?}, but {b:?}");
            self.ties += 1;
        }
    }

    /// Demands that there were ties in at most 1e-5 of all the rays.
    pub fn assert_ties_are_rare(&self) {
        let Self { rays, ties } = *self;
        assert!(rays > 0);
        assert!(ties as f64 <= 1e-5 * rays as f64, "{ties} ties of {rays}");
    }
}

impl Said {
    /// How many rays hit something.
    pub fn met(&self) -> usize {
        self.hits.iter().flatten().count()
    }
}

/// All that a hit is, bit by bit.
fn bits(hit: &Hit) -> ([u32; 6], [u32; 3], usize) {
    let Vec3 { x, y, z } = hit.ng;
    let numbers = [hit.t, hit.u, hit.v, x, y, z].map(f32::to_bits);
    let instances = hit.inst_id.len();
    (
        numbers,
        [hit.prim_id, hit.geom_id, hit.inst_id[0]],
        instances,
    )
}

/// Every hit that is offered along a ray, nearest first, and the lesser numbers where t is the same.
pub fn offered(scene: &Scene, ray: &Ray) -> Vec<Candidate> {
    let found = Mutex::new(Vec::new());
    let record = |candidate: &Candidate| {
        found.lock().unwrap().push(*candidate);
        false
    };
    let options = QueryOptions::default().with_filter(&record);
    assert_eq!(scene.intersect1(ray, &options), None, "all are rejected");
    let mut found = found.into_inner().unwrap();
    let numbers = |hit: &Hit| (hit.inst_id, hit.geom_id, hit.prim_id);
    found.sort_by(|Candidate { hit: a, .. }, Candidate { hit: b, .. }| {
        a.t.total_cmp(&b.t)
            .then_with(|| numbers(a).cmp(&numbers(b)))
    });
    found
}
