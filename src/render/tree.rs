//! The Embree tree over a scene's placements.

use super::place::Place;
use super::scene::Shape;
use crate::embree::{Device, Error, Geometry, Hit, Scene, SceneBuilder};

/// The tree, and whose geometries are in it.
pub(super) struct Tree {
    pub scene: Scene,
    /// Geometry `i` is of placement `i`, as long as there are any; the ones after these are flat triangles
    /// of the placements listed here.
    places: usize,
    flat: Vec<u32>,
}

impl Tree {
    /// A tree of all places; each shape that has instances gets one of its own.
    pub fn new(
        device: &Device,
        shapes: &[Shape],
        places: &[Place],
        filters: bool,
    ) -> Result<Self, Error> {
        // Flat triangles get the same promise as curved ones: no ray slips between them.
        let empty = || {
            Ok(SceneBuilder::new(device)?
                .robust(true)
                .query_filters(filters))
        };
        let mut inner: Vec<Option<Scene>> = vec![None; shapes.len()];
        let (mut builder, mut apart) = (empty()?, Vec::new());
        for (number, place) in places.iter().enumerate() {
            let shape = &shapes[place.shape];
            let Some(instance) = &place.instance else {
                builder.attach(&shape.geometry(device)?);
                apart.extend(flat(shape, device)?.map(|flat| (number as u32, flat)));
                continue;
            };
            let tree = match &mut inner[place.shape] {
                Some(tree) => tree,
                none => {
                    let mut builder = empty()?;
                    builder.attach(&shape.geometry(device)?);
                    if let Some(flat) = flat(shape, device)? {
                        builder.attach(&flat);
                    }
                    none.insert(builder.commit()?)
                }
            };
            builder.attach(&Geometry::instance(device, tree, instance.to_scene)?.commit()?);
        }
        for (_, geometry) in &apart {
            builder.attach(geometry);
        }
        Ok(Self {
            scene: builder.commit()?,
            places: places.len(),
            flat: apart.into_iter().map(|(number, _)| number).collect(),
        })
    }

    /// The number of the placement that a hit is on.
    pub fn place_of(&self, hit: &Hit) -> u32 {
        match hit.inst_id[0] {
            Hit::NONE => match (hit.geom_id as usize).checked_sub(self.places) {
                None => hit.geom_id,
                Some(n) => self.flat[n],
            },
            instance => instance,
        }
    }
}

/// The flat triangles of a curved mesh that are traced apart.
fn flat(shape: &Shape, device: &Device) -> Result<Option<Geometry>, Error> {
    let Shape::Curved(mesh) = shape else {
        return Ok(None);
    };
    mesh.flat_geometry(device)?
        .map(|flat| flat.commit())
        .transpose()
}
