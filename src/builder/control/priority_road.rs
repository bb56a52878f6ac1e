//! Priority roads: who gives way at intersections without signs, by the tags of the roads.

/// Which arms give way to a priority road; `None` if that is uncertain. A lane may only ignore another if it is certain which of
/// them waits: the priority road has two legs at the intersection, straight or with a bend, no sign on it contradicts, and another
/// road meets it.
pub fn give_way(arms: &[PriorityArm]) -> Option<Vec<bool>> {
    let mut through: Vec<usize> = arms.iter().filter(|arm| arm.priority_road).map(|arm| arm.leg).collect();
    through.sort_unstable();
    through.dedup();
    let [_, _] = through[..] else { return None };
    let gives_way: Vec<bool> = arms.iter().map(|arm| !through.contains(&arm.leg)).collect();
    let contradicted = arms.iter().zip(&gives_way).any(|(arm, gives_way)| {
        let in_part = !arm.priority_road && !gives_way;
        arm.leads_in && (arm.signed && !gives_way || in_part)
    });
    (gives_way.contains(&true) && !contradicted).then_some(gives_way)
}

/// A road end at an intersection.
#[derive(Clone, Copy, Debug)]
pub struct PriorityArm {
    /// The first arm, by index, of its leg: carriageways on both sides of a median are one leg.
    pub leg: usize,
    /// Whether it belongs to a priority road.
    pub priority_road: bool,
    /// Whether lanes lead in.
    pub leads_in: bool,
    /// Whether a stop or give-way sign stands there.
    pub signed: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builder::BuildOptions;
    use crate::builder::tests::{Asked, built_as};
    use crate::geometry::Point;

    /// Legs with a letter for each arm: `p` on a priority road, `s` with a sign on a priority road, `o` on another.
    fn gives_way(legs: &[&str]) -> Option<Vec<bool>> {
        let mut arms: Vec<PriorityArm> = Vec::new();
        for letters in legs {
            let leg = arms.len();
            arms.extend(letters.chars().map(|kind| PriorityArm {
                leg,
                priority_road: kind != 'o',
                leads_in: true,
                signed: kind == 's',
            }));
        }
        give_way(&arms)
    }

    /// By lanelets straight on: whether they ignore others, on a street with these tags; `None` on the one that crosses it.
    fn first(tags: &str) -> Vec<Option<bool>> {
        let nodes =
            [(1, 0.0, 0.0, ""), (2, -90.0, 0.0, ""), (3, 90.0, 0.0, ""), (4, 0.0, -90.0, ""), (5, 0.0, 90.0, "")];
        let (street, crossing) = (format!("highway=residential lanes=2 {tags}"), "highway=residential lanes=2");
        let ways: [(i64, &[i64], &str); 2] = [(10, &[2, 1, 3], &street), (11, &[4, 1, 5], crossing)];
        let map = built_as(&Asked { nodes: &nodes, ways: &ways, options: BuildOptions::default() }).map;
        let straight = map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("turn_direction", "straight"));
        let ways = straight.map(|lanelet| {
            let bound: Vec<Point> = map.bound_points(lanelet.left).map(|point| point.position).collect();
            let along = bound[bound.len() - 1] - bound[0];
            let own =
                map.regulatory_elements.iter().filter(|element| lanelet.regulatory_elements.contains(&element.id));
            let ignored: usize = own.map(|element| element.lanelets("yield").count()).sum();
            // Straight on it meets two that cross straight, four turns out of the crossing road, and one far turn.
            (along.x.abs() > along.y.abs()).then_some(ignored > 3)
        });
        let mut ways: Vec<Option<bool>> = ways.collect();
        ways.sort_unstable();
        ways
    }

    #[test]
    fn who_drives_on_a_priority_road_ignores_who_crosses_it() {
        assert_eq!(first("priority_road=designated"), [None, None, Some(true), Some(true)]);
        assert_eq!(first("priority_road=end"), [None, None, Some(false), Some(false)]);
        assert_eq!(first(""), [None, None, Some(false), Some(false)]);
    }

    #[test]
    fn others_give_way_to_a_priority_road_that_leads_through() {
        assert_eq!(gives_way(&["p", "o", "p", "o"]), Some(vec![false, true, false, true]));
        assert_eq!(gives_way(&["p", "p", "o"]), Some(vec![false, false, true]), "it bends");
        assert_eq!(gives_way(&["pp", "o", "pp"]), Some(vec![false, false, true, false, false]), "divided");
    }

    #[test]
    fn nobody_gives_way_where_it_is_not_certain() {
        assert_eq!(gives_way(&["o", "o", "o"]), None);
        assert_eq!(gives_way(&["p", "o", "o"]), None, "it ends here");
        assert_eq!(gives_way(&["p", "p", "p", "o"]), None, "two priority roads meet");
        assert_eq!(gives_way(&["p", "s", "o"]), None, "a sign says otherwise");
        assert_eq!(gives_way(&["p", "po", "o"]), None, "a carriageway of it is no priority road");
        assert_eq!(gives_way(&["p", "p"]), None, "nobody meets it");
    }
}
