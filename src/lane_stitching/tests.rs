//! Joints and paint of two or three lanes.

use crate::geometry::simple_ring::is_simple;
use crate::geometry::{Point, Polyline, Vector};

use super::*;

const HALF: f64 = 1.75;
const A: LaneId = LaneId { road: 1, lane: 0 };
const B: LaneId = LaneId { road: 2, lane: 0 };
const C: LaneId = LaneId { road: 3, lane: 0 };

fn line(points: &[(f64, f64)]) -> Polyline {
    Polyline::new(points.iter().map(|&(x, y)| Point::new(x, y))).unwrap()
}

fn wide(points: &[(f64, f64)], width: f64) -> Lane {
    Lane::along(line(points), Widths::even(width).unwrap()).unwrap()
}

fn lane(points: &[(f64, f64)]) -> Lane {
    wide(points, 2.0 * HALF)
}

/// A lane of 40 m that leaves the origin at this angle, degrees, from east.
fn leaving(degrees: f64, points: usize) -> Lane {
    let along = Vector::new(degrees.to_radians().cos(), degrees.to_radians().sin());
    let step = 40.0 / (points - 1) as f64;
    let middle = Polyline::new((0..points).map(|i| Point::origin() + along * (i as f64 * step))).unwrap();
    Lane::along(middle, Widths::even(2.0 * HALF).unwrap()).unwrap()
}

/// A lane of 40 m that comes to the origin from the west.
fn coming(points: usize) -> Lane {
    let step = 40.0 / (points - 1) as f64;
    let middle = Polyline::new((0..points).map(|i| Point::new(-40.0 + i as f64 * step, 0.0))).unwrap();
    Lane::along(middle, Widths::even(2.0 * HALF).unwrap()).unwrap()
}

fn turning(degrees: f64) -> LaneStitching {
    LaneStitching::new([(A, coming(2)), (B, leaving(degrees, 2))])
}

/// The point that both lanes share on a side.
fn shared(stitching: &LaneStitching, side: usize) -> Point {
    let [a, b] = [A, B].map(|id| stitching.get(id).unwrap().bounds()[side].clone());
    assert_eq!(a.last(), b.first(), "a gap on side {side}");
    b[0]
}

fn close(a: Point, b: (f64, f64)) -> bool {
    (a - Point::new(b.0, b.1)).norm() < 1e-9
}

#[test]
fn ends_meet_in_four_ways() {
    let (west, east) = ([(-40.0, 0.0), (0.0, 0.0)], [(0.0, 0.0), (40.0, 9.0)]);
    let back = |points: [(f64, f64); 2]| [points[1], points[0]];
    let at = |a: [(f64, f64); 2], b: [(f64, f64); 2]| {
        let stitching = LaneStitching::new([(A, lane(&a)), (B, lane(&b))]);
        LaneEnd::BOTH.map(|end| stitching.meeting(A, end).unwrap())
    };
    assert_eq!(at(west, east), [Meeting::Open, Meeting::Joined(B)]);
    assert_eq!(at(back(west), back(east)), [Meeting::Joined(B), Meeting::Open]);
    assert_eq!(at(back(west), east), [Meeting::Fork, Meeting::Open]);
    assert_eq!(at(west, back(east)), [Meeting::Open, Meeting::Merge]);
}

#[test]
fn forks_and_merges_stay_as_they_are() {
    for (a, b) in [
        ([(0.0, 0.0), (-40.0, 0.0)], [(0.0, 0.0), (40.0, 9.0)]),
        ([(-40.0, 0.0), (0.0, 0.0)], [(40.0, 9.0), (0.0, 0.0)]),
    ] {
        let both = LaneStitching::new([(A, lane(&a)), (B, lane(&b))]);
        assert_eq!(both.get(A), LaneStitching::new([(A, lane(&a))]).get(A));
    }
}

#[test]
fn three_ends_are_not_stitched() {
    let three = [(A, coming(2)), (B, leaving(20.0, 2)), (C, leaving(-20.0, 2))];
    let stitching = LaneStitching::new(three);
    assert_eq!(stitching.meeting(A, LaneEnd::End), Some(Meeting::Junction));
    assert_eq!(stitching.get(A), LaneStitching::new([(A, coming(2))]).get(A));
}

