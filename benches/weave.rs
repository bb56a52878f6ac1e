//! How long lanes take to be stitched and painted: `cargo bench --bench weave` weaves 500 lanes all at once and then
//! edits one of them again and again. It fails where an edit costs more than a hundredth of the whole, or either more than its
//! budget.

#![allow(clippy::unwrap_used, reason = "a benchmark that cannot go on must stop")]

use std::hint::black_box;
use std::time::{Duration, Instant};

use lanewright::geometry::{Point, Polyline};
use lanewright::weave::{Kind, Lane, LaneEnd, LaneId, Marking, Meeting, Paint, Weave, Widths};

/// Lanes of a street, one behind the other.
const LANES_ALONG: u32 = 25;
/// Streets side by side.
const LANES_ACROSS: u32 = 20;
/// Length of a lane, metres.
const LENGTH: f64 = 100.0;
/// Each time is the least of so many runs: what else the machine does only ever adds.
const RUNS: u32 = 50;
/// What stitching and painting all 500 lanes may take.
const WHOLE: Duration = Duration::from_millis(25);
/// What they may take after an edit of one lane.
const EDIT: Duration = Duration::from_micros(250);
/// The part of the whole that an edit may cost.
const PART: f64 = 0.01;

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
    let mut runs: Vec<Vec<(LaneId, Lane)>> = (0..RUNS).map(|_| lanes.clone()).collect();
    let whole = least(|_| Weave::new(runs.pop().unwrap_or_default()));
    let mut weave = Weave::new(lanes);
    let edited = LaneId { road: 3, lane: 12 };
    assert!(matches!(weave.meeting(edited, LaneEnd::End), Some(Meeting::Joined(_))), "the lanes do not meet");
    let paint = least(|run| {
        let anew = weave.set(edited, lane(edited, points, 0.0, 60.0 + f64::from(run)));
        assert_eq!(anew.len(), 1);
    });
    // The lane swings out to its side: so both its joints move, and with them both its neighbours.
    let shape = least(|run| {
        let anew = weave.set(edited, lane(edited, points.max(3), 1.0 + f64::from(run), 70.0));
        assert_eq!(anew.len(), 3);
    });
    let strokes: usize = weave.iter().map(|(_, lane)| lane.strokes().len()).sum();
    let part = shape.as_secs_f64() / whole.as_secs_f64();
    println!(
        "| {} | {points} | {strokes} | {:.2} | {:.1} | {:.1} | {:.2} % |",
        weave.iter().count(),
        whole.as_secs_f64() * 1e3,
        paint.as_secs_f64() * 1e6,
        shape.as_secs_f64() * 1e6,
        part * 100.0
    );
    assert!(whole <= WHOLE, "500 lanes take {whole:?}");
    assert!(shape <= EDIT, "one lane takes {shape:?}");
    assert!(part < PART, "one lane takes {:.2} % of all", part * 100.0);
}

fn names() -> impl Iterator<Item = LaneId> {
    (0..LANES_ACROSS).flat_map(|across| (0..LANES_ALONG).map(move |along| LaneId { road: across.into(), lane: along }))
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

/// The least time of some runs, which are numbered. What they make is thrown away outside.
fn least<T>(mut run: impl FnMut(u32) -> T) -> Duration {
    let timed = |i| {
        let start = Instant::now();
        let made = black_box(run(i));
        let time = start.elapsed();
        drop(made);
        time
    };
    (0..RUNS).map(timed).min().unwrap_or_default()
}
