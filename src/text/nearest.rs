//! What somebody meant who misspelt a word.

/// The word most like `said`; `None` if none is like it. A third of its letters may be wrong, capitals do not count.
pub fn nearest<'a>(said: &str, words: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = (said.chars().count() / 3).max(1);
    let said = said.to_lowercase();
    let near =
        words.into_iter().map(|word| (distance(&said, &word.to_lowercase()), word)).filter(|&(far, _)| far <= limit);
    near.min_by_key(|&(far, _)| far).map(|(_, word)| word)
}

/// Letters to put in, take out or change to get from one word to the other (Levenshtein).
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    // From what was read of `a` to each begin of `b` that is not empty.
    let mut row: Vec<usize> = (1..=b.len()).collect();
    let mut last = b.len();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = i;
        let mut left = i + 1;
        for (cell, &y) in row.iter_mut().zip(&b) {
            let changed = diagonal + usize::from(x != y);
            diagonal = *cell;
            left = changed.min(diagonal + 1).min(left + 1);
            *cell = left;
        }
        last = left;
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_are_counted() {
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("select", "selct"), 1);
        assert_eq!(nearest("selct", ["ignore", "select", "suppress"]), Some("select"));
        assert_eq!(nearest("vm-3-08", ["vm-03-08", "vm-03-09"]), Some("vm-03-08"));
        assert_eq!(nearest("zebra", ["ignore", "select"]), None);
    }
}
