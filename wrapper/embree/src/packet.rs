//! Packets of 1, 4, 8 or 16 rays with their hits, in Embree's layout.

use std::mem::{offset_of, size_of};

use glam::Vec3;

use super::bindings::{embree_3, embree_4};
use super::ray::{Hit, LARGEST_COMPONENT, LEAST_COMPONENT, Ray};
use super::record::HIT_FIELDS;
use super::sys::{INVALID_ID, LEVELS};

/// Names a packet's width in bounds: `Width<N>: Traced` holds for 1, 4, 8 and 16.
///
/// ```
/// use curvetri_embree::{QueryOptions, Ray, RayPacket, Scene, Traced, Width};
///
/// fn count_hits<const N: usize>(scene: &Scene, rays: &[Ray]) -> u32
/// where
///     Width<N>: Traced,
/// {
///     let shadow = |rays: &[Ray]| {
///         let mut packet = RayPacket::<N>::from_rays(rays);
///         scene.occluded(&mut packet, &QueryOptions::INCOHERENT).count_ones()
///     };
///     rays.chunks(N).map(shadow).sum()
/// }
/// ```
pub struct Width<const N: usize>;

/// The widths Embree traces.
pub trait Traced: sealed::Sealed {}

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Width<1> {}
    impl Sealed for super::Width<4> {}
    impl Sealed for super::Width<8> {}
    impl Sealed for super::Width<16> {}
}

impl Traced for Width<1> {}
impl Traced for Width<4> {}
impl Traced for Width<8> {}
impl Traced for Width<16> {}

/// A packet of `N` rays (1, 4, 8 or 16) with room for their hits.
///
/// Lanes begin empty: an empty lane is not traced, and nothing of it is changed. The fields are
/// Embree's own arrays, aligned for every width, so that they can be filled and read lane by lane or
/// many at a time.
///
/// ```
/// use curvetri_embree::{QueryOptions, Ray, RayPacket, SceneBuilder};
/// use glam::Vec3;
///
/// let device = curvetri_embree_linked::device()?;
/// let empty = SceneBuilder::new(&device)?.commit()?;
/// let mut packet = RayPacket::<4>::from_rays(&[Ray::new(Vec3::ZERO, Vec3::X); 3]);
/// assert_eq!(packet.active(), 0b0111);
/// empty.intersect(&mut packet, &QueryOptions::default());
/// assert_eq!(packet.hit(0), None);
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
#[derive(Clone)]
#[repr(C, align(64))]
pub struct RayPacket<const N: usize> {
    /// The rays. A query shortens `tfar` to the hit, or sets it to -infinity where a ray is occluded.
    pub rays: Rays<N>,
    /// The hits of the last [`intersect`](super::Scene::intersect).
    pub hits: Hits<N>,
    active: Active,
}

/// One bit a lane. Aligned so that it lies behind the padding of Embree's own structs.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
struct Active(u32);

/// The rays of a packet, component by component.
///
/// ```
/// use curvetri_embree::RayPacket;
///
/// let mut packet = RayPacket::<8>::new();
/// packet.rays.org_z = [-1.0; 8];
/// packet.rays.dir_z = [1.0; 8];
/// packet.rays.tnear = [0.0; 8];
/// packet.rays.tfar = [f32::INFINITY; 8];
/// packet.rays.mask = [!0; 8];
/// packet.set_active(0xff);
/// assert!(packet.ray(5).is_traceable());
/// ```
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Rays<const N: usize> {
    /// Origins' x.
    pub org_x: [f32; N],
    /// Origins' y.
    pub org_y: [f32; N],
    /// Origins' z.
    pub org_z: [f32; N],
    /// Where the rays begin.
    pub tnear: [f32; N],
    /// Directions' x.
    pub dir_x: [f32; N],
    /// Directions' y.
    pub dir_y: [f32; N],
    /// Directions' z.
    pub dir_z: [f32; N],
    /// Times in [0, 1].
    pub time: [f32; N],
    /// Where the rays end; after a query where they hit.
    pub tfar: [f32; N],
    /// Ray masks.
    pub mask: [u32; N],
    /// The caller's own numbers.
    pub id: [u32; N],
    /// For Embree's use; 0.
    pub flags: [u32; N],
}

