//! Rings, their areas and their unions. A ring is a list of points, not closed.

use geo::algorithm::bool_ops::FillRule;
use geo::{Area, BooleanOps, Buffer, Contains, Coord, Intersects, LineString, MultiPolygon, Polygon};

pub use super::convex_hull::convex_hull;
use super::tangled_ring::untangled;
use super::{Point, Polyline};

/// `geo`'s polygon from a ring.
pub fn to_geo(ring: &[Point]) -> Polygon<f64> {
    Polygon::new(LineString::new(ring.iter().map(|p| Coord { x: p.x, y: p.y }).collect()), Vec::new())
}

/// Whether a ring has no area at all: its points lie on one line, to within a thousandth of a millimetre, or are no numbers. Boolean
/// operations are not made for such rings, so they never get them.
pub fn is_flat(ring: &[Point]) -> bool {
    let Some(first) = ring.first() else { return true };
    let farthest = ring.iter().map(|p| p - first).max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
    let Some(along) = farthest.filter(|along| along.norm().is_finite()) else { return true };
    let near = Polyline::MERGE * along.norm();
    along.norm() <= Polyline::MERGE || ring.iter().all(|p| super::cross(along, p - first).abs() <= near)
}

/// Signed area in square metres: positive when the ring runs counter-clockwise.
pub fn signed_area(ring: &[Point]) -> f64 {
    area_around(ring.iter())
}

/// [`signed_area`] of an iterator of points.
pub fn area_around<'a>(ring: impl Iterator<Item = &'a Point> + Clone) -> f64 {
    let Some(origin) = ring.clone().next() else { return 0.0 };
    let next = ring.clone().cycle().skip(1);
    ring.zip(next).map(|(a, b)| super::cross(a - origin, b - origin)).sum::<f64>() / 2.0
}

/// The common area of two rings, square metres. Rings that cross themselves count by the even-odd rule.
pub fn overlap(a: &[Point], b: &[Point]) -> f64 {
    intersection(a, b).unsigned_area()
}

/// The common area of two simple rings of any orientation, square metres: as [`overlap`], but faster.
///
/// The interior of a simple ring is the strips below its upper edges minus those below its lower edges. The common area is
/// the signed sum, over all pairs of edges, of the area below both.
pub fn common_area(a: &[Point], b: &[Point]) -> f64 {
    let base = a.first().copied().unwrap_or_default();
    Strips::new(a, base).zip(Strips::new(b, base)).map_or(0.0, |(a, b)| a.common_area(&b))
}

/// The common area of two simple rings, square metres, and its centroid; `None` if it is empty. See [`common_area`].
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

/// The edges of a simple ring, for comparison with many others. See [`common_area`].
pub struct Strips {
    bounds: [Point; 2],
    /// The ranges of x + y and x - y.
    diagonals: [[f64; 2]; 2],
    /// The edges of all runs, each run from west to east.
    edges: Vec<Edge>,
    /// For each run its end in `edges`, and its sign: 1 if the ring passes it to the east, -1 to the west.
    runs: Vec<(usize, f64)>,
}

impl Strips {
    /// The edges of a ring; `None` if it has no points. `base` must be the same for all rings that are compared.
    pub fn new(ring: &[Point], base: Point) -> Option<Self> {
        let range = |of: fn(&Point) -> f64| {
            ring.iter().map(of).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
        };
        let (bounds, diagonals) = (bounds(ring)?, [range(|p| p.x + p.y), range(|p| p.x - p.y)]);
        let mut strips = Self { bounds, diagonals, edges: Vec::with_capacity(ring.len()), runs: Vec::with_capacity(4) };
        let (mut first, mut last, mut run_sign) = (0, *ring.last()?, 0.0);
        for p in ring {
            if let Some((edge, sign)) = Edge::new(last, *p, base) {
                if sign != run_sign {
                    strips.end_run(&mut first, run_sign);
                    run_sign = sign;
                }
                strips.edges.push(edge);
            }
            last = *p;
        }
        strips.end_run(&mut first, run_sign);
        Some(strips)
    }

