//! Gives elements new ids if ids repeat, or if Autoware cannot read them.

use rustc_hash::FxHashMap;

use super::TextEdits;
use super::references::NAMING;
use crate::diagnostic::{SourceSpan, Subject};
use crate::element_edits::{Key, key_of};
use crate::osm::ElementKind;
use crate::osm::element::Child;

impl TextEdits<'_> {
    /// Gives one element of this id another one, and says so in those that refer to it: in all, or in these.
    pub(super) fn renumber(&mut self, key: Key, nth: usize, referrers: Option<&[Subject]>) -> Option<()> {
        let (kind, id) = key;
        let fresh = self.fresh(kind == ElementKind::Way)?;
        let span = self.nth(key, nth)?;
        self.element_at(&span)?.set_attribute("id", &fresh.to_string());
        let told: Vec<Key> = match referrers {
            Some(some) => some.iter().filter_map(|one| key_of(*one)).collect(),
            None => self.referrers_of(key).collect(),
        };
        self.renumbered.push((key, fresh));
        self.renames.extend(told.into_iter().map(|referrer| (referrer, key, fresh)));
        let named = if referrers.is_none() { self.references.named(key).to_vec() } else { Vec::new() };
        for key in named {
            let osm = self.osm;
            let tags = match key.0 {
                ElementKind::Way => osm.way(key.1).map(|one| &one.tags),
                _ => osm.relation(key.1).map(|one| &one.tags),
            }?;
            for name in NAMING.into_iter().filter(|name| tags.get(name).is_some_and(|value| value == id.to_string())) {
                self.element_of(key)?.set_tag(name, &fresh.to_string());
            }
        }
        Some(())
    }

    /// The position of the nth element of an id, in file order.
    pub(super) fn nth(&self, key: Key, nth: usize) -> Option<SourceSpan> {
        match self.repeated.get(&key) {
            Some(spans) => spans.get(nth).copied().cloned(),
            None => self.span(key).filter(|_| nth == 0).cloned(),
        }
    }

    /// The new ids of the elements that have one, by kind and old id.
    pub fn renumbered(&self) -> FxHashMap<Key, i64> {
        self.renumbered.iter().copied().collect()
    }

    /// Rewrites the references to elements that have a new id.
    pub(super) fn rename(&mut self) {
        let mut renames: FxHashMap<Key, FxHashMap<Key, i64>> = FxHashMap::default();
        for (referrer, old, fresh) in self.renames.drain(..) {
            renames.entry(referrer).or_default().insert(old, fresh);
        }
        for (referrer, fresh) in renames {
            let Some(element) = self.element_of(referrer) else { continue };
            element.replace(|child| match child {
                Child::Vertex(old) => Some(Child::Vertex(*fresh.get(&(ElementKind::Node, *old))?)),
                Child::Member(kind, old, role) => Some(Child::Member(*kind, *fresh.get(&(*kind, *old))?, role.clone())),
                _ => None,
            });
        }
    }
}
