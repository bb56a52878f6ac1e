//! From OpenStreetMap to a Lanelet2 map, one stage a file. Each stage borrows what came before and returns a new value.
//!
//! ```text
//! OsmData ─road_network→ RoadNetwork ─consolidate→ RoadNetwork ─outline→ Outlines ─lanes→ Lanes ─movement→ Movements
//!     └→ conflict, crosswalk, control, right_of_way ─assemble→ LaneletMap
//! ```
//!
//! Widths come before the outline (the cut-back needs the roads' edges), lane borders after it (they end at the cut).
//! Everything speaks of near and far, never of left and right, except where a tag or a role does.

pub mod consolidate;
pub mod cross_section;
pub mod driving_side;
pub mod geojson;
pub mod outline;
pub mod road_network;
pub(crate) mod speed;
pub(crate) mod tags;
