//! Places where a vehicle stops in the lanes that it watches, or cannot stop for them.

use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::polygon::contains;
use crate::planner::{Attention, EDGE, Outcome, StopSource};

use super::watching::Watching;

pub fn judge(all: &Watching, at: usize) -> Vec<Finding> {
    let attention =
        all.attention[at].as_ref().filter(|attention| !attention.watched.is_empty() && is_odd(all, at, attention));
    let Some((attention, stopping)) =
        attention.and_then(|attention| Some((attention, all.network.stopping(at, attention, &all.params)?)))
    else {
        return Vec::new();
    };
    let (id, count) = (all.id(at), attention.watched.len());
    let about = Subject::Lanelet(id.0);
    let lanes = if count == 1 { "a lane".to_owned() } else { format!("{count} lanes") };
    let counts = |other: usize| all.conflict(at, other).is_some() && !all.are_neighbours(at, other);
    match (stopping.outcome, stopping.first_watched, stopping.lines.default_stop) {
        (Outcome::NeverMeets, ..) if attention.watched.iter().any(|&other| counts(other)) => {
            let message =
                format!("Lanelet {id} watches {lanes} and its path touches none: the module finds no place to stop.");
            let finding = Finding::new("never-meets", about, message).graded(Severity::Info);
            let watched = attention.watched.iter().map(|&other| Subject::Lanelet(all.id(other).0));
            vec![watched.fold(finding, |finding, other| finding.with(other, "watched"))]
        }
        // A later piece of a movement has no stop of its own: vm-03-05 wants the pieces joined.
        (Outcome::StopsTooLate, Some(first), Some(stop)) if counts(first) && !is_later_piece(all, at) => {
            let place = match stop.source {
                StopSource::RoadMarking(line) => format!("at its stop line {line}"),
                StopSource::Margin => "where it would stop".to_owned(),
            };
            let first = all.id(first);
            let message = format!(
                "Lanelet {id} watches {lanes} and stops for none: {place} the vehicle already touches {first}."
            );
            let finding = Finding::new("stops-too-late", about, message).with(Subject::Lanelet(first.0), "watched");
            vec![finding.at(Place::Line(stop.front.ends.to_vec()))]
        }
        _ => Vec::new(),
    }
}

/// Whether a lanelet is a later piece of a way through its intersection.
fn is_later_piece(all: &Watching, at: usize) -> bool {
    let map = all.map;
    all.lane(at).is_some_and(|lane| {
        map.predecessors(lane).iter().any(|&before| map.in_same_intersection(before, lane).is_some())
    })
}

/// Whether a lanelet can be one that anything is to be said of: it touches nobody whom it watches, or those reach back to where the
/// vehicle stops, or a stop line lies inside it. Where its path leads needs to be found of these alone.
fn is_odd(all: &Watching, at: usize, attention: &Attention) -> bool {
    let network = &all.network;
    let approach = network.approach(at, all.params.stopping_reach(), &all.params);
    approach.is_some_and(|approach| attention.watched.iter().any(|&other| approach.meets(&network.surface(other))))
        || (all.strip(at).is_some() && !all.meets_any(at))
        || has_line_inside(all, at)
}

/// Whether a road marking of a lanelet names a stop line that lies in it, away from its begin.
fn has_line_inside(all: &Watching, at: usize) -> bool {
    let view = all.network.view;
    let Some(start) = all.lane(at).map(|lane| all.map.lanes[lane].start.middle()) else { return false };
    let outline = &view.lanelets[at].outline;
    let markings = view.elements_of(&view.lanelets[at], "road_marking");
    let mut lines = markings.flat_map(|element| element.linestrings("refers"));
    lines.any(|id| {
        let line = view.map.linestrings.get(id).filter(|line| line.attributes.is("type", "stop_line"));
        let places = line.map(|line| view.places(line)).unwrap_or_default();
        let middle = places.first().zip(places.last()).map(|(a, b)| nalgebra::center(a, b));
        middle.is_some_and(|middle| (middle - start).norm() > EDGE && contains(outline, middle))
    })
}
