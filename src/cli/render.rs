//! `curvetri render`: a picture of meshes.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result};
use clap::Args;
use curvetri::embree::Device;
use curvetri::mesh::{FileCamera, Scenery};
use curvetri::render::{
    Aovs, Camera, Crop, Film, Form, Framing, Ground, OutputFile, Picture, RenderStats, Scene, aovs,
    render,
};
use glam::DVec3;

use super::console::Console;
use super::integrator::IntegratorArgs;
use super::light::LightArgs;
use super::surface::SurfaceArgs;
use super::values::UpChoice;
use super::{console, device, on_threads, stats, usage, values};

/// The angle that the picture's height covers where nothing says it, in degrees.
const DEFAULT_FOV: f64 = 35.0;

/// The most pixels of a picture: four gigabytes of film.
const MOST_PIXELS: usize = 1 << 28;

/// Render a picture of meshes: their curved surface, sun with shadows, sky
#[derive(Args)]
pub struct RenderArgs {
    /// Mesh files (OBJ, PLY, STL, OFF, glTF, GLB, also as .gz), or - for standard input
    #[arg(required = true, value_name = "MESH")]
    meshes: Vec<PathBuf>,

    /// The picture: FILE.png, or FILE.exr with depth, normals, positions and triangles' numbers
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

    /// Render only this part of the picture: column and row of its upper left corner, width and
    /// height, in pixels
    #[arg(long, value_name = "X,Y,WxH", value_parser = values::crop)]
    crop: Option<Crop>,

    /// Rays a pixel
    #[arg(long, visible_alias = "spp", value_name = "N", default_value_t = 16,
        value_parser = clap::value_parser!(u32).range(1..=65_536))]
    samples: u32,

    /// Threads to use [default: all]
    #[arg(long, value_name = "N", value_parser = values::threads)]
    threads: Option<usize>,

    /// Print what it took on standard output: triangles by kind, times, memory, rays
    #[arg(long)]
    stats: bool,

    /// Print it as JSON (implies --stats)
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

#[derive(Args)]
#[command(next_help_heading = "Camera")]
struct ViewArgs {
    /// Which axis of the meshes points up
    #[arg(long, value_enum, default_value_t = UpChoice::Y)]
    up_axis: UpChoice,

    /// A camera of the files, by its name or number (the first is 0), or none [default: the first,
    /// where no --eye, --target or --up is given]
    #[arg(long, value_name = "NAME|N|none")]
    camera: Option<String>,

    /// Where the camera is [default: in front, above, a little to the right, as near as shows all]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    eye: Option<DVec3>,

    /// The point in the picture's middle [default: the middle of the meshes' bounds]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    target: Option<DVec3>,

    /// Upwards in the picture [default: the up axis]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::direction, allow_hyphen_values = true)]
    up: Option<DVec3>,

    /// The angle that the picture's height covers [default: that of the file's camera, or 35]
    #[arg(long, value_name = "DEGREES", value_parser = values::fov)]
    fov: Option<f64>,
}

/// What a picture is written as, by its file's ending.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Format {
    Png,
    Exr,
}

