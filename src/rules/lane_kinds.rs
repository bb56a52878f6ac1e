//! Kinds of lanes that Lanelet2 knows and Autoware does not, and what Autoware calls them.

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::Lanelet;
use crate::lanelet::index::view::View;
use crate::text::counted;

/// What Lanelet2 calls a lane, and the word for it that Autoware reads.
const SYNONYMS: [(&str, &str); 2] = [("highway", "road"), ("emergency_lane", "road_shoulder")];

/// The word that Autoware reads for a kind of lane.
pub fn for_autoware(kind: &str) -> &str {
    SYNONYMS.into_iter().find(|(theirs, _)| *theirs == kind).map_or(kind, |(_, ours)| ours)
}

/// The finding with the fix that gives all lanes of such a kind the word that Autoware reads: lanes beside and behind each other
/// have one kind before and after.
pub fn renamed(view: &View, finding: Finding) -> Finding {
    let edits_of = |(theirs, ours): (&'static str, &'static str)| {
        let lanelets = view.lanelets.iter().filter(move |seen| seen.is(theirs));
        lanelets.flat_map(move |seen| renaming(seen.lanelet, ours))
    };
    let edits: Vec<Edit> = SYNONYMS.into_iter().flat_map(edits_of).collect();
    let told = SYNONYMS.into_iter().filter_map(|(theirs, ours)| {
        let count = view.lanelets.iter().filter(|seen| seen.is(theirs)).count();
        (count > 0).then(|| format!("subtype={ours} on {} of subtype {theirs}", counted(count, "lanelet")))
    });
    let title = format!("set {}", told.collect::<Vec<_>>().join(", "));
    finding.fixed_by(title, false, edits)
}

/// The edits that set the new word. If only the old word said that vehicles, and nobody else, drive there, a tag says it now.
pub(super) fn renaming(lanelet: &Lanelet, kind: &'static str) -> impl Iterator<Item = Edit> {
    let on = Subject::Lanelet(lanelet.id.0);
    let is_said = lanelet.attributes.iter().any(|(key, _)| key.starts_with("participant"));
    let vehicles = Edit::SetTag { on, key: "participant:vehicle".into(), value: "yes".into() };
    let vehicles = (kind == "road" && !is_said).then_some(vehicles);
    std::iter::once(Edit::SetTag { on, key: "subtype".into(), value: kind.into() }).chain(vehicles)
}
