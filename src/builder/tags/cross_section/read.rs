//! Reads the cross-section of a way from its tags.

use crate::builder::tags::road_class::DrivingSide;
use crate::builder::tags::values::metres_under;
use crate::diagnostic::{Finding, Severity};

use super::facts::MAX_SINGLE_TRACK;
use super::flow::flow;
use super::lanes::{Lanes, lanes};
use super::placement::reference;
use super::sides::{SideStrips, side_strips};
use super::{CrossSection, SectionReading, Strip, StripKind, Travel, WayFacts, minimum_lane_width};

/// The largest width of a lane, metres. The rest of a wider carriageway is a shoulder.
pub(super) const MAX_LANE_WIDTH: f64 = 3.75;

/// The widths of such a shoulder, metres. A narrower rest is no strip; with a wider rest the tagged width is wrong.
const SHOULDER: std::ops::RangeInclusive<f64> = 0.25..=6.0;

/// The strips of a way, left to right, before their widths are final.
struct SectionDraft {
    beyond_left: Vec<Strip>,
    carriageway: Vec<Strip>,
    beyond_right: Vec<Strip>,
}

/// Reads the cross-section of a way.
pub(crate) fn layout(facts: &WayFacts<'_>, notes: &mut Vec<Finding>) -> SectionReading {
    let flow = flow(facts);
    let [mut left, mut right] = [Travel::Backward, Travel::Forward].map(|travel| side_strips(facts, flow, travel));
    let beside = left.carriageway.iter().chain(&right.carriageway).map(|s| s.width).sum();
    let lanes = lanes(facts, flow, beside, notes);
    drop_repeated_bicycle_lane(facts.side, &lanes, &mut left, &mut right);
    let mut draft = assemble(lanes, left, right);
    settle_widths(facts, &mut draft, notes);
    let left_width: f64 = draft.beyond_left.iter().map(|s| s.width).sum();
    let carriageway: f64 = draft.carriageway.iter().map(|s| s.width).sum();
    let section = CrossSection { strips: [draft.beyond_left, draft.carriageway, draft.beyond_right].concat() };
    let middle = section.width() / 2.0 - left_width - carriageway / 2.0;
    let reference = reference(facts, flow, &section, notes).unwrap_or(middle);
    SectionReading { section, shift: if reference == 0.0 { 0.0 } else { -reference } }
}

/// Drops a bicycle lane from `cycleway` if `bicycle:lanes` has it already, at the same edge or between lanes of its direction.
fn drop_repeated_bicycle_lane(side: DrivingSide, lanes: &[Strip], left: &mut SideStrips, right: &mut SideStrips) {
    let is_bicycle = |strip: &&Strip| strip.kind == StripKind::Bicycle;
    let inside = lanes.get(1..lanes.len().saturating_sub(1)).unwrap_or_default();
    let mut between: Vec<Travel> = inside.iter().filter(is_bicycle).map(|strip| strip.travel).collect();
    // The near side first: lanes turn off across a bicycle lane between lanes mostly there.
    let mut edges = [(lanes.last(), right), (lanes.first(), left)];
    if side == DrivingSide::Left {
        edges.reverse();
    }
    for (edge, side) in edges {
        let Some(own) = side.carriageway.iter().find(is_bicycle).map(|strip| strip.travel) else { continue };
        let repeated = between.iter().position(|travel| *travel == own);
        if edge.filter(is_bicycle).is_some() || repeated.is_some() {
            side.carriageway.retain(|strip| !matches!(strip.kind, StripKind::Bicycle | StripKind::Buffer));
            if let (Some(at), true) = (repeated, edge.filter(is_bicycle).is_none()) {
                between.remove(at);
            }
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

/// Divides the tagged width of the carriageway among the lanes without a width of their own.
fn settle_widths(facts: &WayFacts<'_>, draft: &mut SectionDraft, notes: &mut Vec<Finding>) {
    let tagged = metres_under(facts.tags, ["width:carriageway", "width"]);
    let Some(total) = tagged.or_else(|| metres_under(facts.tags, ["est_width"])) else {
        if draft.carriageway.iter().any(|strip| strip.width_guessed) {
            notes.push(facts.note("width-guessed", Severity::Info, "no width tag; lanes have their class's default"));
        }
        return;
    };
    let is_open = |s: &Strip| s.width_guessed && matches!(s.kind, StripKind::Drive | StripKind::Bus);
    let fixed: f64 = draft.carriageway.iter().filter(|s| !is_open(s)).map(|s| s.width).sum();
    let count = draft.carriageway.iter().filter(|s| is_open(s)).count();
    if count == 0 {
        return;
    }
    let single = count == 1 && draft.carriageway.iter().any(|s| is_open(s) && s.travel == Travel::Both);
    let (low, high) = (minimum_lane_width(facts.class), if single { MAX_SINGLE_TRACK } else { MAX_LANE_WIDTH });
    let each = (total - fixed) / count as f64;
    for strip in draft.carriageway.iter_mut().filter(|s| is_open(s)) {
        strip.width = each.clamp(low, high);
        strip.width_guessed = tagged.is_none();
    }
    if each < low {
        let what = format!("width {total} m leaves {each:.2} m for a lane; {low} m are drawn");
        notes.push(facts.note("width-implausible", Severity::Warning, &what).measured(each, low, "m"));
    }
    if each > high {
        add_shoulders(facts, draft, (each - high) * count as f64 / 2.0, notes);
    }
}

/// Adds shoulders of this width, metres, at both edges of the carriageway.
fn add_shoulders(facts: &WayFacts<'_>, draft: &mut SectionDraft, width: f64, notes: &mut Vec<Finding>) {
    if width > *SHOULDER.end() {
        let what = format!("the tagged width is {:.1} m more than the lanes can fill; it is passed over", width * 2.0);
        notes.push(facts.note("width-implausible", Severity::Warning, &what));
    } else if width >= *SHOULDER.start() {
        let shoulder = |travel| Strip::plain(StripKind::Shoulder, travel, width, true);
        let travels = draft.carriageway.first().zip(draft.carriageway.last()).map(|(a, b)| (a.travel, b.travel));
        if let Some((first, last)) = travels {
            draft.carriageway.insert(0, shoulder(first));
            draft.carriageway.push(shoulder(last));
        }
    }
}
