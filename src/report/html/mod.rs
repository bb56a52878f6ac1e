//! A report as one HTML page: the findings, the map they are on, and the rules they break. It needs no network.
//!
//! Text of the map is hostile. It stands in the page only inside packed data, which the page's script shows as text;
//! the page's policy runs no script but its own, known by hash, and loads nothing.

mod build_stages;
mod changes;
mod compare;
mod data;
mod fix_preview;
mod pack;
mod pages;
mod plane;
mod served;

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::{self, Write as _};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::DeflateEncoder;
use serde_json::json;
use sha2::{Digest, Sha256};

pub use build_stages::{BuildStages, InputRoad, InputWay, Stage};
pub use changes::changes_page;
pub use compare::{Earlier, EarlierError};
pub use fix_preview::{FixPreview, fix_previews, shape_of};
pub use pages::escape;
pub use served::{Served, page_origin, parcel, served, served_build_stages, served_review, shown_previews};

use super::{Report, VERSION, groups};
use crate::geometry::Point;
use crate::lane_stitching;
use crate::requirement::Requirement;
use plane::Frame;

/// What a page shows beside the run's own [`Report`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Page<'a> {
    /// How the map is called: the name of its file or directory.
    pub title: &'a str,
    /// The map's file as an absolute path, for an editor to open; `None` if there is none, or more than one.
    pub path: Option<&'a str>,
    /// All requirements in the standard's order; those that the report does not name were skipped.
    pub requirements: &'a [&'a Requirement],
    /// A report to compare with.
    pub earlier: Option<&'a Earlier>,
    /// Where the page's plane has its origin, in the map's metres; from the map itself where absent.
    pub origin: Option<Point>,
}

/// The page's scripts in the order in which they are read; they share one scope.
const SCRIPTS: [&str; 14] = [
    include_str!("decode.js"),
    include_str!("state.js"),
    include_str!("index.js"),
    include_str!("style.js"),
    include_str!("paint.js"),
    include_str!("pins.js"),
    include_str!("view.js"),
    include_str!("input_gestures.js"),
    include_str!("area.js"),
    include_str!("filters.js"),
    include_str!("list.js"),
    include_str!("popup.js"),
    include_str!("summary.js"),
    MAIN,
];
/// Starts everything; the last of all scripts.
const MAIN: &str = include_str!("main.js");

const STYLE: &str = include_str!("style.css");
const PAGE: &str = include_str!("page.html");

/// The page.
///
/// # Errors
///
/// If the data cannot be compressed.
pub fn html(report: &Report<'_>, page: &Page<'_>) -> io::Result<String> {
    let frame = Frame::of(report.map, page.origin);
    let data = STANDARD.encode(deflate(facts(report, page, &frame).to_string().as_bytes())?);
    let map = STANDARD.encode(pack::pack(report.map, &frame)?);
    // Only broken rules bring their pictures, so that the page stays small.
    let broken: BTreeSet<&str> = report.diagnostics.iter().filter_map(|one| one.code.split('/').next()).collect();
    let pages = page.requirements.iter().map(|one| pages::page(one, broken.contains(one.id.as_str())));
    Ok(filled(page.title, &pages.collect::<String>(), &SCRIPTS, JOSM, Some([&data, &map])))
}

/// What the page knows beside the map.
fn facts(report: &Report<'_>, page: &Page<'_>, frame: &Frame) -> serde_json::Value {
    let mut findings = data::findings(&report.entries(), report.map, frame);
    if let Some(earlier) = page.earlier {
        compare::compare(&mut findings, earlier, frame);
    }
    let messages = findings.iter().map(|one| (one.severity, one.code.as_str(), one.message.as_str()));
    let groups = groups(messages, page.requirements);
    json!({
        "title": page.title,
        "path": page.path,
        "version": VERSION,
        "frame": { "origin": [frame.origin.x, frame.origin.y], "lonlat": frame.lonlat },
        "earlier": page.earlier.map(Earlier::title),
        "requirements": data::requirements(page.requirements, report),
        "show": report.show,
        "groups": groups.iter().map(|one| json!({ "sentence": one.sentence, "members": one.members })).collect::<Vec<_>>(),
        "findings": findings,
    })
}

/// The page with its parts in their places; `data` are the packed report and map, where the page brings them along.
fn filled(title: &str, pages: &str, scripts: &[&str], connect: &str, data: Option<[&str; 2]>) -> String {
    let paint = json!({
        "thin": lane_stitching::PAINT,
        "thick": 2.0 * lane_stitching::PAINT,
        "kerb": lane_stitching::KERB,
        "apart": lane_stitching::DOUBLE_APART,
        "dash": [lane_stitching::DASH, lane_stitching::DASH_PERIOD - lane_stitching::DASH],
    });
    let script = format!("(() => {{\n'use strict';\nconst PAINT = {paint};\n{}}})();\n", scripts.concat());
    let policy = policy(&script, connect);
    let [report, map] = data.unwrap_or_default();
    let report = data.map_or_else(String::new, |_| format!("{}{report}</script>", compare::DATA_MARK));
    let map = data.map_or_else(String::new, |_| {
        format!("<script type=\"application/octet-stream\" id=\"map-data\">{map}</script>")
    });
    let parts: [(&str, &str); 7] = [
        ("{{policy}}", &policy),
        ("{{title}}", &pages::escape(title)),
        ("{{style}}", STYLE),
        ("{{pages}}", pages),
        ("{{data}}", &report),
        ("{{map}}", &map),
        ("{{script}}", &script),
    ];
    fill(PAGE, &parts)
}

/// JOSM's remote control, which listens on a port of this machine.
const JOSM: &str = "http://127.0.0.1:8111";

/// Only what the page itself brings may run or shape it, and only to `connect` may it speak.
fn policy(script: &str, connect: &str) -> String {
    let hash = |text: &str| STANDARD.encode(Sha256::digest(text.as_bytes()));
    format!(
        "default-src 'none'; script-src 'sha256-{}'; style-src 'sha256-{}'; img-src data:; \
         connect-src {connect}; base-uri 'none'; form-action 'none'; require-trusted-types-for 'script'",
        hash(script),
        hash(STYLE),
    )
}

/// Puts each part where its mark is, once, without looking into what was put in.
fn fill(page: &str, parts: &[(&str, &str)]) -> String {
    let mut out = String::with_capacity(page.len() + parts.iter().map(|(_, text)| text.len()).sum::<usize>());
    let mut rest = page;
    while let Some(start) = rest.find("{{") {
        let (before, from) = rest.split_at(start);
        out += before;
        match parts.iter().find(|(mark, _)| from.starts_with(mark)) {
            Some((mark, text)) => {
                out += text;
                rest = &from[mark.len()..];
            }
            None => {
                let _ = out.write_str("{{");
                rest = &from[2..];
            }
        }
    }
    out + rest
}

fn deflate(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut deflate = DeflateEncoder::new(Vec::new(), Compression::new(7));
    deflate.write_all(bytes)?;
    deflate.finish()
}

#[cfg(test)]
mod tests;
