//! What OpenStreetMap says of an intersection and the map cannot: goes beside it into `lanewright.toml`.

use crate::geometry::Vector;
use crate::lanelet::PolygonId;
use crate::lanelet::right_of_way::Mover;
use crate::settings::{ApproachName, IntersectionSettings};

use super::lanes::{Arm, Lanes};

/// Compass names, clockwise from north, one for every 45 degrees.
const COMPASS: [&str; 8] = ["N", "NE", "E", "SE", "S", "SW", "W", "NW"];

/// The side of the intersection on which an arm lies, from its direction into the intersection.
fn compass(inward: Vector) -> &'static str {
    let bearing = (-inward.x).atan2(-inward.y).to_degrees().rem_euclid(360.0);
    COMPASS[(bearing / 45.0).round() as usize % 8]
}

/// The names of all arms: compass names, ids of its lanelets where two arms would share one.
pub fn names(arms: &[&Arm], lanes: &Lanes) -> Vec<ApproachName> {
    let sides: Vec<&str> = arms.iter().map(|a| compass(a.inward)).collect();
    arms.iter()
        .zip(&sides)
        .map(|(arm, side)| {
            if sides.iter().filter(|s| *s == side).count() == 1 {
                return ApproachName::Compass((*side).to_owned());
            }
            let own = arm.into.iter().chain(&arm.out).map(|l| lanes.lanes[l.lane].lanelet.0);
            ApproachName::Ids(own.collect())
        })
        .collect()
}

/// The settings of one intersection; `None` if there is nothing to say.
pub fn settings(
    area: PolygonId,
    names: &[ApproachName],
    prohibited: &[(usize, usize)],
    movers: &[Mover],
) -> Option<IntersectionSettings> {
    let mut arms: Vec<usize> =
        movers.iter().filter(|m| m.priority == Some(true) && !m.signalised).map(|m| m.arm).collect();
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
