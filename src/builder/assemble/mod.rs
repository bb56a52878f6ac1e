//! From roads and outlines to the whole map: lanes, then each intersection with everything that belongs to it.

pub mod intersection_settings;
mod right_of_way;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::Point;
use crate::lanelet::{Attributes, LaneletId, LaneletMap, PointId, TurnDirection};
use crate::parallel::Finely;
use crate::settings::{BicycleLanes, IntersectionSettings, Settings, Side};

use super::control::crosswalk::{announce, crosswalk};
use super::control::pedestrian_signals::pedestrian_signals;
use super::control::signal_arrows::{SignalArrows, one_way};
use super::control::stop_line_segments::split_before_stop_lines;
use super::control::walkway::walkways;
use super::control::{Approach, Control, ControlledArm, pedestrian_crossing_signals};
use super::intersection::area::AreaOutline;
use super::intersection::bicycle_lanelets::BicycleMovements;
use super::intersection::conflict;
use super::intersection::conflict::Conflicts;
use super::intersection::movement_types::{Movement, Movements};
use super::intersection::turning_lanelets::{
    DrawnMovements, IntersectionPaint, TurningLanelet, intersection_key, paint,
};
use super::lanes::road_cut::{ConnectionLines, RoadCrossing};
use super::lanes::side_lanes::side_lanes;
use super::lanes::types::{Arm, Lanes};
use super::layout::layout_loop::Layout;
use super::layout::map_layout::{IntersectionLanelets, MapLayout};
use super::map::map_builder::{MapBuilder, MapPart, PartialMaps};
use super::network::turn::STRAIGHT;
use super::network::{Intersection, RoadEnd, RoadIx, RoadNetwork};
use super::streets::heights::Ground;
use super::tags::cross_section::StripKind;
use super::tags::road_class::DrivingSide;

/// A map in local metres, without longitude and latitude.
#[derive(Debug, Default)]
pub struct Assembled {
    /// The map.
    pub map: LaneletMap,
    /// What it cannot say itself.
    pub settings: Settings,
    /// What could not be built as it should.
    pub notes: Vec<Finding>,
    /// Number of `intersection_area`s.
    pub areas: usize,
    /// Number of roads between intersections.
    pub roads: usize,
}

/// What is told of one intersection beside the map.
#[derive(Default)]
struct IntersectionOutput {
    notes: Vec<Finding>,
    intersections: Vec<IntersectionSettings>,
    bicycle_lanes: Vec<i64>,
    areas: usize,
}

/// Intersections that are made before they are added to the map.
const BATCH: usize = 128;

