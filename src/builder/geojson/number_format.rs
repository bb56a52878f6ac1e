//! How numbers, positions, ids, tags and arrows are spelt in the file.

use std::io::{self, Write};
use std::ops::Range;

use serde::Deserialize;
use serde::de::{self, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::ser::{SerializeMap, Serializer};
use serde_json::ser::{CompactFormatter, Formatter};

use crate::builder::tags::cross_section::Arrows;
use crate::osm::{Tags, Text, put_fixed};
use crate::projection::LonLat;

use super::id::{FeatureId, FeaturePlace};

/// Spells numbers as `serde_json` does, in less time where they have no more than nine decimals, as most have.
#[derive(Default)]
pub struct Spelling {
    number: Vec<u8>,
}

impl Formatter for Spelling {
    fn write_f64<W: ?Sized + Write>(&mut self, out: &mut W, value: f64) -> io::Result<()> {
        self.number.clear();
        put_number(&mut self.number, value)?;
        out.write_all(&self.number)
    }
}

/// The decimals of degrees, a tenth of a millimetre, and of most other numbers.
const DECIMALS: usize = 9;
/// As many steps has a whole.
const STEPS: f64 = 1e9;

/// Whether a number is spelt without an exponent. Those of nine decimals have up to fifteen digits then, and are all
/// different ones: no shorter spelling stands for the same.
fn is_plain(value: f64) -> bool {
    (1e-3..1e6).contains(&value.abs())
}

fn put_number(out: &mut Vec<u8>, value: f64) -> io::Result<()> {
    let steps = (value.abs() * STEPS + 0.5) as u64;
    if is_plain(value) && steps as f64 / STEPS == value.abs() {
        put_rounded(out, value);
        return Ok(());
    }
    CompactFormatter.write_f64(out, value)
}

/// Spells a plain number rounded to nine decimals.
fn put_rounded(out: &mut Vec<u8>, value: f64) {
    put_fixed(out, value, DECIMALS);
    let spare = out.iter().rev().take_while(|digit| **digit == b'0').count();
    // Of a whole number one decimal stays.
    out.truncate(out.len() - spare.min(DECIMALS - 1));
}

/// Degrees with nine decimals.
pub fn rounded(degrees: f64) -> f64 {
    (degrees * STEPS).round() / STEPS
}

fn put_degrees(out: &mut Vec<u8>, degrees: f64) -> io::Result<()> {
    if is_plain(degrees) {
        put_rounded(out, degrees);
        return Ok(());
    }
    put_number(out, rounded(degrees))
}

/// Places as they are spelt, each with a comma behind it: what stands in the file several times is spelt once.
#[derive(Default)]
pub struct Spelt {
    text: Vec<u8>,
    /// Where the text of each place ends.
    ends: Vec<usize>,
}

impl Spelt {
    /// Spells one more place.
    pub fn push(&mut self, LonLat { lon, lat }: LonLat) -> io::Result<()> {
        self.text.push(b'[');
        put_degrees(&mut self.text, lon)?;
        self.text.push(b',');
        put_degrees(&mut self.text, lat)?;
        self.text.extend(b"],");
        self.ends.push(self.text.len());
        Ok(())
    }

    /// The text of places that follow each other.
    fn text(&self, places: Range<usize>) -> &[u8] {
        let end = |places: usize| places.checked_sub(1).map_or(0, |last| self.ends[last]);
        &self.text[end(places.start)..end(places.end)]
    }

    /// Puts the ground between two lines that run side by side, left and right, into the feature that was written last,
    /// without a geometry.
    pub fn put_ground(&self, out: &mut Vec<u8>, [left, right]: [&Range<usize>; 2]) {
        out.truncate(out.len() - b"null}".len());
        out.extend(b"{\"type\":\"Polygon\",\"coordinates\":[[");
        out.extend(self.text(right.clone()));
        left.clone().rev().for_each(|place| out.extend(self.text(place..place + 1)));
        out.extend(self.text(right.start..right.start + 1));
        out.pop();
        out.extend(b"]]}}");
    }
}

impl<'de> Deserialize<'de> for FeaturePlace {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Position;
        impl<'de> Visitor<'de> for Position {
            type Value = FeaturePlace;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a position: [longitude, latitude]")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<FeaturePlace, A::Error> {
                let mut number = |i| seq.next_element::<f64>()?.ok_or_else(|| de::Error::invalid_length(i, &self));
                let place = FeaturePlace([number(0)?, number(1)?]);
                // A height, which streets do not have.
                while seq.next_element::<IgnoredAny>()?.is_some() {}
                Ok(place)
            }
        }
        deserializer.deserialize_seq(Position)
    }
}

