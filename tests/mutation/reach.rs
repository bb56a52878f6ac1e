//! Every fault of every rule is raised by a mutation, or it stands here why not.

use std::collections::BTreeSet;

use lanewright::rules;

use super::{all_kinds, projector};

/// Reasons why no mutation of the sample maps raises a fault; a bad map of `tests/rules`, one step from a good one, raises
/// each of them all the same.
const UNRAISED: &[(&str, &[&str])] = &[
    (
        "follows from others, or is said of maps in good order",
        &[
            "load/skipped",
            "load/reversed",
            "vm-03-12/attention",
            "vm-03-10/shared-re",
            "vm-03-10/straight-re",
            "vm-03-11/shared-re",
            "vm-03-11/priority-unknown",
            "vm-03-01/no-right-of-way",
            "phase/arrow",
            "vm-01-14/stacked",
        ],
    ),
    ("of three lanes drawn anew together", &["health/fan"]),
    ("a lanelet drawn in a way that no mutation draws", &["health/very-short", "health/bounds-apart"]),
    (
        "the sample maps have no centre lines, no word that Lanelet2 alone reads, and no intersection without an area",
        &["vm-01-10/backwards", "vm-01-10/mirrored", "vm-01-20/foreign-word", "vm-03-02/turn-forgotten"],
    ),
    ("of bends that the sample maps do not have", &["load/align-heights"]),
    (
        "of a light that stands where none can be, or says nothing of its kind: no mutation is written",
        &["vm-04-01/kind", "vm-04-02/below-road", "vm-04-02/far"],
    ),
    ("of the text, before it is a map", &["load/passed-over", "parts/blank-start"]),
    (
        "told as a near miss or as a lane without length wherever a sample map can have it",
        &["parts/same-place", "parts/point-bound"],
    ),
    (
        "no sample map has areas as relations or landmarks, and one has a roundabout element",
        &[
            "load/area",
            "area/closed",
            "area/shut",
            "area/unspanned",
            "area/dead-end",
            "area/lane-untagged",
            "area/hole",
            "area/concave",
            "area/unreached",
            "landmark/corners",
            "landmark/no-id",
            "roundabout/unreferenced",
            "roundabout/apart",
            "signal/no-light",
        ],
    ),
    (
        "of a whole map rather than of a place: its network, its side, its heights",
        &[
            "access/cut-off",
            "health/island",
            "health/dead-end",
            "health/unreachable",
            "health/gap",
            "health/narrow",
            "health/wide",
            "health/loop",
            "health/near-miss",
            "health/head-on",
            "health/wrong-side",
            "side/inconsistent",
            "vm-07-01/short-approach",
            "vm-07-04/below-sea",
            "vm-03-12/grade-separated-conflict",
        ],
    ),
    (
        "follows from lanes that overlap otherwise, or from what the user says of lights, or of a whole map",
        &[
            "planner/stops-too-late",
            "planner/never-meets",
            "planner/nobody-waits",
            "planner/both-wait",
            "planner/attention-cut",
        ],
    ),
    (
        "no sample map has virtual traffic lights",
        &[
            "vm-03-16/types",
            "vm-03-16/order",
            "vm-03-16/too-large",
            "vm-03-17/re-missing",
            "vm-03-17/self-missing",
            "vm-03-17/not-referenced",
            "vm-03-17/yield",
            "vm-03-17/yield-needless",
            "vm-03-17/multi-re",
            "vm-03-17/shared-re",
            "vm-03-18/overlap",
        ],
    ),
    (
        "no sample map has guide lines, shoulders or side strips; for bicycle lanes, walkways and private ground no mutation is written",
        &[
            "vm-03-15/lane-change",
            "vm-03-15/routable",
            "vm-03-15/invisible",
            "vm-03-15/yield",
            "vm-03-15/wrong-side",
            "vm-03-15/mixed-follow",
            "vm-07-05/on-road",
            "vm-03-06/off-guide",
            "vm-03-06/early-divergence",
            "vm-03-13/exit-no-turn",
            "vm-03-13/exit-not-private",
            "vm-03-13/private-alone",
            "vm-03-13/walkway-missing",
            "vm-03-13/walkway-short",
            "vm-03-13/walkway-unreferenced",
            "vm-01-15/alone",
            "vm-01-15/outer-border",
            "vm-01-17/alone",
            "vm-01-17/beside",
            "vm-01-17/outer-border",
            "vm-01-20/neighbours",
        ],
    ),
    (
        "no sample map has lights for people on foot",
        &["vm-05-02/light-kind", "vm-05-02/vehicles", "vm-05-02/stop-line", "vm-05-02/far"],
    ),
    (
        "no sample map has elements for areas",
        &[
            "vm-06-01/not-shared",
            "vm-06-02/number",
            "vm-06-02/type",
            "vm-06-02/idle",
            "vm-06-02/referrer",
            "vm-06-03/apart",
            "vm-06-03/not-told",
            "vm-06-04/number",
            "vm-06-04/type",
            "vm-06-04/line-type",
            "vm-06-04/idle",
            "vm-06-04/referrer",
            "vm-06-05/number",
            "vm-06-05/type",
            "vm-06-05/line-type",
            "vm-06-05/idle",
            "vm-06-05/referrer",
            "vm-07-02/area",
            "vm-07-07/apart",
            "vm-07-07/too-small",
            "vm-07-07/mid-road",
        ],
    ),
    (
        "needs a drawing of its own: lanes that part, cross, bend or are added, and lines that several lanes share",
        &[
            "vm-01-03/not-shared",
            "vm-01-03/partly-shared",
            "vm-01-10/off-surface",
            "vm-01-11/joint",
            "vm-01-12/joint",
            "vm-01-12/kink",
            "vm-02-01/askew",
            "vm-02-02/sign-missing",
            "vm-02-02/sign-extent",
            "vm-03-01/not-covered",
            "vm-03-01/orphan-ia",
            "vm-03-02/turn-signal-overlap",
            "vm-03-03/width-abs",
            "vm-03-03/joint",
            "vm-03-07/crossing",
            "vm-03-07/overlap",
            "vm-03-08/cut-not-straight",
            "vm-03-08/not-drivable",
            "vm-03-09/end-misaligned",
            "vm-03-09/crosswalk-outside",
            "vm-03-12/sliver",
            "vm-03-12/no-conflict",
            "vm-03-14/not-crossing",
            "vm-03-14/sibling-missing",
            "vm-04-01/no-stop-line",
            "vm-04-01/extent",
            "vm-04-02/directions",
            "vm-04-02/both-ways",
            "vm-05-01/no-stop-line",
            "vm-05-01/several-stop-lines",
            "vm-05-01/line-type",
            "vm-05-01/extent",
            "vm-07-06/no-way-in",
            "vm-07-06/no-way-out",
            "vm-07-08/overlap",
            "vm-07-08/crossing",
        ],
    ),
];

