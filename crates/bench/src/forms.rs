//! What is traced: the same mesh in many forms.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::{BenchError, Clock, grids, median};
use curvetri::curved::{CurvedMesh, CurvedOptions, FlatTriangles, Primitives};
use curvetri::embree::{BuildQuality, Device, Geometry, GeometryBuilder, Scene, SceneBuilder};
use curvetri::mesh::{Mesh, weld};
use curvetri::method::{BoundsKind, Solver, Surface};

/// A form with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedForm {
    /// As it appears in reports and in options.
    pub name: String,
    /// The form.
    pub form: TracedForm,
}

/// What a mesh's triangles are traced as.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TracedForm {
    /// Embree's own triangles.
    Flat {
        /// Without gaps at their edges, a little slower.
        robust: bool,
    },
    /// Curved patches.
    Curved {
        /// Which and how.
        options: CurvedOptions,
        /// The device's settings for it, in Embree's notation.
        device: &'static str,
        /// Embree's smaller tree.
        compact: bool,
        /// How much work goes into the tree.
        quality: BuildQuality,
    },
    /// The curved surface cut into flat triangles of Embree's own.
    Tessellated(Cut),
    /// The same as Embree's grids.
    Grids(Cut),
    /// Embree's own subdivision surface of the mesh, cut at this level.
    Subdivision(u32),
}

/// How finely the curved surface is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// Into so many parts an edge.
    Parts(u32),
    /// As finely as it takes to be as near to the true surface as the curved one is.
    EqualError,
}

/// The name of the default surface's form, on which the goals are.
pub const DEFAULT: &str = "smooth";
/// The name of the form that all others are compared with.
pub const BASELINE: &str = "flat";

/// The device's setting for a tree with more than one user primitive a leaf, in a quarter of the memory.
const SMALL_LEAVES: &str = "object_accel_max_leaf_size=4";

/// All forms, the baseline first. New ones only need an entry here.
#[must_use]
pub fn forms() -> Vec<NamedForm> {
    let mut forms = Vec::new();
    let mut add = |name: &str, form: TracedForm| {
        let name = name.to_owned();
        forms.push(NamedForm { name, form });
    };
    let with = |options, device, compact| TracedForm::Curved {
        options,
        device,
        compact,
        quality: BuildQuality::Medium,
    };
    let curved = |options| with(options, "", false);
    let plain = CurvedOptions::default();
    let triangles = CurvedOptions {
        primitives: Primitives::Triangles,
        ..plain
    };
    let sphere = CurvedOptions {
        bounds: BoundsKind::Sphere,
        ..triangles
    };
    add(BASELINE, TracedForm::BASELINE);
    add("flat-robust", TracedForm::Flat { robust: true });
    add(DEFAULT, curved(plain));
    add("smooth-leaf4", with(plain, SMALL_LEAVES, false));
    add("smooth-compact", with(plain, "", true));
    for (name, quality) in [("low", BuildQuality::Low), ("high", BuildQuality::High)] {
        let form = TracedForm::Curved {
            options: plain,
            device: "",
            compact: false,
            quality,
        };
        add(&format!("smooth-{name}"), form);
    }
    let separate = CurvedOptions {
        flat: FlatTriangles::Separate,
        ..plain
    };
    add("smooth-flat-apart", curved(separate));
    add("smooth-triangles", curved(triangles));
    add(
        "smooth-triangles-leaf4",
        with(triangles, SMALL_LEAVES, false),
    );
    add("smooth-sphere", curved(sphere));
    for surface in [Surface::Tensor, Surface::Angular] {
        add(surface.name(), curved(CurvedOptions { surface, ..plain }));
    }
    add("paper", curved(CurvedOptions::paper()));
    for step in 1..=4 {
        let solver = Solver::Ita { bits: 24, step };
        let form = curved(CurvedOptions { solver, ..plain });
        add(&format!("smooth-ita{step}"), form);
    }
    for (name, form) in [
        (
            "tessellated",
            TracedForm::Tessellated as fn(Cut) -> TracedForm,
        ),
        ("grids", TracedForm::Grids),
    ] {
        for parts in [2, 4, 8] {
            add(
                &format!("{name}-x{}", parts * parts),
                form(Cut::Parts(parts)),
            );
        }
        add(&format!("{name}-equal"), form(Cut::EqualError));
    }
    add("subdivision-4", TracedForm::Subdivision(4));
    forms
}

