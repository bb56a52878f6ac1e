//! The page as a program on this machine serves it: without data, which it fetches, and fetches again when files change.

use std::io;

use serde_json::Value;

use super::ghosts::{Ghost, pages_ghosts};
use super::place::Frame;
use super::workshop::{Workshop, pages_workshop};
use super::{JOSM, MAIN, Page, SCRIPTS, deflate, facts, filled, pack, pages};
use crate::report::Report;
use crate::requirement::Requirement;

/// What only a served page shows.
#[derive(Clone, Copy, Debug, Default)]
pub struct Served<'a> {
    /// What fixes would change.
    pub ghosts: &'a [Ghost],
    /// How the map came to be.
    pub workshop: Option<&'a Workshop>,
}

/// What a served page has more.
const LIVE: [&str; 2] = [include_str!("live.js"), include_str!("ghosts.js")];
/// What the page of a map in the making has more.
const WORKSHOP: [&str; 4] =
    [include_str!("live.js"), include_str!("stages.js"), include_str!("bench.js"), include_str!("panel.js")];

/// The page of a report, with these requirements, each with its pictures.
pub fn served(title: &str, requirements: &[&Requirement]) -> String {
    page(title, requirements, &LIVE)
}

/// The page of a map in the making.
pub fn served_workshop(title: &str, requirements: &[&Requirement]) -> String {
    page(title, requirements, &WORKSHOP)
}

fn page(title: &str, requirements: &[&Requirement], more: &[&'static str]) -> String {
    let pages: String = requirements.iter().map(|one| pages::page(one, true)).collect();
    let scripts = [&SCRIPTS[..SCRIPTS.len() - 1], more, &[MAIN]].concat();
    filled(title, &pages, &scripts, &format!("'self' {JOSM}"), None)
}

/// What the page fetches: the length of the packed report (u32, little-endian), the report, the map.
pub fn parcel(report: &Report<'_>, page: &Page<'_>, served: &Served<'_>) -> io::Result<Vec<u8>> {
    let frame = Frame::of(report.map, page.origin);
    let mut facts = facts(report, page, &frame);
    facts["ghosts"] = pages_ghosts(served.ghosts, &frame);
    facts["workshop"] = served.workshop.map_or(Value::Null, |workshop| pages_workshop(workshop, &frame));
    let facts = deflate(facts.to_string().as_bytes())?;
    let length = u32::try_from(facts.len()).map_err(io::Error::other)?;
    Ok([&length.to_le_bytes()[..], &facts, &pack::pack(report.map, &frame)?].concat())
}
