//! An element that both sides changed: each of its fields from the side that changed it.

use std::collections::{BTreeMap, BTreeSet};

use super::content::{Content, Position};
use super::lists;
use super::versions::Key;
use crate::osm::{ElementKind, Member};

/// A field of which both sides say something else than before, and not the same.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Clash {
    pub(super) about: String,
    /// What base, ours and theirs say.
    pub(super) said: [Option<String>; 3],
}

/// Roles of which an element has one member at most: with two, Lanelet2 reads one of them, or none.
const SINGLE: [&str; 4] = ["left", "right", "centerline", "ref_line"];

/// Puts both changes into one element. Where they contradict each other, it says what `ours` says. `along` tells the order of
/// vertices that both insert between two others.
pub(super) fn merged(
    [base, ours, theirs]: [&Content; 3],
    along: impl Fn(Option<i64>, [&[i64]; 2], Option<i64>) -> Option<Vec<i64>>,
) -> (Content, Vec<Clash>) {
    let mut clashes = Vec::new();
    let mut clash = |about: &str, said: [Option<String>; 3]| clashes.push(Clash { about: about.to_owned(), said });
    let all = [base, ours, theirs];
    let position = one_of(all.map(|one| &one.position)).cloned().unwrap_or_else(|| {
        clash("position", all.map(|one| Some(place(&one.position, &base.position)).filter(|text| !text.is_empty())));
        ours.position.clone()
    });
    let mut tags = BTreeMap::new();
    let keys: BTreeSet<&String> = all.iter().flat_map(|one| one.tags.keys()).collect();
    for key in keys {
        let values = all.map(|one| one.tags.get(key));
        let value = one_of(values).unwrap_or_else(|| {
            clash(&format!("tag {key}"), values.map(Option::<&String>::cloned));
            values[1]
        });
        tags.extend(value.map(|value| (key.clone(), value.clone())));
    }
    let lists = all.map(|one| one.nodes.as_slice());
    let nodes = match one_of(lists) {
        Some(nodes) => nodes.to_vec(),
        None => lists::merged(lists[0], lists[1], lists[2], along).unwrap_or_else(|| {
            clash(
                "nodes",
                lists.map(|nodes| Some(nodes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" "))),
            );
            ours.nodes.clone()
        }),
    };
    let lists = all.map(|one| one.members.as_slice());
    // The members of an area are a ring in their order; those of a lanelet or a regulatory element are known by their roles.
    let is_ring = tags.get("type").is_some_and(|kind| kind == "multipolygon");
    let members = match one_of(lists) {
        Some(members) => members.to_vec(),
        None if is_ring => ring(lists).unwrap_or_else(|| {
            clash("members", lists.map(|members| Some(members.iter().map(member_text).collect::<Vec<_>>().join(", "))));
            ours.members.clone()
        }),
        None => by_role(lists, &mut clash),
    };
    (Content { position, tags, nodes, members }, clashes)
}

/// Where a point is, and how far from where it was.
fn place(position: &Position, before: &Position) -> String {
    let by = before.metres_to(position).filter(|metres| *metres > 0.0);
    position.text() + &by.map_or(String::new(), |metres| format!(" (moved by {metres:.3} m)"))
}

/// What the side says that changed it; `None` where both did, and not to the same.
fn one_of<T: PartialEq>([base, ours, theirs]: [T; 3]) -> Option<T> {
    match () {
        () if theirs == base || ours == theirs => Some(ours),
        () if ours == base => Some(theirs),
        () => None,
    }
}

/// The members of an area, of which both sides changed some.
fn ring(lists: [&[Member]; 3]) -> Option<Vec<Member>> {
    // By their numbers among all, because lists are merged of what can be copied.
    let all: Vec<&Member> = lists.into_iter().flatten().collect();
    let number = |member: &Member| all.iter().position(|one| *one == member);
    let [base, ours, theirs] = lists.map(|members| members.iter().filter_map(number).collect::<Vec<usize>>());
    let merged = lists::merged(&base, &ours, &theirs, |_, _, _| None)?;
    Some(merged.into_iter().filter_map(|number| all.get(number).copied().cloned()).collect())
}

fn member_text(member: &Member) -> String {
    format!("{} {} as {}", member.kind, member.id, if member.role.is_empty() { "member" } else { &member.role })
}

/// What a conflict is about that is about the role of a member.
pub(super) fn role_of((kind, id): Key) -> String {
    format!("role of {kind} {id}")
}

