//! Connecting roads whose lanes change their ids from section to section: a lane that leads through gets one id all along, so that it
//! becomes one lanelet. Where a lane is not there, one without width takes its place.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use crate::text::Text;
use crate::xodr::{Cubic, Cubics, JunctionKind, Lane, OpenDrive, Road, RoadEnd, RoadLink, Validity};

use super::lane_use::LaneUse;
use super::stretches::steps;

/// For each section the new ids of its lanes, by the old ones.
type NewIds = Vec<BTreeMap<i64, i64>>;

/// The file with one id for each lane that leads through a connecting road.
pub fn with_tracks(file: &OpenDrive) -> Cow<'_, OpenDrive> {
    let common: BTreeSet<&Text> =
        file.junctions.iter().filter(|it| it.kind == JunctionKind::Common).map(|it| &it.id).collect();
    let connecting = |road: &&Road| road.junction.as_ref().is_some_and(|junction| common.contains(junction));
    let renamed: BTreeMap<Text, NewIds> =
        file.roads.iter().filter(connecting).filter_map(|road| Some((road.id.clone(), new_ids(road)?))).collect();
    if renamed.is_empty() {
        return Cow::Borrowed(file);
    }
    let mut file = file.clone();
    for road in &mut file.roads {
        if let Some(ids) = renamed.get(&road.id) {
            rename(road, ids);
        }
        for side in [0, 1] {
            let Some(RoadLink::Road(other, contact)) = &road.links[side] else { continue };
            let Some(ids) = renamed.get(other) else { continue };
            let at = match contact {
                Some(RoadEnd::Start) => ids.first(),
                Some(RoadEnd::End) => ids.last(),
                None => None,
            };
            let own = if side == 0 { road.sections.first_mut() } else { road.sections.last_mut() };
            for link in own.into_iter().flat_map(|section| &mut section.lanes).flat_map(|lane| &mut lane.links[side]) {
                *link = at.and_then(|at| at.get(link)).copied().unwrap_or(*link);
            }
        }
    }
    for connection in file.junctions.iter_mut().flat_map(|junction| &mut junction.connections) {
        let Some(ids) = renamed.get(&connection.connecting) else { continue };
        let at = if connection.contact == Some(RoadEnd::End) { ids.last() } else { ids.first() };
        for [_, to] in &mut connection.lanes {
            *to = at.and_then(|at| at.get(to)).copied().unwrap_or(*to);
        }
    }
    Cow::Owned(file)
}

/// The new ids of a road; `None` if the old ones serve, or lanes cross.
fn new_ids(road: &Road) -> Option<NewIds> {
    let mut tracks: Vec<BTreeMap<i64, usize>> = Vec::new();
    let mut count = 0;
    for (at, section) in road.sections.iter().enumerate() {
        let before = at.checked_sub(1).map(|before| (&road.sections[before], &tracks[before]));
        let links = before.map(|(before, _)| steps(before, section)).unwrap_or_default();
        let mut here: BTreeMap<i64, usize> = BTreeMap::new();
        for lane in &section.lanes {
            let linked = links.iter().find(|[a, b]| *b == lane.id && a.signum() == b.signum()).map(|[a, _]| *a);
            // Strips beside the lanes are seldom linked.
            let from = linked.or((!LaneUse::of(lane).is_driven()).then_some(lane.id));
            let known = from.and_then(|from| before?.1.get(&from).copied());
            let track = known.filter(|track| !here.values().any(|other| other == track));
            here.insert(lane.id, track.unwrap_or(count));
            count += usize::from(track.is_none());
        }
        tracks.push(here);
    }
    let same = |pair: &[BTreeMap<i64, usize>]| pair[0] == pair[1];
    if tracks.windows(2).all(same) {
        return None;
    }
    let mut id_of: BTreeMap<usize, i64> = BTreeMap::new();
    for side in [1, -1] {
        let orders: Vec<Vec<usize>> = tracks.iter().map(|here| outward(here, side)).collect();
        for (rank, track) in merged(&orders)?.into_iter().enumerate() {
            id_of.insert(track, side * (rank as i64 + 1));
        }
    }
    let renamed =
        |here: &BTreeMap<i64, usize>| here.iter().filter_map(|(id, track)| Some((*id, *id_of.get(track)?))).collect();
    Some(tracks.iter().map(renamed).collect())
}

/// The lanes of one side of a section, from the centre outward.
fn outward(here: &BTreeMap<i64, usize>, side: i64) -> Vec<usize> {
    let mut lanes: Vec<(i64, usize)> =
        here.iter().filter(|(id, _)| id.signum() == side).map(|(id, track)| (id.abs(), *track)).collect();
    lanes.sort_unstable();
    lanes.into_iter().map(|(_, track)| track).collect()
}

