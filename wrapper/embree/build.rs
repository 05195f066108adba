//! Finds the installed Embree, compiles the shim over it (`shim/`) and links both.
//!
//! `EMBREE_DIR`, a prefix with `include/` and `lib/`, goes before the system's Embree. With `DOCS_RS`
//! set nothing is compiled or linked: the documentation is that of Embree 4.3.

use std::env;
use std::path::{Path, PathBuf};
use std::process::exit;

const MISSING: &str = "curvetri needs Embree 3.13 or 4.3 and later with its headers: install them \
     (on Debian and Ubuntu: apt-get install libembree-dev), or set EMBREE_DIR to a prefix that has \
     include/ and lib/";

/// The Embree to build against.
struct Embree {
    /// 3 or 4.
    major: u32,
    /// `RTC_VERSION` of its headers, as in 31305.
    version: u32,
    /// Levels of nested instances it was built for.
    levels: u32,
    /// Whether its hits carry `instPrimID`.
    inst_prim_id: bool,
    /// The prefix given by `EMBREE_DIR`.
    prefix: Option<PathBuf>,
}

fn main() {
    for watched in ["build.rs", "shim"] {
        println!("cargo::rerun-if-changed={watched}");
    }
    for watched in ["EMBREE_DIR", "DOCS_RS"] {
        println!("cargo::rerun-if-env-changed={watched}");
    }
    println!("cargo::rustc-check-cfg=cfg(embree3, embree4, inst_prim_id, embree_bindgen)");
    if env::var_os("DOCS_RS").is_some() {
        println!("cargo::rustc-cfg=embree4");
        println!("cargo::rustc-cfg=inst_prim_id");
        return;
    }
    let embree = find().unwrap_or_else(|message| fail(&message));
    println!("cargo::rustc-cfg=embree{}", embree.major);
    if embree.inst_prim_id {
        println!("cargo::rustc-cfg=inst_prim_id");
    }
    bind(&embree);
    compile(&embree);
    link(&embree);
}

fn fail(message: &str) -> ! {
    println!("cargo::error={message}");
    exit(1)
}

fn find() -> Result<Embree, String> {
    let prefix = env::var_os("EMBREE_DIR")
        .filter(|dir| !dir.is_empty())
        .map(PathBuf::from);
    for major in [4, 3] {
        if let Some(prefix) = &prefix {
            // the compiler would go on to look among the system's headers
            let header = prefix.join(format!("include/embree{major}/rtcore.h"));
            if !header.is_file() {
                continue;
            }
        }
        if let Some(embree) = probe(major, prefix.clone())? {
            return Ok(embree);
        }
    }
    Err(match prefix {
        Some(prefix) => format!(
            "EMBREE_DIR is {}, where there is neither include/embree4/rtcore.h nor \
             include/embree3/rtcore.h; {MISSING}",
            prefix.display()
        ),
        None => MISSING.to_owned(),
    })
}

/// What the compiler knows of this major version of Embree; `None` if it finds no headers.
fn probe(major: u32, prefix: Option<PathBuf>) -> Result<Option<Embree>, String> {
    let expanded = compiler(major, prefix.as_deref())
        .cargo_metadata(false)
        .file("shim/probe.c")
        .try_expand()
        .map_err(|error| format!("the C compiler does not run: {error}"))?;
    let expanded = String::from_utf8_lossy(&expanded);
    // what a macro expands to may come in lines of its own, with line markers between them
    let lines = expanded.lines().filter(|line| !line.starts_with('#'));
    let words: Vec<&str> = lines.flat_map(str::split_whitespace).collect();
    let Some(at) = words.iter().position(|&word| word == "curvetri_probe") else {
        return Ok(None);
    };
    let numbers: Vec<u32> = words[at + 1..]
        .iter()
        .filter_map(|word| word.parse().ok())
        .collect();
    let &[version, levels, arrays] = numbers.as_slice() else {
        return Err(format!(
            "Embree's headers give no version: {:?}",
            &words[at..]
        ));
    };
    // so that another Embree in its place is noticed
    if let Some(header) = header(&expanded, major) {
        println!("cargo::rerun-if-changed={header}");
    }
    let embree = Embree {
        major,
        version,
        levels,
        inst_prim_id: arrays == 1,
        prefix,
    };
    if version < 31300 || (40000..40300).contains(&version) {
        return Err(format!(
            "the Embree found is {}; {MISSING}",
            dotted(version)
        ));
    }
    Ok(Some(embree))
}

