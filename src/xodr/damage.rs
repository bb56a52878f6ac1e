//! Roads whose numbers cannot be those of a road.

use super::road::Road;

/// A place farther than this from the file's origin, metres, is none: projected coordinates stay below.
const FARTHEST: f64 = 1e8;
/// A border farther than this from its reference line, metres, is none.
const BROADEST: f64 = 1_000.0;
/// A height above or below 0, metres, that is none.
const HIGHEST: f64 = 100_000.0;
/// The longest road, metres.
const LONGEST: f64 = 1e6;
/// The most lanes side by side.
const MOST_LANES: usize = 300;

/// Why a road cannot be drawn, one sentence without a subject.
pub fn damage(road: &Road) -> Option<String> {
    /// Places along each section at which it is looked at.
    const PLACES: usize = 16;
    if road.length > LONGEST {
        return Some(format!("is longer than {} km", LONGEST / 1000.0));
    }
    if let Some(section) = road.sections.iter().find(|section| section.lanes.len() > MOST_LANES) {
        return Some(format!("has {} lanes side by side at s={:.1}", section.lanes.len(), section.span[0]));
    }
    let far = |value: f64, most: f64| value.is_nan() || value.abs() > most;
    for section in &road.sections {
        for i in 0..=PLACES {
            let station = section.span[0] + section.length() * i as f64 / PLACES as f64;
            let at = road.plan.at(station).point;
            if far(at.x, FARTHEST) || far(at.y, FARTHEST) {
                return Some(format!("leads out of the world at s={station:.1}"));
            }
            if far(road.elevation.at(station, station), HIGHEST) {
                return Some(format!("leads out of the world in height at s={station:.1}"));
            }
            let outermost = [section.lanes.first(), section.lanes.last()].into_iter().flatten();
            if outermost.map(|lane| section.offset(road, lane.id, station)).any(|offset| far(offset, BROADEST)) {
                return Some(format!("is broader than {BROADEST} m at s={station:.1}"));
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::super::cubic::{Cubic, Cubics};
    use super::super::plan_view::{PlanRecord, PlanView, Shape};
    use super::super::road::{Lane, Section};
    use super::*;
    use crate::geometry::Point;

    #[test]
    fn numbers_of_no_road_are_told() {
        let cubic = |factors| Cubics::new(vec![Cubic { start: 0.0, factors }]);
        let record =
            PlanRecord { start: 0.0, origin: Point::origin(), heading: 0.0, length: 100.0, shape: Shape::Line };
        let lane = |c: f64| Lane { id: -1, widths: cubic([3.5, 0.0, c, 0.0]), ..Lane::default() };
        let road = |lane: Lane| Road {
            length: 100.0,
            plan: PlanView::new(vec![record]),
            sections: vec![Section { span: [0.0, 100.0], lanes: vec![lane], ..Section::default() }],
            ..Road::default()
        };
        assert_eq!(damage(&road(lane(0.0))), None);
        assert!(damage(&road(lane(9999.0))).is_some_and(|it| it.contains("broader")));
        let high = Road { elevation: cubic([0.0, 0.0, 0.0, 9999.0]), ..road(lane(0.0)) };
        assert!(damage(&high).is_some_and(|it| it.contains("height")));
        let mut crowded = road(lane(0.0));
        crowded.sections[0].lanes = (1..=1000).map(|id| Lane { id: -id, ..Lane::default() }).collect();
        assert!(damage(&crowded).is_some_and(|it| it.contains("1000 lanes")));
        assert!(damage(&Road { length: 1e9, ..road(lane(0.0)) }).is_some_and(|it| it.contains("longer")));
    }
}
