//! Whether a value is a slip of the pen, or another word of the same meaning.

use super::meanings::Meanings;
use super::table::{Key, On, Slip, Types, Words};
use crate::text::{misspelt, rearranged};

impl Key {
    /// What is wrong with its value.
    pub(super) fn value(&'static self, value: &str, meanings: &'static Meanings) -> Option<Slip> {
        if let Some(form) = self.form {
            return Some(Slip::Form(form, form.fault(value)?));
        }
        if self.values.is_empty() || self.values.iter().any(|known| known == value) {
            return None;
        }
        let words = || self.values.iter().map(String::as_str);
        let meant = meanings.of(value, words()).or_else(|| misspelt(value, words()));
        match self.closed {
            true => Some(Slip::Word(&self.values, meant)),
            false => meant.map(Slip::Value),
        }
    }
}

impl Words {
    /// The `type` that was meant. What a relation is, is decided before anybody asks.
    pub(super) fn kind(&'static self, on: On, value: &str, meanings: &'static Meanings) -> Option<&'static str> {
        let knows = |list: &Types| list.names.iter().any(|name| name == value);
        if matches!(on, On::Lanelet | On::Element | On::Area) || self.types.iter().any(knows) {
            return None;
        }
        let here = || self.lists(on).flat_map(|list| &list.names).map(String::as_str);
        // Of words for points, which are many and short, none is said of lines.
        let other = if on == On::LineString { On::Polygon } else { On::LineString };
        let there = || self.lists(other).filter(|_| on != On::Point).flat_map(|list| &list.names).map(String::as_str);
        meanings
            .of(value, here())
            .or_else(|| misspelt(value, here()))
            .or_else(|| rearranged(value, here()))
            .or_else(|| meanings.of(value, there()))
            .or_else(|| misspelt(value, there()))
            .or_else(|| meanings.initials(value, here()))
    }

    /// The `subtype` that was meant.
    pub(super) fn subtype(
        &'static self,
        on: On,
        kind: Option<&str>,
        value: &str,
        meanings: &'static Meanings,
    ) -> Option<&'static str> {
        // Signs have the numbers of their country.
        let is_number = kind == Some("traffic_sign") && value.contains(|letter: char| letter.is_ascii_digit());
        if matches!(on, On::Point | On::Element) || is_number {
            return None;
        }
        let kind = kind.map(|kind| self.kind(on, kind, meanings).unwrap_or(kind));
        let of = |list: &&Types| {
            matches!(on, On::Lanelet | On::Area) || list.names.iter().any(|name| Some(name.as_str()) == kind)
        };
        let here: Vec<&Types> = self.lists(on).filter(of).collect();
        let is_paint =
            matches!(on, On::LineString) && (here.is_empty() || here.iter().any(|list| list.subtypes.is_none()));
        let paint = self.paint.words.iter().filter(|_| is_paint);
        let words =
            || here.iter().flat_map(|list| list.subtypes.iter().flatten()).chain(paint.clone()).map(String::as_str);
        if words().any(|word| word == value) {
            return None;
        }
        // Of other words for roads, and of parts, the rule of what Autoware drives on tells all.
        let is_lane = matches!(on, On::Lanelet | On::Area);
        let meaning = meanings.of(value, words()).filter(|meant| !is_lane || *meant != "road");
        let meant = meaning.or_else(|| misspelt(value, words()));
        if is_lane {
            return meant;
        }
        let without = is_paint.then(|| meanings.without_idle(value)).flatten();
        meant
            .or_else(|| rearranged(value, words()))
            .or_else(|| words().find(|word| without.as_deref() == Some(word)))
            .or_else(|| meanings.of(without.as_deref()?, words()))
            .or_else(|| meanings.initials(value, words()))
    }
}
