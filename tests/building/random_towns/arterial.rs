//! A wide street of a suburb with car parks and drive-through lanes beside it, so close that no two cars find room between them.

use std::collections::BTreeMap;

use super::dice::Dice;
use super::plan::{Place, Plan};

/// Whole metres along the street and to its left.
type Spot = (i32, i32);

/// The tags of the ways, and the places over which they lead; where two have the same place they meet.
const WAYS: [(&str, &[Spot]); 14] = [
    ("highway=primary lanes=4", &[(-110, 0), (-45, 0), (-20, 0), (-5, 0), (0, 0), (22, 0), (27, 0), (62, 0), (110, 0)]),
    ("highway=residential", &[(0, 0), (0, 28), (2, 58), (6, 110)]),
    // Drive-through lanes between two driveways.
    (SERVICE, &[(-45, 0), (-44, 14), (-44, 20), (-44, 26), (-43, 31), (-20, 30), (0, 28), (22, 29)]),
    (SERVICE, &[(-20, 0), (-20, 14), (-20, 20), (-20, 26), (-20, 30)]),
    (SERVICE, &[(-44, 14), (-20, 14)]),
    (SERVICE, &[(-44, 20), (-20, 20)]),
    (SERVICE, &[(-44, 26), (-20, 26)]),
    // A car park.
    (SERVICE, &[(22, 0), (22, 16), (22, 29), (22, 37), (38, 37), (48, 36), (62, 35), (82, 34)]),
    (SERVICE, &[(-24, -72), (-22, -25), (-20, 0)]),
    (SERVICE, &[(62, 0), (62, 15), (48, 15), (38, 15), (22, 16)]),
    (SERVICE, &[(38, 15), (38, 37)]),
    (SERVICE, &[(48, 15), (48, 36)]),
    // The other side of the street.
    (SERVICE, &[(27, 0), (34, -22), (62, -24), (62, 0), (62, 15), (62, 35)]),
    (SERVICE, &[(-5, 0), (-5, -25), (-10, -86)]),
];
const SERVICE: &str = "highway=service";

/// The street with all its places some metres elsewhere, those on the street itself along it only.
pub fn arterial(dice: &mut Dice) -> Plan {
    let mut plan = Plan::default();
    let mut nodes: BTreeMap<Spot, usize> = BTreeMap::new();
    for (tags, places) in WAYS {
        let mut node = |spot: &Spot| {
            *nodes.entry(*spot).or_insert_with(|| {
                let aside = if spot.1 == 0 { 0.0 } else { dice.between(-2.0, 2.0) };
                let place: Place = [f64::from(spot.0) + dice.between(-3.0, 3.0), f64::from(spot.1) + aside];
                plan.node(place, "")
            })
        };
        let along = places.iter().map(&mut node).collect();
        plan.way(along, tags);
    }
    plan
}
