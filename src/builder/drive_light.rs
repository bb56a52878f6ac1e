//! Lights for drivers where people cross a road between intersections and have lights: a stop line before the crosswalk on
//! each lane, and a light behind it for each direction.
//!
//! Where people have lights, drivers have some too, or nobody would stop for them. They are added to the map that stands: the
//! stop line may come to lie on the lane before the one that crosses.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::{Point, Vector, cross, polygon};
use crate::lanelet::index::Lane;
use crate::lanelet::{Lanelet, LaneletId, LaneletMap, LineStringId, PointId, RegulatoryElementId, RoadType, Target};
use crate::projection::Projector;

use super::across::{Ends, across};
use super::assembly::tags;
use super::connection::STOP_GAP;
use super::control::{BEHIND, LIGHT_HEIGHT, LightShape, bulbs_of};
use super::ids::Key;
use super::pen::Pen;
use super::road_network::DrivingSide;

/// The least that lies between the stop line and the crosswalk, metres, where a lane begins before it.
const GAP_LEAST: f64 = 0.5;
/// A crosswalk so near behind an intersection with lights, metres, belongs to these: whoever has left it need not stop again.
const BEHIND_LIGHTS: f64 = 30.0;

/// One lane that crosses.
struct Crosser {
    /// The lanelet on which the stop line lies, ...
    stops: LaneletId,
    /// ... and the line.
    line: Ends,
    /// Where the middle of the lane crosses the middle of the crosswalk, and which way it heads.
    middle: Point,
    heading: Vector,
    /// How far it drives on the crosswalk, metres.
    breadth: f64,
}

/// Adds the lights, and notes of lanes that have no room for a stop line.
pub fn add(map: &mut LaneletMap, projector: &Projector, driving: DrivingSide) -> Vec<Finding> {
    let crosswalks = lit(map);
    if crosswalks.is_empty() {
        return Vec::new();
    }
    let mut notes = Vec::new();
    let mut all: Vec<(LaneletId, Vec<Crosser>)> = Vec::new();
    // Autoware heeds one light of a lanelet.
    let mut taken: FxHashSet<LaneletId> = FxHashSet::default();
    {
        let before = Before::new(map);
        for (crosswalk, lanes) in crosswalks {
            let Some(area) = map.lanelets.get(crosswalk).map(|lanelet| map.outline(lanelet)) else { continue };
            let mut crossers = Vec::new();
            for lane in lanes {
                match crosser(map, &before, &area, lane) {
                    Reached::At(crosser) if taken.insert(crosser.stops) => crossers.push(*crosser),
                    Reached::At(_) => notes.push(note(crosswalk, lane, &area, "stops for another one before")),
                    Reached::Without => notes.push(note(crosswalk, lane, &area, "has no room for a stop line before")),
                    Reached::Elsewhere => {}
                }
            }
            all.push((crosswalk, crossers));
        }
    }
    let mut pen = Pen::new(map, projector);
    for (crosswalk, crossers) in all {
        // Those who drive one way, from the one lane to the other.
        let walk = pen.map.lanelets.get(crosswalk).and_then(|lanelet| walk(pen.map, lanelet)).unwrap_or_default();
        let (to_left, to_right): (Vec<Crosser>, Vec<Crosser>) =
            crossers.into_iter().partition(|crosser| cross(walk, crosser.heading) > 0.0);
        for (way, crossers) in [("left", to_left), ("right", to_right)] {
            let key = Key::new("drive lights").number(crosswalk.0).word(way);
            draw(&mut pen, driving, key, &crossers);
        }
    }
    notes
}

/// The crosswalks with lights, and the lanes for motor vehicles outside intersections that cross each.
fn lit(map: &LaneletMap) -> Vec<(LaneletId, Vec<LaneletId>)> {
    let has_lights = |lanelet: &Lanelet| {
        let mut elements = lanelet.regulatory_elements.iter().filter_map(|&id| map.regulatory_elements.get(id));
        elements.any(|element| element.subtype == "traffic_light")
    };
    let crosswalks = map.lanelets.iter().filter(|lanelet| RoadType::of(&lanelet.attributes) == RoadType::Crosswalk);
    let lit: FxHashSet<LaneletId> =
        crosswalks.filter(|lanelet| has_lights(lanelet)).map(|lanelet| lanelet.id).collect();
    let elements = map.regulatory_elements.iter().filter(|element| element.subtype == "crosswalk");
    let known =
        elements.filter_map(|element| Some((element.id, element.lanelets("refers").find(|id| lit.contains(id))?)));
    let known: Vec<(RegulatoryElementId, LaneletId)> = known.collect();
    let mut lanes: FxHashMap<RegulatoryElementId, Vec<LaneletId>> = FxHashMap::default();
    let elements: FxHashSet<RegulatoryElementId> = known.iter().map(|(element, _)| *element).collect();
    for lanelet in map.lanelets.iter().filter(|lanelet| is_open_road(lanelet)) {
        for element in lanelet.regulatory_elements.iter().filter(|id| elements.contains(id)) {
            lanes.entry(*element).or_default().push(lanelet.id);
        }
    }
    known.into_iter().filter_map(|(element, crosswalk)| Some((crosswalk, lanes.remove(&element)?))).collect()
}