    /// Ends the run that began at edge `first`, if it has edges.
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

    /// The edges of each run with its sign.
    fn runs(&self) -> impl Iterator<Item = (&[Edge], f64)> {
        let mut first = 0;
        self.runs.iter().map(move |&(end, sign)| (&self.edges[std::mem::replace(&mut first, end)..end], sign))
    }

    /// The common area, square metres.
    pub fn common_area(&self, other: &Self) -> f64 {
        if self.may_touch(other) { self.common_area_between(other, EVERYWHERE).abs() } else { 0.0 }
    }

    /// The common area, square metres, within a range of x. It is negative if the rings have different orientations.
    pub(super) fn common_area_between(&self, other: &Self, range: [f64; 2]) -> f64 {
        let mut sum = 0.0;
        self.each_piece(other, range, |piece| sum += piece.below_both());
        sum
    }

    /// Calls `each` with the common x range of every pair of edges, one of each ring.
    fn each_piece(&self, other: &Self, range: [f64; 2], mut each: impl FnMut(EdgePair)) {
        for (a, of_a) in self.runs() {
            for (b, of_b) in other.runs() {
                along_both(a, b, range, of_a * of_b, &mut each);
            }
        }
    }

    /// Whether the bounding boxes overlap, along the axes and along the diagonals.
    pub(super) fn may_touch(&self, other: &Self) -> bool {
        let ([low_a, high_a], [low_b, high_b]) = (self.bounds, other.bounds);
        let (low, high) = (low_a.sup(&low_b), high_a.inf(&high_b));
        let apart = |[low_a, high_a]: [f64; 2], [low_b, high_b]: [f64; 2]| low_a > high_b || low_b > high_a;
        low.x < high.x && low.y < high.y && !(0..2).any(|i| apart(self.diagonals[i], other.diagonals[i]))
    }
}

/// The whole range of x.
const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// Calls `each` with the common x ranges of the edges of two runs, from west to east.
fn along_both(a: &[Edge], b: &[Edge], [west, east]: [f64; 2], sign: f64, each: &mut impl FnMut(EdgePair)) {
    let mut from = a[0].from.max(b[0].from).max(west);
    if from >= a[a.len() - 1].to.min(b[b.len() - 1].to).min(east) {
        return;
    }
    let [mut i, mut j] = [a, b].map(|run| run.partition_point(|edge| edge.to <= from));
    while let (Some(x), Some(y)) = (a.get(i), b.get(j))
        && from < east
    {
        let to = x.to.min(y.to).min(east);
        each(EdgePair { sign, from, to, heights: [[x.at(from), x.at(to)], [y.at(from), y.at(to)]] });
        i += usize::from(x.to <= to);
        j += usize::from(y.to <= to);
        from = to;
    }
}

/// The bounding box of a ring: its lowest and its highest corner.
pub fn bounds(ring: &[Point]) -> Option<[Point; 2]> {
    let first = *ring.first()?;
    Some(ring.iter().fold([first; 2], |[low, high], p| [low.inf(p), high.sup(p)]))
}

/// An edge of a ring as a function of x between `from` and `to`.
struct Edge {
    from: f64,
    to: f64,
    /// Height at `from`.
    height: f64,
    slope: f64,
}

impl Edge {
    /// The edge from one point to another, its heights above `base`, and whether it runs to the east (1) or to the west (-1);
    /// `None` if it is vertical.
    fn new(p: Point, q: Point, base: Point) -> Option<(Self, f64)> {
        let (left, right, sign) = if p.x < q.x { (p, q, 1.0) } else { (q, p, -1.0) };
        let slope = (right.y - left.y) / (right.x - left.x);
        slope.is_finite().then_some((Self { from: left.x, to: right.x, height: left.y - base.y, slope }, sign))
    }

