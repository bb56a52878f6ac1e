//! The position of OpenStreetMap's line in the cross-section: `placement`.

use crate::diagnostic::{Finding, Severity};

use super::flow::Flow;
use super::{CrossSection, Strip, StripKind, Travel, WayFacts};

/// The offset of OpenStreetMap's line from the middle of the section, metres, left positive; `None` without a tag.
pub(super) fn reference(
    facts: &WayFacts<'_>,
    flow: Flow,
    section: &CrossSection,
    notes: &mut Vec<Finding>,
) -> Option<f64> {
    let only = if flow == Flow::Backward { Travel::Backward } else { Travel::Forward };
    let (value, travel) =
        [("placement:forward", Travel::Forward), ("placement:backward", Travel::Backward), ("placement", only)]
            .iter()
            .find_map(|(key, travel)| Some((facts.tags.get(key)?, *travel)))?;
    if value == "transition" {
        return None;
    }
    let offset = offset(value, travel, section);
    if offset.is_none() {
        let what = format!("placement={value} names no lane of the road; its line is taken as the middle");
        notes.push(facts.note("placement-unread", Severity::Info, &what));
    }
    offset
}

fn offset(value: &str, travel: Travel, section: &CrossSection) -> Option<f64> {
    let (place, number) = value.split_once(':')?;
    let number: usize = number.trim().parse().ok()?;
    let is_lane = |strip: &Strip| {
        strip.travel == travel && matches!(strip.kind, StripKind::Drive | StripKind::Bus | StripKind::Buffer)
    };
    let mut lanes: Vec<usize> =
        section.strips.iter().enumerate().filter(|(_, strip)| is_lane(strip)).map(|(i, _)| i).collect();
    if travel == Travel::Backward {
        lanes.reverse();
    }
    let lane = *lanes.get(number.checked_sub(1)?)?;
    let (left, right) = match travel {
        Travel::Backward => (section.edge(lane + 1), section.edge(lane)),
        _ => (section.edge(lane), section.edge(lane + 1)),
    };
    match place {
        "left_of" => Some(left),
        "right_of" => Some(right),
        "middle_of" => Some((left + right) / 2.0),
        _ => None,
    }
}
