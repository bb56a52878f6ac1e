//! The net of lanes: rings too small to drive, parts that hang together with nothing.

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::FxHashSet;

use crate::diagnostic::{Finding, Place, Severity};
use crate::geometry::{Polyline, Vector};
use crate::lanelet::index::{Edge, MapIndex, UnionFind};
use crate::lanelet::{LaneletId, RoadType};
use crate::rules::routing_moves::RoutingMoves;

use super::links::Links;
use super::params::{Params, subject};

/// A ring of more lanelets than this has pieces too short to be lanes, and those are told of already.
const MOST_PIECES: usize = 12;

/// Fewer lanes than this are no net from which a note says that something is apart.
const NET: usize = 10;

pub fn judge(map: &MapIndex, params: &Params, moves: &RoutingMoves, links: &Links) -> Vec<Finding> {
    let mut findings: Vec<Finding> = (0..map.lanes.len()).filter_map(|at| ring(map, params, at)).collect();
    findings.extend(islands(map, params, moves, links));
    findings
}

/// The shortest way from the end of a lane back to its start, if no vehicle can turn on a ring that short. The finding is about
/// the first lane on it.
fn ring(map: &MapIndex, params: &Params, at: usize) -> Option<Finding> {
    // A lane without length is told of as that.
    let has_length = map.lanes[at].length() >= params.least_length;
    if !map.lanes[at].vehicle || !has_length {
        return None;
    }
    let mut open = vec![(map.lanes[at].length(), vec![at])];
    while let Some((length, path)) = open.pop() {
        let last = *path.last()?;
        for &next in map.followers(last) {
            if next == at && length < params.shortest_loop {
                let ids: Vec<String> = path.iter().map(|&lane| map.lanes[lane].id.to_string()).collect();
                let message = match &ids[..] {
                    [id] => format!("Lane {id} follows itself after {length:.1} m."),
                    _ => format!("Lanes {} form a ring of {length:.1} m.", ids.join(", ")),
                };
                let finding = Finding::new("loop", subject(map, at), message)
                    .measured(length, params.shortest_loop, "m")
                    .at(Place::Polygon(map.lanes[at].outline.clone()));
                return Some(
                    path.iter().skip(1).fold(finding, |all, &lane| all.with(subject(map, lane), "in the ring")),
                );
            }
            let longer = length + map.lanes[next].length();
            if next > at
                && longer < params.shortest_loop
                && map.lanes[next].vehicle
                && path.len() < MOST_PIECES
                && !path.contains(&next)
            {
                open.push((longer, path.iter().copied().chain([next]).collect()));
            }
        }
    }
    None
}

/// Parts of the net between which nobody can drive, by followers and permitted lane changes, and that lie in the midst of others. Of
/// what may lead out of the map there is a note only, and only where no border is shared with the rest.
fn islands(map: &MapIndex, params: &Params, moves: &RoutingMoves, links: &Links) -> Vec<Finding> {
    let lanes: Vec<usize> = (0..map.lanes.len()).filter(|&at| map.lanes[at].vehicle).collect();
    let cut_off = parts(map, &lanes, |at| {
        moves.beside(at).into_iter().filter(|other| other.may_leave).map(|other| other.lane).collect()
    });
    let mut findings = Vec::new();
    let mut told = FxHashSet::default();
    for part in besides_the_largest(&cut_off, 1) {
        if !is_cut_off(map, params, moves, links, part) {
            continue;
        }
        told.extend(part.iter().copied());
        let message = |count, first| match count {
            1 => format!("Nobody can drive from lane {first} to another lane, or from another one to it."),
            _ => format!("Nobody can drive between {count} lanes, {first} the first, and the rest of the map."),
        };
        findings.extend(island(map, part, message));
    }
    let beside = |at: usize| map.lanes[at].bounds.iter().flat_map(|&way| map.users_of(way)).copied().collect();
    let loose = parts(map, &lanes, beside);
    for part in besides_the_largest(&loose, NET).filter(|part| part.iter().all(|at| !told.contains(at))) {
        let message = |count, first| match count {
            1 => format!("Lane {first} is connected to no other lane."),
            _ => format!("{count} lanes, {first} the first, are connected with each other but not with the rest."),
        };
        findings.extend(island(map, part, message).map(|finding| finding.graded(Severity::Info)));
    }
    findings
}

