//! Lights for drivers where people cross a road between intersections and have lights: a stop line before the crosswalk on
//! each lane, and a light behind it for each direction.
//!
//! Where people have lights, drivers have some too, or nobody would stop for them. The road is cut at the stop lines, so
//! that the lights hang on the lanelets that begin there, as inside intersections.
//!
//! Where they cross so close to an intersection without lights that no vehicle can wait between, those on the road that
//! they cross stop before the intersection: it has lights for that road, and whoever has none gives way.

use crate::builder::lanes::road_cut::{
    CROSSWALK_BREADTH, ConnectionLines, RoadCrossing, STOP_GAP, STOP_GAP_MOST, VEHICLE, has_lights,
};
use crate::builder::lanes::types::{Lanes, RoadLane};
use crate::builder::layout::map_layout::IntersectionLanelets;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::{End, Intersection, RoadEnd, RoadIx, RoadNetwork};
use crate::builder::tags::road_class::DrivingSide;
use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::{angle_between, left_of};
use crate::lanelet::right_of_way::OPPOSITE;

use super::{BEHIND, Control, LightShape, add_light, light_element, sign_at, stop_line};

/// The least that lies between the stop line and the crosswalk, metres.
const GAP_LEAST: f64 = 0.5;
/// A crosswalk so near behind an intersection with lights, metres, belongs to these: whoever has left it need not stop again.
const BEHIND_LIGHTS: f64 = 30.0;
/// Between crosswalks that are less than this apart, metres, and their stop lines no vehicle can wait: one light holds it
/// before both.
const TOGETHER: f64 = 2.0 * STOP_GAP + VEHICLE;

/// A part of a road between intersections where people cross and have lights.
pub struct SignalisedCrossing {
    /// The road.
    pub road: RoadIx,
    /// The first crossing on it, an OpenStreetMap node.
    pub node: i64,
    /// From the begin of the first crosswalk to the end of the last along the road's line, metres.
    pub span: [f64; 2],
    /// Whether those who drive toward the start and toward the end of the road stop there.
    pub stops: [bool; 2],
}

/// Finds them, in order of roads and stations.
pub fn signalised_crossings(
    network: &RoadNetwork,
    lines: &ConnectionLines,
    ways: &[Option<Box<IntersectionLanelets>>],
) -> Vec<SignalisedCrossing> {
    let half = CROSSWALK_BREADTH / 2.0;
    let between = lines.crossings.iter().filter(|crossing| crossing.arm.is_none());
    let mut found: Vec<SignalisedCrossing> = Vec::new();
    for crossing in between.filter(|crossing| has_lights(network.road(crossing.road), crossing)) {
        let span = [crossing.station - half, crossing.station + half];
        match found.last_mut() {
            Some(last) if last.road == crossing.road && span[0] - last.span[1] < TOGETHER => last.span[1] = span[1],
            _ => found.push(SignalisedCrossing { road: crossing.road, node: crossing.node, span, stops: [true; 2] }),
        }
    }
    for lit in &mut found {
        let [start, end] = lines.kept[lit.road];
        let from = |end, driven| leaves_lights(network, lines, ways, RoadEnd { road: lit.road, end }, driven);
        lit.stops = [!from(End::End, end - lit.span[1]), !from(End::Start, lit.span[0] - start)];
    }
    found.retain(|lit| lit.stops != [false; 2]);
    found
}

/// Whether those who have come so far, metres, from the end of a road have left an intersection with lights close before.
fn leaves_lights(
    network: &RoadNetwork,
    lines: &ConnectionLines,
    ways: &[Option<Box<IntersectionLanelets>>],
    at: RoadEnd,
    driven: f64,
) -> bool {
    let mut open = vec![(at, driven)];
    while let Some((at, driven)) = open.pop() {
        let ix = network.road(at.road).intersection(at.end);
        let intersection = network.intersection(ix);
        let area = ways.get(ix.position()).and_then(|ways| ways.as_ref()?.area.as_ref());
        if driven > BEHIND_LIGHTS || area.is_some() && !intersection.signals {
            continue;
        }
        if area.is_some() {
            return true;
        }
        for before in intersection.arms.iter().filter(|before| before.road != at.road) {
            let [start, end] = lines.kept[before.road];
            open.push((RoadEnd { road: before.road, end: before.end.other() }, driven + end - start));
        }
    }
    false
}

/// The ends of roads, in order, whose drivers have lights at an intersection only because people have some there, and notes
/// of crossings where nothing tells that those who cross them go first.
pub fn guarded(
    network: &RoadNetwork,
    lines: &ConnectionLines,
    lanes: &Lanes,
    ways: &[Option<Box<IntersectionLanelets>>],
) -> (Vec<RoadEnd>, Vec<Finding>) {
    let mut of: Vec<Vec<(RoadEnd, &RoadCrossing)>> = vec![Vec::new(); network.intersections.len()];
    for crossing in lines.crossings.iter().filter(|crossing| has_lights(network.road(crossing.road), crossing)) {
        let Some(end) = crossing.arm else { continue };
        let ix = network.road(crossing.road).intersection(end);
        of[ix].push((RoadEnd { road: crossing.road, end }, crossing));
    }
    let (mut guarded, mut notes) = (Vec::new(), Vec::new());
    for ((intersection, ways), lit) in network.intersections.iter().zip(ways).zip(of) {
        if lit.is_empty() || intersection.signals {
            continue;
        }
        let arms: Vec<RoadEnd> = lit.iter().map(|(at, _)| *at).collect();
        let ruled = ways.as_ref().is_some_and(|ways| ways.area.is_some()) && !intersection.all_way_stop;
        match main_road(network, lanes, intersection, &arms).filter(|_| ruled) {
            Some(main) => guarded.extend(main),
            None => notes.extend(lit.iter().map(|(at, crossing)| unguarded(network, *at, crossing))),
        }
    }
    guarded.sort_unstable();
    (guarded, notes)
}

