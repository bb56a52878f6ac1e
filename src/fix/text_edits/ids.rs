//! New ids. A fix that is made again beside others gets the same ones, so that what the others do is told apart.

use super::{Key, TextEdits};
use crate::diagnostic::Fix;
use crate::osm::OsmData;

/// The highest ids that are in use.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ids {
    /// Of all.
    last: i64,
    /// Of those that Autoware can read where it reads 32 bits.
    small: i64,
}

/// The ids that a fix has used, from those behind the first to the second.
#[derive(Clone, Copy, Debug)]
pub struct IdRange {
    from: Ids,
    to: Ids,
}

impl Ids {
    /// Those of a map.
    pub(super) fn last_of(osm: &OsmData) -> Self {
        let ids = osm.nodes.iter().map(|node| node.id).chain(osm.ways.iter().map(|way| way.id));
        let ids = ids.chain(osm.relations.iter().map(|relation| relation.id));
        let small = |id: i64| if id <= i64::from(i32::MAX) { id } else { 0 };
        ids.map(|id| Self { last: id, small: small(id) }).fold(Self { last: 0, small: 0 }, Self::max)
    }

    fn max(self, other: Self) -> Self {
        Self { last: self.last.max(other.last), small: self.small.max(other.small) }
    }
}

impl TextEdits<'_> {
    /// Leaves ids to the fixes that used them before.
    pub fn spare(&mut self, ranges: impl Iterator<Item = IdRange>) {
        self.ids = ranges.fold(self.ids, |ids, range| ids.max(range.to));
    }

    /// As [`TextEdits::apply`], with the ids that the fix used before, where they are enough; gives them back, too.
    pub fn apply_again(&mut self, fix: &Fix, used: Option<IdRange>) -> Option<(Vec<Key>, IdRange)> {
        if let Some(range) = used {
            let next = std::mem::replace(&mut self.ids, range.from);
            self.limit = Some(range.to);
            let created = self.apply(fix);
            self.limit = None;
            self.ids = next.max(range.to);
            if let Some(created) = created {
                return Some((created, range));
            }
        }
        let from = self.ids;
        let created = self.apply(fix)?;
        Some((created, IdRange { from, to: self.ids }))
    }

    /// An unused id; with `small`, one that fits 31 bits.
    pub(super) fn fresh(&mut self, small: bool) -> Option<i64> {
        let Self { ids, limit, .. } = self;
        if small && ids.last >= i64::from(i32::MAX) {
            ids.small += 1;
            let most = limit.map_or(i64::from(i32::MAX), |limit| limit.small);
            return (ids.small <= most).then_some(ids.small);
        }
        ids.last = ids.last.checked_add(1)?;
        if ids.last <= i64::from(i32::MAX) {
            ids.small = ids.small.max(ids.last);
        }
        limit.is_none_or(|limit| ids.last <= limit.last).then_some(ids.last)
    }
}
