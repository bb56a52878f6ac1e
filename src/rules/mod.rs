//! The table of the standard: number, document, predicate.

mod access;
mod area;
mod area_element;
mod barrier;
mod bound_count;
mod centerline_ends;
mod check;
mod config;
mod crowd;
mod cut_bound;
mod disordered_bound;
mod divided_lanelets;
mod ends_at_stop_line;
mod engine;
mod exchanged_lights;
mod far_lanes;
mod geoid;
mod health;
mod ids;
mod landmark;
mod lane_kinds;
mod lanelet_pieces;
mod light_places;
mod load;
mod lost_members;
mod map_border;
mod merged_borders;
mod merged_lanelets;
mod near_nodes;
mod node;
mod obeyed_light;
mod parallel_bounds;
mod parts;
mod routing_moves;

mod crosswalk_element;
mod driving_side;
mod element_size;
mod opposing_overlap;
mod phase;
mod pictures;
mod planner;
mod projector;
mod redrawn_area;
mod right_of_way_element;
mod road_borders;
mod roundabout;
mod side_lane;
mod signal;
mod stop_line_crossings;
mod tag;
pub mod tier4;
mod two_way;

mod virtual_light;
mod vm_01_01;
mod vm_01_02;
mod vm_01_03;
mod vm_01_04;
mod vm_01_05;
mod vm_01_08;
mod vm_01_09;
mod vm_01_10;
mod vm_01_11;
mod vm_01_12;
mod vm_01_13;
mod vm_01_14;
mod vm_01_15;
mod vm_01_16;
mod vm_01_17;
mod vm_01_18;
mod vm_01_19;
mod vm_01_20;
mod vm_01_21;
mod vm_02_01;
mod vm_02_02;
mod vm_02_03;
mod vm_02_04;
mod vm_03_01;
mod vm_03_02;
mod vm_03_03;
mod vm_03_04;
mod vm_03_05;
mod vm_03_06;
mod vm_03_07;
mod vm_03_08;
mod vm_03_09;
mod vm_03_10;
mod vm_03_11;
mod vm_03_12;
mod vm_03_13;
mod vm_03_14;
mod vm_03_15;
mod vm_03_16;
mod vm_03_17;
mod vm_03_18;
mod vm_04_01;
mod vm_04_02;
mod vm_04_03;
mod vm_05_01;
mod vm_05_02;
mod vm_05_03;
mod vm_05_04;
mod vm_06_01;
mod vm_06_02;
mod vm_06_03;
mod vm_06_04;
mod vm_06_05;
mod vm_06_06;
mod vm_07_01;
mod vm_07_02;
mod vm_07_03;
mod vm_07_04;
mod vm_07_05;
mod vm_07_06;
mod vm_07_07;
mod vm_07_08;
mod walkway;

use std::sync::LazyLock;

pub use config::{Config, ConfigError, vet};
pub use engine::run;

use check::{NoParams, Predicate, judge};

use crate::cancel;
use crate::diagnostic::{Diagnostic, Finding, Severity};
use crate::lanelet::index::MapIndex;
use crate::requirement::{DocumentError, Requirement};

/// One line of the table.
#[derive(Debug)]
pub struct Row {
    /// The document, parsed.
    pub requirement: Requirement,
    /// The predicate; `None` where a requirement needs eyes.
    predicate: Option<Predicate>,
}

macro_rules! predicate {
    (needs_eyes) => {
        None
    };
    ($rule:ident) => {
        Some(|map, params| judge($rule::check, map, params))
    };
}

macro_rules! table {
    ($($id:literal => $rule:ident),* $(,)?) => {
        /// Number, document and predicate of every requirement, in the standard's order.
        const TABLE: &[(&str, &str, Option<Predicate>)] =
            &[$(($id, include_str!(concat!("../../rules/", $id, ".md")), predicate!($rule))),*];
    };
}

table! {
    "load" => load,
    "ids" => ids,
    "node" => node,
    "projector" => projector,
    "side" => driving_side,
    "phase" => phase,
    "tag" => tag,
    "access" => access,
    "parts" => parts,
    "area" => area,
    "roundabout" => roundabout,
    "signal" => signal,
    "landmark" => landmark,
    "health" => health,
    "planner" => planner,
    "vm-01-01" => vm_01_01,
    "vm-01-02" => vm_01_02,
    "vm-01-03" => vm_01_03,
    "vm-01-04" => vm_01_04,
    "vm-01-05" => vm_01_05,
    "vm-01-06" => needs_eyes,
    "vm-01-07" => needs_eyes,
    "vm-01-08" => vm_01_08,
    "vm-01-09" => vm_01_09,
    "vm-01-10" => vm_01_10,
    "vm-01-11" => vm_01_11,
    "vm-01-12" => vm_01_12,
    "vm-01-13" => vm_01_13,
    "vm-01-14" => vm_01_14,
    "vm-01-15" => vm_01_15,
    "vm-01-16" => vm_01_16,
    "vm-01-17" => vm_01_17,
    "vm-01-18" => vm_01_18,
    "vm-01-19" => vm_01_19,
    "vm-01-20" => vm_01_20,
    "vm-01-21" => vm_01_21,
    "vm-02-01" => vm_02_01,
    "vm-02-02" => vm_02_02,
    "vm-02-03" => vm_02_03,
    "vm-02-04" => vm_02_04,
    "vm-03-01" => vm_03_01,
    "vm-03-02" => vm_03_02,
    "vm-03-03" => vm_03_03,
    "vm-03-04" => vm_03_04,
    "vm-03-05" => vm_03_05,
    "vm-03-06" => vm_03_06,
    "vm-03-07" => vm_03_07,
    "vm-03-08" => vm_03_08,
    "vm-03-09" => vm_03_09,
    "vm-03-10" => vm_03_10,
    "vm-03-11" => vm_03_11,
    "vm-03-12" => vm_03_12,
    "vm-03-13" => vm_03_13,
    "vm-03-14" => vm_03_14,
    "vm-03-15" => vm_03_15,
    "vm-03-16" => vm_03_16,
    "vm-03-17" => vm_03_17,
    "vm-03-18" => vm_03_18,
    "vm-04-01" => vm_04_01,
    "vm-04-02" => vm_04_02,
    "vm-04-03" => vm_04_03,
    "vm-05-01" => vm_05_01,
    "vm-05-02" => vm_05_02,
    "vm-05-03" => vm_05_03,
    "vm-05-04" => vm_05_04,
    "vm-06-01" => vm_06_01,
    "vm-06-02" => vm_06_02,
    "vm-06-03" => vm_06_03,
    "vm-06-04" => vm_06_04,
    "vm-06-05" => vm_06_05,
    "vm-06-06" => vm_06_06,
    "vm-07-01" => vm_07_01,
    "vm-07-02" => vm_07_02,
    "vm-07-03" => vm_07_03,
    "vm-07-04" => vm_07_04,
    "vm-07-05" => vm_07_05,
    "vm-07-06" => vm_07_06,
    "vm-07-07" => vm_07_07,
    "vm-07-08" => vm_07_08,
}

