//! Leads the lanes that go on at a fork or a merge of one-way roads straight on.
//!
//! OpenStreetMap draws each road in the middle of its lanes. Where a lane leaves to one side, the middle of those that go on jumps to
//! the other side by half of it, and all lanes would swing with it inside the intersection. Here the line of the road that goes on
//! begins where its lanes come from, and reaches its own place farther on.

use crate::builder::network::road_end::{at_depth, inward, on_cut, outward};
use crate::builder::network::{End, Intersection, Road, RoadEnd, RoadNetwork};
use crate::builder::tags::cross_section::{Arrows, Strip, Travel};
use crate::geometry::{Point, Polyline, Vector, angle_between, left_of};

use super::set_line;

/// The road that goes on turns by less than this, radians: 15 degrees.
const STRAIGHT_ON: f64 = std::f64::consts::PI / 12.0;
/// How far up two roads it shows which leaves to the left of the other, metres.
const BEARING: f64 = 30.0;
/// The lanes are shifted by at most this, metres: two wide lanes.
const LARGEST: f64 = 7.5;
/// Smaller shifts, metres, are not seen.
const LEAST: f64 = 0.25;
/// The length of a shift for each metre of it and each square of a speed in km/h, up to [`FAST`] (MUTCD 2009, table 6C-4: `W S² / 155`),
/// and for each km/h above (`W S / 1.6`).
const SLOW_TAPER: f64 = 1.0 / 155.0;
const FAST_TAPER: f64 = 1.0 / 1.6;
/// Above this speed, km/h, the longer taper counts.
const FAST: f64 = 60.0;
/// A shift is at least so many times as long as wide: a shorter one would be a bend of its own.
const LEAST_RATIO: f64 = 8.0;
/// Where a road has one of these tags, the map says where its lanes lie.
const PLACED: [&str; 3] = ["placement", "placement:forward", "placement:backward"];
/// Distance between the places of a shifted line, metres.
const PLACES: f64 = 4.0;

/// The network in which the lanes that go on at a fork or merge of one-way roads do not swing.
#[must_use]
pub fn straight_at_forks(network: RoadNetwork) -> RoadNetwork {
    straight_where(network, |_, _| true)
}

/// As [`straight_at_forks`], for the roads that go on from ends for which `counts` holds.
#[must_use]
pub fn straight_where(mut network: RoadNetwork, counts: impl Fn(&Road, End) -> bool) -> RoadNetwork {
    let counts = |(arm, _): &(RoadEnd, f64)| counts(network.road(arm.road), arm.end);
    let shifts = network.intersections.iter().filter_map(|at| shift(&network, at)).filter(counts);
    let shifts: Vec<(RoadEnd, f64)> = shifts.collect();
    for (RoadEnd { road, end }, aside) in shifts {
        let road = &mut network.roads[road];
        if let Some(line) = shifted(road, end, aside) {
            set_line(road, line);
        }
    }
    network
}

/// The road end at a fork or merge that lies aside of where its lanes come from or go to, and how far it is to be moved to the left of
/// its line, metres.
fn shift(network: &RoadNetwork, at: &Intersection) -> Option<(RoadEnd, f64)> {
    let [a, b, c] = at.arms[..] else { return None };
    if at.circle.is_some() || a.road == b.road || b.road == c.road || a.road == c.road {
        return None;
    }
    // The common road is the one that leads in where the others lead out, or the other way round.
    let leads_in = |arm: RoadEnd| Some(network.road(arm.road).one_way()? == arm.end.inbound());
    let ins = [leads_in(a)?, leads_in(b)?, leads_in(c)?];
    let (common, [x, y]) = match ins {
        [p, q, r] if q == r && p != q => (a, [b, c]),
        [p, q, r] if p == r && p != q => (b, [c, a]),
        [p, q, r] if p == q && p != r => (c, [a, b]),
        _ => return None,
    };
    let (whole, on) = (lanes(network, common), |arm| lanes(network, arm));
    // Directions along the common road, out of it.
    let ahead = direction(network, common);
    let turn = |arm: RoadEnd| angle_between(ahead, -direction(network, arm));
    let (main, side) = if turn(x).abs() <= turn(y).abs() { (x, y) } else { (y, x) };
    let leaves_left = angle_between(bearing(network, main), bearing(network, side)) > 0.0;
    if turn(main).abs() >= STRAIGHT_ON || on(main) >= whole || network.road(main.road).roundabout {
        return None;
    }
    if [common, main].iter().any(|arm| PLACED.iter().any(|key| network.road(arm.road).tags.has(key))) {
        return None;
    }
    // The edge on the side where nothing leaves goes straight on.
    let through = |strip: &Strip| strip.arrows != Arrows::REVERSE;
    let from = outer_edge(network, common, leaves_left, through)?;
    let gap = (from - outer_edge(network, main, !leaves_left, |_| true)?).dot(&left_of(ahead));
    // The lanes of the road that goes on lie away from those that leave, unless some only turn back.
    let is_away = leaves_left == (gap < 0.0);
    let turns_back = network.road(common.road).section.driven().any(|(_, strip)| !through(strip));
    ((is_away || turns_back) && (LEAST..=LARGEST).contains(&gap.abs())).then_some(())?;
    // To the left of `ahead` is to the left of a line that leads away from the intersection.
    Some((main, if main.end == End::Start { gap } else { -gap }))
}