    fn at(&self, x: f64) -> f64 {
        self.height + self.slope * (x - self.from)
    }
}

/// An edge of one ring and an edge of another in their common x range.
struct EdgePair {
    /// 1 if the rings lie on the same side of their edges, else -1.
    sign: f64,
    from: f64,
    to: f64,
    /// The heights of each edge at `from` and `to`.
    heights: [[f64; 2]; 2],
}

impl EdgePair {
    /// The signed area below both edges.
    fn below_both(&self) -> f64 {
        let [a, b] = self.heights;
        let [first, last] = [a[0] - b[0], a[1] - b[1]];
        let least = a[0].min(b[0]) + a[1].min(b[1]);
        // If the edges cross, a triangle above the lower ends belongs to it.
        let crossing = if first * last < 0.0 { first * last / (first - last).abs() } else { 0.0 };
        self.sign * (least - crossing) / 2.0 * (self.to - self.from)
    }

    /// Adds its area and moments; x is counted from `base`.
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

/// An area and the integrals of x and y over it.
#[derive(Default)]
struct Moments {
    area: f64,
    east: f64,
    north: f64,
}

impl Moments {
    /// Adds the area below a straight line.
    fn add_below(&mut self, sign: f64, [from, to]: [f64; 2], [a, b]: [f64; 2]) {
        let width = sign * (to - from);
        let area = width * (a + b) / 2.0;
        self.area += area;
        self.east += from * area + width * (to - from) * (a + 2.0 * b) / 6.0;
        self.north += width * (a * a + a * b + b * b) / 6.0;
    }
}

/// The area that both rings cover.
pub fn intersection(a: &[Point], b: &[Point]) -> MultiPolygon<f64> {
    if is_flat(a) || is_flat(b) {
        return MultiPolygon::new(Vec::new());
    }
    to_geo(&untangled(a)).intersection(&to_geo(&untangled(b)))
}

/// The common area of two rings, square metres. Rings that cross themselves count by the non-zero rule.
pub fn overlap_by_winding(a: &[Point], b: &[Point]) -> f64 {
    if is_flat(a) || is_flat(b) {
        return 0.0;
    }
    to_geo(&untangled(a)).intersection_with_fill_rule(&to_geo(&untangled(b)), FillRule::NonZero).unsigned_area()
}

/// Whether the point lies in the interior of the ring.
pub fn contains(ring: &[Point], p: Point) -> bool {
    to_geo(ring).contains(&geo::Point::new(p.x, p.y))
}

/// The largest piece of `a` that `b` does not cover, as a ring that is not closed; `None` if nothing is left.
pub fn largest_outside(a: &[Point], b: &[Point]) -> Option<Vec<Point>> {
    match [a, b].map(is_flat) {
        [true, _] => None,
        [_, true] => Some(a.to_vec()),
        [false, false] => largest(to_geo(a).difference(&to_geo(b))),
    }
}

/// More rings than this are taken off another one by one.
const MOST_AT_ONCE: usize = 8;

/// The largest piece of `ring` that none of `others` covers, clockwise, not closed; `None` if nothing is left.
pub fn outside(ring: &[Point], others: &[Vec<Point>]) -> Option<Vec<Point>> {
    if is_flat(ring) {
        return None;
    }
    let rest = if others.len() <= MOST_AT_ONCE {
        to_geo(ring).difference(&ground(others))
    } else {
        let others = counter_clockwise(others);
        others.iter().fold(MultiPolygon::from(to_geo(ring)), |rest, other| rest.difference(other))
    };
    clockwise(largest(rest)?)
}

/// The outer ring of the largest piece.
fn largest(rest: MultiPolygon<f64>) -> Option<Vec<Point>> {
    let largest = rest.into_iter().max_by(|x, y| x.unsigned_area().total_cmp(&y.unsigned_area()))?;
    let mut ring: Vec<Point> = largest.exterior().coords().map(|c| Point::new(c.x, c.y)).collect();
    ring.pop();
    Some(ring)
}

/// The union of rings, with its holes.
pub fn ground(rings: &[Vec<Point>]) -> MultiPolygon<f64> {
    united(&counter_clockwise(rings))
}

/// The union of counter-clockwise rings, two at a time: dozens at once whose edges nearly lie on each other take i_overlay 4.5.2 seconds.
fn united(rings: &[Polygon<f64>]) -> MultiPolygon<f64> {
    if rings.len() > 2 {
        let (first, rest) = rings.split_at(rings.len() / 2);
        return united(first).union(&united(rest));
    }
    if rings.is_empty() { MultiPolygon::new(Vec::new()) } else { geo::unary_union(rings) }
}

/// The outer boundary of the largest piece of the union of rings, clockwise, not closed; `None` if it is empty. Points are
/// moved by up to a millionth of the extent.
pub fn union(rings: &[Vec<Point>]) -> Option<Vec<Point>> {
    clockwise(largest(ground(rings))?)
}

/// The outer boundary of the largest piece of the union of rings after gaps and bays up to twice `width` metres wide are filled,
/// clockwise, not closed; `None` if it is empty. Corners keep their places to within a centimetre.
pub fn closed(rings: &[Vec<Point>], width: f64) -> Option<Vec<Point>> {
    let ground = ground(rings);
    if ground.0.is_empty() {
        return None;
    }
    clockwise(largest(ground.buffer(width).buffer(-width))?)
}

/// The pieces of a ring beside a part that is taken off it that are narrower than twice `width` metres and have at least the area `least`,
/// square metres: the teeth that are left where the two meet at a sharp angle.
pub fn teeth(ring: &[Point], part: &[Point], width: f64, least: f64) -> Vec<Vec<Point>> {
    /// The teeth touch the part up to this distance, metres.
    const TOUCHES: f64 = 0.05;
    if is_flat(ring) || is_flat(part) {
        return Vec::new();
    }
    let rest = to_geo(ring).difference(&to_geo(part));
    let narrow = rest.difference(&rest.buffer(-width).buffer(width));
    let beside = to_geo(part).buffer(TOUCHES);
    let is_tooth = |piece: &Polygon<f64>| piece.unsigned_area() >= least && beside.intersects(piece);
    let outer = |piece: Polygon<f64>| {
        let mut ring: Vec<Point> = piece.exterior().coords().map(|c| Point::new(c.x, c.y)).collect();
        ring.pop();
        ring
    };
    narrow.into_iter().filter(is_tooth).map(outer).collect()
}

/// Polygons of the same orientation, as the non-zero rule needs; without those that have no area.
fn counter_clockwise(rings: &[Vec<Point>]) -> Vec<Polygon<f64>> {
    rings
        .iter()
        .filter(|ring| !is_flat(ring))
        .map(|ring| match signed_area(ring) < 0.0 {
            true => to_geo(&ring.iter().rev().copied().collect::<Vec<_>>()),
            false => to_geo(ring),
        })
        .collect()
}

/// The ring, clockwise; `None` if it has fewer than three points.
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
    fn common_area_of_squares() {
        let square =
            |x: f64, y: f64| [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(a, b)| Point::new(a + x, b + y));
        let mut turned = square(1.0, 1.0);
        turned.reverse();
        assert_eq!(common_area(&square(0.0, 0.0), &turned), 1.0);
        assert_eq!(common_area(&square(0.0, 0.0), &square(2.0, 0.0)), 0.0);
        assert_eq!(common_area(&square(0.0, 0.0), &square(5.0, 0.0)), 0.0);
        assert_eq!(common_area(&square(0.0, 0.0), &[]), 0.0);
    }

