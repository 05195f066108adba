//! Builds and renders all that is compared: the same camera, light and rays for all.

use std::time::Duration;

use anyhow::{Context, Result};
use curvetri::compare::View;
use curvetri::curved::CurvedOptions;
use curvetri::mesh::Parts;
use curvetri::render::{
    Background, Form, Ground, Picture, RenderStats, Scene, Shading, Times, render,
};

use super::super::console::Console;
use super::super::device;
use super::LoadedMeshes;
use super::args::CompareArgs;

/// The name of the curved surface that is lit by interpolated normals.
pub const INTERPOLATED: &str = "interpolated";

/// Something to be compared.
#[derive(Clone, Debug)]
pub struct Contestant {
    /// Short: the head of a column.
    pub name: String,
    /// What it is.
    pub title: String,
    pub form: Form,
    pub shading: Shading,
}

/// What was measured of it.
pub struct Measured {
    pub contestant: Contestant,
    /// Vertices as the mesh has them, split at hard edges.
    pub vertices: usize,
    /// Of the first run, with medians over all for times.
    pub stats: RenderStats,
    /// Of each run.
    pub times: Vec<Times>,
    pub view: View,
}

/// What all are measured with.
pub struct Comparison<'a> {
    args: &'a CompareArgs,
    picture: Picture,
    embree: [String; 2],
}

/// What has been measured so far of one of them.
struct Underway<'a> {
    contestant: Contestant,
    parts: &'a Parts,
    load: Duration,
    stats: RenderStats,
    times: Vec<Times>,
    view: Option<View>,
}

impl<'a> Comparison<'a> {
    /// Places the camera so that these meshes are seen, and the ground under `lowest`: the same for
    /// all, as the form that stands for the truth has it.
    pub fn new(
        args: &'a CompareArgs,
        meshes: &LoadedMeshes,
        lowest: (&LoadedMeshes, Form),
    ) -> Result<Self> {
        let [width, height] = args.size;
        let device = device(args.threads)?;
        let scene = |loaded: &LoadedMeshes, form| {
            let scene = Scene::new(&device, loaded.parts.clone(), form);
            scene.context("cannot build the scene")
        };
        let flat = scene(meshes, Form::Flat)?;
        let up = args.view.up();
        let lighting = args.light.lighting(up, &flat, &meshes.scenery);
        let has_ground = args.light.ground() != Ground::None;
        let shadows_of = has_ground.then_some(lighting.towards_sun);
        let (cameras, aspect) = (&meshes.scenery.cameras, width as f64 / height as f64);
        let camera = args.view.camera(&flat, cameras, aspect, shadows_of)?;
        let picture = Picture {
            samples: args.samples,
            seed: args.integrator.seed,
            integrator: args.integrator.integrator()?,
            material: args.integrator.material()?,
            show_sky: args.light.show_sky(),
            albedo: args.light.albedo,
            ground: if has_ground {
                Ground::under(&scene(lowest.0, lowest.1)?, lighting.sky.up)
            } else {
                Ground::None
            },
            lighting,
            ..Picture::new(width, height, camera, up)
        };
        // The first picture of all also starts threads and fetches code: it is not measured.
        let small = Picture {
            width: 64,
            height: 48,
            samples: 1,
            ..picture.clone()
        };
        render(&flat, &small, &|_, _| ())?;
        Ok(Self {
            args,
            picture,
            embree: [device.version().to_string(), device.isa()],
        })
    }

    /// Embree's version and the instruction set it uses.
    pub fn embree(&self) -> &[String; 2] {
        &self.embree
    }

    /// Measures forms of the meshes, and the reference. The runs take turns, so that whatever else
    /// the machine does meets them all.
    pub fn measure(
        &self,
        forms: Vec<Contestant>,
        meshes: &LoadedMeshes,
        reference: Option<&LoadedMeshes>,
        console: &Console,
    ) -> Result<(Vec<Measured>, Option<Measured>)> {
        let mut all: Vec<Underway<'_>> = forms
            .into_iter()
            .map(|form| Underway::new(form, meshes))
            .chain(reference.map(|fine| Underway::new(Contestant::reference(), fine)))
            .collect();
        for run in 1..=self.args.repeat {
            for one in &mut all {
                self.run(one, console)
                    .with_context(|| format!("{} (run {run})", one.contestant.title))?;
            }
        }
        let mut done: Vec<Measured> = all.into_iter().map(Underway::done).collect();
        let reference = reference.and_then(|_| done.pop());
        Ok((done, reference))
    }

