//! Intersections that no area marks: lanes that cross or join others from other approaches.

use rustc_hash::{FxHashMap, FxHashSet};

use super::lane::{Edge, Lane, extent};
use super::types::{Conflict, DrivingSide, MapIndex};
use super::union_find::UnionFind;
use crate::geometry::{Point, Polyline, Vector, angle_between, segment_crossing};
use crate::lanelet::{LineStringId, PointId, TurnDirection};

/// Lanes whose directions differ by less than this (deg) run along each other: they join like a ramp, or lie on each other.
const ALONG: f64 = 20.0;
/// Lanes that end together join from different approaches beyond this angle (deg) of their first headings.
pub const JOINING: f64 = 30.0;
/// The middle of a lane this far (m) beside that of another lies at its side.
const ASIDE: f64 = 1.0;
/// Ends of lanes that have corners this close (m) lie beside each other, though their bounds are not shared.
const BESIDE: f64 = 0.5;
/// A lane longer than this (m) is a road that was not cut where others cross it, and no movement.
const LONGEST: f64 = 100.0;
/// Two roads between which nobody turns meet if both are cut at the crossing, into lanes no longer than this (m).
const LONGEST_CROSSING: f64 = 40.0;
/// A ring of lanes no longer than this (m) is a roundabout if it turns by at least `LEAST_TURN` on each twelfth of its length ...
const LONGEST_RING: f64 = 800.0;
/// ... (deg). A circle turns by 30; a block of houses does not turn at all between its corners.
const LEAST_TURN: f64 = 8.0;
/// A shorter ring (m) may have any shape, if others only join it and leave it.
const SHORT_RING: f64 = 200.0;

/// An intersection without an `intersection_area`.
#[derive(Clone, Debug)]
pub struct Unmarked {
    /// Its lanes, by their position in `MapIndex::lanes`, sorted.
    pub lanes: Vec<usize>,
    /// Longer ones that cross these on their level: roads that were not cut there.
    pub uncut: Vec<usize>,
    /// Middle of the lanes' box.
    pub middle: Point,
    /// Whether all of it is private ground: the aisles of a car park, or a driveway.
    pub private: bool,
    /// Whether cars cross there on the way to different roads; else they only join.
    pub crossed: bool,
}

