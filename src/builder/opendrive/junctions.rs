//! Junctions: their connecting lanes become turning lanelets with an area around them where they cross, and rights of way.

use std::collections::{BTreeMap, BTreeSet};

use crate::builder::assemble::intersection_settings;
use crate::builder::assemble::right_of_way_elements::{headings, legs_of, rights_of_way};
use crate::builder::ids::Key;
use crate::builder::intersection::area_outline::area_outline;
use crate::builder::intersection::conflict::{Conflicts, conflicts, strip_indices};
use crate::builder::intersection::movement_types::Movement;
use crate::builder::intersection::turn_direction::turn_direction;
use crate::builder::intersection::turning_lanelets::{SharedBounds, TurningLanelet};
use crate::builder::lanes::types::{Arm, ArmLane, Lanes, RoadLane};
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::approach_control::Control;
use crate::builder::network::turn_angle::{STRAIGHT_ON, turned};
use crate::builder::network::{End, RoadEnd, RoadIx};
use crate::builder::streets::heights::Ground;
use crate::builder::tags::cross_section::StripKind;
use crate::builder::tags::road_class::DrivingSide;
use crate::diagnostic::{Finding, Place, Severity};
use crate::geometry::{Point, Vector};
use crate::lanelet::index::center_line;
use crate::lanelet::right_of_way::RankedMovement;
use crate::lanelet::{Attributes, PointId, PolygonId, TurnDirection};
use crate::settings::{ApproachName, IntersectionSettings, LooseEnds};
use crate::xodr::{Junction, JunctionKind, RoadLink};

use super::lane_use::LaneUse;
use super::scene::{Drawn, DrawnLane, Scene, note};
use super::signals::Furniture;

/// What all junctions add.
#[derive(Default)]
pub struct Made {
    /// Intersection areas.
    pub areas: usize,
    /// What could not be drawn as it should.
    pub notes: Vec<Finding>,
    /// What the map format cannot express.
    pub settings: Vec<IntersectionSettings>,
    /// Lanes that the file links to nothing.
    pub loose_ends: LooseEnds,
    /// The lanelets, by index, that lie in an area.
    pub in_area: BTreeSet<usize>,
    /// For each approach of an area that has lights, the lanelets, by index, that begin there.
    pub lit: Vec<Vec<usize>>,
}

/// The end of a road: its index, and whether it is the end at the larger station.
type Ending = (usize, bool);

/// A junction with its lanelets.
pub struct Site<'a> {
    /// The file.
    pub scene: &'a Scene<'a>,
    /// Its lanelets.
    pub drawn: &'a Drawn,
    /// The road ends around it, clockwise.
    pub endings: Vec<Ending>,
    /// For each road end its lanes.
    pub arms: Vec<Arm>,
    /// The ways through it.
    pub paths: Vec<TurningLanelet>,
    /// For each path the lane that it is drawn from.
    pub members: Vec<usize>,
    /// Other lanes, which are not reached from outside or do not lead out.
    pub strays: Vec<usize>,
}

/// Draws the areas of all junctions and decides their rights of way.
pub fn draw(assembly: &mut MapBuilder, scene: &Scene, drawn: &Drawn, furniture: &Furniture, side: DrivingSide) -> Made {
    let mut made = Made::default();
    let lanes = Lanes { lanes: drawn.lanes.iter().map(|lane| road_lane(scene, lane)).collect(), ..Lanes::default() };
    let mut by_junction: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (at, lane) in drawn.lanes.iter().enumerate().filter(|(_, lane)| lane.used.is_driven()) {
        if let Some(junction) = &scene.road(lane.stretch()).junction {
            by_junction.entry(junction.as_str()).or_default().push(at);
        }
    }
    for junction in scene.file.junctions.iter().filter(|junction| junction.kind == JunctionKind::Common) {
        let members = by_junction.get(junction.id.as_str()).map_or(&[][..], Vec::as_slice);
        let site = Site::new(assembly, scene, drawn, members, side);
        site.finish(assembly, junction, &lanes, (furniture, side), &mut made);
    }
    made
}

