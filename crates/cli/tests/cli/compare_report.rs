//! The report of `curvetri compare` in a browser: drawn, driven by the keyboard, without a network.

use std::path::Path;

use crate::browser::Browser;
use crate::program::Workshop;
use serde_json::{Value, json};

const TAB: (&str, u32) = ("Tab", 9);
const RIGHT: (&str, u32) = ("ArrowRight", 39);
const DOWN: (&str, u32) = ("ArrowDown", 40);
const HOME: (&str, u32) = ("Home", 36);
const END: (&str, u32) = ("End", 35);

/// A report of a ball, beside itself as a reference.
fn report(shop: &Workshop) -> String {
    let mesh = shop.sphere("ball.obj");
    let html = shop.path("report.html");
    shop.succeeds(&[
        "compare",
        &mesh,
        "--reference",
        &mesh,
        "-o",
        &shop.path("a.png"),
        "--report",
        &html,
        "--size",
        "320x240",
        "--samples",
        "2",
        "--also",
        "angular",
    ]);
    html
}

/// Presses Tab until this element has the focus.
fn tab_to(browser: &mut Browser, id: &str) {
    for _ in 0..20 {
        if browser.value("document.activeElement.id") == id {
            return;
        }
        browser.press(TAB.0, TAB.1);
    }
    panic!("the keyboard does not get to {id}");
}

/// What the slider shows: its value, where the left picture ends, and the pictures' descriptions.
fn slider(browser: &mut Browser) -> Value {
    browser.value(
        "({
            value: document.getElementById('split').value,
            clip: getComputedStyle(document.getElementById('left-picture')).clipPath,
            left: document.getElementById('left-picture').alt,
            right: document.getElementById('right-picture').alt,
            words: document.getElementById('split').getAttribute('aria-valuetext'),
        })",
    )
}

#[test]
fn the_report_is_driven_by_the_keyboard_and_loads_nothing() {
    let Some(mut browser) = Browser::start() else {
        return;
    };
    let shop = Workshop::new();
    let page = report(&shop);
    browser.open(Path::new(&page), "");

    let drawn = "Array.from(document.images, (image) => [image.complete, image.naturalWidth])";
    let drawn = browser.value(drawn);
    let drawn = drawn.as_array().unwrap();
    assert!(drawn.len() >= 8, "{drawn:?}");
    assert!(
        drawn.iter().all(|image| *image == json!([true, 320])),
        "{drawn:?}"
    );
    let nameless = "Array.from(document.images).filter((image) => !image.alt).length";
    assert_eq!(browser.value(nameless), 0);

    let before = slider(&mut browser);
    assert_eq!(before["value"], "50");
    assert_eq!(before["words"], "50 % flat, 50 % curved");
    tab_to(&mut browser, "left");
    browser.press(DOWN.0, DOWN.1);
    tab_to(&mut browser, "split");
    for _ in 0..3 {
        browser.press(RIGHT.0, RIGHT.1);
    }
    let moved = slider(&mut browser);
    assert_eq!(moved["value"], "53");
    assert_eq!(moved["clip"], "inset(0px 47% 0px 0px)");
    assert_eq!(
        moved["words"], "53 % curved, 47 % curved",
        "the arrow chose the next picture"
    );
    assert_eq!(moved["left"], moved["right"]);
    assert_ne!(moved["left"], before["left"]);
    browser.press(END.0, END.1);
    assert_eq!(slider(&mut browser)["value"], "100");
    browser.press(HOME.0, HOME.1);
    assert_eq!(slider(&mut browser)["clip"], "inset(0px 100% 0px 0px)");
    let focused = "getComputedStyle(document.getElementById('split')).outlineStyle";
    assert_eq!(browser.value(focused), "solid", "the focus is seen");

    let requests = browser
        .events
        .iter()
        .filter(|event| event["method"] == "Network.requestWillBeSent");
    let asked: Vec<&str> = requests
        .map(|event| event["params"]["request"]["url"].as_str().unwrap())
        .filter(|url| !url.starts_with("data:") && !url.starts_with("file://"))
        .collect();
    assert!(asked.is_empty(), "{asked:?}");
    let files = |event: &&Value| {
        let url = event["params"]["request"]["url"].as_str();
        url.is_some_and(|url| url.starts_with("file://"))
    };
    assert_eq!(
        browser.events.iter().filter(files).count(),
        1,
        "the page itself"
    );
    let complaints: Vec<&Value> = browser
        .events
        .iter()
        .filter(|event| {
            event["method"] == "Runtime.exceptionThrown" || event["method"] == "Log.entryAdded"
        })
        .collect();
    assert!(complaints.is_empty(), "{complaints:#?}");
}

#[test]
fn the_report_fits_a_narrow_window_and_goes_dark() {
    let Some(mut browser) = Browser::start() else {
        return;
    };
    let shop = Workshop::new();
    let page = report(&shop);
    let narrow = json!({ "width": 360, "height": 700, "deviceScaleFactor": 1, "mobile": false });
    browser.call("Emulation.setDeviceMetricsOverride", narrow);
    browser.open(Path::new(&page), "#left=reference&right=angular&split=20");
    assert_eq!(
        slider(&mut browser)["words"],
        "20 % reference, 80 % angular"
    );
    let sticks_out = "document.documentElement.scrollWidth - document.documentElement.clientWidth";
    assert_eq!(browser.value(sticks_out), 0);
    let wide = "document.getElementById('stage').getBoundingClientRect().width";
    let wide = browser.value(wide).as_f64().unwrap();
    assert!((250.0..345.0).contains(&wide), "the picture is {wide} wide");
    let brightness = |scheme: &str| {
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        browser.call(
            "Emulation.setEmulatedMedia",
            json!({ "features": features }),
        );
        let color = browser.value("getComputedStyle(document.body).backgroundColor");
        let color = color.as_str().unwrap();
        let digits: Vec<u32> = color
            .split(|c: char| !c.is_ascii_digit())
            .filter_map(|n| n.parse().ok())
            .collect();
        digits.iter().sum::<u32>()
    };
    let [light, dark] = ["light", "dark"].map(brightness);
    assert!(light > 600 && dark < 150, "{light} {dark}");
}
