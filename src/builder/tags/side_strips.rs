//! Runs of strips beside the lanes for cars that become one lanelet: bicycle lanes, shoulders, pedestrian lanes.

use super::cross_section::{CrossSection, Strip, StripKind, Travel};
use std::ops::Range;

/// The widths of a bicycle lane, metres.
const BICYCLE: std::ops::RangeInclusive<f64> = 0.8..=3.0;
/// The widths of a bicycle lane for both directions, metres.
const BICYCLE_BOTH_WAYS: std::ops::RangeInclusive<f64> = 0.8..=6.0;
/// The smallest width of a shoulder, metres: a vehicle stops on it in part. Narrower strips are the edge of the road.
const MIN_SHOULDER: f64 = 1.0;
/// The smallest width of a pedestrian lane, metres: one person.
const MIN_PEDESTRIAN: f64 = 0.6;

/// The use of a run of strips.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StripUse {
    /// Bicycles.
    Bicycle,
    /// Vehicles that stop.
    Shoulder,
    /// People on foot.
    Pedestrian,
}

/// Neighbouring strips that become one lanelet.
#[derive(Clone, Debug, PartialEq)]
pub struct StripRun {
    /// Its use.
    pub used: StripUse,
    /// The indices of the strips.
    pub strips: Range<usize>,
    /// The direction of its lanelet; `Both`: two lanelets on the same strips.
    pub travel: Travel,
}

impl StripRun {
    /// For each of its lanelets, whether it runs against the road's line.
    pub fn directions(&self) -> &'static [bool] {
        match (self.travel, self.used) {
            (Travel::Backward, _) => &[true],
            (Travel::Both, StripUse::Bicycle) => &[false, true],
            _ => &[false],
        }
    }
}

/// The runs of strips of a section, from left to right.
pub fn strip_runs(section: &CrossSection) -> Vec<StripRun> {
    let mut runs = all_runs(section);
    loop {
        let kept: Vec<StripRun> = runs.iter().filter(|run| is_reachable(section, &runs, run)).cloned().collect();
        if kept.len() == runs.len() {
            return runs;
        }
        runs = kept;
    }
}

/// All runs of valid width.
fn all_runs(section: &CrossSection) -> Vec<StripRun> {
    let mut runs: Vec<StripRun> = Vec::new();
    let mut start = 0;
    for strips in section.strips.chunk_by(|a, b| strip_use(a.kind) == strip_use(b.kind) && !are_parted(a, b)) {
        let run = start..start + strips.len();
        start = run.end;
        let Some((used, own)) = strips.first().and_then(|first| Some((strip_use(first.kind)?, first.travel))) else {
            continue;
        };
        let bicycle_widths = if own == Travel::Both { BICYCLE_BOTH_WAYS } else { BICYCLE };
        let range = match used {
            StripUse::Bicycle => with_buffers(section, run.clone(), *bicycle_widths.end()),
            _ => run.clone(),
        };
        let width = width(section, &range);
        let fits = match used {
            StripUse::Bicycle => bicycle_widths.contains(&width),
            StripUse::Shoulder => width >= MIN_SHOULDER,
            StripUse::Pedestrian => width >= MIN_PEDESTRIAN,
        };
        if fits {
            runs.push(StripRun { used, travel: travel(section, used, own, &run), strips: range });
        }
    }
    runs
}

/// The width of strips, metres.
fn width(section: &CrossSection, strips: &Range<usize>) -> f64 {
    section.strips.iter().take(strips.end).skip(strips.start).map(|strip| strip.width).sum()
}

/// Whether two neighbouring strips are shoulders of either direction in the middle of a road: each ends there, at a barrier or a median
/// without width.
pub(crate) fn are_parted(a: &Strip, b: &Strip) -> bool {
    let is_shoulder = |strip: &Strip| strip_use(strip.kind) == Some(StripUse::Shoulder);
    is_shoulder(a) && is_shoulder(b) && a.travel.reversed() == b.travel && a.travel != b.travel
}

fn strip_use(kind: StripKind) -> Option<StripUse> {
    match kind {
        StripKind::Bicycle => Some(StripUse::Bicycle),
        StripKind::Shoulder | StripKind::Parking => Some(StripUse::Shoulder),
        StripKind::Pedestrian => Some(StripUse::Pedestrian),
        StripKind::Drive | StripKind::Bus | StripKind::Sidewalk | StripKind::Buffer => None,
    }
}

/// A bicycle lane with the painted buffers beside it, unless it becomes wider than `most`, metres: so it touches the lane beside it.
fn with_buffers(section: &CrossSection, mut range: Range<usize>, most: f64) -> Range<usize> {
    let is_buffer = |i: usize| section.strips.get(i).is_some_and(|strip| strip.kind == StripKind::Buffer);
    if range.start > 0 && is_buffer(range.start - 1) && most >= width(section, &(range.start - 1..range.end)) {
        range.start -= 1;
    }
    if is_buffer(range.end) && most >= width(section, &(range.start..range.end + 1)) {
        range.end += 1;
    }
    range
}

/// The direction of a run: bicycle lanes have their own; all others have that of the nearest lane, a bicycle lane included.
fn travel(section: &CrossSection, used: StripUse, own: Travel, strips: &Range<usize>) -> Travel {
    if used == StripUse::Bicycle {
        return own;
    }
    let bicycle = |strip: &Strip| strip.kind == StripKind::Bicycle && strip.travel != Travel::Both;
    let strips_of_bicycles = section.strips.iter().enumerate().filter(|(_, strip)| bicycle(strip));
    let nearest = section.driven().chain(strips_of_bicycles).min_by_key(|(i, _)| i.abs_diff(strips.start));
    let beside = nearest.map(|(_, strip)| strip.travel).filter(|travel| *travel != Travel::Both);
    beside.unwrap_or(own)
}

/// Whether a run can be reached: a shoulder or pedestrian lane has to touch a lane, a shoulder at least another run.
fn is_reachable(section: &CrossSection, runs: &[StripRun], run: &StripRun) -> bool {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shoulders_in_the_middle_of_a_road_are_two() {
        let runs = |width: f64, kinds: [StripKind; 2]| {
            let strip = |kind, travel| Strip::plain(kind, travel, width, false);
            let [first, second] = kinds;
            let strips = vec![
                Strip::plain(StripKind::Drive, Travel::Backward, 3.0, false),
                strip(first, Travel::Backward),
                strip(second, Travel::Forward),
                Strip::plain(StripKind::Drive, Travel::Forward, 3.0, false),
            ];
            strip_runs(&CrossSection { strips }).into_iter().map(|run| (run.strips, run.travel)).collect::<Vec<_>>()
        };
        let two = [(1..2, Travel::Backward), (2..3, Travel::Forward)];
        assert_eq!(runs(1.2, [StripKind::Shoulder, StripKind::Shoulder]), two);
        assert_eq!(runs(2.2, [StripKind::Shoulder, StripKind::Parking]), two);
        assert_eq!(runs(0.63, [StripKind::Shoulder, StripKind::Shoulder]), [], "neither is wide enough to stop on");
    }
}
