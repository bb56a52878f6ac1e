//! The part of a map that decides what stands in a square, and where else that stands: it is divided sooner than the whole map.

use std::borrow::Cow;

use crate::lanelet::{Attributes, LaneletMap, LineStringId, PointId, PolygonId, Target};

use super::NAMING;

/// Two corners of a square, metres.
type Square = [[f64; 2]; 2];

/// Leaves of a map what touches a square, with all that this is connected with by references in whichever direction, and so what
/// shares a point with one of these.
pub fn excerpt(map: &mut LaneletMap, square: Square) {
    let mut parts = Parts::of(map);
    parts.keep(map, |points| touches(map, points, square));
    let near = parts.points(map);
    parts.keep(map, |points| points.iter().any(|id| map.points.position(*id).is_some_and(|at| near[at])));
    let mut points = parts.points(map);
    for (kept, point) in points.iter_mut().zip(&map.points) {
        *kept |= touches(map, &[point.id], square);
    }
    let mut stays = parts.kept().into_iter();
    let mut next = move || stays.next().unwrap_or_default();
    map.lanelets.retain(|_| next());
    map.regulatory_elements.retain(|_| next());
    map.polygons.retain(|_| next());
    map.linestrings.retain(|_| next());
    let mut points = points.into_iter();
    map.points.retain(|_| points.next().unwrap_or_default());
}

/// Whether the box around some points touches the square.
fn touches(map: &LaneletMap, points: &[PointId], [low, high]: Square) -> bool {
    let places = points.iter().filter_map(|id| map.points.get(*id)).map(|point| point.position);
    let around = places.fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[least, most], p| {
        [[least[0].min(p.x), least[1].min(p.y)], [most[0].max(p.x), most[1].max(p.y)]]
    });
    (0..2).all(|i| around[0][i] <= high[i] && low[i] <= around[1][i])
}

/// Lanelets, regulatory elements, polygons and lines, numbered in this order, in parts that are connected by references. Lanelets
/// that follow each other share points only: a part is an intersection, or a road.
struct Parts {
    /// By number: another of the same part, or itself.
    joined: Vec<usize>,
    /// By number, of the first of each part: whether the part is kept.
    kept: Vec<bool>,
    /// The first number of each kind.
    begins: [usize; 4],
}

impl Parts {
    fn of(map: &LaneletMap) -> Self {
        let lanelets = map.lanelets.len();
        let polygons = lanelets + map.regulatory_elements.len();
        let lines = polygons + map.polygons.len();
        let all = lines + map.linestrings.len();
        let mut parts =
            Self { joined: (0..all).collect(), kept: vec![false; all], begins: [0, lanelets, polygons, lines] };
        let line = |id: LineStringId| map.linestrings.position(id).map(|at| lines + at);
        let polygon = |id: PolygonId| map.polygons.position(id).map(|at| polygons + at);
        for (number, lanelet) in map.lanelets.iter().enumerate() {
            let bounds = [Some(lanelet.left.line), Some(lanelet.right.line), lanelet.centerline];
            parts.join(number, bounds.into_iter().flatten().map(line));
            let elements = lanelet.regulatory_elements.iter();
            parts.join(number, elements.map(|id| map.regulatory_elements.position(*id).map(|at| lanelets + at)));
            parts.join(
                number,
                named(&lanelet.attributes).flat_map(|id| [line(LineStringId(id)), polygon(PolygonId(id))]),
            );
        }
        for (at, element) in map.regulatory_elements.iter().enumerate() {
            let members = element.members.iter().map(|member| match member.target {
                Target::Lanelet(id) => map.lanelets.position(id),
                Target::Polygon(id) => polygon(id),
                Target::LineString(id) => line(id),
                Target::Point(_) => None,
            });
            parts.join(lanelets + at, members);
        }
        for (at, of) in map.linestrings.iter().enumerate() {
            parts.join(lines + at, named(&of.attributes).map(|id| line(LineStringId(id))));
        }
        parts
    }

    fn join(&mut self, one: usize, others: impl Iterator<Item = Option<usize>>) {
        for other in others.flatten() {
            let (one, other) = (self.first(one), self.first(other));
            self.joined[one.max(other)] = one.min(other);
        }
    }

    fn first(&mut self, mut number: usize) -> usize {
        while self.joined[number] != number {
            // So the way there is halved each time.
            self.joined[number] = self.joined[self.joined[number]];
            number = self.joined[number];
        }
        number
    }

    /// Keeps the parts that have a line, polygon or element with such points.
    fn keep(&mut self, map: &LaneletMap, are_wanted: impl Fn(&[PointId]) -> bool) {
        for (number, points) in with_points(self.begins, map) {
            let first = self.first(number);
            self.kept[first] = self.kept[first] || are_wanted(&points);
        }
    }

    /// Whether each is kept.
    fn kept(&mut self) -> Vec<bool> {
        let firsts: Vec<usize> = (0..self.joined.len()).map(|number| self.first(number)).collect();
        firsts.into_iter().map(|first| self.kept[first]).collect()
    }

    /// Whether each point belongs to what is kept.
    fn points(&mut self, map: &LaneletMap) -> Vec<bool> {
        let (kept, mut points) = (self.kept(), vec![false; map.points.len()]);
        for (_, of) in with_points(self.begins, map).filter(|(number, _)| kept[*number]) {
            of.iter().filter_map(|id| map.points.position(*id)).for_each(|at| points[at] = true);
        }
        points
    }
}

/// The ways that tags name.
fn named(attributes: &Attributes) -> impl Iterator<Item = i64> {
    NAMING.iter().filter_map(|key| attributes.get(key)?.trim().parse().ok())
}

/// What has points, by number, and which.
fn with_points(begins: [usize; 4], map: &LaneletMap) -> impl Iterator<Item = (usize, Cow<'_, [PointId]>)> {
    let [_, elements, polygons, lines] = begins;
    let of_elements = map.regulatory_elements.iter().enumerate().map(move |(at, element)| {
        let points = element.members.iter().filter_map(|member| match member.target {
            Target::Point(id) => Some(id),
            _ => None,
        });
        (elements + at, Cow::Owned(points.collect()))
    });
    let of_polygons = map.polygons.iter().enumerate();
    let of_polygons = of_polygons.map(move |(at, polygon)| (polygons + at, Cow::Borrowed(&polygon.points[..])));
    let of_lines = map.linestrings.iter().enumerate();
    let of_lines = of_lines.map(move |(at, line)| (lines + at, Cow::Borrowed(&line.points[..])));
    of_elements.chain(of_polygons).chain(of_lines)
}
