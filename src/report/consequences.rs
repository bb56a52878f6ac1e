//! Which findings follow from another one: a point in the wrong place spoils every lanelet that uses it.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use super::split_code;
use crate::diagnostic::{Diagnostic, Subject};
use crate::lanelet::{
    Lanelet, LaneletId, LaneletMap, LineStringId, Member, PointId, PolygonId, RegulatoryElementId, Target,
};

/// What says that a point lies in the wrong place.
const MISPLACED: &str = "node/coordinate";
/// Rules whose findings follow from no place.
const OF_THEIR_OWN: [&str; 3] = ["projector", "ids", "node"];

/// A kind of finding that others follow from.
struct Cause {
    code: &'static str,
    /// What may follow from it, where it is about something that is spoilt.
    effects: &'static [&'static str],
    /// What a finding of this code spoils.
    spoils: fn(&LaneletMap, &Diagnostic) -> BTreeSet<Subject>,
}

const CAUSES: [Cause; 6] = [
    // Lanelets that refer to the light of another approach lie far from its stop line.
    Cause {
        code: "vm-04-02/exchanged",
        effects: &["vm-02-04/off-lane", "vm-03-09/start-misaligned", "vm-04-02/directions", "vm-04-02/both-ways"],
        spoils: around_elements,
    },
    // A lanelet between one way and itself, or with a bound of no length, leads nowhere.
    Cause { code: "vm-01-05/shared-point", effects: LOOSE_ENDS, spoils: beside_one_bound },
    Cause { code: "parts/point-bound", effects: LOOSE_ENDS, spoils: at_the_point },
    // What crosses in an intersection crosses outside of all areas as long as it has none.
    Cause {
        code: "vm-03-01/unmarked",
        effects: &["vm-07-08/crossing", "vm-07-08/overlap"],
        spoils: |_, found| found.finding.related.iter().map(|one| one.subject).chain([found.finding.subject]).collect(),
    },
    // A lane of another kind fits no lane around it.
    Cause { code: "tag/value", effects: OTHER_KIND, spoils: of_this_subtype },
    Cause { code: "access/not-road", effects: OTHER_KIND, spoils: of_this_subtype },
];
const LOOSE_ENDS: &[&str] = &[
    "vm-03-04/in-lane-dead-end",
    "vm-03-04/out-lane-unreached",
    "vm-03-04/dangling-il",
    "vm-03-04/near-miss",
    "health/dead-end",
    "health/unreachable",
    "health/near-miss",
];
const OTHER_KIND: &[&str] = &["vm-01-20/neighbours", "vm-01-21/other-kind"];

/// For each finding the one that it follows from in the end, by position.
pub fn causes(found: &[Diagnostic], map: &LaneletMap) -> Vec<Option<usize>> {
    let misplaced = found.iter().enumerate().filter(|(_, one)| one.code == MISPLACED);
    let misplaced: FxHashMap<PointId, usize> =
        misplaced.filter_map(|(at, one)| Some((PointId(one.finding.subject.id()?), at))).collect();
    let by_place = |one: &Diagnostic| {
        let own = misplaced.is_empty() || OF_THEIR_OWN.contains(&split_code(&one.code).0);
        let points = if own { Vec::new() } else { points_of(map, one.finding.subject) };
        points.iter().find_map(|point| misplaced.get(point)).copied()
    };
    let mut spoilt: FxHashMap<(&str, Subject), usize> = FxHashMap::default();
    let is_effect = |code: &str| CAUSES.iter().any(|cause| cause.effects.contains(&code));
    if found.iter().any(|one| is_effect(&one.code)) {
        for (at, one) in found.iter().enumerate() {
            for cause in CAUSES.iter().filter(|cause| cause.code == one.code) {
                for subject in (cause.spoils)(map, one) {
                    cause.effects.iter().for_each(|&effect| _ = spoilt.entry((effect, subject)).or_insert(at));
                }
            }
        }
    }
    let by_kind = |one: &Diagnostic| {
        let others = one.finding.related.iter().map(|related| related.subject);
        let mut about = std::iter::once(one.finding.subject).chain(others);
        about.find_map(|subject| spoilt.get(&(one.code.as_str(), subject)).copied())
    };
    let direct: Vec<Option<usize>> = found.iter().map(|one| by_place(one).or_else(|| by_kind(one))).collect();
    (0..found.len()).map(|at| root(&direct, at)).collect()
}

