//! Intersections that no area marks: lanes that cross or join others from other approaches.

use rustc_hash::{FxHashMap, FxHashSet};

use super::STRAIGHT_ON;
use super::lane::{Edge, Lane, extent};
use super::types::{Conflict, MapIndex, Unmarked};
use super::union_find::UnionFind;
use super::view::boxes_meet;
use crate::geometry::{Point, Polyline, Vector, angle_between, segment_crossing};
use crate::lanelet::{LineStringId, PointId};

/// Lanes whose directions differ by less than this (deg) run along each other: they join like a ramp, or lie on each other.
const ALONG: f64 = 20.0;
/// Lanes that end together join from different approaches beyond this angle (deg) of their first headings.
pub const JOINING: f64 = 30.0;
/// The middle of a lane this far (m) beside that of another lies at its side.
const ASIDE: f64 = 1.0;
/// Ends of lanes that have corners this close (m) lie beside each other, though their bounds are not shared.
const BESIDE: f64 = 0.5;
/// A lane that starts with both corners this close (m) to the end of another continues it, though on nodes of its own.
const CONTINUING: f64 = 1.0;
/// A lane longer than this (m) is a road that was not cut where others cross it, and no movement.
const LONGEST: f64 = 100.0;
/// A lane that starts at the stop line of its light may be this long (m): as wide are the largest intersections.
const LONGEST_RULED: f64 = 150.0;
/// A branch that is cut into pieces has at most so many behind the common lane, each at most so long (m).
const BRANCH_PIECES: usize = 3;
const LONGEST_BRANCH_PIECE: f64 = 20.0;
/// Its lanes lie on each other up to this far (m) behind the common lane.
const BRANCH_REACH: f64 = 30.0;
/// A carriageway has no more lanes than these.
const WIDEST: usize = 16;
/// Two roads between which nobody turns meet if both are cut at the crossing, into lanes no longer than this (m).
const LONGEST_CROSSING: f64 = 40.0;

/// Two lanes that overlap and come from different approaches.
struct Meeting {
    lanes: [usize; 2],
    /// Whether both are for cars.
    cars: bool,
    /// Whether they join, or lead against each other; else they cross. At a roundabout its rules say who goes first.
    joins: bool,
}

