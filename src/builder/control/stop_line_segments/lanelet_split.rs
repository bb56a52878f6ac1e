//! Splits a road across, all its lanes and side lanes at once.
//!
//! A bound is one line with one marking, and a lanelet obeys one light. Where either changes, the road is split: neighbours share
//! their bounds on both sides of the split, and lanelets that follow each other their end nodes. The first piece keeps the ids of
//! the road.

use crate::builder::control::mid_block_signals::SignalisedCrossing;
use crate::builder::lanes::lanelet_validity::{are_read_as_drawn, is_simple, is_valid};
use crate::builder::lanes::road_cut::STOP_GAP;
use crate::builder::lanes::types::{Lanes, RoadLane, RoadPiece, SplitReason};
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::road_end::at_depth;
use crate::builder::network::{End, Road, RoadIx, RoadNetwork};
use crate::builder::streets::heights::Ground;
use crate::builder::tags::side_strips::strip_runs;
use crate::geometry::{Point, Vector, cross, left_of};
use crate::lanelet::{Attributes, Bound, LineStringId, PointId};

/// No split comes closer than this, metres, to a point of a border.
const SPLIT_FROM_POINT: f64 = 0.5;
/// The largest distance, metres, from where a border crosses a split to its place by the cross-section.
const ASIDE: f64 = 1.0;
/// No piece is shorter than this, metres.
const PIECE: f64 = 2.0;
/// An approach begins at another split that is nearer than this, metres.
const APPROACH_AT_SPLIT: f64 = 5.0;
/// Where a road cannot be split, the start of an approach moves toward the stop line in steps of this length, metres.
const START_STEP: f64 = 0.5;
/// The largest number of these steps.
const STEPS: usize = 20;
/// Distances, metres, by which a stop line moves away from a crosswalk, or toward it, until the road can be split there.
const GAPS: [f64; 7] = [0.0, 0.5, -0.5, 1.0, 1.5, 2.0, -0.8];

/// Where a split meets each border, by edges of the cross-section: the index of the border's point before it, and the place.
type SplitPlaces = Vec<Option<(usize, Point)>>;

/// A split across a road.
pub struct RoadSplit {
    /// Along the road's line, metres.
    station: f64,
    reason: SplitReason,
    places: SplitPlaces,
}

impl RoadSplit {
    fn place(&self, edge: usize) -> Option<(usize, Point)> {
        *self.places.get(edge)?
    }
}

/// A part of a road where some borders have another marking, and that marking by edges of the cross-section.
pub struct RepaintedSegment {
    /// The stations between which it lies, metres.
    pub span: [f64; 2],
    pub markings: EdgeMarkings,
}

/// Edges of a road's cross-section with their markings before the stop line.
pub type EdgeMarkings = Vec<(usize, Attributes)>;

/// Where a road is split, and which parts of it are repainted.
pub struct RoadSplits {
    pub road: RoadIx,
    /// In order of stations.
    pub splits: Vec<RoadSplit>,
    pub repainted: Vec<RepaintedSegment>,
}

/// The approach to a stop line, which begins where the road is to be split.
pub struct StopApproach {
    pub reason: SplitReason,
    /// The station of the stop line, metres.
    pub stop_line: f64,
    /// The end of the road toward which vehicles drive.
    pub toward: End,
    /// Its length where there is room, metres.
    pub length: f64,
    /// Its least length, metres.
    pub least: f64,
}

/// Finds where a road can be split.
pub struct LaneletSplitter<'a> {
    road: &'a Road,
    span: [f64; 2],
    /// The borders of the whole road.
    borders: Vec<Option<Vec<Point>>>,
    /// In order of stations.
    pub splits: Vec<RoadSplit>,
}

impl<'a> LaneletSplitter<'a> {
    /// For a road of one piece.
    pub fn new(assembly: &MapBuilder, road: &'a Road, piece: &RoadPiece) -> Self {
        let borders = piece.borders.iter().map(|bound| bound.map(|bound| assembly.bound_line(bound))).collect();
        Self { road, span: piece.span, borders, splits: Vec::new() }
    }

