//! Roads cut into stretches: along each, the same lanes run from its begin to its end, and nothing of them changes.

use std::collections::BTreeSet;
use std::ops::Range;

use crate::xodr::{Lane, OpenDrive, Road, RoadMark, Section, Shape};

use super::lane_use::{LaneUse, sides};
use super::signal_use::{AT_CUT, lights_between, stop_stations};

/// Sections and roads shorter than this, metres, are dissolved: exporters leave some of a micrometre.
const MICRO: f64 = 0.1;
/// Roads shorter than this, metres, that join two others are dissolved: Lanelet2 takes ends so near to each other for a map that is broken.
const SHORT_ROAD: f64 = 0.5;
/// Paint and speed limits that change closer than this, metres, to another change are those of the stretch before.
const SHORTEST: f64 = 2.0;

/// Borders closer than this everywhere, metres, are one.
pub const ONE_BORDER: f64 = 0.02;
/// By how much a width, metres, may be more than it should be.
const WIDTH_NOISE: f64 = 0.005;
/// So often a stretch is halved to find the station at which a lane has a width.
const BISECTIONS: usize = 40;
/// A lane whose width jumps by more than this, metres, or that has no more, is another one behind the jump.
const SAME_WIDTH: f64 = 0.05;

/// A lanelet turns no farther than this, radians, and is looked at in steps of so many.
const MOST_TURN: f64 = 3.5;
const TURN_STEP: f64 = 0.2;
/// A lane that is nowhere wider than this, metres, is none: exporters leave some beside others. Where a lane opens between two others,
/// its lanelet begins where it is as wide: from there on their borders are apart.
const OPEN: f64 = 0.5;
/// Borders of lanes of opposite directions that are closer than this, metres, are taken for one (vm-01-04).
const STRIP: f64 = 0.32;
/// Paint may change, and a lanelet begin, so far, metres, from where the file has it.
const FARTHEST_CUT: f64 = 4.0;

/// A part of a road along which nothing changes.
#[derive(Clone, Debug)]
pub struct Stretch {
    /// Index of the road.
    pub road: usize,
    /// The stations between which it lies, metres.
    pub span: [f64; 2],
    /// Its sections, by index in `kept`; all have the same lanes.
    pub sections: Range<usize>,
    /// The first of its sections, as the file counts them.
    pub first_section: usize,
    /// Which of the stretches that begin in that section it is.
    pub part: usize,
    /// The lanes for motor vehicles that become lanelets.
    pub driven: BTreeSet<i64>,
}

/// A road cut up.
#[derive(Clone, Debug, Default)]
pub struct CutRoad {
    /// The sections that are long enough, by their index in the road.
    pub kept: Vec<usize>,
    /// For each pair of kept sections that follow each other, the lanes that lead on.
    pub links: Vec<Vec<[i64; 2]>>,
    /// In order along the road.
    pub stretches: Vec<Stretch>,
    /// Whether it is so short that its lanes are no lanelets: those before and behind it meet.
    pub dissolved: bool,
}

/// Cuts a road.
pub fn cut(file: &OpenDrive, index: usize, connecting: bool) -> CutRoad {
    let Some(road) = file.roads.get(index) else { return CutRoad::default() };
    let kept = kept(road);
    let links: Vec<Vec<[i64; 2]>> = kept.windows(2).map(|pair| linked(road, pair[0], pair[1])).collect();
    let mut cut = CutRoad { kept, links, ..CutRoad::default() };
    let Some(&first) = cut.kept.first() else { return cut };
    let start_of = |at: usize| road.sections[cut.kept[at]].span[0];
    // Where lanes change, a stretch must end; elsewhere, it ends where paint or speed changes, if that is far enough from other ends.
    let hard: Vec<usize> = (1..cut.kept.len()).filter(|&at| !goes_on(road, &cut, at)).collect();
    let mut stations: Vec<f64> = std::iter::once(0.0).chain(hard.iter().map(|&at| start_of(at))).collect();
    stations.push(road.length);
    if !connecting {
        for line in stop_stations(road) {
            if stations.iter().all(|station| (station - line).abs() > AT_CUT) {
                stations.push(line);
            }
        }
        stations.retain(|station| (0.0..=road.length).contains(station));
        stations.sort_by(f64::total_cmp);
    }
    let opening: Vec<f64> = stations
        .windows(2)
        .flat_map(|pair| openings(road, &sections_between(road, &cut.kept, [pair[0], pair[1]]), [pair[0], pair[1]]))
        .collect();
    stations.extend(opening.into_iter().map(|station| clear_of_strip(road, &cut.kept, station)));
    if !connecting {
        stations.extend(half_turns(road));
    }
    stations.sort_by(f64::total_cmp);
    stations.dedup();
    if !connecting {
        for change in changes(road, &cut.kept) {
            let change = clear_of_strip(road, &cut.kept, change);
            if stations.iter().all(|station| (station - change).abs() >= SHORTEST) {
                stations.push(change);
            }
        }
        stations.sort_by(f64::total_cmp);
    }
    let mut counted = (first, 0);
    for pair in stations.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        if to <= from {
            continue;
        }
        let sections = range_between(road, &cut.kept, [from, to]);
        let begin = sections.start;
        let first_section = cut.kept[begin];
        counted = if counted.0 == first_section { (first_section, counted.1 + 1) } else { (first_section, 1) };
        let part = counted.1 - 1;
        let driven = driven(road, &sections_between(road, &cut.kept, [from, to]), [from, to], connecting);
        cut.stretches.push(Stretch { road: index, span: [from, to], sections, first_section, part, driven });
    }
    let joins = road.links.iter().all(Option::is_some);
    cut.dissolved = cut.stretches.len() == 1 && road.length < if joins { SHORT_ROAD } else { MICRO };
    cut
}

