//! What OpenStreetMap tells of an intersection and the map cannot express: its entry in `lanewright.toml`.

use crate::builder::lanes::types::{Arm, Lanes};
use crate::geometry::Vector;
use crate::lanelet::PolygonId;
use crate::lanelet::right_of_way::RankedMovement;
use crate::settings::{ApproachName, IntersectionSettings};

/// Compass names, clockwise from north, one for every 45 degrees.
const COMPASS: [&str; 8] = ["N", "NE", "E", "SE", "S", "SW", "W", "NW"];

/// A direction closer than this, degrees, to the border between two sides has the names of both: measured on the lanes, it may
/// lie on either side.
const UNSURE: f64 = 10.0;

/// The sides of the intersection on which an arm may lie, by the direction of its vehicles.
fn sides(inward: Vector) -> [&'static str; 2] {
    let bearing = (-inward.x).atan2(-inward.y).to_degrees();
    [bearing - UNSURE, bearing + UNSURE].map(|b| COMPASS[(b.rem_euclid(360.0) / 45.0).round() as usize % COMPASS.len()])
}

/// The names of all arms: compass names, ids of its lanelets where another arm might be taken for it. `headings` are the
/// directions in which vehicles head who arrive; where none do, the arm's own counts.
pub fn names(arms: &[&Arm], headings: &[Option<Vector>], lanes: &Lanes) -> Vec<ApproachName> {
    let sides: Vec<[&str; 2]> =
        arms.iter().zip(headings).map(|(arm, heading)| sides(heading.unwrap_or(arm.inward))).collect();
    arms.iter()
        .zip(&sides)
        .map(|(arm, [side, other])| {
            if side == other && sides.iter().filter(|s| s.contains(side)).count() == 1 {
                return ApproachName::Compass((*side).to_owned());
            }
            let own = arm.into.iter().chain(&arm.out).map(|l| lanes.lanes[l.lane].lanelet.0);
            ApproachName::Ids(own.collect())
        })
        .collect()
}

/// The settings of one intersection; `None` if there are none.
pub fn settings(
    area: PolygonId,
    names: &[ApproachName],
    prohibited: &[(usize, usize)],
    ranked: &[RankedMovement],
) -> Option<IntersectionSettings> {
    let mut arms: Vec<usize> =
        ranked.iter().filter(|m| m.priority == Some(true) && !m.signalised).map(|m| m.arm).collect();
    arms.sort_unstable();
    arms.dedup();
    let settings = IntersectionSettings {
        ia: Some(area.0),
        priority_arms: arms.into_iter().map(|a| names[a].clone()).collect(),
        prohibited: prohibited.iter().map(|&(a, b)| [names[a].clone(), names[b].clone()]).collect(),
        ..IntersectionSettings::default()
    };
    (!settings.priority_arms.is_empty() || !settings.prohibited.is_empty()).then_some(settings)
}
