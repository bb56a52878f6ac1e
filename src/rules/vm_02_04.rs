//! vm-02-04: a stop line lies on a lane that its element rules, before what it protects.

use rustc_hash::{FxHashMap, FxHashSet};
use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Subject};
use crate::geometry::{Point, Polyline, polygon, segment_crossing};
use crate::lanelet::index::{Lane, MapIndex};
use crate::lanelet::{LineStringId, RegulatoryElement};

use super::exchanged_lights::exchanges;
use super::stop_line_crossings;
use super::stop_line_crossings::{StopLineCrossing, line_of_lanes};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    reach: f64,
    extra: f64,
    behind: f64,
}

/// Elements whose stop line is for vehicles, on a lane that refers to them or before it.
const JUDGED: [&str; 3] = ["traffic_light", "traffic_sign", "crosswalk"];

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let elements = map.map.regulatory_elements.iter();
    let judged = elements.filter(|element| JUDGED.contains(&element.subtype.as_str()));
    let exchanged: FxHashSet<_> = exchanges(map).into_iter().flat_map(|one| one.elements).collect();
    let judged = judged.flat_map(|element| judge(map, params, element, exchanged.contains(&element.id)));
    judged.collect()
}

/// Judges the stop lines of an element. Where its references are exchanged with those of another, its line is the right one.
fn judge(map: &MapIndex, params: &Params, element: &RegulatoryElement, is_exchanged: bool) -> Vec<Finding> {
    let referrers = map.referrers(element.id).iter().filter_map(|&id| map.lane(id));
    let referrers: Vec<usize> = referrers.filter(|&lane| map.lanes[lane].is_for_cars()).collect();
    // A light of people on foot has no vehicle that could pass a line.
    if referrers.is_empty() {
        return Vec::new();
    }
    let ruled = LanesAtElement::of(map, params, &referrers);
    let lines = element.linestrings("ref_line").filter_map(|way| map.stop_line(way));
    lines
        .filter_map(|line| {
            let crossed = stop_line_crossings::crossings(map, &line, params.extra);
            let on: Vec<&StopLineCrossing> = crossed.iter().filter(|crossing| ruled.meets(crossing)).collect();
            if on.is_empty() {
                let finding = off_lane(element, line.way, line.ends);
                return Some(match is_exchanged {
                    true => finding,
                    false => with_own_line(map, finding, element, line.way, &referrers),
                });
            }
            behind(map, params, element, line.way, &on)
        })
        .collect()
}

/// The lanes on which a vehicle meets an element.
struct LanesAtElement {
    /// Those that refer to it and those before them within reach, each with the distance of its end from the first lane
    /// that refers, metres.
    before: FxHashMap<usize, f64>,
    /// Those right behind a lane that refers.
    behind: FxHashSet<usize>,
}

impl LanesAtElement {
    fn of(map: &MapIndex, params: &Params, referrers: &[usize]) -> Self {
        let behind = referrers.iter().flat_map(|&lane| map.followers(lane)).copied().collect();
        let mut before: FxHashMap<usize, f64> = referrers.iter().map(|&lane| (lane, 0.0)).collect();
        let mut open: Vec<(usize, f64)> = referrers.iter().map(|&lane| (lane, 0.0)).collect();
        while let Some((lane, far)) = open.pop() {
            for &next in map.predecessors(lane).iter().filter(|&&next| map.lanes[next].is_for_cars()) {
                if far > params.reach || before.get(&next).is_some_and(|&known| known <= far) {
                    continue;
                }
                before.insert(next, far);
                open.push((next, far + map.lanes[next].length()));
            }
        }
        Self { before, behind }
    }

    /// Whether a vehicle meets the element where a line crosses a lane. On a lane behind, only what was drawn across it
    /// counts: prolonged, the line of another approach reaches into the exit beside it.
    fn meets(&self, crossing: &StopLineCrossing) -> bool {
        self.before.contains_key(&crossing.lane) || (self.behind.contains(&crossing.lane) && crossing.span > 0.5)
    }
}

