//! What a rule is: a sentence over the whole map.

use serde::de::DeserializeOwned;

use crate::diagnostic::Finding;
use crate::lanelet::index::MapIndex;

/// One requirement, as a program judges it. A rule knows neither its number nor its severity nor how a finding is
/// shown; its document in `rules/` says all three.
pub trait Rule {
    /// What a user may tune; the defaults stand in the rule's document.
    type Params: DeserializeOwned;

    /// Every place where the map breaks the requirement. An empty list is a clean map.
    fn check(map: &MapIndex, params: &Self::Params) -> Vec<Finding>;
}

/// For rules without parameters.
#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoParams {}
