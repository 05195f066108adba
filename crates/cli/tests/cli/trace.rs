//! `curvetri trace` as a whole program.

use std::fs::File;

use crate::program::{Workshop, stderr};
use curvetri_bodies::SplitMix;
use npyz::npz::NpzArchive;
use npyz::{AutoSerialize, Deserialize, Order, WriterBuilder};

const NO_PRIMITIVE: u32 = 4_294_967_295;

/// What a hits file holds.
#[derive(Debug, PartialEq)]
struct Hits {
    /// Single precision where the rays are.
    t: Vec<f64>,
    prim_id: Vec<u32>,
    uv: Vec<f32>,
    ng: Vec<f32>,
}

/// Writes an array as numpy does.
fn save<T: AutoSerialize + Copy>(
    shop: &Workshop,
    name: &str,
    shape: &[u64],
    order: Order,
    values: &[T],
) -> String {
    let path = shop.path(name);
    let file = File::create(&path).unwrap();
    let options = npyz::WriteOptions::new()
        .default_dtype()
        .shape(shape)
        .order(order);
    let mut writer = options.writer(file).begin_nd().unwrap();
    writer.extend(values.iter().copied()).unwrap();
    writer.finish().unwrap();
    path
}

fn save_rays(shop: &Workshop, name: &str, rays: &[[f64; 6]]) -> String {
    save(
        shop,
        name,
        &[rays.len() as u64, 6],
        Order::C,
        rays.as_flattened(),
    )
}

fn load(path: &str) -> Hits {
    fn array<T: Deserialize>(
        npz: &mut NpzArchive<impl std::io::Read + std::io::Seek>,
        name: &str,
        columns: &[u64],
    ) -> Vec<T> {
        let npy = npz.by_name(name).unwrap().unwrap();
        assert_eq!(&npy.shape()[1..], columns, "{name}");
        npy.into_vec().unwrap()
    }
    let mut npz = NpzArchive::open(path).unwrap();
    let dtype = npz.by_name("t").unwrap().unwrap().dtype().descr();
    let single = dtype.contains("f4");
    Hits {
        t: if single {
            let t: Vec<f32> = array(&mut npz, "t", &[]);
            t.into_iter().map(f64::from).collect()
        } else {
            array(&mut npz, "t", &[])
        },
        prim_id: array(&mut npz, "prim_id", &[]),
        uv: array(&mut npz, "uv", &[2]),
        ng: array(&mut npz, "ng", &[3]),
    }
}

/// Traces rays and reads their hits.
fn trace(shop: &Workshop, mesh: &str, rays: &str, more: &[&str]) -> Hits {
    let hits = shop.path("hits.npz");
    shop.succeeds(&[&["trace", mesh, "--rays", rays, "-o", &hits], more].concat());
    load(&hits)
}

/// Rays from all around towards somewhere near the unit sphere, of all lengths.
fn random_rays(count: usize) -> Vec<[f64; 6]> {
    let mut random = SplitMix::new(7);
    let mut cube = |side: f64| [0; 3].map(|_| random.between(-side, side));
    let mut rays = Vec::new();
    while rays.len() < count {
        let (origin, target, [length, ..]) = (cube(6.0), cube(1.2), cube(2.0));
        let d: Vec<f64> = (0..3)
            .map(|i| (target[i] - origin[i]) * length.exp2())
            .collect();
        if origin.iter().map(|x| x * x).sum::<f64>() > 2.0 {
            rays.push([origin[0], origin[1], origin[2], d[0], d[1], d[2]]);
        }
    }
    rays
}

/// Where a ray meets the unit sphere first.
fn sphere_hit(ray: &[f64; 6]) -> Option<f64> {
    let (o, d) = ray.split_at(3);
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (a, b, c) = (dot(d, d), dot(o, d), dot(o, o) - 1.0);
    let root = (b * b - a * c).sqrt();
    (root > 0.0).then(|| (-b - root) / a).filter(|t| *t > 0.0)
}

