//! What a review decides about: fixes, those that would make the same change as one.

use rustc_hash::FxHashMap;

use crate::diagnostic::{Diagnostic, Edit};
use crate::fix::Mend;
use crate::rules;
use crate::text::without_numbers;

/// A fix, with the findings that propose it.
#[derive(Clone, Debug)]
pub struct Item {
    /// Each finding's fix; the first is that of `finding`.
    pub mends: Vec<Mend>,
    /// The finding that proposes it first.
    pub finding: Diagnostic,
    /// Whether `fix` makes it without being asked for fixes that need a review.
    pub safe: bool,
    /// Code and title without numbers: fixes of one kind can be accepted at once.
    pub kind: String,
    /// What it takes for granted.
    pub assumes: String,
}

/// What somebody decided about a fix.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Decision {
    /// It was made.
    Accepted,
    /// It is not wanted, for this reason.
    Rejected(String),
    /// Somebody will look at it again.
    Later,
}

/// The fixes that findings propose: those that need a review first, then the others; of each the errors first.
pub fn of(found: &[Diagnostic]) -> Vec<Item> {
    let mut items: Vec<Item> = Vec::new();
    let mut places: FxHashMap<String, usize> = FxHashMap::default();
    for one in found {
        let Some(fix) = &one.finding.fix else { continue };
        let mend = Mend { code: one.code.clone(), subject: one.finding.subject, title: fix.title.clone() };
        match places.get(&format!("{:?}", fix.edits)).and_then(|&at| items.get_mut(at)) {
            Some(item) => item.mends.push(mend),
            None => {
                places.insert(format!("{:?}", fix.edits), items.len());
                items.push(Item {
                    kind: format!("{}: {}", one.code, without_numbers(&fix.title)),
                    mends: vec![mend],
                    finding: one.clone(),
                    safe: fix.safe,
                    assumes: if fix.safe { String::new() } else { assumption(&one.code, &fix.edits) },
                });
            }
        }
    }
    items.sort_by_key(|item| (item.safe, std::cmp::Reverse(item.finding.severity)));
    items
}

/// What a fix takes for granted, as the rule's document says it, or else what its edits tell.
fn assumption(code: &str, edits: &[Edit]) -> String {
    let rows = rules::table().unwrap_or_default();
    let said = code.split_once('/').and_then(|(id, slug)| {
        let row = rows.iter().find(|row| row.requirement.id == id)?;
        row.requirement.fault(slug)?.assumes.clone()
    });
    said.unwrap_or_else(|| of_edits(edits).to_owned())
}

fn of_edits(edits: &[Edit]) -> &'static str {
    let has = |test: fn(&Edit) -> bool| edits.iter().any(test);
    if has(|edit| matches!(edit, Edit::CreateArea { .. })) {
        "That these lanelets are one intersection, and that it reaches as far as their ends and the road borders."
    } else if has(|edit| matches!(edit, Edit::Divide(_))) {
        "That the lanelet is meant to end where those beside it or across it do."
    } else if has(|edit| {
        matches!(edit, Edit::CreateRegulatoryElement { .. } | Edit::CreateStopLine { .. } | Edit::CreateMarking { .. })
    }) {
        "That what is drawn here stands on the street and is meant for these lanelets."
    } else if has(|edit| matches!(edit, Edit::MergePoints { .. } | Edit::ReplaceWay { .. })) {
        "That these are one and the same, drawn twice."
    } else if has(|edit| matches!(edit, Edit::SetPlace { .. } | Edit::PlaceBetween { .. } | Edit::SetVertices { .. })) {
        "That the shape around it is right, and that this alone is off."
    } else if has(|edit| matches!(edit, Edit::Remove { .. } | Edit::RemoveRepeat { .. } | Edit::RemoveMember { .. })) {
        "That it is left over, and that nobody needs it."
    } else if has(|edit| matches!(edit, Edit::RemoveTag { .. })) {
        "That the tag says nothing that is true of the street."
    } else {
        "That the rest of the map around it is right, and tells what was meant here."
    }
}
