//! How things look: the colours, and the width of each line at a scale.

use std::fmt::Write;

use crate::lane_stitching::{KERB, Kind, PAINT, Paint};
use crate::lanelet::{Attributes, RoadType, TurnDirection};

/// How a linestring is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// True to scale, in a class.
    True(Kind, &'static str),
    /// One line of a class.
    Single(&'static str),
    /// By something other than a line along its points.
    Elsewhere,
}

/// Class of yellow paint.
pub const YELLOW: &str = "paint-yellow";
/// Its style, for drawings that have such paint.
pub const YELLOW_PAINT: &str = ".paint-yellow{stroke:#ffc933}\n";
/// Class of an area that vehicles may cross.
pub const PASSAGE: &str = "passage";
/// Its style, for drawings that have such areas.
pub const PASSAGE_GROUND: &str = ".passage{fill:#b9a58a;fill-opacity:.55;stroke:#8d7656;stroke-width:.8}\n";

/// How what is pointed at looks.
pub const MARKED: &str = ".marked{fill:none;stroke:#0a7d4b;stroke-width:2.6;stroke-dasharray:7 4}\n\
    .marked-halo{fill:none;stroke:#fff;stroke-opacity:.85;stroke-width:5}\n";

/// How a linestring of these tags is drawn.
pub fn stroke(attributes: &Attributes) -> Stroke {
    let paint = if attributes.is("color", "yellow") { Paint::Yellow } else { Paint::White };
    let painted = match attributes.get("subtype").unwrap_or_default() {
        "dashed" => Kind::Dashed(paint),
        "solid_solid" => Kind::Double(paint),
        "solid_dashed" => Kind::SolidDashed(paint),
        "dashed_solid" => Kind::DashedSolid(paint),
        _ => Kind::Solid(paint),
    };
    match attributes.get("type").unwrap_or_default() {
        "line_thin" => Stroke::True(painted, "paint thin"),
        "line_thick" => Stroke::True(painted, "paint thick"),
        "guide_line" => Stroke::True(Kind::Dashed(paint), "paint thin"),
        "virtual" => Stroke::Single("virtual"),
        "road_border" | "curbstone" | "road_boarder" => Stroke::True(Kind::Kerb, "kerb"),
        "guard_rail" | "wall" | "fence" => Stroke::Single("barrier"),
        "stop_line" | "yield_line" => Stroke::Single("stop"),
        "pedestrian_marking" | "zebra_marking" | "bike_marking" => Stroke::Single("zebra-edge"),
        "traffic_light" | "light_bulbs" | "traffic_sign" => Stroke::Elsewhere,
        _ => Stroke::Single("other"),
    }
}

/// The class of a lanelet's surface.
pub fn surface(attributes: &Attributes) -> &'static str {
    match (RoadType::of(attributes), turn(attributes)) {
        (RoadType::Road, Some(TurnDirection::Left)) => "turn left",
        (RoadType::Road, Some(TurnDirection::Straight)) => "turn straight",
        (RoadType::Road, Some(TurnDirection::Right)) => "turn right",
        (RoadType::Road, None)
            if attributes.is("participant:bicycle", "yes") && !attributes.has("participant:vehicle") =>
        {
            "bicycle"
        }
        (RoadType::Road, None) => "road",
        (RoadType::Shoulder, _) => "shoulder",
        (RoadType::PedestrianLane | RoadType::Walkway, _) => "walk",
        (RoadType::BicycleLane, _) => "bicycle",
        (RoadType::Crosswalk, _) => "crossing",
        (RoadType::Other, _) => "unknown",
    }
}

/// The class of a lanelet's direction arrow.
pub fn arrow(attributes: &Attributes) -> &'static str {
    match turn(attributes) {
        Some(TurnDirection::Left) => "left",
        Some(TurnDirection::Straight) => "straight",
        Some(TurnDirection::Right) => "right",
        None => "plain",
    }
}

/// The class of a polygon.
pub fn area(attributes: &Attributes) -> &'static str {
    match attributes.get("type").unwrap_or_default() {
        "intersection_area" => "box",
        "hatched_road_markings" => "hatched",
        "no_stopping_area" | "no_parking_area" => "forbidden",
        "no_obstacle_segmentation_area" | "no_obstacle_segmentation_area_for_run_out" | "obstacle_removal_area" => {
            "forbidden"
        }
        "detection_area" => "watched",
        "crosswalk_polygon" => "zebra-outline",
        "speed_bump" => "bump",
        _ => "lot",
    }
}

