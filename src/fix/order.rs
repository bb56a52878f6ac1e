//! Which fixes go first, place by place.

use super::fixes_by_place::{BLAME_DISTANCE, ByPlace};
use super::proposal::{Mend, Proposal};

/// Fixes farther apart than this (m) do not affect each other, unless they are about the same elements: their effects are found
/// within [`BLAME_DISTANCE`].
pub const APART: f64 = 2.0 * BLAME_DISTANCE;

/// Ranks: what mends the file itself, what is safe, what is assumed, areas.
const RANKS: usize = 4;

/// The fixes that go first: those of elements that do not load, because most other findings may only follow from these; then at
/// each place the safe ones, which must not be blamed for what an assumption does; then the others; areas last, when what they
/// lie over is final. Places far apart do not wait for each other.
pub fn first_of(open: Vec<Proposal>) -> Vec<Proposal> {
    let mut by_rank: [Vec<Proposal>; RANKS] = Default::default();
    for one in open {
        if let Some(rank) = by_rank.get_mut(rank(&one)) {
            rank.push(one);
        }
    }
    let [of_the_file, others @ ..] = by_rank;
    if !of_the_file.is_empty() {
        return of_the_file;
    }
    let (mut first, mut earlier): (Vec<Proposal>, Vec<Proposal>) = Default::default();
    for rank in others {
        let waiting_for = ByPlace::of(&earlier);
        first.extend(rank.iter().filter(|one| !waiting_for.has_near(one, APART)).cloned());
        earlier.extend(rank);
    }
    first
}

fn rank(one: &Proposal) -> usize {
    match is_of_the_file(&one.mend) {
        true => 0,
        false => 1 + usize::from(!one.fix.safe) + usize::from(one.draws_area()),
    }
}

/// Whether a fix mends the file itself, before anything in it means something.
fn is_of_the_file(mend: &Mend) -> bool {
    ["load/", "ids/", "node/"].iter().any(|family| mend.code.starts_with(family))
}
