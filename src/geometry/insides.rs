//! Whether the interiors of two rings meet, decided as Boost.Geometry decides it for Lanelet2: exactly, on a grid.

use super::Point;

/// The number of cells along the longer side of the bounding box of both rings.
const CELLS: f64 = 1e7;

/// A place on the grid; also a vector between two.
pub(super) type Cell = [i64; 2];

/// Whether two rings have interior points in common. Their vertices are first rounded to a grid over both, so that rings that
/// overlap by less than a cell only touch. Rings that cross themselves count by the non-zero rule.
pub fn insides_meet(a: &[Point], b: &[Point]) -> bool {
    let Some(grid) = Grid::over(a, b) else { return false };
    let [a, b] = [a, b].map(|ring| ring.iter().map(|&p| grid.cell(p)).collect::<Vec<Cell>>());
    // If no piece of either ring lies inside or outside the other, the rings are the same.
    let mut same = true;
    for (ring, other) in [(&a, &b), (&b, &a)] {
        let reach = [0, 1].map(|axis| range(other, axis));
        for (from, to) in edges(ring) {
            if [0, 1].iter().any(|&axis| apart(range(&[from, to], axis), reach[axis])) {
                same = false;
                continue;
            }
            let Some(cuts) = cuts(from, to, other) else { return true };
            for pair in cuts.windows(2) {
                match Middle::of(from, to, pair[0] + pair[1]).side(other) {
                    Side::In => return true,
                    Side::On => {}
                    Side::Out => same = false,
                }
            }
        }
    }
    same
}

/// The grid over two rings.
pub(super) struct Grid {
    low: Point,
    /// Cells per metre.
    fineness: f64,
}

impl Grid {
    pub(super) fn over(a: &[Point], b: &[Point]) -> Option<Self> {
        let low = a.iter().chain(b).copied().reduce(|p, q| Point::new(p.x.min(q.x), p.y.min(q.y)))?;
        let size = a.iter().chain(b).map(|p| (p.x - low.x).max(p.y - low.y)).fold(0.0, f64::max);
        let fineness = if size > 0.0 { CELLS / size } else { 1.0 };
        Some(Self { low, fineness: if fineness < 1.0 { fineness } else { (fineness + 0.5).floor() } })
    }

    pub(super) fn cell(&self, p: Point) -> Cell {
        // The sum is rounded as in Boost.Geometry.
        let at = |v: f64, low: f64| (-CELLS / 2.0 + (v - low) * self.fineness).round() as i64;
        [at(p.x, self.low.x), at(p.y, self.low.y)]
    }
}

pub(super) fn minus([ax, ay]: Cell, [bx, by]: Cell) -> Cell {
    [ax - bx, ay - by]
}

pub(super) fn cross(a: Cell, b: Cell) -> i64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn dot(a: Cell, b: Cell) -> i64 {
    a[0] * b[0] + a[1] * b[1]
}

/// The smallest and the largest value of one coordinate.
pub(super) fn range(cells: &[Cell], axis: usize) -> [i64; 2] {
    cells.iter().fold([i64::MAX, i64::MIN], |[low, high], cell| [low.min(cell[axis]), high.max(cell[axis])])
}

pub(super) fn apart(a: [i64; 2], b: [i64; 2]) -> bool {
    a[1] < b[0] || b[1] < a[0]
}

/// The edges of a ring that have a length.
fn edges(ring: &[Cell]) -> impl Iterator<Item = (Cell, Cell)> {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(&from, &to)| (from, to)).filter(|(from, to)| from != to)
}

