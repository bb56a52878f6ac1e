//! Short strings, and places in files.

mod nearest;
mod unified_diff;

pub use nearest::{misspelt, nearest, rearranged};
pub use unified_diff::unified_diff;

/// A short string: keys, values, roles. Up to 24 bytes are stored inline.
pub type Text = compact_str::CompactString;

/// A place in a source file.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct SourceSpan {
    /// Which of the map's files, by its index in `OsmData::sources`.
    pub file: u32,
    /// Byte offset of the element's `<`.
    pub start: u64,
    /// Byte offset behind the element's last `>`.
    pub end: u64,
}

/// A number of things with the word for one: `1 lanelet`, `2 lanelets`.
pub fn counted(count: usize, one: &str) -> String {
    let s = if count == 1 { "" } else { "s" };
    format!("{count} {one}{s}")
}

/// A sentence with `…` for each number in it, so that sentences of one kind are the same.
pub fn without_numbers(sentence: &str) -> String {
    let is_number = |word: &&str| word.chars().any(|c| c.is_ascii_digit()) && word.parse::<f64>().is_ok();
    let words = sentence.split(' ').map(|word| {
        let bare = word.trim_end_matches([',', ':', ';']);
        let end = word.get(bare.len()..).unwrap_or_default();
        if is_number(&bare) { format!("…{end}") } else { word.to_owned() }
    });
    words.collect::<Vec<_>>().join(" ")
}
