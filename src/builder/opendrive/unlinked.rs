//! Lanes that a file links to nothing though others begin or end at their very ends: they are taken as linked, and it is told.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnostic::{Finding, Severity};
use crate::geometry::{Point, Vector};
use crate::xodr::Place;

use super::contacts::{Contact, LaneEnd};
use super::lane_use::sides;
use super::lines::StretchLanes;
use super::nodes::WELD;
use super::scene::{Scene, note};

/// Ends farther apart than this, metres, are not taken as linked. Lanelet2 takes nearer ones for a map that is broken.
const TAKEN_AS_LINKED: f64 = 0.5;
/// Lanes that go on do not turn at their joint: the least cosine of the angle between them.
const AHEAD: f64 = 0.8;

/// An end of a lane, as vehicles see it.
struct Ending {
    end: LaneEnd,
    /// Left and right end of its borders.
    places: [Place; 2],
    /// The direction of travel there.
    heading: Vector,
    /// Whether the file links it to another.
    linked: bool,
}

impl Ending {
    /// How far two ends lie from each other, metres; `None` if no vehicle goes on from one to the other, or if both are linked already.
    fn distance(&self, other: &Self) -> Option<f64> {
        let off = |[a, b]: [Place; 2]| {
            let [x, y, z] = [0, 1, 2].map(|i| a[i] - b[i]);
            x.hypot(y).hypot(z)
        };
        let pair = |side: usize| off([self.places[side], other.places[side]]);
        let most = pair(0).max(pair(1));
        let known = self.linked && other.linked;
        (!known && most <= TAKEN_AS_LINKED && self.heading.dot(&other.heading) >= AHEAD).then_some(most)
    }

    fn middle(&self) -> Point {
        let [a, b] = self.places;
        Point::new(f64::midpoint(a[0], b[0]), f64::midpoint(a[1], b[1]))
    }
}

/// Contacts of ends that meet, one of which the file links to nothing: all at one place, else the nearest one. Also gives a note for each two
/// roads.
pub fn meeting(scene: &Scene, lanes: &[StretchLanes], known: &[Contact]) -> (Vec<Contact>, Vec<Finding>) {
    let linked: BTreeSet<LaneEnd> = known.iter().flat_map(|contact| contact.ends).collect();
    let [exits, entries] = endings(scene, lanes, &linked);
    let cell = |at: Point, [dx, dy]: [i64; 2]| [at.x.floor() as i64 + dx, at.y.floor() as i64 + dy];
    let mut by_cell: BTreeMap<[i64; 2], Vec<&Ending>> = BTreeMap::new();
    for entry in &entries {
        by_cell.entry(cell(entry.middle(), [0, 0])).or_default().push(entry);
    }
    let mut found: BTreeMap<[LaneEnd; 2], usize> = BTreeMap::new();
    for exit in &exits {
        let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [dx, dy]));
        let near = around.flat_map(|step| by_cell.get(&cell(exit.middle(), step)).into_iter().flatten());
        let mut near: Vec<(f64, LaneEnd)> =
            near.filter(|entry| entry.end != exit.end).filter_map(|it| Some((exit.distance(it)?, it.end))).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let at_place = near.iter().take_while(|(distance, _)| *distance <= WELD).count();
        for (_, other) in near.iter().take(at_place.max(1)) {
            found.insert([exit.end.min(*other), exit.end.max(*other)], scene.road(exit.end.stretch).line);
        }
    }
    let contacts: Vec<Contact> = found.into_iter().map(|(ends, line)| Contact { ends, line, bridged: false }).collect();
    let notes = contact_notes(scene, &contacts);
    (contacts, notes)
}

/// The ends at which vehicles leave lanes, and those at which they enter them.
fn endings(scene: &Scene, lanes: &[StretchLanes], linked: &BTreeSet<LaneEnd>) -> [Vec<Ending>; 2] {
    let mut found = [Vec::new(), Vec::new()];
    for (stretch, of_stretch) in lanes.iter().enumerate() {
        let road = scene.road(stretch);
        for (lane, far) in of_stretch.driven.iter().flat_map(|(lane, _)| [(*lane, false), (*lane, true)]) {
            let end = LaneEnd { stretch, far, lane: lane.id };
            let linked = linked.contains(&end);
            let [high, low] = sides(lane.id).map(|border| scene.border_at(stretch, far, border));
            let angle = road.angle(scene.stretches[stretch].span[usize::from(far)]);
            let along = Vector::new(angle.cos(), angle.sin());
            for &direction in road.directions(lane) {
                let (places, heading) = if direction > 0 { ([high, low], along) } else { ([low, high], -along) };
                let leaves = (direction > 0) == far;
                found[usize::from(!leaves)].push(Ending { end, places, heading, linked });
            }
        }
    }
    found
}

fn contact_notes(scene: &Scene, contacts: &[Contact]) -> Vec<Finding> {
    let mut by_roads: BTreeMap<[usize; 2], Vec<&Contact>> = BTreeMap::new();
    for contact in contacts {
        by_roads.entry(contact.ends.map(|end| scene.stretches[end.stretch].road)).or_default().push(contact);
    }
    let message = |([a, b], contacts): (&[usize; 2], &Vec<&Contact>)| {
        let name = |index: usize| &scene.file.roads[index].id;
        let first = contacts[0].ends;
        let where_ = if a == b {
            format!("{} places along road {} lanes meet", contacts.len(), name(*a))
        } else {
            let ids =
                format!("lane {} of road {} and lane {} of road {}", first[0].lane, name(*a), first[1].lane, name(*b));
            let more = if contacts.len() > 1 { format!(" and {} more", contacts.len() - 1) } else { String::new() };
            format!("{ids} meet{more}")
        };
        let in_ = if a == b { "at " } else { "" };
        let message = format!("{in_}{where_}, but the file links none of them: they are taken as linked");
        note("opendrive-link", contacts[0].line, message).graded(Severity::Warning)
    };
    by_roads.iter().map(message).collect()
}
