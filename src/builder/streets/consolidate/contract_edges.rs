//! Contracts the roads that lie inside intersections, and keeps what hung on them.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::builder::network::road_end::other_end;
use crate::builder::network::{
    InnerRoad, Intersection, IntersectionIx, Island, LaneConnection, RoadEnd, RoadIx, RoadNetwork, TurnRestriction,
};
use crate::geometry::Point;

use super::island::{around_corner, encloses_island};
use super::passages::{Rules, passages};
use super::{ConsolidateOptions, MergeNote, MergeReason, MergeVerdict};

/// The network after one round, whether anything merged, and a note per verdict.
pub fn contract(
    network: RoadNetwork,
    verdicts: &[MergeVerdict],
    options: &ConsolidateOptions,
) -> (RoadNetwork, bool, Vec<MergeNote>) {
    let clusters = clusters(&network, verdicts, options);
    let mut notes = Vec::new();
    for verdict in verdicts {
        let refusal = clusters.refused.get(&verdict.road).copied();
        notes.push(MergeNote {
            key: network.road(verdict.road).key,
            merged: verdict.merge && refusal.is_none(),
            reason: refusal.unwrap_or(verdict.reason),
            left: verdict.left,
            wish: verdict.wish,
        });
    }
    match clusters.accepted.is_empty() {
        true => (network, false, notes),
        false => (rebuild(network, &clusters.accepted), true, notes),
    }
}

/// Intersections that become one.
struct Cluster {
    /// Ascending.
    members: Vec<IntersectionIx>,
    /// Ascending.
    inner: Vec<RoadIx>,
    /// Outer arms in clockwise order around the cluster.
    contour: Vec<RoadEnd>,
}

#[derive(Default)]
struct Clusters {
    accepted: Vec<Cluster>,
    refused: FxHashMap<RoadIx, MergeReason>,
}

/// Grows clusters road by road, the shortest first, so that a limit cuts off the weakest link and not the whole.
fn clusters(network: &RoadNetwork, verdicts: &[MergeVerdict], options: &ConsolidateOptions) -> Clusters {
    let mut result = Clusters::default();
    let mut order: Vec<&MergeVerdict> = verdicts.iter().filter(|v| v.merge).collect();
    order.sort_by(|a, b| {
        let rank = |v: &MergeVerdict| u8::from(v.reason != MergeReason::Wish);
        rank(a)
            .cmp(&rank(b))
            .then(a.left.total_cmp(&b.left))
            .then(network.road(a.road).key.cmp(&network.road(b.road).key))
    });
    let mut barred: FxHashSet<RoadIx> = FxHashSet::default();
    let groups = loop {
        let (groups, refused, lopsided) = grow(network, &order, &barred, options);
        if lopsided.is_empty() {
            result.refused = refused;
            break groups;
        }
        barred.extend(lopsided);
    };
    for members in groups.into_groups() {
        let inner = inner_roads(network, &members);
        match contour(network, &members, &inner) {
            Some(contour) => result.accepted.push(Cluster { members, inner, contour }),
            None => {
                result.refused.extend(inner.into_iter().map(|road| (road, MergeReason::Enclosed)));
            }
        }
    }
    result
}

