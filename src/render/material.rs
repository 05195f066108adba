//! What meshes are made of.

/// What the meshes are made of. The ground is always diffuse.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Material {
    /// Diffuse: reflects the picture's albedo evenly to all sides (Lambert).
    #[default]
    Lambert,
    /// Clear glass, or any other dielectric: reflects and refracts by Fresnel's equations and Snell's
    /// law. Inside is behind the triangles' fronts. Only [`Path`](super::Integrator::Path) shows it.
    Glass {
        /// Refractive index of the inside to the outside, above 0; about 1.5 for glass, 1.33 for
        /// water.
        index: f32,
    },
}
