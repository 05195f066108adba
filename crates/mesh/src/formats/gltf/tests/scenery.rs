//! Cameras and lights.

use glam::DVec3;

use super::{ACCESSORS, data, json, load_text, primitive};

#[test]
fn cameras_and_the_sun_stand_where_their_nodes_put_them() {
    // A quarter turn around y: what looked along -z looks along -x.
    let turn = "\"rotation\":[0,0.7071068,0,0.7071068]";
    let nodes = format!(
        "{{\"mesh\":0}},{{\"name\":\"side\",\"camera\":0,\"translation\":[5,0,0],{turn}}},\
         {{\"extensions\":{{\"KHR_lights_punctual\":{{\"light\":0}}}},{turn}}},\
         {{\"extensions\":{{\"KHR_lights_punctual\":{{\"light\":1}}}}}},{{\"camera\":1}}"
    );
    let text = json(&data(), ACCESSORS, &primitive(3), &nodes, true);
    let text = text.replacen(
        '{',
        "{\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.7853982,\"znear\":0.1}},\
         {\"type\":\"orthographic\",\"orthographic\":{\"xmag\":1,\"ymag\":1,\"zfar\":9,\"znear\":0}}],\
         \"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":\
         {\"lights\":[{\"type\":\"directional\"},{\"type\":\"point\",\"intensity\":0}]}},",
        1,
    );
    let loaded = load_text(&text).unwrap();
    let [camera] = &loaded.scenery.cameras[..] else {
        panic!("{:?}", loaded.scenery);
    };
    assert_eq!((camera.name.as_str(), camera.eye), ("side", 5.0 * DVec3::X));
    assert!(camera.forward.distance(DVec3::NEG_X) < 1e-6);
    assert!(camera.up.distance(DVec3::Y) < 1e-6);
    assert!((camera.fov_degrees - 45.0).abs() < 1e-5);
    assert!(loaded.scenery.suns[0].distance(DVec3::X) < 1e-6);
    assert_eq!(loaded.scenery.suns.len(), 1);
    assert_eq!(
        loaded.report.warnings,
        [
            "1 cameras are not perspective ones, or degenerate, and are not used",
            "1 lights are of an unknown type, dark, or degenerate, and are not used"
        ]
    );
    let absent = text.replace("\"light\":1", "\"light\":7");
    assert_eq!(
        load_text(&absent).unwrap_err(),
        "x.gltf: there is no light 7"
    );
}

#[test]
fn a_long_name_of_a_camera_is_not_kept_once_a_node() {
    let nodes = format!("{{\"mesh\":0}}{}", ",{\"camera\":0}".repeat(300));
    let text = json(&data(), ACCESSORS, &primitive(3), &nodes, true);
    let camera = format!(
        "{{\"cameras\":[{{\"type\":\"perspective\",\"name\":\"{}\",\
         \"perspective\":{{\"yfov\":1,\"znear\":0.1}}}}],",
        "ä".repeat(10_000)
    );
    let cameras = load_text(&text.replacen('{', &camera, 1)).unwrap().scenery;
    let lengths = cameras.cameras.iter().map(|c| c.name.chars().count());
    assert_eq!(lengths.collect::<Vec<_>>(), [128; 300]);
}

#[test]
fn lights_at_a_point_keep_their_intensity_range_and_cone() {
    // A quarter turn around x: what shone along -z shines along y. Scales change neither.
    let turn = "\"rotation\":[0.7071068,0,0,0.7071068],\"scale\":[3,3,3]";
    let light = |n: u32| format!("\"extensions\":{{\"KHR_lights_punctual\":{{\"light\":{n}}}}}");
    let nodes = format!(
        "{{\"mesh\":0,\"children\":[1,2]}},{{\"translation\":[1,2,3],{}}},{{{},{turn}}},{{{}}}",
        light(0),
        light(1),
        light(2)
    );
    let text = json(&data(), ACCESSORS, &primitive(3), &nodes, true);
    let text = text.replacen(
        '{',
        "{\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[\
         {\"type\":\"point\",\"color\":[1,0.5,0],\"intensity\":8},\
         {\"type\":\"spot\",\"range\":5,\"spot\":{\"innerConeAngle\":0.5,\
         \"outerConeAngle\":1.5707964}},\
         {\"type\":\"spot\",\"spot\":{\"innerConeAngle\":1,\"outerConeAngle\":0.5}}]}},",
        1,
    );
    let loaded = load_text(&text).unwrap();
    let [point, spot] = loaded.scenery.lamps[..] else {
        panic!("{:?}", loaded.scenery);
    };
    assert_eq!(point.position, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(point.intensity, DVec3::new(8.0, 4.0, 0.0));
    assert_eq!((point.range, point.cone), (None, None));
    assert_eq!((spot.intensity, spot.range), (DVec3::ONE, Some(5.0)));
    let cone = spot.cone.unwrap();
    assert!(cone.axis.distance(DVec3::Y) < 1e-6, "{}", cone.axis);
    assert_eq!(cone.angles, [0.5, std::f64::consts::FRAC_PI_2]);
    assert_eq!(loaded.report.warnings.len(), 1, "the third has no cone");
}
