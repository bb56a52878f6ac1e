//! vm-01-09: a speed limit is a number of km/h that can be.

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::LaneletId;
use crate::lanelet::index::MapIndex;
use crate::lanelet::number::{number, speed_with_unit};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    min_speed_limit: f64,
    max_speed_limit: f64,
    /// Whether a limit with its unit is wrong: Lanelet2 reads it, TIER IV's validator does not.
    numbers_only: bool,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let roads = map.map.lanelets.iter().filter(|one| matches!(one.attributes.get("subtype"), Some("road" | "private")));
    let limits = roads.filter_map(|lanelet| Some((lanelet.id, lanelet.attributes.get("speed_limit")?)));
    let findings = limits.filter_map(|(id, said)| {
        let finding = |fault, message| Some(Finding::new(fault, Subject::Lanelet(id.0), message));
        let (low, high) = (params.min_speed_limit, params.max_speed_limit);
        if let Some(speed) = speed_with_unit(said).filter(|speed| *speed > 0.0 && !params.numbers_only) {
            return Some(with_unit(id, said, speed));
        }
        match number(said) {
            Some(speed) if speed > 0.0 && (speed < low || speed > high) => {
                let limit = if speed < low { low } else { high };
                let message = format!("speed_limit={said} of lanelet {id} is outside {low} to {high} km/h.");
                Some(finding("speed-range", message)?.measured(speed, limit, "km/h"))
            }
            // C reads `nan` as a number, and every comparison with it is false.
            Some(speed) if speed > 0.0 || speed.is_nan() => None,
            _ => finding("speed-invalid", format!("speed_limit={said} of lanelet {id} is no positive number.")),
        }
    });
    let in_metres = in_metres_per_second(map);
    findings.chain(in_metres).collect()
}

/// Limits of lanelets and of `speed_limit` elements that read like metres per second.
fn in_metres_per_second<'m>(map: &'m MapIndex) -> impl Iterator<Item = Finding> + 'm {
    let lanelets = map.map.lanelets.iter().map(|one| (Subject::Lanelet(one.id.0), "speed_limit", &one.attributes));
    let elements = map.map.regulatory_elements.iter().filter(|one| one.subtype == "speed_limit");
    let elements = elements.map(|one| (Subject::RegulatoryElement(one.id.0), "sign_type", &one.attributes));
    lanelets.chain(elements).filter_map(|(on, key, tags)| {
        let said = tags.get(key)?;
        let decimals = said.trim().split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let meant = meant_in_metres(number(said)?, decimals)?;
        let message = format!("{key}={said} of {on} counts in km/h, and reads like {meant} km/h in metres per second.");
        let edits = vec![Edit::SetTag { on, key: key.into(), value: meant.to_string().into() }];
        Some(Finding::new("speed-metres", on, message).fixed_by(format!("set {key}={meant}"), false, edits))
    })
}

/// The limit that somebody meant who wrote metres per second, km/h: of a number with decimals, that makes a round one in km/h or in mph.
fn meant_in_metres(said: f64, decimals: usize) -> Option<f64> {
    /// Signs say multiples of this, km/h or mph.
    const STEP: f64 = 5.0;
    const KMH: f64 = 3.6;
    const MPH: f64 = 3.6 / 1.609_344;
    // Half of the last decimal, and at most what a third one says: factors are rounded, too.
    let rounded = (0.5 * 0.1_f64.powi(decimals.min(3) as i32)).max(0.0005) + 0.001;
    let is_multiple = |value: f64, step: f64, off: f64| (value - (value / step).round() * step).abs() <= off;
    let is_round = |factor: f64| is_multiple(said * factor, STEP, rounded * factor);
    // A round limit in mph may stand there in km/h.
    let is_mph = is_round(MPH / KMH);
    let can_be = said > 1.0 && !is_multiple(said, 0.5, 0.001) && !is_mph && (is_round(KMH) || is_round(MPH));
    can_be.then(|| (said * KMH).round())
}

/// A limit that Lanelet2 reads with its unit; other programs that read the map may not.
fn with_unit(id: LaneletId, said: &str, speed: f64) -> Finding {
    // A tenth is more than any sign says.
    let value = ((speed * 10.0).round() / 10.0).to_string();
    let on = Subject::Lanelet(id.0);
    let message = format!("speed_limit={said} of lanelet {id} has a unit; a number of km/h is wanted.");
    let edits = vec![Edit::SetTag { on, key: "speed_limit".into(), value: value.as_str().into() }];
    Finding::new("speed-unit", on, message).fixed_by(format!("set speed_limit={value}"), true, edits)
}