/// The hits of a packet, component by component; undefined in lanes that missed, but for `geom_id`.
///
/// ```
/// use curvetri_embree::{Hit, RayPacket};
///
/// let packet = RayPacket::<8>::new();
/// assert_eq!(packet.hits.geom_id, [Hit::NONE; 8]);
/// ```
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Hits<const N: usize> {
    /// Normals' x.
    pub ng_x: [f32; N],
    /// Normals' y.
    pub ng_y: [f32; N],
    /// Normals' z.
    pub ng_z: [f32; N],
    /// First parameters.
    pub u: [f32; N],
    /// Second parameters.
    pub v: [f32; N],
    /// The primitives' numbers.
    pub prim_id: [u32; N],
    /// The geometries' numbers; [`Hit::NONE`] for a miss.
    pub geom_id: [u32; N],
    /// The instances' numbers by level.
    pub inst_id: [[u32; N]; LEVELS],
    /// The numbers in instance arrays by level. An Embree without them leaves this alone.
    inst_prim_id: [[u32; N]; LEVELS],
}

/// How many arrays the rays and the hits are.
const FIELDS: usize = 12 + HIT_FIELDS;

macro_rules! fits_embree {
    ($generation:ident, $width:literal, $ray:ident, $hit:ident, $rayhit:ident) => {
        const _: () = {
            use $generation::{$hit, $ray, $rayhit};
            assert!(size_of::<Rays<$width>>() == size_of::<$ray>());
            assert!(align_of::<RayPacket<$width>>() >= align_of::<$rayhit>());
            assert!(offset_of!(RayPacket<$width>, active) >= size_of::<$rayhit>());
            assert!(size_of::<Rays<$width>>() + size_of::<Hits<$width>>() == 4 * FIELDS * $width);
            assert!(offset_of!(RayPacket<$width>, hits) == offset_of!($rayhit, hit));
            assert!(offset_of!(Rays<$width>, tnear) == offset_of!($ray, tnear));
            assert!(offset_of!(Rays<$width>, dir_x) == offset_of!($ray, dir_x));
            assert!(offset_of!(Rays<$width>, tfar) == offset_of!($ray, tfar));
            assert!(offset_of!(Rays<$width>, flags) == offset_of!($ray, flags));
            assert!(offset_of!(Hits<$width>, ng_x) == offset_of!($hit, Ng_x));
            assert!(offset_of!(Hits<$width>, u) == offset_of!($hit, u));
            assert!(offset_of!(Hits<$width>, geom_id) == offset_of!($hit, geomID));
            assert!(offset_of!(Hits<$width>, inst_id) == offset_of!($hit, instID));
        };
    };
    ($width:literal, $ray:ident, $hit:ident, $rayhit:ident) => {
        fits_embree!(embree_3, $width, $ray, $hit, $rayhit);
        fits_embree!(embree_4, $width, $ray, $hit, $rayhit);
        const _: () = assert!(
            offset_of!(Hits<$width>, inst_prim_id) == offset_of!(embree_4::$hit, instPrimID)
        );
    };
}
fits_embree!(1, RTCRay, RTCHit, RTCRayHit);
fits_embree!(4, RTCRay4, RTCHit4, RTCRayHit4);
fits_embree!(8, RTCRay8, RTCHit8, RTCRayHit8);
fits_embree!(16, RTCRay16, RTCHit16, RTCRayHit16);

impl<const N: usize> Default for RayPacket<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> RayPacket<N> {
    /// A packet of empty lanes.
    pub const fn new() -> Self {
        let rays = Rays {
            org_x: [0.0; N],
            org_y: [0.0; N],
            org_z: [0.0; N],
            tnear: [f32::INFINITY; N],
            dir_x: [0.0; N],
            dir_y: [0.0; N],
            dir_z: [0.0; N],
            time: [0.0; N],
            tfar: [f32::NEG_INFINITY; N],
            mask: [0; N],
            id: [0; N],
            flags: [0; N],
        };
        let hits = Hits {
            ng_x: [0.0; N],
            ng_y: [0.0; N],
            ng_z: [0.0; N],
            u: [0.0; N],
            v: [0.0; N],
            prim_id: [INVALID_ID; N],
            geom_id: [INVALID_ID; N],
            inst_id: [[INVALID_ID; N]; LEVELS],
            inst_prim_id: [[INVALID_ID; N]; LEVELS],
        };
        Self {
            rays,
            hits,
            active: Active(0),
        }
    }