    fn run(&self, one: &mut Underway<'_>, console: &Console) -> Result<()> {
        let Contestant {
            name,
            form,
            shading,
            ..
        } = &one.contestant;
        // A device of its own tells how much memory is this scene's.
        let device = device(self.args.threads)?;
        let bar = console.spinner("building");
        let scene = Scene::new(&device, one.parts.clone(), *form);
        let scene = scene.context("cannot build the scene")?;
        bar.finish_and_clear();
        let picture = Picture {
            shading: *shading,
            ..self.picture.clone()
        };
        let bar = console.progress("rendering", 0);
        let (film, stats) = render(&scene, &picture, &|_, tiles| {
            bar.set_length(tiles as u64);
            bar.inc(1);
        })?;
        bar.finish_and_clear();
        console.note(&format!("{name}: {:.2} Mray/s", stats.mray_per_second()));
        let times = Times {
            load: one.load,
            ..stats.times
        };
        one.times.push(times);
        if one.view.is_none() {
            let image = film.to_rgb8(Background::default(), self.args.light.exposure);
            one.view = Some(View::new(&scene, &picture, image)?);
            one.stats = stats;
        }
        Ok(())
    }
}

impl Contestant {
    /// What renderers do with triangles that have vertex normals.
    pub fn flat(name: &str) -> Self {
        Self {
            name: name.into(),
            title: "flat triangles with interpolated normals".into(),
            form: Form::Flat,
            shading: Shading::Interpolated,
        }
    }

    /// Flat triangles as they are.
    pub fn facets() -> Self {
        Self {
            name: "facets".into(),
            title: "flat triangles with their own normals".into(),
            form: Form::Flat,
            shading: Shading::Geometric,
        }
    }

    /// Curved triangles.
    pub fn curved(name: &str, form: Form) -> Self {
        let surface = match form {
            Form::Flat => "flat",
            Form::Curved(options) if options == CurvedOptions::paper() => "paper's own",
            Form::Curved(options) => options.surface.name(),
        };
        Self {
            name: name.into(),
            title: format!("the {surface} curved surface"),
            form,
            shading: Shading::Geometric,
        }
    }

    /// The same, lit by these normals.
    pub fn lit_by(mut self, shading: Shading) -> Self {
        if shading == Shading::Interpolated && self.shading != shading {
            self.title += " with interpolated normals";
        }
        self.shading = shading;
        self
    }

    /// A fine mesh that stands for the truth. Flat, so that it does not favour the curved surfaces.
    fn reference() -> Self {
        let flat = Self::flat("reference");
        Self {
            title: format!("the reference, as {}", flat.title),
            ..flat
        }
    }
}

impl<'a> Underway<'a> {
    fn new(contestant: Contestant, loaded: &'a LoadedMeshes) -> Self {
        Self {
            contestant,
            parts: &loaded.parts,
            load: loaded.time,
            stats: RenderStats::default(),
            times: Vec::new(),
            view: None,
        }
    }

    fn done(self) -> Measured {
        let median = |part: fn(&Times) -> Duration| {
            let mut all: Vec<Duration> = self.times.iter().map(part).collect();
            all.sort_unstable();
            (all[(all.len() - 1) / 2] + all[all.len() / 2]) / 2
        };
        let times = Times {
            load: median(|times| times.load),
            curve: median(|times| times.curve),
            build: median(|times| times.build),
            render: median(|times| times.render),
        };
        Measured {
            vertices: (self.parts.meshes.iter())
                .map(|mesh| mesh.positions().len())
                .sum(),
            stats: RenderStats {
                times,
                ..self.stats
            },
            contestant: self.contestant,
            times: self.times,
            view: self.view.expect("there is at least one run"),
        }
    }
}