/// Lanes that hang together by followers, over areas, and by what lies `beside`.
fn parts(map: &MapIndex, lanes: &[usize], beside: impl Fn(usize) -> Vec<usize>) -> Vec<Vec<usize>> {
    let mut groups = UnionFind::new(map.lanes.len());
    for &at in lanes {
        let others = map.followers(at).iter().copied().chain(beside(at));
        others.filter(|&other| map.lanes[other].vehicle).for_each(|other| groups.join(at, other));
    }
    map.ways_over_areas().into_iter().for_each(|[from, to]| groups.join(from, to));
    let mut parts: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for &at in lanes {
        parts.entry(groups.root(at)).or_default().push(at);
    }
    parts.into_values().collect()
}

/// All parts smaller than the largest, if that is a net of at least so many lanes, from which something could be cut off. If two
/// halves have one size, it is unknown which of them is out of place.
fn besides_the_largest(parts: &[Vec<usize>], least: usize) -> impl Iterator<Item = &Vec<usize>> {
    let largest = parts.iter().map(Vec::len).max().unwrap_or_default();
    let is_net = largest >= least && largest > 1;
    parts.iter().filter(move |part| is_net && part.len() < largest)
}

/// Whether these lanes lie in the midst of others and nobody can drive between them: all their ends are close to lanes that go on, none
/// of them is driven beside by oncoming traffic, as a road of two directions is, and nothing is said yet of their ends.
fn is_cut_off(map: &MapIndex, params: &Params, moves: &RoutingMoves, links: &Links, part: &[usize]) -> bool {
    let own: FxHashSet<usize> = part.iter().copied().collect();
    let loose = &map.settings.loose_ends;
    let is_street = |&at: &usize| map.lanes[at].kind == RoadType::Road && map.lanes[at].is_for_cars();
    let is_one_way = |&at: &usize| {
        let along: FxHashSet<usize> = moves.beside(at).into_iter().map(|other| other.lane).collect();
        let mut beside = map.lanes[at].bounds.iter().flat_map(|&way| map.users_of(way));
        beside.all(|other| own.contains(other) || along.contains(other) || !map.lanes[*other].vehicle)
    };
    let is_near = |edge: &Edge, at: usize| {
        let (place, reach) = (edge.middle(), Vector::repeat(params.turning_place));
        let near = map.lanes_near(place - reach, place + reach);
        let near = near.into_iter().filter(|&other| {
            let outline = &map.lanes[other].outline;
            let line = Polyline::new(outline.iter().chain(outline.first()).copied());
            !own.contains(&other)
                && map.lanes[other].vehicle
                && map.are_level(at, other, place)
                && line.is_some_and(|line| line.distance(place) <= params.turning_place)
        });
        let near: Vec<usize> = near.collect();
        // Where others begin or end without another lane, too, the map ends.
        let is_loose = |&other: &usize| {
            let lane = &map.lanes[other];
            let (start, end) = (map.predecessors(other).is_empty(), map.followers(other).is_empty());
            let is_close = |edge: &Edge| (edge.middle() - place).norm() <= params.turning_place;
            start && is_close(&lane.start) || end && is_close(&lane.end)
        };
        !near.is_empty() && !near.iter().any(is_loose)
    };
    let entries: Vec<usize> = part.iter().copied().filter(|&at| map.predecessors(at).is_empty()).collect();
    let exits: Vec<usize> = part.iter().copied().filter(|&at| map.followers(at).is_empty()).collect();
    let is_known = |at: &usize, ends: &BTreeSet<i64>| ends.contains(&map.lanes[*at].id.0);
    let entered =
        |at: &usize| is_near(&map.lanes[*at].start, *at) && !links.starts.contains(at) && !is_known(at, &loose.starts);
    let left = |at: &usize| is_near(&map.lanes[*at].end, *at) && !links.ends.contains(at) && !is_known(at, &loose.ends);
    !(entries.is_empty() && exits.is_empty())
        && part.iter().all(|at| is_street(at) && is_one_way(at))
        && entries.iter().all(entered)
        && exits.iter().all(left)
}

fn island(map: &MapIndex, part: &[usize], message: impl Fn(usize, LaneletId) -> String) -> Option<Finding> {
    let first = part.iter().copied().min()?;
    let lane = &map.lanes[first];
    let finding = Finding::new("island", subject(map, first), message(part.len(), lane.id));
    Some(finding.at(Place::Polygon(lane.outline.clone())))
}
