//! Borders as lines of the map, each drawn once, and the lanelets between them.

use std::collections::BTreeMap;

use crate::builder::ids::Key;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::tags::marking::unpainted;
use crate::lanelet::{Attributes, Bound, LineStringId, PointId};
use crate::xodr::{Lane, Place};

use super::lane_use::LaneUse;
use super::marks::{self, Beside};
use super::nodes::{BorderEnd, sides};
use super::plane::Plane;
use super::sampling;
use super::scene::{Drawn, DrawnLane, Scene};

/// Points closer than this to the end of their line, metres, are left out: the end may have been moved a little.
const BESIDE_END: f64 = 0.05;
/// Heights are whole tenths of millimetres, as in all maps.
const STEPS: f64 = 1e4;

/// The lanes of a stretch that become lanelets.
pub struct StretchLanes<'a> {
    /// Lanes for motor vehicles.
    pub driven: Vec<(&'a Lane, LaneUse)>,
    /// Strips beside them.
    pub sides: Vec<SideRun>,
    /// For each border the one that stands for it.
    pub stands: BTreeMap<i64, i64>,
}

/// Lanes of one use beside those that are driven, which are one lanelet.
pub struct SideRun {
    /// What it is for.
    pub used: LaneUse,
    /// The driven lane beside it, and the outermost lane of the run: both have the borders of the run for outer borders.
    pub lanes: [i64; 2],
}

impl SideRun {
    /// The border toward the driven lanes, and the other one.
    pub fn borders(&self) -> [i64; 2] {
        self.lanes
    }

    /// The driven lane beside it.
    pub fn beside(&self) -> i64 {
        self.lanes[0]
    }
}

/// One lanelet to be drawn.
pub struct One {
    /// Index of the stretch.
    pub stretch: usize,
    /// The lane.
    pub lane: i64,
    /// 1 along the road, -1 against it.
    pub direction: i8,
    /// What it is for.
    pub used: LaneUse,
    /// km/h.
    pub limit: f64,
    /// Whether it is the second one of a lane that is driven both ways.
    pub back: bool,
}

/// Borders as lines, each drawn once.
pub struct Lines<'a> {
    /// The file.
    pub scene: &'a Scene<'a>,
    /// For each end of a border the first one of its node, and the node's place.
    pub ends: &'a BTreeMap<BorderEnd, (BorderEnd, Place)>,
    points: BTreeMap<BorderEnd, PointId>,
    lines: BTreeMap<(usize, i64), LineStringId>,
}

impl<'a> Lines<'a> {
    /// Nothing is drawn yet.
    pub fn new(scene: &'a Scene<'a>, ends: &'a BTreeMap<BorderEnd, (BorderEnd, Place)>) -> Self {
        Self { scene, ends, points: BTreeMap::new(), lines: BTreeMap::new() }
    }

    /// The node at the end of a border.
    fn node(&mut self, assembly: &mut MapBuilder, end: BorderEnd) -> (PointId, Place) {
        let (first, place) = self.ends.get(&end).copied().unwrap_or((end, self.scene.border_at(end.0, end.1, end.2)));
        let scene = self.scene;
        let id = *self.points.entry(first).or_insert_with(|| {
            let (stretch, far, border) = first;
            let key = scene.key("node", stretch).number(border).number(i64::from(far));
            point(assembly, scene.plane, key, place)
        });
        (id, place)
    }

