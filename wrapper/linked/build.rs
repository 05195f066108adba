//! Finds the installed Embree, compiles the shim that fills its table (`shim/`) and links both.
//!
//! `EMBREE_DIR`, a prefix with `include/` and `lib/`, goes before the system's Embree. A build script of a package
//! that depends on this one finds that `lib/` in `DEP_EMBREE_LIB`, for its programs' run-time path. With `DOCS_RS` set
//! nothing is compiled or linked.

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
    /// The prefix given by `EMBREE_DIR`.
    prefix: Option<PathBuf>,
}

fn main() {
    for watched in ["build.rs", "include", "shim"] {
        println!("cargo::rerun-if-changed={watched}");
    }
    for watched in ["EMBREE_DIR", "DOCS_RS"] {
        println!("cargo::rerun-if-env-changed={watched}");
    }
    if env::var_os("DOCS_RS").is_some() {
        return;
    }
    let embree = find().unwrap_or_else(|message| fail(&message));
    #[cfg(feature = "bindgen")]
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
    let &[version, levels] = numbers.as_slice() else {
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
        prefix,
    };
    if version < 31300 || (40000..40300).contains(&version) {
        return Err(format!(
            "the Embree found is {}; {MISSING}",
            dotted(version)
        ));
    }
    if levels != 1 {
        return Err(format!(
            "the Embree found ({}) was built for {levels} levels of nested instances, but curvetri takes 1: set \
             EMBREE_DIR to one that was built with EMBREE_MAX_INSTANCE_LEVEL_COUNT=1, as distributions do",
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
        .file("shim/linked.c")
        .include("include")
        .warnings(true)
        .compile("curvetri_linked_embree");
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
        // for this package's own tests
        println!("cargo::rustc-link-arg=-Wl,-rpath,{}", lib.display());
        println!("cargo::metadata=lib={}", lib.display());
    }
    println!("cargo::rustc-link-lib=embree{}", embree.major);
    println!("cargo::metadata=version={}", dotted(embree.version));
}

/// Generates what `ci/bindings.sh` compares with the committed bindings in `curvetri-embree`: those of Embree's own
/// types (`embree_3.rs`, `embree_4.rs`) and of the table (`table.rs`).
#[cfg(feature = "bindgen")]
fn bind(embree: &Embree) {
    let plain = bindgen::EnumVariation::NewType {
        is_bitfield: false,
        is_global: false,
    };
    let builder = || {
        bindgen::Builder::default()
            .default_enum_style(plain)
            .prepend_enum_name(false)
            .generate_comments(false)
            .layout_tests(true)
            .rust_edition(bindgen::RustEdition::Edition2024)
            .formatter(bindgen::Formatter::Prettyplease)
    };
    let mut types = builder()
        .header("shim/embree.h")
        .clang_arg(format!("-DCURVETRI_EMBREE={}", embree.major))
        .bitfield_enum("RTC.*Flags")
        .allowlist_type("RTC(Ray|Hit|RayHit)(4|8|16)?|RTC(Intersect|RayQuery)Context")
        .allowlist_type("RTC(Bounds|(Bounds|Filter|Intersect|Occluded)Function.*Arguments)")
        .allowlist_type(
            "RTC(BufferType|BuildQuality|DeviceProperty|Error|Format|GeometryType|SceneFlags)",
        )
        .allowlist_var("RTC_MAX_(INSTANCE_LEVEL|TIME_STEP)_COUNT|RTC_VERSION_M.*");
    if let Some(prefix) = &embree.prefix {
        types = types.clang_arg(format!("-I{}", prefix.join("include").display()));
    }
    let table = builder()
        .header("include/curvetri_table.h")
        .allowlist_file(".*curvetri_table.h");
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap());
    for (builder, name) in [
        (types, format!("embree_{}.rs", embree.major)),
        (table, "table.rs".to_owned()),
    ] {
        let path = out.join(name);
        let bindings = builder
            .generate()
            .unwrap_or_else(|error| fail(&format!("bindgen cannot read the headers: {error}")));
        if let Err(error) = bindings.write_to_file(&path) {
            fail(&format!("{}: {error}", path.display()));
        }
    }
}
