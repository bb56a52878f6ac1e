//! Rings and the areas between them, through `geo`. A ring is a list of points, not closed.

use geo::{Area, BooleanOps, Contains, Coord, LineString, MultiPolygon, Polygon};

use super::Point;

/// `geo`'s polygon from a ring.
pub fn to_geo(ring: &[Point]) -> Polygon<f64> {
    Polygon::new(LineString::new(ring.iter().map(|p| Coord { x: p.x, y: p.y }).collect()), Vec::new())
}

/// Signed area in square metres: positive when the ring runs counter-clockwise.
pub fn signed_area(ring: &[Point]) -> f64 {
    area_around(ring.iter())
}

/// As [`signed_area`], of places one after the other.
pub fn area_around<'a>(ring: impl Iterator<Item = &'a Point> + Clone) -> f64 {
    let Some(origin) = ring.clone().next() else { return 0.0 };
    let next = ring.clone().cycle().skip(1);
    ring.zip(next).map(|(a, b)| super::cross(a - origin, b - origin)).sum::<f64>() / 2.0
}

/// Area in square metres that both rings cover. Rings that cross themselves count by the non-zero rule.
pub fn overlap(a: &[Point], b: &[Point]) -> f64 {
    intersection(a, b).unsigned_area()
}

/// Area in square metres that two simple rings share, whichever way they run: as [`overlap`], without a sweep.
///
/// A simple ring's interior is the sum of the strips below its upper edges less those below its lower ones, so the
/// common area is the sum over all pairs of edges of what lies below both.
pub fn common_area(a: &[Point], b: &[Point]) -> f64 {
    let base = a.first().copied().unwrap_or_default();
    Strips::new(a, base).zip(Strips::new(b, base)).map_or(0.0, |(a, b)| a.common_area(&b))
}

/// Area and middle of what two simple rings share; `None` if they share nothing. See [`common_area`].
pub fn common_part(a: &[Point], b: &[Point]) -> Option<(f64, Point)> {
    let base = *a.first()?;
    let (a, b) = (Strips::new(a, base)?, Strips::new(b, base)?);
    let mut sum = Moments::default();
    if a.may_touch(&b) {
        a.each_piece(&b, EVERYWHERE, |piece| piece.add_to(base.x, &mut sum));
    }
    let middle = base + super::Vector::new(sum.east, sum.north) / sum.area;
    (sum.area != 0.0 && middle.x.is_finite() && middle.y.is_finite()).then(|| (sum.area.abs(), middle))
}

/// A simple ring as its edges, each with the strip below it: made once where what it shares with several others is asked.
pub struct Strips {
    bounds: [Point; 2],
    /// Between which sums and differences of the coordinates it lies.
    aslant: [[f64; 2]; 2],
    /// Run after run, each from west to east.
    edges: Vec<Edge>,
    /// Where the runs end among the edges, and on which side of them the ring lies: 1 or -1.
    runs: Vec<(usize, f64)>,
}

impl Strips {
    /// Of a ring; strips end at the height of `base`, which is the same for all rings that are compared. `None` without
    /// any point.
    pub fn new(ring: &[Point], base: Point) -> Option<Self> {
        let range = |of: fn(&Point) -> f64| {
            ring.iter().map(of).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
        };
        let (bounds, aslant) = (bounds(ring)?, [range(|p| p.x + p.y), range(|p| p.x - p.y)]);
        let mut strips = Self { bounds, aslant, edges: Vec::with_capacity(ring.len()), runs: Vec::with_capacity(4) };
        let (mut first, mut last, mut sign) = (0, *ring.last()?, 0.0);
        for p in ring {
            if let Some((edge, way)) = Edge::new(last, *p, base) {
                if way != sign {
                    strips.end_run(&mut first, sign);
                    sign = way;
                }
                strips.edges.push(edge);
            }
            last = *p;
        }
        strips.end_run(&mut first, sign);
        Some(strips)
    }

    /// Ends a run that began at an edge, where there is any edge since, and begins another.
    fn end_run(&mut self, first: &mut usize, sign: f64) {
        let end = self.edges.len();
        if end > *first {
            if sign < 0.0 {
                self.edges[*first..].reverse();
            }
            self.runs.push((end, sign));
            *first = end;
        }
    }

    /// The edges of each run with its side.
    fn runs(&self) -> impl Iterator<Item = (&[Edge], f64)> {
        let mut first = 0;
        self.runs.iter().map(move |&(end, sign)| (&self.edges[std::mem::replace(&mut first, end)..end], sign))
    }

    /// Area in square metres that both rings cover.
    pub fn common_area(&self, other: &Self) -> f64 {
        if self.may_touch(other) { self.common_area_between(other, EVERYWHERE).abs() } else { 0.0 }
    }

    /// Area in square metres that both rings cover from one place to another on the way to the east; below 0 if they run different
    /// ways around.
    pub(super) fn common_area_between(&self, other: &Self, range: [f64; 2]) -> f64 {
        let mut sum = 0.0;
        self.each_piece(other, range, |piece| sum += piece.below_both());
        sum
    }

