//! The cameras and lights of a glTF file's scene.

use std::f64::consts::FRAC_PI_2;

use glam::{DAffine3, DVec3};
use gltf::json::camera::Type as CameraType;
use gltf::json::extensions::scene::khr_lights_punctual::{Light, Type as LightType};
use gltf::json::validation::Checked;
use gltf::json::{Node, Root};

use crate::error::MAX_COORDINATE;
use crate::report::LoadReport;
use crate::scenery::{FileCamera, FileCone, FileLamp, Scenery};

/// The most characters of a camera's name: many nodes may carry one camera.
const LONGEST_NAME: usize = 128;

/// Reads the cameras and lights of the nodes; warns of what cannot be used.
pub(super) fn read(
    root: &Root,
    nodes: &[(usize, DAffine3)],
    report: &mut LoadReport,
) -> Result<Scenery, String> {
    let mut scenery = Scenery::default();
    let (mut other_cameras, mut other_lights) = (0, 0);
    for &(index, to_scene) in nodes {
        let node = &root.nodes[index];
        if node.camera.is_some() {
            match camera(root, node, to_scene)? {
                Some(camera) => scenery.cameras.push(camera),
                None => other_cameras += 1,
            }
        }
        if let Some(light) = light(root, node)? {
            match usable(light, to_scene) {
                Some(Usable::Sun(towards)) => scenery.suns.push(towards),
                Some(Usable::Lamp(lamp)) => scenery.lamps.push(lamp),
                None => other_lights += 1,
            }
        }
    }
    if other_cameras > 0 {
        report.warnings.push(format!(
            "{other_cameras} cameras are not perspective ones, or degenerate, and are not used"
        ));
    }
    if other_lights > 0 {
        report.warnings.push(format!(
            "{other_lights} lights are of an unknown type, dark, or degenerate, and are not used"
        ));
    }
    Ok(scenery)
}

/// A node's camera, if it is one that can be used.
fn camera(root: &Root, node: &Node, to_scene: DAffine3) -> Result<Option<FileCamera>, String> {
    let Some(index) = node.camera else {
        return Ok(None);
    };
    let camera = root.get(index);
    let camera = camera.ok_or_else(|| format!("there is no camera {}", index.value()))?;
    let perspective = match camera.type_ {
        Checked::Valid(CameraType::Perspective) => camera.perspective.as_ref(),
        _ => None,
    };
    let axes = to_scene.matrix3;
    let unit = |v: DVec3| v.try_normalize().filter(|v| v.is_finite());
    let (Some(perspective), Some(forward), Some(up)) =
        (perspective, unit(-axes.z_axis), unit(axes.y_axis))
    else {
        return Ok(None);
    };
    let fov_degrees = f64::from(perspective.yfov).to_degrees();
    let eye = to_scene.translation;
    let usable = fov_degrees > 0.0 && fov_degrees < 180.0 && eye.is_finite();
    let name = node.name.as_ref().filter(|name| !name.is_empty());
    let name = name.or(camera.name.as_ref()).map_or("", String::as_str);
    Ok(usable.then(|| FileCamera {
        name: name.chars().take(LONGEST_NAME).collect(),
        eye,
        forward,
        up,
        fov_degrees,
    }))
}

/// A node's light.
fn light<'a>(root: &'a Root, node: &Node) -> Result<Option<&'a Light>, String> {
    let extension = node.extensions.as_ref();
    let Some(light) = extension.and_then(|e| e.khr_lights_punctual.as_ref()) else {
        return Ok(None);
    };
    let lights = root.extensions.as_ref();
    let lights = lights.and_then(|e| e.khr_lights_punctual.as_ref());
    let index = light.light.value();
    let light = lights.and_then(|lights| lights.lights.get(index));
    let light = light.ok_or_else(|| format!("there is no light {index}"))?;
    Ok(Some(light))
}

/// A light that can be used.
enum Usable {
    /// The direction towards it.
    Sun(DVec3),
    Lamp(FileLamp),
}

/// The light where a node puts it: it shines along its own negative z axis. Scales do not change it.
fn usable(light: &Light, to_scene: DAffine3) -> Option<Usable> {
    let towards = to_scene.matrix3.z_axis.try_normalize();
    let towards = towards.filter(|towards| towards.is_finite());
    let type_ = match light.type_ {
        Checked::Valid(type_) => type_,
        Checked::Invalid => return None,
    };
    let cone = match type_ {
        LightType::Directional => return towards.map(Usable::Sun),
        LightType::Point => None,
        LightType::Spot => Some(cone(light, -towards?)?),
    };
    let colour = DVec3::from(light.color.map(f64::from)).max(DVec3::ZERO);
    let lamp = FileLamp {
        position: to_scene.translation,
        intensity: f64::from(light.intensity) * colour,
        range: light.range.map(f64::from),
        cone,
    };
    let shines = lamp.intensity.is_finite() && lamp.intensity.max_element() > 0.0;
    let has_range = lamp.range.is_none_or(|range| range > 0.0);
    let near = lamp.position.abs().max_element() <= MAX_COORDINATE;
    (shines && light.intensity > 0.0 && has_range && near).then_some(Usable::Lamp(lamp))
}

/// A spot light's cone, if its angles are such as the extension allows.
fn cone(light: &Light, axis: DVec3) -> Option<FileCone> {
    let angles = match &light.spot {
        Some(spot) => [spot.inner_cone_angle, spot.outer_cone_angle],
        None => [0.0, std::f32::consts::FRAC_PI_4],
    };
    let [inner, outer] = angles.map(f64::from);
    // A right angle in single precision is a little more than one.
    let usable = inner >= 0.0 && inner < outer && outer < FRAC_PI_2 + 1e-6;
    usable.then_some(FileCone {
        axis,
        angles: [inner, outer].map(|angle| angle.min(FRAC_PI_2)),
    })
}
