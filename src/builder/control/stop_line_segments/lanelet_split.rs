//! Cuts a road across, all its lanes and what lies beside them abreast.
//!
//! A bound is one line with one marking, and a lanelet obeys one light. Where either changes, the road is cut: neighbours
//! share their bounds on both sides of the cut, and what continues each other its end nodes. The first piece keeps the ids
//! of the road.

use crate::builder::control::pedestrian_crossing_signals::SignalisedCrossing;
use crate::builder::lanes::lanelet_validity::{are_read_as_drawn, is_simple, is_valid};
use crate::builder::lanes::road_cut::STOP_GAP;
use crate::builder::lanes::types::{Lanes, RoadLane, RoadPiece, SplitReason};
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::road_end::at_depth;
use crate::builder::network::{End, Road, RoadIx, RoadNetwork};
use crate::builder::streets::heights::Ground;
use crate::builder::tags::side_strips::strip_runs;
use crate::geometry::{Point, Vector, cross};
use crate::lanelet::{Attributes, Bound, LineStringId, PointId};

/// No cut comes closer than this, metres, to another point of a border.
const CLEAR: f64 = 0.5;
/// A border crosses the cut no farther than this, metres, from where the cross-section has it.
const ASIDE: f64 = 1.0;
/// No piece is shorter than this, metres.
const PIECE: f64 = 2.0;
/// The begin of a stretch so near to another cut, metres, is that cut.
const NEAR: f64 = 5.0;
/// The begin of a stretch that cannot lie where it should is moved by this, metres, toward the stop line,
const STEP: f64 = 0.5;
/// at most so many times.
const STEPS: usize = 20;
/// So far, metres, a stop line before a crosswalk is moved away from it, or toward it, where it cannot lie as it should.
const GAPS: [f64; 7] = [0.0, 0.5, -0.5, 1.0, 1.5, 2.0, -0.8];

/// Where a cut meets each border, by edges of the cross-section: behind which of its points, and the place.
type Places = Vec<Option<(usize, Point)>>;

/// A cut across a road.
pub struct LaneletCut {
    /// Along the road's line, metres.
    station: f64,
    cause: SplitReason,
    places: Places,
}

/// Finds where a road can be cut.
pub struct LaneletSplitter<'a> {
    road: &'a Road,
    span: [f64; 2],
    /// The borders of the whole road.
    lines: Vec<Option<Vec<Point>>>,
    /// By stations.
    cuts: Vec<LaneletCut>,
}

impl<'a> LaneletSplitter<'a> {
    /// For a road of one piece.
    pub fn new(assembly: &MapBuilder, road: &'a Road, whole: &RoadPiece) -> Self {
        let lines = whole.borders.iter().map(|it| it.map(|it| assembly.bound_line(it))).collect();
        Self { road, span: whole.span, lines, cuts: Vec::new() }
    }

    /// The cuts by stations.
    pub fn into_cuts(self) -> Vec<LaneletCut> {
        self.cuts
    }

    /// Cuts where those who drive toward an end stop before a crosswalk, if they are not on another road there.
    pub fn cut_at_stop_line(&mut self, lit: &SignalisedCrossing, toward: End) {
        let stations = GAPS.map(|gap| at_depth(lit.span, toward.other(), -STOP_GAP - gap));
        if stations.first().is_some_and(|&station| self.is_clear(station)) {
            let _ = stations.into_iter().any(|station| self.cut(station, SplitReason::Line(lit.node, toward)));
        }
    }

    /// Cuts as far before the stop line of those who drive toward an end as they want, but by half of the way that they
    /// have to it at most, and by the least at least; gives the station.
    pub fn cut_stretch(&mut self, cause: SplitReason, line: f64, toward: End, wanted: f64, least: f64) -> Option<f64> {
        let sign = if toward == End::End { 1.0 } else { -1.0 };
        let depth_of = |station: f64| (line - station) * sign;
        let lines =
            self.cuts.iter().filter(|cut| matches!(cut.cause, SplitReason::Line(..))).map(|cut| depth_of(cut.station));
        // The stop line itself may have been moved.
        let before = lines.filter(|depth| *depth > STOP_GAP + STEP);
        let room = before.fold(depth_of(self.span[toward.other().index()]), f64::min);
        let (most, least) = (wanted.min(room / 2.0), least.min(wanted));
        let depths = (0..STEPS).map(|i| most - i as f64 * STEP).take_while(|&depth| depth >= least && depth > 0.0);
        let stations: Vec<f64> = depths.map(|depth| line - depth * sign).collect();
        let wanted = *stations.first()?;
        let off = |station: f64| (station - wanted).abs();
        let known = self.cuts.iter().map(|cut| cut.station).filter(|&cut| off(cut) < NEAR && depth_of(cut) >= least);
        let known = known.min_by(|&a, &b| off(a).total_cmp(&off(b)));
        known.or_else(|| stations.into_iter().find(|&station| self.cut(station, cause)))
    }

