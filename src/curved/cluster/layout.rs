//! How a cluster is stored.
//!
//! A cluster has directions of its own: along the sum of its triangles' normals, where neighbours are thin,
//! and across two edges of one of them. Boxes along the axes of space let half as many more rays through. A
//! triangle's box is what lies between two values along each of three directions, which need not be
//! perpendicular. Along a fourth, across the longest edge, only one end counts: it cuts off the half of the
//! box that the triangle leaves empty. At the other end there is but a corner; nearly nothing could be cut off.

use glam::Vec3;

use crate::embree::Bounds;
use curvetri_method::PATCHES;

/// Most triangles of a cluster.
pub(in crate::curved) const SIZE: usize = 8;
/// Stands for "none" where a cluster has fewer triangles.
pub(super) const NONE: u32 = u32::MAX;
/// Directions along which boxes have ends.
pub(super) const DIRECTIONS: usize = 4;
/// The direction along which boxes have one end only. The other is beyond the cluster.
pub(super) const CUT: usize = DIRECTIONS - 1;
/// Half the width of every box along [`CUT`], in half steps.
pub(super) const CUT_HALF: u8 = 127;
/// A direction's components are stored in units of one over this.
pub(super) const DIGITS: f32 = 128.0;
/// All places of a cluster, one bit each.
const ALL: u32 = u32::MAX >> (u32::BITS as usize - SIZE);

/// Some neighbouring triangles and their boxes.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(in crate::curved) struct Cluster {
    /// The middle of the common box along the axes of space.
    pub(super) middle: [f32; 3],
    /// Half the extents of the common box.
    pub(super) half: [RoundedUp; 3],
    /// A step along each direction.
    pub(super) step: [RoundedUp; DIRECTIONS],
    /// The directions: their x components, then y, then z.
    pub(super) directions: [[i8; DIRECTIONS]; 3],
    /// The boxes' middles along each direction, in steps from the cluster's middle.
    pub(super) middles: [[i8; SIZE]; DIRECTIONS],
    /// Half the boxes' widths along each direction but [`CUT`], in half steps.
    pub(super) halves: [[u8; SIZE]; CUT],
    /// The triangles' numbers in the mesh.
    pub(super) triangles: [u32; SIZE],
}

const _: () = assert!(size_of::<Cluster>() == 128 && SIZE == PATCHES);

/// A number of 0 or more as bfloat16, the upper half of an `f32`, rounded up.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RoundedUp(pub(super) u16);

impl RoundedUp {
    pub(super) fn new(number: f32) -> Self {
        let bits = number.to_bits();
        // Beyond the greatest number it is infinite, as it should be.
        Self(bits.div_ceil(1 << 16) as u16)
    }

    #[inline(always)]
    pub(super) fn get(self) -> f32 {
        f32::from_bits(u32::from(self.0) << 16)
    }
}

impl Cluster {
    /// The common box's middle, from which steps are counted.
    #[inline(always)]
    pub fn middle(&self) -> Vec3 {
        self.middle.into()
    }

    /// Half the common box's extents.
    #[inline(always)]
    fn half(&self) -> Vec3 {
        let [x, y, z] = self.half;
        Vec3::new(x.get(), y.get(), z.get())
    }

    /// The greatest distance from the middle to where a triangle may be, along any direction.
    #[inline(always)]
    pub fn extent(&self) -> f32 {
        self.half().element_sum()
    }

    /// One of the directions; its length is about one.
    #[inline(always)]
    pub fn direction(&self, axis: usize) -> Vec3 {
        let [x, y, z] = self.directions.map(|component| f32::from(component[axis]));
        Vec3::new(x, y, z) * (1.0 / DIGITS)
    }

    /// One component of all directions.
    #[inline(always)]
    pub fn components(&self, component: usize) -> [f32; DIRECTIONS] {
        self.directions[component].map(|digits| f32::from(digits) * (1.0 / DIGITS))
    }

    /// A step along each of the directions.
    #[inline(always)]
    pub fn step(&self) -> [f32; DIRECTIONS] {
        let [a, b, c, d] = self.step;
        [a.get(), b.get(), c.get(), d.get()]
    }

    /// The boxes along a direction: their middles, in steps from the cluster's, and half their widths, in half
    /// steps.
    #[inline(always)]
    pub fn ranges_in_steps(&self, axis: usize) -> [[f32; SIZE]; 2] {
        let halves = self.halves.get(axis).unwrap_or(&[CUT_HALF; SIZE]);
        let [mut middle, mut half] = [[0.0; SIZE]; 2];
        for n in 0..SIZE {
            (middle[n], half[n]) = (self.middles[axis][n].into(), halves[n].into());
        }
        [middle, half]
    }

    /// The box of all its triangles.
    pub fn bounds(&self) -> Bounds {
        let (middle, half) = (self.middle(), self.half());
        let (lower, upper) = (middle - half, middle + half);
        Bounds {
            // The next numbers, as the ends are rounded.
            lower: lower.to_array().map(f32::next_down).into(),
            upper: upper.to_array().map(f32::next_up).into(),
        }
    }

    /// The number of the triangle at place `n`.
    pub fn triangle(&self, n: usize) -> u32 {
        self.triangles[n]
    }

    /// The places that hold a triangle, one bit each.
    pub fn present(&self) -> u32 {
        let missing = self.triangles.iter().filter(|&&triangle| triangle == NONE);
        ALL >> missing.count()
    }
}
