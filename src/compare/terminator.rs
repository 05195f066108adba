//! The shadow terminator: where light ends on a body, and where flat triangles end it too soon.

use image::{Rgb, RgbImage};
use serde::Serialize;

use super::probe::{Probe, ProbedSurface, Sun};

/// What marks darkened pixels: a red that neither light nor dark surfaces have.
const MARK: Rgb<u8> = Rgb([230, 30, 40]);

/// Pixels that a form darkens although the sun shines there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Darkened {
    /// Pixels whose middle sees both surfaces, and where the sun shines on the true one.
    pub lit: usize,
    /// Those among them where the form's shading normal faces the sun but its own triangles, or
    /// those of the meshes beside it, are in the light's way.
    pub darkened: usize,
}

impl Darkened {
    /// The share of lit pixels that are darkened, 0 to 1.
    pub fn share(&self) -> f64 {
        self.darkened as f64 / self.lit.max(1) as f64
    }
}

/// Counts the pixels that a form darkens although the sun shines on the true surface there.
///
/// # Panics
/// If the probes' sizes differ.
pub fn darkened(form: &Probe, truth: &Probe) -> Darkened {
    let both = form.both(truth);
    both.fold(Darkened::default(), |count, (form, truth)| Darkened {
        lit: count.lit + usize::from(truth.sun == Sun::Shines),
        darkened: count.darkened + usize::from(is_darkened(form, truth)),
    })
}

/// The picture with its darkened pixels marked in red.
///
/// # Panics
/// If the sizes differ.
pub fn marked(picture: &RgbImage, form: &Probe, truth: &Probe) -> RgbImage {
    let mut marked = picture.clone();
    let pairs = form.beside(truth);
    assert_eq!(marked.pixels().len(), form.seen().len(), "another size");
    for (pixel, pair) in marked.pixels_mut().zip(pairs) {
        if let (Some(form), Some(truth)) = pair
            && is_darkened(form, truth)
        {
            *pixel = MARK;
        }
    }
    marked
}

fn is_darkened(form: &ProbedSurface, truth: &ProbedSurface) -> bool {
    truth.sun == Sun::Shines && form.sun == Sun::Blocked
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn probe(suns: &[Option<Sun>]) -> Probe {
        let seen = |sun: &Option<Sun>| {
            sun.map(|sun| ProbedSurface {
                geometric: Vec3::Z,
                shading: Vec3::Z,
                sun,
            })
        };
        Probe::of(suns.len(), suns.iter().map(seen).collect())
    }

    #[test]
    fn only_pixels_that_the_sun_reaches_and_both_see_count() {
        use Sun::{Behind, Blocked, Shines};
        let truth = [
            Some(Shines),
            Some(Shines),
            Some(Shines),
            Some(Blocked),
            Some(Behind),
            Some(Shines),
            None,
        ];
        let form = [
            Some(Blocked),
            Some(Shines),
            Some(Behind),
            Some(Blocked),
            Some(Blocked),
            None,
            Some(Blocked),
        ];
        let [truth, form] = [&truth, &form].map(|suns| probe(suns));
        let count = darkened(&form, &truth);
        assert_eq!(
            count,
            Darkened {
                lit: 3,
                darkened: 1
            }
        );
        assert!((count.share() - 1.0 / 3.0).abs() < 1e-12);
        assert_eq!(darkened(&truth, &truth).darkened, 0);
        let picture = marked(&RgbImage::new(7, 1), &form, &truth);
        let red: Vec<u32> = picture
            .enumerate_pixels()
            .filter(|(_, _, p)| **p == MARK)
            .map(|(x, ..)| x)
            .collect();
        assert_eq!(red, [0]);
    }

    #[test]
    fn nothing_lit_is_nothing_darkened() {
        assert_eq!(Darkened::default().share(), 0.0);
    }
}
