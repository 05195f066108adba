//! The Embree tree over a scene's placements.

use super::placed_shape::PlacedShape;
use super::shape::Shape;
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
        places: &[PlacedShape],
        filters: bool,
    ) -> Result<Self, Error> {
        // Flat triangles get the same promise as curved ones: no ray slips between them.
        let empty = || {
            Ok(SceneBuilder::new(device)?
                .robust(true)
                .query_filters(filters))
        };
        let mut inner: Vec<Option<Scene>> = vec![None; shapes.len()];
        let (mut builder, mut separate) = (empty()?, Vec::new());
        for (number, place) in places.iter().enumerate() {
            let shape = &shapes[place.shape];
            let Some(instance) = &place.instance else {
                for (n, geometry) in shape.geometries(device)?.into_iter().enumerate() {
                    if n == 0 {
                        builder.attach(&geometry);
                    } else {
                        separate.push((number as u32, geometry));
                    }
                }
                continue;
            };
            let tree = match &mut inner[place.shape] {
                Some(tree) => tree,
                none => {
                    let mut builder = empty()?;
                    for geometry in shape.geometries(device)? {
                        builder.attach(&geometry);
                    }
                    none.insert(builder.commit()?)
                }
            };
            builder.attach(&Geometry::instance(device, tree, instance.to_scene)?.commit()?);
        }
        for (_, geometry) in &separate {
            builder.attach(geometry);
        }
        Ok(Self {
            scene: builder.commit()?,
            places: places.len(),
            flat: separate.into_iter().map(|(number, _)| number).collect(),
        })
    }

    /// The number of the placement that a hit is on.
    pub fn placement_of(&self, hit: &Hit) -> u32 {
        match hit.inst_id[0] {
            Hit::NONE => match (hit.geom_id as usize).checked_sub(self.places) {
                None => hit.geom_id,
                Some(n) => self.flat[n],
            },
            instance => instance,
        }
    }
}
