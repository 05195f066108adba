//! The declared order of the workspace: of packages, and of folders and files within them. Whoever adds a
//! folder declares here what it may know of.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use curvetri_layout::Sources;
use serde_json::Value;

/// The packages, each with those of this workspace that it may depend on. Tests and benches may depend on more.
const PACKAGES: &[(&str, &[&str])] = &[
    ("curvetri-method", &[]),
    ("curvetri-mesh", &[]),
    ("curvetri-embree", &[]),
    ("curvetri-embree-linked", &["curvetri-embree"]),
    (
        "curvetri",
        &[
            "curvetri-method",
            "curvetri-mesh",
            "curvetri-embree",
            "curvetri-embree-linked",
        ],
    ),
    ("curvetri-bodies", &["curvetri-mesh"]),
    (
        "curvetri-accuracy",
        &["curvetri", "curvetri-embree-linked", "curvetri-bodies"],
    ),
    (
        "curvetri-bench",
        &["curvetri", "curvetri-embree-linked", "curvetri-bodies"],
    ),
    (
        "curvetri-cli",
        &[
            "curvetri",
            "curvetri-embree-linked",
            "curvetri-bodies",
            "curvetri-accuracy",
            "curvetri-bench",
        ],
    ),
    (
        "curvetri-demo",
        &["curvetri", "curvetri-embree-linked", "curvetri-bodies"],
    ),
    ("curvetri-fuzz-seeds", &["curvetri-mesh", "curvetri-bodies"]),
    ("curvetri-test-support", &["curvetri", "curvetri-bodies"]),
    ("curvetri-layout", &[]),
];

/// Folders whose parts have an order: the crate's root file, the folder, and its parts from the bottom up.
const FOLDERS: &[(&str, &str, &[&str])] = &[
    (
        "src/lib.rs",
        "",
        &["method", "output", "curved", "render", "compare"],
    ),
    (
        "src/lib.rs",
        "curved",
        &[
            "bits",
            "options",
            "triangle",
            "build",
            "cluster",
            "curved_mesh",
            "query",
            "geometries",
            "report",
            "tessellate",
        ],
    ),
    (
        "src/lib.rs",
        "render",
        &[
            "rounding",
            "stats",
            "material",
            "vicinity",
            "camera",
            "light",
            "shape",
            "placed_shape",
            "tree",
            "scene",
            "hit_geometry",
            "extent",
            "shading",
            "all_hits",
            "user_ray",
            "ray_batch",
            "framing",
            "picture",
            "film",
            "integrate",
            "exr",
        ],
    ),
    (
        "src/lib.rs",
        "compare",
        &[
            "summary",
            "pictures",
            "outline",
            "probe",
            "normals",
            "terminator",
            "view",
        ],
    ),
    (
        "crates/method/src/lib.rs",
        "",
        &[
            "numbers",
            "patch",
            "evaluate",
            "bounds",
            "store",
            "build",
            "intersect",
        ],
    ),
];

fn workspace() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    root.canonicalize().expect("the workspace is there")
}

#[test]
fn folders_import_downwards_and_no_file_by_a_circle() {
    let mut faults = Vec::new();
    for (root, folder, order) in FOLDERS {
        let sources = Sources::read(workspace().join(root)).unwrap();
        let [files, imports] = [sources.files().len(), sources.imports().len()];
        assert!(
            imports > files,
            "{root}: {imports} imports in {files} files"
        );
        faults.extend(sources.faults(folder, order));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn packages_depend_on_what_they_may() {
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let metadata = Command::new(cargo)
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .current_dir(workspace())
        .output()
        .unwrap();
    assert!(metadata.status.success(), "{metadata:?}");
    let metadata: Value = serde_json::from_slice(&metadata.stdout).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    let name = |value: &Value| value["name"].as_str().unwrap().to_owned();
    let own: Vec<String> = packages.iter().map(name).collect();
    let mut found = BTreeMap::new();
    for package in packages {
        let dependencies = package["dependencies"].as_array().unwrap().iter();
        let dependencies = dependencies.filter(|dependency| dependency["kind"] != "dev");
        let dependencies: Vec<String> = dependencies
            .map(name)
            .filter(|dependency| own.contains(dependency))
            .collect();
        found.insert(name(package), dependencies);
    }
    let allowed: BTreeMap<&str, &[&str]> = PACKAGES.iter().copied().collect();
    for (package, dependencies) in &found {
        let Some(allowed) = allowed.get(package.as_str()) else {
            panic!("{package} is not in the declared order");
        };
        for dependency in dependencies {
            let may = allowed.contains(&dependency.as_str());
            assert!(may, "{package} depends on {dependency}");
        }
    }
    for package in allowed.keys() {
        assert!(
            found.contains_key(*package),
            "{package} is declared but not there"
        );
    }
}

#[test]
fn what_packages_may_depend_on_is_declared_before_them() {
    for (n, (package, allowed)) in PACKAGES.iter().enumerate() {
        let before: Vec<&str> = PACKAGES[..n].iter().map(|(name, _)| *name).collect();
        for dependency in *allowed {
            assert!(before.contains(dependency), "{package}: {dependency}");
        }
    }
}
