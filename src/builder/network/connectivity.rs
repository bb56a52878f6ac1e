//! Reads the lanes of a relation of `type=connectivity`.

use crate::osm::Tags;

/// The largest number of lanes of a road in one direction.
const MOST: usize = 24;

/// The lanes that lead to each other (from, to), each counted from 1 on the left: `connectivity=1:1|2:2,3`, or the older `from=1`
/// with `to=1`. Lanes in parentheses are left out: vehicles reach them only across a marking.
///
/// # Errors
/// If the tags are malformed, or lanes cross.
pub(super) fn lanes(tags: &Tags) -> Result<Vec<[usize; 2]>, &'static str> {
    let mut lanes = Vec::new();
    match (tags.get("connectivity"), tags.get("from"), tags.get("to")) {
        (Some(text), _, _) => {
            for statement in text.split('|') {
                let (from, to) = statement.split_once(':').ok_or("its lanes are not written as 1:1|2:2,3")?;
                let usual = to.split(',').map(str::trim).filter(|to| !to.starts_with('('));
                for to in usual {
                    lanes.push([number(from)?, number(to)?]);
                }
            }
        }
        (None, Some(from), Some(to)) => lanes.push([number(from)?, number(to)?]),
        _ => return Err("it names no lanes"),
    }
    lanes.sort_unstable();
    lanes.dedup();
    if cross(&lanes) { Err("its lanes would cross each other") } else { Ok(lanes) }
}

/// Whether any of these sorted pairs of lanes cross.
pub(crate) fn cross(lanes: &[[usize; 2]]) -> bool {
    lanes.windows(2).any(|w| w[1][0] > w[0][0] && w[1][1] < w[0][1])
}

fn number(text: &str) -> Result<usize, &'static str> {
    let number = text.trim().parse().ok().filter(|lane| (1..=MOST).contains(lane));
    number.ok_or("its lanes are not numbered from 1 on")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(pairs: &[(&str, &str)]) -> Result<Vec<[usize; 2]>, &'static str> {
        lanes(&pairs.iter().copied().collect())
    }

    #[test]
    fn both_notations_are_read() {
        assert_eq!(of(&[("connectivity", "1:1|2:2,3|3:4,(5)")]), Ok(vec![[1, 1], [2, 2], [2, 3], [3, 4]]));
        assert_eq!(of(&[("connectivity", " 2 : 1 ")]), Ok(vec![[2, 1]]));
        assert_eq!(of(&[("from", "2"), ("to", "1")]), Ok(vec![[2, 1]]));
        // Lanes that become one do not cross.
        assert_eq!(of(&[("connectivity", "1:1|2:1")]), Ok(vec![[1, 1], [2, 1]]));
    }

    #[test]
    fn malformed_tags_are_errors() {
        assert_eq!(of(&[("connectivity", "1:2|2:1")]), Err("its lanes would cross each other"));
        for text in ["", "1", "1:", "0:1", "a:b", "1:99", "1:1|"] {
            assert!(of(&[("connectivity", text)]).is_err(), "{text}");
        }
        assert!(of(&[("from", "1")]).is_err());
    }
}