impl MapIndex<'_> {
    /// The intersections that no area marks, whether or not their lanelets have a `turn_direction`. Told apart from them, and left
    /// out: lanes that only branch off, that join as on a ramp, that lie on each other or above each other, and roundabouts, but for
    /// places where who joins crosses the way of who leaves.
    pub fn unmarked_intersections(&self) -> &[Unmarked] {
        &self.unmarked_by_lane().0
    }

    /// Whether a lane turns to one side at an intersection that no area marks, and so is no stretch of road.
    pub fn turns_at_unmarked(&self, lane: usize) -> bool {
        self.lanes[lane].turn().abs() > STRAIGHT_ON && self.is_at_unmarked(lane)
    }

    /// The intersection that no area marks to which both of two lanes belong.
    pub fn shared_unmarked(&self, x: usize, y: usize) -> Option<&Unmarked> {
        let at = self.unmarked_of(x).filter(|at| self.unmarked_of(y) == Some(*at))?;
        self.unmarked_intersections().get(at)
    }

    /// Whether a lane belongs to an intersection that no area marks.
    pub fn is_at_unmarked(&self, lane: usize) -> bool {
        self.unmarked_of(lane).is_some()
    }

    /// Position of a lane's intersection among those that no area marks.
    fn unmarked_of(&self, lane: usize) -> Option<usize> {
        self.unmarked_by_lane().1.get(&lane).copied()
    }

    /// These intersections, and for each of their lanes the position of its own.
    fn unmarked_by_lane(&self) -> &(Vec<Unmarked>, FxHashMap<usize, usize>) {
        self.unmarked.get_or_init(|| {
            let all = self.find_unmarked();
            let lanes = all.iter().enumerate().flat_map(|(at, one)| one.lanes.iter().map(move |&lane| (lane, at)));
            let by_lane = lanes.collect();
            (all, by_lane)
        })
    }

    // Rules that run at the same time wait for this one. It does no work of several threads: one that waits for the others would take up
    // another rule, and that one would wait for this for ever.
    fn find_unmarked(&self) -> Vec<Unmarked> {
        let mut groups = UnionFind::new(self.lanes.len());
        let mut taking_part: FxHashSet<usize> = FxHashSet::default();
        let mut cars_meet: FxHashSet<usize> = FxHashSet::default();
        let mut cars_cross: Vec<(usize, usize)> = Vec::new();
        let is_sure = |one: &Meeting| one.joins || self.is_on_one_level(one.lanes[0], one.lanes[1]);
        let (sure, doubtful): (Vec<_>, Vec<_>) = self.meetings().into_iter().partition(is_sure);
        for meeting in sure {
            let [x, y] = meeting.lanes;
            groups.join(x, y);
            taking_part.extend([x, y]);
            if meeting.cars {
                cars_meet.insert(x);
                cars_cross.extend((!meeting.joins).then_some((x, y)));
            }
        }
        // Two lanes that meet others here are not on different levels.
        for meeting in doubtful.into_iter().filter(|one| one.lanes.iter().all(|lane| taking_part.contains(lane))) {
            let [x, y] = meeting.lanes;
            groups.join(x, y);
            cars_cross.extend(meeting.cars.then_some((x, y)));
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
        let mut crossings: FxHashMap<usize, Vec<(usize, usize)>> = FxHashMap::default();
        for (x, y) in cars_cross {
            crossings.entry(groups.root(x)).or_default().push((x, y));
        }
        let mut crossed = |lanes: &[usize]| {
            let own = lanes.first().and_then(|&lane| crossings.get(&groups.root(lane)));
            own.is_some_and(|pairs| self.lead_apart(lanes, pairs))
        };
        clusters.into_iter().map(|lanes| self.unmarked(crossed(&lanes), lanes)).collect()
    }

    /// Where lanes overlap, at least one of them for cars, that come from different approaches, and not as on a roundabout.
    fn meetings(&self) -> Vec<Meeting> {
        let of_lane = |x: usize| {
            let later = self.conflicts[x].iter().filter(move |conflict| conflict.other > x && conflict.real);
            later.filter_map(move |conflict| {
                let y = conflict.other;
                let cars = [x, y].map(|lane| self.lanes[lane].is_for_cars());
                let meet = cars.contains(&true) && self.is_free(y) && self.meet(x, conflict);
                meet.then(|| Meeting {
                    lanes: [x, y],
                    cars: cars == [true; 2],
                    joins: self.ends_with(x, y) || !self.cross(x, conflict, || self.are_at_roundabout(x, y)),
                })
            })
        };
        let all: Vec<Meeting> = (0..self.lanes.len()).filter(|&x| self.is_free(x)).flat_map(of_lane).collect();
        let outside = |mut one: Meeting| {
            let [x, y] = one.lanes;
            one.joins |= [x, y].into_iter().all(|lane| self.is_at_roundabout(lane));
            (!self.is_ruled_by_roundabout(x, y)).then_some(one)
        };
        all.into_iter().filter_map(outside).collect()
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

    /// Whether a lane crosses or joins others from other approaches, and not as on a roundabout.
    pub fn meets_others(&self, lane: usize) -> bool {
        let met = self.conflicts[lane].iter().filter(|conflict| conflict.real && self.meet(lane, conflict));
        met.map(|conflict| conflict.other).any(|other| !self.is_ruled_by_roundabout(lane, other))
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
        let length = self.lanes[lane].length();
        let has_light = || self.elements(self.lanes[lane].id, "traffic_light").next().is_some();
        let is_ruled = || length <= LONGEST_RULED && has_light() && self.starts_at_stop_line(lane);
        (length <= LONGEST || is_ruled()) && self.may_be_cut(lane)
    }

    /// Whether a lane of buses can belong to it: whether others cross it is not known.
    fn is_free_for_buses(&self, lane: usize) -> bool {
        let at = &self.lanes[lane];
        at.is_for_buses() && at.simple && at.length() <= LONGEST && !self.has_area(lane)
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

    /// Whether two lanes that overlap come from different approaches: they cross, join, or lead against each other.
    fn meet(&self, x: usize, conflict: &Conflict) -> bool {
        self.meet_if(x, conflict, || self.are_at_roundabout(x, conflict.other))
    }

    /// The same where it is known, or must not be asked, whether they are part of a roundabout.
    fn meet_if(&self, x: usize, conflict: &Conflict, at_roundabout: impl Fn() -> bool) -> bool {
        let [one, other] = [x, conflict.other].map(|lane| &self.lanes[lane]);
        let is_one_road = nearly_continue(one, other) || nearly_continue(other, one);
        // Who says that it turns means an intersection.
        let is_labelled = || [one, other].into_iter().any(|lane| lane.lanelet.attributes.has("turn_direction"));
        let only_part = || !is_labelled() && self.branched_before(x, conflict) && !change_sides(one, other);
        !is_one_road && !only_part() && (self.cross(x, conflict, at_roundabout) || lead_head_on(one, other))
    }

    /// Whether two lanes come from one, each over short pieces at most, and overlap right behind it: their branch begins before them.
    pub fn branched_before(&self, x: usize, conflict: &Conflict) -> bool {
        let before = |lane: usize| {
            let only = move |&at: &usize| match self.predecessors(at) {
                &[one] => Some(one),
                _ => None,
            };
            let short = move |&at: &usize| self.lanes[at].length() <= LONGEST_BRANCH_PIECE;
            let first = only(&lane);
            std::iter::successors(first, move |at| short(at).then(|| only(at)).flatten()).take(BRANCH_PIECES)
        };
        let is_near = |from: usize| (self.lanes[from].end.middle() - conflict.place).norm() <= BRANCH_REACH;
        before(x).any(|one| is_near(one) && before(conflict.other).any(|other| other == one))
    }

    fn are_at_roundabout(&self, x: usize, y: usize) -> bool {
        self.is_at_roundabout(x) && self.is_at_roundabout(y)
    }

    /// Whether two lanes lead to the same lane, or to lanes side by side of one carriageway.
    fn lead_to_one_road(&self, x: usize, y: usize) -> bool {
        let [end, other] = [x, y].map(|lane| &self.lanes[lane].end);
        let followers = self.followers(y);
        end.ids == other.ids
            || end.touches(other)
            || self.carriageway(self.followers(x)).iter().any(|lane| followers.contains(lane))
    }

    /// Whether two lanes that overlap cross, or join at an angle.
    fn cross(&self, x: usize, conflict: &Conflict, at_roundabout: impl Fn() -> bool) -> bool {
        let [a, b] = [x, conflict.other].map(|lane| &self.lanes[lane]);
        let apart = |one: Option<Vector>, other: Option<Vector>| {
            one.zip(other).map_or(0.0, |(one, other)| angle_between(one, other).abs().to_degrees())
        };
        let first = apart(a.heading_in(), b.heading_in());
        if self.lead_to_one_road(x, conflict.other) {
            return first > JOINING || self.is_ruled(x) || self.is_ruled(conflict.other);
        }
        let there = |line: Option<&Polyline>| line.map(|line| line.direction(line.project(conflict.place).station));
        let crossing = apart(there(a.center.as_ref()), there(b.center.as_ref()));
        let is_across = |angle: f64, limit: f64| (limit..180.0 - limit).contains(&angle);
        // Who turns off over the lane beside his own crosses it; lanes that go on along each other only change places.
        let last = apart(a.heading_out(), b.heading_out());
        let is_parting = || (crossing > 90.0 || last > JOINING) && change_sides(a, b);
        // Where a road bends, its two directions start at any angle, and its lines may lie over each other by a hand. Who leaves a
        // roundabout crosses who joins it from the same street.
        let is_oncoming = crossing > 180.0 - ALONG && !at_roundabout();
        is_across(crossing, ALONG) || (is_across(first, JOINING) && !is_oncoming) || is_parting()
    }

    /// Whether a light, or a stop or give-way sign before it, says when who drives here may go.
    fn is_ruled(&self, lane: usize) -> bool {
        let ids = || self.predecessors(lane).iter().chain([&lane]).map(|&lane| self.lanes[lane].id);
        self.elements(self.lanes[lane].id, "traffic_light").next().is_some()
            || ids().any(|id| self.elements(id, "traffic_sign").any(|sign| self.ranks(sign)))
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

    /// Whether a lane from where one starts, or from beside it on its road, leads onto the road of the other: it ends where that one
    /// ends, or beside it, or beside where it starts.
    fn leads_over(&self, from: usize, to: usize) -> bool {
        let beside = self.lanes[from].bounds.into_iter().flat_map(|way| self.users_of(way)).copied();
        let starts = std::iter::once(from).chain(beside);
        let mut turns = starts.flat_map(|lane| self.siblings(lane)).chain(self.followers_of_carriageway(from));
        let Lane { start, end, .. } = self.lanes[to];
        // Where the other goes on behind the turn itself, the road only forks.
        let leads_onto = |onto: &Edge| lie_beside(onto, &end) || (onto.ids != start.ids && lie_beside(onto, &start));
        turns.any(|turn| turn != from && turn != to && leads_onto(&self.lanes[turn].end))
    }

    /// The lanes that start on the carriageway of a lane: behind the lanes before it, and behind those side by side with them.
    fn followers_of_carriageway(&self, lane: usize) -> impl Iterator<Item = usize> + '_ {
        // Those that end together have the same followers.
        let mut ends: FxHashSet<[PointId; 2]> = FxHashSet::default();
        let mut before = self.carriageway(self.predecessors(lane));
        before.retain(|&one| ends.insert(self.lanes[one].end.ids));
        before.into_iter().flat_map(|one| self.followers(one)).copied()
    }

    /// Some lanes of a carriageway, and those side by side with them.
    pub(super) fn carriageway(&self, some: &[usize]) -> Vec<usize> {
        let mut all = some.to_vec();
        let mut at = 0;
        while let Some(&one) = all.get(at).filter(|_| all.len() < WIDEST) {
            at += 1;
            let [left, right] = self.lanes[one].bounds;
            for (way, side) in [(left, 1), (right, 0)] {
                let abreast = self.users_of(way).iter().filter(|&&other| self.lanes[other].bounds[side] == way);
                let new: Vec<usize> = abreast.filter(|other| !all.contains(other)).copied().collect();
                all.extend(new);
            }
        }
        all
    }

    /// Adds the lanes that start or end with those that take part, those abreast of them, and lanes of buses from the same carriageways:
    /// they drive over the same intersection, though nobody crosses them.
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
            let company = siblings.chain(joining).chain(abreast).filter(|&other| self.is_free(other));
            let beside = self.lanes[lane].bounds.into_iter().flat_map(|way| self.users_of(way)).copied();
            let buses =
                beside.chain(self.followers_of_carriageway(lane)).filter(|&other| self.is_free_for_buses(other));
            for other in company.chain(buses) {
                if other != lane {
                    groups.join(lane, other);
                    if taking_part.insert(other) {
                        open.push(other);
                    }
                }
            }
        }
    }

    /// Whether others do more than join a lane at its end, or join or leave the lane beside it over this one. What is a roundabout is told
    /// by this, and so cannot be asked here.
    pub(super) fn is_crossed(&self, lane: usize) -> bool {
        let mut conflicts = self.conflicts[lane].iter().filter(|conflict| conflict.real);
        let level = |other: usize| self.is_on_one_level(lane, other);
        let Lane { start, end, .. } = self.lanes[lane];
        let is_beside = |other: &Lane| end.touches(&other.end) || start.touches(&other.start);
        conflicts.any(|one| !is_beside(&self.lanes[one.other]) && self.meet_if(lane, one, || false) && level(one.other))
    }
}

