//! The places of a border, so dense that the straight pieces between them lie within a chord error of the curve itself.

use crate::xodr::{Place, Road, Section};

use super::scene::Scene;
use super::stretches::section_at;

/// The largest distance of the curve from its chord, metres: the requirement is 1 cm, of which the joints need a part.
pub const CHORD: f64 = 0.004;
/// The same inside junctions, where borders of several heights lie almost on each other.
const CHORD_INSIDE: f64 = 0.0005;
/// The longest chord, metres.
pub const LONGEST: f64 = 40.0;
/// A border has no more places than this: a curve that needs more is damaged.
const MOST: usize = 200_000;
/// A piece of this length, metres, is divided no more.
pub const SHORTEST: f64 = 0.02;

/// The places of the outer border of a lane, 0 for the centre lane, along a stretch, its ends included.
pub fn border(scene: &Scene, stretch: usize, border: i64) -> Vec<Place> {
    let (road, sections) = (scene.road(stretch), scene.sections(stretch));
    let [from, to] = scene.stretches[stretch].span;
    let last = sections.len().saturating_sub(1);
    let at = |station: f64| {
        // Of two sections that meet, the one before counts at the end of the border, the one behind elsewhere.
        let ends = station >= to && sections.get(last).is_some_and(|section| section.span[0] >= to);
        let section = section_at(if ends { &sections[..last.max(1)] } else { &sections }, station);
        section.map_or([0.0; 3], |section| scene.border_place(stretch, section, border, station))
    };
    let mut stations = knots(road, &sections, [from, to]);
    stations.push(to);
    let chord = if scene.connecting[scene.stretches[stretch].road] { CHORD_INSIDE } else { CHORD };
    let mut line = vec![(from, at(from))];
    let mut begin = from;
    for end in stations {
        divide(&at, [begin, end], chord, &mut line);
        line.push((end, at(end)));
        begin = end;
    }
    unfolded(road, line)
}

/// The places of a border without those where it runs back against its road: inside a turn that is tighter than the lane is wide.
fn unfolded(road: &Road, line: Vec<(f64, Place)>) -> Vec<Place> {
    let last = line.len().saturating_sub(1);
    let mut kept: Vec<(f64, Place)> = Vec::with_capacity(line.len());
    for (i, (station, place)) in line.into_iter().enumerate() {
        let goes_on = |before: &(f64, Place), heading: f64| {
            let [dx, dy] = [place[0] - before.1[0], place[1] - before.1[1]];
            let angle = road.angle(heading);
            dx * angle.cos() + dy * angle.sin() > 0.0
        };
        while kept.len() > 1 && kept.last().is_some_and(|before| !goes_on(before, before.0)) {
            kept.pop();
        }
        while i == last && kept.len() > 1 && kept.last().is_some_and(|before| !goes_on(before, station)) {
            kept.pop();
        }
        if i == 0 || i == last || kept.last().is_some_and(|before| goes_on(before, station)) {
            kept.push((station, place));
        }
    }
    kept.into_iter().map(|(_, place)| place).collect()
}

/// Stations strictly between two others at which the curve may bend.
fn knots(road: &Road, sections: &[&Section], [from, to]: [f64; 2]) -> Vec<f64> {
    let mut all: Vec<f64> = road.plan.records().iter().map(|record| record.start).collect();
    all.extend(road.elevation.starts().chain(road.superelevation.starts()).chain(road.lane_offset.starts()));
    all.extend(road.shapes.stations());
    for section in sections {
        all.push(section.span[0]);
        let starts = section
            .lanes
            .iter()
            .flat_map(|lane| lane.widths.starts().chain(lane.borders.starts()).chain(lane.heights.starts()));
        all.extend(starts.map(|start| section.span[0] + start));
    }
    all.retain(|station| *station > from + SHORTEST && *station < to - SHORTEST);
    all.sort_by(f64::total_cmp);
    all.dedup_by(|b, a| *b - *a < SHORTEST);
    all
}

/// Adds the places strictly between two stations that the curve needs.
fn divide(at: &impl Fn(f64) -> Place, span: [f64; 2], chord: f64, line: &mut Vec<(f64, Place)>) {
    let mut open = vec![span];
    while let Some([from, to]) = open.pop() {
        let [a, b] = [from, to].map(at);
        let length = to - from;
        let bends = || [0.25, 0.5, 0.75].into_iter().any(|part| off(at(from + length * part), a, b) > chord);
        let divides = length > SHORTEST && line.len() + open.len() < MOST;
        if divides && (length > LONGEST || bends()) {
            let middle = from + length / 2.0;
            open.push([middle, to]);
            open.push([from, middle]);
        } else if to < span[1] {
            line.push((to, b));
        }
    }
}

/// How far a place lies from a chord, metres: across in the plane, or in height.
fn off(p: Place, a: Place, b: Place) -> f64 {
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    let square = (dx * dx + dy * dy).max(f64::MIN_POSITIVE);
    let along = (((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / square).clamp(0.0, 1.0);
    let across = (p[0] - a[0] - dx * along).hypot(p[1] - a[1] - dy * along);
    across.max((p[2] - a[2] - (b[2] - a[2]) * along).abs())
}
