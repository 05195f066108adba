//! `curvetri trace --all-hits` and `--occluded`.

use std::fs::File;

use crate::program::Workshop;
use curvetri_bodies::SplitMix;
use npyz::npz::NpzArchive;
use npyz::{Deserialize, WriterBuilder};

const NO_PRIMITIVE: u32 = u32::MAX;

/// Rays from all around that pass by or through the unit sphere.
fn rays() -> Vec<[f32; 6]> {
    let mut random = SplitMix::new(3);
    let ray = |_| {
        let mut ray: [f32; 6] = std::array::from_fn(|_| random.between(-1.2, 1.2) as f32);
        (0..3).for_each(|k| {
            ray[k] = 4.0 * ray[k].signum() + ray[k];
            ray[3 + k] -= ray[k];
        });
        ray
    };
    (0..1000).map(ray).collect()
}

fn save(shop: &Workshop, rays: &[[f32; 6]]) -> String {
    let path = shop.path("rays.npy");
    let options = npyz::WriteOptions::new()
        .default_dtype()
        .shape(&[rays.len() as u64, 6]);
    let file = File::create(&path).unwrap();
    let mut writer = options.writer(file).begin_nd().unwrap();
    writer.extend(rays.as_flattened().iter().copied()).unwrap();
    writer.finish().unwrap();
    path
}

/// What a file of hits holds, with its arrays' names and shapes.
struct Hits(NpzArchive<std::io::BufReader<File>>);

impl Hits {
    fn trace(shop: &Workshop, mesh: &str, rays: &str, more: &[&str]) -> Self {
        let hits = shop.path("hits.npz");
        shop.succeeds(&[&["trace", mesh, "--rays", rays, "-o", &hits], more].concat());
        Self(NpzArchive::open(hits).unwrap())
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = self.0.array_names().map(str::to_owned).collect();
        names.sort();
        names
    }

    fn array<T: Deserialize>(&mut self, name: &str, shape: &[u64]) -> Vec<T> {
        let npy = self.0.by_name(name).unwrap().unwrap();
        assert_eq!(npy.shape(), shape, "{name}");
        npy.into_vec().unwrap()
    }
}

#[test]
fn all_hits_of_a_ball_are_where_rays_enter_and_leave_it() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let rays = rays();
    let file = save(&shop, &rays);
    let n = rays.len() as u64;
    let mut nearest = Hits::trace(&shop, &mesh, &file, &[]);
    let nearest: Vec<f32> = nearest.array("t", &[n]);
    for packet in ["1", "4", "8", "16"] {
        let mut hits = Hits::trace(
            &shop,
            &mesh,
            &file,
            &["--all-hits", "3", "--packet", packet],
        );
        assert_eq!(hits.names(), ["count", "ng", "prim_id", "t", "uv"]);
        let count: Vec<u32> = hits.array("count", &[n]);
        let t: Vec<f32> = hits.array("t", &[n, 3]);
        let prim_id: Vec<u32> = hits.array("prim_id", &[n, 3]);
        let uv: Vec<f32> = hits.array("uv", &[n, 3, 2]);
        let ng: Vec<f32> = hits.array("ng", &[n, 3, 3]);
        let mut met = 0;
        for (i, ray) in rays.iter().enumerate() {
            let (t, prim_id) = (&t[3 * i..][..3], &prim_id[3 * i..][..3]);
            assert_eq!(t[0], nearest[i]);
            let found = count[i] as usize;
            assert!([0, 2].contains(&found), "{found} hits");
            assert!(t[..found].iter().all(|t| t.is_finite()) && t[..found].is_sorted());
            assert_eq!(&t[found..], &[f32::INFINITY; 3][found..]);
            assert_eq!(&prim_id[found..], &[NO_PRIMITIVE; 3][found..]);
            assert_eq!(&uv[6 * i..][2 * found..6], &[0.0; 6][2 * found..]);
            assert_eq!(&ng[9 * i..][3 * found..9], &[0.0; 9][3 * found..]);
            // The normals of a ball are its points, and point in and then out along the ray.
            for (n, t) in t[..found].iter().enumerate() {
                let ng = &ng[9 * i + 3 * n..][..3];
                let point: Vec<f32> = (0..3).map(|k| ray[k] + t * ray[3 + k]).collect();
                for (x, y) in point.iter().zip(ng) {
                    assert!((x - y).abs() < 1e-3, "{point:?}, {ng:?}");
                }
                let along: f32 = ng.iter().zip(&ray[3..]).map(|(x, y)| x * y).sum();
                assert_eq!(along < 0.0, n == 0);
                met += 1;
            }
        }
        assert!(met > 500);
    }
}

#[test]
fn more_hits_than_are_kept_are_counted() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let file = save(&shop, &[[0.1, 0.2, 5.0, 0.0, 0.0, -1.0]]);
    for surface in ["flat", "smooth"] {
        let more = ["--all-hits", "1", "--surface", surface];
        let mut hits = Hits::trace(&shop, &mesh, &file, &more);
        assert_eq!(hits.array::<u32>("count", &[1]), [2]);
        assert!(hits.array::<f32>("t", &[1, 1])[0] < 5.0);
        assert!(hits.array::<f32>("ng", &[1, 1, 3])[2] > 0.0);
    }
}

#[test]
fn occluded_rays_are_those_that_hit() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let rays = rays();
    let file = save(&shop, &rays);
    let n = rays.len() as u64;
    for surface in ["flat", "angular", "smooth"] {
        let mut hits = Hits::trace(&shop, &mesh, &file, &["--surface", surface]);
        let t: Vec<f32> = hits.array("t", &[n]);
        let hit: Vec<bool> = t.iter().map(|t| t.is_finite()).collect();
        assert!(hit.contains(&true) && hit.contains(&false));
        for packet in ["1", "4", "8", "16"] {
            let more = ["--occluded", "--packet", packet, "--surface", surface];
            let mut occluded = Hits::trace(&shop, &mesh, &file, &more);
            assert_eq!(occluded.names(), ["occluded"]);
            assert_eq!(occluded.array::<bool>("occluded", &[n]), hit, "{packet}");
        }
    }
}

#[test]
fn no_rays_have_no_hits() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let file = save(&shop, &[]);
    let mut hits = Hits::trace(&shop, &mesh, &file, &["--all-hits", "4"]);
    assert!(hits.array::<f32>("uv", &[0, 4, 2]).is_empty());
    assert!(hits.array::<u32>("count", &[0]).is_empty());
    let mut hits = Hits::trace(&shop, &mesh, &file, &["--occluded"]);
    assert!(hits.array::<bool>("occluded", &[0]).is_empty());
}

#[test]
fn what_cannot_be_asked_for_is_a_mistake_of_usage() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let (rays, hits) = (save(&shop, &rays()), shop.path("hits.npz"));
    let says = |more: &[&str]| {
        let said = shop.fails(
            2,
            &[&["trace", &mesh, "--rays", &rays, "-o", &hits], more].concat(),
        );
        assert!(!shop.names().contains(&"hits.npz".to_owned()));
        said
    };
    let both = says(&["--all-hits", "4", "--occluded"]);
    assert!(
        both.contains("--all-hits") && both.contains("--occluded"),
        "{both}"
    );
    for wrong in ["0", "-1", "65537", "1.5", "all"] {
        let said = says(&[&format!("--all-hits={wrong}")]);
        assert!(said.contains("1 to 65536 hits"), "{said}");
    }
    assert!(says(&["--all-hits"]).contains("--all-hits"));
    assert!(says(&["--packet", "2"]).contains("16"));
}
