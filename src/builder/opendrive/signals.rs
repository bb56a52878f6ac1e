//! Which lanes signals and stop lines of the file speak to, and what controls the approaches of junctions.

use std::collections::{BTreeMap, BTreeSet};

use crate::builder::network::approach_control::Control;
use crate::xodr::{Signal, Validity};

use super::scene::{Drawn, Scene, spoken_to};
use super::signal_use::{AT_CUT, SignalUse, is_between, use_of};
use super::stop_lines::{StopLine, stop_lines};

/// From a signal to the junction whose lanelets it controls, metres at most.
const SIGNAL_TO_JUNCTION: f64 = 120.0;
/// A stop line is no farther from its junction than this, metres.
const LINE_TO_JUNCTION: f64 = 40.0;

/// A signal, and the lanes that it speaks to.
#[derive(Clone, Debug)]
pub struct Placed<'a> {
    /// The signal.
    pub signal: &'a Signal,
    /// Index of its road.
    pub road: usize,
    /// What it is for.
    pub used: SignalUse,
    /// Lanelets, by index.
    pub lanes: Vec<usize>,
    /// Those of them that lead through a junction and at whose end it counts.
    pub at_exit: BTreeSet<usize>,
}

impl Placed<'_> {
    /// Whether it is a light that stands on a lane between intersections.
    pub fn is_between(&self, scene: &Scene, drawn: &Drawn, lane: usize) -> bool {
        let lane = &drawn.lanes[lane];
        let own = scene.road_of(lane) == self.road;
        let between = || is_between(scene.road(lane.stretch()), self.signal.at[0], lane.direction);
        own && self.used == SignalUse::VehicleLight && between()
    }
}

/// An approach of a junction: the last lane before it, and the lanes behind its end for which a signal counts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Approach {
    /// The lanelet before.
    pub lane: usize,
    /// The lanelets behind.
    pub behind: Vec<usize>,
}

/// All that signals and lines say.
#[derive(Default)]
pub struct Furniture<'a> {
    /// In order of the file.
    pub signals: Vec<Placed<'a>>,
    /// The stop lines of the file.
    pub lines: Vec<StopLine>,
    /// The station of the stop line of each lane, metres.
    pub stops: BTreeMap<usize, f64>,
    /// The lanes that end at a stop line, with more road behind it.
    pub at_end: BTreeSet<usize>,
    /// What controls each lane: approaches, and lanes of junctions.
    controls: BTreeMap<usize, Control>,
    /// The same lanes where a sign says that they go first.
    first: BTreeSet<usize>,
    /// The lights of those lanes, by their ids.
    lights: BTreeMap<usize, BTreeSet<&'a str>>,
}

impl<'a> Furniture<'a> {
    /// Whether a sign says of one of these lanes that it goes first.
    pub fn goes_first(&self, lanes: &[usize]) -> bool {
        lanes.iter().any(|lane| self.first.contains(lane))
    }

    /// The ids of the lights of these lanes.
    pub fn lights(&self, lanes: &[usize]) -> BTreeSet<&'a str> {
        lanes.iter().filter_map(|lane| self.lights.get(lane)).flatten().copied().collect()
    }

    /// Where the last lane before a junction, or one before it on the same road, begins at a stop line: the lane that ends at the line,
    /// and those from there to the junction.
    pub fn at_line(&self, scene: &Scene, drawn: &Drawn, lane: usize) -> Option<Approach> {
        let (mut at, mut gone) = (lane, 0.0);
        let mut behind = vec![lane];
        while let [before] = drawn.back[at][..] {
            if self.at_end.contains(&before) {
                behind.reverse();
                return Some(Approach { lane: before, behind });
            }
            let [from, to] = scene.span(&drawn.lanes[at]);
            gone += to - from;
            if gone > LINE_TO_JUNCTION || scene.road_of(&drawn.lanes[before]) != scene.road_of(&drawn.lanes[lane]) {
                break;
            }
            at = before;
            behind.push(at);
        }
        None
    }

    /// What controls an approach, by its lanes and those behind: lights, else a stop sign, else a give-way sign.
    pub fn control(&self, lanes: &[usize]) -> Control {
        let found: Vec<Control> = lanes.iter().filter_map(|lane| self.controls.get(lane).copied()).collect();
        let order = [Control::Signals, Control::Stop, Control::GiveWay];
        order.into_iter().find(|control| found.contains(control)).unwrap_or(Control::None)
    }
}

