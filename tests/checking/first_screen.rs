//! What people are shown of a check: every code, every count, the worst first, and no more than fits.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lanewright::diagnostic::{Diagnostic, Finding, Severity, Subject};
use lanewright::lanelet::LaneletMap;
use lanewright::report::{Next, Report, Sources, TextStyle, summary, text};
use lanewright::requirement::Requirement;
use lanewright::rules;
use proptest::prelude::*;

use crate::common::judging::{beside, judge_as, load};
use crate::common::needs::shared;
use crate::common::root;

const NEXT: Next<'_> = Next { map: "my map", fixable: true, page: None };

type Counts = BTreeMap<(Severity, String), usize>;

fn shown(diagnostics: &[Diagnostic], show: Severity) -> String {
    let (sources, map) = (Sources::new([]), LaneletMap::default());
    let requirements: Vec<&Requirement> = rules::table().unwrap().iter().map(|row| &row.requirement).collect();
    let report = Report { show, requirements: &requirements, ..Report::new(diagnostics, &sources, &map) };
    let mut out = Vec::new();
    text(&mut out, &report, &NEXT, TextStyle::default()).unwrap();
    String::from_utf8(out).unwrap()
}

fn severity(word: &str) -> Option<Severity> {
    [Severity::Error, Severity::Warning, Severity::Info].into_iter().find(|one| one.to_string() == word)
}

/// What a line speaks of, and of how many: the first line of an entry, or one of those that only count. A message may contain "] ".
fn told(line: &str) -> Option<((Severity, String), usize)> {
    if told_in_full(line) {
        let (head, rest) = line.split_once("] ")?;
        let (word, code) = head.split_once('[')?;
        let count = rest.split_once(' ').and_then(|(count, rest)| {
            (rest.starts_with("× ") || rest == "more that say something else").then(|| count.parse().unwrap())
        });
        return Some(((severity(word)?, code.to_owned()), count.unwrap_or(1)));
    }
    let mut words = line.split_whitespace();
    let (count, word, code) = (words.next()?.parse().ok()?, words.next()?, words.next()?);
    Some(((severity(word)?, code.to_owned()), count))
}

/// How many findings are counted under the one that they follow from: `so: 1 error, 2 infos more follow from this`.
fn counted_below(text: &str) -> usize {
    let lines = text.lines().filter_map(|line| line.strip_prefix("  so: ")?.split_once(" more follow"));
    let counts = lines.flat_map(|(counts, _)| counts.split(", "));
    counts.filter_map(|count| count.split(' ').next()?.parse::<usize>().ok()).sum()
}

/// All that was found is told with its number, or counted under what it follows from, nothing else is, and the worst is told first.
fn holds(diagnostics: &[Diagnostic], show: Severity) {
    let text = shown(diagnostics, show);
    let mut expected = Counts::new();
    for one in diagnostics {
        *expected.entry((one.severity, one.code.clone())).or_default() += 1;
    }
    let mut counts = Counts::new();
    let lines: Vec<_> = text.lines().filter_map(told).collect();
    for (what, count) in &lines {
        *counts.entry(what.clone()).or_default() += count;
    }
    let below = counted_below(&text);
    assert!(counts.iter().all(|(what, count)| expected.get(what) >= Some(count)), "{text}");
    assert_eq!(counts.values().sum::<usize>() + below, diagnostics.len(), "{text}");
    assert!(below > 0 || counts == expected, "{text}");
    let severities: Vec<Severity> = lines.iter().map(|((severity, _), _)| *severity).collect();
    assert!(severities.is_sorted_by(|one, next| one >= next), "{text}");
    let entries = text.lines().filter(|line| told_in_full(line));
    assert!(entries.clone().all(|line| told(line).unwrap().0.0 >= show), "{text}");
    assert!(text.contains(&summary(diagnostics)), "{text}");
    assert_eq!(text, shown(diagnostics, show));
}

fn told_in_full(line: &str) -> bool {
    ["error[", "warning[", "info["].iter().any(|word| line.starts_with(word))
}

fn files(folder: PathBuf) -> Vec<PathBuf> {
    let mut files: Vec<_> = folder.read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|ending| ending == "osm"));
    files.sort();
    files
}

fn judged(path: &Path) -> Vec<Diagnostic> {
    let (_, loaded) = load(path);
    let (settings, config) = beside(path);
    judge_as(&loaded, &settings, &config)
}

