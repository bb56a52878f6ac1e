//! Strips side by side that become one lanelet beside the lanes for cars: bicycle lanes, shoulders, strips for people on foot.

use super::cross_section::{CrossSection, StripKind, Travel};
use std::ops::Range;

/// Widths of a lane for bicycles, metres: what is narrower is no lane, what is wider no lane for bicycles alone.
pub(crate) const BICYCLE: std::ops::RangeInclusive<f64> = 0.8..=3.0;
/// The same where bicycles ride both ways, metres: at most two lanes.
pub(crate) const BICYCLE_BOTH_WAYS: std::ops::RangeInclusive<f64> = 0.8..=6.0;
/// A vehicle halts on what is at least so wide, metres, in part; narrower strips are the edge of the road.
pub(crate) const SHOULDER_LEAST: f64 = 1.0;
/// One person walks on what is at least so wide, metres.
pub(crate) const PEDESTRIAN_LEAST: f64 = 0.6;

/// What a run of strips is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StripUse {
    /// Bicycles.
    Bicycle,
    /// Vehicles that halt.
    Shoulder,
    /// People on foot.
    Pedestrian,
}

/// Strips side by side that are one lanelet.
#[derive(Clone, Debug, PartialEq)]
pub struct StripRun {
    /// What it is for.
    pub used: StripUse,
    /// The strips, by index.
    pub strips: Range<usize>,
    /// Which way its lanelet runs; two that lie on each other where it is both ways.
    pub travel: Travel,
}

impl StripRun {
    /// For each of its lanelets whether it runs against the road's line.
    pub fn directions(&self) -> &'static [bool] {
        match (self.travel, self.used) {
            (Travel::Backward, _) => &[true],
            (Travel::Both, StripUse::Bicycle) => &[false, true],
            _ => &[false],
        }
    }
}

/// What lies beside the driven strips of a section, from left to right.
pub fn strip_runs(section: &CrossSection) -> Vec<StripRun> {
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
pub(crate) fn whole(section: &CrossSection) -> Vec<StripRun> {
    let strips = &section.strips;
    let mut runs: Vec<StripRun> = Vec::new();
    let mut at = 0;
    while at < strips.len() {
        let begin = at;
        at += 1;
        let Some(used) = used(strips[begin].kind) else { continue };
        while strips.get(at).is_some_and(|strip| self::used(strip.kind) == Some(used)) {
            at += 1;
        }
        let strips = if used == StripUse::Bicycle { with_buffers(section, begin..at) } else { begin..at };
        let width: f64 = section.strips[strips.clone()].iter().map(|strip| strip.width).sum();
        let fits = match used {
            StripUse::Bicycle => bicycle_widths(section, begin..at).contains(&width),
            StripUse::Shoulder => width >= SHOULDER_LEAST,
            StripUse::Pedestrian => width >= PEDESTRIAN_LEAST,
        };
        if fits {
            runs.push(StripRun { used, travel: travel(section, used, begin..at), strips });
        }
    }
    runs
}

pub(crate) fn used(kind: StripKind) -> Option<StripUse> {
    match kind {
        StripKind::Bicycle => Some(StripUse::Bicycle),
        StripKind::Shoulder | StripKind::Parking => Some(StripUse::Shoulder),
        StripKind::Pedestrian => Some(StripUse::Pedestrian),
        StripKind::Drive | StripKind::Bus | StripKind::Sidewalk | StripKind::Buffer => None,
    }
}

/// The painted buffers beside a bicycle lane belong to it, as far as it does not grow too wide: so it touches the lane
/// beside it.
pub(crate) fn with_buffers(section: &CrossSection, bicycles: Range<usize>) -> Range<usize> {
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
pub(crate) fn bicycle_widths(section: &CrossSection, strips: Range<usize>) -> std::ops::RangeInclusive<f64> {
    if section.strips[strips.start].travel == Travel::Both { BICYCLE_BOTH_WAYS } else { BICYCLE }
}

/// Bicycles have a direction of their own; all else runs as the traffic beside it does.
pub(crate) fn travel(section: &CrossSection, used: StripUse, strips: Range<usize>) -> Travel {
    let own = section.strips[strips.start].travel;
    if used == StripUse::Bicycle {
        return own;
    }
    let nearest = section.driven().min_by_key(|(i, _)| i.abs_diff(strips.start));
    let beside = nearest.map(|(_, strip)| strip.travel).filter(|travel| *travel != Travel::Both);
    beside.unwrap_or(own)
}

/// Whether a run is of any use: nobody finds a shoulder, or a strip for people on foot, that touches no lane.
pub(crate) fn reached(section: &CrossSection, runs: &[StripRun], run: &StripRun) -> bool {
    let Range { start, end } = run.strips;
    let drive =
        |i: Option<usize>| i.and_then(|i| section.strips.get(i)).is_some_and(|strip| strip.kind == StripKind::Drive);
    let road = [drive(start.checked_sub(1)), drive(Some(end))];
    let other =
        [runs.iter().any(|other| other.strips.end == start), runs.iter().any(|other| other.strips.start == end)];
    match run.used {
        StripUse::Bicycle => true,
        StripUse::Shoulder => road.contains(&true) || other.contains(&true),
        StripUse::Pedestrian => road.contains(&true),
    }
}
