//! The page as a program on this machine serves it: without data, which it fetches, and fetches again when files change.

use std::io;

use serde_json::Value;

use super::build_stages::{BuildStages, page_build_stages};
use super::fix_preview::{FixPreview, page_fix_previews};
use super::plane::Frame;
use super::{JOSM, MAIN, Page, SCRIPTS, deflate, facts, filled, pack, pages};
use crate::geometry::Point;
use crate::lanelet::LaneletMap;
use crate::report::Report;
use crate::requirement::Requirement;

/// What only a served page shows.
#[derive(Clone, Copy, Debug, Default)]
pub struct Served<'a> {
    /// What fixes would change.
    pub previews: &'a [FixPreview],
    /// How the map came to be.
    pub build_stages: Option<&'a BuildStages>,
    /// How far a review has come, as `review.js` reads it.
    pub review: Option<&'a Value>,
}

/// What a served page has more.
const MAP_SCRIPTS: [&str; 3] = [include_str!("live.js"), include_str!("fix_preview.js"), include_str!("planner.js")];
/// What the page of a map in the making has more.
const BUILD_SCRIPTS: [&str; 4] =
    [include_str!("live.js"), include_str!("stages.js"), include_str!("editing.js"), include_str!("panel.js")];

/// What the page of a review has more.
const REVIEW_SCRIPTS: [&str; 4] =
    [include_str!("live.js"), include_str!("fix_preview.js"), include_str!("review.js"), include_str!("hand_edits.js")];

/// The page of a review.
pub fn served_review(title: &str, requirements: &[&Requirement]) -> String {
    page(title, requirements, &REVIEW_SCRIPTS)
}

/// Where the plane of a map's page has its origin, in the map's metres.
pub fn page_origin(map: &LaneletMap) -> Point {
    Frame::of(map, None).origin
}

/// What a fix would change, as the page reads it.
pub fn shown_previews(previews: &[FixPreview], origin: Point) -> Value {
    page_fix_previews(previews, &Frame { origin, lonlat: None })
}

/// The page of a report, with these requirements, each with its pictures.
pub fn served(title: &str, requirements: &[&Requirement]) -> String {
    page(title, requirements, &MAP_SCRIPTS)
}

/// The page of a map in the making.
pub fn served_build_stages(title: &str, requirements: &[&Requirement]) -> String {
    page(title, requirements, &BUILD_SCRIPTS)
}

fn page(title: &str, requirements: &[&Requirement], more: &[&'static str]) -> String {
    let pages: String = requirements.iter().map(|one| pages::page(one, true)).collect();
    let scripts = [&SCRIPTS[..SCRIPTS.len() - 1], more, &[MAIN]].concat();
    filled(title, &pages, &scripts, &format!("'self' {JOSM}"), None)
}

/// What the page fetches: the length of the packed report (u32, little-endian), the report, the map.
///
/// # Errors
///
/// If the data cannot be compressed.
pub fn parcel(report: &Report<'_>, page: &Page<'_>, served: &Served<'_>) -> io::Result<Vec<u8>> {
    let frame = Frame::of(report.map, page.origin);
    let mut facts = facts(report, page, &frame);
    facts["fix_previews"] = page_fix_previews(served.previews, &frame);
    facts["workshop"] = served.build_stages.map_or(Value::Null, |build_stages| page_build_stages(build_stages, &frame));
    facts["review"] = served.review.cloned().unwrap_or_default();
    let facts = deflate(facts.to_string().as_bytes())?;
    let length = u32::try_from(facts.len()).map_err(io::Error::other)?;
    Ok([&length.to_le_bytes()[..], &facts, &pack::pack(report.map, &frame)?].concat())
}
