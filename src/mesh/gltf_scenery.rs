//! The cameras and lights of a glTF file's scene.

use glam::{DAffine3, DVec3};
use gltf::json::camera::Type as CameraType;
use gltf::json::extensions::scene::khr_lights_punctual::Type as LightType;
use gltf::json::validation::Checked;
use gltf::json::{Node, Root};

use super::LoadReport;
use super::scenery::{FileCamera, Scenery};

/// How many characters of a camera's name are kept: many nodes may carry one camera.
const LONGEST_NAME: usize = 128;

/// Reads the cameras and the infinitely far lights of the nodes; the others are told of.
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
        match light(root, node)? {
            // It shines along its own negative z axis.
            Some(Checked::Valid(LightType::Directional)) => {
                let towards = to_scene.matrix3.z_axis.try_normalize();
                scenery
                    .suns
                    .extend(towards.filter(|towards| towards.is_finite()));
            }
            Some(_) => other_lights += 1,
            None => {}
        }
    }
    if other_cameras > 0 {
        report.warnings.push(format!(
            "{other_cameras} cameras are not perspective ones, or degenerate, and are not used"
        ));
    }
    if other_lights > 0 {
        report.warnings.push(format!(
            "{other_lights} point or spot lights are not used; only directional ones are"
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

/// The type of a node's light.
fn light(root: &Root, node: &Node) -> Result<Option<Checked<LightType>>, String> {
    let extension = node.extensions.as_ref();
    let Some(light) = extension.and_then(|e| e.khr_lights_punctual.as_ref()) else {
        return Ok(None);
    };
    let lights = root.extensions.as_ref();
    let lights = lights.and_then(|e| e.khr_lights_punctual.as_ref());
    let index = light.light.value();
    let light = lights.and_then(|lights| lights.lights.get(index));
    let light = light.ok_or_else(|| format!("there is no light {index}"))?;
    Ok(Some(light.type_))
}
