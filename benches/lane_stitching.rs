//! How long lanes take to be stitched and painted: `cargo bench --bench lane_stitching` weaves 500 lanes all at once and then
//! edits one of them again and again. It fails where an edit costs more than a hundredth of the whole, or either more than its
//! budget.

#![allow(clippy::unwrap_used, reason = "a benchmark that cannot go on must stop")]

mod clock;

use std::hint::black_box;
use std::time::Instant;

use clock::processor_time;
use lanewright::geometry::{Point, Polyline};
use lanewright::lane_stitching::{Kind, Lane, LaneId, LaneStitching, Marking, Paint, Widths};

/// Streets side by side.
const STREETS: u32 = 20;
/// Lanes of a street, one behind the other.
const LANES: u32 = 25;
/// Length of a lane, metres.
const LENGTH: f64 = 100.0;
/// Each time is the least of so many runs.
const RUNS: u32 = 7;
/// What stitching and painting all 500 lanes may take, seconds.
const WHOLE_MOST: f64 = 25e-3;
/// What an edit of one lane may take, seconds.
const EDIT_MOST: f64 = 250e-6;
/// The part of the whole that an edit may cost.
const PART_MOST: f64 = 0.01;

fn main() {
    println!(
        "| lanes | points of a middle line | strokes | all, ms | one lane's paint, µs | one lane's shape, µs | part of all |"
    );
    println!("|---:|---:|---:|---:|---:|---:|---:|");
    for points in [2, 6, 21, 101] {
        row(points);
    }
}

fn row(points: u32) {
    let lanes: Vec<(LaneId, Lane)> = names().map(|id| (id, lane(id, points, 0.0, 70.0))).collect();
    // Several, since the clock is too coarse for one.
    let (whole, _) = least(|_| vec![lanes.clone(); 4], LaneStitching::new);
    let mut weave = LaneStitching::new(lanes);
    let inner = || names().filter(|id| (1..LANES - 1).contains(&id.lane));
    let repainted = |run: u32| inner().map(|id| (id, lane(id, points, 0.0, 60.0 + f64::from(run)))).collect();
    let (paint, anew) = least(repainted, |(id, lane)| weave.set(id, lane));
    assert!(anew.iter().all(|anew| anew.len() == 1));
    // The lane swings out to its side: so both its joints move, and with them both its neighbours.
    let swung = |run: u32| inner().map(|id| (id, lane(id, points.max(3), 1.0 + f64::from(run), 70.0))).collect();
    let (shape, anew) = least(swung, |(id, lane)| weave.set(id, lane));
    assert!(anew.iter().all(|anew| anew.len() == 3), "the lanes do not meet");
    let strokes: usize = weave.iter().map(|(_, lane)| lane.strokes().len()).sum();
    let part = shape / whole;
    println!(
        "| {} | {points} | {strokes} | {:.2} | {:.1} | {:.1} | {:.2} % |",
        weave.iter().count(),
        whole * 1e3,
        paint * 1e6,
        shape * 1e6,
        part * 100.0
    );
    assert!(whole <= WHOLE_MOST, "500 lanes take {:.1} ms", whole * 1e3);
    assert!(shape <= EDIT_MOST, "one lane takes {:.0} µs", shape * 1e6);
    assert!(part < PART_MOST, "one lane takes {:.2} % of all", part * 100.0);
}

fn names() -> impl Iterator<Item = LaneId> {
    (0..STREETS).flat_map(|street| (0..LANES).map(move |lane| LaneId { road: street.into(), lane }))
}

/// A lane of a street that winds to and fro: it swings out by so many metres, and its double line begins at a station.
fn lane(id: LaneId, points: u32, swing: f64, double: f64) -> Lane {
    let across = id.road as f64;
    let place = |i: u32| {
        let part = f64::from(i) / f64::from(points - 1);
        let along = (f64::from(id.lane) + part) * LENGTH;
        // The ends stay where they are to the last bit.
        let out = if i == 0 || i + 1 == points { 0.0 } else { swing * (part * std::f64::consts::PI).sin() };
        Point::new(along, across * 20.0 + 5.0 * (along / 80.0).sin() + out)
    };
    let middle = Polyline::new((0..points).map(place)).unwrap();
    let marking = |station, kind| Marking { station, kinds: vec![kind] };
    let left = vec![marking(0.0, Kind::Dashed(Paint::White)), marking(double, Kind::Double(Paint::Yellow))];
    let right = vec![marking(0.0, Kind::Solid(Paint::White)), marking(50.0, Kind::Kerb)];
    Lane::along(middle, Widths::even(3.5).unwrap()).unwrap().painted([left, right]).unwrap()
}

/// Seconds of processor time that one of many takes, the least of some runs, which are numbered; and what the last of
/// them made.
fn least<I, T>(mut many: impl FnMut(u32) -> Vec<I>, mut make: impl FnMut(I) -> T) -> (f64, Vec<T>) {
    let start = Instant::now();
    let now = || processor_time().unwrap_or_else(|| start.elapsed().as_secs_f64());
    let mut timed = |run| {
        let inputs = many(run);
        let count = inputs.len() as f64;
        let before = now();
        let made: Vec<T> = inputs.into_iter().map(|input| black_box(make(input))).collect();
        ((now() - before) / count, made)
    };
    let mut best = timed(0);
    for run in 1..RUNS {
        let (seconds, made) = timed(run);
        best = (best.0.min(seconds), made);
    }
    best
}