/// The file that the compiler's line markers (`# 1 "/usr/include/embree4/rtcore_config.h" 1`) name as Embree's.
fn header(expanded: &str, major: u32) -> Option<&str> {
    let mut markers = expanded.lines().filter(|line| line.starts_with("# "));
    let ending = format!("embree{major}/rtcore_config.h");
    markers.find_map(|line| {
        line.split('"')
            .nth(1)
            .filter(|file| file.ends_with(&ending))
    })
}

fn dotted(version: u32) -> String {
    format!(
        "{}.{}.{}",
        version / 10000,
        version / 100 % 100,
        version % 100
    )
}

fn compiler(major: u32, prefix: Option<&Path>) -> cc::Build {
    let mut build = cc::Build::new();
    build
        .define("CURVETRI_EMBREE", major.to_string().as_str())
        .std("c11");
    if let Some(prefix) = prefix {
        build.include(prefix.join("include"));
    }
    build
}

fn compile(embree: &Embree) {
    compiler(embree.major, embree.prefix.as_deref())
        .files(["shim/shim.c", "shim/linked.c"])
        .warnings(true)
        .compile("curvetri_shim");
}

fn link(embree: &Embree) {
    if let Some(prefix) = &embree.prefix {
        let name = format!("libembree{}.", embree.major);
        let holds = |dir: &PathBuf| {
            dir.read_dir().is_ok_and(|mut entries| {
                entries.any(|entry| {
                    entry.is_ok_and(|entry| entry.file_name().to_string_lossy().starts_with(&name))
                })
            })
        };
        let Some(lib) = ["lib", "lib64"]
            .map(|dir| prefix.join(dir))
            .into_iter()
            .find(holds)
        else {
            fail(&format!(
                "EMBREE_DIR is {}, whose lib/ has no {name}*",
                prefix.display()
            ));
        };
        println!("cargo::rustc-link-search=native={}", lib.display());
        println!("cargo::rustc-link-arg=-Wl,-rpath,{}", lib.display());
    }
    println!("cargo::metadata=version={}", dotted(embree.version));
}

/// The committed bindings fit Embree as distributions build it.
#[cfg(not(feature = "bindgen"))]
fn bind(embree: &Embree) {
    if embree.levels != 1 || embree.inst_prim_id != (embree.major == 4) {
        fail(&format!(
            "the Embree found ({}) was built with {} instance levels and {} instance arrays, which \
             changes its structures: build curvetri with the feature `bindgen` (it needs libclang)",
            dotted(embree.version),
            embree.levels,
            if embree.inst_prim_id {
                "with"
            } else {
                "without"
            },
        ));
    }
}

/// Generates what `ci/bindings.sh` compares with the committed bindings.
#[cfg(feature = "bindgen")]
fn bind(embree: &Embree) {
    let plain = bindgen::EnumVariation::NewType {
        is_bitfield: false,
        is_global: false,
    };
    let mut builder = bindgen::Builder::default()
        .header("shim/shim.h")
        .clang_arg(format!("-DCURVETRI_EMBREE={}", embree.major))
        .allowlist_function("curvetri_.*")
        .allowlist_type("Curvetri.*|RTCRay|RTCHit|RTCRayHit|RTC(Ray|Hit|RayHit)(4|8|16)")
        .allowlist_type(
            "RTCDeviceProperty|RTC(Bounds|Filter|Intersect|Occluded)Function.*Arguments",
        )
        .allowlist_var("RTC_MAX_(INSTANCE_LEVEL|TIME_STEP)_COUNT|RTC_VERSION_M.*")
        .default_enum_style(plain)
        .bitfield_enum("RTC.*Flags")
        .prepend_enum_name(false)
        .generate_comments(false)
        .layout_tests(true)
        .rust_edition(bindgen::RustEdition::Edition2024)
        .formatter(bindgen::Formatter::Prettyplease);
    if let Some(prefix) = &embree.prefix {
        builder = builder.clang_arg(format!("-I{}", prefix.join("include").display()));
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap()).join("bindings.rs");
    builder
        .generate()
        .unwrap_or_else(|error| fail(&format!("bindgen cannot read Embree's headers: {error}")))
        .write_to_file(&out)
        .unwrap_or_else(|error| fail(&format!("{}: {error}", out.display())));
    println!("cargo::rustc-cfg=embree_bindgen");
}
