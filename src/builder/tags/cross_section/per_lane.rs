//! The tags of each lane of one direction: `turn:lanes`, `change:lanes`, `width:lanes`, access tags.

use crate::builder::tags::admission::{Admitted, of_value};
use crate::builder::tags::speed_limits::parse;
use crate::builder::tags::values::{is_yes, metres};
use crate::diagnostic::{Finding, Severity};

use super::flow::Flow;
use super::road_lists::{BUS, MOTOR, is_without_direction, listed, of_direction};
use super::{Arrows, Defaults, LANE_WIDTHS, Strip, StripKind, Travel, WayFacts};

const BICYCLE: &str = "bicycle:lanes";
const OTHERS: [&str; 5] = ["turn:lanes", "change:lanes", "width:lanes", "hov:lanes", "maxspeed:lanes"];

/// The `:lanes` tags of one direction, each a list from left to right in the direction of travel.
#[derive(Debug, Default)]
pub(super) struct PerLane {
    lists: Vec<(&'static str, Vec<String>)>,
    change: Option<String>,
}

/// Reads the lists of one direction. Lists without a direction belong to the only direction of a one-way road. `count` is the
/// value of `lanes:forward` or its like.
pub(super) fn per_lane(
    facts: &WayFacts<'_>,
    travel: Travel,
    flow: Flow,
    count: Option<usize>,
    notes: &mut Vec<Finding>,
) -> PerLane {
    let (suffix, only) = match travel {
        Travel::Forward => (":forward", flow == Flow::Forward),
        Travel::Backward => (":backward", flow == Flow::Backward),
        Travel::Both => (":both_ways", flow == Flow::Alternating),
    };
    let directed = |key: &str| facts.tags.get_joined([key, suffix]);
    let own = |key: &str| facts.tags.get(key).filter(|_| only);
    // Most ways have no such tags.
    let any = facts.tags.iter().any(|(key, _)| key.contains(":lanes"));
    let keys = MOTOR.into_iter().chain(BUS).chain([BICYCLE]).chain(OTHERS).filter(|_| any);
    let read = |key: &'static str| {
        let list = directed(key).map(listed).or_else(|| of_direction(facts, travel, flow, key));
        Some((key, list.or_else(|| own(key).map(listed))?))
    };
    let lists: Vec<_> = keys.clone().filter_map(read).collect();
    if flow == Flow::TwoWay && travel == Travel::Forward {
        notes.extend(keys.filter(|key| is_without_direction(facts, flow, key)).map(|key| {
            let what = format!(
                "{key} does not tell which lanes of this two-way road it is about, and is passed over; {key}:forward and \
                 {key}:backward would"
            );
            facts.note("lanes-contradict", Severity::Warning, &what)
        }));
    }
    let change = directed("change").or_else(|| facts.tags.get("change")).map(str::to_owned);
    let mut list = PerLane { lists, change };
    if list.turn_around_arrows() {
        let what = format!(
            "turn:lanes{suffix} would send neighbouring lanes across each other: it is read from right to left"
        );
        notes.push(facts.note("lanes-contradict", Severity::Warning, &what));
    }
    if let Some((first, second)) = list.disagreement(count) {
        let what = format!("{first} and {second} speak of different numbers of lanes{suffix}");
        notes.push(facts.note("lanes-contradict", Severity::Warning, &what));
    }
    list
}

impl PerLane {
    fn list(&self, key: &str, count: usize) -> Option<&[String]> {
        let (_, list) = self.lists.iter().find(|(k, list)| *k == key && list.len() == count)?;
        Some(list)
    }

    fn entry(&self, key: &str, count: usize, lane: usize) -> Option<&str> {
        let entry = self.list(key, count)?.get(lane)?.as_str();
        (!entry.is_empty()).then_some(entry)
    }

    /// Two tags of different length, unless the count decides between them.
    fn disagreement(&self, count: Option<usize>) -> Option<(&'static str, &'static str)> {
        if self.matching(count).is_some() {
            return None;
        }
        let (first, list) = self.lists.first()?;
        let other = self.lists.iter().find(|(_, other)| other.len() != list.len());
        match (other, count) {
            (Some((second, _)), _) => Some((first, second)),
            (None, Some(count)) if count != list.len() => Some((first, "the number of lanes")),
            _ => None,
        }
    }

    /// The length of the longest list of which `count` entries are lanes for motor vehicles or cars.
    pub fn matching(&self, count: Option<usize>) -> Option<usize> {
        let count = count?;
        let fits = |len: &usize| {
            let without = |lanes: usize| len.saturating_sub(lanes) == count;
            without(0) || without(self.bicycle_lanes(*len)) || without(self.special_lanes(*len))
        };
        self.lists.iter().map(|(_, list)| list.len()).filter(fits).max()
    }

    /// The length of the longest list.
    pub fn longest(&self) -> Option<usize> {
        self.lists.iter().map(|(_, list)| list.len()).max()
    }

    /// The number of bicycle lanes among `count` lanes.
    pub fn bicycle_lanes(&self, count: usize) -> usize {
        (0..count).filter(|lane| self.kind(count, *lane) == Some(StripKind::Bicycle)).count()
    }

    /// The number of lanes that are not for cars among `count` lanes.
    pub fn special_lanes(&self, count: usize) -> usize {
        (0..count).filter(|lane| self.kind(count, *lane).is_some()).count()
    }