/// The arms where people cross and those that lead straight over into them, if they are the road that has priority.
fn main_road(
    network: &RoadNetwork,
    lanes: &Lanes,
    intersection: &Intersection,
    crossed: &[RoadEnd],
) -> Option<Vec<RoadEnd>> {
    let minor = |at: &RoadEnd| {
        let road = network.road(at.road);
        !road.public || matches!(sign_at(road, at.end), Control::Stop | Control::GiveWay)
    };
    let straight = |a: &RoadEnd, b: &RoadEnd| {
        let bend = angle_between(lanes.arm(*a).inward, -lanes.arm(*b).inward).abs();
        a != b && bend <= OPPOSITE.to_radians()
    };
    let leads_over = |at: &RoadEnd| crossed.iter().any(|on| straight(at, on));
    let on_it = |at: &RoadEnd| crossed.contains(at) || leads_over(at) && !minor(at);
    let (main, others): (Vec<RoadEnd>, Vec<RoadEnd>) = intersection.arms.iter().partition(|at| on_it(at));
    let class = |at: &RoadEnd| network.road(at.road).class;
    let lowest = crossed.iter().map(class).max()?;
    // Of equal roads that which goes on where the other ends.
    let through = main.len() == 2 && others.len() == 1;
    let below = |at: &RoadEnd| minor(at) || class(at) > lowest || class(at) == lowest && through;
    (!crossed.iter().any(minor) && others.iter().all(below)).then_some(main)
}

fn unguarded(network: &RoadNetwork, at: RoadEnd, crossing: &RoadCrossing) -> Finding {
    let road = network.road(at.road);
    let [node, way] = [crossing.node, road.key.way];
    let message = format!(
        "People have lights at node {node}, but the intersection beside it has none, and way {way} has no priority there: \
         its drivers have none."
    );
    Finding::new("crossing-unlit", Subject::Node(node), message)
        .with(Subject::Way(way), "road")
        .at(Place::Point(road.line.at(crossing.station)))
}

/// Draws the lights, and gives notes of lanes that have no room for a stop line.
pub fn draw(
    assembly: &mut MapBuilder,
    network: &RoadNetwork,
    lanes: &Lanes,
    driving: DrivingSide,
    lit: &[SignalisedCrossing],
) -> Vec<Finding> {
    let mut notes = Vec::new();
    for lit in lit {
        let Some((piece, own)) = lanes.piece_at(lit.road, (lit.span[0] + lit.span[1]) / 2.0) else { continue };
        let gaps = [piece.span[1] - lit.span[1], lit.span[0] - piece.span[0]];
        for toward in End::BOTH.into_iter().filter(|toward| lit.stops[*toward]) {
            let own: Vec<&RoadLane> = own.iter().filter(|lane| lane.backward == (toward == End::Start)).collect();
            if (GAP_LEAST..=2.0 * STOP_GAP_MOST).contains(&gaps[toward]) {
                draw_one_way(assembly, network, driving, (lit, toward), &own);
            } else if !own.is_empty() {
                notes.push(note(network, lit));
            }
        }
    }
    notes
}

fn note(network: &RoadNetwork, lit: &SignalisedCrossing) -> Finding {
    let road = network.road(lit.road);
    let [node, way] = [lit.node, road.key.way];
    let message = format!(
        "Way {way} has no room for stop lines before node {node}, where people have lights: its drivers have none."
    );
    Finding::new("crossing-unlit", Subject::Node(node), message)
        .with(Subject::Way(way), "road")
        .at(Place::Point(road.line.at((lit.span[0] + lit.span[1]) / 2.0)))
}

/// Draws the light of those who drive toward an end of a road, and a stop line and an element for each of their lanes.
fn draw_one_way(
    assembly: &mut MapBuilder,
    network: &RoadNetwork,
    driving: DrivingSide,
    (lit, toward): (&SignalisedCrossing, End),
    lanes: &[&RoadLane],
) {
    let road = network.road(lit.road);
    let (Some(first), Some(last)) = (lanes.first(), lanes.last()) else { return };
    let forth = if toward == End::End { 1.0 } else { -1.0 };
    let station = lit.span[toward] + BEHIND * forth;
    let along = road.line.direction(station);
    let middle = (road.section.edge(first.strip) + road.section.edge(last.strip + 1)) / 2.0;
    assembly.set_ground(crate::builder::streets::heights::Ground::under(road));
    let shape = LightShape::new(driving, road.line.at(station) + left_of(along) * middle, along * forth);
    let key = road.key_of("drive lights").number(lit.node).number(toward.index() as i64);
    let light = add_light(assembly, key, &shape);
    for lane in lanes {
        let starts = [lane.left, lane.right].map(|bound| assembly.bound_ids(bound).first().copied());
        let [Some(left), Some(right)] = starts else { continue };
        let key = key.number(lane.lanelet.0);
        let line = stop_line(assembly, key, [left, right]);
        light_element(assembly, key, light, line, &[lane.lanelet]);
    }
    assembly.set_ground(crate::builder::streets::heights::Ground::default());
}
