//! Tells which roads belong to a roundabout that lies wholly in the data and looks like one to those who come to it.

use rustc_hash::FxHashMap;

use crate::builder::tags::cross_section::{CrossSection, Travel};
use crate::geometry::Polyline;
use crate::lanelet::index::RingShape;

use super::{RoadIx, RoadKey, RoadNetwork};

/// A piece of a ring in its direction of travel.
struct Piece {
    /// The OpenStreetMap nodes where it begins and ends.
    from: i64,
    to: i64,
    line: Polyline,
    /// `None` inside an intersection.
    road: Option<RoadIx>,
}

impl Piece {
    fn new(key: RoadKey, line: &Polyline, section: &CrossSection, road: Option<RoadIx>) -> Option<Self> {
        Some(match section.one_way()? {
            Travel::Backward => Self { from: key.last, to: key.first, line: line.reversed(), road },
            _ => Self { from: key.first, to: key.last, line: line.clone(), road },
        })
    }
}

/// The roundabouts of which the whole ring is in the data, and round. At others nobody sees that the rules of a roundabout hold.
#[derive(Clone, Debug, Default)]
pub struct WholeRoundabouts {
    /// For each road of a ring the least OpenStreetMap node of that ring.
    of_road: FxHashMap<RoadIx, i64>,
}

impl WholeRoundabouts {
    /// Whether a road is part of one.
    pub fn contains(&self, road: RoadIx) -> bool {
        self.of_road.contains_key(&road)
    }

    /// The roundabout of which a road is part, by the least OpenStreetMap node of its ring.
    pub fn ring_of(&self, road: RoadIx) -> Option<i64> {
        self.of_road.get(&road).copied()
    }
}

impl RoadNetwork {
    /// See [`WholeRoundabouts`].
    pub fn whole_roundabouts(&self) -> WholeRoundabouts {
        let roads = RoadIx::all(self.roads.len()).map(|ix| (ix, self.road(ix))).filter(|(_, road)| road.roundabout);
        let roads = roads.filter_map(|(ix, road)| Piece::new(road.key, &road.line, &road.section, Some(ix)));
        let inner = self.intersections.iter().flat_map(|at| &at.inner).filter(|inner| inner.roundabout);
        let inner = inner.filter_map(|inner| Piece::new(inner.key, &inner.line, &inner.section, None));
        let mut pieces: Vec<Piece> = roads.chain(inner).collect();
        pieces.sort_by_key(|piece| (piece.from, piece.to));
        let from: FxHashMap<i64, usize> = pieces.iter().map(|piece| piece.from).zip(0..).collect();
        let mut passed = vec![false; pieces.len()];
        let mut whole = WholeRoundabouts::default();
        for start in 0..pieces.len() {
            let mut at = Some(start);
            let mut walk: Vec<usize> = Vec::new();
            while let Some(piece) = at.filter(|&piece| !passed[piece]) {
                passed[piece] = true;
                walk.push(piece);
                at = from.get(&pieces[piece].to).copied();
            }
            let ring = at.and_then(|end| walk.iter().position(|&piece| piece == end)).map(|begin| &walk[begin..]);
            let ring = ring.unwrap_or_default();
            let places = ring.iter().flat_map(|&piece| pieces[piece].line.points()).copied();
            if Polyline::new(places).is_some_and(|line| RingShape::of(&line) != RingShape::Other) {
                let least = ring.iter().map(|&piece| pieces[piece].from).min().unwrap_or_default();
                let roads = ring.iter().filter_map(|&piece| pieces[piece].road);
                whole.of_road.extend(roads.map(|road| (road, least)));
            }
        }
        whole
    }
}

#[cfg(test)]
mod tests {
    use crate::builder::network::hand_drawn::{network, osm};

    /// How many roads there are of a ring of twelve nodes with three arms, and how many of them belong to a whole roundabout. `stretch`
    /// is the ring's length from west to east, as parts of its width; `drawn` are the nodes of its way.
    fn ring(stretch: f64, drawn: &[i64]) -> [usize; 2] {
        let place = |i: i64| {
            let angle = std::f64::consts::TAU * i as f64 / 12.0;
            (i, 15.0 * stretch * angle.cos(), 15.0 * angle.sin(), "")
        };
        let mut nodes: Vec<_> = (0..12).map(place).collect();
        nodes.extend([(20, 15.0 * stretch + 60.0, 0.0, ""), (21, 0.0, 75.0, ""), (22, 0.0, -75.0, "")]);
        let ways = [(10, drawn, "junction=roundabout"), (11, &[20, 0], ""), (12, &[21, 3], ""), (13, &[22, 9], "")];
        let network = network(&osm(&nodes, &ways));
        let ring = network.roads.iter().filter(|road| road.roundabout).count();
        [ring, network.whole_roundabouts().of_road.len()]
    }

    #[test]
    fn only_whole_and_round_rings_are_seen_as_roundabouts() {
        let around: Vec<i64> = (0..12).chain([0]).collect();
        assert_eq!(ring(1.0, &around), [3, 3]);
        assert_eq!(ring(1.0, &around[..11]), [3, 0], "the data ends");
        assert_eq!(ring(6.0, &around), [3, 0], "two long sides");
    }
}
