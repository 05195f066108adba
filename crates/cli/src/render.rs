//! `curvetri render`: a picture of meshes.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result};
use clap::Args;
use curvetri::embree::Device;
use curvetri::mesh::Scenery;
use curvetri::output::OutputFile;
use curvetri::render::{Aovs, Crop, Film, Ground, Picture, RenderStats, Scene, aovs, render};

use super::console::Console;
use super::integrator::IntegratorArgs;
use super::light::LightArgs;
use super::surface::SurfaceArgs;
use super::view::ViewArgs;
use super::{console, device, on_threads, stats, usage, values};

/// The most pixels of a picture: four gigabytes of film.
const MOST_PIXELS: usize = 1 << 28;

/// Render a picture of the curved surface of meshes
#[derive(Args)]
pub struct RenderArgs {
    /// Mesh files (OBJ, PLY, STL, OFF, glTF, GLB, also as .gz), or - for standard input
    #[arg(required = true, value_name = "MESH")]
    meshes: Vec<PathBuf>,

    /// The picture: FILE.png, or FILE.exr, which also has depth, normals, positions and triangle
    /// numbers
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// Width and height in pixels [default: 800x600]
    #[arg(long, value_name = "WxH", value_parser = values::size, conflicts_with_all = ["width", "height"])]
    size: Option<[usize; 2]>,

    /// Width in pixels [default: 4/3 of the height]
    #[arg(long, value_name = "PIXELS", value_parser = values::side)]
    width: Option<usize>,

    /// Height in pixels [default: 3/4 of the width]
    #[arg(long, value_name = "PIXELS", value_parser = values::side)]
    height: Option<usize>,

    /// Render only a part of the picture: the column and the row of its upper left corner, its
    /// width and its height, in pixels
    #[arg(long, value_name = "X,Y,WxH", value_parser = values::crop)]
    crop: Option<Crop>,

    /// Rays for each pixel
    #[arg(long, visible_alias = "spp", value_name = "N", default_value_t = 16,
        value_parser = clap::value_parser!(u32).range(1..=65_536))]
    samples: u32,

    /// Threads to use [default: all]
    #[arg(long, value_name = "N", value_parser = values::threads)]
    threads: Option<usize>,

    /// Print statistics on standard output: triangles by kind, times, memory, rays
    #[arg(long)]
    stats: bool,

    /// Print the statistics as JSON (implies --stats)
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    view: ViewArgs,

    #[command(flatten)]
    integrator: IntegratorArgs,

    #[command(flatten)]
    light: LightArgs,

    #[command(flatten)]
    surface: SurfaceArgs,
}

/// What a picture is written as, by its file's ending.
#[derive(Clone, Copy, PartialEq, Eq)]
enum PictureFormat {
    Png,
    Exr,
}

/// Runs the command.
pub fn run(args: &RenderArgs, console: &Console) -> Result<()> {
    let form = match args.surface.tolerated_pixels() {
        Some(_) => args.surface.form_within(0.0)?,
        None => args.surface.form()?,
    };
    let format = args.check()?;
    let device = device(args.threads)?;
    let (film, stats) = on_threads(args.threads, || {
        let start = Instant::now();
        let (parts, scenery) = args.surface.load_all(&args.meshes, console)?;
        let load = start.elapsed();
        args.view.file_camera(&scenery.cameras)?;
        let output = OutputFile::create(&args.output)?;
        let bar = console.spinner("building");
        let scene = Scene::new(&device, parts, form).context("cannot build the scene")?;
        bar.finish_and_clear();
        let picture = args.picture(&scene, &scenery)?;
        let scene = match args.surface.tolerated_pixels() {
            Some(pixels) => {
                // What a pixel is on the meshes is known once they are in the picture.
                let length = pixels * picture.least_pixel(scene.bounds()) / scene.greatest_scale();
                let scene = scene.curved_anew(&device, args.surface.form_within(length)?);
                scene.context("cannot build the scene")?
            }
            None => scene,
        };
        let (film, mut stats) = traced(&scene, &picture, console)?;
        stats.times.load = load;
        match format {
            PictureFormat::Png => output
                .finish(|out| film.write_png(out, args.light.background(), args.light.exposure))?,
            PictureFormat::Exr => {
                let aovs: Aovs = aovs(&scene, &picture)?;
                output.finish(|out| film.write_exr(out, &aovs))?;
            }
        }
        Ok((film, stats))
    })?;
    args.tell(&film, &stats, &device, console)
}

