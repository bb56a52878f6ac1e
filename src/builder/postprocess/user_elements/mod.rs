//! Elements inside intersections that the user describes in `lanewright.toml` and OpenStreetMap does not know: guide lines,
//! stop lines, virtual traffic lights, signal phases.
//!
//! They are added to the finished map. It is read as `check` reads it, so that names of approaches mean the same. An element
//! that cannot be drawn completely is left out and reported, because Autoware loads no map with an incomplete element.

mod guide_lines;
mod right_of_way_edit;
mod signal_phases;
mod stop_line;
mod traced_guide_lines;
mod virtual_light;

use crate::builder::options::{Inside, metres};
use crate::diagnostic::{Finding, Severity, Subject};
use crate::lanelet::index::{MapIndex, Traffic};
use crate::lanelet::{LaneletMap, LineStringId};
use crate::projection::Projector;
use crate::settings::{GuideLine, InsideSettings, IntersectionSettings, Settings};

use super::map_editor::MapEditor;
use guide_lines::Guide;
use signal_phases::SignalPhases;
use stop_line::{StopLine, StopLines};
use traced_guide_lines::TracedBounds;
use virtual_light::{VirtualLight, VirtualLights};

/// Slug of the finding about an element that is not drawn.
pub const UNDRAWN: &str = "inside-undrawn";

/// Adds to a map what the user describes, and the phases to the settings of the map. Returns findings about what is left out.
pub fn draw(map: &mut LaneletMap, projector: &Projector, inside: &Inside, map_settings: &mut Settings) -> Vec<Finding> {
    let entries: Vec<IntersectionSettings> =
        inside.intersections.iter().filter(|entry| entry.is_to_draw()).cloned().collect();
    if entries.is_empty() && inside.everywhere.says_nothing() {
        return Vec::new();
    }
    map.place_on_globe(projector);
    let mut settings = map_settings.clone();
    settings.intersection.extend(entries);
    let (traced, mut notes) = trace_guide_lines(map, projector, &settings);
    let elements = {
        let index = MapIndex::new(map, &[], &settings);
        let mut elements = Elements { notes: unplaced(&index, projector), ..Elements::default() };
        for (i, intersection) in index.intersections.iter().enumerate() {
            let mut stop_lines = elements.add_intersection(&index, projector, i);
            if intersection.area.is_some() {
                elements.add_everywhere(&index, &index.traffic[i], inside.everywhere, &traced, &mut stop_lines);
                elements.stop_lines.append(&mut stop_lines.lines);
            }
        }
        elements
    };
    let mut editor = MapEditor::new(map, projector);
    elements.guides.into_iter().for_each(|guide| guide_lines::draw(&mut editor, guide));
    elements.stop_lines.into_iter().for_each(|line| stop_line::draw(&mut editor, line));
    elements.phases.into_iter().for_each(|phases| signal_phases::write(&mut editor, map_settings, phases));
    let mut end_lines = virtual_light::EndLines::new();
    elements.lights.into_iter().for_each(|light| virtual_light::draw(&mut editor, &mut end_lines, light));
    notes.extend(elements.notes);
    notes
}

/// A guide line of the settings: the index of its entry and its index in `guide_lines`.
type GuideLineIndex = (usize, usize);

/// Moves bounds onto the guide lines of the settings. Returns those bounds, and findings about lines that are left out.
fn trace_guide_lines(
    map: &mut LaneletMap,
    projector: &Projector,
    settings: &Settings,
) -> (Vec<LineStringId>, Vec<Finding>) {
    let (mut bounds, mut notes, mut unused) = (Vec::new(), Vec::new(), Vec::new());
    let mut lines = settings.intersection.iter().flat_map(|entry| &entry.guide_lines);
    if !lines.any(|line| matches!(line, GuideLine::Places(_))) {
        return (bounds, notes);
    }
    let found = find_traced_bounds(map, projector, settings, &mut notes);
    let mut editor = MapEditor::new(map, projector);
    let drawn: Vec<_> = found.iter().map(|(_, traced)| traced.draw(&mut editor)).collect();
    let checked: Vec<_> = {
        let index = MapIndex::new(map, &[], settings);
        found.iter().map(|(_, traced)| traced.check(&index)).collect()
    };
    for (((line, traced), change), result) in found.iter().zip(drawn).zip(checked) {
        match result {
            Ok(()) => {
                bounds.extend(traced.bounds());
                unused.extend(change.replaced_points());
            }
            Err(why) => {
                notes.push(undrawn_guide_line(settings, *line, &why));
                change.undo(map);
            }
        }
    }
    traced_guide_lines::remove_unused(map, unused.into_iter());
    (bounds, notes)
}

/// The bounds that belong to the guide lines of the settings.
fn find_traced_bounds(
    map: &LaneletMap,
    projector: &Projector,
    settings: &Settings,
    notes: &mut Vec<Finding>,
) -> Vec<(GuideLineIndex, TracedBounds)> {
    let index = MapIndex::new(map, &[], settings);
    let entries =
        index.traffic.iter().enumerate().flat_map(|(intersection, traffic)| {
            index.entries_of(intersection).iter().map(move |&entry| (traffic, entry))
        });
    let mut found: Vec<(GuideLineIndex, TracedBounds)> = Vec::new();
    for (traffic, entry) in entries {
        for (i, line) in settings.intersection[entry].guide_lines.iter().enumerate() {
            let GuideLine::Places(places) = line else { continue };
            let points = places.iter().map(|&place| metres(projector, place)).collect();
            let traced = TracedBounds::new(&index, traffic, points);
            match traced {
                Ok(traced) if found.iter().any(|(_, other)| traced.shares_with(other)) => {
                    notes.push(undrawn_guide_line(settings, (entry, i), "another guide line leads the same bound"));
                }
                Ok(traced) => found.push(((entry, i), traced)),
                Err(why) => notes.push(undrawn_guide_line(settings, (entry, i), &why)),
            }
        }
    }
    found
}

