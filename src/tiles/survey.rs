//! What must be known of all data before they are cut: ids, places, the nodes of ways.

use std::io;
use std::path::Path;

use rustc_hash::FxHashMap;

use crate::cells::{Ids, Lists};
use crate::osm::{DataBlocks, Node, ReadError, Way};
use crate::projection::{Extent, LonLat};

use super::spool::{Elements, Spool};

/// Why data cannot be taken in.
#[derive(Debug, thiserror::Error)]
pub enum SurveyError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The elements cannot be written.
    #[error("cannot write the elements: {0}")]
    Write(#[from] io::Error),
}

/// What a way is to a builder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum WayUse {
    /// No road.
    Other,
    /// A road, by its tags.
    Highway,
    /// A road that cars drive on.
    Driven,
}

/// The position of a node that is not there.
pub(super) const GONE: u32 = u32::MAX;

/// Ids and places of nodes, and the nodes of ways, in the order of the file: some 30 bytes a node. The elements lie on disk.
#[derive(Debug)]
pub struct Survey {
    pub(super) node_ids: Ids,
    /// Not a number where a node has no place.
    pub(super) places: Vec<LonLat>,
    /// The positions of the nodes of each way, or [`GONE`].
    pub(super) way_nodes: Lists<u32>,
    pub(super) way_ids: Ids,
    pub(super) ways: Vec<WayUse>,
    /// Nodes that ways have before the nodes come: where in the lists, and the id.
    ahead: Vec<(usize, i64)>,
    /// What the file says that it holds of the Earth.
    pub bounds: Vec<Extent>,
    /// Relations with `type=lanelet`.
    pub lanelets: usize,
    /// The heights of nodes by their positions, metres, that the tiles get: as far as they are written, if nobody finds others.
    pub elevations: FxHashMap<u32, f64>,
    pub(super) elements: Spool,
}

/// What a builder sees in elements.
#[derive(Clone, Copy)]
pub struct Meaning<'a> {
    /// What a way is to it.
    pub use_of: &'a dyn Fn(&Way) -> WayUse,
    /// The height that a node says, metres.
    pub elevation: &'a dyn Fn(&Node) -> Option<f64>,
}

impl Survey {
    /// Reads a file, XML or PBF, once. Its elements are kept on disk, in a folder that is there.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, or is no OpenStreetMap data, or if the disk is full.
    pub fn read(path: &Path, folder: &Path, meaning: Meaning<'_>) -> Result<Self, SurveyError> {
        let mut survey = Self::empty(Spool::new(folder)?);
        let mut blocks = DataBlocks::open(path)?;
        while let Some(block) = blocks.next_block()? {
            survey.bounds.extend(&block.bounds);
            let elements = Elements::from(block);
            survey.elements.push(&elements)?;
            survey.add(&elements, meaning);
        }
        for (at, id) in std::mem::take(&mut survey.ahead) {
            if let Some((place, node)) = survey.way_nodes.items_mut().get_mut(at).zip(survey.node_ids.find(id)) {
                *place = node;
            }
        }
        if survey.bounds.is_empty() {
            survey.bounds.push(Extent::EARTH);
        }
        Ok(survey)
    }

    fn empty(elements: Spool) -> Self {
        Self {
            node_ids: Ids::default(),
            places: Vec::new(),
            way_nodes: Lists::default(),
            way_ids: Ids::default(),
            ways: Vec::new(),
            ahead: Vec::new(),
            bounds: Vec::new(),
            lanelets: 0,
            elevations: FxHashMap::default(),
            elements,
        }
    }

    fn add(&mut self, block: &Elements, meaning: Meaning<'_>) {
        const NOWHERE: LonLat = LonLat { lon: f64::NAN, lat: f64::NAN };
        for node in &block.nodes {
            let place = node.position.unwrap_or(NOWHERE);
            let own = self.places.len() as u32;
            // Of nodes with the same id the last counts.
            let first = self.node_ids.push(node.id);
            if let Some(first) = first.and_then(|first| self.places.get_mut(first as usize)) {
                *first = place;
            }
            self.places.push(place);
            let first = first.unwrap_or(own);
            match (meaning.elevation)(node) {
                Some(height) => drop(self.elevations.insert(first, height)),
                None => drop(self.elevations.remove(&first)),
            }
        }
        for way in &block.ways {
            self.way_ids.push(way.id);
            self.ways.push((meaning.use_of)(way));
            let before = self.way_nodes.items();
            let at = |id: &i64| self.node_ids.find(*id).unwrap_or(GONE);
            let found: Vec<u32> = way.nodes.iter().map(at).collect();
            let gone = found.iter().zip(&way.nodes).enumerate().filter(|(_, (at, _))| **at == GONE);
            self.ahead.extend(gone.map(|(i, (_, id))| (before + i, *id)));
            self.way_nodes.push(found);
        }
        self.lanelets += block.relations.iter().filter(|relation| relation.tags.is("type", "lanelet")).count();
    }

    /// How many ways there are of this use or a greater one.
    pub fn count(&self, least: WayUse) -> usize {
        self.ways.iter().filter(|of| **of >= least).count()
    }

    /// The box around the nodes of all ways of this use or a greater one; `None` if none has a place.
    pub fn around(&self, least: WayUse) -> Option<Extent> {
        let ways = self.ways.iter().enumerate().filter(|(_, of)| **of >= least);
        let nodes = ways.flat_map(|(way, _)| self.way_nodes.at(way));
        Extent::of(nodes.filter_map(|node| self.place(*node)))
    }

    /// The box around all nodes; `None` if none has a place.
    pub fn around_all(&self) -> Option<Extent> {
        Extent::of((0..self.places.len() as u32).filter_map(|node| self.place(node)))
    }

    /// The nodes of each way of this use or a greater one, by their positions, in the order of the file.
    pub fn nodes_of(&self, least: WayUse) -> impl Iterator<Item = &[u32]> {
        let ways = self.ways.iter().enumerate().filter(move |(_, of)| **of >= least);
        ways.map(|(way, _)| self.way_nodes.at(way))
    }

    /// Where a node lies, by its position; `None` where it has no place.
    pub fn place(&self, node: u32) -> Option<LonLat> {
        self.places.get(node as usize).copied().filter(|place| place.lat.is_finite())
    }
}
