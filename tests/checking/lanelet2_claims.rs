//! What the documents of the rules say of Lanelet2 is what the real library does.

use std::collections::BTreeMap;

use crate::common::needs::python;
use crate::common::root;

/// A claim of `lanelet2_claims.py`, the document that makes it, and its words there.
const CLAIMS: [(&str, &str, &str); 14] = [
    ("dashed", "vm-01-02", "a dashed line may be crossed from both sides"),
    (
        "one-sided paint",
        "vm-01-02",
        "`solid_dashed` to the left and `dashed_solid` to the right along the way as stored",
    ),
    ("other paint", "vm-01-02", "every other line by nobody"),
    ("lane_change alone", "vm-01-02", "Lanelet2 reads `lane_change` alone where it stands."),
    ("unnamed side", "vm-01-02", "the side that is not named is closed, whatever the paint says"),
    (
        "left=no alone",
        "vm-01-02",
        "`lane_change:left=no` without `lane_change:right` does not count, and the paint does.",
    ),
    (
        "both sides",
        "vm-01-02",
        "`lane_change:left` (to the left, along the way as stored) and `lane_change:right` instead",
    ),
    (
        "one_way=no",
        "vm-01-01",
        "With `one_way=no` (or `false`, `0`) Lanelet2 puts the lanelet into the routing graph twice",
    ),
    ("no one_way", "vm-01-01", "Without the tag a vehicle takes it for one-way, a pedestrian does not"),
    ("shared ways conflict", "vm-01-14", "two lanelets on each other conflict whether they share their ways or not"),
    ("leading digits", "node", "latitude `49,00003` as 49, `ele` of `1,5` as 1 and of `1.5 m` as 1.5"),
    ("word", "node", "a word as 0"),
    ("second ref_line", "load", "A `right_of_way` with a second `ref_line` loads; its stop line is the first one."),
    ("key twice", "tag", "of a key that stands twice the last value, of the `ele` of a node the first"),
];

#[test]
fn what_the_documents_say_of_lanelet2_is_what_it_does() {
    for (claim, document, words) in CLAIMS {
        let text = std::fs::read_to_string(root().join(format!("rules/{document}.md"))).unwrap();
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains(words), "{document} no longer says of {claim}: {words}");
    }
    let Some(mut python) = python() else { return };
    let output = python.arg(root().join("tests/checking/lanelet2_claims.py")).output().unwrap();
    let answers: BTreeMap<String, bool> = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&output.stderr)));
    let claims: Vec<&str> = CLAIMS.iter().map(|(claim, ..)| *claim).collect();
    for (claim, holds) in &answers {
        assert!(claims.contains(&claim.as_str()), "no document makes the claim {claim}");
        assert!(holds, "Lanelet2 does otherwise: {claim}");
    }
    assert_eq!(answers.len(), claims.len());
}