    /// Adds the lanelet of a lane between two borders, the left one along the road first.
    pub fn lanelet(
        &mut self,
        assembly: &mut MapBuilder,
        drawn: &mut Drawn,
        lanes: &StretchLanes,
        borders: [i64; 2],
        One { stretch, lane, direction, used, limit, back }: One,
    ) {
        let [high, low] = borders.map(|border| lanes.stands.get(&border).copied().unwrap_or(border));
        if high == low {
            return;
        }
        let [high, low] = [high, low].map(|border| self.draw(assembly, stretch, border, lanes));
        let inverted = direction < 0;
        let bound = |line: LineStringId| Bound { line, inverted };
        let bounds = if inverted { [bound(low), bound(high)] } else { [bound(high), bound(low)] };
        let key = self.scene.key("lane", stretch).number(lane);
        let key = if back { key.word("back") } else { key };
        let lanelet = assembly.lanelet(key, bounds[0], bounds[1], used.tags(limit));
        let ends = bounds.map(|bound| assembly.bound_ids(bound));
        let nodes = [false, true].map(|last| {
            ends.each_ref().map(|ids| if last { ids.last() } else { ids.first() }.copied().unwrap_or(PointId(0)))
        });
        drawn.of_lane.insert((stretch, lane, direction), drawn.lanes.len());
        drawn.lanes.push(DrawnLane { stretch, lane, direction, used, lanelet, bounds, nodes });
    }

    /// The line of a border.
    fn draw(&mut self, assembly: &mut MapBuilder, stretch: usize, border: i64, lanes: &StretchLanes) -> LineStringId {
        if let Some(known) = self.lines.get(&(stretch, border)) {
            return *known;
        }
        let scene = self.scene;
        let (first, from) = self.node(assembly, (stretch, false, border));
        let (last, to) = self.node(assembly, (stretch, true, border));
        let road = scene.road(stretch);
        let mut places = sampling::border(road, &scene.sections(stretch), border, scene.stretches[stretch].span);
        places.pop();
        let far_from_ends =
            |at: &Place| [from, to].iter().all(|end| (at[0] - end[0]).hypot(at[1] - end[1]) > BESIDE_END);
        let inner: Vec<Place> = places.into_iter().skip(1).filter(far_from_ends).collect();
        let key = scene.key("border", stretch).number(border);
        let mut points = vec![first];
        for ((at, height), number) in scene.plane.to_map(&inner).into_iter().zip(0..) {
            points.push(assembly.point_at(key.number(number), at, rounded(height), Attributes::new()));
        }
        points.push(last);
        let tags = self.tags(stretch, border, lanes);
        let line = assembly.line(key, points, tags);
        self.lines.insert((stretch, border), line);
        line
    }

    fn tags(
        &self,
        stretch: usize,
        border: i64,
        StretchLanes { driven, sides: runs, stands }: &StretchLanes,
    ) -> Attributes {
        let scene = self.scene;
        let road = scene.road(stretch);
        let stands_for = |side: i64| stands.get(&side).copied().unwrap_or(side);
        let beside_it = driven.iter().filter(|(lane, used)| {
            used.is_driven() && sides(lane.id).iter().any(|side| stands.get(side) == Some(&border))
        });
        let beside_it: Vec<&Lane> = beside_it.map(|(lane, _)| *lane).collect();
        let beside = match beside_it[..] {
            [a, b] if road.directions(a) == road.directions(b) && !a.both_ways => Beside::SameWay,
            [_, _] => Beside::Opposed,
            [_] if runs.iter().any(|run| stands_for(run.borders()[0]) == border) => Beside::Strip,
            [_] => Beside::Edge,
            [] if runs.iter().any(|run| stands_for(run.borders()[1]) == border) => Beside::Kerb,
            _ => Beside::Nothing,
        };
        if scene.connecting[scene.stretches[stretch].road] {
            return unpainted();
        }
        // Of borders that are one, the outermost paint counts.
        let one: Vec<i64> = stands.iter().filter(|(_, stands)| **stands == border).map(|(border, _)| *border).collect();
        let section = scene.section(stretch);
        let marks = one.iter().filter_map(|border| section.mark(*border, scene.middle(stretch)));
        let painted = marks.clone().find(|mark| mark.kind != "none");
        marks::border(painted.or(marks.clone().next()), beside)
    }
}

/// Adds a point of the file.
pub fn point(assembly: &mut MapBuilder, plane: &Plane, key: Key, place: Place) -> PointId {
    let (at, height) = plane.to_map(&[place]).pop().unwrap_or_default();
    assembly.point_at(key, at, rounded(height), Attributes::new())
}

fn rounded(height: f64) -> f64 {
    (height * STEPS).round() / STEPS
}