/// Whether two ends of lanes have a corner in common, or nearly so.
fn lie_beside(edge: &Edge, other: &Edge) -> bool {
    let near = |p: &Point| other.points.iter().any(|q| (p - q).norm() <= BESIDE);
    edge.touches(other) || edge.points.iter().any(near)
}

/// Whether a lane starts where another ends and goes on in its direction, be it on other nodes: pieces of one road that nobody joined.
fn nearly_continue(lane: &Lane, next: &Lane) -> bool {
    let ends = lane.end.points.iter().zip(&next.start.points);
    let turn = lane.heading_out().zip(next.heading_in()).map(|(out, into)| angle_between(out, into));
    ends.map(|(a, b)| (a - b).norm()).all(|apart| apart <= CONTINUING)
        && turn.is_some_and(|turn| turn.abs().to_degrees() < ALONG)
}

/// Whether one of two lanes starts where the other ends, against it, and their other ends lie apart: a road for both directions becomes
/// a single lane for both there, or several such lanes meet.
fn lead_head_on(a: &Lane, b: &Lane) -> bool {
    let is_against = |one: &Edge, other: &Edge| one.ids == [other.ids[1], other.ids[0]];
    is_against(&a.end, &b.start) != is_against(&a.start, &b.end)
}

/// Whether the middle of a lane crosses that of another from one side to the other, as where a road forks and who turns off crosses
/// those that come from the other branch.
fn change_sides(a: &Lane, b: &Lane) -> bool {
    let Some((center, other)) = a.center.as_ref().zip(b.center.as_ref()) else { return false };
    let [start, end] = [b.start, b.end].map(|edge| center.project(edge.middle()).offset);
    let aside = start * end < 0.0 && start.abs() >= ASIDE && end.abs() >= ASIDE;
    aside && lines_cross(center, other)
}

/// Whether a segment of one line crosses one of the other. Of lines that cross, most segments lie far from the other line.
fn lines_cross(one: &Polyline, other: &Polyline) -> bool {
    /// By which boxes are larger than what they hold, metres: no rounding hides a crossing at their edges.
    const HAIR: f64 = 1e-6;
    let around = |points: &[Point]| {
        let [low, high] = extent(points);
        [low - Vector::repeat(HAIR), high + Vector::repeat(HAIR)]
    };
    let [of_one, of_other] = [one, other].map(|line| around(line.points()));
    let near = other.segments().map(|(r, s)| ([r, s], around(&[r, s])));
    let near: Vec<_> = near.filter(|(_, around)| boxes_meet(*around, of_one)).collect();
    one.segments().any(|(p, q)| {
        let own = around(&[p, q]);
        let crosses = |[r, s]: [Point; 2]| segment_crossing(p, q, r, s).is_some();
        boxes_meet(own, of_other) && near.iter().any(|(ends, around)| boxes_meet(own, *around) && crosses(*ends))
    })
}
