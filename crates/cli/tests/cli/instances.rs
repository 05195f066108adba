//! glTF files that use a mesh several times, by the whole program: against the same scene whose nodes
//! have a mesh each.

use std::f64::consts::{PI, TAU};

use crate::program::{Workshop, stdout};
use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};
use serde_json::{Value, json};

/// A mesh's arrays.
struct Arrays {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// The unit sphere in strips of latitude, with one vertex at each pole.
fn ball(around: u32) -> Arrays {
    let (rows, last) = (around / 2, around * (around / 2 - 1) + 1);
    let mut positions = vec![[0.0, 0.0, 1.0]];
    for row in 1..rows {
        let (sin, cos) = (PI * f64::from(row) / f64::from(rows)).sin_cos();
        positions.extend((0..around).map(|n| {
            let (y, x) = (TAU * f64::from(n) / f64::from(around)).sin_cos();
            [sin * x, sin * y, cos].map(|c| c as f32)
        }));
    }
    positions.push([0.0, 0.0, -1.0]);
    let at = |row: u32, n: u32| 1 + (row - 1) * around + n % around;
    let mut triangles = Vec::new();
    for n in 0..around {
        triangles.push([0, at(1, n), at(1, n + 1)]);
        for row in 1..rows - 1 {
            let [a, b] = [at(row, n), at(row, n + 1)];
            let [c, d] = [at(row + 1, n), at(row + 1, n + 1)];
            triangles.extend([[a, c, d], [a, d, b]]);
        }
        triangles.push([last, at(rows - 1, n + 1), at(rows - 1, n)]);
    }
    Arrays {
        normals: positions.clone(),
        positions,
        triangles,
    }
}

/// A square that looks up along z.
fn plate() -> Arrays {
    Arrays {
        positions: vec![
            [-4.0, -3.0, 0.0],
            [4.0, -3.0, 0.0],
            [4.0, 3.0, 0.0],
            [-4.0, 3.0, 0.0],
        ],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// A GLB file of meshes, nodes and whatever else.
fn glb(meshes: &[Arrays], nodes: Value, more: Value) -> Vec<u8> {
    let (mut binary, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
    let mut accessor = |bytes: Vec<u8>, what: Value| {
        views.push(json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len()}));
        binary.extend(bytes);
        let mut accessor = what;
        accessor["bufferView"] = json!(views.len() - 1);
        accessors.push(accessor);
        accessors.len() - 1
    };
    let floats = |vectors: &[[f32; 3]]| -> Vec<u8> {
        let numbers = vectors.as_flattened().iter();
        numbers.flat_map(|x| x.to_le_bytes()).collect()
    };
    let mut described = Vec::new();
    for mesh in meshes {
        let vectors = |count: usize| json!({"componentType": 5126, "type": "VEC3", "count": count});
        let positions = accessor(floats(&mesh.positions), vectors(mesh.positions.len()));
        let normals = accessor(floats(&mesh.normals), vectors(mesh.normals.len()));
        let order = mesh.triangles.as_flattened();
        let indices = accessor(
            order.iter().flat_map(|i| i.to_le_bytes()).collect(),
            json!({"componentType": 5125, "type": "SCALAR", "count": order.len()}),
        );
        let attributes = json!({"POSITION": positions, "NORMAL": normals});
        described.push(json!({"primitives": [{"attributes": attributes, "indices": indices}]}));
    }
    let mut root = json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": binary.len()}],
        "bufferViews": views,
        "accessors": accessors,
        "meshes": described,
        "nodes": nodes,
    });
    let Value::Object(more) = more else {
        panic!("{more} is no object");
    };
    root.as_object_mut().unwrap().extend(more);
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = |n: usize| (n as u32).to_le_bytes();
    let whole = 28 + text.len() + binary.len();
    [
        &b"glTF\x02\0\0\0"[..],
        &length(whole),
        &length(text.len()),
        b"JSON",
        &text,
        &length(binary.len()),
        b"BIN\0",
        &binary,
    ]
    .concat()
}

/// A plate with a ball as it is, a mirrored and turned one, and a stretched one on it: of one mesh, or
/// of one each.
fn scene(shared: bool) -> Vec<u8> {
    let mesh = |n: usize| if shared { 1 } else { n };
    let turn = [0.5, 0.5, 0.5, 0.5];
    let nodes = json!([
        {"mesh": 0},
        {"mesh": mesh(1), "translation": [-2.2, 0.0, 1.0]},
        {"mesh": mesh(2), "translation": [0.0, 0.3, 0.9], "rotation": turn, "scale": [-0.9, 0.9, 0.9]},
        {"mesh": mesh(3), "translation": [2.2, -0.2, 1.3], "scale": [0.8, 1.1, 1.3]},
    ]);
    let balls = if shared { 1 } else { 3 };
    let meshes: Vec<Arrays> = std::iter::once(plate())
        .chain((0..balls).map(|_| ball(32)))
        .collect();
    glb(&meshes, nodes, json!({}))
}

