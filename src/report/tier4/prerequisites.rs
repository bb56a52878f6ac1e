//! Validators that need others to have passed.

use std::collections::BTreeMap;

use super::Issue;
use super::set::Prerequisites;
use crate::diagnostic::Severity;

/// What a validator came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Verdict {
    worst: Option<Severity>,
}

impl Verdict {
    pub(super) fn of(issues: &[Issue]) -> Self {
        Self { worst: issues.iter().map(|issue| issue.severity).max() }
    }

    /// Infos do not fail.
    pub(super) fn passed(self) -> bool {
        self.worst.is_none_or(|worst| worst == Severity::Info)
    }

    /// Whether those that need it may run.
    fn lets_on(self, forgiving: bool) -> bool {
        self.passed() || (forgiving && self.worst == Some(Severity::Warning))
    }
}

/// Replaces the issues of validators whose prerequisites failed, are not there, or need each other in a circle.
pub(super) fn apply<'a>(all: &Prerequisites<'a>, found: &mut BTreeMap<&'a str, Vec<Issue>>) {
    let mut open: Vec<usize> = (0..all.len()).collect();
    let mut settled: Vec<&str> = Vec::new();
    // Each round settles those that need only what is settled; what is left needs itself or what nobody has.
    loop {
        let (ready, rest): (Vec<usize>, Vec<usize>) =
            open.iter().partition(|&&at| all[at].1.iter().all(|(needed, _)| settled.contains(needed)));
        if ready.is_empty() {
            break;
        }
        for at in ready {
            let (name, needed) = &all[at];
            let verdict = |name: &str| Verdict::of(found.get(name).map_or(&[], Vec::as_slice));
            if !needed.iter().all(|&(other, forgiving)| verdict(other).lets_on(forgiving)) {
                let names: Vec<&str> = needed.iter().map(|(other, _)| *other).collect();
                let message = format!("{name} was not run, since it needs {} to pass.", names.join(", "));
                found.insert(name, vec![Issue::general("General.PrerequisitesFailure-001", message)]);
            }
            settled.push(name);
        }
        open = rest;
    }
    for at in open {
        let name = all[at].0;
        let message = format!("{name} was not run: what it needs is not in the set, or needs it in turn.");
        found.insert(name, vec![Issue::general("General.InvalidPrerequisites-001", message)]);
    }
}
