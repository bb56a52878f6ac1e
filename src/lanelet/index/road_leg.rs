//! Road legs: which of the edges around an intersection belong to one approach.

use super::Edge;
use super::thresholds;
use super::union_find::UnionFind;
use crate::geometry::{Point, Vector};

/// An edge that vehicles cross.
#[derive(Clone, Copy, Debug)]
pub struct Crossed {
    /// The edge, left and right in the direction of travel.
    pub edge: Edge,
    /// Whether they come into the intersection here; else they leave it.
    pub inward: bool,
    /// Whether cars do.
    pub for_cars: bool,
}

/// Per edge the first edge of its leg. Edges that share a point belong together, and so do those that lie on one line
/// across the road, as carriageways on both sides of a median do: nearest first, and only as long as cars come on one side
/// of the leg and go on the other. Roads side by side that each lead both ways are legs of their own.
pub fn legs(edges: &[Crossed]) -> Vec<usize> {
    let mut legs = UnionFind::new(edges.len());
    let mut apart: Vec<(f64, usize, usize)> = Vec::new();
    for a in 0..edges.len() {
        for b in a + 1..edges.len() {
            let [one, other] = [&edges[a].edge, &edges[b].edge];
            if one.touches(other) {
                if one.angle_to(other) <= thresholds::ARM_CORNER {
                    legs.join(a, b);
                }
            } else if on_one_line(one, other) {
                apart.push(((one.middle() - other.middle()).norm(), a, b));
            }
        }
    }
    apart.sort_by(|x, y| x.0.total_cmp(&y.0));
    for (_, a, b) in apart {
        let roots = [legs.root(a), legs.root(b)];
        let both: Vec<&Crossed> =
            (0..edges.len()).filter(|&at| roots.contains(&legs.root(at))).map(|at| &edges[at]).collect();
        if roots[0] != roots[1] && changes(&both) <= 1 {
            legs.join(a, b);
        }
    }
    (0..edges.len()).map(|at| legs.root(at)).collect()
}

/// Whether two edges lie on one line across a road.
fn on_one_line(a: &Edge, b: &Edge) -> bool {
    a.angle_to(b) <= thresholds::ARM_ANGLE
        && (a.middle() - b.middle()).norm() <= thresholds::ARM_REACH
        && a.distance_from_line(b.middle()) <= thresholds::ARM_LINE
        && b.distance_from_line(a.middle()) <= thresholds::ARM_LINE
}

/// From one side of a leg to the other, how often lanes in for cars lie beside lanes out.
fn changes(edges: &[&Crossed]) -> usize {
    // To the right of someone who looks in.
    let across: Vector = edges.iter().map(|e| if e.inward { e.edge.across() } else { -e.edge.across() }).sum();
    let mut order: Vec<(f64, bool)> = edges
        .iter()
        .filter(|e| e.for_cars)
        .map(|e| ((e.edge.middle() - Point::origin()).dot(&across), e.inward))
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order.windows(2).filter(|pair| pair[0].1 != pair[1].1).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanelet::PointId;

    /// Edges of 3 m side by side from west to east, as someone looks north into the intersection: where they begin, and
    /// whether they lead in.
    fn side_by_side(edges: &[(f64, bool)]) -> Vec<usize> {
        let edge = |&(x, inward): &(f64, bool)| {
            let mut points = [Point::new(x, 0.0), Point::new(x + 3.0, 0.0)];
            if !inward {
                points.reverse();
            }
            Crossed {
                edge: Edge { ids: points.map(|p| PointId(1 + p.x.round() as i64)), points },
                inward,
                for_cars: true,
            }
        };
        let edges: Vec<Crossed> = edges.iter().map(edge).collect();
        legs(&edges)
    }

    #[test]
    fn carriageways_beside_a_median_are_one_leg() {
        assert_eq!(side_by_side(&[(0.0, false), (5.0, true), (8.0, true)]), [0, 0, 0]);
        assert_eq!(side_by_side(&[(0.0, true), (5.0, true), (9.0, false)]), [0, 0, 0], "a carriageway for a turn");
    }

    #[test]
    fn roads_side_by_side_that_lead_both_ways_are_two_legs() {
        assert_eq!(side_by_side(&[(0.0, false), (3.0, true), (7.0, false), (10.0, true)]), [0, 0, 2, 2]);
        assert_eq!(side_by_side(&[(0.0, true), (3.0, false), (7.0, true), (10.0, false)]), [0, 0, 2, 2]);
    }
}
