//! Every hit along a ray, not the nearest alone.

use std::sync::Mutex;

use super::scene::Scene;
use crate::embree::{Candidate, Hit, QueryOptions, Ray, RayPacket, Traced, Width};

/// Patches reach over their edges by so many times a hit's error bound. What a ray hits there is on both
/// neighbours, which lie up to as far from each other where they meet at a hard edge.
const FRINGE: f32 = 4.0;
/// The least sine of the angle between a ray and the surface that the distance of two hits along the
/// ray is judged by.
const LEAST_SLOPE: f32 = 1e-3;

impl Scene {
    /// Finds every hit along the rays of a packet, in one walk through the tree: into `hits`, lane by
    /// lane, nearest first; an empty or untraceable lane has none. A rejecting filter makes the
    /// geometry offer them one by one.
    ///
    /// Neighbouring triangles overlap a little, so that no ray slips between them, and a ray through a
    /// shared edge hits both: two hits of different triangles that face the same way and whose t
    /// differ by no more than the [error bounds](Scene::error_bound) of both (and the overlap's width,
    /// some times that) allow count as one, the nearer. So from outside a closed body the hits are even
    /// in number and alternate front and back. Surfaces that lie upon each other, as close as that,
    /// count once for the same reason.
    ///
    /// # Panics
    /// If the scene was not made [for filters](Scene::with_filters).
    pub fn all_hits<const N: usize>(
        &self,
        packet: &RayPacket<N>,
        coherent: bool,
        hits: &mut [Vec<Hit>; N],
    ) where
        Width<N>: Traced,
    {
        let mut packet = packet.clone();
        packet.rays.id = std::array::from_fn(|lane| lane as u32);
        let found = std::mem::replace(hits, [const { Vec::new() }; N]).map(|mut hits| {
            hits.clear();
            Mutex::new(hits)
        });
        let record = |candidate: &Candidate| {
            let mut found = found[candidate.ray.id as usize]
                .lock()
                .expect("nothing panics with it");
            found.push(candidate.hit);
            false
        };
        let options = QueryOptions {
            coherent,
            filter: Some(&record),
        };
        self.tree().intersect(&mut packet, &options);
        *hits = found.map(|hits| hits.into_inner().expect("nothing panics with it"));
        for (lane, hits) in hits.iter_mut().enumerate() {
            self.sort_and_merge(&packet.ray(lane), hits);
        }
    }

    /// Every hit along one ray, as [`all_hits`](Self::all_hits).
    ///
    /// # Panics
    /// As [`all_hits`](Self::all_hits).
    pub fn all_hits1(&self, ray: &Ray) -> Vec<Hit> {
        let mut hits = [Vec::new()];
        self.all_hits(&RayPacket::<1>::from_rays([ray]), false, &mut hits);
        let [hits] = hits;
        hits
    }

    fn sort_and_merge(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        // By triangle where t is the same, so that the order does not depend on the tree.
        let place = |hit: &Hit| (self.placement_of(hit), hit.prim_id);
        hits.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then_with(|| place(a).cmp(&place(b))));
        let mut count = 0;
        for n in 0..hits.len() {
            let hit = hits[n];
            if !hits[..count].iter().any(|old| self.is_same(ray, old, &hit)) {
                hits[count] = hit;
                count += 1;
            }
        }
        hits.truncate(count);
    }

    /// Whether two hits of a ray are one point of the surface, seen by two triangles.
    fn is_same(&self, ray: &Ray, a: &Hit, b: &Hit) -> bool {
        let [slope_a, slope_b] = [a, b].map(|hit| self.normal(hit).dot(ray.direction));
        if (slope_a < 0.0) != (slope_b < 0.0) {
            return false;
        }
        let slope = slope_a.abs().min(slope_b.abs());
        let slope = slope.max(LEAST_SLOPE * ray.direction.length());
        let tolerance = FRINGE * (self.error_bound(a, ray) + self.error_bound(b, ray));
        (b.t - a.t).abs() * slope <= tolerance
    }
}
