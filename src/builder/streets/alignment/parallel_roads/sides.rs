//! On which side of each other roads lie that overlap. It is decided once, as they are drawn.

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::builder::network::End;
use crate::builder::streets::alignment::side_order::{SideHint, SideHints};

use super::overlap_search::{Adjacency, AdjacentPlace};
use super::shifted_road::{ShiftedRoad, TOLERANCE};

/// Roads drawn closer together than this, metres, may lie on either side of each other: it is a mapper's accuracy.
const UNCLEAR: f64 = 1.0;
/// The side on which a road is drawn shows up to so many places before and behind, 40 m.
const AROUND: usize = 10;

/// The sides of all roads that are drawn beside others.
pub(super) struct Sides<'a> {
    hints: &'a SideHints,
    /// By ordered pair of roads, in order of the places of the first.
    drawn: FxHashMap<(usize, usize), Vec<Drawn>>,
}

/// On which side of a place of a road another is drawn.
struct Drawn {
    /// Index of the place.
    index: usize,
    /// Whether both roads run in the same direction. This tells the two legs of a loop apart.
    same_direction: bool,
    /// 1 left, -1 right.
    side: f64,
}

impl<'a> Sides<'a> {
    /// The sides of `roads` that have not moved yet. Roads on different levels have sides only near the intersection where
    /// they part.
    pub(super) fn new(roads: &FxHashMap<usize, ShiftedRoad>, hints: &'a SideHints, adjacency: &Adjacency) -> Self {
        let sides = |(&(a, b), adjacent): (&(usize, usize), &Vec<AdjacentPlace>)| {
            let (road, same_level) = (&roads[&a], roads[&a].level == roads[&b].level);
            let hints = hints.get(&(a, b)).map_or(&[][..], Vec::as_slice);
            let runs = adjacent.chunk_by(|x, y| x.index + 1 == y.index && x.same_direction == y.same_direction);
            let sides = runs.flat_map(|run| {
                let hints: Vec<(&SideHint, bool)> =
                    hints.iter().map(|hint| (hint, begins_at_cut(road, run, hint))).collect();
                let drawn = |(i, place): (usize, &AdjacentPlace)| {
                    let station = road.stations[place.index];
                    let part_there = || hints.iter().any(|(hint, at_cut)| *at_cut && hint.holds_at(station));
                    let around = &run[i.saturating_sub(AROUND)..(i + AROUND + 1).min(run.len())];
                    let side = || side(station, around, &hints, a < b);
                    let AdjacentPlace { index, same_direction, .. } = *place;
                    (same_level || part_there()).then(|| Drawn { index, same_direction, side: side() })
                };
                run.iter().enumerate().filter_map(drawn).collect::<Vec<_>>()
            });
            ((a, b), sides.collect())
        };
        Self { hints, drawn: adjacency.par_iter().map(sides).collect() }
    }

    /// On which side of the first road of a pair the second lies beside a place: as either was drawn there or near by, else as both lie
    /// now. `None` if one leads over the other.
    pub(super) fn at(
        &self,
        pair: (usize, usize),
        [road, other]: [&ShiftedRoad; 2],
        place: &AdjacentPlace,
    ) -> Option<f64> {
        let AdjacentPlace { index, beside, same_direction, .. } = *place;
        let own = || self.drawn_near(pair, index, same_direction);
        let seen_from_other = || {
            let side = self.drawn_near((pair.1, pair.0), beside, same_direction)?;
            Some(if same_direction { -side } else { side })
        };
        // Roads that are drawn on each other may each seem to lie to the left: what the first road of the network sees counts.
        let first = pair.0 <= pair.1;
        if let Some(side) = if first { own().or_else(seen_from_other) } else { seen_from_other().or_else(own) } {
            return Some(side);
        }
        let hints = self.hints.get(&pair).map_or(&[][..], Vec::as_slice);
        let hints: Vec<(&SideHint, bool)> = hints.iter().map(|hint| (hint, false)).collect();
        let now = || side(road.stations[index], std::slice::from_ref(place), &hints, first);
        (road.level == other.level).then(now)
    }

    /// The side on which the second road of a pair was drawn beside the place with this index or the nearest one to it.
    fn drawn_near(&self, pair: (usize, usize), index: usize, same_direction: bool) -> Option<f64> {
        let drawn = self.drawn.get(&pair)?;
        let begin = drawn.partition_point(|one| one.index + AROUND < index);
        let near = drawn[begin..].iter().take_while(|one| one.index <= index + AROUND);
        let near = near.filter(|one| one.same_direction == same_direction);
        near.min_by_key(|one| one.index.abs_diff(index)).map(|nearest| nearest.side)
    }
}

/// Whether a run of places begins at the cut of the intersection that the two roads share.
fn begins_at_cut(road: &ShiftedRoad, run: &[AdjacentPlace], hint: &SideHint) -> bool {
    let Some([first, last]) = road.kept else { return false };
    match hint.meets {
        Some(End::Start) => run.first().is_some_and(|adjacent| adjacent.index == first),
        Some(End::End) => run.last().is_some_and(|adjacent| adjacent.index == last),
        None => false,
    }
}

/// The side of the other road at a station, metres, from the places `around` it. `first` if the road comes before the other in the
/// network.
fn side(station: f64, around: &[AdjacentPlace], hints: &[(&SideHint, bool)], first: bool) -> f64 {
    hinted_side(station, around, hints).unwrap_or_else(|| drawn_side(around, first))
}

/// The side of the other road at a station, by the order of arms at intersections, each with whether the run begins at its cut; `None`
/// without hints, or if they contradict each other. Away from the intersection a hint counts only if the side on which the other road
/// is drawn `around` there is unclear.
fn hinted_side(station: f64, around: &[AdjacentPlace], hints: &[(&SideHint, bool)]) -> Option<f64> {
    let mut near = hints.iter().filter(|(hint, _)| hint.holds_at(station)).peekable();
    near.peek()?;
    let unclear = around.iter().all(|adjacent| adjacent.offset.abs() < UNCLEAR);
    let mut sides = near.filter(|(_, begins_at_cut)| *begins_at_cut || unclear).map(|(hint, _)| hint.side);
    let first = sides.next()?;
    sides.all(|side| side == first).then_some(first)
}

/// The side on which the other road is drawn along neighbouring places: 1 left, -1 right. If both are drawn on top of each other,
/// the `first` road of the network goes to the left.
fn drawn_side(run: &[AdjacentPlace], first: bool) -> f64 {
    let farthest = run.iter().max_by(|x, y| x.offset.abs().total_cmp(&y.offset.abs()));
    match farthest {
        Some(adjacent) if adjacent.offset.abs() > TOLERANCE => adjacent.offset.signum(),
        Some(adjacent) if adjacent.same_direction && !first => 1.0,
        _ => -1.0,
    }
}
