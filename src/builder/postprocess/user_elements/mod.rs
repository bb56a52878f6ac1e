//! What the user says of intersections: guide lines, stop lines in the middle, virtual traffic lights, phases.
//!
//! OpenStreetMap knows none of these; `lanewright.toml` names them. They are added to the map that stands, which is read
//! as `check` reads it, so that the names of approaches and the turns mean the same here and there. Whatever cannot be
//! drawn as a whole is left out and named: Autoware loads no map with half an element.

mod guide_lines;
mod right_of_way;
mod signal_phases;
mod stop_line;
mod traced_guide_lines;
mod virtual_light;

use crate::builder::options::{Inside, metres};
use crate::diagnostic::{Finding, Severity, Subject};
use crate::lanelet::index::{MapIndex, Thresholds};
use crate::lanelet::{LaneletMap, LineStringId};
use crate::projection::Projector;
use crate::settings::{GuideLine, InsideSettings, IntersectionSettings, Settings};

use super::map_editor::MapEditor;
use guide_lines::Guide;
use signal_phases::SignalPhases;
use stop_line::{StopLine, StopLines};
use traced_guide_lines::TracedBounds;
use virtual_light::{VirtualLight, VirtualLights};

/// Slug of the finding about something that is not drawn.
pub const UNDRAWN: &str = "inside-undrawn";

/// What is to be drawn.
#[derive(Default)]
struct Sketch {
    guides: Vec<Guide>,
    stop_lines: Vec<StopLine>,
    lights: Vec<VirtualLight>,
    phases: Vec<SignalPhases>,
    notes: Vec<Finding>,
}

/// Draws into a map of which the settings `beside` say what it cannot, adds to these what the user says, and names what is
/// left out.
pub fn draw(map: &mut LaneletMap, projector: &Projector, inside: &Inside, beside: &mut Settings) -> Vec<Finding> {
    let wanted = inside.intersections.iter().filter(|entry| entry.is_to_draw());
    let wanted: Vec<IntersectionSettings> = wanted.cloned().collect();
    if wanted.is_empty() && inside.everywhere.says_nothing() {
        return Vec::new();
    }
    map.place_on_globe(projector);
    let mut settings = beside.clone();
    settings.intersection.extend(wanted);
    let (led, mut notes) = lead(map, projector, &settings);
    let sketch = {
        let index = MapIndex::new(map, &[], &settings, Thresholds::default());
        sketch(&index, projector, inside.everywhere, &led)
    };
    let mut pen = MapEditor::new(map, projector);
    sketch.guides.into_iter().for_each(|guide| guide_lines::draw(&mut pen, guide));
    sketch.stop_lines.into_iter().for_each(|line| stop_line::draw(&mut pen, line));
    sketch.phases.into_iter().for_each(|phased| signal_phases::write(&mut pen, beside, phased));
    let mut ends = virtual_light::EndLines::new();
    sketch.lights.into_iter().for_each(|light| virtual_light::draw(&mut pen, &mut ends, light));
    notes.extend(sketch.notes);
    notes
}

/// Leads bounds along the guide lines that the settings have; gives those bounds, and names the lines that are left out.
fn lead(map: &mut LaneletMap, projector: &Projector, settings: &Settings) -> (Vec<LineStringId>, Vec<Finding>) {
    let (mut found, mut notes) = (Vec::new(), Vec::new());
    let not_drawn = |(entry, i): (usize, usize), why: &str| {
        undrawn(&settings.intersection[entry], &format!("guide_lines[{i}]"), why)
    };
    let lines = settings.intersection.iter().flat_map(|entry| &entry.guide_lines);
    if !lines.into_iter().any(|line| matches!(line, GuideLine::Places(_))) {
        return (Vec::new(), notes);
    }
    {
        let index = MapIndex::new(map, &[], settings, Thresholds::default());
        for (at, traffic) in index.traffic.iter().enumerate() {
            for &entry in index.entries_of(at) {
                for (i, line) in settings.intersection[entry].guide_lines.iter().enumerate() {
                    let GuideLine::Places(places) = line else { continue };
                    let places = places.iter().map(|&place| metres(projector, place)).collect();
                    match TracedBounds::new(&index, traffic, places) {
                        Ok(led) if found.iter().any(|(_, other): &(_, TracedBounds)| led.shares_with(other)) => {
                            notes.push(not_drawn((entry, i), "another guide line leads the same bound"));
                        }
                        Ok(led) => found.push(((entry, i), led)),
                        Err(why) => notes.push(not_drawn((entry, i), &why)),
                    }
                }
            }
        }
    }
    let mut pen = MapEditor::new(map, projector);
    let drawn: Vec<_> = found.into_iter().map(|(at, led)| (at, led.draw(&mut pen), led)).collect();
    let vetted: Vec<_> = {
        let index = MapIndex::new(map, &[], settings, Thresholds::default());
        drawn.into_iter().map(|(at, traced, led)| (at, traced, led.vet(&index), led)).collect()
    };
    let (mut bounds, mut left) = (Vec::new(), Vec::new());
    for (at, traced, vetted, led) in vetted {
        match vetted {
            Ok(()) => {
                bounds.extend(led.bounds());
                left.extend(traced.left());
            }
            Err(why) => {
                notes.push(not_drawn(at, &why));
                traced.undo(map);
            }
        }
    }
    traced_guide_lines::sweep(map, left.into_iter());
    (bounds, notes)
}

fn sketch(map: &MapIndex, projector: &Projector, everywhere: InsideSettings, led: &[LineStringId]) -> Sketch {
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
        for entry in &entries {
            if entry.arrows == Some(true) && !traffic.signalised {
                sketch.notes.push(unheeded(entry, "arrows is not heeded: there are no traffic lights here".to_owned()));
            }
            let faults = signal_phases::faults(map, at, entry).into_iter();
            sketch.notes.extend(faults.map(|(i, why)| unheeded(entry, format!("phases[{i}] is not heeded: {why}"))));
        }
        sketch.phases.extend(signal_phases::phased(map, at, &entries));
        sketch.lights.append(&mut lights.lights);
        if map.intersections[at].area.is_none() {
            continue;
        }
        if everywhere.stop_lines == Some(true) {
            stop_lines.add_waiting(map, traffic);
        }
        if everywhere.guide_lines == Some(true) {
            sketch.guides.extend(
                guide_lines::between_lanes(map, traffic).into_iter().filter(|guide| !led.contains(&guide.bound)),
            );
        }
        sketch.stop_lines.append(&mut stop_lines.lines);
    }
    sketch
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
    unheeded(entry, format!("{what} is not drawn: {why}"))
}

fn unheeded(entry: &IntersectionSettings, message: String) -> Finding {
    let place = entry.origin.as_ref().map_or_else(String::new, |origin| format!("{}:{}: ", origin.file, origin.line));
    Finding::new(UNDRAWN, Subject::Map, format!("{place}{message}")).graded(Severity::Warning)
}
