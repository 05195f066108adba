//! Whether two builds hit the same: `hits write FILE` traces many rays through the meshes of `scenes`
//! and writes what they hit; `hits compare FILE FILE` compares two such files, as of builds against two
//! versions of Embree.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use curvetri::curved::CurvedOptions;
use curvetri::mesh::{Loader, Mesh};
use curvetri::method::Surface;
use curvetri::render::{Form, PacketWidth, Scene, UserRay, UserRays, answer_rays};
use curvetri_bodies::SplitMix;
use glam::DVec3;

/// Rays at each mesh, by each surface and each width of packets.
const RAYS: usize = 20_000;
const WIDTHS: [PacketWidth; 4] = [
    PacketWidth::One,
    PacketWidth::Four,
    PacketWidth::Eight,
    PacketWidth::Sixteen,
];
/// Share of rays that may differ.
const MOST: f64 = 1e-5;
/// t, the triangle, u and v: as bits, four bytes each.
const WORDS: usize = 4;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    match args[..] {
        ["write", file] => write(Path::new(file)),
        ["compare", one, other] => compare(Path::new(one), Path::new(other)),
        _ => Err("usage: hits write FILE | hits compare FILE FILE".into()),
    }
}

fn write(file: &Path) -> Result<ExitCode, Box<dyn Error>> {
    let device = curvetri::linked::device()?;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut names: Vec<_> = std::fs::read_dir(folder)?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()?;
    names.retain(|path| path.extension().is_some_and(|extension| extension == "obj"));
    names.sort();
    let mut words = Vec::new();
    for path in names {
        let mesh = Loader::new().load(&path)?.mesh;
        let rays = rays(&mesh);
        for surface in Surface::ALL {
            let options = CurvedOptions {
                surface,
                ..CurvedOptions::default()
            };
            let scene = Scene::new(&device, vec![mesh.clone()], Form::Curved(options))?;
            for width in WIDTHS {
                words.extend(hits(&scene, &rays, width));
            }
        }
    }
    let count = words.len() / WORDS;
    let bytes: Vec<u8> = words.into_iter().flat_map(u32::to_le_bytes).collect();
    std::fs::write(file, bytes)?;
    let version = device.version();
    println!("{count} rays by Embree {version}: {}", file.display());
    Ok(ExitCode::SUCCESS)
}

/// Rays from all around towards somewhere near the mesh: the same on every machine.
fn rays(mesh: &Mesh) -> Vec<UserRay> {
    let mut random = SplitMix::new(97);
    let bounds = mesh.bounds();
    let mut cube = |side: f64| DVec3::from_array([0; 3].map(|_| random.between(-side, side)));
    let ray = |_| {
        let origin = cube(3.0).map(|x| x + 2.0 * x.signum()) * bounds.diagonal();
        let target = cube(0.4) * bounds.diagonal();
        UserRay {
            origin: bounds.centre() + origin,
            direction: target - origin,
            tnear: 0.0,
            tfar: f64::INFINITY,
        }
    };
    (0..RAYS).map(ray).collect()
}

fn hits(scene: &Scene, rays: &[UserRay], width: PacketWidth) -> Vec<u32> {
    let rays = UserRays {
        count: rays.len(),
        ray: &|i| rays[i],
        progress: &|_| (),
    };
    let answers = answer_rays(scene, &rays, width);
    let hits = answers.t.iter().zip(&answers.prim_id).zip(&answers.uv);
    hits.flat_map(|((t, prim), uv)| {
        [
            (*t as f32).to_bits(),
            *prim,
            uv[0].to_bits(),
            uv[1].to_bits(),
        ]
    })
    .collect()
}

fn compare(one: &Path, other: &Path) -> Result<ExitCode, Box<dyn Error>> {
    let [one, other] = [std::fs::read(one)?, std::fs::read(other)?];
    if one.is_empty() || one.len() != other.len() {
        return Err("the files do not hold the hits of the same rays".into());
    }
    let size = 4 * WORDS;
    let pairs = || one.chunks(size).zip(other.chunks(size));
    let hit = pairs()
        .filter(|(a, _)| a[..4] != f32::INFINITY.to_le_bytes())
        .count();
    let differ = pairs().filter(|(a, b)| a != b).count();
    let total = one.len() / size;
    println!("of {total} rays {hit} hit; {differ} differ");
    let same = hit > total / 10 && differ as f64 <= MOST * total as f64;
    Ok(ExitCode::from(u8::from(!same)))
}
