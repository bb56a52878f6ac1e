//! Edits in any order give, to the last bit, the same weave as weaving the edited lanes all at once.

use std::collections::BTreeMap;

use lanewright::geometry::{Point, Polyline};
use lanewright::lane_stitching::{
    Kind, Lane, LaneEnd, LaneId, LaneStitching, Marking, Paint, StitchedLane, WidthAt, Widths,
};
use proptest::prelude::*;

/// The description of a random lane, in numbers so small that ends often meet.
#[derive(Clone, Debug)]
struct Sketch {
    /// Places on a grid of 10 m.
    points: Vec<(i8, i8)>,
    /// Points between two of them.
    between: usize,
    widths: [u8; 2],
    nodes: [Option<i64>; 2],
    kinds: Vec<(u8, usize)>,
    explicit: bool,
}

const KINDS: [Kind; 9] = [
    Kind::Solid(Paint::White),
    Kind::Dashed(Paint::White),
    Kind::Dotted(Paint::Yellow),
    Kind::Double(Paint::Yellow),
    Kind::SolidDashed(Paint::White),
    Kind::DashedSolid(Paint::White),
    Kind::Kerb,
    Kind::Virtual,
    Kind::Unknown,
];

impl Sketch {
    /// The lane; `None` where its points lie on each other.
    fn lane(&self) -> Option<Lane> {
        let middle = Polyline::new(self.points.iter().map(|&(x, y)| Point::new(f64::from(x), f64::from(y)) * 10.0))?;
        let count = (middle.points().len() - 1) * self.between + 1;
        let middle = if self.between > 1 { middle.resampled_to(count) } else { middle };
        let [start, end] = self.widths.map(|width| 1.0 + f64::from(width) / 4.0);
        let at = |station, half| WidthAt { station, left: half, right: half };
        let lane = if self.explicit {
            let bounds = [0.5, -0.5].map(|side| middle.offset(start * side, 2.0));
            let [Some(left), Some(right)] = bounds else { return None };
            Lane::between([left, right])
        } else {
            Lane::along(middle, Widths::new(vec![at(1.0, start), at(15.0, end)]).unwrap())
        };
        let mut station = 0.0;
        let mut marking = |&(gap, kind): &(u8, usize)| {
            station += f64::from(gap) + 0.5;
            Marking { station, kinds: vec![KINDS[kind]] }
        };
        let side: Vec<Marking> = self.kinds.iter().map(&mut marking).collect();
        Some(lane.unwrap().on_nodes(self.nodes).painted([side.clone(), side]).unwrap())
    }
}

#[derive(Clone, Debug)]
enum Edit {
    Set(i64, u32, Sketch),
    Remove(i64, u32),
    Road(i64, Vec<Sketch>),
    Exclude(Option<(i64, u32)>),
}

fn sketch() -> impl Strategy<Value = Sketch> {
    let point = (-2_i8..3, -2_i8..3);
    let node = || prop::option::weighted(0.3, 0_i64..6);
    (
        prop::collection::vec(point, 2..6),
        1_usize..9,
        [0_u8..12, 0_u8..12],
        [node(), node()],
        prop::collection::vec((0_u8..20, 0..KINDS.len()), 0..4),
        prop::bool::weighted(0.1),
    )
        .prop_map(|(points, between, widths, nodes, kinds, explicit)| Sketch {
            points,
            between,
            widths,
            nodes,
            kinds,
            explicit,
        })
}

fn edit() -> impl Strategy<Value = Edit> {
    let name = || (0_i64..8, 0_u32..3);
    prop_oneof![
        6 => (name(), sketch()).prop_map(|((road, lane), sketch)| Edit::Set(road, lane, sketch)),
        2 => name().prop_map(|(road, lane)| Edit::Remove(road, lane)),
        2 => (0_i64..8, prop::collection::vec(sketch(), 0..4)).prop_map(|(road, lanes)| Edit::Road(road, lanes)),
        1 => prop::option::of(name()).prop_map(Edit::Exclude),
    ]
}

/// All that a woven lane consists of, as bytes.
fn bytes(lane: &StitchedLane) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut line = |points: &[Point]| {
        bytes.extend(points.len().to_le_bytes());
        points.iter().for_each(|p| [p.x, p.y].iter().for_each(|v| bytes.extend(v.to_le_bytes())));
    };
    lane.bounds().iter().for_each(|bound| line(bound));
    line(lane.outline());
    lane.strokes().iter().for_each(|stroke| line(stroke.line));
    for stroke in lane.strokes().iter() {
        bytes.extend(format!("{}{:?}{:?}", stroke.side, stroke.kind, stroke.colour).bytes());
    }
    bytes
}

