//! The lanelets of all lanes, between the file's own borders.

use std::collections::{BTreeMap, BTreeSet};

use crate::builder::map::map_builder::MapBuilder;
use crate::diagnostic::{Finding, Severity};
use crate::settings::{BesideSettings, BicycleLanes};
use crate::xodr::{self, Lane, Road, Section};

use super::contacts::{Contact, LaneEnd, contacts};
use super::lane_use::{LaneUse, sides};
use super::lines::{Lines, One, SideRun, StretchLanes};
use super::nodes::{EndNodes, Nodes};
use super::runs::runs;
use super::scene::{Drawn, Piece, Scene, note};
use super::shapes;
use super::stretches::{ONE_BORDER, section_at, strip};
use super::unlinked;
use super::wrong_ends;

/// A way through a junction that is narrower than this everywhere, metres, is none.
const NO_WIDTH: f64 = 0.3;
/// The speed limit where a file says none, km/h: the usual one in towns.
const UNSAID_SPEED: f64 = 50.0;
/// Speed limits of lanes for bicycles and of shoulders, km/h.
const CYCLING: f64 = 20.0;
const CRAWLING: f64 = 10.0;
/// A shoulder narrower than this, metres, is a part of the border: nobody can halt there.
const NARROW_SHOULDER: f64 = 1.0;
/// A shoulder or a lane for bicycles shorter than this, metres, is none: it lies beside a piece of road between two others.
const SHORT_STRIP: f64 = 2.0;
/// A lane for bicycles narrower than this, metres, is none.
const NARROW_BICYCLES: f64 = 0.8;

/// The borders of a stretch, from left to right, each with the border that stands for it.
fn borders(scene: &Scene, stretch: usize) -> Vec<(i64, i64)> {
    let (section, road) = (scene.section(stretch), scene.road(stretch));
    let ids: Vec<i64> = section.lanes.iter().map(|lane| lane.id).collect();
    let left = ids.iter().copied().filter(|id| *id > 0);
    let all: Vec<i64> = left.chain([0]).chain(ids.iter().copied().filter(|id| *id < 0)).collect();
    let mut representative: BTreeMap<i64, i64> = BTreeMap::from([(0, 0)]);
    let mut outward: Vec<i64> = all.iter().copied().filter(|border| *border != 0).collect();
    outward.sort_by_key(|border| border.abs());
    for border in outward {
        let inside = border - border.signum();
        let width = width(scene, stretch, road, border);
        let of_inside = representative.get(&inside).copied();
        let stands = of_inside.filter(|_| width < ONE_BORDER).unwrap_or(border);
        representative.insert(border, stands);
    }
    all.into_iter().map(|border| (border, representative.get(&border).copied().unwrap_or(border))).collect()
}

/// The largest width of a lane along a stretch, metres.
fn width(scene: &Scene, stretch: usize, road: &Road, lane: i64) -> f64 {
    const PLACES: usize = 8;
    let [from, to] = scene.stretches[stretch].span;
    let sections = scene.sections(stretch);
    let at = |i: usize| {
        let station = from + (to - from) * i as f64 / PLACES as f64;
        section_at(&sections, station).map_or(0.0, |section| section.width(road, lane, station))
    };
    (0..=PLACES).map(at).fold(0.0, f64::max)
}

