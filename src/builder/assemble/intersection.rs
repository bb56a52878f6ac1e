//! One intersection: its notes and settings, its area, and everything that rules its lanelets.

use std::collections::BTreeSet;

use crate::builder::control::controlled_arm::{Approach, ControlledArm};
use crate::builder::control::light_places::LightGround;
use crate::builder::control::signal_arrows::one_way;
use crate::builder::control::walkway::walkways;
use crate::builder::intersection::area_outline::AreaOutline;
use crate::builder::intersection::bicycle_lanelets::BicycleMovements;
use crate::builder::intersection::conflict::{Conflicts, conflicts, strip_indices};
use crate::builder::intersection::movement_types::{Movement, Movements};
use crate::builder::intersection::ring_movements::RingMovements;
use crate::builder::intersection::turn_direction::{tag_turns, turn_direction};
use crate::builder::intersection::turning_lanelets::{DrawnMovements, TurningLanelet, intersection_key};
use crate::builder::lanes::types::{Arm, ArmLane};
use crate::builder::layout::map_layout::IntersectionLanelets;
use crate::builder::map::map_builder::{MapBuilder, MapPart};
use crate::builder::network::approach_control::Control;
use crate::builder::network::signal_assignment::has_lights;
use crate::builder::network::{Intersection, RoadEnd};
use crate::builder::tags::cross_section::StripKind;
use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::{Point, Polyline};
use crate::lanelet::{Attributes, LaneletId, PointId, PolygonId};
use crate::settings::{IntersectionSettings, LooseEnds};

use super::crossings::announce_to;
use super::intersection_settings;
use super::loose_ends::LooseLanes;
use super::map_context::MapContext;
use super::right_of_way_elements::{headings, legs_of, rights_of_way};
use super::waiting::Waiting;

use rustc_hash::FxHashSet;

/// A node closer than this, metres, to the line between its neighbours does not change the shape of an outline. Cuts bend by so
/// little where two roads share a corner.
const ON_CUT: f64 = 0.05;

/// What one intersection adds to the notes and settings of the map.
#[derive(Default)]
pub(super) struct IntersectionOutput {
    pub(super) notes: Vec<Finding>,
    pub(super) settings: Option<IntersectionSettings>,
    pub(super) bicycle_lanes: Vec<i64>,
    pub(super) has_area: bool,
    pub(super) loose_ends: LooseEnds,
}

/// One intersection under construction.
pub(super) struct IntersectionAssembly<'a> {
    pub(super) context: &'a MapContext<'a>,
    pub(super) assembly: MapBuilder<'a>,
    output: IntersectionOutput,
    /// Its lanes for bicycles.
    bicycles: BicycleMovements,
}

/// The lanelets for vehicles, and their conflicts.
struct Traffic<'a> {
    paths: &'a [TurningLanelet],
    conflicts: &'a Conflicts,
}

impl<'a> IntersectionAssembly<'a> {
    /// Finishes an intersection whose lanelets were drawn over `below`.
    pub(super) fn finish(
        context: &'a MapContext,
        below: &'a MapBuilder<'a>,
        intersection: &Intersection,
        turning: IntersectionLanelets,
    ) -> (MapPart, IntersectionOutput) {
        let mut assembly = MapBuilder::resume(below, turning.part);
        assembly.set_ground(context.lanes.ground_of(intersection, below));
        let mut one = Self { context, assembly, output: IntersectionOutput::default(), bicycles: turning.bicycles };
        let arms: Vec<&Arm> = intersection.arms.iter().map(|&arm| context.lanes.arm(arm)).collect();
        let DrawnMovements { paths, dropped, .. } = &turning.drawn;
        one.note_dropped(intersection, dropped);
        if context.as_roads {
            one.output.bicycle_lanes = one.bicycles.paths.iter().map(|path| path.lanelet.0).collect();
        }
        let movements: Vec<Movement> = paths.iter().map(|path| path.movement).chain(dropped.iter().copied()).collect();
        let loose = LooseLanes::of_intersection(context, intersection, &arms, &movements);
        one.output.notes.extend(loose.notes);
        one.output.loose_ends = loose.lanelets;
        one.announce_crosswalks(intersection, paths);
        one.walkways(intersection, paths);
        if let Some(area) = turning.area {
            let prohibited = prohibited(&turning.plan, &turning.drawn, &arms);
            let traffic = Traffic { paths, conflicts: &turning.conflicts.unwrap_or_default() };
            one.area(intersection, &arms, traffic, &prohibited, &area);
        } else if intersection.signals {
            one.lights(intersection, &arms, paths);
        } else {
            one.roundabout_entries(intersection, &arms, paths);
        }
        (one.assembly.into_part(), one.output)
    }

