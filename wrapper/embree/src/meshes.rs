//! Embree's own meshes: flat triangles, grids, subdivision surfaces.

use glam::Vec3;

use super::device::Device;
use super::error::{Error, attempt};
use super::geometry::{Geometry, GeometryBuilder};
use super::sys::{
    RTC_BUFFER_TYPE_FACE, RTC_BUFFER_TYPE_GRID, RTC_BUFFER_TYPE_INDEX, RTC_BUFFER_TYPE_VERTEX,
    RTC_FORMAT_FLOAT3, RTC_FORMAT_GRID, RTC_FORMAT_UINT, RTC_FORMAT_UINT3, RTC_GEOMETRY_TYPE_GRID,
    RTC_GEOMETRY_TYPE_SUBDIVISION, RTC_GEOMETRY_TYPE_TRIANGLE,
};
use super::table::embree;

/// A rectangle of vertices, each four neighbours of which are two flat triangles: one primitive of
/// [`Geometry::grids`].
///
/// ```
/// use curvetri_embree::{Geometry, Grid};
/// use glam::Vec3;
///
/// let vertices: Vec<Vec3> = (0..6).map(|i| Vec3::new((i % 3) as f32, (i / 3) as f32, 0.0)).collect();
/// let grid = Grid { first: 0, stride: 3, width: 3, height: 2 };
/// let device = curvetri_embree_linked::device()?;
/// let geometry = Geometry::grids(&device, &vertices, &[grid])?.commit()?;
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct Grid {
    /// The first row's first vertex.
    pub first: u32,
    /// Vertices from the beginning of a row to that of the next.
    pub stride: u32,
    /// Vertices of a row: 2 to [`Grid::MOST`].
    pub width: u16,
    /// Rows: 2 to [`Grid::MOST`].
    pub height: u16,
}

impl Grid {
    /// Most vertices along either side.
    pub const MOST: u16 = 32767;

    /// One past the last vertex.
    fn end(&self) -> u64 {
        u64::from(self.first)
            + u64::from(self.height - 1) * u64::from(self.stride)
            + u64::from(self.width)
    }
}

/// More elements than these cannot be numbered.
const LIMIT: usize = u32::MAX as usize - 1;

fn check_count(what: &'static str, count: usize) -> Result<(), Error> {
    let limit = LIMIT;
    if count > limit {
        return Err(Error::TooMany { what, count, limit });
    }
    Ok(())
}

fn check_indices(indices: &[[u32; 3]], vertices: usize) -> Result<(), Error> {
    for (triangle, corners) in indices.iter().enumerate() {
        let wrong = corners.iter().find(|index| **index as usize >= vertices);
        if let Some(&index) = wrong {
            return Err(Error::Index {
                triangle,
                index,
                vertices,
            });
        }
    }
    Ok(())
}

impl GeometryBuilder {
    /// A geometry of Embree's own with these vertices.
    fn with_vertices(device: &Device, kind: u32, positions: &[Vec3]) -> Result<Self, Error> {
        check_count("vertices", positions.len())?;
        let builder = Self::new(device, kind, None)?;
        let positions: &[[f32; 3]] = &positions.iter().map(Vec3::to_array).collect::<Vec<_>>();
        builder.fill(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, positions)?;
        Ok(builder)
    }
}

impl Geometry {
    /// Embree's own flat triangles, from copies of the vertices and of three vertex numbers a
    /// triangle. Hits have u and v of the second and the third vertex, and a normal that is the cross
    /// product of two sides.
    ///
    /// # Errors
    /// If a triangle names a vertex that does not exist, there are more than Embree can number, or
    /// there is not enough memory.
    pub fn triangles(
        device: &Device,
        positions: &[Vec3],
        indices: &[[u32; 3]],
    ) -> Result<GeometryBuilder, Error> {
        check_count("triangles", indices.len())?;
        check_indices(indices, positions.len())?;
        let kind = RTC_GEOMETRY_TYPE_TRIANGLE;
        let builder = GeometryBuilder::with_vertices(device, kind, positions)?;
        builder.fill(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, indices)?;
        Ok(builder)
    }

