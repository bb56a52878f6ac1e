//! The squares that a map is divided into: aligned with the coordinates, not with the map, so that a larger or smaller map is
//! divided along the same lines.

use crate::geometry::Point;

/// An element may reach over this many cells: beyond, a node is misplaced, or the cells are far too small.
const MOST_CELLS: usize = 1 << 20;

/// A square of the grid, by the number of squares between it and the origin. The order is that of rows from south to north.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// To the north.
    pub row: i32,
    /// To the east.
    pub column: i32,
}

/// Squares of one size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    size: u32,
}

/// An element that reaches over more cells than there can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooWide;

impl Grid {
    /// Squares whose sides have this length, metres; `None` if it is 0.
    pub fn new(size: u32) -> Option<Self> {
        (size > 0).then_some(Self { size })
    }

    /// Squares whose sides have this length, metres, which must not be 0.
    pub(crate) const fn of_metres(size: u32) -> Self {
        assert!(size > 0);
        Self { size }
    }

    /// Width and height of a cell, metres.
    pub fn size(self) -> f64 {
        f64::from(self.size)
    }

    /// East and north of the lower left corner of a cell, metres.
    pub fn corner(self, cell: Cell) -> [f64; 2] {
        [cell.column, cell.row].map(|number| f64::from(number) * self.size())
    }

    /// The name of a cell's file: the corner in whole metres.
    pub fn name(self, cell: Cell) -> String {
        let [x, y] = [cell.column, cell.row].map(|number| i64::from(number) * i64::from(self.size));
        format!("{x}_{y}.osm")
    }

    /// The cell in which a place lies; `None` too far away for any.
    pub fn around(self, place: Point) -> Option<Cell> {
        let [x, y] = self.scaled(place);
        row(y).ok().zip(row(x).ok()).map(|(row, column)| Cell { row, column })
    }

    /// Adds the cells that a line touches.
    ///
    /// # Errors
    ///
    /// If there are more than a million.
    pub fn along(self, line: &[Point], found: &mut Vec<Cell>) -> Result<(), TooWide> {
        if let [only] = line {
            let [x, y] = self.scaled(*only);
            return push(found, row(y)?, [x, x]);
        }
        line.windows(2).try_for_each(|ends| self.between([ends[0], ends[1]], found))
    }

    /// Adds the cells that an area touches which its ring does not: those within. The ring need not be closed.
    ///
    /// # Errors
    ///
    /// If there are more than a million.
    pub fn within(self, ring: &[Point], found: &mut Vec<Cell>) -> Result<(), TooWide> {
        // A cell that no side of the ring touches lies within, or not, as a whole: as the line through its middle does.
        let mut crossings: Vec<(i32, f64)> = Vec::new();
        let ends = ring.iter().zip(ring.iter().cycle().skip(1));
        for (a, b) in ends {
            let ([ax, ay], [bx, by]) = (self.scaled(*a), self.scaled(*b));
            let (from, to) = (row(ay.min(by) + 0.5)?, row(ay.max(by) + 0.5)?);
            for row in from..to {
                let middle = f64::from(row) + 0.5;
                crossings.push((row, ax + (middle - ay) * (bx - ax) / (by - ay)));
            }
            if crossings.len() > MOST_CELLS {
                return Err(TooWide);
            }
        }
        crossings.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        crossings.chunks_exact(2).try_for_each(|pair| push(found, pair[0].0, [pair[0].1, pair[1].1]))
    }

    /// Adds the cells between two places, row by row.
    fn between(self, [a, b]: [Point; 2], found: &mut Vec<Cell>) -> Result<(), TooWide> {
        let [[ax, ay], [bx, by]] = [self.scaled(a), self.scaled(b)];
        let [low, high] = if ay <= by { [[ax, ay], [bx, by]] } else { [[bx, by], [ax, ay]] };
        let (first, last) = (row(low[1])?, row(high[1])?);
        if i64::from(last) - i64::from(first) > MOST_CELLS as i64 {
            return Err(TooWide);
        }
        let x_at = |y: f64| low[0] + (y - low[1]) * (high[0] - low[0]) / (high[1] - low[1]);
        for row in first..=last {
            let enters = if row == first { low[0] } else { x_at(f64::from(row)) };
            let leaves = if row == last { high[0] } else { x_at(f64::from(row) + 1.0) };
            push(found, row, [enters, leaves])?;
        }
        Ok(())
    }

    /// East and north in cells. What is no number is at the origin, as in Autoware's loader.
    fn scaled(self, point: Point) -> [f64; 2] {
        [point.x, point.y].map(|metres| if metres.is_finite() { metres / self.size() } else { 0.0 })
    }
}

/// The row or column of a place.
fn row(scaled: f64) -> Result<i32, TooWide> {
    const FARTHEST: f64 = 1e9;
    if scaled.abs() < FARTHEST { Ok(scaled.floor() as i32) } else { Err(TooWide) }
}