/// Bytes by part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bytes {
    /// Positions, normals and indices that tracing needs beside Embree's own copies.
    pub mesh: u64,
    /// Packed patches and clusters.
    pub records: u64,
    /// Embree's own copies of vertices and indices.
    pub buffers: u64,
    /// Embree's tree.
    pub tree: u64,
}

impl Bytes {
    /// All together.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.mesh + self.records + self.buffers + self.tree
    }
}

/// Seconds that making a form took, medians of a few times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BuildTimes {
    /// To curve or to cut the mesh.
    pub prepare: f64,
    /// To build Embree's tree.
    pub build: f64,
    /// Both over the baseline's, which was made in turns with it: the median of the pairs.
    pub over_flat: f64,
}

impl BuildTimes {
    /// Both.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.prepare + self.build
    }
}

/// A form, ready to be traced.
pub struct Built {
    /// The scene.
    pub scene: Scene,
    /// Triangles, grids or faces of it.
    pub primitives: u64,
    /// Flat triangles that a form stands for that has others as primitives.
    pub pieces: u64,
    /// What it takes.
    pub bytes: Bytes,
    /// How long it took.
    pub times: BuildTimes,
}

/// Builds are repeated up to so often ...
const BUILDS: usize = 15;
/// ... as long as they take no longer than this together.
const ENOUGH: Duration = Duration::from_millis(600);

/// Bytes a primitive takes at most while it is made, by which forms too large are left out.
mod need {
    pub const FLAT: u64 = 200;
    pub const CURVED: u64 = 420;
    pub const GRID_PIECE: u64 = 45;
    pub const SUBDIVISION_PIECE: u64 = 45;
}

impl TracedForm {
    /// The one that the others are compared with.
    pub(super) const BASELINE: Self = Self::Flat { robust: false };

    /// The bytes that are needed to make it, roughly.
    pub(super) fn need(&self, mesh: &Mesh, parts: u32) -> u64 {
        let triangles = mesh.triangles().len() as u64;
        let pieces = triangles * u64::from(parts).pow(2);
        match self {
            Self::Flat { .. } => triangles * need::FLAT,
            Self::Curved { .. } => triangles * need::CURVED,
            Self::Tessellated(_) => pieces * need::FLAT,
            Self::Grids(_) => pieces * need::GRID_PIECE + triangles * need::CURVED,
            Self::Subdivision(_) => pieces * 2 * need::SUBDIVISION_PIECE + triangles * need::FLAT,
        }
    }

    /// Into how many parts an edge is cut, if the form says it: 1 for what is not cut.
    #[must_use]
    pub fn parts(&self) -> Option<u32> {
        match self {
            Self::Tessellated(Cut::Parts(parts)) | Self::Grids(Cut::Parts(parts)) => Some(*parts),
            Self::Tessellated(Cut::EqualError) | Self::Grids(Cut::EqualError) => None,
            Self::Subdivision(level) => Some(*level),
            Self::Flat { .. } | Self::Curved { .. } => Some(1),
        }
    }

    /// The settings of the device for it.
    fn device(&self) -> &'static str {
        match self {
            Self::Curved { device, .. } => device,
            _ => "",
        }
    }

    /// Makes it of a mesh, a few times for its times, in turns with the baseline.
    pub(super) fn build(
        &self,
        mesh: &Arc<Mesh>,
        parts: u32,
        clock: Clock,
    ) -> Result<Built, BenchError> {
        let start = Instant::now();
        let mut times = Vec::new();
        loop {
            let mut built = self.build_once(mesh, parts, clock)?;
            if *self != Self::BASELINE {
                let flat = Self::BASELINE.build_once(mesh, 1, clock)?.times;
                built.times.over_flat = built.times.total() / flat.total();
            }
            times.push(built.times);
            if times.len() == BUILDS || start.elapsed() > ENOUGH {
                let of = |part: fn(&BuildTimes) -> f64| median(times.iter().map(part));
                let times = BuildTimes {
                    prepare: of(|times| times.prepare),
                    build: of(|times| times.build),
                    over_flat: of(|times| times.over_flat),
                };
                return Ok(Built { times, ..built });
            }
        }
    }

    fn build_once(&self, mesh: &Arc<Mesh>, parts: u32, clock: Clock) -> Result<Built, BenchError> {
        let device = curvetri::linked::device_with_config(self.device())?;
        let triangles = mesh.triangles().len() as u64;
        let pieces = triangles * u64::from(parts).pow(2);
        let start = clock.program_time();
        match self {
            Self::Flat { robust } => {
                let geometry = || Geometry::triangles(&device, mesh.positions(), mesh.triangles());
                Making::new(&device, (clock, start), triangles)
                    .finish(geometry, |b| b.robust(*robust))
            }
            Self::Curved {
                options,
                compact,
                quality,
                ..
            } => {
                let curved = Arc::new(CurvedMesh::new(mesh.clone(), options));
                let mut making = Making::new(&device, (clock, start), triangles);
                making.bytes.mesh = mesh.memory() as u64;
                making.bytes.records = curved.memory() as u64;
                let robust = options.flat == FlatTriangles::Separate;
                making.finish_all(
                    || curved.geometries(&device),
                    |b| b.compact(*compact).robust(robust).build_quality(*quality),
                )
            }
            Self::Tessellated(_) => {
                let fine = curve(mesh).tessellate(parts)?.into_mesh();
                let geometry = || Geometry::triangles(&device, fine.positions(), fine.triangles());
                Making::new(&device, (clock, start), pieces).finish(geometry, |b| b)
            }
            Self::Grids(_) => {
                let (positions, grids) = grids::of(&curve(mesh).tessellate(parts)?, mesh);
                let mut making = Making::new(&device, (clock, start), grids.len() as u64);
                making.pieces = pieces;
                making.finish(|| Geometry::grids(&device, &positions, &grids), |b| b)
            }
            Self::Subdivision(level) => {
                let (positions, faces) = by_place(mesh);
                let mut making = Making::new(&device, (clock, start), triangles);
                making.pieces = pieces;
                let geometry = || Geometry::subdivision(&device, &positions, &faces, *level);
                making.finish(geometry, |b| b)
            }
        }
    }
}