fn road_lane(scene: &Scene, lane: &DrawnLane) -> RoadLane {
    RoadLane {
        road: RoadIx::new(scene.road_of(lane)),
        strip: 0,
        backward: lane.direction < 0,
        lanelet: lane.lanelet,
        left: lane.bounds[0],
        right: lane.bounds[1],
    }
}

/// The kind of strip that stands for a use.
fn strip(used: LaneUse) -> StripKind {
    if used == LaneUse::Buses { StripKind::Bus } else { StripKind::Drive }
}

impl<'a> Site<'a> {
    fn new(assembly: &MapBuilder, scene: &'a Scene, drawn: &'a Drawn, members: &[usize], side: DrivingSide) -> Self {
        let mut site = Self {
            scene,
            drawn,
            endings: Vec::new(),
            arms: Vec::new(),
            paths: Vec::new(),
            members: Vec::new(),
            strays: Vec::new(),
        };
        // For each member the lanes before and behind the junction.
        let around: Vec<(usize, [usize; 2])> = members
            .iter()
            .filter_map(|&member| {
                Some((member, [site.leave(members, member, false)?, site.leave(members, member, true)?]))
            })
            .collect();
        let ending = |lane: usize, leads_in: bool| -> Ending {
            let lane = &drawn.lanes[lane];
            let end = if leads_in { lane.exit() } else { lane.entry() };
            (scene.road_of(lane), end.far)
        };
        let mut endings: Vec<Ending> =
            around.iter().flat_map(|(_, [from, to])| [ending(*from, true), ending(*to, false)]).collect();
        endings.sort_unstable();
        endings.dedup();
        let mut arms: Vec<(Ending, Arm)> = endings.into_iter().map(|at| (at, site.arm(assembly, at))).collect();
        clockwise(assembly, &mut arms);
        (site.endings, site.arms) = arms.into_iter().unzip();
        for (member, [from, to]) in around {
            let position = |ending: Ending| site.endings.iter().position(|it| *it == ending);
            let (Some(start), Some(end)) = (position(ending(from, true)), position(ending(to, false))) else {
                continue;
            };
            let lane_of = |lanes: &[ArmLane], lane: usize| lanes.iter().position(|it| it.lane == lane);
            let (into, out) = (&site.arms[start].into, &site.arms[end].out);
            let (Some(in_lane), Some(out_lane)) = (lane_of(into, from), lane_of(out, to)) else { continue };
            let movement = Movement { from: start, to: end, in_lane, out_lane };
            let Some(path) = site.path(assembly, members, member, movement, side) else { continue };
            site.paths.push(path);
            site.members.push(member);
        }
        site.strays = members.iter().copied().filter(|member| !site.members.contains(member)).collect();
        site
    }

    /// The first lane outside the junction from which a member is reached, or which is reached from it.
    fn leave(&self, members: &[usize], member: usize, ahead: bool) -> Option<usize> {
        let links = if ahead { &self.drawn.next } else { &self.drawn.back };
        let mut at = member;
        // A chain has at most all members.
        for _ in 0..=members.len() {
            at = *links[at].first()?;
            if !members.contains(&at) {
                return Some(at);
            }
        }
        None
    }

