//! load: what Autoware's loader rejects or changes.

use rayon::prelude::*;
use rustc_hash::FxHashSet;

use crate::diagnostic::{Edit, Finding, Place, Severity, Subject, nearest};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{
    BoundRole, Condition, ElementKind, LaneletId, LineStringId, LoadFault, RegulatoryElementId, RingFault, RoleLimit,
    SUPPORTED_FORMAT_VERSION, known_subtypes,
};

use super::disordered_bound::with_points_in_order;
use super::lost_members::LostMembers;
use super::{NoParams, bound_count};
use crate::lanelet::placed::aligned_once;
use crate::parallel::InSmallParts;
use crate::text::{counted, misspelt};

/// What the loader makes something of.
const RELATION_TYPES: [&str; 3] = ["lanelet", "multipolygon", "regulatory_element"];

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let lost = LostMembers::of(map);
    // What is wrong with several elements taken for one says nothing of any of them: their ids come first.
    let shared = with_shared_ids(map);
    let findings = map.faults.iter().filter_map(|fault| {
        let mut finding = finding(map, fault)?.standing_at(fault.span.clone());
        finding.fix = finding.fix.filter(|_| !shared.contains(&fault.subject));
        let is_empty = matches!(fault.condition, Condition::WithoutMembers { .. });
        let may_be_found =
            is_empty || matches!(fault.condition, Condition::MemberCount { .. } | Condition::SignWithoutType { .. });
        let finding = if may_be_found { lost.found_again(finding) } else { finding };
        if !is_empty || finding.fix.is_some() || shared.contains(&fault.subject) {
            return Some(finding);
        }
        let edits = vec![Edit::Remove { subject: fault.subject }];
        Some(finding.fixed_by("remove the element, which says nothing", true, edits))
    });
    findings.chain(reversed(map)).chain(turned_by_heights(map)).collect()
}

/// Lanelets that run against the point order of both bounds. Many valid maps have some, so there is one finding for all of
/// them. Two lanelets that share both ways in opposite directions do not count: one of them has to.
fn reversed(map: &MapIndex) -> Option<Finding> {
    let ways: FxHashSet<[LineStringId; 2]> =
        map.map.lanelets.iter().map(|lanelet| [lanelet.left.line, lanelet.right.line]).collect();
    let stacked = |subject: Subject| {
        let lanelet = subject.id().and_then(|id| map.map.lanelets.get(LaneletId(id)));
        lanelet.is_some_and(|lanelet| ways.contains(&[lanelet.right.line, lanelet.left.line]))
    };
    let turned =
        |fault: &&LoadFault| matches!(fault.condition, Condition::BothBoundsTurned { .. }) && !stacked(fault.subject);
    let lanelets: Vec<Subject> = map.faults.iter().filter(turned).map(|fault| fault.subject).collect();
    let &first = lanelets.first()?;
    let message = format!(
        "{} of {} lanelets run against the points of both their bounds, {first} the first.",
        lanelets.len(),
        map.map.lanelets.len()
    );
    Some(Finding::new("reversed", Subject::Map, message).with(first, "first"))
}

/// The elements whose id others of their kind have, too.
pub(super) fn with_shared_ids(map: &MapIndex) -> FxHashSet<Subject> {
    let is_shared = |fault: &&LoadFault| matches!(fault.condition, Condition::DuplicateId { .. });
    map.faults.iter().filter(is_shared).map(|fault| fault.subject).collect()
}

/// Findings, by subject and message, that the loader itself does not report.
pub(super) fn unsaid(map: &MapIndex) -> FxHashSet<(Subject, String)> {
    let faults = map.faults.iter().filter(|fault| fault.condition.is_unsaid());
    faults.filter_map(|fault| Some((fault.subject, finding(map, fault)?.message))).collect()
}