/// Whether motor vehicles drive on a lanelet that is part of no intersection.
fn is_open_road(lanelet: &Lanelet) -> bool {
    let driven = ["participant:vehicle", "participant:vehicle:bus"].iter().any(|key| lanelet.attributes.is(key, "yes"));
    driven && !lanelet.attributes.has("intersection_area")
}

/// Lanelets by the points with which they end.
struct Before(FxHashMap<[PointId; 2], Vec<LaneletId>>);

impl Before {
    fn new(map: &LaneletMap) -> Self {
        let mut ending: FxHashMap<[PointId; 2], Vec<LaneletId>> = FxHashMap::default();
        for lanelet in &map.lanelets {
            let last = |bound| map.bound_points(bound).next_back().map(|point| point.id);
            if let (Some(left), Some(right)) = (last(lanelet.left), last(lanelet.right)) {
                ending.entry([left, right]).or_default().push(lanelet.id);
            }
        }
        Self(ending)
    }

    /// The lanelets that lead to a lane.
    fn of<'a>(&'a self, map: &'a LaneletMap, lane: &Lane) -> impl Iterator<Item = &'a Lanelet> {
        let ids = self.0.get(&lane.start.ids).map_or(&[][..], Vec::as_slice);
        ids.iter()
            .filter_map(|&id| map.lanelets.get(id))
            .filter(|lanelet| RoadType::of(&lanelet.attributes) != RoadType::Crosswalk)
    }
}

/// What becomes of a lane that crosses.
enum Reached {
    /// It stops before the crosswalk.
    At(Box<Crosser>),
    /// It cannot: there is no room.
    Without,
    /// Others stop for it: the lane before crosses, too, or an intersection with lights lies close before.
    Elsewhere,
}

fn crosser(map: &LaneletMap, before: &Before, area: &[Point], id: LaneletId) -> Reached {
    let lane_of = |lanelet: &Lanelet| Lane::new(map, lanelet);
    let Some(lane) = map.lanelets.get(id).and_then(lane_of) else { return Reached::Without };
    let Some((on, off)) = common(&lane, area) else { return Reached::Without };
    let crosses_too = |lanelet: &Lanelet| lane_of(lanelet).is_some_and(|lane| common(&lane, area).is_some());
    if on < GAP_LEAST && before.of(map, &lane).any(|lanelet| is_open_road(lanelet) && crosses_too(lanelet)) {
        return Reached::Elsewhere;
    }
    if leaves_lights(map, before, &lane, on) {
        return Reached::Elsewhere;
    }
    let (Some(center), Some((stops, line))) = (&lane.center, stop_line(map, before, &lane, on)) else {
        return Reached::Without;
    };
    let middle = (on + off) / 2.0;
    Reached::At(Box::new(Crosser {
        stops,
        line,
        middle: center.at(middle),
        heading: center.direction(middle),
        breadth: off - on,
    }))
}

/// From where to where along the middle of a lane, metres, it lies on a crosswalk.
fn common(lane: &Lane, area: &[Point]) -> Option<(f64, f64)> {
    /// What is smaller, square metres, only touches.
    const TOUCH: f64 = 0.1;
    let center = lane.center.as_ref()?;
    if polygon::overlap(&lane.outline, area) < TOUCH {
        return None;
    }
    let common = polygon::intersection(&lane.outline, area);
    let corners = common.0.iter().flat_map(|part| part.exterior().points()).map(|p| Point::new(p.x(), p.y()));
    let stations: Vec<f64> = corners.map(|corner| center.project(corner).station).collect();
    let [first, last] = [f64::min as fn(f64, f64) -> f64, f64::max].map(|of| stations.iter().copied().reduce(of));
    Some((first?, last?))
}

