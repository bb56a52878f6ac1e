//! vm-03-03: lanelets of an intersection keep their width and bend smoothly.

use serde::Deserialize;

use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::{Point, Polyline, Vector, angle_between, curve};
use crate::lanelet::LineStringId;
use crate::lanelet::index::{Lane, MapIndex, tangent};
use crate::rules::disordered_bound::with_points_in_order;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    width: [f64; 2],
    vehicle_width: [f64; 3],
    bicycle_width: [f64; 2],
    kink: [f64; 2],
    curvature: [f64; 2],
    jagged_center: f64,
    jagged: [f64; 2],
    joint: [f64; 2],
}

/// Steps along a line between measurements, metres: bends of a hand-drawn line within one are no bends.
const MEASURED_EVERY: f64 = 1.0;
/// Widths are told to this, metres.
const EXACT: f64 = 0.01;
/// Curvature is measured over steps of this length, metres, as Autoware's paths are.
const CURVATURE_STEP: f64 = 2.0;
/// Over so many steps the bend of a lane next to a lanelet is measured.
const BEND_STEPS: usize = 4;
/// What bends within this distance (m) is one bend of the lane: its bounds lie so far apart, or one of them begins to bend before.
const ONE_BEND: f64 = 8.0;
/// A bend goes on if it is at most so many times as tight as that before it.
const BENDS_ON: f64 = 1.5;

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let mut findings = Vec::new();
    let inside = map.intersections.iter().zip(&map.traffic).filter(|(intersection, _)| intersection.area.is_some());
    for movement in inside.flat_map(|(_, traffic)| &traffic.movements) {
        let lane = &map.lanes[movement.lane];
        let Some(center) = &lane.center else { continue };
        findings.extend(widths(map, params, movement.lane, center));
        let bends = kinks(map, params, lane, center).into_iter().chain(curvature(params, lane, center));
        findings.extend(one_for_each_bend(bends.collect()));
        findings.extend(jaggedness(map, params, movement.lane, center));
        findings.extend(joints(map, params, movement.lane));
    }
    findings
}

/// Warning beyond the first limit, error beyond the second; `None` within both.
fn grade(value: f64, [warning, error]: [f64; 2]) -> Option<Severity> {
    match value {
        _ if value > error => Some(Severity::Error),
        _ if value > warning => Some(Severity::Warning),
        _ => None,
    }
}

/// Whether another lanelet lies on this one and runs against it.
fn is_used_both_ways(map: &MapIndex, lane: &Lane) -> bool {
    let [left, right] = lane.bounds;
    map.users_of(left).iter().any(|&other| map.lanes[other].bounds == [right, left])
}

fn widths(map: &MapIndex, params: &Params, at: usize, center: &Polyline) -> Vec<Finding> {
    let lane = &map.lanes[at];
    let bounds = [&lane.left, &lane.right].map(|bound| Polyline::new(bound.iter().copied()));
    let [Some(left), Some(right)] = bounds else { return Vec::new() };
    let middle = center.resampled(MEASURED_EVERY);
    let width: Vec<f64> = middle.points().iter().map(|&p| left.distance(p) + right.distance(p)).collect();
    let mut sorted = width.clone();
    sorted.sort_by(f64::total_cmp);
    let (median, last) = (sorted[sorted.len() / 2], width.len() - 1);
    let subject = Subject::Lanelet(lane.id.0);
    let mut findings = Vec::new();
    let taper = |i: usize| width[0] + (width[last] - width[0]) * i as f64 / last as f64;
    let off = |i: &usize| (width[*i] - taper(*i)).abs() / median.max(Polyline::MERGE);
    if let Some(worst) = (0..=last).max_by(|a, b| off(a).total_cmp(&off(b)))
        && let Some(severity) = grade(off(&worst), params.width)
    {
        let station = center.length() * worst as f64 / last as f64;
        let percent = 100.0 * off(&worst);
        let message = format!("Width of {} deviates {percent:.0} % from a linear taper at {station:.0} m.", lane.id);
        let finding = Finding::new("width", subject, message).measured(percent, 100.0 * params.width[0], "%");
        findings.push(finding.at(Place::Point(middle.points()[worst])).graded(severity));
    }
    let [least, low, high] = match lane.bicycle {
        true => {
            let [low, high] = params.bicycle_width;
            [0.0, low, if is_used_both_ways(map, lane) { 2.0 * high } else { high }]
        }
        false => params.vehicle_width,
    };
    let extremes = [(sorted[0], sorted[0] < low - EXACT, low), (sorted[last], sorted[last] > high + EXACT, high)];
    for (value, _, limit) in extremes.into_iter().filter(|(_, broken, _)| *broken) {
        let at = width.iter().position(|w| *w == value).unwrap_or(0);
        let message = format!("Lanelet {} is {value:.2} m wide; {limit} m is the limit.", lane.id);
        let finding = Finding::new("width-abs", subject, message).measured(value, limit, "m");
        let severity = if value < least { Severity::Error } else { Severity::Warning };
        findings.push(finding.at(Place::Point(middle.points()[at])).graded(severity));
    }
    findings
}

