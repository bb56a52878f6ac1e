//! Guide lines between the lanes of one turn: dashes on the bound that two lanes share, as long as the lanes that begin
//! together run together.

use std::collections::BTreeMap;

use crate::builder::ids::Key;
use crate::builder::postprocess::map_editor::MapEditor;
use crate::geometry::Polyline;
use crate::lanelet::index::{MapIndex, Movement, Traffic};
use crate::lanelet::right_of_way::Turn;
use crate::lanelet::{Attributes, LineStringId};

use super::stop_line::drivable;

/// Lanes that begin together have parted where their bounds are this far, metres, from each other.
const APART: f64 = 0.1;
/// Where they part is looked for in steps of this length, metres.
const STEP: f64 = 0.25;
/// Nobody paints a line shorter than this, metres.
const SHORTEST: f64 = 5.0;

/// A guide line, before it is drawn.
pub struct Guide {
    /// The bound that it marks.
    pub bound: LineStringId,
    /// Whether the lanes that it leads run against the bound.
    inverted: bool,
    /// How far it runs along the bound, metres; `None`: all along.
    length: Option<f64>,
}

/// The guide lines between the lanes of the turns of an intersection.
pub fn between_lanes(map: &MapIndex, traffic: &Traffic) -> Vec<Guide> {
    let mut turns: BTreeMap<(usize, usize), Vec<&Movement>> = BTreeMap::new();
    for movement in drivable(map, traffic).filter(|movement| movement.mover.turn != Turn::Straight) {
        turns.entry((movement.from, movement.to)).or_default().push(movement);
    }
    let mut guides: Vec<Guide> = Vec::new();
    for movements in turns.values() {
        for left in movements {
            let shared = map.lanes[left.lane].bounds[1];
            let beside = |right: &&&Movement| map.lanes[right.lane].bounds[0] == shared;
            let Some(right) = movements.iter().find(beside) else { continue };
            if guides.iter().all(|guide| guide.bound != shared) {
                let together = [(*left, 1), (*right, 0)].map(|(of, side)| together(map, traffic, of, side));
                guides.extend(guide(map, left.lane, shared, together));
            }
        }
    }
    guides
}

/// The guide line on a lane's right bound; `None` where too little is left of it.
fn guide(map: &MapIndex, lane: usize, bound: LineStringId, together: [Option<f64>; 2]) -> Option<Guide> {
    let length = together.into_iter().flatten().min_by(f64::total_cmp);
    let whole = map.lanes[lane].border(1)?.length();
    let lanelet = map.map.lanelets.get(map.lanes[lane].id)?;
    let inverted = lanelet.right.inverted;
    (length.unwrap_or(whole) >= SHORTEST).then_some(Guide { bound, inverted, length })
}

/// How far, metres, the bound of a movement runs on those of the movements that begin with it and turn as it does;
/// `None`: all along.
fn together(map: &MapIndex, traffic: &Traffic, movement: &Movement, side: usize) -> Option<f64> {
    let bound = |lane: usize| map.lanes[lane].border(side);
    let own = bound(movement.lane)?;
    let alike = |other: &usize| {
        let turn = |x: usize| traffic.movements[x].mover.turn;
        let own_line = map.lanes[*other].bounds[side] == map.lanes[movement.lane].bounds[side];
        !own_line && traffic.of_lane(*other).is_some_and(|x| turn(x) == movement.mover.turn)
    };
    let others: Vec<Polyline> = map.siblings(movement.lane).filter(alike).filter_map(bound).collect();
    let steps = (own.length() / STEP) as usize;
    let parted = |step: &usize| others.iter().any(|other| other.distance(own.at(*step as f64 * STEP)) > APART);
    (0..=steps).find(parted).map(|step| (step.max(1) - 1) as f64 * STEP)
}

/// Draws a line over the nodes of its bound; nothing else uses it.
pub fn draw(pen: &mut MapEditor, Guide { bound, inverted, length }: Guide) {
    let Some(mut nodes) = pen.map.linestrings.get(bound).map(|line| line.points.clone()) else { return };
    let Some(mut shape) = pen.shape(bound) else { return };
    if inverted {
        nodes.reverse();
        shape = shape.reversed();
    }
    let key = Key::new("inside guide line").number(bound.0);
    if let Some(length) = length {
        let kept = shape.stations().iter().filter(|station| **station < length - STEP).count();
        let end = shape.at(length);
        nodes.truncate(kept);
        nodes.push(pen.point_on(key.word("end"), bound, end));
        nodes.dedup();
    }
    pen.line(key, nodes, Attributes::of(&[("type", "line_thin"), ("subtype", "dashed")]));
}
