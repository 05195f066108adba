//! `curvetri render`: a picture of meshes.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result};
use clap::Args;
use curvetri::embree::Device;
use curvetri::mesh::{FileCamera, Scenery};
use curvetri::render::{
    Background, Camera, Film, Framing, Ground, Lighting, OutputFile, Picture, RenderStats, Scene,
    UpAxis, render,
};
use glam::DVec3;

use super::console::Console;
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

    /// The picture, a PNG file
    #[arg(short, long, value_name = "FILE.png")]
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

    /// The angle that the picture's height covers [default: the file's camera's, or 35]
    #[arg(long, value_name = "DEGREES", value_parser = values::fov)]
    fov: Option<f64>,
}

#[derive(Args)]
#[command(next_help_heading = "Light and ground")]
struct LightArgs {
    /// The direction towards the sun [default: the files' first directional light's, or to the upper
    /// left, in front]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::direction, allow_hyphen_values = true)]
    sun_direction: Option<DVec3>,

    /// Brightness of the sun, as a factor
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = values::brightness)]
    sun: f32,

    /// Brightness of the sky, as a factor
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = values::brightness)]
    sky: f32,

    /// Share of light that the surface reflects
    #[arg(long, value_name = "SHARE", default_value = "0.7", value_parser = values::share)]
    albedo: f32,

    /// Exposure in stops, over the default
    #[arg(long, value_name = "STOPS", default_value = "0", value_parser = values::stops,
        allow_hyphen_values = true)]
    exposure: f32,

    /// Put the meshes on a plane that takes their shadows
    #[arg(long)]
    ground: bool,

    /// Leave the background transparent
    #[arg(long)]
    transparent: bool,
}

/// Runs the command.
pub fn run(args: &RenderArgs, console: &Console) -> Result<()> {
    let form = args.surface.form()?;
    let size = args.size()?;
    if !args
        .output
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("png"))
    {
        return usage(format!("{} does not end in .png", args.output.display()));
    }
    if args.view.eye.is_some() && args.view.eye == args.view.target {
        return usage("the camera's --eye and --target are the same point");
    }
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
        let file_camera = args.view.file_camera(&scenery.cameras)?;
        let output = OutputFile::create(&args.output)?;
        let bar = console.spinner("building");
        let scene = Scene::new(&device, meshes, form).context("cannot build the scene")?;
        bar.finish_and_clear();
        let (film, mut stats) = args.trace(&scene, size, file_camera, &scenery.suns, console)?;
        stats.times.load = load;
        output.finish(|out| film.write_png(out, args.light.background(), args.light.exposure))?;
        Ok((film, stats))
    })?;
    args.tell(&film, &stats, &device, console)
}

impl RenderArgs {
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

    fn trace(
        &self,
        scene: &Scene,
        [width, height]: [usize; 2],
        file_camera: Option<&FileCamera>,
        suns: &[DVec3],
        console: &Console,
    ) -> Result<(Film, RenderStats)> {
        let lighting = self.light.lighting(self.view.up_axis.axis(), suns);
        let framing = Framing {
            up: self.view.up_axis.axis(),
            fov_degrees: self.view.fov.unwrap_or(DEFAULT_FOV),
            aspect: width as f64 / height as f64,
            shadows_of: self.light.ground.then_some(lighting.towards_sun),
        };
        let picture = Picture {
            width,
            height,
            samples: self.samples,
            camera: self.view.camera(file_camera, || framing.camera(scene)),
            lighting,
            albedo: self.light.albedo,
            ground: if self.light.ground {
                Ground::Plane
            } else {
                Ground::None
            },
        };
        let camera = &picture.camera;
        console.note(&format!(
            "camera at {}, towards {}",
            camera.eye, camera.target
        ));
        let bar = console.progress("rendering", 0);
        let result = render(scene, &picture, &|_, tiles| {
            bar.set_length(tiles as u64);
            bar.inc(1);
        });
        bar.finish_and_clear();
        Ok(result?)
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

    /// The camera as asked for, and where nothing is asked for the file's, or as it framed the scene.
    fn camera(&self, file: Option<&FileCamera>, framed: impl FnOnce() -> Camera) -> Camera {
        let start = match file {
            Some(file) => Camera {
                eye: file.eye,
                target: file.eye + file.forward,
                up: file.up,
                fov_degrees: self.fov.unwrap_or(file.fov_degrees),
            },
            None => framed(),
        };
        let target = self.target.unwrap_or(start.target);
        Camera {
            // A target of its own moves the camera along.
            eye: self.eye.unwrap_or(start.eye + target - start.target),
            target,
            up: self.up.unwrap_or(start.up),
            ..start
        }
    }
}

impl LightArgs {
    fn lighting(&self, up: UpAxis, suns: &[DVec3]) -> Lighting {
        let mut lighting = Lighting::daylight(up);
        if let Some(direction) = self.sun_direction.or(suns.first().copied()) {
            lighting.towards_sun = direction.as_vec3().normalize();
        }
        lighting.sun *= self.sun;
        lighting.sky.above *= self.sky;
        lighting.sky.below *= self.sky;
        lighting
    }

    fn background(&self) -> Background {
        if self.transparent {
            Background::Transparent
        } else {
            Background::default()
        }
    }
}