/// Runs the command.
pub fn run(args: &RenderArgs, console: &Console) -> Result<()> {
    let form = args.surface.form()?;
    let format = args.check(form)?;
    let device = device(args.threads)?;
    let (film, stats) = on_threads(args.threads, || {
        let start = Instant::now();
        let (mut meshes, mut scenery) = (Vec::new(), Scenery::default());
        for path in &args.meshes {
            let loaded = args.surface.load(path, console)?;
            meshes.push(loaded.mesh);
            scenery.cameras.extend(loaded.scenery.cameras);
            scenery.suns.extend(loaded.scenery.suns);
        }
        let load = start.elapsed();
        args.view.file_camera(&scenery.cameras)?;
        let output = OutputFile::create(&args.output)?;
        let bar = console.spinner("building");
        let scene = Scene::new(&device, meshes, form).context("cannot build the scene")?;
        bar.finish_and_clear();
        let picture = args.picture(&scene, &scenery)?;
        let (film, mut stats) = traced(&scene, &picture, console)?;
        stats.times.load = load;
        match format {
            Format::Png => output
                .finish(|out| film.write_png(out, args.light.background(), args.light.exposure))?,
            Format::Exr => {
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
    fn check(&self, form: Form) -> Result<Format> {
        let size = self.size()?;
        if let Some(crop) = self.crop
            && (crop.x + crop.width > size[0] || crop.y + crop.height > size[1])
        {
            return usage(format!(
                "--crop {},{},{}x{} is not within the picture of {}x{} pixels",
                crop.x, crop.y, crop.width, crop.height, size[0], size[1]
            ));
        }
        let view = &self.view;
        if view.eye.is_some() && view.eye == view.target {
            return usage("the camera's --eye and --target are the same point");
        }
        self.integrator.integrator()?;
        self.integrator.material()?;
        self.light.check(form == Form::Flat)?;
        let format = self.format()?;
        if format == Format::Exr && self.light.exposure != 0.0 {
            return usage("--exposure is for .png: an .exr file has the light as it is");
        }
        Ok(format)
    }

    fn format(&self) -> Result<Format> {
        let is = |ending: &str| {
            let extension = self.output.extension();
            extension.is_some_and(|e| e.eq_ignore_ascii_case(ending))
        };
        match (is("png"), is("exr")) {
            (true, _) => Ok(Format::Png),
            (_, true) => Ok(Format::Exr),
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
        let up = self.view.up_axis.axis();
        let lighting = self.light.lighting(up, scene, &scenery.suns);
        let ground = self.light.ground();
        let framing = Framing {
            up,
            fov_degrees: self.view.fov.unwrap_or(DEFAULT_FOV),
            aspect: width as f64 / height as f64,
            shadows_of: (ground == Ground::Plane).then_some(lighting.towards_sun),
        };
        Ok(Picture {
            width,
            height,
            crop: self.crop,
            samples: self.samples,
            seed: self.integrator.seed,
            integrator: self.integrator.integrator()?,
            camera: match self.view.file_camera(&scenery.cameras)? {
                Some(camera) => self.view.camera(from_file(camera)),
                None => self.view.camera(framing.camera(scene)),
            },
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

impl ViewArgs {
    /// The camera of the files that is asked for, or the first where nothing is.
    fn file_camera<'a>(&self, cameras: &'a [FileCamera]) -> Result<Option<&'a FileCamera>> {
        let Some(wanted) = &self.camera else {
            let placed = self.eye.is_some() || self.target.is_some() || self.up.is_some();
            return Ok(cameras.first().filter(|_| !placed));
        };
        if wanted == "none" {
            return Ok(None);
        }
        let by_name = cameras.iter().find(|camera| camera.name == *wanted);
        let by_number = || wanted.parse().ok().and_then(|n: usize| cameras.get(n));
        if let Some(camera) = by_name.or_else(by_number) {
            return Ok(Some(camera));
        }
        let names: Vec<String> = cameras.iter().map(|c| format!("{:?}", c.name)).collect();
        usage(match names.len() {
            0 => format!("there is no camera {wanted:?}: the files have none"),
            _ => format!(
                "there is no camera {wanted:?}; there are {}",
                names.join(", ")
            ),
        })
    }

    /// The camera as asked for, and where nothing is asked for this one.
    fn camera(&self, start: Camera) -> Camera {
        let target = self.target.unwrap_or(start.target);
        Camera {
            // A target of its own moves the camera along.
            eye: self.eye.unwrap_or(start.eye + target - start.target),
            target,
            up: self.up.unwrap_or(start.up),
            fov_degrees: self.fov.unwrap_or(start.fov_degrees),
        }
    }
}

fn from_file(camera: &FileCamera) -> Camera {
    Camera {
        eye: camera.eye,
        target: camera.eye + camera.forward,
        up: camera.up,
        fov_degrees: camera.fov_degrees,
    }
}