    /// Goes through the pieces of pairs of edges, one of either ring, that lie above each other.
    fn each_piece(&self, other: &Self, range: [f64; 2], mut each: impl FnMut(Piece)) {
        for (a, of_a) in self.runs() {
            for (b, of_b) in other.runs() {
                along_both(a, b, range, of_a * of_b, &mut each);
            }
        }
    }

    /// Whether no line from south to north, from west to east or midway between these runs between the two.
    pub(super) fn may_touch(&self, other: &Self) -> bool {
        let ([low_a, high_a], [low_b, high_b]) = (self.bounds, other.bounds);
        let (low, high) = (low_a.sup(&low_b), high_a.inf(&high_b));
        let apart = |[low_a, high_a]: [f64; 2], [low_b, high_b]: [f64; 2]| low_a > high_b || low_b > high_a;
        low.x < high.x && low.y < high.y && !(0..2).any(|i| apart(self.aslant[i], other.aslant[i]))
    }
}

/// From the farthest west to the farthest east.
const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// Goes through the pieces of two runs that lie above each other, from west to east.
fn along_both(a: &[Edge], b: &[Edge], [west, east]: [f64; 2], sign: f64, each: &mut impl FnMut(Piece)) {
    let mut from = a[0].from.max(b[0].from).max(west);
    if from >= a[a.len() - 1].to.min(b[b.len() - 1].to).min(east) {
        return;
    }
    let [mut i, mut j] = [a, b].map(|run| run.partition_point(|edge| edge.to <= from));
    while let (Some(x), Some(y)) = (a.get(i), b.get(j))
        && from < east
    {
        let to = x.to.min(y.to).min(east);
        each(Piece { sign, from, to, heights: [[x.at(from), x.at(to)], [y.at(from), y.at(to)]] });
        i += usize::from(x.to <= to);
        j += usize::from(y.to <= to);
        from = to;
    }
}

/// The lowest and the highest coordinates of a ring.
pub fn bounds(ring: &[Point]) -> Option<[Point; 2]> {
    let first = *ring.first()?;
    Some(ring.iter().fold([first; 2], |[low, high], p| [low.inf(p), high.sup(p)]))
}

/// An edge of a ring as a function of east, between `from` and `to`.
struct Edge {
    from: f64,
    to: f64,
    /// Height at `from`.
    height: f64,
    slope: f64,
}

impl Edge {
    /// The edge from one place to another, its heights above `base`, and whether it runs to the east (1) or back (-1); `None`
    /// if it is as good as vertical.
    fn new(p: Point, q: Point, base: Point) -> Option<(Self, f64)> {
        let (left, right, way) = if p.x < q.x { (p, q, 1.0) } else { (q, p, -1.0) };
        let slope = (right.y - left.y) / (right.x - left.x);
        slope.is_finite().then_some((Self { from: left.x, to: right.x, height: left.y - base.y, slope }, way))
    }

    fn at(&self, x: f64) -> f64 {
        self.height + self.slope * (x - self.from)
    }
}

/// What lies below an edge of one ring and one of another, from west to east.
struct Piece {
    /// Whether the rings lie on the same side of their edges (1) or not (-1).
    sign: f64,
    from: f64,
    to: f64,
    /// Of either edge, at both ends.
    heights: [[f64; 2]; 2],
}

impl Piece {
    /// Its signed area.
    fn below_both(&self) -> f64 {
        let [a, b] = self.heights;
        let [first, last] = [a[0] - b[0], a[1] - b[1]];
        let least = a[0].min(b[0]) + a[1].min(b[1]);
        // Where the edges cross, a triangle above the lower ends counts too.
        let crossing = if first * last < 0.0 { first * last / (first - last).abs() } else { 0.0 };
        self.sign * (least - crossing) / 2.0 * (self.to - self.from)
    }

    /// Adds its area and moments; east is counted from `base`.
    fn add_to(&self, base: f64, sum: &mut Moments) {
        let (sign, [a, b]) = (self.sign, self.heights);
        let [first, last] = [a[0] - b[0], a[1] - b[1]];
        let ends = [a[0].min(b[0]), a[1].min(b[1])];
        let (from, to) = (self.from - base, self.to - base);
        if first * last < 0.0 {
            let part = first / (first - last);
            let (middle, height) = (from + (to - from) * part, a[0] + (a[1] - a[0]) * part);
            sum.add_below(sign, [from, middle], [ends[0], height]);
            sum.add_below(sign, [middle, to], [height, ends[1]]);
        } else {
            sum.add_below(sign, [from, to], ends);
        }
    }
}

/// An area, and the integrals of east and north over it.
#[derive(Default)]
struct Moments {
    area: f64,
    east: f64,
    north: f64,
}

impl Moments {
    /// Adds what lies below one straight line.
    fn add_below(&mut self, sign: f64, [from, to]: [f64; 2], [a, b]: [f64; 2]) {
        let width = sign * (to - from);
        let area = width * (a + b) / 2.0;
        self.area += area;
        self.east += from * area + width * (to - from) * (a + 2.0 * b) / 6.0;
        self.north += width * (a * a + a * b + b * b) / 6.0;
    }
}

