//! The differences between pictures.

use image::RgbImage;
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, FlipPool, magma_lut};

/// The root of the mean square of the difference of two pictures' display values (sRGB as they are
/// shown, 0 to 1), over all pixels and channels.
///
/// # Panics
/// If the pictures' sizes differ.
pub fn rmse(a: &RgbImage, b: &RgbImage) -> f64 {
    assert_same_size(a, b);
    let square = |(a, b): (&u8, &u8)| u64::from(a.abs_diff(*b)).pow(2);
    let sum: u64 = a.iter().zip(b.iter()).map(square).sum();
    (sum as f64 / a.len().max(1) as f64).sqrt() / 255.0
}

/// How different two pictures look.
#[derive(Clone, Debug, PartialEq)]
pub struct Flip {
    /// The mean of the map, 0 (the same) to 1.
    pub mean: f64,
    /// Where they look different: from black (not at all) over violet and orange to bright yellow.
    pub map: RgbImage,
}

/// The difference that an eye sees when the pictures alternate in one place: LDR-FLIP (Andersson et
/// al., "FLIP: A Difference Evaluator for Alternating Images", 2020, doi 10.1145/3406183), by the
/// authors' own code, at 67 pixels a degree of view (a 0.7 m wide 4K screen seen from 0.7 m).
///
/// # Panics
/// If the pictures' sizes differ, or they have no pixel.
pub fn flip(reference: &RgbImage, test: &RgbImage) -> Flip {
    assert_same_size(reference, test);
    let (width, height) = reference.dimensions();
    let [reference, test] =
        [reference, test].map(|image| FlipImageRgb8::with_data(width, height, image.as_raw()));
    let errors = nv_flip::flip(reference, test, DEFAULT_PIXELS_PER_DEGREE);
    let map = errors.apply_color_lut(&magma_lut()).to_vec();
    Flip {
        mean: FlipPool::from_image(&errors).mean().into(),
        map: RgbImage::from_raw(width, height, map).expect("as many pixels as there were"),
    }
}

fn assert_same_size(a: &RgbImage, b: &RgbImage) {
    assert_eq!(
        a.dimensions(),
        b.dimensions(),
        "pictures of different sizes"
    );
}

#[cfg(test)]
mod tests {
    use image::Rgb;

    use super::*;

    fn plain(color: [u8; 3]) -> RgbImage {
        RgbImage::from_pixel(24, 20, Rgb(color))
    }

    #[test]
    fn a_picture_is_not_different_from_itself() {
        let image = RgbImage::from_fn(31, 17, |x, y| Rgb([x as u8, 9 * y as u8, (x * y) as u8]));
        assert_eq!(rmse(&image, &image), 0.0);
        let flip = flip(&image, &image);
        assert_eq!(flip.mean, 0.0);
        assert_eq!(flip.map.dimensions(), (31, 17));
        assert!(flip.map.pixels().all(|p| p.0[0] < 4), "black all over");
    }

    #[test]
    fn the_root_mean_square_is_of_all_channels() {
        assert_eq!(rmse(&plain([0; 3]), &plain([255; 3])), 1.0);
        let one = rmse(&plain([10, 20, 30]), &plain([10, 20, 81]));
        assert!((one - 0.2 / 3_f64.sqrt()).abs() < 1e-12, "{one}");
    }

    /// The paper's scale ends where plain green and plain blue are: equation 7 and the text after it.
    #[test]
    fn plain_green_and_plain_blue_differ_by_one() {
        let flip = flip(&plain([0, 255, 0]), &plain([0, 0, 255]));
        assert!((flip.mean - 1.0).abs() < 1e-5, "{}", flip.mean);
        let bright = flip.map.get_pixel(9, 9).0;
        assert!(bright[0] > 240 && bright[1] > 240, "{bright:?}");
    }

    #[test]
    fn a_greater_difference_is_a_greater_error() {
        let error = |grey: u8| flip(&plain([100; 3]), &plain([grey; 3])).mean;
        assert!(error(110) < error(120) && error(120) < error(200));
    }

    #[test]
    #[should_panic(expected = "different sizes")]
    fn sizes_must_agree() {
        rmse(&plain([0; 3]), &RgbImage::new(3, 3));
    }
}
