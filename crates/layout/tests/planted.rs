//! Sources with a planted fault, which has to be found, and sources with none.

use std::fs;
use std::path::Path;

use curvetri_layout::Sources;
use tempfile::TempDir;

/// The declared order of the planted crates: `low` may not know of `high`.
const ORDER: &[&str] = &["low", "high"];

/// What is found in a crate of these files, with what every crate here has: `low/item.rs` with `Low` and `low`,
/// `high/item.rs` with `High`, `high`, a macro and a constant.
fn faults(files: &[(&str, &str)]) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let given = [
        ("lib.rs", "mod low;\nmod high;\n"),
        ("low/mod.rs", "mod item;\npub use item::{Low, low};\n"),
        ("low/item.rs", "pub struct Low;\npub fn low() {}\n"),
        ("high/mod.rs", "pub mod item;\npub use item::*;\n"),
        (
            "high/item.rs",
            "use crate::low::Low;\npub struct High(pub Low);\npub fn high() {}\n\
             pub const MOST: [u8; 2] = { [1, 2] };\n\
             macro_rules! raise { () => {}; }\npub(crate) use raise;\n",
        ),
    ];
    for (name, text) in given.iter().chain(files) {
        write(&folder, name, text);
    }
    let sources = Sources::read(folder.path().join("lib.rs")).unwrap();
    sources.faults("", ORDER)
}

fn write(folder: &TempDir, name: &str, text: &str) {
    let path = folder.path().join(Path::new(name));
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, text).unwrap();
}

/// What is found where `low/item.rs` has this as well.
fn faults_with(text: &str) -> Vec<String> {
    faults(&[(
        "low/item.rs",
        &format!("pub struct Low;\npub fn low() {{}}\n{text}\n"),
    )])
}

fn assert_upwards(text: &str) {
    let faults = faults_with(text);
    let upwards = |fault: &String| {
        fault.starts_with("upwards: low/item.rs:") && fault.ends_with("of high/item.rs")
    };
    assert!(faults.iter().any(upwards), "{text}: {faults:?}");
    // `high` imports `low`, so an arrow upwards closes a circle here.
    let circle = |fault: &String| fault.starts_with("circle: ");
    assert!(faults.iter().any(circle), "{text}: {faults:?}");
}

#[test]
fn an_order_that_holds_has_no_faults() {
    assert_eq!(faults(&[]), Vec::<String>::new());
}

#[test]
fn an_arrow_upwards_is_found_however_it_is_written() {
    for text in [
        "use crate::high::High;",
        "use crate::high::item::High;",
        "use crate::{low::Low as Own, high::{self, High as Other}};",
        "use super::super::high::High;",
        "pub use crate::high::High as Lent;",
        "pub fn f() { crate::high::high() }",
        "pub fn f() -> u8 { 1 + super::super::high::MOST[0] }",
        "pub fn f() -> u8 { -crate::high::MOST[0] }",
        "pub fn f(range: u8) -> bool { (0..crate::high::MOST[0]).contains(&range) }",
        "pub fn f() { use crate::high::{High, high}; high() }",
        "pub fn f() { assert_eq!(1, usize::from(crate::high::MOST[0])); }",
        "pub fn f() { crate::high::raise!(); }",
        "pub fn f() { raise!(); }",
        "use crate::high; pub fn f() { high::high() }",
        "use crate::high as other; pub fn f() { other::high() }",
        "pub struct S { pub high: Vec<crate::high::High> }",
        "pub trait T { fn f(&self) -> crate::high::High; }",
        "impl Low { pub(crate) fn f(self) -> crate::high::High { todo!() } }",
        "impl From<crate::high::High> for Low { fn from(_: crate::high::High) -> Low { Low } }",
        "pub mod inner { pub fn f() { super::super::super::high::high() } }",
        "#[allow(dead_code)] pub(crate) const F: fn() = crate::high::high;",
        "use crate::high::*;",
        "thread_local! { static S: crate::high::High = todo!(); }",
    ] {
        assert_upwards(text);
    }
}

#[test]
fn a_re_export_is_followed_to_the_file_that_defines_the_item() {
    for (root, text) in [
        (
            "mod low;\nmod high;\npub use high::High;\n",
            "use crate::High;",
        ),
        (
            "mod low;\nmod high;\npub use high::item as part;\n",
            "use crate::part::High;",
        ),
        (
            "mod low;\nmod high;\npub use high::*;\n",
            "pub fn f() { crate::high() }",
        ),
        (
            "mod low;\nmod high;\nmod inner { pub use super::high::High as Other; }\npub use inner::Other;\n",
            "use crate::Other;",
        ),
    ] {
        let low = format!("pub struct Low;\npub fn low() {{}}\n{text}\n");
        let faults = faults(&[("lib.rs", root), ("low/item.rs", &low)]);
        let upwards = |fault: &String| {
            fault.starts_with("upwards: low/item.rs:") && fault.ends_with("of high/item.rs")
        };
        assert!(faults.iter().any(upwards), "{root}{text}: {faults:?}");
    }
}

#[test]
fn a_re_export_of_what_lies_below_is_no_fault() {
    let root = "mod low;\nmod high;\npub use low::Low;\npub use high::High;\n";
    let high = "use crate::Low;\npub struct High(pub Low);\npub fn high() {}\n";
    assert_eq!(
        faults(&[("lib.rs", root), ("high/item.rs", high)]),
        Vec::<String>::new()
    );
}

