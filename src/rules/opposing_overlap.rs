//! Lanes of opposite directions that overlap, wholly or in part.

use rayon::prelude::*;

use crate::geometry::{Polyline, Vector, angle_between, polygon};
use crate::lanelet::index::{Lane, MapIndex};
use crate::parallel::InSmallParts;

use super::crowd;

/// Two headings are opposite if the cosine of the angle between them is below this: 150 degrees and more.
const AGAINST: f64 = -0.866;

/// Two lanes that overlap and run against each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpposingOverlap {
    /// The lanes, by position, in the order of the map.
    pub lanes: [usize; 2],
    /// Overlap as a share of the smaller lane's area (1).
    pub share: f64,
    /// The same, m2.
    pub area: f64,
    /// Whether both bounds of one are those of the other, each on the other side.
    pub swapped: bool,
}

/// Whether a lane is for cars, driven forward, and outside every intersection; inside one, lanes have to cross, and a lane in which
/// vehicles reverse lies on those in which they drive.
pub fn is_plain(map: &MapIndex, at: usize) -> bool {
    let lane = &map.lanes[at];
    lane.is_for_cars() && lane.simple && !lane.reverses() && map.intersections_of(at).is_empty()
}

/// Mean width of a lane, metres.
pub fn width(lane: &Lane) -> Option<f64> {
    let length = lane.length();
    (length > 1.0).then(|| lane.area / length)
}

/// All pairs of a map.
pub fn all(map: &MapIndex) -> Vec<OpposingOverlap> {
    let headings: Vec<Option<Headings>> =
        map.lanes.iter().map(|lane| lane.center.as_ref().and_then(Headings::of)).collect();
    let of_lane = |at: usize| {
        let mut others: Vec<usize> = crosswise(map, at).collect();
        let conflicts = map.conflicts[at].iter().filter(|conflict| conflict.real && !conflict.grade_separated);
        others.extend(conflicts.map(|conflict| conflict.other));
        others.sort_unstable();
        others.dedup();
        let may_oppose =
            |other: usize| headings[at].zip(headings[other]).is_none_or(|(mine, theirs)| mine.may_oppose(theirs));
        others.retain(|&other| other > at && is_plain(map, other) && may_oppose(other));
        // Where more lie on it, vm-07-08 says so.
        let found = others.into_iter().filter_map(|other| judge(map, at, other)).take(crowd::MOST);
        found.collect::<Vec<_>>()
    };
    let lanes = (0..map.lanes.len()).into_par_iter().in_small_parts();
    lanes.filter(|&at| is_plain(map, at)).flat_map_iter(of_lane).collect()
}

/// Between which directions a line runs: the one from end to end, and how far it turns away from it, radians.
#[derive(Clone, Copy)]
struct Headings {
    chord: Vector,
    away: f64,
}

impl Headings {
    fn of(line: &Polyline) -> Option<Self> {
        let chord = (line.last() - line.first()).try_normalize(Polyline::MERGE)?;
        let away = line.segments().map(|(a, b)| angle_between(chord, b - a).abs()).fold(0.0, f64::max);
        Some(Self { chord, away })
    }

    /// Whether somewhere on the two lines the directions can be opposite: most lanes that cross need no closer look.
    fn may_oppose(self, other: Self) -> bool {
        /// Radians by which no rounding is off.
        const SPARE: f64 = 1e-6;
        angle_between(self.chord, other.chord).abs() + self.away + other.away + SPARE > AGAINST.acos()
    }
}

/// Lanes that have a bound of this one on the other side: left as right, right as left.
fn crosswise<'a>(map: &'a MapIndex<'a>, at: usize) -> impl Iterator<Item = usize> + 'a {
    let [left, right] = map.lanes[at].bounds;
    let as_right = map.users_of(left).iter().copied().filter(move |&other| map.lanes[other].bounds[1] == left);
    let as_left = map.users_of(right).iter().copied().filter(move |&other| map.lanes[other].bounds[0] == right);
    as_right.chain(as_left)
}

fn judge(map: &MapIndex, at: usize, other: usize) -> Option<OpposingOverlap> {
    let (a, b) = (&map.lanes[at], &map.lanes[other]);
    let (mine, theirs) = (a.center.as_ref()?, b.center.as_ref()?);
    let [short, long] = if mine.length() <= theirs.length() { [mine, theirs] } else { [theirs, mine] };
    // Along the whole lane: one that turns across the other opposes it only for a part.
    let against = [0.1, 0.5, 0.9].map(|part| part * short.length()).iter().all(|&station| {
        let facing = long.direction(long.project(short.at(station)).station);
        short.direction(station).dot(&facing) < AGAINST
    });
    if !against {
        return None;
    }
    let area = polygon::overlap(&a.outline, &b.outline);
    let share = area / a.area.min(b.area);
    let swapped = a.bounds[0] == b.bounds[1] && a.bounds[1] == b.bounds[0];
    Some(OpposingOverlap { lanes: [at, other], share, area, swapped })
}
