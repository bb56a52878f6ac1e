//! Lanes that continue each other, stitched at their ends and painted; after an edit only what depends on it is made
//! anew.
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

/// Cosine of the turn, 172 degrees, from which on a lane leads back: there the borders inside the bend would cross more
/// than seven lanes' widths away.
const BACK: f64 = -0.99;

/// A lane as it is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StitchedLane {
    bounds: [Vec<Point>; 2],
    outline: Vec<Point>,
    strokes: Strokes,
}

impl StitchedLane {
    /// The left and the right bound, in the lane's direction of travel.
    pub fn bounds(&self) -> &[Vec<Point>; 2] {
        &self.bounds
    }

    /// The left bound, then the right one backwards.
    pub fn outline(&self) -> &[Point] {
        &self.outline
    }

    /// What is painted along the bounds.
    pub fn strokes(&self) -> &Strokes {
        &self.strokes
    }
}

/// How an end of a lane meets others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meeting {
    /// It meets none.
    Open,
    /// It goes on in this lane, or comes from it: their bounds are stitched.
    Joined(LaneId),
    /// Two lanes start here: what leads into them decides how they part.
    Fork,
    /// Two lanes end here: what leads out of them decides how they unite.
    Merge,
    /// More than two meet here: only the movements between them can tell which go on in which.
    Junction,
    /// The lane meets itself.
    Loop,
    /// The other leads back to where the lane comes from, or the lane to where the other does: a vehicle would have to
    /// turn around between them.
    Back,
    /// The bounds of either lane were given and stay as they are.
    Explicit,
    /// The lane is left out.
    Excluded,
}

/// A lane with what it became.
#[derive(Clone, Debug)]
struct Entry {
    lane: Lane,
    /// Its borders before they are stitched.
    borders: [Vec<Point>; 2],
    /// What its ends are pulled to, start and end, by side.
    pulls: [Option<[Pull; 2]>; 2],
    woven: StitchedLane,
}

/// Lanes, kept woven through all edits: the same, to the last bit, as if the lanes had been woven all at once.
#[derive(Clone, Debug, Default)]
pub struct LaneStitching {
    lanes: BTreeMap<LaneId, Entry>,
    ends: Ends,
    excluded: Option<LaneId>,
}

impl LaneStitching {
    /// Weaves lanes. Of several with one name the last one counts.
    pub fn new(lanes: impl IntoIterator<Item = (LaneId, Lane)>) -> Self {
        let mut weave = Self::default();
        for (id, lane) in lanes {
            weave.take(id);
            weave.put(id, lane);
        }
        let all: Vec<LaneId> = weave.lanes.keys().copied().collect();
        for id in all {
            let pulls = LaneEnd::BOTH.map(|end| weave.pull(id, end));
            weave.draw(id, pulls);
        }
        weave
    }

    /// What became of a lane.
    pub fn get(&self, id: LaneId) -> Option<&StitchedLane> {
        self.lanes.get(&id).map(|entry| &entry.woven)
    }

    /// All lanes in order of their names.
    pub fn iter(&self) -> impl Iterator<Item = (LaneId, &StitchedLane)> {
        self.lanes.iter().map(|(id, entry)| (*id, &entry.woven))
    }

    /// A lane as it was given.
    pub fn lane(&self, id: LaneId) -> Option<&Lane> {
        self.lanes.get(&id).map(|entry| &entry.lane)
    }

    /// How an end of a lane meets others; `None` if there is no such lane.
    pub fn meeting(&self, id: LaneId, end: LaneEnd) -> Option<Meeting> {
        let lane = self.lane(id)?;
        if self.excluded == Some(id) {
            return Some(Meeting::Excluded);
        }
        let mut others = self.ends.at(lane.node(end), self.excluded).filter(|at| *at != (id, end));
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

    /// Puts a lane where none of its name is, not yet drawn.
    fn put(&mut self, id: LaneId, lane: Lane) {
        self.ends.add(id, &lane);
        let borders = borders(&lane.shape);
        self.lanes.insert(id, Entry { lane, borders, pulls: [None, None], woven: StitchedLane::default() });
    }

    fn take(&mut self, id: LaneId) {
        if let Some(entry) = self.lanes.remove(&id) {
            self.ends.remove(id, &entry.lane);
        }
    }

    /// What an end of a lane is pulled to, by side; `None` where it is not stitched.
    fn pull(&self, id: LaneId, end: LaneEnd) -> Option<[Pull; 2]> {
        let Some(Meeting::Joined(other)) = self.meeting(id, end) else { return None };
        let (own, other) = (self.lanes.get(&id)?, self.lanes.get(&other)?);
        let [ending, starting] = if end == LaneEnd::End { [own, other] } else { [other, own] };
        Some(stitched(ending, starting).map(|pulls| pulls[1 - end.index()]))
    }

    /// Draws a lane between its joints.
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
        entry.woven = StitchedLane { bounds, outline, strokes };
    }
}

/// Whether one of two lanes that meet at this end of the first leads back along the other.
fn turns_back(lane: &Lane, end: LaneEnd, other: &Lane) -> bool {
    let there = if end == LaneEnd::Start { LaneEnd::End } else { LaneEnd::Start };
    lane.heading(end).dot(&other.heading(there)) <= BACK
}

/// Stitches the borders of a lane to those of the one that it goes on in: by side, for the first and for the second.
fn stitched(ending: &Entry, starting: &Entry) -> [[Pull; 2]; 2] {
    let middles = [ending.lane.place(LaneEnd::End), starting.lane.place(LaneEnd::Start)];
    let joint = nalgebra::center(&middles[0], &middles[1]);
    [0, 1].map(|side| {
        let strands = [Strand::ending(&ending.borders[side]), Strand::starting(&starting.borders[side])];
        let halves = [0, 1].map(|i| (strands[i].tip() - middles[i]).norm());
        meet(strands, joint, halves[0].max(halves[1]))
    })
}

/// A border between the places that its ends are pulled to.
fn between(border: &[Point], start: Option<Pull>, end: Option<Pull>) -> Vec<Point> {
    let lost = |pull: Option<Pull>| pull.map_or(0, |pull| pull.lost);
    let place = |pull: Option<Pull>| pull.map(|pull| pull.place);
    let kept = border.get(lost(start)..border.len().saturating_sub(lost(end))).unwrap_or_default();
    place(start).into_iter().chain(kept.iter().copied()).chain(place(end)).collect()
}