/// The two bounds and the centre line, each with its name and way.
fn lines<'a>(lane: &'a Lane, center: &'a Polyline) -> Vec<(&'static str, Option<LineStringId>, Polyline)> {
    let bound = |points: &[Point]| Polyline::new(points.iter().copied());
    let all = [
        ("Left bound", Some(lane.bounds[0]), bound(&lane.left)),
        ("Right bound", Some(lane.bounds[1]), bound(&lane.right)),
        ("Centre line", None, Some(center.clone())),
    ];
    all.into_iter().filter_map(|(name, way, line)| Some((name, way, line?))).collect()
}

/// Changes of direction at the inner points, degrees, left positive.
fn turns(line: &Polyline) -> Vec<f64> {
    line.points().windows(3).map(|w| angle_between(w[1] - w[0], w[2] - w[1]).to_degrees()).collect()
}

/// A line of a lane that bends too much.
struct Bend {
    finding: Finding,
    place: Point,
    /// The same in a few words.
    short: String,
}

/// One finding for each bend, the worst one, which names what else bends there.
fn one_for_each_bend(mut bends: Vec<Bend>) -> Vec<Finding> {
    bends.sort_by_key(|one| std::cmp::Reverse(one.finding.severity));
    let mut of_each: Vec<(Bend, Vec<Bend>)> = Vec::new();
    for bend in bends {
        let same = of_each.iter_mut().find(|(first, _)| (first.place - bend.place).norm() <= ONE_BEND);
        match same {
            Some((_, others)) => others.push(bend),
            None => of_each.push((bend, Vec::new())),
        }
    }
    let one = |(first, others): (Bend, Vec<Bend>)| {
        let shorts: Vec<&str> = others.iter().map(|other| other.short.as_str()).collect();
        let mut finding = first.finding;
        if !shorts.is_empty() {
            finding.message = format!("{} ({}).", finding.message.trim_end_matches('.'), shorts.join(", "));
        }
        let bounds = others.iter().flat_map(|other| &other.finding.related);
        bounds.fold(finding, |finding, other| match finding.related.contains(other) {
            true => finding,
            false => finding.with(other.subject, other.part),
        })
    };
    of_each.into_iter().map(one).collect()
}

