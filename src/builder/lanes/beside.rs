//! What lies beside the lanes for cars as lanelets: bicycle lanes, shoulders, parked cars, strips for people on foot.
//!
//! Strips of one use side by side are one lanelet, or two on each other where bicycles ride both ways: so either shares its
//! border with the lane beside it. It shares its borders with what lies on either side, as far as that is
//! a lanelet, too: Autoware finds it from the lane over the common way only.

#[cfg(test)]
mod tests;

use std::ops::Range;

use crate::builder::ids::Key;
use crate::builder::map::assembly::Assembly;
use crate::builder::network::{Road, RoadIx, RoadNetwork};
use crate::builder::tags::cross_section::{CrossSection, StripKind, Travel};
use crate::lanelet::{Attributes, Bound, LaneletId};
use crate::settings::{BesideSettings, BicycleLanes};

use super::road_lanes::Lanes;
use super::sound::sound;

/// Widths of a lane for bicycles, metres: what is narrower is no lane, what is wider no lane for bicycles alone.
const BICYCLE: std::ops::RangeInclusive<f64> = 0.8..=3.0;
/// The same where bicycles ride both ways, metres: at most two lanes.
const BICYCLE_BOTH_WAYS: std::ops::RangeInclusive<f64> = 0.8..=6.0;
/// A vehicle halts on what is at least so wide, metres, in part; narrower strips are the edge of the road.
const SHOULDER_LEAST: f64 = 1.0;
/// One person walks on what is at least so wide, metres.
const PEDESTRIAN_LEAST: f64 = 0.6;
/// How fast one cycles, km/h.
const CYCLING: &str = "20";
/// How fast one drives onto what is meant for halting, or walks, km/h.
const CRAWLING: &str = "10";

/// What a run of strips is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Bicycles.
    Bicycle,
    /// Vehicles that halt.
    Shoulder,
    /// People on foot.
    Pedestrian,
}

/// Strips side by side that are one lanelet.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// What it is for.
    pub used: Use,
    /// The strips, by index.
    pub strips: Range<usize>,
    /// Which way its lanelet runs; two that lie on each other where it is both ways.
    pub travel: Travel,
}

impl Run {
    /// For each of its lanelets whether it runs against the road's line.
    pub fn directions(&self) -> &'static [bool] {
        match (self.travel, self.used) {
            (Travel::Backward, _) => &[true],
            (Travel::Both, Use::Bicycle) => &[false, true],
            _ => &[false],
        }
    }
}

/// What lies beside the driven strips of a section, from left to right.
pub fn runs(section: &CrossSection) -> Vec<Run> {
    let mut runs = whole(section);
    loop {
        let open: Vec<bool> = runs.iter().map(|run| reached(section, &runs, run)).collect();
        if !open.contains(&false) {
            return runs;
        }
        let mut open = open.into_iter();
        runs.retain(|_| open.next().unwrap_or(false));
    }
}

/// All runs that are neither too narrow nor too wide, whatever lies beside them.
fn whole(section: &CrossSection) -> Vec<Run> {
    let strips = &section.strips;
    let mut runs: Vec<Run> = Vec::new();
    let mut at = 0;
    while at < strips.len() {
        let begin = at;
        at += 1;
        let Some(used) = used(strips[begin].kind) else { continue };
        while strips.get(at).is_some_and(|strip| self::used(strip.kind) == Some(used)) {
            at += 1;
        }
        let strips = if used == Use::Bicycle { with_buffers(section, begin..at) } else { begin..at };
        let width: f64 = section.strips[strips.clone()].iter().map(|strip| strip.width).sum();
        let fits = match used {
            Use::Bicycle => bicycle_widths(section, begin..at).contains(&width),
            Use::Shoulder => width >= SHOULDER_LEAST,
            Use::Pedestrian => width >= PEDESTRIAN_LEAST,
        };
        if fits {
            runs.push(Run { used, travel: travel(section, used, begin..at), strips });
        }
    }
    runs
}

fn used(kind: StripKind) -> Option<Use> {
    match kind {
        StripKind::Bicycle => Some(Use::Bicycle),
        StripKind::Shoulder | StripKind::Parking => Some(Use::Shoulder),
        StripKind::Pedestrian => Some(Use::Pedestrian),
        StripKind::Drive | StripKind::Bus | StripKind::Sidewalk | StripKind::Buffer => None,
    }
}

/// The painted buffers beside a bicycle lane belong to it, as far as it does not grow too wide: so it touches the lane
/// beside it.
fn with_buffers(section: &CrossSection, bicycles: Range<usize>) -> Range<usize> {
    let buffer = |i: usize| section.strips.get(i).is_some_and(|strip| strip.kind == StripKind::Buffer);
    let wide = |range: &Range<usize>| section.strips[range.clone()].iter().map(|s| s.width).sum::<f64>();
    let most = *bicycle_widths(section, bicycles.clone()).end();
    let mut range = bicycles;
    if range.start > 0 && buffer(range.start - 1) && most >= wide(&(range.start - 1..range.end)) {
        range.start -= 1;
    }
    if buffer(range.end) && most >= wide(&(range.start..range.end + 1)) {
        range.end += 1;
    }
    range
}

/// How wide strips for bicycles can be, metres.
fn bicycle_widths(section: &CrossSection, strips: Range<usize>) -> std::ops::RangeInclusive<f64> {
    if section.strips[strips.start].travel == Travel::Both { BICYCLE_BOTH_WAYS } else { BICYCLE }
}

