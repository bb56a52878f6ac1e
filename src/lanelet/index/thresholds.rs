//! The numbers of the notions that all rules share: when two lanelets conflict, when one lies in an intersection, what makes an
//! approach. A rule's own numbers are in its document.

/// Share of a lanelet's area that an intersection area must cover for it to lie inside (1). Hand-drawn maps that
/// comply reach 0.996.
pub const COVER: f64 = 0.99;
/// A lanelet smaller than this (m2) lies in no area by its geometry alone: a sliver of a lane tells nothing.
pub const LEAST_AREA: f64 = 1.0;
/// Two lanelets whose overlap is larger than this (m2) conflict for Autoware, which has no threshold; below lies
/// the noise of clipping.
pub const RAW_CONFLICT: f64 = 1e-4;
/// From this share of a lanelet's area (1) an overlap is a conflict for the rules as well ...
pub const REAL_SHARE: f64 = 0.01;
/// ... or from this area (m2).
pub const REAL_AREA: f64 = 0.25;
/// More vertical distance than this (m) between two lanelets is a bridge, or a floor of a car park: under less no car drives,
/// since a ceiling at 2 m is the lowest, and the deck itself is thick.
pub const GRADE_SEPARATION: f64 = 2.5;
/// Edges of one approach lie on one line within this angle (deg) ...
pub const ARM_ANGLE: f64 = 20.0;
/// ... and this distance of their middles from each other's line (m) ...
pub const ARM_LINE: f64 = 0.5;
/// ... and are no farther apart than a wide road with its median (m).
pub const ARM_REACH: f64 = 30.0;
/// Two edges that share a point belong to one approach up to this angle (deg); beyond it the point is the corner
/// between two.
pub const ARM_CORNER: f64 = 60.0;
/// Two approaches are opposite if their headings differ from 180 by no more than this (deg).
pub const OPPOSITE: f64 = 45.0;
/// Two approaches that refer to the same light are green together if the angle between their directions is no larger
/// than this (deg): the face of a light cannot be read from the side.
pub const SHARED_LIGHT: f64 = 60.0;
/// A stop line farther than this (m) from the start of a lanelet belongs to something else ...
pub const STOP_LINE_REACH: f64 = 2.0;
/// ... and so does one that is abreast of less than this share (1) of it, unless the lanelet refers to it.
pub const STOP_LINE_OVERLAP: f64 = 0.5;
