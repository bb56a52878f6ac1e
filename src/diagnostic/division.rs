//! Places at which a road is cut: its ways, and the lanelets between them.

use serde::Serialize;

use crate::text::Text;

/// Ways, and all lanelets that lie between them, cut at the same places.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Division {
    /// Bounds and centre lines, each cut as often as the others. A way that only runs along a segment with a new vertex gets it, too.
    pub ways: Vec<WayCut>,
    /// Every lanelet that has one of them.
    pub lanelets: Vec<LaneletCut>,
}

/// A way that is cut; its first part, in file order, keeps the id, the others get fresh ones.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WayCut {
    /// The way.
    pub way: i64,
    /// Where, in file order.
    pub places: Vec<CutPlace>,
}

/// A place on a way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CutPlace {
    /// The number of the vertex at the place or before it.
    pub vertex: usize,
    /// The share (0..1) of the way from this vertex to the next; at 0 it is the vertex itself.
    pub share: f64,
}

/// A lanelet that is cut. The new pieces get fresh ids, and all tags and members that are not named here.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LaneletCut {
    /// The lanelet.
    pub lanelet: i64,
    /// Those of the ways that run against it: the last part of each belongs to its first piece.
    pub against: Vec<i64>,
    /// The number of the piece that keeps the id, in the direction of travel, from 0.
    pub stays: usize,
    /// Regulatory elements to which only some pieces refer, and which name only these.
    pub elements: Vec<(i64, Vec<usize>)>,
    /// Tags that only some pieces have.
    pub tags: Vec<(Text, Vec<usize>)>,
}
