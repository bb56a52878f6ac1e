//! Paint and kerbs of OpenDRIVE as the tags of Lanelet2's linestrings.

use crate::lanelet::Attributes;
use crate::xodr::RoadMark;

/// What lies on both sides of a border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beside {
    /// Lanes for vehicles that go the same way.
    SameWay,
    /// Lanes for vehicles, one of which goes the other way.
    Opposed,
    /// A lane for vehicles on one side, and a strip beside it on which they may halt or others ride.
    Strip,
    /// A lane for vehicles on one side only.
    Edge,
    /// The outer border of such a strip.
    Kerb,
    /// None.
    Nothing,
}

/// The tags of a border along the road's reference line.
pub fn border(mark: Option<&RoadMark>, beside: Beside) -> Attributes {
    if beside == Beside::Kerb {
        return Attributes::of(&[("type", "road_border")]);
    }
    let kind = mark.map_or("none", |mark| mark.kind.as_str());
    let thick = mark.is_some_and(|mark| mark.weight == "bold");
    let line = if thick { "line_thick" } else { "line_thin" };
    let (name, subtype) = match kind {
        "solid" => (line, "solid"),
        "broken" => (line, "dashed"),
        "solid solid" => (line, "solid_solid"),
        "solid broken" => (line, "solid_dashed"),
        "broken solid" => (line, "dashed_solid"),
        "broken broken" | "botts dots" => (line, "dashed"),
        "curb" | "grass" | "edge" if beside != Beside::Strip => ("road_border", ""),
        _ if beside == Beside::Edge => ("road_border", ""),
        _ => ("virtual", ""),
    };
    let mut tags = Attributes::of(&[("type", name)]);
    if !subtype.is_empty() {
        tags.push("subtype", subtype);
    }
    let colors = ["yellow", "blue", "red", "green", "orange", "violet"];
    let color = mark.map(|mark| mark.color.as_str()).filter(|color| !subtype.is_empty() && colors.contains(color));
    if let Some(color) = color {
        tags.push("color", color);
    }
    if beside == Beside::Nothing {
        return tags;
    }
    let said = mark.map_or("", |mark| mark.lane_change.as_str());
    // Lanes of larger ids lie to the left of the reference line.
    let [leftward, rightward] = match (beside, said, subtype) {
        (Beside::Opposed | Beside::Edge | Beside::Strip, ..) => [false; 2],
        (_, "both", _) => [true; 2],
        (_, "increase", _) => [true, false],
        (_, "decrease", _) => [false, true],
        (_, "none", _) => [false; 2],
        // From the side of the broken line one may cross. Of two lines the left one comes first.
        (_, _, "dashed_solid") => [false, true],
        (_, _, "solid_dashed") => [true, false],
        (_, _, "dashed") => [true; 2],
        // Nothing is painted and nothing is said: nothing forbids it.
        (_, _, "") if name == "virtual" => [true; 2],
        _ => [false; 2],
    };
    match [leftward, rightward] {
        [true, true] => tags.push("lane_change", "yes"),
        [false, false] => tags.push("lane_change", "no"),
        [leftward, _] => {
            tags.push("lane_change:left", if leftward { "yes" } else { "no" });
            tags.push("lane_change:right", if leftward { "no" } else { "yes" });
        }
    }
    tags
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tags(kind: &str, lane_change: &str, beside: Beside) -> Vec<String> {
        let mark = RoadMark { kind: kind.into(), lane_change: lane_change.into(), ..RoadMark::default() };
        let tags = border(Some(&mark), beside);
        ["type", "subtype", "lane_change", "lane_change:left"]
            .map(|key| tags.get(key).unwrap_or("").to_owned())
            .to_vec()
    }

    #[test]
    fn paint_tells_who_may_cross_it() {
        assert_eq!(tags("broken", "", Beside::SameWay), ["line_thin", "dashed", "yes", ""]);
        assert_eq!(tags("broken", "none", Beside::SameWay), ["line_thin", "dashed", "no", ""]);
        assert_eq!(tags("broken", "", Beside::Opposed), ["line_thin", "dashed", "no", ""]);
        assert_eq!(tags("solid broken", "", Beside::SameWay), ["line_thin", "solid_dashed", "", "yes"]);
        assert_eq!(tags("solid", "decrease", Beside::SameWay), ["line_thin", "solid", "", "no"]);
        assert_eq!(tags("none", "", Beside::Edge), ["road_border", "", "no", ""]);
        assert_eq!(tags("none", "", Beside::SameWay), ["virtual", "", "yes", ""]);
    }
}