fn kinks(map: &MapIndex, params: &Params, lane: &Lane, center: &Polyline) -> Vec<Bend> {
    let findings = lines(lane, center).into_iter().filter_map(|(name, way, line)| {
        let (bend, place) = sharpest(&line)?;
        let severity = grade(bend, params.kink)?;
        let finding = |at: String| {
            let message = format!("{name} of {} bends {bend:.0} deg at {at}.", lane.id);
            Finding::new("kink", Subject::Lanelet(lane.id.0), message)
        };
        let far = |id: &&crate::lanelet::PointId| {
            map.map.points.get(**id).map_or(f64::INFINITY, |point| (point.position - place).norm())
        };
        let points = way.and_then(|way| map.map.linestrings.get(way)).map(|line| &line.points);
        let node = points.and_then(|ids| ids.iter().min_by(|a, b| far(a).total_cmp(&far(b))));
        let finding = match (node, way) {
            (Some(node), Some(way)) => finding(format!("node {node}"))
                .with(Subject::LineString(way.0), "bound")
                .with(Subject::Point(node.0), "node"),
            _ => finding(format!("{:.0} m", center.project(place).station)),
        };
        let finding = finding.measured(bend, params.kink[0], "deg").at(Place::Point(place)).graded(severity);
        let finding = match way {
            Some(way) => with_points_in_order(map, finding, way),
            None => finding,
        };
        Some(Bend { finding, place, short: format!("{} {bend:.0} deg", name.to_lowercase()) })
    });
    findings.collect()
}

/// The largest change of direction between the metres before and behind a place, degrees. Looked for at even steps and
/// at the points of the line: a dent between two steps would hide.
fn sharpest(line: &Polyline) -> Option<(f64, Point)> {
    let even = line.resampled(MEASURED_EVERY);
    let steps = turns(&even).into_iter().zip(even.points().iter().skip(1).copied());
    let length = line.length();
    let mut inner = line.stations();
    inner.retain(|at| (MEASURED_EVERY..=length - MEASURED_EVERY).contains(at));
    let [before, here, behind] =
        [-MEASURED_EVERY, 0.0, MEASURED_EVERY].map(|by| line.at_each(inner.iter().map(|at| at + by)));
    let corners =
        (0..inner.len()).map(|i| (angle_between(here[i] - before[i], behind[i] - here[i]).to_degrees(), here[i]));
    let bends = steps.chain(corners).map(|(turn, place)| (turn.abs(), place));
    bends.max_by(|a, b| a.0.total_cmp(&b.0))
}

fn curvature(params: &Params, lane: &Lane, center: &Polyline) -> Option<Bend> {
    let (radius, place) = curve::tightest_bend(center, CURVATURE_STEP)?;
    let severity = grade(1.0 / radius, params.curvature)?;
    let message = format!("Centre line of {} bends with a radius of {radius:.1} m.", lane.id);
    let finding = Finding::new("curvature", Subject::Lanelet(lane.id.0), message);
    let finding = finding.measured(1.0 / radius, params.curvature[0], "1/m").at(Place::Point(place)).graded(severity);
    Some(Bend { finding, place, short: format!("radius {radius:.1} m") })
}

/// Bends to and fro, without those that the directions at the ends require, or without those that go on with the bend of the lane
/// before or lead into that of the lane behind, as at small roundabouts.
fn jaggedness(map: &MapIndex, params: &Params, at: usize, center: &Polyline) -> Vec<Finding> {
    let lane = &map.lanes[at];
    let ends = headings(map, at);
    let findings = lines(lane, center).into_iter().filter_map(|(name, way, line)| {
        let mut turns = turns(&line.resampled(MEASURED_EVERY));
        let jagged = to_and_fro(&turns) - asked(&line, &ends);
        let limits = if way.is_some() { params.jagged } else { [params.jagged_center, f64::INFINITY] };
        grade(jagged, limits)?;
        without_bends_that_go_on(&mut turns, &bends_next_to(map, at, name, true));
        turns.reverse();
        without_bends_that_go_on(&mut turns, &bends_next_to(map, at, name, false));
        let jagged = jagged.min(to_and_fro(&turns));
        let severity = grade(jagged, limits)?;
        let message = format!("{name} of {} zig-zags by {jagged:.0} deg.", lane.id);
        let finding = Finding::new("jagged", Subject::Lanelet(lane.id.0), message);
        let finding = finding.measured(jagged, limits[0], "deg").graded(severity);
        Some(match way {
            Some(way) => finding.with(Subject::LineString(way.0), "bound"),
            None => finding,
        })
    });
    findings.collect()
}

