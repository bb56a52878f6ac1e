//! A fix that a finding proposes, and a batch of them, made and judged.

use rustc_hash::FxHashMap;

use super::route::Change;
use super::text_edits::{Key, key_of};
use crate::diagnostic::{Diagnostic, Edit, Fix, Subject};
use crate::osm::OsmData;

/// A fix and what it mends.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Mend {
    /// Code of the finding.
    pub code: String,
    /// What it is about.
    pub subject: Subject,
    /// What the fix does, in one line.
    pub title: String,
}

/// A fix that a finding proposes.
#[derive(Clone, Debug)]
pub struct Proposal {
    /// What is mended.
    pub mend: Mend,
    /// The edits.
    pub fix: Fix,
    /// Where the finding is: east and north, local metres.
    pub place: Option<[f64; 2]>,
    /// The elements that the finding speaks of.
    pub about: Vec<Key>,
    /// The elements that it created, once it is applied.
    pub creates: Vec<Key>,
    /// The elements that contain what it changed, once it is applied.
    pub reaches: Vec<Key>,
    /// The fixes of the errors that it brought.
    pub followers: Vec<(Mend, Fix)>,
}

impl Proposal {
    /// That of a finding; `None` if it has none.
    pub fn of(found: &Diagnostic) -> Option<Self> {
        let fix = found.finding.fix.clone()?;
        let mend = Mend { code: found.code.clone(), subject: found.finding.subject, title: fix.title.clone() };
        let place = found.local.map(|place| [place.x, place.y]);
        let related = found.finding.related.iter().map(|one| one.subject);
        let about = std::iter::once(found.finding.subject).chain(related).filter_map(key_of).collect();
        Some(Self { mend, fix, place, about, creates: Vec::new(), reaches: Vec::new(), followers: Vec::new() })
    }

    /// Whether it draws an area: the lanelets in the area have to be final first.
    pub fn draws_area(&self) -> bool {
        self.fix.edits.iter().any(|edit| matches!(edit, Edit::CreateArea { .. }))
    }

    /// The elements that its edits change, or make part of something else.
    pub fn touched(&self) -> impl Iterator<Item = Key> + '_ {
        self.edits().flat_map(touched).filter_map(key_of)
    }

    /// All edits, its own and those of the fixes that follow from it.
    pub fn edits(&self) -> impl Iterator<Item = &Edit> {
        self.fix.edits.iter().chain(self.followers.iter().flat_map(|(_, fix)| &fix.edits))
    }

    /// Its own mend and those that follow from it.
    pub fn mends(self) -> impl Iterator<Item = Mend> {
        std::iter::once(self.mend).chain(self.followers.into_iter().map(|(mend, _)| mend))
    }
}

/// A batch of fixes, made and judged.
pub struct Attempt {
    /// The map as it would be.
    pub osm: OsmData,
    /// What would be left to find in it.
    pub left: Vec<Diagnostic>,
    /// The fixes that were made.
    pub done: Vec<Proposal>,
    /// New ids of elements, by their old ones.
    pub renumbered: FxHashMap<Key, i64>,
    /// The routes that it changes.
    pub routes: Vec<Change>,
    /// Where fixes followed from these, the map without them, and its findings.
    pub as_made: Option<(OsmData, Vec<Diagnostic>)>,
}

/// What an edit changes, or makes part of something else.
fn touched(edit: &Edit) -> Vec<Subject> {
    match edit {
        Edit::SetTag { on, .. }
        | Edit::RemoveTag { on, .. }
        | Edit::RemoveRepeat { on, .. }
        | Edit::Renumber { on, .. } => {
            vec![*on]
        }
        Edit::AddMember { on, member, .. }
        | Edit::RemoveMember { on, member, .. }
        | Edit::SetRole { on, member, .. } => {
            vec![*on, *member]
        }
        Edit::MergePoints { from, to } => vec![Subject::Point(*from), Subject::Point(*to)],
        Edit::InsertVertex { way, .. }
        | Edit::RemoveVertex { way, .. }
        | Edit::SetVertices { way, .. }
        | Edit::ReverseWay { way } => vec![*way],
        Edit::ReplaceWay { lanelet, .. } | Edit::CreateOpposite { lanelet, .. } => vec![Subject::Lanelet(*lanelet)],
        Edit::SetPlace { point, .. } | Edit::PlaceBetween { point, .. } => vec![Subject::Point(*point)],
        Edit::Remove { subject } => vec![*subject],
        Edit::SetFormatVersion { .. } => Vec::new(),
        Edit::CreateStopLine { element, .. } => vec![*element],
        Edit::CreateArea { lanelets, .. } | Edit::CreateMarking { lanelets, .. } => {
            lanelets.iter().copied().map(Subject::Lanelet).collect()
        }
        Edit::CreateRegulatoryElement { referrers, .. } => referrers.iter().copied().map(Subject::Lanelet).collect(),
        Edit::Divide(division) => {
            let lanelets = division.lanelets.iter().map(|cut| Subject::Lanelet(cut.lanelet));
            lanelets.chain(division.ways.iter().map(|cut| Subject::LineString(cut.way))).collect()
        }
    }
}
