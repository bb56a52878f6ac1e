//! What a fix would change: shapes, findings, what Autoware's planner would do, and pictures before and after.

use std::collections::BTreeMap;

use crate::diagnostic::{Diagnostic, Severity, Subject};
use crate::fix::new_findings;
use crate::geometry::Point;
use crate::lanelet::index::view::View;
use crate::lanelet::locate::locate;
use crate::lanelet::{LaneletMap, from_osm};
use crate::planner::{Params, RoadNetwork};
use crate::report::diff::Kind;
use crate::report::draw::{self, Focus, Options, bounding_box};
use crate::report::failure::Failure;
use crate::report::html::{FixPreview, fix_previews, shape_of};
use crate::report::planner::sentence;

use super::{Outcome, Review, counts};
use crate::diagnostic::Place;

/// Around what changes, metres: as much street as tells where it is, and not so much that nothing is seen.
const MARGIN: f64 = 12.0;
/// Least and largest half side of a picture, metres.
const RADIUS: [f64; 2] = [18.0, 70.0];
/// Longer side of a picture, pixels.
const SIDE: f64 = 560.0;

/// What comes of one fix.
pub struct Preview {
    /// Why it would not be kept, where it would not.
    pub refused: Option<String>,
    /// Fixes that follow from it and would be made with it.
    pub also: Vec<String>,
    /// What would be different, with its shape.
    pub changes: Vec<FixPreview>,
    /// Errors and warnings before and after.
    pub counts: [[usize; 2]; 2],
    /// Errors and warnings that were not there before.
    pub brings: Vec<String>,
    /// What Autoware's planner would do, before and after, where that differs.
    pub planner: Vec<[String; 2]>,
    /// The place before and after, as SVG; none where nothing is drawn of it.
    pub pictures: Option<[String; 2]>,
}

impl Review {
    /// What would come of an open fix in the map as it is now.
    ///
    /// # Errors
    ///
    /// Where the fix is not open, or the map cannot be judged.
    pub fn preview(&mut self, item: usize) -> Result<Preview, Failure> {
        self.open_item(item)?;
        let outcome = self.tried(item)?;
        let Some(finding) = self.items.get(item).map(|item| item.finding.clone()) else {
            return Err(Failure::new("there is no such fix"));
        };
        let after = from_osm(&outcome.osm, &self.plane(outcome.with_projector_file).0).map;
        let before = self.now.map.as_ref();
        let known: Vec<usize> =
            (0..self.now.left.len()).filter(|&at| self.now.left.get(at) == Some(&finding)).collect();
        let changes = fix_previews(before, &after, &self.now.left, &known);
        let pictures = pictures([before, &after], &finding, &changes)?;
        let own = self.items.get(item).map(|item| item.mends.clone()).unwrap_or_default();
        let refused = match own.iter().any(|mend| outcome.made.contains(mend)) {
            true => None,
            false => Some(
                outcome
                    .refused
                    .first()
                    .map_or_else(|| "it mends nothing here any more".to_owned(), |(_, why)| why.clone()),
            ),
        };
        let also = outcome.made.iter().filter(|mend| !own.contains(mend));
        Ok(Preview {
            refused,
            also: also.map(|mend| format!("{} on {}: {}", mend.code, mend.subject, mend.title)).collect(),
            planner: planner([before, &after], &changes),
            changes,
            counts: [counts(&self.now.left), counts(&outcome.left)],
            brings: brings(&self.now.left, &outcome),
            pictures,
        })
    }
}

/// Errors and warnings that a map has more than before.
fn brings(before: &[Diagnostic], outcome: &Outcome) -> Vec<String> {
    let heavy = new_findings(before, &outcome.left).into_iter().filter(|one| one.severity > Severity::Info);
    heavy.map(|one| format!("{} {}: {}", one.severity, one.code, one.finding.message)).collect()
}

/// What the planner would do on the lanelets that change or whose elements do, where that differs.
fn planner(maps: [&LaneletMap; 2], changes: &[FixPreview]) -> Vec<[String; 2]> {
    let changed = |subject: Subject| changes.iter().any(|one| one.subject == subject);
    let said = maps.map(|map| {
        let view = View::new(map);
        let network = RoadNetwork::new(&view);
        let turning = (0..view.lanelets.len()).filter(|&at| network.graph.passes(at) && network.turn(at).is_some());
        let params = Params::default();
        let mut said: BTreeMap<i64, String> = BTreeMap::new();
        for at in turning {
            let Some(id) = view.lanelets.get(at).map(|lanelet| lanelet.lanelet.id) else { continue };
            let of_elements = map.lanelets.get(id).is_some_and(|lanelet| {
                lanelet.regulatory_elements.iter().any(|element| changed(Subject::RegulatoryElement(element.0)))
            });
            if of_elements || changed(Subject::Lanelet(id.0)) {
                said.extend(network.forecast(at, &[], &params).map(|forecast| (id.0, sentence(&forecast))));
            }
        }
        said
    });
    let [before, after] = &said;
    let pair = |id: &i64| {
        let of = |said: &BTreeMap<i64, String>| {
            said.get(id).cloned().unwrap_or_else(|| format!("Lanelet {id}: the planner sees no turn there."))
        };
        let pair = [of(before), of(after)];
        (before.get(id) != after.get(id)).then_some(pair)
    };
    let mut ids: Vec<&i64> = before.keys().chain(after.keys()).collect();
    ids.sort_unstable();
    ids.dedup();
    ids.into_iter().filter_map(pair).collect()
}

/// The place of a fix before and after.
fn pictures(
    [before, after]: [&LaneletMap; 2],
    finding: &Diagnostic,
    changes: &[FixPreview],
) -> Result<Option<[String; 2]>, Failure> {
    let spot = finding.local.or_else(|| locate(before, finding.finding.subject, &Place::Unknown).local);
    let near = |point: &&Point| spot.is_none_or(|spot| (*point - spot).norm() < RADIUS[1]);
    let of_changes = changes.iter().flat_map(|change| &change.shape).flat_map(|(_, points)| points).filter(near);
    let points: Vec<Point> = of_changes.copied().chain(spot).collect();
    let Some((low, high)) = bounding_box(&points) else { return Ok(None) };
    let radius = ((high - low).max() / 2.0 + MARGIN).clamp(RADIUS[0], RADIUS[1]);
    let focus = Focus::Around(nalgebra::center(&low, &high), radius);
    let options = Options { focus, scale: Some(SIDE / (2.0 * radius)), without_legend: true, ..Options::default() };
    let view = draw::view(after, &options).map_err(|error| Failure::new(error.to_string()).help(error.help()))?;
    let old = changes.iter().filter(|change| change.change != Kind::Added);
    let old = old.flat_map(|change| shape_of(before, change.subject)).collect();
    let new = changes.iter().filter(|change| change.change != Kind::Removed);
    let new = new.flat_map(|change| change.shape.clone()).collect();
    let drawn = |map: &LaneletMap, marked: Vec<(bool, Vec<Point>)>| {
        draw::svg_of(map, &[], view, &Options { marked, ..options.clone() })
    };
    Ok(Some([drawn(before, old), drawn(after, new)]))
}