#[test]
fn a_circle_of_files_within_a_folder_is_found() {
    let faults = faults(&[
        (
            "low/mod.rs",
            "mod item;\nmod a;\nmod b;\nmod c;\npub use item::{Low, low};\n",
        ),
        ("low/a.rs", "use super::b::B;\npub struct A(B);\n"),
        ("low/b.rs", "pub struct B;\nfn f() { super::c::c() }\n"),
        (
            "low/c.rs",
            "pub fn c() { let _: Option<crate::low::a::A> = None; }\n",
        ),
    ]);
    let [circle] = &faults[..] else {
        panic!("{faults:?}");
    };
    for file in ["low/a.rs:", "low/b.rs:", "low/c.rs:"] {
        assert!(circle.contains(file), "{circle}");
    }
}

#[test]
fn what_a_folder_s_root_defines_is_above_its_files() {
    let faults = faults(&[
        (
            "low/mod.rs",
            "mod item;\npub use item::{Low, low};\npub fn root() { low() }\n",
        ),
        (
            "low/item.rs",
            "pub struct Low;\npub fn low() { super::root() }\n",
        ),
    ]);
    assert!(
        faults.iter().any(|fault| fault.starts_with("circle: ")),
        "{faults:?}"
    );
}

#[test]
fn tests_may_use_anything() {
    for text in [
        "#[cfg(test)]\nmod tests { use crate::high::High; }",
        "#[cfg(all(test, unix))]\nmod tests { use crate::high::High; }",
        "#[test]\nfn f() { crate::high::high() }",
        "#[cfg(test)]\nuse crate::high::High;\npub fn g() {}",
        "impl Low { #[cfg(test)] pub fn f<A, B>() { crate::high::high() } pub fn g() {} }",
        "pub struct S { #[cfg(test)] high: crate::high::High, pub a: u8 }",
    ] {
        assert_eq!(faults_with(text), Vec::<String>::new(), "{text}");
    }
    assert_upwards("#[cfg(not(test))]\nuse crate::high::High;");
    assert_upwards("#[cfg(any(test, unix))]\nuse crate::high::High;");
    assert_upwards("impl Low { #[cfg(test)] pub fn f() {} pub fn g() { crate::high::high() } }");
}

#[test]
fn a_file_of_tests_is_not_read() {
    let faults = faults(&[
        (
            "low/mod.rs",
            "mod item;\n#[cfg(test)]\nmod tests;\npub use item::{Low, low};\n",
        ),
        ("low/tests.rs", "use crate::high::High;\n"),
    ]);
    assert_eq!(faults, Vec::<String>::new());
}

#[test]
fn a_method_that_stands_above_its_type_is_an_arrow_upwards_where_it_is_called() {
    let high = |method: &str| {
        format!(
            "use crate::low::Low;\npub struct High(pub Low);\npub fn high() {{}}\n\
             impl<'a> Low {{ pub fn {method}(&self) -> u8 {{ 1 }} }}\n"
        )
    };
    for call in ["low.lift()", "Low::lift(low)", "low.lift::<u8>()"] {
        let low =
            format!("pub struct Low;\npub fn low() {{}}\npub fn f(low: &Low) {{ {call}; }}\n");
        let faults = faults(&[("high/item.rs", &high("lift")), ("low/item.rs", &low)]);
        let upwards = |fault: &String| fault.starts_with("upwards: low/item.rs:3 imports");
        assert!(faults.iter().any(upwards), "{call}: {faults:?}");
    }
    // Two files define it: the name does not tell which is called.
    let low =
        "pub struct Low;\npub fn low() {}\npub fn f(low: &Low) { low.lift(); }\nfn lift() {}\n";
    let found = faults(&[("high/item.rs", &high("lift")), ("low/item.rs", low)]);
    assert_eq!(found, Vec::<String>::new());
}

#[test]
fn what_only_looks_like_an_import_is_none() {
    for text in [
        "/// As [`High`](crate::high::High).\npub fn f() {} // crate::high",
        "pub(in crate::low) fn f() { let _ = \"crate::high::High\"; }",
        "pub fn f() { let high = Low; high.high(); }\nimpl Low { fn high(&self) {} }",
        "pub fn f<'high>(a: &'high u8) -> &'high u8 { a }",
        "use std::collections::HashMap as high; pub fn f() { let _ = high::<u8, u8>::new(); }",
        "pub fn f() { ::std::mem::drop(<u8 as Default>::default()); }",
    ] {
        assert_eq!(faults_with(text), Vec::<String>::new(), "{text}");
    }
}

#[test]
fn a_folder_that_is_not_declared_and_one_that_is_not_there_are_faults() {
    let faults = faults(&[
        ("lib.rs", "mod low;\nmod high;\nmod other;\n"),
        ("other.rs", "pub fn f() {}\n"),
    ]);
    assert_eq!(faults, ["undeclared: other in \"\""]);
    let folder = tempfile::tempdir().unwrap();
    write(&folder, "lib.rs", "mod low;\n");
    write(&folder, "low.rs", "pub fn f() {}\n");
    let sources = Sources::read(folder.path().join("lib.rs")).unwrap();
    assert_eq!(sources.faults("", ORDER), ["missing: high in \"\""]);
}

#[test]
fn a_missing_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    write(&folder, "lib.rs", "mod gone;\n");
    let error = Sources::read(folder.path().join("lib.rs")).err().unwrap();
    assert!(error.to_string().contains("gone"), "{error}");
}
