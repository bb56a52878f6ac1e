//! The way of a movement along the lines of the streets, where a curve from lane to lane would turn too tightly: over a link in a
//! median, or around the end of a road that lies inside the intersection.

use crate::builder::network::{End, InnerRoad, Intersection, RoadEnd, RoadNetwork};
use crate::builder::tags::cross_section::Travel;
use crate::geometry::fillet::Rounding;
use crate::geometry::pose::Pose;
use crate::geometry::{Point, Polyline, Vector, angle_between, curve, line_crossing, segment_crossing};

/// How tightly the way bends at the corners of the streets.
const BENDS: Rounding = Rounding { min_radius: 4.5, easy_radius: 6.0, max_shift: 1.0 };
/// A car follows the streets with ease if no bend is tighter than this radius, metres, ...
pub const RADIUS_LEAST: f64 = 4.3;
/// ... and at full lock, where an arrow tells it to, if none is tighter than this.
pub const RADIUS_TOLD: f64 = 3.3;
/// A U-turn bends to the other side by no more than this, radians (8 degrees).
pub const SWAY_MOST: f64 = 0.14;
/// A way that turns by more than this, radians (300 degrees), leads around a loop.
const TURN_MOST: f64 = 5.24;
/// The way begins and ends along its lanes but for this angle, radians (10 degrees).
const ALONG: f64 = 0.175;
/// The lines of streets that meet are continued by at most this to where they cross, metres.
const CONTINUED_BY: f64 = 12.0;
/// Corners of a line are mitred up to this many times its distance from the middle of the street.
const MITER: f64 = 2.0;

/// The streets of an intersection.
#[derive(Clone, Copy)]
pub struct StreetPaths<'a> {
    /// The network.
    pub network: &'a RoadNetwork,
    /// The intersection.
    pub intersection: &'a Intersection,
}

impl StreetPaths<'_> {
    /// The poses on the way from a lane of one road, where it is cut, to a lane of another: along the lines of both lanes and, between
    /// the roads, those on the shortest way over the roads inside; or from lane to lane through the middles of the latter. The one that
    /// sways less; `None` if the streets do not join the roads, or if a car cannot follow without a smaller radius than this, metres.
    pub fn between(&self, [from, to]: [RoadEnd; 2], lanes: [Pose; 2], radius: f64) -> Option<Vec<Pose>> {
        let node = |at: RoadEnd| self.network.road(at.road).node(at.end);
        let inner = self.over_inner_roads(node(from), node(to))?;
        let mut last = self.inside(to, lanes[1].point)?;
        last.reverse();
        let mut way = self.inside(from, lanes[0].point)?;
        inner.iter().cloned().chain([last]).for_each(|next| join(&mut way, next));
        let ways = [poses_along(&way, lanes), poses_through(&inner, lanes)].into_iter().flatten();
        let is_drivable = |poses: &[Pose]| curve::radius(poses) >= radius && curve::turned(poses).abs() <= TURN_MOST;
        let drivable = ways.map(|poses| (curve::sway(&poses), poses));
        let drivable = drivable.filter(|(sway, poses)| *sway <= SWAY_MOST && is_drivable(poses));
        drivable.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, poses)| poses)
    }

    /// The line of a lane from a place on a cut to the end of its road inside the intersection.
    fn inside(&self, at: RoadEnd, cut: Point) -> Option<Vec<Point>> {
        let road = self.network.road(at.road);
        let line = if at.end == End::End { road.line.clone() } else { road.line.reversed() };
        let on_line = line.project(cut);
        let inside = line.cut(on_line.station, line.length()).and_then(|inside| inside.offset(on_line.offset, MITER));
        let mut places = inside.map_or_else(|| vec![cut], Polyline::into_points);
        *places.first_mut()? = cut;
        Some(places)
    }

    /// The lines of lanes on the shortest way from one node to another over the roads inside.
    fn over_inner_roads(&self, from: i64, to: i64) -> Option<Vec<Vec<Point>>> {
        // The ways to the nodes that are reached, the shortest first.
        let mut open: Vec<(f64, i64, Vec<Vec<Point>>)> = vec![(0.0, from, Vec::new())];
        let mut reached: Vec<i64> = Vec::new();
        while let Some(next) = (0..open.len()).min_by(|&a, &b| open[a].0.total_cmp(&open[b].0)) {
            let (length, node, way) = open.remove(next);
            if node == to {
                return Some(way);
            }
            if reached.contains(&node) {
                continue;
            }
            reached.push(node);
            for (inner, travel, there) in self.intersection.inner.iter().flat_map(|inner| leaving(inner, node)) {
                if let Some(line) = lane_line(inner, travel) {
                    let way = way.iter().cloned().chain([line]).collect();
                    open.push((length + inner.line.length(), there, way));
                }
            }
        }
        None
    }
}

