//! The film: what the camera's rays brought, and how it becomes an image.

use std::io::{self, Write};

use glam::{Vec3, Vec4};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, RgbImage};

use super::picture::Window;

/// A picture in linear light: per pixel its radiance multiplied by its coverage, and the coverage,
/// the share of the pixel where something was seen.
///
/// ```
/// use curvetri::render::{Background, Film};
///
/// let film = Film::new(4, 3);
/// assert_eq!((film.width(), film.height(), film.pixels().len()), (4, 3, 12));
/// let mut png = Vec::new();
/// film.write_png(&mut png, Background::Transparent, 0.0)?;
/// assert_eq!(&png[1..4], b"PNG");
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    window: Window,
    pixels: Vec<Vec4>,
}

/// What shows where nothing is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// From the first row to the last, in linear light.
    Gradient {
        /// Radiance at the top.
        top: Vec3,
        /// Radiance at the bottom.
        bottom: Vec3,
    },
    /// Nothing: the image has an alpha channel.
    Transparent,
}

impl Default for Background {
    fn default() -> Self {
        Self::Gradient {
            top: Vec3::new(0.48, 0.55, 0.66),
            bottom: Vec3::new(0.80, 0.82, 0.84),
        }
    }
}

impl Film {
    /// A film on which nothing was seen.
    pub fn new(width: usize, height: usize) -> Self {
        Self::of(Window::all([width, height]))
    }

    /// A film for a part of a picture.
    pub(super) fn of(window: Window) -> Self {
        Self {
            window,
            pixels: vec![Vec4::ZERO; window.count()],
        }
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.window.size[0]
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.window.size[1]
    }

    pub(super) fn window(&self) -> &Window {
        &self.window
    }

    /// The pixels, row by row from the top: radiance (red, green, blue) times coverage, and
    /// coverage.
    pub fn pixels(&self) -> &[Vec4] {
        &self.pixels
    }

    /// Multiplies each pixel's light by a colour, by its place in [`pixels`](Self::pixels).
    pub fn tint(&mut self, colour: impl Fn(usize) -> Vec3) {
        for (place, pixel) in self.pixels.iter_mut().enumerate() {
            *pixel *= colour(place).extend(1.0);
        }
    }

    /// Copies a square with this many pixels a side to this place in the picture; what lies beyond
    /// the film's edges is left out.
    pub(super) fn paste(&mut self, corner: [usize; 2], side: usize, pixels: &[Vec4]) {
        for (from, at) in self.window.rows_of(corner, side) {
            self.pixels[at..at + from.len()].copy_from_slice(&pixels[from]);
        }
    }

    /// The picture over a background as 8-bit sRGB; black where that is transparent. The light is
    /// multiplied by 2 to the power of `stops` first.
    pub fn to_rgb8(&self, background: Background, stops: f32) -> RgbImage {
        let [top, bottom] = match background {
            Background::Gradient { top, bottom } => [top, bottom],
            Background::Transparent => [Vec3::ZERO; 2],
        };
        let bytes = self.over(top, bottom, stops.exp2());
        RgbImage::from_raw(self.width() as u32, self.height() as u32, bytes)
            .expect("three bytes a pixel")
    }

    /// Writes the picture as a PNG file: sRGB of 8 bits, with an alpha channel if the background is
    /// transparent. The light is multiplied by 2 to the power of `stops` first.
    ///
    /// # Errors
    /// What the writer says.
    pub fn write_png(
        &self,
        writer: impl Write,
        background: Background,
        stops: f32,
    ) -> io::Result<()> {
        let gain = stops.exp2();
        let (bytes, color) = match background {
            Background::Gradient { top, bottom } => {
                (self.over(top, bottom, gain), ExtendedColorType::Rgb8)
            }
            Background::Transparent => (self.with_alpha(gain), ExtendedColorType::Rgba8),
        };
        PngEncoder::new(writer)
            .write_image(&bytes, self.width() as u32, self.height() as u32, color)
            .map_err(|error| match error {
                image::ImageError::IoError(error) => error,
                other => io::Error::other(other),
            })
    }