/// What `turn_direction` says.
pub fn turn(attributes: &Attributes) -> Option<TurnDirection> {
    attributes.get("turn_direction").and_then(TurnDirection::parse)
}

/// How broad lines of a class are in metres, and the least in pixels.
const BREADTHS: [(&str, f64, f64); 12] = [
    ("thin", PAINT, 0.7),
    ("thick", 2.0 * PAINT, 1.1),
    ("kerb", KERB, 0.9),
    ("barrier", 0.3, 1.1),
    ("stop", 0.4, 1.3),
    ("virtual", 0.07, 0.5),
    ("other", 0.08, 0.6),
    ("path", 0.12, 0.7),
    ("box", 0.1, 0.9),
    ("zebra-edge", 0.08, 0.5),
    ("lamp-body", 0.32, 2.2),
    ("glow", 0.9, 4.0),
];

/// How broad a line of a class is, metres.
pub fn breadth(class: &str) -> f64 {
    let of = |name: &str| class.split(' ').any(|word| word == name);
    BREADTHS.iter().find(|(name, ..)| of(name)).map_or(0.0, |(_, metres, _)| *metres)
}

/// The style sheet for a scale in pixels per metre. Widths are those of real paint, but never too thin to see.
pub fn sheet(scale: f64) -> String {
    let wide = |metres: f64, least: f64| (metres * scale).max(least);
    let mut css = String::from(FLAT);
    for (class, metres, least) in BREADTHS {
        let _ = writeln!(css, ".{class}{{stroke-width:{:.2}}}", wide(metres, least));
    }
    for (class, on, off) in [
        (".virtual", wide(0.35, 1.5), wide(0.35, 1.5)),
        (".box", wide(0.9, 3.0), wide(0.45, 2.0)),
        (".barrier", wide(0.9, 3.0), wide(0.25, 1.0)),
    ] {
        let _ = writeln!(css, "{class}{{stroke-dasharray:{on:.1} {off:.1}}}");
    }
    css
}

