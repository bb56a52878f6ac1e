//! Findings of one code and one cause as one entry, and in which order people are told of them.

use std::cmp::Reverse;
use std::iter::Peekable;
use std::str::CharIndices;

use rustc_hash::FxHashMap;

use super::split_code;
use crate::diagnostic::Severity;
use crate::requirement::Requirement;

/// The chapter of what is wrong with the file itself: as long as it does not load as drawn, the rest says little.
const FILE: &str = "map health: the file";

/// Its rules, causes before what follows from them: under a wrong projector nodes lie elsewhere, and what nodes lie elsewhere or are
/// taken for others does not load as drawn.
const CAUSES: [&str; 4] = ["projector", "ids", "node", "load"];

/// Stands for numbers that differ from finding to finding.
const MANY: &str = "…";

/// Findings that are alike: of one severity and one code, with one message but for its numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// Of all of them.
    pub severity: Severity,
    /// Of all of them.
    pub code: String,
    /// The message, with `…` for numbers that differ.
    pub sentence: String,
    /// Which findings of the run, in its order; at least one.
    pub members: Vec<usize>,
}

/// Groups findings, each given by severity, code and message: the worst first; of one severity, what is wrong with the file
/// itself before the rest, causes before what follows from them, then the rules with most findings, of a rule the codes with most, then the groups with most. Ties are
/// in the order of the run.
pub fn groups<'a>(
    findings: impl IntoIterator<Item = (Severity, &'a str, &'a str)>,
    requirements: &[&Requirement],
) -> Vec<Group> {
    let mut seen: FxHashMap<(Severity, &str, Vec<&str>), Alike<'_>> = FxHashMap::default();
    let mut of_code: FxHashMap<(Severity, &str), (usize, usize)> = FxHashMap::default();
    let mut of_rule = of_code.clone();
    for (at, (severity, code, message)) in findings.into_iter().enumerate() {
        let (words, numbers) = pieces(message);
        let alike = seen.entry((severity, code, words));
        alike.or_insert_with(|| Alike { numbers: numbers.clone(), members: Vec::new() }).add(at, &numbers);
        of_code.entry((severity, code)).or_insert((0, at)).0 += 1;
        of_rule.entry((severity, split_code(code).0)).or_insert((0, at)).0 += 1;
    }
    let in_file = |code: &str| {
        let rule = split_code(code).0;
        requirements.iter().any(|one| one.id == rule && one.category == FILE)
    };
    let mut groups: Vec<_> = seen.into_iter().collect();
    groups.sort_by_cached_key(|((severity, code, _), Alike { members, .. })| {
        let most = |(count, first): (usize, usize)| (Reverse(count), first);
        let (rule, code_rank) = (of_rule[&(*severity, split_code(code).0)], of_code[&(*severity, *code)]);
        let cause = CAUSES.iter().position(|rule| in_file(code) && *rule == split_code(code).0);
        let cause = cause.unwrap_or(CAUSES.len());
        let rank = (Reverse(*severity), !in_file(code), cause, most(rule), most(code_rank));
        (rank, Reverse(members.len()), members[0])
    });
    let group = |((severity, code, words), alike): ((_, &str, Vec<&str>), Alike<'_>)| Group {
        severity,
        code: code.to_owned(),
        sentence: alike.sentence(&words),
        members: alike.members,
    };
    groups.into_iter().map(group).collect()
}

/// A group that grows.
struct Alike<'a> {
    /// Between the words; [`MANY`] where they differ.
    numbers: Vec<&'a str>,
    members: Vec<usize>,
}