/// Joins intersections by the roads in their order but for those `barred`. Returns the sets, why roads do not join any, and
/// those that should not have, although vehicles can wait on them: three corners of a block would be one intersection, and
/// the fourth left over.
fn grow(
    network: &RoadNetwork,
    order: &[&MergeVerdict],
    barred: &FxHashSet<RoadIx>,
    options: &ConsolidateOptions,
) -> (Groups, FxHashMap<RoadIx, MergeReason>, Vec<RoadIx>) {
    let mut groups = Groups::new(network.intersections.len());
    let (mut refused, mut lopsided) = (FxHashMap::default(), Vec::new());
    let mut joined: FxHashMap<RoadIx, usize> = FxHashMap::default();
    for (rank, verdict) in order.iter().enumerate() {
        let road = network.road(verdict.road);
        let union = groups.union_of(road.from, road.to);
        let reason = match verdict.reason {
            MergeReason::Wish => None,
            _ if barred.contains(&verdict.road) => Some(MergeReason::Island),
            _ => objection(network, &union, options),
        };
        match reason {
            Some(reason) => {
                if reason == MergeReason::Island {
                    let waiting = |road: &RoadIx| {
                        matches!(order[joined[road]].reason, MergeReason::AcrossMedian | MergeReason::BetweenSignals)
                    };
                    lopsided.extend(around_corner(network, verdict.road, &joined).filter(waiting));
                }
                refused.insert(verdict.road, reason);
            }
            None => {
                joined.insert(verdict.road, rank);
                groups.join(road.from, road.to);
            }
        }
    }
    (groups, refused, lopsided)
}

/// Why these intersections must not become one; `None` if they may.
fn objection(network: &RoadNetwork, members: &[IntersectionIx], options: &ConsolidateOptions) -> Option<MergeReason> {
    let points: Vec<Point> = members.iter().flat_map(|m| reach_points(network.intersection(*m))).collect();
    let too_far = points.iter().any(|a| points.iter().any(|b| (a - b).norm() > options.reach));
    if too_far {
        return Some(MergeReason::Reach);
    }
    if collapses_roundabout(network, members, options) {
        return Some(MergeReason::Roundabout);
    }
    encloses_island(network, members, &inner_roads(network, members)).then_some(MergeReason::Island)
}

/// Its position, and the ends of the roads that were merged into it.
fn reach_points(intersection: &Intersection) -> Vec<Point> {
    let mut points = vec![intersection.position];
    points.extend(intersection.inner.iter().flat_map(|i| [i.line.first(), i.line.last()]));
    points
}

/// Whether the intersections hold a whole roundabout that vehicles really drive around: one whose ring is long enough
/// to have room for them. A smaller ring is a painted dot, and one intersection.
fn collapses_roundabout(network: &RoadNetwork, members: &[IntersectionIx], options: &ConsolidateOptions) -> bool {
    let held: FxHashSet<IntersectionIx> = members.iter().copied().collect();
    let ring: Vec<RoadIx> = members
        .iter()
        .flat_map(|m| &network.intersection(*m).arms)
        .map(|arm| arm.road)
        .filter(|ix| {
            let road = network.road(*ix);
            road.roundabout && held.contains(&road.from) && held.contains(&road.to)
        })
        .collect::<std::collections::BTreeSet<_>>()
        .into_iter()
        .collect();
    let length: f64 = ring.iter().map(|ix| network.road(*ix).line.length()).sum();
    let starts: FxHashSet<_> = ring.iter().map(|ix| network.road(*ix).from).collect();
    let closed = !ring.is_empty() && ring.iter().all(|ix| starts.contains(&network.road(*ix).to));
    closed && length > std::f64::consts::PI * options.short_across_median
}

/// Every road between two members that does not lead around a block of its own: decided ones, and the rest of the
/// short links beside them.
fn inner_roads(network: &RoadNetwork, members: &[IntersectionIx]) -> Vec<RoadIx> {
    let held: FxHashSet<IntersectionIx> = members.iter().copied().collect();
    let points: Vec<Point> = members.iter().flat_map(|m| reach_points(network.intersection(*m))).collect();
    let across = points.iter().flat_map(|a| points.iter().map(move |b| (a - b).norm())).fold(0.0, f64::max);
    let mut inner: Vec<RoadIx> = members
        .iter()
        .flat_map(|m| &network.intersection(*m).arms)
        .map(|arm| arm.road)
        .filter(|ix| {
            let road = network.road(*ix);
            road.from != road.to
                && held.contains(&road.from)
                && held.contains(&road.to)
                && road.line.length() <= 2.0 * across
        })
        .collect();
    inner.sort();
    inner.dedup();
    inner
}

