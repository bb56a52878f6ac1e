//! Borders of roads that lie side by side between the same nodes: they become one line, which tells who drives beside whom.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::lanelet::{Bound, LaneletMap, LineString, LineStringId, PointId};

/// Replaces a road border of a lanelet that runs over the same points as that of another one, in either direction: both use the one that
/// comes first in the map.
pub fn share_borders(map: &mut LaneletMap) {
    let gone = repeated(map);
    if gone.is_empty() {
        return;
    }
    for lanelet in map.lanelets.as_mut_slice() {
        for bound in [&mut lanelet.left, &mut lanelet.right] {
            if let Some(&Bound { line, inverted }) = gone.get(&bound.line) {
                *bound = Bound { line, inverted: bound.inverted != inverted };
            }
        }
    }
    map.linestrings.retain(|line| !gone.contains_key(&line.id));
}

/// The borders that run over the same points as an earlier one, each with that one, as a bound in the direction of the border.
fn repeated(map: &LaneletMap) -> FxHashMap<LineStringId, Bound> {
    let bounds: FxHashSet<LineStringId> =
        map.lanelets.iter().flat_map(|lanelet| [lanelet.left.line, lanelet.right.line]).collect();
    let is_border = |line: &&LineString| bounds.contains(&line.id) && line.attributes.is("type", "road_border");
    let mut by_ends: FxHashMap<[PointId; 2], Vec<&LineString>> = FxHashMap::default();
    let mut repeated = FxHashMap::default();
    for line in map.linestrings.iter().filter(is_border) {
        let (Some(&first), Some(&last)) = (line.points.first(), line.points.last()) else { continue };
        let earlier = by_ends.entry([first.min(last), first.max(last)]).or_default();
        match earlier.iter().find_map(|one| Some((one.id, is_inverted(one, line)?))) {
            Some((line_before, inverted)) => {
                repeated.insert(line.id, Bound { line: line_before, inverted });
            }
            None => earlier.push(line),
        }
    }
    repeated
}

/// Whether a line runs over the points of another one backwards; `None` if it does not run over the same ones, or is marked otherwise.
fn is_inverted(one: &LineString, other: &LineString) -> Option<bool> {
    let alike = one.attributes == other.attributes;
    let forth = alike && one.points == other.points;
    let back = alike && one.points.len() == other.points.len() && one.points.iter().eq(other.points.iter().rev());
    (forth || back).then_some(!forth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanelet::{Attributes, Lanelet, LaneletId};

    /// Lanelets between lines over these points: their left bound, then their right one.
    fn map(bounds: &[[&[i64]; 2]]) -> LaneletMap {
        let mut map = LaneletMap::default();
        let mut id = 0;
        let mut line = |points: &[i64]| {
            id += 1;
            let points = points.iter().map(|&id| PointId(id)).collect();
            let attributes = Attributes::of(&[("type", "road_border")]);
            map.linestrings.push(LineString { id: LineStringId(id), points, attributes, span: None });
            Bound { line: LineStringId(id), inverted: false }
        };
        let lanelets: Vec<[Bound; 2]> = bounds.iter().map(|bounds| bounds.map(&mut line)).collect();
        for (at, [left, right]) in (100..).zip(lanelets) {
            let (regulatory_elements, attributes) = (Vec::new(), Attributes::of(&[]));
            let id = LaneletId(at);
            map.lanelets.push(Lanelet {
                id,
                left,
                right,
                centerline: None,
                regulatory_elements,
                attributes,
                span: None,
            });
        }
        map
    }

    #[test]
    fn borders_over_the_same_points_are_one_line() {
        let mut map = map(&[[&[1, 2, 3], &[4, 5]], [&[3, 2, 1], &[6, 7]], [&[8, 9], &[1, 2, 3]]]);
        share_borders(&mut map);
        let lines: Vec<i64> = map.linestrings.iter().map(|line| line.id.0).collect();
        assert_eq!(lines, [1, 2, 4, 5], "of three lines over points 1 to 3 the first is left");
        let bound = |line: i64, inverted: bool| Bound { line: LineStringId(line), inverted };
        let bounds: Vec<[Bound; 2]> = map.lanelets.iter().map(|lanelet| [lanelet.left, lanelet.right]).collect();
        let wanted =
            [[bound(1, false), bound(2, false)], [bound(1, true), bound(4, false)], [bound(5, false), bound(1, false)]];
        assert_eq!(bounds, wanted);
    }

    #[test]
    fn borders_over_other_points_between_the_same_ends_stay() {
        let mut map = map(&[[&[1, 2, 3], &[4, 5]], [&[3, 9, 1], &[6, 7]]]);
        share_borders(&mut map);
        assert_eq!(map.linestrings.len(), 4);
    }
}
