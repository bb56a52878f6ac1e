//! Vehicle signals between intersections: a stop line before the crosswalk on each lane, and a light behind the crosswalk for each
//! direction.
//!
//! Where people have lights, drivers need lights to stop for them. Lights without a crosswalk hold vehicles before a place of the
//! same length. The road is split at the stop lines, so that the elements of the lights belong to the lanelets that begin there, as
//! inside intersections.
//!
//! Where people cross so close to an intersection without lights that no vehicle can wait between, vehicles on that road stop
//! before the intersection: it has lights for that road, and the other roads give way.

use std::collections::BTreeMap;

use rustc_hash::FxHashSet;

use crate::builder::lanes::road_cut::{
    CROSSWALK_BREADTH, ConnectionLines, RoadCrossing, STOP_GAP, STOP_GAP_MOST, VEHICLE, has_lights,
};
use crate::builder::lanes::types::{Lanes, RoadLane};
use crate::builder::layout::map_layout::IntersectionLanelets;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::approach_control::{Control, sign_at};
use crate::builder::network::signal_assignment::arrives;
use crate::builder::network::{End, FeatureKind, Intersection, RoadEnd, RoadIx, RoadNetwork};
use crate::builder::streets::heights::Ground;
use crate::builder::tags::cross_section::Travel;
use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::{angle_between, left_of};
use crate::lanelet::right_of_way::OPPOSITE;

use super::light_places::BEHIND;
use super::stop_line::{PAINTED_LINE, stop_line};
use super::vehicle_signals::{LightShape, add_light, light_element};

/// The least distance between the stop line and the crosswalk, metres.
const GAP_LEAST: f64 = 0.5;
/// Vehicles that have left an intersection with lights need not stop at a crosswalk within this distance, metres.
const BEHIND_LIGHTS: f64 = 30.0;
/// Between crosswalks that are less than this apart, metres, no vehicle can wait: one light holds it before both.
const TOGETHER: f64 = 2.0 * STOP_GAP + VEHICLE;
/// Two lights without a crosswalk and without a direction that are less than this apart, metres, are one for each direction: those who
/// arrive stop at the first.
const PAIR: f64 = 40.0;

/// A part of a road between intersections with crossings that have pedestrian signals, or with lights alone.
pub struct SignalisedCrossing {
    /// The road.
    pub road: RoadIx,
    /// The OpenStreetMap node of its first crossing.
    pub node: i64,
    /// Stations of the begin of its first crosswalk and of the end of the last, metres.
    pub span: [f64; 2],
    /// Whether vehicles toward the start and toward the end of the road stop there.
    pub stops: [bool; 2],
}

impl SignalisedCrossing {
    fn middle(&self) -> f64 {
        (self.span[0] + self.span[1]) / 2.0
    }
}

/// Finds them, in order of roads and stations.
pub fn signalised_crossings(
    network: &RoadNetwork,
    lines: &ConnectionLines,
    turning: &[Option<Box<IntersectionLanelets>>],
) -> Vec<SignalisedCrossing> {
    let half = CROSSWALK_BREADTH / 2.0;
    let between = lines.crossings.iter().filter(|crossing| crossing.arm.is_none());
    let mut found: Vec<SignalisedCrossing> = Vec::new();
    let mut last_for_both = false;
    for crossing in between.filter(|crossing| has_lights(network.road(crossing.road), crossing)) {
        let RoadCrossing { road, node, station, lights_only, .. } = *crossing;
        let span = [station - half, station + half];
        let is_for =
            |travel: Option<Travel>, end: End| travel.is_none_or(|it| it == end.inbound() || it == Travel::Both);
        let stops = End::BOTH.map(|end| is_for(lights_only, end) && is_for(network.road(road).one_way(), end));
        let for_both = lights_only == Some(Travel::Both);
        let together = if for_both && last_for_both { PAIR } else { TOGETHER };
        last_for_both = for_both;
        match found.last_mut() {
            Some(last) if last.road == road && span[0] - last.span[1] < together => {
                last.span[1] = span[1];
                last.stops = [0, 1].map(|end| last.stops[end] || stops[end]);
            }
            _ => found.push(SignalisedCrossing { road, node, span, stops }),
        }
    }
    for crossing in &mut found {
        let [start, end] = lines.kept[crossing.road];
        let from = |end, driven| leaves_lights(network, lines, turning, RoadEnd { road: crossing.road, end }, driven);
        crossing.stops[End::Start] &= !from(End::End, end - crossing.span[1]);
        crossing.stops[End::End] &= !from(End::Start, crossing.span[0] - start);
    }
    found.retain(|crossing| crossing.stops != [false; 2]);
    found
}

