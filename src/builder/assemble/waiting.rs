//! Who waits before an intersection without lights: drivers expect no stop line where they wait for nobody.

use std::collections::BTreeSet;

use rustc_hash::FxHashSet;

use crate::builder::intersection::conflict::Conflicts;
use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::lanes::types::Arm;
use crate::builder::network::RoadNetwork;
use crate::lanelet::right_of_way::{RankedMovement, Turn};

/// The lanelets of an intersection, and who of them waits for whom.
pub(super) struct Waiting<'a> {
    network: &'a RoadNetwork,
    arms: &'a [&'a Arm],
    /// For each arm the first one of its leg.
    legs: &'a [usize],
    paths: &'a [TurningLanelet],
    ranked: &'a [RankedMovement],
    conflicts: &'a Conflicts,
    /// Pairs of legs, both ways round, from one of which vehicles go straight on to the other.
    straight_on: FxHashSet<[usize; 2]>,
    /// The leg of a T-junction that ends there.
    stem: Option<usize>,
}

impl<'a> Waiting<'a> {
    /// For an intersection; lanelets, their ranks and conflicts in one order.
    pub fn new(
        network: &'a RoadNetwork,
        arms: &'a [&'a Arm],
        legs: &'a [usize],
        (paths, ranked, conflicts): (&'a [TurningLanelet], &'a [RankedMovement], &'a Conflicts),
    ) -> Self {
        let straight = paths.iter().zip(ranked).filter(|(_, ranked)| ranked.turn == Turn::Straight);
        let pairs = straight.map(|(path, _)| [path.movement.from, path.movement.to].map(|arm| legs[arm]));
        let straight_on = pairs.flat_map(|[from, to]| [[from, to], [to, from]]).collect();
        let mut waiting = Self { network, arms, legs, paths, ranked, conflicts, straight_on, stem: None };
        waiting.stem = waiting.find_stem();
        waiting
    }

    /// Whether the road of an arm is public.
    pub fn is_public(&self, arm: usize) -> bool {
        self.network.road(self.arms[arm].at.road).public
    }

    /// Whether somebody waits on an arm: not where the road only divides, where others join it or cross it and give way, and before
    /// driveways.
    pub fn is_at(&self, arm: usize) -> bool {
        let mut own = (0..self.paths.len()).filter(|&x| self.paths[x].movement.from == arm);
        own.any(|x| {
            self.conflicts.real[x].iter().any(|&y| self.waits(x, y))
                || (0..self.paths.len()).any(|y| self.turns_into(x, y) && self.waits(x, y))
        })
    }

    /// Whether the first of two lanelets turns into the road on which the other leads out: it waits for those there, though lanes of
    /// their own are left for each.
    fn turns_into(&self, x: usize, y: usize) -> bool {
        self.ranked[x].turn != Turn::Straight && self.paths[x].movement.to == self.paths[y].movement.to
    }

    /// Whether who drives on the first of two lanelets that meet waits for the other before the intersection.
    fn waits(&self, x: usize, y: usize) -> bool {
        let [one, other] = [x, y].map(|at| self.paths[at].movement);
        let [from, other_from] = [one.from, other.from].map(|arm| self.legs[arm]);
        let are_public = || [one.from, one.to, other.from, other.to].into_iter().all(|arm| self.is_public(arm));
        let first = match (self.ranked[x].priority, self.ranked[y].priority) {
            (Some(first), Some(second)) => first && !second,
            _ => self.stem == Some(other_from) && from != other_from,
        };
        // Who turns across oncoming traffic waits inside.
        let is_oncoming = || self.straight_on.contains(&[from, other_from]);
        let joins = one.to == other.to && goes_on(&self.ranked[x], &self.ranked[y]);
        one.from != other.from && are_public() && !first && !joins && !is_oncoming()
    }

    /// The leg of a T-junction that ends there: all of its vehicles turn, and its road is no greater than the one that leads through.
    fn find_stem(&self) -> Option<usize> {
        let ends = self.paths.iter().flat_map(|path| [path.movement.from, path.movement.to]);
        let used: BTreeSet<usize> = ends.map(|arm| self.legs[arm]).collect();
        let leads_on = |leg: &&usize| self.straight_on.iter().any(|pair| pair.contains(leg));
        let (through, stems): (Vec<usize>, Vec<usize>) = used.iter().partition(leads_on);
        let ([_, _], &[stem]) = (&through[..], &stems[..]) else { return None };
        let classes = |wanted: bool| {
            let of_part = (0..self.arms.len()).filter(move |&arm| (self.legs[arm] == stem) == wanted);
            of_part.map(|arm| self.network.road(self.arms[arm].at.road).class)
        };
        (classes(true).min() >= classes(false).max()).then_some(stem)
    }
}

/// Whether the first of two movements that join goes on as if the other was not there: it has priority, or goes straight on where the
/// other turns.
fn goes_on(one: &RankedMovement, other: &RankedMovement) -> bool {
    match (one.priority, other.priority) {
        (Some(first), Some(second)) => first && !second,
        _ => one.turn == Turn::Straight && other.turn != Turn::Straight,
    }
}
