//! Ground within the outline of an intersection that no lanelet needs: a map maker leads the kerb along the lanes, or draws an island.

use std::collections::BTreeSet;

use geo::{Area, BooleanOps, Buffer, Distance, Euclidean, Intersects, Line, LineString, MultiPolygon, Polygon};

use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::lanes::types::Arm;
use crate::geometry::{Point, Polyline, polygon};

/// Between the lanelets and the kerb that leads along them, metres.
const BESIDE: f64 = 0.2;
/// A gap between lanelets stays ground for vehicles up to twice this, metres; a circle of this radius and [`BESIDE`] is empty ground.
const GAP: f64 = 2.3;
/// Behind its cut a road keeps its width for this, metres: its kerb does not begin with a corner.
const RUN_OUT: f64 = 0.5;
/// A strip beside the lanes of a road that is wider than this, metres, such as for parking, ends at a kerb of its own.
const STRIP: f64 = 1.0;
/// Smaller pieces, square metres, are not worth a kerb of their own.
const LEAST: f64 = 15.0;
/// A piece at most this far from the outline, metres, lies at its edge.
const TOUCHES: f64 = 0.1;
/// A piece at the edge reaches this far beyond itself, metres: boolean operations move corners by a hair, and a thread of ground
/// would stay.
const BEYOND: f64 = 0.01;
/// An island's kerb lies this much farther from the lanelets than the kerb at the edge, metres.
const ASIDE: f64 = 0.3;
/// The squares in which empty ground is looked for, metres.
const SQUARE: f64 = 1.0;

/// A piece of ground that lies away from all lanelets and cuts; rings are not closed.
pub enum EmptyGround {
    /// At the edge of the outline, and a hair beyond it.
    Rim(Vec<Point>),
    /// Between lanelets, clockwise: as far from them as a kerb is.
    Island(Vec<Point>),
}

/// The ground of a road at its end.
pub struct RoadGround {
    /// Its cut, or the ring around the ground behind it that the road crosses straight on.
    ground: Vec<Point>,
    /// The sides of the ground, along the cut, of strips outside of all lanes, where cars park or where nobody drives.
    bare: Vec<[Point; 2]>,
}

impl RoadGround {
    /// Of an arm whose cut has these places. Over a crosswalk behind its cut a road goes on as wide as it is.
    pub fn of(arm: &Arm, cut: Vec<Point>) -> Self {
        let lanes = || arm.into.iter().chain(&arm.out);
        let behind = arm.inward * lanes().map(|lane| lane.straight).fold(0.0, f64::max);
        let nearest = |kerb: Point| {
            let ends = lanes().flat_map(|lane| lane.places);
            ends.min_by(|a, b| (a - kerb).norm().total_cmp(&(b - kerb).norm()))
        };
        let kerbs = [cut.first(), cut.last()].into_iter().flatten();
        let bare =
            kerbs.filter_map(|kerb| Some([*kerb, nearest(*kerb)?])).filter(|[kerb, lane]| (kerb - lane).norm() > STRIP);
        let bare = bare.flat_map(|[a, b]| [[a, b], [a + behind, b + behind]]).collect();
        let far_side: Vec<Point> = cut.iter().rev().map(|place| place + behind).collect();
        let ground = if behind.norm() > 0.0 { [cut, far_side].concat() } else { cut };
        Self { ground, bare }
    }
}

/// The empty ground of a simple ring, the largest piece first; not where a strip of a road beside its lanes ends at it: it would
/// stand out.
pub fn empty_ground(ring: &[Point], roads: &[RoadGround], paths: &[TurningLanelet]) -> Vec<EmptyGround> {
    if !has_empty_circle(ring, paths) {
        return Vec::new();
    }
    let outlines: Vec<Vec<Point>> = paths.iter().map(|path| path.outline.clone()).collect();
    let along_cuts = roads.iter().map(|road| match polygon::is_flat(&road.ground) {
        true => road.ground.iter().map(|p| (p.x, p.y)).collect::<LineString>().buffer(RUN_OUT + GAP),
        false => polygon::to_geo(&road.ground).buffer(RUN_OUT + GAP),
    });
    let lanes = polygon::ground(&outlines).buffer(BESIDE + GAP);
    let used = along_cuts.fold(lanes, |used, cut| used.union(&cut)).buffer(-GAP);
    let left = polygon::to_geo(ring).difference(&used);
    let strips: Vec<Line> =
        roads.iter().flat_map(|road| &road.bare).map(|[a, b]| Line::new((a.x, a.y), (b.x, b.y))).collect();
    let is_wide = |piece: &Polygon| {
        let middle: MultiPolygon = piece.buffer(-0.8 * GAP);
        piece.unsigned_area() >= LEAST
            && middle.unsigned_area() > 0.0
            && !strips.iter().any(|strip| Euclidean.distance(strip, piece) < 2.0 * RUN_OUT)
    };
    let mut pieces: Vec<Polygon> = left.into_iter().filter(is_wide).collect();
    pieces.sort_by(|a, b| b.unsigned_area().total_cmp(&a.unsigned_area()));
    let edge = polygon::to_geo(ring);
    let one_movement_apart = |kerb: &[Point]| kerb.iter().any(|place| is_one_movement_apart(*place, ring, paths));
    let kerb = |piece: &Polygon| match Euclidean.distance(edge.exterior(), piece.exterior()) < TOUCHES {
        true => Some(EmptyGround::Rim(largest(&piece.buffer(BEYOND))?)),
        false => {
            let kerb = largest(&piece.buffer(-ASIDE))?;
            one_movement_apart(&kerb).then_some(EmptyGround::Island(kerb))
        }
    };
    pieces.iter().filter_map(kerb).collect()
}

