//! How many points the borders of a file would have: roads beyond what a file may have are left out, and it is told.

use crate::diagnostic::{Finding, Severity};
use crate::geometry::Point;
use crate::xodr::{OpenDrive, Road, Shape};

use super::sampling::{CHORD, LONGEST, SHORTEST};
use super::scene::note;

/// So many points are built of any file, ...
const MOST: f64 = 600_000.0;
/// ... and so many more for each record of its roads. Files of real towns need 3 to 6 for each, one of a motorway 20.
const FOR_EACH_RECORD: f64 = 40.0;

/// Whether each road is built: the first of the file are, as many as have room. A note tells of the others.
pub fn roads_with_room(file: &OpenDrive, notes: &mut Vec<Finding>) -> Vec<bool> {
    let most = MOST + FOR_EACH_RECORD * file.roads.iter().map(|road| records(road) as f64).sum::<f64>();
    let mut sum = 0.0;
    let with_room = file.roads.iter().map(|road| {
        let is_first = sum == 0.0;
        sum += points(road);
        sum <= most || is_first
    });
    let with_room: Vec<bool> = with_room.collect();
    let mut left_out = file.roads.iter().zip(&with_room).filter(|(_, fits)| !**fits).map(|(road, _)| road);
    if let Some(first) = left_out.next() {
        let message = format!(
            "the borders of the roads would have {sum:.0} points, and {most:.0} are built: road {} and {} others are left out; \
             are its numbers metres? else export a smaller part",
            first.id,
            left_out.count()
        );
        notes.push(note("too-many-points", first.line, message).graded(Severity::Warning));
    }
    with_room
}

/// The records of a road's line, its heights and its lanes.
fn records(road: &Road) -> usize {
    road.plan.records().len() + knots(road) + road.sections.iter().map(|section| section.lanes.len()).sum::<usize>()
}

/// The records of heights and widths, at each of which a border may bend.
fn knots(road: &Road) -> usize {
    let along = road.elevation.starts().chain(road.superelevation.starts()).chain(road.lane_offset.starts()).count();
    let lanes = road.sections.iter().flat_map(|section| &section.lanes);
    let across =
        lanes.map(|lane| lane.widths.starts().count() + lane.borders.starts().count() + lane.heights.starts().count());
    along + road.shapes.stations().count() + across.sum::<usize>()
}

/// About how many points the borders of a road have.
fn points(road: &Road) -> f64 {
    let line: f64 = road
        .plan
        .records()
        .iter()
        .map(|record| match record.shape {
            Shape::Line => on_curve(record.length, 0.0),
            Shape::Arc(curvature) => on_curve(record.length, curvature.abs()),
            Shape::Spiral([from, to]) => on_curve(record.length, from.abs().max(to.abs())),
            Shape::Poly3(_) | Shape::ParamPoly3 { .. } => {
                let at = |i: usize| record.at(record.length * i as f64 / PIECES as f64).point;
                on_polyline(&(0..=PIECES).map(at).collect::<Vec<Point>>())
            }
        })
        .sum();
    let borders = road.sections.iter().map(|section| section.lanes.len() + 1).max().unwrap_or(0);
    (line + knots(road) as f64) * borders as f64
}

/// A polynomial is looked at in so many pieces.
const PIECES: usize = 32;

/// The points of a curve so long, metres, with a curvature of 1/m.
fn on_curve(length: f64, curvature: f64) -> f64 {
    1.0 + length * (curvature / (8.0 * CHORD)).sqrt().clamp(1.0 / LONGEST, 1.0 / SHORTEST)
}

/// The points of a curve through these: as many as let no chord lie farther from it than is allowed.
fn on_polyline(through: &[Point]) -> f64 {
    let straight = through.windows(2).map(|pair| (pair[1] - pair[0]).norm() / LONGEST);
    let bent = through.windows(3).map(|three| {
        let off = (three[1] - nalgebra::center(&three[0], &three[2])).norm();
        (off / CHORD).sqrt()
    });
    1.0 + straight.chain(bent).filter(|points| points.is_finite()).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::xodr::read;

    fn roads(count: usize, length: f64, geometry: &str) -> OpenDrive {
        let lane = "<lane id=\"-1\" type=\"driving\"><width sOffset=\"0\" a=\"3\" b=\"0\" c=\"0\" d=\"0\"/></lane>";
        let road = |id: usize| {
            format!(
                "<road id=\"{id}\" junction=\"-1\" length=\"{length}\"><planView><geometry s=\"0\" x=\"0\" y=\"{}\" hdg=\"0\" \
                 length=\"{length}\">{geometry}</geometry></planView><lanes><laneSection s=\"0\"><center><lane id=\"0\" \
                 type=\"none\"/></center><right>{lane}</right></laneSection></lanes></road>",
                10 * id
            )
        };
        read(&format!(
            "<OpenDRIVE><header revMajor=\"1\" revMinor=\"6\"/>{}</OpenDRIVE>",
            (0..count).map(road).collect::<String>()
        ))
        .unwrap()
    }

    #[test]
    fn of_roads_with_too_many_points_the_first_are_built() {
        let mut notes = Vec::new();
        assert!(roads_with_room(&roads(50, 1_000.0, "<line/>"), &mut notes).into_iter().all(|fits| fits));
        assert!(notes.is_empty());
        // 25,000 points on each of two borders.
        let with_room = roads_with_room(&roads(50, 1e6, "<line/>"), &mut notes);
        assert_eq!(with_room.iter().position(|fits| !fits), Some(12));
        let [note] = &notes[..] else { panic!("one note: {notes:?}") };
        assert!(note.message.contains("road 12 and 37 others are left out"), "{}", note.message);
        // However long it is, the first is.
        let wild = "<paramPoly3 pRange=\"normalized\" aU=\"0\" bU=\"1e7\" cU=\"3e9\" dU=\"0\" aV=\"0\" bV=\"1\" cV=\"0\" dV=\"9e9\"/>";
        let with_room = roads_with_room(&roads(3, 1e4, wild), &mut Vec::new());
        assert_eq!(with_room, [true, false, false]);
    }
}
