//! What one side deleted and the other needs is kept: what it has changed, with whatever that is part of, and what it refers to.

use std::collections::BTreeMap;

use rustc_hash::{FxHashMap, FxHashSet};

use super::conflict::Side;
use super::decide::{Decision, Decisions};
use super::fields::Clash;
use super::versions::Key;
use super::view::View;

/// Puts back what was deleted and is needed, and says so.
pub(super) fn keep_what_is_needed(decisions: &mut Decisions, sides: [&View<'_>; 3]) {
    for side in [Side::Ours, Side::Theirs] {
        keep_what_changed(decisions, sides, side);
    }
    for key in std::mem::take(&mut decisions.gone) {
        let said = [Some("there"), None, Some("changed")].map(|word| word.map(str::to_owned));
        decisions.clash(key, Clash { about: "deletion".to_owned(), said }, Side::Ours);
    }
    keep_what_is_referred_to(decisions, sides);
}

/// Elements that this side has changed and the other deleted are kept together with the deleted elements that they are part of:
/// a vertex with its line, the line with its lanelet. One conflict names what all of them are part of.
fn keep_what_changed(decisions: &mut Decisions, sides: [&View<'_>; 3], side: Side) {
    let torn: Vec<Key> = decisions.torn.iter().filter(|(_, one)| **one == side).map(|(key, _)| *key).collect();
    if torn.is_empty() {
        return;
    }
    let [base, ours, theirs] = sides;
    let (keeper, deleter) = if side == Side::Ours { (ours, theirs) } else { (theirs, ours) };
    // Only what was deleted can be lacking.
    let mut users: FxHashMap<Key, Vec<Key>> = FxHashMap::default();
    for user in keeper.keys().filter(|key| base.has(*key) && !deleter.has(*key)) {
        for key in keeper.references(user) {
            users.entry(key).or_default().push(user);
        }
    }
    let mut changed: BTreeMap<Key, usize> = BTreeMap::new();
    for key in torn {
        let (mut seen, mut queue, mut tops) = (FxHashSet::default(), vec![key], Vec::new());
        while let Some(one) = queue.pop() {
            if !seen.insert(one) {
                continue;
            }
            if !decisions.has(one, ours) {
                decisions.restore(one, side);
            }
            decisions.brought.insert(one);
            match users.get(&one) {
                Some(users) => queue.extend(users),
                None => tops.push(one),
            }
        }
        // Those that refer to each other in a circle are part of each other.
        let top = tops.into_iter().max().unwrap_or(key);
        *changed.entry(top).or_default() += 1;
    }
    for (top, count) in changed {
        let own = match count {
            1 => "changed".to_owned(),
            _ => format!("changed in {count} places"),
        };
        let said = match side {
            Side::Ours => [Some("there".to_owned()), Some(own), None],
            Side::Theirs => [Some("there".to_owned()), None, Some(own)],
        };
        decisions.clash(top, Clash { about: "deletion".to_owned(), said }, side);
    }
}

/// Elements that the result refers to and one side has deleted are kept, unless that side itself refers to what it has deleted.
fn keep_what_is_referred_to(decisions: &mut Decisions, sides: [&View<'_>; 3]) {
    let [_, ours, theirs] = sides;
    let mut queue: Vec<Key> = ours.keys().filter(|key| decisions.has(*key, ours)).collect();
    let added =
        decisions.made.iter().filter(|(key, decision)| !matches!(decision, Decision::Removed) && !ours.has(**key));
    let mut added: Vec<Key> = added.map(|(key, _)| *key).collect();
    added.sort_unstable();
    queue.extend(added);
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
            if deleter.has(user) && deleter.references(user).contains(&key) {
                continue;
            }
            decisions.restore(key, side);
            queue.push(key);
            if !decisions.brought.contains(&user) && !decisions.tells_role(user, key) {
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
