//! Crosswalks: the outlines of the file become lanelets from kerb to kerb, announced to the lanes that they cross, with their lights.

use crate::builder::control::crosswalk::{announce, pedestrian_attributes};
use crate::builder::ids::Key;
use crate::builder::map::map_builder::MapBuilder;
use crate::diagnostic::Finding;
use crate::geometry::{Point, Vector};
use crate::lanelet::{Attributes, Bound, LaneletId, Target};
use crate::xodr::{Object, Place, Road};

use super::lights::{Body, WALK_BODY, body};
use super::scene::{Drawn, Scene, note};
use super::signal_use::SignalUse;
use super::signals::Furniture;

/// The breadth of a crosswalk without an outline, metres.
const BREADTH: f64 = 3.0;
/// A light for people on foot belongs to the crosswalk within this distance, metres.
const LIGHT_REACH: f64 = 6.0;
/// So broad may a signal say that its crosswalk is, metres.
const SAID_BREADTH: std::ops::RangeInclusive<f64> = 1.0..=15.0;
/// Numbers of a crosswalk's marking: Germany's, and that of OpenDRIVE's own list of signals.
const ZEBRAS: [&str; 2] = ["293", "1000003"];

/// A crosswalk of the file: its corners and its key.
struct Crosswalk {
    ring: Vec<Place>,
    across: Vector,
    key: Key,
    line: usize,
    id: String,
}

/// Whether an object is a crosswalk.
fn is_crosswalk(object: &Object) -> bool {
    let words = object.words();
    let named = ["crosswalk", "zebra", "pedestriancrossing"].iter().any(|word| words.contains(word));
    object.kind == "crosswalk" || named && ["roadMark", "-1", "", "none"].contains(&object.kind.as_str())
}

/// Adds all crosswalks.
pub fn draw(assembly: &mut MapBuilder, scene: &Scene, drawn: &Drawn, furniture: &Furniture) -> Vec<Finding> {
    let mut notes = Vec::new();
    let lanes: Vec<(LaneletId, Vec<Point>)> = drawn
        .lanes
        .iter()
        .filter(|lane| lane.used.is_driven())
        .map(|lane| (lane.lanelet, assembly.outline(lane.lanelet)))
        .collect();
    let mut made: Vec<(LaneletId, Vec<Point>, Vector)> = Vec::new();
    for crosswalk in crosswalks(scene) {
        let Some((lanelet, across)) = lanelet(assembly, scene, &crosswalk) else {
            let message = format!("crosswalk {} has an outline without breadth: it is left out", crosswalk.id);
            notes.push(note("opendrive-crosswalk", crosswalk.line, message));
            continue;
        };
        if !announce(assembly, lanelet, lanes.iter().map(|(id, outline)| (*id, &outline[..]))) {
            let message = format!("nobody drives over crosswalk {}", crosswalk.id);
            notes.push(note("opendrive-crosswalk", crosswalk.line, message));
        }
        made.push((lanelet, assembly.outline(lanelet), across));
    }
    walk_lights(assembly, scene, furniture, &made, &mut notes);
    notes
}

fn crosswalks(scene: &Scene) -> Vec<Crosswalk> {
    let mut all: Vec<Crosswalk> = Vec::new();
    let mut marked: Vec<(usize, f64)> = Vec::new();
    for (index, road) in scene.file.roads.iter().enumerate().filter(|(_, road)| !road.plan.is_empty()) {
        for object in road.objects.iter().filter(|object| is_crosswalk(object)) {
            let key =
                Key::new("opendrive").word("crosswalk").word(&road.id).word(&object.id).number(object.line as i64);
            let across = scene.plane.angle(road.angle(object.at[0])) + std::f64::consts::FRAC_PI_2;
            let across = Vector::new(across.cos(), across.sin());
            let ring = object.ring(road).unwrap_or_else(|| whole_width(road, object.at[0], BREADTH));
            marked.push((index, object.at[0]));
            all.push(Crosswalk { ring, across, key, line: object.line, id: object.id.to_string() });
        }
    }
    for (index, road) in scene.file.roads.iter().enumerate().filter(|(_, road)| !road.plan.is_empty()) {
        for signal in road.signals.iter().filter(|signal| ZEBRAS.contains(&signal.kind.as_str())) {
            if marked.iter().any(|(other, station)| *other == index && (station - signal.at[0]).abs() < LIGHT_REACH) {
                continue;
            }
            marked.push((index, signal.at[0]));
            let key =
                Key::new("opendrive").word("crosswalk").word(&road.id).word(&signal.id).number(signal.line as i64);
            let across = scene.plane.angle(road.angle(signal.at[0])) + std::f64::consts::FRAC_PI_2;
            let across = Vector::new(across.cos(), across.sin());
            let breadth = signal.value.filter(|value| SAID_BREADTH.contains(value)).unwrap_or(BREADTH);
            let ring = whole_width(road, signal.at[0], breadth);
            all.push(Crosswalk { ring, across, key, line: signal.line, id: signal.id.to_string() });
        }
    }
    all
}

