//! The report: one page with everything in it, which loads nothing.

use std::io::Cursor;

use anyhow::{Context, Result};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::{ImageFormat, RgbImage};
use minijinja::Environment;
use serde::Serialize;

use super::figures::Figures;
use super::pictures::{Pictures, Shown};
use super::table::{self, ComparisonTable};

/// The name says that what is put into it is escaped for HTML.
const NAME: &str = "report.html";
const TEMPLATE: &str = include_str!("report.html");
const STYLE: &str = include_str!("report.css");
const SCRIPT: &str = include_str!("report.js");

/// What the template is filled with.
#[derive(Serialize)]
struct Page<'a> {
    style: &'static str,
    script: &'static str,
    figures: &'a Figures,
    pictures: Vec<ReportPicture<'a>>,
    tables: Vec<ComparisonTable>,
    version: &'static str,
}

#[derive(Serialize)]
struct ReportPicture<'a> {
    key: &'a str,
    title: &'a str,
    caption: &'a str,
    data: String,
}

/// The page.
pub fn html(figures: &Figures, pictures: &Pictures) -> Result<String> {
    let pictures: Result<_> = pictures.shown.iter().map(ReportPicture::of).collect();
    let page = Page {
        style: STYLE,
        script: SCRIPT,
        figures,
        pictures: pictures?,
        tables: table::tables(figures),
        version: env!("CARGO_PKG_VERSION"),
    };
    let mut environment = Environment::new();
    environment.set_trim_blocks(true);
    environment.set_lstrip_blocks(true);
    environment.add_template(NAME, TEMPLATE)?;
    let template = environment.get_template(NAME)?;
    let page = template.render(page);
    page.context("cannot write the report")
}

impl<'a> ReportPicture<'a> {
    fn of(shown: &'a Shown) -> Result<Self> {
        Ok(Self {
            key: &shown.key,
            title: &shown.title,
            caption: &shown.caption,
            data: data_uri(&shown.image)?,
        })
    }
}

fn data_uri(image: &RgbImage) -> Result<String> {
    let mut png = Cursor::new(Vec::new());
    image.write_to(&mut png, ImageFormat::Png)?;
    Ok(format!(
        "data:image/png;base64,{}",
        STANDARD.encode(png.into_inner())
    ))
}
