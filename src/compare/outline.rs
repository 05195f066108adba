//! Outlines in a picture, and the distance between them.

use glam::Vec2;
use rayon::prelude::*;
use rstar::primitives::Line;
use rstar::{PointDistance, RTree};

use super::summary::Summary;

/// Halvings of the way between two pixels' middles: an outline is known to within 1/1024 pixel there.
const HALVINGS: usize = 10;

/// Where a body ends in a picture: the line between the points where it is seen and those where it
/// is not, in pixels from the picture's upper left corner.
///
/// It has one point on each line between the middles of neighbouring pixels of which one sees the
/// body, and is straight from point to point. The picture's own edge is no outline.
#[derive(Clone, Debug)]
pub struct Outline {
    segments: RTree<Line<[f32; 2]>>,
}

impl Outline {
    /// The outline of whatever is `inside`. That function gets points of the picture, in pixels from its
    /// upper left corner. What is narrower than a pixel may be missed.
    pub fn new(width: usize, height: usize, inside: impl Fn(Vec2) -> bool + Sync) -> Self {
        let middle = |n: usize| Vec2::new((n % width) as f32 + 0.5, (n / width) as f32 + 0.5);
        let mask: Vec<bool> = (0..width * height)
            .into_par_iter()
            .map(|n| inside(middle(n)))
            .collect();
        let segments: Vec<Line<[f32; 2]>> = (0..height.saturating_sub(1))
            .into_par_iter()
            .flat_map_iter(|y| (0..width.saturating_sub(1)).map(move |x| y * width + x))
            .flat_map_iter(|n| {
                let corners = [n, n + 1, n + width + 1, n + width];
                let corners = corners.map(|corner| (middle(corner), mask[corner]));
                segments_of_cell(corners, &inside).into_iter().flatten()
            })
            .filter(|[a, b]| a != b)
            .map(|[a, b]| Line::new(a.into(), b.into()))
            .collect();
        Self {
            segments: RTree::bulk_load(segments),
        }
    }

    /// Whether there is none: the body is not in the picture, or fills it.
    pub fn is_empty(&self) -> bool {
        self.segments.size() == 0
    }

    /// The distance between the outlines, in pixels: from each point of either to the nearest of the
    /// other, by length. The greatest is the Hausdorff distance. `None` if there is not one of either.
    pub fn distance(&self, other: &Self) -> Option<Summary> {
        if self.is_empty() || other.is_empty() {
            return None;
        }
        let mut distances = self.distances_to(other);
        distances.extend(other.distances_to(self));
        Summary::of(distances)
    }

    /// The distance of each segment's middle to the other outline, with the segment's length.
    fn distances_to(&self, other: &Self) -> Vec<[f64; 2]> {
        let segments: Vec<_> = self.segments.iter().collect();
        segments
            .par_iter()
            .map(|segment| {
                let [from, to] = [segment.from, segment.to].map(Vec2::from);
                let middle: [f32; 2] = from.midpoint(to).into();
                let nearest = other.segments.nearest_neighbor(&middle);
                let nearest = nearest.expect("the other outline is not empty");
                let distance = nearest.distance_2(&middle).sqrt();
                [distance.into(), from.distance(to).into()]
            })
            .collect()
    }
}

/// The outline between the middles of four neighbouring pixels, given around their cell.
fn segments_of_cell(
    corners: [(Vec2, bool); 4],
    inside: &impl Fn(Vec2) -> bool,
) -> [Option<[Vec2; 2]>; 2] {
    let crossings: [Option<Vec2>; 4] = std::array::from_fn(|side| {
        let [(a, a_inside), (b, b_inside)] = [corners[side], corners[(side + 1) % 4]];
        match (a_inside, b_inside) {
            (true, false) => Some(crossing(a, b, inside)),
            (false, true) => Some(crossing(b, a, inside)),
            _ => None,
        }
    });
    match crossings {
        [Some(a), Some(b), Some(c), Some(d)] => {
            // Two corners that face each other are inside: does the body go on between them?
            let middle = inside(corners[0].0.midpoint(corners[2].0));
            if middle == corners[0].1 {
                [Some([a, b]), Some([c, d])]
            } else {
                [Some([d, a]), Some([b, c])]
            }
        }
        _ => {
            let mut ends = crossings.into_iter().flatten();
            [ends.next().zip(ends.next()).map(|(a, b)| [a, b]), None]
        }
    }
}