/// All requirements in the standard's order.
///
/// # Errors
///
/// If a document of `rules/` was spoilt before compiling, which a test prevents.
pub fn table() -> Result<&'static [Row], &'static DocumentError> {
    static ROWS: LazyLock<Result<Vec<Row>, DocumentError>> = LazyLock::new(|| {
        let rows = TABLE.iter().map(|&(id, text, predicate)| {
            let requirement = Requirement::parse(id, text)?;
            Ok(Row { requirement: Requirement { pictures: pictures::of(id), ..requirement }, predicate })
        });
        rows.collect()
    });
    ROWS.as_deref()
}

/// The requirement of this number; a slug behind it (`vm-03-08/closed`) is passed over.
pub fn find(code: &str) -> Option<&'static Requirement> {
    let id = code.split('/').next()?;
    table().ok()?.iter().map(|row| &row.requirement).find(|requirement| requirement.id == id)
}

/// The requirements that a run is about, in the standard's order.
pub fn selected(config: &Config) -> Vec<&'static Requirement> {
    let rows = table().unwrap_or_default();
    rows.iter().map(|row| &row.requirement).filter(|requirement| config.wants_rule(requirement)).collect()
}

fn run_row(map: &MapIndex, config: &Config, row: &Row) -> Result<Vec<Diagnostic>, ConfigError> {
    cancel::look();
    let requirement = &row.requirement;
    let Some(predicate) = row.predicate.filter(|_| config.wants_rule(requirement)) else {
        return Ok(Vec::new());
    };
    let mut params = requirement.defaults();
    let own = config.parameters.get(&requirement.id);
    params.extend(own.into_iter().flatten().map(|(name, value)| (name.clone(), value.clone())));
    let mut findings = predicate(map, params).map_err(|error| ConfigError::Parameter {
        rule: requirement.id.clone(),
        message: error.message().to_owned(),
    })?;
    let rank = |fault: &str| requirement.faults.iter().position(|(slug, _)| slug == fault);
    findings.sort_by(|a, b| {
        (rank(a.fault), a.subject).cmp(&(rank(b.fault), b.subject)).then_with(|| a.message.cmp(&b.message))
    });
    let diagnostics = findings.into_iter().map(|finding| diagnostic(map, config, requirement, finding));
    Ok(diagnostics.filter(|diagnostic| config.selection.wants(&diagnostic.code)).collect())
}

/// A finding with number, severity, help and places.
fn diagnostic(map: &MapIndex, config: &Config, requirement: &Requirement, finding: Finding) -> Diagnostic {
    let code = format!("{}/{}", requirement.id, finding.fault);
    let fault = requirement.fault(finding.fault);
    // The user's word is above the rule's grading, which is above the document's.
    let severity = config.severity(&code).or(finding.severity);
    let severity = severity.or(fault.map(|fault| fault.severity)).unwrap_or(Severity::Error);
    let found = crate::lanelet::locate::locate(map.map, finding.subject, &finding.place);
    Diagnostic {
        code,
        severity,
        help: finding.help.map(str::to_owned).or_else(|| fault.map(|fault| fault.help.clone())),
        span: finding.span.clone().or(found.span),
        lonlat: found.lonlat,
        local: found.local,
        finding,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::requirement::Check;

    #[test]
    fn every_document_parses_and_its_defaults_fit_the_rule() {
        let map = crate::lanelet::LaneletMap::default();
        let settings = crate::settings::Settings::default();
        let index = MapIndex::new(&map, &[], &settings);
        for row in table().unwrap() {
            let Requirement { id, check, .. } = &row.requirement;
            assert_eq!(row.predicate.is_none(), *check == Check::Manual, "{id}");
            if let Some(predicate) = row.predicate {
                assert_eq!(
                    predicate(&index, row.requirement.defaults()).map_err(|e| e.to_string()),
                    Ok(Vec::new()),
                    "{id}"
                );
            }
        }
    }
}