fn off_lane(element: &RegulatoryElement, way: LineStringId, ends: [Point; 2]) -> Finding {
    let message = format!(
        "Stop line {way} of {} {} crosses no lanelet that refers to the element, nor one before it.",
        element.subtype, element.id
    );
    Finding::new("off-lane", Subject::LineString(way.0), message)
        .with(Subject::RegulatoryElement(element.id.0), "element")
        .at(Place::Line(ends.to_vec()))
}

/// Adds the edits that give an element the stop line of its own lanes in place of that of others.
fn with_own_line(
    map: &MapIndex,
    finding: Finding,
    element: &RegulatoryElement,
    wrong: LineStringId,
    lanes: &[usize],
) -> Finding {
    let own = line_of_lanes(map, lanes).filter(|own| !element.linestrings("ref_line").any(|line| line == *own));
    let Some(own) = own else { return finding };
    let (on, role) = (Subject::RegulatoryElement(element.id.0), || "ref_line".into());
    let [old, new] = [wrong, own].map(|line| Subject::LineString(line.0));
    let edits =
        vec![Edit::RemoveMember { on, role: role(), member: old }, Edit::AddMember { on, role: role(), member: new }];
    finding.with(new, "stop line of its lanes").fixed_by(format!("use stop line {own} instead"), false, edits)
}

/// A crosswalk's line that a vehicle meets only when it has crossed.
fn behind(
    map: &MapIndex,
    params: &Params,
    element: &RegulatoryElement,
    way: LineStringId,
    crossed: &[&StopLineCrossing],
) -> Option<Finding> {
    if element.subtype != "crosswalk" {
        return None;
    }
    let walks: Vec<&Lane> = element.lanelets("refers").filter_map(|id| map.lane_of(id)).collect();
    // Every lane that has both of them has to pass the line first; lanes that have the line alone lead there.
    let mut worst: Option<(f64, &StopLineCrossing)> = None;
    // Prolonged, the line reaches into the lane beside, which comes over the crosswalk the other way.
    for &crossing in crossed.iter().filter(|crossing| crossing.span > 0.5) {
        let entries = walks.iter().filter_map(|walk| entry(&map.lanes[crossing.lane], walk));
        let first = entries.fold(f64::INFINITY, f64::min);
        if !first.is_finite() || crossing.station <= first + params.behind {
            return None;
        }
        let late = crossing.station - first;
        if worst.is_none_or(|(known, _)| late > known) {
            worst = Some((late, crossing));
        }
    }
    let (late, crossing) = worst?;
    let id = map.lanes[crossing.lane].id;
    let message = format!(
        "Stop line {way} of crosswalk {} lies {late:.1} m behind the near edge of the crosswalk on lanelet {id}.",
        element.id
    );
    let finding = Finding::new("behind", Subject::LineString(way.0), message);
    let finding = finding.with(Subject::RegulatoryElement(element.id.0), "element");
    Some(finding.with(Subject::Lanelet(id.0), "lanelet").measured(late, params.behind, "m"))
}

/// Where a lane's middle first enters a crosswalk, metres from its start.
fn entry(lane: &Lane, walk: &Lane) -> Option<f64> {
    let center: &Polyline = lane.center.as_ref()?;
    if polygon::contains(&walk.outline, center.first()) {
        return Some(0.0);
    }
    let stations = center.stations();
    let ring = walk.outline.iter().zip(walk.outline.iter().cycle().skip(1));
    let ring: Vec<(Point, Point)> = ring.map(|(a, b)| (*a, *b)).collect();
    center.segments().zip(stations).find_map(|((a, b), before)| {
        let hits = ring.iter().filter_map(|&(c, d)| segment_crossing(a, b, c, d));
        hits.map(|(.., place)| before + (place - a).norm()).min_by(f64::total_cmp)
    })
}
