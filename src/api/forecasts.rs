//! What Autoware's planner will do with a map.

use crate::lanelet::LaneletId;
use crate::lanelet::index::view::View;
use crate::planner::{Forecast, NoRoute, Params, RoadNetwork, surroundings};
use crate::projection::LonLat;
use crate::report::failure::Failure;

use super::error::{Error, ErrorKind};
use super::{Configuration, Input, Loaded};

/// Of which lanelets it is told what the planner will do.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Along {
    /// All with a `turn_direction`.
    #[default]
    Intersections,
    /// These, by id.
    Lanelets(Vec<i64>),
    /// Those at a place: with a `turn_direction` if there are any.
    At(LonLat),
    /// Those with a `turn_direction` on the shortest way between two lanelets, without changing lanes.
    Route {
        /// Where it begins.
        from: i64,
        /// Where it ends.
        to: i64,
    },
}

/// Tells what Autoware's planner will do on lanelets of a map, in the order of the file or of the route.
///
/// # Errors
///
/// Where the map cannot be read, has no such lanelet, or there is none at the place.
pub fn forecast(map: impl Into<Input>, along: &Along, params: &Params) -> Result<Vec<Forecast>, Error> {
    let loaded = Loaded::read(map, &Configuration::default())?;
    forecasts(&loaded, along, params).map_err(ErrorKind::Read.of())
}

/// The same of a map that is read already.
pub(crate) fn forecasts(loaded: &Loaded, along: &Along, params: &Params) -> Result<Vec<Forecast>, Failure> {
    /// For more lanelets than this the whole map is looked at once.
    const FEW: usize = 4;
    if let Along::Lanelets(ids) = along
        && ids.len() <= FEW
    {
        let found: Result<Vec<Option<Forecast>>, Failure> =
            ids.iter().map(|&id| of_lanelet(loaded, id, params).map_err(no_route)).collect();
        return Ok(found?.into_iter().flatten().collect());
    }
    let view = View::new(&loaded.map);
    let network = RoadNetwork::new(&view);
    let (lanelets, route) = chosen(loaded, &network, along)?;
    let all = lanelets.iter().filter_map(|&at| network.forecast(at, &route, params));
    Ok(all.collect())
}

/// What the planner will do on one lanelet, found from what lies around it.
fn of_lanelet(loaded: &Loaded, id: i64, params: &Params) -> Result<Option<Forecast>, NoRoute> {
    let view = surroundings(&loaded.map, LaneletId(id), params).ok_or(NoRoute::NoSuchLanelet(id))?;
    let network = RoadNetwork::new(&view);
    Ok(network.forecast(network.lanelet(id)?, &[], params))
}

/// Why there is no such lanelet or route, with a way out.
fn no_route(error: NoRoute) -> Failure {
    let help = match error {
        NoRoute::NoSuchLanelet(_) => "`lanewright draw MAP --ids` writes the ids of lanelets into the picture",
        NoRoute::NotForVehicles(_) => "name a lanelet with subtype road, or one that vehicles may enter",
        NoRoute::NotConnected(..) => "name two lanelets of which one is reached from the other straight on or by turns",
    };
    Failure::new(error.to_string()).help(help)
}

/// The lanelets, and the route on which they lie.
fn chosen(loaded: &Loaded, network: &RoadNetwork<'_, '_>, along: &Along) -> Result<(Vec<usize>, Vec<usize>), Failure> {
    let all = || (0..network.view.lanelets.len()).filter(|&at| network.graph.passes(at));
    let turns = |at: &usize| network.turn(*at).is_some();
    match along {
        Along::Intersections => Ok((all().filter(turns).collect(), Vec::new())),
        Along::Lanelets(ids) => {
            let lanelets: Result<Vec<usize>, NoRoute> = ids.iter().map(|&id| network.lanelet(id)).collect();
            Ok((lanelets.map_err(no_route)?, Vec::new()))
        }
        Along::At(place) => {
            let LonLat { lat, lon } = *place;
            let spot = loaded.projector.forward(*place, 0.0).ok_or_else(|| {
                let name = loaded.projector.name();
                Failure::new(format!("the projection {name} of this map does not reach {lat},{lon}"))
                    .help("use --lanelet ID")
            })?;
            let there = network.at(spot);
            let turning: Vec<usize> = there.iter().copied().filter(turns).collect();
            match (turning.is_empty(), there.is_empty()) {
                (false, _) => Ok((turning, Vec::new())),
                (true, false) => Ok((there, Vec::new())),
                (true, true) => Err(Failure::new(format!("no lanelet for vehicles lies at {lat},{lon}"))
                    .help("give a place inside an intersection, or use --lanelet ID")),
            }
        }
        &Along::Route { from, to } => {
            let route = network.route(from, to).map_err(no_route)?;
            Ok((route.iter().copied().filter(turns).collect(), route))
        }
    }
}