/// Whether vehicles that have driven this far, metres, from the end of a road have left an intersection with lights nearby.
fn leaves_lights(
    network: &RoadNetwork,
    lines: &ConnectionLines,
    turning: &[Option<Box<IntersectionLanelets>>],
    at: RoadEnd,
    driven: f64,
) -> bool {
    let mut open = vec![(at, driven)];
    while let Some((at, driven)) = open.pop() {
        let ix = network.road(at.road).intersection(at.end);
        let intersection = network.intersection(ix);
        let area = turning.get(ix.position()).and_then(|turning| turning.as_ref()?.area.as_ref());
        if driven > BEHIND_LIGHTS || area.is_some() && !intersection.signals {
            continue;
        }
        if area.is_some() {
            return true;
        }
        let others = intersection.arms.iter().filter(|before| before.road != at.road);
        for before in others.filter(|before| arrives(network.road(before.road), before.end)) {
            let [start, end] = lines.kept[before.road];
            open.push((RoadEnd { road: before.road, end: before.end.other() }, driven + end - start));
        }
    }
    false
}

/// The ends of roads, in order, that have vehicle signals at an intersection only because of pedestrian signals there, and notes
/// of crossings with pedestrian signals on roads without priority, which have none.
pub fn guarded(
    network: &RoadNetwork,
    lines: &ConnectionLines,
    lanes: &Lanes,
    turning: &[Option<Box<IntersectionLanelets>>],
) -> (Vec<RoadEnd>, Vec<Finding>) {
    let mut crossed: Vec<Vec<(RoadEnd, &RoadCrossing)>> = vec![Vec::new(); network.intersections.len()];
    for crossing in lines.crossings.iter().filter(|crossing| has_lights(network.road(crossing.road), crossing)) {
        let Some(end) = crossing.arm else { continue };
        let ix = network.road(crossing.road).intersection(end);
        crossed[ix].push((RoadEnd { road: crossing.road, end }, crossing));
    }
    let (mut guarded, mut notes) = (Vec::new(), Vec::new());
    for ((intersection, turning), crossed) in network.intersections.iter().zip(turning).zip(crossed) {
        if crossed.is_empty() || intersection.signals {
            continue;
        }
        let arms: Vec<RoadEnd> = crossed.iter().map(|(at, _)| *at).collect();
        let has_area = turning.as_ref().is_some_and(|turning| turning.area.is_some());
        let main = MainRoad { network, lanes, crossed: &arms }.arms(intersection);
        match main.filter(|_| has_area && !intersection.all_way_stop) {
            Some(main) => guarded.extend(main),
            None => notes.extend(crossed.iter().map(|(at, crossing)| unguarded(network, *at, crossing))),
        }
    }
    guarded.sort_unstable();
    (guarded, notes)
}

/// The road of the arms on which people cross at an intersection.
struct MainRoad<'a> {
    network: &'a RoadNetwork,
    lanes: &'a Lanes,
    crossed: &'a [RoadEnd],
}

impl MainRoad<'_> {
    /// Its arms, those that lead straight on from the crossed ones included; `None` if the road has no priority.
    fn arms(&self, intersection: &Intersection) -> Option<Vec<RoadEnd>> {
        let (main, others): (Vec<RoadEnd>, Vec<RoadEnd>) = intersection
            .arms
            .iter()
            .partition(|at| self.crossed.contains(at) || self.leads_straight_on(**at) && !self.is_minor(**at));
        let class = |at: RoadEnd| self.network.road(at.road).class;
        let lowest = self.crossed.iter().map(|at| class(*at)).max()?;
        // Of roads of one class the one that goes on has priority over the one that ends.
        let through = main.len() == 2 && others.len() == 1;
        let yields = |at: RoadEnd| self.is_minor(at) || class(at) > lowest || class(at) == lowest && through;
        let has_priority = !self.crossed.iter().any(|at| self.is_minor(*at)) && others.into_iter().all(yields);
        has_priority.then_some(main)
    }

    /// Whether a road end is on private ground or has a stop or give-way sign.
    fn is_minor(&self, at: RoadEnd) -> bool {
        let road = self.network.road(at.road);
        !road.public || matches!(sign_at(road, at.end), Control::Stop | Control::GiveWay)
    }

    /// Whether an arm lies opposite one that people cross.
    fn leads_straight_on(&self, at: RoadEnd) -> bool {
        self.crossed.iter().any(|crossed| {
            let bend = angle_between(self.lanes.arm(at).inward, -self.lanes.arm(*crossed).inward).abs();
            at != *crossed && bend <= OPPOSITE.to_radians()
        })
    }
}

