//! A worked example from the intersection module's README: a crossing of four roads, with lights and without, whose `right_of_way`
//! elements name the lanes of its table. What the planner watches there was derived from its text; its pictures were not at hand.
//!
//! Source: autoware_universe, `autoware_behavior_velocity_intersection_module/README.md` (6eac070c), "How-to/Why set RightOfWay tag".

use std::collections::{BTreeMap, BTreeSet};

use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::builder::{BuildOptions, build};
use lanewright::geometry::Vector;
use lanewright::lanelet::index::view::View;
use lanewright::lanelet::{Attributes, LaneletId, LaneletMap, Member, RegulatoryElement, RegulatoryElementId, Target};
use lanewright::planner::{Params, RoadNetwork, Watched};

use crate::common::drawing::osm;
use crate::common::root;

/// How a lanelet turns, from the side on which vehicles drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Turn {
    Straight,
    /// Left where vehicles keep left.
    Near,
    /// Over the lane of those who come toward it.
    Far,
}

/// The lanelets of a crossing: how each turns, and the direction of its approach.
type Crossing = BTreeMap<LaneletId, (Turn, Vector)>;

fn crossing(map: &LaneletMap, side: DrivingSide) -> Crossing {
    let turning = map.lanelets.iter().filter_map(|lanelet| {
        let turn = match (lanelet.attributes.get("turn_direction")?, side) {
            ("straight", _) => Turn::Straight,
            ("left", DrivingSide::Left) | ("right", DrivingSide::Right) => Turn::Near,
            _ => Turn::Far,
        };
        let first: Vec<_> = map.bound_points(lanelet.left).take(2).map(|point| point.position).collect();
        Some((lanelet.id, (turn, (first[1] - first[0]).normalize())))
    });
    turning.collect()
}

/// Whether two approaches are green together: those of one road.
fn in_phase(a: Vector, b: Vector) -> bool {
    a.dot(&b).abs() > 0.7
}

/// Whether the README's table lists the other lane as `yield`.
fn is_yield((turn, from): (Turn, Vector), (other, from_there): (Turn, Vector), lights: bool) -> bool {
    let together = in_phase(from, from_there);
    match (turn, lights) {
        (Turn::Straight, true) => false,
        (Turn::Straight, false) => together && other != Turn::Straight,
        (Turn::Near, true) => !together || other == Turn::Far,
        (Turn::Near, false) => together && other == Turn::Far,
        (Turn::Far, true) => !together,
        (Turn::Far, false) => false,
    }
}

/// Whom each lanelet watches, by the planner.
fn watched(map: &LaneletMap) -> BTreeMap<LaneletId, BTreeSet<LaneletId>> {
    let view = View::new(map);
    let network = RoadNetwork::new(&view);
    let inside = (0..view.lanelets.len()).filter(|&at| network.graph.passes(at) && network.turn(at).is_some());
    let told = inside.filter_map(|at| network.forecast(at, &[], &Params::default()));
    let ids = |list: &[Watched]| list.iter().map(|one| one.lanelet).collect();
    told.map(|one| (one.lanelet, ids(&one.watched))).collect()
}

/// Takes the elements of this subtype from a map.
fn without(map: &mut LaneletMap, subtype: &str) {
    let gone: BTreeSet<RegulatoryElementId> =
        map.regulatory_elements.iter().filter(|element| element.subtype == subtype).map(|element| element.id).collect();
    map.regulatory_elements.retain(|element| !gone.contains(&element.id));
    let ids: Vec<LaneletId> = map.lanelets.iter().map(|lanelet| lanelet.id).collect();
    for id in ids {
        map.lanelets.get_mut(id).unwrap().regulatory_elements.retain(|element| !gone.contains(element));
    }
}

#[test]
fn the_yield_lanes_of_the_intersection_modules_readme() {
    for (sample, side) in [("crossing_left", DrivingSide::Left), ("crossing_right", DrivingSide::Right)] {
        let text = std::fs::read_to_string(root().join(format!("sample_maps/{sample}.osm"))).unwrap();
        let options = BuildOptions { driving_side: Some(side), ..BuildOptions::default() };
        let built = build(&osm(text), &options).unwrap().map;
        let crossing = crossing(&built, side);
        assert_eq!(crossing.len(), 12, "{sample}: three ways on from each of four roads");
        for (lights, counts) in [(true, [0, 0, 2]), (false, [5, 1, 6])] {
            let mut map = built.clone();
            without(&mut map, "right_of_way");
            if !lights {
                without(&mut map, "traffic_light");
                without(&mut map, "traffic_sign");
            }
            let unruled = {
                let mut map = map.clone();
                without(&mut map, "traffic_light");
                watched(&map)
            };
            for (number, (&id, &own)) in (1..).zip(&crossing) {
                let yields = unruled[&id].iter().filter(|other| is_yield(own, crossing[*other], lights));
                let yields: Vec<Member> =
                    yields.map(|other| Member { role: "yield".into(), target: Target::Lanelet(*other) }).collect();
                if yields.is_empty() {
                    continue;
                }
                let itself = Member { role: "right_of_way".into(), target: Target::Lanelet(id) };
                let element = RegulatoryElementId(number);
                map.regulatory_elements.insert(RegulatoryElement {
                    id: element,
                    subtype: "right_of_way".into(),
                    members: [vec![itself], yields].concat(),
                    attributes: Attributes::default(),
                    span: None,
                });
                map.lanelets.get_mut(id).unwrap().regulatory_elements.push(element);
            }
            let all = watched(&map);
            for (id, own) in &crossing {
                let count = counts[own.0 as usize];
                assert_eq!(all[id].len(), count, "{sample}, lights {lights}: {:?} {id} watches {:?}", own.0, all[id]);
                // Without lights all cross traffic is watched; with lights only who comes toward the vehicle.
                let toward = all[id].iter().filter(|other| in_phase(own.1, crossing[*other].1)).count();
                let expected = match (own.0, lights) {
                    (Turn::Far, _) => 2,
                    _ => 0,
                };
                assert_eq!(toward, expected, "{sample}, lights {lights}: {:?} {id}", own.0);
            }
        }
    }
}
