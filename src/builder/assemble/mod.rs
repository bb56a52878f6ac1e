//! From roads and outlines to the whole map: lanes, then each intersection with everything that belongs to it.

mod crossings;
mod intersection;
pub mod intersection_settings;
mod loose_ends;
mod map_context;
mod ranked_movements;
pub(crate) mod right_of_way_elements;
mod roundabouts;
mod waiting;

use crate::diagnostic::Finding;
use crate::geometry::Point;
use crate::lanelet::LaneletMap;
use crate::settings::{BicycleLanes, Settings, Side};

use super::control::mid_block_signals;
use super::control::signal_arrows::SignalArrows;
use super::control::stop_line_segments::split_before_stop_lines;
use super::lanes::side_lanes::side_lanes;
use super::layout::map_layout::{IntersectionLanelets, Layout};
use super::map::map_builder::{MapBuilder, MapPart};
use super::network::Intersection;
use super::tags::road_class::DrivingSide;
use crossings::Crossings;
use intersection::{IntersectionAssembly, IntersectionOutput};
use loose_ends::LooseLanes;
use map_context::MapContext;
use roundabouts::RoundaboutElements;

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

/// Builds the map.
pub fn assemble(layout: Layout, arrows: &SignalArrows) -> Assembled {
    // By value, so that memory is freed as soon as a part is not needed.
    let Layout { network: owned_network, lines, mut assembly, lanes, turning, .. } = { layout };
    let network = &owned_network;
    let lit = mid_block_signals::signalised_crossings(network, &lines, &turning);
    let (guarded, unguarded) = mid_block_signals::guarded(network, &lines, &lanes, &turning);
    let lanes = split_before_stop_lines(&mut assembly, network, &lines, &turning, (&lit, &guarded), lanes);
    let as_roads = network.beside.bicycle_lanes == BicycleLanes::Road;
    let bicycles = side_lanes(&mut assembly, network, &lanes, |assembly| turning_bounds(assembly, &turning));
    let (crossings, idle) = Crossings::add(&mut assembly, network, &lines, &lanes, &turning);
    let unlit = mid_block_signals::draw(&mut assembly, network, &lines, &lanes, &lit);
    let roundabouts = &network.whole_roundabouts();
    let mut rings = RoundaboutElements::add(&mut assembly, network, roundabouts, &lanes, &turning);
    let mut whole = Assembled { roads: network.roads.len(), ..Assembled::default() };
    whole.settings.driving_side = Some(if network.side == DrivingSide::Left { Side::Left } else { Side::Right });
    whole.notes.extend(unlit.into_iter().chain(unguarded).chain(idle).chain(rings.note.take()));
    if as_roads {
        whole.settings.bicycle_lanes = bicycles.iter().map(|lanelet| lanelet.0).collect();
    }
    let context =
        MapContext { network, roundabouts, lanes: &lanes, crossings: &crossings, arrows, guarded: &guarded, as_roads };
    let dead_ends = LooseLanes::of_dead_ends(&context);
    let passed = network.intersections.iter().zip(turning).filter_map(|(at, turning)| Some((at, turning?)));
    let (passed, turning): (Vec<&Intersection>, Vec<Box<IntersectionLanelets>>) = passed.unzip();
    let finish = |(at, turning): (&Intersection, Box<IntersectionLanelets>)| {
        IntersectionAssembly::finish(&context, &assembly, at, *turning)
    };
    let room = MapPart::with_room(&assembly, turning.iter().map(|turning| &turning.part));
    let (parts, outputs) = room.filled(passed.into_iter().zip(turning), finish);
    // The whole map takes the most memory, so everything that it was made from is freed meanwhile.
    let done = (crossings, lanes, lines, owned_network);
    whole.map = rayon::join(|| assembly.finish(parts), || drop(done)).0;
    rings.attach_to(&mut whole.map);
    whole.notes.extend(dead_ends.notes);
    whole.settings.loose_ends = dead_ends.lanelets;
    for IntersectionOutput { notes, settings, bicycle_lanes, has_area, loose_ends } in outputs {
        whole.notes.extend(notes);
        whole.settings.loose_ends.extend(loose_ends);
        whole.settings.intersection.extend(settings);
        whole.settings.bicycle_lanes.extend(bicycle_lanes);
        whole.areas += usize::from(has_area);
    }
    whole
}

/// The bounds of all lanelets in intersections.
fn turning_bounds(assembly: &MapBuilder, turning: &[Option<Box<IntersectionLanelets>>]) -> Vec<Vec<Point>> {
    let bounds = |one: &IntersectionLanelets| {
        let lines = one.drawn.paths.iter().flat_map(|path| path.bounds);
        lines.map(|line| one.part.line_places(assembly, line)).collect::<Vec<_>>()
    };
    turning.iter().flatten().flat_map(|one| bounds(one)).collect()
}
