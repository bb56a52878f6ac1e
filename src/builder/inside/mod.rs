//! What the user wants drawn inside intersections: guide lines, stop lines in the middle, virtual traffic lights.
//!
//! OpenStreetMap knows none of these; `lanewright.toml` names them. They are added to the map that stands, which is read
//! as `check` reads it, so that the names of approaches and the turns mean the same here and there. Whatever cannot be
//! drawn as a whole is left out and named: Autoware loads no map with half an element.

mod across;
mod guide;
mod pen;
mod stop_line;
mod virtual_light;

use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::Point;
use crate::lanelet::LaneletMap;
use crate::lanelet::index::{MapIndex, Thresholds};
use crate::projection::{LonLat, Projector};
use crate::settings::{InsideSettings, IntersectionSettings, Place, Settings};

use guide::Guide;
use pen::Pen;
use stop_line::{StopLine, StopLines};
use virtual_light::{VirtualLight, VirtualLights};

pub(super) use pen::is_taken;

/// Slug of the finding about something that is not drawn.
pub const UNDRAWN: &str = "inside-undrawn";

/// What a user wants drawn inside intersections.
#[derive(Clone, Debug, Default)]
pub struct Inside {
    /// In all of them.
    pub everywhere: InsideSettings,
    /// In single ones.
    pub intersections: Vec<IntersectionSettings>,
}

/// What is to be drawn.
#[derive(Default)]
struct Sketch {
    guides: Vec<Guide>,
    stop_lines: Vec<StopLine>,
    lights: Vec<VirtualLight>,
    notes: Vec<Finding>,
}

/// Draws into a map of which the `settings` say what it cannot, and names what is left out.
pub fn draw(map: &mut LaneletMap, projector: &Projector, inside: &Inside, settings: &Settings) -> Vec<Finding> {
    let wanted = inside.intersections.iter().filter(|entry| entry.is_to_draw());
    let wanted: Vec<IntersectionSettings> = wanted.cloned().collect();
    if wanted.is_empty() && inside.everywhere.says_nothing() {
        return Vec::new();
    }
    let mut settings = settings.clone();
    settings.intersection.extend(wanted);
    let sketch = {
        let index = MapIndex::new(map, &[], &settings, Thresholds::default());
        sketch(&index, projector, inside.everywhere)
    };
    let mut pen = Pen::new(map, projector);
    sketch.guides.into_iter().for_each(|guide| guide::draw(&mut pen, guide));
    sketch.stop_lines.into_iter().for_each(|line| stop_line::draw(&mut pen, line));
    let mut ends = virtual_light::EndLines::new();
    sketch.lights.into_iter().for_each(|light| virtual_light::draw(&mut pen, &mut ends, light));
    sketch.notes
}

fn sketch(map: &MapIndex, projector: &Projector, everywhere: InsideSettings) -> Sketch {
    let mut sketch = Sketch { notes: unplaced(map, projector), ..Sketch::default() };
    for (at, traffic) in map.traffic.iter().enumerate() {
        let entries = map.entries_of(at).iter().map(|&entry| &map.settings.intersection[entry]);
        let entries: Vec<&IntersectionSettings> = entries.filter(|entry| entry.is_to_draw()).collect();
        let (mut stop_lines, mut lights) = (StopLines::default(), VirtualLights::default());
        for entry in &entries {
            for (i, ends) in entry.stop_lines.iter().enumerate() {
                let drawn = stop_lines.add(map, traffic, ends.map(|place| metres(projector, place)));
                sketch.notes.extend(drawn.err().map(|why| undrawn(entry, &format!("stop_lines[{i}]"), &why)));
            }
        }
        for entry in &entries {
            for (i, wanted) in entry.virtual_lights.iter().enumerate() {
                let drawn = lights.add(map, at, wanted);
                sketch.notes.extend(drawn.err().map(|why| undrawn(entry, &format!("virtual_lights[{i}]"), &why)));
            }
        }
        sketch.lights.append(&mut lights.lights);
        if map.intersections[at].area.is_none() {
            continue;
        }
        if everywhere.stop_lines == Some(true) {
            stop_lines.add_waiting(map, traffic);
        }
        if everywhere.guide_lines == Some(true) {
            sketch.guides.extend(guide::between_lanes(map, traffic));
        }
        sketch.stop_lines.append(&mut stop_lines.lines);
    }
    sketch
}

/// A place in metres; far away from everything where the projection does not reach it.
fn metres(projector: &Projector, [lat, lon]: Place) -> Point {
    projector.forward(LonLat { lon, lat }, 0.0).unwrap_or(Point::new(f64::MAX.sqrt(), f64::MAX.sqrt()))
}

/// Entries that speak of no intersection.
fn unplaced(map: &MapIndex, projector: &Projector) -> Vec<Finding> {
    let mut found = vec![false; map.settings.intersection.len()];
    (0..map.intersections.len()).flat_map(|at| map.entries_of(at)).for_each(|&entry| found[entry] = true);
    let entries = map.settings.intersection.iter().zip(found);
    let lost = entries.filter(|(entry, found)| entry.is_to_draw() && !found);
    lost.map(|(entry, _)| undrawn(entry, "[[intersection]]", &nowhere(map, projector, entry))).collect()
}

/// Why an entry speaks of no intersection.
fn nowhere(map: &MapIndex, projector: &Projector, entry: &IntersectionSettings) -> String {
    match (entry.ia, entry.at) {
        (None, Some(place)) => {
            let here = metres(projector, place);
            let areas = map.intersections.iter().filter_map(|one| Some((one.area?, (one.middle - here).norm())));
            let [lat, lon] = place;
            match areas.min_by(|a, b| a.1.total_cmp(&b.1)) {
                Some((area, off)) if off < 1e6 => format!(
                    "{lat}, {lon} lies in no intersection_area; the nearest is that of {area}, {off:.0} m away: `ia = {area}`"
                ),
                _ => format!("{lat}, {lon} lies in no intersection_area"),
            }
        }
        (Some(ia), _) => {
            format!("the map has no intersection_area {ia}; say where it is with `at = [latitude, longitude]`")
        }
        (None, None) => "it names no intersection".to_owned(),
    }
}

/// A finding about what an entry wants and the map does not get.
fn undrawn(entry: &IntersectionSettings, what: &str, why: &str) -> Finding {
    let place = entry.origin.as_ref().map_or_else(String::new, |origin| format!("{}:{}: ", origin.file, origin.line));
    Finding::new(UNDRAWN, Subject::Map, format!("{place}{what} is not drawn: {why}")).graded(Severity::Warning)
}