/// Finds the lanes of all signals and stop lines.
pub fn furniture<'a>(scene: &Scene<'a>, drawn: &Drawn) -> Furniture<'a> {
    let mut all = Furniture::default();
    let mut references: BTreeMap<&str, Vec<(usize, f64, &Validity)>> = BTreeMap::new();
    for (index, road) in scene.file.roads.iter().enumerate() {
        for it in &road.references {
            references.entry(it.id.as_str()).or_default().push((index, it.at[0], &it.validity));
        }
    }
    all.lines = stop_lines(scene, drawn);
    for (index, road) in scene.file.roads.iter().enumerate() {
        for signal in &road.signals {
            let used = use_of(signal);
            let references = references.get(signal.id.as_str()).map_or(&[][..], Vec::as_slice);
            let referred = |it: &&StopLine| references.iter().any(|(road, station, _)| it.is_at(*road, *station));
            let at_lines: Vec<&StopLine> = all
                .lines
                .iter()
                .filter(|it| used == SignalUse::VehicleLight && !it.lanes.is_empty())
                .filter(referred)
                .collect();
            // A light that is referred to at a stop line counts there, wherever it stands.
            let mut lanes: Vec<usize> = at_lines.iter().flat_map(|line| line.lanes.iter().copied()).collect();
            let at_exit = at_lines.iter().flat_map(|line| line.at_exit(scene, drawn)).collect();
            if at_lines.is_empty() {
                lanes = spoken_to(scene, drawn, index, signal.at[0], &signal.validity);
                for (other, station, validity) in references {
                    lanes.extend(spoken_to(scene, drawn, *other, *station, validity));
                }
            }
            lanes.sort_unstable();
            lanes.dedup();
            all.signals.push(Placed { signal, road: index, used, lanes, at_exit });
        }
    }
    for at in 0..all.lines.len() {
        let StopLine { lanes, station, .. } = &all.lines[at];
        let (lanes, station) = (lanes.clone(), *station);
        for lane in lanes {
            stop(scene, drawn, &mut all, lane, station);
        }
    }
    control_lanes(scene, drawn, &mut all);
    all
}

/// Says of the lanes of lights and signs, and of those before them, what controls them.
fn control_lanes(scene: &Scene, drawn: &Drawn, all: &mut Furniture) {
    for it in &all.signals {
        let control = match it.used {
            SignalUse::VehicleLight => Control::Signals,
            SignalUse::Stop => Control::Stop,
            SignalUse::GiveWay => Control::GiveWay,
            SignalUse::Priority => Control::None,
            _ => continue,
        };
        let near = |lane: &usize| !it.is_between(scene, drawn, *lane) && !it.at_exit.contains(lane);
        let near: Vec<usize> = it.lanes.iter().copied().filter(near).collect();
        for approach in approaches(scene, drawn, &near) {
            // A light on one connecting lane does not rule the others that leave the same lane.
            let lanes = if it.lanes.contains(&approach.lane) { vec![approach.lane] } else { approach.behind };
            for lane in lanes {
                if it.used == SignalUse::Priority {
                    all.first.insert(lane);
                    continue;
                }
                if control == Control::Signals {
                    all.lights.entry(lane).or_default().insert(it.signal.id.as_str());
                }
                let known = all.controls.entry(lane).or_insert(control);
                if control == Control::Signals || (control == Control::Stop && *known == Control::GiveWay) {
                    *known = control;
                }
            }
        }
    }
}

/// Keeps the stop line of a lane that lies nearest to its end. A line at the begin of a lane is that of those before it.
fn stop(scene: &Scene, drawn: &Drawn, all: &mut Furniture, at: usize, station: f64) {
    let lane = &drawn.lanes[at];
    let [from, to] = scene.span(lane);
    let begin = if lane.direction > 0 { from } else { to };
    let inside = scene.connecting[scene.road_of(lane)];
    let before = |other: &&usize| scene.road_of(&drawn.lanes[**other]) == scene.road_of(lane);
    if !inside && (station - begin).abs() < AT_CUT && drawn.back[at].iter().any(|other| before(&other)) {
        for &other in drawn.back[at].iter().filter(before) {
            let [from, to] = scene.span(&drawn.lanes[other]);
            all.stops.insert(other, if lane.direction > 0 { to } else { from });
            all.at_end.insert(other);
        }
        return;
    }
    let station = station.clamp(from, to);
    let end = if lane.direction > 0 { to } else { from };
    if (end - station).abs() < AT_CUT && drawn.next[at].iter().any(|other| before(&other)) {
        all.at_end.insert(at);
    }
    let ahead = |station: f64| if lane.direction > 0 { station } else { -station };
    let known = all.stops.entry(at).or_insert(station);
    if ahead(station) > ahead(*known) {
        *known = station;
    }
}

/// The approaches of junctions to which lanes lead, with the lanes behind for which a signal on those lanes counts.
pub fn approaches(scene: &Scene, drawn: &Drawn, lanes: &[usize]) -> Vec<Approach> {
    let inside = |lane: usize| scene.connecting[scene.road_of(&drawn.lanes[lane])];
    let mut found: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for &lane in lanes {
        if inside(lane) {
            let mut at = lane;
            let mut seen = BTreeSet::from([lane]);
            while let Some(&before) = drawn.back[at].first().filter(|before| inside(**before) && seen.insert(**before))
            {
                at = before;
            }
            for &before in drawn.back[at].iter().filter(|before| !inside(**before)) {
                found.entry(before).or_default().insert(at);
            }
            continue;
        }
        let (mut at, mut gone) = (lane, 0.0);
        loop {
            let next = &drawn.next[at];
            if next.iter().any(|&next| inside(next)) {
                found.entry(at).or_default().extend(next.iter().copied().filter(|&next| inside(next)));
                break;
            }
            let [only] = next[..] else { break };
            let [from, to] = scene.span(&drawn.lanes[only]);
            gone += to - from;
            if gone > SIGNAL_TO_JUNCTION {
                break;
            }
            at = only;
        }
    }
    found.into_iter().map(|(lane, behind)| Approach { lane, behind: behind.into_iter().collect() }).collect()
}
