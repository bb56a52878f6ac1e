//! The maps of `tests/rules`: good maps have no findings, bad maps have the findings that the text file beside them lists.
//!
//! `make rules` writes these text files, the pictures and the index of the rules anew; look at `git diff` before you commit.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use lanewright::diagnostic::Severity;
use lanewright::report::draw::{self, Options};
use lanewright::report::{Report, Sources, TextStyle, full, rule_index};
use lanewright::requirement::Check;
use lanewright::rules;
use lanewright::settings::Settings;

use super::differences::things;
use crate::common::judging::{beside, info_of, judge, judge_as, load};
use crate::common::{is_fresh, root};

/// Every fault that the domain's specification names, with its severities: error, warning, info.
const SPECIFIED: &[(&str, &str, &str)] = &[
    ("load", "E", "missing-ref bound-count bound-polygon re-subtype re-members align"),
    ("ids", "E", "duplicate range"),
    ("node", "E", "no-ele"),
    ("node", "WE", "local-mismatch"),
    ("side", "E", "inconsistent"),
    ("phase", "I", "arrow"),
    ("vm-03-01", "E", "ia-tag-missing ia-tag-wrong ia-tag-dangling not-covered ia-id-range"),
    ("vm-03-01", "WE", "turn-without-ia"),
    ("vm-03-01", "W", "orphan-ia"),
    ("vm-03-01", "I", "no-right-of-way"),
    ("vm-03-02", "E", "turn-missing turn-invalid turn-signal-distance"),
    ("vm-03-02", "WE", "turn-mismatch"),
    ("vm-03-02", "W", "bound-type lane-change-in-ia turn-signal-overlap"),
    ("vm-03-03", "WE", "width width-abs kink curvature jagged joint"),
    (
        "vm-03-04",
        "E",
        "in-lane-dead-end out-lane-unreached near-miss signal-link-missing signal-no-stopline signal-on-in-lane",
    ),
    ("vm-03-04", "W", "movement-missing signal-multi"),
    ("vm-03-04", "WE", "dangling-il"),
    ("vm-03-05", "E", "divided"),
    ("vm-03-06", "W", "off-guide early-divergence"),
    ("vm-03-07", "E", "crossing"),
    ("vm-03-07", "WE", "overlap"),
    ("vm-03-07", "W", "not-shared"),
    ("vm-03-08", "E", "invalid lane-node-missing"),
    ("vm-03-08", "WE", "edge-not-border"),
    ("vm-03-08", "W", "cut-not-straight"),
    ("vm-03-08", "I", "closed not-drivable"),
    ("vm-03-09", "WE", "start-misaligned"),
    ("vm-03-09", "W", "no-stop-line end-misaligned crosswalk-outside"),
    ("vm-03-10", "E", "re-missing self-missing not-referenced yield-unsafe"),
    ("vm-03-10", "WE", "yield-missing"),
    ("vm-03-10", "WI", "yield-needless"),
    ("vm-03-10", "W", "multi-re"),
    ("vm-03-10", "I", "shared-re straight-re"),
    ("vm-03-11", "E", "self-missing not-referenced yield-unsafe mutual priority-inverted"),
    ("vm-03-11", "W", "re-missing yield-missing multi-re"),
    ("vm-03-11", "WI", "yield-needless"),
    ("vm-03-11", "I", "shared-re priority-unknown"),
    ("vm-03-12", "I", "attention no-conflict"),
    ("vm-03-12", "W", "sliver grade-separated-conflict"),
    ("vm-03-13", "E", "exit-no-turn walkway-unreferenced"),
    ("vm-03-13", "W", "exit-not-private walkway-short walkway-idle"),
    ("vm-03-13", "I", "walkway-missing"),
    ("vm-03-14", "E", "shape not-crossing"),
    ("vm-03-14", "W", "unreferenced sibling-missing"),
    ("vm-03-15", "E", "not-shared routable mixed-follow"),
    ("vm-03-15", "W", "lane-change invisible wrong-side"),
    ("vm-03-15", "WI", "yield"),
    ("vm-03-16", "E", "types order"),
    ("vm-03-17", "E", "yield"),
    ("vm-03-18", "E", "overlap"),
];

