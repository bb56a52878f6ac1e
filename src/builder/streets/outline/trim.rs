//! How much of each road remains between the cuts at its two ends.

use crate::builder::network::Stations;
use crate::geometry::{Polyline, angle_between};

/// Shares a road of `length` between the trims that its two ends want, so that `remains` is left of it: where it is
/// too short they give up the room for their kerbs in proportion, down to the `least` they need, and where even that
/// is too much, in proportion again.
pub fn share(length: f64, least: Stations, wanted: [f64; 2], remains: f64) -> [f64; 2] {
    let sum = |trims: [f64; 2]| trims[0] + trims[1];
    // A road no longer than twice what should remain keeps its middle half.
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

/// Moves a cut along the line to the next vertex where that lies so close ahead that the inner edge of the road, bending
/// there, begins before the cut.
pub fn clear_of_bends(line: &Polyline, station: f64, half: f64) -> f64 {
    let stations = line.stations();
    let mut cut = station;
    for (w, s) in line.points().windows(3).zip(&stations[1..]) {
        let (before, behind) = (w[1] - w[0], w[2] - w[1]);
        // Only a bend of more than a right angle reaches farther ahead than half the width.
        if *s <= cut || *s - cut > half + SLIVER && before.dot(&behind) > 0.0 {
            continue;
        }
        let turn = angle_between(before, behind).abs();
        if *s - cut <= half * (turn / 2.0).tan() + SLIVER {
            cut = *s + PAST;
        }
    }
    cut
}

/// A piece of edge shorter than this, metres, is not worth a vertex.
const SLIVER: f64 = 0.02;
/// A cut at a vertex lies so far past it, metres, that it belongs to the segment behind beyond doubt.
const PAST: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_roads_keep_their_trims() {
        assert_eq!(share(50.0, [2.0, 3.0], [5.0, 7.0], 1.0), [5.0, 43.0]);
    }

    #[test]
    fn kerbs_give_up_their_room_first() {
        assert_eq!(share(11.0, [4.0, 4.0], [6.0, 8.0], 1.0), [4.0 + 2.0 / 3.0, 11.0 - 4.0 - 4.0 / 3.0]);
    }

    #[test]
    fn trims_that_meet_are_shortened_in_proportion() {
        assert_eq!(share(10.0, [12.0, 6.0], [14.0, 9.0], 1.0), [6.0, 7.0]);
        let [from, to] = share(0.5, [3.0, 1.0], [3.0, 1.0], 1.0);
        assert!(from > 0.0 && to < 0.5 && to - from > 0.2);
    }
}
