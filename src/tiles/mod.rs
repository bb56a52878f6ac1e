//! Cuts OpenStreetMap data into tiles that are built one after the other, so that memory depends on the largest tile.
//!
//! A tile is a square of whole cells. It is built from all that touches it and its surroundings, and only its cells are kept:
//! what stands in a cell depends on what lies near it, so that the cells are the same as those of the map built in one piece.
//! Two things may lead far away. A road is one lanelet from one intersection to the next, so the surroundings are those of
//! all roads that touch the tile, to their ends. And an element in a cell brings along what it refers to, the lanelets of its
//! intersection, so roads that begin shortly outside the tile count, too.
//!
//! The file is read once, block by block: ids, places and the nodes of ways are held ([`Survey`]), the elements go to disk. When all
//! roads are known, each element is copied from there into the files of the tiles that need it ([`cut()`]). When tiles are
//! joined, they are held against each other ([`Agreement`]).

mod agreement;
mod cut;
mod reach;
mod record;
mod spool;
mod survey;

pub use agreement::{Agreement, Disagreement};
pub use cut::{TileFile, cut};
pub use reach::TileSize;
pub use record::Record;
pub use survey::{Meaning, Survey, SurveyError, WayUse};
