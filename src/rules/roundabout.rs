//! roundabout: whether Autoware's turn signals find in a roundabout element what they look for.

use std::collections::BTreeSet;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{LaneletId, RegulatoryElement};

use super::NoParams;

/// Tags of an entry: the exits for which the signal is on from there.
const SIGNALS: [&str; 2] = ["exit_turn_signal_left", "exit_turn_signal_right"];
/// The tag of a lane from which on the signal for leaving is on.
const ENABLE: &str = "enable_exit_turn_signal";

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let rings: Vec<Ring> =
        map.map.regulatory_elements.iter().filter(|element| element.subtype == "roundabout").map(Ring::of).collect();
    let mut findings = Vec::new();
    for ring in &rings {
        findings.extend(unreferenced(map, ring));
        // A lanelet may lead from one street right into the next: then it is entry and exit.
        let only = |of: &BTreeSet<LaneletId>, not: &BTreeSet<LaneletId>| -> Vec<LaneletId> {
            of.difference(not).copied().collect()
        };
        let links = missing_links(map, ring);
        findings.extend(links.iter().map(|&at| link_missing(map, ring, at)));
        // One finding tells of a lanelet that is missing: the others are held against the element as it would be with it.
        let mut whole = Ring::of(ring.element);
        whole.inner.extend(links.iter().map(|&at| map.lanes[at].id));
        let [entries, exits] = [only(&ring.entries, &ring.exits), only(&ring.exits, &ring.entries)];
        findings.extend(entries.into_iter().filter_map(|id| apart(map, &whole, id, "entry", [false, true])));
        findings.extend(exits.into_iter().filter_map(|id| apart(map, &whole, id, "exit", [true, false])));
        findings.extend(ring.inner.iter().filter_map(|&id| apart(map, &whole, id, "internal", [true, true])));
    }
    for lanelet in &map.map.lanelets {
        let about = Subject::Lanelet(lanelet.id.0);
        for key in SIGNALS {
            let Some(value) = lanelet.attributes.get(key) else { continue };
            findings.extend(no_exits(&rings, lanelet.id, key, value));
        }
        findings.extend(old_signals(lanelet.id, &lanelet.attributes));
        if let Some(value) = lanelet.attributes.get(ENABLE).filter(|value| matches!(*value, "yes" | "1")) {
            let message =
                format!("{ENABLE}={value} of lanelet {} has no effect: Autoware reads true alone.", lanelet.id);
            let edit = Edit::SetTag { on: about, key: ENABLE.into(), value: "true".into() };
            findings.push(Finding::new("not-true", about, message).fixed_by(
                format!("set {ENABLE}=true"),
                false,
                vec![edit],
            ));
        }
    }
    findings
}

/// An element with its lanelets.
struct Ring<'m> {
    element: &'m RegulatoryElement,
    entries: BTreeSet<LaneletId>,
    exits: BTreeSet<LaneletId>,
    inner: BTreeSet<LaneletId>,
}

impl<'m> Ring<'m> {
    fn of(element: &'m RegulatoryElement) -> Self {
        let of = |role: &str| element.lanelets(role).collect();
        Self { element, entries: of("entry"), exits: of("exit"), inner: of("internal") }
    }

    fn holds(&self, id: LaneletId) -> bool {
        [&self.entries, &self.exits, &self.inner].iter().any(|lanes| lanes.contains(&id))
    }
}

/// Entries and exits that do not refer to the element: Autoware looks for it in the lanelets that it drives on.
fn unreferenced(map: &MapIndex, ring: &Ring) -> Option<Finding> {
    let referrers: BTreeSet<LaneletId> = map.referrers(ring.element.id).iter().copied().collect();
    let idle: BTreeSet<LaneletId> =
        ring.entries.union(&ring.exits).filter(|id| !referrers.contains(id)).copied().collect();
    let first = idle.first()?;
    let (id, subject) = (ring.element.id, Subject::RegulatoryElement(ring.element.id.0));
    let message = match idle.len() {
        1 => format!("Lanelet {first} is part of roundabout element {id} and does not refer to it."),
        count => format!(
            "{count} entries and exits of roundabout element {id} do not refer to it, lanelet {first} the first."
        ),
    };
    let edit = |lane: &LaneletId| Edit::AddMember {
        on: Subject::Lanelet(lane.0),
        role: "regulatory_element".into(),
        member: subject,
    };
    let finding = Finding::new("unreferenced", subject, message).with(Subject::Lanelet(first.0), "lanelet");
    Some(finding.fixed_by("let them refer to the element", false, idle.iter().map(edit).collect()))
}

/// The lanelets that lie between two of an element, lead nowhere else, and are not in it.
fn missing_links(map: &MapIndex, ring: &Ring) -> Vec<usize> {
    let all = [&ring.entries, &ring.inner].into_iter().flatten().filter_map(|id| map.lane(*id));
    let next: BTreeSet<usize> = all.flat_map(|at| map.followers(at).iter().copied()).collect();
    let holds = |at: &usize| ring.holds(map.lanes[*at].id);
    let is_link = |at: &usize| {
        let (before, behind) = (map.predecessors(*at), map.followers(*at));
        !holds(at) && map.turn_direction(*at).is_none() && !behind.is_empty() && before.iter().chain(behind).all(holds)
    };
    next.into_iter().filter(is_link).collect()
}