/// Builds the map.
pub fn assemble(settled: Layout, arrows: &SignalArrows) -> Assembled {
    let Layout { network, restricted, draft, notes } = settled;
    let settled = network;
    let network = &settled;
    // Moved, so that what is not asked for any more goes at once.
    let MapLayout { lines, mut assembly, lanes, ways, .. } = { draft };
    let lit = pedestrian_crossing_signals::signalised_crossings(network, &lines, &ways);
    let (guarded, unguarded) = pedestrian_crossing_signals::guarded(network, &lines, &lanes, &ways);
    let lanes = split_before_stop_lines(&mut assembly, network, &lines, &ways, (&lit, &guarded), lanes);
    let as_roads = network.beside.bicycle_lanes == BicycleLanes::Road;
    let bicycles = side_lanes(&mut assembly, network, &lanes);
    let (crossings, idle) = Crossings::add(&mut assembly, network, &lines, &lanes, &ways);
    let unlit = pedestrian_crossing_signals::draw(&mut assembly, network, &lanes, network.side, &lit);
    let mut whole = Assembled { notes, roads: network.roads.len(), ..Assembled::default() };
    whole.settings.driving_side = Some(if network.side == DrivingSide::Left { Side::Left } else { Side::Right });
    whole.notes.extend(unlit.into_iter().chain(unguarded).chain(idle));
    if as_roads {
        whole.settings.bicycle_lanes = bicycles.iter().map(|lanelet| lanelet.0).collect();
    }
    let made = |below: &MapBuilder, intersection: &Intersection, ways: IntersectionLanelets| {
        let mut assembly = MapBuilder::resume(below, ways.part);
        assembly.set_ground(lanes.ground_of(intersection, below));
        let beside = IntersectionOutput::default();
        let cycling = ways.cycles;
        let mut stage = Stage {
            network,
            lanes: &lanes,
            crossings: &crossings,
            guarded: &guarded,
            arrows,
            assembly,
            beside,
            cycling,
            as_roads,
        };
        stage.intersection(intersection, &ways.plan, &ways.drawn, &ways.conflicts.unwrap_or_default(), ways.area);
        (stage.assembly.into_part(), stage.beside)
    };
    let passed = network.intersections.iter().zip(ways).filter_map(|(at, ways)| Some((at, ways?)));
    let passed: Vec<(&Intersection, Box<IntersectionLanelets>)> = passed.collect();
    assembly.compact();
    let passing: Vec<&Intersection> = passed.iter().map(|(at, _)| *at).collect();
    let mut parts = PartialMaps::over(&assembly, passed.iter().map(|(_, ways)| &ways.part));
    let mut all_beside: Vec<IntersectionOutput> = Vec::with_capacity(passed.len());
    let mut passed = passed.into_iter();
    let mut ready: Vec<(MapPart, IntersectionOutput)> = Vec::new();
    loop {
        let batch: Vec<(&Intersection, Box<IntersectionLanelets>)> = passed.by_ref().take(BATCH).collect();
        let done = batch.is_empty();
        let add = |(part, beside)| {
            parts.add(part);
            all_beside.push(beside);
        };
        let (next, ()) = rayon::join(
            || batch.into_par_iter().finely().map(|(at, ways)| made(&assembly, at, *ways)).collect(),
            || std::mem::take(&mut ready).into_iter().for_each(add),
        );
        ready = next;
        if done {
            break;
        }
    }
    let apart = parts.are_apart_from(&assembly);
    whole.map = if apart {
        // A whole map takes the most memory of all that is made: what it was made from need not stand beside it.
        drop(passing);
        let done = (crossings, lanes, lines, settled);
        rayon::join(|| assembly.finish(parts), || drop(done)).0
    } else {
        assembly.require_unique_ids();
        for ((&at, part), beside) in passing.iter().zip(parts.split()).zip(&mut all_beside) {
            if assembly.add(part).is_err() {
                // Something added before has taken one of its ids: it is made once more, over all that stands.
                let ways = IntersectionLanelets::draw(network, &restricted, &lanes, at, &assembly);
                let again = made(&assembly, at, ways.outlined(network, &restricted, &lanes, at, &assembly));
                *beside = again.1;
                let _ = assembly.add(again.0);
            }
        }
        assembly.into_map()
    };
    for mut beside in all_beside {
        whole.notes.append(&mut beside.notes);
        whole.settings.intersection.append(&mut beside.intersections);
        whole.settings.bicycle_lanes.append(&mut beside.bicycle_lanes);
        whole.areas += beside.areas;
    }
    whole
}

/// Crosswalks, found by road.
#[derive(Default)]
struct Crossings {
    of_road: FxHashMap<RoadIx, Vec<(RoadCrossing, LaneletId)>>,
}