/// What does not depend on the scale. Colour-blind people can distinguish the hues of the turns, too.
const FLAT: &str = "\
path,circle,rect{fill:none;stroke-linejoin:round}
.ground{fill:#eceee8}
.road{fill:#6a717b}
.shoulder{fill:#8b9099}
.walk{fill:#d9d2c0}
.bicycle{fill:#8a6a66}
.crossing{fill:#2f343b;fill-opacity:.3}
.unknown{fill:#a9adb3}
.turn{fill-opacity:.34}
.turn.left{fill:#f2a63b}
.turn.straight{fill:#5fb6ef}
.turn.right{fill:#43c790}
.seam{stroke:#4c525a;stroke-opacity:.35;stroke-width:.6}
.box{fill:#565c65;stroke:#f4d35e}
.hatched{fill:#b9bdc3;stroke:#fff;stroke-width:1}
.forbidden{fill:#d64550;fill-opacity:.22;stroke:#d64550;stroke-width:.8}
.watched{fill:#3d7fd6;fill-opacity:.2;stroke:#3d7fd6;stroke-width:.8}
.zebra-outline{stroke:#fff;stroke-opacity:.6;stroke-width:.8}
.bump{fill:#e7c24a;fill-opacity:.6}
.lot{fill:#c5c9c2;fill-opacity:.7;stroke:#a4a99f;stroke-width:.6}
.paint{stroke:#fff}
.zebra{fill:#fff;fill-opacity:.62}
.zebra-edge{stroke:#fff;stroke-opacity:.7}
.kerb{stroke:#24282d;stroke-linecap:round}
.barrier{stroke:#3b2f63}
.stop{stroke:#ff4b4b}
.virtual{stroke:#cfe0f5;stroke-opacity:.75}
.other{stroke:#8d6cc9}
.path{stroke-opacity:.95}
.path.left{stroke:#ffb84d}.tip.left{fill:#ffb84d}
.path.straight{stroke:#7cc8ff}.tip.straight{fill:#7cc8ff}
.path.right{stroke:#58e0a6}.tip.right{fill:#58e0a6}
.path.plain{stroke:none}.tip.plain{fill:#fff;fill-opacity:.5}
.lamp-body{stroke:#17191c;stroke-linecap:round}
.lamp-rim{fill:#17191c}
.red{fill:#ff5148}.yellow{fill:#ffc933}.green{fill:#35d07f}.white{fill:#fff}
.sign{fill:#2f6fd0;stroke:#fff;stroke-width:1}
.halt{fill:#d62839;stroke:#fff;stroke-width:1}
.halo{stroke:#fff;stroke-opacity:.85;stroke-linecap:round}
.pen{stroke:#1d2024;stroke-linecap:round}
.id-turn .pen{stroke:#123a5a}.id-area .pen{stroke:#7a5b00}.id-rule .pen{stroke:#8b1a5b}
.glow{stroke-opacity:.45;stroke-linecap:round}
.glow.error{stroke:#e01e37}.glow.warning{stroke:#ff8c1a}.glow.info{stroke:#2f80ed}
.veil{fill-opacity:.1;stroke-opacity:.85;stroke-width:1.8}
.veil.error{fill:#e01e37;stroke:#e01e37}.veil.warning{fill:#ff8c1a;stroke:#ff8c1a}.veil.info{fill:#2f80ed;stroke:#2f80ed}
.spot{fill-opacity:.3}
.spot.error{fill:#e01e37}.spot.warning{fill:#ff8c1a}.spot.info{fill:#2f80ed}
.pin{stroke:#fff;stroke-width:1.4}
.pin.error{fill:#e01e37}.pin.warning{fill:#f27d0c}.pin.info{fill:#2f80ed}
.found .pen{stroke:#1d2024}
.rule{stroke:#1d2024;stroke-width:1.4}
.card{fill:#fff;fill-opacity:.86}
.carriage{fill:#6a717b;fill-opacity:.55}
.strip{stroke:#fff;stroke-opacity:.6;stroke-width:.8}
.strip-drive{fill:#6a717b}.strip-bus{fill:#8a6a3a}.strip-bicycle{fill:#8a6a66}.strip-parking{fill:#7f8f9f}
.strip-shoulder{fill:#8b9099}.strip-pedestrian{fill:#a8a493}.strip-sidewalk{fill:#d9d2c0}.strip-buffer{fill:#b9c4a8}
.outline{fill:#9aa1ab;stroke:#f4d35e;stroke-width:1.6}
.outline.merged{fill:#c3b3e3}.outline.fallback{fill:#d98a86}.outline.changed{fill:#d98c2b;stroke:#b3261e;stroke-width:2.4}
.centre{stroke:#1d2024;stroke-width:1;stroke-dasharray:5 4}
.edge{stroke:#3d7fd6;stroke-width:1.2}
.foot{stroke:#e01e37;stroke-opacity:.5;stroke-width:1}
.least{stroke:#f27d0c;stroke-width:2.2}
.wanted{stroke:#2f9e62;stroke-width:2.2}
.cut{stroke:#1d2024;stroke-width:2.6}
.in{stroke:#8c5bd6;stroke-width:3}.out{stroke:#2f9e62;stroke-width:3}
.node{fill:#1d2024}.hit{fill:#7aa7e0;stroke:#fff;stroke-width:.8}.decides{fill:#e01e37;stroke:#fff;stroke-width:1}
.swatch.centre,.swatch.node{fill:#1d2024}.swatch.edge{fill:#3d7fd6}.swatch.hit{fill:#7aa7e0}.swatch.decides{fill:#e01e37}
.swatch.least{fill:#f27d0c}.swatch.wanted,.swatch.out{fill:#2f9e62}.swatch.cut{fill:#1d2024}.swatch.in{fill:#8c5bd6}
.swatch.left{fill:#f2a63b}.swatch.straight{fill:#5fb6ef}.swatch.right{fill:#43c790}
";

#[cfg(test)]
mod tests {
    use super::*;

    fn tags(pairs: &[(&str, &str)]) -> Attributes {
        pairs.iter().copied().collect()
    }

    #[test]
    fn a_double_line_keeps_its_order() {
        let dashed_left = stroke(&tags(&[("type", "line_thin"), ("subtype", "dashed_solid"), ("color", "yellow")]));
        assert_eq!(dashed_left, Stroke::True(Kind::DashedSolid(Paint::Yellow), "paint thin"));
    }

    #[test]
    fn turns_have_their_hue() {
        let left = tags(&[("subtype", "road"), ("turn_direction", "left")]);
        assert_eq!(surface(&left), "turn left");
        assert_eq!(surface(&tags(&[("subtype", "road"), ("turn_direction", "up")])), "road");
    }

    #[test]
    fn thin_paint_stays_visible() {
        assert!(sheet(0.1).contains(".thin{stroke-width:0.70}"));
        assert!(sheet(20.0).contains(".thin{stroke-width:2.40}"));
    }
}