#[test]
fn a_lane_is_not_stitched_to_itself() {
    let ring = lane(&[(0.0, 0.0), (40.0, 0.0), (40.0, 40.0), (0.0, 40.0), (0.0, 0.0)]);
    assert_eq!(LaneStitching::new([(A, ring)]).meeting(A, LaneEnd::End), Some(Meeting::Loop));
}

#[test]
fn lanes_that_lead_back_are_not_stitched() {
    // Side by side, as both directions of a road at its dead end, and on the same ground, as those of a single track.
    for y in [3.5, 0.0] {
        let lanes =
            [(A, coming(2).on_nodes([None, Some(7)])), (B, lane(&[(0.0, y), (-40.0, y)]).on_nodes([Some(7), None]))];
        let stitching = LaneStitching::new(lanes.clone());
        assert_eq!(stitching.meeting(A, LaneEnd::End), Some(Meeting::Back));
        assert_eq!(stitching.meeting(B, LaneEnd::Start), Some(Meeting::Back));
        for (id, lane) in lanes {
            assert_eq!(stitching.get(id), LaneStitching::new([(id, lane)]).get(id));
        }
    }
    assert_eq!(turning(171.5).meeting(A, LaneEnd::End), Some(Meeting::Joined(B)));
    assert_eq!(turning(172.5).meeting(A, LaneEnd::End), Some(Meeting::Back));
}

#[test]
fn both_sides_of_a_bend_are_mitred() {
    for degrees in [1.0, 20.0, 90.0, 140.0, -20.0, -90.0, -140.0_f64] {
        let stitching = turning(degrees);
        // On the bisector, half a width from both middle lines.
        let half = degrees.to_radians() / 2.0;
        let miter = (-half.sin() * HALF / half.cos(), HALF);
        assert!(close(shared(&stitching, 0), miter), "{degrees}: {:?}", shared(&stitching, 0));
        assert!(close(shared(&stitching, 1), (-miter.0, -miter.1)), "{degrees}: {:?}", shared(&stitching, 1));
    }
}

#[test]
fn the_ends_of_straight_lanes_stay() {
    let stitching = turning(0.0);
    assert!(close(shared(&stitching, 0), (0.0, HALF)) && close(shared(&stitching, 1), (0.0, -HALF)));
    assert_eq!(stitching.get(A).unwrap().bounds()[0].len(), 2);
}

#[test]
fn an_outer_miter_ends_at_three_half_widths() {
    // The miter lies one half width divided by the cosine of half the turn away: three half widths at 141.06 degrees.
    let reach = |degrees: f64| (shared(&turning(degrees), 1) - Point::origin()).norm() / HALF;
    assert!((reach(141.0) - 1.0 / 70.5_f64.to_radians().cos()).abs() < 1e-9 && reach(141.0) < 3.0);
    for degrees in [141.1, 150.0, 170.0] {
        assert!((reach(degrees) - 3.0).abs() < 1e-9, "{degrees}: {}", reach(degrees));
        // In the direction of the exact miter.
        let along = shared(&turning(degrees), 1);
        let half = degrees.to_radians() / 2.0;
        assert!((along.y / along.x + half.cos() / half.sin()).abs() < 1e-9);
    }
}

#[test]
fn an_inner_corner_is_exact_at_any_distance() {
    for degrees in [141.1, 150.0, 165.0_f64] {
        let half = degrees.to_radians() / 2.0;
        let exact = (-half.sin() * HALF / half.cos(), HALF);
        assert!((exact.0.hypot(exact.1)) > 3.0 * HALF);
        assert!(close(shared(&turning(degrees), 0), exact), "{degrees}");
    }
}

