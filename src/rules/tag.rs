//! tag: keys, values and roles that are slips of the pen.

use std::collections::BTreeMap;

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::diagnostic::{Edit, Finding, Severity, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::vocabulary::{self, Form, On, Slip, roles, slip};
use crate::lanelet::{Attributes, Condition, ElementKind, Lanelet, LineStringId, PointId, RegulatoryElementId};
use crate::parallel::InSmallParts;
use crate::text::{SourceSpan, Text, counted, misspelt, rearranged};

use super::load::name;
use super::signal::RELATION;
use super::vm_01_02::lines_between_lanes;
use super::vm_07_02;
use super::{NoParams, crowd};

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let mut findings = tags(map);
    findings.extend(map.map.lanelets.iter().filter_map(misplaced));
    findings.extend(named_nothing(map));
    findings.extend(misspelt_roles(map));
    findings.extend(unread_roles(map));
    findings
}

/// A primitive with its tags.
struct Tagged<'m> {
    on: On,
    subject: Subject,
    tags: &'m Attributes,
    /// Whether lanelets have it as centre line and nothing as border: nobody reads what type it has.
    is_centerline: bool,
}

/// The primitives of a layer, each with what it is, its id and its tags.
fn tagged<'m, T: Sync>(
    layer: &'m [T],
    parts: impl Fn(&'m T) -> (On, Subject, &'m Attributes) + Send + Sync,
) -> impl ParallelIterator<Item = Tagged<'m>> {
    layer.par_iter().in_small_parts().map(move |it| {
        let (on, subject, tags) = parts(it);
        Tagged { on, subject, tags, is_centerline: false }
    })
}

fn tags(map: &MapIndex) -> Vec<Finding> {
    let (between, bulbs) = (lines_between_lanes(map), bulbs(map));
    let all = map.map;
    let points = tagged(all.points.as_slice(), |it| (On::Point, Subject::Point(it.id.0), it.attributes()));
    let centerlines: FxHashSet<LineStringId> = all.lanelets.iter().filter_map(|lanelet| lanelet.centerline).collect();
    let lines = tagged(all.linestrings.as_slice(), |it| (On::LineString, Subject::LineString(it.id.0), &it.attributes));
    let lines = lines.map(|it| {
        let id = LineStringId(it.subject.id().unwrap_or_default());
        Tagged { is_centerline: centerlines.contains(&id) && map.users_of(id).is_empty(), ..it }
    });
    let polygons = tagged(all.polygons.as_slice(), |it| (On::Polygon, Subject::Polygon(it.id.0), &it.attributes));
    let lanelets = tagged(all.lanelets.as_slice(), |it| (On::Lanelet, Subject::Lanelet(it.id.0), &it.attributes));
    let elements = tagged(all.regulatory_elements.as_slice(), |it| {
        (On::Element, Subject::RegulatoryElement(it.id.0), &it.attributes)
    });
    let areas = tagged(all.areas.as_slice(), |it| (On::Area, Subject::Relation(it.id.0), &it.attributes));
    let primitives = points.chain(lines).chain(polygons).chain(lanelets).chain(elements).chain(areas);
    // Of these, other rules judge more.
    let known = |subject: Subject| match subject {
        Subject::LineString(id) => between.contains_key(&LineStringId(id)),
        Subject::Point(id) => bulbs.contains(&PointId(id)),
        _ => false,
    };
    let found: Vec<(Option<Slipped>, Finding)> = primitives
        .flat_map_iter(|it| {
            let is_known = known(it.subject);
            let slips = it.tags.iter().filter_map(|(key, value)| {
                let finding = tag(&it, is_known, key, value)?;
                let value = if finding.fault == "key" { "" } else { value };
                Some((Some((it.on, finding.fault, key, value, finding.fix.is_some())), finding))
            });
            slips.chain(twice(&it).into_iter().map(|finding| (None, finding))).collect::<Vec<_>>()
        })
        .collect();
    told_once(found)
}

/// A slip of one kind: where, which fault, the key, the value where it matters, and whether it can be mended.
type Slipped<'m> = (On, &'static str, &'m str, &'m str, bool);