    fn over(&self, top: Vec3, bottom: Vec3, gain: f32) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(3 * self.pixels.len());
        let (first, rows) = (self.window.corner[1], self.window.full[1]);
        for (row, pixels) in self.pixels.chunks(self.width()).enumerate() {
            let behind = top.lerp(bottom, ((first + row) as f32 + 0.5) / rows as f32);
            for pixel in pixels {
                let light = gain * pixel.truncate() + (1.0 - pixel.w) * behind;
                bytes.extend(light.to_array().map(srgb));
            }
        }
        bytes
    }

    fn with_alpha(&self, gain: f32) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(4 * self.pixels.len());
        for pixel in &self.pixels {
            let light = if pixel.w > 0.0 {
                gain / pixel.w * pixel.truncate()
            } else {
                Vec3::ZERO
            };
            bytes.extend(light.to_array().map(srgb));
            bytes.push((255.0 * pixel.w).round() as u8);
        }
        bytes
    }
}

/// Linear light as an 8-bit sRGB value (IEC 61966-2-1).
fn srgb(light: f32) -> u8 {
    let light = light.clamp(0.0, 1.0);
    let value = if light <= 0.003_130_8 {
        12.92 * light
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    };
    (255.0 * value).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transfer_function_is_srgb() {
        let values = [0.0, 1.0, 0.5, 0.214_041_14, 0.002, -1.0, 7.0].map(srgb);
        assert_eq!(values, [0, 255, 188, 128, 7, 0, 255]);
        assert_eq!(srgb(f32::NAN), 0);
    }

    fn read(film: &Film, background: Background, stops: f32) -> image::DynamicImage {
        let mut bytes = Vec::new();
        film.write_png(&mut bytes, background, stops).unwrap();
        image::load_from_memory(&bytes).unwrap()
    }

    #[test]
    fn pixels_lie_over_the_background() {
        let mut film = Film::new(3, 2);
        film.paste([1, 0], 4, &[Vec4::new(0.25, 0.0, 0.0, 0.5); 16]);
        let grey = Vec3::splat(0.5);
        let image = read(
            &film,
            Background::Gradient {
                top: grey,
                bottom: grey,
            },
            1.0,
        )
        .into_rgb8();
        assert_eq!(image.get_pixel(0, 1).0, [srgb(0.5); 3]);
        assert_eq!(
            image.get_pixel(2, 1).0,
            [srgb(0.75), srgb(0.25), srgb(0.25)]
        );
    }

    #[test]
    fn a_part_of_a_picture_lies_over_its_part_of_the_background() {
        let grid: Vec<Vec4> = (0..16).map(|n| Vec4::splat(0.01 * n as f32)).collect();
        let film = |window: Window| {
            let mut film = Film::of(window);
            for corner in [[0, 0], [4, 0], [0, 4], [4, 4]] {
                film.paste(corner, 4, &grid);
            }
            read(&film, Background::default(), 0.0).into_rgb8()
        };
        let whole = film(Window::all([7, 6]));
        let (corner, size) = ([2, 3], [4, 2]);
        let part = film(Window {
            full: [7, 6],
            corner,
            size,
        });
        assert_eq!(part.dimensions(), (4, 2));
        for (x, y, pixel) in part.enumerate_pixels() {
            assert_eq!(pixel, whole.get_pixel(x + 2, y + 3), "{x} {y}");
        }
    }

    #[test]
    fn a_transparent_background_leaves_the_colour_and_its_coverage() {
        let mut film = Film::new(2, 1);
        film.paste([1, 0], 1, &[Vec4::new(0.25, 0.0, 0.5, 0.5)]);
        let image = read(&film, Background::Transparent, 0.0).into_rgba8();
        assert_eq!(image.get_pixel(0, 0).0, [0; 4]);
        assert_eq!(image.get_pixel(1, 0).0, [srgb(0.5), 0, 255, 128]);
    }
}