/// The kept sections between two stations, by their index among them.
fn range_between(road: &Road, kept: &[usize], [from, to]: [f64; 2]) -> Range<usize> {
    let starts_before = |at: &usize, station: f64| road.sections[*at].span[0] < station;
    let begin =
        kept.partition_point(|at| starts_before(at, from) || road.sections[*at].span[0] == from).saturating_sub(1);
    begin..kept.partition_point(|at| starts_before(at, to)).max(begin + 1).min(kept.len())
}

fn sections_between<'a>(road: &'a Road, kept: &[usize], span: [f64; 2]) -> Vec<&'a Section> {
    kept[range_between(road, kept, span)].iter().map(|&at| &road.sections[at]).collect()
}

/// The width of a lane at stations along these sections, with the stations, both in metres.
fn widths(road: &Road, sections: &[&Section], [from, to]: [f64; 2], lane: i64) -> Vec<(f64, f64)> {
    const PLACES: usize = 32;
    let at = |i: usize| {
        let station = from + (to - from) * i as f64 / PLACES as f64;
        (station, width_at(road, sections, station, lane))
    };
    (0..=PLACES).map(at).collect()
}

/// The section in which a station lies: of two that meet there the one behind.
pub fn section_at<'a>(sections: &[&'a Section], station: f64) -> Option<&'a Section> {
    let behind = sections.partition_point(|section| section.span[0] <= station);
    sections.get(behind.saturating_sub(1)).copied()
}

fn width_at(road: &Road, sections: &[&Section], station: f64, lane: i64) -> f64 {
    section_at(sections, station).map_or(0.0, |section| section.width(road, lane, station))
}

/// The lanes for motor vehicles along these sections; on a connecting road a piece may be narrow of a lane that becomes wide.
fn driven(road: &Road, sections: &[&Section], span: [f64; 2], connecting: bool) -> BTreeSet<i64> {
    let least = if connecting { ONE_BORDER } else { OPEN + WIDTH_NOISE };
    let lanes = sections.first().into_iter().flat_map(|section| vehicle_lanes(section));
    let wide = |lane: &&Lane| widths(road, sections, span, lane.id).iter().any(|(_, width)| *width > least);
    lanes.filter(wide).map(|lane| lane.id).collect()
}

/// The stations at which a lane becomes wide that begins or ends without width between two others.
fn openings(road: &Road, sections: &[&Section], [from, to]: [f64; 2]) -> Vec<f64> {
    let driven = driven(road, sections, [from, to], false);
    let mut found = Vec::new();
    for &lane in &driven {
        let beside = |step: i64| {
            let next = lane + step;
            driven.contains(&if next == 0 { step } else { next })
        };
        if !beside(1) || !beside(-1) {
            continue;
        }
        let widths = widths(road, sections, [from, to], lane);
        let ahead: Vec<(f64, f64)> = widths.iter().rev().copied().collect();
        for line in [widths, ahead] {
            let behind = line.iter().position(|(_, width)| *width > OPEN).unwrap_or(0);
            if line[0].1 > SAME_WIDTH || behind == 0 {
                continue;
            }
            let [mut narrow, mut wide] = [line[behind - 1].0, line[behind].0];
            for _ in 0..BISECTIONS {
                let middle = f64::midpoint(narrow, wide);
                let open = width_at(road, sections, middle, lane) > OPEN;
                if open { wide = middle } else { narrow = middle }
            }
            found.push(wide);
        }
    }
    found.retain(|station| *station > from + MICRO && *station < to - MICRO);
    found
}

