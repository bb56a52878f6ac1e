//! Stitches lanes that continue each other at their ends, and paints them. After an edit only the lanes that depend on it are
//! drawn again.
#![doc = include_str!("../../docs/lane_stitching.md")]

mod border;
mod edit;
mod ends;
mod joint;
mod lane;
mod paint;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use crate::geometry::Point;

use border::borders;
use ends::Ends;
use joint::{Pull, Strand, meet};

pub use lane::{Lane, LaneEnd, LaneError, LaneId, WidthAt, Widths};
pub use paint::{Colour, DASH, DASH_PERIOD, DOUBLE_APART, KERB, Kind, Marking, PAINT, Paint, Stroke, Strokes};

/// The cosine of the turn, 172 degrees, from which on a lane leads back: the inner borders would cross more than seven lane
/// widths away.
const BACK: f64 = -0.99;

/// A stitched lane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StitchedLane {
    bounds: [Vec<Point>; 2],
    outline: Vec<Point>,
    strokes: Strokes,
}

impl StitchedLane {
    /// The left and the right bound, in the direction of travel.
    pub fn bounds(&self) -> &[Vec<Point>; 2] {
        &self.bounds
    }

    /// The left bound, then the reversed right bound.
    pub fn outline(&self) -> &[Point] {
        &self.outline
    }

    /// The paint along the bounds.
    pub fn strokes(&self) -> &Strokes {
        &self.strokes
    }
}

/// How an end of a lane meets other lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meeting {
    /// It meets no lane.
    Open,
    /// The lane continues in this lane, or this lane in it. Their bounds are stitched.
    Joined(LaneId),
    /// Two lanes start here. The lanes that lead into them decide how they diverge.
    Fork,
    /// Two lanes end here. The lanes that lead out of them decide how they merge.
    Merge,
    /// More than two ends meet here. Only the movements between them tell which lanes continue each other.
    Junction,
    /// The lane meets itself.
    Loop,
    /// The other lane leads back: a vehicle would have to turn around.
    Back,
    /// The bounds of one lane are given and stay as they are.
    Explicit,
    /// The lane is excluded.
    Excluded,
}

/// A lane and its stitched form.
#[derive(Clone, Debug)]
struct Entry {
    lane: Lane,
    /// The borders before stitching.
    borders: [Vec<Point>; 2],
    /// The pulls at the start and at the end, by side; `None` if that end is not stitched.
    pulls: [Option<[Pull; 2]>; 2],
    stitched: StitchedLane,
}

/// Lanes that stay stitched through all edits: bit for bit as if all lanes were stitched at once.
#[derive(Clone, Debug, Default)]
pub struct LaneStitching {
    lanes: BTreeMap<LaneId, Entry>,
    ends: Ends,
    excluded: Option<LaneId>,
}

impl LaneStitching {
    /// Stitches lanes. Of several lanes with the same id the last counts.
    pub fn new(lanes: impl IntoIterator<Item = (LaneId, Lane)>) -> Self {
        let mut stitching = Self::default();
        for (id, lane) in lanes {
            stitching.take(id);
            stitching.put(id, lane);
        }
        let all: Vec<LaneId> = stitching.lanes.keys().copied().collect();
        for id in all {
            let pulls = LaneEnd::BOTH.map(|end| stitching.pull(id, end));
            stitching.draw(id, pulls);
        }
        stitching
    }

    /// A stitched lane.
    pub fn get(&self, id: LaneId) -> Option<&StitchedLane> {
        self.lanes.get(&id).map(|entry| &entry.stitched)
    }

    /// All stitched lanes, sorted by id.
    pub fn iter(&self) -> impl Iterator<Item = (LaneId, &StitchedLane)> {
        self.lanes.iter().map(|(id, entry)| (*id, &entry.stitched))
    }

    /// A lane as given.
    pub fn lane(&self, id: LaneId) -> Option<&Lane> {
        self.lanes.get(&id).map(|entry| &entry.lane)
    }

