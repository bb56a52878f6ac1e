//! What is merged, and how much of it was taken.

use crate::osm::{ElementKind, OsmData};

/// Kind and id of an element.
pub type Key = (ElementKind, i64);

/// Who wins where one side has deleted what the other has changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Deletions {
    /// The change: nothing is lost.
    #[default]
    Kept,
    /// The deletion, where ours has deleted: what a person took out of a built map stays out.
    OfOursStand,
}

/// What is merged: three maps of one file each.
#[derive(Clone, Copy, Debug)]
pub struct Versions<'a> {
    /// What both sides began with.
    pub base: &'a OsmData,
    /// The side whose text is kept where it can be.
    pub ours: &'a OsmData,
    /// The other side.
    pub theirs: &'a OsmData,
}

/// How many elements of theirs are in the result that ours did not have so.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Taken {
    /// That ours does not have.
    pub added: usize,
    /// That ours has as they were.
    pub changed: usize,
    /// That both have changed, each something else of them.
    pub combined: usize,
    /// That theirs has deleted.
    pub removed: usize,
}
