//! Right of way as the existing validator judges it (vm-03-10, 11, 17): by overlaps of lanelets, and by the directions in
//! which lights hang.

use std::collections::BTreeSet;

use rustc_hash::FxHashSet;

use super::{Issue, Params, issue};
use crate::diagnostic::Subject;
use crate::lanelet::index::routing_graph::{Graph, Rules};
use crate::lanelet::index::tier4_yields::{Overlaps, Ruled};
use crate::lanelet::index::view::{Seen, View};
use crate::lanelet::{LaneletId, RegulatoryElement};

/// A lanelet, the one element judged with it, and what is asked of it.
struct Case<'a, 'm> {
    view: &'a View<'m>,
    graph: &'a Graph<'a, 'm>,
    at: usize,
    seen: &'a Seen<'m>,
}

impl<'a, 'm> Case<'a, 'm> {
    fn all(view: &'a View<'m>, graph: &'a Graph<'a, 'm>) -> impl Iterator<Item = Self> + use<'a, 'm> {
        view.lanelets.iter().enumerate().map(move |(at, seen)| Self { view, graph, at, seen })
    }

    fn id(&self) -> LaneletId {
        self.seen.id()
    }

    fn has(&self, subtype: &str) -> bool {
        self.view.elements_of(self.seen, subtype).next().is_some()
    }

    fn elements(&self) -> Vec<&'m RegulatoryElement> {
        self.view.elements_of(self.seen, "right_of_way").collect()
    }

    fn overlaps(&self, ruled: Ruled) -> Overlaps {
        Overlaps::new(self.view, self.graph, self.at, ruled)
    }

    fn ids(&self, lanelets: &[usize]) -> BTreeSet<LaneletId> {
        lanelets.iter().map(|&at| self.view.lanelets[at].id()).collect()
    }

    /// The faults of an element that serves this lanelet alone. Overlaps that are too small to count have the first of these
    /// numbers; lanelets that are expected but not listed, or listed but not expected, have the others.
    fn judge(&self, element: &RegulatoryElement, ruled: Ruled, [sliver, missing, needless]: [u16; 3]) -> Vec<Issue> {
        let Overlaps { wanted, slivers } = self.overlaps(ruled);
        let mut issues: Vec<Issue> = slivers.into_iter().map(|other| self.sliver(element, sliver, other)).collect();
        issues.extend(self.compare(element, &self.ids(&wanted), [missing, needless]));
        issues
    }

    fn turn(&self) -> Option<&'m str> {
        self.seen.tag("turn_direction")
    }

    /// Issues of one number for what is expected but not listed, of another for what is listed but not expected.
    fn compare(&self, element: &RegulatoryElement, expected: &BTreeSet<LaneletId>, numbers: [u16; 2]) -> Vec<Issue> {
        let listed: BTreeSet<LaneletId> = element.lanelets("yield").collect();
        let (id, own) = (element.id, self.id());
        let about = |number, message| issue(number, Subject::RegulatoryElement(id.0), message);
        let missing = expected.difference(&listed).map(|other| {
            about(numbers[0], format!("right_of_way {id} of lanelet {own} does not list lanelet {other} as yield."))
        });
        let needless = listed.difference(expected).map(|other| {
            about(
                numbers[1],
                format!("right_of_way {id} of lanelet {own} lists lanelet {other} as yield without need."),
            )
        });
        missing.chain(needless).collect()
    }

    fn sliver(&self, element: &RegulatoryElement, number: u16, other: usize) -> Issue {
        let (id, own, other) = (element.id, self.id(), self.view.lanelets[other].id());
        let message = format!("Lanelets {own} and {other} overlap so little that right_of_way {id} need not list it.");
        issue(number, Subject::RegulatoryElement(id.0), message)
    }
}

/// `right_of_way_with_traffic_lights`: of lanelets that turn and have a light of their own.
pub fn with_traffic_lights(view: &View, _: &Params) -> Vec<Issue> {
    let graph = Graph::new(view, Rules::Car);
    let turning = Case::all(view, &graph)
        .filter(|case| matches!(case.turn(), Some("left" | "right")) && case.has("traffic_light"));
    turning.flat_map(|case| signalised(&case)).collect()
}

