//! What the program says of meshes that are odd.

use crate::program::{Workshop, stderr};

/// A triangle at a place along x, a vertex beside it that no face names, and a line.
fn odd(x: f64) -> String {
    format!(
        "v 0 0 0\nv {x} 0 0\nv {} 0 0\nv {x} 1 0\nl 1 2\nf 2 3 4\n",
        x + 1.0
    )
}

/// What a run of the program warns of, a line each.
fn warnings(shop: &Workshop, args: &[&str]) -> Vec<String> {
    let said = stderr(&shop.succeeds(args));
    let lines = said.lines().filter(|line| line.contains("warning: "));
    lines.map(str::to_owned).collect()
}

fn render<'a>(meshes: &[&'a str], picture: &'a str) -> Vec<&'a str> {
    [&["render"], meshes, &["-o", picture, "--size", "8x8"]].concat()
}

#[test]
fn inspect_says_what_render_says() {
    let shop = Workshop::new();
    let mesh = shop.write("odd.obj", odd(0.0));
    let picture = shop.path("odd.png");
    let rendered = warnings(&shop, &render(&[&mesh], &picture));
    assert_eq!(rendered.len(), 2, "{rendered:?}");
    assert!(
        rendered[1].contains("1 vertex is in no face"),
        "{rendered:?}"
    );
    assert_eq!(warnings(&shop, &["inspect", &mesh]), rendered);
    assert_eq!(warnings(&shop, &["inspect", "--json", &mesh]), rendered);
    let quiet: [String; 0] = [];
    assert_eq!(warnings(&shop, &["inspect", "--quiet", &mesh]), quiet);
}

#[test]
fn meshes_without_any_area_are_refused_unless_others_have_some() {
    let shop = Workshop::new();
    let line = shop.write("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 1 1 2\n");
    let picture = shop.path("line.png");
    let run = shop.run(&render(&[&line], &picture));
    assert_eq!(run.status.code(), Some(1));
    let said = stderr(&run);
    assert!(
        said.contains("none of the 2 triangles has an area"),
        "{said}"
    );
    assert!(said.contains("error: no triangle has an area"), "{said}");
    assert!(!std::path::Path::new(&picture).exists());
    let other = shop.write("other.obj", odd(0.0));
    let warned = warnings(&shop, &render(&[&line, &other], &picture));
    assert!(warned[0].contains("line.obj: none of the 2"), "{warned:?}");
    let warned = warnings(&shop, &["inspect", &line]);
    assert!(warned[0].contains("line.obj: none of the 2"), "{warned:?}");
}

#[test]
fn files_too_far_apart_for_one_scene_are_told() {
    let shop = Workshop::new();
    let [here, there] = [0.0, 5e6].map(|x| shop.write(&format!("{x}.obj"), odd(x)));
    let picture = shop.path("both.png");
    let apart = |meshes: &[&str]| {
        let mut warned = warnings(&shop, &render(meshes, &picture));
        warned.retain(|line| line.contains("so far apart"));
        warned
    };
    assert_eq!(apart(&[&here]), [] as [String; 0]);
    assert_eq!(apart(&[&there]), [] as [String; 0]);
    let both = apart(&[&here, &there]);
    assert!(both[0].contains("shape of 1 triangle;"), "{both:?}");
    // Many of a file at the same place, and one elsewhere.
    assert_eq!(apart(&[&there, &there]), [] as [String; 0]);
}