/// The station at which a road is cut for one where a strip between its directions is about to close: the nearest at which the strip
/// is so wide that both of its borders can end there.
fn clear_of_strip(road: &Road, kept: &[usize], station: f64) -> f64 {
    let Some(&at) = kept.iter().rev().find(|at| road.sections[**at].span[0] < station) else { return station };
    let section = &road.sections[at];
    let driven = |side: i64| vehicle_lanes(section).map(|lane| lane.id * side).filter(|id| *id > 0).min();
    let (Some(left), Some(right)) = (driven(1), driven(-1)) else { return station };
    let strip = |station: f64| -> f64 {
        (1 - right..left).filter(|lane| *lane != 0).map(|lane| section.width(road, lane, station)).sum()
    };
    let width = strip(station.min(section.span[1]));
    if width <= ONE_BORDER || width >= STRIP {
        return station;
    }
    let steps =
        (1..=(FARTHEST_CUT / MICRO) as usize).flat_map(|step| [1.0, -1.0].map(|side| side * step as f64 * MICRO));
    let around =
        steps.map(|step| station + step).filter(|at| *at > section.span[0] + MICRO && *at < section.span[1] - MICRO);
    around.into_iter().find(|at| strip(*at) >= STRIP).unwrap_or(station)
}

/// The stations at which a road has turned as far as a lanelet may: on a helix or a ring its outline would cross itself.
fn half_turns(road: &Road) -> Vec<f64> {
    let mut found = Vec::new();
    let mut turned = 0.0;
    let mut last: Option<f64> = None;
    for record in road.plan.records() {
        let steps = match record.shape {
            Shape::Line => 1.0,
            Shape::Arc(curvature) => (curvature.abs() * record.length / TURN_STEP).ceil(),
            Shape::Spiral([from, to]) => (from.abs().max(to.abs()) * record.length / TURN_STEP).ceil(),
            Shape::Poly3(_) | Shape::ParamPoly3 { .. } => 16.0,
        };
        let steps = steps.clamp(1.0, 10_000.0);
        for step in 0..=steps as usize {
            let station = record.start + record.length * step as f64 / steps;
            let angle = record.at(station - record.start).angle;
            if let Some(last) = last {
                turned += (angle - last).sin().atan2((angle - last).cos());
            }
            last = Some(angle);
            if turned.abs() > MOST_TURN && station > MICRO && station < road.length - MICRO {
                found.push(station);
                turned = 0.0;
            }
        }
    }
    found
}

/// The sections that are no micro sections; of a road of which all are, the longest.
fn kept(road: &Road) -> Vec<usize> {
    let kept: Vec<usize> = (0..road.sections.len()).filter(|&i| road.sections[i].length() >= MICRO).collect();
    if !kept.is_empty() || road.length <= 0.0 {
        return kept;
    }
    let longest =
        (0..road.sections.len()).max_by(|&a, &b| road.sections[a].length().total_cmp(&road.sections[b].length()));
    longest.into_iter().collect()
}

