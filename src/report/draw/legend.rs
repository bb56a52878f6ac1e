//! The legend: the scale bar, what the hues mean, how many findings there are.

use super::canvas::Canvas;
use super::style;
use crate::diagnostic::{Diagnostic, Severity};
use crate::geometry::Point;
use crate::lanelet::{LaneletMap, TurnDirection};

/// Height of letters in pixels.
const LETTER: f64 = 8.0;
/// Distance of the legend from the edge of the sheet, pixels.
const INSET: f64 = 14.0;

/// Draws the scale bar, and beside it the hues that occur and how many findings the picture shows.
pub fn legend(canvas: &mut Canvas, map: &LaneletMap, diagnostics: &[Diagnostic], more: &[(&str, &str)]) {
    let mut entries: Vec<(String, String)> =
        more.iter().map(|(class, words)| ((*class).to_owned(), (*words).to_owned())).collect();
    for turn in [TurnDirection::Left, TurnDirection::Straight, TurnDirection::Right] {
        if map.lanelets.iter().any(|l| style::turn(&l.attributes) == Some(turn)) {
            entries.push((format!("swatch {}", turn.as_str()), turn.as_str().to_owned()));
        }
    }
    let pins = super::findings::pins(&canvas.view, map, diagnostics);
    for severity in [Severity::Error, Severity::Warning, Severity::Info] {
        let count = pins.iter().filter(|(_, d)| d.severity == severity).count();
        if count > 0 {
            let plural = if count == 1 { "" } else { "s" };
            entries.push((format!("pin {severity}"), format!("{count} {severity}{plural}")));
        }
    }
    card(canvas, entries);
}

/// Draws the scale bar on a card, and beside it what the classes mean.
pub fn card(canvas: &mut Canvas, entries: Vec<(String, String)>) {
    let (metres, bar) = bar_length(canvas.view.scale);
    let label = format!("{metres} m");
    let base = canvas.view.height() - INSET;
    let mut x = 2.0 * INSET;
    let widths: f64 = entries.iter().map(|(_, text)| entry_width(text)).sum();
    let width = bar + super::lettering::width(&label, LETTER) + widths + 3.0 * INSET;
    let card = [
        (INSET, base + 6.0),
        (INSET, base - LETTER - 8.0),
        (INSET + width, base - LETTER - 8.0),
        (INSET + width, base + 6.0),
    ];
    canvas.pixels("card", &card.map(|(x, y)| Point::new(x, y)), true);
    let ticks = [(x, base - 5.0), (x, base), (x + bar, base), (x + bar, base - 5.0)];
    canvas.pixels("rule", &ticks.map(|(x, y)| Point::new(x, y)), false);
    x += bar + 6.0;
    canvas.words_at("scale", x, base, &label, LETTER);
    x += super::lettering::width(&label, LETTER) + INSET;
    for (class, text) in entries {
        let side = LETTER + 1.0;
        let square = [(x, base), (x, base - side), (x + side, base - side), (x + side, base)];
        canvas.pixels(&class, &square.map(|(x, y)| Point::new(x, y)), true);
        canvas.words_at("scale", x + side + 5.0, base, &text, LETTER);
        x += entry_width(&text);
    }
}

fn entry_width(text: &str) -> f64 {
    LETTER + 6.0 + super::lettering::width(text, LETTER) + INSET
}

/// A round number of metres that gives a bar of 50 to 130 pixels, and its length in pixels.
fn bar_length(scale: f64) -> (f64, f64) {
    const LEAST: f64 = 50.0;
    let mut metres = 10_f64.powf((LEAST / scale).log10().floor());
    for step in [2.0, 2.5, 2.0] {
        if metres * scale >= LEAST {
            break;
        }
        metres *= step;
    }
    (metres, metres * scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_is_round_and_readable() {
        for scale in [0.013, 0.5, 1.0, 7.0, 24.0, 300.0] {
            let (metres, pixels) = bar_length(scale);
            assert!((50.0..=130.0).contains(&pixels), "{scale}: {metres} m, {pixels} px");
            let leading = metres / 10_f64.powf(metres.log10().floor());
            assert!([1.0, 2.0, 5.0, 10.0].iter().any(|l| (leading - l).abs() < 1e-9), "{metres}");
        }
    }
}