/// The channels of a picture.
fn channels(path: &str) -> Vec<(String, Vec<f32>)> {
    let image = read_first_flat_layer_from_file(path).unwrap();
    let channels = image.layer_data.channel_data.list.into_iter();
    let floats = channels.filter_map(|channel| match channel.sample_data {
        FlatSamples::F32(values) => Some((channel.name.to_string(), values)),
        _ => None,
    });
    floats.collect()
}

/// The share of values that are further apart than this.
fn apart(a: &[f32], b: &[f32], room: f32) -> f64 {
    assert_eq!(a.len(), b.len());
    // Infinite depths are the same as each other, and not a number is off.
    let is_off =
        |a: f32, b: f32| a != b && (a - b).abs().partial_cmp(&room).is_none_or(|o| o.is_gt());
    let off = a.iter().zip(b).filter(|&(&a, &b)| is_off(a, b));
    off.count() as f64 / a.len() as f64
}

const VIEW: [&str; 10] = [
    "--size",
    "160x96",
    "--up-axis",
    "z",
    "--samples",
    "16",
    "--seed",
    "3",
    "--sun-direction",
    "-0.5,-0.6,0.8",
];

#[test]
fn instances_make_the_picture_of_copies() {
    let shop = Workshop::new();
    let [shared, copies] = [true, false].map(|shared| {
        let name = if shared { "shared.glb" } else { "copies.glb" };
        shop.write(name, scene(shared))
    });
    let cases: [&[&str]; 9] = [
        &[],
        &["--shading", "interpolated"],
        &["--surface", "flat"],
        &[
            "--surface",
            "flat",
            "--shading",
            "interpolated",
            "--sky-shadows",
        ],
        &["--method", "paper"],
        &[
            "--surface",
            "tensor",
            "--primitives",
            "triangles",
            "--integrator",
            "ao",
        ],
        &["--integrator", "path", "--depth", "3", "--ground"],
        &[
            "--integrator",
            "path",
            "--material",
            "glass",
            "--depth",
            "6",
        ],
        &[
            "--integrator",
            "path",
            "--material",
            "glass",
            "--surface",
            "flat",
            "--depth",
            "6",
        ],
    ];
    for case in cases {
        let [one, other] = [&shared, &copies].map(|mesh| {
            let picture = shop.path("picture.exr");
            let args = ["render", mesh, "-o", &picture];
            shop.succeeds(&[&args[..], &VIEW, case].concat());
            channels(&picture)
        });
        let glass = case.contains(&"glass");
        for ((name, a), (_, b)) in one.iter().zip(&other) {
            // Rays through glass part quickly, and decide at random what is nearly even. What is seen
            // at an outline is one or the other.
            let (room, share) = match &name[..] {
                "R" | "G" | "B" if glass => (0.05, 0.03),
                "R" | "G" | "B" | "A" => (0.01, 0.005),
                // The surfaces of the stretched ball differ a little, their normals more.
                "N.X" | "N.Y" | "N.Z" if !case.contains(&"flat") => (0.03, 0.003),
                _ => (0.01, 0.003),
            };
            let off = apart(a, b, room);
            assert!(off <= share, "{case:?}: {off} of {name} are apart");
            let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
            if matches!(&name[..], "R" | "G" | "B" | "A") {
                assert!(
                    (mean(a) - mean(b)).abs() < 1e-3 * mean(b),
                    "{case:?} {name}"
                );
            }
        }
    }
}

#[test]
fn a_crop_of_instances_is_the_part_of_the_whole() {
    let shop = Workshop::new();
    let mesh = shop.write("shared.glb", scene(true));
    let [all, part] = [&[][..], &["--crop", "53,21,40x30"]].map(|crop| {
        let picture = shop.path("picture.exr");
        let args = ["render", &mesh, "-o", &picture, "--integrator", "path"];
        shop.succeeds(&[&args[..], &VIEW, crop].concat());
        channels(&picture)
    });
    for ((name, all), (_, part)) in all.iter().zip(&part) {
        let cropped = (21..51).flat_map(|y| &all[160 * y + 53..160 * y + 93]);
        assert!(cropped.eq(part), "{name}");
    }
}

