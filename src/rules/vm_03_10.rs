//! vm-03-10: where signals rule, a turning lanelet lists those whom it need not watch.

use crate::diagnostic::{Edit, Finding, Severity, Subject};
use crate::lanelet::index::{MapIndex, Traffic};
use crate::lanelet::right_of_way::{Relation, Turn};

use super::NoParams;
use super::right_of_way_element::{Judged, ruled_by_signal, wiring};
use super::virtual_light::is_coordinated;

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    // Virtual lights have a requirement of their own.
    let mut findings = wiring(map, |id| ruled_by_signal(map, id) && !is_coordinated(map, id));
    let wanted = |traffic: &Traffic, x: usize| {
        let movement = &traffic.movements[x];
        movement.ranked.signalised && !is_coordinated(map, map.lanes[movement.lane].id)
    };
    for judged in Judged::all(map, wanted) {
        findings.extend(judged.multi_re());
        if judged.traffic.movements[judged.x].ranked.turn == Turn::Straight {
            findings.extend(straight_re(&judged));
            continue;
        }
        findings.extend(re_missing(&judged));
        findings.extend(yield_missing(&judged));
        findings.extend(yield_unsafe(&judged));
        findings.extend(judged.needless());
    }
    findings
}

/// Autoware watches nobody for a straight lanelet with a light.
fn straight_re(judged: &Judged) -> Option<Finding> {
    let element = judged.map.elements(judged.id, "right_of_way").next()?;
    let message =
        format!("right_of_way {} of straight lanelet {} is not used: a signal rules it.", element.id, judged.id);
    let subject = Subject::RegulatoryElement(element.id.0);
    let edits = vec![Edit::RemoveMember { on: judged.subject(), role: "regulatory_element".into(), member: subject }];
    let finding = Finding::new("straight-re", subject, message).with(judged.subject(), "straight lanelet");
    Some(finding.fixed_by(format!("let lanelet {} no longer refer to it", judged.id), false, edits))
}

fn re_missing(judged: &Judged) -> Option<Finding> {
    let ids: Vec<String> = judged.due.iter().map(|&y| judged.map.lanes[y].id.to_string()).collect();
    judged.re_missing(format!(
        "Turning lanelet {} has a signal but no right_of_way; Autoware will wait for {}.",
        judged.id,
        ids.join(", ")
    ))
}

fn yield_missing(judged: &Judged) -> Vec<Finding> {
    let findings = judged.missing().map(|y| {
        let at = judged.traffic.of_lane(y);
        let other_phase = at.is_some_and(|at| judged.traffic.relation(judged.x, at) == Relation::AntiPhase);
        let (reason, severity) = match other_phase {
            true => ("other phase", Severity::Error),
            // Maps in use leave it out; the vehicle then waits for those who wait for it.
            false => ("opposing far turn", Severity::Warning),
        };
        let element = judged.elements.first().map_or(String::new(), |element| element.id.to_string());
        let other = judged.map.lanes[y].id;
        let message = format!("right_of_way {element} of {} should yield {other} ({reason}).", judged.id);
        judged.with_yield(judged.about("yield-missing", y, message).graded(severity), y)
    });
    findings.collect()
}

/// Oncoming traffic that is green together with a far turn goes first; the turn must not be told to ignore it.
fn yield_unsafe(judged: &Judged) -> Vec<Finding> {
    let me = judged.traffic.movements[judged.x].ranked;
    let mut findings = Vec::new();
    for &y in &judged.ignored {
        let Some(at) = judged.traffic.of_lane(y) else { continue };
        let together = judged.traffic.relation(judged.x, at) == Relation::InPhase;
        let first = judged.traffic.movements[at].ranked.turn != Turn::Far;
        if me.turn != Turn::Far || !together || !first || !judged.conflict(y).is_some_and(|conflict| conflict.real) {
            continue;
        }
        let other = judged.map.lanes[y].id;
        let message = format!("{} is told to ignore {other}, which has priority over it.", judged.id);
        let finding = judged.about("yield-unsafe", y, message);
        findings.push(finding.fixed_by(
            format!("take {other} out of the element"),
            !judged.shares_elements(),
            judged.drop_yield(y),
        ));
    }
    findings
}
