//! Fixes that bring more warnings than they mend errors: they are listed, and made only if somebody asks for it.

use std::collections::BTreeMap;

use rustc_hash::FxHashMap;

use super::finding_counts::FindingCounts;
use super::fixes_by_place::{ByPlace, keys};
use super::proposal::Attempt;
use crate::diagnostic::{Diagnostic, Fix, Severity};

/// What a fix brings and mends of what it changes. Findings that another fix would mend are not brought.
#[derive(Default)]
struct Balance<'a> {
    warnings_come: i64,
    errors_come: i64,
    warnings_gone: i64,
    errors_gone: i64,
    /// The warnings that come, by code.
    codes: BTreeMap<&'a str, usize>,
}

/// So many codes of warnings are named in a reason.
const NAMED_CODES: usize = 3;

impl Balance<'_> {
    /// How many more warnings it brings than it mends findings.
    fn excess(&self) -> i64 {
        self.warnings_come - self.warnings_gone - self.errors_gone
    }

    /// How many errors it mends more than it brings to light.
    fn errors_fewer(&self) -> i64 {
        self.errors_gone - self.errors_come
    }

    fn reason(&self) -> String {
        let mut codes: Vec<(&str, usize)> = self.codes.iter().map(|(code, count)| (*code, *count)).collect();
        codes.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let named = codes.iter().take(NAMED_CODES).map(|(code, count)| format!("{count} × {code}"));
        let named = named.collect::<Vec<_>>().join(", ");
        let rest = if codes.len() > NAMED_CODES { " and others" } else { "" };
        let more = match self.excess() {
            1 => "1 more warning".to_owned(),
            more => format!("{more} more warnings"),
        };
        format!("it brings {more} than it mends, --allow-warnings makes it: {named}{rest}")
    }
}

/// The unsafe fixes of a batch after which there are more warnings about what they change than errors fewer, each with the reason.
/// Where the map has room for `most` warnings, those that draw areas and mend errors are left out of these, as long as the map has no more.
pub fn of(
    before: &[Diagnostic],
    attempt: &Attempt,
    may: impl Fn(&Fix) -> bool,
    most: Option<usize>,
) -> Vec<(usize, String)> {
    if attempt.done.iter().all(|one| one.fix.safe) {
        return Vec::new();
    }
    let stays = |one: &&Diagnostic| one.severity > Severity::Info && !one.finding.fix.as_ref().is_some_and(&may);
    let is_error = |one: &Diagnostic| one.severity == Severity::Error;
    let fixes = ByPlace::of(&attempt.done);
    let mut balances: FxHashMap<usize, Balance> = FxHashMap::default();
    let come = FindingCounts::of(before).renumbered(&attempt.renumbered).exceeded_by(&attempt.left);
    for one in come.into_iter().filter(stays) {
        for at in fixes.about_any(&keys(one).collect::<Vec<_>>()) {
            let balance = balances.entry(at).or_default();
            match is_error(one) {
                true => balance.errors_come += 1,
                false => {
                    balance.warnings_come += 1;
                    *balance.codes.entry(&one.code).or_default() += 1;
                }
            }
        }
    }
    let gone = FindingCounts::of(&attempt.left).exceeded_by(before);
    for one in gone.into_iter().filter(|one| one.severity > Severity::Info) {
        for at in fixes.about_any(&keys(one).collect::<Vec<_>>()) {
            let balance = balances.entry(at).or_default();
            match is_error(one) {
                true => balance.errors_gone += 1,
                false => balance.warnings_gone += 1,
            }
        }
    }
    balances.retain(|&at, one| one.excess() > 0 && attempt.done.get(at).is_some_and(|fix| !fix.fix.safe));
    let mut heavy: Vec<(usize, Balance)> = balances.into_iter().collect();
    // Those that cost most for what they mend go first.
    heavy.sort_unstable_by(|(a, x), (b, y)| {
        let [of_x, of_y] = [x.excess() * y.errors_fewer().max(1), y.excess() * x.errors_fewer().max(1)];
        of_y.cmp(&of_x).then(a.cmp(b))
    });
    if let Some(most) = most {
        let warnings = attempt.left.iter().filter(|one| stays(one) && !is_error(one)).count();
        let mut over = i64::try_from(warnings).unwrap_or(i64::MAX) - i64::try_from(most).unwrap_or(i64::MAX);
        heavy.retain(|(at, one)| {
            let may_stay = attempt.done.get(*at).is_some_and(|fix| fix.draws_area()) && one.errors_fewer() > 0;
            let stays = may_stay && over <= 0;
            if !stays {
                over -= one.excess() + one.errors_gone;
            }
            !stays
        });
    }
    heavy.sort_unstable_by_key(|(at, _)| *at);
    heavy.into_iter().map(|(at, one)| (at, one.reason())).collect()
}
