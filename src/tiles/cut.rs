//! Copies each element into the files of the tiles that need it.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use rustc_hash::FxHashMap;

use crate::cells::{Cell, CellSets, Ids, NOWHERE, SetId};
use crate::osm::{ElementKind, Member, MetaInfo, Node, OsmText, Relation};
use crate::projection::Projector;

use super::reach::{Reach, TileSize, line};
use super::spool::{Elements, Spool};
use super::survey::Survey;

/// The data of one tile.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TileFile {
    /// The tile.
    pub tile: Cell,
    /// OpenStreetMap XML.
    pub path: PathBuf,
}

impl TileFile {
    /// The name of a tile's file in a folder.
    pub fn path_in(folder: &Path, tile: Cell) -> PathBuf {
        folder.join(format!("{}_{}.osm", tile.column, tile.row))
    }
}

/// Writes the files of the tiles of some data, in a folder that is there; they are listed row by row.
///
/// # Errors
///
/// If one of the files cannot be written.
pub fn cut(survey: Survey, projector: &Projector, size: TileSize, folder: &Path) -> io::Result<Vec<TileFile>> {
    let (needs, elements) = Needs::of(survey, projector, size);
    let cells = needs.sets.cells();
    let mut files: Vec<TileFile> =
        cells.iter().map(|tile| TileFile { tile: *tile, path: TileFile::path_in(folder, *tile) }).collect();
    let head = OsmText::head(&MetaInfo::default());
    let append_to_all = |text: OsmText| files.iter().try_for_each(|file| append(&file.path, text.as_bytes()));
    append_to_all(head)?;
    for block in elements.blocks()? {
        needs.copy(&block?, &files)?;
    }
    append_to_all(OsmText::tail())?;
    files.sort_unstable_by_key(|file| file.tile);
    Ok(files)
}

/// Which tiles need each element, by its position among those of its kind.
struct Needs {
    sets: CellSets,
    node_ids: Ids,
    nodes: Vec<SetId>,
    way_ids: Ids,
    ways: Vec<SetId>,
    elevations: FxHashMap<u32, f64>,
}

impl Needs {
    /// Also gives the elements.
    fn of(mut survey: Survey, projector: &Projector, size: TileSize) -> (Self, Spool) {
        let places = projector.forward_all(&std::mem::take(&mut survey.places));
        let mut reach = Reach::new(&survey, &places, size);
        let mut nodes: Vec<SetId> =
            (0..places.len()).map(|node| reach.of_node(&line(&[node as u32], &places))).collect();
        let mut ways = Vec::with_capacity(survey.ways.len());
        for way in 0..survey.ways.len() {
            let on_way = survey.way_nodes.at(way);
            let set = reach.of_way(way, &line(on_way, &places));
            for node in on_way {
                if let Some(of_node) = nodes.get_mut(*node as usize) {
                    *of_node = reach.sets.union(*of_node, set);
                }
            }
            ways.push(set);
        }
        let Survey { node_ids, way_ids, elevations, elements, .. } = survey;
        (Self { sets: reach.sets, node_ids, nodes, way_ids, ways, elevations }, elements)
    }

    fn node(&self, id: i64) -> &[u32] {
        let set = self.node_ids.find(id).and_then(|at| self.nodes.get(at as usize));
        self.sets.get(set.copied().unwrap_or(NOWHERE))
    }

    fn way(&self, id: i64) -> &[u32] {
        let set = self.way_ids.find(id).and_then(|at| self.ways.get(at as usize));
        self.sets.get(set.copied().unwrap_or(NOWHERE))
    }

    /// The tiles of all nodes and ways that are members.
    fn relation(&self, relation: &Relation) -> Vec<u32> {
        let of_member = |member: &Member| match member.kind {
            ElementKind::Node => self.node(member.id),
            ElementKind::Way => self.way(member.id),
            ElementKind::Relation => &[],
        };
        let mut tiles: Vec<u32> = relation.members.iter().flat_map(of_member).copied().collect();
        tiles.sort_unstable();
        tiles.dedup();
        tiles
    }

    /// The node with its height in `ele`, where it is known.
    fn with_elevation<'a>(&self, node: &'a Node) -> Cow<'a, Node> {
        let known = if self.elevations.is_empty() { None } else { self.node_ids.find(node.id) };
        let Some(height) = known.and_then(|at| self.elevations.get(&at)) else { return Cow::Borrowed(node) };
        let mut node = node.clone();
        node.tags.set("ele", height.to_string());
        Cow::Owned(node)
    }

    /// Appends the elements of a block to the files of the tiles that need them.
    fn copy(&self, block: &Elements, files: &[TileFile]) -> io::Result<()> {
        let mut texts: BTreeMap<u32, OsmText> = BTreeMap::new();
        for node in &block.nodes {
            let node = self.with_elevation(node);
            self.node(node.id).iter().for_each(|tile| texts.entry(*tile).or_default().put_node_exactly(&node));
        }
        for way in &block.ways {
            self.way(way.id).iter().for_each(|tile| texts.entry(*tile).or_default().put_way(way));
        }
        for relation in &block.relations {
            let tiles = self.relation(relation);
            tiles.into_iter().for_each(|tile| texts.entry(tile).or_default().put_relation(relation));
        }
        for (tile, text) in texts {
            if let Some(file) = files.get(tile as usize) {
                append(&file.path, text.as_bytes())?;
            }
        }
        Ok(())
    }
}

fn append(path: &Path, text: &[u8]) -> io::Result<()> {
    OpenOptions::new().create(true).append(true).open(path)?.write_all(text)
}
