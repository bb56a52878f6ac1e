//! The numbers of the notions that all rules share.

/// When two lanelets conflict, when one lies in an intersection, what makes an approach. A rule's own numbers are
/// in its document.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// Share of a lanelet's area that an intersection area must cover for it to lie inside (1). Hand-drawn maps that
    /// comply reach 0.996.
    pub cover: f64,
    /// A lanelet smaller than this (m2) lies in no area by its geometry alone: a sliver of a lane tells nothing.
    pub least_area: f64,
    /// Two lanelets whose overlap is larger than this (m2) conflict for Autoware, which has no threshold; below lies
    /// the noise of clipping.
    pub raw_conflict: f64,
    /// From this share of a lanelet's area (1) an overlap is a conflict for the rules as well ...
    pub real_share: f64,
    /// ... or from this area (m2).
    pub real_area: f64,
    /// More vertical distance than this (m) between two lanelets is a bridge: no vehicle is as low.
    pub grade_separation: f64,
    /// Edges of one approach lie on one line within this angle (deg) ...
    pub arm_angle: f64,
    /// ... and this distance of their middles from each other's line (m) ...
    pub arm_line: f64,
    /// ... and are no farther apart than a wide road with its median (m).
    pub arm_reach: f64,
    /// Two edges that share a point belong to one approach up to this angle (deg); beyond it the point is the corner
    /// between two.
    pub arm_corner: f64,
    /// Two approaches are opposite if their headings differ from 180 by no more than this (deg).
    pub opposite: f64,
    /// Two approaches that refer to the same light are green together if the angle between their directions is no larger
    /// than this (deg): the face of a light cannot be read from the side.
    pub shared_light: f64,
    /// A stop line farther than this (m) from the start of a lanelet belongs to something else ...
    pub stop_line_reach: f64,
    /// ... and so does one that is abreast of less than this share (1) of it, unless the lanelet refers to it.
    pub stop_line_overlap: f64,
}

impl Default for Thresholds {
    fn default() -> Self {
        Self {
            cover: 0.99,
            least_area: 1.0,
            raw_conflict: 1e-4,
            real_share: 0.01,
            real_area: 0.25,
            grade_separation: 3.0,
            arm_angle: 20.0,
            arm_line: 0.5,
            arm_reach: 30.0,
            arm_corner: 60.0,
            opposite: 45.0,
            shared_light: 60.0,
            stop_line_reach: 2.0,
            stop_line_overlap: 0.5,
        }
    }
}