/// Where the body ends on the way from a point inside to one outside.
fn crossing(mut within: Vec2, mut out: Vec2, inside: &impl Fn(Vec2) -> bool) -> Vec2 {
    for _ in 0..HALVINGS {
        let middle = within.midpoint(out);
        *(if inside(middle) {
            &mut within
        } else {
            &mut out
        }) = middle;
    }
    within.midpoint(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc(centre: [f32; 2], radius: f32) -> Outline {
        Outline::new(90, 80, move |p| p.distance(centre.into()) < radius)
    }

    #[test]
    fn an_outline_is_not_off_itself() {
        let distance = disc([40.0, 40.0], 30.0).distance(&disc([40.0, 40.0], 30.0));
        assert!(distance.unwrap().max < 1e-5, "{distance:?}");
    }

    #[test]
    fn concentric_circles_are_as_far_apart_as_their_radii_differ() {
        let distance = disc([40.2, 39.7], 30.0).distance(&disc([40.2, 39.7], 28.5));
        let Summary { mean, p95, max } = distance.unwrap();
        for value in [mean, p95, max] {
            assert!((value - 1.5).abs() < 0.02, "{distance:?}");
        }
    }

    #[test]
    fn a_shifted_half_plane_is_off_by_the_shift_and_shifts_less_than_a_pixel_show() {
        let half = |shift: f32| {
            let normal = Vec2::new(0.6, 0.8);
            Outline::new(70, 50, move |p| p.dot(normal) < 40.0 + shift)
        };
        for shift in [0.05, 0.3, 4.0] {
            let distance = half(0.0).distance(&half(shift)).unwrap();
            // at the picture's edge the nearest point is beyond it
            assert!(
                (distance.mean - f64::from(shift)).abs() < 0.05 * f64::from(shift) + 2e-3,
                "{distance:?}"
            );
        }
    }

    #[test]
    fn a_shifted_disc_is_off_by_the_shift_at_the_most_and_two_over_pi_of_it_on_average() {
        let distance = disc([40.0, 40.0], 30.0).distance(&disc([41.0, 40.0], 30.0));
        let Summary { mean, max, .. } = distance.unwrap();
        let expected = 2.0 / std::f64::consts::PI;
        assert!((mean - expected).abs() < 0.01, "{distance:?}");
        assert!((max - 1.0).abs() < 0.01, "{distance:?}");
    }

    #[test]
    fn a_part_that_the_other_outline_lacks_is_found_from_either_side() {
        let far = |p: Vec2| p.distance(Vec2::new(70.0, 20.0)) < 3.0;
        let near = |p: Vec2| p.distance(Vec2::new(20.0, 20.0)) < 10.0;
        let one = Outline::new(90, 80, near);
        let two = Outline::new(90, 80, |p| near(p) || far(p));
        let [a, b] = [one.distance(&two), two.distance(&one)].map(Option::unwrap);
        assert_eq!(a, b);
        assert!((a.max - 43.0).abs() < 0.05, "{a:?}");
    }

    #[test]
    fn corners_that_touch_are_parted_or_joined_as_the_middle_says() {
        let chequered = |p: Vec2| (p.x < 1.0) == (p.y < 1.0);
        let joined = |p: Vec2| chequered(p) || p.distance(Vec2::ONE) < 0.3;
        let parted = |p: Vec2| chequered(p) && p.distance(Vec2::ONE) > 0.3;
        // The lines go around the corners outside, or around those inside.
        let away = |outline: &Outline, p: [f32; 2]| {
            let nearest = outline.segments.nearest_neighbor(&p).unwrap();
            nearest.distance_2(&p).sqrt()
        };
        let [joined, parted] = [Outline::new(2, 2, joined), Outline::new(2, 2, parted)];
        assert_eq!(joined.segments.size(), 2);
        assert_eq!(parted.segments.size(), 2);
        // (0.5, 0.5) is inside: joined corners have their line further away than parted ones.
        assert!(away(&joined, [0.5, 0.5]) > away(&parted, [0.5, 0.5]));
    }

    #[test]
    fn nothing_and_all_have_no_outline() {
        let [nothing, all] = [false, true].map(|seen| Outline::new(5, 4, move |_| seen));
        assert!(nothing.is_empty() && all.is_empty());
        assert_eq!(nothing.distance(&disc([9.0, 9.0], 4.0)), None);
        assert!(Outline::new(1, 1, |_| true).is_empty());
    }
}