/// The places on an edge at which vertices of a ring lie, its start and end included, as shares of the square of its length;
/// `None` if an edge of the ring crosses it.
fn cuts(from: Cell, to: Cell, ring: &[Cell]) -> Option<Vec<i64>> {
    let along = minus(to, from);
    let mut cuts = vec![0, dot(along, along)];
    for (c, d) in edges(ring) {
        if [0, 1].iter().any(|&axis| apart(range(&[from, to], axis), range(&[c, d], axis))) {
            continue;
        }
        let own = [c, d].map(|p| cross(along, minus(p, from)).signum());
        let others = [from, to].map(|p| cross(minus(d, c), minus(p, c)).signum());
        if own[0] * own[1] < 0 && others[0] * others[1] < 0 {
            return None;
        }
        if own[0] == 0 {
            cuts.push(dot(along, minus(c, from)).clamp(0, cuts[1]));
        }
    }
    cuts.sort_unstable();
    cuts.dedup();
    Some(cuts)
}

/// Whether a cell lies inside a ring, not on it.
pub(super) fn lies_in(cell: Cell, ring: &[Cell]) -> bool {
    matches!(Middle { at: cell.map(i128::from), scale: 1 }.side(ring), Side::In)
}

/// Where a place lies relative to a ring.
enum Side {
    In,
    On,
    Out,
}

/// The middle of a piece of an edge, in cells times `scale`.
struct Middle {
    at: [i128; 2],
    scale: i128,
}

impl Middle {
    /// The middle of a piece of an edge. `sum` is the sum of the shares at which the piece starts and ends.
    fn of(from: Cell, to: Cell, sum: i64) -> Self {
        let along = minus(to, from);
        let scale = 2 * i128::from(dot(along, along));
        let at = |axis: usize| i128::from(from[axis]) * scale + i128::from(along[axis]) * i128::from(sum);
        Self { at: [at(0), at(1)], scale }
    }

    fn side(&self, ring: &[Cell]) -> Side {
        let mut turns = 0;
        for (c, d) in edges(ring) {
            let from = |p: Cell, axis: usize| self.at[axis] - i128::from(p[axis]) * self.scale;
            let between = |axis: usize| from(c, axis).signum() * from(d, axis).signum() <= 0;
            if !between(1) {
                continue;
            }
            let along = minus(d, c).map(i128::from);
            let left = along[0] * from(c, 1) - along[1] * from(c, 0);
            if left == 0 && between(0) {
                return Side::On;
            }
            // An edge includes its lower end but not its upper one.
            let up = d[1] > c[1];
            if (from(c, 1) < 0) != (from(d, 1) < 0) && (left > 0) == up {
                turns += if up { 1 } else { -1 };
            }
        }
        if turns == 0 { Side::Out } else { Side::In }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64) -> Vec<Point> {
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(dx, dy)| Point::new(x + dx, y + dy)).to_vec()
    }

    #[test]
    fn what_lies_on_or_in_another_meets_it_and_what_touches_does_not() {
        let at = square(0.0, 0.0);
        assert!(insides_meet(&at, &at));
        assert!(insides_meet(&at, &square(0.5, 0.0)));
        assert!(insides_meet(&at, &[Point::new(0.2, 0.2), Point::new(0.8, 0.2), Point::new(0.5, 0.9)]));
        assert!(!insides_meet(&at, &square(1.0, 0.25)));
        assert!(!insides_meet(&at, &square(1.0, 1.0)));
        assert!(!insides_meet(&at, &square(3.0, 0.0)));
    }

    #[test]
    fn less_than_a_cell_is_nothing() {
        // A cell of two squares side by side is 0.2 µm.
        assert!(!insides_meet(&square(0.0, 0.0), &square(1.0 - 1e-8, 0.0)));
        assert!(insides_meet(&square(0.0, 0.0), &square(1.0 - 1e-6, 0.0)));
    }

    #[test]
    fn a_ring_that_goes_around_twice_has_an_inside() {
        let twice = [square(0.0, 0.0), square(0.0, 0.0)].concat();
        assert!(insides_meet(&twice, &[Point::new(0.2, 0.2), Point::new(0.8, 0.2), Point::new(0.5, 0.9)]));
    }
}
