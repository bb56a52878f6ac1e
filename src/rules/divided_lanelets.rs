//! The fix that cuts a lanelet across, with those beside it that share its bounds, and with all that hangs on them.

use std::collections::BTreeMap;

use super::lanelet_pieces::Pieces;
use crate::diagnostic::{CutPlace, Division, Edit, Finding, WayCut};
use crate::geometry::{Point, Polyline, Vector, line_crossing};
use crate::lanelet::index::{Edge, MapIndex};
use crate::lanelet::{Bound, LineStringId};

/// More lanes side by side than these are not cut at once.
const MOST: usize = 12;
/// The other bound of a lane lies no farther away than this (m), measured along the cut.
const WIDEST: f64 = 12.0;
/// A vertex this close (m) to the cut is cut at, rather than a new one beside it.
const SNAP: f64 = 0.3;
/// No part of a bound is shorter than this (m): ends that lie nearer are moved, not parted.
const SHORTEST: f64 = 1.0;
/// A corner this close (m) to a border lies on it: as far as end nodes that lie beside each other are joined.
const ON_BORDER: f64 = 0.5;

/// A straight line across a road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Across {
    /// A place on it.
    pub place: Point,
    /// Its direction.
    pub along: Vector,
}

/// Where a way is cut.
#[derive(Clone, Copy, Debug)]
struct Place {
    at: CutPlace,
    point: Point,
}

/// The ways of a division, each with its places in the order of the lines, and the lanes.
struct Cuts<'i, 'm> {
    map: &'i MapIndex<'m>,
    lines: &'i [Across],
    ways: BTreeMap<LineStringId, Vec<Place>>,
    lanes: Vec<usize>,
}

/// The edits that cut a lane on lines across it, and the lanes beside it that share its bounds; `None` where a bound
/// does not meet a line, or would have a part of almost no length.
pub fn edits(map: &MapIndex, lane: usize, lines: &[Across]) -> Option<Vec<Edit>> {
    let mut cuts = Cuts { map, lines, ways: BTreeMap::new(), lanes: vec![lane] };
    let mut at = 0;
    while let Some(&lane) = cuts.lanes.get(at) {
        if at >= MOST {
            return None;
        }
        cuts.add(lane)?;
        at += 1;
    }
    let lanelets: Option<Vec<_>> = cuts.lanes.iter().map(|&lane| cuts.pieces(lane)?.cut(map)).collect();
    let in_file_order = |(way, places): (&LineStringId, &Vec<Place>)| {
        let mut places: Vec<CutPlace> = places.iter().map(|place| place.at).collect();
        places.sort_by(|a, b| a.vertex.cmp(&b.vertex).then(a.share.total_cmp(&b.share)));
        WayCut { way: way.0, places }
    };
    let ways = cuts.ways.iter().map(in_file_order).collect();
    (!lines.is_empty()).then_some(vec![Edit::Divide(Division { ways, lanelets: lanelets? })])
}

impl Cuts<'_, '_> {
    /// Cuts those ways of a lane that are not cut yet, and takes in their other lanes.
    fn add(&mut self, lane: usize) -> Option<()> {
        let lanelet = self.map.lanes[lane].lanelet;
        let bounds = [lanelet.left.line, lanelet.right.line];
        for [way, other] in [bounds, [bounds[1], bounds[0]]] {
            if self.ways.contains_key(&way) {
                continue;
            }
            let from: Vec<Point> = match self.ways.get(&other) {
                Some(known) => known.iter().map(|place| place.point).collect(),
                None => self.lines.iter().map(|line| line.place).collect(),
            };
            self.cut(way, &from)?;
            for &user in self.map.users_of(way) {
                if !self.lanes.contains(&user) {
                    self.lanes.push(user);
                }
            }
        }
        if let Some(center) = lanelet.centerline.filter(|center| !self.ways.contains_key(center)) {
            let middle = |(a, b): (&Place, &Place)| nalgebra::center(&a.point, &b.point);
            let [left, right] = bounds.map(|way| self.ways.get(&way));
            let from: Vec<Point> = left?.iter().zip(right?).map(middle).collect();
            self.cut(center, &from)?;
        }
        Some(())
    }

    /// Cuts a way where it meets the lines, each nearest to one of these places.
    fn cut(&mut self, way: LineStringId, from: &[Point]) -> Option<()> {
        let points = self.map.map.bound_line(Bound { line: way, inverted: false });
        let places: Option<Vec<Place>> =
            from.iter().zip(self.lines).map(|(&from, line)| cut(&points, from, line)).collect();
        self.ways.insert(way, places?);
        Some(())
    }