fn unguarded(network: &RoadNetwork, at: RoadEnd, crossing: &RoadCrossing) -> Finding {
    let [node, way] = [crossing.node, network.road(at.road).key.way];
    let message = format!(
        "People have lights at node {node}, but the intersection beside it has none, and way {way} has no priority there: \
         its drivers have none."
    );
    unlit(network, at.road, node, crossing.station, message)
}

/// The note of a crossing with pedestrian signals but without vehicle signals; `station` is that of the crossing, metres.
fn unlit(network: &RoadNetwork, road: RoadIx, node: i64, station: f64, message: String) -> Finding {
    let road = network.road(road);
    Finding::new("crossing-unlit", Subject::Node(node), message)
        .with(Subject::Way(road.key.way), "road")
        .at(Place::Point(road.line.at(station)))
}

/// Why drivers have no lights at this node of a way.
fn no_room(way: i64, node: i64) -> String {
    format!("Way {way} has no room for stop lines before the lights at node {node}: its drivers have none.")
}

/// Notes of lights between intersections whose roads are too short for them.
fn left_out(network: &RoadNetwork, lines: &ConnectionLines) -> Vec<Finding> {
    let placed: FxHashSet<i64> = lines.crossings.iter().map(|crossing| crossing.node).collect();
    let mut notes = BTreeMap::new();
    for (ix, road) in RoadIx::all(network.roads.len()).zip(&network.roads) {
        for feature in &road.features {
            if matches!(feature.kind, FeatureKind::MidBlockSignals(_)) && !placed.contains(&feature.node) {
                let message = no_room(road.key.way, feature.node);
                notes.entry(feature.node).or_insert_with(|| unlit(network, ix, feature.node, feature.station, message));
            }
        }
    }
    notes.into_values().collect()
}

/// Draws the vehicle signals, and gives notes of roads and lanes that have no room for a stop line.
pub fn draw(
    assembly: &mut MapBuilder,
    network: &RoadNetwork,
    lines: &ConnectionLines,
    lanes: &Lanes,
    crossings: &[SignalisedCrossing],
) -> Vec<Finding> {
    let mut notes = left_out(network, lines);
    for crossing in crossings {
        let Some((piece, own)) = lanes.piece_at(crossing.road, crossing.middle()) else { continue };
        let gaps = [piece.span[1] - crossing.span[1], crossing.span[0] - piece.span[0]];
        for toward in End::BOTH.into_iter().filter(|toward| crossing.stops[*toward]) {
            let own: Vec<&RoadLane> = own.iter().filter(|lane| lane.backward == (toward == End::Start)).collect();
            if (GAP_LEAST..=2.0 * STOP_GAP_MOST).contains(&gaps[toward]) {
                draw_one_way(assembly, network, (crossing, toward), piece.span[toward.other()], &own);
            } else if !own.is_empty() {
                let (node, way) = (crossing.node, network.road(crossing.road).key.way);
                notes.push(unlit(network, crossing.road, node, crossing.middle(), no_room(way, node)));
            }
        }
    }
    notes
}

/// Draws the light for vehicles toward an end of a road, and a stop line and an element for each of their lanes. The light faces those
/// who wait at the stop line, at station `waiting_at`, metres.
fn draw_one_way(
    assembly: &mut MapBuilder,
    network: &RoadNetwork,
    (crossing, toward): (&SignalisedCrossing, End),
    waiting_at: f64,
    lanes: &[&RoadLane],
) {
    let road = network.road(crossing.road);
    let (Some(first), Some(last)) = (lanes.first(), lanes.last()) else { return };
    let forth = if toward == End::End { 1.0 } else { -1.0 };
    let station = crossing.span[toward] + BEHIND * forth;
    let along = road.line.direction(station);
    let middle = (road.section.edge(first.strip) + road.section.edge(last.strip + 1)) / 2.0;
    assembly.set_ground(Ground::under(road));
    let ahead = road.line.direction(waiting_at) * forth;
    let shape = LightShape::new(network.side, road.line.at(station) + left_of(along) * middle, ahead);
    let key = road.key_of("drive lights").number(crossing.node).number(toward.index() as i64);
    let light = add_light(assembly, key, &shape);
    for lane in lanes {
        let starts = [lane.left, lane.right].map(|bound| assembly.bound_ids(bound).first().copied());
        let [Some(left), Some(right)] = starts else { continue };
        let key = key.number(lane.lanelet.0);
        let line = stop_line(assembly, key, [left, right], PAINTED_LINE);
        light_element(assembly, key, light, line, &[lane.lanelet]);
    }
    assembly.set_ground(Ground::default());
}