/// The sum of all bends without the turn as a whole, degrees.
fn to_and_fro(turns: &[f64]) -> f64 {
    turns.iter().map(|turn| turn.abs()).sum::<f64>() - turns.iter().sum::<f64>().abs()
}

/// Takes from the first bends what goes on with a bend at the end of a line before, degrees for each step.
fn without_bends_that_go_on(turns: &mut [f64], before: &[f64]) {
    let Some(side) = turns.iter().find(|turn| turn.abs() > 1.0).map(|turn| turn.signum()) else { return };
    let most = BENDS_ON * before.iter().map(|bend| bend * side).fold(0.0, f64::max);
    for turn in turns.iter_mut().take_while(|turn| **turn * side > -1.0) {
        *turn -= turn.signum() * turn.abs().min(most);
    }
}

/// The mean bends of the lines of that name of the lanes before a lane, or behind it, over their steps next to it, degrees for each
/// step. Beyond a lane that is too short, those of the lanes next to that one.
fn bends_next_to(map: &MapIndex, at: usize, name: &str, before: bool) -> Vec<f64> {
    let next_to = |at| if before { map.predecessors(at) } else { map.followers(at) };
    let bend = |&lane: &usize| {
        let lane = &map.lanes[lane];
        let (_, _, line) = lines(lane, lane.center.as_ref()?).into_iter().find(|line| line.0 == name)?;
        let turns = turns(&line.resampled(MEASURED_EVERY));
        let count = turns.len().min(BEND_STEPS);
        let near = if before { &turns[turns.len() - count..] } else { &turns[..count] };
        (count > 1).then(|| near.iter().sum::<f64>() / count as f64)
    };
    let bends = |lane: &usize| match bend(lane) {
        Some(bend) => vec![bend],
        None => next_to(*lane).iter().filter_map(bend).collect(),
    };
    next_to(at).iter().flat_map(bends).collect()
}

/// The directions of the lanes before and behind, in all pairs.
fn headings(map: &MapIndex, at: usize) -> Vec<[Vector; 2]> {
    let before = map.predecessors(at).iter().filter_map(|&lane| map.lanes[lane].heading_out());
    let behind: Vec<Vector> = map.followers(at).iter().filter_map(|&lane| map.lanes[lane].heading_in()).collect();
    before.flat_map(|out| behind.iter().map(move |&on| [out, on])).collect()
}

/// The bends to and fro, degrees, that even the smoothest line from one direction to another needs: a line to a lane alongside
/// bends twice. The least of all pairs of directions; 0 if the line is open at an end.
fn asked(line: &Polyline, ends: &[[Vector; 2]]) -> f64 {
    let way = line.last() - line.first();
    let asked = ends.iter().map(|&[out, on]| {
        let bends = [angle_between(out, way), angle_between(way, on)];
        (bends[0].abs() + bends[1].abs() - (bends[0] + bends[1]).abs()).to_degrees()
    });
    asked.min_by(f64::total_cmp).unwrap_or(0.0)
}

