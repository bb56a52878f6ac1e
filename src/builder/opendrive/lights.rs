//! Lights, signs and stop lines as elements of the map, hung on the lanelets that they control.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;

use crate::builder::control::stop_line::{PAINTED_LINE, SIGN_LINE, stop_line};
use crate::builder::control::vehicle_signals::bulbs_of;
use crate::builder::ids::Key;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::approach_control::Control;
use crate::diagnostic::{Finding, Severity};
use crate::geometry::{Point, Polyline, Vector, left_of};
use crate::lanelet::{Attributes, Bound, LaneletId, LineStringId, PointId, Target};
use crate::osm::Text;
use crate::xodr::Signal;

use super::hung_lights::{HungLights, Light};
use super::lane_use::sides;
use super::lines::point;
use super::scene::{Drawn, Piece, Scene, note};
use super::signal_use::{SignalUse, is_in_metres};
use super::signals::{Approach, Furniture, Placed, approaches};

/// Width and height of a light whose size is not said, metres.
const BODY: [f64; 2] = [0.4, 1.2];
/// Heights of the bodies of lights, metres.
const HEIGHTS: RangeInclusive<f64> = 0.2..=2.0;
/// Width and height of a light for people on foot, metres.
pub const WALK_BODY: [f64; 2] = [0.3, 0.8];
/// Width of a sign, metres.
const SIGN: f64 = 0.6;
/// A stop line of the file that lies so near to the end of its lane, metres, is the lane's end.
const AT_END: f64 = 0.5;

/// Draws what signals say.
pub struct Drawing<'a> {
    /// The file.
    pub scene: &'a Scene<'a>,
    /// Its lanelets.
    pub drawn: &'a Drawn,
    /// Its signals.
    pub furniture: &'a Furniture<'a>,
    /// Stop lines, by the lane before.
    lines: BTreeMap<usize, LineStringId>,
    /// The lights of the lanelets behind stop lines.
    lit: HungLights,
    /// What could not be drawn as it should.
    pub notes: Vec<Finding>,
}

impl<'a> Drawing<'a> {
    /// Nothing is drawn yet.
    pub fn new(scene: &'a Scene<'a>, drawn: &'a Drawn, furniture: &'a Furniture<'a>) -> Self {
        Self { scene, drawn, furniture, lines: BTreeMap::new(), lit: HungLights::default(), notes: Vec::new() }
    }

    /// Draws lights, signs and stop lines. `in_area` tells which lanelets lie in an intersection area; `lit` has those behind each
    /// approach with lights.
    pub fn draw(&mut self, assembly: &mut MapBuilder, in_area: impl Fn(usize) -> bool, lit: &[Vec<usize>]) {
        let furniture = self.furniture;
        for placed in &furniture.signals {
            match placed.used {
                SignalUse::VehicleLight => self.light(assembly, placed),
                SignalUse::Stop => self.sign(assembly, placed, "stop_sign"),
                SignalUse::GiveWay => self.sign(assembly, placed, "give_way"),
                SignalUse::Speed(limit) => self.speed(assembly, placed, limit),
                SignalUse::WalkLight | SignalUse::StopLine | SignalUse::Priority | SignalUse::Other => {}
            }
        }
        for members in lit {
            self.light_rest(assembly, members);
        }
        std::mem::take(&mut self.lit).draw(assembly);
        // All other approaches: vehicles stop there only for others.
        for lane in 0..self.drawn.lanes.len() {
            let behind: Vec<usize> = self.drawn.next[lane].iter().copied().filter(|&next| in_area(next)).collect();
            let has_line = self.furniture.stops.contains_key(&lane);
            if in_area(lane) || behind.is_empty() && !has_line {
                continue;
            }
            if self.furniture.at_line(self.scene, self.drawn, lane).is_some() && !has_line {
                // It begins behind the stop line.
                continue;
            }
            let behind = if behind.is_empty() { self.drawn.next[lane].clone() } else { behind };
            let control = self.furniture.control(&[&[lane][..], &behind].concat());
            if matches!(control, Control::Signals | Control::Stop) && self.lines.contains_key(&lane) {
                continue;
            }
            let carriers =
                if behind.is_empty() { vec![self.drawn.lanes[lane].lanelet] } else { self.lanelets(&behind) };
            let line = self.stop_line(assembly, lane, PAINTED_LINE);
            let key = self.lane_key("marking", lane);
            assembly.element(key, "road_marking", &[("refers", Target::LineString(line))], &carriers);
        }
        self.paint(assembly);
    }

