//! Claims: what each fix needs for itself, so that two fixes of one round do not change the same thing.

use rustc_hash::FxHashSet;

use crate::element_edits::Key;
use crate::osm::ElementKind;

/// A part of an element that an edit claims.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Part {
    Tag(String),
    Place,
    Vertex(usize),
    Member(ElementKind, i64),
    /// The references to one element, wherever they stand.
    References(Key),
    /// A reference to a new element of this subtype.
    Created(String),
}

/// What one fix needs for itself.
#[derive(Debug, Default)]
pub(super) struct Claim {
    /// Elements of which nobody else may change or name anything.
    pub(super) whole: Vec<Key>,
    /// Parts of elements that nobody else may change.
    pub(super) parts: Vec<(Key, Part)>,
    /// Elements that must stay as they are, since the fix names them.
    pub(super) named: Vec<Key>,
}

/// What the fixes of this round have claimed.
#[derive(Debug, Default)]
pub(super) struct Claims {
    whole: FxHashSet<Key>,
    parts: FxHashSet<(Key, Part)>,
    touched: FxHashSet<Key>,
}

impl Claims {
    pub(super) fn allow(&self, claim: &Claim) -> bool {
        !claim.whole.iter().any(|key| self.touched.contains(key))
            && !claim.parts.iter().any(|part| self.whole.contains(&part.0) || self.parts.contains(part))
            && !claim.named.iter().any(|key| self.whole.contains(key))
    }

    pub(super) fn add(&mut self, claim: Claim) {
        let Claim { whole, parts, named } = claim;
        self.touched.extend(whole.iter().copied().chain(parts.iter().map(|part| part.0)).chain(named));
        self.whole.extend(whole);
        self.parts.extend(parts);
    }
}
