//! Crosswalks: a lanelet from kerb to kerb, and the regulatory element for every lane that crosses it.

use crate::builder::ids::Key;
use crate::builder::lanes::road_cut::{CROSSWALK_BREADTH, RoadCrossing};
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::Road;
use crate::geometry::{Point, left_of, polygon};
use crate::lanelet::{Attributes, Bound, LaneletId, PointId, Target};

/// A corner closer than this, metres, to a node of a cut is that node.
const SAME_NODE: f64 = 0.01;
/// A crosswalk reaches this far, metres, over the kerbs, as people draw it. Without this length a crosswalk over a single lane would
/// lie inside the lane, and TIER IV's validator would report two lanes that do not share their borders.
const OVER_KERB: f64 = 0.7;
/// Lanelets that share at least this area, square metres, with a crosswalk cross it.
const CROSSES: f64 = 0.1;

/// Adds the lanelet of a crossing, in the walking direction from the left kerb of the road's line to the right one. Corners that
/// lie on a node of the road's `cuts` are that node.
pub fn crosswalk(assembly: &mut MapBuilder, road: &Road, crossing: &RoadCrossing, cuts: &[PointId]) -> LaneletId {
    let key = Key::new("crosswalk").number(crossing.node).number(road.key.way).number(road.key.first);
    let (left, right) = road.section.carriageway();
    let (left, right) = (road.section.edge(left) + OVER_KERB, road.section.edge(right) - OVER_KERB);
    let direction = road.line.direction(crossing.station);
    let middle = road.line.at(crossing.station);
    let mut side = |name: &str, along: f64| {
        let ends = [("from", left), ("to", right)].map(|(end, offset)| {
            let place = middle + direction * along + left_of(direction) * offset;
            let known = cuts.iter().copied().find(|&cut| (assembly.position(cut) - place).norm() < SAME_NODE);
            known.unwrap_or_else(|| assembly.point(key.word(name).word(end), place, 0.0))
        });
        assembly.line(key.word(name), ends.to_vec(), Attributes::of(&[("type", "pedestrian_marking")]))
    };
    // The road's direction is to the left of the walking direction.
    let bounds = [side("left", CROSSWALK_BREADTH / 2.0), side("right", -CROSSWALK_BREADTH / 2.0)];
    let [left, right] = bounds.map(|line| Bound { line, inverted: false });
    assembly.lanelet(key, left, right, pedestrian_attributes("crosswalk"))
}

/// Tags of a lanelet for people on foot.
pub(crate) fn pedestrian_attributes(subtype: &str) -> Attributes {
    Attributes::of(&[
        ("type", "lanelet"),
        ("subtype", subtype),
        ("location", "urban"),
        ("one_way", "no"),
        ("participant:pedestrian", "yes"),
    ])
}

/// Adds the element of a crosswalk for the lanelets that cross it; `false` if there is none.
pub fn announce<'a>(
    assembly: &mut MapBuilder,
    crosswalk: LaneletId,
    lanes: impl Iterator<Item = (LaneletId, &'a [Point])>,
) -> bool {
    let area = assembly.outline(crosswalk);
    let carriers: Vec<LaneletId> =
        lanes.filter(|(_, outline)| polygon::common_area(&area, outline) >= CROSSES).map(|(id, _)| id).collect();
    if carriers.is_empty() {
        return false;
    }
    let key = Key::new("crosswalk element").number(crosswalk.0);
    assembly.element(key, "crosswalk", &[("refers", Target::Lanelet(crosswalk))], &carriers);
    true
}

#[cfg(test)]
mod tests {
    use crate::builder::tests::{Asked, built_as};
    use crate::builder::{BuildOptions, Built};

    /// Three streets meet; people cross the one in the west between its end and the middle.
    fn crossing(west: &str, north: &str, east: &str) -> Built {
        let nodes = [
            (1, 0.0, 0.0, ""),
            (2, -80.0, 0.0, ""),
            (3, 0.0, 80.0, ""),
            (4, 80.0, 0.0, ""),
            (5, -9.0, 0.0, "highway=crossing"),
        ];
        let street = |tags| format!("highway=residential lanes=1 {tags}");
        let [west, north, east] = [west, north, east].map(street);
        let ways: [(i64, &[i64], &str); 3] = [(10, &[2, 5, 1], &west), (11, &[3, 1], &north), (12, &[4, 1], &east)];
        built_as(&Asked { nodes: &nodes, ways: &ways, options: BuildOptions::default() })
    }

    /// How many crosswalks there are, elements that tell of them, and notes of those left out.
    fn found(built: &Built) -> [usize; 3] {
        let map = &built.map;
        [
            map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "crosswalk")).count(),
            map.regulatory_elements.iter().filter(|element| element.subtype == "crosswalk").count(),
            built.notes.iter().filter(|note| note.fault == "crosswalk-idle").count(),
        ]
    }

    #[test]
    fn a_crosswalk_that_no_lane_crosses_is_left_out() {
        let [to, from] = ["oneway=yes", "oneway=-1"];
        assert_eq!(found(&crossing(to, to, from)), [1, 1, 0]);
        assert_eq!(found(&crossing(from, from, to)), [1, 1, 0]);
        // All come in, and none gets out.
        assert_eq!(found(&crossing(to, to, to)), [0, 0, 1]);
    }

    #[test]
    fn both_carriageways_around_an_island_have_one_crosswalk() {
        let crossing = "highway=crossing crossing=zebra";
        let nodes = [
            (1, -80.0, 0.0, ""),
            (2, 0.0, 0.0, ""),
            (3, 30.0, 4.0, crossing),
            (4, 30.0, -4.0, crossing),
            (5, 60.0, 0.0, ""),
            (6, 140.0, 0.0, ""),
        ];
        let ways: [(i64, &[i64], &str); 4] = [
            (10, &[1, 2], "highway=secondary name=A"),
            (11, &[5, 3, 2], "highway=secondary name=A oneway=yes"),
            (12, &[2, 4, 5], "highway=secondary name=A oneway=yes"),
            (13, &[5, 6], "highway=secondary name=A"),
        ];
        assert_eq!(
            found(&built_as(&Asked { nodes: &nodes, ways: &ways, options: BuildOptions::default() })),
            [1, 1, 0]
        );
    }

    #[test]
    fn lanes_that_go_on_through_lights_have_the_element_of_the_crosswalk_before_them() {
        let nodes = [
            (1, 0.0, 0.0, "highway=traffic_signals"),
            (2, -80.0, 0.0, ""),
            (3, 80.0, 0.0, ""),
            (4, -8.0, 0.0, "highway=crossing crossing=traffic_signals"),
        ];
        let ways: [(i64, &[i64], &str); 2] = [
            (10, &[2, 4, 1], "highway=residential oneway=yes lanes=1 name=A"),
            (11, &[1, 3], "highway=residential oneway=yes lanes=1 name=B"),
        ];
        let built = built_as(&Asked { nodes: &nodes, ways: &ways, options: BuildOptions::default() });
        assert_eq!(found(&built), [1, 1, 0]);
    }
}