/// The line before a place along a lane (m), or on the lanes before it where that one is too short, with the lanelet on
/// which it lies.
fn stop_line(map: &LaneletMap, before: &Before, lane: &Lane, on: f64) -> Option<(LaneletId, Ends)> {
    let station = on - STOP_GAP;
    if station >= 0.0 {
        return Some((lane.id, across(lane, station)?));
    }
    let mut open = before.of(map, lane).filter(|lanelet| is_open_road(lanelet));
    if let (Some(only), None) = (open.next().and_then(|lanelet| Lane::new(map, lanelet)), open.next())
        && station + only.length() >= 0.0
    {
        return Some((only.id, across(&only, station + only.length())?));
    }
    (on >= GAP_LEAST).then(|| across(lane, 0.0)).flatten().map(|line| (lane.id, line))
}

/// Whether a lane leads out of an intersection with lights that lies close before.
fn leaves_lights(map: &LaneletMap, before: &Before, lane: &Lane, on: f64) -> bool {
    let is_lit = |lanelet: &Lanelet| {
        lanelet.attributes.has("intersection_area") && crate::lanelet::index::is_signalised(map, lanelet.id)
    };
    let mut open = Vec::from_iter((on <= BEHIND_LIGHTS).then(|| (lane.clone(), on)));
    while let Some((lane, driven)) = open.pop() {
        for lanelet in before.of(map, &lane) {
            if is_lit(lanelet) {
                return true;
            }
            let Some(earlier) = Lane::new(map, lanelet).filter(|_| is_open_road(lanelet)) else { continue };
            let driven = driven + earlier.length();
            if driven <= BEHIND_LIGHTS {
                open.push((earlier, driven));
            }
        }
    }
    false
}

/// Which way people walk on a crosswalk.
fn walk(map: &LaneletMap, crosswalk: &Lanelet) -> Option<Vector> {
    let line = map.bound_line(crosswalk.left);
    Some(line.last()? - line.first()?)
}

fn note(crosswalk: LaneletId, lane: LaneletId, area: &[Point], why: &str) -> Finding {
    let message = format!("Lane {lane} {why} crosswalk {crosswalk}, whose people have lights: its drivers have none.");
    Finding::new("crossing-unlit", Subject::Lanelet(crosswalk.0), message)
        .with(Subject::Lanelet(lane.0), "lane")
        .at(Place::Line(area.to_vec()))
}

/// Draws the light of those who drive one way, and a stop line and an element for each of their lanes.
fn draw(pen: &mut Pen, driving: DrivingSide, key: Key, crossers: &[Crosser]) {
    let Some(first) = crossers.first() else { return };
    let count = crossers.len() as f64;
    let heading =
        crossers.iter().map(|one| one.heading).sum::<Vector>().try_normalize(f64::EPSILON).unwrap_or(first.heading);
    let middle = crossers.iter().map(|one| one.middle.coords).sum::<Vector>() / count;
    let breadth = crossers.iter().map(|one| one.breadth).fold(0.0, f64::max);
    let middle = Point::from(middle) + heading * (breadth / 2.0 + BEHIND);
    let ele = pen.height(first.line[0].0, first.line[0].1) + LIGHT_HEIGHT;
    let [light, bulbs] = light(pen, key, &LightShape::new(driving, middle, heading), ele);
    for crosser in crossers {
        let key = key.number(crosser.stops.0);
        let nodes = ["left", "right"].into_iter().zip(crosser.line);
        let nodes = nodes.map(|(side, (bound, place))| pen.point_on(key.word(side), bound, place)).collect();
        let line = pen.line(key.word("stop line"), nodes, tags(&[("type", "stop_line"), ("subtype", "solid")]));
        let members = vec![
            ("refers", Target::LineString(light)),
            ("light_bulbs", Target::LineString(bulbs)),
            ("ref_line", Target::LineString(line)),
        ];
        pen.element(key.word("lights"), "traffic_light", members, &[crosser.stops]);
    }
}

/// A light with its lower edge at a height, metres, and its bulbs.
fn light(pen: &mut Pen, key: Key, shape: &LightShape, ele: f64) -> [LineStringId; 2] {
    let ends = ["from", "to"].into_iter().zip(shape.ends).map(|(name, place)| pen.point(key.word(name), place, ele));
    let ends = ends.collect();
    let light = pen.named_line(key, ends, shape.attributes());
    let lamps = shape
        .lamps
        .map(|(color, place, up)| pen.tagged_point(key.word(color), place, ele + up, tags(&[("color", color)])));
    [light, pen.line(key.word("bulbs"), lamps.to_vec(), bulbs_of(light))]
}