/// The outer ring of the largest polygon, clockwise, not closed.
fn largest(pieces: &MultiPolygon) -> Option<Vec<Point>> {
    let largest = pieces.iter().max_by(|a, b| a.unsigned_area().total_cmp(&b.unsigned_area()))?;
    let mut ring: Vec<Point> = largest.exterior().coords().map(|c| Point::new(c.x, c.y)).collect();
    ring.pop();
    if polygon::signed_area(&ring) > 0.0 {
        ring.reverse();
    }
    Some(ring)
}

/// Whether only lanelets between the same two arms, which are neighbours, lie between a place and the nearest point of the outline: a
/// lane that turns off before the others leads around an island, but the middle of a crossing is no island.
fn is_one_movement_apart(place: Point, ring: &[Point], paths: &[TurningLanelet]) -> bool {
    let Some(outline) = Polyline::new(ring.iter().chain(ring.first()).copied()) else { return false };
    let nearest = outline.project(place).point;
    let way = Line::new((place.x, place.y), (nearest.x, nearest.y));
    let crossed = paths.iter().filter(|path| polygon::to_geo(&path.outline).intersects(&way));
    let pair = |path: &TurningLanelet| [path.movement.from, path.movement.to];
    let mut pairs = crossed.map(pair).map(|[a, b]| [a.min(b), a.max(b)]);
    let used: BTreeSet<usize> = paths.iter().flat_map(pair).collect();
    let are_neighbours = |[a, b]: [usize; 2]| {
        let between = used.range(a..b).count();
        between == 1 || between + 1 == used.len()
    };
    pairs.next().is_some_and(|first| are_neighbours(first) && pairs.all(|other| other == first))
}

/// Whether a circle of empty ground may lie in a ring: a square in it is that far from the outlines of all lanelets, and not much less
/// from the ring. A lanelet is narrower than the circle.
fn has_empty_circle(ring: &[Point], paths: &[TurningLanelet]) -> bool {
    let Some([low, high]) = polygon::bounds(ring) else { return false };
    let [width, height] = [high.x - low.x, high.y - low.y].map(|metres| (metres / SQUARE) as usize + 1);
    let mut near = vec![false; width * height];
    let mut mark = |line: &[Point], radius: f64| {
        let reach = (radius / SQUARE) as i64;
        let halves: Vec<i64> = (-reach..=reach).map(|dy| ((reach * reach - dy * dy) as f64).sqrt() as i64).collect();
        for (a, b) in line.iter().zip(line.iter().cycle().skip(1)) {
            let steps = ((b - a).norm() / SQUARE).ceil().max(1.0);
            for step in 0..steps as usize {
                let at = (a + (b - a) * (step as f64 / steps) - low) / SQUARE;
                let [x, y] = [at.x, at.y].map(|cell| cell.floor() as i64);
                let rows = (y - reach..=y + reach).zip(&halves);
                for (row, half) in rows.filter(|(row, _)| (0..height as i64).contains(row)) {
                    let [from, to] = [x - half, x + half + 1].map(|cell| cell.clamp(0, width as i64) as usize);
                    near[row as usize * width..][from..to].fill(true);
                }
            }
        }
    };
    paths.iter().for_each(|path| mark(&path.outline, BESIDE + GAP));
    mark(ring, 0.8 * GAP);
    // The ring crosses the middle of a row into itself and out of itself by turns.
    near.chunks(width).enumerate().any(|(row, near)| {
        let y = low.y + (row as f64 + 0.5) * SQUARE;
        let edges = ring.iter().zip(ring.iter().cycle().skip(1));
        let crossing =
            edges.filter(|(a, b)| (a.y <= y) != (b.y <= y)).map(|(a, b)| a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x));
        let mut crossings: Vec<f64> = crossing.map(|x| (x - low.x) / SQUARE - 0.5).collect();
        crossings.sort_unstable_by(f64::total_cmp);
        crossings.chunks_exact(2).any(|pair| {
            let [from, to] = [pair[0].ceil(), pair[1].floor() + 1.0].map(|cell| cell.clamp(0.0, width as f64) as usize);
            near[from.min(to)..to].contains(&false)
        })
    })
}

#[cfg(test)]
mod tests {
    use crate::builder::intersection::movement_types::Movement;
    use crate::geometry::Vector;
    use crate::lanelet::{LaneletId, LineStringId};