    /// A packet of the first `N` of some rays; lanes without one stay empty.
    pub fn from_rays<'a>(rays: impl IntoIterator<Item = &'a Ray>) -> Self {
        let mut packet = Self::new();
        for (lane, ray) in rays.into_iter().take(N).enumerate() {
            packet.set_ray(lane, ray);
        }
        packet
    }

    /// Puts a ray into a lane and forgets the lane's hit.
    ///
    /// # Panics
    /// If there is no such lane.
    pub fn set_ray(&mut self, lane: usize, ray: &Ray) {
        let rays = &mut self.rays;
        [rays.org_x[lane], rays.org_y[lane], rays.org_z[lane]] = ray.origin.to_array();
        [rays.dir_x[lane], rays.dir_y[lane], rays.dir_z[lane]] = ray.direction.to_array();
        rays.tnear[lane] = ray.tnear;
        rays.tfar[lane] = ray.tfar;
        rays.time[lane] = ray.time;
        rays.mask[lane] = ray.mask;
        rays.id[lane] = ray.id;
        rays.flags[lane] = ray.flags;
        self.hits.geom_id[lane] = INVALID_ID;
        self.active.0 |= 1 << lane;
    }

    /// The lane's ray, its `tfar` as the last query left it.
    ///
    /// # Panics
    /// If there is no such lane.
    pub fn ray(&self, lane: usize) -> Ray {
        let rays = &self.rays;
        Ray {
            origin: Vec3::new(rays.org_x[lane], rays.org_y[lane], rays.org_z[lane]),
            direction: Vec3::new(rays.dir_x[lane], rays.dir_y[lane], rays.dir_z[lane]),
            tnear: rays.tnear[lane],
            tfar: rays.tfar[lane],
            time: rays.time[lane],
            mask: rays.mask[lane],
            id: rays.id[lane],
            flags: rays.flags[lane],
        }
    }

    /// What the lane's ray hit in the last [`intersect`](super::Scene::intersect), if anything.
    ///
    /// # Panics
    /// If there is no such lane.
    pub fn hit(&self, lane: usize) -> Option<Hit> {
        let hits = &self.hits;
        if hits.geom_id[lane] == INVALID_ID {
            return None;
        }
        Some(Hit {
            t: self.rays.tfar[lane],
            u: hits.u[lane],
            v: hits.v[lane],
            ng: Vec3::new(hits.ng_x[lane], hits.ng_y[lane], hits.ng_z[lane]),
            prim_id: hits.prim_id[lane],
            geom_id: hits.geom_id[lane],
            inst_id: std::array::from_fn(|level| hits.inst_id[level][lane]),
            inst_prim_id: std::array::from_fn(|level| hits.inst_prim_id[level][lane]),
        })
    }

    /// The lanes that hold rays, one bit a lane.
    pub fn active(&self) -> u32 {
        self.active.0
    }

    /// Chooses the lanes to trace, one bit a lane, and forgets their hits: for packets whose `rays`
    /// are filled directly.
    pub fn set_active(&mut self, lanes: u32) {
        self.active.0 = lanes & all(N);
        self.hits.geom_id = [INVALID_ID; N];
    }

    /// The lanes that hold rays which Embree can trace, their components within `reach`, one bit a
    /// lane; see [`Ray::is_traceable`].
    pub(super) fn traceable(&self, reach: f32) -> u32 {
        debug_assert!(reach <= LARGEST_COMPONENT);
        let rays = &self.rays;
        let mut good = [true; N];
        // comparisons with NaN are false
        for component in [
            &rays.org_x,
            &rays.org_y,
            &rays.org_z,
            &rays.dir_x,
            &rays.dir_y,
            &rays.dir_z,
        ] {
            for lane in 0..N {
                good[lane] &= component[lane].abs() <= reach;
            }
        }
        let mut lanes = 0;
        for (lane, good) in good.into_iter().enumerate() {
            let [x, y, z] = [rays.dir_x[lane], rays.dir_y[lane], rays.dir_z[lane]];
            let leads = x.abs().max(y.abs()).max(z.abs()) >= LEAST_COMPONENT;
            let (tnear, tfar, time) = (rays.tnear[lane], rays.tfar[lane], rays.time[lane]);
            let good =
                good && leads && tnear >= 0.0 && tnear <= tfar && (0.0..=1.0).contains(&time);
            lanes |= u32::from(good) << lane;
        }
        lanes & self.active.0
    }

    /// The lanes whose rays end where they begin, one bit a lane.
    pub(super) fn points(&self) -> u32 {
        let mut lanes = 0;
        for lane in 0..N {
            lanes |= u32::from(self.rays.tnear[lane] == self.rays.tfar[lane]) << lane;
        }
        lanes
    }

    /// Whether a ray's direction has a component that is negative, but nearer to zero than
    /// [`LEAST_COMPONENT`]. Embree takes such a one for positive when it divides by it, but for negative when
    /// it sorts a coherent packet's rays by where they lead: other rays of the packet lose hits then.
    pub(super) fn leads_hardly_back(&self) -> bool {
        let rays = &self.rays;
        let mut any = false;
        for component in [&rays.dir_x, &rays.dir_y, &rays.dir_z] {
            for &along in component {
                any |= (along < 0.0) & (along > -LEAST_COMPONENT);
            }
        }
        any
    }

    /// `M` lanes from `first` on as a packet of their own, of which `lanes` are to be traced.
    pub(super) fn part<const M: usize>(&self, first: usize, lanes: u32) -> RayPacket<M> {
        let mut part = RayPacket::<M>::new();
        for field in 0..FIELDS {
            let lanes = &self.words()[field * N + first..][..M];
            part.words_mut()[field * M..][..M].copy_from_slice(lanes);
        }
        part.active.0 = lanes >> first & all(M);
        part
    }

    /// Puts back what [`part`](Self::part) gave.
    pub(super) fn put_part<const M: usize>(&mut self, first: usize, part: &RayPacket<M>) {
        for field in 0..FIELDS {
            let lanes = &part.words()[field * M..][..M];
            self.words_mut()[field * N + first..][..M].copy_from_slice(lanes);
        }
    }

    /// The arrays of the rays and the hits one after the other, as bits.
    fn words(&self) -> &[u32] {
        // SAFETY: `rays` and `hits` lie at the beginning, without gaps, and are made of arrays of `N`
        // four-byte numbers.
        unsafe { std::slice::from_raw_parts(std::ptr::from_ref(self).cast(), FIELDS * N) }
    }

    fn words_mut(&mut self) -> &mut [u32] {
        // SAFETY: as in `words`; every bit pattern is a number.
        unsafe { std::slice::from_raw_parts_mut(std::ptr::from_mut(self).cast(), FIELDS * N) }
    }
}