/// Adds the cells of a row between two places.
fn push(found: &mut Vec<Cell>, at: i32, [a, b]: [f64; 2]) -> Result<(), TooWide> {
    let (first, last) = (row(a.min(b))?, row(a.max(b))?);
    if found.len() as i64 + i64::from(last) - i64::from(first) > MOST_CELLS as i64 {
        return Err(TooWide);
    }
    found.extend((first..=last).map(|column| Cell { row: at, column }));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const GRID: Grid = Grid { size: 10 };

    fn names(of: impl Fn(&mut Vec<Cell>) -> Result<(), TooWide>) -> Vec<String> {
        let mut found = Vec::new();
        of(&mut found).unwrap();
        found.sort_unstable();
        found.dedup();
        found.into_iter().map(|cell| GRID.name(cell)).collect()
    }

    fn points(of: &[(f64, f64)]) -> Vec<Point> {
        of.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    #[test]
    fn a_cell_has_its_lower_left_rim_and_not_its_upper_right_one() {
        for (x, y, name) in [(0.0, 0.0, "0_0.osm"), (10.0, 9.999, "10_0.osm"), (-0.001, -10.0, "-10_-10.osm")] {
            assert_eq!(names(|found| GRID.along(&points(&[(x, y)]), found)), [name]);
        }
        let cell = Cell { row: -2, column: 3 };
        assert_eq!((GRID.name(cell).as_str(), GRID.corner(cell)), ("30_-20.osm", [30.0, -20.0]));
    }

    #[test]
    fn a_line_touches_what_it_runs_through() {
        let diagonal = points(&[(1.0, 1.0), (28.0, 12.0)]);
        let through = ["0_0.osm", "10_0.osm", "20_0.osm", "20_10.osm"];
        assert_eq!(names(|found| GRID.along(&diagonal, found)), through);
        let back: Vec<Point> = diagonal.into_iter().rev().collect();
        assert_eq!(names(|found| GRID.along(&back, found)), through);
        assert_eq!(names(|found| GRID.along(&points(&[(5.0, 5.0), (5.0, 25.0)]), found)).len(), 3);
    }

    #[test]
    fn an_area_touches_what_is_inside() {
        let square = points(&[(5.0, 5.0), (35.0, 5.0), (35.0, 35.0), (5.0, 35.0)]);
        let inside = names(|found| GRID.within(&square, found));
        assert!(inside.contains(&"10_10.osm".to_owned()) && inside.contains(&"20_20.osm".to_owned()), "{inside:?}");
        assert!(!inside.iter().any(|name| name.starts_with("40")), "{inside:?}");
        assert_eq!(names(|found| GRID.within(&points(&[(1.0, 1.0)]), found)).len(), 0);
    }

    #[test]
    fn what_reaches_over_the_earth_is_too_wide() {
        let far = points(&[(0.0, 0.0), (1e300, 1e300)]);
        let metre = Grid { size: 1 };
        let mut found = Vec::new();
        assert_eq!(metre.along(&far, &mut found), Err(TooWide));
        assert_eq!(metre.along(&points(&[(0.0, 0.0), (0.0, 5e6)]), &mut found), Err(TooWide));
        assert_eq!(metre.along(&points(&[(0.0, 0.0), (5e6, 0.0)]), &mut found), Err(TooWide));
        assert_eq!(metre.within(&points(&[(0.0, 0.0), (0.0, 5e6), (5e6, 0.0)]), &mut found), Err(TooWide));
    }

    proptest! {
        #[test]
        fn every_place_of_a_line_and_an_area_is_in_a_cell_that_is_found(
            size in 1_u32..60,
            corners in prop::collection::vec((-200.0..200.0_f64, -200.0..200.0_f64), 3..8),
            side in 0_usize..8,
            part in 0.0..1.0_f64,
        ) {
            let (grid, ring) = (Grid { size }, points(&corners));
            let mut found = Vec::new();
            grid.along(&ring, &mut found).unwrap();
            let cell = |point: Point| {
                let [x, y] = grid.scaled(point);
                Cell { row: row(y).unwrap(), column: row(x).unwrap() }
            };
            let at = side % (ring.len() - 1);
            let place = ring[at] + (ring[at + 1] - ring[at]) * part;
            // A place that was computed may lie a hair beside the line, and beyond the rim of a cell.
            let near = [-1e-9, 1e-9].map(|hair| cell(place + nalgebra::Vector2::new(hair, hair)));
            let near = [near[0], near[1], cell(place + nalgebra::Vector2::new(1e-9, -1e-9)), cell(place + nalgebra::Vector2::new(-1e-9, 1e-9))];
            prop_assert!(near.iter().any(|cell| found.contains(cell)));
            // The middle of a triangle lies within it.
            let triangle = &ring[..3];
            let middle = Point::from((ring[0].coords + ring[1].coords + ring[2].coords) / 3.0);
            let mut found = Vec::new();
            grid.along(&[ring[0], ring[1], ring[2], ring[0]], &mut found).unwrap();
            grid.within(triangle, &mut found).unwrap();
            prop_assert!(found.contains(&cell(middle)));
        }
    }
}