/// A slip that stands on more primitives than a reader looks at came from a program: one finding tells of all, and mends all.
fn told_once(found: Vec<(Option<Slipped>, Finding)>) -> Vec<Finding> {
    let mut counts: FxHashMap<Slipped, usize> = FxHashMap::default();
    found.iter().filter_map(|(slipped, _)| *slipped).for_each(|one| *counts.entry(one).or_default() += 1);
    let mut findings: Vec<Finding> = Vec::new();
    let mut groups: FxHashMap<Slipped, usize> = FxHashMap::default();
    for (slipped, mut finding) in found {
        let Some((slipped, count)) = slipped.and_then(|one| Some((one, *counts.get(&one)?))) else {
            findings.push(finding);
            continue;
        };
        if count <= crowd::MOST {
            findings.push(finding);
        } else if let Some(group) = groups.get(&slipped).and_then(|&at| findings.get_mut(at)) {
            let edits = finding.fix.map(|fix| fix.edits);
            if let Some((all, own)) = group.fix.as_mut().zip(edits) {
                all.edits.extend(own);
            }
        } else {
            finding.message = format!("{} So it stands {count} times.", finding.message);
            if let Some(fix) = &mut finding.fix {
                fix.title = format!("{} on all {count}", fix.title);
            }
            groups.insert(slipped, findings.len());
            findings.push(finding);
        }
    }
    findings
}

/// Keys that stand in one primitive more than once, with different values.
fn twice(it: &Tagged) -> Vec<Finding> {
    let mut tags: Vec<(&str, &str)> = it.tags.iter().collect();
    // Stable: of one key the first and the last value stay so.
    tags.sort_by_key(|(key, _)| *key);
    let of_keys = tags.chunk_by(|(one, _), (other, _)| one == other);
    let told = of_keys.filter_map(|tags| {
        let (&(key, first), &(_, last)) = (tags.first()?, tags.last()?);
        let message = format!("{} has the key {key} twice, with {first} and {last}.", name(it.subject));
        (first != last).then(|| Finding::new("twice", it.subject, message))
    });
    told.collect()
}

/// What is wrong with one tag.
fn tag(it: &Tagged, is_known: bool, key: &str, value: &str) -> Option<Finding> {
    let slip = slip(it.on, it.tags, key, value)?;
    // Of what lights tell of each other, the rule signal tells more.
    if it.on == On::Element && key.starts_with(RELATION) {
        return None;
    }
    let about = it.subject;
    let set = |value: &str| Edit::SetTag { on: about, key: key.into(), value: value.into() };
    if let Slip::Key(meant) = slip {
        // Unquoted, nobody would see the blank.
        let message = match key.trim() == meant {
            true => format!("{} has the key \"{key}\" with a blank; did you mean {meant}?", name(about)),
            false => format!("{} has the key {key}, which nothing reads; did you mean {meant}?", name(about)),
        };
        let finding = Finding::new("key", about, message);
        // A value that the known key cannot have, such as `None` for a height, would be a fault of its own.
        if matches!(vocabulary::slip(it.on, it.tags, meant, value), Some(Slip::Form(..) | Slip::Word(..))) {
            return Some(finding);
        }
        // As soon as one participant is named, who is not named may not enter: of another word than `participant` nobody knows whether
        // that was meant, unless it lets all vehicles in.
        let names_some = meant.starts_with("participant") && !key.starts_with("participant");
        if it.tags.has(meant) || names_some && (meant, value) != ("participant:vehicle", "yes") {
            return Some(finding);
        }
        let renamed = Edit::SetTag { on: about, key: meant.into(), value: value.into() };
        let edits = vec![Edit::RemoveTag { on: about, key: key.into() }, renamed];
        return Some(finding.fixed_by(format!("name the key {meant}"), false, edits));
    }
    if let Slip::RenamedKey(now) = slip {
        let message = format!("{} has the key {key}, which is called {now} today.", name(about));
        let edit = Edit::SetTag { on: about, key: now.into(), value: value.into() };
        return Some(Finding::new("renamed", about, message).fixed_by(format!("set {now}={value}"), false, vec![edit]));
    }
    if let Slip::RenamedValue(now) = slip {
        let message = format!("{key}={value} of {about} is called {now} today.");
        let finding = Finding::new("renamed", about, message);
        return Some(finding.fixed_by(format!("set {key}={now}"), false, vec![set(now)]));
    }
    if let Slip::Elsewhere(kinds) = slip {
        let kinds: Vec<&str> = kinds.iter().map(|on| on.plural()).collect();
        let message =
            format!("{} has the key {key}, which has no effect: it is read of {}.", name(about), kinds.join(" and "));
        return Some(Finding::new("misplaced", about, message));
    }
    // No type makes a centre line something else.
    let is_idle = it.is_centerline && matches!(key, "type" | "subtype") && slip != Slip::Value("centerline");
    if is_judged_elsewhere(it, is_known, key, value) || is_idle {
        return None;
    }
    let (what, meant) = match slip {
        Slip::Key(_) | Slip::RenamedKey(_) | Slip::RenamedValue(_) | Slip::Elsewhere(_) => return None,
        Slip::Value(meant) => ("is nothing that Lanelet2 or Autoware knows".to_owned(), Some(meant.to_owned())),
        Slip::Form(Form::YesNo | Form::YesNoAlone, meant) => ("is neither yes nor no".to_owned(), meant),
        Slip::Form(form, meant) => (format!("is no {}", form.as_str()), meant),
        Slip::Word(words, meant) => (format!("is none of {}", words.join(", ")), meant.map(str::to_owned)),
    };
    let said = format!("{key}={value} of {about} {what}");
    Some(match meant {
        Some(meant) => {
            let finding = Finding::new("value", about, format!("{said}; did you mean {meant}?"));
            finding.fixed_by(format!("set {key}={meant}"), false, vec![set(&meant)])
        }
        None => Finding::new("value", about, format!("{said}.")),
    })
}