/// The directions in which a road leads away from a node, and the node where it leads.
fn leaving(inner: &InnerRoad, node: i64) -> impl Iterator<Item = (&InnerRoad, Travel, i64)> {
    let ways =
        [(inner.key.first, Travel::Forward, inner.key.last), (inner.key.last, Travel::Backward, inner.key.first)];
    ways.into_iter().filter(move |(from, ..)| *from == node).map(move |(_, travel, there)| (inner, travel, there))
}

/// The line of the lane of a road that is nearest to its middle, in a direction of travel; `None` without one.
fn lane_line(inner: &InnerRoad, travel: Travel) -> Option<Vec<Point>> {
    let lanes = inner.section.driven().filter(|(_, strip)| [travel, Travel::Both].contains(&strip.travel));
    let middles = lanes.map(|(i, _)| f64::midpoint(inner.section.edge(i), inner.section.edge(i + 1)));
    let middle = middles.min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    let line = inner.line.offset(middle, MITER)?;
    Some(if travel == Travel::Backward { line.reversed() } else { line }.into_points())
}

/// Continues a line with another: from where they last cross, else over where they would, if that is near.
fn join(way: &mut Vec<Point>, mut next: Vec<Point>) {
    let crossing = (0..way.len().saturating_sub(1)).rev().find_map(|i| {
        let crossed =
            |j: usize| segment_crossing(way[i], way[i + 1], next[j], next[j + 1]).map(|(.., place)| (j, place));
        (0..next.len().saturating_sub(1)).rev().find_map(crossed).map(|(j, place)| (i, j, place))
    });
    if let Some((i, j, place)) = crossing {
        way.truncate(i + 1);
        next.drain(..=j);
        way.push(place);
    } else if let ([.., a, b], [c, d, ..]) = (&way[..], &next[..])
        && let Some((_, _, place)) = line_crossing(*b, b - a, *c, d - c)
        && (place - b).dot(&(b - a)) > 0.0
        && (c - place).dot(&(d - c)) > 0.0
        && (place - b).norm().max((c - place).norm()) <= CONTINUED_BY
    {
        way.push(place);
    }
    way.extend(next);
}

/// The poses along a line with rounded corners between lanes; `None` if it begins or ends aside of them.
fn poses_along(way: &[Point], [from, to]: [Pose; 2]) -> Option<Vec<Pose>> {
    let distinct = Polyline::new(way.iter().copied())?;
    let way = Polyline::new(BENDS.of(distinct.points()).iter().copied())?;
    let directions: Vec<Vector> = way.segments().map(|(a, b)| (b - a).normalize()).collect();
    let ends = [(from.heading, *directions.first()?), (to.heading, *directions.last()?)];
    if ends.iter().any(|(lane, way)| angle_between(*lane, *way).abs() > ALONG) {
        return None;
    }
    let between = directions.windows(2).map(|w| (w[0] + w[1]).try_normalize(f64::EPSILON));
    let headings = std::iter::once(Some(from.heading)).chain(between).chain([Some(to.heading)]);
    way.points().iter().zip(headings).map(|(&point, heading)| Some(Pose { point, heading: heading? })).collect()
}

/// The poses of smooth curves between lanes through the middles of lines; `None` without one.
fn poses_through(lines: &[Vec<Point>], [from, to]: [Pose; 2]) -> Option<Vec<Pose>> {
    let middle = |line: &Vec<Point>| {
        let line = Polyline::new(line.iter().copied())?;
        let half = line.length() / 2.0;
        Some(Pose { point: line.at(half), heading: line.direction(half) })
    };
    let middles: Vec<Pose> = lines.iter().map(middle).collect::<Option<_>>()?;
    middles.first()?;
    let passed: Vec<Pose> = std::iter::once(from).chain(middles).chain([to]).collect();
    Some(curve::through(&passed))
}