/// Draws the lanelets of all lanes.
pub fn draw(assembly: &mut MapBuilder, scene: &Scene, beside: &BesideSettings) -> Drawn {
    let found = contacts(scene.file, scene.cut, scene.first);
    let mut drawn = Drawn::default();
    for dangling in found.dangling {
        drawn.notes.push(note("opendrive-link", dangling.line, dangling.message));
    }
    let stretches = 0..scene.stretches.len();
    let all_borders: Vec<Vec<(i64, i64)>> = stretches.clone().map(|stretch| borders(scene, stretch)).collect();
    let lanes: Vec<StretchLanes> = stretches
        .clone()
        .map(|stretch| {
            let (driven, stands) = (used(scene, stretch), all_borders[stretch].iter().copied().collect());
            let sides = side_runs(scene, stretch, &driven, beside);
            StretchLanes { driven, sides, stands }
        })
        .collect();
    let (mut all_contacts, mut told) = wrong_ends::righted(scene, &lanes, found.all);
    drawn.notes.append(&mut told);
    let (mut unlinked, mut told) = unlinked::meeting(scene, &lanes, &all_contacts);
    drawn.notes.append(&mut told);
    all_contacts.append(&mut unlinked);
    all_contacts.sort_unstable();
    let ends = meeting_ends(scene, &all_borders, &lanes, &all_contacts, &mut drawn.notes);
    let mut meeting: BTreeMap<LaneEnd, Vec<LaneEnd>> = BTreeMap::new();
    for [a, b] in all_contacts.iter().map(|contact| contact.ends) {
        meeting.entry(a).or_default().push(b);
        meeting.entry(b).or_default().push(a);
    }
    let mut lines = Lines::new(scene, &ends);
    for index in 0..scene.file.roads.len() {
        for pieces in runs(scene, &lanes, (&ends, &meeting), index) {
            way(&mut lines, assembly, &mut drawn, (&lanes, &meeting), pieces);
        }
        let first = scene.first[index];
        for stretch in first..first + scene.cut[index].stretches.len() {
            strips(&mut lines, assembly, &mut drawn, &lanes, stretch);
        }
    }
    unsaid_speeds(scene, &lanes, &mut drawn.notes);
    let mut told = shapes::notes(scene, &drawn);
    drawn.notes.append(&mut told);
    follow(&mut drawn, &all_contacts);
    drawn
}

/// Adds the lanelets of a way along a road, one for each direction.
fn way(
    lines: &mut Lines,
    assembly: &mut MapBuilder,
    drawn: &mut Drawn,
    (lanes, meeting): (&[StretchLanes], &BTreeMap<LaneEnd, Vec<LaneEnd>>),
    pieces: Vec<Piece>,
) {
    let scene = lines.scene;
    let Some((begin, end)) = pieces.first().zip(pieces.last()).map(|(begin, end)| (*begin, *end)) else { return };
    let middle = pieces[pieces.len() / 2];
    let road = scene.road(begin.stretch);
    if pieces.iter().all(|piece| width(scene, piece.stretch, road, piece.lane) < NO_WIDTH) {
        return;
    }
    let Some((lane, used)) = lanes[middle.stretch].driven.iter().find(|(lane, _)| lane.id == middle.lane) else {
        return;
    };
    let inside = scene.connecting[scene.stretches[begin.stretch].road];
    let ends =
        [(begin, false), (end, true)].map(|(piece, far)| LaneEnd { stretch: piece.stretch, far, lane: piece.lane });
    if inside && ends.into_iter().any(|end| is_cut_off(lines.ends, (lanes, meeting), end)) {
        let message = format!(
            "lane {} of road {} does not reach the lane that it is linked to: it is left out",
            begin.lane, road.id
        );
        drawn.notes.push(note("opendrive-gap", road.line, message).graded(Severity::Warning));
        return;
    }
    let limit = road.speed(scene.section(middle.stretch), lane, scene.middle(middle.stretch)).unwrap_or(UNSAID_SPEED);
    let borders: Vec<[i64; 2]> = pieces.iter().map(|piece| sides(piece.lane)).collect();
    let mut directions = Vec::new();
    for &direction in road.directions(lane) {
        let ends = [direction < 0, direction > 0].map(|far| {
            let Piece { stretch, lane } = if far { end } else { begin };
            LaneEnd { stretch, far, lane }
        });
        if lane.both_ways && inside && !leads_through(scene, meeting, ends) {
            let message = format!(
                "lane {} of road {} is driven both ways, but leads nowhere in one direction, in which it is left out",
                lane.id, road.id
            );
            drawn.notes.push(note("opendrive-link", road.line, message));
            continue;
        }
        directions.push((direction, direction != road.directions(lane)[0]));
    }
    lines.lanelets(assembly, drawn, lanes, One { pieces, borders, directions, used: *used, limit });
}

