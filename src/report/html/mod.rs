//! A report as one HTML page: the findings, the map they are on, and the rules they break. It needs no network.
//!
//! Text of the map is hostile. It stands in the page only inside packed data, which the page's script shows as text;
//! the page's policy runs no script but its own, known by hash, and loads nothing.

mod compare;
mod data;
mod pack;
mod pages;
mod place;

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::{self, Write as _};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::DeflateEncoder;
use serde_json::json;
use sha2::{Digest, Sha256};

pub use compare::{Earlier, EarlierError};

use super::{Report, VERSION};
use crate::requirement::Requirement;
use place::Frame;

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
}

/// The page's scripts in the order in which they are read; they share one scope.
const SCRIPTS: [&str; 13] = [
    include_str!("decode.js"),
    include_str!("state.js"),
    include_str!("index.js"),
    include_str!("style.js"),
    include_str!("paint.js"),
    include_str!("pins.js"),
    include_str!("view.js"),
    include_str!("hands.js"),
    include_str!("filters.js"),
    include_str!("list.js"),
    include_str!("card.js"),
    include_str!("summary.js"),
    include_str!("main.js"),
];

const STYLE: &str = include_str!("style.css");
const PAGE: &str = include_str!("page.html");

/// The page. Fails only where the compressor does.
pub fn html(report: &Report<'_>, page: &Page<'_>) -> io::Result<String> {
    let frame = Frame::of(report.map);
    let mut findings = data::findings(&report.entries(), report.map, &frame);
    if let Some(earlier) = page.earlier {
        compare::compare(&mut findings, earlier, &frame);
    }
    let data = json!({
        "title": page.title,
        "path": page.path,
        "version": VERSION,
        "frame": { "origin": [frame.origin.x, frame.origin.y], "lonlat": frame.lonlat },
        "earlier": page.earlier.map(Earlier::title),
        "requirements": data::requirements(page.requirements, report),
        "findings": findings,
    });
    let map_data = STANDARD.encode(pack::pack(report.map, &frame)?);
    let report_data = STANDARD.encode(deflate(data.to_string().as_bytes())?);
    // Only broken rules bring their pictures, so that the page stays small.
    let broken: BTreeSet<&str> = report.diagnostics.iter().filter_map(|one| one.code.split('/').next()).collect();
    let pages = page.requirements.iter().map(|one| pages::page(one, broken.contains(one.id.as_str())));
    let pages: String = pages.collect();
    let script = script();
    let policy = policy(&script);
    let title = pages::escape(page.title);
    let parts: [(&str, &str); 7] = [
        ("{{policy}}", &policy),
        ("{{title}}", &title),
        ("{{style}}", STYLE),
        ("{{pages}}", &pages),
        ("{{data}}", &format!("{}{report_data}</script>", compare::DATA_MARK)),
        ("{{map}}", &map_data),
        ("{{script}}", &script),
    ];
    Ok(fill(PAGE, &parts))
}

/// All scripts as one, in a scope of its own.
fn script() -> String {
    let mut script = String::from("(() => {\n'use strict';\n");
    for part in SCRIPTS {
        script += part;
    }
    script + "})();\n"
}

/// Only what the page itself brings may run or shape it. JOSM's remote control listens on a port of this machine.
fn policy(script: &str) -> String {
    let hash = |text: &str| STANDARD.encode(Sha256::digest(text.as_bytes()));
    format!(
        "default-src 'none'; script-src 'sha256-{}'; style-src 'sha256-{}'; img-src data:; \
         connect-src http://127.0.0.1:8111; base-uri 'none'; form-action 'none'; require-trusted-types-for 'script'",
        hash(script),
        hash(STYLE),
    )
}

/// Puts each part where its mark stands, once, without looking into what was put in.
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