    /// Splits the road where vehicles toward an end stop before a crosswalk, unless they would stand on another road there.
    pub fn split_at_stop_line(&mut self, crossing: &SignalisedCrossing, toward: End) {
        let stations = GAPS.map(|gap| at_depth(crossing.span, toward.other(), -STOP_GAP - gap));
        if self.is_clear(stations[0]) {
            let _ = stations.into_iter().any(|station| self.split(station, SplitReason::Line(crossing.node, toward)));
        }
    }

    /// Splits the road where an approach begins: at its length before the stop line, but at half the way that vehicles have to
    /// the stop line at most. Gives the station, metres; `None` if there is no room for the least length.
    pub fn split_at_approach(&mut self, approach: &StopApproach) -> Option<f64> {
        let StopApproach { reason, stop_line, toward, length, least } = *approach;
        let sign = if toward == End::End { 1.0 } else { -1.0 };
        let depth = |station: f64| (stop_line - station) * sign;
        let stop_lines = self.splits.iter().filter(|split| matches!(split.reason, SplitReason::Line(..)));
        // The stop line itself may have been moved.
        let before = stop_lines.map(|split| depth(split.station)).filter(|depth| *depth > STOP_GAP + START_STEP);
        let room = before.fold(depth(self.span[toward.other().index()]), f64::min);
        let (most, least) = (length.min(room / 2.0), least.min(length));
        let depths =
            (0..STEPS).map(|i| most - i as f64 * START_STEP).take_while(|&depth| depth >= least && depth > 0.0);
        let stations: Vec<f64> = depths.map(|depth| stop_line - depth * sign).collect();
        let best = *stations.first()?;
        let offset = |station: f64| (station - best).abs();
        let known = self.splits.iter().map(|split| split.station);
        let known = known.filter(|&station| offset(station) < APPROACH_AT_SPLIT && depth(station) >= least);
        let known = known.min_by(|&a, &b| offset(a).total_cmp(&offset(b)));
        known.or_else(|| stations.into_iter().find(|&station| self.split(station, reason)))
    }

    /// Whether a split leaves no piece too short.
    fn is_clear(&self, station: f64) -> bool {
        let [from, to] = self.span;
        let apart = |other: f64| (station - other).abs() >= PIECE;
        station - from >= PIECE && to - station >= PIECE && self.splits.iter().all(|split| apart(split.station))
    }

    /// Splits the road at a station; `false` if it cannot be split there.
    fn split(&mut self, station: f64, reason: SplitReason) -> bool {
        if !self.is_clear(station) {
            return false;
        }
        let Some(places) = self.places(station) else { return false };
        let new = RoadSplit { station, reason, places };
        let i = self.splits.partition_point(|split| split.station < station);
        let valid = self.leaves_lanes_valid(&new, i) && self.leaves_side_lanes_valid(&new, i);
        if valid {
            self.splits.insert(i, new);
        }
        valid
    }

    /// The bounds between two edges around a new split, which gets index `i`: from the split before it to the split behind it, and
    /// those of the two parts into which the new split divides them.
    fn bounds(&self, new: &RoadSplit, i: usize, edges: [usize; 2]) -> Option<[[Vec<Point>; 2]; 3]> {
        let (before, behind) = (i.checked_sub(1).map(|i| &self.splits[i]), self.splits.get(i));
        let [left, right] = edges.map(|edge| self.borders[edge].as_ref().map(|border| (edge, border)));
        let (left, right) = (left?, right?);
        let between = |from: Option<&RoadSplit>, to: Option<&RoadSplit>| {
            [left, right].map(|(edge, border)| {
                part(border, from.and_then(|split| split.place(edge)), to.and_then(|split| split.place(edge)))
            })
        };
        Some([between(before, behind), between(before, Some(new)), between(Some(new), behind)])
    }

    /// Whether both parts of all lanes are simple, and read as drawn in either direction.
    fn leaves_lanes_valid(&self, new: &RoadSplit, i: usize) -> bool {
        let is_readable = |bounds: &[Vec<Point>; 2]| {
            let [left, right] = bounds;
            let reversed = [right, left].map(|line| line.iter().rev().copied().collect::<Vec<Point>>());
            is_simple(bounds) && are_read_as_drawn(bounds) && are_read_as_drawn(&reversed)
        };
        let mut lanes = self.road.section.driven().filter_map(|(strip, _)| self.bounds(new, i, [strip, strip + 1]));
        lanes.all(|[_, before, behind]| is_readable(&before) && is_readable(&behind))
    }

