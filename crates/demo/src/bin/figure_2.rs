//! Figure 2 of the paper: its four bodies as flat triangles and as the curved surfaces they stand
//! for, all ray traced, in one picture.
//!
//!     cargo run --release --bin figure_2 -- out/figure_2.png
//!
//! The bodies are cut as coarsely as in the paper, and curved by its form: without the test that
//! keeps triangles flat where the guide field folds over, which the 96 triangles of the torus would
//! not pass (see docs/limits.md).

use std::io::Cursor;

use curvetri::curved::CurvedOptions;
use curvetri::output::OutputFile;
use curvetri::render::{Background, Form, Framing, Picture, Scene, UpAxis, render};
use curvetri_bodies::Body;
use image::{RgbaImage, imageops};

const TILE: [usize; 2] = [320, 264];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let output = std::env::args().nth(1).ok_or("name the picture to write")?;
    let device = curvetri::linked::device()?;
    let bodies = [
        Body::sphere_tetrahedron(),
        Body::cylinder(),
        Body::cone(),
        Body::torus(6, 8),
    ];
    let curved = Form::Curved(CurvedOptions {
        unchecked: true,
        ..CurvedOptions::default()
    });
    let [width, height] = TILE.map(|side| side as u32);
    let mut sheet = RgbaImage::new(width * bodies.len() as u32, height * 2);
    for (column, body) in bodies.iter().enumerate() {
        for (row, form) in [Form::Flat, curved].into_iter().enumerate() {
            let tile = tile(&Scene::new(&device, vec![body.mesh()], form)?)?;
            let (x, y) = (column as u32 * width, row as u32 * height);
            imageops::replace(&mut sheet, &tile, x.into(), y.into());
        }
    }
    let mut png = Cursor::new(Vec::new());
    sheet.write_to(&mut png, image::ImageFormat::Png)?;
    OutputFile::create(&output)?.finish(|out| out.write_all(png.get_ref()))?;
    println!("{output}");
    Ok(())
}

/// One body, seen from a little above.
fn tile(scene: &Scene) -> Result<RgbaImage, Box<dyn std::error::Error>> {
    let [width, height] = TILE;
    let up = UpAxis::Z;
    let framing = Framing {
        up,
        fov_degrees: Some(30.0),
        aspect: width as f64 / height as f64,
        shadows_of: None,
    };
    let picture = Picture {
        albedo: 0.8,
        ..Picture::new(width, height, framing.camera(scene), up)
    };
    let (film, _) = render(scene, &picture, &|_, _| {})?;
    let mut png = Cursor::new(Vec::new());
    film.write_png(&mut png, Background::default(), 0.0)?;
    Ok(image::load_from_memory(png.get_ref())?.to_rgba8())
}