/// All lanes of a width, one bit a lane.
pub(super) const fn all(width: usize) -> u32 {
    ((1_u64 << width) - 1) as u32
}

/// Embree's mask of the lanes to trace, -1 or 0 each, aligned for every width.
#[repr(C, align(64))]
pub(super) struct Valid<const N: usize>(pub(super) [i32; N]);

impl<const N: usize> Valid<N> {
    pub(super) fn of(lanes: u32) -> Self {
        Self(std::array::from_fn(|lane| {
            -i32::from(lanes & 1 << lane != 0)
        }))
    }
}

/// The lanes that Embree's mask of any width names, one bit a lane.
///
/// # Safety
/// `valid` holds `width` lanes, each -1 or 0.
pub(super) unsafe fn read_valid(valid: *const i32, width: usize) -> u32 {
    // SAFETY: as the caller promises. A loop of known length needs no branch a lane.
    unsafe {
        match width {
            1 => u32::from(*valid != 0),
            4 => read_lanes::<4>(valid),
            8 => read_lanes::<8>(valid),
            16 => read_lanes::<16>(valid),
            _ => unreachable!("Embree has packets of 1, 4, 8 and 16 rays"),
        }
    }
}

#[inline(always)]
unsafe fn read_lanes<const N: usize>(valid: *const i32) -> u32 {
    // SAFETY: as the caller of `read_valid` promises.
    let valid = unsafe { valid.cast::<[i32; N]>().read() };
    (0..N).fold(0, |lanes, lane| lanes | valid[lane] as u32 & 1 << lane)
}