/// Whether the file links an end of a lane to others, but ends in the same nodes as none of them.
fn is_cut_off(
    ends: &EndNodes,
    (lanes, meeting): (&[StretchLanes], &BTreeMap<LaneEnd, Vec<LaneEnd>>),
    end: LaneEnd,
) -> bool {
    let nodes = |end: LaneEnd| {
        sides(end.lane).map(|border| {
            let stands = lanes[end.stretch].stands.get(&border).copied().unwrap_or(border);
            ends.get(&(end.stretch, end.far, stands)).map(|(first, _)| *first)
        })
    };
    let joined = |other: &LaneEnd| {
        let [high, low] = nodes(*other);
        nodes(end) == if end.far == other.far { [low, high] } else { [high, low] }
    };
    meeting.get(&end).is_some_and(|others| !others.is_empty() && !others.iter().any(joined))
}

/// Adds the lanelets of the strips beside the driven lanes of a stretch.
fn strips(lines: &mut Lines, assembly: &mut MapBuilder, drawn: &mut Drawn, lanes: &[StretchLanes], stretch: usize) {
    let road = lines.scene.road(stretch);
    for run in &lanes[stretch].sides {
        let [inner, outer] = run.borders();
        let borders = vec![if outer > 0 { [outer, inner] } else { [inner, outer] }];
        let beside = lanes[stretch].driven.iter().find(|(lane, _)| lane.id == run.beside());
        let direction = beside.map_or(1, |(lane, _)| road.directions(lane)[0]);
        let limit = if run.used == LaneUse::Bicycles { CYCLING } else { CRAWLING };
        let pieces = vec![Piece { stretch, lane: run.lanes[1] }];
        let directions = vec![(direction, false)];
        lines.lanelets(assembly, drawn, lanes, One { pieces, borders, directions, used: run.used, limit });
    }
}

/// Whether a lane is reached and left in a direction: of one that is driven both ways in a junction, often only one direction is.
fn leads_through(scene: &Scene, meeting: &BTreeMap<LaneEnd, Vec<LaneEnd>>, [entry, exit]: [LaneEnd; 2]) -> bool {
    let goes_on = |end: LaneEnd, leaving: bool| {
        meeting.get(&end).into_iter().flatten().any(|other| {
            let along = if leaving == other.far { -1 } else { 1 };
            let lane = scene.section(other.stretch).lane(other.lane);
            lane.is_some_and(|lane| scene.road(other.stretch).directions(lane).contains(&along))
        })
    };
    goes_on(entry, false) && goes_on(exit, true)
}

/// One note for each road of which some lane has no speed limit.
fn unsaid_speeds(scene: &Scene, lanes: &[StretchLanes], notes: &mut Vec<Finding>) {
    let mut told = BTreeSet::new();
    for (stretch, lanes) in lanes.iter().enumerate() {
        let (road, section) = (scene.road(stretch), scene.section(stretch));
        let unsaid = |(lane, used): &(&Lane, LaneUse)| {
            used.is_driven() && road.speed(section, lane, scene.middle(stretch)).is_none()
        };
        if lanes.driven.iter().any(unsaid) && told.insert(&road.id) {
            let message = format!("road {} has no speed limit: {UNSAID_SPEED} km/h", road.id);
            notes.push(note("opendrive-speed", road.line, message).graded(Severity::Info));
        }
    }
}

/// The lanes of a stretch that become lanelets.
fn used<'a>(scene: &'a Scene, stretch: usize) -> Vec<(&'a Lane, LaneUse)> {
    let it = scene.stretches[stretch];
    let lanes = scene.section(stretch).lanes.iter().filter(|lane| it.driven.contains(&lane.id));
    if scene.cut[it.road].dissolved { Vec::new() } else { lanes.map(|lane| (lane, LaneUse::of(lane))).collect() }
}

