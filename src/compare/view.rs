//! What a scene shows, and how far that is from what another one shows.

use glam::Vec2;
use image::RgbImage;
use serde::Serialize;

use super::normals::{geometric_angles, shading_angles};
use super::outline::Outline;
use super::pictures::{flip, rmse};
use super::probe::Probe;
use super::summary::Summary;
use super::terminator::{Darkened, darkened};
use crate::embree::QueryOptions;
use crate::render::{CameraError, Picture, Scene};

/// What a scene shows through a camera.
#[derive(Clone, Debug)]
pub struct View {
    /// Its picture.
    pub image: RgbImage,
    /// Its surface through the pixels' middles.
    pub probe: Probe,
    /// Where the meshes end, without the ground.
    pub outline: Outline,
}

/// How far what one scene shows is from what another one shows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// [`rmse`] of the pictures.
    pub rmse: f64,
    /// The mean of [`flip`] of the pictures.
    pub flip: f64,
    /// Its map.
    #[serde(skip)]
    pub flip_map: RgbImage,
    /// The outlines' distance in pixels.
    pub outline: Option<Summary>,
    /// The angle between the normals that the surfaces are lit by, in degrees.
    pub shading_normal: Option<Summary>,
    /// The angle of the geometry's own normal to the other's shading normal, in degrees.
    pub geometric_normal: Option<Summary>,
    /// The pixels where the sun shines on the other and that this one darkens.
    pub darkened: Darkened,
}

impl View {
    /// Looks at a scene of which a picture was made.
    ///
    /// # Errors
    /// If the camera sees nothing.
    ///
    /// # Panics
    /// If the image does not have the picture's size.
    pub fn new(scene: &Scene, picture: &Picture, image: RgbImage) -> Result<Self, CameraError> {
        let (width, height) = (picture.width, picture.height);
        let [columns, rows] = [image.width(), image.height()].map(|n| n as usize);
        assert_eq!([columns, rows], [width, height], "another size");
        let lens = picture.lens(scene)?;
        let inside = |point: Vec2| {
            let ray = lens.ray(point.x, point.y);
            scene.tree().occluded1(&ray, &QueryOptions::COHERENT)
        };
        Ok(Self {
            image,
            probe: Probe::new(
                scene,
                &picture.camera,
                [width, height],
                picture.shading,
                picture.lighting.towards_sun,
            )?,
            outline: Outline::new(width, height, inside),
        })
    }

    /// Whether no pixel's middle shows a surface.
    pub fn is_empty(&self) -> bool {
        self.probe.seen().iter().all(Option::is_none)
    }

    /// How far this view is from the true one.
    ///
    /// # Panics
    /// If their sizes differ.
    pub fn difference_from(&self, truth: &Self) -> Difference {
        let flip = flip(&truth.image, &self.image);
        Difference {
            rmse: rmse(&truth.image, &self.image),
            flip: flip.mean,
            flip_map: flip.map,
            outline: self.outline.distance(&truth.outline),
            shading_normal: shading_angles(&self.probe, &truth.probe),
            geometric_normal: geometric_angles(&self.probe, &truth.probe),
            darkened: darkened(&self.probe, &truth.probe),
        }
    }
}