/// Writes Embree's mask of any width.
///
/// # Safety
/// `valid` has room for `width` lanes.
pub(super) unsafe fn write_valid(valid: *mut i32, width: usize, lanes: u32) {
    // SAFETY: as the caller promises.
    unsafe {
        match width {
            1 => *valid = Valid::<1>::of(lanes).0[0],
            4 => valid.cast::<[i32; 4]>().write(Valid::of(lanes).0),
            8 => valid.cast::<[i32; 8]>().write(Valid::of(lanes).0),
            16 => valid.cast::<[i32; 16]>().write(Valid::of(lanes).0),
            _ => (), // `read_valid` has panicked, and a panic here would cross into C
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lane_gives_back_its_ray() {
        let ray = Ray {
            origin: Vec3::new(1.0, 2.0, 3.0),
            direction: Vec3::new(4.0, 5.0, 6.0),
            tnear: 0.5,
            tfar: 7.0,
            time: 0.25,
            mask: 0xff,
            id: 12,
            flags: 0,
        };
        let mut packet = RayPacket::<8>::new();
        packet.set_ray(5, &ray);
        assert_eq!(packet.ray(5), ray);
        assert_eq!(packet.active(), 1 << 5);
        assert_eq!(packet.hit(5), None);
        assert_eq!(packet.traceable(LARGEST_COMPONENT), 1 << 5);
    }

    #[test]
    fn masks_are_read_as_they_are_written() {
        for width in [1, 4, 8, 16] {
            for lanes in [0, 1, 0x5a5a, 0x8421, 0xffff] {
                let mut valid = Valid::<16>::of(0);
                // SAFETY: the array has room for sixteen lanes.
                let read = unsafe {
                    write_valid(valid.0.as_mut_ptr(), width, lanes);
                    read_valid(valid.0.as_ptr(), width)
                };
                assert_eq!(read, lanes & all(width));
                let written = (0..16).filter(|lane| valid.0[*lane] == -1);
                assert_eq!(written.fold(0, |bits, lane| bits | 1 << lane), read);
            }
        }
    }

    #[test]
    fn parts_go_out_and_come_back() {
        let ray = |x| Ray::new(Vec3::new(x, 0.0, 0.0), Vec3::X);
        let rays: Vec<Ray> = (0..16).map(|i| ray(i as f32)).collect();
        let mut packet = RayPacket::<16>::from_rays(&rays);
        let mut part = packet.part::<4>(8, 0b0110 << 8 | 0b1001);
        assert_eq!(part.active(), 0b0110);
        assert_eq!(part.ray(3), rays[11]);
        part.rays.tfar[1] = 5.0;
        part.hits.geom_id[1] = 7;
        part.hits.inst_id[0][1] = 3;
        packet.put_part(8, &part);
        let hit = packet.hit(9).unwrap();
        assert_eq!((hit.t, hit.geom_id, hit.inst_id[0]), (5.0, 7, 3));
        for lane in (0..16).filter(|lane| *lane != 9) {
            assert_eq!((packet.ray(lane), packet.hit(lane)), (rays[lane], None));
        }
    }

    #[test]
    fn rays_of_every_width_are_judged_alike() {
        let good = Ray::new(Vec3::ZERO, Vec3::X);
        let bad = Ray::new(Vec3::new(0.0, f32::NAN, 0.0), Vec3::X);
        let nowhere = Ray::new(Vec3::ZERO, Vec3::splat(1e-19));
        let rays: Vec<Ray> = (0..16)
            .map(|i| match i % 4 {
                0 => bad,
                3 => nowhere,
                _ => good,
            })
            .collect();
        let expected = (0..16)
            .filter(|i| rays[*i].is_traceable())
            .fold(0, |lanes, i| lanes | 1 << i);
        assert_eq!(
            RayPacket::<16>::from_rays(&rays).traceable(LARGEST_COMPONENT),
            expected
        );
        assert_eq!(
            RayPacket::<8>::from_rays(&rays).traceable(LARGEST_COMPONENT),
            expected & 0xff
        );
        assert_eq!(
            RayPacket::<4>::from_rays(&rays).traceable(LARGEST_COMPONENT),
            expected & 0xf
        );
        assert_eq!(
            RayPacket::<1>::from_rays(&rays).traceable(LARGEST_COMPONENT),
            0
        );
    }
}