#[cfg(test)]
mod tests {
    use crate::builder::network::hand_drawn::{osm, plane};
    use crate::builder::network::{NetworkOptions, RoadIx, RoadKey, road_network};

    use super::*;

    fn network(nodes: &[(i64, f64, f64, &str)], ways: &[(i64, &[i64], &str)]) -> RoadNetwork {
        road_network(&osm(nodes, ways), &plane, &NetworkOptions::default()).unwrap().network
    }

    /// The end of the road of a way at a node.
    fn end(network: &RoadNetwork, way: i64, node: i64) -> RoadEnd {
        let road = RoadIx::all(network.roads.len()).find(|&road| {
            let key = network.road(road).key;
            key.way == way && [key.first, key.last].contains(&node)
        });
        let road = road.unwrap();
        let end = if network.road(road).node(End::End) == node { End::End } else { End::Start };
        RoadEnd { road, end }
    }

    fn lane(x: f64, y: f64, east: f64) -> Pose {
        Pose { point: Point::new(x, y), heading: Vector::new(east, 0.0) }
    }

    /// The radius, the sway and the turn of a way, metres and degrees, left positive.
    fn measure(poses: &[Pose]) -> [f64; 3] {
        [curve::radius(poses), curve::sway(poses).to_degrees(), curve::turned(poses).to_degrees()]
    }

    #[test]
    fn a_road_that_bends_before_its_end_is_followed_around_the_bend() {
        let nodes =
            [(1, -60.0, 0.0, ""), (2, 0.0, 0.0, ""), (3, 60.0, 0.0, ""), (4, 0.0, 14.0, ""), (5, -60.0, 14.0, "")];
        let network = network(&nodes, &[(10, &[1, 2, 3], ""), (11, &[5, 4, 2], "")]);
        let (side, main) = (end(&network, 11, 2), end(&network, 10, 2));
        let intersection = network.intersection(network.intersection_at(side));
        let paths = StreetPaths { network: &network, intersection };
        let back = paths.between([side, main], [lane(-12.0, 12.5, 1.0), lane(-12.0, 1.5, -1.0)], RADIUS_LEAST).unwrap();
        let [radius, sway, turn] = measure(&back);
        assert!(radius >= RADIUS_LEAST && sway < 1.0 && (turn + 180.0).abs() < 1.0, "{radius} m, {sway}, {turn}");
        // No car follows a hairpin.
        assert!(paths.between([side, main], [lane(-1.0, 4.0, 1.0), lane(-1.0, 1.5, -1.0)], RADIUS_TOLD).is_none());
    }

    #[test]
    fn a_link_between_two_carriageways_is_followed() {
        let nodes = [(1, -60.0, 0.0, ""), (2, 0.0, 0.0, ""), (3, 0.0, 14.0, ""), (4, -60.0, 14.0, "")];
        let mut network =
            network(&nodes, &[(10, &[1, 2], "oneway=yes"), (11, &[2, 3], "oneway=yes"), (12, &[3, 4], "oneway=yes")]);
        let (from, link, to) = (end(&network, 10, 2), end(&network, 11, 2), end(&network, 12, 3));
        let at = network.intersection_at(from);
        let lanes = [lane(-10.0, 0.0, 1.0), lane(-10.0, 14.0, -1.0)];
        let alone = StreetPaths { network: &network, intersection: network.intersection(at) };
        assert!(alone.between([from, to], lanes, RADIUS_LEAST).is_none(), "no road leads there");
        let road = network.road(link.road).clone();
        let inner = |line: Polyline, first: i64, last: i64| InnerRoad {
            key: RoadKey { first, last, ..road.key },
            ways: vec![11],
            line,
            section: road.section.clone(),
            roundabout: false,
        };
        network.intersections[at].inner = vec![inner(road.line.clone(), 2, 3)];
        let paths = StreetPaths { network: &network, intersection: network.intersection(at) };
        let [radius, sway, turn] = measure(&paths.between([from, to], lanes, RADIUS_LEAST).unwrap());
        assert!(radius >= RADIUS_LEAST && sway < 8.0 && (turn - 180.0).abs() < 1.0, "{radius} m, {sway}, {turn}");
        // A link that leads the other way is none.
        network.intersections[at].inner = vec![inner(road.line.reversed(), 3, 2)];
        let paths = StreetPaths { network: &network, intersection: network.intersection(at) };
        assert!(paths.between([from, to], lanes, RADIUS_LEAST).is_none());
    }
}
