//! Shares a road between the trims at its two ends.

use crate::builder::network::Stations;
use crate::geometry::{Polyline, angle_between};

/// The stations between which a road of `length` metres remains, at least `remains` metres of it, if both ends get the trims
/// `wanted`. On a short road the room for kerbs shrinks in proportion, down to the `least` trims, and then these.
pub fn share(length: f64, least: [f64; 2], wanted: [f64; 2], remains: f64) -> Stations {
    let sum = |trims: [f64; 2]| trims[0] + trims[1];
    // A road shorter than twice `remains` keeps its middle half.
    let room = length - remains.min(length / 2.0);
    let trims = if sum(wanted) <= room {
        wanted
    } else if sum(least) <= room {
        let given = (room - sum(least)) / (sum(wanted) - sum(least));
        [0, 1].map(|i| least[i] + (wanted[i] - least[i]) * given)
    } else {
        least.map(|trim| trim * room / sum(least))
    };
    [trims[0], length - trims[1]]
}

/// The cut at a station, metres, moved past the next vertex if the inner edge of the bend there begins before it.
pub fn clear_of_bends(line: &Polyline, station: f64, half: f64) -> f64 {
    let stations = line.stations();
    let mut cut = station;
    for (w, s) in line.points().windows(3).zip(&stations[1..]) {
        let (before, after) = (w[1] - w[0], w[2] - w[1]);
        // Only a bend of more than a right angle reaches farther than half the width.
        if *s <= cut || *s - cut > half + SLIVER && before.dot(&after) > 0.0 {
            continue;
        }
        let turn = angle_between(before, after).abs();
        if *s - cut <= half * (turn / 2.0).tan() + SLIVER {
            cut = *s + PAST;
        }
    }
    cut
}

/// Least length of an edge, metres.
const SLIVER: f64 = 0.02;
/// Distance of a cut after a vertex, metres: it belongs to the next segment.
const PAST: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_roads_keep_their_trims() {
        assert_eq!(share(50.0, [2.0, 3.0], [5.0, 7.0], 1.0), [5.0, 43.0]);
    }

    #[test]
    fn the_room_for_kerbs_shrinks_first() {
        assert_eq!(share(11.0, [4.0, 4.0], [6.0, 8.0], 1.0), [4.0 + 2.0 / 3.0, 11.0 - 4.0 - 4.0 / 3.0]);
    }

    #[test]
    fn trims_that_meet_are_shortened_in_proportion() {
        assert_eq!(share(10.0, [12.0, 6.0], [14.0, 9.0], 1.0), [6.0, 7.0]);
        let [from, to] = share(0.5, [3.0, 1.0], [3.0, 1.0], 1.0);
        assert!(from > 0.0 && to < 0.5 && to - from > 0.2);
    }
}