    /// The pieces of a lane of which all ways are cut; `None` where the lines do not follow each other alike on both sides.
    fn pieces(&self, lane: usize) -> Option<Pieces> {
        let map = self.map;
        let lanelet = map.lanes[lane].lanelet;
        let mut against = Vec::new();
        let mut orders: Vec<Vec<usize>> = Vec::new();
        let mut sides: Vec<Vec<Vec<Point>>> = Vec::new();
        for bound in [lanelet.left, lanelet.right] {
            let places = self.ways.get(&bound.line)?;
            let mut order: Vec<usize> = (0..places.len()).collect();
            let rank = |at: usize| places.get(at).map_or((0, 0.0), |place| (place.at.vertex, place.at.share));
            order.sort_by(|&a, &b| rank(a).0.cmp(&rank(b).0).then(rank(a).1.total_cmp(&rank(b).1)));
            let points = map.map.bound_line(Bound { line: bound.line, inverted: false });
            let mut parts = parts(&points, order.iter().filter_map(|&at| places.get(at)));
            if bound.inverted {
                against.push(bound.line);
                order.reverse();
                parts.reverse();
                parts.iter_mut().for_each(|part| part.reverse());
            }
            orders.push(order);
            sides.push(parts);
        }
        if let Some(center) = lanelet.centerline {
            let points = map.map.bound_line(Bound { line: center, inverted: false });
            let far = |edge: &Edge| points.first().map_or(0.0, |first| (first - edge.middle()).norm());
            if far(&map.lanes[lane].end) < far(&map.lanes[lane].start) {
                against.push(center);
            }
        }
        let [left, right] = <[_; 2]>::try_from(sides).ok()?;
        (orders.first() == orders.get(1)).then(|| Pieces::new(lane, against, left, right))
    }
}

/// Where a line through a place meets a way, nearest to that place.
fn cut(points: &[Point], from: Point, line: &Across) -> Option<Place> {
    let meets = points.windows(2).enumerate().filter_map(|(at, pair)| {
        let (share, _, point) = line_crossing(pair[0], pair[1] - pair[0], from, line.along)?;
        (-1e-9..=1.0 + 1e-9).contains(&share).then_some((at, share.clamp(0.0, 1.0), point))
    });
    let far = |point: &Point| (point - from).norm();
    let (vertex, share, point) = meets.min_by(|a, b| far(&a.2).total_cmp(&far(&b.2)))?;
    if far(&point) > WIDEST {
        return None;
    }
    let [a, b] = [*points.get(vertex)?, *points.get(vertex + 1)?];
    let length = (b - a).norm();
    let place = if share * length <= SNAP && share <= 0.5 {
        Place { at: CutPlace { vertex, share: 0.0 }, point: a }
    } else if (1.0 - share) * length <= SNAP {
        Place { at: CutPlace { vertex: vertex + 1, share: 0.0 }, point: b }
    } else {
        Place { at: CutPlace { vertex, share }, point }
    };
    let long = |points: &[Point]| points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>() >= SHORTEST;
    let parts = parts(points, std::iter::once(&place));
    parts.iter().all(|part| long(part)).then_some(place)
}

/// The parts of a way between places in file order.
fn parts<'p>(points: &[Point], places: impl Iterator<Item = &'p Place>) -> Vec<Vec<Point>> {
    let (mut parts, mut part, mut next) = (Vec::new(), Vec::new(), 0);
    for place in places {
        let behind = place.at.vertex + usize::from(place.at.share > 0.0);
        part.extend(points.get(next..behind).unwrap_or_default());
        part.push(place.point);
        parts.push(std::mem::replace(&mut part, vec![place.point]));
        next = place.at.vertex + 1;
    }
    part.extend(points.get(next..).unwrap_or_default());
    parts.push(part);
    parts
}

/// Adds the edits that cut a lane where lanes beside it start and end.
pub fn beside(map: &MapIndex, finding: Finding, lane: usize, others: &[usize]) -> Finding {
    match edits(map, lane, &ends_beside(map, lane, others)) {
        Some(edits) => {
            let title = format!("cut lanelet {} where those beside it are cut", map.lanes[lane].id);
            finding.fixed_by(title, false, edits)
        }
        None => finding,
    }
}

/// The lines on which lanes beside one start and end along it, in its direction.
fn ends_beside(map: &MapIndex, lane: usize, others: &[usize]) -> Vec<Across> {
    let borders: Vec<Polyline> = [0, 1].into_iter().filter_map(|side| map.lanes[lane].border(side)).collect();
    let on_border = |place: &Point| {
        let feet = borders.iter().map(|border| (border.project(*place), border.length()));
        let near = feet.filter(|(foot, _)| foot.offset.abs() <= ON_BORDER);
        near.map(|(foot, length)| (foot.station, length)).next()
    };
    let mut lines: Vec<(f64, Across)> = Vec::new();
    for edge in others.iter().flat_map(|&other| [map.lanes[other].start, map.lanes[other].end]) {
        for place in edge.points {
            let Some((station, length)) = on_border(&place) else { continue };
            if station >= SHORTEST && length - station >= SHORTEST {
                lines.push((station, Across { place, along: edge.across() }));
            }
        }
    }
    lines.sort_by(|a, b| a.0.total_cmp(&b.0));
    lines.dedup_by(|later, first| later.0 - first.0 < SHORTEST);
    lines.into_iter().map(|(_, line)| line).collect()
}