/// Two borders on the outside of a bend whose miter lies beyond the cap; the second leaves at this angle, degrees.
fn far_miter(degrees: f64) -> (Point, Point) {
    let (from, to) = (Point::new(0.0, -1.0), Point::new(12.0, 11.0));
    let along = Vector::new(degrees.to_radians().cos(), degrees.to_radians().sin());
    let (a, b) = ([Point::new(-40.0, -1.0), from], [to, to + along * 40.0]);
    let [pull, other] = meet([Strand::ending(&a), Strand::starting(&b)], Point::origin(), 1.0);
    assert_eq!(pull.place, other.place);
    (pull.place, nalgebra::center(&from, &to))
}

#[test]
fn a_long_miter_is_clamped_from_120_degrees_on_and_bevelled_below() {
    for degrees in [90.0, 119.0, 119.99] {
        let (place, bevel) = far_miter(degrees);
        assert_eq!(place, bevel, "{degrees}");
    }
    for degrees in [120.01, 121.0, 150.0] {
        let (place, _) = far_miter(degrees);
        assert!(((place - Point::origin()).norm() - 3.0).abs() < 1e-9, "{degrees}: {place}");
    }
}

#[test]
fn the_cap_is_that_of_the_wider_lane() {
    // Half widths of 1 and 2 m: the miter on the outside of this bend lies 3.5 m away, within three times the wider.
    let stitching =
        LaneStitching::new([(A, wide(&[(-40.0, 0.0), (0.0, 0.0)], 2.0)), (B, wide(&[(0.0, 0.0), (0.0, 40.0)], 4.0))]);
    assert!(close(shared(&stitching, 1), (2.0, -1.0)));
    // In a slight bend the borders cross far away, and a bevel joins them.
    let stitching =
        LaneStitching::new([(A, wide(&[(-40.0, 0.0), (0.0, 0.0)], 2.0)), (B, wide(&[(0.0, 0.0), (40.0, 0.5)], 4.0))]);
    let place = shared(&stitching, 1);
    assert!((place.y + 1.5).abs() < 0.01 && place.x.abs() < 0.1, "{place}");
}

#[test]
fn sparse_borders_are_trimmed_and_dense_ones_are_not() {
    // The last points before the bend lie beyond the crossing of the inner borders.
    let near = |points: usize| -> Vec<(f64, f64)> {
        let mut x: Vec<f64> = (0..points - 2).map(|i| -40.0 + 5.0 * i as f64).collect();
        x.extend([-0.5, 0.0]);
        x.into_iter().map(|x| (x, 0.0)).collect()
    };
    let inner = |points: usize| {
        let stitching = LaneStitching::new([(A, lane(&near(points))), (B, leaving(90.0, 2))]);
        (shared(&stitching, 0), stitching.get(A).unwrap().bounds()[0].len())
    };
    let (place, left) = inner(6);
    assert!(close(place, (-HALF, HALF)), "{place}");
    assert_eq!(left, 5);
    let (place, left) = inner(7);
    assert!(close(place, (-HALF / 2.0, HALF / 2.0)), "{place}");
    // Only the point from which it would run back is lost.
    assert_eq!(left, 6);
    // No point is lost if none lies beyond the crossing.
    let stitching = LaneStitching::new([(A, coming(81)), (B, leaving(20.0, 81))]);
    assert!(close(shared(&stitching, 0), (-HALF * 10_f64.to_radians().tan(), HALF)));
    assert_eq!(stitching.get(A).unwrap().bounds()[0].len(), 81);
}

#[test]
fn the_outline_follows_the_ends() {
    let stitching = turning(60.0);
    for (_, lane) in stitching.iter() {
        let [left, right] = lane.bounds();
        let ring: Vec<Point> = left.iter().chain(right.iter().rev()).copied().collect();
        assert_eq!(lane.outline(), ring);
    }
    assert!(stitching.get(A).unwrap().outline().contains(&shared(&stitching, 0)));
}

#[test]
fn no_joint_folds_an_outline() {
    for degrees in (-170..=170).step_by(5) {
        for points in [[2, 2], [3, 6], [6, 9], [9, 81], [81, 81]] {
            let stitching = LaneStitching::new([(A, coming(points[0])), (B, leaving(f64::from(degrees), points[1]))]);
            for (id, lane) in stitching.iter() {
                assert!(
                    is_simple(lane.outline()),
                    "{degrees} degrees, {points:?} points, {id:?}: {:?}",
                    lane.outline()
                );
            }
            shared(&stitching, 0);
            shared(&stitching, 1);
        }
    }
}

