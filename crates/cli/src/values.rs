//! Values on the command line.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::ValueEnum;
use curvetri::render::{Crop, UpAxis};
use glam::DVec3;

/// Pixels of a side.
const SIDE: RangeInclusive<usize> = 1..=65_535;

/// Width and height, as in 1280x720.
pub fn size(text: &str) -> Result<[usize; 2], String> {
    let form = "a size is WIDTHxHEIGHT in pixels, as in 1280x720";
    let (width, height) = text.split_once(['x', 'X']).ok_or(form)?;
    Ok([side(width)?, side(height)?])
}

/// One side of a picture in pixels.
pub fn side(text: &str) -> Result<usize, String> {
    match text.trim().parse() {
        Ok(pixels) if SIDE.contains(&pixels) => Ok(pixels),
        _ => Err(format!(
            "a picture's side has {} to {} pixels",
            SIDE.start(),
            SIDE.end()
        )),
    }
}

/// A picture's file, which is a PNG file.
pub fn png(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("png"))
    {
        Ok(path)
    } else {
        Err(format!("{text} does not end in .png"))
    }
}

/// Which axis points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum UpChoice {
    Y,
    Z,
}

impl UpChoice {
    pub fn axis(self) -> UpAxis {
        match self {
            Self::Y => UpAxis::Y,
            Self::Z => UpAxis::Z,
        }
    }
}

/// A part of a picture, as in 100,50,320x240.
pub fn crop(text: &str) -> Result<Crop, String> {
    let form = "a part of a picture is X,Y,WIDTHxHEIGHT in pixels, as in 100,50,320x240";
    let (x, rest) = text.split_once(',').ok_or(form)?;
    let (y, size) = rest.split_once(',').ok_or(form)?;
    let start = |text: &str| match text.trim().parse() {
        Ok(start) if start < *SIDE.end() => Ok(start),
        _ => Err(form),
    };
    let [width, height] = self::size(size)?;
    Ok(Crop {
        x: start(x)?,
        y: start(y)?,
        width,
        height,
    })
}

/// A point or direction, as in 1,2.5,-3.
pub fn vector(text: &str) -> Result<DVec3, String> {
    let numbers: Result<Vec<f64>, String> = text.split(',').map(number).collect();
    match numbers?[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        _ => Err("three numbers are needed, as in 1,2.5,-3".into()),
    }
}

/// A ball's centre and radius, as in 1,2.5,-3,0.5.
pub fn ball(text: &str) -> Result<(DVec3, f64), String> {
    let numbers: Result<Vec<f64>, String> = text.split(',').map(number).collect();
    match numbers?[..] {
        [x, y, z, radius] if radius > 0.0 => Ok((DVec3::new(x, y, z), radius)),
        [_, _, _, _] => Err("a radius is above 0".into()),
        _ => Err("a centre and a radius are needed: four numbers, as in 1,2.5,-3,0.5".into()),
    }
}

/// A direction: a vector that is not zero.
pub fn direction(text: &str) -> Result<DVec3, String> {
    let vector = vector(text)?;
    let unit = vector.try_normalize();
    unit.ok_or_else(|| "a direction must not be zero".into())
}

/// A finite number.
pub fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("'{}' is not a finite number", text.trim())),
    }
}

/// An angle of view in degrees.
pub fn fov(text: &str) -> Result<f64, String> {
    let degrees = number(text)?;
    if (0.001..=179.0).contains(&degrees) {
        Ok(degrees)
    } else {
        Err("an angle of view is 0.001 to 179 degrees".into())
    }
}

/// What the height of an orthographic picture covers.
pub fn film_height(text: &str) -> Result<f64, String> {
    let height = number(text)?;
    if height > 0.0 && height.is_finite() {
        Ok(height)
    } else {
        Err("the height that a picture covers is above 0".into())
    }
}

/// An angle between faces in degrees.
pub fn crease(text: &str) -> Result<f32, String> {
    let degrees = number(text)?;
    if (0.0..=180.0).contains(&degrees) {
        Ok(degrees as f32)
    } else {
        Err("an angle between faces is 0 to 180 degrees".into())
    }
}

/// How far a curved surface may lie from what is traced in its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// In the mesh's units.
    Length(f32),
    /// In pixels of the picture.
    Pixels(f32),
}

/// A tolerance: a length, or pixels.
pub fn tolerance(text: &str) -> Result<Tolerance, String> {
    let (amount, of): (_, fn(f32) -> Tolerance) = match text.trim().strip_suffix("px") {
        Some(pixels) => (pixels, Tolerance::Pixels),
        None => (text, Tolerance::Length),
    };
    let form = "a tolerance is a length, or pixels as in 0.05px; 0 or more";
    let amount = number(amount).map_err(|_| form)? as f32;
    if amount >= 0.0 && amount.is_finite() {
        Ok(of(amount))
    } else {
        Err(form.into())
    }
}

/// A share, 0 to 1.
pub fn share(text: &str) -> Result<f32, String> {
    let share = number(text)?;
    if (0.0..=1.0).contains(&share) {
        Ok(share as f32)
    } else {
        Err("a share is 0 to 1".into())
    }
}