/// The lanelets of an element before and behind a lanelet.
fn ends_of<'a>(map: &'a MapIndex, ring: &'a Ring, at: usize) -> impl Iterator<Item = LaneletId> + 'a {
    let both = map.predecessors(at).iter().chain(map.followers(at));
    both.map(|&other| map.lanes[other].id).filter(|id| ring.holds(*id))
}

/// What is said of a lanelet that is missing in an element.
fn link_missing(map: &MapIndex, ring: &Ring, at: usize) -> Finding {
    let (id, element) = (map.lanes[at].id, ring.element.id);
    let message = format!("Lanelet {id} lies between lanelets of roundabout element {element} and is not in it.");
    let finding = Finding::new("apart", Subject::Lanelet(id.0), message);
    let finding = finding.with(Subject::RegulatoryElement(element.0), "roundabout element");
    let finding = ends_of(map, ring, at).fold(finding, |all, other| all.with(Subject::Lanelet(other.0), "beside it"));
    finding.advised("List it in the element with the role internal.")
}

/// A lanelet that does not hang together with the others of its element: nothing leads to it, or it leads to none of them.
fn apart(map: &MapIndex, ring: &Ring, id: LaneletId, role: &str, [before, behind]: [bool; 2]) -> Option<Finding> {
    let at = map.lane(id)?;
    // Lanelets in an intersection wait by its rules, not by those of the element.
    let in_intersection = |&other: &usize| map.turn_direction(other).is_some();
    let any = |lanes: &[usize]| {
        lanes.iter().any(|&other| ring.holds(map.lanes[other].id))
            || !lanes.is_empty() && lanes.iter().all(in_intersection)
    };
    let what = match (!before || any(map.predecessors(at)), !behind || any(map.followers(at))) {
        (true, true) => return None,
        (false, true) => "no lanelet of the element leads into it",
        (true, false) => "it leads into no lanelet of the element",
        (false, false) => "no lanelet of the element leads into it or out of it",
    };
    let message = format!("Lanelet {id} has the role {role} in roundabout element {}, but {what}.", ring.element.id);
    let finding = Finding::new("apart", Subject::Lanelet(id.0), message);
    Some(finding.with(Subject::RegulatoryElement(ring.element.id.0), "roundabout element"))
}

/// Ids in the tag of an entry that are no exits of its roundabout.
fn no_exits(rings: &[Ring], lanelet: LaneletId, key: &str, value: &str) -> Vec<Finding> {
    let about = Subject::Lanelet(lanelet.0);
    let own: Vec<&Ring> = rings.iter().filter(|ring| ring.entries.contains(&lanelet)).collect();
    if own.is_empty() {
        let message = format!("Lanelet {lanelet} has {key} and is the entry of no roundabout element.");
        return vec![Finding::new("no-exit", about, message)];
    }
    let ids = value.split([',', ' ', '[', ']']).filter_map(|id| id.parse::<i64>().ok());
    let wrong = ids.filter(|id| !own.iter().any(|ring| ring.exits.contains(&LaneletId(*id))));
    wrong
        .map(|id| {
            let message = format!("{key} of lanelet {lanelet} names {id}, which is no exit of its roundabout element.");
            Finding::new("no-exit", about, message)
        })
        .collect()
}

/// The tags that said the same at first: the id of an exit as key, the signal as value.
fn old_signals(lanelet: LaneletId, tags: &crate::lanelet::Attributes) -> Option<Finding> {
    let is_id = |key: &str| key.parse::<i64>().is_ok();
    let old: Vec<(&str, usize)> = tags
        .iter()
        .filter_map(|(key, value)| match value {
            "turn_signal_left" if is_id(key) => Some((key, 0)),
            "turn_signal_right" if is_id(key) => Some((key, 1)),
            _ => None,
        })
        .collect();
    let &(first, side) = old.first()?;
    let about = Subject::Lanelet(lanelet.0);
    let message = format!(
        "Lanelet {lanelet} has the id {first} as a tag, which Autoware reads no more; {} lists the exits instead.",
        SIGNALS[side]
    );
    let mut edits: Vec<Edit> = old.iter().map(|(key, _)| Edit::RemoveTag { on: about, key: (*key).into() }).collect();
    for (side, key) in SIGNALS.into_iter().enumerate() {
        let ids: Vec<&str> = old.iter().filter(|one| one.1 == side).map(|one| one.0).collect();
        if !ids.is_empty() && !tags.has(key) {
            edits.push(Edit::SetTag { on: about, key: key.into(), value: ids.join(",").into() });
        }
    }
    Some(Finding::new("old-tag", about, message).fixed_by("list the exits", false, edits))
}