#[test]
fn explicit_bounds_are_neither_stitched_nor_painted() {
    let bounds = [line(&[(-40.0, 2.0), (0.3, 2.0)]), line(&[(-40.0, -2.0), (-0.3, -2.0)])];
    let solid = || vec![Marking { station: 0.0, kinds: vec![Kind::Solid(Paint::White)] }];
    let given = Lane::between(bounds.clone()).unwrap().painted([solid(), solid()]).unwrap();
    let stitching = LaneStitching::new([(A, given), (B, leaving(30.0, 2))]);
    assert_eq!(stitching.meeting(A, LaneEnd::End), Some(Meeting::Explicit));
    assert_eq!(stitching.meeting(B, LaneEnd::Start), Some(Meeting::Explicit));
    let [left, right] = stitching.get(A).unwrap().bounds();
    assert_eq!([&left[..], &right[..]], [bounds[0].points(), bounds[1].points()]);
    assert!(stitching.get(A).unwrap().strokes().is_empty());
    assert_eq!(stitching.get(B), LaneStitching::new([(B, leaving(30.0, 2))]).get(B));
}

#[test]
fn a_lane_under_edit_is_left_out() {
    // The dragged lane passes the joint of two others.
    let mut stitching = LaneStitching::new([(A, coming(2)), (B, leaving(30.0, 2)), (C, leaving(200.0, 2))]);
    assert_eq!(stitching.meeting(A, LaneEnd::End), Some(Meeting::Junction));
    assert_eq!(stitching.exclude(Some(C)), [A, B]);
    assert_eq!(stitching.meeting(A, LaneEnd::End), Some(Meeting::Joined(B)));
    assert_eq!(stitching.meeting(C, LaneEnd::Start), Some(Meeting::Excluded));
    shared(&stitching, 0);
    assert_eq!(stitching.exclude(None), [A, B]);
    assert_eq!(stitching.meeting(A, LaneEnd::End), Some(Meeting::Junction));
}

#[test]
fn ends_without_a_node_meet_on_one_centimetre() {
    let at = |x: f64| LaneStitching::new([(A, coming(2)), (B, lane(&[(x, 0.0), (40.0, 9.0)]))]);
    assert_eq!(at(0.004).meeting(A, LaneEnd::End), Some(Meeting::Joined(B)));
    shared(&at(0.004), 0);
    assert_eq!(at(0.006).meeting(A, LaneEnd::End), Some(Meeting::Open));
}

#[test]
fn ends_with_a_node_meet_by_graph() {
    let joined = |a: Option<i64>, b: Option<i64>, x: f64| {
        let away = lane(&[(x, 0.0), (40.0, 9.0)]).on_nodes([b, None]);
        LaneStitching::new([(A, coming(2).on_nodes([None, a])), (B, away)]).meeting(A, LaneEnd::End)
    };
    assert_eq!(joined(Some(7), Some(7), 0.2), Some(Meeting::Joined(B)));
    assert_eq!(joined(Some(7), Some(8), 0.0), Some(Meeting::Open));
    assert_eq!(joined(Some(7), None, 0.0), Some(Meeting::Open));
}

#[test]
fn invalid_lanes_are_refused() {
    let straight = || line(&[(0.0, 0.0), (1.0, 0.0)]);
    assert!(matches!(Widths::even(0.0), Err(LaneError::Width { .. })));
    assert!(matches!(Widths::even(f64::NAN), Err(LaneError::Width { .. })));
    assert_eq!(Widths::new(Vec::new()), Err(LaneError::NoWidth));
    let at = |station| WidthAt { station, left: 1.0, right: 1.0 };
    assert_eq!(Widths::new(vec![at(3.0), at(2.0)]), Err(LaneError::Order(3.0, 2.0)));
    let far = line(&[(0.0, 0.0), (1e9, 0.0)]);
    assert_eq!(Lane::between([straight(), far]), Err(LaneError::Place(1e9, 0.0)));
    let painted = [vec![Marking { station: f64::NAN, kinds: Vec::new() }], Vec::new()];
    assert!(Lane::between([straight(), straight()]).unwrap().painted(painted).is_err());
}

