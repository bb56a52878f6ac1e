//! Lists of which both sides changed something.

use std::hash::Hash;
use std::ops::Range;

use imara_diff::{Algorithm, Diff, InternedInput, Interner};

/// Where a list differs from the one before: what stood there, and what stands there.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Hunk<T> {
    old: Range<usize>,
    new: Vec<T>,
}

/// The changes of both sides in one list; `None` where they contradict each other. Of what both insert at one place, `in_order` tells
/// the order, if it can: it is given what stands before, both, and what stands behind.
pub(super) fn merged<T: Hash + Eq + Copy>(
    base: &[T],
    ours: &[T],
    theirs: &[T],
    in_order: impl Fn(Option<T>, [&[T]; 2], Option<T>) -> Option<Vec<T>>,
) -> Option<Vec<T>> {
    let (our_hunks, their_hunks) = (hunks(base, ours), hunks(base, theirs));
    let (mut own, mut others) = (our_hunks.iter().peekable(), their_hunks.iter().peekable());
    let mut list = Vec::with_capacity(ours.len() + theirs.len());
    let mut at = 0;
    loop {
        let (old, new) = match (own.peek(), others.peek()) {
            (None, None) => break,
            (Some(one), Some(other)) if one == other => {
                let one = (*one).clone();
                own.next();
                others.next();
                (one.old, one.new)
            }
            (Some(one), Some(other)) if one.old.is_empty() && one.old == other.old => {
                let place = one.old.clone();
                let before = place.start.checked_sub(1).and_then(|at| base.get(at).copied());
                let new = in_order(before, [&one.new, &other.new], base.get(place.end).copied())?;
                own.next();
                others.next();
                (place, new)
            }
            (Some(one), Some(other)) if overlap(&one.old, &other.old) => return None,
            (Some(one), Some(other)) => {
                let first = (one.old.start, one.old.end) <= (other.old.start, other.old.end);
                let next = if first { own.next() } else { others.next() }?;
                (next.old.clone(), next.new.clone())
            }
            _ => {
                let next = own.next().or_else(|| others.next())?;
                (next.old.clone(), next.new.clone())
            }
        };
        list.extend_from_slice(base.get(at..old.start)?);
        list.extend(new);
        at = old.end;
    }
    list.extend_from_slice(base.get(at..)?);
    Some(list)
}

/// Whether two changes touch the same. What is inserted right before or behind a change does not.
fn overlap(a: &Range<usize>, b: &Range<usize>) -> bool {
    a.start < b.end && b.start < a.end
}

fn hunks<T: Hash + Eq + Copy>(old: &[T], new: &[T]) -> Vec<Hunk<T>> {
    let mut input = InternedInput { before: Vec::new(), after: Vec::new(), interner: Interner::new(old.len()) };
    input.update_before(old.iter().copied());
    input.update_after(new.iter().copied());
    let diff = Diff::compute(Algorithm::MyersMinimal, &input);
    let range = |range: Range<u32>| range.start as usize..range.end as usize;
    diff.hunks()
        .map(|hunk| Hunk { old: range(hunk.before), new: new.get(range(hunk.after)).unwrap_or_default().to_vec() })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(base: &str, ours: &str, theirs: &str) -> Option<String> {
        let letters = |text: &str| text.chars().collect::<Vec<char>>();
        let by_letter = |_: Option<char>, [a, b]: [&[char]; 2], _: Option<char>| {
            let mut both = [a, b].concat();
            both.sort_unstable();
            Some(both).filter(|both| !both.contains(&'?'))
        };
        Some(merged(&letters(base), &letters(ours), &letters(theirs), by_letter)?.into_iter().collect())
    }

    #[test]
    fn both_changes_are_made() {
        assert_eq!(of("abcdef", "aXbcdef", "abcdeYf").unwrap(), "aXbcdeYf");
        assert_eq!(of("abcdef", "acdef", "abcdf").unwrap(), "acdf");
        assert_eq!(of("abc", "aXc", "aXc").unwrap(), "aXc");
        assert_eq!(of("abc", "abc", "").unwrap(), "");
        assert_eq!(of("", "ab", "").unwrap(), "ab");
    }

    #[test]
    fn what_is_inserted_beside_a_change_is_none_of_its_business() {
        assert_eq!(of("abc", "aXbc", "ac").unwrap(), "aXc");
        assert_eq!(of("abc", "abXc", "aYc").unwrap(), "aYXc");
        assert_eq!(of("abc", "aXbc", "aYc").unwrap(), "aXYc");
    }

    #[test]
    fn of_two_insertions_at_one_place_the_order_is_asked() {
        assert_eq!(of("ab", "aYb", "aXb").unwrap(), "aXYb");
        assert_eq!(of("ab", "a?b", "aXb"), None);
    }

    #[test]
    fn what_contradicts_is_not_merged() {
        assert_eq!(of("abc", "aXc", "aYc"), None);
        assert_eq!(of("abcd", "dcba", "abXcd"), None);
        assert_eq!(of("abcd", "ad", "abXcd"), None);
    }
}