#[test]
fn hits_are_those_of_the_sphere() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let rays = random_rays(2000);
    let hits = trace(&shop, &mesh, &save_rays(&shop, "rays.npy", &rays), &[]);
    assert_eq!(hits.t.len(), rays.len());
    let mut compared = 0;
    for (i, ray) in rays.iter().enumerate() {
        let (t, ng) = (hits.t[i], &hits.ng[3 * i..3 * i + 3]);
        let expected = sphere_hit(ray);
        // At the very rim rounding decides.
        if expected.is_some() != t.is_finite() {
            let nearest = nearest_to_centre(ray);
            assert!(
                (nearest - 1.0).abs() < 1e-4,
                "ray {i} passes at {nearest} and has t {t}"
            );
            continue;
        }
        let Some(expected) = expected else {
            assert_eq!((hits.t[i], hits.prim_id[i]), (f64::INFINITY, NO_PRIMITIVE));
            assert_eq!(
                (ng, &hits.uv[2 * i..2 * i + 2]),
                (&[0.0; 3][..], &[0.0; 2][..])
            );
            continue;
        };
        compared += 1;
        assert!(hits.prim_id[i] < 4);
        let uv = [hits.uv[2 * i], hits.uv[2 * i + 1]];
        assert!(uv.iter().all(|b| (-1e-4..=1.0001).contains(b)), "{uv:?}");
        let point: Vec<f64> = (0..3).map(|k| ray[k] + t * ray[3 + k]).collect();
        let off = point.iter().map(|x| x * x).sum::<f64>().sqrt() - 1.0;
        assert!(off.abs() < 1e-5, "ray {i} hits {off} off the sphere");
        if nearest_to_centre(ray) < 0.99 {
            assert!(
                (t / expected - 1.0).abs() < 1e-4,
                "ray {i}: {t}, not {expected}"
            );
        }
        let cosine: f64 = (0..3).map(|k| f64::from(ng[k]) * point[k]).sum();
        assert!(
            (cosine - 1.0).abs() < 1e-4,
            "ray {i}: the normal is off, {cosine}"
        );
        let length: f32 = ng.iter().map(|x| x * x).sum::<f32>().sqrt();
        assert!((length - 1.0).abs() < 1e-6);
    }
    assert!(compared > 500, "{compared} hits are too few to tell");
}

/// How near a ray's line comes to the origin.
fn nearest_to_centre(ray: &[f64; 6]) -> f64 {
    let (o, d) = ray.split_at(3);
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    (dot(o, o) - dot(o, d).powi(2) / dot(d, d)).max(0.0).sqrt()
}

#[test]
fn packets_of_all_widths_and_any_number_of_threads_agree() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    // Not a multiple of any width, and more than one job's rays.
    let rays = save_rays(&shop, "rays.npy", &random_rays(9003));
    for form in [
        &["--surface", "smooth"][..],
        &["--method", "paper"],
        &["--surface", "flat"],
    ] {
        let answer = |packet: &str, threads: &str| {
            let options = ["--packet", packet, "--threads", threads];
            trace(&shop, &mesh, &rays, &[&options, form].concat())
        };
        let single = answer("1", "1");
        assert!(single == answer("1", "2"), "threads");
        for packet in ["4", "8", "16"] {
            let together = answer(packet, "2");
            let same = |i: &usize| {
                single.t[*i] == together.t[*i] && single.prim_id[*i] == together.prim_id[*i]
            };
            let agreeing = (0..single.t.len()).filter(same).count();
            if !form.contains(&"flat") {
                assert!(single == together, "packets of {packet}: {agreeing} agree");
            } else {
                // Embree's own triangles round differently by the packet's width.
                let close = |(a, b): (&f64, &f64)| a == b || (a / b - 1.0).abs() < 1e-5;
                let close = single
                    .t
                    .iter()
                    .zip(&together.t)
                    .filter(|p| close(*p))
                    .count();
                assert!(
                    close >= single.t.len() - 2,
                    "packets of {packet}: {close} agree"
                );
            }
        }
    }
}

#[test]
fn both_precisions_both_orders_and_both_byte_orders_are_read() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    // Numbers that both precisions hold.
    let rays: Vec<[f64; 6]> = random_rays(50)
        .into_iter()
        .map(|ray| ray.map(|x| f64::from(x as f32)))
        .collect();
    let double = save_rays(&shop, "double.npy", &rays);
    let single: Vec<f32> = rays.as_flattened().iter().map(|x| *x as f32).collect();
    let single = save(&shop, "single.npy", &[50, 6], Order::C, &single);
    let columns: Vec<f64> = (0..6)
        .flat_map(|column| rays.iter().map(move |ray| ray[column]))
        .collect();
    let fortran = save(&shop, "fortran.npy", &[50, 6], Order::Fortran, &columns);
    let big = {
        let bytes = std::fs::read(&double).unwrap();
        let start = bytes.len() - 50 * 6 * 8;
        let header = String::from_utf8_lossy(&bytes[10..start]).replace("<f8", ">f8");
        let mut swapped = [&bytes[..10], header.as_bytes()].concat();
        swapped.extend(bytes[start..].chunks(8).flat_map(|x| x.iter().rev()));
        shop.write("big.npy", swapped)
    };
    let hits = trace(&shop, &mesh, &double, &[]);
    assert!(hits.t.iter().any(|t| t.is_finite()));
    for other in [single, fortran, big] {
        assert!(hits == trace(&shop, &mesh, &other, &[]), "{other}");
    }
}