/// Members in any order, each with its roles.
fn by_role([base, ours, theirs]: [&[Member]; 3], clash: &mut impl FnMut(&str, [Option<String>; 3])) -> Vec<Member> {
    let [in_base, in_ours, in_theirs] = [base, ours, theirs].map(roles);
    let mut left: BTreeMap<(Key, &str), usize> = BTreeMap::new();
    let members: BTreeSet<Key> =
        [&in_base, &in_ours, &in_theirs].into_iter().flat_map(|one| one.keys().copied()).collect();
    for member in members {
        let said = [&in_base, &in_ours, &in_theirs].map(|one| one.get(&member));
        let chosen = one_of(said).unwrap_or_else(|| {
            clash(&role_of(member), said.map(|roles| roles.map(|roles| roles.join(", "))));
            said[1]
        });
        for role in chosen.into_iter().flatten() {
            *left.entry((member, role)).or_default() += 1;
        }
    }
    settle_single_roles([base, ours, theirs], &mut left, clash);
    // In the order of ours; what theirs adds stands behind what it follows there.
    let mut merged: Vec<Member> = ours.iter().filter(|member| take(&mut left, member)).cloned().collect();
    let mut behind = 0;
    for member in theirs {
        if take(&mut left, member) {
            merged.insert(behind, member.clone());
            behind += 1;
        } else if let Some(at) = merged.iter().position(|one| one == member) {
            behind = at + 1;
        }
    }
    merged
}

/// Whether a member is still to be placed; it is then placed.
fn take<'m>(left: &mut BTreeMap<(Key, &'m str), usize>, member: &'m Member) -> bool {
    let count = left.get_mut(&((member.kind, member.id), member.role.as_str())).filter(|left| **left > 0);
    count.map(|count| *count -= 1).is_some()
}

/// The roles of each member, sorted.
fn roles(members: &[Member]) -> BTreeMap<Key, Vec<&str>> {
    let mut roles: BTreeMap<Key, Vec<&str>> = BTreeMap::new();
    for member in members {
        roles.entry((member.kind, member.id)).or_default().push(&member.role);
    }
    roles.values_mut().for_each(|roles| roles.sort_unstable());
    roles
}

/// Keeps ours where a role that has one member on either side would have two: a bound, or one that both have exchanged.
fn settle_single_roles<'m>(
    lists: [&'m [Member]; 3],
    left: &mut BTreeMap<(Key, &'m str), usize>,
    clash: &mut impl FnMut(&str, [Option<String>; 3]),
) {
    let with_role = |members: &'m [Member], role: &str| -> Vec<&'m Member> {
        members.iter().filter(|member| member.role == role).collect()
    };
    let all: BTreeSet<&str> =
        lists.iter().flat_map(|members| members.iter()).map(|member| member.role.as_str()).collect();
    for role in all {
        let said = lists.map(|members| with_role(members, role));
        let merged: usize = left.iter().filter(|((_, one), _)| *one == role).map(|(_, count)| count).sum();
        let [base, ours, theirs] = &said;
        if merged == 0 && said.iter().all(|members| !members.is_empty()) {
            // One took some of its members and the other the rest: without any, the element may mean nothing.
            let is_of_ours = |member: &Key| ours.iter().any(|own| (own.kind, own.id) == *member);
            left.retain(|(member, _), _| !is_of_ours(member));
            for own in lists[1].iter().filter(|own| is_of_ours(&(own.kind, own.id))) {
                *left.entry(((own.kind, own.id), own.role.as_str())).or_default() += 1;
            }
            let named = |members: &Vec<&Member>| {
                Some(members.iter().map(|one| format!("{} {}", one.kind, one.id)).collect::<Vec<_>>().join(", "))
            };
            clash(if role.is_empty() { "member without role" } else { role }, said.each_ref().map(named));
            continue;
        }
        let is_exchanged = base.first().is_some_and(|one| !left.contains_key(&((one.kind, one.id), role)));
        if merged < 2 || said.iter().any(|members| members.len() > 1) || !(is_exchanged || SINGLE.contains(&role)) {
            continue;
        }
        if ours.is_empty() || theirs.is_empty() {
            continue;
        }
        let said =
            [base, ours, theirs].map(|members| members.first().map(|member| format!("{} {}", member.kind, member.id)));
        left.retain(|(member, one), _| *one != role || ours.iter().any(|own| (own.kind, own.id) == *member));
        clash(if role.is_empty() { "member without role" } else { role }, said);
    }
}

/// Whether two elements of one id, which neither side had before, are meant to be the same: whether they lie at one place, or are
/// made of the same.
pub(super) fn are_alike(kind: ElementKind, ours: &Content, theirs: &Content) -> bool {
    /// Two people, or one change on two branches, put the same point this close, metres.
    const SAME_NEW_POINT: f64 = 1.0;
    match kind {
        ElementKind::Node => ours.position.metres_to(&theirs.position).is_some_and(|metres| metres < SAME_NEW_POINT),
        ElementKind::Way => mostly_shared(&ours.nodes, &theirs.nodes),
        ElementKind::Relation => mostly_shared(&ours.members, &theirs.members),
    }
}

/// Whether more than half of the longer list is in the other.
fn mostly_shared<T: PartialEq>(a: &[T], b: &[T]) -> bool {
    let shared = a.iter().filter(|one| b.contains(one)).count();
    2 * shared > a.len().max(b.len())
}