#[test]
fn every_code_and_every_count_is_told() {
    let mut folders: Vec<_> =
        root().join("tests/rules").read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
    folders.sort();
    let mut maps: Vec<PathBuf> = folders.into_iter().filter(|path| path.is_dir()).flat_map(files).collect();
    maps.extend(["corpus/lanelet2", "corpus/lanelet2_more"].into_iter().filter_map(shared).flat_map(files));
    assert!(maps.len() > 300, "{}", maps.len());
    let mut all = Vec::new();
    for map in &maps {
        let found = judged(map);
        for show in [Severity::Error, Severity::Warning, Severity::Info] {
            holds(&found, show);
        }
        all.extend(found);
    }
    holds(&all, Severity::Warning);
}

#[test]
fn a_map_drawn_by_hand_is_told_in_its_first_screen() {
    let Some(map) = shared("corpus/lanelet2_more/scenario_simulator_borregas.osm") else { return };
    let found = judged(&map);
    let (errors, others) = (found.iter()).fold((0, 0), |(errors, others), one| match one.severity {
        Severity::Error => (errors + 1, others),
        _ => (errors, others + 1),
    });
    assert!(errors > 90 && others > 60);
    let text = shown(&found, Severity::Warning);
    let screen: Vec<&str> = text.lines().take(40).collect();
    let told: usize =
        screen.iter().filter_map(|line| told(line)).filter(|(what, _)| what.0 == Severity::Error).map(|(_, n)| n).sum();
    assert_eq!(told, errors, "{text}");
    assert!(screen[0].starts_with("my map: 93 errors"), "{text}");
    assert!(screen.iter().filter(|line| line.starts_with("  help: ")).count() >= 5, "{text}");
    let last: Vec<&str> = text.lines().rev().take(6).collect();
    for aim in ["lanewright explain vm-01-01/location", "lanewright fix 'my map'", "--report", "--format concise"] {
        assert!(last.iter().any(|line| line.contains(aim)), "{aim} is not told:\n{text}");
    }
}

#[test]
fn what_keeps_the_file_from_loading_comes_first() {
    let diagnostic = |code: &str, severity, message: String| Diagnostic {
        code: code.to_owned(),
        severity,
        finding: Finding::new("fault", Subject::Lanelet(1), message),
        help: None,
        span: None,
        lonlat: None,
        local: None,
    };
    let mut found: Vec<Diagnostic> = (0..50)
        .map(|n| diagnostic("vm-01-01/location", Severity::Error, format!("Lanelet {n} has no location.")))
        .collect();
    found.push(diagnostic(
        "load/missing-ref",
        Severity::Error,
        "Way 5 refers to node 7, which does not exist.".to_owned(),
    ));
    found.push(diagnostic("load/format-version", Severity::Warning, "none".to_owned()));
    let text = shown(&found, Severity::Warning);
    let heads: Vec<&str> = text.lines().filter(|line| told_in_full(line)).collect();
    assert_eq!(
        heads,
        [
            "error[load/missing-ref] Way 5 refers to node 7, which does not exist.",
            "error[vm-01-01/location] 50 × Lanelet … has no location.",
            "warning[load/format-version] none",
        ]
    );
}

fn any_severity() -> impl Strategy<Value = Severity> {
    prop_oneof![Just(Severity::Error), Just(Severity::Warning), Just(Severity::Info)]
}

fn any_diagnostic() -> impl Strategy<Value = Diagnostic> {
    let message = prop_oneof!["Lane [0-9]{1,3} is [ab]", "[0-9]{1,2}, -[0-9] and [0-9]\\.[0-9]m", "\\PC{0,12}"];
    (any_severity(), prop_oneof!["load/[ab]", "vm-03-0[1-3]/[a-c]"], message, any::<i64>()).prop_map(
        |(severity, code, message, id)| Diagnostic {
            code,
            severity,
            finding: Finding::new("fault", Subject::Way(id), format!("It says {message}")),
            help: None,
            span: None,
            lonlat: None,
            local: None,
        },
    )
}

proptest! {
    #[test]
    fn whatever_is_found_is_told_with_its_number(
        found in proptest::collection::vec(any_diagnostic(), 0..60),
        show in any_severity(),
    ) {
        holds(&found, show);
    }
}
