//! Fixes that bring more warnings than they mend errors: they are listed, and made only if somebody asks for it.

use rustc_hash::FxHashMap;

use super::fixes_by_place::{ByPlace, keys};
use super::proposal::Attempt;
use crate::diagnostic::{Diagnostic, Severity};

/// The unsafe fixes of a batch after which there are more warnings about what they change than errors fewer, each with the reason.
pub fn of(before: &[Diagnostic], attempt: &Attempt) -> Vec<(usize, String)> {
    if attempt.done.iter().all(|one| one.fix.safe) {
        return Vec::new();
    }
    let fixes = ByPlace::of(&attempt.done);
    let (mut balance, mut first): (FxHashMap<usize, i64>, FxHashMap<usize, &Diagnostic>) = Default::default();
    let come = missing_in(before, &attempt.left);
    let gone = missing_in(&attempt.left, before);
    for one in come.iter().filter(|one| one.severity == Severity::Warning) {
        for at in fixes.about_any(&keys(one).collect::<Vec<_>>()) {
            *balance.entry(at).or_default() += 1;
            first.entry(at).or_insert(one);
        }
    }
    for one in gone.iter().filter(|one| one.severity > Severity::Info) {
        for at in fixes.about_any(&keys(one).collect::<Vec<_>>()) {
            *balance.entry(at).or_default() -= 1;
        }
    }
    let worse = first.into_iter().filter_map(|(at, first)| {
        let more = balance.get(&at).copied().filter(|&more| more > 0)?;
        attempt.done.get(at).filter(|one| !one.fix.safe)?;
        let (code, message) = (&first.code, &first.finding.message);
        let reason =
            format!("it brings {more} more warnings than it mends, --allow-warnings makes it; {code}: {message}");
        Some((at, reason))
    });
    let mut worse: Vec<(usize, String)> = worse.collect();
    worse.sort_unstable();
    worse
}

/// The findings of one list of which the other has fewer, by code, subject and message.
fn missing_in<'a>(known: &[Diagnostic], found: &'a [Diagnostic]) -> Vec<&'a Diagnostic> {
    let key = |one: &Diagnostic| (one.code.clone(), one.finding.subject, one.finding.message.clone());
    let mut counts: FxHashMap<_, usize> = FxHashMap::default();
    for one in known {
        *counts.entry(key(one)).or_default() += 1;
    }
    let is_new = |one: &&Diagnostic| match counts.get_mut(&key(one)) {
        Some(count) if *count > 0 => {
            *count -= 1;
            false
        }
        _ => true,
    };
    found.iter().filter(is_new).collect()
}
