//! From the tags of a way to its cross-section: the parts are read apart and put together here.

use crate::builder::tags::values::metres_under;
use crate::diagnostic::{Finding, Severity};

use super::facts::MAX_SINGLE_TRACK;
use super::flow::flow;
use super::lanes::{Lanes, lanes};
use super::placement::reference;
use super::sides::{SideStrips, side_strips};
use super::{CrossSection, SectionReading, Strip, StripKind, Travel, WayFacts, minimum_lane_width};

/// Lanes are drawn no wider than this, metres, whatever the width of the carriageway says: what is left over is a
/// shoulder.
pub(super) const MAX_LANE_WIDTH: f64 = 3.75;

/// A shoulder left over on one side, metres: below, it is no strip of its own; above, the tagged width is not that of
/// this carriageway.
const LEFT_OVER: std::ops::RangeInclusive<f64> = 0.25..=6.0;

/// The strips of a way while their widths are settled, left to right along the way.
struct SectionDraft {
    beyond_left: Vec<Strip>,
    carriageway: Vec<Strip>,
    beyond_right: Vec<Strip>,
}

/// Reads the cross-section of a way.
pub(crate) fn layout(facts: &WayFacts<'_>, notes: &mut Vec<Finding>) -> SectionReading {
    let flow = flow(facts);
    let mut left = side_strips(facts, flow, Travel::Backward);
    let mut right = side_strips(facts, flow, Travel::Forward);
    let beside = left.carriageway.iter().chain(&right.carriageway).map(|s| s.width).sum();
    let lanes = lanes(facts, flow, beside, notes);
    drop_repeated_bicycle_lane(&lanes, &mut left, &mut right);
    let mut draft = assemble(lanes, left, right);
    settle_widths(facts, &mut draft, notes);
    let lead: f64 = draft.beyond_left.iter().map(|s| s.width).sum();
    let carriageway: f64 = draft.carriageway.iter().map(|s| s.width).sum();
    let mut strips = draft.beyond_left;
    strips.append(&mut draft.carriageway);
    strips.append(&mut draft.beyond_right);
    let section = CrossSection { strips };
    let middle = section.width() / 2.0 - lead - carriageway / 2.0;
    let reference = reference(facts, flow, &section, notes).unwrap_or(middle);
    SectionReading { section, shift: if reference == 0.0 { 0.0 } else { -reference } }
}

/// A bicycle lane that `bicycle:lanes` already put beside the motor lanes is not repeated for `cycleway`.
fn drop_repeated_bicycle_lane(lanes: &[Strip], left: &mut SideStrips, right: &mut SideStrips) {
    for (edge, side) in [(lanes.first(), left), (lanes.last(), right)] {
        if edge.is_some_and(|strip| strip.kind == StripKind::Bicycle) {
            side.carriageway.retain(|strip| strip.kind != StripKind::Bicycle);
        }
    }
}

fn assemble(lanes: Lanes, left: SideStrips, right: SideStrips) -> SectionDraft {
    let outward = |mut strips: Vec<Strip>| {
        strips.reverse();
        strips
    };
    let mut carriageway = outward(left.carriageway);
    carriageway.extend(lanes);
    carriageway.extend(right.carriageway);
    SectionDraft { beyond_left: outward(left.beyond), carriageway, beyond_right: right.beyond }
}

/// Spreads a tagged width of the carriageway over the lanes that have none of their own.
fn settle_widths(facts: &WayFacts<'_>, draft: &mut SectionDraft, notes: &mut Vec<Finding>) {
    let tagged = metres_under(facts.tags, ["width:carriageway", "width"]);
    let Some(total) = tagged.or_else(|| metres_under(facts.tags, ["est_width"])) else {
        if draft.carriageway.iter().any(|strip| strip.width_guessed) {
            notes.push(facts.note("width-guessed", Severity::Info, "no width tag; lanes have their class's default"));
        }
        return;
    };
    let open = |s: &Strip| s.width_guessed && matches!(s.kind, StripKind::Drive | StripKind::Bus);
    let fixed: f64 = draft.carriageway.iter().filter(|s| !open(s)).map(|s| s.width).sum();
    let count = draft.carriageway.iter().filter(|s| open(s)).count();
    if count == 0 {
        return;
    }
    let single = count == 1 && draft.carriageway.iter().any(|s| open(s) && s.travel == Travel::Both);
    let (low, high) = (minimum_lane_width(facts.class), if single { MAX_SINGLE_TRACK } else { MAX_LANE_WIDTH });
    let each = (total - fixed) / count as f64;
    for strip in draft.carriageway.iter_mut().filter(|s| open(s)) {
        strip.width = each.clamp(low, high);
        strip.width_guessed = tagged.is_none();
    }
    if each < low {
        let what = format!("width {total} m leaves {each:.2} m for a lane; {low} m are drawn");
        notes.push(facts.note("width-implausible", Severity::Warning, &what).measured(each, low, "m"));
    }
    if each > high {
        leave_shoulders(facts, draft, (each - high) * count as f64 / 2.0, notes);
    }
}

/// What a carriageway is wider than its lanes lies at both edges.
fn leave_shoulders(facts: &WayFacts<'_>, draft: &mut SectionDraft, width: f64, notes: &mut Vec<Finding>) {
    if width > *LEFT_OVER.end() {
        let what = format!("the tagged width is {:.1} m more than the lanes can fill; it is passed over", width * 2.0);
        notes.push(facts.note("width-implausible", Severity::Warning, &what));
    } else if width >= *LEFT_OVER.start() {
        let shoulder = |travel| Strip::plain(StripKind::Shoulder, travel, width, true);
        let travels = draft.carriageway.first().zip(draft.carriageway.last()).map(|(a, b)| (a.travel, b.travel));
        if let Some((first, last)) = travels {
            draft.carriageway.insert(0, shoulder(first));
            draft.carriageway.push(shoulder(last));
        }
    }
}
