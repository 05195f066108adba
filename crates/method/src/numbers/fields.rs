//! The one way between structs and arrays, columns and SIMD lanes: a cursor that goes over the numbers of a
//! struct in the order in which the struct shows them.

use super::scalar::Real;
use super::vector::Vector;

/// Reads or writes the numbers of a struct, one after the other.
pub(crate) trait Cursor<V: Real> {
    /// The next number.
    fn number(&mut self, number: &mut V);
    /// The next truth value, which takes the place of a number.
    fn truth(&mut self, truth: &mut V::Mask);

    /// The next three numbers.
    #[inline(always)]
    fn vector(&mut self, vector: &mut Vector<V>) {
        self.number(&mut vector.x);
        self.number(&mut vector.y);
        self.number(&mut vector.z);
    }
}

/// A struct of numbers.
pub(crate) trait Fields<V: Real>: Copy {
    /// How many numbers there are.
    const COUNT: usize;
    /// Shows all numbers, always in the same order.
    fn visit(&mut self, cursor: &mut impl Cursor<V>);
}

/// The numbers of a struct as an array.
#[inline(always)]
pub(crate) fn to_array<V: Real, const N: usize>(mut of: impl Fields<V>, any: V) -> [V; N] {
    let mut numbers = [any; N];
    let mut to = Write {
        numbers: &mut numbers,
        next: 0,
    };
    of.visit(&mut to);
    debug_assert_eq!(to.next, N);
    numbers
}

/// A struct of these numbers; `blank` is any of its kind.
#[inline(always)]
pub(crate) fn from_array<V: Real, F: Fields<V>, const N: usize>(
    mut blank: F,
    numbers: &[V; N],
) -> F {
    const { assert!(N == F::COUNT) };
    blank.visit(&mut Read { numbers, next: 0 });
    blank
}

struct Write<'a, V, const N: usize> {
    numbers: &'a mut [V; N],
    next: usize,
}

impl<V: Real, const N: usize> Cursor<V> for Write<'_, V, N> {
    #[inline(always)]
    fn number(&mut self, number: &mut V) {
        self.numbers[self.next] = *number;
        self.next += 1;
    }

    #[inline(always)]
    fn truth(&mut self, truth: &mut V::Mask) {
        let any = self.numbers[self.next];
        self.number(&mut V::select(*truth, any.one(), any.zero()));
    }
}

struct Read<'a, V, const N: usize> {
    numbers: &'a [V; N],
    next: usize,
}

impl<V: Real, const N: usize> Cursor<V> for Read<'_, V, N> {
    #[inline(always)]
    fn number(&mut self, number: &mut V) {
        *number = self.numbers[self.next];
        self.next += 1;
    }

    #[inline(always)]
    fn truth(&mut self, truth: &mut V::Mask) {
        let number = self.numbers[self.next];
        *truth = number.zero().less(number);
        self.next += 1;
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    struct Count(usize);

    impl<V: Real> Cursor<V> for Count {
        fn number(&mut self, _: &mut V) {
            self.0 += 1;
        }
        fn truth(&mut self, _: &mut V::Mask) {
            self.0 += 1;
        }
    }

    /// Checks that a struct shows as many numbers as it says.
    pub fn assert_counted<F: Fields<f32>>(mut of: F) {
        let mut count = Count(0);
        of.visit(&mut count);
        assert_eq!(count.0, F::COUNT);
    }
}