/// The finding of a fault; `None` for those of other families.
fn finding(map: &MapIndex, fault: &LoadFault) -> Option<Finding> {
    file(map, fault).or_else(|| bounds(map, fault)).or_else(|| element(map, fault))
}

/// What is wrong with the file, and with references in it.
fn file(map: &MapIndex, fault: &LoadFault) -> Option<Finding> {
    let subject = fault.subject;
    let about = name(subject);
    let found = |slug, message: String| Finding::new(slug, subject, message);
    Some(match &fault.condition {
        Condition::MissingReference { kind, id, role } => {
            let finding = found("missing-ref", format!("{about} refers to {kind} {id}, which does not exist."));
            with_member_removed(map, finding, *kind, *id, role.as_deref())
        }
        Condition::WayWithoutNodes => found("empty-way", format!("{about} has no nodes and is dropped.")),
        Condition::MemberDropped { kind, id, role } => {
            found("skipped", format!("{about} loses its member {role}: {kind} {id} did not load."))
        }
        Condition::NotRegulatoryElement { kind, id, untyped } => {
            let finding =
                found("element-type", format!("{about} refers to {kind} {id} as regulatory_element, which it is not."));
            match untyped {
                true => with_inferred_tag(finding, Subject::Relation(*id), "type", Some("regulatory_element")),
                false => without_member(finding, *kind, *id, "regulatory_element"),
            }
        }
        Condition::UnknownRelationType { found: kind, meant } => {
            if let Some((said, known)) = kind.as_ref().and_then(|kind| Some((kind, misspelt(kind, RELATION_TYPES)?))) {
                let message = format!("{about} has type {said} and is ignored; did you mean {known}?");
                let edits = vec![Edit::SetTag { on: subject, key: "type".into(), value: known.into() }];
                return Some(found("relation-type", message).fixed_by(format!("set type={known}"), false, edits));
            }
            let kind = kind.as_ref().map_or("no type".to_owned(), |kind| format!("type {kind}"));
            with_inferred_tag(
                found("relation-type", format!("{about} has {kind} and is ignored.")),
                subject,
                "type",
                meant.as_deref(),
            )
        }
        Condition::BrokenArea(fault) => broken_area(subject, fault),
        Condition::NoFormatVersion => {
            let finding = found("format-version", "The map has no MetaInfo format_version.".to_owned());
            with_format_version(map, finding)
        }
        Condition::BadFormatVersion { found: version } => {
            let message = format!("format_version {version} is not of the form 2, 2.0 or 2.0.0.");
            with_format_version(map, found("format-version", message))
        }
        Condition::UnsupportedFormatVersion { found: version, supported } => found(
            "format-version",
            format!("format_version {version} is above {supported}, the highest that Autoware supports."),
        ),
        Condition::PassedOver { message, .. } => found("passed-over", format!("{message}.")),
        _ => return None,
    })
}

/// Adds the fix that writes the version that Autoware knows. Formats 1 and 2 differ in bicycle lanes alone: where a map has none, it
/// means the same under both.
fn with_format_version(map: &MapIndex, finding: Finding) -> Finding {
    let is_safe = !map.map.lanelets.iter().any(|lanelet| lanelet.attributes.is("subtype", "bicycle_lane"));
    let version = SUPPORTED_FORMAT_VERSION.to_string();
    let title = format!("write format_version=\"{version}\"");
    finding.fixed_by(title, is_safe, vec![Edit::SetFormatVersion { version: version.into() }])
}

