//! Runs the rules over a map, each as the user wants it.

use rayon::prelude::*;

use crate::diagnostic::Diagnostic;
use crate::lanelet::index::MapIndex;
use crate::parallel::InSmallParts;
use crate::settings::Profile;

use super::{Config, ConfigError, run_row, table, tier4};

/// Runs every rule over the map, in parallel. The findings are sorted by rule in the table's order, then by fault in the
/// document's order, then by subject, so the number of threads does not matter.
///
/// # Errors
///
/// If a parameter that the user gives has the wrong type.
pub fn run(map: &MapIndex, config: &Config) -> Result<Vec<Diagnostic>, ConfigError> {
    let rows = table().map_err(Clone::clone)?;
    if config.profile == Profile::Tier4 {
        return tier4::run(map, config);
    }
    let by_rule: Vec<Vec<Diagnostic>> =
        rows.par_iter().in_small_parts().map(|row| run_row(map, config, row)).collect::<Result<_, ConfigError>>()?;
    Ok(by_rule.into_iter().flatten().collect())
}