/// The first cause in a row of causes; `None` for what follows from nothing.
fn root(direct: &[Option<usize>], at: usize) -> Option<usize> {
    let mut cause = direct[at]?;
    // No row is longer than there are kinds of causes.
    for _ in 0..=CAUSES.len() {
        match direct[cause] {
            Some(before) if before != at => cause = before,
            _ => break,
        }
    }
    (cause != at).then_some(cause)
}

/// Elements that a finding names, the lanelets that refer to them, and their members.
fn around_elements(map: &LaneletMap, found: &Diagnostic) -> BTreeSet<Subject> {
    let others = found.finding.related.iter().map(|related| related.subject);
    let named = others.chain([found.finding.subject]).filter_map(|subject| match subject {
        Subject::RegulatoryElement(id) => Some(RegulatoryElementId(id)),
        _ => None,
    });
    let elements: BTreeSet<RegulatoryElementId> = named.collect();
    let refers = |lanelet: &&Lanelet| lanelet.regulatory_elements.iter().any(|id| elements.contains(id));
    let lanelets = map.lanelets.iter().filter(refers).map(|lanelet| Subject::Lanelet(lanelet.id.0));
    let members = elements.iter().filter_map(|&id| map.regulatory_elements.get(id)).flat_map(|one| &one.members);
    let line = |member: &Member| match member.target {
        Target::LineString(id) => Some(Subject::LineString(id.0)),
        _ => None,
    };
    let own = elements.iter().map(|id| Subject::RegulatoryElement(id.0));
    own.chain(lanelets).chain(members.filter_map(line)).collect()
}

/// What touches a way that is both bounds of a lanelet.
fn beside_one_bound(map: &LaneletMap, found: &Diagnostic) -> BTreeSet<Subject> {
    let lanelet = found.finding.subject.id().and_then(|id| map.lanelets.get(LaneletId(id)));
    let both = lanelet.filter(|lanelet| lanelet.left.line == lanelet.right.line);
    both.map(|lanelet| touching(map, &points_of(map, Subject::LineString(lanelet.left.line.0)))).unwrap_or_default()
}

/// What touches the bound of no length that a finding is about.
fn at_the_point(map: &LaneletMap, found: &Diagnostic) -> BTreeSet<Subject> {
    touching(map, &points_of(map, found.finding.subject))
}

/// Points, and the lanelets that have one of them in a bound.
fn touching(map: &LaneletMap, points: &[PointId]) -> BTreeSet<Subject> {
    let touches = |lanelet: &&Lanelet| {
        let mut own = [lanelet.left, lanelet.right].into_iter().flat_map(|bound| map.bound_points(bound));
        own.any(|point| points.contains(&point.id))
    };
    let lanelets = map.lanelets.iter().filter(touches).map(|lanelet| Subject::Lanelet(lanelet.id.0));
    points.iter().map(|point| Subject::Point(point.0)).chain(lanelets).collect()
}

/// The lanelets with the subtype of the one of which a finding says that its subtype is wrong.
fn of_this_subtype(map: &LaneletMap, found: &Diagnostic) -> BTreeSet<Subject> {
    let is_about_subtype = found.code == "access/not-road" || found.finding.message.starts_with("subtype=");
    let Subject::Lanelet(id) = found.finding.subject else { return BTreeSet::new() };
    let subtype = |lanelet: &Lanelet| lanelet.attributes.get("subtype").unwrap_or_default().to_owned();
    let Some(own) = map.lanelets.get(LaneletId(id)).map(subtype).filter(|_| is_about_subtype) else {
        return BTreeSet::new();
    };
    map.lanelets.iter().filter(|other| subtype(other) == own).map(|other| Subject::Lanelet(other.id.0)).collect()
}

/// The points that a primitive is made of.
fn points_of(map: &LaneletMap, subject: Subject) -> Vec<PointId> {
    let line = |id: LineStringId| map.linestrings.get(id).map_or(&[][..], |line| &line.points);
    match subject {
        Subject::Point(id) => vec![PointId(id)],
        Subject::LineString(id) => line(LineStringId(id)).to_vec(),
        Subject::Polygon(id) => map.polygons.get(PolygonId(id)).map(|ring| ring.points.clone()).unwrap_or_default(),
        Subject::Lanelet(id) => {
            let lanelet = map.lanelets.get(LaneletId(id));
            let bounds = lanelet.into_iter().flat_map(|lanelet| [lanelet.left.line, lanelet.right.line]);
            bounds.flat_map(line).copied().collect()
        }
        _ => Vec::new(),
    }
}
