//! The stop lines of a file: over which lanes they lead, and where.

use crate::xodr::Object;

use super::lane_use::sides;
use super::scene::{Drawn, Scene, spoken_to, stretch_at};
use super::signal_use::{AT_CUT, SignalUse, is_stop_line, middle, use_of};

/// A line so near to the end of a way through a junction, metres, is that of the road behind.
const AT_EXIT: f64 = 5.0;

/// A stop line of the file.
#[derive(Clone, Debug)]
pub struct StopLine {
    /// Its id in the file.
    pub id: String,
    /// Line of the file, from 1.
    pub line: usize,
    /// Index of its road.
    pub road: usize,
    /// Metres along the road.
    pub station: f64,
    /// Offsets of its ends, metres to the left; `None` where neither an outline nor a lane tells.
    pub across: Option<[f64; 2]>,
    /// The lanelets that it crosses, by index.
    pub lanes: Vec<usize>,
}

impl StopLine {
    /// Whether it lies at a station of a road.
    pub fn is_at(&self, road: usize, station: f64) -> bool {
        self.road == road && (self.station - station).abs() <= AT_CUT
    }

    /// Its lanes that lead through a junction and end right behind it.
    pub fn at_exit(&self, scene: &Scene, drawn: &Drawn) -> Vec<usize> {
        let near = |lane: &&usize| {
            let lane = &drawn.lanes[**lane];
            let [from, to] = scene.span(lane);
            let left = if lane.direction > 0 { to - self.station } else { self.station - from };
            scene.connecting[self.road] && left <= AT_EXIT && left < (to - from) / 2.0
        };
        self.lanes.iter().filter(near).copied().collect()
    }
}

/// The stop lines of all roads, objects first.
pub fn stop_lines(scene: &Scene, drawn: &Drawn) -> Vec<StopLine> {
    let mut all = Vec::new();
    for (index, road) in scene.file.roads.iter().enumerate().filter(|(_, road)| !road.plan.is_empty()) {
        for object in road.objects.iter().filter(|object| is_stop_line(&object.words())) {
            let lanes = under(scene, drawn, index, object);
            let across = object.ring(road).map(|_| extent(scene, index, object));
            let station = middle(road, object).clamp(0.0, road.length);
            all.push(StopLine { id: object.id.to_string(), line: object.line, road: index, station, across, lanes });
        }
    }
    for (index, road) in scene.file.roads.iter().enumerate() {
        for signal in road.signals.iter().filter(|signal| use_of(signal) == SignalUse::StopLine) {
            let station = signal.at[0].clamp(0.0, road.length);
            let lanes = spoken_to(scene, drawn, index, station, &signal.validity);
            let (id, line) = (signal.id.to_string(), signal.line);
            all.push(StopLine { id, line, road: index, station, across: None, lanes });
        }
    }
    all
}

/// The lanelets over which a line leads; those that it faces, where it says so.
fn under(scene: &Scene, drawn: &Drawn, index: usize, object: &Object) -> Vec<usize> {
    let road = &scene.file.roads[index];
    let station = middle(road, object).clamp(0.0, road.length);
    let lanes = spoken_to(scene, drawn, index, station, &object.validity);
    if object.ring(road).is_none() {
        return lanes;
    }
    let [low, high] = extent(scene, index, object);
    let covers = |lane: &usize| {
        let Some(piece) = stretch_at(scene, index, station).and_then(|stretch| drawn.lanes[*lane].piece_on(stretch))
        else {
            return false;
        };
        let section = scene.section_near(piece.stretch, station);
        let sides = sides(piece.lane).map(|border| section.offset(road, border, station));
        (low..=high).contains(&f64::midpoint(sides[0], sides[1]))
    };
    lanes.into_iter().filter(covers).collect()
}

/// The offsets of the ends of a line, metres to the left of its road.
fn extent(scene: &Scene, index: usize, object: &Object) -> [f64; 2] {
    let road = &scene.file.roads[index];
    let at = road.plan.at(object.at[0]);
    let ring = object.ring(road).unwrap_or_default();
    let across = ring.iter().map(|[x, y, _]| (y - at.point.y) * at.angle.cos() - (x - at.point.x) * at.angle.sin());
    across.fold([f64::MAX, f64::MIN], |[low, high], t| [low.min(t), high.max(t)])
}
