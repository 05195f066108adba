//! Many triangles made into patches at once, one in each SIMD lane: their packed forms and
//! boxes, bit for bit what [`Patch::new`] makes of each alone.

use fearless_simd::{Level, dispatch, f32x8, mask32x8, prelude::*};

use super::validity::{folds, shears};
use crate::numbers::{Cursor, Fields, PATCHES, PatchMask, Patches, Real, Vector, to_array};
use crate::patch::{
    BoundsKind, Patch, PatchFlags, PatchKind, Rule, Surface, TriangleFrame, TriangleVertices,
};
use crate::store::{
    Columns, Contents, PackedPatch, in_columns, load_lanes, load_one, pack_unevenness, store_lanes,
};

/// How many numbers a triangle's vertices are.
const VERTICES: usize = TriangleVertices::<f32>::COUNT;

/// Takes a triangle's place in the list and what it was made into. One type for all callers, since the
/// code in lanes is large and there for each kind of processor.
type Take<'a> = &'a mut dyn FnMut(usize, BuiltPatch);

/// What a triangle was made into.
///
/// ```
/// use curvetri_method::{BuiltPatch, PatchFlags, PatchKind, TriangleVertices, vector};
///
/// let c = 1.0 / 3f32.sqrt();
/// let positions = [vector(c, c, c), vector(c, -c, -c), vector(-c, c, -c)];
/// let triangle = TriangleVertices { positions, normals: positions };
/// BuiltPatch::each(&[triangle; 20], PatchFlags::default(), |_, built| {
///     assert_eq!(built.packed.kind(), PatchKind::Curved);
/// });
/// ```
#[derive(Clone, Copy, Debug)]
pub struct BuiltPatch {
    /// The same as of [`Patch::pack`].
    pub packed: PackedPatch,
    /// The same as of [`Patch::bounds`].
    pub bounds: [Vector<f32>; 2],
}

impl BuiltPatch {
    /// One triangle.
    pub fn new(triangle: &TriangleVertices, flags: PatchFlags) -> Self {
        let (packed, bounds) = Patch::built(triangle.positions, triangle.normals, flags);
        Self { packed, bounds }
    }

    /// How far the surface may lie off the triangle's plane at the most, in units of the patch's
    /// [size](TriangleVertices::size); none where there is no curved surface.
    pub fn greatest_height(&self) -> Option<f32> {
        let [least, most] = self.packed.slab()?;
        Some(most.max(-least))
    }

    /// Triangles with the same flags, each of which is handed on with its place in the list.
    pub fn each(
        triangles: &[TriangleVertices],
        flags: PatchFlags,
        mut take: impl FnMut(usize, Self),
    ) {
        Self::each_at(Level::new(), triangles, flags, &mut take);
    }

    /// The same with the instructions of one level.
    fn each_at(level: Level, triangles: &[TriangleVertices], flags: PatchFlags, take: Take<'_>) {
        if flags.is_flat() || flags.is_unchecked() || flags.bounds() == BoundsKind::Sphere {
            for (n, triangle) in triangles.iter().enumerate() {
                take(n, Self::new(triangle, flags));
            }
            return;
        }
        dispatch!(level, simd => each_in_lanes(simd, triangles, flags, take));
    }
}

/// Eight triangles at a time; those that the method does not take as they are, one by
/// one: there are few.
#[inline(always)]
fn each_in_lanes<S: Simd>(
    simd: S,
    triangles: &[TriangleVertices],
    flags: PatchFlags,
    take: Take<'_>,
) {
    let mut made = [[0.0; PATCHES]; BUILT];
    for (n, group) in triangles.chunks(PATCHES).enumerate() {
        let taken = make(simd, group, flags, &mut made);
        for (lane, triangle) in group.iter().enumerate() {
            let built = if taken & 1 << lane != 0 {
                load_one(&made, lane, BuiltNumbers::blank()).pack(flags)
            } else {
                BuiltPatch::new(triangle, flags)
            };
            take(n * PATCHES + lane, built);
        }
    }
}

/// Makes patches of up to eight triangles; one bit a lane for those that
/// are curved by the surface's own rule.
#[inline(always)]
fn make<S: Simd>(
    simd: S,
    group: &[TriangleVertices],
    flags: PatchFlags,
    made: &mut Columns<BUILT>,
) -> u64 {
    // The last one again in lanes that are left.
    let columns = in_columns(
        #[inline(always)]
        |lane| to_array::<_, VERTICES>(group[lane.min(group.len() - 1)], 0.0),
    );
    let blank = TriangleVertices::blank(Patches(f32x8::splat(simd, 0.0)));
    let TriangleVertices { positions, normals } = load_lanes(simd, &columns, blank);
    let frame = TriangleFrame::of_sound(&positions, &normals);
    let PatchMask(sound) = frame.is_sound(&positions);
    let mut taken = sound.to_bitmask() & (u64::MAX >> (64 - group.len()));
    if taken == 0 {
        return 0;
    }
    let mut patch = Patch::from_frame(&frame, &normals, flags);
    if patch.rule == Rule::Angular {
        patch.set_angles();
    }
    let checks = simd.vectorize(
        #[inline(always)]
        || patch.checks(),
    );
    let fits = match patch.rule {
        Rule::Tensor => checks.tame,
        _ => checks.reaches,
    };
    let PatchMask(stands) = !(shears(&patch) | folds(&patch));
    let PatchMask(near) = patch.agrees(&normals) & fits & checks.low;
    taken &= (near & stands).to_bitmask();
    if taken != 0 {
        if flags.surface() == Surface::Smooth {
            simd.vectorize(
                #[inline(always)]
                || patch.correct(flags),
            );
        }
        let net = checks.net.corrected(&patch);
        let numbers = BuiltNumbers {
            slab: net.slab(),
            correction: patch.edges.each_ref().map(|edge| edge.correction),
            unit: patch.correction_unit(),
            unevenness: simd.vectorize(
                #[inline(always)]
                || patch.unevenness(&normals),
            ),
            bounds: patch.tight_box(Some(&net)),
        };
        let all = PatchMask(mask32x8::splat(simd, true));
        store_lanes(numbers, made, all);
    }
    taken
}