    use super::*;
    use crate::builder::lanes::types::ArmLane;
    use crate::builder::network::{End, RoadEnd, RoadIx};
    use crate::builder::tags::cross_section::StripKind;

    /// A lanelet 3 m wide along a line from one arm to another.
    fn path(from: usize, to: usize, line: &[(f64, f64)]) -> TurningLanelet {
        let line = Polyline::new(line.iter().map(|&(x, y)| Point::new(x, y))).unwrap();
        let [left, right] = [1.5, -1.5].map(|aside| line.offset(aside, 3.0).unwrap().into_points());
        TurningLanelet {
            movement: Movement { from, to, in_lane: 0, out_lane: 0 },
            lanelet: LaneletId(1),
            turn: 0.0,
            outline: left.into_iter().chain(right.into_iter().rev()).collect(),
            bounds: [LineStringId(1), LineStringId(2)],
            heading: Vector::new(1.0, 0.0),
            corner: 0.0,
            radius: 20.0,
            sway: 0.0,
            kind: StripKind::Drive,
        }
    }

    fn ring(corners: &[(f64, f64)]) -> Vec<Point> {
        corners.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    /// A slip lane from the west to the north, the road that goes straight on, and the one that it joins.
    fn triangle() -> (Vec<Point>, Vec<TurningLanelet>) {
        let outline = ring(&[(-22.0, -2.0), (-22.0, 2.0), (-2.0, 22.0), (2.0, 22.0), (2.0, -2.0)]);
        let slip = path(0, 1, &[(-22.0, 0.0), (-20.0, 0.3), (-0.3, 20.0), (0.0, 22.0)]);
        let paths = vec![slip, path(0, 2, &[(-22.0, 0.0), (2.0, 0.0)]), path(2, 1, &[(0.0, -2.0), (0.0, 22.0)])];
        (outline, paths)
    }

    #[test]
    fn a_slip_lane_leads_around_an_island() {
        let (outline, paths) = triangle();
        let found = empty_ground(&outline, &[], &paths);
        let [EmptyGround::Island(kerb)] = &found[..] else { panic!("no island") };
        assert!(polygon::signed_area(kerb) < -15.0, "clockwise: {kerb:?}");
        let beside = |place: &Point| {
            paths
                .iter()
                .map(|path| {
                    let outline = Polyline::new(path.outline.iter().chain(path.outline.first()).copied()).unwrap();
                    outline.distance(*place)
                })
                .fold(f64::MAX, f64::min)
        };
        assert!(kerb.iter().all(|place| beside(place) > 0.45), "the kerb lies half a metre from the lanes");
        assert!(kerb.iter().all(|place| polygon::contains(&outline, *place)));
    }

    #[test]
    fn the_middle_of_a_crossing_is_no_island() {
        let outline = ring(&[(-15.0, -15.0), (-15.0, 15.0), (15.0, 15.0), (15.0, -15.0)]);
        let far = 8.0;
        let paths = vec![
            path(0, 2, &[(-15.0, -far), (15.0, -far)]),
            path(2, 0, &[(15.0, far), (-15.0, far)]),
            path(3, 1, &[(far, -15.0), (far, 15.0)]),
            path(1, 3, &[(-far, 15.0), (-far, -15.0)]),
        ];
        let found = empty_ground(&outline, &[], &paths);
        assert!(found.iter().all(|piece| matches!(piece, EmptyGround::Rim(_))), "the corners are at the edge");
        let middle = Point::origin();
        let holds = |piece: &EmptyGround| match piece {
            EmptyGround::Rim(ring) | EmptyGround::Island(ring) => polygon::contains(ring, middle),
        };
        assert!(!found.iter().any(holds));
    }

    #[test]
    fn a_wide_corner_is_taken_off_but_not_where_cars_park() {
        let outline = ring(&[(-20.0, -2.0), (-20.0, 12.0), (20.0, 12.0), (20.0, -2.0)]);
        let paths = vec![path(0, 1, &[(-20.0, 0.0), (20.0, 0.0)])];
        let found = empty_ground(&outline, &[], &paths);
        let [EmptyGround::Rim(piece)] = &found[..] else { panic!("not one piece") };
        let [low, high] = polygon::bounds(piece).unwrap();
        assert!((low.y - 1.7).abs() < 0.05 && high.y > 12.0, "{low} {high}");
        let lane =
            |places: [(f64, f64); 2]| ArmLane { places: places.map(|(x, y)| Point::new(x, y)), ..ArmLane::plain() };
        let at = RoadEnd { road: RoadIx::new(0), end: End::Start };
        let east = Vector::new(1.0, 0.0);
        let arm = Arm {
            at,
            inward: east,
            aim: east,
            into: vec![lane([(-20.0, 1.5), (-20.0, -1.5)])],
            out: Vec::new(),
            cut: Vec::new(),
        };
        let parking = RoadGround::of(&arm, ring(&[(-20.0, -1.5), (-20.0, 1.5), (-20.0, 12.0)]));
        assert!(empty_ground(&outline, &[parking], &paths).is_empty());
    }
}
