//! `curvetri render` into OpenEXR files.

use std::collections::HashMap;

use crate::program::Workshop;
use exr::prelude::{FlatSamples, Vec2, read_first_flat_layer_from_file};

/// A file's channels by name, its size, where its data begins and how large the whole picture is.
struct Read {
    floats: HashMap<String, Vec<f32>>,
    numbers: HashMap<String, Vec<u32>>,
    size: [usize; 2],
    corner: [i32; 2],
    full: [usize; 2],
}

fn read(path: &str) -> Read {
    let image = read_first_flat_layer_from_file(path).unwrap();
    let layer = image.layer_data;
    let (mut floats, mut numbers) = (HashMap::new(), HashMap::new());
    for channel in layer.channel_data.list {
        let name = channel.name.to_string();
        match channel.sample_data {
            FlatSamples::F32(values) => drop(floats.insert(name, values)),
            FlatSamples::U32(values) => drop(numbers.insert(name, values)),
            FlatSamples::F16(_) => panic!("{name} is of half precision"),
        }
    }
    let Vec2(x, y) = layer.attributes.layer_position;
    let Vec2(width, height) = image.attributes.display_window.size;
    Read {
        floats,
        numbers,
        size: [layer.size.0, layer.size.1],
        corner: [x, y],
        full: [width, height],
    }
}

impl Read {
    fn float(&self, name: &str, [x, y]: [usize; 2]) -> f32 {
        self.floats[name][y * self.size[0] + x]
    }
    fn vector(&self, names: [&str; 3], at: [usize; 2]) -> [f32; 3] {
        names.map(|name| self.float(name, at))
    }
    fn number(&self, name: &str, [x, y]: [usize; 2]) -> u32 {
        self.numbers[name][y * self.size[0] + x]
    }
}

const P: [&str; 3] = ["P.X", "P.Y", "P.Z"];
const N: [&str; 3] = ["N.X", "N.Y", "N.Z"];
const ALBEDO: [&str; 3] = ["albedo.R", "albedo.G", "albedo.B"];
const VIEW: [&str; 6] = ["--eye", "10,0,5", "--target", "10,0,0", "--size", "41x31"];

fn length(vector: [f32; 3]) -> f32 {
    vector.iter().map(|x| x * x).sum::<f32>().sqrt()
}

#[test]
fn a_ball_s_file_holds_light_and_surface() {
    let shop = Workshop::new();
    let far = shop.sphere("far.obj");
    let ball = shop.moved_sphere("ball.obj", [10.0, 0.0, 0.0]);
    let file = shop.path("ball.exr");
    let args = ["render", &far, &ball, "-o", &file, "--albedo", "0.25"];
    shop.succeeds(&[&args[..], &VIEW].concat());
    assert_eq!(shop.names(), ["ball.exr", "ball.obj", "far.obj"]);
    let file = read(&file);
    assert_eq!(
        (file.size, file.full, file.corner),
        ([41, 31], [41, 31], [0; 2])
    );
    let mut names: Vec<_> = file.floats.keys().chain(file.numbers.keys()).collect();
    names.sort();
    let expected = [
        "A", "B", "G", "N.X", "N.Y", "N.Z", "P.X", "P.Y", "P.Z", "R", "Z", "albedo.B", "albedo.G",
        "albedo.R", "id", "mesh",
    ];
    assert_eq!(names, expected);

    let middle = [20, 15];
    let near = |a: f32, b: f32| (a - b).abs() < 1e-5;
    assert!(near(file.float("Z", middle), 4.0));
    assert_eq!(file.float("A", middle), 1.0);
    assert_eq!(file.vector(ALBEDO, middle), [0.25; 3]);
    assert!(file.float("R", middle) > 0.01);
    let mut triangles = std::collections::HashSet::new();
    let mut covered = 0;
    for at in (0..31).flat_map(|y| (0..41).map(move |x| [x, y])) {
        let depth = file.float("Z", at);
        if depth == f32::INFINITY {
            assert_eq!(file.number("id", at), u32::MAX);
            assert_eq!(file.number("mesh", at), u32::MAX);
            assert_eq!([file.vector(P, at), file.vector(N, at)], [[0.0; 3]; 2]);
            continue;
        }
        covered += 1;
        let ([x, y, z], normal) = (file.vector(P, at), file.vector(N, at));
        assert!(near(length(normal), 1.0), "{normal:?}");
        for (position, normal) in [x - 10.0, y, z].into_iter().zip(normal) {
            assert!((position - normal).abs() < 1e-4, "a unit ball's: {at:?}");
        }
        assert!((5.0 - z - depth).abs() < 1e-4, "along the view: {at:?}");
        assert_eq!(file.number("mesh", at), 1);
        triangles.insert(file.number("id", at));
    }
    assert!(triangles.len() >= 3 && triangles.iter().all(|id| *id < 4));
    let coverage: f32 = file.floats["A"].iter().sum();
    assert!((coverage / covered as f32 - 1.0).abs() < 0.05);
}

#[test]
fn a_crop_keeps_its_place_and_its_values() {
    let shop = Workshop::new();
    let ball = shop.moved_sphere("ball.obj", [10.0, 0.0, 0.0]);
    let files = [("whole.exr", None), ("part.exr", Some("7,3,20x11"))].map(|(name, crop)| {
        let path = shop.path(name);
        let args = [
            "render",
            &ball,
            "-o",
            &path,
            "--integrator",
            "path",
            "--depth",
            "2",
        ];
        let crop: Vec<&str> = crop.map_or(vec![], |crop| vec!["--crop", crop]);
        shop.succeeds(&[&args[..], &VIEW, &["--ground"], &crop].concat());
        read(&path)
    });
    let [whole, part] = files;
    assert_eq!(
        (part.size, part.full, part.corner),
        ([20, 11], [41, 31], [7, 3])
    );
    for (name, values) in &part.floats {
        for (n, value) in values.iter().enumerate() {
            let at = [7 + n % 20, 3 + n / 20];
            assert_eq!(*value, whole.float(name, at), "{name} {at:?}");
        }
    }
    for at in (0..11).flat_map(|y| (0..20).map(move |x| [x, y])) {
        let id = whole.number("id", [7 + at[0], 3 + at[1]]);
        assert_eq!(part.number("id", at), id);
    }
}
