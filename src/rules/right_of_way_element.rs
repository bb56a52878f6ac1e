//! What vm-03-10 and vm-03-11 have in common: how a `right_of_way` element is wired, and whom it lists.

use rustc_hash::FxHashSet;

use crate::diagnostic::{Edit, Finding, Place, Severity, Subject};
use crate::lanelet::index::{Conflict, MapIndex, Rank, Traffic};
use crate::lanelet::right_of_way::{Relation, Turn};
use crate::lanelet::{Condition, ElementKind, Lanelet, LaneletId, RegulatoryElement, RegulatoryElementId};

/// One movement with the elements that speak of it.
pub struct Judged<'m> {
    /// The map.
    pub map: &'m MapIndex<'m>,
    /// The traffic of its intersection.
    pub traffic: &'m Traffic,
    /// The movement, by its position.
    pub x: usize,
    /// Its lanelet, by its position.
    pub lane: usize,
    /// Id of its lanelet.
    pub id: LaneletId,
    /// The elements that have an effect on it.
    pub elements: Vec<&'m RegulatoryElement>,
    /// The lanes that these list, by position, sorted.
    pub ignored: Vec<usize>,
    /// The lanes that they should list, in order.
    pub due: Vec<usize>,
    /// Those of them that the map tells for certain: only these are written.
    pub sure: Vec<usize>,
    /// Whether an element lists it, even if it does not refer to that element.
    pub listed: bool,
}

impl<'m> Judged<'m> {
    /// All movements that `wanted` takes.
    pub fn all(map: &'m MapIndex<'m>, wanted: impl Fn(&Traffic, usize) -> bool) -> Vec<Self> {
        let mut all = Vec::new();
        let elements = map.map.regulatory_elements.iter().filter(|element| element.subtype == "right_of_way");
        let listed: FxHashSet<LaneletId> = elements.flat_map(|element| element.lanelets("right_of_way")).collect();
        for (at, traffic) in map.traffic.iter().enumerate() {
            for (x, movement) in traffic.movements.iter().enumerate() {
                // A lane of two areas is judged with the first.
                let first = map
                    .intersections_of(movement.lane)
                    .iter()
                    .find(|&&i| map.traffic[i].of_lane(movement.lane).is_some());
                if first != Some(&at) || !map.lanes[movement.lane].vehicle || !wanted(traffic, x) {
                    continue;
                }
                let lane = movement.lane;
                // A lanelet without turn_direction has a finding of its own; it is judged once that is mended.
                let tagged = |lane: &usize| map.turn_direction(*lane).is_some();
                let waits = |y: &usize| !joins_first_by_element(map, traffic, *y, x);
                let due = traffic.yields(map, x).into_iter().filter(waits).map(|y| traffic.movements[y].lane);
                let due: Vec<usize> = due.filter(tagged).collect();
                let is_sure = |y: &usize| traffic.of_lane(*y).is_some_and(|y| is_sure(map, traffic, x, y));
                all.push(Self {
                    map,
                    traffic,
                    x,
                    lane,
                    id: map.lanes[lane].id,
                    elements: map.rights_of_way(lane),
                    ignored: map.ignored(lane),
                    sure: due.iter().copied().filter(is_sure).collect(),
                    due,
                    listed: listed.contains(&map.lanes[lane].id),
                });
            }
        }
        all
    }

    /// The lanelet in findings.
    pub fn subject(&self) -> Subject {
        Subject::Lanelet(self.id.0)
    }

    /// Whether the lanelet refers to any `right_of_way` element, be it without effect.
    pub fn has_element(&self) -> bool {
        self.map.elements(self.id, "right_of_way").next().is_some()
    }

    /// The conflict with another lane.
    pub fn conflict(&self, y: usize) -> Option<&Conflict> {
        self.map.conflicts[self.lane].iter().find(|conflict| conflict.other == y)
    }

    /// The edit that makes the element it lacks.
    pub fn create(&self) -> Vec<Edit> {
        let mut members = vec![("right_of_way".into(), self.subject())];
        members.extend(self.sure.iter().map(|&y| ("yield".into(), Subject::Lanelet(self.map.lanes[y].id.0))));
        vec![Edit::CreateRegulatoryElement { subtype: "right_of_way".into(), members, referrers: vec![self.id.0] }]
    }

