//! What Autoware's planner will do with a map, as its modules read the map: whom it watches, where it stops, from where it blinks.
//!
//! Told is what follows from the map alone: for each lanelet with `turn_direction` what the modules intersection, merge from private,
//! blind spot, crosswalk, stop line, traffic light and turn signal take from it. What they make of vehicles, people and the colours of
//! lights is not. `docs/planner.md` names the versions that were read.

mod attention;
mod crosswalks;
mod forecast;
mod lines;
mod params;
mod path;
mod road_network;
mod sides;
mod strip;

pub use attention::{Attention, AttentionEnd, Ignored, Reach, Reason};
pub use crosswalks::{CrosswalkStop, StopAt};
pub use forecast::{Forecast, Outcome, Priority, Stopping, Watched};
pub use lines::{DefaultStop, EDGE, Lines, ReachesIn, StopSource, StuckArea};
pub use params::{Params, ParamsError};
pub use path::Front;
pub use road_network::{NoRoute, RoadNetwork, surroundings};
pub use sides::{BlindSpot, Blinker, PrivateRoad, SignLine, TrafficLight};
pub use strip::Strip;
