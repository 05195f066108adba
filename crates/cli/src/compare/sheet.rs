//! The pictures of a comparison beside each other in one.

use std::io::{self, Write};

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, Rgb, RgbImage, imageops};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::pictures::{Pictures, Shown};

/// The pictures, in their order, of those there are.
const PANELS: [&str; 4] = ["flat", "curved", "difference", "reference"];
/// Pixels between and around the pictures.
const GAP: u32 = 8;
/// Pixels of the strip above a picture.
const STRIP: u32 = 24;
const PAPER: Rgb<u8> = Rgb([34, 36, 40]);
const INK: [u8; 3] = [232; 3];
const WEIGHT: FontWeight = FontWeight::Regular;
const HEIGHT: RasterHeight = RasterHeight::Size16;

/// Writes the sheet as a PNG file.
pub fn write(pictures: &Pictures, out: impl Write) -> io::Result<()> {
    let panels: Vec<&Shown> = PANELS.iter().filter_map(|key| pictures.get(key)).collect();
    let sheet = sheet(&panels);
    PngEncoder::new(out)
        .write_image(
            &sheet,
            sheet.width(),
            sheet.height(),
            ExtendedColorType::Rgb8,
        )
        .map_err(|error| match error {
            image::ImageError::IoError(error) => error,
            other => io::Error::other(other),
        })
}

/// The pictures, all of the same size, each under the beginning of its caption.
fn sheet(panels: &[&Shown]) -> RgbImage {
    let (width, height) = panels[0].image.dimensions();
    let step = width + GAP;
    let size = [panels.len() as u32 * step + GAP, STRIP + height + GAP];
    let mut sheet = RgbImage::from_pixel(size[0], size[1], PAPER);
    for (panel, x) in panels.iter().zip((GAP..).step_by(step as usize)) {
        let heading = panel.caption.split(['.', ':']).next();
        let top = (STRIP - HEIGHT.val() as u32) / 2;
        label(&mut sheet, heading.unwrap_or_default(), [x, top], width);
        imageops::replace(&mut sheet, &panel.image, x.into(), STRIP.into());
    }
    sheet
}

/// Writes as much of a text as fits into the width.
fn label(sheet: &mut RgbImage, text: &str, [x, y]: [u32; 2], width: u32) {
    let advance = get_raster_width(WEIGHT, HEIGHT);
    for (n, letter) in text.chars().take(width as usize / advance).enumerate() {
        let Some(raster) = get_raster(letter, WEIGHT, HEIGHT) else {
            continue;
        };
        for (row, line) in raster.rows().enumerate() {
            for (column, &ink) in line.iter().enumerate() {
                let at = [x as usize + n * advance + column, y as usize + row].map(|n| n as u32);
                let pixel = &mut sheet.get_pixel_mut(at[0], at[1]).0;
                let mixed = |i: usize| {
                    let [paper, ink_there] = [PAPER.0[i], INK[i]].map(u32::from);
                    ((255 - u32::from(ink)) * paper + u32::from(ink) * ink_there) / 255
                };
                *pixel = [0, 1, 2].map(|i| mixed(i) as u8);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(key: &str, color: [u8; 3], width: u32) -> Shown {
        Shown {
            key: key.into(),
            title: String::new(),
            caption: "A title: and more.".into(),
            image: RgbImage::from_pixel(width, 20, Rgb(color)),
        }
    }

    #[test]
    fn pictures_lie_beside_each_other_under_their_labels() {
        let panels = [
            shown("flat", [200, 0, 0], 90),
            shown("curved", [0, 200, 0], 90),
        ];
        let sheet = sheet(&[&panels[0], &panels[1]]);
        assert_eq!(sheet.dimensions(), (3 * GAP + 180, STRIP + 20 + GAP));
        assert_eq!(sheet.get_pixel(GAP, STRIP).0, [200, 0, 0]);
        assert_eq!(sheet.get_pixel(2 * GAP + 90, STRIP).0, [0, 200, 0]);
        assert_eq!(*sheet.get_pixel(GAP + 90, STRIP), PAPER);
        let inked = |from: u32, to: u32| {
            (from..to).any(|x| (0..STRIP).any(|y| sheet.get_pixel(x, y).0[0] > 150))
        };
        assert!(inked(GAP, GAP + 60) && inked(2 * GAP + 90, 2 * GAP + 150));
        assert!(
            !inked(GAP + 60, GAP + 90),
            "seven letters take less than 60"
        );
    }

    #[test]
    fn a_label_ends_where_its_picture_does() {
        let panel = shown("flat", [0; 3], 20);
        let sheet = sheet(&[&panel]);
        assert!((20 + GAP..20 + 2 * GAP).all(|x| sheet.get_pixel(x, 12) == &PAPER));
    }
}
