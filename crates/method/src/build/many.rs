//! Many triangles made into patches at once, one in each SIMD lane: what is kept of them and their
//! boxes, bit for bit what [`Patch::new`] makes of each alone.

use fearless_simd::{Level, dispatch, prelude::*};

use super::validity::{folds, shears};
use crate::numbers::{PATCHES, PatchMask, Patches, Vector, vector};
use crate::patch::{BoundsKind, Corners, Frame, Patch, PatchFlags, PatchKind, Rule, Surface};
use crate::store::{Heights, PatchRecord, in_columns, pack_unevenness, vertices};

/// Takes a triangle's place in the list and what it was made into. One type for all who ask, since the
/// code in lanes is large and there for each kind of processor.
type Take<'a> = &'a mut dyn FnMut(usize, Prepared);

/// What a triangle was made into.
#[derive(Clone, Copy, Debug)]
pub struct Prepared {
    /// As [`Patch::record`] tells.
    pub record: PatchRecord,
    /// As [`Patch::bounds`] tells.
    pub bounds: [Vector<f32>; 2],
}

impl Prepared {
    /// One triangle.
    pub fn new(triangle: &Corners, flags: PatchFlags) -> Self {
        let (record, bounds) = Patch::prepared(triangle.positions, triangle.normals, flags);
        Self { record, bounds }
    }

    /// How far the surface may lie off the triangle's plane at the most, in units of the patch's
    /// [size](Corners::size); none where there is no curved surface.
    pub fn greatest_height(&self) -> Option<f32> {
        let [least, most] = self.record.slab::<f32>()?;
        Some(most.max(-least))
    }

    /// Triangles with the same flags, each of which is handed on with its place in the list.
    pub fn each(triangles: &[Corners], flags: PatchFlags, mut take: impl FnMut(usize, Self)) {
        Self::each_at(Level::new(), triangles, flags, &mut take);
    }