    /// The end of a road at the junction.
    fn arm(&self, assembly: &MapBuilder, (road, far): Ending) -> Arm {
        let cut = &self.scene.cut[road];
        let stretch = self.scene.first[road] + if far { cut.stretches.len().saturating_sub(1) } else { 0 };
        let span = self.scene.stretches[stretch].span;
        let angle = self.scene.plane.angle(self.scene.road(stretch).angle(if far { span[1] } else { span[0] }));
        let along = Vector::new(angle.cos(), angle.sin());
        let inward = if far { along } else { -along };
        let end = if far { End::End } else { End::Start };
        let mut arm = Arm {
            at: RoadEnd { road: RoadIx::new(road), end },
            inward,
            aim: inward,
            into: Vec::new(),
            out: Vec::new(),
            cut: Vec::new(),
        };
        let mut here: Vec<(usize, &DrawnLane)> =
            self.drawn.on(stretch).filter(|(_, lane)| lane.used.is_driven()).collect();
        // From right to left, looking in.
        if far {
            here.reverse();
        }
        for (at, lane) in here {
            let leads_in = lane.exit().far == far;
            let nodes = lane.nodes[usize::from(leads_in)];
            let [left, right] = nodes;
            arm.cut.extend(if leads_in { [right, left] } else { [left, right] });
            let heading = if leads_in { inward } else { -inward };
            let list = if leads_in { &mut arm.into } else { &mut arm.out };
            list.push(ArmLane::new(assembly, at, nodes, heading, strip(lane.used)));
        }
        let mut seen = BTreeSet::new();
        arm.cut.retain(|id| seen.insert(*id));
        // From left to right in their own direction of travel.
        arm.into.reverse();
        arm
    }

    fn path(
        &self,
        assembly: &MapBuilder,
        members: &[usize],
        member: usize,
        movement: Movement,
        side: DrivingSide,
    ) -> Option<TurningLanelet> {
        let lane = &self.drawn.lanes[member];
        let [left, right] = lane.bounds.map(|bound| assembly.bound_line(bound));
        let middle = center_line(&left, &right)?;
        // The whole way through the junction turns, of which this lane may be a part.
        let mut turn = turned(side, &middle);
        for links in [&self.drawn.next, &self.drawn.back] {
            let mut at = member;
            // A chain has at most all members.
            for _ in 1..members.len() {
                let Some(&other) = links[at].first().filter(|other| members.contains(other) && **other != member)
                else {
                    break;
                };
                let [left, right] = self.drawn.lanes[other].bounds.map(|bound| assembly.bound_line(bound));
                turn += center_line(&left, &right).map_or(0.0, |middle| turned(side, &middle));
                at = other;
            }
        }
        let heading = middle.at(crate::lanelet::index::HEADING_REACH.min(middle.length())) - middle.first();
        Some(TurningLanelet {
            movement,
            lanelet: lane.lanelet,
            turn,
            outline: left.into_iter().chain(right.into_iter().rev()).collect(),
            bounds: lane.bounds.map(|bound| bound.line),
            heading: heading.try_normalize(f64::EPSILON)?,
            corner: 0.0,
            radius: f64::INFINITY,
            sway: 0.0,
            kind: strip(lane.used),
        })
    }

    /// Says of the lanelets that are no ways through the junction which way they turn, and in which area they lie.
    fn turn_strays(&self, assembly: &mut MapBuilder, side: DrivingSide, area: &str) {
        for &stray in &self.strays {
            let lane = &self.drawn.lanes[stray];
            let [left, right] = lane.bounds.map(|bound| assembly.bound_line(bound));
            let turn = center_line(&left, &right).map_or(0.0, |middle| turned(side, &middle));
            if let Some(attributes) = assembly.attributes_mut(lane.lanelet) {
                let direction = match turn {
                    turn if turn.abs() <= STRAIGHT_ON => TurnDirection::Straight,
                    turn if turn > 0.0 => TurnDirection::Left,
                    _ => TurnDirection::Right,
                };
                attributes.set("turn_direction", direction.as_str());
                attributes.set("intersection_area", area);
            }
        }
    }