    /// Whether both parts of all side lanes are valid, if the whole was.
    fn leaves_side_lanes_valid(&self, new: &RoadSplit, i: usize) -> bool {
        let section = &self.road.section;
        strip_runs(section).into_iter().all(|run| {
            let Some([whole, a, b]) = self.bounds(new, i, [run.strips.start, run.strips.end]) else { return true };
            let width = section.strips[run.strips].iter().map(|strip| strip.width).sum::<f64>();
            !is_valid(&whole, width) || is_valid(&a, width) && is_valid(&b, width)
        })
    }

    /// Where a split at a station meets the borders; `None` if it cannot meet all of them.
    fn places(&self, station: f64) -> Option<SplitPlaces> {
        let (middle, along) = (self.road.line.at(station), self.road.line.direction(station));
        let expected = |edge: usize| middle + left_of(along) * self.road.section.edge(edge);
        let place = |(edge, border): (usize, &Option<Vec<Point>>)| match border {
            Some(border) => split_place(border, expected(edge), along).map(Some),
            None => Some(None),
        };
        self.borders.iter().enumerate().map(place).collect()
    }
}

/// Where a line crosses the split across the direction `along`, nearest to the expected place. `None` where it does not, or close
/// to one of its points.
fn split_place(line: &[Point], expected: Point, along: Vector) -> Option<(usize, Point)> {
    let across = |(i, pair): (usize, &[Point])| {
        let [before, behind] = [0, 1].map(|i| (pair[i] - expected).dot(&along));
        (before < 0.0 && behind >= 0.0).then(|| (i, pair[0] + (pair[1] - pair[0]) * (before / (before - behind))))
    };
    let offset = |(_, place): &(usize, Point)| cross(along, place - expected).abs();
    let nearest = line.windows(2).enumerate().filter_map(across).min_by(|a, b| offset(a).total_cmp(&offset(b)));
    let (i, place) = nearest.filter(|found| offset(found) <= ASIDE)?;
    [line[i], line[i + 1]].iter().all(|point| (point - place).norm() >= SPLIT_FROM_POINT).then_some((i, place))
}

/// The part of a row of points between two places. A place comes with the index of the point before it; without a place, the part
/// reaches to the end of the row.
fn part<T: Copy>(row: &[T], from: Option<(usize, T)>, to: Option<(usize, T)>) -> Vec<T> {
    let first = from.map_or(0, |(i, _)| i + 1);
    let last = to.map_or(row.len(), |(i, _)| i + 1);
    let inner = row.get(first..last.max(first)).unwrap_or_default().iter().copied();
    from.map(|it| it.1).into_iter().chain(inner).chain(to.map(|it| it.1)).collect()
}

/// The lanes with the roads divided at their splits, which come in order of roads, and the segments repainted.
pub fn split_lanes(assembly: &mut MapBuilder, network: &RoadNetwork, lanes: Lanes, splits: Vec<RoadSplits>) -> Lanes {
    let Lanes { lanes: before, mut arms, mut pieces } = lanes;
    let mut before = before.into_iter().peekable();
    let mut splits = splits.into_iter().peekable();
    let (mut lanes, mut first_before) = (Vec::with_capacity(before.len()), 0);
    for (i, (arms, pieces)) in arms.iter_mut().zip(&mut pieces).enumerate() {
        let ix = RoadIx::new(i);
        let first = lanes.len();
        lanes.extend(std::iter::from_fn(|| before.next_if(|lane: &RoadLane| lane.road == ix)));
        let count = lanes.len() - first;
        if let Some(splits) = splits.next_if(|splits| splits.road == ix)
            && let Some(whole) = pieces.pop()
        {
            *pieces = split_pieces(assembly, network.road(ix), &whole, &splits);
            for piece in &pieces[1..] {
                for i in first..first + count {
                    let lane = lane_of_piece(assembly, network.road(ix), &lanes[i], &whole, piece);
                    lanes.push(lane);
                }
            }
        }
        let last = lanes.len() - count;
        for (arm, begin) in arms.iter_mut().zip([first, last]) {
            arm.into.iter_mut().chain(&mut arm.out).for_each(|end| end.lane = end.lane - first_before + begin);
        }
        first_before += count;
    }
    assembly.set_ground(Ground::default());
    Lanes { lanes, arms, pieces }
}

