//! Stop lines: the line over the end of a lane before an intersection or crosswalk. The lane ends where `lanes::lane_ends` cuts its
//! road, or where `stop_line_segments` splits it.

use crate::builder::ids::Key;
use crate::builder::map::map_builder::MapBuilder;
use crate::lanelet::{Attributes, LineStringId, PointId};

/// The subtype of a stop line that no sign refers to: its paint.
pub const PAINTED_LINE: &str = "solid";
/// The subtype of the stop line of a sign: TIER IV's validator reads there, and Autoware in its type, what it is.
pub const SIGN_LINE: &str = "stop_line";

/// Adds a stop line on the end nodes of a lane.
pub fn stop_line(assembly: &mut MapBuilder, key: Key, nodes: [PointId; 2], subtype: &str) -> LineStringId {
    assembly.line(key.word("stop line"), nodes.to_vec(), Attributes::of(&[("type", "stop_line"), ("subtype", subtype)]))
}