/// The strips beside the driven lanes that become lanelets: shoulders with parked cars, and lanes for bicycles.
fn side_runs(scene: &Scene, stretch: usize, driven: &[(&Lane, LaneUse)], beside: &BesideSettings) -> Vec<SideRun> {
    let (road, sections) = (scene.road(stretch), scene.sections(stretch));
    let [from, to] = scene.stretches[stretch].span;
    if road.junction.is_some() || driven.is_empty() || to - from < SHORT_STRIP {
        return Vec::new();
    }
    let mut runs = Vec::new();
    for side in [1, -1] {
        let Some((used, [first, last])) = sections.first().and_then(|section| strip(section, side)) else { continue };
        let wanted = match used {
            LaneUse::Shoulder => beside.shoulders,
            LaneUse::Bicycles => beside.bicycle_lanes != BicycleLanes::None,
            _ => false,
        };
        let inner = xodr::inner(first);
        let goes_on = sections.iter().all(|section| strip(section, side) == Some((used, [first, last])));
        if !wanted || !goes_on || !driven.iter().any(|(lane, _)| lane.id == inner) {
            continue;
        }
        let least = if used == LaneUse::Bicycles { NARROW_BICYCLES } else { NARROW_SHOULDER };
        // A part of a strip narrower than that is a part of the border, whatever lies behind.
        let span = scene.stretches[stretch].span;
        let wide = |section: &&Section| {
            let [from, to] = [section.span[0].max(span[0]), section.span[1].min(span[1])];
            [from, f64::midpoint(from, to), to].into_iter().all(|station| {
                let [a, b] = [inner, last].map(|border| section.offset(road, border, station));
                (a - b).abs() >= least
            })
        };
        if sections.iter().all(wide) {
            runs.push(SideRun { used, lanes: [inner, last] });
        }
    }
    runs
}

/// The nodes at the ends of all borders: for each the first end that it belongs to, and its place.
fn meeting_ends(
    scene: &Scene,
    all_borders: &[Vec<(i64, i64)>],
    lanes: &[StretchLanes],
    contacts: &[Contact],
    notes: &mut Vec<Finding>,
) -> EndNodes {
    let mut nodes = Nodes::default();
    for (stretch, borders) in all_borders.iter().enumerate() {
        let inside = scene.road(stretch).junction.is_some();
        for far in [false, true] {
            for &(border, _) in borders {
                nodes.add((stretch, far, border), scene.border_at(stretch, far, border), inside);
            }
            for (border, stands) in borders.iter().filter(|(border, stands)| border != stands) {
                nodes.pinch((stretch, far, *border), (stretch, far, *stands));
            }
        }
    }
    let driven = |end: LaneEnd| lanes[end.stretch].driven.iter().any(|(lane, _)| lane.id == end.lane);
    let gaps = nodes.join(contacts, driven);
    nodes.touch(driven);
    for gap in gaps {
        let [a, b] = gap.contact.ends.map(|end| format!("lane {} of road {}", end.lane, scene.road(end.stretch).id));
        let done = if gap.joined { "they are joined all the same" } else { "they are not joined" };
        let message = format!("{a} and {b} are linked but end {:.2} m from each other: {done}", gap.distance);
        notes.push(note("opendrive-gap", gap.contact.line, message).graded(Severity::Warning));
    }
    nodes.places()
}

/// Finds which lanes follow which.
fn follow(drawn: &mut Drawn, contacts: &[Contact]) {
    let mut leaving: BTreeMap<LaneEnd, Vec<usize>> = BTreeMap::new();
    let mut entering: BTreeMap<LaneEnd, Vec<usize>> = BTreeMap::new();
    for (at, lane) in drawn.lanes.iter().enumerate() {
        leaving.entry(lane.exit()).or_default().push(at);
        entering.entry(lane.entry()).or_default().push(at);
    }
    drawn.next = vec![Vec::new(); drawn.lanes.len()];
    drawn.back = drawn.next.clone();
    let driven = |end: LaneEnd| {
        drawn.on(end.stretch).any(|(_, lane)| lane.piece_on(end.stretch).is_some_and(|it| it.lane == end.lane))
    };
    let linked = contacts.iter().map(|contact| contact.ends).filter(|ends| ends.iter().all(|end| driven(*end)));
    drawn.linked = linked.flatten().collect();
    for contact in contacts {
        for [a, b] in [contact.ends, [contact.ends[1], contact.ends[0]]] {
            for &from in leaving.get(&a).into_iter().flatten() {
                for &to in entering.get(&b).into_iter().flatten() {
                    if drawn.lanes[from].nodes[1] == drawn.lanes[to].nodes[0] {
                        drawn.next[from].push(to);
                        drawn.back[to].push(from);
                    }
                }
            }
        }
    }
    for list in drawn.next.iter_mut().chain(&mut drawn.back) {
        list.sort_unstable();
        list.dedup();
    }
}
