//! Extensions of glTF: which do not matter, and what is said of the others.

use gltf::json::Root;

use crate::report::LoadReport;

/// Extensions that say nothing of the surface's shape, or nothing that is not read.
const HARMLESS: [&str; 10] = [
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_animation_",
    "KHR_xmp",
    "KHR_mesh_quantization",
    "MSFT_texture_",
    "ADOBE_materials_",
];

/// Extensions that compress a mesh's numbers.
const COMPRESSION: [&str; 3] = [
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
];

/// Refuses what cannot be read, and warns of what is left out.
pub(super) fn check(root: &Root, report: &mut LoadReport) -> Result<(), String> {
    let is_harmless = |name: &str| HARMLESS.iter().any(|start| name.starts_with(start));
    for name in &root.extensions_required {
        if COMPRESSION.contains(&name.as_str()) {
            return Err(is_compressed(name));
        }
        if !is_harmless(name) {
            return Err(format!(
                "it needs the glTF extension {name}, which is not read; export it without"
            ));
        }
    }
    if root
        .extensions_used
        .iter()
        .any(|e| e == "EXT_mesh_gpu_instancing")
    {
        let what = "copies made by EXT_mesh_gpu_instancing are not read";
        report.warnings.push(what.into());
    }
    Ok(())
}

/// The extension by which the file's numbers are compressed, if it names one.
pub(super) fn compression(root: &Root) -> Option<&'static str> {
    let used = |name: &str| root.extensions_used.iter().any(|used| used == name);
    COMPRESSION.into_iter().find(|name| used(name))
}

/// A sentence on numbers that are compressed.
pub(super) fn is_compressed(extension: &str) -> String {
    format!(
        "its data is compressed by the glTF extension {extension}, which is not read; export it \
         without compression, or unpack it with `gltf-transform copy`"
    )
}
