//! Links that name the wrong end of a road: where the lanes do not meet there, but do at the other end, that one is meant.

use std::collections::BTreeMap;

use crate::diagnostic::{Finding, Severity};
use crate::xodr::Place;

use super::contacts::{Contact, LaneEnd};
use super::lane_use::sides;
use super::lines::StretchLanes;
use super::nodes::FARTHEST;
use super::scene::{Scene, note};

/// The contacts with the ends that are meant, in order, and a note for each two roads.
pub fn righted(scene: &Scene, lanes: &[StretchLanes], contacts: Vec<Contact>) -> (Vec<Contact>, Vec<Finding>) {
    let driven = |end: &LaneEnd| lanes[end.stretch].driven.iter().any(|(lane, _)| lane.id == end.lane);
    let mut by_roads: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    let mut right: Vec<Contact> = Vec::with_capacity(contacts.len());
    for contact in contacts {
        let meant = |contact: &Contact| {
            if !contact.ends.iter().all(driven) || apart(scene, contact.ends) <= FARTHEST {
                return None;
            }
            let [a, b] = contact.ends.map(|end| other_end(scene, end).filter(driven));
            let turned = [[a, Some(contact.ends[1])], [Some(contact.ends[0]), b], [a, b]];
            let turned = turned.into_iter().filter_map(|[a, b]| Some([a?, b?])).filter(|[a, b]| a != b);
            let nearest = turned.map(|ends| (apart(scene, ends), ends)).min_by(|a, b| a.0.total_cmp(&b.0));
            nearest.filter(|(apart, _)| *apart <= FARTHEST).map(|(_, ends)| ends)
        };
        if let Some([a, b]) = meant(&contact) {
            by_roads.entry([a, b].map(|end| scene.stretches[end.stretch].road)).or_insert(contact.line);
            right.push(Contact { ends: [a.min(b), a.max(b)], ..contact });
        } else {
            right.push(contact);
        }
    }
    right.sort_unstable();
    right.dedup_by_key(|contact| contact.ends);
    let told = |([a, b], line): (&[usize; 2], &usize)| {
        let [a, b] = [a, b].map(|road| &scene.file.roads[*road].id);
        let message =
            format!("roads {a} and {b} do not meet at the ends that are linked, but at others: those are taken");
        note("opendrive-link", *line, message).graded(Severity::Warning)
    };
    let notes = by_roads.iter().map(told).collect();
    (right, notes)
}

/// The end of the same lane at the other end of its road; `None` where the lane ends inside the road.
fn other_end(scene: &Scene, end: LaneEnd) -> Option<LaneEnd> {
    let road = scene.stretches[end.stretch].road;
    let [first, last] = [scene.first[road], scene.first[road] + scene.cut[road].stretches.len() - 1];
    let [own, other] = if end.far { [last, first] } else { [first, last] };
    (own == end.stretch).then_some(LaneEnd { stretch: other, far: !end.far, lane: end.lane })
}

/// How far the borders of two lanes that meet end from each other, metres.
fn apart(scene: &Scene, ends: [LaneEnd; 2]) -> f64 {
    let places = ends.map(|end| sides(end.lane).map(|border| scene.border_at(end.stretch, end.far, border)));
    let [[a_high, a_low], [b_high, b_low]] = places;
    let off = |a: Place, b: Place| (a[0] - b[0]).hypot(a[1] - b[1]);
    // Where the roads run against each other, left and right change sides.
    if ends[0].far == ends[1].far {
        off(a_high, b_low).max(off(a_low, b_high))
    } else {
        off(a_high, b_high).max(off(a_low, b_low))
    }
}