/// Bad maps that differ from good ones in more than one thing, with the number of things and the reason.
const MORE_THAN_ONE: &[(&str, usize, &str)] = &[
    (
        "vm-03-04/bad-signal-on-in-lane",
        3,
        "a light that moves leaves the two lanelets behind the line for the one before",
    ),
    ("vm-01-10/bad-mirrored", 5, "all lanelets of the map have left and right exchanged"),
    ("vm-01-20/bad-foreign-word", 2, "both lanelets beside the road have the word"),
    ("vm-04-02/bad-exchanged", 2, "two elements exchange their lights"),
    ("load/bad-format-version-word", 2, "formats 1 and 2 differ where both lanelets are bicycle lanes"),
    ("node/bad-coordinate-metres", 9, "all latitudes and longitudes are metres"),
    ("node/bad-coordinate-exchanged", 9, "all latitudes stand as longitudes"),
    ("node/bad-ele-left-out", 9, "the heights of a map are left out where all of it lies at 0"),
    ("health/bad-dead-end", 2, "the lane behind the missing one lies aside, so that it does not resume the one before"),
    (
        "health/bad-unreachable",
        2,
        "the lane behind the missing one lies aside, so that it does not resume the one before",
    ),
    ("vm-07-04/bad-below-sea", 12, "all heights of a map are above the sea, or none"),
];

/// The maps of one rule whose names start with `good` or `bad`.
fn maps(rule: &str, start: &str) -> Vec<PathBuf> {
    let folder = root().join("tests/rules").join(rule);
    let Ok(entries) = std::fs::read_dir(&folder) else { return Vec::new() };
    let mut maps: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    maps.retain(|path| {
        let name = path.file_name().unwrap().to_string_lossy();
        name.starts_with(start) && name.ends_with(".osm")
    });
    maps.sort();
    maps
}

fn rule_ids() -> Vec<&'static str> {
    rules::table().unwrap().iter().map(|row| row.requirement.id.as_str()).collect()
}

#[test]
fn every_rule_has_a_good_map_and_every_fault_a_bad_one() {
    for rule in rule_ids() {
        assert!(!maps(rule, "good").is_empty(), "tests/rules/{rule}/good.osm is missing");
        let bad: Vec<String> =
            maps(rule, "bad-").iter().map(|path| path.file_stem().unwrap().to_string_lossy().into_owned()).collect();
        for (slug, _) in &rules::find(rule).unwrap().faults {
            let shown = |name: &String| name.strip_prefix("bad-").is_some_and(|rest| rest.starts_with(slug.as_str()));
            assert!(bad.iter().any(shown), "tests/rules/{rule}/bad-{slug}.osm is missing");
        }
    }
}

#[test]
fn every_specified_fault_exists() {
    for (rule, severities, slugs) in SPECIFIED {
        let requirement = rules::find(rule).unwrap_or_else(|| panic!("no rule {rule}"));
        for slug in slugs.split(' ') {
            let fault = requirement.fault(slug).unwrap_or_else(|| panic!("{rule} has no fault {slug}"));
            let letter = match fault.severity {
                Severity::Error => 'E',
                Severity::Warning => 'W',
                Severity::Info => 'I',
            };
            assert!(severities.contains(letter), "{rule}/{slug} is {}, not {severities}", fault.severity);
        }
    }
}