#[test]
fn every_fault_is_raised_by_a_mutation_or_listed_with_a_reason() {
    let mutated = all_kinds().flat_map(|kind| kind.raises.iter().copied());
    let files = projector::MUTATIONS.iter().map(|(_, raises, _)| *raises).chain(projector::ALSO);
    let raised: BTreeSet<&str> = mutated.chain(files).collect();
    let unraised: BTreeSet<&str> = UNRAISED.iter().flat_map(|(_, slugs)| slugs.iter().copied()).collect();
    let rows = rules::table().unwrap().iter().map(|row| &row.requirement);
    let all: BTreeSet<String> =
        rows.flat_map(|one| one.faults.iter().map(move |(slug, _)| format!("{}/{slug}", one.id))).collect();
    let neither: Vec<&String> =
        all.iter().filter(|code| !raised.contains(code.as_str()) && !unraised.contains(code.as_str())).collect();
    assert!(neither.is_empty(), "no mutation raises {neither:?}: add one, or say why not");
    let both: Vec<&str> = raised.intersection(&unraised).copied().collect();
    assert!(both.is_empty(), "{both:?} are raised by mutations after all");
    let unknown: Vec<&str> = raised.union(&unraised).copied().filter(|code| !all.contains(*code)).collect();
    assert!(unknown.is_empty(), "{unknown:?} are faults of no rule");
    println!("{} of {} faults are raised by mutations", raised.len(), all.len());
}
