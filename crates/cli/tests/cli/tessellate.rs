//! `curvetri tessellate` as a whole program.

use crate::program::Workshop;
use curvetri::mesh::{Loader, Topology};

#[test]
fn a_ball_of_four_triangles_becomes_round() {
    let shop = Workshop::new();
    let (ball, fine) = (shop.sphere("ball.obj"), shop.path("fine.obj"));
    shop.succeeds(&["tessellate", &ball, "--level", "6", "-o", &fine]);
    let mesh = Loader::new().load(&fine).unwrap().mesh;
    assert_eq!(mesh.triangles().len(), 4 * 36);
    assert!(Topology::new(&mesh).counts().is_closed());
    for (p, n) in mesh.positions().iter().zip(mesh.normals()) {
        assert!(
            (p.length() - 1.0).abs() < 1e-5 && n.dot(*p) > 0.9999,
            "{p} {n}"
        );
    }
}

#[test]
fn what_cannot_be_cut_is_refused_and_leaves_no_file() {
    let shop = Workshop::new();
    let ball = shop.sphere("ball.obj");
    let text = shop.fails(
        2,
        &["tessellate", &ball, "--surface", "flat", "-o", "out.obj"],
    );
    assert!(text.contains("nothing to cut"), "{text}");
    let text = shop.fails(1, &["tessellate", "absent.obj", "-o", "out.obj"]);
    assert!(text.contains("absent.obj"), "{text}");
    assert_eq!(shop.names(), ["ball.obj"]);
}
