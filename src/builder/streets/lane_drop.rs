//! Lane drops: a road begins with more lanes than it has farther on, so that as many lanes lead on behind an intersection as before
//! it, and merge where no other traffic crosses.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::builder::ids::Key;
use crate::builder::network::{End, Feature, Road, RoadEnd, RoadKey, RoadNetwork, Stations};
use crate::builder::tags::cross_section::{Strip, StripKind};
use crate::builder::tags::road_class::DrivingSide;
use crate::geometry::{Point, Polyline};

use super::alignment::straight_where;
use super::consolidate::network_edit::NetworkEdit;

/// Corners of a line that is moved sideways are mitred up to this many times the distance.
pub(super) const MITER_LIMIT: f64 = 2.0;

/// More lanes at one end of a road.
#[derive(Clone, Copy, Debug)]
pub struct LaneDrop {
    /// The end of the road where they lead away from an intersection.
    pub at: RoadEnd,
    /// The number of additional lanes.
    pub lanes: usize,
    /// Where they end: distance along the road's line from this end, metres.
    pub length: f64,
}

impl LaneDrop {
    /// How far the widened road reaches to the left of its present line, and to the right (negative), metres.
    pub fn reaches(&self, road: &Road, side: DrivingSide) -> [f64; 2] {
        let half = road.half_width();
        let more = outer_lane(road, side, self.at.end).map_or(0.0, |(_, lane)| lane.width) * self.lanes as f64;
        match (road.one_way(), outer_is_last(side, self.at.end)) {
            (Some(_), _) => [half + more / 2.0, -half - more / 2.0],
            (None, true) => [half, -half - more],
            (None, false) => [half + more, -half],
        }
    }
}

/// Whether the outer lane of those that lead away from an end of a road is the last one along its line.
fn outer_is_last(side: DrivingSide, end: End) -> bool {
    (end == End::Start) == (side == DrivingSide::Right)
}

/// The index of the outer lane of those that lead away from an end of a road, and the lane.
fn outer_lane(road: &Road, side: DrivingSide, end: End) -> Option<(usize, &Strip)> {
    let is_lane = |strip: &(usize, &Strip)| strip.1.kind == StripKind::Drive && strip.1.travel == end.other().inbound();
    let mut lanes = road.section.strips.iter().enumerate().filter(is_lane);
    if outer_is_last(side, end) { lanes.next_back() } else { lanes.next() }
}

/// The network with more lanes at the ends of some roads, each of which is divided where they end. `kept` are the stations between
/// which the outlines leave each road; those of the result are returned, too. At most one drop is made for each road.
#[must_use]
pub fn with_lane_drops(network: RoadNetwork, kept: &[Stations], drops: &[LaneDrop]) -> (RoadNetwork, Vec<Stations>) {
    let side = network.side;
    let changes = drops.iter().map(|drop| ((drop.at, drop.length), move |road: &mut Road| widen(road, side, drop)));
    let named = |road: &Road, end: End| (road.key.way, road.node(end));
    let widened: FxHashSet<(i64, i64)> =
        drops.iter().map(|drop| named(network.road(drop.at.road), drop.at.end)).collect();
    let (network, kept) = with_other_ends(network, kept, changes);
    (straight_where(network, |road, end| widened.contains(&named(road, end))), kept)
}

/// The network in which the ends of some roads over a length, metres, are roads of their own, and changed. `kept` as in
/// [`with_lane_drops`]. At most one end of each road is changed.
pub(super) fn with_other_ends<F: Fn(&mut Road) -> Option<()>>(
    network: RoadNetwork,
    kept: &[Stations],
    changes: impl Iterator<Item = ((RoadEnd, f64), F)>,
) -> (RoadNetwork, Vec<Stations>) {
    let mut stations: FxHashMap<RoadKey, Stations> =
        network.roads.iter().map(|road| road.key).zip(kept.iter().copied()).collect();
    let mut edit = NetworkEdit::new(network);
    for ((at, near), change) in changes {
        let road = edit.road(at.road);
        let Some((position, pieces)) = divided(road, (at.end, near), change) else { continue };
        let cut = kept.get(at.road.position()).copied().unwrap_or([0.0, road.line.length()]);
        let behind = road.line.length() - cut[1];
        let [first, second] = pieces.each_ref().map(|piece| (piece.key, piece.line.length()));
        let node = first.0.last;
        stations.insert(first.0, [cut[0], first.1]);
        stations.insert(second.0, [0.0, second.1 - behind]);
        edit.divide(at.road, pieces, (node, position));
    }
    let network = edit.finish();
    let kept = network.roads.iter().map(|road| stations.get(&road.key).copied().unwrap_or([0.0, road.line.length()]));
    let kept = kept.collect();
    (network, kept)
}

/// The two pieces of a road along its line, of which the one over a length, metres, from an end is changed, and the place between them.
/// `None` if a piece would have no length, or cannot be changed.
fn divided(
    road: &Road,
    (end, near): (End, f64),
    change: impl Fn(&mut Road) -> Option<()>,
) -> Option<(Point, [Road; 2])> {
    let length = road.line.length();
    let (changed, station) = match end {
        End::Start => (0, near),
        End::End => (1, length - near),
    };
    let RoadKey { way, first, last, turn } = road.key;
    let key = Key::new("lane drop").number(way).number(first).number(last).number(i64::from(turn));
    let node = key.number(end.index() as i64).new_node();
    let mut first = piece(road, [0.0, station])?;
    let mut second = piece(road, [station, length])?;
    (first.key.last, second.key.first) = (node, node);
    let mut pieces = [first, second];
    change(pieces.get_mut(changed)?)?;
    Some((road.line.at(station), pieces))
}