impl MapIndex<'_> {
    /// The intersections that no area marks, whether or not their lanelets have a `turn_direction`. Told apart from them, and left
    /// out: lanes that only branch off, that join as on a ramp, that lie on each other or above each other, and roundabouts.
    pub fn unmarked_intersections(&self) -> Vec<Unmarked> {
        let mut groups = UnionFind::new(self.lanes.len());
        let mut taking_part: FxHashSet<usize> = FxHashSet::default();
        let mut cars_meet: FxHashSet<usize> = FxHashSet::default();
        let mut cars_cross: Vec<(usize, usize)> = Vec::new();
        let (sure, doubtful): (Vec<_>, Vec<_>) =
            self.meetings().into_iter().partition(|&(x, y)| self.ends_with(x, y) || self.is_on_one_level(x, y));
        let are_for_cars = |x: usize, y: usize| [x, y].iter().all(|&lane| self.lanes[lane].is_for_cars());
        for (x, y) in sure {
            groups.join(x, y);
            taking_part.extend([x, y]);
            if are_for_cars(x, y) {
                cars_meet.insert(x);
                cars_cross.extend((!self.ends_with(x, y)).then_some((x, y)));
            }
        }
        // Two lanes that meet others here are not on different levels.
        for (x, y) in doubtful.into_iter().filter(|(x, y)| taking_part.contains(x) && taking_part.contains(y)) {
            groups.join(x, y);
            cars_cross.extend(are_for_cars(x, y).then_some((x, y)));
        }
        self.add_company(&mut groups, &mut taking_part);
        let mut members: Vec<usize> = taking_part.into_iter().collect();
        members.sort_unstable();
        let mut by_root: FxHashMap<usize, usize> = FxHashMap::default();
        let mut clusters: Vec<Vec<usize>> = Vec::new();
        for at in members {
            let place = *by_root.entry(groups.root(at)).or_insert_with(|| {
                clusters.push(Vec::new());
                clusters.len() - 1
            });
            clusters[place].push(at);
        }
        // A driveway across a bicycle lane is no intersection of roads.
        clusters.retain(|lanes| lanes.iter().any(|lane| cars_meet.contains(lane)));
        let clusters = clusters.into_iter().filter(|lanes| !lanes.iter().any(|&lane| self.is_on_roundabout(lane)));
        let mut crossings: FxHashMap<usize, Vec<(usize, usize)>> = FxHashMap::default();
        for (x, y) in cars_cross {
            crossings.entry(groups.root(x)).or_default().push((x, y));
        }
        let mut crossed = |lanes: &[usize]| {
            let own = lanes.first().and_then(|&lane| crossings.get(&groups.root(lane)));
            own.is_some_and(|pairs| self.lead_apart(lanes, pairs))
        };
        clusters.map(|lanes| self.unmarked(crossed(&lanes), lanes)).collect()
    }

    /// The pairs of lanes, at least one of them for cars, that overlap and come from different approaches.
    fn meetings(&self) -> Vec<(usize, usize)> {
        let of_lane = |x: usize| {
            let later = self.conflicts[x].iter().filter(move |conflict| conflict.other > x && conflict.real);
            let meeting = later.filter(move |conflict| {
                let y = conflict.other;
                (self.lanes[x].is_for_cars() || self.lanes[y].is_for_cars())
                    && self.is_free(y)
                    && self.meet(x, conflict)
            });
            meeting.map(move |conflict| (x, conflict.other))
        };
        (0..self.lanes.len()).filter(|&x| self.is_free(x)).flat_map(of_lane).collect()
    }

    /// Whether two lanes of one of these pairs lead to different roads: their ends are not linked, one beside the other. Who joins the
    /// second lane of a road runs over its first, and crosses nobody's way.
    fn lead_apart(&self, lanes: &[usize], pairs: &[(usize, usize)]) -> bool {
        let mut roads = UnionFind::new(lanes.len());
        let mut at_point: FxHashMap<PointId, usize> = FxHashMap::default();
        for (place, &lane) in lanes.iter().enumerate() {
            for id in self.lanes[lane].end.ids {
                let first = *at_point.entry(id).or_insert(place);
                roads.join(first, place);
            }
        }
        let mut road = |lane: usize| lanes.binary_search(&lane).ok().map(|place| roads.root(place));
        pairs.iter().any(|&(x, y)| road(x) != road(y))
    }

    /// Whether a lane crosses or joins others from other approaches, but for lanes that are a roundabout.
    pub fn meets_others(&self, lane: usize) -> bool {
        let met = self.conflicts[lane].iter().filter(|conflict| conflict.real && self.meet(lane, conflict));
        let mut met = met.map(|conflict| conflict.other).peekable();
        met.peek().is_some() && !self.is_on_roundabout(lane) && met.any(|other| !self.is_on_roundabout(other))
    }

    /// Whether two lanes end together.
    fn ends_with(&self, x: usize, y: usize) -> bool {
        self.lanes[x].end.ids == self.lanes[y].end.ids
    }

    fn unmarked(&self, crossed: bool, lanes: Vec<usize>) -> Unmarked {
        let corners: Vec<Point> = lanes.iter().flat_map(|&lane| self.lanes[lane].extent).collect();
        let [low, high] = extent(&corners);
        let is_private = |&lane: &usize| self.lanes[lane].lanelet.attributes.is("location", "private");
        Unmarked {
            uncut: self.uncut(&lanes),
            middle: nalgebra::center(&low, &high),
            private: lanes.iter().all(is_private),
            crossed,
            lanes,
        }
    }

    /// Whether a lane can belong to an intersection that has no area: it is short enough for a movement.
    fn is_free(&self, lane: usize) -> bool {
        self.lanes[lane].length() <= LONGEST && self.may_be_cut(lane)
    }

    /// Whether a lane, whatever its length, is one for vehicles outside of any area.
    fn may_be_cut(&self, lane: usize) -> bool {
        let at = &self.lanes[lane];
        at.simple && at.is_drivable() && !self.has_area(lane)
    }

    /// The lanes too long for a movement that cross one of these on its level.
    fn uncut(&self, lanes: &[usize]) -> Vec<usize> {
        let of_lane = |&x: &usize| {
            let long = self.conflicts[x].iter().filter(|conflict| conflict.real && !self.is_free(conflict.other));
            let crossing = long.filter(move |conflict| self.may_be_cut(conflict.other) && self.meet(x, conflict));
            crossing.map(|conflict| conflict.other).filter(move |&y| self.is_on_one_level(x, y))
        };
        let mut uncut: Vec<usize> = lanes.iter().flat_map(of_lane).collect();
        uncut.sort_unstable();
        uncut.dedup();
        uncut
    }

    /// Whether two lanes that overlap come from different approaches: they cross, or join at an angle.
    fn meet(&self, x: usize, conflict: &Conflict) -> bool {
        let [a, b] = [x, conflict.other].map(|lane| &self.lanes[lane]);
        let apart = |one: Option<Vector>, other: Option<Vector>| {
            one.zip(other).map_or(0.0, |(one, other)| angle_between(one, other).abs().to_degrees())
        };
        let first = apart(a.heading_in(), b.heading_in());
        if a.end.ids == b.end.ids {
            return first > JOINING;
        }
        let there = |line: Option<&Polyline>| line.map(|line| line.direction(line.project(conflict.place).station));
        let crossing = apart(there(a.center.as_ref()), there(b.center.as_ref()));
        let is_across = |angle: f64, limit: f64| (limit..180.0 - limit).contains(&angle);
        is_across(crossing, ALONG) || is_across(first, JOINING) || (crossing > 90.0 && change_sides(a, b))
    }

    /// Whether two lanes that cross do so on one level. Where all is drawn at one height, it shows in the lanes that lead from one road
    /// to the other; two roads between which nobody turns must be cut right at the crossing.
    fn is_on_one_level(&self, x: usize, y: usize) -> bool {
        let [a, b] = [x, y].map(|lane| &self.lanes[lane]);
        let [low, high] = a.heights;
        let is_flat = low == high && a.heights == b.heights;
        let is_alone = |lane: usize| {
            let at = &self.lanes[lane];
            let beside = at.bounds.into_iter().flat_map(|way| self.users_of(way)).copied();
            let mut road = std::iter::once(lane).chain(beside);
            at.length() <= LONGEST_CROSSING
                && road
                    .all(|one| self.siblings(one).next().is_none() && self.ending[&self.lanes[one].end.ids].len() < 2)
        };
        !is_flat || self.leads_over(x, y) || self.leads_over(y, x) || (is_alone(x) && is_alone(y))
    }

    /// Whether a lane from where one starts, or from beside it, leads onto the road of the other: it ends where that one ends, or beside
    /// it, or beside where it starts.
    fn leads_over(&self, from: usize, to: usize) -> bool {
        let beside = self.lanes[from].bounds.into_iter().flat_map(|way| self.users_of(way)).copied();
        let mut starts = std::iter::once(from).chain(beside);
        let Lane { start, end, .. } = self.lanes[to];
        let is_beside = |edge: &Edge, other: &Edge| {
            let near = |p: &Point| other.points.iter().any(|q| (p - q).norm() <= BESIDE);
            edge.touches(other) || edge.points.iter().any(near)
        };
        starts.any(|lane| {
            let mut turns = self.siblings(lane).filter(|&turn| turn != from && turn != to);
            // Where the other goes on behind the turn itself, the road only forks.
            let leads_onto = |onto: &Edge| is_beside(onto, &end) || (onto.ids != start.ids && is_beside(onto, &start));
            turns.any(|turn| leads_onto(&self.lanes[turn].end))
        })
    }

    /// Adds the lanes that start or end with those that take part, and those abreast of them: they drive over the same
    /// intersection, though nobody crosses them.
    fn add_company(&self, groups: &mut UnionFind, taking_part: &mut FxHashSet<usize>) {
        let mut ways: FxHashSet<LineStringId> = FxHashSet::default();
        let mut open: Vec<usize> = taking_part.iter().copied().collect();
        open.sort_unstable();
        while let Some(lane) = open.pop() {
            let most = 3.0 * self.lanes[lane].length().max(15.0);
            let siblings = self.siblings(lane).filter(|&other| self.lanes[other].length() < most);
            let joining = self.ending.get(&self.lanes[lane].end.ids).into_iter().flatten().copied();
            let joining: Vec<usize> = joining.filter(|other| taking_part.contains(other)).collect();
            let abreast = self.lanes[lane].bounds.into_iter().filter(|way| ways.insert(*way));
            let abreast: Vec<usize> = abreast.flat_map(|way| self.users_of(way)).copied().collect();
            for other in siblings.chain(joining).chain(abreast) {
                if other != lane && self.is_free(other) {
                    groups.join(lane, other);
                    if taking_part.insert(other) {
                        open.push(other);
                    }
                }
            }
        }
    }

    /// Whether the shortest way from a lane back to itself is a roundabout.
    fn is_on_roundabout(&self, lane: usize) -> bool {
        let mut before: FxHashMap<usize, usize> = FxHashMap::default();
        let mut open = std::collections::BTreeSet::from([(0, lane)]);
        while let Some((metres, at)) = open.pop_first() {
            for &next in self.followers(at) {
                if next == lane {
                    return self.goes_around(&ring(lane, at, &before));
                }
                let reached = metres + self.lanes[next].length().ceil() as u64;
                if reached as f64 <= LONGEST_RING && !before.contains_key(&next) {
                    before.insert(next, at);
                    open.insert((reached, next));
                }
            }
        }
        false
    }

    /// Whether a ring of lanes runs around an island as roundabouts do.
    fn goes_around(&self, ring: &[usize]) -> bool {
        let turn: f64 = ring.iter().map(|&lane| self.lanes[lane].turn()).sum();
        let length: f64 = ring.iter().map(|&lane| self.lanes[lane].length()).sum();
        let far = match self.side.side.map(DrivingSide::far_turn) {
            Some(TurnDirection::Right) => turn < 0.0,
            Some(_) => turn > 0.0,
            None => true,
        };
        let is_two_way = ring.iter().any(|&lane| self.has_oncoming_inside(lane, turn > 0.0));
        far && !is_two_way
            && (self.is_round(ring) || length <= SHORT_RING && !ring.iter().any(|&lane| self.is_crossed(lane)))
    }

    /// Whether cars come the other way beside a lane, on its left or on its right: around a small block, and never inside a roundabout.
    fn has_oncoming_inside(&self, lane: usize, is_left: bool) -> bool {
        let side = usize::from(!is_left);
        let inner = self.lanes[lane].bounds[side];
        self.users_of(inner).iter().any(|&other| other != lane && self.lanes[other].bounds[side] == inner)
    }

    /// Whether others do more than join a lane at its end.
    fn is_crossed(&self, lane: usize) -> bool {
        let mut conflicts = self.conflicts[lane].iter().filter(|conflict| conflict.real);
        let level = |other: usize| self.is_on_one_level(lane, other);
        conflicts.any(|one| !self.ends_with(lane, one.other) && self.meet(lane, one) && level(one.other))
    }

    /// Whether a ring of lanes bends everywhere.
    fn is_round(&self, ring: &[usize]) -> bool {
        let centers = ring.iter().filter_map(|&lane| self.lanes[lane].center.as_ref());
        let mut places: Vec<Point> = centers.flat_map(|center| center.points().iter().copied()).collect();
        places.extend(places.first().copied());
        let Some(line) = Polyline::new(places) else { return false };
        let line = line.resampled_to(24);
        let chords: Vec<Vector> = line.segments().map(|(from, to)| to - from).collect();
        let turns = (0..chords.len()).map(|at| angle_between(chords[at], chords[(at + 2) % chords.len()]).to_degrees());
        let (least, most) =
            turns.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), turn| (low.min(turn), high.max(turn)));
        least >= LEAST_TURN || most <= -LEAST_TURN
    }
}

/// Whether the middle of a lane crosses that of another from one side to the other, as where a road forks and who turns off crosses
/// those that come from the other branch.
fn change_sides(a: &Lane, b: &Lane) -> bool {
    let Some((center, other)) = a.center.as_ref().zip(b.center.as_ref()) else { return false };
    let [start, end] = [b.start, b.end].map(|edge| center.project(edge.middle()).offset);
    let aside = start * end < 0.0 && start.abs() >= ASIDE && end.abs() >= ASIDE;
    aside && center.segments().any(|(p, q)| other.segments().any(|(r, s)| segment_crossing(p, q, r, s).is_some()))
}

/// The lanes from one to another, each the follower of the one `before` it.
fn ring(first: usize, last: usize, before: &FxHashMap<usize, usize>) -> Vec<usize> {
    let mut ring: Vec<usize> = vec![last];
    while let Some(&previous) = ring.last().and_then(|at| before.get(at)) {
        ring.push(previous);
    }
    if last != first && ring.last() != Some(&first) {
        ring.push(first);
    }
    ring.reverse();
    ring
}