/// The outer arms clockwise, as one finds them who walks around the cluster along its edge: clockwise to the next
/// arm, over an inner road to its other end, and on. `None` if an arm is left out: then it leads into a hole.
fn contour(network: &RoadNetwork, members: &[IntersectionIx], inner: &[RoadIx]) -> Option<Vec<RoadEnd>> {
    let is_inner = |arm: &RoadEnd| inner.binary_search(&arm.road).is_ok();
    let outer: Vec<RoadEnd> =
        members.iter().flat_map(|m| network.intersection(*m).arms.iter().copied()).filter(|a| !is_inner(a)).collect();
    let first = *outer.iter().min_by_key(|arm| (network.road(arm.road).key, arm.end))?;
    let next_clockwise = |arm: RoadEnd| -> Option<RoadEnd> {
        let arms = &network.intersection(network.road(arm.road).intersection(arm.end)).arms;
        let at = arms.iter().position(|a| *a == arm)?;
        Some(arms[(at + 1) % arms.len()])
    };
    let mut walk = vec![first];
    let mut at = first;
    // Each road end is passed at most once on the way around.
    let limit = members.iter().map(|m| network.intersection(*m).arms.len()).sum::<usize>() + 1;
    for _ in 0..limit {
        at = next_clockwise(at)?;
        if is_inner(&at) {
            at = other_end(at);
        } else if at == first {
            break;
        } else {
            walk.push(at);
        }
    }
    (walk.len() == outer.len()).then_some(walk)
}

fn rebuild(network: RoadNetwork, clusters: &[Cluster]) -> RoadNetwork {
    let rules = Rules::new(&network.restrictions);
    let made: Vec<Intersection> = clusters.iter().map(|cluster| merged(&network, cluster, &rules)).collect();
    drop(rules);
    let RoadNetwork { mut roads, intersections, restrictions, connections, .. } = network;
    let mut taken = vec![false; intersections.len()];
    clusters.iter().flat_map(|cluster| &cluster.members).for_each(|member| taken[*member] = true);
    // Each with its old place, and the merged ones with the numbers behind those.
    let mut old: Vec<(Intersection, usize)> =
        intersections.into_iter().zip(0..).filter(|(_, at)| !taken[*at]).collect();
    old.extend(made.into_iter().zip(taken.len()..));
    old.sort_by(|a, b| a.0.nodes.cmp(&b.0.nodes));
    let mut moved = vec![IntersectionIx(0); taken.len()];
    for ((_, at), new) in old.iter().zip(0..) {
        match at.checked_sub(taken.len()) {
            None => moved[*at] = IntersectionIx(new),
            Some(cluster) => {
                clusters[cluster].members.iter().for_each(|member| moved[*member] = IntersectionIx(new));
            }
        }
    }
    let mut place: Vec<Option<RoadIx>> = vec![Some(RoadIx(0)); roads.len()];
    clusters.iter().flat_map(|cluster| &cluster.inner).for_each(|road| place[*road] = None);
    place.iter_mut().flatten().zip(0..).for_each(|(road, new)| *road = RoadIx(new));
    let moved = |at: IntersectionIx| moved[at];
    let mut places = place.iter();
    roads.retain_mut(|road| {
        (road.from, road.to) = (moved(road.from), moved(road.to));
        places.next().is_some_and(Option::is_some)
    });
    let place = |road: RoadIx| place[road];
    let renamed = |arm: RoadEnd| place(arm.road).map(|road| RoadEnd { road, end: arm.end });
    let intersections = old.into_iter().map(|(mut intersection, _)| {
        intersection.arms = intersection.arms.into_iter().filter_map(renamed).collect();
        intersection.passages = intersection.passages.map(|passages| {
            passages.into_iter().filter_map(|(from, to)| Some((renamed(from)?, renamed(to)?))).collect()
        });
        intersection
    });
    // A restriction over inner roads alone is kept by the passages.
    let restricted = |r: TurnRestriction| {
        let via: Vec<RoadIx> = r.via.iter().filter_map(|road| place(*road)).collect();
        let kept = via.is_empty() == r.via.is_empty();
        kept.then_some(TurnRestriction { from: renamed(r.from)?, to: renamed(r.to)?, via, ..r })
    };
    let connected = |c: LaneConnection| Some(LaneConnection { from: renamed(c.from)?, to: renamed(c.to)?, ..c });
    RoadNetwork {
        roads,
        intersections: intersections.collect(),
        restrictions: restrictions.into_iter().filter_map(restricted).collect(),
        connections: connections.into_iter().filter_map(connected).collect(),
        ..network
    }
}

