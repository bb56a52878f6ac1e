//! The pieces of a lanelet that is cut: which of them keeps its id, its elements, its tags.

use crate::diagnostic::LaneletCut;
use crate::geometry::{Point, Polyline, polygon};
use crate::lanelet::index::thresholds;
use crate::lanelet::index::{MapIndex, center_line};
use crate::lanelet::{LineStringId, PolygonId, RegulatoryElement, Target};

/// A stop line this close (m) before a cut is the one at which the lane is cut.
const AT_CUT: f64 = 2.0;
/// A stop line farther (m) from the middle of a lane is not across it.
const BESIDE: f64 = 8.0;
/// Elements that stop vehicles on the lane before their stop line: the lane behind it has no part in them.
const BEFORE: [&str; 1] = ["traffic_sign"];

/// The pieces of a lane, in the direction of travel.
pub struct Pieces {
    lane: usize,
    against: Vec<LineStringId>,
    outlines: Vec<Vec<Point>>,
    lengths: Vec<f64>,
}

impl Pieces {
    /// From the parts of its bounds.
    pub fn new(lane: usize, against: Vec<LineStringId>, left: Vec<Vec<Point>>, right: Vec<Vec<Point>>) -> Self {
        let both = || left.iter().zip(&right);
        let lengths = both().map(|(left, right)| center_line(left, right).map_or(0.0, |line| line.length())).collect();
        let outlines = both().map(|(left, right)| left.iter().chain(right.iter().rev()).copied().collect()).collect();
        Self { lane, against, outlines, lengths }
    }

    /// What becomes of the lanelet and of what hangs on it.
    pub fn cut(&self, map: &MapIndex) -> Option<LaneletCut> {
        let lanelet = map.lanes[self.lane].lanelet;
        let own = lanelet.regulatory_elements.iter().filter_map(|id| map.map.regulatory_elements.get(*id));
        let mut elements: Vec<&RegulatoryElement> = own.chain(map.elements_naming(lanelet.id)).collect();
        elements.sort_unstable_by_key(|element| element.id);
        elements.dedup_by_key(|element| element.id);
        let elements = elements.into_iter().map(|element| (element.id.0, self.concerned(map, element)));
        let some = |(_, pieces): &(i64, Vec<usize>)| pieces.len() < self.outlines.len();
        let area = lanelet.attributes.get("intersection_area");
        let inside = area.and_then(|area| self.inside(map, area));
        let turning = inside.clone().or_else(|| self.in_conflict(map));
        let stays = self.longest(turning.as_deref());
        let mut tags = Vec::new();
        for (key, pieces) in [("intersection_area", inside), ("turn_direction", turning)] {
            if let Some(pieces) = pieces.filter(|_| lanelet.attributes.has(key)) {
                tags.push((key.into(), pieces));
            }
        }
        Some(LaneletCut {
            lanelet: lanelet.id.0,
            against: self.against.iter().map(|way| way.0).collect(),
            stays: stays?,
            elements: elements.filter(some).collect(),
            tags,
        })
    }

    /// The longest of some pieces, or of all: the first of those that are equally long. What others say of a lanelet of an
    /// intersection they say of the piece that lies there, so that one keeps the id.
    fn longest(&self, some: Option<&[usize]>) -> Option<usize> {
        let pieces = (0..self.lengths.len()).filter(|at| some.is_none_or(|some| some.contains(at)));
        pieces.max_by(|&a, &b| self.lengths[a].total_cmp(&self.lengths[b]).then(b.cmp(&a)))
    }

    /// The pieces that an element concerns: those on the ground that it speaks of, else the one at its stop line; all, where neither
    /// tells.
    fn concerned(&self, map: &MapIndex, element: &RegulatoryElement) -> Vec<usize> {
        let own = map.lanes[self.lane].id;
        let grounds: Vec<Vec<Point>> = element
            .members
            .iter()
            .filter_map(|member| match member.target {
                Target::Lanelet(id) if id != own => Some(map.map.outline(map.map.lanelets.get(id)?)),
                Target::Polygon(id) => Some(self::ground(map, id)),
                _ => None,
            })
            .collect();
        let pieces = self.on(&grounds);
        if !pieces.is_empty() {
            return pieces;
        }
        let role = if element.subtype == "road_marking" { "refers" } else { "ref_line" };
        let lines = element.linestrings(role).filter_map(|way| map.stop_line(way));
        let stop = lines.filter_map(|line| self.station(map, nalgebra::center(&line.ends[0], &line.ends[1]))).next();
        match stop {
            Some(station) if BEFORE.contains(&element.subtype.as_str()) => vec![self.at(station - AT_CUT)],
            Some(station) => vec![self.at(station + AT_CUT)],
            None => (0..self.outlines.len()).collect(),
        }
    }

    /// The pieces that overlap one of some rings by more than a sliver.
    fn on(&self, rings: &[Vec<Point>]) -> Vec<usize> {
        let overlaps =
            |outline: &[Point]| rings.iter().any(|ring| polygon::overlap(outline, ring) > thresholds::REAL_AREA);
        (0..self.outlines.len()).filter(|&at| overlaps(&self.outlines[at])).collect()
    }

    /// The pieces of which the greater part lies in an area.
    fn inside(&self, map: &MapIndex, area: &str) -> Option<Vec<usize>> {
        let id = PolygonId(area.trim().parse().ok()?);
        let ring = ground(map, id);
        let is_inside =
            |outline: &Vec<Point>| 2.0 * polygon::overlap(outline, &ring) > polygon::signed_area(outline).abs();
        let pieces: Vec<usize> = (0..self.outlines.len()).filter(|&at| is_inside(&self.outlines[at])).collect();
        (!pieces.is_empty()).then_some(pieces)
    }

    /// The pieces on which others cross the lane; where none do, those on the ground of lanes that start or end with it.
    fn in_conflict(&self, map: &MapIndex) -> Option<Vec<usize>> {
        let conflicts = map.conflicts[self.lane].iter().filter(|conflict| conflict.real);
        let mut pieces: Vec<usize> =
            conflicts.filter_map(|conflict| Some(self.at(self.station(map, conflict.place)?))).collect();
        pieces.sort_unstable();
        pieces.dedup();
        if pieces.is_empty() {
            let ending = map.followers(self.lane).first().map_or(&[][..], |&next| map.predecessors(next));
            let parting = map.siblings(self.lane).chain(ending.iter().copied()).filter(|&other| other != self.lane);
            let grounds: Vec<Vec<Point>> = parting.map(|other| map.lanes[other].outline.clone()).collect();
            pieces = self.on(&grounds);
        }
        (!pieces.is_empty()).then_some(pieces)
    }

    /// How far along the lane a place lies, metres; `None` where it is not on it.
    fn station(&self, map: &MapIndex, place: Point) -> Option<f64> {
        let center: &Polyline = map.lanes[self.lane].center.as_ref()?;
        let foot = center.project(place);
        (foot.offset.abs() <= BESIDE).then_some(foot.station)
    }

    /// The number of the piece at a station.
    fn at(&self, station: f64) -> usize {
        let mut behind = 0.0;
        let starts = self.lengths.iter().skip(1).zip(&self.lengths).map(|(_, before)| {
            behind += before;
            behind
        });
        starts.filter(|start| *start <= station).count()
    }
}

/// The outline of a polygon; empty if it is not there.
fn ground(map: &MapIndex, id: PolygonId) -> Vec<Point> {
    let points = map.map.polygons.get(id).map_or(&[][..], |polygon| &polygon.points);
    map.map.points.get_each(points.iter().copied()).map(|point| point.position).collect()
}