#[test]
fn a_middle_line_that_turns_back_stays_finite() {
    // Resampled, it has the same point before and after its turn.
    let back = line(&[(0.0, 0.0), (30.0, 0.0), (20.0, 0.0)]).resampled_to(5);
    let stitching = LaneStitching::new([(A, Lane::along(back, Widths::even(2.0).unwrap()).unwrap())]);
    let finite = |p: &Point| p.x.is_finite() && p.y.is_finite();
    assert!(stitching.get(A).unwrap().outline().iter().all(finite));
    let spot = line(&[(0.0, 0.0), (1.0, 0.0), (0.0, 0.0)]).resampled_to(2);
    assert_eq!(Lane::along(spot, Widths::even(2.0).unwrap()), Err(LaneError::NoLength));
}

mod painted {
    use super::*;

    type Drawn = (Kind, Colour, Vec<(f64, f64)>);

    /// The strokes along the left bound of a straight lane of 20 m, 1.75 m to the left of its middle.
    fn strokes(markings: &[(f64, &[Kind])]) -> Vec<Drawn> {
        let markings = markings.iter().map(|&(station, kinds)| Marking { station, kinds: kinds.to_vec() }).collect();
        let lane = lane(&[(0.0, 0.0), (20.0, 0.0)]).painted([markings, Vec::new()]).unwrap();
        let stitching = LaneStitching::new([(A, lane)]);
        let strokes = stitching.get(A).unwrap().strokes();
        assert_eq!(strokes.iter().count(), strokes.len());
        strokes
            .iter()
            .map(|stroke| (stroke.kind, stroke.colour, stroke.line.iter().map(|p| (p.x, p.y)).collect()))
            .collect()
    }

    #[test]
    fn solid_lines_have_their_colour() {
        for (paint, colour) in [(Paint::White, Colour::White), (Paint::Yellow, Colour::Yellow)] {
            let kind = Kind::Solid(paint);
            assert_eq!(strokes(&[(0.0, &[kind])]), [(kind, colour, vec![(0.0, HALF), (20.0, HALF)])]);
        }
    }

    #[test]
    fn dashes_are_3_m_long_every_9_m() {
        let kind = Kind::Dashed(Paint::White);
        let dash = |from, to| (kind, Colour::White, vec![(from, HALF), (to, HALF)]);
        assert_eq!(strokes(&[(0.0, &[kind])]), [dash(0.0, 3.0), dash(9.0, 12.0), dash(18.0, 20.0)]);
    }

    #[test]
    fn dots_are_half_a_metre_long_every_metre() {
        let drawn = strokes(&[(0.0, &[Kind::Dotted(Paint::Yellow)])]);
        assert_eq!(drawn.len(), 20);
        assert_eq!(drawn[19].2, [(19.0, HALF), (19.5, HALF)]);
        assert_eq!(drawn[19].1, Colour::Yellow);
    }

    #[test]
    fn a_double_line_is_two_parallels() {
        for (paint, colour) in [(Paint::Yellow, Colour::Yellow), (Paint::White, Colour::White)] {
            let kind = Kind::Double(paint);
            let line = |y| (kind, colour, vec![(0.0, y), (20.0, y)]);
            assert_eq!(strokes(&[(0.0, &[kind])]), [line(HALF + 0.18), line(HALF - 0.18)]);
        }
    }

