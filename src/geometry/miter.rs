//! The miter point of a corner.

use super::{Point, Vector, left_of};

/// The point `offset` metres to the left of both segments of a corner, of which the unit directions are given. It lies far away
/// if the line nearly turns back.
pub fn miter(corner: Point, [before, after]: [Vector; 2], offset: f64) -> Point {
    corner + (left_of(before) + left_of(after)) * (offset / (1.0 + before.dot(&after)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_lies_beside_both_lines() {
        let [east, north] = [Vector::x(), Vector::y()];
        let corner = Point::new(10.0, 20.0);
        assert_eq!(miter(corner, [east, north], 2.0), Point::new(8.0, 22.0));
        assert_eq!(miter(corner, [east, north], -2.0), Point::new(12.0, 18.0));
        assert_eq!(miter(corner, [east, east], 2.0), Point::new(10.0, 22.0));
    }
}
