//! Whether an outline crosses itself, so that cutting its ears is of no use.
//!
//! Ear cutting takes long where it fails: cubic time in the number of corners. So large outlines are
//! looked at before.

use std::collections::HashSet;

use glam::DVec2;

/// How many pairs of edges are looked at, at most, for each outline. All pairs of an outline of
/// eight thousand corners are fewer.
const MAX_PAIRS: usize = 1 << 25;

/// Edges cross if their ends lie on different sides of each other by more than this share of the
/// outline's size squared: less may be rounding where they touch.
const CERTAIN: f64 = 1e-10;

/// Whether two edges of a closed outline certainly cross, or one is there twice in the same
/// direction. An outline that is too large to tell counts as crossing.
pub(super) fn crosses_itself(outline: &[[f64; 2]]) -> bool {
    repeats_an_edge(outline) || has_a_crossing(outline)
}

fn edges(outline: &[[f64; 2]]) -> impl Iterator<Item = [[f64; 2]; 2]> {
    (0..outline.len()).map(|k| [outline[k], outline[(k + 1) % outline.len()]])
}

fn repeats_an_edge(outline: &[[f64; 2]]) -> bool {
    let mut known = HashSet::with_capacity(outline.len());
    let bits = |edge: [[f64; 2]; 2]| edge.map(|p| p.map(|x| (x + 0.0).to_bits()));
    edges(outline).any(|edge| edge[0] != edge[1] && !known.insert(bits(edge)))
}

fn has_a_crossing(outline: &[[f64; 2]]) -> bool {
    let mut edges: Vec<[DVec2; 2]> = edges(outline).map(|e| e.map(DVec2::from)).collect();
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for [a, _] in &edges {
        (low, high) = (low.min(*a), high.max(*a));
    }
    let certain = CERTAIN * (high - low).length_squared();
    // Along the longer axis, where fewer edges lie beside each other; rising.
    let along = if high.x - low.x >= high.y - low.y {
        0
    } else {
        1
    };
    for edge in &mut edges {
        if edge[0][along] > edge[1][along] {
            edge.swap(0, 1);
        }
    }
    edges.sort_unstable_by(|a, b| a[0][along].total_cmp(&b[0][along]));
    let mut pairs = 0;
    for (k, edge) in edges.iter().enumerate() {
        let beside = edges[k + 1..].iter();
        for other in beside.take_while(|other| other[0][along] <= edge[1][along]) {
            pairs += 1;
            if pairs > MAX_PAIRS || cross(edge, other, certain) {
                return true;
            }
        }
    }
    false
}

/// Whether each edge's ends certainly lie on different sides of the other.
fn cross(a: &[DVec2; 2], b: &[DVec2; 2], certain: f64) -> bool {
    parts(a, b, certain) && parts(b, a, certain)
}

fn parts([from, to]: &[DVec2; 2], other: &[DVec2; 2], certain: f64) -> bool {
    let [one, two] = other.map(|p| (to - from).perp_dot(p - from));
    one > certain && two < -certain || one < -certain && two > certain
}

#[cfg(test)]
mod tests {
    use super::*;

    fn around(n: u32, point: impl Fn(f64) -> [f64; 2]) -> Vec<[f64; 2]> {
        (0..n).map(|k| point(f64::from(k))).collect()
    }

    #[test]
    fn outlines_that_do_not_cross_are_left_to_the_ears() {
        let zigzag = |k: f64| [k, if k % 2.0 == 0.0 { 1.0 } else { 3.0 }];
        let mut comb = around(999, zigzag);
        comb.extend([[998.0, -1.0], [0.0, -1.0]]);
        assert!(!crosses_itself(&comb));
        // There and back on a line, around a hole, and back over the same edge.
        let keyhole = [
            [0., 0.],
            [4., 0.],
            [4., 4.],
            [0., 4.],
            [0., 0.],
            [1., 1.],
            [1., 3.],
            [3., 3.],
            [3., 1.],
            [1., 1.],
        ];
        assert!(!crosses_itself(&keyhole));
        assert!(!crosses_itself(&[[1.0, 1.0]; 500]));
        let spiral = |k: f64| {
            let out = if k < 500.0 { k } else { 999.5 - k };
            [out * (0.1 * k).cos(), out * (0.1 * k).sin()]
        };
        assert!(crosses_itself(&around(1000, spiral)));
    }

    #[test]
    fn stars_bows_and_repeated_rounds_cross() {
        let star = around(501, |k| (2.4 * k).sin_cos().into());
        assert!(crosses_itself(&star));
        assert!(crosses_itself(&[[0., 0.], [1., 1.], [1., 0.], [0., 1.]]));
        let square = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]];
        assert!(crosses_itself(&square.repeat(100)));
    }

    #[test]
    fn numbers_that_are_not_finite_make_no_panic() {
        for odd in [f64::NAN, f64::INFINITY, 1e300, -1e300] {
            let mut outline = around(300, |k| (0.02 * k).sin_cos().into());
            outline[7] = [odd, 0.0];
            crosses_itself(&outline);
        }
    }
}
