//! vm-03-01: an intersection is an area, lanelets that name it, and their rules of the road.

use crate::diagnostic::{Edit, Finding, Place, Severity, Subject};
use crate::lanelet::index::{Intersection, MapIndex};
use crate::lanelet::{Lanelet, LineStringId, PolygonId};

use super::{NoParams, Rule};

/// See `rules/vm-03-01.md`.
pub struct Criteria;

impl Rule for Criteria {
    type Params = NoParams;

    fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
        let covers = covers(map);
        let mut findings: Vec<Finding> =
            map.map.lanelets.iter().filter_map(|lanelet| judge_lanelet(map, lanelet, &covers)).collect();
        for intersection in &map.intersections {
            findings.extend(judge_area(map, intersection));
        }
        findings
    }
}

/// An area and the share of a lane that it covers.
type Cover = (PolygonId, f64);

/// For every lane the areas that cover part of it, the largest share first.
fn covers(map: &MapIndex) -> Vec<Vec<Cover>> {
    let mut covers = vec![Vec::new(); map.lanes.len()];
    for intersection in &map.intersections {
        let Some(area) = intersection.area else { continue };
        let members = intersection.members.iter().map(|member| (member.lane, member.cover));
        for (lane, cover) in members.chain(intersection.touched.iter().copied()) {
            covers[lane].push((area, cover));
        }
    }
    for list in &mut covers {
        list.sort_by(|a: &Cover, b: &Cover| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    }
    covers
}

fn judge_lanelet(map: &MapIndex, lanelet: &Lanelet, covers: &[Vec<Cover>]) -> Option<Finding> {
    let covers: &[Cover] = map.lane(lanelet.id).map_or(&[], |lane| &covers[lane]);
    // Only where the index counts it in: an overpass above the area is covered, too.
    let inside = map.lane(lanelet.id).and_then(|lane| {
        let areas = map.intersections_of(lane).iter().filter_map(|&at| map.intersections[at].area);
        let covering = areas.filter(|area| covers.iter().any(|c| c.0 == *area && c.1 >= map.thresholds.cover));
        covering.min()
    });
    let subject = Subject::Lanelet(lanelet.id.0);
    let Some(value) = lanelet.attributes.get("intersection_area") else {
        return match inside {
            Some(area) => Some(tag_missing(lanelet, area, share_in(covers, area))),
            None => turn_without_area(map, lanelet, covers),
        };
    };
    let Some(named) = area_id(value).filter(|&id| map.intersection_area(id).is_some()) else {
        let message = format!("Lanelet {} names area {value}, which is not an intersection_area.", lanelet.id);
        let finding = Finding::new("ia-tag-dangling", subject, message);
        return Some(match inside {
            // The area is the right one; its own id is what cannot be read, and that is said of it.
            Some(area) if area.to_string() == value => return None,
            Some(area) => retag(finding, subject, area),
            None if is_line(map, value) => {
                let on = Subject::LineString(value.trim().parse().unwrap_or_default());
                let edits = vec![Edit::SetTag { on, key: "area".into(), value: "yes".into() }];
                finding.with(on, "no area").fixed_by(format!("set area=yes on {on}"), true, edits)
            }
            None => {
                let edits = vec![Edit::RemoveTag { on: subject, key: "intersection_area".into() }];
                finding.fixed_by("remove the tag intersection_area", true, edits)
            }
        });
    };
    let lane = map.lane_of(lanelet.id).filter(|lane| lane.simple)?;
    let share = share_in(covers, named);
    if share >= map.thresholds.cover {
        return None;
    }
    if let Some(area) = inside {
        let message = format!("Lanelet {} is tagged with area {named} but lies in {area}.", lanelet.id);
        let finding = Finding::new("ia-tag-wrong", subject, message)
            .with(Subject::Polygon(named.0), "tagged area")
            .with(Subject::Polygon(area.0), "covering area");
        return Some(retag(finding, subject, area));
    }
    let message = format!("Only {} % of lanelet {} is inside its area {named}.", percent(share), lanelet.id);
    let ring = map.intersections.iter().find(|i| i.area == Some(named)).map(|i| i.ring.as_slice()).unwrap_or_default();
    let outside = crate::geometry::polygon::largest_outside(&lane.outline, ring);
    let finding = Finding::new("not-covered", subject, message)
        .with(Subject::Polygon(named.0), "intersection area")
        .measured(100.0 * share, 100.0 * map.thresholds.cover, "%");
    Some(match outside {
        Some(ring) => finding.at(Place::Polygon(ring)),
        None => finding,
    })
}

fn tag_missing(lanelet: &Lanelet, area: PolygonId, share: f64) -> Finding {
    let message = format!(
        "Lanelet {} lies {} % inside intersection area {area} but has no intersection_area tag.",
        lanelet.id,
        percent(share)
    );
    let subject = Subject::Lanelet(lanelet.id.0);
    let finding = Finding::new("ia-tag-missing", subject, message).with(Subject::Polygon(area.0), "intersection area");
    retag(finding, subject, area)
}

/// A turn outside every area: an intersection whose area is missing where lanelets conflict, else the blinker of a
/// lane that branches off.
fn turn_without_area(map: &MapIndex, lanelet: &Lanelet, covers: &[Cover]) -> Option<Finding> {
    lanelet.attributes.get("turn_direction").filter(|value| !value.is_empty())?;
    let conflicts = map.lane(lanelet.id).is_some_and(|lane| map.has_real_conflict(lane));
    let message = format!("Lanelet {} has turn_direction but belongs to no intersection area.", lanelet.id);
    let finding = Finding::new("turn-without-ia", Subject::Lanelet(lanelet.id.0), message).graded(if conflicts {
        Severity::Error
    } else {
        Severity::Warning
    });
    Some(match covers.first() {
        Some(&(area, share)) if share > 0.0 => finding
            .with(Subject::Polygon(area.0), "nearest intersection area")
            .measured(100.0 * share, 100.0 * map.thresholds.cover, "%"),
        _ => finding,
    })
}

fn judge_area(map: &MapIndex, intersection: &Intersection) -> Vec<Finding> {
    let Some(area) = intersection.area else { return Vec::new() };
    let subject = Subject::Polygon(area.0);
    let mut findings = Vec::new();
    if area_id(&area.to_string()).is_none() {
        let message =
            format!("Intersection area {area} has an id that Autoware cannot read: it must be 1..={}.", i32::MAX);
        let edits = vec![Edit::Renumber { on: subject, nth: 0, referrers: None }];
        let title = "give it an id that is free, here and in the tags of its lanelets";
        findings.push(Finding::new("ia-id-range", subject, message).fixed_by(title, true, edits));
    }
    if intersection.members.is_empty() {
        findings.push(Finding::new("orphan-ia", subject, format!("Intersection area {area} holds no lanelet.")));
        return findings;
    }
    let lanelets = || intersection.members.iter().map(|member| map.lanes[member.lane].id);
    let signalised = lanelets().any(|id| map.is_signalised(id));
    if !signalised && !lanelets().any(|id| map.elements(id, "right_of_way").next().is_some()) {
        let message = format!("No lanelet of the unsignalised intersection {area} has a right_of_way element.");
        findings.push(Finding::new("no-right-of-way", subject, message));
    }
    findings
}

/// Whether this is the id of an area that is drawn as a line, for want of `area=yes`.
fn is_line(map: &MapIndex, value: &str) -> bool {
    let line = area_id(value).and_then(|id| map.map.linestrings.get(LineStringId(id.0)));
    line.is_some_and(|line| line.attributes.is("type", "intersection_area"))
}

fn retag(finding: Finding, on: Subject, area: PolygonId) -> Finding {
    let value = area.to_string().into();
    let edits = vec![Edit::SetTag { on, key: "intersection_area".into(), value }];
    finding.fixed_by(format!("set intersection_area={area}"), true, edits)
}

/// The id that a tag's value names as Autoware reads it: `atoi` into 32 bits.
fn area_id(value: &str) -> Option<PolygonId> {
    let digits = value.bytes().all(|b| b.is_ascii_digit()) && !value.starts_with('0');
    let id: i32 = value.parse().ok().filter(|_| digits)?;
    Some(PolygonId(id.into()))
}

fn share_in(covers: &[Cover], area: PolygonId) -> f64 {
    covers.iter().find(|cover| cover.0 == area).map_or(0.0, |cover| cover.1)
}

/// Rounded down, so that what is short of a limit never reads as if it met it.
fn percent(share: f64) -> f64 {
    (share.min(1.0) * 1000.0).floor() / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_read_as_autoware_does() {
        assert_eq!(area_id("250"), Some(PolygonId(250)));
        assert_eq!(area_id("2147483647"), Some(PolygonId(2_147_483_647)));
        for bad in ["2147483648", "0", "-3", "+3", "010", "3a", "", " 3"] {
            assert_eq!(area_id(bad), None, "{bad:?}");
        }
    }
}