/// What is wrong with the bounds of a lanelet.
fn bounds(map: &MapIndex, fault: &LoadFault) -> Option<Finding> {
    let subject = fault.subject;
    let about = name(subject);
    let found = |slug, message: String| Finding::new(slug, subject, message);
    Some(match &fault.condition {
        Condition::BoundCount { role, count, ways, meant } => {
            bound_count::finding(map, subject, *role, *count, ways, *meant)
        }
        Condition::BoundIsPolygon { role, way } => {
            let message = format!("{} {way} of {subject} has area=yes and loads as a polygon.", bound(*role));
            let edits = vec![Edit::RemoveTag { on: Subject::Polygon(*way), key: "area".into() }];
            found("bound-polygon", message).with(Subject::Polygon(*way), role.as_str()).fixed_by(
                format!("remove the tag area of way {way}"),
                true,
                edits,
            )
        }
        Condition::BoundIsNotWay { role, kind, id } => {
            found("bound-not-way", format!("{} of {subject} is {kind} {id}; it must be a way.", bound(*role)))
        }
        Condition::BoundTooShort { role, way } => {
            let message = format!("{} {way} of {subject} has fewer than two points.", bound(*role));
            found("bound-short", message).with(Subject::LineString(*way), role.as_str())
        }
        Condition::BoundDropped { role, way } => {
            let message = format!("{about} is left out: its {role} {way} did not load.");
            found("skipped", message).with(Subject::Way(*way), role.as_str())
        }
        Condition::BoundsTooLong { lanelets, most } => {
            let lanelets = counted(*lanelets, "lanelet");
            let message = format!(
                "The bounds of the lanelets before {subject} have {most} points together, each as often as a lanelet uses it: \
                 {lanelets} from there on are not judged. Divide long lines where lanelets begin and end."
            );
            found("skipped", message).graded(Severity::Error)
        }
        Condition::BoundsOpposed { left, right } => opposed(map, subject, *left, *right),
        _ => return None,
    })
}

/// What is wrong with a regulatory element.
fn element(map: &MapIndex, fault: &LoadFault) -> Option<Finding> {
    let subject = fault.subject;
    let about = name(subject);
    let found = |slug, message: String| Finding::new(slug, subject, message);
    Some(match &fault.condition {
        Condition::WithoutSubtype { meant } => {
            let message = format!("{about} has no subtype; no map will be published.");
            with_inferred_tag(found("re-subtype", message), subject, "subtype", meant.as_deref())
        }
        Condition::UnknownSubtype { subtype, has_bounds } => unknown_subtype(subject, subtype, *has_bounds),
        Condition::MemberCount { subtype, limit, count } => return member_count(map, fault, subtype, *limit, *count),
        Condition::WithoutMembers { subtype } => {
            let message = format!("{subtype} {} has no members and does not load.", id_of(subject));
            referrers(map, found("re-members", message))
        }
        Condition::SignWithoutType { subtype, sign } => {
            let message = match sign {
                Some(sign) => format!("{subtype} {} has sign {sign}, which has no subtype.", id_of(subject)),
                None => format!("{subtype} {} has neither a sign nor a sign_type.", id_of(subject)),
            };
            referrers(map, found("re-members", message))
        }
        Condition::StopLinesPerLanelet { lanelets, stop_lines } => {
            let message = format!(
                "all_way_stop {} has {stop_lines} stop lines for {lanelets} lanelets; each needs one.",
                id_of(subject)
            );
            referrers(map, found("re-members", message))
        }
        Condition::MemberIsRegulatoryElement { id, role } => {
            let message =
                format!("Member {role} of {subject} is regulatory element {id}; elements cannot hold each other.");
            let finding = found("re-member-type", message).with(Subject::RegulatoryElement(*id), "member");
            without_member(finding, ElementKind::Relation, *id, role)
        }
        Condition::MemberOfUnknownType { id, role, found: kind } => {
            let kind = kind.as_ref().map_or("no type".to_owned(), |kind| format!("type {kind}"));
            found("re-member-type", format!("Member {role} of {subject} is relation {id}, which has {kind}."))
        }
        _ => return None,
    })
}