    #[test]
    fn rings_without_area_have_nothing_in_common_and_add_nothing() {
        let ring = |places: &[(f64, f64)]| places.iter().map(|&(x, y)| Point::new(x, y)).collect::<Vec<_>>();
        let square = ring(&[(0.0, 0.0), (0.0, 4.0), (4.0, 4.0), (4.0, 0.0)]);
        let flat = [
            ring(&[]),
            ring(&[(1.0, 1.0)]),
            ring(&[(1.0, 1.0), (1.0, 1.0), (1.0, 1.0)]),
            ring(&[(0.0, 0.0), (3.0, 1.0), (6.0, 2.0), (3.0, 1.0)]),
            ring(&[(0.0, 0.0), (f64::NAN, 1.0), (2.0, 2.0)]),
            ring(&[(0.0, 0.0), (f64::INFINITY, 1.0), (2.0, 2.0)]),
        ];
        assert!(!is_flat(&square) && !is_flat(&ring(&[(0.0, 0.0), (100.0, 0.001), (200.0, 0.0)])));
        for one in &flat {
            assert!(is_flat(one), "{one:?}");
            assert_eq!(
                (overlap(one, &square), overlap(&square, one), overlap_by_winding(one, &square)),
                (0.0, 0.0, 0.0)
            );
            assert_eq!((largest_outside(one, &square), largest_outside(&square, one)), (None, Some(square.clone())));
            assert_eq!(outside(one, std::slice::from_ref(&square)), None);
            assert_eq!(outside(&square, std::slice::from_ref(one)).map(|rest| signed_area(&rest)), Some(-16.0));
            assert_eq!(closed(std::slice::from_ref(one), 2.0), None);
        }
        let all = [&flat[..], &[square]].concat();
        assert_eq!(union(&all).map(|outline| signed_area(&outline)), Some(-16.0));
    }

