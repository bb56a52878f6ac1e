//! Key-value pairs of an element, in file order.

use serde::{Deserialize, Serialize};
use thin_vec::ThinVec;

/// Tags of one element, as a list, since there are few. Where a key repeats, the last value wins, as in Lanelet2's reader. All
/// keys and values are in one allocation, because a map has more tags than anything else.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tags(ThinVec<u8>);

impl Tags {
    /// No tags.
    pub const fn new() -> Self {
        Self(ThinVec::new())
    }

    /// From pairs of key and value.
    pub fn of(pairs: &[(&str, &str)]) -> Self {
        pairs.iter().copied().collect()
    }

    /// No tags, with room for this many bytes of keys and values.
    pub fn with_room(bytes: usize) -> Self {
        Self(ThinVec::with_capacity(bytes))
    }

    /// A copy with room for this many more bytes.
    #[must_use]
    pub fn with_more_room(&self, bytes: usize) -> Self {
        let mut tags = self.clone();
        tags.0.reserve_exact(bytes);
        tags
    }

    fn pairs(&self) -> Pairs<'_> {
        Pairs(&self.0)
    }

    /// The value of the last key for which this holds.
    fn last(&self, is_key: impl Fn(&[u8]) -> bool) -> Option<&str> {
        self.pairs().filter(|(key, _)| is_key(key)).last().map(|(_, value)| text(value))
    }

    /// The value of `key` where it stands first.
    pub fn first(&self, key: &str) -> Option<&str> {
        self.pairs().find(|(k, _)| *k == key.as_bytes()).map(|(_, value)| text(value))
    }

    /// The value of `key`.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.last(|k| k == key.as_bytes())
    }

    /// The value of the key that is the concatenation of these parts, without an allocation.
    pub fn get_joined<const N: usize>(&self, parts: [&str; N]) -> Option<&str> {
        self.last(|key| {
            let rest = parts.iter().try_fold(key, |rest, part| rest.strip_prefix(part.as_bytes()));
            rest.is_some_and(<[u8]>::is_empty)
        })
    }

    /// Whether `key` has exactly this value.
    pub fn is(&self, key: &str, value: &str) -> bool {
        self.get(key) == Some(value)
    }

    /// Whether `key` is there.
    pub fn has(&self, key: &str) -> bool {
        self.pairs().any(|(k, _)| k == key.as_bytes())
    }

    /// Sets `key`, replacing an earlier value.
    pub fn set(&mut self, key: impl AsRef<str>, value: impl AsRef<str>) {
        let (key, value) = (key.as_ref(), value.as_ref());
        let before = self.pairs().position(|(k, _)| k == key.as_bytes());
        let Some(before) = before else { return self.push(key, value) };
        let pairs = self.iter().enumerate();
        *self = pairs.map(|(i, (key, old))| (key, if i == before { value } else { old })).collect();
    }

    /// Adds a pair as a file says it, without looking for an earlier one.
    pub fn push(&mut self, key: impl AsRef<str>, value: impl AsRef<str>) {
        let words = [key.as_ref(), value.as_ref()];
        self.0.reserve(words.iter().map(|word| word.len() + length_of(word.len()).count()).sum());
        words.iter().for_each(|word| self.0.extend(length_of(word.len())));
        words.iter().for_each(|word| self.0.extend_from_slice(word.as_bytes()));
    }

    /// All pairs in order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.pairs().map(|(key, value)| (text(key), text(value)))
    }

    /// As [`Tags::iter`], but as bytes, for callers that only copy them.
    pub fn words(&self) -> impl Iterator<Item = (&[u8], &[u8])> {
        self.pairs()
    }

    /// The place of a key among the tags of an element in canonical form; keys of one place follow each other by name.
    pub fn rank(key: &[u8]) -> usize {
        const FIRST: [&[u8]; 5] = [b"type", b"subtype", b"local_x", b"local_y", b"ele"];
        FIRST.iter().position(|first| *first == key).unwrap_or(FIRST.len())
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.pairs().count()
    }
}

/// What was pushed is text.
fn text(word: &[u8]) -> &str {
    std::str::from_utf8(word).unwrap_or_default()
}

/// Set in a byte of a length if another one follows.
const MORE: u8 = 0x80;

/// The bytes of a length: seven bits each, the lowest first.
fn length_of(length: usize) -> impl Iterator<Item = u8> {
    let mut rest = Some(length);
    std::iter::from_fn(move || {
        let length = rest?;
        rest = Some(length >> 7).filter(|rest| *rest > 0);
        Some((length & 0x7f) as u8 | if rest.is_some() { MORE } else { 0 })
    })
}

/// A length, and the bytes after it.
fn length_in(bytes: &[u8]) -> Option<(usize, &[u8])> {
    let end = bytes.iter().position(|byte| byte & MORE == 0)?;
    let (length, rest) = bytes.split_at_checked(end + 1)?;
    Some((length.iter().rev().fold(0, |length, byte| length << 7 | usize::from(byte & !MORE)), rest))
}

/// The remaining pairs: each the lengths of key and value, then the key, then the value.
struct Pairs<'a>(&'a [u8]);

impl<'a> Iterator for Pairs<'a> {
    type Item = (&'a [u8], &'a [u8]);

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        let (key, value, rest) = match self.0 {
            // Nearly every length fits one byte.
            [key, value, rest @ ..] if (key | value) & MORE == 0 => (usize::from(*key), usize::from(*value), rest),
            _ => {
                let (key, rest) = length_in(self.0)?;
                let (value, rest) = length_in(rest)?;
                (key, value, rest)
            }
        };
        let (key, rest) = rest.split_at_checked(key)?;
        let (value, rest) = rest.split_at_checked(value)?;
        self.0 = rest;
        Some((key, value))
    }
}

impl<K: AsRef<str>, V: AsRef<str>> FromIterator<(K, V)> for Tags {
    fn from_iter<I: IntoIterator<Item = (K, V)>>(pairs: I) -> Self {
        let mut tags = Self::new();
        pairs.into_iter().for_each(|(key, value)| tags.push(key, value));
        tags
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_are_read_as_they_were_written() {
        let long = "ä".repeat(20_000);
        let mut tags: Tags =
            [("name", long.as_str()), ("", ""), ("oneway", "yes"), ("oneway", "no")].into_iter().collect();
        assert_eq!(tags.iter().last(), Some(("oneway", "no")));
        assert_eq!((tags.get("name"), tags.get("oneway"), tags.get("")), (Some(long.as_str()), Some("no"), Some("")));
        assert_eq!((tags.get_joined(["one", "way"]), tags.get_joined(["on", "way"])), (Some("no"), None));
        tags.set("name", "B 27");
        tags.set("ref", "27");
        assert_eq!((tags.len(), tags.get("name"), tags.iter().last()), (5, Some("B 27"), Some(("ref", "27"))));
        assert!(tags.has("ref") && !tags.has("re") && !tags.is_empty());
    }
}