fn curve(mesh: &Arc<Mesh>) -> CurvedMesh {
    CurvedMesh::new(mesh.clone(), &CurvedOptions::default())
}

/// Positions that occur once, and the triangles of them.
fn by_place(mesh: &Mesh) -> (Vec<glam::Vec3>, Vec<[u32; 3]>) {
    let (place_of, count) = weld(mesh.positions());
    let mut positions = vec![glam::Vec3::ZERO; count];
    for (&place, &position) in place_of.iter().zip(mesh.positions()) {
        positions[place as usize] = position;
    }
    let faces = mesh.triangles().iter();
    let faces = faces.map(|t| t.map(|v| place_of[v as usize])).collect();
    (positions, faces)
}

/// A form whose scene is still to be built.
struct Making<'a> {
    device: &'a Device,
    clock: Clock,
    prepare: f64,
    primitives: u64,
    pieces: u64,
    bytes: Bytes,
}

impl<'a> Making<'a> {
    fn new(device: &'a Device, (clock, start): (Clock, f64), primitives: u64) -> Self {
        Self {
            device,
            clock,
            prepare: clock.program_time() - start,
            primitives,
            pieces: primitives,
            bytes: Bytes::default(),
        }
    }

    fn finish(
        self,
        geometry: impl FnOnce() -> Result<GeometryBuilder, curvetri::embree::Error>,
        flags: impl FnOnce(SceneBuilder) -> SceneBuilder,
    ) -> Result<Built, BenchError> {
        self.finish_all(|| Ok(vec![geometry()?]), flags)
    }

    fn finish_all(
        mut self,
        geometries: impl FnOnce() -> Result<Vec<GeometryBuilder>, curvetri::embree::Error>,
        flags: impl FnOnce(SceneBuilder) -> SceneBuilder,
    ) -> Result<Built, BenchError> {
        let start = self.clock.program_time();
        let empty = self.device.memory().current;
        let geometries = geometries()?.into_iter().map(GeometryBuilder::commit);
        let geometries = geometries.collect::<Result<Vec<_>, _>>()?;
        let filled = self.device.memory().current;
        let mut builder = flags(SceneBuilder::new(self.device)?);
        for geometry in &geometries {
            builder.attach(geometry);
        }
        let scene = builder.commit()?;
        let build = self.clock.program_time() - start;
        self.bytes.buffers = filled - empty;
        self.bytes.tree = self.device.memory().current.saturating_sub(filled);
        Ok(Built {
            scene,
            primitives: self.primitives,
            pieces: self.pieces,
            bytes: self.bytes,
            times: BuildTimes {
                prepare: self.prepare,
                build,
                over_flat: 1.0,
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_the_baseline_is_first() {
        let forms = forms();
        assert_eq!(forms[0].name, BASELINE);
        assert!(forms.iter().any(|form| form.name == DEFAULT));
        let mut names: Vec<_> = forms.iter().map(|form| &form.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), forms.len());
    }
}
