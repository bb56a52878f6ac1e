//! vm-03-01: an intersection is an area, lanelets that name it, and their rules of the road.

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::diagnostic::{Edit, Finding, Fix, Place, Severity, Subject};
use crate::geometry::polygon::largest_outside;
use crate::lanelet::index::{
    AreaOutlines, Intersection, MapIndex, Outline, STRAIGHT_ON, U_TURN, Undrawn, Unmarked, declared_area,
};
use crate::lanelet::lane_change::is_said_by_side;
use crate::lanelet::{Lanelet, LineStringId, PolygonId};
use crate::parallel::InSmallParts;

use super::redrawn_area::{RedrawnAreas, area_around};
use super::{NoParams, far_lanes};
use crate::lanelet::index::thresholds;

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let covers = covers(map);
    let unmarked = UnmarkedIntersections::of(map);
    let areas = Areas::of(map);
    let lanelets = map.map.lanelets.iter();
    let mut findings: Vec<Finding> =
        lanelets.filter_map(|lanelet| judge_lanelet(map, lanelet, &covers, &unmarked, &areas)).collect();
    findings.extend(unmarked.findings());
    for intersection in &map.intersections {
        findings.extend(judge_area(map, intersection));
    }
    findings
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

fn judge_lanelet(
    map: &MapIndex,
    lanelet: &Lanelet,
    covers: &[Vec<Cover>],
    unmarked: &UnmarkedIntersections,
    areas: &Areas,
) -> Option<Finding> {
    let covers: &[Cover] = map.lane(lanelet.id).map_or(&[], |lane| &covers[lane]);
    // Only where the index counts it in: an overpass above the area is covered, too.
    let inside = map.lane(lanelet.id).and_then(|lane| {
        let areas = map.intersections_of(lane).iter().filter_map(|&at| map.intersections[at].area);
        let covering = areas.filter(|area| covers.iter().any(|c| c.0 == *area && c.1 >= thresholds::COVER));
        covering.min()
    });
    let subject = Subject::Lanelet(lanelet.id.0);
    let Some(value) = lanelet.attributes.get("intersection_area") else {
        return match inside {
            Some(area) => Some(tag_missing(lanelet, area, share_in(covers, area))),
            None => turn_without_area(map, lanelet, covers, unmarked),
        };
    };
    let Some(named) = area_id(value).filter(|&id| map.intersection_area(id).is_some()) else {
        let message = format!("Lanelet {} names area {value}, which is not an intersection_area.", lanelet.id);
        let finding = Finding::new("ia-tag-dangling", subject, message);
        return Some(match inside {
            // The area is the right one; its own id is what cannot be read, and that is said of it.
            Some(area) if area.to_string() == value => return None,
            Some(area) => retag(finding, subject, area),
            None => areas.mend_dangling(finding, value),
        });
    };
    let lane = map.lane_of(lanelet.id).filter(|lane| lane.simple)?;
    let share = share_in(covers, named);
    if share >= thresholds::COVER {
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
    let finding = Finding::new("not-covered", subject, message)
        .with(Subject::Polygon(named.0), "intersection area")
        .measured(100.0 * share, 100.0 * thresholds::COVER, "%");
    let Some(intersection) = map.intersections.iter().find(|one| one.area == Some(named)) else { return Some(finding) };
    let finding = areas.redrawn.mend(finding, intersection);
    Some(match largest_outside(&lane.outline, &intersection.ring) {
        Some(ring) => finding.at(Place::Polygon(ring)),
        None => finding,
    })
}

/// What mends areas: the lanes by the area that they name, and outlines.
struct Areas<'i, 'm> {
    map: &'i MapIndex<'m>,
    naming: FxHashMap<&'i str, Vec<usize>>,
    redrawn: RedrawnAreas<'i, 'm>,
}

impl<'i, 'm> Areas<'i, 'm> {
    fn of(map: &'i MapIndex<'m>) -> Self {
        let mut naming: FxHashMap<&str, Vec<usize>> = FxHashMap::default();
        for lanelet in map.map.lanelets.iter() {
            if let Some((value, lane)) = lanelet.attributes.get("intersection_area").zip(map.lane(lanelet.id)) {
                naming.entry(value).or_default().push(lane);
            }
        }
        Self { map, naming, redrawn: RedrawnAreas::new(map) }
    }

    /// Where a lanelet names what is no area: the way that was to be one is made one, else an area is drawn.
    fn mend_dangling(&self, finding: Finding, value: &str) -> Finding {
        let id = value.trim().parse().unwrap_or_default();
        let set = |on, key: &'static str, value: &'static str, safe| {
            let edits = vec![Edit::SetTag { on, key: key.into(), value: value.into() }];
            finding.clone().with(on, "no area").fixed_by(format!("set {key}={value} on {on}"), safe, edits)
        };
        if self.map.map.polygons.contains(PolygonId(id)) {
            return set(Subject::Polygon(id), "type", "intersection_area", false);
        }
        let line = self.map.map.linestrings.get(LineStringId(id));
        if line.is_some_and(|line| line.attributes.is("type", "intersection_area")) {
            return set(Subject::LineString(id), "area", "yes", true);
        }
        let lanes = self.naming.get(value).map_or(&[][..], Vec::as_slice);
        let finding = self.redrawn.replace(finding, lanes);
        if finding.fix.is_some() {
            return finding;
        }
        let edits = vec![Edit::RemoveTag { on: finding.subject, key: "intersection_area".into() }];
        finding.fixed_by("remove the tag intersection_area", false, edits)
    }
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
fn turn_without_area(
    map: &MapIndex,
    lanelet: &Lanelet,
    covers: &[Cover],
    unmarked: &UnmarkedIntersections,
) -> Option<Finding> {
    lanelet.attributes.get("turn_direction").filter(|value| !value.is_empty())?;
    let lane = map.lane(lanelet.id);
    let conflicts = lane.is_some_and(|lane| map.meets_others(lane));
    let message = format!("Lanelet {} has turn_direction but belongs to no intersection area.", lanelet.id);
    let finding = Finding::new("turn-without-ia", Subject::Lanelet(lanelet.id.0), message).graded(if conflicts {
        Severity::Error
    } else {
        Severity::Warning
    });
    let finding = match covers.first() {
        Some(&(area, share)) if share > 0.0 => finding
            .with(Subject::Polygon(area.0), "nearest intersection area")
            .measured(100.0 * share, 100.0 * thresholds::COVER, "%"),
        _ => finding,
    };
    Some(match lane.and_then(|lane| unmarked.of_lane(lane)) {
        Some(Bare { fix, .. }) => {
            let said = finding.message.trim_end_matches('.');
            let message = format!("{said}{}.", why_undrawn(fix));
            Finding { fix: fix.clone().ok(), message, ..finding }
        }
        None if !conflicts && lane.is_some_and(|lane| is_alone(map, lane)) => {
            let message =
                format!("Lanelet {} has turn_direction, but no lane crosses, joins or leaves it.", lanelet.id);
            let edits = vec![Edit::RemoveTag { on: finding.subject, key: "turn_direction".into() }];
            let finding = Finding { message, ..finding }.fixed_by("remove the tag turn_direction", false, edits);
            finding.advised("Remove the tag turn_direction; it is for the lanelets of intersections.")
        }
        None => finding,
    })
}

/// Whether a lane is a bend or a straight of a road: none branches off beside it, and none joins it. A lane that is drawn twice is one.
fn is_alone(map: &MapIndex, lane: usize) -> bool {
    let only = |lanes: &[usize]| lanes.windows(2).all(|pair| map.lanes[pair[0]].bounds == map.lanes[pair[1]].bounds);
    let (before, behind) = (map.predecessors(lane), map.followers(lane));
    only(before)
        && only(behind)
        && before.iter().all(|&before| only(map.followers(before)))
        && behind.iter().all(|&behind| only(map.predecessors(behind)))
}

/// Whether so many lanelets meet that no area is drawn around them: that would take long, and be no intersection.
fn is_too_large(intersection: &Unmarked) -> bool {
    const MOST_LANES: usize = 240;
    intersection.lanes.len() > MOST_LANES
}

/// An intersection without an area, with what marks it, or why no area is drawn.
struct Bare<'i> {
    intersection: &'i Unmarked,
    fix: Result<Fix, Option<Undrawn>>,
}

/// The intersections without an area.
struct UnmarkedIntersections<'i, 'm> {
    map: &'i MapIndex<'m>,
    all: Vec<Bare<'i>>,
    by_lane: FxHashMap<usize, usize>,
}

impl<'i, 'm> UnmarkedIntersections<'i, 'm> {
    fn of(map: &'i MapIndex<'m>) -> Self {
        let all = map.unmarked_intersections();
        let members = all.iter().enumerate().flat_map(|(at, one)| one.lanes.iter().map(move |&lane| (lane, at)));
        let by_lane = members.collect();
        let outlines = (!all.is_empty()).then(|| AreaOutlines::new(map));
        let fix = |one: &Unmarked| -> Result<Fix, Option<Undrawn>> {
            let outlines = outlines.as_ref().filter(|_| !is_too_large(one)).ok_or(None)?;
            // What is not divided yet lies outside of any area.
            if let Some(division) = far_lanes::division(map, one) {
                return division.ok_or(None);
            }
            let (outline, lanes) = outlines.around_with_covered(&one.lanes).map_err(Some)?;
            let title =
                format!("draw the area of the intersection, tag its {} lanelets and say where they turn", lanes.len());
            Ok(Fix { title, safe: false, edits: marking(map, &lanes, &outline) })
        };
        let fixes: Vec<Result<Fix, Option<Undrawn>>> = all.par_iter().in_small_parts().map(fix).collect();
        let all = all.iter().zip(fixes).map(|(intersection, fix)| Bare { intersection, fix });
        Self { map, all: all.collect(), by_lane }
    }

    fn of_lane(&self, lane: usize) -> Option<&Bare<'i>> {
        self.all.get(*self.by_lane.get(&lane)?)
    }

    /// One finding for each intersection of which nothing is marked; where a lanelet has `turn_direction`, that says it.
    fn findings(&self) -> impl Iterator<Item = Finding> + '_ {
        let is_marked = |lane: &usize| self.map.lanes[*lane].lanelet.attributes.has("turn_direction");
        let bare = self.all.iter().filter(move |one| !one.intersection.lanes.iter().any(is_marked));
        bare.filter_map(|one| Some(Finding { fix: one.fix.clone().ok(), ..self.unmarked(one)? }))
    }

    fn unmarked(&self, Bare { intersection, fix }: &Bare) -> Option<Finding> {
        let intersection = *intersection;
        let ids: Vec<i64> = intersection.lanes.iter().map(|&lane| self.map.lanes[lane].id.0).collect();
        let [first, rest @ ..] = &ids[..] else { return None };
        let ground = if intersection.private { " on private ground" } else { "" };
        let message = format!(
            "{} lanelets cross or join{ground}, among them {first}, without turn_direction and intersection_area{}.",
            ids.len(),
            if is_too_large(intersection) {
                ": too many for an area that a machine draws".to_owned()
            } else {
                why_undrawn(fix)
            }
        );
        let finding = Finding::new("unmarked", Subject::Lanelet(*first), message).at(Place::Point(intersection.middle));
        let finding = rest.iter().fold(finding, |finding, &id| finding.with(Subject::Lanelet(id), "lanelet"));
        Some(match intersection {
            Unmarked { private: true, .. } => finding.graded(Severity::Info),
            Unmarked { crossed: false, .. } => finding.graded(Severity::Warning),
            _ => finding,
        })
    }
}