/// A rectangle over all lanes of a road around a station, so many metres broad.
fn whole_width(road: &Road, station: f64, breadth: f64) -> Vec<Place> {
    let Some(section) = road.sections.get(road.section_at(station)) else { return Vec::new() };
    let driven = section.lanes.iter().filter(|lane| super::lane_use::LaneUse::of(lane).is_driven());
    let borders = driven.flat_map(|lane| super::lane_use::sides(lane.id));
    let offsets = borders.map(|border| section.offset(road, border, station));
    let [low, high] = offsets.fold([f64::MAX, f64::MIN], |[low, high], t| [low.min(t), high.max(t)]);
    if low >= high {
        return Vec::new();
    }
    let half = breadth / 2.0;
    [[-half, low], [half, low], [half, high], [-half, high]].map(|[s, t]| road.place(station + s, t)).to_vec()
}

/// Adds the lanelet of a crosswalk; also gives the direction in which people walk.
fn lanelet(assembly: &mut MapBuilder, scene: &Scene, crosswalk: &Crosswalk) -> Option<(LaneletId, Vector)> {
    let corners = scene.plane.to_map(&crosswalk.ring);
    let sides = long_sides(&corners, crosswalk.across)?;
    let names = ["left", "right"];
    let mut bounds = names.iter().zip(&sides).map(|(name, side)| {
        let key = crosswalk.key.word(name);
        let points = side
            .iter()
            .zip(0..)
            .map(|((at, height), i)| assembly.point_at(key.number(i), *at, *height, Attributes::new()));
        let points = points.collect();
        Bound { line: assembly.line(key, points, Attributes::of(&[("type", "pedestrian_marking")])), inverted: false }
    });
    let (left, right) = (bounds.next()?, bounds.next()?);
    drop(bounds);
    let first = &sides[0];
    let walk = (first.last()?.0 - first.first()?.0).try_normalize(f64::EPSILON)?;
    Some((assembly.lanelet(crosswalk.key, left, right, pedestrian_attributes("crosswalk")), walk))
}

/// A side of a crosswalk: places with heights.
type SideLine = Vec<(Point, f64)>;

/// The left and the right side of a ring for people who walk across: the ring without its two ends, which are the pieces whose middles
/// lie farthest back and farthest ahead.
fn long_sides(ring: &[(Point, f64)], across: Vector) -> Option<[SideLine; 2]> {
    /// A crosswalk is no narrower than this, metres.
    const LEAST: f64 = 0.3;
    if ring.len() < 4 {
        return None;
    }
    let ring = clockwise(ring);
    let count = ring.len();
    let direction = walking(&ring, across);
    let edge = |i: usize| (ring[i].0, ring[(i + 1) % count].0);
    let ahead = |i: usize| {
        let (a, b) = edge(i);
        nalgebra::center(&a, &b).coords.dot(&direction)
    };
    let begin = (0..count).min_by(|&a, &b| ahead(a).total_cmp(&ahead(b)))?;
    let end = (0..count).max_by(|&a, &b| ahead(a).total_cmp(&ahead(b)))?;
    let chain = |from: usize, to: usize| -> SideLine {
        let steps = (to + count - from) % count;
        (0..=steps).map(|step| ring[(from + step) % count]).collect()
    };
    // Clockwise from the end of the first edge leads along the left side.
    let left = chain((begin + 1) % count, end);
    let mut right = chain((end + 1) % count, begin);
    right.reverse();
    let length = |side: &SideLine| side.windows(2).map(|pair| (pair[1].0 - pair[0].0).norm()).sum::<f64>();
    let apart = |a: usize| {
        let (p, q) = edge(a);
        (p - q).norm() >= LEAST
    };
    (left.len() > 1 && right.len() > 1 && length(&left) > LEAST && length(&right) > LEAST && apart(begin) && apart(end))
        .then_some([left, right])
}

