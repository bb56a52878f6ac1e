//! What a rule is: a function over the whole map.

use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;

/// How a program judges a requirement.
pub type Predicate = fn(&MapIndex, toml::Table) -> Result<Vec<Finding>, toml::de::Error>;

/// For rules without parameters.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoParams {}

/// A rule finds every place where the map breaks one requirement; an empty list is a clean map. It knows neither its number nor its
/// severity nor how a finding is shown: its document in `rules/` says all three, and the defaults of its parameters.
pub type Check<P> = fn(&MapIndex, &P) -> Vec<Finding>;

/// Reads the parameters of a rule and runs it.
pub fn judge<P: DeserializeOwned>(
    check: Check<P>,
    map: &MapIndex,
    params: toml::Table,
) -> Result<Vec<Finding>, toml::de::Error> {
    Ok(check(map, &toml::Value::Table(params).try_into()?))
}