/// An approval that nobody asks for: the planner asks in lanes that turn and at crosswalks.
fn misplaced(lanelet: &Lanelet) -> Option<Finding> {
    let key = "rtc_approval_required_v1";
    let tags = &lanelet.attributes;
    let (module, is_there, needs) = match tags.get(key)? {
        "intersection" => ("intersection", tags.has("turn_direction"), "a lane with turn_direction"),
        "crosswalk" => ("crosswalk", tags.is("subtype", "crosswalk"), "a crosswalk"),
        _ => return None,
    };
    let message =
        format!("{key}={module} of lanelet {} has no effect: it is read of {needs}, and this is none.", lanelet.id);
    (!is_there).then(|| Finding::new("misplaced", Subject::Lanelet(lanelet.id.0), message))
}

/// Ids in tags of which the map has no such line: of bulbs that are no part of a light's element, where vm-04-01 tells more, and
/// of lines that a vehicle should follow.
fn named_nothing(map: &MapIndex) -> Vec<Finding> {
    let all = map.map;
    let elements = all.regulatory_elements.iter().filter(|element| element.subtype == "traffic_light");
    let in_elements: FxHashSet<LineStringId> =
        elements.flat_map(|element| element.linestrings("light_bulbs")).collect();
    let id = |tags: &Attributes, key: &str| Some(LineStringId(tags.get(key)?.trim().parse().ok()?));
    let bulbs = all.linestrings.iter().filter(|line| !in_elements.contains(&line.id)).filter_map(|line| {
        let key = "traffic_light_id";
        let named = id(&line.attributes, key)?;
        let is_light = all.linestrings.get(named).is_some_and(|body| body.attributes.is("type", "traffic_light"));
        (!is_light).then_some((Subject::LineString(line.id.0), key, named, "traffic light"))
    });
    let lanes = all.lanelets.iter().filter_map(|lanelet| {
        let key = "waypoints";
        let named = id(&lanelet.attributes, key)?;
        all.linestrings.get(named).is_none().then_some((Subject::Lanelet(lanelet.id.0), key, named, "line"))
    });
    let finding = |(about, key, named, what): (Subject, &str, LineStringId, &str)| {
        Finding::new("id", about, format!("{key}={named} of {} names no {what} of the map.", name(about)))
    };
    bulbs.chain(lanes).map(finding).collect()
}

/// The points of light bulbs.
fn bulbs(map: &MapIndex) -> FxHashSet<PointId> {
    let lines = map.map.regulatory_elements.iter().flat_map(|element| element.linestrings("light_bulbs"));
    lines.filter_map(|line| map.map.linestrings.get(line)).flat_map(|line| line.points.iter().copied()).collect()
}

