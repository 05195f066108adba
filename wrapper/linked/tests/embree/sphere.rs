//! Spheres as a user geometry, and where rays hit them by another way.

use std::sync::Arc;

use curvetri_bodies::SplitMix;
use glam::Vec3;

use curvetri_embree::*;
pub use curvetri_embree_linked as linked;

/// One primitive a sphere.
pub struct Spheres(pub Vec<(Vec3, f32)>);

impl Spheres {
    /// The t of both points where a ray's line meets a sphere, in order.
    pub fn roots(&self, prim: u32, ray: &Ray) -> Option<[f32; 2]> {
        let (center, radius) = self.0[prim as usize];
        let origin = (ray.origin - center).as_dvec3();
        let direction = ray.direction.as_dvec3();
        let (a, b) = (direction.length_squared(), origin.dot(direction));
        let c = origin.length_squared() - f64::from(radius).powi(2);
        let root = (b * b - a * c).sqrt();
        (root >= 0.0).then(|| [((-b - root) / a) as f32, ((-b + root) / a) as f32])
    }

    pub fn surface_hit(&self, prim: u32, ray: &Ray, t: f32, root: usize) -> SurfaceHit {
        let ng = ray.at(t) - self.0[prim as usize].0;
        SurfaceHit {
            t,
            u: root as f32,
            v: 0.25,
            ng,
        }
    }

    /// The nearest hit of all spheres: t, primitive.
    pub fn nearest(&self, ray: &Ray) -> Option<(f32, u32)> {
        (0..self.primitives())
            .filter_map(|prim| self.roots(prim, ray).map(|roots| (prim, roots)))
            .flat_map(|(prim, roots)| roots.map(|t| (t, prim)))
            .filter(|(t, _)| *t >= ray.tnear && *t <= ray.tfar)
            .min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

impl UserGeometry for Spheres {
    fn primitives(&self) -> u32 {
        self.0.len() as u32
    }

    fn bounds(&self, prim: u32, time_step: u32) -> Bounds {
        assert_eq!(time_step, 0);
        let (center, radius) = self.0[prim as usize];
        let half = Vec3::splat(radius * 1.0001);
        Bounds {
            lower: center - half,
            upper: center + half,
        }
    }

    fn intersect(&self, query: &mut IntersectQuery<'_>) {
        for lane in query.lanes() {
            let (prim, ray) = (query.prim_id(), query.ray(lane));
            for (root, t) in self.roots(prim, &ray).into_iter().flatten().enumerate() {
                if query.report(lane, self.surface_hit(prim, &ray, t, root)) {
                    break;
                }
            }
        }
    }

    fn occluded(&self, query: &mut OccludedQuery<'_>) {
        for lane in query.lanes() {
            let (prim, ray) = (query.prim_id(), query.ray(lane));
            for (root, t) in self.roots(prim, &ray).into_iter().flatten().enumerate() {
                if query.report(lane, self.surface_hit(prim, &ray, t, root)) {
                    break;
                }
            }
        }
    }
}

/// Many small spheres in the unit cube.
pub fn many(count: usize, seed: u64) -> Arc<Spheres> {
    let mut random = SplitMix::new(seed);
    let spheres = (0..count).map(|_| {
        let center = 0.5 + 0.5 * random.in_cube();
        (center, random.between(0.01, 0.1) as f32)
    });
    Arc::new(Spheres(spheres.collect()))
}

/// Rays of any length that start in or around the unit cube.
pub fn random_rays(count: usize, seed: u64) -> Vec<Ray> {
    let mut random = SplitMix::new(seed);
    let rays = (0..count).map(|_| {
        let origin = 0.5 + 1.5 * random.in_cube();
        let target = 0.5 + 0.5 * random.in_cube();
        Ray::new(origin, (target - origin) * random.between(0.1, 10.0) as f32)
    });
    rays.collect()
}

/// A scene of one geometry.
pub fn scene_of(device: &Device, geometry: GeometryBuilder) -> Scene {
    let mut builder = SceneBuilder::new(device).unwrap();
    assert_eq!(builder.attach(&geometry.commit().unwrap()), 0);
    builder.commit().unwrap()
}

pub fn sphere_scene(device: &Device, spheres: Arc<Spheres>) -> Scene {
    scene_of(device, Geometry::user(device, spheres).unwrap())
}

/// Traces rays in packets of N.
pub fn hits<const N: usize>(
    scene: &Scene,
    rays: &[Ray],
    options: &QueryOptions<'_>,
) -> Vec<Option<Hit>>
where
    Width<N>: Traced,
{
    let mut hits = Vec::new();
    for chunk in rays.chunks(N) {
        let mut packet = RayPacket::<N>::from_rays(chunk);
        scene.intersect(&mut packet, options);
        hits.extend((0..chunk.len()).map(|lane| packet.hit(lane)));
    }
    hits
}

/// Traces rays for occlusion in packets of N.
pub fn shadows<const N: usize>(scene: &Scene, rays: &[Ray], options: &QueryOptions<'_>) -> Vec<bool>
where
    Width<N>: Traced,
{
    let mut shadows = Vec::new();
    for chunk in rays.chunks(N) {
        let mut packet = RayPacket::<N>::from_rays(chunk);
        let occluded = scene.occluded(&mut packet, options);
        shadows.extend((0..chunk.len()).map(|lane| occluded & 1 << lane != 0));
    }
    shadows
}
