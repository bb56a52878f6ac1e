//! How numbers, positions, ids, tags and arrows are spelt in the file.

use std::io::{self, Write};

use serde::Deserialize;
use serde::de::{self, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::ser::{SerializeMap, Serializer};
use serde_json::ser::{CompactFormatter, Formatter};

use crate::builder::cross_section::Arrows;
use crate::osm::{Tags, Text, put_fixed};

use super::shape::{Id, Place};

/// Spells numbers as `serde_json` does, in less time where they have no more than nine decimals, as most have.
#[derive(Default)]
pub struct Spelling {
    number: Vec<u8>,
}

impl Formatter for Spelling {
    fn write_f64<W: ?Sized + Write>(&mut self, out: &mut W, value: f64) -> io::Result<()> {
        const DECIMALS: usize = 9;
        const STEPS: f64 = 1e9;
        // Numbers of up to fifteen digits are all different ones: no shorter spelling stands for the same. Of small ones
        // the usual spelling has an exponent.
        let spelt = (1e-3..1e6).contains(&value.abs()) && {
            let steps = (value.abs() * STEPS + 0.5) as u64;
            steps as f64 / STEPS == value.abs()
        };
        if !spelt {
            return CompactFormatter.write_f64(out, value);
        }
        self.number.clear();
        put_fixed(&mut self.number, value, DECIMALS);
        let spare = self.number.iter().rev().take_while(|digit| **digit == b'0').count();
        // Of a whole number one decimal stays.
        let spare = spare.min(DECIMALS - 1);
        out.write_all(&self.number[..self.number.len() - spare])
    }
}

impl<'de> Deserialize<'de> for Place {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Position;
        impl<'de> Visitor<'de> for Position {
            type Value = Place;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a position: [longitude, latitude]")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Place, A::Error> {
                let mut number = |i| seq.next_element::<f64>()?.ok_or_else(|| de::Error::invalid_length(i, &self));
                let place = Place([number(0)?, number(1)?]);
                // A height, which streets do not have.
                while seq.next_element::<IgnoredAny>()?.is_some() {}
                Ok(place)
            }
        }
        deserializer.deserialize_seq(Position)
    }
}

impl<'de> Deserialize<'de> for Id {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct TextOrNumber;
        impl Visitor<'_> for TextOrNumber {
            type Value = Id;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("an id: text or a whole number")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Id, E> {
                Ok(Id(text.into()))
            }

            fn visit_i64<E: de::Error>(self, number: i64) -> Result<Id, E> {
                Ok(Id(number.to_string().into()))
            }

            fn visit_u64<E: de::Error>(self, number: u64) -> Result<Id, E> {
                Ok(Id(number.to_string().into()))
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