    /// Whether no piece becomes too short by a cut.
    fn is_clear(&self, station: f64) -> bool {
        let [from, to] = self.span;
        let apart = |other: f64| (station - other).abs() >= PIECE;
        station - from >= PIECE && to - station >= PIECE && self.cuts.iter().all(|cut| apart(cut.station))
    }

    /// Cuts the road at a station; `false` if it cannot be cut there.
    fn cut(&mut self, station: f64, cause: SplitReason) -> bool {
        if !self.is_clear(station) {
            return false;
        }
        let Some(places) = self.places(station) else { return false };
        let at = self.cuts.partition_point(|cut| cut.station < station);
        let [before, behind] = [at.checked_sub(1), Some(at)].map(|i| self.cuts.get(i?).map(|cut| &cut.places));
        let pair = |edges: [usize; 2]| -> Option<[[Vec<Point>; 2]; 3]> {
            let of = |from: Option<&Places>, to: Option<&Places>| {
                let of = |edge: usize| Some(part(self.lines[edge].as_ref()?, place(from, edge), place(to, edge)));
                Some([of(edges[0])?, of(edges[1])?])
            };
            Some([of(before, behind)?, of(before, Some(&places))?, of(Some(&places), behind)?])
        };
        let section = &self.road.section;
        let mut lanes = section.driven().filter_map(|(i, _)| pair([i, i + 1]));
        let read_as_drawn =
            |it: &[Vec<Point>; 2]| is_simple(it) && are_read_as_drawn(it) && are_read_as_drawn(&turned(it));
        let width = |strips: std::ops::Range<usize>| section.strips[strips].iter().map(|s| s.width).sum::<f64>();
        let beside = strip_runs(section).into_iter();
        let mut beside = beside.filter_map(|run| Some((pair([run.strips.start, run.strips.end])?, width(run.strips))));
        let whole = lanes.all(|[_, a, b]| read_as_drawn(&a) && read_as_drawn(&b))
            && beside
                .all(|([whole, a, b], width)| !is_valid(&whole, width) || is_valid(&a, width) && is_valid(&b, width));
        if whole {
            self.cuts.insert(at, LaneletCut { station, cause, places });
        }
        whole
    }

    /// Where the borders are cut across at a station; `None` if they cannot be.
    fn places(&self, station: f64) -> Option<Places> {
        let (middle, along) = (self.road.line.at(station), self.road.line.direction(station));
        let wanted = |edge: usize| middle + crate::geometry::left_of(along) * self.road.section.edge(edge);
        let place = |(edge, line): (usize, &Option<Vec<Point>>)| match line {
            Some(line) => crossing(line, wanted(edge), along).map(Some),
            None => Some(None),
        };
        self.lines.iter().enumerate().map(place).collect()
    }
}

fn place(places: Option<&Places>, edge: usize) -> Option<(usize, Point)> {
    *places?.get(edge)?
}

/// The same lane, run through the other way.
fn turned([left, right]: &[Vec<Point>; 2]) -> [Vec<Point>; 2] {
    [right, left].map(|line| line.iter().rev().copied().collect())
}

/// Where a line crosses the cut through a place, nearest to that place: behind which of its points. `None` where it does
/// not, or close to a point.
fn crossing(line: &[Point], wanted: Point, along: Vector) -> Option<(usize, Point)> {
    let across = |(i, pair): (usize, &[Point])| {
        let [before, behind] = [0, 1].map(|i| (pair[i] - wanted).dot(&along));
        (before < 0.0 && behind >= 0.0).then(|| (i, pair[0] + (pair[1] - pair[0]) * (before / (before - behind))))
    };
    let off = |(_, place): &(usize, Point)| cross(along, place - wanted).abs();
    let nearest = line.windows(2).enumerate().filter_map(across).min_by(|a, b| off(a).total_cmp(&off(b)));
    let (i, place) = nearest.filter(|found| off(found) <= ASIDE)?;
    [line[i], line[i + 1]].iter().all(|point| (point - place).norm() >= CLEAR).then_some((i, place))
}

/// What lies of a row between two places, each behind one of its members; to its ends where there is none.
fn part<T: Copy>(row: &[T], from: Option<(usize, T)>, to: Option<(usize, T)>) -> Vec<T> {
    let first = from.map_or(0, |(i, _)| i + 1);
    let last = to.map_or(row.len(), |(i, _)| i + 1);
    let inner = row.get(first..last.max(first)).unwrap_or_default().iter().copied();
    from.map(|it| it.1).into_iter().chain(inner).chain(to.map(|it| it.1)).collect()
}