    /// A finding that speaks of its first element and of another lane, at the place where both overlap.
    pub fn about(&self, fault: &'static str, y: usize, message: impl Into<String>) -> Finding {
        let subject = self.elements.first().map_or(self.subject(), |element| Subject::RegulatoryElement(element.id.0));
        let other = Subject::Lanelet(self.map.lanes[y].id.0);
        let finding = Finding::new(fault, subject, message).with(self.subject(), "right of way").with(other, "yield");
        match self.conflict(y) {
            Some(conflict) => finding.at(Place::Point(conflict.place)),
            None => finding,
        }
    }

    /// The edits that take a lane out of its elements.
    pub fn drop_yield(&self, y: usize) -> Vec<Edit> {
        let member = Subject::Lanelet(self.map.lanes[y].id.0);
        let listing =
            self.elements.iter().filter(|element| element.lanelets("yield").any(|id| id.0 == self.map.lanes[y].id.0));
        let edits = listing.map(|element| Edit::RemoveMember {
            on: Subject::RegulatoryElement(element.id.0),
            role: "yield".into(),
            member,
        });
        edits.collect()
    }

    /// Whether the elements serve other lanelets, too: then an edit changes the lot of those as well.
    pub fn shares_elements(&self) -> bool {
        self.elements.iter().any(|element| element.lanelets("right_of_way").count() > 1)
    }

    /// No element where one is due.
    pub fn re_missing(&self, message: String) -> Option<Finding> {
        if self.due.is_empty() || self.has_element() {
            return None;
        }
        let finding = Finding::new("re-missing", self.subject(), message);
        let finding = self
            .due
            .iter()
            .fold(finding, |finding, &y| finding.with(Subject::Lanelet(self.map.lanes[y].id.0), "need not be watched"));
        Some(match (self.listed, self.sure.is_empty()) {
            // It needs no second one.
            (true, _) => finding.advised("Let it refer to the right_of_way element that names it."),
            (false, true) => finding,
            (false, false) => finding.fixed_by("create the right_of_way element", true, self.create()),
        })
    }

