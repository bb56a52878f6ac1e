//! One road lanelet is deleted from a map: how often that is told.

use std::collections::BTreeMap;

use lanewright::osm::ElementKind;
use rayon::prelude::*;

use super::draft::Draft;
use super::{Base, bases};
use crate::common::soak;

/// The name of the mutation.
pub const NAME: &str = "delete a road lanelet";
/// A lane that is gone shows at the lanes before and behind it, or at the lines beside it.
pub const GONE: &[&str] = &[
    "health/hole",
    "vm-03-04/dangling-il",
    "vm-03-04/in-lane-dead-end",
    "vm-03-04/out-lane-unreached",
    "vm-03-04/movement-missing",
];
/// So many may slip, in parts of all.
pub const SLIPS: f64 = 0.1;
/// Of each map this one of so many is deleted; all of them, one after the other, in a soak.
const EVERY: usize = 4;

/// The ids of road lanelets.
pub fn roads(map: &Draft) -> impl Iterator<Item = i64> + '_ {
    map.lanelets().filter(|lanelet| lanelet.tags.is("subtype", "road")).map(|lanelet| lanelet.id)
}

#[test]
fn nine_of_ten_deleted_lanes_are_told() {
    let bases = bases();
    let every = if soak() { 1 } else { EVERY };
    let trials: Vec<(&Base, i64)> =
        bases.iter().flat_map(|base| roads(&base.draft).step_by(every).map(move |id| (base, id))).collect();
    let is_told = |&(base, id): &(&Base, i64)| {
        let mut draft = base.draft.clone();
        draft.remove(ElementKind::Relation, id);
        base.judge(&draft).iter().any(|found| base.is_new(found) && GONE.contains(&found.code.as_str()))
    };
    let told: Vec<bool> = trials.par_iter().map(is_told).collect();
    let mut missed: BTreeMap<&str, Vec<i64>> = BTreeMap::new();
    for ((base, id), _) in trials.iter().zip(&told).filter(|(_, told)| !**told) {
        missed.entry(&base.name).or_default().push(*id);
    }
    let slips = told.iter().filter(|told| !**told).count();
    println!("{} of {} deleted lanes are told, not {missed:?}", trials.len() - slips, trials.len());
    assert!(
        trials.len() > 50 && slips as f64 <= SLIPS * trials.len() as f64,
        "{slips} of {}: {missed:?}",
        trials.len()
    );
}