/// Bicycles have a direction of their own; all else runs as the traffic beside it does.
fn travel(section: &CrossSection, used: Use, strips: Range<usize>) -> Travel {
    let own = section.strips[strips.start].travel;
    if used == Use::Bicycle {
        return own;
    }
    let nearest = section.driven().min_by_key(|(i, _)| i.abs_diff(strips.start));
    let beside = nearest.map(|(_, strip)| strip.travel).filter(|travel| *travel != Travel::Both);
    beside.unwrap_or(own)
}

/// Whether a run is of any use: nobody finds a shoulder, or a strip for people on foot, that touches no lane.
fn reached(section: &CrossSection, runs: &[Run], run: &Run) -> bool {
    let Range { start, end } = run.strips;
    let drive =
        |i: Option<usize>| i.and_then(|i| section.strips.get(i)).is_some_and(|strip| strip.kind == StripKind::Drive);
    let road = [drive(start.checked_sub(1)), drive(Some(end))];
    let other =
        [runs.iter().any(|other| other.strips.end == start), runs.iter().any(|other| other.strips.start == end)];
    match run.used {
        Use::Bicycle => true,
        Use::Shoulder => road.contains(&true) || other.contains(&true),
        Use::Pedestrian => road.contains(&true),
    }
}

/// Adds the lanelets beside the lanes of all roads; gives those for bicycles.
pub fn beside(assembly: &mut Assembly, network: &RoadNetwork, lanes: &Lanes) -> Vec<LaneletId> {
    let mut bicycles = Vec::new();
    for (ix, road) in network.roads.iter().enumerate() {
        let ix = RoadIx(ix as u32);
        let key = road.key_of("beside");
        let pieces = lanes.pieces_of(ix).iter();
        let pieces = pieces.map(|piece| (piece.behind.map_or(key, |cause| cause.of(key)), &piece.borders[..]));
        let pieces: Vec<(Key, &[Option<Bound>])> = pieces.collect();
        for run in runs(&road.section) {
            for &(key, borders) in &pieces {
                for &backward in run.directions() {
                    let lanelet = lanelet(assembly, road, (key, borders), (&run, backward), &network.beside);
                    bicycles.extend(lanelet.filter(|_| run.used == Use::Bicycle));
                }
            }
        }
    }
    bicycles
}

/// Adds the lanelet of a run, unless the settings leave it out or there is no room for it.
fn lanelet(
    assembly: &mut Assembly,
    road: &Road,
    (key, borders): (Key, &[Option<Bound>]),
    (run, backward): (&Run, bool),
    settings: &BesideSettings,
) -> Option<LaneletId> {
    let parked = road.section.strips[run.strips.clone()].iter().any(|strip| strip.kind == StripKind::Parking);
    let wanted = match run.used {
        Use::Bicycle => settings.bicycle_lanes != BicycleLanes::None,
        Use::Shoulder => {
            if parked {
                settings.parking
            } else {
                settings.shoulders
            }
        }
        Use::Pedestrian => settings.pedestrian_lanes,
    };
    if !wanted {
        return None;
    }
    let [left, right] = bounds(assembly, road, borders, (run, backward))?;
    let key = key.number(run.strips.start as i64);
    let key = if backward && run.travel == Travel::Both { key.word("back") } else { key };
    let mut attributes = attributes(road, run, settings);
    attributes.push("road_id", crate::osm::Text::from(road.key.to_string()));
    Some(assembly.lanelet(key, left, right, attributes))
}

/// The bounds of the lanelet of a run that runs along the road's line or against it, in its direction; `None` if there is no
/// room for it.
pub fn bounds(
    assembly: &Assembly,
    road: &Road,
    borders: &[Option<Bound>],
    (run, backward): (&Run, bool),
) -> Option<[Bound; 2]> {
    let border = |edge: usize| borders.get(edge).copied().flatten();
    let (left, right) = (border(run.strips.start)?, border(run.strips.end)?);
    let turned = |bound: Bound| Bound { inverted: !bound.inverted, ..bound };
    let bounds = if backward { [turned(right), turned(left)] } else { [left, right] };
    let width: f64 = road.section.strips[run.strips.clone()].iter().map(|strip| strip.width).sum();
    sound(&bounds.map(|bound| assembly.bound_line(bound)), width).then_some(bounds)
}

/// Tags of a lanelet beside the lanes. Its subtype says who may use it: Lanelet2 admits bicycles to a `bicycle_lane`, and
/// nobody to the others, over which no route leads.
pub fn attributes(road: &Road, run: &Run, settings: &BesideSettings) -> Attributes {
    let (subtype, speed) = match (run.used, settings.bicycle_lanes) {
        (Use::Bicycle, BicycleLanes::Road) => ("road", CYCLING),
        (Use::Bicycle, _) => ("bicycle_lane", CYCLING),
        (Use::Shoulder, _) => ("road_shoulder", CRAWLING),
        (Use::Pedestrian, _) => ("pedestrian_lane", CRAWLING),
    };
    let location = if road.public { "urban" } else { "private" };
    let mut tags =
        Attributes::of(&[("type", "lanelet"), ("subtype", subtype), ("location", location), ("one_way", "yes")]);
    tags.push("speed_limit", speed);
    tags
}
