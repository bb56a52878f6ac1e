//! Rights of way as TIER IV's validator reads them.
//!
//! Without lights, the validator wants the element of a lanelet to list all lanelets that it meets. Autoware ignores the listed
//! lanelets, so only the elements of lanelets that go before all others stay; a vehicle on any other lanelet waits for everybody. With
//! lights, an element lists the lanelets that have green at another time by the validator's reading, if it is safe to ignore them.
//! The validator also wants one lanelet of each area to have an element. If no lanelet goes before all others, two lanelets share an
//! element, because the validator does not judge the list of a shared one.

use std::collections::BTreeSet;

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use super::lanes_seen::{Judged, LanesSeen};
use crate::builder::ids::Key;
use crate::builder::postprocess::map_editor::{drop_elements, insert_element, is_taken};
use crate::lanelet::index::tier4_yields::{Ruled, share_predecessor};
use crate::lanelet::index::view::View;
use crate::lanelet::{LaneletId, LaneletMap, Member, RegulatoryElement, RegulatoryElementId, Target};
use crate::parallel::InSmallParts;

/// Changes the `right_of_way` elements of a map as the validator reads them.
pub fn suit_validator(map: &mut LaneletMap) {
    let changes = {
        let view = View::new(map);
        Changes::new(&LanesSeen::new(&view))
    };
    changes.apply(map);
}

/// What is to be changed.
struct Changes {
    /// The lanelets that each element is to list instead. An element that would list none is removed.
    lists: Vec<(RegulatoryElementId, Vec<LaneletId>)>,
    /// Elements to be added.
    added: Vec<Added>,
}

/// An element to be added.
struct Added {
    owners: Vec<LaneletId>,
    yielding: Vec<LaneletId>,
}

/// A lanelet with the one element that lists it, and nobody else, as its owner.
struct Owner<'m> {
    at: usize,
    element: &'m RegulatoryElement,
    /// The lanelets that the element lists, by position, in order.
    listed: Vec<usize>,
    /// Those of them that it is to list.
    kept: Vec<usize>,
}

impl<'m> LanesSeen<'_, 'm> {
    /// The owners of elements, with what these are to list.
    fn owners(&self) -> Vec<Owner<'m>> {
        let lanelets = 0..self.view.lanelets.len();
        lanelets.into_par_iter().in_small_parts().filter_map(|at| self.owner(at)).collect()
    }

    fn owner(&self, at: usize) -> Option<Owner<'m>> {
        let element = self.element(at)?;
        let listed = self.listed(element);
        let kept = match self.judged(at) {
            Judged::Never | Judged::By(Ruled::Virtually) => listed.clone(),
            Judged::By(Ruled::ByLight) => self.kept_by_light(at, &listed),
            Judged::By(Ruled::ByNothing) => {
                let wanted = self.wanted(at, Ruled::ByNothing);
                let first = wanted.iter().all(|y| listed.binary_search(y).is_ok());
                if first { wanted } else { Vec::new() }
            }
        };
        Some(Owner { at, element, listed, kept })
    }

    /// Of the lanelets that a turn with a light may ignore, those that the validator expects; the vehicle waits for the others without
    /// need. If it expects none of them, one is kept, if possible one that Autoware does not watch anyway: the validator wants an
    /// element on each turn, and the loader rejects an element that lists nothing.
    fn kept_by_light(&self, at: usize, listed: &[usize]) -> Vec<usize> {
        let expected = self.wanted(at, Ruled::ByLight).into_iter();
        let kept: Vec<usize> = expected.filter(|y| listed.binary_search(y).is_ok()).collect();
        if !kept.is_empty() {
            return kept;
        }
        self.unwatched(at, listed).into_iter().chain(listed.iter().copied()).take(1).collect()
    }

    /// An element for an area in which no lanelet goes before all others. `listed` has the lanelets that each lanelet may ignore.
    fn element_for(&self, members: &[usize], listed: &FxHashMap<usize, &[usize]>) -> Option<Added> {
        let (owners, yielding) = self
            .beside_light(members)
            .or_else(|| shared(members, listed))
            .or_else(|| self.of_no_effect(members, members))
            .or_else(|| self.of_no_effect(members, &self.behind(members)))
            .or_else(|| self.turn_without_effect(members))?;
        let ids = |lanelets: Vec<usize>| lanelets.into_iter().map(|at| self.view.lanelets[at].id()).collect();
        Some(Added { owners: ids(owners), yielding: ids(yielding) })
    }

    /// An element on a straight lanelet with a light, which may ignore lanelets that have green at another time: Autoware watches none
    /// of them there.
    fn beside_light(&self, members: &[usize]) -> Option<(Vec<usize>, Vec<usize>)> {
        let straight = members.iter().copied().filter(|&at| self.judged(at) == Judged::Never);
        let mut with_others = straight.map(|at| (vec![at], self.wanted(at, Ruled::ByLight)));
        with_others.find(|(_, yielding)| !yielding.is_empty())
    }

    /// The lanelets that begin where those of an area end.
    fn behind(&self, members: &[usize]) -> Vec<usize> {
        members.iter().flat_map(|&at| self.graph.following(at)).collect()
    }

    /// An element that lists one of `others` that Autoware does not watch anyway, because it begins on the same lanelet as its owners or
    /// does not meet them. Two owners are better than one: the validator does not judge a shared list.
    fn of_no_effect(&self, members: &[usize], others: &[usize]) -> Option<(Vec<usize>, Vec<usize>)> {
        let owns = |at: &&usize| matches!(self.judged(**at), Judged::Never | Judged::By(Ruled::ByNothing));
        let owners = members.iter().filter(owns).map(|&x| (x, self.unwatched(x, others)));
        let owners: Vec<(usize, BTreeSet<usize>)> = owners.collect();
        for (i, (x, of_x)) in owners.iter().enumerate() {
            for (y, of_y) in &owners[i + 1..] {
                if let Some(&other) = of_x.intersection(of_y).next() {
                    return Some((vec![*x, *y], vec![other]));
                }
            }
        }
        let alone = |x: &usize| self.judged(*x) == Judged::Never || self.wanted(*x, Ruled::ByNothing).is_empty();
        let (x, of_x) = owners.iter().find(|(x, of_x)| !of_x.is_empty() && alone(x))?;
        Some((vec![*x], of_x.iter().take(1).copied().collect()))
    }

    /// An element on a turn with a light that lists a lanelet which Autoware does not watch anyway. The validator wants an element on
    /// each such turn but does not expect this lanelet in it, so that one error is left of two.
    fn turn_without_effect(&self, members: &[usize]) -> Option<(Vec<usize>, Vec<usize>)> {
        let others: Vec<usize> = members.iter().copied().chain(self.behind(members)).collect();
        let mut turns = members.iter().filter(|at| self.judged(**at) == Judged::By(Ruled::ByLight));
        turns.find_map(|&x| Some((vec![x], vec![*self.unwatched(x, &others).first()?])))
    }

    /// Those of `others` that Autoware does not watch for a lanelet.
    fn unwatched(&self, x: usize, others: &[usize]) -> BTreeSet<usize> {
        let meets: FxHashSet<usize> = self.graph.conflicting(x).into_iter().collect();
        let free = |y: &usize| *y != x && (!meets.contains(y) || share_predecessor(&self.graph, x, *y));
        others.iter().copied().filter(free).collect()
    }
}

