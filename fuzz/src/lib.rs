//! What the fuzz targets share: a loader's run under a limit on memory, and what has to hold of it.

use std::alloc::System;
use std::sync::Once;

use cap::Cap;
use curvetri::mesh::{Loader, Mesh, Scenery};

mod cast;

pub use cast::cast_rays;

/// Beyond the limit an allocation fails, which ends the process: a crash with the place on the stack.
#[global_allocator]
static MEMORY: Cap<System> = Cap::new(System, usize::MAX);

/// How much of memory a file may take, in times its own length.
const TIMES: usize = 10;

/// What any file may take: tables of constant size, and what the readers allow even the smallest.
const ANY: usize = 1 << 20;

/// The name makes binary files that are cut off STL files, and does nothing else.
const NAME: &str = "fuzzed.stl";

/// A file's format is told by its content, so each target has its own way to keep the fuzzer from
/// wandering off into the other formats: files that do not start like its own are not looked at.
pub fn load(file: &[u8], is_own: impl Fn(&[u8]) -> bool) {
    if is_own(file) {
        load_within(file, file.len());
    }
}

/// Loads a file, which has this length once unpacked, and checks what comes out. Then the same with
/// what is wrong in it skipped.
pub fn load_within(file: &[u8], length: usize) {
    one_thread();
    for lenient in [false, true] {
        load_by(Loader::new().lenient(lenient), file.to_vec(), length);
    }
}

fn load_by(loader: Loader<'_>, file: Vec<u8>, length: usize) {
    MEMORY
        .set_limit(MEMORY.allocated() + TIMES * length + ANY)
        .expect("the limit is above what is in use");
    let loaded = loader.load_bytes(file, NAME);
    MEMORY.set_limit(usize::MAX).expect("no limit");
    match loaded {
        Err(error) => assert_names_place(&error.to_string()),
        Ok(loaded) => {
            assert_sound(&loaded.mesh);
            assert_usable(&loaded.scenery);
        }
    }
}

/// Makes rayon work on the calling thread, which is faster with files this small, and the same at
/// every run.
pub fn one_thread() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
        let pool = pool.use_current_thread().build_global();
        pool.expect("the pool has not been used before");
    });
}

fn assert_names_place(message: &str) {
    assert!(message.starts_with(&format!("{NAME}:")), "{message}");
}

fn assert_sound(mesh: &Mesh) {
    assert!(!mesh.triangles().is_empty());
    assert_eq!(mesh.positions().len(), mesh.normals().len());
    assert!(mesh.origin().is_finite());
    assert!(mesh.positions().iter().all(|p| p.is_finite()));
    assert!(mesh.normals().iter().all(|n| n.is_normalized()));
    let indices = mesh.triangles().as_flattened();
    assert!(
        indices
            .iter()
            .all(|&i| (i as usize) < mesh.positions().len())
    );
}

fn assert_usable(scenery: &Scenery) {
    assert!(scenery.suns.iter().all(|sun| sun.is_normalized()));
    for camera in &scenery.cameras {
        assert!(camera.eye.is_finite());
        assert!(camera.forward.is_normalized() && camera.up.is_normalized());
        assert!(camera.fov_degrees > 0.0 && camera.fov_degrees < 180.0);
    }
    for lamp in &scenery.lamps {
        assert!(lamp.position.is_finite() && lamp.intensity.is_finite());
        assert!(lamp.intensity.min_element() >= 0.0 && lamp.intensity.max_element() > 0.0);
        assert!(lamp.range.is_none_or(|range| range > 0.0));
    }
}
