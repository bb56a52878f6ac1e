//! Infers the bound of a lanelet that has none, or several, from the lanelets and ways around it, where only one way fits.

use std::collections::BTreeSet;

use rustc_hash::FxHashSet;

use super::Loader;
use crate::diagnostic::Subject;
use crate::geometry::Point as PlanePoint;
use crate::lanelet::align::{align, opposed};
use crate::lanelet::{BoundRole, Condition, LineString, LineStringId, PointId};

/// The largest distance between two bounds where no neighbour shows which belong together, metres: two wide lanes, or a broad
/// crosswalk.
const BOUND_WITHIN: f64 = 12.0;

impl Loader<'_> {
    /// Notes the way for each such lanelet.
    pub(super) fn infer_missing_bounds(&mut self) {
        let lacks = |condition: &Condition| match condition {
            Condition::BoundCount { role, ways, .. } if *role != BoundRole::Centerline => Some((*role, ways.clone())),
            _ => None,
        };
        let open: Vec<(usize, i64, (BoundRole, Vec<i64>))> = (self.loaded.faults.iter().enumerate())
            .filter_map(|(at, fault)| match fault.subject {
                Subject::Lanelet(id) => Some((at, id, lacks(&fault.condition)?)),
                _ => None,
            })
            .collect();
        if open.is_empty() {
            return;
        }
        let around = Surroundings::of(self);
        let found: Vec<(usize, Option<i64>)> =
            open.into_iter().map(|(at, id, (role, ways))| (at, around.other_bound(self, id, role, &ways))).collect();
        for (at, way) in found {
            if let Some(Condition::BoundCount { meant, .. }) = self.loaded.faults.get_mut(at).map(|f| &mut f.condition)
            {
                *meant = way;
            }
        }
    }

    /// The way of a role, where it is the only one.
    fn named(&self, lanelet: i64, role: BoundRole) -> Option<&LineString> {
        let relation = self.osm.relation(lanelet)?;
        let mut ways = relation.members.iter().filter(|member| member.role == role.as_str());
        let way = ways.next().filter(|_| ways.next().is_none())?;
        self.loaded.map.linestrings.get(LineStringId(way.id))
    }
}

/// What surrounds a lanelet that lacks a bound.
struct Surroundings {
    /// Start and end edges of all lanelets, left and right.
    edges: Vec<[PointId; 2]>,
    /// The two bounds of each lanelet.
    pairs: FxHashSet<[LineStringId; 2]>,
    /// Ways that bound something, or that an element refers to.
    used: FxHashSet<LineStringId>,
}

impl Surroundings {
    fn of(loader: &Loader<'_>) -> Self {
        let map = &loader.loaded.map;
        let mut around = Self { edges: Vec::new(), pairs: FxHashSet::default(), used: FxHashSet::default() };
        for lanelet in &map.lanelets {
            around.pairs.insert([lanelet.left.line, lanelet.right.line]);
            let ends = [lanelet.left, lanelet.right].map(|bound| {
                let mut points = map.bound_points(bound).map(|point| point.id);
                let first = points.next();
                (first, points.next_back().or(first))
            });
            if let [(Some(a), Some(b)), (Some(c), Some(d))] = ends {
                around.edges.extend([[a, c], [b, d]]);
            }
        }
        let members = loader.osm.relations.iter().flat_map(|relation| &relation.members);
        around.used.extend(members.map(|member| LineStringId(member.id)));
        around
    }

    /// The missing bound: the way that leads from edge to edge of the neighbours. Where the known bound has none at one of its ends
    /// or at both, else the only unused way that meets the other edge, or that has the same type beside the known bound.
    /// Where several ways have the role, one of these, if it alone leads from edge to edge.
    fn other_bound(&self, loader: &Loader<'_>, lanelet: i64, role: BoundRole, ways: &[i64]) -> Option<i64> {
        let (side, other) = match role {
            BoundRole::Left => (0, BoundRole::Right),
            _ => (1, BoundRole::Left),
        };
        let known = loader.named(lanelet, other)?;
        let ends = [*known.points.first()?, *known.points.last()?];
        // The points where the other bound can start and end, by the edges that meet the known one.
        let opposite = ends.map(|end| -> BTreeSet<PointId> {
            self.edges.iter().filter(|edge| edge[1 - side] == end).map(|edge| edge[side]).collect()
        });
        let meets = |line: &LineString| {
            let (Some(first), Some(last)) = (line.points.first(), line.points.last()) else { return [0, 0] };
            let count = |a, b| usize::from(opposite[0].contains(a)) + usize::from(opposite[1].contains(b));
            [count(first, last), count(last, first)]
        };
        // Where lanelets meet the known bound at both ends, the other one has to meet them at both: one that does not would end in
        // the middle of a lane.
        let has_neighbours_at_both = opposite.iter().all(|points| !points.is_empty());
        let named = |line: &LineString| ways.is_empty() || ways.contains(&line.id.0);
        let fits = |line: &&LineString| line.id != known.id && named(line) && self.fits(loader, known, line, side);
        let lines: Vec<&LineString> = loader.loaded.map.linestrings.iter().filter(fits).collect();
        let both = lines.iter().filter(|line| meets(line).contains(&2));
        if let Some(way) = only(both.map(|line| line.id.0)) {
            return Some(way);
        }
        if !ways.is_empty() || has_neighbours_at_both {
            return None;
        }
        let free = || lines.iter().filter(|line| !self.used.contains(&line.id));
        only(free().filter(|line| meets(line).contains(&1)).map(|line| line.id.0)).or_else(|| {
            let alike = free().filter(|line| line.attributes.get("type") == known.attributes.get("type"));
            only(alike.map(|line| line.id.0))
        })
    }

    /// Whether a line lies beside a bound, on the right side of it, and makes no lanelet that there is already.
    fn fits(&self, loader: &Loader<'_>, known: &LineString, line: &LineString, side: usize) -> bool {
        let order = |a, b| if side == 0 { [b, a] } else { [a, b] };
        if line.points.len() < 2 || self.pairs.contains(&order(known.id, line.id)) {
            return false;
        }
        let [mut left, mut right] = order(known.id, line.id).map(|id| loader.line(id));
        let near = |a: &PlanePoint, b: &PlanePoint| (a - b).norm() <= BOUND_WITHIN;
        let ([Some(a), Some(b)], [Some(c), Some(d)]) = ([left.first(), left.last()], [right.first(), right.last()])
        else {
            return false;
        };
        if !(near(a, c) && near(b, d) || near(a, d) && near(b, c)) {
            return false;
        }
        let (turn_left, turn_right) = align(&left, &right);
        if turn_left {
            left.reverse();
        }
        if turn_right {
            right.reverse();
        }
        !opposed(&left, &right)
    }
}

/// The only one; `None` where there are none or several.
fn only(mut ways: impl Iterator<Item = i64>) -> Option<i64> {
    let first = ways.next()?;
    ways.next().is_none().then_some(first)
}
