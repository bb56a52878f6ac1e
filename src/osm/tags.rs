//! Key-value pairs of an element, in file order.

use thin_vec::ThinVec;

/// A short string: keys, values, roles. Up to 24 bytes lie inline.
pub type Text = compact_str::CompactString;

/// Tags of one element. Few, so a list; the last value wins where a key repeats, as it does for Lanelet2's reader.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tags(ThinVec<(Text, Text)>);

impl Tags {
    /// No tags.
    pub const fn new() -> Self {
        Self(ThinVec::new())
    }

    /// No tags yet, and room for so many.
    pub fn with_room(count: usize) -> Self {
        Self(ThinVec::with_capacity(count))
    }

    /// The value of `key`.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.0.iter().rev().find(|(k, _)| k == key).map(|(_, v)| v.as_str())
    }

    /// The value of the key that these parts make up, one behind the other: nothing is allocated to ask for it.
    pub fn get_joined<const N: usize>(&self, parts: [&str; N]) -> Option<&str> {
        let length: usize = parts.iter().map(|part| part.len()).sum();
        let is_key = |key: &str| {
            key.len() == length && parts.iter().try_fold(key, |rest, part| rest.strip_prefix(part)).is_some()
        };
        self.0.iter().rev().find(|(k, _)| is_key(k)).map(|(_, v)| v.as_str())
    }

    /// Whether `key` has exactly this value.
    pub fn is(&self, key: &str, value: &str) -> bool {
        self.get(key) == Some(value)
    }

    /// Whether `key` is there.
    pub fn has(&self, key: &str) -> bool {
        self.get(key).is_some()
    }

    /// Sets `key`, replacing an earlier value.
    pub fn set(&mut self, key: impl Into<Text>, value: impl Into<Text>) {
        let (key, value) = (key.into(), value.into());
        match self.0.iter_mut().find(|(k, _)| *k == key) {
            Some(pair) => pair.1 = value,
            None => self.0.push((key, value)),
        }
    }

    /// Adds a pair as a file says it, without looking for an earlier one.
    pub fn push(&mut self, key: impl Into<Text>, value: impl Into<Text>) {
        self.0.push((key.into(), value.into()));
    }

    /// All pairs in order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(k, v)| (k.as_str(), v.as_str()))
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.0.len()
    }
}

impl<K: Into<Text>, V: Into<Text>> FromIterator<(K, V)> for Tags {
    fn from_iter<I: IntoIterator<Item = (K, V)>>(pairs: I) -> Self {
        Self(pairs.into_iter().map(|(k, v)| (k.into(), v.into())).collect())
    }
}
