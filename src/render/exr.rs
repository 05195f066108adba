//! OpenEXR files: a picture's light as it is, and what else is known of its pixels.

use std::io::{self, Seek, Write};

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer,
    LayerAttributes, Text, Vec2, WritableImage,
};
use glam::{Vec3, Vec4};

use super::film::Film;
use super::integrate::Aovs;

impl Film {
    /// Writes the picture as an OpenEXR file in linear light (Rec. 709 primaries), without background,
    /// its channels named as Blender and Nuke expect them:
    ///
    /// | channels | |
    /// |---|---|
    /// | `R` `G` `B` | radiance times coverage, f32 |
    /// | `A` | coverage: the share of the pixel where something is seen, f32 |
    /// | `albedo.R` `albedo.G` `albedo.B` | share of light reflected, f32 |
    /// | `N.X` `N.Y` `N.Z` | unit normal towards the viewer, in the user's space, f32 |
    /// | `P.X` `P.Y` `P.Z` | position in the user's space, f32 |
    /// | `Z` | distance along the camera's view, f32; infinity where nothing is seen |
    /// | `id` | the triangle's number in its mesh, u32; 4294967295 for none |
    /// | `mesh` | the mesh's number, u32; 4294967295 for none |
    ///
    /// R, G, B and A are means over the pixel's samples; all others are what the ray through its
    /// middle sees. A crop keeps its place: the display window is the whole picture, the data window
    /// the crop.
    ///
    /// # Errors
    /// What the writer says.
    ///
    /// # Panics
    /// If the variables are those of another size of picture.
    pub fn write_exr(&self, writer: impl Write + Seek, aovs: &Aovs) -> io::Result<()> {
        let window = self.window();
        assert_eq!(aovs.depth.len(), window.count(), "those of another picture");
        let vector = |[x, y]: [usize; 2]| Vec2(x, y);
        let layer = Layer::new(
            vector(window.size),
            LayerAttributes {
                layer_position: vector(window.corner).to_i32(),
                software_name: Some(Text::from("curvetri")),
                ..LayerAttributes::default()
            },
            Encoding::SMALL_LOSSLESS,
            AnyChannels::sort(self.channels(aovs).into_iter().collect()),
        );
        let full = IntegerBounds::from_dimensions(vector(window.full));
        let image = Image::empty(ImageAttributes::new(full)).with_layer(layer);
        // On this thread alone: `--threads` holds for the writer as well.
        let written = image.write().non_parallel().to_buffered(writer);
        written.map_err(|error| match error {
            exr::error::Error::Io(error) => error,
            other => io::Error::other(other),
        })
    }

    fn channels(&self, aovs: &Aovs) -> Vec<AnyChannel<FlatSamples>> {
        let light = |of: fn(&Vec4) -> f32| self.pixels().iter().map(of).collect();
        let number = |name, values: &[u32]| AnyChannel::new(name, FlatSamples::U32(values.into()));
        let position: Vec<Vec3> = aovs.position.iter().map(|p| p.as_vec3()).collect();
        let mut channels = vec![
            float("R", light(|pixel| pixel.x)),
            float("G", light(|pixel| pixel.y)),
            float("B", light(|pixel| pixel.z)),
            float("A", light(|pixel| pixel.w)),
            float("Z", aovs.depth.clone()),
            number("id", &aovs.primitive),
            number("mesh", &aovs.mesh),
        ];
        channels.extend(vectors(["albedo.R", "albedo.G", "albedo.B"], &aovs.albedo));
        channels.extend(vectors(["N.X", "N.Y", "N.Z"], &aovs.normal));
        channels.extend(vectors(["P.X", "P.Y", "P.Z"], &position));
        channels
    }
}

fn float(name: &str, values: Vec<f32>) -> AnyChannel<FlatSamples> {
    AnyChannel::new(name, FlatSamples::F32(values))
}

fn vectors(names: [&str; 3], values: &[Vec3]) -> [AnyChannel<FlatSamples>; 3] {
    [0, 1, 2].map(|axis| float(names[axis], values.iter().map(|v| v[axis]).collect()))
}
