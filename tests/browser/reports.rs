//! Reports to look at: a crossing that we build and then break, with texts that would run if a page let them.

use std::path::{Path, PathBuf};

use lanewright::builder::{BuildOptions, build};
use lanewright::diagnostic::Diagnostic;
use lanewright::lanelet::LaneletMap;
use lanewright::lanelet::index::MapIndex;
use lanewright::report::html::{Earlier, Page, html};
use lanewright::report::{Report, Sources};
use lanewright::requirement::Requirement;
use lanewright::rules::{self, Config};

use crate::common::root;

/// What a hostile mapper writes into a tag. The slash is written so that only an HTML parser sees it.
pub const EVIL: &str =
    "</script><script>window.evil=1</script><img src=x onerror=window.evil=2>\"'><svg onload=evil=3>";

/// A report on disk and the findings in it.
pub struct Written {
    pub file: PathBuf,
    pub findings: Vec<Diagnostic>,
    pub map: LaneletMap,
}

/// A crossing with two turns that lost their direction and one lanelet with hostile tags.
pub fn broken(name: &str) -> Written {
    write(name, 2, None)
}

/// The same with one more turn broken, or one mended, held against the report of [`broken`].
pub fn compared(name: &str, turns: usize) -> Written {
    let before = broken(&format!("before-{name}"));
    let earlier = Earlier::read(&std::fs::read_to_string(before.file).unwrap()).unwrap();
    write(name, turns, Some(&earlier))
}

fn write(name: &str, turns: usize, earlier: Option<&Earlier>) -> Written {
    let osm = lanewright::osm::read_file(&root().join("sample_maps/crossing_right.osm")).unwrap();
    let built = build(&osm, &BuildOptions::default()).unwrap();
    let (mut map, settings) = (built.map, built.settings);
    let turning: Vec<_> = map.lanelets.iter().filter(|l| l.attributes.has("turn_direction")).map(|l| l.id).collect();
    assert!(turning.len() > 4);
    for &id in &turning[..turns] {
        let lanelet = map.lanelets.get_mut(id).unwrap();
        let kept = lanelet.attributes.iter().filter(|(key, _)| *key != "turn_direction");
        lanelet.attributes = kept
            .map(|(k, v)| (k.to_owned(), v.to_owned()))
            .collect::<Vec<_>>()
            .iter()
            .map(|(k, v)| (k.as_str(), v.as_str()))
            .collect();
    }
    let hostile = map.lanelets.get_mut(turning[0]).unwrap();
    hostile.attributes.set("name", EVIL);
    hostile.attributes.set(EVIL, "1");
    let index = MapIndex::new(&map, &[], &settings);
    let mut findings = rules::run(&index, &Config::default()).unwrap();
    findings[0].finding.message += EVIL;
    let requirements: Vec<&Requirement> = rules::table().unwrap().iter().map(|row| &row.requirement).collect();
    let sources = Sources::new([]);
    let report = Report { requirements: &requirements, ..Report::new(&findings, &sources, &map) };
    let page = Page { title: EVIL, path: None, requirements: &requirements, earlier, origin: None };
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.html"));
    std::fs::write(&file, html(&report, &page).unwrap()).unwrap();
    Written { file, findings, map }
}
