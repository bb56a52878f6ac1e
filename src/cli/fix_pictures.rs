//! `fix --pictures`: a page with the places that were mended, before and after side by side, and what was done there.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use crate::api::{Fixed, files};
use crate::diagnostic::{Place, Subject};
use crate::fix::Mend;
use crate::geometry::Point;
use crate::lanelet::locate::locate;
use crate::lanelet::{LaneletMap, from_osm};
use crate::report::diff::Diff;
use crate::report::draw::sketch::beside;
use crate::report::draw::{self, Focus, Options, bounding_box};
use crate::report::failure::Failure;
use crate::report::html::escape;

use super::{gallery, stage};

/// What was done in one square of this size, metres, is in one picture.
const SQUARE: f64 = 80.0;
/// Around that, metres.
const MARGIN: f64 = 40.0;
/// What is within this of where it was, metres, has not moved.
const STILL: f64 = 0.001;

/// Writes the page and its pictures into a directory, all or nothing; gives how many places there are.
pub fn write(dir: &Path, fixed: &Fixed) -> Result<usize, Failure> {
    let before = &fixed.loaded.map;
    let after = &from_osm(&fixed.mended.osm, &fixed.loaded.projector).map;
    let (places, unseen) = places([before, after], &fixed.mended.done);
    let title = fixed.loaded.files.first().and_then(|file| file.file_name()).unwrap_or_default();
    let mut page = gallery::head(&escape(&title.display().to_string()));
    let mut pictures: Vec<(String, String)> = Vec::new();
    for place in places {
        let name = format!("{}.svg", pictures.len() + 1);
        let _ = writeln!(
            page,
            "<section><figure class=\"wide\"><a href=\"{name}\"><img loading=\"lazy\" src=\"{name}\" alt=\"before and after\"></a></figure>{}</section>",
            list(&place.done)
        );
        pictures.push((name, place.picture([before, after])?));
    }
    if !unseen.is_empty() {
        let _ = writeln!(page, "<section><h2>What a picture does not show</h2>{}</section>", list(&unseen));
    }
    let texts = pictures.iter().map(|(name, svg)| (name.as_str(), svg.as_bytes()));
    let all: Vec<(&str, &[u8])> = texts.chain([("index.html", page.as_bytes())]).collect();
    files::publish(dir, &all)?;
    Ok(pictures.len())
}

/// Where something was done.
#[derive(Default)]
struct Mended<'a> {
    at: Vec<Point>,
    done: Vec<&'a Mend>,
}

/// What was done, by place; and that of which no place is known, or where only points differ, which no picture shows.
fn places<'a>(maps: [&LaneletMap; 2], done: &'a [Mend]) -> (Vec<Mended<'a>>, Vec<&'a Mend>) {
    let [before, after] = maps;
    let place = |subject| [after, before].iter().find_map(|map| locate(map, subject, &Place::Unknown).local);
    let square = |place: Point| [place.y, place.x].map(|metres| (metres / SQUARE).floor() as i64);
    let changed = Diff::between(before, after, STILL).changes.into_iter().map(|change| change.subject);
    let seen = changed.filter(|subject| !matches!(subject, Subject::Point(_))).filter_map(place).map(square);
    let mut squares: BTreeMap<[i64; 2], Mended<'_>> = seen.map(|square| (square, Mended::default())).collect();
    let mut unseen = Vec::new();
    for mend in done {
        let place = place(mend.subject);
        match place.and_then(|place| squares.get_mut(&square(place))) {
            Some(mended) => {
                mended.at.extend(place);
                mended.done.push(mend);
            }
            None => unseen.push(mend),
        }
    }
    (squares.into_values().filter(|mended| !mended.done.is_empty()).collect(), unseen)
}

impl Mended<'_> {
    /// The place before and after, side by side.
    fn picture(&self, [before, after]: [&LaneletMap; 2]) -> Result<String, Failure> {
        let (low, high) = bounding_box(&self.at).unwrap_or_default();
        let radius = (high - low).max() / 2.0 + MARGIN;
        let options = Options { focus: Focus::Around(nalgebra::center(&low, &high), radius), ..Options::default() };
        let view = draw::view(after, &options).map_err(stage::failure)?;
        let [left, right] = [before, after].map(|map| draw::svg_of(map, &[], view, &options));
        Ok(beside(&left, &right, view))
    }
}

fn list(done: &[&Mend]) -> String {
    let item = |mend: &&Mend| {
        format!("<li><code>{}</code> {}: {}</li>", escape(&mend.code), mend.subject, escape(&mend.title))
    };
    format!("<ul>{}</ul>", done.iter().map(item).collect::<String>())
}
