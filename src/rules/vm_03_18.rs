//! vm-03-18: the sections of two virtual traffic lights on one way do not overlap.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::Point;
use crate::lanelet::index::MapIndex;

use super::NoParams;
use super::virtual_light::{Section, lights, sections};

/// Sections that overlap by less than this (m) only touch.
const TOUCH: f64 = 0.1;

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let all: Vec<Section> = lights(map)
        .flat_map(|light| {
            let lanes = map.referrers(light.id).iter().filter_map(|&id| map.lane(id));
            lanes.flat_map(move |lane| sections(map, light, lane).unwrap_or_default())
        })
        // Lines out of order are vm-03-16's.
        .filter(|section| section.start < section.end)
        .collect();
    let mut of_lane: FxHashMap<usize, Vec<usize>> = FxHashMap::default();
    let mut said = FxHashSet::default();
    let mut findings = Vec::new();
    for (at, section) in all.iter().enumerate() {
        for &lane in &section.path {
            let others = of_lane.entry(lane).or_default();
            for other in others.iter().map(|&other| &all[other]) {
                if other.light.id != section.light.id
                    && let Some(length) = common(map, section, other)
                    && said.insert((section.light.id.min(other.light.id), section.light.id.max(other.light.id)))
                {
                    findings.push(finding(map, section, other, lane, length));
                }
            }
            others.push(at);
        }
    }
    findings
}

/// Over how many metres two sections lie on each other, if a vehicle can drive through both in one go. Ways that part
/// behind the start lines are two ways.
fn common(map: &MapIndex, a: &Section, b: &Section) -> Option<f64> {
    let ahead = |first: &Section, second: &Section| {
        let at = first.path.iter().position(|lane| *lane == second.path[0])?;
        let agree = first.path[at..].iter().zip(&second.path).all(|(x, y)| x == y);
        let shift: f64 = first.path[..at].iter().map(|&lane| map.lanes[lane].length()).sum();
        agree.then(|| first.end.min(second.end + shift) - first.start.max(second.start + shift))
    };
    ahead(a, b).or_else(|| ahead(b, a)).filter(|length| *length > TOUCH)
}

fn finding(map: &MapIndex, a: &Section, b: &Section, lane: usize, length: f64) -> Finding {
    let (first, second) = (a.light.id.min(b.light.id), a.light.id.max(b.light.id));
    let lane = &map.lanes[lane];
    let message = format!(
        "Virtual traffic light {first}: its section overlaps that of {second} by {length:.1} m on lanelet {}.",
        lane.id
    );
    let center: Vec<Point> = lane.center.iter().flat_map(|center| center.points().iter().copied()).collect();
    Finding::new("overlap", Subject::RegulatoryElement(first.0), message)
        .with(Subject::RegulatoryElement(second.0), "other light")
        .with(Subject::Lanelet(lane.id.0), "lanelet")
        .measured(length, 0.0, "m")
        .at(Place::Line(center))
}