fn signalised(case: &Case) -> Vec<Issue> {
    let id = case.id();
    let elements = case.elements();
    let element = match elements[..] {
        [] => return vec![issue(1, Subject::Lanelet(id.0), format!("Lanelet {id} has no right_of_way element."))],
        [element] => element,
        // The tool calls the lanelet's id that of a regulatory element; exclusion lists of its users say the same.
        _ => {
            let message = format!("Lanelet {id} has {} right_of_way elements.", elements.len());
            return vec![issue(2, Subject::RegulatoryElement(id.0), message)];
        }
    };
    if !element.lanelets("right_of_way").any(|own| own == id) {
        let message = format!("right_of_way {} does not list its lanelet {id} as right_of_way.", element.id);
        return vec![issue(3, Subject::RegulatoryElement(element.id.0), message)];
    }
    case.judge(element, Ruled::ByLight, [6, 4, 5])
}

/// `right_of_way_without_traffic_lights`.
pub fn without_traffic_lights(view: &View, _: &Params) -> Vec<Issue> {
    let graph = Graph::new(view, Rules::Car);
    let concerned: Vec<Case> = Case::all(view, &graph)
        .filter(|case| case.turn().is_some() || case.seen.tag("intersection_area").is_some())
        .collect();
    let unruled = concerned.iter().filter(|case| !case.has("traffic_light") && !case.has("virtual_traffic_light"));
    let mut issues: Vec<Issue> = unruled
        .flat_map(|case| case.elements().into_iter().flat_map(move |element| unsignalised(case, element)))
        .collect();
    issues.extend(areas_without(&concerned));
    issues
}

fn unsignalised(case: &Case, element: &RegulatoryElement) -> Vec<Issue> {
    let (id, subject) = (element.id, Subject::RegulatoryElement(element.id.0));
    let own: Vec<LaneletId> = element.lanelets("right_of_way").collect();
    if own.len() != 1 {
        return vec![issue(1, subject, format!("right_of_way {id} lists {} lanelets as right_of_way.", own.len()))];
    }
    if own[0] != case.id() {
        let message = format!("right_of_way {id} lists lanelet {} instead of its lanelet {}.", own[0], case.id());
        return vec![issue(2, subject, message)];
    }
    case.judge(element, Ruled::ByNothing, [6, 3, 4])
}

/// Areas of which no lanelet has a right of way, lights or not.
fn areas_without(concerned: &[Case]) -> Vec<Issue> {
    let of = |case: &Case| case.seen.area_tag();
    let served: FxHashSet<i64> = concerned.iter().filter(|case| case.has("right_of_way")).filter_map(of).collect();
    let areas: BTreeSet<i64> = concerned.iter().filter_map(of).collect();
    let without = areas.into_iter().filter(|area| !served.contains(area));
    without
        .map(|area| {
            let message = format!("No lanelet of intersection_area {area} has a right_of_way element.");
            issue(5, Subject::Polygon(area), message)
        })
        .collect()
}

/// `right_of_way_for_virtual_traffic_lights`: whatever overlaps has to be listed, siblings too.
pub fn for_virtual_traffic_lights(view: &View, _: &Params) -> Vec<Issue> {
    let graph = Graph::new(view, Rules::Car);
    let ruled = Case::all(view, &graph).filter(|case| case.has("virtual_traffic_light"));
    ruled.flat_map(|case| coordinated(&case)).collect()
}

fn coordinated(case: &Case) -> Vec<Issue> {
    let lanelet = case.id();
    let elements = case.elements();
    let [element] = elements[..] else {
        let (number, message) = match elements.len() {
            0 => (1, format!("Lanelet {lanelet} has a virtual traffic light but no right_of_way element.")),
            count => (2, format!("Lanelet {lanelet} has {count} right_of_way elements.")),
        };
        return vec![issue(number, Subject::Lanelet(lanelet.0), message)];
    };
    let (id, subject) = (element.id, Subject::RegulatoryElement(element.id.0));
    let own: Vec<LaneletId> = element.lanelets("right_of_way").collect();
    if own.len() != 1 {
        return vec![issue(3, subject, format!("right_of_way {id} lists {} lanelets as right_of_way.", own.len()))];
    }
    if own[0] != lanelet {
        let message = format!("right_of_way {id} lists lanelet {} instead of its lanelet {lanelet}.", own[0]);
        return vec![issue(4, subject, message)];
    }
    case.judge(element, Ruled::Virtually, [7, 5, 6])
}
