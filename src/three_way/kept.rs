//! What one side deleted and the other needs is kept: what it has changed, with whatever that is part of, and what it refers to.

use std::collections::BTreeMap;

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use super::conflict::Side;
use super::decide::{Decision, Decisions};
use super::fields::Clash;
use super::versions::{Deletions, Key};
use super::view::View;

/// Puts back what was deleted and is needed, and says so.
pub(super) fn keep_what_is_needed(decisions: &mut Decisions, sides: [&View<'_>; 3], deletions: Deletions) {
    for side in [Side::Ours, Side::Theirs] {
        keep_what_changed(decisions, sides, side);
    }
    tell_what_stays_out(decisions, sides);
    keep_what_is_referred_to(decisions, sides, deletions);
}

/// The elements that only one side has deleted, as the other has them: which of them each is part of.
struct Wholes(FxHashMap<Key, Vec<Key>>);

impl Wholes {
    fn of(sides: [&View<'_>; 3], keeper: Side) -> Self {
        let [base, ours, theirs] = sides;
        let (keeper, deleter) = if keeper == Side::Ours { (ours, theirs) } else { (theirs, ours) };
        let mut users: FxHashMap<Key, Vec<Key>> = FxHashMap::default();
        for user in keeper.keys().filter(|key| base.has(*key) && !deleter.has(*key)) {
            for key in keeper.references(user) {
                users.entry(key).or_default().push(user);
            }
        }
        Self(users)
    }

    /// An element and all that it is part of: a vertex with its line, the line with its lanelet; and what nothing else has a part of.
    fn around(&self, key: Key) -> (FxHashSet<Key>, Key) {
        let (mut seen, mut queue, mut top) = (FxHashSet::default(), vec![key], None);
        while let Some(one) = queue.pop() {
            if !seen.insert(one) {
                continue;
            }
            match self.0.get(&one) {
                Some(users) => queue.extend(users),
                None => top = top.max(Some(one)),
            }
        }
        // Those that refer to each other in a circle are part of each other.
        (seen, top.unwrap_or(key))
    }
}

/// How many changes a conflict is about.
fn changed(count: usize) -> String {
    match count {
        1 => "changed".to_owned(),
        _ => format!("changed in {count} places"),
    }
}

/// Elements that this side has changed and the other deleted are kept together with the deleted elements that they are part of.
/// One conflict names what all of them are part of.
fn keep_what_changed(decisions: &mut Decisions, sides: [&View<'_>; 3], side: Side) {
    let torn: Vec<Key> = decisions.torn.iter().filter(|(_, one)| **one == side).map(|(key, _)| *key).collect();
    if torn.is_empty() {
        return;
    }
    let wholes = Wholes::of(sides, side);
    let mut tops: BTreeMap<Key, usize> = BTreeMap::new();
    for key in torn {
        let (around, top) = wholes.around(key);
        for one in around {
            if !decisions.has(one, sides[1]) {
                decisions.restore(one, side);
            }
            decisions.brought.insert(one);
        }
        *tops.entry(top).or_default() += 1;
    }
    for (top, count) in tops {
        let (was, own) = (Some("there".to_owned()), Some(changed(count)));
        let said = if side == Side::Ours { [was, own, None] } else { [was, None, own] };
        decisions.clash(top, Clash { about: "deletion".to_owned(), said }, side);
    }
}

/// What ours has deleted and theirs changed, and what stays out.
fn tell_what_stays_out(decisions: &mut Decisions, sides: [&View<'_>; 3]) {
    let gone = std::mem::take(&mut decisions.gone);
    if gone.is_empty() {
        return;
    }
    let wholes = Wholes::of(sides, Side::Theirs);
    let mut tops: BTreeMap<Key, usize> = BTreeMap::new();
    for key in gone {
        *tops.entry(wholes.around(key).1).or_default() += 1;
    }
    for (top, count) in tops {
        let said = [Some("there".to_owned()), None, Some(changed(count))];
        decisions.clash(top, Clash { about: "deletion".to_owned(), said }, Side::Ours);
    }
}

/// Elements that the result refers to and one side has deleted are kept, unless that side itself refers to what it has deleted.
fn keep_what_is_referred_to(decisions: &mut Decisions, sides: [&View<'_>; 3], deletions: Deletions) {
    let [_, ours, theirs] = sides;
    // What ours has as it was can only lack what theirs has deleted.
    let is_lacking = decisions.made.values().any(|decision| matches!(decision, Decision::Removed));
    let own: Vec<Key> = if is_lacking { ours.keys().collect() } else { Vec::new() };
    let needs_a_look = |key: &Key| ours.references(*key).iter().any(|other| !decisions.has(*other, ours));
    let mut queue: Vec<Key> = own.into_par_iter().filter(needs_a_look).collect();
    queue.retain(|key| decisions.has(*key, ours));
    let made = decisions.made.iter().filter(|(_, decision)| !matches!(decision, Decision::Removed));
    let mut made: Vec<Key> = made.map(|(key, _)| *key).collect();
    made.sort_unstable();
    queue.extend(made);
    while let Some(user) = queue.pop() {
        for key in decisions.references(user, sides) {
            if decisions.has(key, ours) {
                continue;
            }
            let (side, keeper, deleter) = match (ours.has(key), theirs.has(key)) {
                (true, _) => (Side::Ours, ours, theirs),
                (false, true) => (Side::Theirs, theirs, ours),
                // It is nowhere: whoever refers to it did before.
                (false, false) => continue,
            };
            if decisions.hollow.contains(&key) && decisions.leave_out(user, key, sides) {
                continue;
            }
            if deleter.has(user) && deleter.references(user).contains(&key) {
                continue;
            }
            if side == Side::Theirs && deletions == Deletions::OfOursStand && decisions.leave_out(user, key, sides) {
                continue;
            }
            decisions.restore(key, side);
            queue.push(key);
            if !decisions.brought.contains(&user) && !decisions.tells_of_members(user) {
                let told = keeper.subject(user).or_else(|| deleter.subject(user)).map(|user| format!("used by {user}"));
                let said = match side {
                    // Ours still has it, theirs deleted it.
                    Side::Ours => [Some("there".to_owned()), told, None],
                    Side::Theirs => [Some("there".to_owned()), None, told],
                };
                decisions.clash(key, Clash { about: "deletion".to_owned(), said }, side);
            }
            decisions.brought.insert(key);
        }
    }
}
