//! Bounds of which the points are in the wrong order: those that run back over themselves for a piece, or cross themselves between
//! two points that are exchanged.

use crate::diagnostic::{Edit, Finding, Subject};
use crate::geometry::polyline::distance_to_segment;
use crate::geometry::{Point, angle_between, segment_crossing};
use crate::lanelet::LineStringId;
use crate::lanelet::index::MapIndex;

/// A bound that turns by more than this, degrees, goes back where it came from; the tightest hairpin bends over metres.
const BACK: f64 = 150.0;
/// A bound that turns by less than this, degrees, goes on.
const ON: f64 = 60.0;
/// So near, metres, do the points that are left out lie to what is left: the bound stays where it was drawn.
const SAME_LINE: f64 = 0.05;

/// A bound that runs back by less than this, metres, was drawn with an unsteady hand.
const SLIP: f64 = 0.1;
/// A bound that runs back more often than this is a scribble.
const MOST_FOLDS: usize = 8;
/// It runs back over no more points than these.
const LONGEST_FOLD: usize = 16;
/// Bounds of more points than these are not held against themselves piece by piece.
const MOST_POINTS: usize = 400;

/// Adds the fix that lets a bound run on where it runs back over itself or crosses itself. Its ends stay.
pub fn with_points_in_order(map: &MapIndex, finding: Finding, bound: LineStringId) -> Finding {
    let Some((ids, line)) = points(map, bound) else { return finding };
    let ordered = match (without_folds(&line), exchanged(&line)) {
        (Some(kept), _) => {
            Some((format!("leave out the points of way {bound} on which it runs back over itself"), kept))
        }
        (None, Some(order)) => {
            Some((format!("exchange two points of way {bound}, between which it crosses itself"), order))
        }
        (None, None) => None,
    };
    let Some((title, order)) = ordered else { return finding };
    let points = order.into_iter().filter_map(|index| ids.get(index).copied()).collect();
    finding.fixed_by(title, false, vec![Edit::SetVertices { way: Subject::LineString(bound.0), points }])
}

/// The place from which a bound runs back over itself for a piece, before it goes on.
pub fn fold(map: &MapIndex, bound: LineStringId) -> Option<Point> {
    let (_, line) = points(map, bound)?;
    let kept = without_folds(&line)?;
    let pairs = kept.windows(2).map(|pair| (line[pair[0]], &line[pair[0] + 1..pair[1]]));
    let mut far = pairs.filter(|(from, out)| out.iter().any(|place| (place - from).norm() > SLIP));
    far.next().map(|(from, _)| from)
}

/// The ids of a bound's points and where they lie; `None` where one is missing.
fn points(map: &MapIndex, bound: LineStringId) -> Option<(Vec<i64>, Vec<Point>)> {
    let ids = &map.map.linestrings.get(bound)?.points;
    let line: Vec<Point> = map.map.points.get_each(ids.iter().copied()).map(|point| point.position).collect();
    (line.len() == ids.len()).then(|| (ids.iter().map(|id| id.0).collect(), line))
}

/// Which points of a line are left when it does not run back over itself any more; `None` if it never does, does so too often, or does not
/// go on there.
fn without_folds(line: &[Point]) -> Option<Vec<usize>> {
    let mut kept: Vec<usize> = (0..line.len()).collect();
    let mut from = 1;
    for _ in 0..=MOST_FOLDS {
        let Some(fold) = (from..kept.len().saturating_sub(1)).find(|&at| turn(line, &kept, at) > BACK) else {
            return (kept.len() < line.len()).then_some(kept);
        };
        let next = (fold + 2..kept.len()).take(LONGEST_FOLD).find(|&next| {
            let shorter = [&kept[fold - 1..=fold], &kept[next..kept.len().min(next + 2)]].concat();
            let runs_on = [1, 2].into_iter().all(|at| turn(line, &shorter, at) < ON);
            runs_on && kept[fold + 1..next].iter().all(|&out| is_on(line, &shorter, line[out]))
        })?;
        kept.drain(fold + 1..next);
        from = fold;
    }
    None
}