    /// Lanes that the elements should list but do not.
    pub fn missing(&self) -> impl Iterator<Item = usize> + '_ {
        let due = self.due.iter().copied().filter(|_| !self.elements.is_empty());
        due.filter(|y| self.ignored.binary_search(y).is_err())
    }

    /// Adds the edit that lists a lane in the first element, if the map tells for certain that the lane waits.
    pub fn with_yield(&self, finding: Finding, y: usize) -> Finding {
        if !self.sure.contains(&y) {
            return finding;
        }
        let title = format!("list {} as yield", self.map.lanes[y].id);
        finding.fixed_by(title, !self.shares_elements(), self.add_yield(y))
    }

    /// The edit that adds a lane to the first element.
    fn add_yield(&self, y: usize) -> Vec<Edit> {
        let member = Subject::Lanelet(self.map.lanes[y].id.0);
        let first = self.elements.first().into_iter();
        let edits = first.map(|element| Edit::AddMember {
            on: Subject::RegulatoryElement(element.id.0),
            role: "yield".into(),
            member,
        });
        edits.collect()
    }

    /// More than one element on the lanelet.
    pub fn multi_re(&self) -> Option<Finding> {
        let all: Vec<i64> = self.map.elements(self.id, "right_of_way").map(|element| element.id.0).collect();
        let [first, .., last] = all[..] else { return None };
        let message =
            format!("Lanelet {} refers to {} right_of_way elements; Autoware unites their yields.", self.id, all.len());
        let finding = Finding::new("multi-re", self.subject(), message);
        let finding = finding.with(Subject::RegulatoryElement(first), "first element");
        let finding = finding.with(Subject::RegulatoryElement(last), "last element");
        Some(self.without_elements_of_others(finding))
    }

    /// Adds the edits that let the lanelet refer to the one element that gives it the right of way, and no longer to those of
    /// others.
    fn without_elements_of_others(&self, finding: Finding) -> Finding {
        let all = self.map.elements(self.id, "right_of_way");
        let (own, others): (Vec<_>, Vec<_>) =
            all.partition(|element| element.lanelets("right_of_way").any(|id| id == self.id));
        if own.len() > 1 && others.is_empty() {
            return self.united(finding, &own);
        }
        if own.len() != 1 || others.is_empty() {
            return finding;
        }
        let on = self.subject();
        let edits = others.iter().map(|element| Edit::RemoveMember {
            on,
            role: "regulatory_element".into(),
            member: Subject::RegulatoryElement(element.id.0),
        });
        finding.fixed_by("no longer refer to the elements that give others the right of way", false, edits.collect())
    }

    /// Adds the edits that put the yields of all elements of the lanelet into the first, as Autoware reads them; the others go
    /// where nobody else has them.
    fn united(&self, finding: Finding, all: &[&RegulatoryElement]) -> Finding {
        let [first, others @ ..] = all else { return finding };
        let (lanelet, into) = (self.subject(), Subject::RegulatoryElement(first.id.0));
        let mut known: FxHashSet<LaneletId> = first.lanelets("yield").collect();
        let mut edits = Vec::new();
        for other in others {
            let fresh = other.lanelets("yield").filter(|&y| known.insert(y));
            edits.extend(fresh.map(|y| Edit::AddMember {
                on: into,
                role: "yield".into(),
                member: Subject::Lanelet(y.0),
            }));
            let on = Subject::RegulatoryElement(other.id.0);
            if self.map.referrers(other.id) == [self.id] {
                edits.push(Edit::Remove { subject: on });
                continue;
            }
            edits.push(Edit::RemoveMember { on: lanelet, role: "regulatory_element".into(), member: on });
            edits.push(Edit::RemoveMember { on, role: "right_of_way".into(), member: lanelet });
        }
        finding.fixed_by(format!("put their yields into {into}"), false, edits)
    }

    /// Listed lanes that do not touch the lanelet.
    pub fn needless(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        for element in &self.elements {
            let subject = Subject::RegulatoryElement(element.id.0);
            let shared = element.lanelets("right_of_way").count() > 1;
            let mut seen = FxHashSet::default();
            for y in element.lanelets("yield").filter(|&y| seen.insert(y)) {
                let Some(other) = self.map.lane(y).filter(|&other| self.conflict(other).is_none()) else { continue };
                let judged = self.map.movement(other).is_some() && self.map.lanes[self.lane].simple;
                if !judged || !self.map.lanes[other].simple || self.map.siblings(self.lane).any(|s| s == other) {
                    continue;
                }
                let message = format!("{y} in right_of_way {} does not touch {}.", element.id, self.id);
                let finding = Finding::new("yield-needless", subject, message)
                    .with(self.subject(), "right of way")
                    .with(Subject::Lanelet(y.0), "yield");
                let touches = |id: LaneletId| {
                    self.map.lane(id).is_some_and(|at| self.map.conflicts[at].iter().any(|one| one.other == other))
                };
                findings.push(if element.lanelets("right_of_way").any(touches) {
                    let touched = element.lanelets("right_of_way").filter(|id| touches(*id));
                    let finding = touched.fold(finding, |all, id| all.with(Subject::Lanelet(id.0), "touches it"));
                    finding.advised("Others of the element touch it: give this lanelet an element of its own.")
                } else if shared {
                    finding
                } else {
                    let edits =
                        vec![Edit::RemoveMember { on: subject, role: "yield".into(), member: Subject::Lanelet(y.0) }];
                    finding.graded(Severity::Warning).fixed_by(format!("take {y} out of the element"), true, edits)
                });
            }
        }
        findings
    }
}

/// Whether an element lets the first of two movements, which turns far, ignore one that turns near into the same lane, and not the other
/// way round, where nothing else tells who goes first: so it is on a ring that is met almost head-on, and where the main road bends.
pub fn joins_first_by_element(map: &MapIndex, traffic: &Traffic, x: usize, y: usize) -> bool {
    let [me, other] = [x, y].map(|at| &traffic.movements[at]);
    let turns = (me.ranked.turn, other.ranked.turn) == (Turn::Far, Turn::Near);
    let joins = map.lanes[me.lane].end.ids == map.lanes[other.lane].end.ids;
    let ignores = |x: usize, y: usize| map.ignored(x).binary_search(&y).is_ok();
    traffic.rank == Rank::Unknown
        && turns
        && joins
        && traffic.relation(x, y) == Relation::InPhase
        && ignores(me.lane, other.lane)
        && !ignores(other.lane, me.lane)
}

/// Whether the map tells that the second of two movements waits for the first. Where nothing tells which road goes first, that is who
/// turns off the road on which the first drives, across it: this road goes straight on to the approach from which the second comes.
/// Else a road with priority may bend there.
fn is_sure(map: &MapIndex, traffic: &Traffic, x: usize, y: usize) -> bool {
    let [me, other] = [x, y].map(|at| &traffic.movements[at]);
    let goes_on = || {
        let mut along = traffic.movements.iter().filter(|one| one.from == me.from && one.to == other.from);
        along.any(|one| one.ranked.turn == Turn::Straight && map.lanes[one.lane].is_for_cars())
    };
    traffic.signalised || traffic.rank != Rank::Unknown || traffic.relation(x, y) == Relation::Same || goes_on()
}