fn traced(scene: &Scene, picture: &Picture, console: &Console) -> Result<(Film, RenderStats)> {
    let camera = &picture.camera;
    console.note(&format!(
        "camera at {}, towards {}",
        camera.eye, camera.target
    ));
    let bar = console.progress("rendering", 0);
    let result = render(scene, picture, &|_, tiles| {
        bar.set_length(tiles as u64);
        bar.inc(1);
    });
    bar.finish_and_clear();
    Ok(result?)
}

impl RenderArgs {
    /// Refuses what does not go together, before any work.
    fn check(&self) -> Result<PictureFormat> {
        let size = self.size()?;
        if let Some(crop) = self.crop
            && (crop.x + crop.width > size[0] || crop.y + crop.height > size[1])
        {
            return usage(format!(
                "--crop {},{},{}x{} is not within the picture of {}x{} pixels",
                crop.x, crop.y, crop.width, crop.height, size[0], size[1]
            ));
        }
        self.view.check()?;
        self.integrator.integrator()?;
        self.integrator.material()?;
        let format = self.format()?;
        if format == PictureFormat::Exr && self.light.exposure != 0.0 {
            return usage("--exposure is for .png: an .exr file has the light as it is");
        }
        Ok(format)
    }

    fn format(&self) -> Result<PictureFormat> {
        let is = |ending: &str| {
            let extension = self.output.extension();
            extension.is_some_and(|e| e.eq_ignore_ascii_case(ending))
        };
        match (is("png"), is("exr")) {
            (true, _) => Ok(PictureFormat::Png),
            (_, true) => Ok(PictureFormat::Exr),
            _ => usage(format!(
                "{} ends neither in .png nor in .exr",
                self.output.display()
            )),
        }
    }

    fn size(&self) -> Result<[usize; 2]> {
        let size = match (self.size, self.width, self.height) {
            (Some(size), _, _) => size,
            (_, Some(width), Some(height)) => [width, height],
            (_, Some(width), None) => [width, (width * 3 / 4).max(1)],
            (_, None, Some(height)) => [height * 4 / 3, height],
            (_, None, None) => [800, 600],
        };
        if size[0] * size[1] > MOST_PIXELS {
            return usage(format!("a picture has at most {MOST_PIXELS} pixels"));
        }
        Ok(size)
    }

    fn picture(&self, scene: &Scene, scenery: &Scenery) -> Result<Picture> {
        let [width, height] = self.size()?;
        let lighting = (self.light).lighting(self.view.up(), scene, scenery);
        let ground = self.light.ground();
        let shadows_of = (ground == Ground::Plane).then_some(lighting.towards_sun);
        let aspect = width as f64 / height as f64;
        Ok(Picture {
            width,
            height,
            crop: self.crop,
            samples: self.samples,
            seed: self.integrator.seed,
            integrator: self.integrator.integrator()?,
            camera: (self.view).camera(scene, &scenery.cameras, aspect, shadows_of)?,
            lighting,
            material: self.integrator.material()?,
            albedo: self.light.albedo,
            shading: self.light.shading(),
            ground,
            show_sky: self.light.show_sky(),
        })
    }

    fn tell(
        &self,
        film: &Film,
        stats: &RenderStats,
        device: &Device,
        console: &Console,
    ) -> Result<()> {
        console.note(&format!(
            "{}: {} x {} pixels, {:.2} Mray/s",
            self.output.display(),
            film.width(),
            film.height(),
            stats.mray_per_second()
        ));
        match (self.stats, self.json) {
            (_, true) => console::print(&stats::json(stats, device)),
            (true, false) => console::print(&stats::text(stats, device)),
            (false, false) => Ok(()),
        }
    }
}