    /// Draws the stop lines of the file at which no lane of the map ends, as paint only.
    fn paint(&mut self, assembly: &mut MapBuilder) {
        /// A line that lies so near to one that is drawn, metres, is that one.
        const KNOWN: f64 = 1.0;
        let place = |assembly: &MapBuilder, line: &LineStringId| {
            Polyline::new(assembly.bound_line(Bound { line: *line, inverted: false }))
        };
        let mut known: Vec<Polyline> = self.lines.values().filter_map(|line| place(assembly, line)).collect();
        for line in &self.furniture.lines {
            let road = &self.scene.file.roads[line.road];
            let of_lane = || {
                let lane = &self.drawn.lanes[*line.lanes.first()?];
                let Piece { stretch, lane } = self.scene.piece_at(lane, line.station);
                let [high, low] = sides(lane)
                    .map(|border| self.scene.section_near(stretch, line.station).offset(road, border, line.station));
                Some([low, high])
            };
            let Some([low, high]) = line.across.or_else(of_lane) else { continue };
            let ends = [high, low].map(|offset| road.place(line.station, offset));
            let ends_in_map: Vec<Point> = self.scene.plane.to_map(&ends).into_iter().map(|(at, _)| at).collect();
            let Some(own) = Polyline::new(ends_in_map) else { continue };
            let middle = own.at(own.length() / 2.0);
            if known.iter().any(|other| other.distance(middle) <= KNOWN) {
                continue;
            }
            let key = Key::new("opendrive").word("paint").word(&road.id).word(&line.id).number(line.line as i64);
            let nodes = [("left", ends[0]), ("right", ends[1])]
                .map(|(name, place)| point(assembly, self.scene.plane, key.word(name), place));
            stop_line(assembly, key, nodes, PAINTED_LINE);
            known.push(own);
            let message = format!(
                "stop line {} of road {} lies where no lane of the map ends: it is drawn, and vehicles stop where theirs does",
                line.id, road.id
            );
            self.notes.push(note("opendrive-signal", line.line, message).graded(Severity::Warning));
        }
    }

    fn lanelets(&self, lanes: &[usize]) -> Vec<LaneletId> {
        lanes.iter().map(|&lane| self.drawn.lanes[lane].lanelet).collect()
    }

    fn lane_key(&self, part: &str, lane: usize) -> Key {
        Key::new("opendrive").word(part).number(self.drawn.lanes[lane].lanelet.0)
    }

    /// The stop line of a lane: where the file has it, else at the lane's end.
    fn stop_line(&mut self, assembly: &mut MapBuilder, at: usize, subtype: &str) -> LineStringId {
        if let Some(known) = self.lines.get(&at) {
            return *known;
        }
        let lane = &self.drawn.lanes[at];
        let key = self.lane_key("stop", at);
        let [from, to] = self.scene.span(lane);
        let end = if lane.direction > 0 { to } else { from };
        let said = self.furniture.stops.get(&at).copied().filter(|station| (station - end).abs() > AT_END);
        let nodes = match said {
            None => lane.nodes[1],
            Some(station) => {
                let Piece { stretch, lane: id } = self.scene.piece_at(lane, station);
                let (road, section) = (self.scene.road(stretch), self.scene.section_near(stretch, station));
                let [high, low] = sides(id).map(|border| road.place(station, section.offset(road, border, station)));
                let [left, right] = if lane.direction > 0 { [high, low] } else { [low, high] };
                [("left", left), ("right", right)]
                    .map(|(name, place)| point(assembly, self.scene.plane, key.word(name), place))
            }
        };
        let line = stop_line(assembly, key, nodes, subtype);
        self.lines.insert(at, line);
        line
    }

    /// The approaches of a signal; without a junction behind, its lanes themselves.
    fn approaches(&self, placed: &Placed) -> Vec<Approach> {
        let (at_exit, others): (Vec<usize>, Vec<usize>) =
            placed.lanes.iter().partition(|lane| placed.at_exit.contains(lane));
        let (between, near): (Vec<usize>, Vec<usize>) =
            others.into_iter().partition(|&lane| placed.is_between(self.scene, self.drawn, lane));
        let mut found = approaches(self.scene, self.drawn, &near);
        for approach in &mut found {
            if let Some(at_line) = self.furniture.at_line(self.scene, self.drawn, approach.lane) {
                *approach = at_line;
            }
        }
        let others = if found.is_empty() { near } else { Vec::new() };
        found.extend(at_exit.into_iter().map(|lane| Approach { lane, behind: self.drawn.next[lane].clone() }));
        for lane in between.into_iter().chain(others) {
            // Lanes are split at lights; the part that begins there may be the one behind or the one before.
            let before = self.drawn.back[lane].first().copied().filter(|_| self.drawn.lanes[lane].direction > 0);
            found.push(match before {
                Some(before) => Approach { lane: before, behind: vec![lane] },
                None => Approach { lane, behind: self.drawn.next[lane].clone() },
            });
        }
        found
    }

