//! Which stop line a lanelet of an intersection starts at.

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::Lane;
use super::thresholds;
use super::types::{MapIndex, StopLineTree};
use crate::geometry::{Point, Polyline, Vector, angle_between};
use crate::lanelet::{LineString, LineStringId, PointId};

/// A stop line of the map as a straight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopLine {
    /// Its way.
    pub way: LineStringId,
    /// Its two ends; of an outline of paint, those of its longest edge.
    pub ends: [Point; 2],
    /// The edge that its ends are those of, where it comes back to where it begins, as an outline of paint does.
    pub edge_of_outline: Option<[PointId; 2]>,
    /// Its height in the middle, metres; 0 where the map has none.
    pub height: f64,
}

/// How far a stop line is from where it should be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit {
    /// Distance of the farther end of the edge from the stop line, metres.
    pub distance: f64,
    /// Angle between both, degrees, 0..=90.
    pub angle: f64,
    /// Whether the edge lies behind the line, downstream.
    pub behind: bool,
}

/// A line of which one edge is so many times longer than the straight between its ends is drawn around its paint.
const OUTLINE: f64 = 2.0;

impl StopLine {
    /// From a way; `None` if it has no length.
    pub fn of(map: &MapIndex, line: &LineString) -> Option<Self> {
        let end = |id| map.map.points.get(id).filter(|point| point.position.coords.iter().all(|c| c.is_finite()));
        let mut ends = [*line.points.first()?, *line.points.last()?];
        // Without one of its nodes, an edge has no length.
        let length = |[a, b]: [PointId; 2]| end(a).zip(end(b)).map_or(0.0, |(a, b)| (b.position - a.position).norm());
        let edges = line.points.windows(2).map(|pair| [pair[0], pair[1]]);
        let longest = edges.max_by(|a, b| length(*a).total_cmp(&length(*b)));
        let longest = longest.filter(|edge| length(*edge) > OUTLINE * length(ends));
        ends = longest.unwrap_or(ends);
        let points = [end(ends[0])?, end(ends[1])?];
        let ends = points.map(|point| point.position);
        let [a, b] = points.map(|point| point.ele().unwrap_or_default());
        let line = Self { way: line.id, ends, edge_of_outline: longest, height: (a + b) / 2.0 };
        ((ends[1] - ends[0]).norm() > Polyline::MERGE).then_some(line)
    }

    /// The line, longer by `extra` metres at both ends.
    fn extended(&self, extra: f64) -> [Point; 2] {
        let along = (self.ends[1] - self.ends[0]).normalize() * extra;
        [self.ends[0] - along, self.ends[1] + along]
    }

    /// How well the start of a lane lies on the line, made longer by `extra` metres at both ends.
    pub fn misfit(&self, lane: &Lane, extra: f64) -> Misfit {
        let [a, b] = self.extended(extra);
        let distance = lane.start.points.iter().map(|&p| distance_to(p, a, b)).fold(0.0, f64::max);
        let angle = angle_between(b - a, lane.start.across()).abs().to_degrees();
        let away = lane.start.middle() - nalgebra::center(&a, &b);
        let behind = lane.heading_in().is_some_and(|heading| away.dot(&heading) > 0.0);
        Misfit { distance, angle: angle.min(180.0 - angle), behind }
    }

    /// Share of the start of a lane that lies abreast of the line.
    fn overlap(&self, lane: &Lane) -> f64 {
        let along: Vector = lane.start.across();
        let width = along.norm().max(Polyline::MERGE);
        let [a, b] = self.ends.map(|end| (end - lane.start.points[0]).dot(&along) / (width * width));
        (a.max(b).min(1.0) - a.min(b).max(0.0)).max(0.0)
    }
}

/// Distance of `p` from the line from `a` to `b`.
fn distance_to(p: Point, a: Point, b: Point) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    (p - (a + along * t)).norm()
}

impl MapIndex<'_> {
    /// A way as a stop line.
    pub fn stop_line(&self, way: LineStringId) -> Option<StopLine> {
        StopLine::of(self, self.map.linestrings.get(way)?)
    }

    /// The stop line that a lanelet of an intersection starts at: the one that an element names, or any other that lies
    /// near its start.
    pub fn stop_line_of(&self, lane: usize) -> Option<StopLine> {
        self.named_stop_line(lane).or_else(|| {
            let lane = &self.lanes[lane];
            let reach = thresholds::STOP_LINE_REACH;
            let [low, high] = super::extent(&lane.start.points);
            let reach = Vector::repeat(reach);
            let near = self.stop_lines_near(low - reach, high + reach);
            self.nearest(lane, near.into_iter(), thresholds::STOP_LINE_OVERLAP)
        })
    }

    /// Whether a lane starts at the stop line that it obeys.
    pub fn starts_at_stop_line(&self, lane: usize) -> bool {
        let reach = thresholds::STOP_LINE_REACH;
        self.stop_line_of(lane).is_some_and(|line| line.misfit(&self.lanes[lane], reach).distance <= reach)
    }

    /// The stop lines whose boxes meet the one between two corners, by id.
    pub fn stop_lines_near(&self, low: Point, high: Point) -> Vec<StopLine> {
        let reach = AABB::from_corners([low.x, low.y], [high.x, high.y]);
        let tree = self.stop_lines.get_or_init(|| tree(self));
        let mut near: Vec<LineStringId> = tree.locate_in_envelope_intersecting(&reach).map(|one| one.data).collect();
        near.sort_unstable();
        near.into_iter().filter_map(|way| self.stop_line(way)).collect()
    }

    /// The stop line that elements name: that of the lanelet's traffic light; else one near its start of its road
    /// markings, or of the traffic signs of the lanes before.
    pub fn named_stop_line(&self, lane: usize) -> Option<StopLine> {
        let id = self.lanes[lane].id;
        let lights = self.elements(id, "traffic_light").flat_map(|light| light.linestrings("ref_line"));
        if let Some(line) = lights.filter_map(|way| self.stop_line(way)).next() {
            return Some(line);
        }
        let marked = self.elements(id, "road_marking").flat_map(|marking| marking.linestrings("refers"));
        let before = self.predecessors(lane).iter().map(|&before| self.lanes[before].id);
        let signs =
            before.flat_map(|id| self.elements(id, "traffic_sign")).flat_map(|sign| sign.linestrings("ref_line"));
        let lines: Vec<StopLine> = marked.chain(signs).filter_map(|way| self.stop_line(way)).collect();
        self.nearest(&self.lanes[lane], lines.into_iter(), 0.0)
    }

    /// The nearest of some stop lines that is near the start and abreast of this share of it.
    fn nearest(&self, lane: &Lane, lines: impl Iterator<Item = StopLine>, overlap: f64) -> Option<StopLine> {
        let distance = |line: &StopLine| distance_to(lane.start.middle(), line.ends[0], line.ends[1]);
        lines
            .filter(|line| distance(line) <= thresholds::STOP_LINE_REACH && line.overlap(lane) >= overlap)
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}

/// All stop lines of the map.
fn tree(map: &MapIndex) -> StopLineTree {
    let lines = map.map.linestrings.iter().filter(|line| line.attributes.is("type", "stop_line"));
    let boxes = lines.filter_map(|line| StopLine::of(map, line)).map(|line| {
        let [a, b] = line.ends;
        GeomWithData::new(Rectangle::from_corners([a.x, a.y], [b.x, b.y]), line.way)
    });
    RTree::bulk_load(boxes.collect())
}