#[test]
fn memory_grows_with_the_meshes_and_hardly_with_their_uses() {
    let shop = Workshop::new();
    let uses = |count: usize| {
        let nodes: Vec<Value> = (0..count)
            .map(|n| json!({"mesh": 0, "translation": [3 * (n % 100), 3 * (n / 100), 0]}))
            .collect();
        shop.write(
            &format!("{count}.glb"),
            glb(&[ball(46)], json!(nodes), json!({})),
        )
    };
    let stats = |mesh: &str| -> Value {
        let picture = shop.path("picture.png");
        let args = [
            "render", mesh, "-o", &picture, "--size", "80x60", "--json", "--ground",
        ];
        let more = ["--samples", "1", "--up-axis", "z"];
        serde_json::from_str(&stdout(&shop.succeeds(&[&args[..], &more].concat()))).unwrap()
    };
    let [few, many] = [2, 30_000].map(|count| stats(&uses(count)));
    let triangles = 46 * 2 * 22;
    for (stats, instances) in [(&few, 2), (&many, 30_000)] {
        assert_eq!(stats["instances"], instances);
        assert_eq!(stats["triangles"]["total"], triangles);
    }
    assert_eq!(few["bytes"]["mesh"], many["bytes"]["mesh"]);
    let peak = |stats: &Value| stats["bytes"]["peak"].as_u64().unwrap();
    // 60 million triangles would be 30 times as much for their indices and places alone.
    let more = peak(&many).saturating_sub(peak(&few)) / 30_000;
    assert!(more < 3000, "{more} bytes a use");

    // What makes one mesh of it says why it does not.
    let error = shop.fails(1, &["inspect", &shop.path("30000.glb")]);
    let reason = "its copies of meshes add up to 60720000 triangles, but at most 50000000";
    assert!(error.contains(reason), "{error}");
}

#[test]
fn lights_of_the_file_light_the_picture() {
    let shop = Workshop::new();
    let spot = json!({"innerConeAngle": 0.2, "outerConeAngle": 0.4});
    let lights = json!({"extensions": {"KHR_lights_punctual": {"lights": [
        {"type": "point", "intensity": 50, "color": [1, 0, 0]},
        {"type": "spot", "intensity": 50, "color": [0, 1, 0], "spot": spot},
    ]}}});
    let light = |n: usize, x: f64| json!({"translation": [x, 0, 2], "extensions": {"KHR_lights_punctual": {"light": n}}});
    let ball =
        |x: f64, y: f64| json!({"mesh": 1, "translation": [x, y, 0.5], "scale": [0.2, 0.2, 0.2]});
    let nodes =
        json!([{"mesh": 0}, ball(-1.0, 0.0), ball(2.0, 0.5), light(0, -2.0), light(1, 2.0)]);
    let mesh = shop.write("lit.glb", glb(&[plate(), self::ball(16)], nodes, lights));
    let picture = |more: &[&str]| {
        let file = shop.path("picture.exr");
        let view = [
            "--size",
            "80x60",
            "--eye",
            "0,0,20",
            "--target",
            "0,0,0",
            "--up",
            "0,1,0",
            "--up-axis",
            "z",
            "--fov",
            "17",
            "--sky",
            "0",
        ];
        shop.succeeds(&[&["render", &mesh, "-o", &file][..], &view, more].concat());
        channels(&file)
    };
    let channel = |picture: &[(String, Vec<f32>)], name: &str| -> Vec<f32> {
        picture.iter().find(|(n, _)| n == name).unwrap().1.clone()
    };
    // A pixel is a tenth of a unit.
    let at = |values: &[f32], x: f64, y: f64| {
        values[(30.0 - 10.0 * y) as usize * 80 + (40.0 + 10.0 * x) as usize]
    };
    for integrator in [
        &["--integrator", "direct"][..],
        &["--integrator", "path", "--depth", "1"],
    ] {
        let lit = picture(integrator);
        let [red, green, blue] = ["R", "G", "B"].map(|name| channel(&lit, name));
        assert!(
            blue.iter().all(|&b| b == 0.0),
            "no sun where the file has lights of its own"
        );
        let under = at(&red, -2.0, 0.03);
        // The inverse square times the cosine: 2 away straight below, and 1.5 aside.
        let aside = at(&red, -2.0, -1.5) / under;
        let expected = (1.0_f32 + 0.75 * 0.75).powf(-1.5);
        assert!(
            (aside / expected - 1.0).abs() < 0.06,
            "{integrator:?}: {aside}, not {expected}"
        );
        // Beyond the first ball is its shadow: where the ray through it from the light ends.
        let shadow = at(&red, -0.667, 0.03);
        assert!(shadow < 0.01 * under, "{integrator:?}: {shadow} of {under}");
        assert!(at(&green, 2.0, -0.2) > 0.5 * under);
        assert_eq!(at(&green, 2.0, -1.2), 0.0, "outside the cone");
    }
    let sun = channel(&picture(&["--file-lights", "0"]), "B");
    assert!(
        sun.iter().any(|&b| b > 0.1),
        "without the file's lights the sun shines"
    );
    let both = channel(&picture(&["--sun", "0.5"]), "B");
    assert!(
        both.iter().any(|&b| b > 0.1),
        "a sun that is asked for shines as well"
    );
}