#[test]
fn rays_have_a_beginning_and_an_end_and_untraceable_ones_miss() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let (inf, nan) = (f64::INFINITY, f64::NAN);
    // From (0.1, 0.2, 5) downwards in steps of 2: the sphere begins near t = 2 and ends near 3.
    let with = |change: &[(usize, f64)]| {
        let mut ray = [0.1, 0.2, 5.0, 0.0, 0.0, -2.0, 0.0, inf];
        for (index, value) in change {
            ray[*index] = *value;
        }
        ray
    };
    let cases = [
        (with(&[]), Some(2.0)),
        (with(&[(7, 2.5)]), Some(2.0)),
        (with(&[(7, 1.9)]), None),
        (with(&[(6, 2.5)]), Some(3.0)),
        (with(&[(6, 3.5)]), None),
        (with(&[(6, 2.5), (7, 2.4)]), None),
        (with(&[(6, -1.0)]), Some(2.0)),
        (with(&[(6, -1e-6)]), Some(2.0)),
        (with(&[(7, -1.0)]), None),
        (with(&[(6, nan)]), None),
        (with(&[(7, nan)]), None),
        (with(&[(0, nan)]), None),
        (with(&[(2, inf)]), None),
        (with(&[(5, nan)]), None),
        (with(&[(5, 1e300)]), None),
        (with(&[(5, 0.0)]), None),
        (with(&[(5, 2.0)]), None),
    ];
    let flat: Vec<f64> = cases.iter().flat_map(|(ray, _)| *ray).collect();
    let rays = save(&shop, "rays.npy", &[cases.len() as u64, 8], Order::C, &flat);
    for packet in ["1", "4", "8", "16"] {
        for surface in ["smooth", "flat"] {
            let options = ["--packet", packet, "--surface", surface];
            let hits = trace(&shop, &mesh, &rays, &options);
            for (i, (ray, expected)) in cases.iter().enumerate() {
                assert_eq!(
                    hits.t[i].is_finite(),
                    expected.is_some(),
                    "{surface} {ray:?}"
                );
                if let (Some(t), "smooth") = (expected, surface) {
                    assert!((hits.t[i] - t).abs() < 0.05, "{ray:?}: {}", hits.t[i]);
                }
            }
        }
    }
}

#[test]
fn rays_that_cannot_be_traced_are_counted_with_the_first_one_s_row() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let ray = [0.1, 0.2, 5.0, 0.0, 0.0, -2.0, 0.0, f64::INFINITY];
    let says = |faults: &[(usize, usize, f64)], more: &[&str]| {
        let mut rays = [ray; 5];
        for (row, column, value) in faults {
            rays[*row][*column] = *value;
        }
        let rays = save(&shop, "rays.npy", &[5, 8], Order::C, rays.as_flattened());
        let hits = shop.path("hits.npz");
        let run = [&["trace", &mesh, "--rays", &rays, "-o", &hits], more].concat();
        stderr(&shop.succeeds(&run))
    };
    for more in [
        &[][..],
        &["--packet", "16"],
        &["--occluded"],
        &["--all-hits", "2"],
        &["--surface", "flat"],
    ] {
        let said = says(&[(3, 0, f64::NAN), (1, 2, 1e19), (4, 6, -1.0)], more);
        assert!(said.contains("2 of 5") && said.contains("row 1,"), "{said}");
        assert!(said.contains("origin has a component of 1e19"), "{said}");
        let said = says(&[(2, 6, 4.0), (2, 7, 3.0)], more);
        assert!(said.contains("1 of 5") && said.contains("row 2,"), "{said}");
        assert!(
            said.contains("tnear, 4, is greater than its tfar, 3"),
            "{said}"
        );
        assert!(!says(&[(4, 6, -1.0)], more).contains("cannot be traced"));
    }
}

#[test]
fn a_ray_that_begins_and_ends_at_its_hit_has_it_with_packets_of_all_widths() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let rays = random_rays(500);
    let whole = trace(&shop, &mesh, &save_rays(&shop, "rays.npy", &rays), &[]);
    let mut cut: Vec<f64> = Vec::new();
    for (ray, t) in rays.iter().zip(&whole.t) {
        cut.extend(ray.iter().chain(&[*t; 2]));
    }
    let cut = save(&shop, "cut.npy", &[500, 8], Order::C, &cut);
    for packet in ["1", "4", "8", "16"] {
        let again = trace(&shop, &mesh, &cut, &["--packet", packet]);
        assert!(again == whole, "packets of {packet}");
    }
}

