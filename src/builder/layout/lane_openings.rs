//! Where a road goes on with two or more lanes more than before, or fewer: they open, or close, one after another.

use std::ops::Range;

use rustc_hash::FxHashSet;

use crate::builder::network::{End, Road, RoadEnd, RoadKey, RoadNetwork};
use crate::builder::streets::lane_opening::LaneOpening;
use crate::builder::tags::cross_section::{StripKind, Travel};
use crate::builder::tags::road_class::DrivingSide;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::left_of;

use super::lane_drops::{LENGTH, place_to_change_lanes};
use super::map_layout::Layout;

/// A lane opens over at least this length, metres: six times its width.
const LEAST: f64 = 20.0;
/// Blocks of lanes lie equally straight ahead if they differ by less than this, metres.
const EQUALLY_AHEAD: f64 = 0.5;

/// The ends of roads where lanes are closed, so that only one more begins, or ends, at a place; at most one end of each road.
pub fn lane_openings(layout: &Layout) -> Vec<LaneOpening> {
    let joints = layout.network.intersections.iter().filter_map(|at| <[RoadEnd; 2]>::try_from(&at.arms[..]).ok());
    let pairs = joints.flat_map(|[a, b]| [(a, b), (b, a)]);
    let mut roads = FxHashSet::default();
    pairs.filter_map(|(narrow, wide)| opening(layout, narrow, wide)).filter(|one| roads.insert(one.at.road)).collect()
}

/// The note that a road begins, or ends, with fewer lanes than its way has.
pub fn closed_lanes(network: &RoadNetwork, opening: &LaneOpening) -> Finding {
    let RoadKey { way, first, last, .. } = network.road(opening.at.road).key;
    let node = network.intersection(network.intersection_at(opening.at)).first_node();
    let count = opening.closed.len();
    let lanes = if count == 1 { "one lane less".to_owned() } else { format!("{count} lanes less") };
    let message = format!(
        "way {way} between nodes {first} and {last} has {lanes} over {:.0} m from node {node}: its lanes open or close one after another",
        opening.length
    );
    Finding::new("lanes-closed", Subject::Way(way), message).graded(Severity::Info)
}

/// The lanes that are closed at the end of a wide road where it meets a narrow one. Nothing is closed where the map tells which lanes
/// lead to which.
fn opening(layout: &Layout, narrow: RoadEnd, wide: RoadEnd) -> Option<LaneOpening> {
    let told =
        [[narrow, wide], [wide, narrow]].iter().any(|[from, to]| layout.restrictions.lanes(*from, *to).is_some());
    if narrow.road == wide.road || told {
        return None;
    }
    let away = |end: End| end.other().inbound();
    let both = [(narrow.end.inbound(), away(wide.end)), (away(narrow.end), wide.end.inbound())];
    both.into_iter().find_map(|travels| opening_of(layout, [narrow, wide], travels))
}

/// The same for one direction of travel, which is `before` along the narrow road and `behind` along the wide one.
fn opening_of(
    layout: &Layout,
    [narrow, wide]: [RoadEnd; 2],
    (before, behind): (Travel, Travel),
) -> Option<LaneOpening> {
    let network = &layout.network;
    let [few, road] = [narrow, wide].map(|at| network.road(at.road));
    let (first, lanes) = (car_lanes(few, before)?, car_lanes(road, behind)?);
    let (fewer, more) = (first.len(), lanes.len());
    if fewer == 0 || more < fewer + 2 {
        return None;
    }
    let piece = LENGTH.min(layout.left(wide.road) / (more - fewer) as f64);
    let length = place_to_change_lanes(layout, wide, piece).filter(|_| piece >= LEAST)?;
    let block = match road.one_way() {
        Some(_) => straightest_block(network.side, (few, narrow.end, &first, before), (road, wide.end, &lanes, behind)),
        // The lanes of the other direction stay where they are: the outer ones open.
        None if outer_is_last(network.side, behind) => 0..fewer + 1,
        None => more - fewer - 1..more,
    };
    let closed = lanes.iter().enumerate().filter(|(i, _)| !block.contains(i)).map(|(_, lane)| *lane).collect();
    Some(LaneOpening { at: wide, closed, stays: *lanes.get(block.start)?, length })
}

/// The lanes of one direction, in order; `None` if some are for buses only.
fn car_lanes(road: &Road, travel: Travel) -> Option<Vec<usize>> {
    let own: Vec<_> = road.section.driven().filter(|(_, strip)| strip.travel == travel).collect();
    own.iter().all(|(_, strip)| strip.kind == StripKind::Drive).then(|| own.iter().map(|(lane, _)| *lane).collect())
}

/// Whether the outer lane of a direction is the last one along the line of its road.
fn outer_is_last(side: DrivingSide, travel: Travel) -> bool {
    (travel == Travel::Forward) == (side == DrivingSide::Right)
}

/// A road, its end at the joint, its lanes, and their direction.
type Lanes<'a> = (&'a Road, End, &'a [usize], Travel);

/// Of the blocks of one lane more than a narrow road has, the one of a wide road that lies straight ahead; of two the inner one.
fn straightest_block(side: DrivingSide, few: Lanes, wide: Lanes) -> Range<usize> {
    let (road, end, lanes, travel) = wide;
    let size = few.2.len() + 1;
    let ahead = middle(few);
    let station = if end == End::Start { 0.0 } else { road.line.length() };
    let along = road.line.direction(station) * if travel == Travel::Forward { 1.0 } else { -1.0 };
    let [a, b] =
        [few, wide].map(|(road, end, ..)| road.line.at(if end == End::Start { 0.0 } else { road.line.length() }));
    let shift = (b - a).dot(&left_of(along));
    let aside = |start: &usize| {
        let block = lanes.get(*start..*start + size).unwrap_or_default();
        (middle((road, end, block, travel)) + shift - ahead).abs()
    };
    let starts = 0..=lanes.len() - size;
    let least = starts.clone().map(|start| aside(&start)).fold(f64::INFINITY, f64::min);
    let mut straight = starts.filter(|start| aside(start) < least + EQUALLY_AHEAD);
    let start = if outer_is_last(side, travel) { straight.next() } else { straight.next_back() };
    let start = start.unwrap_or_default();
    start..start + size
}

/// The middle of some lanes: how far, metres, it lies to the left of the line of the road as they lead along it.
fn middle((road, _, lanes, travel): Lanes) -> f64 {
    let [Some(first), Some(last)] = [lanes.first(), lanes.last()] else { return 0.0 };
    let aside = (road.section.edge(*first) + road.section.edge(*last + 1)) / 2.0;
    if travel == Travel::Forward { aside } else { -aside }
}
