//! A picture of a mesh with its triangles painted by what became of them.

use std::path::Path;

use anyhow::Result;
use curvetri::method::{FlatReason, PatchKind};
use curvetri::output::OutputFile;
use curvetri::render::{
    Background, Framing, NO_PRIMITIVE, Picture, Scene, Shape, UpAxis, aovs, render,
};
use glam::Vec3;

use super::console::Console;

/// The picture's size in pixels, and rays for each.
const SIZE: [usize; 2] = [1000, 750];
const SAMPLES: u32 = 16;

/// The kinds' names, as the counts have them, and their colours.
const LEGEND: [(&str, &str, [u8; 3]); 9] = [
    ("curved", "grey", [205, 205, 200]),
    ("fallback", "blue", [40, 110, 235]),
    ("flat_plane", "cyan", [110, 215, 225]),
    ("flat_tolerance", "yellow", [245, 220, 40]),
    ("flat_sliver", "magenta", [235, 60, 200]),
    ("flat_back_normal", "red", [225, 30, 25]),
    ("flat_bend", "orange", [250, 140, 20]),
    ("flat_fold", "green", [40, 175, 70]),
    ("degenerate", "black", [15, 15, 15]),
];

/// The kinds' names and colours.
pub fn legend() -> impl Iterator<Item = (&'static str, &'static str)> {
    LEGEND.into_iter().map(|(kind, colour, _)| (kind, colour))
}

/// Writes a picture of a scene's curved meshes.
pub fn paint(scene: &Scene, file: &Path, up: UpAxis, console: &Console) -> Result<()> {
    let output = OutputFile::create(file)?;
    let [width, height] = SIZE;
    let framing = Framing {
        up,
        fov_degrees: Some(35.0),
        aspect: width as f64 / height as f64,
        shadows_of: None,
    };
    let picture = Picture {
        samples: SAMPLES,
        albedo: 1.0,
        ..Picture::new(width, height, framing.camera(scene), up)
    };
    let bar = console.progress("rendering", 0);
    let (mut film, _) = render(scene, &picture, &|_, tiles| {
        bar.set_length(tiles as u64);
        bar.inc(1);
    })?;
    bar.finish_and_clear();
    let seen = aovs(scene, &picture)?;
    film.tint(|pixel| match seen.primitive[pixel] {
        NO_PRIMITIVE => Vec3::ONE,
        triangle => match scene.shape_at(seen.mesh[pixel]) {
            Shape::Curved(mesh) => colour(mesh.kind(triangle)),
            Shape::Flat(_) => colour(PatchKind::Flat(FlatReason::Requested)),
        },
    });
    Ok(output.finish(|out| film.write_png(out, Background::default(), 0.0))?)
}

/// A kind's colour, as a share of each primary colour's light.
fn colour(kind: PatchKind) -> Vec3 {
    let at = match kind {
        PatchKind::Curved => 0,
        PatchKind::Fallback => 1,
        PatchKind::Flat(FlatReason::Plane) => 2,
        PatchKind::Flat(FlatReason::Requested) => 3,
        PatchKind::Flat(FlatReason::Sliver) => 4,
        PatchKind::Flat(FlatReason::BackNormal) => 5,
        PatchKind::Flat(FlatReason::Bend) => 6,
        PatchKind::Flat(FlatReason::Fold) => 7,
        PatchKind::Degenerate => 8,
    };
    let [r, g, b] = LEGEND[at].2.map(|part| (f32::from(part) / 255.0).powf(2.2));
    Vec3::new(r, g, b)
}

#[cfg(test)]
mod tests {
    use curvetri::curved::Kinds;

    use super::*;

    #[test]
    fn the_legend_names_the_kinds_and_their_colours_differ() {
        let names = Kinds::default().named().map(|(name, _)| name);
        assert_eq!(LEGEND.map(|(name, ..)| name), names);
        for (n, (.., one)) in LEGEND.iter().enumerate() {
            for (.., other) in &LEGEND[..n] {
                let difference = (0..3).map(|k| one[k].abs_diff(other[k])).max();
                assert!(difference > Some(60), "{one:?} {other:?}");
            }
        }
    }
}
