//! `curvetri trace`: the hits of rays from a file.

use std::io;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use curvetri::embree::Device;
use curvetri::mesh::Mesh;
use curvetri::output::{OutputFile, WriteSeek};
use curvetri::render::{
    AllAnswers, Answers, Form, PacketWidth, Scene, Untraceable, UserRay, UserRays, answer_all_hits,
    answer_occluded, answer_rays, untraceable_rays,
};
use glam::DVec3;
use npyz::npz::NpzWriter;
use npyz::zip::CompressionMethod;
use npyz::zip::write::FileOptions;
use npyz::{AutoSerialize, DType, NpyFile, Order, TypeChar, WriterBuilder};

use super::console::Console;
use super::surface::SurfaceArgs;
use super::{device, on_threads, values};

/// What a file of rays holds.
const EXPECTED: &str = "expected float32 or float64 of shape (N, 6), origin and direction, or \
                        (N, 8), with tnear and tfar after them";

/// Trace rays from a file and write their hits
///
/// RAYS.npy holds float32 or float64 of shape (N, 6): origin and direction. Or of shape (N, 8), with
/// tnear and tfar after them. Directions need not be of unit length. Hits have tnear <= t <= tfar, also
/// on a curved surface where the two are equal; Embree, which traces flat triangles, leaves out a hit
/// at tnear itself.
///
/// A tnear below 0 is 0. A ray cannot be traced that holds a NaN, whose origin or direction has a
/// component beyond 1.844e18 (less where the file has instances that are made very small), whose
/// direction has none of 1e-18 or more, or whose tnear is greater than its tfar. Such rays miss; a
/// warning says how many there are, and which row, counted from 0, is the first and why.
///
/// HITS.npz holds
///   t        (N)     as RAYS  distance in units of the direction's length; infinity for a miss
///   prim_id  (N)     uint32   number of the triangle in file order; 4294967295 for a miss
///   uv       (N, 2)  float32  barycentric coordinates of the second and third vertex
///   ng       (N, 3)  float32  unit normal of the surface; zeros for a miss
///
/// Rays from far away are moved along themselves to near the mesh in double precision, so float64 rays
/// lose nothing however far they come from. t is float64 for them, and float32 for float32 rays.
///
/// With --all-hits K these arrays have shapes (N, K), (N, K), (N, K, 2) and (N, K, 3): the first K
/// hits of each ray, nearest first, with misses after its last. A further array, count (N; uint32),
/// has the number of all hits of each ray, which may be more than K. A hit on the common edge of two
/// triangles counts once: two hits are one if their t are equal to rounding and their triangles
/// differ and face the same way.
///
/// With --occluded there is one array, occluded (N; bool): whether each ray hits anything.
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct TraceArgs {
    /// Mesh file (OBJ, PLY, STL, OFF, glTF, GLB, also as .gz), or - for standard input
    mesh: PathBuf,

    /// The file of rays
    #[arg(long, value_name = "RAYS.npy")]
    rays: PathBuf,

    /// The file of hits to write
    #[arg(short, long, value_name = "HITS.npz")]
    output: PathBuf,

    /// Write the first K hits of each ray, not only the nearest
    #[arg(long, value_name = "K", value_parser = values::hits, conflicts_with = "occluded")]
    all_hits: Option<usize>,

    /// Write only whether each ray hits anything
    #[arg(long)]
    occluded: bool,

    /// How many rays are handed to Embree at a time. The answers are the same
    #[arg(long, value_enum, default_value_t = PacketChoice::One)]
    packet: PacketChoice,

    /// Threads to use [default: all]
    #[arg(long, value_name = "N", value_parser = values::threads)]
    threads: Option<usize>,

    #[command(flatten)]
    surface: SurfaceArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PacketChoice {
    #[value(name = "1")]
    One,
    #[value(name = "4")]
    Four,
    #[value(name = "8")]
    Eight,
    #[value(name = "16")]
    Sixteen,
}

/// Runs the command.
pub fn run(args: &TraceArgs, console: &Console) -> Result<()> {
    let form = args.surface.form()?;
    let device = device(args.threads)?;
    on_threads(args.threads, || {
        let rays = RayTable::read(&args.rays)?;
        let mesh = args.surface.load(&args.mesh, console)?.mesh;
        let output = OutputFile::create(&args.output)?;
        let bar = console.progress("tracing", rays.rows as u64);
        let (results, untraceable) =
            args.trace(&device, mesh, form, &rays, &|done| bar.inc(done as u64))?;
        bar.finish_and_clear();
        if let Some(untraceable) = untraceable {
            console.warn(&describe(&untraceable, rays.rows));
        }
        console.note(&format!("{} of {} rays hit", results.hit(), rays.rows));
        let single = matches!(rays.values, Values::Single(_));
        Ok(output.finish(|out| results.write(out, single))?)
    })
}

impl TraceArgs {
    fn trace(
        &self,
        device: &Device,
        mesh: Mesh,
        form: Form,
        rays: &RayTable,
        progress: &(dyn Fn(usize) + Sync),
    ) -> Result<(Results, Option<Untraceable>)> {
        let scene = if let Some(most) = self.all_hits {
            check_size(rays.rows, most)?;
            Scene::with_filters(device, vec![mesh], form)
        } else {
            Scene::new(device, vec![mesh], form)
        };
        let scene = scene.context("cannot build the scene")?;
        let rays = UserRays {
            count: rays.rows,
            ray: &|i| rays.ray(i),
            progress,
        };
        let width = self.packet.width();
        let results = match self.all_hits {
            _ if self.occluded => Results::Occluded(answer_occluded(&scene, &rays, width)),
            None => Results::Nearest(answer_rays(&scene, &rays, width)),
            Some(most) => Results::All(answer_all_hits(&scene, &rays, width, most), most),
        };
        Ok((results, untraceable_rays(&scene, &rays)))
    }
}

/// What to say of rays that cannot be traced.
fn describe(untraceable: &Untraceable, rows: usize) -> String {
    let Untraceable {
        count,
        first,
        fault,
    } = untraceable;
    format!(
        "rays that cannot be traced, and so hit nothing: {count} of {rows}; the first is in row {first}, counted \
         from 0: {fault}"
    )
}

/// What was found out about the rays.
enum Results {
    Nearest(Answers),
    /// With the number of hits returned for each ray.
    All(AllAnswers, usize),
    Occluded(Vec<bool>),
}

impl Results {
    /// How many rays hit anything.
    fn hit(&self) -> usize {
        match self {
            Self::Nearest(answers) => answers.t.iter().filter(|t| t.is_finite()).count(),
            Self::All(answers, _) => answers.count.iter().filter(|count| **count > 0).count(),
            Self::Occluded(occluded) => occluded.iter().filter(|occluded| **occluded).count(),
        }
    }

    /// Writes the arrays as numpy's `savez` does, t in single precision if so.
    fn write(&self, out: &mut dyn WriteSeek, single: bool) -> io::Result<()> {
        let mut npz = NpzWriter::new(out);
        match self {
            Self::Nearest(answers) => {
                let shape = [answers.t.len() as u64];
                add_hits(&mut npz, &shape, answers, single)?;
            }
            Self::All(answers, most) => {
                let count = answers.count.len() as u64;
                add_hits(&mut npz, &[count, *most as u64], &answers.hits, single)?;
                add(&mut npz, "count", &[count], &answers.count)?;
            }
            Self::Occluded(occluded) => {
                add(&mut npz, "occluded", &[occluded.len() as u64], occluded)?;
            }
        }
        npz.zip_writer().finish()?;
        Ok(())
    }
}

/// Refuses more hits than there can be memory for.
fn check_size(rays: usize, most: usize) -> Result<()> {
    let bytes = rays
        .checked_mul(most)
        .and_then(|hits| hits.checked_mul(BYTES_A_HIT));
    let mut memory = Vec::<u8>::new();
    if bytes.is_none_or(|bytes| memory.try_reserve_exact(bytes).is_err()) {
        bail!(
            "{rays} rays with {most} hits each do not fit into memory: ask for fewer hits or rays"
        );
    }
    Ok(())
}

/// What t, prim_id, uv and ng of a hit take.
const BYTES_A_HIT: usize = 32;

impl PacketChoice {
    fn width(self) -> PacketWidth {
        match self {
            Self::One => PacketWidth::One,
            Self::Four => PacketWidth::Four,
            Self::Eight => PacketWidth::Eight,
            Self::Sixteen => PacketWidth::Sixteen,
        }
    }
}

/// The rays of a file.
struct RayTable {
    rows: usize,
    columns: usize,
    /// Whether a column's values follow each other, not a row's.
    by_column: bool,
    values: Values,
}

enum Values {
    Single(Vec<f32>),
    Double(Vec<f64>),
}

impl RayTable {
    fn read(path: &Path) -> Result<Self> {
        let bytes =
            std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        Self::parse(&bytes).with_context(|| format!("{} holds no rays", path.display()))
    }

    fn parse(bytes: &[u8]) -> Result<Self> {
        let mut rest = bytes;
        let npy = NpyFile::new(&mut rest).with_context(|| format!("no .npy file; {EXPECTED}"))?;
        let header = npy.header().clone();
        let type_string = match header.dtype() {
            DType::Plain(plain) => plain,
            other => bail!("it is of dtype {}; {EXPECTED}", other.descr()),
        };
        let &[rows, columns @ (6 | 8)] = header.shape() else {
            bail!("it is of shape {}; {EXPECTED}", tuple(header.shape()));
        };
        let size = match (type_string.type_char(), type_string.size_field()) {
            (TypeChar::Float, size @ (4 | 8)) => size,
            _ => bail!("it is of dtype {type_string}; {EXPECTED}"),
        };
        drop(npy);
        let needed = rows.checked_mul(columns * size);
        if needed != Some(rest.len() as u64) {
            bail!(
                "{} bytes of data do not make the shape {} of its header",
                rest.len(),
                tuple(header.shape())
            );
        }
        let by_column = header.order() == Order::Fortran;
        let npy = NpyFile::with_header(header, rest);
        let values = if size == 4 {
            Values::Single(npy.into_vec()?)
        } else {
            Values::Double(npy.into_vec()?)
        };
        let [rows, columns] = [rows, columns].map(|n| n as usize);
        Ok(Self {
            rows,
            columns,
            by_column,
            values,
        })
    }

    fn ray(&self, row: usize) -> UserRay {
        let value = |column: usize| {
            let index = if self.by_column {
                column * self.rows + row
            } else {
                row * self.columns + column
            };
            match &self.values {
                Values::Single(values) => values[index].into(),
                Values::Double(values) => values[index],
            }
        };
        let vector = |first: usize| DVec3::new(value(first), value(first + 1), value(first + 2));
        let (tnear, tfar) = if self.columns == 8 {
            (value(6), value(7))
        } else {
            (0.0, f64::INFINITY)
        };
        UserRay {
            origin: vector(0),
            direction: vector(3),
            tnear,
            tfar,
        }
    }
}

fn tuple(shape: &[u64]) -> String {
    let numbers: Vec<String> = shape.iter().map(u64::to_string).collect();
    let comma = if shape.len() == 1 { "," } else { "" };
    format!("({}{comma})", numbers.join(", "))
}

/// Adds the arrays of hits, which have this shape or begin with it.
fn add_hits(
    npz: &mut NpzWriter<&mut dyn WriteSeek>,
    shape: &[u64],
    hits: &Answers,
    single: bool,
) -> io::Result<()> {
    let with = |columns: u64| [shape, &[columns]].concat();
    if single {
        let t: Vec<f32> = hits.t.iter().map(|t| *t as f32).collect();
        add(npz, "t", shape, &t)?;
    } else {
        add(npz, "t", shape, &hits.t)?;
    }
    add(npz, "prim_id", shape, &hits.prim_id)?;
    add(npz, "uv", &with(2), hits.uv.as_flattened())?;
    add(npz, "ng", &with(3), hits.ng.as_flattened())
}

fn add<T: AutoSerialize + Copy>(
    npz: &mut NpzWriter<&mut dyn WriteSeek>,
    name: &str,
    shape: &[u64],
    values: &[T],
) -> io::Result<()> {
    // A fixed date: the same hits are the same file.
    let options = FileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(Default::default())
        .large_file(size_of_val(values) as u64 >= u64::from(u32::MAX) - (1 << 16));
    let mut array = npz
        .array(name, options)?
        .default_dtype()
        .shape(shape)
        .begin_nd()?;
    array.extend(values.iter().copied())?;
    array.finish()
}
