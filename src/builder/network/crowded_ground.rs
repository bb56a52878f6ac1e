//! Bounds how much road lies on one ground: of more than any city has, ways are left out, and a finding says so. All that lies on one
//! ground has to be compared with all of it.

use std::collections::BTreeMap;

use rustc_hash::FxHashMap;

use crate::builder::tags::values::number_of;
use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::Point;
use crate::osm::Tags;

use super::access::Drivable;
use super::frame::level;
use super::way_runs::Run;

/// The side of the squares of ground, metres.
const SIDE: f64 = 50.0;

/// Metres of road of one level on a square at most, each as often as the road has lanes. Of 54 extracts of real cities the densest
/// square, a crossing of wide main roads, has 1,261.
const MOST: f64 = 2_000.0;

/// The same of all levels: the floors of a car park lie above each other.
const MOST_ABOVE_EACH_OTHER: f64 = 4.0 * MOST;

/// Ends of segments that meet two others or more at their node, on a square at most: a crossing of two streets has two, a side street
/// one. Of the same extracts the densest square has 24.
const MOST_MEETING: usize = 40;

/// The least that a segment counts, metres: many short ones are as much work as a long one.
const LEAST: f64 = 2.0;

/// A square of the ground: how many sides east and north of the origin it lies.
type Square = [i64; 2];

/// The level of a way, and the storey that it has within a building.
type Storey<'a> = (u64, Option<&'a str>);

/// What lies on a square.
#[derive(Default)]
struct Ground {
    /// Metres of road, each as often as the road has lanes.
    metres: f64,
    /// Ends of segments that meet two others or more.
    meeting: usize,
    /// The first way of which a part is left out here.
    first: Option<i64>,
    /// The last way of those, and how many they are.
    last: Option<i64>,
    left_out: usize,
}

impl Ground {
    /// Adds so many metres of a way; whether they are built, where `most` are.
    fn has_room(&mut self, most: f64, metres: f64, way: i64) -> bool {
        self.metres += metres;
        self.metres <= most || self.leaves_out(way)
    }

    /// Adds an end of a way that meets two others or more; whether it is built.
    fn has_room_to_meet(&mut self, way: i64) -> bool {
        self.meeting += 1;
        self.meeting <= MOST_MEETING || self.leaves_out(way)
    }

    /// Notes that a part of a way is not built here: `false`.
    fn leaves_out(&mut self, way: i64) -> bool {
        self.first.get_or_insert(way);
        self.left_out += usize::from(self.last.replace(way) != Some(way));
        false
    }
}