    /// The same with the instructions of one level.
    fn each_at(level: Level, triangles: &[Corners], flags: PatchFlags, take: Take<'_>) {
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
fn each_in_lanes<S: Simd>(simd: S, triangles: &[Corners], flags: PatchFlags, take: Take<'_>) {
    let mut made = Made::default();
    for (n, group) in triangles.chunks(PATCHES).enumerate() {
        let taken = make(simd, group, flags, &mut made);
        for (lane, triangle) in group.iter().enumerate() {
            let prepared = if taken & 1 << lane != 0 {
                made.prepared(lane, flags)
            } else {
                Prepared::new(triangle, flags)
            };
            take(n * PATCHES + lane, prepared);
        }
    }
}

/// Makes patches of up to eight triangles; one bit a lane for those that
/// are curved by the rule that the surface asks for.
#[inline(always)]
fn make<S: Simd>(simd: S, group: &[Corners], flags: PatchFlags, made: &mut Made) -> u64 {
    // The last one again in lanes that are left.
    let columns = in_columns(
        #[inline(always)]
        |lane| group[lane.min(group.len() - 1)].numbers(),
    );
    let [positions, normals] = vertices(simd, &columns);
    let frame = Frame::of_sound(&positions, &normals);
    let PatchMask(sound) = frame.is_sound(&positions);
    let mut taken = sound.to_bitmask() & (u64::MAX >> (64 - group.len()));
    if taken == 0 {
        return 0;
    }
    let mut patch = Patch::laid(&frame, &normals, flags);
    if patch.rule == Rule::Angular {
        patch.set_angles();
    }
    let looked_at = simd.vectorize(
        #[inline(always)]
        || patch.looked_at(),
    );
    let fits = match patch.rule {
        Rule::Tensor => looked_at.tame,
        _ => looked_at.reaches,
    };
    let PatchMask(stands) = !(shears(&patch) | folds(&patch));
    let PatchMask(near) = patch.agrees(&normals) & fits & looked_at.low;
    taken &= (near & stands).to_bitmask();
    if taken != 0 {
        if flags.surface() == Surface::Smooth {
            simd.vectorize(
                #[inline(always)]
                || patch.correct(flags),
            );
        }
        let net = looked_at.net.corrected(&patch);
        made.slab = net.slab().map(Patches::numbers);
        for (to, side) in made.correction.iter_mut().zip(&patch.sides) {
            for (to, &coefficient) in to.iter_mut().zip(&side.correction) {
                *to = coefficient.numbers();
            }
        }
        made.unit = patch.correction_unit().numbers();
        made.unevenness = simd.vectorize(
            #[inline(always)]
            || patch.unevenness(&normals).numbers(),
        );
        let [lower, upper] = patch.tight_box(Some(&net));
        made.bounds = [corner(lower), corner(upper)];
    }
    taken
}

/// A number a lane.
type Column = [f32; PATCHES];

/// What patches in lanes were made into.
#[derive(Default)]
struct Made {
    slab: [Column; 2],
    correction: [[Column; 3]; 3],
    unit: Column,
    unevenness: Column,
    bounds: [[Column; 3]; 2],
}

impl Made {
    #[inline(always)]
    fn prepared(&self, lane: usize, flags: PatchFlags) -> Prepared {
        let heights = Heights {
            slab: self.slab.each_ref().map(|column| column[lane]),
            correction: (self.correction.each_ref())
                .map(|side| side.each_ref().map(|column| column[lane])),
            unit: self.unit[lane],
            unevenness: pack_unevenness(self.unevenness[lane]),
        };
        let corner = |[x, y, z]: &[Column; 3]| vector(x[lane], y[lane], z[lane]);
        Prepared {
            record: PatchRecord::new(PatchKind::Curved, flags, &heights),
            bounds: self.bounds.each_ref().map(corner),
        }
    }
}

#[inline(always)]
fn corner<S: Simd>(vector: Vector<Patches<S>>) -> [Column; 3] {
    [vector.x.numbers(), vector.y.numbers(), vector.z.numbers()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{Random, fuses, rounded};

    fn triangles(random: &mut Random) -> Vec<Corners> {
        (0..2000)
            .map(|n| {
                let tilt = [3.0, 10.0, 25.0, 50.0][n / 7 % 4];
                let (positions, normals) = random.triangle(tilt, 0.6);
                let mut corners = Corners {
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
    fn bits(prepared: &Prepared) -> String {
        let corners = prepared
            .bounds
            .map(|corner| corner.to_array().map(f32::to_bits));
        format!("{:?} {corners:?}", prepared.record)
    }

    /// Whether they are the same but for rounding.
    fn is_near(one: &Prepared, other: &Prepared) -> bool {
        let ends = |prepared: &Prepared| prepared.bounds.map(Vector::to_array).concat();
        let near = |(a, b): (f32, f32)| a.to_bits() == b.to_bits() || (a - b).abs() < 1e-5;
        one.record.kind() == other.record.kind() && ends(one).into_iter().zip(ends(other)).all(near)
    }

    #[test]
    fn lanes_make_what_is_made_alone() {
        let mut random = Random(31);
        let triangles = triangles(&mut random);
        let (mut curved, mut apart) = (0, 0);
        for surface in Surface::ALL {
            for straight in 0..8 {
                let flags = (0..3).filter(|k| straight & 1 << k != 0);
                let flags = flags.fold(PatchFlags::new(surface), PatchFlags::with_straight);
                for level in [Level::new(), Level::baseline()] {
                    let mut next = 0;
                    Prepared::each_at(level, &triangles, flags, &mut |n, prepared| {
                        assert_eq!(n, next);
                        next += 1;
                        let alone = Prepared::new(&triangles[n], flags);
                        if fuses(level) {
                            assert_eq!(bits(&prepared), bits(&alone), "{:?}", triangles[n]);
                        } else {
                            apart += u32::from(!is_near(&prepared, &alone));
                        }
                        curved += u32::from(prepared.record.kind() == PatchKind::Curved);
                    });
                    assert_eq!(next, triangles.len());
                }
            }
        }
        println!("{apart} apart where lanes round twice");
        assert!(curved > 30_000, "{curved}");
        assert!(apart * 500 < curved, "{apart} of {curved}");
    }

    #[test]
    fn a_box_is_the_same_from_what_is_kept() {
        let mut random = Random(32);
        for triangle in triangles(&mut random) {
            let prepared = Prepared::new(&triangle, PatchFlags::default());
            let Corners { positions, normals } = triangle;
            let patch = Patch::from_record(positions, normals, &prepared.record);
            assert_eq!(
                format!("{:?}", patch.bounds()),
                format!("{:?}", prepared.bounds)
            );
        }
    }
}
