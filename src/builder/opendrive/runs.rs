//! Which pieces of lanes are one lanelet: on a connecting road each way from its begin to its end, elsewhere each lane of a stretch.

use std::collections::{BTreeMap, BTreeSet};

use super::contacts::LaneEnd;
use super::lane_use::sides;
use super::lines::StretchLanes;
use super::nodes::EndNodes;
use super::scene::{Piece, Scene};

/// The most ways through one road that are told apart.
const MOST_WAYS: usize = 200;

/// The ways through a road, in order of the lanes where they begin. `meeting` has the ends of lanes that meet each end.
pub fn runs(
    scene: &Scene,
    lanes: &[StretchLanes],
    (ends, meeting): (&EndNodes, &BTreeMap<LaneEnd, Vec<LaneEnd>>),
    road: usize,
) -> Vec<Vec<Piece>> {
    let stretches = scene.first[road]..scene.first[road] + scene.cut[road].stretches.len();
    let of_stretch =
        |stretch: usize| lanes[stretch].driven.iter().map(move |(lane, _)| Piece { stretch, lane: lane.id });
    let all: Vec<Piece> = stretches.clone().flat_map(of_stretch).collect();
    if !scene.connecting[road] {
        return all.into_iter().map(|piece| vec![piece]).collect();
    }
    let next: BTreeMap<Piece, Vec<Piece>> =
        all.iter().map(|piece| (*piece, behind(scene, lanes, (ends, meeting), *piece))).collect();
    let reached: BTreeSet<Piece> = next.values().flatten().copied().collect();
    let mut open: Vec<Vec<Piece>> =
        all.iter().filter(|piece| !reached.contains(piece)).map(|piece| vec![*piece]).rev().collect();
    let mut ways = Vec::new();
    while let Some(mut way) = open.pop() {
        while let Some((only, others)) = way.last().and_then(|last| next.get(last)?.split_first()) {
            open.extend(others.iter().rev().map(|piece| [&way[..], &[*piece]].concat()));
            way.push(*only);
            if open.len() > MOST_WAYS {
                break;
            }
        }
        ways.push(way);
        if ways.len() + open.len() > MOST_WAYS {
            return all.into_iter().map(|piece| vec![piece]).collect();
        }
    }
    ways
}

/// The pieces of the next stretch in which a piece goes on the same way.
fn behind(
    scene: &Scene,
    lanes: &[StretchLanes],
    (ends, meeting): (&EndNodes, &BTreeMap<LaneEnd, Vec<LaneEnd>>),
    piece: Piece,
) -> Vec<Piece> {
    let directions = |piece: Piece| {
        let driven = lanes[piece.stretch].driven.iter().find(|(lane, _)| lane.id == piece.lane);
        driven.map(|(lane, used)| (scene.road(piece.stretch).directions(lane), *used))
    };
    let node = |stretch: usize, far: bool, border: i64| {
        let stands = lanes[stretch].stands.get(&border).copied().unwrap_or(border);
        ends.get(&(stretch, far, stands)).map(|(first, _)| *first)
    };
    let here = LaneEnd { stretch: piece.stretch, far: true, lane: piece.lane };
    let mut found: Vec<Piece> = meeting
        .get(&here)
        .into_iter()
        .flatten()
        .filter(|other| other.stretch == piece.stretch + 1 && !other.far)
        .map(|other| Piece { stretch: other.stretch, lane: other.lane })
        .filter(|other| scene.stretches[other.stretch].road == scene.stretches[piece.stretch].road)
        .filter(|other| directions(*other).is_some() && directions(*other) == directions(piece))
        .filter(|other| {
            let pairs = sides(piece.lane).into_iter().zip(sides(other.lane));
            pairs.into_iter().all(|(a, b)| node(piece.stretch, true, a) == node(other.stretch, false, b))
        })
        .collect();
    found.sort_unstable();
    found.dedup();
    found
}