impl Lanes {
    /// Divides roads, in their order, where they are cut, and paints stretches of them.
    pub(super) fn divide(
        &mut self,
        assembly: &mut MapBuilder,
        network: &RoadNetwork,
        found: Vec<(RoadIx, Vec<LaneletCut>, Vec<Stretch>)>,
    ) {
        let mut known = std::mem::take(&mut self.lanes).into_iter().peekable();
        let mut found = found.into_iter().peekable();
        let mut first = 0;
        for (i, (arms, pieces)) in self.arms.iter_mut().zip(&mut self.pieces).enumerate() {
            let ix = RoadIx::new(i);
            let own: Vec<RoadLane> = std::iter::from_fn(|| known.next_if(|lane| lane.road == ix)).collect();
            let begin = self.lanes.len();
            let count = own.len();
            self.lanes.extend(own);
            if let Some((_, cuts, stretches)) = found.next_if(|(road, ..)| *road == ix)
                && let Some(whole) = pieces.pop()
            {
                let own = &self.lanes[begin..];
                let (divided, more) = divided(assembly, network.road(ix), (&whole, own), &cuts, &stretches);
                *pieces = divided;
                self.lanes.extend(more);
            }
            let last = self.lanes.len() - count;
            for (arm, begin) in arms.iter_mut().zip([begin, last]) {
                arm.into.iter_mut().chain(&mut arm.out).for_each(|end| end.lane = end.lane - first + begin);
            }
            first += count;
        }
        assembly.set_ground(Ground::default());
    }
}

/// The pieces of a road, and the lanes of all but the first.
fn divided(
    assembly: &mut MapBuilder,
    road: &Road,
    (whole, lanes): (&RoadPiece, &[RoadLane]),
    cuts: &[LaneletCut],
    stretches: &[Stretch],
) -> (Vec<RoadPiece>, Vec<RoadLane>) {
    assembly.set_ground(Ground::under(road));
    let mut pieces: Vec<RoadPiece> = Vec::with_capacity(cuts.len() + 1);
    for i in 0..=cuts.len() {
        let (before, behind) = (i.checked_sub(1).and_then(|i| cuts.get(i)), cuts.get(i));
        let station = |cut: Option<&LaneletCut>, end: End| cut.map_or(whole.span[end], |cut| cut.station);
        let span = [station(before, End::Start), station(behind, End::End)];
        pieces.push(RoadPiece { behind: before.map(|cut| cut.cause), span, borders: vec![None; whole.borders.len()] });
    }
    for (edge, border) in whole.borders.iter().enumerate() {
        let Some(border) = *border else { continue };
        let lines = border_pieces(assembly, road, (edge, border), cuts, &pieces, stretches);
        for (piece, line) in pieces.iter_mut().zip(lines) {
            piece.borders[edge] = Some(Bound { line, ..border });
        }
    }
    let mut more = Vec::with_capacity(lanes.len() * cuts.len());
    for piece in &pieces {
        let Some(cause) = piece.behind else { continue };
        let beyond = |bound: Bound| {
            let edge = whole.borders.iter().position(|border| border.is_some_and(|it| it.line == bound.line));
            let line = edge.and_then(|edge| piece.borders[edge]).map_or(bound.line, |it| it.line);
            Bound { line, ..bound }
        };
        for lane in lanes {
            let (left, right) = (beyond(lane.left), beyond(lane.right));
            let attributes = assembly.lanelet_of(lane.lanelet).map(|it| it.attributes.clone()).unwrap_or_default();
            let key = cause.of(road.key_of("lane")).number(lane.strip as i64).number(i64::from(lane.backward));
            let lanelet = assembly.lanelet(key, left, right, attributes);
            more.push(RoadLane { lanelet, left, right, ..lane.clone() });
        }
    }
    (pieces, more)
}

/// Shortens a border to the first piece of its road, and draws the others anew, painted as it was or as stretches say.
fn border_pieces(
    assembly: &mut MapBuilder,
    road: &Road,
    (edge, border): (usize, Bound),
    cuts: &[LaneletCut],
    pieces: &[RoadPiece],
    stretches: &[Stretch],
) -> Vec<LineStringId> {
    let ids = assembly.bound_ids(border);
    let own = assembly.line_of(border.line).map(|line| line.attributes.clone()).unwrap_or_default();
    let key = |cause: SplitReason| cause.of(road.key_of("border")).number(edge as i64);
    let nodes = cuts.iter().map(|cut| {
        let (i, place) = place(Some(&cut.places), edge)?;
        Some((i, assembly.point_between(key(cut.cause).word("cut"), place, [*ids.get(i)?, *ids.get(i + 1)?])))
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
        let stretch = stretches.iter().filter(|it| it.span[0] <= middle && middle <= it.span[1]);
        let painted = stretch.flat_map(|it| &it.painted).find(|(of, _)| *of == edge).map(|(_, marking)| marking);
        let attributes = painted.unwrap_or(&own).clone();
        lines.push(match piece.behind {
            Some(cause) => assembly.line(key(cause), points, attributes),
            None => {
                assembly.reshape_line(border.line, points);
                assembly.retag_line(border.line, attributes);
                border.line
            }
        });
    }
    lines
}

/// A part of a road where some of its edges are painted otherwise.
pub struct Stretch {
    /// Between which stations.
    pub span: [f64; 2],
    /// What is painted on which edge.
    pub painted: Painted,
}

/// Edges of a road's cross-section with what is painted there before the stop line.
pub type Painted = Vec<(usize, Attributes)>;