fn merged(network: &RoadNetwork, cluster: &Cluster, rules: &Rules<'_>) -> Intersection {
    let members: Vec<&Intersection> = cluster.members.iter().map(|m| network.intersection(*m)).collect();
    let mut nodes: Vec<i64> = members.iter().flat_map(|m| m.nodes.iter().copied()).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let centre = members.iter().fold(crate::geometry::Vector::zeros(), |sum, m| sum + m.position.coords);
    let mut inner: Vec<InnerRoad> = members.iter().flat_map(|m| m.inner.iter().cloned()).collect();
    inner.extend(cluster.inner.iter().map(|ix| {
        let road = network.road(*ix);
        InnerRoad {
            key: road.key,
            ways: road.ways.clone(),
            line: road.line.clone(),
            section: road.section.clone(),
            roundabout: road.roundabout,
        }
    }));
    inner.sort_by_key(|i| i.key);
    let crossroads: Vec<&&Intersection> = members.iter().filter(|m| m.arms.len() > 2).collect();
    let is_inner = |ix: RoadIx| cluster.inner.binary_search(&ix).is_ok();
    let mut islands: Vec<Island> = members.iter().flat_map(|m| m.islands.iter().cloned()).collect();
    islands.sort_by_key(|island| island.way);
    islands.dedup_by_key(|island| island.way);
    Intersection {
        nodes,
        position: Point::from(centre / members.len() as f64),
        arms: cluster.contour.clone(),
        map_edge: false,
        signals: members.iter().any(|m| m.signals),
        all_way_stop: !crossroads.is_empty() && crossroads.iter().all(|m| m.all_way_stop),
        circle: members.iter().find_map(|m| m.circle.clone()),
        inner,
        passages: Some(passages(network, &cluster.members, &is_inner, rules)),
        islands,
    }
}

/// Disjoint sets of intersections.
struct Groups {
    group: Vec<usize>,
    members: Vec<Vec<IntersectionIx>>,
}

impl Groups {
    fn new(count: usize) -> Self {
        Self { group: (0..count).collect(), members: (0..count).map(|i| vec![IntersectionIx::new(i)]).collect() }
    }

    fn of(&self, ix: IntersectionIx) -> usize {
        self.group[ix]
    }

    fn union_of(&self, a: IntersectionIx, b: IntersectionIx) -> Vec<IntersectionIx> {
        let mut union = self.members[self.of(a)].clone();
        if self.of(a) != self.of(b) {
            union.extend(&self.members[self.of(b)]);
        }
        union
    }

    fn join(&mut self, a: IntersectionIx, b: IntersectionIx) {
        let (mut large, mut small) = (self.of(a), self.of(b));
        if large == small {
            return;
        }
        if self.members[large].len() < self.members[small].len() {
            std::mem::swap(&mut large, &mut small);
        }
        for ix in std::mem::take(&mut self.members[small]) {
            self.group[ix] = large;
            self.members[large].push(ix);
        }
    }

    /// The sets of two and more, each ascending, in order of their first member.
    fn into_groups(self) -> Vec<Vec<IntersectionIx>> {
        let mut groups: Vec<Vec<IntersectionIx>> = self.members.into_iter().filter(|m| m.len() > 1).collect();
        groups.iter_mut().for_each(|g| g.sort());
        groups.sort();
        groups
    }
}
