//! `curvetri render`: a picture of meshes.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use curvetri::embree::Device;
use curvetri::mesh::Mesh;
use curvetri::render::{
    Background, Camera, Film, Form, Framing, Ground, Lighting, OutputFile, Picture, RenderStats,
    Scene, Shading, UpAxis, render,
};
use glam::DVec3;

use super::console::Console;
use super::surface::SurfaceArgs;
use super::{console, device, on_threads, stats, usage, values};

/// The most pixels of a picture: four gigabytes of film.
const MOST_PIXELS: usize = 1 << 28;
/// Where the help has the options of light.
const LIGHT: &str = "Light and ground";

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

    /// What flat triangles are lit by; curved ones have a normal of their own [default: geometric]
    #[arg(long, value_enum, help_heading = LIGHT)]
    shading: Option<ShadingChoice>,

    /// Leave the background transparent
    #[arg(long, help_heading = LIGHT)]
    transparent: bool,

    #[command(flatten)]
    surface: SurfaceArgs,
}

#[derive(Args)]
#[command(next_help_heading = "Camera")]
pub struct ViewArgs {
    /// Which axis of the meshes points up
    #[arg(long, value_enum, default_value_t = UpChoice::Y)]
    pub up_axis: UpChoice,

    /// Where the camera is [default: in front, above, a little to the right, as near as shows all]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    eye: Option<DVec3>,

    /// The point in the picture's middle [default: the middle of the meshes' bounds]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    target: Option<DVec3>,

    /// Upwards in the picture [default: the up axis]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::direction, allow_hyphen_values = true)]
    up: Option<DVec3>,

    /// The angle that the picture's height covers
    #[arg(long, value_name = "DEGREES", default_value = "35", value_parser = values::fov)]
    pub fov: f64,
}

#[derive(Args)]
#[command(next_help_heading = LIGHT)]
pub struct LightArgs {
    /// The direction towards the sun [default: to the upper left, in front]
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
    pub albedo: f32,

    /// Exposure in stops, over the default
    #[arg(long, value_name = "STOPS", default_value = "0", value_parser = values::stops,
        allow_hyphen_values = true)]
    pub exposure: f32,

    /// Put the meshes on a plane that takes their shadows
    #[arg(long)]
    pub ground: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum UpChoice {
    Y,
    Z,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ShadingChoice {
    /// Their own normals
    Geometric,
    /// The vertices' normals between them: a smooth look, while shadows stay those of flat triangles
    Interpolated,
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
    args.view.check()?;
    if args.shading.is_some() && form != Form::Flat {
        return usage("--shading is for --surface flat: a curved surface has normals of its own");
    }
    let device = device(args.threads)?;
    let (film, stats) = on_threads(args.threads, || {
        let start = Instant::now();
        let meshes: Result<Vec<Mesh>> = args
            .meshes
            .iter()
            .map(|path| args.surface.load(path, console))
            .collect();
        let (meshes, load) = (meshes?, start.elapsed());
        let output = OutputFile::create(&args.output)?;
        let bar = console.spinner("building");
        let scene = Scene::new(&device, meshes, form).context("cannot build the scene")?;
        bar.finish_and_clear();
        let (film, mut stats) = args.trace(&scene, size, console)?;
        stats.times.load = load;
        output.finish(|out| film.write_png(out, args.background(), args.light.exposure))?;
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

    fn shading(&self) -> Shading {
        match self.shading {
            None | Some(ShadingChoice::Geometric) => Shading::Geometric,
            Some(ShadingChoice::Interpolated) => Shading::Interpolated,
        }
    }

    fn background(&self) -> Background {
        if self.transparent {
            Background::Transparent
        } else {
            Background::default()
        }
    }

    fn trace(
        &self,
        scene: &Scene,
        [width, height]: [usize; 2],
        console: &Console,
    ) -> Result<(Film, RenderStats)> {
        let lighting = self.light.lighting(self.view.up_axis.axis());
        let framing = Framing {
            up: self.view.up_axis.axis(),
            fov_degrees: self.view.fov,
            aspect: width as f64 / height as f64,
            shadows_of: self.light.ground.then_some(lighting.towards_sun),
        };
        let picture = Picture {
            width,
            height,
            samples: self.samples,
            camera: self.view.camera(framing.camera(scene)),
            lighting,
            albedo: self.light.albedo,
            shading: self.shading(),
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
    /// Looks for a camera that sees nothing.
    pub fn check(&self) -> Result<()> {
        if self.eye.is_some() && self.eye == self.target {
            return usage("the camera's --eye and --target are the same point");
        }
        Ok(())
    }

    /// The camera as asked for, and where nothing is asked for as it framed the scene.
    pub fn camera(&self, framed: Camera) -> Camera {
        let target = self.target.unwrap_or(framed.target);
        Camera {
            // A target of its own moves the framing camera along.
            eye: self.eye.unwrap_or(framed.eye + target - framed.target),
            target,
            up: self.up.unwrap_or(framed.up),
            ..framed
        }
    }
}

impl LightArgs {
    pub fn lighting(&self, up: UpAxis) -> Lighting {
        let mut lighting = Lighting::daylight(up);
        if let Some(direction) = self.sun_direction {
            lighting.towards_sun = direction.as_vec3().normalize();
        }
        lighting.sun *= self.sun;
        lighting.sky.above *= self.sky;
        lighting.sky.below *= self.sky;
        lighting
    }
}

impl UpChoice {
    pub fn axis(self) -> UpAxis {
        match self {
            Self::Y => UpAxis::Y,
            Self::Z => UpAxis::Z,
        }
    }
}