/// The lanes of a section that lead on to those of a later one, over the micro sections between.
fn linked(road: &Road, from: usize, to: usize) -> Vec<[i64; 2]> {
    let mut pairs: Vec<[i64; 2]> = road.sections[from].lanes.iter().map(|lane| [lane.id; 2]).collect();
    for at in from..to {
        let step = steps(&road.sections[at], &road.sections[at + 1]);
        pairs =
            pairs.iter().flat_map(|[a, b]| step.iter().filter(move |s| s[0] == *b).map(move |s| [*a, s[1]])).collect();
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// The lanes of a section that lead on to those of the next one, by the links of either.
fn steps(before: &Section, after: &Section) -> Vec<[i64; 2]> {
    let ahead = before.lanes.iter().flat_map(|lane| lane.links[1].iter().map(|next| [lane.id, *next]));
    let back = after.lanes.iter().flat_map(|lane| lane.links[0].iter().map(|last| [*last, lane.id]));
    let exist = |[a, b]: &[i64; 2]| before.lane(*a).is_some() && after.lane(*b).is_some();
    let mut all: Vec<[i64; 2]> = ahead.chain(back).filter(exist).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The lanes for motor vehicles of a section.
fn vehicle_lanes(section: &Section) -> impl Iterator<Item = &Lane> {
    section.lanes.iter().filter(|lane| LaneUse::of(lane).is_driven())
}

/// Whether all lanes for motor vehicles lead from the kept section before to this one and are of one kind in both. What lies beside them
/// changes often in surveys.
fn goes_on(road: &Road, cut: &CutRoad, at: usize) -> bool {
    let [before, after] = [at - 1, at].map(|at| &road.sections[cut.kept[at]]);
    let same = |(a, b): (&Lane, &Lane)| {
        a.id == b.id
            && a.kind == b.kind
            && (a.reversed, a.both_ways) == (b.reversed, b.both_ways)
            && a.access == b.access
    };
    let links: Vec<[i64; 2]> = vehicle_lanes(before)
        .flat_map(|lane| cut.links[at - 1].iter().copied().filter(|[from, _]| *from == lane.id))
        .filter(|[_, to]| vehicle_lanes(after).any(|lane| lane.id == *to))
        .collect();
    vehicle_lanes(before).count() == vehicle_lanes(after).count()
        && vehicle_lanes(before).zip(vehicle_lanes(after)).all(same)
        && links.iter().all(|[a, b]| a == b)
        && vehicle_lanes(before).all(|lane| {
            let widths = [before, after].map(|section| section.width(road, lane.id, after.span[0]));
            let wider = |section: &Section| {
                section.width(road, lane.id, f64::midpoint(section.span[0], section.span[1])) > widths[1]
            };
            let pinched = widths[1] <= SAME_WIDTH && wider(before) && wider(after);
            links.contains(&[lane.id; 2]) && (widths[0] - widths[1]).abs() < SAME_WIDTH && !pinched
        })
}

/// The stations at which the paint or the speed limit of a lane for motor vehicles changes, or the strip beside them.
fn changes(road: &Road, kept: &[usize]) -> Vec<f64> {
    let mut found: Vec<f64> = road.speeds.iter().map(|(station, _)| *station).chain(lights_between(road)).collect();
    for (&i, next) in kept.iter().zip(kept.iter().skip(1).map(Some).chain([None])) {
        let section = &road.sections[i];
        let own = |marks: &[RoadMark]| {
            marks.windows(2).filter(|p| !alike(Some(&p[0]), Some(&p[1]))).map(|p| p[1].start).collect::<Vec<_>>()
        };
        let mut borders: Vec<i64> = vehicle_lanes(section).flat_map(|lane| sides(lane.id)).collect();
        borders.sort_unstable();
        borders.dedup();
        let painted = section.lanes.iter().filter(|lane| borders.contains(&lane.id)).flat_map(|lane| own(&lane.marks));
        let limited = vehicle_lanes(section).flat_map(|lane| lane.speeds.iter().map(|speed| speed.0));
        let inside = painted.chain(limited).chain(own(&section.centre_marks));
        found.extend(inside.filter(|start| *start > 0.0).map(|start| section.span[0] + start));
        let Some(&next) = next else { continue };
        let after = &road.sections[next];
        let station = after.span[0];
        let repainted =
            borders.iter().any(|border| !alike(section.mark(*border, section.span[1]), after.mark(*border, station)));
        let limits = |section: &Section, lane: &Lane, station| road.speed(section, lane, station);
        let limited = vehicle_lanes(section).any(|lane| {
            let other = after.lane(lane.id);
            other.is_some_and(|other| limits(section, lane, section.span[1] - 1e-6) != limits(after, other, station))
        });
        if repainted || limited || [1, -1].into_iter().any(|side| strip(section, side) != strip(after, side)) {
            found.push(station);
        }
    }
    found.sort_by(f64::total_cmp);
    found.dedup();
    found.retain(|station| *station > 0.0 && *station < road.length);
    found
}

/// What lies beside the driven lanes on a side, 1 for the left one, and the ids of the first and the last of its lanes.
pub fn strip(section: &Section, side: i64) -> Option<(LaneUse, [i64; 2])> {
    let last = vehicle_lanes(section).map(|lane| lane.id * side).filter(|id| *id > 0).max()?;
    let use_at = |id: i64| section.lane(id * side).map_or(LaneUse::None, LaneUse::of);
    let used = use_at(last + 1);
    let end = (last + 1..).take_while(|id| use_at(*id) == used && section.lane(*id * side).is_some()).last()?;
    (used != LaneUse::None).then_some((used, [(last + 1) * side, end * side]))
}

fn alike(a: Option<&RoadMark>, b: Option<&RoadMark>) -> bool {
    let word =
        |mark: Option<&RoadMark>| mark.map(|mark| (mark.kind.clone(), mark.color.clone(), mark.lane_change.clone()));
    word(a) == word(b)
}