    fn finish(
        self,
        assembly: &mut MapBuilder,
        junction: &Junction,
        lanes: &Lanes,
        (furniture, side): (&Furniture, DrivingSide),
        made: &mut Made,
    ) {
        let indices = strip_indices(&self.paths);
        let found = conflicts(&self.paths, &indices);
        let controls: Vec<Control> = (0..self.arms.len()).map(|arm| self.control(arm, furniture)).collect();
        if !self.needs_area(&found, &controls) {
            return;
        }
        self.crossing_neighbours(junction, &found, made);
        let key = Key::new("opendrive").word("intersection area").word(&junction.id);
        let mut bounds = SharedBounds::default();
        // Lanes that lead nowhere lie in the area, too.
        let nowhere = Movement { from: 0, to: 0, in_lane: 0, out_lane: 0 };
        let strays = self.strays.iter().filter_map(|&stray| self.path(assembly, &[], stray, nowhere, side));
        let covered: Vec<TurningLanelet> = self.paths.iter().cloned().chain(strays).collect();
        let covered_indices = strip_indices(&covered);
        for line in covered.iter().flat_map(|path| path.bounds) {
            bounds.adopt(assembly, line);
        }
        let arms: Vec<&Arm> = self.arms.iter().collect();
        let ground = assembly.ground_between(arms.iter().flat_map(|arm| arm.cut.iter().copied()));
        assembly.set_ground(ground);
        let outline = area_outline(assembly, key, lanes, &arms, &bounds, (&covered, &covered_indices), &[]);
        assembly.set_ground(Ground::default());
        let id = assembly.polygon_id(key);
        assembly.polygon(id, outline.ring.clone(), Attributes::of(&[("type", "intersection_area"), ("area", "yes")]));
        made.areas += 1;
        made.in_area.extend(&self.members);
        for arm in (0..arms.len()).filter(|arm| controls[*arm] == Control::Signals) {
            let of_arm = self.paths.iter().zip(&self.members).filter(|(path, _)| path.movement.from == arm);
            made.lit.push(of_arm.map(|(_, member)| *member).collect());
        }
        for &arm in &outline.lost {
            let message = format!(
                "the area of junction {} does not lead along the end of road {}",
                junction.id, self.scene.file.roads[self.endings[arm].0].id
            );
            let cut = assembly.positions(&arms[arm].cut);
            made.notes.push(note("lane-end-inside", junction.line, message).at(Place::Line(cut)));
        }
        self.loose_ends(junction, made);
        let name = id.0.to_string();
        for path in &self.paths {
            if let Some(attributes) = assembly.attributes_mut(path.lanelet) {
                attributes.set("turn_direction", turn_direction(path).as_str());
                attributes.set("intersection_area", &name);
            }
        }
        self.turn_strays(assembly, side, &name);
        let legs = legs_of(assembly, &arms);
        let ranks = self.ranks(junction, &controls, furniture);
        let ranked = self.ranked_movements(&controls, &ranks, side);
        let phases = self.phases(junction, furniture);
        rights_of_way(assembly, &legs, &self.paths, &ranked, &found, &phases);
        let of_leg = headings(&legs, &self.paths);
        let heading_of: Vec<_> = legs.iter().map(|&leg| of_leg[leg]).collect();
        let names = intersection_settings::names(&arms, &heading_of, lanes);
        made.settings.extend(junction_settings(id, &names, &ranked, phases));
    }

    /// Tells of lanes that begin side by side and lie on each other farther on, by the file's own borders.
    fn crossing_neighbours(&self, junction: &Junction, found: &Conflicts, made: &mut Made) {
        for (at, others) in found.real.iter().enumerate() {
            for &other in others.iter().filter(|&&other| other > at) {
                let [a, b] = [at, other].map(|at| self.paths[at].movement);
                let side_by_side = a.from == b.from && a.in_lane.abs_diff(b.in_lane) == 1;
                if !side_by_side || (a.to, a.out_lane) == (b.to, b.out_lane) {
                    continue;
                }
                let pieces = [at, other].map(|at| self.drawn.lanes[self.members[at]].pieces[0]);
                let [a, b] = pieces.map(|piece| self.drawn.name(self.scene, piece));
                let message =
                    format!("in junction {}, {a} and {b} begin side by side and overlap farther on", junction.id);
                let told = note("opendrive-overlap", junction.line, message).graded(Severity::Warning);
                made.notes.push(pieces.into_iter().fold(told, |told, piece| self.drawn.about(told, piece)));
            }
        }
    }