/// The pieces of a road between its splits.
fn split_pieces(assembly: &mut MapBuilder, road: &Road, whole: &RoadPiece, splits: &RoadSplits) -> Vec<RoadPiece> {
    assembly.set_ground(Ground::under(road));
    let reasons = std::iter::once(whole.behind).chain(splits.splits.iter().map(|split| Some(split.reason)));
    let stations = || splits.splits.iter().map(|split| split.station);
    let (starts, ends) = (std::iter::once(whole.span[0]).chain(stations()), stations().chain([whole.span[1]]));
    let piece = |(behind, (from, to))| RoadPiece { behind, span: [from, to], borders: vec![None; whole.borders.len()] };
    let mut pieces: Vec<RoadPiece> = reasons.zip(starts.zip(ends)).map(piece).collect();
    for (edge, border) in whole.borders.iter().enumerate() {
        let Some(border) = *border else { continue };
        let lines = split_border(assembly, road, (edge, border), &pieces, splits);
        for (piece, line) in pieces.iter_mut().zip(lines) {
            piece.borders[edge] = Some(Bound { line, ..border });
        }
    }
    pieces
}

/// Adds the lane of a piece behind a split that continues a lane of the whole road.
fn lane_of_piece(
    assembly: &mut MapBuilder,
    road: &Road,
    lane: &RoadLane,
    whole: &RoadPiece,
    piece: &RoadPiece,
) -> RoadLane {
    let [left, right] = [lane.left, lane.right].map(|bound| {
        let edge = whole.borders.iter().position(|border| border.is_some_and(|it| it.line == bound.line));
        let line = edge.and_then(|edge| piece.borders[edge]).map_or(bound.line, |it| it.line);
        Bound { line, ..bound }
    });
    let attributes = assembly.lanelet_of(lane.lanelet).map(|it| it.attributes.clone()).unwrap_or_default();
    let key = road.key_of("lane");
    let key = piece.behind.map_or(key, |reason| reason.of(key));
    let key = key.number(lane.strip as i64).number(i64::from(lane.backward));
    let lanelet = assembly.lanelet(key, left, right, attributes);
    RoadLane { lanelet, left, right, ..lane.clone() }
}

/// The lines of a border by pieces: shortens its own line to the first piece, and draws the others anew, with its marking or that
/// of a repainted segment.
fn split_border(
    assembly: &mut MapBuilder,
    road: &Road,
    (edge, border): (usize, Bound),
    pieces: &[RoadPiece],
    splits: &RoadSplits,
) -> Vec<LineStringId> {
    let ids = assembly.bound_ids(border);
    let own = assembly.line_of(border.line).map(|line| line.attributes.clone()).unwrap_or_default();
    let key = |reason: SplitReason| reason.of(road.key_of("border")).number(edge as i64);
    let nodes = splits.splits.iter().map(|split| {
        let (i, place) = split.place(edge)?;
        Some((i, assembly.point_between(key(split.reason).word("cut"), place, [*ids.get(i)?, *ids.get(i + 1)?])))
    });
    let nodes: Vec<Option<(usize, PointId)>> = nodes.collect();
    let mut lines = Vec::with_capacity(pieces.len());
    for (i, piece) in pieces.iter().enumerate() {
        let before = i.checked_sub(1).and_then(|i| *nodes.get(i)?);
        let mut points = part(&ids, before, nodes.get(i).copied().flatten());
        if border.inverted {
            points.reverse();
        }
        let middle = (piece.span[0] + piece.span[1]) / 2.0;
        let segments = splits.repainted.iter().filter(|it| it.span[0] <= middle && middle <= it.span[1]);
        let marking = segments.flat_map(|it| &it.markings).find(|(of, _)| *of == edge).map(|(_, marking)| marking);
        let attributes = marking.unwrap_or(&own).clone();
        lines.push(match piece.behind {
            Some(reason) => assembly.line(key(reason), points, attributes),
            None => {
                assembly.reshape_line(border.line, points);
                assembly.retag_line(border.line, attributes);
                border.line
            }
        });
    }
    lines
}