/// One order that agrees with all; `None` if there is none.
fn merged(orders: &[Vec<usize>]) -> Option<Vec<usize>> {
    let mut left: BTreeSet<usize> = orders.iter().flatten().copied().collect();
    let mut order = Vec::with_capacity(left.len());
    while !left.is_empty() {
        let waits = |track: usize| {
            orders.iter().any(|order| {
                order.iter().take_while(|it| **it != track).any(|it| left.contains(it)) && order.contains(&track)
            })
        };
        let next = left.iter().copied().find(|track| !waits(*track))?;
        left.remove(&next);
        order.push(next);
    }
    Some(order)
}

fn rename(road: &mut Road, ids: &NewIds) {
    let new_at = |road: &Road, station: f64| ids.get(road.section_at(station)).cloned().unwrap_or_default();
    let renamed = |validity: &Validity, here: &BTreeMap<i64, i64>| {
        let named = here.iter().filter(|(old, _)| validity.names(**old)).map(|(_, new)| [*new; 2]);
        Validity {
            facing: validity.facing,
            lanes: if validity.lanes.is_empty() { Vec::new() } else { named.collect() },
        }
    };
    for at in 0..road.signals.len() {
        let here = new_at(road, road.signals[at].at[0]);
        road.signals[at].validity = renamed(&road.signals[at].validity, &here);
    }
    for at in 0..road.references.len() {
        let here = new_at(road, road.references[at].at[0]);
        road.references[at].validity = renamed(&road.references[at].validity, &here);
    }
    for at in 0..road.objects.len() {
        let here = new_at(road, road.objects[at].at[0]);
        road.objects[at].validity = renamed(&road.objects[at].validity, &here);
    }
    // The kind of a strip that is not driven holds where it is not there, so that nothing changes.
    let mut kinds: BTreeMap<i64, (Text, bool)> = BTreeMap::new();
    for (section, here) in road.sections.iter().zip(ids) {
        for lane in &section.lanes {
            let Some(id) = here.get(&lane.id) else { continue };
            let known = kinds.entry(*id).or_insert_with(|| (lane.kind.clone(), false));
            known.1 |= LaneUse::of(lane).is_driven();
        }
    }
    let last = road.sections.len().saturating_sub(1);
    for (at, (section, here)) in road.sections.iter_mut().zip(ids).enumerate() {
        let mut lanes: Vec<Lane> = Vec::with_capacity(kinds.len());
        for mut lane in std::mem::take(&mut section.lanes) {
            let Some(id) = here.get(&lane.id) else { continue };
            lane.id = *id;
            let next_to = [at.checked_sub(1), (at < last).then_some(at + 1)];
            for (links, other) in lane.links.iter_mut().zip(next_to) {
                let Some(other) = other.and_then(|other| ids.get(other)) else { continue };
                *links = links.iter().filter_map(|link| other.get(link).copied()).collect();
            }
            lanes.push(lane);
        }
        for (id, (kind, driven)) in &kinds {
            if !lanes.iter().any(|lane| lane.id == *id) {
                let widths = Cubics::new(vec![Cubic { start: 0.0, factors: [0.0; 4] }]);
                let kind = if *driven { Text::const_new("none") } else { kind.clone() };
                lanes.push(Lane { id: *id, kind, widths, ..Lane::default() });
            }
        }
        lanes.sort_by_key(|lane| std::cmp::Reverse(lane.id));
        section.lanes = lanes;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_merged_or_contradict_each_other() {
        assert_eq!(merged(&[vec![0, 1, 3], vec![0, 2, 3]]), Some(vec![0, 1, 2, 3]));
        assert_eq!(merged(&[vec![1, 0], vec![2, 1]]), Some(vec![2, 1, 0]));
        assert_eq!(merged(&[vec![0, 1], vec![1, 0]]), None);
    }

    #[test]
    fn a_lane_that_moves_outward_keeps_its_id() {
        let lane = |id: i64, next: &[i64]| Lane {
            id,
            kind: "driving".into(),
            links: [Vec::new(), next.to_vec()],
            ..Lane::default()
        };
        let section = |lanes: Vec<Lane>| crate::xodr::Section { lanes, ..crate::xodr::Section::default() };
        let road = Road {
            sections: vec![
                section(vec![lane(-1, &[-1]), lane(-2, &[-3])]),
                section(vec![lane(-1, &[]), lane(-2, &[]), lane(-3, &[])]),
            ],
            ..Road::default()
        };
        let ids = new_ids(&road).unwrap();
        assert_eq!(ids[0], BTreeMap::from([(-1, -1), (-2, -3)]));
        assert_eq!(ids[1], BTreeMap::from([(-1, -1), (-2, -2), (-3, -3)]));
    }
}