    /// Names the lanes that the file leads to the junction and links to nothing there, and the directions of lanes for both in which
    /// nothing leads on.
    fn loose_ends(&self, junction: &Junction, made: &mut Made) {
        let mut around = self.endings.clone();
        for (index, road) in self.scene.file.roads.iter().enumerate() {
            for (side, link) in road.links.iter().enumerate() {
                let leads = matches!(link, Some(RoadLink::Junction(id)) if *id == junction.id);
                around.extend(leads.then_some((index, side == 1)));
            }
        }
        around.sort_unstable();
        around.dedup();
        for (road, far) in around {
            let Some(last) = self.scene.cut[road].stretches.len().checked_sub(1) else { continue };
            let stretch = self.scene.first[road] + if far { last } else { 0 };
            for (at, lane) in self.drawn.on(stretch).filter(|(_, lane)| lane.used.is_driven()) {
                let ends = lane.exit().far == far;
                let end = if ends { lane.exit() } else { lane.entry() };
                let turned = |other: &DrawnLane| other.pieces == lane.pieces && other.direction != lane.direction;
                let both_ways = self.drawn.on(stretch).any(|(_, other)| turned(other));
                let goes_on = if ends { &self.drawn.next[at] } else { &self.drawn.back[at] };
                if self.drawn.linked.contains(&end) && !(both_ways && goes_on.is_empty()) {
                    continue;
                }
                let list = if ends { &mut made.loose_ends.ends } else { &mut made.loose_ends.starts };
                list.insert(lane.lanelet.0);
                let (lane, road) = (end.lane, &self.scene.file.roads[road].id);
                let message = match ends {
                    true => format!("junction {} leads nowhere from lane {lane} of road {road}", junction.id),
                    false => format!("junction {} leads from nowhere to lane {lane} of road {road}", junction.id),
                };
                made.notes.push(note("opendrive-link", junction.line, message));
            }
        }
    }
}

/// Puts the arms into clockwise order around the middle of the junction.
fn clockwise(assembly: &MapBuilder, arms: &mut [(Ending, Arm)]) {
    let middle = |cut: &[PointId]| -> Point {
        let places = assembly.positions(cut);
        let sum: Vector = places.iter().map(|place| place.coords).sum();
        Point::from(sum / places.len().max(1) as f64)
    };
    let sum: Vector = arms.iter().map(|(_, arm)| middle(&arm.cut).coords).sum();
    let centre = Point::from(sum / arms.len().max(1) as f64);
    // A little behind the cut, so that two roads side by side keep their order whatever their ends are.
    let bearing = |arm: &Arm| {
        let ray = middle(&arm.cut) - arm.inward * 0.1 - centre;
        ray.y.atan2(ray.x)
    };
    arms.sort_by(|(a_at, a), (b_at, b)| bearing(b).total_cmp(&bearing(a)).then(a_at.cmp(b_at)));
}

/// What the map format cannot say of a junction: which approaches go first, and which are green together.
fn junction_settings(
    area: PolygonId,
    names: &[ApproachName],
    ranked: &[RankedMovement],
    phases: Vec<Vec<usize>>,
) -> Option<IntersectionSettings> {
    // The settings know approaches: one of which some ways go first is none that does.
    let all_first = |arm: usize| ranked.iter().all(|it| it.arm != arm || it.priority == Some(true));
    let arms: Vec<RankedMovement> = ranked
        .iter()
        .map(|ranked| RankedMovement { priority: ranked.priority.filter(|_| all_first(ranked.arm)), ..*ranked })
        .collect();
    let settings = intersection_settings::settings(area, names, &[], &arms);
    if phases.is_empty() {
        return settings;
    }
    let settings = settings.unwrap_or(IntersectionSettings { ia: Some(area.0), ..IntersectionSettings::default() });
    let phases = phases.into_iter().map(|arms| arms.into_iter().map(|arm| names[arm].clone()).collect());
    Some(IntersectionSettings { phases: phases.collect(), ..settings })
}
