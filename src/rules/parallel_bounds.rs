//! Bounds of two lanes that run along each other but are two separate ways.

use rayon::prelude::*;

use crate::diagnostic::Edit;
use crate::geometry::{Point, Polyline, Vector};
use crate::lanelet::LineStringId;
use crate::lanelet::index::thresholds;
use crate::lanelet::index::view::boxes_meet;
use crate::lanelet::index::{Lane, MapIndex, extent};
use crate::parallel::InSmallParts;

/// Distance between measurements along a bound, metres: short compared with any lane.
const MEASURED_EVERY: f64 = 1.0;

/// How close two bounds must be to count as one.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// Largest distance between the two, metres.
    pub apart: f64,
    /// Share of the shorter one that has to be this close (1).
    pub share: f64,
}

/// Two lanes side by side, each with a bound of its own where the other's runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParallelBounds {
    /// The lanes, by their positions.
    pub lanes: [usize; 2],
    /// The bound of each.
    pub ways: [LineStringId; 2],
    /// How long each bound is, metres.
    pub lengths: [f64; 2],
    /// Whether the lanes run against each other.
    pub opposed: bool,
    /// Whether both bounds join the same two points.
    same_ends: bool,
}

/// A bound with what is asked of it for each pair.
pub struct Border {
    /// Its points.
    pub line: Polyline,
    /// How long it is, metres.
    pub length: f64,
    /// Corners of its box.
    pub extent: [Point; 2],
}

impl Border {
    /// Measures a bound.
    pub fn of(line: Polyline) -> Self {
        Self { length: line.length(), extent: extent(line.points()), line }
    }

    /// Its box, larger by a distance (m) on all sides.
    pub fn around(&self, distance: f64) -> [Point; 2] {
        let ([low, high], margin) = (self.extent, Vector::repeat(distance));
        [low - margin, high + margin]
    }
}

/// The bounds of a lane, left and right.
type Bounds = [Option<Border>; 2];

impl ParallelBounds {
    /// Which of two lanes' bounds run along each other; `None` if none do, or if the lanes have a way in common.
    fn of(map: &MapIndex, [one, other]: [usize; 2], lines: [&Bounds; 2], reach: Reach) -> Option<Self> {
        let (a, b) = (&map.lanes[one], &map.lanes[other]);
        if a.bounds.iter().any(|way| b.bounds.contains(way)) || on_two_levels(a, b) {
            return None;
        }
        let sides = [(0, 0), (0, 1), (1, 0), (1, 1)];
        sides.into_iter().find_map(|(i, j)| {
            let (mine, theirs) = (lines[0][i].as_ref()?, lines[1][j].as_ref()?);
            let [short, long] = if mine.length <= theirs.length { [mine, theirs] } else { [theirs, mine] };
            if !runs_along(short, long, reach) {
                return None;
            }
            let (middle, short, long) = (short.length / 2.0, &short.line, &long.line);
            // Lanes that run the same way lie side by side where one's left is the other's right, and else on each other.
            let facing = long.direction(long.project(short.at(middle)).station);
            let opposed = short.direction(middle).dot(&facing) < 0.0;
            let ends = |lane: &Lane, side: usize| [lane.start.ids[side], lane.end.ids[side]];
            let (mut own, mut other_ends) = (ends(a, i), ends(b, j));
            own.sort_unstable();
            other_ends.sort_unstable();
            (opposed == (i == j)).then(|| Self {
                lanes: [one, other],
                ways: [a.bounds[i], b.bounds[j]],
                lengths: [mine.length, theirs.length],
                opposed,
                same_ends: own == other_ends,
            })
        })
    }

    /// The edit that lets the second lane use the first one's way; `None` where it would change which lanes follow each other.
    pub fn shared(&self, map: &MapIndex) -> Option<Edit> {
        let [to, from] = self.ways;
        self.same_ends.then(|| Edit::ReplaceWay { lanelet: map.lanes[self.lanes[1]].id.0, from: from.0, to: to.0 })
    }
}

/// Whether the required share of a bound lies close to another.
fn runs_along(border: &Border, other: &Border, reach: Reach) -> bool {
    let around = other.around(reach.apart);
    if !boxes_meet(border.extent, around) {
        return reach.share <= 0.0;
    }
    let mut places = border.line.places(MEASURED_EVERY);
    let count = places.len();
    // Of long bounds that only cross, most places need not be looked at.
    let spacing = border.length / (count - 1) as f64;
    let inside = border.line.segments().filter_map(|ends| length_inside(ends, around));
    let most: f64 = inside.map(|length| length / spacing + 2.0).sum();
    if most < reach.share * count as f64 {
        return false;
    }
    let (mut far, mut hint) = (0, 0);
    places.all(|p| {
        far += usize::from(!boxes_meet([p; 2], around) || !other.line.reaches(p, reach.apart, &mut hint));
        (count - far) as f64 / count as f64 >= reach.share
    })
}

/// How much of a segment, metres, lies in a box; `None` if it does not reach it.
fn length_inside((a, b): (Point, Point), [low, high]: [Point; 2]) -> Option<f64> {
    /// What is a hair beside the box counts.
    const HAIR: f64 = 1e-6;
    let along = b - a;
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let [least, most] = [low[axis] - HAIR - a[axis], high[axis] + HAIR - a[axis]];
        if along[axis] == 0.0 {
            if least > 0.0 || most < 0.0 {
                return None;
            }
            continue;
        }
        let [one, other] = [least / along[axis], most / along[axis]];
        (from, to) = (from.max(one.min(other)), to.min(one.max(other)));
    }
    (from <= to).then(|| along.norm() * (to - from))
}

/// Whether the height ranges of two lanes are so far apart that they cannot be on one level.
pub fn on_two_levels(a: &Lane, b: &Lane) -> bool {
    let gap = (a.heights[0] - b.heights[1]).max(b.heights[0] - a.heights[1]);
    gap > thresholds::GRADE_SEPARATION
}

/// All pairs of lanes whose bounds run along each other, where `first` accepts the one, by its position, and `second` the other.
pub fn all(
    map: &MapIndex,
    reach: Reach,
    first: impl Fn(usize) -> bool + Sync,
    second: impl Fn(usize) -> bool + Sync,
) -> Vec<ParallelBounds> {
    let taking_part = |at: usize| {
        if first(at) || second(at) {
            [0, 1].map(|side| map.lanes[at].border(side).map(Border::of))
        } else {
            Bounds::default()
        }
    };
    let lanes = || (0..map.lanes.len()).into_par_iter().in_small_parts();
    let lines: Vec<Bounds> = lanes().map(taking_part).collect();
    let of_lane = |at: usize| {
        let [low, high] = map.lanes[at].extent;
        let margin = Vector::repeat(reach.apart);
        let near = map.lanes_near(low - margin, high + margin).into_iter();
        let others = near.filter(|&other| other != at && second(other));
        others
            .filter_map(|other| ParallelBounds::of(map, [at, other], [&lines[at], &lines[other]], reach))
            .collect::<Vec<_>>()
    };
    lanes().filter(|&at| first(at)).flat_map_iter(of_lane).collect()
}
