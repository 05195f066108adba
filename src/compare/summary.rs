//! A few numbers for many.

use serde::Serialize;

/// Three numbers that sum up weighted values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Their mean, by weight.
    pub mean: f64,
    /// The value that those with 95 % of the weight do not exceed.
    pub p95: f64,
    /// The greatest.
    pub max: f64,
}

impl Summary {
    /// Sums up values with their weights of 0 or more; `None` without weight.
    pub fn of(mut weighted: Vec<[f64; 2]>) -> Option<Self> {
        let total: f64 = weighted.iter().map(|[_, weight]| weight).sum();
        if total.is_nan() || total <= 0.0 {
            return None;
        }
        weighted.sort_unstable_by(|[a, _], [b, _]| a.total_cmp(b));
        let sum: f64 = weighted.iter().map(|[value, weight]| value * weight).sum();
        let mut below = 0.0;
        let p95 = weighted.iter().find(|[_, weight]| {
            below += weight;
            below >= 0.95 * total
        });
        let max = weighted.last()?[0];
        Some(Self {
            mean: sum / total,
            p95: p95.map_or(max, |[value, _]| *value),
            max,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_count() {
        let summary = Summary::of(vec![[8.0, 1.0], [1.0, 90.0], [3.0, 9.0]]).unwrap();
        assert_eq!((summary.p95, summary.max), (3.0, 8.0));
        assert!((summary.mean - 1.25).abs() < 1e-12);
    }

    #[test]
    fn nothing_has_no_summary() {
        assert_eq!(Summary::of(vec![]), None);
        assert_eq!(Summary::of(vec![[7.0, 0.0]]), None);
    }
}
