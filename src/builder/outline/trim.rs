//! How much of each road remains between the cuts at its two ends.

/// Shares a road of `length` between the trims that its two ends ask for, so that at least `least` remains where the
/// road is long enough: trims that meet are shortened in proportion.
pub fn share(length: f64, wanted: [f64; 2], least: f64) -> [f64; 2] {
    let [start, end] = wanted;
    if length - start - end >= least {
        return [start, length - end];
    }
    // A road no longer than twice what should remain keeps its middle half.
    let remains = least.min(length / 2.0);
    let scale = (length - remains) / (start + end);
    [start * scale, length - end * scale]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_roads_keep_their_trims() {
        assert_eq!(share(50.0, [5.0, 7.0], 1.0), [5.0, 43.0]);
    }

    #[test]
    fn trims_that_meet_are_shortened_in_proportion() {
        assert_eq!(share(10.0, [12.0, 6.0], 1.0), [6.0, 7.0]);
        let [from, to] = share(0.5, [3.0, 1.0], 1.0);
        assert!(from > 0.0 && to < 0.5 && to - from > 0.2);
    }
}
