//! What somebody meant who misspelt a word.

/// The word most like `said`; `None` if none is like it. A third of its letters may be wrong, capitals do not count.
pub fn nearest<'a>(said: &str, words: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let letters = said.chars().count();
    let limit = (letters / 3).max(1);
    let said = said.to_lowercase();
    // Words of other lengths are further than that, and a file may hold one of any length.
    let alike = words.into_iter().filter(|word| word.chars().count().abs_diff(letters) <= limit);
    let near = alike.map(|word| (distance(&said, &word.to_lowercase()), word)).filter(|&(far, _)| far <= limit);
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

/// The compound word that was meant by its parts in another order (`thin_line`), by a part that no other word has (`zebra`), or by its
/// beginning (`dash`); `None` where several could be.
pub fn rearranged<'a>(said: &str, words: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    const SHORTEST: usize = 4;
    const MISSING: usize = 3;
    let parts = |word: &str| {
        let lower = word.to_lowercase();
        let mut parts: Vec<String> =
            lower.split(['_', '-', ' ', ':']).filter(|part| !part.is_empty()).map(str::to_owned).collect();
        parts.sort_unstable();
        parts
    };
    let (of_said, lower) = (parts(said), said.to_lowercase());
    if lower.chars().count() < SHORTEST {
        return None;
    }
    let words: Vec<(&str, Vec<String>)> = words.into_iter().map(|word| (word, parts(word))).collect();
    let only = |is_meant: &dyn Fn(&str, &[String]) -> bool| {
        let mut meant: Vec<&str> =
            words.iter().filter(|(word, of)| is_meant(word, of)).map(|(word, _)| *word).collect();
        meant.dedup();
        meant.first().copied().filter(|_| meant.len() == 1)
    };
    let is_one = of_said.len() == 1;
    only(&|_, of| of.len() > 1 && of == of_said)
        .or_else(|| only(&|_, of| is_one && of.len() > 1 && of.contains(&lower)))
        .or_else(|| only(&|word, of| of.len() == 1 && word.starts_with(&lower) && word.len() - lower.len() <= MISSING))
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
    fn parts_of_compound_words_are_known() {
        let words = ["line_thin", "line_thick", "road_border", "zebra_marking", "bike_marking", "dashed", "solid"];
        for (said, meant) in [
            ("thin_line", Some("line_thin")),
            ("thick-line", Some("line_thick")),
            ("Border", Some("road_border")),
            ("zebra", Some("zebra_marking")),
            ("dash", Some("dashed")),
            ("marking", None),
            ("line", None),
            ("so", None),
            ("roads_border_line", None),
        ] {
            assert_eq!(rearranged(said, words), meant, "{said}");
        }
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