impl<'de> Deserialize<'de> for FeatureId {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct TextOrNumber;
        impl Visitor<'_> for TextOrNumber {
            type Value = FeatureId;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("an id: text or a whole number")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<FeatureId, E> {
                Ok(FeatureId(text.into()))
            }

            fn visit_i64<E: de::Error>(self, number: i64) -> Result<FeatureId, E> {
                Ok(FeatureId(number.to_string().into()))
            }

            fn visit_u64<E: de::Error>(self, number: u64) -> Result<FeatureId, E> {
                Ok(FeatureId(number.to_string().into()))
            }
        }
        deserializer.deserialize_any(TextOrNumber)
    }
}

/// Tags as an object, in their order.
pub mod tag_map {
    use super::*;

    pub fn serialize<S: Serializer>(tags: &Tags, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (key, value) in tags.iter().filter(|(key, value)| tags.is(key, value)) {
            map.serialize_entry(key, value)?;
        }
        map.end()
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Tags, D::Error> {
        struct Pairs;
        impl<'de> Visitor<'de> for Pairs {
            type Value = Tags;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("tags: an object of texts")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Tags, A::Error> {
                let mut tags = Tags::new();
                while let Some((key, value)) = map.next_entry::<Text, Text>()? {
                    tags.push(key, value);
                }
                Ok(tags)
            }
        }
        deserializer.deserialize_map(Pairs)
    }
}

/// Arrows as a list of the words of `turn:lanes`.
pub mod arrow_names {
    use super::*;

    const NAMES: [(&str, Arrows); 10] = [
        ("left", Arrows::LEFT),
        ("slight_left", Arrows::SLIGHT_LEFT),
        ("sharp_left", Arrows::SHARP_LEFT),
        ("through", Arrows::THROUGH),
        ("right", Arrows::RIGHT),
        ("slight_right", Arrows::SLIGHT_RIGHT),
        ("sharp_right", Arrows::SHARP_RIGHT),
        ("reverse", Arrows::REVERSE),
        ("merge_to_left", Arrows::MERGE_TO_LEFT),
        ("merge_to_right", Arrows::MERGE_TO_RIGHT),
    ];

    pub fn serialize<S: Serializer>(arrows: &Arrows, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(NAMES.iter().filter(|(_, arrow)| arrows.has(*arrow)).map(|(name, _)| name))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Arrows, D::Error> {
        let names = Vec::<Text>::deserialize(deserializer)?;
        let known = NAMES.map(|(name, _)| name);
        names.iter().try_fold(Arrows::NONE, |arrows, name| {
            let named = NAMES.iter().find(|(known, _)| known == name);
            Ok(arrows.and(
                named
                    .ok_or_else(|| {
                        de::Error::custom(format!("unknown arrow `{name}`, expected one of {}", known.join(", ")))
                    })?
                    .1,
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde::Serialize;

    use super::*;

    fn spelt(number: f64) -> String {
        let mut out = Vec::new();
        number.serialize(&mut serde_json::Serializer::with_formatter(&mut out, Spelling::default())).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn odd_numbers_are_spelt_as_everywhere() {
        for number in [0.0, -0.0, 1.0, -1.0, 1e-3, 0.000999999, 1e-9, 1e6, 999999.999999999, 0.1 + 0.2, -0.001, 1e300] {
            assert_eq!(spelt(number), serde_json::to_string(&number).unwrap());
        }
    }

    proptest! {
        #[test]
        fn numbers_are_spelt_as_everywhere(steps in -180_000_000_000_i64..180_000_000_000, decimals in 0..12, any: f64) {
            for number in [steps as f64 / 10_f64.powi(decimals), any] {
                prop_assert_eq!(spelt(number), serde_json::to_string(&number).unwrap());
            }
        }
    }
}