#[test]
fn bad_maps_differ_from_a_good_one_in_one_thing() {
    let mut wrong = Vec::new();
    for rule in rule_ids() {
        let settings =
            |path: &Path| (std::fs::read_to_string(path.with_extension("toml")).unwrap_or_default(), info_of(path));
        let goods: Vec<_> = maps(rule, "good").into_iter().map(|path| (load(&path).0, settings(&path))).collect();
        for path in maps(rule, "bad-") {
            let (bad, own) = (load(&path).0, settings(&path));
            let differences = goods.iter().map(|(good, theirs)| {
                let things = things(good, &bad);
                // What is no element, such as the map's format version, is one thing as well.
                let other = things.is_empty() && good.sources[0].text != bad.sources[0].text;
                (things.len() + usize::from(other) + usize::from(own != *theirs), things)
            });
            let (count, things) = differences.min_by_key(|(count, _)| *count).unwrap();
            let name = format!("{rule}/{}", path.file_stem().unwrap().to_string_lossy());
            let known = MORE_THAN_ONE.iter().find(|(map, ..)| *map == name).map_or(1, |(_, count, _)| *count);
            if count != known {
                wrong.push(format!("{name} differs from good in {count} things, not {known}: {things:?}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The pictures that a document shows: `pictures/vm-03-08-good.svg` is that of `tests/rules/vm-03-08/good.osm`.
fn pictures(prose: &str) -> Vec<&str> {
    let links = prose.split("](pictures/").skip(1);
    links.filter_map(|rest| rest.split_once(".svg)")).map(|(name, _)| name).collect()
}

#[test]
fn the_pictures_of_the_documents_are_fresh() {
    let rules_folder = root().join("rules/pictures");
    let mut stale = Vec::new();
    let mut all = BTreeSet::new();
    for row in rules::table().unwrap() {
        let id = &row.requirement.id;
        let shown = pictures(&row.requirement.prose);
        let has = |start: &str| shown.iter().any(|name| name.starts_with(&format!("{id}-{start}")));
        // What only eyes can judge is shown as they see it.
        let bad = if row.requirement.check == Check::Manual { "eyes-" } else { "bad-" };
        assert!(!id.starts_with("vm-") || (has("good") && has(bad)), "rules/{id}.md shows no good or no {bad} picture");
        for name in shown {
            let fixture = name.strip_prefix(&format!("{id}-")).unwrap_or_else(|| panic!("{name} is not of {id}"));
            let path = root().join(format!("tests/rules/{id}/{fixture}.osm"));
            let (_, loaded) = load(&path);
            let (settings, config) = beside(&path);
            // Only what the picture is about: a broken map may raise more.
            let slug = fixture.strip_prefix("bad-").unwrap_or_default();
            let meant = |code: &str| slug.starts_with(code.strip_prefix(&format!("{id}/")).unwrap_or("/"));
            let mut found = judge_as(&loaded, &settings, &config);
            found.retain(|diagnostic| meant(&diagnostic.code));
            let title = format!("{}: {fixture}", row.requirement.title);
            let options = Options { scale: Some(14.0), title, ..Options::default() };
            let svg = draw::svg(&loaded.map, &found, &options).unwrap();
            assert!(svg.len() < 50_000, "{name}.svg has {} bytes", svg.len());
            let path = rules_folder.join(format!("{name}.svg"));
            if !is_fresh(&path, &svg) {
                stale.push(path.display().to_string());
            }
            all.insert(name.to_owned());
        }
        let embedded: BTreeSet<&str> = row.requirement.pictures.iter().map(|(name, _)| name.as_str()).collect();
        let shown: BTreeSet<&str> = pictures(&row.requirement.prose).into_iter().collect();
        assert_eq!(embedded, shown, "src/rules/pictures.rs and rules/{id}.md");
    }
    for entry in std::fs::read_dir(&rules_folder).unwrap() {
        let name = entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned();
        assert!(all.contains(&name), "no document shows rules/pictures/{name}.svg");
    }
    assert!(stale.is_empty(), "run `make rules`: {}", stale.join(", "));
}

#[test]
fn what_no_standard_asks_for_is_grouped_apart() {
    for requirement in rules::table().unwrap().iter().map(|row| &row.requirement) {
        let category = if requirement.is_of_the_standard() { requirement.id.get(..5).unwrap() } else { "map health: " };
        assert!(requirement.category.starts_with(category), "{}: {}", requirement.id, requirement.category);
    }
}

#[test]
fn the_index_of_the_documents_is_fresh() {
    let requirements = rules::table().unwrap().iter().map(|row| &row.requirement);
    let page = root().join("rules/README.md");
    assert!(is_fresh(&page, &rule_index(requirements)), "run `make rules`: {}", page.display());
}

#[test]
fn every_folder_belongs_to_a_rule() {
    let folder = root().join("tests/rules");
    let known: BTreeSet<&str> = rule_ids().into_iter().collect();
    for entry in std::fs::read_dir(folder).unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        assert!(known.contains(name.as_str()), "tests/rules/{name} belongs to no row of the table in src/rules/mod.rs");
    }
}

#[test]
fn good_maps_have_no_findings() {
    for path in rule_ids().into_iter().flat_map(|rule| maps(rule, "good")) {
        let (_, loaded) = load(&path);
        let (settings, config) = beside(&path);
        let said: Vec<String> = judge_as(&loaded, &settings, &config)
            .iter()
            .map(|d| format!("{}: {}", d.code, d.finding.message))
            .collect();
        assert!(said.is_empty(), "{}: {said:#?}", path.display());
    }
}

#[test]
fn roads_above_and_below_an_intersection_are_no_part_of_it() {
    let codes = |name: &str| -> Vec<String> {
        let (_, loaded) = load(&root().join("tests/rules").join(name));
        let found = judge(&loaded, &Settings::default());
        let codes: BTreeSet<String> = found.iter().map(|diagnostic| diagnostic.code.to_string()).collect();
        codes.into_iter().collect()
    };
    // They are connected with nothing. A bridge of which the ramp begins on the level of the intersection lies over its lanelets.
    assert_eq!(codes("vm-03-05/above.osm"), ["health/island", "vm-03-12/grade-separated-conflict"]);
    // A tunnel right under a bicycle lane.
    assert_eq!(codes("vm-03-15/below.osm"), ["health/island"]);
}

#[test]
fn loose_ends_that_the_settings_name_are_infos() {
    const ENDS: [&str; 2] = ["ends", "starts"];
    const STARTS: [&str; 2] = ["starts", "ends"];
    let cases = [
        ("health/bad-dead-end.osm", ENDS, 901, "health/dead-end"),
        ("health/bad-unreachable.osm", STARTS, 903, "health/unreachable"),
        ("vm-03-04/bad-in-lane-dead-end.osm", ENDS, 205, "vm-03-04/in-lane-dead-end"),
        ("vm-03-04/bad-out-lane-unreached.osm", STARTS, 206, "vm-03-04/out-lane-unreached"),
    ];
    for (name, [end, other_end], id, code) in cases {
        let (_, loaded) = load(&root().join("tests/rules").join(name));
        let severities = |settings: &str| -> Vec<Severity> {
            let found = judge(&loaded, &toml::from_str(settings).unwrap());
            found.iter().filter(|found| found.code == code).map(|found| found.severity).collect()
        };
        let unnamed = severities("");
        assert!(unnamed.len() == 1 && unnamed[0] > Severity::Info, "{name}: {unnamed:?}");
        assert_eq!(severities(&format!("loose_ends.{end} = [{id}]")), [Severity::Info], "{name}");
        assert_eq!(severities(&format!("loose_ends.{other_end} = [{id}]")), unnamed, "{name}");
    }
}

#[test]
fn bad_maps_have_the_findings_in_their_text_files() {
    let mut wrong = Vec::new();
    for rule in rule_ids() {
        for path in maps(rule, "bad-") {
            let (data, loaded) = load(&path);
            let (settings, config) = beside(&path);
            let diagnostics = judge_as(&loaded, &settings, &config);
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            let promised = diagnostics.iter().any(|diagnostic| {
                let slug = diagnostic.code.strip_prefix(&format!("{rule}/"));
                slug.is_some_and(|slug| name["bad-".len()..].starts_with(slug))
            });
            assert!(promised, "{} does not raise the fault it is named after", path.display());
            let sources = Sources::new(data.sources.iter().map(|source| (source.name.as_str(), source.text.as_str())));
            let mut said = Vec::new();
            full(&mut said, &Report::new(&diagnostics, &sources, &loaded.map), TextStyle::default()).unwrap();
            let said = String::from_utf8(said).unwrap();
            if !is_fresh(&path.with_extension("txt"), &said) {
                wrong.push(format!("{} now says:\n{said}", path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