    /// Adds a light and the elements by which lanelets obey it.
    fn light(&mut self, assembly: &mut MapBuilder, placed: &Placed) {
        let approaches = self.approaches(placed);
        let key = signal_key(self.scene, placed, "light");
        let Some(heading) = self.heading(assembly, placed, &approaches) else {
            let message = format!(
                "light {} of road {} controls no lane",
                placed.signal.id, self.scene.file.roads[placed.road].id
            );
            self.notes.push(note("opendrive-signal", placed.signal.line, message).graded(Severity::Warning));
            return;
        };
        let shape = Body::of(placed.signal, BODY, heading);
        let lines = body(assembly, self.scene, placed, key, &shape, &["green", "yellow", "red"]);
        for Approach { lane, behind } in approaches {
            let line = self.stop_line(assembly, lane, PAINTED_LINE);
            let behind = if behind.is_empty() { vec![lane] } else { behind };
            for lanelet in self.lanelets(&behind) {
                self.lit.hang(lanelet, line, Light { key, lines });
            }
        }
    }

    /// Lets those lanelets behind an approach obey the lights of another of the approach where the file gives them none: Autoware wants
    /// all or none.
    fn light_rest(&mut self, assembly: &mut MapBuilder, members: &[usize]) {
        let lit = |lane: &usize| self.lit.has(self.drawn.lanes[*lane].lanelet);
        let (lit, unlit): (Vec<usize>, Vec<usize>) = members.iter().partition(|lane| lit(lane));
        for lane in unlit {
            let before = self.drawn.back[lane].first().copied();
            let beside = lit.iter().find(|it| self.drawn.back[**it].first().copied() == before);
            let (Some(before), Some(other)) = (before, beside.or(lit.first())) else { continue };
            let line = self.stop_line(assembly, before, PAINTED_LINE);
            let [lane, other] = [lane, *other].map(|lane| self.drawn.lanes[lane].lanelet);
            self.lit.hang_alike(lane, line, other);
        }
    }

    /// The direction in which drivers look who see a signal: that of the signal's face, turned toward them.
    fn heading(&self, assembly: &MapBuilder, placed: &Placed, approaches: &[Approach]) -> Option<Vector> {
        let lane = &self.drawn.lanes[approaches.first()?.lane];
        let ends: Vec<Point> =
            lane.bounds.iter().flat_map(|bound| assembly.bound_line(*bound).into_iter().rev().take(2)).collect();
        let travel = match ends[..] {
            [a, b, c, d] => ((a - b) + (c - d)).try_normalize(f64::EPSILON)?,
            _ => return None,
        };
        let road = &self.scene.file.roads[placed.road];
        let angle = self.scene.plane.angle(road.angle(placed.signal.at[0]) + placed.signal.turn);
        let face = Vector::new(angle.cos(), angle.sin());
        Some(match face.dot(&travel) {
            along if along.abs() < 0.5 => travel,
            along if along < 0.0 => -face,
            _ => face,
        })
    }

    /// Adds a sign and the element that announces it to the lanes before its stop line.
    fn sign(&mut self, assembly: &mut MapBuilder, placed: &Placed, subtype: &str) {
        let approaches = self.approaches(placed);
        let Some(heading) = self.heading(assembly, placed, &approaches) else { return };
        let key = signal_key(self.scene, placed, "sign");
        let width = if placed.signal.size[0] > 0.0 { placed.signal.size[0] } else { SIGN };
        let shape = Body { heading, size: [width; 2], lift: 0.0 };
        let sign = edge(assembly, self.scene, placed, key, &shape);
        let sign = assembly.line(key, sign.to_vec(), Attributes::of(&[("type", "traffic_sign"), ("subtype", subtype)]));
        for approach in approaches {
            let line = self.stop_line(assembly, approach.lane, SIGN_LINE);
            let members = [("refers", Target::LineString(sign)), ("ref_line", Target::LineString(line))];
            assembly.element(key.number(line.0), "traffic_sign", &members, &self.lanelets(&[approach.lane]));
        }
    }

