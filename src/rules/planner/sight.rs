//! Attention areas that end where the map does.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::Polyline;
use crate::lanelet::PointId;
use crate::lanelet::index::{UnionFind, extent};
use crate::rules::map_border::border;

use super::watching::Watching;

/// One finding for each place at the map's border that cuts attention areas short.
pub fn judge(all: &Watching, map_border: f64) -> Vec<Finding> {
    let Some(border) = border(all.map) else { return Vec::new() };
    let length = all.params.attention_area_length;
    // In a map so small nothing else is to be expected.
    let [low, high] = extent(border.points());
    if (high - low).norm() < 2.0 * length {
        return Vec::new();
    }
    let mut watchers: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for &at in &all.turns {
        for &watched in all.attention[at].iter().flat_map(|attention| &attention.watched) {
            watchers.entry(watched).or_default().push(at);
        }
    }
    places(all, map_border, &border).iter().filter_map(|begins| found(all, &watchers, begins)).collect()
}

/// Lanelets that begin side by side at the map's border: each of a road whose upper part is not in the map.
fn places(all: &Watching, map_border: f64, border: &Polyline) -> Vec<Vec<usize>> {
    let [_, out_of_areas] = all.map.lanes_at_areas();
    let begins_there = |at: &usize| {
        let open = all.network.graph.passes(*at) && all.network.graph.previous(*at).is_empty();
        let lane = all.lane(*at).filter(|lane| open && !out_of_areas.contains(lane));
        lane.is_some_and(|lane| border.distance(all.map.lanes[lane].start.middle()) <= map_border)
    };
    let begins: Vec<usize> = (0..all.network.view.lanelets.len()).filter(begins_there).collect();
    let mut together = UnionFind::new(begins.len());
    let mut known: BTreeMap<PointId, usize> = BTreeMap::new();
    for (i, &at) in begins.iter().enumerate() {
        let points = all.lane(at).map(|lane| all.map.lanes[lane].start.ids).into_iter().flatten();
        for point in points {
            together.join(i, *known.entry(point).or_insert(i));
        }
    }
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (i, &at) in begins.iter().enumerate() {
        groups.entry(together.root(i)).or_default().push(at);
    }
    groups.into_values().collect()
}

/// What is said of lanelets that begin side by side, if any area is cut short by them.
fn found(all: &Watching, watchers: &BTreeMap<usize, Vec<usize>>, begins: &[usize]) -> Option<Finding> {
    let length = all.params.attention_area_length;
    let mut cut: Vec<(f64, usize, usize)> = Vec::new();
    for &begin in begins {
        for (watched, after) in all.network.downstream(begin, length) {
            cut.extend(watchers.get(&watched).into_iter().flatten().map(|&watcher| (after, begin, watcher)));
        }
    }
    let &(after, begin, watcher) = cut.iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    let count = cut.iter().map(|one| one.2).collect::<BTreeSet<usize>>().len();
    let (id, watcher) = (all.id(begin), all.id(watcher));
    let more = match count {
        1 => String::new(),
        2 => " and another lanelet".to_owned(),
        count => format!(" and {} more lanelets", count - 1),
    };
    let message = format!(
        "The map begins with lanelet {id}, {after:.0} m before what lanelet {watcher}{more} should watch for {length:.0} m."
    );
    let finding = Finding::new("attention-cut", Subject::Lanelet(id.0), message)
        .with(Subject::Lanelet(watcher.0), "watches")
        .measured(after, length, "m");
    let start = all.map.lanes[all.lane(begin)?].start;
    let beside = begins.iter().filter(|&&other| other != begin).map(|&other| Subject::Lanelet(all.id(other).0));
    Some(
        beside
            .fold(finding, |finding, other| finding.with(other, "begins beside it"))
            .at(Place::Line(start.points.to_vec())),
    )
}
