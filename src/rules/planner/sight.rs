//! Attention areas that end where the map does.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnostic::{Finding, Place, Subject};
use crate::lanelet::index::extent;
use crate::rules::map_border::border;

use super::watching::Watching;

/// One finding for each lanelet at the map's border that cuts attention areas short.
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
    let [_, out_of_areas] = all.map.lanes_at_areas();
    let begins = (0..all.network.view.lanelets.len()).filter_map(|at| {
        let lane = all.lane(at).filter(|lane| !out_of_areas.contains(lane))?;
        let start = all.map.lanes[lane].start;
        let open = all.network.graph.passes(at) && all.network.graph.previous(at).is_empty();
        (open && border.distance(start.middle()) <= map_border).then_some((at, start))
    });
    begins
        .filter_map(|(begin, start)| {
            let seen = all.network.downstream(begin, length);
            let cut = seen.iter().flat_map(|(watched, after)| {
                let watchers = watchers.get(watched).into_iter().flatten();
                watchers.map(move |&watcher| (watcher, *after))
            });
            let cut: Vec<(usize, f64)> = cut.collect();
            let &(first, after) = cut.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
            let count = cut.iter().map(|one| one.0).collect::<BTreeSet<usize>>().len();
            let (id, first) = (all.id(begin), all.id(first));
            let more = match count {
                1 => String::new(),
                2 => " and another lanelet".to_owned(),
                count => format!(" and {} more lanelets", count - 1),
            };
            let message = format!("The map begins with lanelet {id}, {after:.0} m before what lanelet {first}{more} should watch for {length:.0} m.");
            let finding = Finding::new("attention-cut", Subject::Lanelet(id.0), message)
                .with(Subject::Lanelet(first.0), "watches")
                .measured(after, length, "m");
            Some(finding.at(Place::Line(start.points.to_vec())))
        })
        .collect()
}
