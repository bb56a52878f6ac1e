//! Guide lines between the lanes of one turn: dashes on the bound that two lanes share, as far as it runs along the bounds of
//! the lanes that begin with them.

use std::collections::BTreeMap;

use crate::builder::ids::Key;
use crate::builder::postprocess::map_editor::MapEditor;
use crate::geometry::Polyline;
use crate::lanelet::index::{MapIndex, Movement, Traffic};
use crate::lanelet::right_of_way::Turn;
use crate::lanelet::{Attributes, LineStringId};

use super::stop_line::drivable;

/// Lanes that begin together have diverged where their bounds are this far, metres, from each other.
const DIVERGED: f64 = 0.1;
/// The distance between places where bounds are compared, metres.
const COMPARED_EVERY: f64 = 0.25;
/// The shortest guide line, metres.
const MIN_LENGTH: f64 = 5.0;

/// A guide line to draw.
pub struct Guide {
    /// The bound that it marks.
    pub bound: LineStringId,
    /// Whether the lanes run against the bound.
    inverted: bool,
    /// Its length along the bound, metres; `None`: the whole bound.
    length: Option<f64>,
}

/// The guide lines between the lanes of the turns of an intersection.
pub fn between_lanes(map: &MapIndex, traffic: &Traffic) -> Vec<Guide> {
    let mut turns: BTreeMap<(usize, usize), Vec<&Movement>> = BTreeMap::new();
    for movement in drivable(map, traffic).filter(|movement| movement.ranked.turn != Turn::Straight) {
        turns.entry((movement.from, movement.to)).or_default().push(movement);
    }
    let mut guides: Vec<Guide> = Vec::new();
    for movements in turns.values() {
        for left in movements {
            let shared = map.lanes[left.lane].bounds[1];
            let right = movements.iter().find(|right| map.lanes[right.lane].bounds[0] == shared);
            if let Some(right) = right
                && guides.iter().all(|guide| guide.bound != shared)
            {
                let lengths = [common_length(map, traffic, left, 1), common_length(map, traffic, right, 0)];
                guides.extend(guide(map, left.lane, shared, lengths));
            }
        }
    }
    guides
}

/// The guide line on the right bound of a lane, as long as the shorter of two lengths (metres); `None` if it is too short.
fn guide(map: &MapIndex, lane: usize, bound: LineStringId, lengths: [Option<f64>; 2]) -> Option<Guide> {
    let length = lengths.into_iter().flatten().min_by(f64::total_cmp);
    let bound_length = map.lanes[lane].border(1)?.length();
    let inverted = map.map.lanelets.get(map.lanes[lane].id)?.right.inverted;
    (length.unwrap_or(bound_length) >= MIN_LENGTH).then_some(Guide { bound, inverted, length })
}

/// The length, metres, over which a bound of a movement runs along those of the movements that begin with it and turn the
/// same way; `None`: the whole bound.
fn common_length(map: &MapIndex, traffic: &Traffic, movement: &Movement, side: usize) -> Option<f64> {
    let bound = map.lanes[movement.lane].border(side)?;
    let turns_alike = |other: &usize| {
        let same_line = map.lanes[*other].bounds[side] == map.lanes[movement.lane].bounds[side];
        let turn = traffic.of_lane(*other).map(|x| traffic.movements[x].ranked.turn);
        !same_line && turn == Some(movement.ranked.turn)
    };
    let siblings = map.siblings(movement.lane).filter(turns_alike);
    let others: Vec<Polyline> = siblings.filter_map(|lane| map.lanes[lane].border(side)).collect();
    let mut stations = (0..=(bound.length() / COMPARED_EVERY) as usize).map(|step| step as f64 * COMPARED_EVERY);
    let diverged = stations.find(|&s| others.iter().any(|other| other.distance(bound.at(s)) > DIVERGED));
    diverged.map(|station| (station - COMPARED_EVERY).max(0.0))
}

/// Draws a guide line through the points of its bound.
pub fn draw(editor: &mut MapEditor, Guide { bound, inverted, length }: Guide) {
    let Some(mut points) = editor.map.linestrings.get(bound).map(|line| line.points.clone()) else { return };
    let Some(mut shape) = editor.shape(bound) else { return };
    if inverted {
        points.reverse();
        shape = shape.reversed();
    }
    let key = Key::new("inside guide line").number(bound.0);
    if let Some(length) = length {
        let count = shape.stations().iter().filter(|station| **station < length - COMPARED_EVERY).count();
        let end = shape.at(length);
        points.truncate(count);
        points.push(editor.point_on(key.word("end"), bound, end));
        points.dedup();
    }
    editor.line(key, points, Attributes::of(&[("type", "line_thin"), ("subtype", "dashed")]));
}