/// Whether another rule judges the value of the key. It does so for bulbs, and for lines between two lanes of one direction.
fn is_judged_elsewhere(it: &Tagged, is_known: bool, key: &str, value: &str) -> bool {
    match (it.on, key) {
        // vm-04-03; vm-01-02.
        (On::Point, "color" | "arrow") | (On::LineString, "lane_change") => is_known,
        // vm-03-02, vm-03-01.
        (On::Lanelet, "turn_direction" | "turn_signal_distance" | "intersection_area") => true,
        // vm-05-03, vm-07-02.
        (On::Lanelet, "safety_slow_down_speed" | "safety_slow_down_distance") => true,
        (On::LineString, "type") => vm_07_02::meant(value).is_some(),
        // vm-01-01.
        (On::Lanelet, "one_way" | "location") => it.tags.is("subtype", "road"),
        // vm-04-02; but of 1,25 it reads 1.
        (On::LineString, "height") => it.tags.is("type", "traffic_light") && !value.contains(','),
        _ => false,
    }
}

/// Members with a role that nothing reads: of what, the subject, the member, the role.
fn unread<'m>(
    map: &'m MapIndex,
) -> impl Iterator<Item = (&'m Text, Subject, Option<&'m SourceSpan>, Subject, &'m Text)> {
    map.faults.iter().filter_map(|fault| match &fault.condition {
        Condition::UnreadRole { of, kind, id, role } => {
            let member = match kind {
                ElementKind::Node => Subject::Node(*id),
                ElementKind::Way => Subject::Way(*id),
                ElementKind::Relation => Subject::Relation(*id),
            };
            Some((of, fault.subject, fault.span.as_ref(), member, role))
        }
        _ => None,
    })
}

/// A role that is the beginning of one word has at least this number of letters.
const SHORTEST_BEGINNING: usize = 4;

/// The role that was meant by one that nothing reads: by its letters, or because the member is a regulatory element.
fn role_meant(map: &MapIndex, of: &str, member: Subject, role: &str) -> Option<&'static str> {
    let is_element = || match member {
        Subject::Relation(id) => map.map.regulatory_elements.contains(RegulatoryElementId(id)),
        _ => false,
    };
    meant(of, role).or_else(|| (of == "lanelet" && is_element()).then_some(ELEMENT_ROLE))
}

/// The role of what a lanelet obeys.
const ELEMENT_ROLE: &str = "regulatory_element";

fn meant(of: &str, role: &str) -> Option<&'static str> {
    let words = || roles(of).into_iter().flatten().map(String::as_str);
    // What somebody cut short.
    let begun = || {
        let mut longer = words().filter(|word| role.len() >= SHORTEST_BEGINNING && word.starts_with(role));
        longer.next().filter(|_| longer.next().is_none())
    };
    misspelt(role, words()).or_else(|| rearranged(role, words())).or_else(begun)
}

fn misspelt_roles(map: &MapIndex) -> Vec<Finding> {
    let slips = unread(map).filter_map(|(of, on, span, member, role)| {
        let meant = role_meant(map, of, member, role)?;
        let read_as = if role.trim().is_empty() { "without role" } else { &format!("as {role}, which nothing reads") };
        let message = format!("{} has {member} {read_as}; did you mean {meant}?", name(on));
        let edits = vec![Edit::SetRole { on, member, from: role.clone(), to: meant.into() }];
        let finding = Finding::new("role", on, message).standing_at(span.cloned());
        // What the lanelet was to obey has no effect.
        let finding = if meant == ELEMENT_ROLE { finding.graded(Severity::Error) } else { finding };
        Some(finding.fixed_by(format!("give {member} the role {meant}"), false, edits))
    });
    slips.collect()
}

/// Roles that are like none that is read: one finding for each, since whoever wrote them wrote them everywhere.
fn unread_roles(map: &MapIndex) -> Vec<Finding> {
    let mut all: BTreeMap<(&Text, &Text), (usize, Subject, Option<&SourceSpan>)> = BTreeMap::new();
    for (of, on, span, _, role) in
        unread(map).filter(|(of, _, _, member, role)| role_meant(map, of, *member, role).is_none())
    {
        all.entry((of, role)).or_insert((0, on, span)).0 += 1;
    }
    let findings = all.into_iter().map(|((of, role), (count, first, span))| {
        let role = if role.is_empty() { "no role".to_owned() } else { format!("the role {role}") };
        let have = if count == 1 { "has" } else { "have" };
        let of = match of.as_str() {
            "lanelet" => "lanelets".to_owned(),
            "multipolygon" => "areas".to_owned(),
            subtype => format!("{subtype} elements"),
        };
        let message =
            format!("{} of {of} {have} {role}, which nothing reads; {first} is the first.", counted(count, "member"));
        Finding::new("role", first, message).standing_at(span.cloned()).graded(Severity::Info)
    });
    findings.collect()
}
