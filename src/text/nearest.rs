//! What somebody meant who misspelt a word.

/// The word most like `said`; `None` if none is like it. A third of its letters may be wrong, capitals do not count.
pub fn nearest<'a>(said: &str, words: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = (said.chars().count() / 3).max(1);
    let said = said.to_lowercase();
    let near =
        words.into_iter().map(|word| (distance(&said, &word.to_lowercase()), word)).filter(|&(far, _)| far <= limit);
    near.min_by_key(|&(far, _)| far).map(|(_, word)| word)
}

/// The word that was meant where `said` is a slip of the pen: a letter too many, missing, wrong, or two exchanged. In long words
/// two slips, in very long ones three; capitals do not count. Stricter than [`nearest`], for words that may as well be right.
pub fn misspelt<'a>(said: &str, words: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let letters = |word: &str| word.to_lowercase().chars().collect::<Vec<char>>();
    let said = letters(said);
    let limit = match said.len() {
        0..8 => 1,
        8..12 => 2,
        _ => 3,
    };
    let slips = words.into_iter().filter_map(|word| Some((slips(&said, &letters(word), limit)?, word)));
    slips.min_by_key(|&(far, _)| far).map(|(_, word)| word)
}

/// Slips from one word to the other (optimal string alignment), unless they are more than a limit.
fn slips(a: &[char], b: &[char], limit: usize) -> Option<usize> {
    if a.len().abs_diff(b.len()) > limit {
        return None;
    }
    let mut rows = [Vec::new(), Vec::new(), (0..=b.len()).collect::<Vec<usize>>()];
    for (i, x) in a.iter().enumerate() {
        rows.rotate_left(1);
        let [earlier, above, row] = &mut rows;
        row.clear();
        row.push(i + 1);
        for (j, y) in b.iter().enumerate() {
            let near = |row: &[usize], at: usize| row.get(at).copied().unwrap_or(usize::MAX - 1);
            let one = near(above, j + 1).min(near(row, j)) + 1;
            let mut best = one.min(near(above, j) + usize::from(x != y));
            if i > 0 && j > 0 && a.get(i - 1) == Some(y) && b.get(j - 1) == Some(x) {
                best = best.min(near(earlier, j - 1) + 1);
            }
            row.push(best);
        }
    }
    rows[2].last().copied().filter(|far| *far <= limit)
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
    fn slips_of_the_pen_are_told_from_other_words() {
        let types = ["road_border", "line_thin", "curbstone", "wall", "rail"];
        for (said, meant) in [
            ("road_boarder", Some("road_border")),
            ("lin_thin", Some("line_thin")),
            ("Line_Thin", Some("line_thin")),
            ("curbestone", Some("curbstone")),
            ("wlal", Some("wall")),
            ("tram", None),
            ("hall_way", None),
            ("", None),
        ] {
            assert_eq!(misspelt(said, types), meant, "{said}");
        }
        assert_eq!(
            misspelt("no_obstacle_segmentaton_aera", ["no_obstacle_segmentation_area"]),
            Some("no_obstacle_segmentation_area")
        );
    }

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