impl<'a> Alike<'a> {
    fn add(&mut self, at: usize, numbers: &[&'a str]) {
        self.members.push(at);
        for (known, number) in self.numbers.iter_mut().zip(numbers) {
            if known != number {
                *known = MANY;
            }
        }
    }

    fn sentence(&self, words: &[&str]) -> String {
        let numbers = self.numbers.iter().copied().chain([""]);
        words.iter().zip(numbers).flat_map(|(words, number)| [*words, number]).collect()
    }
}

/// A message cut at its numbers: the words, and between each two of them a number, or several in a row. Digits inside a word,
/// such as those of `vm-03-08` or `m2`, belong to the word.
fn pieces(message: &str) -> (Vec<&str>, Vec<&str>) {
    let (mut words, mut numbers) = (Vec::new(), Vec::new());
    let (mut from, mut before) = (0, ' ');
    let mut chars = message.char_indices().peekable();
    while let Some((at, c)) = chars.next() {
        let in_word = before.is_alphanumeric() || matches!(before, '-' | '_');
        before = c;
        let signed = c == '-' && chars.peek().is_some_and(|(_, next)| next.is_ascii_digit());
        if in_word || !(c.is_ascii_digit() || signed) {
            continue;
        }
        let end = end_of_numbers(message, &mut chars);
        words.push(&message[from..at]);
        numbers.push(&message[at..end]);
        (from, before) = (end, '0');
    }
    words.push(&message[from..]);
    (words, numbers)
}

/// Reads on to the end of a number, and of those that follow it behind commas.
fn end_of_numbers(message: &str, chars: &mut Peekable<CharIndices<'_>>) -> usize {
    loop {
        let at = chars.peek().map_or(message.len(), |&(at, _)| at);
        let rest = &message[at..];
        let goes_on = |between: &str| {
            let behind = rest.strip_prefix(between).map(|behind| behind.strip_prefix('-').unwrap_or(behind));
            behind.is_some_and(|behind| behind.starts_with(|c: char| c.is_ascii_digit()))
        };
        let skip = ["", ".", ",", ", "].into_iter().find(|between| goes_on(between));
        let Some(between) = skip else { return at };
        for _ in 0..=between.len() {
            chars.next();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_taken_out_of_messages() {
        for (message, words, numbers) in [
            ("Lane 12 ends.", &["Lane ", " ends."][..], &["12"][..]),
            ("Lanes -3,45, 6 and 7", &["Lanes ", " and ", ""], &["-3,45, 6", "7"]),
            ("over 12.3 m2, vm-03-08", &["over ", " m2, vm-03-08"], &["12.3"]),
            ("7.", &["", "."], &["7"]),
            ("at 1, 2.5. 停3", &["at ", ". 停3"], &["1, 2.5"]),
            ("30deg 4%", &["", "deg ", "%"], &["30", "4"]),
            ("", &[""], &[]),
        ] {
            assert_eq!(pieces(message), (words.to_vec(), numbers.to_vec()), "{message}");
        }
    }

    #[test]
    fn what_differs_only_in_numbers_is_one_group() {
        use Severity::{Error, Info, Warning};
        let found = [
            (Info, "a/a", "Lane 1 is 2 m wide."),
            (Warning, "a/b", "Lane 7 is 3 m wide."),
            (Error, "a/b", "Lane 1 is 3 m wide."),
            (Error, "a/c", "Lane 5 is 3 m long."),
            (Error, "a/c", "Lane 6 is 3 m long."),
            (Error, "a/c", "Road 6 is 3 m long."),
        ];
        let told: Vec<_> = groups(found, &[]).into_iter().map(|one| (one.sentence, one.members)).collect();
        let expected = [
            ("Lane … is 3 m long.", vec![3, 4]),
            ("Road 6 is 3 m long.", vec![5]),
            ("Lane 1 is 3 m wide.", vec![2]),
            ("Lane 7 is 3 m wide.", vec![1]),
            ("Lane 1 is 2 m wide.", vec![0]),
        ];
        assert_eq!(told, expected.map(|(sentence, members)| (sentence.to_owned(), members)));
    }

    #[test]
    fn the_codes_of_a_rule_stay_together() {
        let found = ["a/few", "b/many", "b/many", "a/most", "a/most", "a/most", "c/one"];
        let found = found.map(|code| (Severity::Warning, code, "It is wrong."));
        let told: Vec<String> = groups(found, &[]).into_iter().map(|one| one.code).collect();
        assert_eq!(told, ["a/most", "a/few", "b/many", "c/one"]);
    }
}