/// What is wrong with an element that has too few or too many members of a role.
fn member_count(map: &MapIndex, fault: &LoadFault, subtype: &str, limit: RoleLimit, count: usize) -> Option<Finding> {
    let subject = fault.subject;
    let found = |message: String| Finding::new("re-members", subject, message);
    if fault.condition.is_unsaid() {
        // Where it does not load, another fault of it says why.
        subject.id().filter(|id| map.map.regulatory_elements.contains(RegulatoryElementId(*id)))?;
        let message =
            format!("{subtype} {} has {count} stop lines; it loads, and the first one counts.", id_of(subject));
        return Some(found(message).graded(Severity::Warning));
    }
    let kind = limit.kind.as_str();
    let message = format!("{subtype} {} needs {limit} {kind} with role {}, has {count}.", id_of(subject), limit.role);
    let finding = referrers(map, found(message));
    if subtype != "right_of_way" || limit.role != "yield" || count > 0 {
        return Some(finding);
    }
    // What it referred to may only be missing from the file.
    let loses = |other: &LoadFault| other.subject == subject && other.condition.loses("yield");
    let is_safe = !map.faults.iter().any(loses);
    Some(finding.fixed_by("remove the element, which has no effect", is_safe, vec![Edit::Remove { subject }]))
}

/// An area that the loader rejects.
fn broken_area(subject: Subject, fault: &RingFault) -> Finding {
    let about = name(subject);
    let message = match fault {
        RingFault::NoLine { role, kind, id } => {
            format!("{about} is a multipolygon of which {role} {kind} {id} is no linestring.")
        }
        RingFault::Open { role } => format!("{about} is a multipolygon of which an {role} ring does not close."),
        RingFault::Crossing { role } => format!("{about} is a multipolygon of which an {role} ring crosses itself."),
        RingFault::Rings(0) => format!("{about} is a multipolygon without an outer ring."),
        RingFault::Rings(count) => format!("{about} is a multipolygon with {count} outer rings; one is allowed."),
    };
    Finding::new("area", subject, message)
}

/// Bounds, each with whether it is turned around, that run against each other.
fn opposed(map: &MapIndex, subject: Subject, left: (i64, bool), right: (i64, bool)) -> Finding {
    let turned = [left, right].into_iter().find(|(_, inverted)| *inverted).unwrap_or(left).0;
    let message = match left.1 || right.1 {
        true => format!("The loader turns bound {turned} of {subject} around, against its other bound."),
        false => format!("The loader leaves bound {turned} of {subject} as it is drawn, against its other bound."),
    };
    let finding = Finding::new("align", subject, message)
        .with(Subject::LineString(left.0), "left")
        .with(Subject::LineString(right.0), "right");
    let line = map.map.linestrings.get(LineStringId(turned)).map(|line| &line.points);
    let points = line.into_iter().flatten().filter_map(|&id| map.map.points.get(id));
    let finding = finding.at(Place::Line(points.map(|point| point.position).collect()));
    with_points_in_order(map, finding, LineStringId(turned))
}

/// Lanelets of which Lanelet2 turns a bound around because of the heights alone: it measures in space which piece of a bound lies nearest
/// to the other one's middle.
fn turned_by_heights(map: &MapIndex) -> Vec<Finding> {
    /// Bounds that differ by less than this in height, metres, are aligned as in the plane.
    const STEEP: f64 = 2.0;
    let lanelets = map.map.lanelets.as_slice().par_iter().in_small_parts();
    let turned = lanelets.filter_map(|lanelet| {
        let points = [lanelet.left, lanelet.right].into_iter().flat_map(|bound| map.map.bound_points(bound));
        let heights = points.map(|point| point.ele().unwrap_or(0.0));
        let [low, high] = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)]);
        let own = [lanelet.left, lanelet.right];
        let in_space = (high - low > STEEP).then(|| aligned_once(map.map, lanelet))?;
        let (turned, _) = in_space.into_iter().zip(own).find(|(space, plane)| space.inverted != plane.inverted)?;
        let message = format!(
            "The loader turns bound {} of {} around because of its heights, {low:.1} to {high:.1} m.",
            turned.line,
            Subject::Lanelet(lanelet.id.0)
        );
        let finding = Finding::new("align-heights", Subject::Lanelet(lanelet.id.0), message);
        Some(finding.with(Subject::LineString(turned.line.0), "bound"))
    });
    turned.collect()
}

