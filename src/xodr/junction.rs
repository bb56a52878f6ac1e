//! Junctions, and the controllers of their lights.

use crate::text::Text;

use super::road::RoadEnd;

/// What a junction is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum JunctionKind {
    /// Roads lead through it on connecting roads.
    #[default]
    Common,
    /// Roads fork without connecting roads.
    Direct,
    /// A place of a road at which others begin; the road itself is not interrupted.
    Virtual,
    /// A crossing with rails.
    Crossing,
}

/// A junction.
#[derive(Clone, Debug, Default)]
pub struct Junction {
    /// Its id: any text.
    pub id: Text,
    /// The line on which it stands, from 1.
    pub line: usize,
    /// What it is.
    pub kind: JunctionKind,
    /// Which lanes lead to which.
    pub connections: Vec<Connection>,
    /// Ids of the controllers of its lights.
    pub controllers: Vec<Text>,
    /// Pairs of roads of which the first goes first.
    pub priorities: Vec<[Text; 2]>,
}

/// Lanes of one road that lead to those of another.
#[derive(Clone, Debug, Default)]
pub struct Connection {
    /// The line on which it stands, from 1.
    pub line: usize,
    /// The road that leads in.
    pub incoming: Text,
    /// The connecting road; in a direct junction the road behind.
    pub connecting: Text,
    /// The end of the connecting road that meets the incoming one.
    pub contact: Option<RoadEnd>,
    /// Pairs of lanes: of the incoming road, of the connecting road.
    pub lanes: Vec<[i64; 2]>,
}

/// Signals that change together.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Controller {
    /// Its id: any text.
    pub id: Text,
    /// The signals.
    pub signals: Vec<Text>,
}
