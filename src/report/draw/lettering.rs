//! Letters drawn with a pen, so that a picture needs no font and looks the same on every machine.

use std::fmt::Write;

/// Each letter is drawn on a grid this many units wide ...
const WIDTH: f64 = 4.0;
/// ... and this high, ...
const HEIGHT: f64 = 6.0;
/// ... and the next one begins this many units behind it.
const GAP: f64 = 1.8;

/// How wide a text comes out at a height, both in pixels.
pub fn width(text: &str, height: f64) -> f64 {
    let count = text.chars().count() as f64;
    (count * (WIDTH + GAP) - GAP).max(0.0) * height / HEIGHT
}

/// The `d` of a path that writes `text` from `left` on the base line `base`, `height` pixels high.
pub fn path(text: &str, left: f64, base: f64, height: f64) -> String {
    let unit = height / HEIGHT;
    let mut path = String::new();
    for (i, letter) in text.chars().enumerate() {
        let x0 = left + i as f64 * (WIDTH + GAP) * unit;
        for stroke in strokes(letter).split(' ').filter(|s| !s.is_empty()) {
            let mut digits = stroke.bytes().map(|b| f64::from(b.saturating_sub(b'0')));
            let mut command = 'M';
            while let (Some(x), Some(y)) = (digits.next(), digits.next()) {
                let _ = write!(path, "{command}{:.1} {:.1}", x0 + x * unit, base - y * unit);
                command = 'L';
            }
        }
    }
    path
}

/// The strokes of each letter: groups of digit pairs `xy` on the grid, x to the right from 0 to 4, y up from 0 to 6.
#[rustfmt::skip]
const STROKES: &[(char, &str)] = &[
    ('0', "103041453616050110"), ('1', "052620 1030"), ('2', "05163645440040"), ('3', "05163645443313 334241301001"),
    ('4', "30360242"), ('5', "460603334241301001"), ('6', "4536160501103041423303"), ('7', "064610"),
    ('8', "13040516364544331302011030414233"), ('9', "0110304145361605041343"), ('A', "002640 1232"),
    ('B', "00063645443303 3342413000"), ('C', "4536160501103041"), ('D', "00062644422000"), ('E', "46060040 0333"),
    ('F', "460600 0333"), ('G', "45361605011030414323"), ('H', "0006 4046 0343"), ('I', "1030 2026 1636"),
    ('J', "4641301001"), ('K', "0006 4602 1340"), ('L', "060040"), ('M', "0006234640"), ('N', "00064046"),
    ('O', "103041453616050110"), ('P', "00063645443303"), ('Q', "103041453616050110 2240"),
    ('R', "00063645443303 2340"), ('S', "453616050413334241301001"), ('T', "0646 2620"), ('U', "060110304146"),
    ('V', "062046"), ('W', "0610233046"), ('X', "0046 0640"), ('Y', "062346 2320"), ('Z', "06460040"),
    ('a', "14344340 4212011040"), ('b', "0600 0314344341301001"), ('c', "4334140301103041"),
    ('d', "4640 4334140301103041"), ('e', "02424334140301103041"), ('f', "36261510 0434"),
    ('g', "4334140302113142 44413010"), ('h', "0600 0314344340"), ('i', "2420 2526"), ('j', "34312010 3536"),
    ('k', "0600 4402 1340"), ('l', "2620"), ('m', "0400 03142320 23344340"), ('n', "0400 0314344340"),
    ('o', "143443413010010314"), ('p', "0400 043443423101"), ('q', "4440 441403021141"), ('r', "0400 03143443"),
    ('s', "43341403123241301001"), ('t', "16112030 0434"), ('u', "0401103041 4440"), ('v', "042044"),
    ('w', "0410223044"), ('x', "0440 0044"), ('y', "0422 442210"), ('z', "04440040"), ('-', "1333"), ('_', "0040"),
    ('.', "2021"), (',', "2110"), (':', "2122 2425"), ('/', "0046"), ('+', "0343 2125"), ('=', "0242 0444"),
    ('(', "36242230"), (')', "16242210"), ('#', "1016 3036 0242 0444"), ('%', "0046 0506 4041"), ('\'', "2624"),
    (' ', ""),
];
/// What is drawn for a letter that is not in the table.
const UNKNOWN: &str = "0006464000";

fn strokes(letter: char) -> &'static str {
    STROKES.iter().find(|(known, _)| *known == letter).map_or(UNKNOWN, |(_, strokes)| strokes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_lies_on_its_grid() {
        for letter in ' '..='~' {
            for stroke in strokes(letter).split(' ') {
                assert!(stroke.len() % 2 == 0, "{letter}: {stroke}");
                for (i, digit) in stroke.bytes().enumerate() {
                    let most = if i % 2 == 0 { b'4' } else { b'6' };
                    assert!((b'0'..=most).contains(&digit), "{letter}: {stroke}");
                }
            }
        }
    }

    #[test]
    fn text_takes_the_width_it_says() {
        assert_eq!(width("", 6.0), 0.0);
        assert!((width("12", 6.0) - 9.8).abs() < 1e-9);
    }
}
