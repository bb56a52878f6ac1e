//! How positions, ids, tags and arrows are encoded in the file.

use std::ops::Range;

use serde::Deserialize;
use serde::de::{self, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::ser::{SerializeMap, Serializer};

use crate::builder::tags::cross_section::Arrows;
use crate::osm::{Tags, Text};
use crate::projection::LonLat;

use super::id::{FeatureId, FeaturePlace};

/// Degrees with nine decimals: 0.1 mm.
pub fn rounded(degrees: f64) -> f64 {
    const PER_DEGREE: f64 = 1e9;
    (degrees * PER_DEGREE).round() / PER_DEGREE
}

/// Positions as JSON, each followed by a comma. A position that several features share is encoded once.
#[derive(Default)]
pub struct EncodedPositions {
    text: Vec<u8>,
    /// Where each position ends in `text`.
    ends: Vec<usize>,
}

impl EncodedPositions {
    /// Encodes one more position.
    ///
    /// # Errors
    ///
    /// None in practice: it writes into memory.
    pub fn push(&mut self, LonLat { lon, lat }: LonLat) -> serde_json::Result<()> {
        serde_json::to_writer(&mut self.text, &[rounded(lon), rounded(lat)])?;
        self.text.push(b',');
        self.ends.push(self.text.len());
        Ok(())
    }

    fn text(&self, positions: Range<usize>) -> &[u8] {
        let end = |count: usize| count.checked_sub(1).map_or(0, |last| self.ends[last]);
        &self.text[end(positions.start)..end(positions.end)]
    }

    /// Gives the feature that was written last, and has no geometry yet, the polygon between a left and a right edge.
    pub fn put_polygon(&self, out: &mut Vec<u8>, [left, right]: [&Range<usize>; 2]) {
        out.truncate(out.len() - b"null}".len());
        out.extend(b"{\"type\":\"Polygon\",\"coordinates\":[[");
        out.extend(self.text(right.clone()));
        left.clone().rev().for_each(|position| out.extend(self.text(position..position + 1)));
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
                // The height of a position is not used.
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

/// Tags as an object that keeps their order.
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

/// Arrows as a list of the values of `turn:lanes`.
pub mod arrow_names {
    use super::*;

    pub fn serialize<S: Serializer>(arrows: &Arrows, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(Arrows::NAMES.iter().filter(|(_, arrow)| arrows.has(*arrow)).map(|(name, _)| name))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Arrows, D::Error> {
        let names = Vec::<Text>::deserialize(deserializer)?;
        names.iter().try_fold(Arrows::NONE, |arrows, name| {
            let named = Arrows::named(name).ok_or_else(|| {
                let known = Arrows::NAMES.map(|(name, _)| name).join(", ");
                de::Error::custom(format!("unknown arrow `{name}`, expected one of {known}"))
            })?;
            Ok(arrows.and(named))
        })
    }
}
