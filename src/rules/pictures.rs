//! The pictures of the documents in `rules/`, drawn from the maps of `tests/rules` by `make rules`.

macro_rules! pictures {
    ($($rule:literal: $($fixture:literal),+;)*) => {
        /// Rule, name and SVG.
        const PICTURES: &[(&str, &str, &str)] = &[$($((
            $rule,
            concat!($rule, "-", $fixture),
            include_str!(concat!("../../rules/pictures/", $rule, "-", $fixture, ".svg")),
        )),+),*];
    };
}

pictures! {
    "side": "good", "bad-inconsistent";
    "phase": "good", "bad-arrow";
    "health": "good", "bad-head-on", "bad-gap";
    "planner": "good", "bad-stops-too-late", "bad-never-meets-turn";
    "vm-01-01": "good", "bad-location";
    "vm-01-02": "good", "bad-lane-change-missing";
    "vm-01-03": "good", "bad-partly-shared";
    "vm-01-04": "good", "bad-cut-apart";
    "vm-01-05": "good", "bad-shared-point";
    "vm-01-06": "good", "eyes-beside-the-paint";
    "vm-01-07": "good", "eyes-beside-the-paint";
    "vm-01-08": "good", "bad-edge-distance";
    "vm-01-09": "good", "bad-speed-range";
    "vm-01-10": "good", "bad-outside";
    "vm-01-11": "good", "bad-gap";
    "vm-01-12": "good", "bad-off-middle";
    "vm-01-13": "good", "bad-overlap";
    "vm-01-14": "good", "bad-not-shared";
    "vm-01-15": "good", "bad-alone";
    "vm-01-16": "good", "bad-not-shared";
    "vm-01-17": "good", "bad-alone";
    "vm-01-18": "good", "bad-not-shared";
    "vm-01-19": "good", "bad-doubled";
    "vm-01-20": "good", "bad-neighbours";
    "vm-01-21": "good", "bad-follower";
    "vm-02-01": "good", "bad-askew";
    "vm-02-02": "good", "bad-unreferenced";
    "vm-02-03": "good", "bad-second-line";
    "vm-02-04": "good", "bad-behind";
    "vm-03-01": "good", "bad-not-covered";
    "vm-03-02": "good", "bad-turn-mismatch";
    "vm-03-03": "good", "bad-width-severe", "bad-jagged";
    "vm-03-04": "good", "bad-movement-missing";
    "vm-03-05": "good", "bad-divided";
    "vm-03-06": "good", "bad-early-divergence";
    "vm-03-07": "good", "bad-crossing";
    "vm-03-08": "good", "bad-lane-node-missing";
    "vm-03-09": "good", "bad-start-misaligned-far";
    "vm-03-10": "good", "bad-yield-unsafe";
    "vm-03-11": "good", "bad-priority-inverted";
    "vm-03-12": "good", "bad-sliver";
    "vm-03-13": "good", "bad-walkway-short";
    "vm-03-14": "good", "bad-sibling-missing";
    "vm-03-15": "good", "bad-not-shared";
    "vm-03-16": "good", "bad-order";
    "vm-03-17": "good", "bad-yield";
    "vm-03-18": "good", "bad-overlap";
    "vm-04-01": "good", "bad-unreferenced";
    "vm-04-02": "good", "bad-reversed";
    "vm-04-03": "good", "bad-color-missing";
    "vm-05-01": "good", "bad-not-crossing";
    "vm-05-02": "good", "bad-light-kind";
    "vm-05-03": "good", "bad-speed";
    "vm-05-04": "good", "bad-across";
    "vm-06-01": "good", "bad-overlap";
    "vm-06-02": "good", "bad-unreferenced";
    "vm-06-03": "good", "bad-not-told";
    "vm-06-04": "good", "bad-unreferenced";
    "vm-06-05": "good", "bad-unreferenced";
    "vm-06-06": "good", "bad-unreferenced";
    "vm-07-01": "good", "bad-short-approach";
    "vm-07-02": "good", "bad-word";
    "vm-07-03": "good", "bad-on-lane";
    "vm-07-04": "good", "bad-below-sea";
    "vm-07-05": "good", "bad-on-road";
    "vm-07-06": "good", "bad-no-way-in";
    "vm-07-07": "good", "bad-too-small";
    "vm-07-08": "good", "bad-crossing";
}

/// The pictures of one rule: name and SVG.
pub(super) fn of(rule: &str) -> Vec<(String, &'static str)> {
    let own = PICTURES.iter().filter(|(id, ..)| *id == rule);
    own.map(|(_, name, svg)| ((*name).to_owned(), *svg)).collect()
}