    /// How an end of a lane meets other lanes; `None` if there is no such lane.
    pub fn meeting(&self, id: LaneId, end: LaneEnd) -> Option<Meeting> {
        let lane = self.lane(id)?;
        if self.excluded == Some(id) {
            return Some(Meeting::Excluded);
        }
        let mut others = self.ends.at(lane.node(end), self.excluded).filter(|other| *other != (id, end));
        let Some((other, other_end)) = others.next() else { return Some(Meeting::Open) };
        let explicit = |id| self.lane(id).is_some_and(Lane::is_explicit);
        let back = |id| self.lane(id).is_some_and(|other| turns_back(lane, end, other));
        Some(match (other_end == end, end) {
            _ if others.next().is_some() => Meeting::Junction,
            _ if other == id => Meeting::Loop,
            (true, LaneEnd::Start) => Meeting::Fork,
            (true, LaneEnd::End) => Meeting::Merge,
            _ if explicit(id) || explicit(other) => Meeting::Explicit,
            _ if back(other) => Meeting::Back,
            _ => Meeting::Joined(other),
        })
    }

    /// Adds a lane of a new id without drawing it.
    fn put(&mut self, id: LaneId, lane: Lane) {
        self.ends.add(id, &lane);
        let borders = borders(&lane.shape);
        self.lanes.insert(id, Entry { lane, borders, pulls: [None, None], stitched: StitchedLane::default() });
    }

    fn take(&mut self, id: LaneId) {
        if let Some(entry) = self.lanes.remove(&id) {
            self.ends.remove(id, &entry.lane);
        }
    }

    /// The pulls at an end of a lane, by side; `None` if it is not stitched.
    fn pull(&self, id: LaneId, end: LaneEnd) -> Option<[Pull; 2]> {
        let Some(Meeting::Joined(other)) = self.meeting(id, end) else { return None };
        let (own, other) = (self.lanes.get(&id)?, self.lanes.get(&other)?);
        let [ending, starting] = if end == LaneEnd::End { [own, other] } else { [other, own] };
        Some(stitch(ending, starting).map(|pulls| pulls[1 - end.index()]))
    }

    /// Draws a lane with these pulls.
    fn draw(&mut self, id: LaneId, pulls: [Option<[Pull; 2]>; 2]) {
        let Some(entry) = self.lanes.get_mut(&id) else { return };
        let bounds = [0, 1].map(|side| {
            let [start, end] = pulls.map(|pulls| pulls.map(|sides| sides[side]));
            between(&entry.borders[side], start, end)
        });
        let outline = bounds[0].iter().chain(bounds[1].iter().rev()).copied().collect();
        let mut strokes = Strokes::default();
        if !entry.lane.is_explicit() {
            for (side, bound) in bounds.iter().enumerate() {
                strokes.draw(side, bound, &entry.lane.markings[side]);
            }
        }
        entry.pulls = pulls;
        entry.stitched = StitchedLane { bounds, outline, strokes };
    }
}

/// Whether a lane leads back along another lane that it meets at this end.
fn turns_back(lane: &Lane, end: LaneEnd, other: &Lane) -> bool {
    let other_end = if end == LaneEnd::Start { LaneEnd::End } else { LaneEnd::Start };
    lane.heading(end).dot(&other.heading(other_end)) <= BACK
}

/// The pulls by which a lane is stitched to the lane in which it continues: by side, for the first and the second lane.
fn stitch(ending: &Entry, starting: &Entry) -> [[Pull; 2]; 2] {
    let middles = [ending.lane.place(LaneEnd::End), starting.lane.place(LaneEnd::Start)];
    let joint = nalgebra::center(&middles[0], &middles[1]);
    [0, 1].map(|side| {
        let strands = [Strand::ending(&ending.borders[side]), Strand::starting(&starting.borders[side])];
        let halves = [0, 1].map(|i| (strands[i].tip() - middles[i]).norm());
        meet(strands, joint, halves[0].max(halves[1]))
    })
}

/// A border with its ends pulled.
fn between(border: &[Point], start: Option<Pull>, end: Option<Pull>) -> Vec<Point> {
    let lost = |pull: Option<Pull>| pull.map_or(0, |pull| pull.lost);
    let place = |pull: Option<Pull>| pull.map(|pull| pull.place);
    let kept = border.get(lost(start)..border.len().saturating_sub(lost(end))).unwrap_or_default();
    place(start).into_iter().chain(kept.iter().copied()).chain(place(end)).collect()
}