    #[test]
    fn what_a_part_leaves_at_a_sharp_angle_is_a_tooth() {
        let ring = |places: &[(f64, f64)]| places.iter().map(|&(x, y)| Point::new(x, y)).collect::<Vec<_>>();
        let ground = ring(&[(0.0, 0.0), (40.0, 0.0), (40.0, 20.0), (0.0, 20.0)]);
        // Between its upper side and the edge of the ground a wedge is left, with its tip at (13.3, 20).
        let sharp = ring(&[(5.0, 19.0), (30.0, 15.0), (30.0, 22.0)]);
        let wedge = teeth(&ground, &sharp, 0.75, 0.4);
        assert_eq!(wedge.len(), 1, "{wedge:?}");
        assert!(wedge[0].iter().all(|p| (3.0..13.4).contains(&p.x) && p.y > 18.0), "{wedge:?}");
        let square = ring(&[(10.0, 15.0), (20.0, 15.0), (20.0, 25.0), (10.0, 25.0)]);
        assert_eq!(teeth(&ground, &square, 0.75, 0.4), Vec::<Vec<Point>>::new(), "right angles stay");
    }

    proptest! {
        /// Stars around a centre are simple rings.
        #[test]
        fn common_area_is_the_overlap(
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
            if let (Some((area, middle)), Some(centroid)) = (part, intersection(&a, &b).centroid()) && area > 0.1 {
                prop_assert!((middle - Point::new(centroid.x(), centroid.y())).norm() < 1e-3);
            }
        }
    }

    #[test]
    fn of_a_tangled_ring_the_hull_counts_and_of_a_ring_with_few_crossings_the_ring() {
        // Golden angles spread points over a disc; each edge crosses most others.
        let at = |i: usize, angle: f64| 50.0 * Point::new((i as f64 * angle).cos(), (i as f64 * angle).sin());
        let tangled: Vec<Point> = (0..500).map(|i| at(i, 2.399_963)).collect();
        let hull = signed_area(&untangled(&tangled)).abs();
        assert!(hull > 7_800.0, "a circle of 50 m has 7,854 m2: {hull}");
        assert!(overlap(&tangled, &tangled) > 7_800.0);
        let mut circle: Vec<Point> = (0..500).map(|i| at(i, std::f64::consts::TAU / 500.0)).collect();
        circle.swap(10, 40);
        assert_eq!(untangled(&circle), circle);
    }
}