    /// The kind of a lane, if it is not for cars.
    fn kind(&self, count: usize, lane: usize) -> Option<StripKind> {
        let cars = MOTOR.iter().find_map(|key| self.entry(key, count, lane));
        let admitted = cars.and_then(of_value);
        let is_closed = admitted == Some(Admitted::Nobody) || cars == Some("private");
        let bus = BUS.iter().find_map(|key| self.entry(key, count, lane));
        let bicycle = self.entry(BICYCLE, count, lane);
        match cars {
            Some(_) if admitted == Some(Admitted::Buses) => Some(StripKind::Bus),
            Some(_) if is_closed && bus.is_some_and(is_yes) => Some(StripKind::Bus),
            Some(told) if is_closed && (bicycle.is_some_and(is_yes) || told == "bicycle") => Some(StripKind::Bicycle),
            Some(_) if admitted == Some(Admitted::Nobody) => Some(StripKind::Buffer),
            Some(_) => None,
            None if matches!(bus, Some("designated" | "official")) => Some(StripKind::Bus),
            None if bicycle == Some("designated") => Some(StripKind::Bicycle),
            None => None,
        }
    }

    /// Turns the list of arrows around if by it neighbouring lanes for cars would cross each other, and the other way around they
    /// would not: it was written from right to left. Vehicles do turn off across lanes that are not for cars.
    fn turn_around_arrows(&mut self) -> bool {
        let is_crossed = |list: &[String]| {
            let spans: Vec<[usize; 2]> = list.iter().filter_map(|entry| span(arrows(entry))).collect();
            spans.iter().zip(spans.iter().skip(1)).any(|([left, _], [_, right])| left > right)
        };
        let arrows_at = self.lists.iter().position(|(key, list)| *key == "turn:lanes" && is_crossed(list));
        let (Some(at), true) = (arrows_at, self.lists.iter().all(|(_, list)| self.special_lanes(list.len()) == 0))
        else {
            return false;
        };
        let Some((_, list)) = self.lists.get_mut(at) else { return false };
        list.reverse();
        let is_better = !is_crossed(list);
        if !is_better {
            list.reverse();
        }
        is_better
    }

    /// Whether some lane among `count` is open to buses by name.
    pub fn admits_buses(&self, count: usize) -> bool {
        let of_lane = |lane| BUS.iter().find_map(|key| self.entry(key, count, lane));
        (0..count).any(|lane| of_lane(lane).is_some_and(is_yes))
    }

    /// The list whose entries are not as many as these lanes, though no list has as many, and how many it has.
    pub fn misfit(&self, count: usize) -> Option<(&'static str, usize)> {
        let (key, list) = self.lists.first().filter(|_| self.matching(Some(count)).is_none())?;
        Some((key, list.len()))
    }

    /// Whether the lists name bus lanes.
    pub fn names_buses(&self, count: usize) -> bool {
        BUS.iter().any(|key| self.list(key, count).is_some())
    }

    /// Whether the first and the last lane are bus lanes by lists that fit no number of lanes.
    pub fn bus_lanes_at_edges(&self, count: usize) -> [bool; 2] {
        let length = self.longest().filter(|length| *length != count && self.list(BUS[0], count).is_none());
        let Some(last) = length.and_then(|length| length.checked_sub(1)) else { return [false; 2] };
        [0, last].map(|lane| self.kind(last + 1, lane) == Some(StripKind::Bus))
    }

    /// Applies the lists of the same length to lanes, left to right in the direction of travel.
    pub fn apply(&self, strips: &mut [Strip], usual: &Defaults) {
        let count = strips.len();
        for (lane, strip) in strips.iter_mut().enumerate() {
            if let Some(kind) = self.kind(count, lane) {
                strip.kind = kind;
                if kind == StripKind::Bicycle {
                    strip.width = usual.bicycle_lane;
                }
            }
            if let Some(width) = self.entry("width:lanes", count, lane).and_then(metres)
                && (LANE_WIDTHS.contains(&width) || strip.kind == StripKind::Bicycle)
            {
                strip.width = width;
                strip.width_guessed = false;
            }
            strip.speed = self.entry("maxspeed:lanes", count, lane).and_then(|entry| parse(entry, None));
            strip.bicycles = self.entry(BICYCLE, count, lane).is_some_and(is_yes);
            strip.arrows = self.entry("turn:lanes", count, lane).map_or(Arrows::NONE, arrows);
            let entry = self.entry("change:lanes", count, lane).or(self.change.as_deref());
            strip.change = entry.map_or([None, None], change);
        }
    }
}

/// The arrows of one entry of `turn:lanes`.
fn arrows(entry: &str) -> Arrows {
    entry.split(';').filter_map(|arrow| Arrows::named(arrow.trim())).fold(Arrows::NONE, Arrows::and)
}

/// The leftmost and the rightmost direction of arrows, by their rank from left to right. A turn back is on either side, and merging
/// tells of no road.
fn span(of: Arrows) -> Option<[usize; 2]> {
    let from_left = [
        Arrows::SHARP_LEFT,
        Arrows::LEFT,
        Arrows::SLIGHT_LEFT,
        Arrows::THROUGH,
        Arrows::SLIGHT_RIGHT,
        Arrows::RIGHT,
        Arrows::SHARP_RIGHT,
    ];
    let has = |arrow: &Arrows| of.has(*arrow);
    Some([from_left.iter().position(has)?, from_left.iter().rposition(has)?])
}

/// Whether a vehicle may change to the left and to the right: one entry of `change:lanes`.
fn change(entry: &str) -> [Option<bool>; 2] {
    match entry {
        "yes" => [Some(true); 2],
        "no" => [Some(false); 2],
        "not_left" | "only_right" => [Some(false), Some(true)],
        "not_right" | "only_left" => [Some(true), Some(false)],
        _ => [None; 2],
    }
}