/// What a patch is packed from, and its box.
#[derive(Clone, Copy)]
struct BuiltNumbers<V> {
    slab: [V; 2],
    correction: [[V; 3]; 3],
    unit: V,
    unevenness: V,
    bounds: [Vector<V>; 2],
}

/// How many numbers that are.
const BUILT: usize = BuiltNumbers::<f32>::COUNT;

impl<V: Real> Fields<V> for BuiltNumbers<V> {
    const COUNT: usize = 2 + 9 + 1 + 1 + 2 * 3;

    #[inline(always)]
    fn visit(&mut self, cursor: &mut impl Cursor<V>) {
        cursor.number(&mut self.slab[0]);
        cursor.number(&mut self.slab[1]);
        let [a, b, c] = &mut self.correction;
        for edge in [a, b, c] {
            cursor.number(&mut edge[0]);
            cursor.number(&mut edge[1]);
            cursor.number(&mut edge[2]);
        }
        cursor.number(&mut self.unit);
        cursor.number(&mut self.unevenness);
        cursor.vector(&mut self.bounds[0]);
        cursor.vector(&mut self.bounds[1]);
    }
}

impl BuiltNumbers<f32> {
    #[inline(always)]
    fn blank() -> Self {
        Self {
            slab: [0.0; 2],
            correction: [[0.0; 3]; 3],
            unit: 0.0,
            unevenness: 0.0,
            bounds: [Vector::default(); 2],
        }
    }

    #[inline(always)]
    fn pack(&self, flags: PatchFlags) -> BuiltPatch {
        let contents = Contents {
            slab: self.slab,
            correction: self.correction,
            unit: self.unit,
            unevenness: pack_unevenness(self.unevenness),
        };
        BuiltPatch {
            packed: PackedPatch::new(PatchKind::Curved, flags, &contents),
            bounds: self.bounds,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::assert_counted;
    use crate::tests::{Random, fuses, rounded};

    fn triangles(random: &mut Random) -> Vec<TriangleVertices> {
        (0..2000)
            .map(|n| {
                let tilt = [3.0, 10.0, 25.0, 50.0][n / 7 % 4];
                let (positions, normals) = random.triangle(tilt, 0.6);
                let mut corners = TriangleVertices {
                    positions: rounded(positions),
                    normals: rounded(normals),
                };
                match n % 41 {
                    0 => corners.positions[2] = corners.positions[1],
                    1 => corners.positions[2] = (corners.positions[0] + corners.positions[1]) * 0.5,
                    2 => corners.normals[0] = -corners.normals[0],
                    3 => corners.normals[1].x = f32::NAN,
                    _ => {}
                }
                corners
            })
            .collect()
    }

    /// Each number's bits, of which NaN has some as well.
    fn bits(built: &BuiltPatch) -> String {
        let corners = built
            .bounds
            .map(|corner| corner.to_array().map(f32::to_bits));
        format!("{:?} {corners:?}", built.packed)
    }

    /// Whether they are the same but for rounding.
    fn is_near(one: &BuiltPatch, other: &BuiltPatch) -> bool {
        let ends = |built: &BuiltPatch| built.bounds.map(Vector::to_array).concat();
        let near = |(a, b): (f32, f32)| a.to_bits() == b.to_bits() || (a - b).abs() < 1e-5;
        one.packed.kind() == other.packed.kind() && ends(one).into_iter().zip(ends(other)).all(near)
    }

    #[test]
    fn what_is_built_shows_as_many_numbers_as_it_says() {
        assert_counted(BuiltNumbers::blank());
    }

    #[test]
    fn lanes_make_what_is_made_alone() {
        let mut random = Random(31);
        let triangles = triangles(&mut random);
        let (mut curved, mut differ) = (0, 0);
        for surface in Surface::ALL {
            for straight in 0..8 {
                let flags = (0..3).filter(|k| straight & 1 << k != 0);
                let flags = flags.fold(PatchFlags::new(surface), PatchFlags::with_straight);
                for level in [Level::new(), Level::baseline()] {
                    let mut next = 0;
                    BuiltPatch::each_at(level, &triangles, flags, &mut |n, built| {
                        assert_eq!(n, next);
                        next += 1;
                        let alone = BuiltPatch::new(&triangles[n], flags);
                        if fuses(level) {
                            assert_eq!(bits(&built), bits(&alone), "{:?}", triangles[n]);
                        } else {
                            differ += u32::from(!is_near(&built, &alone));
                        }
                        curved += u32::from(built.packed.kind() == PatchKind::Curved);
                    });
                    assert_eq!(next, triangles.len());
                }
            }
        }
        println!("{differ} differ where lanes round twice");
        assert!(curved > 30_000, "{curved}");
        assert!(differ * 500 < curved, "{differ} of {curved}");
    }

    #[test]
    fn a_box_is_the_same_from_what_is_kept() {
        let mut random = Random(32);
        for triangle in triangles(&mut random) {
            let built = BuiltPatch::new(&triangle, PatchFlags::default());
            let TriangleVertices { positions, normals } = triangle;
            let patch = Patch::unpack(positions, normals, &built.packed);
            assert_eq!(
                format!("{:?}", patch.bounds()),
                format!("{:?}", built.bounds)
            );
        }
    }
}
