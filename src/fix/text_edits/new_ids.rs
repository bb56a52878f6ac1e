//! New ids. A fix that is applied again together with others gets the same ids as before, so that the effects of the others can
//! be found by comparison.

use super::TextEdits;
use super::ids::IdRange;
use crate::diagnostic::Fix;
use crate::element_edits::Key;

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
