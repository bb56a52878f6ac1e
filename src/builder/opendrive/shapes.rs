//! Lanes inside junctions whose own shape, as the file has it, no vehicle keeps to: they are built so, and it is told.

use std::collections::BTreeSet;

use crate::diagnostic::{Finding, Severity};
use crate::geometry::{Vector, angle_between};

use super::lane_use::sides;
use super::scene::{Drawn, Piece, Scene, note};
use super::stretches::section_at;

/// Metres between the places that are looked at.
const LOOKED_AT_EVERY: f64 = 0.25;
/// By how much of itself a width may differ from an even taper between both ends.
const UNEVEN: f64 = 0.5;
/// A border bends no more than this from one place to the next, degrees.
const BEND: f64 = 45.0;

/// The border of a lane goes ahead at least by this share of what its road does.
const LEAST_AHEAD: f64 = 0.15;

/// One note for each lane with such a shape.
pub fn notes(scene: &Scene, drawn: &Drawn) -> Vec<Finding> {
    let inside = drawn.lanes.iter().filter(|lane| lane.used.is_driven() && scene.connecting[scene.road_of(lane)]);
    let pieces: BTreeSet<Piece> = inside.flat_map(|lane| lane.pieces.iter().copied()).collect();
    let told = pieces.into_iter().filter_map(|piece| Some((piece, odd_shape(scene, piece)?)));
    told.map(|(piece, shape)| {
        let message = format!("{} {shape}; it is built as it is", drawn.name(scene, piece));
        let told = note("opendrive-shape", scene.road(piece.stretch).line, message).graded(Severity::Warning);
        drawn.about(told, piece)
    })
    .collect()
}

/// What is odd about a lane, as the end of a sentence.
fn odd_shape(scene: &Scene, Piece { stretch, lane }: Piece) -> Option<String> {
    let (road, sections) = (scene.road(stretch), scene.sections(stretch));
    let [from, to] = scene.stretches[stretch].span;
    let count = ((to - from) / LOOKED_AT_EVERY).ceil().clamp(2.0, 4000.0) as usize;
    let station = |at: usize| from + (to - from) * at as f64 / count as f64;
    let width = |at: usize| section_at(&sections, station(at)).map_or(0.0, |it| it.width(road, lane, station(at)));
    let [first, last] = [width(0), width(count)];
    for border in sides(lane) {
        let offset = |station: f64| section_at(&sections, station).map_or(0.0, |it| it.offset(road, border, station));
        let place = |at: usize| road.place(station(at), offset(station(at)));
        let steps = (0..count).map(|at| {
            let [a, b] = [place(at), place(at + 1)];
            Vector::new(b[0] - a[0], b[1] - a[1])
        });
        let steps: Vec<Vector> = steps.collect();
        let runs_back = |at: &usize| {
            let angle = road.angle(station(*at));
            steps[*at].dot(&Vector::new(angle.cos(), angle.sin())) < LEAST_AHEAD * (to - from) / count as f64
        };
        if let Some(at) = (0..count).find(runs_back) {
            return Some(format!("turns more tightly than it is wide at s={:.1}", station(at)));
        }
        let bends = |at: &usize| angle_between(steps[*at - 1], steps[*at]).abs().to_degrees() > BEND;
        if let Some(at) = (1..count).find(bends) {
            let degrees = angle_between(steps[at - 1], steps[at]).abs().to_degrees();
            return Some(format!("has a border that bends by {degrees:.0} degrees at s={:.1}", station(at)));
        }
    }
    let even = |at: usize| first + (last - first) * at as f64 / count as f64;
    let off = |at: usize| (width(at) - even(at)).abs() / even(at).max(0.5);
    let most = (0..=count).max_by(|&a, &b| off(a).total_cmp(&off(b))).filter(|&at| off(at) > UNEVEN)?;
    Some(format!(
        "is {:.1} m wide at s={:.1}, and {first:.1} m and {last:.1} m at its ends",
        width(most),
        station(most)
    ))
}