/// How the elements are wired: both sides must speak of each other. `meant` says which lanelets are the rule's.
pub fn wiring(map: &MapIndex, meant: impl Fn(LaneletId) -> bool) -> Vec<Finding> {
    let mut findings = Vec::new();
    // These refer to the element without the role; `tag/role` says so.
    let nameless: FxHashSet<(LaneletId, RegulatoryElementId)> = map
        .faults
        .iter()
        .filter_map(|fault| match (&fault.condition, fault.subject) {
            (Condition::UnreadRole { kind: ElementKind::Relation, id, .. }, Subject::Lanelet(lanelet)) => {
                Some((LaneletId(lanelet), RegulatoryElementId(*id)))
            }
            _ => None,
        })
        .collect();
    // Who has the right of way by these did not load.
    let lost: FxHashSet<Subject> =
        map.faults.iter().filter(|fault| fault.condition.loses("right_of_way")).map(|fault| fault.subject).collect();
    for element in map.map.regulatory_elements.iter().filter(|element| element.subtype == "right_of_way") {
        let subject = Subject::RegulatoryElement(element.id.0);
        let mut seen = FxHashSet::default();
        let own: Vec<LaneletId> = element.lanelets("right_of_way").filter(|&id| seen.insert(id)).collect();
        let meant = |lanelet: &LaneletId| meant(*lanelet);
        for &id in own.iter().filter(|id| meant(id)) {
            let refers = |lanelet: &Lanelet| {
                lanelet.regulatory_elements.contains(&element.id) || nameless.contains(&(lanelet.id, element.id))
            };
            if map.map.lanelets.get(id).is_some_and(|lanelet| !refers(lanelet)) {
                let message = format!(
                    "right_of_way {} has no effect on {id}: the lanelet does not reference the element.",
                    element.id
                );
                let edits = vec![Edit::AddMember {
                    on: Subject::Lanelet(id.0),
                    role: "regulatory_element".into(),
                    member: subject,
                }];
                let finding = Finding::new("not-referenced", subject, message).with(Subject::Lanelet(id.0), "lanelet");
                findings.push(finding.fixed_by(format!("let lanelet {id} refer to it"), true, edits));
            }
        }
        // Lanelet2's own convention lets those who give way refer to the element, too. That does no harm; where those who have the right
        // of way do not, that is told above.
        let lists_others = !own.is_empty() || lost.contains(&subject);
        let gives_way = |id: &LaneletId| lists_others && element.lanelets("yield").any(|other| other == *id);
        let strangers = map.referrers(element.id).iter().filter(|id| !own.contains(id) && !gives_way(id));
        for &id in strangers.filter(|id| meant(id)) {
            let message = format!(
                "right_of_way {} has no effect on {id}: the lanelet is not listed as right_of_way.",
                element.id
            );
            let edits =
                vec![Edit::AddMember { on: subject, role: "right_of_way".into(), member: Subject::Lanelet(id.0) }];
            let finding = Finding::new("self-missing", subject, message).with(Subject::Lanelet(id.0), "lanelet");
            findings.push(finding.fixed_by(format!("list lanelet {id} as right_of_way"), false, edits));
        }
        if own.len() > 1 && own.first().is_some_and(meant) {
            let message =
                format!("right_of_way {} serves {} lanelets; one element each is clearer.", element.id, own.len());
            let finding = Finding::new("shared-re", subject, message);
            findings.push(own.iter().fold(finding, |finding, id| finding.with(Subject::Lanelet(id.0), "right of way")));
        }
    }
    findings
}

/// Whether a signal rules a lanelet, or is meant to. vm-03-04 judges lights without a stop line, and lights that only the lane
/// before, or others with the same start, refer to.
pub fn ruled_by_signal(map: &MapIndex, lanelet: LaneletId) -> bool {
    let has_light = |id: LaneletId| map.elements(id, "traffic_light").next().is_some();
    let near = |lane: usize| {
        let mut others = map.siblings(lane).chain(map.predecessors(lane).iter().copied());
        others.any(|other| has_light(map.lanes[other].id))
    };
    has_light(lanelet) || map.lane(lanelet).is_some_and(near)
}