/// The number of lanes for motor vehicles at a road end.
fn lanes(network: &RoadNetwork, arm: RoadEnd) -> usize {
    network.road(arm.road).section.driven().count()
}

/// The direction into the intersection at a road end.
fn direction(network: &RoadNetwork, arm: RoadEnd) -> Vector {
    let road = network.road(arm.road);
    inward(road, arm.end, at_depth([0.0, road.line.length()], arm.end, 0.0))
}

/// The direction from the intersection to a place on a road.
fn bearing(network: &RoadNetwork, arm: RoadEnd) -> Vector {
    let road = network.road(arm.road);
    outward(road, arm.end, BEARING.min(road.line.length()))
}

/// The edge of the outermost of these lanes for motor vehicles at a road end, on the right looking into the intersection, or on the
/// left.
fn outer_edge(network: &RoadNetwork, arm: RoadEnd, right: bool, counts: impl Fn(&Strip) -> bool) -> Option<Point> {
    let road = network.road(arm.road);
    let mut lanes = road.section.driven().filter(|(_, strip)| counts(strip)).map(|(lane, _)| lane);
    let first = lanes.next()?;
    let edge = if right == (arm.end == End::End) { lanes.last().unwrap_or(first) + 1 } else { first };
    let station = at_depth([0.0, road.line.length()], arm.end, 0.0);
    Some(on_cut(road, arm.end, station, road.section.edge(edge)))
}

/// The line of a road, moved to the left at one end; `None` where it is too short.
fn shifted(road: &Road, end: End, aside: f64) -> Option<Polyline> {
    let whole = road.line.length();
    let length = taper(road, aside.abs()).min(whole);
    if length < LEAST_RATIO * aside.abs() {
        return None;
    }
    let depth = |station: f64| if end == End::Start { station } else { whole - station };
    let mut stations = road.line.stations();
    let steps = (length / PLACES).ceil().max(1.0);
    let places = (0..=steps as usize).map(|step| at_depth([0.0, whole], end, length * step as f64 / steps));
    let vertices = stations.clone();
    stations.extend(places.filter(|at| vertices.iter().all(|vertex| (vertex - at).abs() > PLACES / 4.0)));
    stations.sort_by(f64::total_cmp);
    // From 1 at the end to 0, without a bend at either.
    let share = |at: f64| {
        let t = (depth(at) / length).clamp(0.0, 1.0);
        1.0 - t * t * (3.0 - 2.0 * t)
    };
    let place = |at: &f64| road.line.at(*at) + left_of(road.line.direction(*at)) * (aside * share(*at));
    Polyline::new(stations.iter().map(place))
}

/// The length, metres, over which lanes shift sideways at the speed of a road.
fn taper(road: &Road, aside: f64) -> f64 {
    let speed = road.speed[usize::from(road.one_way() == Some(Travel::Backward))];
    aside * if speed > FAST { speed * FAST_TAPER } else { (speed * speed * SLOW_TAPER).max(LEAST_RATIO) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builder::network::hand_drawn::network_of;

    /// The lateral place, metres, of the edge on the right and on the left of the road that goes on, where the fork lies and far behind.
    fn edges(link_up: bool, reversed: bool, tags: &str) -> [[f64; 2]; 2] {
        let up = if link_up { 40.0 } else { -40.0 };
        let nodes = [(1, 0.0, 0.0), (2, 100.0, 0.0), (3, 300.0, 0.0), (4, 180.0, up)];
        let way = |nodes: [i64; 2]| if reversed { [nodes[1], nodes[0]] } else { nodes };
        let ways = [way([1, 2]), way([2, 3]), way([2, 4])];
        let on = format!("oneway=yes {tags}");
        let network = network_of(
            &nodes,
            &[(10, &ways[0], "oneway=yes lanes=3"), (11, &ways[1], &on), (12, &ways[2], "oneway=yes lanes=1")],
        );
        let network = straight_at_forks(network);
        let road = network.roads.iter().find(|road| road.key.way == 11).unwrap();
        let half = road.half_width();
        let at = |x: f64| road.line.project(Point::new(x, 0.0)).station;
        [at(100.0), at(280.0)].map(|at| [road.line.at(at).y - half, road.line.at(at).y + half])
    }

    #[test]
    fn lanes_that_go_on_keep_their_edge() {
        for reversed in [false, true] {
            let [[right, _], [far_right, far_left]] = edges(true, reversed, "lanes=2");
            assert!((right + 4.5).abs() < 0.3, "{right}: the common road ends with its edge at 1.5 lanes");
            assert!((far_right + far_left).abs() < 1e-9, "back in the middle");
            let [[_, left], _] = edges(false, reversed, "lanes=2");
            assert!((left - 4.5).abs() < 0.3, "{left}");
        }
        let [[right, left], _] = edges(true, false, "lanes=3");
        assert!((right + left).abs() < 1e-9, "no lane is lost");
        let [[right, _], _] = edges(true, false, "lanes=2 placement=right_of:2");
        assert_eq!(right, 0.0, "placement says where the lanes lie");
    }
}
