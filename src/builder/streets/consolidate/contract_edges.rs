//! Merges the intersections at the ends of inner roads (edge contraction), with restrictions, passages and connections.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::builder::network::road_end::{directions, other_end};
use crate::builder::network::{
    InnerRoad, Intersection, IntersectionIx, Island, MOST_DIRECTIONS, RoadEnd, RoadIx, RoadNetwork, TurnRestriction,
};
use crate::geometry::Point;
use crate::geometry::polygon::convex_hull;

use super::inner_routes::{RestrictionIndex, passages};
use super::island::{around_corner, encloses_island};
use super::long_rows::dividing_roads;
use super::renames::Renames;
use super::types::SHORT_ACROSS_MEDIAN;
use super::{ConsolidateOptions, MergeNote, MergeReason, MergeVerdict};
use crate::builder::streets::outline::LEAST_ROAD;

/// Where nothing is left of the road between two intersections, the merged one may reach this many times as far as otherwise.
const OVERLAPPING: f64 = 2.0;

/// The network after one round, whether anything merged, and a note for each verdict.
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
    /// Its outer arms clockwise.
    contour: Vec<RoadEnd>,
}

#[derive(Default)]
struct Clusters {
    accepted: Vec<Cluster>,
    refused: FxHashMap<RoadIx, MergeReason>,
}