fn all(weave: &LaneStitching) -> BTreeMap<LaneId, Vec<u8>> {
    weave.iter().map(|(id, lane)| (id, bytes(lane))).collect()
}

/// The lanes of a weave, woven all at once.
fn rebuilt(weave: &LaneStitching) -> LaneStitching {
    let mut anew = LaneStitching::new(weave.iter().map(|(id, _)| (id, weave.lane(id).unwrap().clone())));
    anew.exclude(weave.excluded());
    anew
}

fn apply(weave: &mut LaneStitching, edit: &Edit) -> Vec<LaneId> {
    match edit {
        Edit::Set(road, lane, sketch) => {
            sketch.lane().map_or_else(Vec::new, |made| weave.set(LaneId { road: *road, lane: *lane }, made))
        }
        Edit::Remove(road, lane) => weave.remove(LaneId { road: *road, lane: *lane }),
        Edit::Road(road, sketches) => weave.set_road(*road, sketches.iter().filter_map(Sketch::lane)),
        Edit::Exclude(lane) => weave.exclude(lane.map(|(road, lane)| LaneId { road, lane })),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 192, ..ProptestConfig::default() })]

    #[test]
    fn edits_give_what_a_rebuild_gives(
        first in prop::collection::vec(((0_i64..8, 0_u32..3), sketch()), 0..16),
        edits in prop::collection::vec(edit(), 1..24),
    ) {
        let named = first.iter().filter_map(|((road, lane), sketch)| {
            Some((LaneId { road: *road, lane: *lane }, sketch.lane()?))
        });
        let mut weave = LaneStitching::new(named);
        for edit in &edits {
            let before = all(&weave);
            let anew = apply(&mut weave, edit);
            let after = all(&weave);
            let whole = rebuilt(&weave);
            prop_assert_eq!(&after, &all(&whole), "after {:?}", edit);
            for (id, _) in weave.iter() {
                for end in LaneEnd::BOTH {
                    prop_assert_eq!(weave.meeting(id, end), whole.meeting(id, end));
                }
            }
            // What was not named as made anew is as it was.
            let named = |id: &LaneId| anew.contains(id);
            for id in before.keys().chain(after.keys()).filter(|id| !named(id)) {
                prop_assert_eq!(before.get(id), after.get(id), "{:?} after {:?}", id, edit);
            }
            prop_assert!(weave.iter().all(|(_, lane)| lane.outline().iter().all(|p| p.x.is_finite() && p.y.is_finite())));
        }
    }

    #[test]
    fn the_order_of_lanes_does_not_matter(
        lanes in prop::collection::vec(sketch(), 0..16),
        turn in 0_usize..16,
    ) {
        let mut named: Vec<(LaneId, Lane)> = lanes
            .iter()
            .filter_map(Sketch::lane)
            .zip(0..)
            .map(|(lane, road)| (LaneId { road, lane: 0 }, lane))
            .collect();
        let weave = LaneStitching::new(named.clone());
        let turn = turn.min(named.len());
        named.rotate_left(turn);
        prop_assert_eq!(all(&weave), all(&LaneStitching::new(named)));
    }
}

#[test]
fn an_edit_reaches_no_farther_than_the_lanes_that_it_is_joined_to() {
    let middle = |points: &[(f64, f64)]| Polyline::new(points.iter().map(|&(x, y)| Point::new(x, y))).unwrap();
    let lane = |points: &[(f64, f64)]| Lane::along(middle(points), Widths::even(3.0).unwrap()).unwrap();
    let id = |road| LaneId { road, lane: 0 };
    let at = |i: i64| (i as f64 * 30.0, (i % 3) as f64);
    let mut weave = LaneStitching::new((0..20).map(|i| (id(i), lane(&[at(i), at(i + 1)]))));
    // Its bounds leave the joints in another direction; then only a bend in its middle changes.
    let bent = |y: f64| lane(&[at(9), (273.0, 0.3), (279.0, 0.3), (285.0, y), (291.0, 0.6), (297.0, 0.6), at(10)]);
    assert_eq!(weave.set(id(9), bent(1.0)), [id(8), id(9), id(10)]);
    assert_eq!(weave.set(id(9), bent(1.5)), [id(9)]);
    assert_eq!(weave.set_road(9, []), [id(8), id(9), id(10)]);
    assert_eq!(weave.remove(id(9)), []);
    assert_eq!(weave.set_road(9, [lane(&[at(9), at(10)])]), [id(8), id(9), id(10)]);
    assert_eq!(weave.exclude(Some(id(9))), [id(8), id(9), id(10)]);
    assert_eq!(weave.exclude(Some(id(9))), []);
}