/// The two lanelets that may ignore the most others in common.
fn shared(members: &[usize], listed: &FxHashMap<usize, &[usize]>) -> Option<(Vec<usize>, Vec<usize>)> {
    let owners: Vec<(usize, &[usize])> = members.iter().filter_map(|x| Some((*x, *listed.get(x)?))).collect();
    let mut best: Option<(Vec<usize>, Vec<usize>)> = None;
    for (i, (x, of_x)) in owners.iter().enumerate() {
        for (y, of_y) in &owners[i + 1..] {
            let both: Vec<usize> = of_x.iter().copied().filter(|z| of_y.binary_search(z).is_ok()).collect();
            if both.len() > best.as_ref().map_or(0, |(_, most)| most.len()) {
                best = Some((vec![*x, *y], both));
            }
        }
    }
    best
}

impl Changes {
    fn new(all: &LanesSeen) -> Self {
        let owners = all.owners();
        let served: FxHashSet<usize> = owners.iter().filter(|one| !one.kept.is_empty()).map(|one| one.at).collect();
        let listed: FxHashMap<usize, &[usize]> =
            owners.iter().filter(|one| one.kept.is_empty()).map(|one| (one.at, &one.listed[..])).collect();
        let areas: Vec<Vec<usize>> = all.areas().into_values().collect();
        let unserved =
            areas.par_iter().in_small_parts().filter(|members| !members.iter().any(|at| served.contains(at)));
        let added = unserved.filter_map(|members| all.element_for(members, &listed)).collect();
        let id = |at: usize| all.view.lanelets[at].id();
        let changed = owners.iter().filter(|one| one.kept != one.listed);
        let lists = changed.map(|one| (one.element.id, one.kept.iter().map(|&at| id(at)).collect()));
        Self { lists: lists.collect(), added }
    }

    fn apply(self, map: &mut LaneletMap) {
        let mut dropped = FxHashSet::default();
        for (id, yielding) in self.lists {
            if yielding.is_empty() {
                dropped.insert(id);
            } else if let Some(element) = map.regulatory_elements.get_mut(id) {
                element.members.retain(|member| member.role != "yield");
                element.members.extend(yielding.into_iter().map(|id| member("yield", id)));
            }
        }
        drop_elements(map, &dropped);
        for Added { owners, yielding } in self.added {
            let key = owners.iter().fold(Key::new("shared right of way"), |key, owner| key.number(owner.0));
            let id = RegulatoryElementId(key.id(|id| is_taken(map, id)));
            let mut members: Vec<Member> = owners.iter().map(|&owner| member("right_of_way", owner)).collect();
            members.extend(yielding.into_iter().map(|id| member("yield", id)));
            insert_element(map, id, "right_of_way", members, &owners);
        }
    }
}

fn member(role: &str, lanelet: LaneletId) -> Member {
    Member { role: role.into(), target: Target::Lanelet(lanelet) }
}