    #[test]
    fn either_line_of_a_double_line_can_be_dashed() {
        let solid = |kind, y| (kind, Colour::White, vec![(0.0, y), (20.0, y)]);
        let dash = |kind, y, from, to| (kind, Colour::White, vec![(from, y), (to, y)]);
        let dashes = |kind, y| [dash(kind, y, 0.0, 3.0), dash(kind, y, 9.0, 12.0), dash(kind, y, 18.0, 20.0)];
        let kind = Kind::SolidDashed(Paint::White);
        let [first, second, third] = dashes(kind, HALF - 0.18);
        assert_eq!(strokes(&[(0.0, &[kind])]), [solid(kind, HALF + 0.18), first, second, third]);
        let kind = Kind::DashedSolid(Paint::White);
        let [first, second, third] = dashes(kind, HALF + 0.18);
        assert_eq!(strokes(&[(0.0, &[kind])]), [first, second, third, solid(kind, HALF - 0.18)]);
    }

    #[test]
    fn a_kerb_is_grey_and_an_unknown_marking_is_magenta() {
        let line = vec![(0.0, HALF), (20.0, HALF)];
        assert_eq!(strokes(&[(0.0, &[Kind::Kerb])]), [(Kind::Kerb, Colour::Grey, line.clone())]);
        assert_eq!(strokes(&[(0.0, &[Kind::Unknown])]), [(Kind::Unknown, Colour::Magenta, line)]);
        assert_eq!(strokes(&[(0.0, &[Kind::Virtual])]), []);
        let stitching = |kind| {
            let marking = Marking { station: 0.0, kinds: vec![kind] };
            let lane = lane(&[(0.0, 0.0), (20.0, 0.0)]).painted([Vec::new(), vec![marking]]).unwrap();
            let stitching = LaneStitching::new([(A, lane)]);
            stitching.get(A).unwrap().strokes().iter().map(|s| (s.side, s.breadth)).next().unwrap()
        };
        assert_eq!(stitching(Kind::Kerb).0, 1);
        assert!(stitching(Kind::Kerb).1 > stitching(Kind::Solid(Paint::White)).1);
    }

    #[test]
    fn pieces_are_cut_by_station() {
        let (solid, kerb) = (Kind::Solid(Paint::White), Kind::Kerb);
        let drawn = strokes(&[(5.0, &[solid]), (12.0, &[]), (15.0, &[solid, kerb]), (30.0, &[kerb])]);
        let piece = |kind, colour, from, to| (kind, colour, vec![(from, HALF), (to, HALF)]);
        let white = |from, to| piece(solid, Colour::White, from, to);
        assert_eq!(drawn, [white(5.0, 12.0), white(15.0, 20.0), piece(kerb, Colour::Grey, 15.0, 20.0)]);
    }

    #[test]
    fn pieces_bend_with_the_bound() {
        let marking = Marking { station: 5.0, kinds: vec![Kind::Solid(Paint::White)] };
        let lane = lane(&[(0.0, 0.0), (10.0, 0.0), (10.0, -20.0)]).painted([vec![marking], Vec::new()]).unwrap();
        let stitching = LaneStitching::new([(A, lane)]);
        let line = stitching.get(A).unwrap().strokes().iter().next().unwrap().line.to_vec();
        assert_eq!(line, [(5.0, HALF), (11.75, HALF), (11.75, -20.0)].map(|(x, y)| Point::new(x, y)));
    }

    #[test]
    fn paint_runs_from_joint_to_joint() {
        let solid = || vec![Marking { station: 0.0, kinds: vec![Kind::Solid(Paint::White)] }];
        let painted = |lane: Lane| lane.painted([solid(), solid()]).unwrap();
        let stitching = LaneStitching::new([(A, painted(coming(2))), (B, painted(leaving(40.0, 2)))]);
        for side in [0, 1] {
            let line = |id| stitching.get(id).unwrap().strokes().iter().nth(side).unwrap().line.to_vec();
            assert_eq!(line(A).last(), Some(&shared(&stitching, side)));
            assert_eq!(line(B).first(), Some(&shared(&stitching, side)));
        }
    }

    #[test]
    fn a_line_around_the_world_costs_no_memory() {
        let marking = Marking { station: 0.0, kinds: vec![Kind::Dotted(Paint::White)] };
        let lane = lane(&[(0.0, 0.0), (9e7, 0.0)]).painted([vec![marking], Vec::new()]).unwrap();
        assert_eq!(LaneStitching::new([(A, lane)]).get(A).unwrap().strokes().len(), 10_000);
    }
}