/// Adds the fix that sets the tag of a relation which its members imply.
fn with_inferred_tag(finding: Finding, on: Subject, key: &str, meant: Option<&str>) -> Finding {
    let Some(meant) = meant else { return finding };
    let edits = vec![Edit::SetTag { on, key: key.into(), value: meant.into() }];
    finding.fixed_by(format!("set {key}={meant}, as its members call for"), true, edits)
}

/// The subject with a capital letter, to start a sentence.
pub(super) fn name(subject: Subject) -> String {
    let name = subject.to_string();
    let mut letters = name.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

fn id_of(subject: Subject) -> i64 {
    subject.id().unwrap_or_default()
}

fn bound(role: BoundRole) -> &'static str {
    match role {
        BoundRole::Left => "Left bound",
        BoundRole::Right => "Right bound",
        BoundRole::Centerline => "Centre line",
    }
}

/// Adds the fix that removes a dangling member, where the element loaded without it.
fn with_member_removed(map: &MapIndex, finding: Finding, kind: ElementKind, id: i64, role: Option<&str>) -> Finding {
    let loaded = match finding.subject {
        Subject::Lanelet(id) => map.map.lanelets.contains(LaneletId(id)),
        Subject::RegulatoryElement(id) => map.map.regulatory_elements.contains(RegulatoryElementId(id)),
        _ => false,
    };
    match role.filter(|_| loaded) {
        Some(role) => {
            let edits = vec![removed_member(finding.subject, kind, id, role)];
            finding.fixed_by(format!("remove the member {kind} {id}"), true, edits)
        }
        None => finding,
    }
}

/// Adds the fix that removes a member that cannot be one; what was meant in its place is not known.
fn without_member(finding: Finding, kind: ElementKind, id: i64, role: &str) -> Finding {
    let edits = vec![removed_member(finding.subject, kind, id, role)];
    finding.fixed_by(format!("remove the member {kind} {id}"), false, edits)
}

fn removed_member(on: Subject, kind: ElementKind, id: i64, role: &str) -> Edit {
    let member = match kind {
        ElementKind::Node => Subject::Node(id),
        ElementKind::Way => Subject::Way(id),
        ElementKind::Relation => Subject::Relation(id),
    };
    Edit::RemoveMember { on, role: role.into(), member }
}

/// Adds the lanelets that lose the element.
fn referrers(map: &MapIndex, finding: Finding) -> Finding {
    let Subject::RegulatoryElement(id) = finding.subject else { return finding };
    let lanelets = map.map.lanelets.iter().filter(|l| l.regulatory_elements.contains(&RegulatoryElementId(id)));
    lanelets.fold(finding, |finding, lanelet| finding.with(Subject::Lanelet(lanelet.id.0), "referring lanelet"))
}

fn unknown_subtype(subject: Subject, subtype: &str, has_bounds: bool) -> Finding {
    let message = format!("{} has unknown subtype {subtype}; no map will be published.", name(subject));
    let finding = Finding::new("re-subtype", subject, message);
    if has_bounds {
        let edits = vec![Edit::SetTag { on: subject, key: "type".into(), value: "lanelet".into() }];
        return finding.fixed_by("set type=lanelet: it has a left and a right bound", false, edits);
    }
    match nearest(subtype, known_subtypes()) {
        Some(known) => {
            let edits = vec![Edit::SetTag { on: subject, key: "subtype".into(), value: known.into() }];
            finding.fixed_by(format!("set subtype={known}"), false, edits)
        }
        // One element that nobody has registered keeps the whole map from being published.
        None => {
            finding.fixed_by("remove the element, which Autoware does not know", false, vec![Edit::Remove { subject }])
        }
    }
}
