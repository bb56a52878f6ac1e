//! Which findings follow from another one: a point in the wrong place spoils every lanelet that uses it.

use std::cell::OnceCell;
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
    spoils: fn(&mut Lanelets, &Diagnostic) -> BTreeSet<Subject>,
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

/// Which lanelets have something in common; each is gathered when it is first asked for.
struct Lanelets<'m> {
    map: &'m LaneletMap,
    by_point: OnceCell<FxHashMap<PointId, Vec<LaneletId>>>,
    by_element: OnceCell<FxHashMap<RegulatoryElementId, Vec<LaneletId>>>,
    /// Those of subtypes of which no finding has told yet.
    by_subtype: Option<FxHashMap<String, Vec<LaneletId>>>,
}

impl<'m> Lanelets<'m> {
    fn of(map: &'m LaneletMap) -> Self {
        Self { map, by_point: OnceCell::new(), by_element: OnceCell::new(), by_subtype: None }
    }

    /// The lanelets that have a point in a bound.
    fn at(&self, point: PointId) -> &[LaneletId] {
        let by_point = self.by_point.get_or_init(|| {
            let mut by_point: FxHashMap<PointId, Vec<LaneletId>> = FxHashMap::default();
            for lanelet in &self.map.lanelets {
                for bound in [lanelet.left, lanelet.right] {
                    for point in self.map.bound_points(bound) {
                        by_point.entry(point.id).or_default().push(lanelet.id);
                    }
                }
            }
            by_point
        });
        by_point.get(&point).map_or(&[], Vec::as_slice)
    }

    /// The lanelets that refer to an element.
    fn referring_to(&self, element: RegulatoryElementId) -> &[LaneletId] {
        let by_element = self.by_element.get_or_init(|| {
            let mut by_element: FxHashMap<RegulatoryElementId, Vec<LaneletId>> = FxHashMap::default();
            for lanelet in &self.map.lanelets {
                lanelet.regulatory_elements.iter().for_each(|id| by_element.entry(*id).or_default().push(lanelet.id));
            }
            by_element
        });
        by_element.get(&element).map_or(&[], Vec::as_slice)
    }

    /// The lanelets of a subtype the first time that it is asked for, then none: what follows from the first finding follows from no
    /// later one.
    fn take_of_subtype(&mut self, subtype: &str) -> Vec<LaneletId> {
        let map = self.map;
        let by_subtype = self.by_subtype.get_or_insert_with(|| {
            let mut by_subtype: FxHashMap<String, Vec<LaneletId>> = FxHashMap::default();
            for lanelet in &map.lanelets {
                let subtype = lanelet.attributes.get("subtype").unwrap_or_default();
                by_subtype.entry(subtype.to_owned()).or_default().push(lanelet.id);
            }
            by_subtype
        });
        by_subtype.remove(subtype).unwrap_or_default()
    }
}

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
        let mut lanelets = Lanelets::of(map);
        for (at, one) in found.iter().enumerate() {
            for cause in CAUSES.iter().filter(|cause| cause.code == one.code) {
                for subject in (cause.spoils)(&mut lanelets, one) {
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
fn around_elements(lanelets: &mut Lanelets, found: &Diagnostic) -> BTreeSet<Subject> {
    let others = found.finding.related.iter().map(|related| related.subject);
    let named = others.chain([found.finding.subject]).filter_map(|subject| match subject {
        Subject::RegulatoryElement(id) => Some(RegulatoryElementId(id)),
        _ => None,
    });
    let elements: BTreeSet<RegulatoryElementId> = named.collect();
    let referring = elements.iter().flat_map(|&id| lanelets.referring_to(id)).map(|id| Subject::Lanelet(id.0));
    let members = elements.iter().filter_map(|&id| lanelets.map.regulatory_elements.get(id));
    let members = members.flat_map(|one| &one.members);
    let line = |member: &Member| match member.target {
        Target::LineString(id) => Some(Subject::LineString(id.0)),
        _ => None,
    };
    let own = elements.iter().map(|id| Subject::RegulatoryElement(id.0));
    own.chain(referring).chain(members.filter_map(line)).collect()
}

/// What touches a way that is both bounds of a lanelet.
fn beside_one_bound(lanelets: &mut Lanelets, found: &Diagnostic) -> BTreeSet<Subject> {
    let map = lanelets.map;
    let lanelet = found.finding.subject.id().and_then(|id| map.lanelets.get(LaneletId(id)));
    let both = lanelet.filter(|lanelet| lanelet.left.line == lanelet.right.line);
    both.map(|lanelet| touching(lanelets, &points_of(map, Subject::LineString(lanelet.left.line.0))))
        .unwrap_or_default()
}

/// What touches the bound of no length that a finding is about.
fn at_the_point(lanelets: &mut Lanelets, found: &Diagnostic) -> BTreeSet<Subject> {
    touching(lanelets, &points_of(lanelets.map, found.finding.subject))
}

/// Points, and the lanelets that have one of them in a bound.
fn touching(lanelets: &Lanelets, points: &[PointId]) -> BTreeSet<Subject> {
    let at_points = points.iter().flat_map(|&point| lanelets.at(point)).map(|id| Subject::Lanelet(id.0));
    points.iter().map(|point| Subject::Point(point.0)).chain(at_points).collect()
}

/// The lanelets with the subtype of the one of which a finding says that its subtype is wrong.
fn of_this_subtype(lanelets: &mut Lanelets, found: &Diagnostic) -> BTreeSet<Subject> {
    let is_about_subtype = found.code == "access/not-road" || found.finding.message.starts_with("subtype=");
    let Subject::Lanelet(id) = found.finding.subject else { return BTreeSet::new() };
    let subtype = |lanelet: &Lanelet| lanelet.attributes.get("subtype").unwrap_or_default().to_owned();
    let Some(own) = lanelets.map.lanelets.get(LaneletId(id)).map(subtype).filter(|_| is_about_subtype) else {
        return BTreeSet::new();
    };
    lanelets.take_of_subtype(&own).into_iter().map(|id| Subject::Lanelet(id.0)).collect()
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