/// Why no area is drawn, to stand at the end of a sentence; nothing where one is.
fn why_undrawn(fix: &Result<Fix, Option<Undrawn>>) -> String {
    match fix {
        Err(Some(Undrawn::Bare(under))) => {
            format!("; no area is proposed, since only {:.0} % of its ground would lie under lanes", percent(*under))
        }
        _ => String::new(),
    }
}

/// The edits that say where lanelets turn that do not say it, and that nobody changes lanes over their virtual bounds, draw the
/// area, and name it in its lanelets.
fn marking(map: &MapIndex, lanes: &[usize], outline: &Outline) -> Vec<Edit> {
    let label = |&lane: &usize| {
        let lanelet = map.lanes[lane].lanelet;
        let label = map.label_for(map.lanes[lane].turn(), STRAIGHT_ON, U_TURN).as_str();
        let on = Subject::Lanelet(lanelet.id.0);
        let is_missing = lanelet.attributes.get("turn_direction").is_none_or(str::is_empty);
        let is_missing = is_missing && !map.begins_in_a_point(lane);
        is_missing.then(|| Edit::SetTag { on, key: "turn_direction".into(), value: label.into() })
    };
    let mut bounds: Vec<_> = lanes.iter().flat_map(|&lane| map.lanes[lane].bounds).collect();
    bounds.sort_unstable();
    bounds.dedup();
    let untold = |way: &LineStringId| {
        let tags = map.map.linestrings.get(*way).map(|line| &line.attributes);
        tags.is_some_and(|tags| tags.is("type", "virtual") && !tags.has("lane_change") && !is_said_by_side(tags))
    };
    let closed = bounds.into_iter().filter(untold).map(|way| Edit::SetTag {
        on: Subject::LineString(way.0),
        key: "lane_change".into(),
        value: "no".into(),
    });
    let mut edits: Vec<Edit> = lanes.iter().filter_map(label).chain(closed).collect();
    let lanelets = lanes.iter().map(|&lane| map.lanes[lane].id.0).collect();
    edits.push(area_around(outline, lanelets));
    edits
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
        // Lanes for buses alone may be all that meets there.
        let names_it = |&(lane, _): &(usize, f64)| declared_area(&map.lanes[lane]) == Some(area);
        if !intersection.touched.iter().any(names_it) {
            findings.push(Finding::new("orphan-ia", subject, format!("Intersection area {area} holds no lanelet.")));
        }
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