    /// Some of [`triangles`](Self::triangles): those that are left out are never hit, and the others keep
    /// their numbers.
    ///
    /// # Errors
    /// As [`triangles`](Self::triangles).
    pub fn some_triangles(
        device: &Device,
        positions: &[Vec3],
        indices: &[[u32; 3]],
        keep: impl Fn(usize) -> bool,
    ) -> Result<GeometryBuilder, Error> {
        check_count("vertices", positions.len())?;
        check_indices(indices, positions.len())?;
        // Embree builds no tree over triangles without a finite box.
        let nowhere = positions.len() as u32;
        let positions = [positions, &[Vec3::NAN]].concat();
        let kept = indices.iter().enumerate();
        let indices: Vec<_> = kept
            .map(|(n, &corners)| if keep(n) { corners } else { [nowhere; 3] })
            .collect();
        Self::triangles(device, &positions, &indices)
    }

    /// Embree's grids: rectangles of vertices, cut into flat triangles as they are traced, from copies
    /// of the vertices. They take a fraction of the memory of as many triangles. Of four neighbours
    /// the triangles share the side from the second of the upper row to the first of the lower one.
    /// Hits have u along the rows and v across them, each from 0 to 1 over the grid.
    ///
    /// # Errors
    /// If a grid has a side of less than 2 or more than [`Grid::MOST`] vertices or names vertices that
    /// do not exist, there are more than Embree can number, or there is not enough memory.
    pub fn grids(
        device: &Device,
        positions: &[Vec3],
        grids: &[Grid],
    ) -> Result<GeometryBuilder, Error> {
        check_count("grids", grids.len())?;
        let sides = 2..=Grid::MOST;
        for (number, grid) in grids.iter().enumerate() {
            let sized = sides.contains(&grid.width) && sides.contains(&grid.height);
            if !sized || grid.end() > positions.len() as u64 {
                return Err(Error::Grid {
                    number,
                    grid: *grid,
                    vertices: positions.len(),
                });
            }
        }
        let kind = RTC_GEOMETRY_TYPE_GRID;
        let builder = GeometryBuilder::with_vertices(device, kind, positions)?;
        builder.fill(RTC_BUFFER_TYPE_GRID, RTC_FORMAT_GRID, grids)?;
        Ok(builder)
    }

    /// Embree's Catmull-Clark subdivision surface of a mesh of triangles, from copies of the vertices
    /// and of three vertex numbers a triangle. It is cut once, when the scene is committed: every side
    /// into `level` parts. Triangles are neighbours where they name the same vertices.
    ///
    /// # Errors
    /// As [`triangles`](Self::triangles), and if `level` is not 1 to [`Geometry::FINEST_LEVEL`], or
    /// Embree was built without subdivision surfaces.
    pub fn subdivision(
        device: &Device,
        positions: &[Vec3],
        indices: &[[u32; 3]],
        level: u32,
    ) -> Result<GeometryBuilder, Error> {
        check_count("triangles", indices.len())?;
        check_indices(indices, positions.len())?;
        if !(1..=Self::FINEST_LEVEL).contains(&level) {
            return Err(Error::Level(level));
        }
        let kind = RTC_GEOMETRY_TYPE_SUBDIVISION;
        let builder = GeometryBuilder::with_vertices(device, kind, positions)?;
        builder.fill(
            RTC_BUFFER_TYPE_FACE,
            RTC_FORMAT_UINT,
            &vec![3_u32; indices.len()],
        )?;
        builder.fill(
            RTC_BUFFER_TYPE_INDEX,
            RTC_FORMAT_UINT,
            indices.as_flattened(),
        )?;
        let handle = builder.handle();
        // SAFETY: the handle is a live subdivision geometry.
        attempt("set the subdivision level", || unsafe {
            embree!(
                device.embree(),
                set_geometry_tessellation_rate(handle, level as f32)
            )
        })?;
        Ok(builder)
    }

    /// The finest level of [`subdivision`](Self::subdivision).
    pub const FINEST_LEVEL: u32 = 4096;
}