/// The direction in which people walk: along the edges of the ring that run most across the road, by their length.
fn walking(ring: &[(Point, f64)], across: Vector) -> Vector {
    let count = ring.len();
    let edges = (0..count).map(|i| ring[(i + 1) % count].0 - ring[i].0);
    let turned = edges.map(|edge| if edge.dot(&across) < 0.0 { -edge } else { edge });
    let most: Vector = turned.filter(|edge| edge.dot(&across) > 0.7 * edge.norm()).sum();
    most.try_normalize(f64::EPSILON).unwrap_or(across)
}

fn clockwise(ring: &[(Point, f64)]) -> SideLine {
    let places: Vec<Point> = ring.iter().map(|(at, _)| *at).collect();
    let mut ring = ring.to_vec();
    if crate::geometry::polygon::signed_area(&places) > 0.0 {
        ring.reverse();
    }
    ring
}

/// Hangs the lights for people on foot on the crosswalks near them.
fn walk_lights(
    assembly: &mut MapBuilder,
    scene: &Scene,
    furniture: &Furniture,
    made: &[(LaneletId, Vec<Point>, Vector)],
    notes: &mut Vec<Finding>,
) {
    let mut members: Vec<Vec<[crate::lanelet::LineStringId; 2]>> = vec![Vec::new(); made.len()];
    for placed in furniture.signals.iter().filter(|it| it.used == SignalUse::WalkLight) {
        let road = &scene.file.roads[placed.road];
        let (at, _) = scene.plane.to_map(&[placed.signal.place(road)]).pop().unwrap_or_default();
        let off = |ring: &[Point]| {
            let closed = ring.iter().chain(ring.first()).copied();
            crate::geometry::Polyline::new(closed).map_or(f64::INFINITY, |line| line.distance(at))
        };
        let nearest = made.iter().enumerate().map(|(i, (_, ring, walk))| (off(ring), i, *walk));
        let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(off, ..)| *off <= LIGHT_REACH);
        let Some((_, index, walk)) = nearest else {
            let message =
                format!("light {} for people on foot stands at no crosswalk: it is left out", placed.signal.id);
            notes.push(note("opendrive-signal", placed.signal.line, message));
            continue;
        };
        let key = Key::new("opendrive")
            .word("walk light")
            .word(&road.id)
            .word(&placed.signal.id)
            .number(placed.signal.line as i64);
        // It is seen by people who come from the other end.
        let middle = Point::from(made[index].1.iter().map(|p| p.coords).sum::<Vector>() / made[index].1.len() as f64);
        let heading = if (at - middle).dot(&walk) < 0.0 { -walk } else { walk };
        let shape = Body::of(placed.signal, WALK_BODY, heading);
        members[index].push(body(assembly, scene, placed, key, &shape, &["green", "red"]));
    }
    for ((lanelet, ..), lights) in made.iter().zip(members).filter(|(_, lights)| !lights.is_empty()) {
        let refers = lights.iter().map(|[light, _]| ("refers", Target::LineString(*light)));
        let bulbs = lights.iter().map(|[_, bulbs]| ("light_bulbs", Target::LineString(*bulbs)));
        let all: Vec<(&str, Target)> = refers.chain(bulbs).collect();
        assembly.element(
            Key::new("opendrive").word("walk lights").number(lanelet.0),
            "traffic_light",
            &all,
            &[*lanelet],
        );
    }
}
