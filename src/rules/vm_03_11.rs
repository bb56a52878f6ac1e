//! vm-03-11: where no signal rules, a lanelet lists those who give way to it.

use crate::diagnostic::{Finding, Subject};
use crate::lanelet::index::{Intersection, MapIndex, Rank, Traffic};
use crate::lanelet::right_of_way::{Relation, Turn};

use super::NoParams;
use super::right_of_way_element::{Judged, joins_first_by_element, ruled_by_signal, wiring};
use super::virtual_light::is_coordinated;

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    // Virtual lights have a requirement of their own.
    let unruled = |id| !ruled_by_signal(map, id) && !is_coordinated(map, id);
    let mut findings = wiring(map, unruled);
    for judged in Judged::all(map, |traffic, x| unruled(map.lanes[traffic.movements[x].lane].id)) {
        findings.extend(judged.multi_re());
        findings.extend(re_missing(&judged));
        findings.extend(yield_missing(&judged));
        findings.extend(judged.ignored.iter().filter_map(|&y| wrongly_ignored(&judged, y)));
        findings.extend(judged.needless());
    }
    let all = map.intersections.iter().zip(&map.traffic);
    findings.extend(all.filter_map(|(intersection, traffic)| priority_unknown(map, intersection, traffic)));
    findings
}

/// `priority` or `minor`, as far as it is known.
fn rank(judged: &Judged) -> &'static str {
    match judged.traffic.movements[judged.x].ranked.priority {
        Some(true) => "Priority",
        Some(false) => "Minor",
        None => "Equal-rank",
    }
}

fn re_missing(judged: &Judged) -> Option<Finding> {
    let ids: Vec<String> = judged.due.iter().map(|&y| judged.map.lanes[y].id.to_string()).collect();
    let (rank, ids) = (rank(judged), ids.join(", "));
    judged.re_missing(format!(
        "{rank} lanelet {} lacks a right_of_way that yields {ids}; ego will wait without need.",
        judged.id
    ))
}

fn yield_missing(judged: &Judged) -> Vec<Finding> {
    let findings = judged.missing().map(|y| {
        let other = judged.map.lanes[y].id;
        let message = format!(
            "{} lanelet {} lacks {other} in right_of_way; ego will wait without need.",
            rank(judged),
            judged.id
        );
        judged.with_yield(judged.about("yield-missing", y, message), y)
    });
    findings.collect()
}

/// A lane that the lanelet may ignore although both then ignore each other, or although that lane goes first.
fn wrongly_ignored(judged: &Judged, y: usize) -> Option<Finding> {
    let Judged { map, traffic, x, .. } = *judged;
    let at = traffic.of_lane(y)?;
    let (me, other) = (traffic.movements[x].ranked, traffic.movements[at].ranked);
    let relation = traffic.relation(x, at);
    let (due, mutual) = (judged.due.contains(&y), mutual(judged, y));
    if !judged.conflict(y)?.real || relation == Relation::Same || (due && !mutual) {
        return None;
    }
    let name = map.lanes[y].id;
    let (fault, message) = if mutual {
        // The finding is about the lanelet that has to give way; about the later one if both are equal.
        let theirs = traffic.yields(map, at).iter().any(|&z| traffic.movements[z].lane == judged.lane);
        let lower = !due && (theirs || at < x);
        if !lower {
            return None;
        }
        ("mutual", format!("{} and {name} each ignore the other and no signal separates them.", judged.id))
    } else if me.priority == Some(false) && other.priority == Some(true) {
        ("priority-inverted", format!("Minor-road lanelet {} ignores priority lanelet {name}.", judged.id))
    } else if me.priority == other.priority
        && match relation {
            Relation::InPhase => {
                me.turn == Turn::Far && other.turn != Turn::Far && !joins_first_by_element(map, traffic, x, at)
            }
            _ => traffic.rank != Rank::Unknown,
        }
    {
        ("yield-unsafe", format!("{} is told to ignore {name}, which does not give way to it.", judged.id))
    } else {
        return None;
    };
    let finding = judged.about(fault, y, message);
    let title = format!("take {name} out of the element");
    Some(finding.fixed_by(title, !judged.shares_elements(), judged.drop_yield(y)))
}

/// Whether both ignore each other, and no signal rules either.
fn mutual(judged: &Judged, y: usize) -> bool {
    let other = judged.map.lanes[y].id;
    let signal = ruled_by_signal(judged.map, other) || is_coordinated(judged.map, other);
    !signal && judged.map.ignored(y).binary_search(&judged.lane).is_ok()
}

/// Lanes from crossing approaches meet, and nothing tells who goes first.
fn priority_unknown(map: &MapIndex, intersection: &Intersection, traffic: &Traffic) -> Option<Finding> {
    if traffic.signalised || traffic.rank != Rank::Unknown {
        return None;
    }
    // A virtual light asks for no rank.
    let ranked = |x: &usize| !is_coordinated(map, map.lanes[traffic.movements[*x].lane].id);
    let crossing = (0..traffic.movements.len()).filter(ranked).any(|x| {
        let mut others = map.conflicts[traffic.movements[x].lane].iter().filter(|conflict| conflict.real);
        others.any(|conflict| {
            traffic.of_lane(conflict.other).is_some_and(|y| traffic.relation(x, y) == Relation::AntiPhase)
        })
    });
    let area = intersection.area.filter(|_| crossing)?;
    let message = format!("Priority road of intersection {area} is unknown; equal rank assumed.");
    Some(Finding::new("priority-unknown", Subject::Polygon(area.0), message))
}