/// Grows clusters road by road, the shortest first, so that a limit excludes the longest road and not the whole cluster.
fn clusters(network: &RoadNetwork, verdicts: &[MergeVerdict], options: &ConsolidateOptions) -> Clusters {
    let mut result = Clusters::default();
    let by_rule = verdicts.iter().filter(|v| v.merge && v.reason != MergeReason::Wish);
    let dividing = dividing_roads(network, &by_rule.map(|verdict| verdict.road).collect::<Vec<_>>());
    let mut order: Vec<&MergeVerdict> = verdicts.iter().filter(|v| v.merge && !dividing.contains(&v.road)).collect();
    order.sort_by(|a, b| {
        let rank = |v: &MergeVerdict| (v.reason != MergeReason::Wish, network.road(v.road).key);
        let ((by_rule, key), (other_by_rule, other_key)) = (rank(a), rank(b));
        by_rule.cmp(&other_by_rule).then(a.left.total_cmp(&b.left)).then(key.cmp(&other_key))
    });
    let mut barred: FxHashSet<RoadIx> = FxHashSet::default();
    let groups = loop {
        let (groups, refused, to_bar) = grow(network, &order, &barred, options);
        if to_bar.is_empty() {
            result.refused = refused;
            break groups;
        }
        barred.extend(to_bar);
    };
    result.refused.extend(dividing.into_iter().map(|road| (road, MergeReason::Row)));
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

/// Joins intersections by the roads in their order, except those `barred`. Returns the groups, why roads were refused, and the
/// roads that must be barred: vehicles can wait on them, and with them three corners of a block would be one intersection
/// without the fourth.
fn grow(
    network: &RoadNetwork,
    order: &[&MergeVerdict],
    barred: &FxHashSet<RoadIx>,
    options: &ConsolidateOptions,
) -> (Groups, FxHashMap<RoadIx, MergeReason>, Vec<RoadIx>) {
    let mut groups = Groups::new(network.intersections.len());
    let (mut refused, mut to_bar) = (FxHashMap::default(), Vec::new());
    let mut joined: FxHashMap<RoadIx, usize> = FxHashMap::default();
    for (rank, verdict) in order.iter().enumerate() {
        let road = network.road(verdict.road);
        let union = groups.union_of(road.from, road.to);
        let reason = match verdict.reason {
            MergeReason::Wish => None,
            _ if barred.contains(&verdict.road) => Some(MergeReason::Island),
            _ => objection(network, &union, verdict.left, options),
        };
        match reason {
            Some(reason) => {
                if reason == MergeReason::Island {
                    let waiting = |road: &RoadIx| {
                        matches!(order[joined[road]].reason, MergeReason::AcrossMedian | MergeReason::BetweenSignals)
                    };
                    to_bar.extend(around_corner(network, verdict.road, &joined).filter(waiting));
                }
                refused.insert(verdict.road, reason);
            }
            None => {
                joined.insert(verdict.road, rank);
                groups.join(road.from, road.to);
            }
        }
    }
    (groups, refused, to_bar)
}

/// Why these intersections must not become one by a road with `left` metres between its cuts; `None` if they may. Where nothing is left
/// of the road, they would otherwise lie on each other.
fn objection(
    network: &RoadNetwork,
    members: &[IntersectionIx],
    left: f64,
    options: &ConsolidateOptions,
) -> Option<MergeReason> {
    let reach = if left <= LEAST_ROAD { OVERLAPPING * options.reach } else { options.reach };
    if across(network, members) > reach {
        return Some(MergeReason::Reach);
    }
    if collapses_roundabout(network, members) {
        return Some(MergeReason::Roundabout);
    }
    let inner = inner_roads(network, members);
    let arms = members.iter().flat_map(|m| &network.intersection(*m).arms);
    let outer = arms.filter(|arm| inner.binary_search(&arm.road).is_err());
    if outer.map(|arm| directions(network, *arm)).sum::<usize>() > MOST_DIRECTIONS {
        return Some(MergeReason::Crowded);
    }
    encloses_island(network, members, &inner, options.island).then_some(MergeReason::Island)
}

/// The position of an intersection, and the ends of its inner roads.
fn extent(intersection: &Intersection) -> Vec<Point> {
    let mut points = vec![intersection.position];
    points.extend(intersection.inner.iter().flat_map(|i| [i.line.first(), i.line.last()]));
    points
}

/// The largest distance between two places of these intersections, metres.
fn across(network: &RoadNetwork, members: &[IntersectionIx]) -> f64 {
    // The two that are farthest apart are corners of the hull.
    let corners = convex_hull(members.iter().flat_map(|m| extent(network.intersection(*m))));
    corners.iter().flat_map(|a| corners.iter().map(move |b| (a - b).norm())).fold(0.0, f64::max)
}

/// Whether the intersections contain a whole roundabout that vehicles drive around. A ring too short for them is a painted dot
/// and one intersection.
fn collapses_roundabout(network: &RoadNetwork, members: &[IntersectionIx]) -> bool {
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
    closed && length > std::f64::consts::PI * SHORT_ACROSS_MEDIAN
}

/// Every road between two members, except long ones, which lead around a block.
fn inner_roads(network: &RoadNetwork, members: &[IntersectionIx]) -> Vec<RoadIx> {
    let held: FxHashSet<IntersectionIx> = members.iter().copied().collect();
    let across = across(network, members);
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

/// The outer arms clockwise, found by walking around the cluster: on to the next arm clockwise, and over inner roads to their
/// other ends. `None` if the walk misses an arm, because it leads into a hole of the cluster.
fn contour(network: &RoadNetwork, members: &[IntersectionIx], inner: &[RoadIx]) -> Option<Vec<RoadEnd>> {
    let is_inner = |arm: &RoadEnd| inner.binary_search(&arm.road).is_ok();
    let outer: Vec<RoadEnd> =
        members.iter().flat_map(|m| network.intersection(*m).arms.iter().copied()).filter(|a| !is_inner(a)).collect();
    let first = *outer.iter().min_by_key(|arm| (network.road(arm.road).key, arm.end))?;
    let next_clockwise = |arm: RoadEnd| -> Option<RoadEnd> {
        let arms = &network.intersection(network.intersection_at(arm)).arms;
        let i = arms.iter().position(|a| *a == arm)?;
        Some(arms[(i + 1) % arms.len()])
    };
    let mut walk = vec![first];
    let mut arm = first;
    // The walk passes each road end at most once.
    let limit = members.iter().map(|m| network.intersection(*m).arms.len()).sum::<usize>() + 1;
    for _ in 0..limit {
        arm = next_clockwise(arm)?;
        if is_inner(&arm) {
            arm = other_end(arm);
        } else if arm == first {
            break;
        } else {
            walk.push(arm);
        }
    }
    (walk.len() == outer.len()).then_some(walk)
}

/// The network with every cluster as one intersection.
fn rebuild(network: RoadNetwork, clusters: &[Cluster]) -> RoadNetwork {
    let rules = RestrictionIndex::new(&network.restrictions);
    let made: Vec<Intersection> = clusters.iter().map(|cluster| merged(&network, cluster, &rules)).collect();
    drop(rules);
    let RoadNetwork { mut roads, intersections, restrictions, connections, .. } = network;
    let mut renames = Renames { roads: vec![Some(RoadIx(0)); roads.len()], ..Renames::default() };
    clusters.iter().flat_map(|cluster| &cluster.inner).for_each(|road| renames.roads[*road] = None);
    renames.roads.iter_mut().flatten().zip(0..).for_each(|(road, new)| *road = RoadIx(new));
    let intersections = with_merged(intersections, clusters, made, &mut renames);
    let mut remaining = renames.roads.iter().map(Option::is_some);
    roads.retain_mut(|road| {
        renames.road(road);
        remaining.next() == Some(true)
    });
    RoadNetwork {
        roads,
        intersections: intersections.into_iter().map(|i| renames.intersection(i)).collect(),
        restrictions: restrictions.into_iter().filter_map(|r| without_inner_roads(r, &renames)).collect(),
        connections: connections.into_iter().filter_map(|c| renames.connection(c)).collect(),
        ..network
    }
}

/// The intersections in order of their nodes, with those `made` from the clusters instead of the members.
fn with_merged(
    intersections: Vec<Intersection>,
    clusters: &[Cluster],
    made: Vec<Intersection>,
    renames: &mut Renames,
) -> Vec<Intersection> {
    let count = intersections.len();
    let mut is_member = vec![false; count];
    clusters.iter().flat_map(|cluster| &cluster.members).for_each(|member| is_member[*member] = true);
    // Each with its old position; the merged ones follow after the others.
    let mut all: Vec<(Intersection, usize)> =
        intersections.into_iter().zip(0..).filter(|(_, old)| !is_member[*old]).collect();
    all.extend(made.into_iter().zip(count..));
    all.sort_by(|a, b| a.0.nodes.cmp(&b.0.nodes));
    renames.intersections = vec![IntersectionIx(0); count];
    for ((_, old), new) in all.iter().zip(0..) {
        match old.checked_sub(count) {
            None => renames.intersections[*old] = IntersectionIx(new),
            Some(cluster) => {
                clusters[cluster].members.iter().for_each(|m| renames.intersections[*m] = IntersectionIx(new));
            }
        }
    }
    all.into_iter().map(|(intersection, _)| intersection).collect()
}

/// The restriction without inner roads; `None` if it has no others: then the passages hold it.
fn without_inner_roads(r: TurnRestriction, renames: &Renames) -> Option<TurnRestriction> {
    let via: Vec<RoadIx> = r.via.iter().filter_map(|road| renames.roads[*road]).collect();
    let kept = via.is_empty() == r.via.is_empty();
    kept.then_some(TurnRestriction { from: renames.arm(r.from)?, to: renames.arm(r.to)?, via, ..r })
}

/// The intersection that a cluster becomes.
fn merged(network: &RoadNetwork, cluster: &Cluster, rules: &RestrictionIndex<'_>) -> Intersection {
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
        closed_by: None,
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

    /// The sets of two or more, each ascending, in order of their first member.
    fn into_groups(self) -> Vec<Vec<IntersectionIx>> {
        let mut groups: Vec<Vec<IntersectionIx>> = self.members.into_iter().filter(|m| m.len() > 1).collect();
        groups.iter_mut().for_each(|g| g.sort());
        groups.sort();
        groups
    }
}
