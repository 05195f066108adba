//! The kernel's own three-vector, over any [`Real`].

use std::ops::{Add, Mul, Neg, Sub};

use super::scalar::{Arithmetic, Real, Scalar};

/// A vector or point of three-dimensional space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vector<R> {
    /// First component.
    pub x: R,
    /// Second component.
    pub y: R,
    /// Third component.
    pub z: R,
}

/// A vector from its components.
#[inline(always)]
pub const fn vector<R>(x: R, y: R, z: R) -> Vector<R> {
    Vector { x, y, z }
}

impl<R: Arithmetic> Vector<R> {
    /// The scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> R {
        let rest = self.y.mul_add(other.y, self.z * other.z);
        self.x.mul_add(other.x, rest)
    }
    /// `self * factor + term`.
    #[inline(always)]
    pub fn mul_add(self, factor: R, term: Self) -> Self {
        vector(
            self.x.mul_add(factor, term.x),
            self.y.mul_add(factor, term.y),
            self.z.mul_add(factor, term.z),
        )
    }
    /// The vector product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        vector(
            self.y.mul_sub(other.z, self.z * other.y),
            self.z.mul_sub(other.x, self.x * other.z),
            self.x.mul_sub(other.y, self.y * other.x),
        )
    }
    /// The components as an array.
    #[inline(always)]
    pub fn to_array(self) -> [R; 3] {
        [self.x, self.y, self.z]
    }
}

impl<R: Real> Vector<R> {
    /// The largest absolute component.
    #[inline(always)]
    pub fn max_abs(self) -> R {
        self.x.abs().greater(self.y.abs()).greater(self.z.abs())
    }
    /// The Euclidean length.
    #[inline(always)]
    pub fn length(self) -> R {
        self.dot(self).sqrt()
    }
    /// The same scalar vector in every lane of a value like this one.
    #[inline(always)]
    pub fn splat(lanes: R, v: Vector<R::Scalar>) -> Self {
        vector(lanes.splat(v.x), lanes.splat(v.y), lanes.splat(v.z))
    }
    /// The same two scalar vectors in every lane of a value like this one.
    #[inline(always)]
    pub(crate) fn splat_both(lanes: R, [a, b]: [Vector<R::Scalar>; 2]) -> [Self; 2] {
        [Self::splat(lanes, a), Self::splat(lanes, b)]
    }
    /// The vector of length 1 in this direction; not finite for the zero vector.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        let length = self.length();
        self * (length.one() / length)
    }
}

impl<R: Scalar> Vector<R> {
    /// Rounded from `f64`.
    pub fn from_f64(v: Vector<f64>) -> Self {
        vector(R::from_f64(v.x), R::from_f64(v.y), R::from_f64(v.z))
    }
    /// The same vector as `f64`; exact.
    pub fn to_f64(self) -> Vector<f64> {
        vector(self.x.to_f64(), self.y.to_f64(), self.z.to_f64())
    }
    /// Whether no component is infinite or NaN.
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.z.is_finite()
    }
}

impl<R: Arithmetic> Add for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        vector(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<R: Arithmetic> Sub for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        vector(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<R: Arithmetic> Neg for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        vector(-self.x, -self.y, -self.z)
    }
}

impl<R: Arithmetic> Mul<R> for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: R) -> Self {
        vector(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl From<glam::Vec3> for Vector<f32> {
    #[inline(always)]
    fn from(v: glam::Vec3) -> Self {
        vector(v.x, v.y, v.z)
    }
}

impl From<Vector<f32>> for glam::Vec3 {
    #[inline(always)]
    fn from(v: Vector<f32>) -> Self {
        glam::vec3(v.x, v.y, v.z)
    }
}

impl From<glam::DVec3> for Vector<f64> {
    #[inline(always)]
    fn from(v: glam::DVec3) -> Self {
        vector(v.x, v.y, v.z)
    }
}

impl From<Vector<f64>> for glam::DVec3 {
    #[inline(always)]
    fn from(v: Vector<f64>) -> Self {
        glam::dvec3(v.x, v.y, v.z)
    }
}

impl From<glam::Vec3> for Vector<f64> {
    #[inline(always)]
    fn from(v: glam::Vec3) -> Self {
        vector(v.x.into(), v.y.into(), v.z.into())
    }
}
