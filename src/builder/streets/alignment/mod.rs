//! Where each carriageway lies: OpenStreetMap's lines, bent and shifted as roads of their width can follow them.

mod abreast;
mod ease;
mod narrow;
mod sides;

use rayon::prelude::*;

use crate::builder::network::RoadNetwork;
use crate::parallel::Finely;

use ease::TIGHTEST;

pub use abreast::abreast;
pub use ease::eased;
pub use narrow::narrowed;

/// The network with the bends of every road eased to what its width can follow. Stations of features move with their
/// places.
#[must_use]
pub fn ease(mut network: RoadNetwork) -> RoadNetwork {
    network.roads.par_iter_mut().finely().for_each(|road| {
        let line = eased(&road.line, road.half_width());
        for feature in &mut road.features {
            feature.station = line.project(road.line.at(feature.station)).station;
        }
        road.line = line;
    });
    network
}
