//! What there is to say of a finding beside its message, one line each, for formats without fields for it.

use super::visible;
use crate::diagnostic::{Diagnostic, Measure, Subject};

/// Help, fix, measure, related primitives, the chain that leads to the primitive (outermost first), place: those that
/// there are.
pub fn details(diagnostic: &Diagnostic, chain: &[Subject]) -> Vec<String> {
    let finding = &diagnostic.finding;
    let related: Vec<String> = finding.related.iter().map(|one| format!("{} ({})", one.subject, one.part)).collect();
    let chain: Vec<String> = chain.iter().map(Subject::to_string).collect();
    let all = [
        diagnostic.help.as_deref().map(|help| visible(help).into_owned()),
        finding.fix.as_ref().map(|fix| format!("fix: {}", visible(&fix.title))),
        finding.measure.and_then(|measure| measured(&measure)),
        (!related.is_empty()).then(|| format!("see also: {}", related.join(", "))),
        (!chain.is_empty()).then(|| format!("part of: {}", chain.join(", "))),
        place(diagnostic),
    ];
    all.into_iter().flatten().collect()
}

fn measured(measure: &Measure) -> Option<String> {
    let with_unit = |value: f64| match measure.unit {
        "1" => short(value),
        unit => format!("{} {unit}", short(value)),
    };
    let known = measure.value.is_finite() && measure.limit.is_finite();
    known.then(|| format!("measured: {}; limit: {}", with_unit(measure.value), with_unit(measure.limit)))
}

/// Three decimals at most, and none that says nothing.
fn short(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Latitude and longitude; where a map has none, metres to the east and north in its plane.
pub fn spot(diagnostic: &Diagnostic) -> Option<String> {
    globe(diagnostic).or_else(|| plane(diagnostic))
}

fn globe(diagnostic: &Diagnostic) -> Option<String> {
    diagnostic.lonlat.map(|at| format!("{:.7}, {:.7}", at.lat, at.lon))
}

fn plane(diagnostic: &Diagnostic) -> Option<String> {
    diagnostic.local.map(|at| format!("x {:.2} m, y {:.2} m", at.x, at.y))
}

/// Latitude and longitude, then metres to the east and north in the map's plane.
fn place(diagnostic: &Diagnostic) -> Option<String> {
    let (globe, plane) = (globe(diagnostic), plane(diagnostic));
    match (globe, plane) {
        (None, None) => None,
        (Some(globe), Some(plane)) => Some(format!("place: {globe} ({plane})")),
        (Some(one), None) | (None, Some(one)) => Some(format!("place: {one}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let all = [0.3, 12.0, -0.0001, 100.0, 0.12345].map(short);
        assert_eq!(all, ["0.3", "12", "0", "100", "0.123"]);
        let measure = |limit| measured(&Measure { value: 0.5, limit, unit: "1" });
        assert_eq!(measure(0.25).as_deref(), Some("measured: 0.5; limit: 0.25"));
        assert_eq!(measure(f64::NAN), None);
    }
}