/// By how much a line through some of these points turns at one of them, degrees; 0 at its ends.
fn turn(line: &[Point], through: &[usize], at: usize) -> f64 {
    let inner = at.checked_sub(1).and_then(|before| through.get(before..at + 2));
    let Some(&[before, here, behind]) = inner else { return 0.0 };
    angle_between(line[here] - line[before], line[behind] - line[here]).to_degrees().abs()
}

fn is_on(line: &[Point], through: &[usize], place: Point) -> bool {
    through.windows(2).any(|pair| distance_to_segment(place, line[pair[0]], line[pair[1]]) < SAME_LINE)
}

/// The points of a line in the order in which it does not cross itself, where it does so only between two that follow each other.
fn exchanged(line: &[Point]) -> Option<Vec<usize>> {
    if line.len() > MOST_POINTS {
        return None;
    }
    let in_file: Vec<usize> = (0..line.len()).collect();
    let at = (0..line.len().saturating_sub(3)).find(|&at| crosses(line, &in_file, at, at + 2))?;
    let mut order = in_file;
    order.swap(at + 1, at + 2);
    let last = line.len() - 1;
    let crosses_still = (0..last).any(|one| (one + 2..last).any(|other| crosses(line, &order, one, other)));
    (!crosses_still).then_some(order)
}

/// Whether the pieces of a line that start at these two of its points cross.
fn crosses(line: &[Point], order: &[usize], one: usize, other: usize) -> bool {
    let [from, to] = [one, other].map(|at| [line[order[at]], line[order[at + 1]]]);
    segment_crossing(from[0], from[1], to[0], to[1]).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(along: &[(f64, f64)]) -> Vec<Point> {
        along.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    #[test]
    fn a_line_goes_on_past_its_fold() {
        let kept = |along: &[(f64, f64)]| without_folds(&places(along));
        assert_eq!(kept(&[(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]), None);
        assert_eq!(kept(&[(0.0, 0.0), (10.0, 0.0), (5.0, 0.0), (20.0, 0.0)]), Some(vec![0, 1, 3]));
        let twice =
            [(0.0, 0.0), (10.0, 0.0), (6.0, 0.02), (4.0, 0.0), (8.0, 0.0), (12.0, 0.0), (11.0, 0.0), (20.0, 0.0)];
        assert_eq!(kept(&twice), Some(vec![0, 1, 6, 7]));
    }

    #[test]
    fn what_lies_elsewhere_is_no_fold() {
        let kept = |along: &[(f64, f64)]| without_folds(&places(along));
        // Back beside the line, back beyond its start, and an end that runs back.
        assert_eq!(kept(&[(0.0, 0.0), (10.0, 0.0), (5.0, 0.3), (20.0, 0.0)]), None);
        assert_eq!(kept(&[(0.0, 0.0), (10.0, 0.0), (-5.0, 0.0), (20.0, 0.0)]), None);
        assert_eq!(kept(&[(0.0, 0.0), (10.0, 0.0), (5.0, 0.0)]), None);
    }

    #[test]
    fn two_points_are_exchanged_where_that_undoes_every_crossing() {
        let order = |along: &[(f64, f64)]| exchanged(&places(along));
        assert_eq!(order(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)]), None);
        let crossed = [(0.0, 0.0), (9.0, 1.0), (8.0, -1.0), (9.0, 10.0)];
        assert_eq!(order(&crossed), Some(vec![0, 2, 1, 3]));
        let twice = [(0.0, 0.0), (9.0, 1.0), (8.0, -1.0), (9.0, 10.0), (12.0, 10.0), (12.0, 5.0), (5.0, 5.0)];
        assert_eq!(order(&twice), None);
    }
}