/// The part of a road between two stations, metres, with its heights and features.
fn piece(road: &Road, [from, to]: Stations) -> Option<Road> {
    let line = road.line.cut(from, to)?;
    let heights = heights_along(road, &line);
    let within = |feature: &&Feature| (from..to).contains(&feature.station) || feature.station == to;
    let moved = |feature: &Feature| Feature { station: feature.station - from, ..feature.clone() };
    let features = road.features.iter().filter(within).map(moved).collect();
    Some(Road { line, heights, features, ..road.clone() })
}

/// The heights of a road at the points of a line along it, metres; empty where the road has none.
pub(super) fn heights_along(road: &Road, line: &Polyline) -> Vec<f64> {
    let stations = road.line.stations();
    if road.heights.len() != stations.len() {
        return Vec::new();
    }
    let height = |station: f64| {
        let behind = stations.partition_point(|at| *at < station).clamp(1, stations.len() - 1);
        let [a, b] = [behind - 1, behind].map(|i| (stations[i], road.heights[i]));
        let share = ((station - a.0) / (b.0 - a.0).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        a.1 + (b.1 - a.1) * share
    };
    line.points().iter().map(|point| height(road.line.project(*point).station)).collect()
}

/// Adds lanes at the outer side of those that lead away from the intersection. All other lanes of a road with two directions stay where
/// they are; those of a one-way road stay around its middle, as the lanes before the intersection do.
fn widen(road: &mut Road, side: DrivingSide, drop: &LaneDrop) -> Option<()> {
    let is_last = outer_is_last(side, drop.at.end);
    let (outer, lane) = outer_lane(road, side, drop.at.end)?;
    let (width, travel) = (lane.width, lane.travel);
    let place = if is_last { outer + 1 } else { outer };
    let added = Strip::plain(StripKind::Drive, travel, width, true);
    road.section.strips.splice(place..place, std::iter::repeat_n(added, drop.lanes));
    if road.one_way().is_none() {
        let aside = width * drop.lanes as f64 / 2.0;
        let line = road.line.offset(if is_last { -aside } else { aside }, MITER_LIMIT)?;
        road.heights = heights_along(road, &line);
        road.line = line;
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builder::network::hand_drawn::network_of;
    use crate::builder::network::{FeatureKind, RoadIx};
    use crate::builder::tags::cross_section::Travel;

    /// The lanes of each piece of a road of 100 m eastward that gets two more lanes over 40 m from one end.
    fn dropped(tags: &str, side: DrivingSide, end: End) -> (RoadNetwork, Vec<Stations>) {
        let mut network = network_of(&[(1, 0.0, 0.0), (2, 100.0, 0.0)], &[(9, &[1, 2], tags)]);
        network.side = side;
        network.roads[0].heights = vec![0.0, 10.0];
        network.roads[0].features = [30.0, 90.0]
            .map(|station| Feature { station, node: 5, kind: FeatureKind::Signals(Travel::Forward) })
            .into();
        let at = RoadEnd { road: RoadIx::new(0), end };
        with_lane_drops(network, &[[5.0, 92.0]], &[LaneDrop { at, lanes: 2, length: 40.0 }])
    }

    fn lanes(road: &Road) -> [usize; 2] {
        [Travel::Forward, Travel::Backward]
            .map(|travel| road.section.driven().filter(|(_, strip)| strip.travel == travel).count())
    }

    #[test]
    fn a_road_is_divided_where_additional_lanes_end() {
        for side in [DrivingSide::Right, DrivingSide::Left] {
            let (network, kept) = dropped("highway=primary lanes=2", side, End::Start);
            let [near, far] = &network.roads[..] else { panic!("{:?}", network.roads) };
            let (near, far, [a, b]) = if near.key.first == 1 { (near, far, [0, 1]) } else { (far, near, [1, 0]) };
            assert_eq!([lanes(near), lanes(far)], [[3, 1], [1, 1]]);
            assert_eq!((near.key.last, near.to), (far.key.first, far.from));
            assert_eq!((kept[a], kept[b]), ([5.0, 40.0], [0.0, 52.0]));
            assert_eq!(near.features.iter().map(|one| one.station).collect::<Vec<_>>(), [30.0]);
            assert_eq!(far.features.iter().map(|one| one.station).collect::<Vec<_>>(), [50.0]);
            for (road, ends) in [(near, [0.0, 4.0]), (far, [4.0, 10.0])] {
                assert!(road.heights.iter().zip(ends).all(|(height, end)| (height - end).abs() < 1e-9), "{road:?}");
            }
            // The lane of the other direction goes straight on.
            let edge = |road: &Road, i: usize| road.line.first().y + road.section.edge(i);
            let (own, other) = if side == DrivingSide::Right { (0, 0) } else { (4, 2) };
            assert!((edge(near, own) - edge(far, other)).abs() < 1e-9, "{side:?}");
        }
    }

    #[test]
    fn lanes_are_added_in_the_direction_that_leads_away() {
        let (network, _) = dropped("highway=primary lanes=2", DrivingSide::Right, End::End);
        let near = network.roads.iter().find(|road| road.key.last == 2).unwrap();
        assert_eq!((lanes(near), near.line.length()), ([1, 3], 40.0));
        // Those of a one-way road stay around its middle; against it none leads away.
        let (network, _) = dropped("highway=primary lanes=2 oneway=yes", DrivingSide::Right, End::Start);
        let near = network.roads.iter().find(|road| road.key.first == 1).unwrap();
        assert_eq!((lanes(near), near.line.first()), ([4, 0], Point::origin()));
        let (network, _) = dropped("highway=primary lanes=2 oneway=yes", DrivingSide::Right, End::End);
        assert_eq!(network.roads.len(), 1);
    }
}