    /// Sets the limit of a sign on its lanes and those behind it on the same road, where the file says none.
    fn speed(&mut self, assembly: &mut MapBuilder, placed: &Placed, limit: f64) {
        if is_in_metres(placed.signal) {
            let id = &placed.signal.id;
            let message =
                format!("the speed limit of signal {id} is a usual one in m/s, but not in its unit: {limit:.0} km/h");
            self.notes.push(note("opendrive-speed", placed.signal.line, message).graded(Severity::Warning));
        }
        for &lane in &placed.lanes {
            let (mut at, mut seen) = (Some(lane), BTreeSet::new());
            while let Some(here) = at.filter(|lane| seen.insert(*lane)) {
                let lane = &self.drawn.lanes[here];
                let piece = self.scene.middle_piece(lane);
                let (road, section) = (self.scene.road(piece.stretch), self.scene.section(piece.stretch));
                let said =
                    section.lane(piece.lane).and_then(|it| road.speed(section, it, self.scene.middle(piece.stretch)));
                if said.is_none()
                    && let Some(tags) = assembly.attributes_mut(lane.lanelet)
                {
                    tags.set("speed_limit", Text::from(limit.round().to_string()));
                }
                let own = self.scene.road_of(lane);
                let goes_on = |next: &&usize| self.scene.road_of(&self.drawn.lanes[**next]) == own;
                at = self.drawn.next[here].iter().find(goes_on).copied();
            }
        }
    }
}

/// The body of a light, or the face of a sign.
pub struct Body {
    /// The direction in which those look who see it.
    heading: Vector,
    /// Width and height, metres.
    size: [f64; 2],
    /// Of its lower edge above the signal's place, metres.
    lift: f64,
}

impl Body {
    /// Of a light, where not said of the usual size. Some files give the height of the pole: the light is at its top.
    pub fn of(signal: &Signal, usual: [f64; 2], heading: Vector) -> Self {
        let [width, height] = signal.size;
        let width = if width > 0.0 { width } else { usual[0] };
        let known = HEIGHTS.contains(&height);
        let lift = if height > *HEIGHTS.end() { height - usual[1] } else { 0.0 };
        Self { heading, size: [width, if known { height } else { usual[1] }], lift }
    }
}

/// The key of what a signal becomes.
fn signal_key(scene: &Scene, placed: &Placed, part: &str) -> Key {
    let road = &scene.file.roads[placed.road].id;
    Key::new("opendrive").word(part).word(road).word(&placed.signal.id).number(placed.signal.line as i64)
}

/// The points of the lower edge of a signal, from left to right as drivers see it.
fn edge(
    assembly: &mut MapBuilder,
    scene: &Scene,
    placed: &Placed,
    key: Key,
    &Body { heading, size: [width, _], lift }: &Body,
) -> [PointId; 2] {
    let road = &scene.file.roads[placed.road];
    let (middle, height) = scene.plane.to_map(&[placed.signal.place(road)]).pop().unwrap_or_default();
    let right = -left_of(heading);
    [("left", -0.5), ("right", 0.5)].map(|(name, along)| {
        assembly.point_at(key.word(name), middle + right * (width * along), height + lift, Attributes::new())
    })
}

/// Adds the body of a light and its lamps, one above the other, or side by side where it is broader than high.
pub fn body(
    assembly: &mut MapBuilder,
    scene: &Scene,
    placed: &Placed,
    key: Key,
    shape: &Body,
    colors: &[&str],
) -> [LineStringId; 2] {
    let [width, height] = shape.size;
    let ends = edge(assembly, scene, placed, key, shape);
    let subtype = if colors.len() == 2 { "red_green" } else { "red_yellow_green" };
    let mut tags = Attributes::of(&[("type", "traffic_light"), ("subtype", subtype)]);
    tags.push("height", Text::from(format!("{height}")));
    let light = assembly.named_line(key, ends.to_vec(), tags);
    let [left, right] = ends.map(|end| assembly.position(end));
    let road = &scene.file.roads[placed.road];
    let (_, base) = scene.plane.to_map(&[placed.signal.place(road)]).pop().unwrap_or_default();
    let count = colors.len() as f64;
    let lamps = colors.iter().enumerate().map(|(i, &color)| {
        let part = (i as f64 + 0.5) / count;
        let (at, up) = if width > height {
            (left + (right - left) * part, height / 2.0)
        } else {
            (nalgebra::center(&left, &right), height * part)
        };
        assembly.point_at(key.word(color), at, base + shape.lift + up, Attributes::of(&[("color", color)]))
    });
    let lamps: Vec<PointId> = lamps.collect();
    let bulbs = assembly.line(key.word("bulbs"), lamps, bulbs_of(light));
    [light, bulbs]
}