impl Crossings {
    /// Adds the crosswalks over which somebody drives, and tells of the others; those over lanes that are there already are
    /// announced to them.
    fn add(
        assembly: &mut MapBuilder,
        network: &RoadNetwork,
        lines: &ConnectionLines,
        lanes: &Lanes,
        ways: &[Option<Box<IntersectionLanelets>>],
    ) -> (Self, Vec<Finding>) {
        let (mut all, mut left_out) = (Self::default(), Vec::new());
        for crossing in &lines.crossings {
            let road = network.road(crossing.road);
            let at = crossing.arm.map(|end| (RoadEnd { road: crossing.road, end }, road.intersection(end)));
            let passed = at.map(|(at, ix)| (at, network.intersection(ix), ways[ix].as_deref()));
            if let Some((at, intersection, Some(ways))) = passed
                && !ways.lead_over(intersection, at, network.beside.bicycle_lanes)
            {
                left_out.push(idle(crossing, network));
                continue;
            }
            assembly.set_ground(match passed {
                Some((_, intersection, _)) => lanes.ground_of(intersection, assembly),
                None => Ground::under(road),
            });
            let cuts: Vec<PointId> = lanes.arms[crossing.road].iter().flat_map(|arm| &arm.cut).copied().collect();
            let id = crosswalk(assembly, road, crossing, &cuts);
            pedestrian_signals(assembly, road, crossing, id);
            // Where two roads go on as one, the lanes do.
            let over: Vec<RoadIx> = match passed {
                Some((_, _, Some(_))) => Vec::new(),
                Some((_, intersection, None)) => intersection.arms.iter().map(|arm| arm.road).collect(),
                None => vec![crossing.road],
            };
            let over = over.into_iter().flat_map(|road| lanes.of_road(road)).map(|lane| lane.lanelet);
            let over: Vec<(LaneletId, Vec<Point>)> = over.map(|lane| (lane, assembly.outline(lane))).collect();
            announce(assembly, id, over.iter().map(|(id, outline)| (*id, &outline[..])));
            all.of_road.entry(crossing.road).or_default().push((crossing.clone(), id));
        }
        assembly.set_ground(Ground::default());
        (all, left_out)
    }
}

/// A crosswalk over the end of a road from which nobody drives on, and to which nobody comes.
fn idle(crossing: &RoadCrossing, network: &RoadNetwork) -> Finding {
    let road = network.road(crossing.road);
    let (node, way) = (crossing.node, road.key.way);
    let message = format!("Nobody drives over the crosswalk at node {node} of way {way}: it is left out.");
    let finding = Finding::new("crosswalk-idle", Subject::Node(node), message).graded(Severity::Info);
    finding.with(Subject::Way(way), "road").at(Place::Point(road.line.at(crossing.station)))
}

/// One intersection: what is built of it so far, and what it is built from.
struct Stage<'a> {
    network: &'a RoadNetwork,
    lanes: &'a Lanes,
    crossings: &'a Crossings,
    arrows: &'a SignalArrows,
    /// The ends of roads that have lights because people have some there, in order.
    guarded: &'a [RoadEnd],
    assembly: MapBuilder<'a>,
    /// All but the map.
    beside: IntersectionOutput,
    /// Its lanes for bicycles.
    cycling: BicycleMovements,
    /// Whether these are written as roads, which others watch and yield to.
    as_roads: bool,
}