    fn note_dropped(&mut self, intersection: &Intersection, dropped: &[Movement]) {
        for movement in dropped {
            let way = |arm: usize| self.context.network.road(intersection.arms[arm].road).key.way;
            let (from, to) = (way(movement.from), way(movement.to));
            let node = intersection.nodes.first().copied().unwrap_or_default();
            let message = format!("There is no room for a lane from way {from} to way {to} at node {node}.");
            let finding = Finding::new("movement-dropped", Subject::Node(node), message)
                .with(Subject::Way(from), "from")
                .with(Subject::Way(to), "to")
                .at(Place::Point(intersection.position));
            self.output.notes.push(finding);
        }
    }

    /// Adds everything that makes crossing lanelets an intersection for Autoware.
    fn area(
        &mut self,
        intersection: &Intersection,
        arms: &[&Arm],
        traffic: Traffic,
        prohibited: &[(usize, usize)],
        outline: &AreaOutline,
    ) {
        let id = self.area_polygon(intersection, arms, outline);
        let bicycles = std::mem::take(&mut self.bicycles);
        tag_turns(&mut self.assembly, intersection, id, traffic.paths.iter().chain(&bicycles.paths));
        // Only lanelets of subtype road are watched, have lights, and are yielded to.
        let (with_bicycles, conflicts_with_bicycles);
        let Traffic { paths, conflicts } = if self.context.as_roads && !bicycles.paths.is_empty() {
            with_bicycles = [traffic.paths, &bicycles.paths].concat();
            conflicts_with_bicycles = conflicts(&with_bicycles, &strip_indices(&with_bicycles));
            Traffic { paths: &with_bicycles, conflicts: &conflicts_with_bicycles }
        } else {
            traffic
        };
        let controls = self.controls(intersection, arms);
        let arrows = self.context.arrows.are_at(id, &outline.places);
        let (driving, key) =
            (self.context.network.side, intersection_key("intersection area", intersection).word("arm"));
        let ground =
            LightGround { rings: vec![outline.places.clone()], lanelets: self.car_lanelets(paths).collect(), arms };
        let legs = legs_of(&self.assembly, arms);
        let ranked = self.ranked_movements(arms, paths, &controls, &legs);
        let waiting = Waiting::new(self.context.network, arms, &legs, (paths, &ranked, conflicts));
        let crossings = self.context.crossings;
        // Whoever comes from private ground onto a public road waits; between the aisles of a car park nobody paints a line.
        let meets_public = (0..arms.len()).any(|i| waiting.is_public(i));
        let has_line = |i: usize| {
            let is_guarded = || controls[i] != Control::None || crossings.at(arms[i].at).next().is_some();
            meets_public && !waiting.is_public(i) || is_guarded() || waiting.is_at(i)
        };
        for (i, arm) in arms.iter().enumerate().filter(|(i, _)| has_line(*i)) {
            let (arm, approaches) = self.approaches((i, arm), paths, &bicycles, controls[i], arrows);
            let controlled = ControlledArm { arm: &arm, control: controls[i], approaches: &approaches, driving };
            controlled.draw(&mut self.assembly, key, &ground);
        }
        rights_of_way(&mut self.assembly, &legs, paths, &ranked, conflicts, &[]);
        let of_leg = headings(&legs, paths);
        let headings: Vec<_> = legs.iter().map(|&leg| of_leg[leg]).collect();
        let names = intersection_settings::names(arms, &headings, self.context.lanes);
        self.output.settings = intersection_settings::settings(id, &names, prohibited, &ranked);
    }

    /// Adds the lights where no lanelets cross, as where a road divides at a small angle, on the arms that they face.
    fn lights(&mut self, intersection: &Intersection, arms: &[&Arm], paths: &[TurningLanelet]) {
        let (driving, key) = (self.context.network.side, intersection_key("intersection", intersection).word("arm"));
        let bicycles = std::mem::take(&mut self.bicycles);
        let rings = paths.iter().map(|path| self.assembly.outline(path.lanelet)).collect();
        let ground = LightGround { rings, lanelets: self.car_lanelets(paths).collect(), arms };
        let lit = arms.iter().enumerate().filter(|(_, arm)| has_lights(self.context.network, arm.at));
        for (i, arm) in lit {
            let (arm, approaches) = self.approaches((i, arm), paths, &bicycles, Control::Signals, false);
            let controlled = ControlledArm { arm: &arm, control: Control::Signals, approaches: &approaches, driving };
            controlled.draw(&mut self.assembly, key, &ground);
        }
    }

