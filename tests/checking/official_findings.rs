//! The findings on Autoware's official maps: those known, each a defect of the map or a documented disagreement.

use std::collections::BTreeMap;

use lanewright::diagnostic::Severity;
use lanewright::settings::Settings;

use crate::common::judging::{judge, load};
use crate::common::needs::shared;

const VM_03_LEFT: &str = "corpus/lanelet2/autoware_vm_03_left_hand.osm";
const SAMPLE: &str = "corpus/conformance/map/sample_map.osm";
const INTERSECTION: &str = "corpus/lanelet2/autoware_intersection.osm";
const VM_03_RIGHT: &str = "corpus/lanelet2/autoware_vm_03_right_hand.osm";

/// Fault, severity, and the count on each of the four maps above.
const EXPECTED: [(&str, Severity, [usize; 4]); 23] = [
    ("vm-03-01/ia-tag-missing", Severity::Error, [28, 0, 1, 19]),
    ("vm-03-01/ia-tag-wrong", Severity::Error, [0, 0, 0, 0]),
    ("vm-03-02/turn-missing", Severity::Error, [1, 0, 0, 1]),
    ("vm-03-02/turn-mismatch", Severity::Error, [0, 0, 0, 8]),
    ("vm-03-08/edge-not-border", Severity::Error, [1, 0, 2, 1]),
    ("vm-03-08/lane-node-missing", Severity::Error, [3, 6, 0, 2]),
    ("vm-03-04/near-miss", Severity::Error, [1, 0, 0, 1]),
    ("vm-03-04/dangling-il", Severity::Warning, [21, 1, 0, 13]),
    ("vm-03-04/dangling-il", Severity::Error, [0, 0, 0, 0]),
    ("vm-03-04/signal-link-missing", Severity::Error, [0, 1, 0, 0]),
    ("vm-03-09/start-misaligned", Severity::Error, [0, 0, 0, 18]),
    ("vm-03-09/start-misaligned", Severity::Warning, [0, 0, 0, 0]),
    ("vm-03-09/no-stop-line", Severity::Warning, [0, 3, 6, 0]),
    ("vm-03-09/end-misaligned", Severity::Warning, [0, 0, 0, 0]),
    ("vm-03-10/re-missing", Severity::Error, [1, 0, 1, 4]),
    ("vm-03-10/yield-missing", Severity::Error, [0, 0, 1, 3]),
    ("vm-03-10/yield-missing", Severity::Warning, [8, 0, 8, 0]),
    ("vm-03-10/yield-unsafe", Severity::Error, [0, 1, 0, 0]),
    ("vm-03-10/yield-needless", Severity::Info, [32, 0, 31, 9]),
    // Elements that serve one lanelet only.
    ("vm-03-10/yield-needless", Severity::Warning, [0, 0, 0, 2]),
    ("vm-03-12/sliver", Severity::Warning, [0, 0, 5, 0]),
    ("vm-03-12/attention", Severity::Info, [0, 0, 0, 0]),
    // Every lane of the last one has another light than its neighbours, because its stop lines lie at the exits.
    ("phase/arrow", Severity::Info, [1, 0, 0, 8]),
];

/// Faults that none of these maps may have.
const NEVER: [&str; 24] = [
    "vm-03-01/ia-tag-dangling",
    "vm-03-01/not-covered",
    "vm-03-01/orphan-ia",
    "vm-03-02/turn-invalid",
    "vm-03-02/lane-change-in-ia",
    "vm-03-03/width",
    "vm-03-03/width-abs",
    "vm-03-03/kink",
    "vm-03-03/curvature",
    "vm-03-03/jagged",
    "vm-03-05/divided",
    "vm-03-07/crossing",
    "vm-03-07/overlap",
    "vm-03-07/not-shared",
    "vm-03-08/invalid",
    "vm-03-08/closed",
    "vm-03-08/cut-not-straight",
    "vm-03-16/types",
    "vm-03-16/order",
    "vm-03-17/re-missing",
    "vm-03-17/yield",
    "vm-03-18/overlap",
    "node/local-mismatch",
    "node/no-ele",
];

#[test]
fn the_official_maps_have_their_known_defects_and_no_other() {
    for (column, file) in [VM_03_LEFT, SAMPLE, INTERSECTION, VM_03_RIGHT].into_iter().enumerate() {
        let Some(path) = shared(file) else { return };
        let (_, loaded) = load(&path);
        let mut counts: BTreeMap<(String, Severity), usize> = BTreeMap::new();
        for diagnostic in judge(&loaded, &Settings::default()) {
            *counts.entry((diagnostic.code, diagnostic.severity)).or_default() += 1;
        }
        for (code, severity, expected) in EXPECTED {
            let found = counts.get(&(code.to_owned(), severity)).copied().unwrap_or(0);
            assert_eq!(found, expected[column], "{code} on {file}");
        }
        for (code, _) in counts.keys() {
            assert!(!NEVER.contains(&code.as_str()), "{code} on {file}");
        }
    }
}