/// What both rings cover.
pub fn intersection(a: &[Point], b: &[Point]) -> MultiPolygon<f64> {
    to_geo(a).intersection(&to_geo(b))
}

/// Whether the ring holds the point in its interior.
pub fn contains(ring: &[Point], p: Point) -> bool {
    to_geo(ring).contains(&geo::Point::new(p.x, p.y))
}

/// The convex hull of the points, clockwise, not closed (Andrew's monotone chain, exact orientations).
pub fn convex_hull(points: impl IntoIterator<Item = Point>) -> Vec<Point> {
    let mut points: Vec<Point> = points.into_iter().collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let chain = |points: &mut dyn Iterator<Item = Point>| {
        let mut hull: Vec<Point> = Vec::new();
        for p in points {
            while hull.len() >= 2 && super::orientation(hull[hull.len() - 2], hull[hull.len() - 1], p) >= 0.0 {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
        hull
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    hull
}

/// The largest piece of `a` that `b` does not cover, as a ring that is not closed; `None` if nothing is left.
pub fn largest_outside(a: &[Point], b: &[Point]) -> Option<Vec<Point>> {
    largest(to_geo(a).difference(&to_geo(b)))
}

/// The largest piece of `ring` that none of `others` covers, clockwise, not closed; `None` if nothing is left.
pub fn outside(ring: &[Point], others: &[Vec<Point>]) -> Option<Vec<Point>> {
    let others = geo::unary_union(&counter_clockwise(others));
    clockwise(largest(to_geo(ring).difference(&others))?)
}

/// The outer ring of the largest piece.
fn largest(rest: MultiPolygon<f64>) -> Option<Vec<Point>> {
    let largest = rest.into_iter().max_by(|x, y| x.unsigned_area().total_cmp(&y.unsigned_area()))?;
    let mut ring: Vec<Point> = largest.exterior().coords().map(|c| Point::new(c.x, c.y)).collect();
    ring.pop();
    Some(ring)
}

/// All that these rings cover together, with the holes between them.
pub fn ground(rings: &[Vec<Point>]) -> MultiPolygon<f64> {
    geo::unary_union(&counter_clockwise(rings))
}

/// The outer boundary of the largest piece of the union of these rings, clockwise, not closed; `None` if there is none.
/// Points come out moved by up to a millionth of the rings' extent.
pub fn union(rings: &[Vec<Point>]) -> Option<Vec<Point>> {
    clockwise(largest(ground(rings))?)
}

/// As polygons that all run the same way: what crosses itself counts by the non-zero rule.
fn counter_clockwise(rings: &[Vec<Point>]) -> Vec<Polygon<f64>> {
    rings
        .iter()
        .map(|ring| match signed_area(ring) < 0.0 {
            true => to_geo(&ring.iter().rev().copied().collect::<Vec<_>>()),
            false => to_geo(ring),
        })
        .collect()
}

/// The ring turned to run clockwise; `None` if it has no area.
fn clockwise(mut ring: Vec<Point>) -> Option<Vec<Point>> {
    if signed_area(&ring) > 0.0 {
        ring.reverse();
    }
    (ring.len() > 2).then_some(ring)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geo::Centroid;
    use proptest::prelude::*;

    #[test]
    fn squares_share_what_they_share() {
        let square =
            |x: f64, y: f64| [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(a, b)| Point::new(a + x, b + y));
        let mut turned = square(1.0, 1.0);
        turned.reverse();
        assert_eq!(common_area(&square(0.0, 0.0), &turned), 1.0);
        assert_eq!(common_area(&square(0.0, 0.0), &square(2.0, 0.0)), 0.0);
        assert_eq!(common_area(&square(0.0, 0.0), &square(5.0, 0.0)), 0.0);
        assert_eq!(common_area(&square(0.0, 0.0), &[]), 0.0);
    }

    proptest! {
        /// Stars around a centre are simple rings.
        #[test]
        fn the_sum_of_strips_is_the_overlap(
            a in prop::collection::vec(1.0..20.0, 3..30),
            b in prop::collection::vec(1.0..20.0, 3..30),
            (x, y) in (-20.0..20.0, -20.0..20.0),
        ) {
            let star = |radii: &[f64], x: f64, y: f64| -> Vec<Point> {
                let step = std::f64::consts::TAU / radii.len() as f64;
                let spoke = |(i, r): (usize, &f64)| Point::new(x + r * (step * i as f64).cos(), y + r * (step * i as f64).sin());
                radii.iter().enumerate().map(spoke).collect()
            };
            let (a, b) = (star(&a, 5000.0, 7000.0), star(&b, 5000.0 + x, 7000.0 + y));
            prop_assert!((common_area(&a, &b) - overlap(&a, &b)).abs() < 1e-3);
            let part = common_part(&a, &b);
            prop_assert!((part.map_or(0.0, |(area, _)| area) - common_area(&a, &b)).abs() < 1e-6);
            if let (Some((area, middle)), Some(whole)) = (part, intersection(&a, &b).centroid()) && area > 0.1 {
                prop_assert!((middle - Point::new(whole.x(), whole.y())).norm() < 1e-3);
            }
        }
    }
}