impl Stage<'_> {
    fn intersection(
        &mut self,
        intersection: &Intersection,
        plan: &Movements,
        drawn: &DrawnMovements,
        conflicts: &Conflicts,
        area: Option<AreaOutline>,
    ) {
        let lanes = self.lanes;
        let arms: Vec<&Arm> = intersection.arms.iter().map(|&at| lanes.arm(at)).collect();
        let DrawnMovements { paths, dropped, .. } = drawn;
        self.note_dropped(intersection, dropped);
        if self.as_roads {
            self.beside.bicycle_lanes = self.cycling.paths.iter().map(|path| path.lanelet.0).collect();
        }
        self.note_closed(
            intersection,
            &arms,
            &paths.iter().map(|path| path.movement).chain(dropped.iter().copied()).collect::<Vec<_>>(),
        );
        self.announce_crosswalks(intersection, paths);
        self.walkways(intersection, paths);
        if let Some(area) = area {
            let prohibited = prohibited(plan, drawn, &arms);
            self.area(intersection, &arms, &prohibited, paths, conflicts, area);
        }
    }

    fn note_dropped(&mut self, intersection: &Intersection, dropped: &[Movement]) {
        for movement in dropped {
            let way = |arm: usize| self.network.road(intersection.arms[arm].road).key.way;
            let (from, to) = (way(movement.from), way(movement.to));
            let node = intersection.nodes.first().copied().unwrap_or_default();
            let message = format!("There is no room for a lane from way {from} to way {to} at node {node}.");
            let finding = Finding::new("movement-dropped", Subject::Node(node), message)
                .with(Subject::Way(from), "from")
                .with(Subject::Way(to), "to")
                .at(Place::Point(intersection.position));
            self.beside.notes.push(finding);
        }
    }

    /// Lanes that the input leaves no way into the intersection, or out of it.
    fn note_closed(&mut self, intersection: &Intersection, arms: &[&Arm], movements: &[Movement]) {
        let node = intersection.nodes.first().copied().unwrap_or_default();
        for (i, arm) in arms.iter().enumerate() {
            let way = self.network.road(arm.at.road).key.way;
            let led_on = |lane: usize| movements.iter().any(|m| (m.from, m.in_lane) == (i, lane));
            let led_to = |lane: usize| movements.iter().any(|m| (m.to, m.out_lane) == (i, lane));
            let ends = (0..arm.into.len()).filter(|&lane| !led_on(lane)).map(|_| "on from");
            let begins = (0..arm.out.len()).filter(|&lane| !led_to(lane)).map(|_| "to");
            for whither in ends.chain(begins) {
                let message =
                    format!("No road leads {whither} a lane of way {way} at node {node}: is a one-way missing?");
                let finding = Finding::new("lane-closed", Subject::Way(way), message);
                self.beside
                    .notes
                    .push(finding.with(Subject::Node(node), "there").at(Place::Point(intersection.position)));
            }
        }
    }

    /// Everything that makes crossing lanelets an intersection for Autoware.
    fn area(
        &mut self,
        intersection: &Intersection,
        arms: &[&Arm],
        prohibited: &[(usize, usize)],
        paths: &[TurningLanelet],
        conflicts: &Conflicts,
        outline: AreaOutline,
    ) {
        self.beside.areas += 1;
        let key = intersection_key("intersection area", intersection);
        let id = self.assembly.polygon_id(key);
        let ring = outline.places;
        self.assembly.polygon(id, outline.ring, Attributes::of(&[("type", "intersection_area"), ("area", "yes")]));
        for arm in outline.lost {
            let cut = arms[arm].cut.iter().map(|&node| self.assembly.position(node)).collect();
            let message = format!("The outline of intersection area {id} does not lead along the end of a road.");
            let finding = Finding::new("lane-end-inside", Subject::Polygon(id.0), message);
            self.beside.notes.push(finding.at(Place::Line(cut)));
        }
        for way in outline.covered {
            let message = format!(
                "Intersection area {id} covers the island of way {way}: it lies wholly inside, and an area has no holes, or \
                 ways run over it."
            );
            let finding = Finding::new("island-covered", Subject::Polygon(id.0), message).graded(Severity::Info);
            self.beside.notes.push(finding.with(Subject::Way(way), "island"));
        }
        let cycling = std::mem::take(&mut self.cycling);
        let (name, painted) = (id.0.to_string(), paint(intersection) != IntersectionPaint::None);
        for path in paths.iter().chain(&cycling.paths) {
            self.tag_path(path, &name);
            // Nothing is painted across an intersection, not even where two roads only merge lanes.
            for line in path.bounds.into_iter().filter(|_| painted) {
                self.assembly.retag_line(line, Attributes::of(&[("type", "virtual")]));
            }
        }
        // Only what is a road is watched, has lights, and is yielded to.
        let (with, across);
        let (paths, conflicts) = match self.as_roads && !cycling.paths.is_empty() {
            true => {
                with = [paths, &cycling.paths].concat();
                across = conflict::conflicts(&with, &conflict::strip_indices(&with));
                (&with[..], &across)
            }
            false => (paths, conflicts),
        };
        let controls = self.controls(intersection, arms);
        let arrows = self.arrows.are_at(id, &ring);
        for (i, arm) in arms.iter().enumerate() {
            let starts =
                |path: &TurningLanelet| (path.movement.from, path.movement.in_lane, path.kind == StripKind::Bicycle);
            let from = |lane: usize| move |path: &&TurningLanelet| starts(path) == (i, lane, false);
            let mut approaches: Vec<Approach> = (arm.into.iter().enumerate())
                .map(|(lane, before)| Approach {
                    lane: self.lanes.lanes[before.lane].lanelet,
                    behind: paths.iter().filter(from(lane)).map(|path| path.lanelet).collect(),
                    arrow: arrows.then(|| one_way(paths.iter().filter(from(lane)).map(direction))).flatten(),
                })
                .collect();
            let mut arm = (*arm).clone();
            for (lane, end) in cycling.ends.into_of(i).filter(|_| self.as_roads && controls[i] != Control::Stop) {
                let behind = paths.iter().filter(|path| starts(path) == (i, lane, true));
                let behind: Vec<LaneletId> = behind.map(|path| path.lanelet).collect();
                let Some(&lane) = behind.first() else { continue };
                arm.into.push(*end);
                approaches.push(Approach { lane, behind, arrow: None });
            }
            let key = key.word("arm");
            let (control, driving) = (controls[i], self.network.side);
            let controlled = ControlledArm { arm: &arm, control, approaches: &approaches, driving };
            controlled.draw(&mut self.assembly, key, &ring);
        }
        let legs = self.legs(arms);
        let movers = self.movers(arms, paths, &controls, &legs);
        self.rights_of_way(&legs, paths, &movers, conflicts);
        let names = intersection_settings::names(arms, self.lanes);
        self.beside.intersections.extend(intersection_settings::settings(id, &names, prohibited, &movers));
    }

    fn tag_path(&mut self, path: &TurningLanelet, area: &str) {
        let Some(attributes) = self.assembly.attributes_mut(path.lanelet) else { return };
        attributes.set("turn_direction", direction(path).as_str());
        attributes.set("intersection_area", area);
    }

    fn walkways(&mut self, intersection: &Intersection, paths: &[TurningLanelet]) {
        if !self.network.beside.walkways {
            return;
        }
        let crossings = self.crossings;
        let crossed = |at: RoadEnd| {
            let of_road = crossings.of_road.get(&at.road).map_or(&[][..], |c| c);
            of_road.iter().any(|(crossing, _)| crossing.arm == Some(at.end))
        };
        walkways(&mut self.assembly, self.network, self.lanes, intersection, crossed, paths);
    }

    fn announce_crosswalks(&mut self, intersection: &Intersection, paths: &[TurningLanelet]) {
        let as_roads = self.as_roads;
        for &at in &intersection.arms {
            let crossings = self.crossings;
            for (crossing, id) in crossings.of_road.get(&at.road).map_or(&[][..], |c| c) {
                if crossing.arm == Some(at.end) {
                    let cycles = self.cycling.paths.iter().filter(|_| as_roads);
                    let all = paths.iter().chain(cycles);
                    let all: Vec<_> = all.map(|p| (p.lanelet, self.assembly.outline(p.lanelet))).collect();
                    announce(&mut self.assembly, *id, all.iter().map(|(lanelet, outline)| (*lanelet, &outline[..])));
                }
            }
        }
    }
}

/// Which way a movement goes.
fn direction(path: &TurningLanelet) -> TurnDirection {
    match path.turn {
        turn if turn.abs() <= STRAIGHT => TurnDirection::Straight,
        turn if turn > 0.0 => TurnDirection::Left,
        _ => TurnDirection::Right,
    }
}

/// Pairs of arms between which there is no movement: those that must not be, and, where there is no room for it, the way
/// once more around a loop.
fn prohibited(plan: &Movements, drawn: &DrawnMovements, arms: &[&Arm]) -> Vec<(usize, usize)> {
    let is_drawn = |pair: (usize, usize)| drawn.paths.iter().any(|it| (it.movement.from, it.movement.to) == pair);
    let dropped = drawn.dropped.iter().map(|it| (it.from, it.to));
    let around = dropped.filter(|&(from, to)| arms[from].at.road == arms[to].at.road && !is_drawn((from, to)));
    let mut all: Vec<(usize, usize)> = plan.prohibited.iter().copied().chain(around).collect();
    all.sort_unstable();
    all.dedup();
    all
}