/// The elements to draw.
#[derive(Default)]
struct Elements {
    guides: Vec<Guide>,
    stop_lines: Vec<StopLine>,
    lights: Vec<VirtualLight>,
    phases: Vec<SignalPhases>,
    notes: Vec<Finding>,
}

impl Elements {
    /// Adds what the entries of the settings describe at an intersection. Returns the stop lines.
    fn add_intersection(&mut self, map: &MapIndex, projector: &Projector, intersection: usize) -> StopLines {
        let traffic = &map.traffic[intersection];
        let entries = map.entries_of(intersection).iter().map(|&entry| &map.settings.intersection[entry]);
        let entries: Vec<&IntersectionSettings> = entries.filter(|entry| entry.is_to_draw()).collect();
        let (mut stop_lines, mut lights) = (StopLines::default(), VirtualLights::default());
        for entry in &entries {
            for (i, ends) in entry.stop_lines.iter().enumerate() {
                let added = stop_lines.add(map, traffic, ends.map(|place| metres(projector, place)));
                self.notes.extend(added.err().map(|why| undrawn(entry, &format!("stop_lines[{i}]"), &why)));
            }
        }
        for entry in &entries {
            for (i, light) in entry.virtual_lights.iter().enumerate() {
                let added = lights.add(map, intersection, light);
                self.notes.extend(added.err().map(|why| undrawn(entry, &format!("virtual_lights[{i}]"), &why)));
            }
        }
        self.lights.append(&mut lights.lights);
        for entry in &entries {
            if entry.arrows == Some(true) && !traffic.signalised {
                let message = "arrows is not heeded: there are no traffic lights here".to_owned();
                self.notes.push(finding(entry, message));
            }
            let faults = signal_phases::faults(map, intersection, entry).into_iter();
            self.notes.extend(faults.map(|(i, why)| finding(entry, format!("phases[{i}] is not heeded: {why}"))));
        }
        self.phases.extend(signal_phases::phases(map, intersection, &entries));
        stop_lines
    }

    /// Adds the lines that the user wants at every intersection. `traced` bounds have a guide line already.
    fn add_everywhere(
        &mut self,
        map: &MapIndex,
        traffic: &Traffic,
        everywhere: InsideSettings,
        traced: &[LineStringId],
        stop_lines: &mut StopLines,
    ) {
        if everywhere.stop_lines == Some(true) {
            stop_lines.add_waiting(map, traffic);
        }
        if everywhere.guide_lines == Some(true) {
            let guides = guide_lines::between_lanes(map, traffic).into_iter();
            self.guides.extend(guides.filter(|guide| !traced.contains(&guide.bound)));
        }
    }
}

/// Findings about entries that describe no intersection.
fn unplaced(map: &MapIndex, projector: &Projector) -> Vec<Finding> {
    let mut found = vec![false; map.settings.intersection.len()];
    (0..map.intersections.len()).flat_map(|i| map.entries_of(i)).for_each(|&entry| found[entry] = true);
    let entries = map.settings.intersection.iter().zip(found);
    let unplaced = entries.filter(|(entry, found)| entry.is_to_draw() && !found);
    unplaced.map(|(entry, _)| undrawn(entry, "[[intersection]]", &why_unplaced(map, projector, entry))).collect()
}

fn why_unplaced(map: &MapIndex, projector: &Projector, entry: &IntersectionSettings) -> String {
    let [lat, lon] = match (entry.ia, entry.at) {
        (None, Some(place)) => place,
        (Some(ia), _) => {
            return format!("the map has no intersection_area {ia}; say where it is with `at = [latitude, longitude]`");
        }
        (None, None) => return "it names no intersection".to_owned(),
    };
    let position = metres(projector, [lat, lon]);
    let areas = map.intersections.iter().filter_map(|one| Some((one.area?, (one.middle - position).norm())));
    match areas.min_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((area, distance)) if distance < 1e6 => format!(
            "{lat}, {lon} lies in no intersection_area; the nearest is that of {area}, {distance:.0} m away: `ia = {area}`"
        ),
        _ => format!("{lat}, {lon} lies in no intersection_area"),
    }
}

fn undrawn_guide_line(settings: &Settings, (entry, i): GuideLineIndex, why: &str) -> Finding {
    undrawn(&settings.intersection[entry], &format!("guide_lines[{i}]"), why)
}

fn undrawn(entry: &IntersectionSettings, what: &str, why: &str) -> Finding {
    finding(entry, format!("{what} is not drawn: {why}"))
}

/// A finding about an entry of the settings, with its place in the file.
fn finding(entry: &IntersectionSettings, message: String) -> Finding {
    let place = entry.origin.as_ref().map_or_else(String::new, |origin| format!("{}:{}: ", origin.file, origin.line));
    Finding::new(UNDRAWN, Subject::Map, format!("{place}{message}")).graded(Severity::Warning)
}
