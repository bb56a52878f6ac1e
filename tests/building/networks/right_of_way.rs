//! Who goes first where signs stand on some carriageways only.

use lanewright::builder::Built;

use super::{SIDES, built, elements, found_of_geometry, network_of};

/// Two one-way streets that arrive side by side, the first past a stop sign, and a third that joins them: its cars ignore those of the
/// first alone, and the check agrees.
#[test]
fn a_sign_holds_for_its_own_carriageway() {
    let nodes = [
        (1, 18.0, 112.0, ""),
        (2, 12.0, 24.0, "highway=stop"),
        (3, 6.0, 10.0, ""),
        (4, 82.0, 82.0, ""),
        (5, 99.0, -90.0, ""),
        (6, 3.0, 5.5, ""),
        (7, -60.0, -100.0, ""),
    ];
    let ways: [(i64, &[i64], &str); 4] = [
        (11, &[1, 2, 3], "highway=tertiary oneway=yes"),
        (12, &[4, 3], "highway=tertiary oneway=yes"),
        (13, &[5, 6], "highway=residential oneway=yes"),
        (14, &[3, 6, 7], "highway=tertiary oneway=yes"),
    ];
    for side in SIDES {
        let Built { map, settings, .. } = built(&network_of(side, &nodes, &ways), side, "");
        assert_eq!(found_of_geometry(&map, &settings), Vec::<String>::new());
        let yields =
            elements(&map, "right_of_way").iter().map(|element| element.lanelets("yield").count()).collect::<Vec<_>>();
        assert_eq!(yields, [1, 1]);
    }
}