    /// Adds the lines at which vehicles wait that join a roundabout, and the signs there.
    fn roundabout_entries(&mut self, intersection: &Intersection, arms: &[&Arm], paths: &[TurningLanelet]) {
        let MapContext { roundabouts, lanes, .. } = *self.context;
        let rings = RingMovements { roundabouts, lanes, at: intersection, paths };
        let joins = |path: &&TurningLanelet| rings.of(path).is_some_and(|movement| movement.joins);
        let entries: BTreeSet<usize> = paths.iter().filter(joins).map(|path| path.movement.from).collect();
        let (driving, key) = (self.context.network.side, intersection_key("intersection", intersection).word("arm"));
        let controls = self.controls(intersection, arms);
        let ground = LightGround { rings: Vec::new(), lanelets: Vec::new(), arms };
        for i in entries.into_iter().filter(|&i| controls[i] != Control::Signals) {
            let (arm, approaches) =
                self.approaches((i, arms[i]), paths, &BicycleMovements::default(), controls[i], false);
            let controlled = ControlledArm { arm: &arm, control: controls[i], approaches: &approaches, driving };
            controlled.draw(&mut self.assembly, key, &ground);
        }
    }

    /// The outlines of the lanelets for cars.
    fn car_lanelets<'s>(&'s self, paths: &'s [TurningLanelet]) -> impl Iterator<Item = Vec<Point>> + use<'s, 'a> {
        let for_cars = paths.iter().filter(|path| path.kind == StripKind::Drive);
        for_cars.map(|path| self.assembly.outline(path.lanelet))
    }

    /// Adds the polygon of the area, and notes its faults.
    fn area_polygon(&mut self, intersection: &Intersection, arms: &[&Arm], outline: &AreaOutline) -> PolygonId {
        self.output.has_area = true;
        let id = self.assembly.polygon_id(intersection_key("intersection area", intersection));
        let attributes = Attributes::of(&[("type", "intersection_area"), ("area", "yes")]);
        let ring = self.without_needless_nodes(arms, outline);
        self.assembly.polygon(id, ring, attributes);
        for &arm in &outline.lost {
            let cut = self.assembly.positions(&arms[arm].cut);
            let message = format!("The outline of intersection area {id} does not lead along the end of a road.");
            let finding = Finding::new("lane-end-inside", Subject::Polygon(id.0), message);
            self.output.notes.push(finding.at(Place::Line(cut)));
        }
        for &way in &outline.covered {
            let message = format!(
                "Intersection area {id} covers the island of way {way}: lanes run over it, or the outline finds no way around it."
            );
            let finding = Finding::new("island-covered", Subject::Polygon(id.0), message).graded(Severity::Info);
            self.output.notes.push(finding.with(Subject::Way(way), "island"));
        }
        id
    }

    /// The ring of an area without needless nodes: those on a straight cut at which neither a border nor a lane for cars ends, as
    /// between two bus lanes. Autoware uses the nodes of an area only for lanes for cars.
    fn without_needless_nodes(&self, arms: &[&Arm], outline: &AreaOutline) -> Vec<PointId> {
        let inner = |arm: &&Arm| arm.cut[1.min(arm.cut.len())..arm.cut.len().max(2) - 1].to_vec();
        let mut needless: FxHashSet<PointId> = arms.iter().flat_map(inner).collect();
        for (i, arm) in arms.iter().enumerate() {
            self.anchors((i, arm)).for_each(|id| _ = needless.remove(&id));
        }
        let count = outline.ring.len();
        let is_straight = |i: usize| {
            let [before, after] = [outline.places[(i + count - 1) % count], outline.places[(i + 1) % count]];
            Polyline::new([before, after]).is_some_and(|line| line.distance(outline.places[i]) <= ON_CUT)
        };
        let kept = (0..count).filter(|&i| !needless.contains(&outline.ring[i]) || !is_straight(i));
        kept.map(|i| outline.ring[i]).collect()
    }

    /// The nodes of a cut at which a border, a lane for cars, or a bicycle lane that is tagged as a road ends.
    fn anchors<'s>(&'s self, (index, arm): (usize, &'s Arm)) -> impl Iterator<Item = PointId> + use<'s, 'a> {
        let lanes = self.context.lanes;
        let borders = lanes.borders_at(arm.at).iter().flatten().filter_map(|bound| self.assembly.line_of(bound.line));
        let borders = borders.filter(|line| line.attributes.is("type", "road_border"));
        let is_for_cars = |end: &&ArmLane| {
            let lanelet = self.assembly.lanelet_of(lanes.lanes[end.lane].lanelet);
            lanelet.is_some_and(|lanelet| lanelet.attributes.is("subtype", "road"))
        };
        let bicycles = self.bicycles.ends.of_arm(index).filter(|_| self.context.as_roads);
        let ends = arm.into.iter().chain(&arm.out).filter(is_for_cars).chain(bicycles).flat_map(|end| end.nodes);
        borders.flat_map(|line| [line.points.first(), line.points.last()]).flatten().copied().chain(ends)
    }

    /// The lanes over which vehicles approach on an arm, and bicycles where their lanes are roads; with the arm to which these
    /// are added.
    fn approaches(
        &self,
        (index, arm): (usize, &Arm),
        paths: &[TurningLanelet],
        bicycles: &BicycleMovements,
        control: Control,
        arrows: bool,
    ) -> (Arm, Vec<Approach>) {
        let from = |lane: usize, bicycle: bool| {
            paths.iter().filter(move |path| {
                let movement = path.movement;
                (movement.from, movement.in_lane, path.kind == StripKind::Bicycle) == (index, lane, bicycle)
            })
        };
        let mut approaches: Vec<Approach> = (arm.into.iter().enumerate())
            .map(|(lane, before)| Approach {
                lane: self.context.lanes.lanes[before.lane].lanelet,
                behind: from(lane, false).map(|path| path.lanelet).collect(),
                arrow: arrows.then(|| one_way(from(lane, false).map(turn_direction))).flatten(),
            })
            .collect();
        let mut arm = arm.clone();
        for (lane, end) in bicycles.ends.leading_in(index).filter(|_| self.context.as_roads && control != Control::Stop)
        {
            let behind: Vec<LaneletId> = from(lane, true).map(|path| path.lanelet).collect();
            let Some(&lane) = behind.first() else { continue };
            arm.into.push(*end);
            approaches.push(Approach { lane, behind, arrow: None });
        }
        (arm, approaches)
    }

    fn walkways(&mut self, intersection: &Intersection, paths: &[TurningLanelet]) {
        if self.context.network.beside.walkways {
            let crossings = self.context.crossings;
            let crossed = |arm: RoadEnd| crossings.at(arm).next().is_some();
            walkways(&mut self.assembly, self.context.network, self.context.lanes, intersection, crossed, paths);
        }
    }

    fn announce_crosswalks(&mut self, intersection: &Intersection, paths: &[TurningLanelet]) {
        for crosswalk in intersection.arms.iter().flat_map(|arm| self.context.crossings.at(*arm)) {
            let bicycles = self.bicycles.paths.iter().filter(|_| self.context.as_roads);
            let lanelets: Vec<LaneletId> = paths.iter().chain(bicycles).map(|path| path.lanelet).collect();
            announce_to(&mut self.assembly, crosswalk, lanelets.into_iter());
        }
    }
}

/// Pairs of arms without a movement: those that are prohibited and, if there is no room for them, U-turns and the movement that leads
/// around a loop once more.
fn prohibited(plan: &Movements, drawn: &DrawnMovements, arms: &[&Arm]) -> Vec<(usize, usize)> {
    let is_drawn = |pair: (usize, usize)| drawn.paths.iter().any(|it| (it.movement.from, it.movement.to) == pair);
    let dropped = drawn.dropped.iter().map(|it| (it.from, it.to));
    let around = dropped.filter(|&(from, to)| arms[from].at.road == arms[to].at.road && !is_drawn((from, to)));
    let no_room = plan.u_turns.iter().copied().filter(|&turn| !is_drawn(turn));
    let mut all: Vec<(usize, usize)> = plan.prohibited.iter().copied().chain(around).chain(no_room).collect();
    all.sort_unstable();
    all.dedup();
    all
}