/// A factor for light.
pub fn brightness(text: &str) -> Result<f32, String> {
    let factor = number(text)?;
    if (0.0..=1e6).contains(&factor) {
        Ok(factor as f32)
    } else {
        Err("a brightness is 0 to 1e6".into())
    }
}

/// A length above 0.
pub fn length(text: &str) -> Result<f32, String> {
    let length = number(text)? as f32;
    if length > 0.0 && length.is_finite() {
        Ok(length)
    } else {
        Err("a distance is above 0".into())
    }
}

/// A refractive index.
pub fn index(text: &str) -> Result<f32, String> {
    let index = number(text)?;
    if (0.1..=10.0).contains(&index) {
        Ok(index as f32)
    } else {
        Err("a refractive index is 0.1 to 10".into())
    }
}

/// An exposure in stops.
pub fn stops(text: &str) -> Result<f32, String> {
    let stops = number(text)?;
    if (-20.0..=20.0).contains(&stops) {
        Ok(stops as f32)
    } else {
        Err("an exposure is -20 to 20 stops".into())
    }
}

/// A number of points to measure at.
pub fn samples(text: &str) -> Result<usize, String> {
    match text.trim().parse() {
        Ok(samples @ 1..=1_000_000_000) => Ok(samples),
        _ => Err("1 to 1000000000 points".into()),
    }
}

/// A number of hits a ray.
pub fn hits(text: &str) -> Result<usize, String> {
    match text.trim().parse() {
        Ok(hits @ 1..=65_536) => Ok(hits),
        _ => Err("1 to 65536 hits".into()),
    }
}

/// A number of rounds.
pub fn rounds(text: &str) -> Result<usize, String> {
    match text.trim().parse() {
        Ok(rounds @ 1..=1000) => Ok(rounds),
        _ => Err("1 to 1000 rounds".into()),
    }
}

/// A number of triangles to make.
pub fn triangles(text: &str) -> Result<usize, String> {
    match text.trim().parse() {
        Ok(triangles @ 18..=100_000_000) => Ok(triangles),
        _ => Err("18 to 100000000 triangles".into()),
    }
}

/// A number of threads.
pub fn threads(text: &str) -> Result<usize, String> {
    match text.trim().parse() {
        Ok(threads @ 1..=1024) => Ok(threads),
        _ => Err("1 to 1024 threads".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_numbers_within_reason() {
        assert_eq!(size("1280x720"), Ok([1280, 720]));
        for wrong in [
            "", "1280", "0x7", "7x0", "-1x7", "7x", "1e3x7", "7x70000", "7x7x7",
        ] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_crop_is_a_place_and_a_size() {
        let crop_at = |x, y, width, height| Crop {
            x,
            y,
            width,
            height,
        };
        assert_eq!(crop("3,4,5x6"), Ok(crop_at(3, 4, 5, 6)));
        assert_eq!(crop("0,0,1x1"), Ok(crop_at(0, 0, 1, 1)));
        for wrong in [
            "",
            "3",
            "3,4",
            "3,4,5",
            "3,4,0x5",
            "-3,4,5x6",
            "3,4,5,6",
            "3.5,4,5x6",
            "3,99999,5x6",
        ] {
            assert!(crop(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_ball_has_a_centre_and_a_radius() {
        assert_eq!(ball("1,-2,3,0.5"), Ok((DVec3::new(1.0, -2.0, 3.0), 0.5)));
        for wrong in ["1,2,3", "1,2,3,0", "1,2,3,-1", "1,2,3,4,5", "1,2,3,nan"] {
            assert!(ball(wrong).is_err(), "{wrong}");
        }
        assert!(
            ["0", "-1", "1e50", "inf"]
                .iter()
                .all(|w| length(w).is_err())
        );
        assert!(["0", "-1.5", "11", "x"].iter().all(|w| index(w).is_err()));
    }

    #[test]
    fn vectors_are_three_finite_numbers() {
        assert_eq!(vector("1,-2.5, 3e2"), Ok(DVec3::new(1.0, -2.5, 300.0)));
        for wrong in ["", "1,2", "1,2,3,4", "1,nan,3", "1,inf,3", "1;2;3", "a,b,c"] {
            assert!(vector(wrong).is_err(), "{wrong}");
        }
        assert!(direction("0,0,0").is_err());
    }

    #[test]
    fn angles_and_shares_have_their_ranges() {
        assert_eq!(fov("40"), Ok(40.0));
        assert!(
            ["0", "-3", "180", "nan"]
                .into_iter()
                .all(|wrong| fov(wrong).is_err())
        );
        assert!(
            ["-1", "181", "NaN"]
                .into_iter()
                .all(|wrong| crease(wrong).is_err())
        );
        assert!(
            ["-0.1", "1.1", "inf"]
                .into_iter()
                .all(|wrong| share(wrong).is_err())
        );
        assert!(
            ["0", "-1", "2000", "x"]
                .into_iter()
                .all(|wrong| threads(wrong).is_err())
        );
        assert!(
            ["25", "-25", "x"]
                .into_iter()
                .all(|wrong| stops(wrong).is_err())
        );
    }
}
