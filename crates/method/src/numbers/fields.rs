//! Numbers of a struct, one after the other.

use super::scalar::Constant;
use super::vector::Vector;

/// Sees every number that rays ask for of a patch, each at its place.
pub(crate) trait Visitor<S: Constant> {
    fn number(&mut self, at: usize, number: &mut S);
    fn truth(&mut self, at: usize, truth: &mut S::Mask);

    #[inline(always)]
    fn vector(&mut self, at: usize, vector: &mut Vector<S>) {
        self.number(at, &mut vector.x);
        self.number(at + 1, &mut vector.y);
        self.number(at + 2, &mut vector.z);
    }
}