#[test]
fn no_rays_have_no_hits() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let hits = trace(&shop, &mesh, &save_rays(&shop, "rays.npy", &[]), &[]);
    assert_eq!(
        hits,
        Hits {
            t: vec![],
            prim_id: vec![],
            uv: vec![],
            ng: vec![]
        }
    );
}

#[test]
fn far_from_the_origin_no_digit_is_lost() {
    let shop = Workshop::new();
    let centre = [4e6, -2e6, 1e6];
    let mesh = shop.moved_sphere("far.obj", centre);
    let rays = random_rays(300);
    let moved: Vec<[f64; 6]> = rays
        .iter()
        .map(|ray| std::array::from_fn(|i| ray[i] + centre.get(i).unwrap_or(&0.0)))
        .collect();
    let hits = trace(&shop, &mesh, &save_rays(&shop, "rays.npy", &moved), &[]);
    let mut compared = 0;
    for (ray, &t) in rays.iter().zip(&hits.t) {
        if let Some(expected) = sphere_hit(ray).filter(|_| nearest_to_centre(ray) < 0.99) {
            compared += 1;
            assert!((t / expected - 1.0).abs() < 1e-4, "{t}, not {expected}");
        }
    }
    assert!(compared > 50);
}

#[test]
fn double_precision_rays_from_very_far_away_hit_what_they_hit_from_near() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let near = random_rays(2000);
    for far in [1e4, 1e7] {
        // Moved back along themselves, in their own lengths.
        let moved: Vec<[f64; 6]> = near
            .iter()
            .map(|ray| std::array::from_fn(|i| ray[i] - if i < 3 { far * ray[i + 3] } else { 0.0 }))
            .collect();
        let near = save_rays(&shop, "near.npy", &near);
        let moved = save_rays(&shop, "far.npy", &moved);
        for form in [
            &["--surface", "smooth"][..],
            &["--packet", "16"],
            &["--surface", "flat"],
        ] {
            let [near, moved] = [&near, &moved].map(|rays| trace(&shop, &mesh, rays, form));
            let differ = (0..near.t.len()).filter(|&i| {
                let t = moved.t[i] - far;
                let same_t = near.t[i] == t || (near.t[i] - t).abs() < 1e-4 * near.t[i];
                near.prim_id[i] != moved.prim_id[i] || !same_t
            });
            let differ = differ.count();
            assert!(
                differ * 1000 <= near.t.len(),
                "{differ} differ, {form:?} from {far}"
            );
        }
    }
}

#[test]
fn the_same_hits_are_the_same_file() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let rays = save_rays(&shop, "rays.npy", &random_rays(100));
    let file = |name: &str| {
        let path = shop.path(name);
        shop.succeeds(&["trace", &mesh, "--rays", &rays, "-o", &path]);
        std::fs::read(path).unwrap()
    };
    assert!(file("a.npz") == file("b.npz"));
}

#[test]
fn a_file_that_holds_no_rays_is_named_with_what_is_expected() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    let says = |rays: &str| {
        let hits = shop.path("hits.npz");
        let said = shop.fails(1, &["trace", &mesh, "--rays", rays, "-o", &hits]);
        assert!(said.contains(rays), "the file is named: {said}");
        assert!(!shop.names().contains(&"hits.npz".to_owned()));
        said
    };
    let missing = says(&shop.path("missing.npy"));
    assert!(missing.contains("No such file"), "{missing}");
    let other = says(&shop.write("other.npy", "no array at all"));
    assert!(other.contains("(N, 6)"), "{other}");

    let wide = says(&save(&shop, "wide.npy", &[2, 7], Order::C, &[0_f64; 14]));
    assert!(wide.contains("(2, 7)") && wide.contains("(N, 6)"), "{wide}");
    let line = says(&save(&shop, "line.npy", &[6], Order::C, &[0_f64; 6]));
    assert!(line.contains("(6,)") && line.contains("(N, 6)"), "{line}");
    let whole = says(&save(&shop, "whole.npy", &[1, 6], Order::C, &[0_i32; 6]));
    assert!(whole.contains("i4") && whole.contains("float32"), "{whole}");

    let good = std::fs::read(save_rays(&shop, "good.npy", &random_rays(9))).unwrap();
    let cut = says(&shop.write("cut.npy", &good[..good.len() - 3]));
    assert!(cut.contains("(9, 6)"), "{cut}");
    // A header that promises more than there is memory.
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (9999999999999999, 6)}\n";
    let length = (header.len() as u16).to_le_bytes();
    let huge = [b"\x93NUMPY\x01\0", &length[..], header.as_bytes(), &[0; 48]].concat();
    let huge = says(&shop.write("huge.npy", huge));
    assert!(huge.contains("48 bytes"), "{huge}");
}
