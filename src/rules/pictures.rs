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
}

/// The pictures of one rule: name and SVG.
pub(super) fn of(rule: &str) -> Vec<(String, &'static str)> {
    let own = PICTURES.iter().filter(|(id, ..)| *id == rule);
    own.map(|(_, name, svg)| ((*name).to_owned(), *svg)).collect()
}