/// The runs without their segments on ground where more road lies than on any real one. Roads of higher classes stay first, then those of
/// smaller ids. Each square decides by what lies on it alone, so that a part of the data comes out as it does in the whole.
pub(super) fn thinned(
    runs: Vec<Run>,
    ways: &[Drivable<'_>],
    positions: &FxHashMap<i64, Point>,
    notes: &mut Vec<Finding>,
) -> Vec<Run> {
    let mut order: Vec<usize> = (0..runs.len()).collect();
    order.sort_by_key(|&at| {
        let way = &ways[runs[at].way];
        (way.class, way.link, way.way.id)
    });
    // Of each level, and of all of them.
    let mut ground: FxHashMap<(Square, Option<Storey>), Ground> = FxHashMap::default();
    let mut ends_at: FxHashMap<i64, usize> = FxHashMap::default();
    let mut left_out: Vec<(usize, usize)> = Vec::new();
    for at in order {
        let run = &runs[at];
        let way = ways[run.way].way;
        let lanes = lanes(&way.tags);
        let storey = (level(&way.tags).to_bits(), way.tags.get("level"));
        for (segment, pair) in run.nodes.windows(2).enumerate() {
            let mut fits = true;
            each_square([positions[&pair[0]], positions[&pair[1]]], |square, metres| {
                let metres = metres.max(LEAST) * lanes;
                // What its own level has no room for does not count among all levels.
                fits &= ground.entry((square, Some(storey))).or_default().has_room(MOST, metres, way.id)
                    && ground.entry((square, None)).or_default().has_room(MOST_ABOVE_EACH_OTHER, metres, way.id);
            });
            for node in pair {
                let ends = ends_at.entry(*node).or_default();
                *ends += usize::from(fits);
                if fits && *ends > 2 {
                    let square = (square_of(positions[node]), None);
                    fits = ground.entry(square).or_default().has_room_to_meet(way.id);
                }
            }
            if !fits {
                left_out.push((at, segment));
            }
        }
    }
    if left_out.is_empty() {
        return runs;
    }
    notes.extend(too_many(&ground));
    left_out.sort_unstable();
    let mut parts = Vec::new();
    let mut left_out = left_out.into_iter().peekable();
    for (at, run) in runs.into_iter().enumerate() {
        let mut without = Vec::new();
        while let Some((_, segment)) = left_out.next_if(|(of, _)| *of == at) {
            without.push(segment);
        }
        if without.is_empty() { parts.push(run) } else { parts.extend(parts_of(&run, &without)) }
    }
    parts
}

/// The parts of a run beside the segments that are left out, which are in order. The road ends there as at the edge of the data.
fn parts_of(run: &Run, without: &[usize]) -> Vec<Run> {
    let last = run.nodes.len() - 1;
    let starts = std::iter::once(0).chain(without.iter().map(|segment| segment + 1));
    let ends = without.iter().copied().chain([last]);
    let between = starts.zip(ends).filter(|(start, end)| start < end);
    let part = |(start, end): (usize, usize)| Run {
        way: run.way,
        nodes: run.nodes[start..=end].to_vec(),
        edge: [start > 0 || run.edge[0], end < last || run.edge[1]],
    };
    between.map(part).collect()
}

/// A finding for each square on which ways are left out, in the order of the squares.
fn too_many(ground: &FxHashMap<(Square, Option<Storey>), Ground>) -> impl Iterator<Item = Finding> {
    let crowded: BTreeMap<_, &Ground> = ground.iter().filter(|(_, ground)| ground.left_out > 0).collect();
    crowded.into_iter().filter_map(|((square, storey), ground)| {
        let first = ground.first?;
        let (most, on) = if storey.is_some() { (MOST, "on one level") } else { (MOST_ABOVE_EACH_OTHER, "on all levels") };
        let there_are = if ground.metres > most {
            format!("{:.0} m of lanes {on}, and {most} m are built", ground.metres)
        } else {
            format!("{} ends of ways that meet others, and {MOST_MEETING} are built", ground.meeting)
        };
        let others = match ground.left_out {
            ..2 => String::new(),
            count => format!(" and {} others", count - 1),
        };
        let message = format!(
            "too many ways: on a square of {SIDE} m there are {there_are}; left out there: way {first}{others}; remove what is \
             drawn twice, or build a smaller part"
        );
        let place = Place::Point(Point::from(square.map(|sides| (sides as f64 + 0.5) * SIDE)));
        let finding = Finding::new("too-many-ways", Subject::Way(first), message).at(place);
        Some(finding.graded(Severity::Warning))
    })
}

/// How many lanes a way has at most by its tags.
fn lanes(tags: &Tags) -> f64 {
    /// As many as a road of that kind has without tags.
    const USUAL: [f64; 2] = [2.0, 1.0];
    /// More are not built.
    const MOST_LANES: f64 = 24.0;
    let tagged = tags.get("lanes").and_then(|value| number_of(value.split(';').next()?));
    let listed = tags.iter().filter(|(key, _)| key.ends_with(":lanes")).map(|(_, list)| list.split('|').count() as f64);
    let usual = USUAL[usize::from(matches!(tags.get("oneway"), Some("yes" | "1" | "true" | "-1")))];
    let told = tagged.into_iter().filter(|count| count.is_finite()).chain(listed);
    told.reduce(f64::max).unwrap_or(usual).clamp(1.0, MOST_LANES)
}

/// The square on which a place lies.
fn square_of(place: Point) -> Square {
    [place.x, place.y].map(|at| (at / SIDE).floor() as i64)
}

/// Calls `each` with the squares that a segment crosses and how much of it, metres, lies on each.
fn each_square([from, to]: [Point; 2], mut each: impl FnMut(Square, f64)) {
    let along = to - from;
    let length = along.norm();
    if square_of(from) == square_of(to) {
        return each(square_of(from), length);
    }
    let mut cuts = vec![0.0, 1.0];
    for axis in 0..2 {
        let [low, high] = [from[axis].min(to[axis]) / SIDE, from[axis].max(to[axis]) / SIDE];
        let lines = (low.ceil() as i64)..=(high.floor() as i64);
        cuts.extend(
            lines.map(|line| (line as f64 * SIDE - from[axis]) / along[axis]).filter(|t| (0.0..1.0).contains(t)),
        );
    }
    cuts.sort_by(f64::total_cmp);
    for pair in cuts.windows(2).filter(|pair| pair[0] < pair[1]) {
        let middle = from + along * ((pair[0] + pair[1]) / 2.0);
        each(square_of(middle), length * (pair[1] - pair[0]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builder::network::hand_drawn::{osm, plane};
    use crate::builder::network::{NetworkOptions, NetworkReading, road_network};

    /// Roads of 30 m side by side on one square, each with these tags, and a road far from them.
    fn side_by_side(count: i64, tags: impl Fn(i64) -> String) -> NetworkReading {
        let mut nodes = vec![(1, 1_000.0, 1_000.0, ""), (2, 1_100.0, 1_000.0, "")];
        let mut ways: Vec<(i64, Vec<i64>, String)> = vec![(1, vec![1, 2], String::new())];
        for i in 0..count {
            let ends = [10 + 2 * i, 11 + 2 * i];
            let east = 5.0 + 30.0 * i as f64 / count as f64;
            nodes.extend([(ends[0], east, 10.0, ""), (ends[1], east, 40.0, "")]);
            ways.push((10 + i, ends.to_vec(), tags(i)));
        }
        let ways: Vec<_> = ways.iter().map(|(id, nodes, tags)| (*id, &nodes[..], &tags[..])).collect();
        road_network(&osm(&nodes, &ways), &plane, &NetworkOptions::default()).unwrap()
    }

    fn ways(built: &NetworkReading) -> Vec<i64> {
        built.network.roads.iter().map(|road| road.key.way).collect()
    }

    fn told(built: &NetworkReading) -> Vec<&Finding> {
        built.notes.iter().filter(|note| note.fault == "too-many-ways").collect()
    }

    #[test]
    fn of_too_many_ways_on_one_square_the_first_are_built() {
        // 33 roads of two lanes are 1,980 m.
        let built = side_by_side(33, |_| "lanes=2".into());
        assert_eq!((ways(&built).len(), told(&built).len()), (34, 0));
        let built = side_by_side(50, |_| "lanes=2".into());
        assert_eq!(ways(&built), [vec![1], (10..43).collect()].concat(), "the smallest ids, and what lies elsewhere");
        let [note] = told(&built)[..] else { panic!("one finding: {:?}", told(&built)) };
        assert!(
            note.message
                .contains("3000 m of lanes on one level, and 2000 m are built; left out there: way 43 and 16 others"),
            "{}",
            note.message
        );
        assert_eq!((note.subject, note.severity), (Subject::Way(43), Some(Severity::Warning)));
        assert_eq!(note.place, Place::Point(Point::new(25.0, 25.0)));
    }

    #[test]
    fn roads_of_a_higher_class_and_narrow_ones_stay() {
        let built = side_by_side(50, |i| if i == 49 { "highway=primary lanes=2".into() } else { "lanes=2".into() });
        assert!(ways(&built).contains(&59), "the last id is a main road: {:?}", ways(&built));
        let built = side_by_side(50, |_| "lanes=1 oneway=yes".into());
        assert_eq!((ways(&built).len(), told(&built).len()), (51, 0));
    }

    #[test]
    fn floors_of_a_car_park_lie_above_each_other() {
        let built = side_by_side(120, |i| format!("lanes=2 layer={}", i % 4));
        assert_eq!((ways(&built).len(), told(&built).len()), (121, 0));
        let built = side_by_side(150, |i| format!("lanes=2 layer={}", i % 150));
        let [note] = told(&built)[..] else { panic!("one finding: {:?}", told(&built)) };
        assert!(
            note.message.contains("on all levels, and 8000 m are built; left out there: way 143 and 16 others"),
            "{}",
            note.message
        );
    }

    #[test]
    fn of_too_many_crossings_on_one_square_the_first_are_built() {
        // Streets along the square, each 4 m from the next, and as many across.
        let built = |along: usize, across: usize| {
            let place =
                |i: usize, k: usize| (10 + (100 * i + k) as i64, 3.0 + 4.0 * k as f64, 3.0 + 4.0 * i as f64, "");
            let nodes: Vec<_> = (0..along).flat_map(|i| (0..across).map(move |k| place(i, k))).collect();
            let id = |i: usize, k: usize| place(i, k).0;
            let mut ways: Vec<(i64, Vec<i64>)> =
                (0..along).map(|i| (1 + i as i64, (0..across).map(|k| id(i, k)).collect())).collect();
            ways.extend((0..across).map(|k| (51 + k as i64, (0..along).map(|i| id(i, k)).collect())));
            let ways: Vec<_> = ways.iter().map(|(id, nodes)| (*id, &nodes[..], "lanes=1 oneway=yes")).collect();
            road_network(&osm(&nodes, &ways), &plane, &NetworkOptions::default()).unwrap()
        };
        assert_eq!(told(&built(5, 6)).len(), 0);
        let crowded = built(9, 10);
        let [note] = told(&crowded)[..] else { panic!("one finding: {:?}", told(&crowded)) };
        assert!(
            note.message.contains("ends of ways that meet others, and 40 are built; left out there: way 5"),
            "{}",
            note.message
        );
        assert!((1..=9).all(|way| ways(&crowded).contains(&way)), "the smaller ids: {:?}", ways(&crowded));
    }

    #[test]
    fn a_way_goes_on_behind_the_crowded_square() {
        let run = Run { way: 0, nodes: vec![1, 2, 3, 4, 5], edge: [false, true] };
        let parts = parts_of(&run, &[1, 2]);
        let parts: Vec<_> = parts.into_iter().map(|part| (part.nodes, part.edge)).collect();
        assert_eq!(parts, [(vec![1, 2], [false, true]), (vec![4, 5], [true, true])]);
        assert!(parts_of(&run, &[0, 1, 2, 3]).is_empty());
    }

    #[test]
    fn squares_share_a_segment() {
        let mut shares = Vec::new();
        each_square([Point::new(-10.0, 20.0), Point::new(90.0, 20.0)], |square, metres| shares.push((square, metres)));
        assert_eq!(shares, [([-1, 0], 10.0), ([0, 0], 50.0), ([1, 0], 40.0)]);
    }
}
