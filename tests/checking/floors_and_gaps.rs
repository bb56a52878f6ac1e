//! Lanes above each other, gaps in roads of several lanes, and lanes in which no car fits: what is said of them, and what is not.

use lanewright::osm::OsmData;

use super::strangers_maps::{Sheet, found, mended};

/// A car park: on each floor a lane in two pieces, which the last floor lacks the first piece of.
fn car_park(rise: f64) -> OsmData {
    let mut sheet = Sheet::default();
    let mut node = 0;
    for floor in 0..3 {
        let mut at = |x: f64, y: f64| {
            node += 1;
            let tags = format!("local_x={x} local_y={y} ele={}", 10.0 + rise * f64::from(floor));
            sheet.drawing.node(node, [""; 2], &tags);
            node
        };
        let [a, b, c] = [0.0, 40.0, 80.0].map(|x| [at(x, 3.5), at(x, 0.0)]);
        if floor < 2 {
            sheet.road(&[a[0], b[0]], &[a[1], b[1]], "");
        }
        if floor > 0 {
            sheet.road(&[b[0], c[0]], &[b[1], c[1]], "");
        }
    }
    sheet.drawing.data()
}

fn said(data: &OsmData, code: &str) -> usize {
    found(data).iter().filter(|one| one.code == code).count()
}

#[test]
fn lanes_of_two_floors_were_not_meant_to_be_one() {
    assert_eq!(said(&car_park(2.6), "health/near-miss"), 0);
    // Heights that drift are those of one floor.
    assert!(said(&car_park(0.2), "health/near-miss") > 0);
}

#[test]
fn lanes_of_two_floors_do_not_lie_on_each_other() {
    assert_eq!(said(&car_park(2.6), "vm-07-08/overlap"), 0);
    assert!(said(&car_park(0.2), "vm-07-08/overlap") > 0);
}

#[test]
fn no_fix_joins_nodes_of_two_floors() {
    for rise in [1.3, 2.6] {
        let heights = |data: &OsmData| {
            let mut all: Vec<String> =
                data.nodes.iter().filter_map(|one| one.tags.get("ele").map(str::to_owned)).collect();
            all.sort_unstable();
            all
        };
        let before = car_park(rise);
        assert_eq!(heights(&mended(car_park(rise)).osm), heights(&before), "{rise}");
    }
}

/// A road of so many lanes, wide as given, in pieces of 25 m; lane changes are allowed. `gap` leaves out so many pieces in the middle.
fn lanes(count: usize, width: f64, gap: usize) -> OsmData {
    let mut sheet = Sheet::default();
    let is_there = |at: usize| at < 2 || at >= 2 + gap;
    let mut before = None;
    for at in 0..5 + gap {
        let line = |sheet: &mut Sheet| -> Vec<i64> {
            let y = |lane: usize| -width * lane as f64;
            (0..=count).flat_map(|lane| sheet.nodes([[25.0 * at as f64, y(lane)]])).collect()
        };
        let here = line(&mut sheet);
        if let Some(before) = before.replace(here.clone()).filter(|_| at > 0 && is_there(at - 1)) {
            let before: Vec<i64> = before;
            let kind = |lane: usize| match lane {
                _ if lane == 0 || lane == count => "type=road_border",
                _ => "type=line_thin subtype=dashed lane_change=yes",
            };
            let ways: Vec<i64> = (0..=count).map(|lane| sheet.way(&[before[lane], here[lane]], kind(lane))).collect();
            for pair in ways.windows(2) {
                sheet.lanelet([pair[0], pair[1]], "subtype=road location=urban speed_limit=40");
            }
        }
    }
    sheet.drawing.data()
}

#[test]
fn a_road_of_several_lanes_with_a_gap_is_told_as_one_of_a_single_lane() {
    for count in 1..4 {
        assert_eq!(said(&lanes(count, 3.0, 0), "health/gap"), 0, "{count}");
        for gap in [1, 2] {
            assert_eq!(said(&lanes(count, 3.0, gap), "health/gap"), count, "{count} lanes, {gap} pieces");
        }
    }
}

#[test]
fn a_road_in_which_no_car_fits_is_told_however_many_lanes_it_has() {
    for count in 1..4 {
        for (width, is_told) in [(0.5, true), (1.2, true), (1.6, false)] {
            let narrow = said(&lanes(count, width, 0), "health/narrow");
            assert_eq!(narrow, if is_told { 4 * count } else { 0 }, "{count} lanes of {width} m");
        }
    }
}

#[test]
fn narrow_lanes_side_by_side_are_no_near_misses() {
    assert_eq!(said(&lanes(3, 0.48, 0), "health/near-miss"), 0);
}