/// Jumps of direction where the lanelet begins and ends.
fn joints(map: &MapIndex, params: &Params, at: usize) -> Vec<Finding> {
    let before = map.predecessors(at).iter().map(|&other| (other, at));
    // Between two lanelets of the intersection the second one says it.
    let after = map.followers(at).iter().map(|&other| (at, other)).filter(|&(_, y)| map.movement(y).is_none());
    let findings = before.chain(after).filter_map(|(x, y)| {
        let (a, b) = (&map.lanes[x], &map.lanes[y]);
        if !a.vehicle || !b.vehicle {
            return None;
        }
        let chords = angle_between(a.heading_out()?, b.heading_in()?).abs().to_degrees();
        // An arc that begins at the joint is no jump, though its first metres point elsewhere than its tangent.
        let tangents = tangent(&a.center.as_ref()?.reversed()).zip(tangent(b.center.as_ref()?));
        let jump = tangents.map_or(chords, |(back, on)| angle_between(-back, on).abs().to_degrees().min(chords));
        let severity = grade(jump, params.joint)?;
        let message = format!("Heading jumps {jump:.0} deg between {} and {}.", a.id, b.id);
        let (own, other) = if x == at { (a, b) } else { (b, a) };
        let finding = Finding::new("joint", Subject::Lanelet(own.id.0), message)
            .with(Subject::Lanelet(other.id.0), "neighbour along the road")
            .measured(jump, params.joint[0], "deg")
            .at(Place::Line(a.end.points.to_vec()));
        Some(finding.graded(severity))
    });
    findings.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn zig_zag(line: &Polyline) -> f64 {
        to_and_fro(&turns(&line.resampled(MEASURED_EVERY)))
    }

    fn line(place: impl Fn(f64) -> f64) -> Polyline {
        Polyline::new((0..=20).map(|i| Point::new(f64::from(i), place(f64::from(i))))).unwrap()
    }

    #[test]
    fn leading_over_to_a_lane_alongside_is_no_zig_zag() {
        let east = [Vector::new(1.0, 0.0); 2];
        // Three metres sideways on the way of a lane that goes on in the same direction, to either side.
        for sideways in [3.0, -3.0] {
            let over = line(|x| sideways * (x / 20.0).powi(2) * (3.0 - 2.0 * x / 20.0));
            assert!(zig_zag(&over) > 20.0);
            assert!(zig_zag(&over) - asked(&over, &[east]) < 15.0);
        }
        // To and fro on the spot; and over to a lane that begins in that direction.
        let to_and_fro = line(|x| if x % 4.0 < 2.0 { 0.0 } else { 0.5 });
        assert!(zig_zag(&to_and_fro) - asked(&to_and_fro, &[east]) > 60.0);
        let slanting = line(|x| 0.15 * x);
        let along = [Vector::new(1.0, 0.15); 2];
        assert!(asked(&slanting, &[along]) < 1e-6);
        assert!(asked(&slanting, &[east, along]) < 1e-6, "the least of all pairs");
        assert_eq!(asked(&slanting, &[]), 0.0);
    }

    #[test]
    fn a_bend_that_goes_on_is_no_zig_zag() {
        // Round a roundabout by 60 degrees to the left, then out of it by 50 to the right.
        let exit = || [vec![12.0; 5], vec![-10.0; 5]].concat();
        let left_over = |before: &[f64]| {
            let mut turns = exit();
            without_bends_that_go_on(&mut turns, before);
            to_and_fro(&turns).round()
        };
        assert_eq!(to_and_fro(&exit()), 100.0);
        assert_eq!(left_over(&[0.0, 11.0]), 0.0, "from the roundabout");
        assert_eq!(left_over(&[0.0, -11.0]), 100.0, "from a straight lane, or round the other way");
        assert_eq!(left_over(&[4.0]), 60.0, "from a wider bend: half of each step goes on");
        let mut zig_zag = [10.0, -10.0].repeat(4);
        without_bends_that_go_on(&mut zig_zag, &[11.0]);
        assert_eq!(to_and_fro(&zig_zag), 60.0);
    }

    #[test]
    fn one_bend_is_one_finding() {
        let bend = |fault, severity, x: f64, short: &str| {
            let finding = Finding::new(fault, Subject::Lanelet(1), format!("{short} there."))
                .with(Subject::LineString(if fault == "kink" { 2 } else { 3 }), "bound")
                .graded(severity);
            Bend { finding, place: Point::new(x, 0.0), short: short.to_owned() }
        };
        let found = one_for_each_bend(vec![
            bend("kink", Severity::Warning, 0.0, "left bound 31 deg"),
            bend("curvature", Severity::Error, 3.0, "radius 1.9 m"),
            bend("kink", Severity::Warning, 30.0, "left bound 40 deg"),
        ]);
        let said: Vec<&str> = found.iter().map(|one| one.message.as_str()).collect();
        assert_eq!(said, ["radius 1.9 m there (left bound 31 deg).", "left bound 40 deg there."]);
        assert_eq!((found[0].fault, found[0].related.len()), ("curvature", 2));
    }
}
