//! What a page wants of the input: nodes elsewhere, other tags, roads merged or kept apart.

use std::collections::BTreeMap;

use crate::osm::{OsmData, kept};
use crate::projection::LonLat;
use crate::report::failure::Failure;
use crate::settings::MergeSettings;
use serde::{Deserialize, Deserializer};

/// One edit. A later one of the same thing goes above an earlier one.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "edit", rename_all = "lowercase", deny_unknown_fields)]
pub enum Edit {
    /// Put a node elsewhere, degrees.
    Move {
        #[serde(deserialize_with = "id")]
        node: i64,
        lat: f64,
        lon: f64,
    },
    /// Give a way a tag, or take it.
    Tag {
        #[serde(deserialize_with = "id")]
        way: i64,
        key: String,
        value: Option<String>,
    },
    /// Merge the road between two nodes, keep it apart, or let the program decide.
    Merge {
        #[serde(deserialize_with = "ids")]
        nodes: [i64; 2],
        merge: Option<bool>,
    },
}

/// What a page asks to be built.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Question {
    /// In the order in which they were made.
    #[serde(default)]
    pub edits: Vec<Edit>,
    /// Latitude and longitude of what is looked at.
    pub around: Option<[f64; 2]>,
    /// Whether the answer is wanted at once, without what the rules find: that takes as long as all the rest.
    #[serde(default)]
    pub quick: bool,
}

/// Ids are texts, because JavaScript's numbers do not hold all of them.
fn id<'de, D: Deserializer<'de>>(from: D) -> Result<i64, D::Error> {
    String::deserialize(from)?.parse().map_err(serde::de::Error::custom)
}

fn ids<'de, D: Deserializer<'de>>(from: D) -> Result<[i64; 2], D::Error> {
    let [a, b] = <[String; 2]>::deserialize(from)?;
    let number = |text: String| text.parse().map_err(serde::de::Error::custom);
    Ok([number(a)?, number(b)?])
}

impl Question {
    /// Where each moved node goes in the end.
    pub fn moves(&self) -> BTreeMap<i64, LonLat> {
        let moves = self.edits.iter().filter_map(|edit| match *edit {
            Edit::Move { node, lat, lon } => Some((node, kept(LonLat { lon, lat }))),
            _ => None,
        });
        moves.collect()
    }

    /// What each changed tag is in the end, by way and key.
    pub fn tags(&self) -> BTreeMap<(i64, &str), Option<&str>> {
        let tags = self.edits.iter().filter_map(|edit| match edit {
            Edit::Tag { way, key, value } => Some(((*way, key.as_str()), value.as_deref())),
            _ => None,
        });
        tags.collect()
    }

    /// The roads that are decided in the end, merged or not.
    pub fn merges(&self) -> Vec<(MergeSettings, bool)> {
        let wishes: BTreeMap<[i64; 2], Option<bool>> = self
            .edits
            .iter()
            .filter_map(|edit| match edit {
                Edit::Merge { nodes, merge } => Some((*nodes, *merge)),
                _ => None,
            })
            .collect();
        let said = |nodes: [i64; 2]| MergeSettings { nodes: nodes.to_vec(), ..MergeSettings::default() };
        wishes.into_iter().filter_map(|(nodes, merge)| Some((said(nodes), merge?))).collect()
    }

    /// Makes the edits of nodes and tags. What lies outside of a part of the input is passed over.
    pub fn apply(&self, data: &mut OsmData) -> Result<(), Failure> {
        for (node, place) in self.moves() {
            let on_earth = (-90.0..=90.0).contains(&place.lat) && (-180.0..=180.0).contains(&place.lon);
            if !on_earth {
                return Err(Failure::new(format!("node {node} cannot go to {}, {}", place.lat, place.lon)));
            }
            data.move_node(node, place);
        }
        for ((way, key), value) in self.tags() {
            data.tag_way(way, key, value);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_edit_of_a_thing_counts() {
        let question: Question = serde_json::from_str(
            r#"{"edits":[{"edit":"tag","way":"-7","key":"lanes","value":"3"},{"edit":"move","node":"1","lat":48.00000004,"lon":11},
            {"edit":"tag","way":"-7","key":"lanes","value":null},{"edit":"merge","nodes":["1","2"],"merge":true},
            {"edit":"merge","nodes":["3","4"],"merge":false},{"edit":"merge","nodes":["1","2"],"merge":null}]}"#,
        )
        .unwrap();
        assert_eq!(question.tags(), BTreeMap::from([((-7, "lanes"), None)]));
        assert_eq!(question.moves(), BTreeMap::from([(1, LonLat { lon: 11.0, lat: 48.0 })]));
        let merges = question.merges();
        assert_eq!((merges.len(), merges[0].0.nodes.as_slice(), merges[0].1), (1, [3, 4].as_slice(), false));
    }

    #[test]
    fn what_is_no_edit_is_refused() {
        for text in [
            r#"{"edits":[{"edit":"move","node":1,"lat":0,"lon":0}]}"#,
            r#"{"edits":[{"edit":"burn"}]}"#,
            r#"{"edits":[],"path":"/etc/passwd"}"#,
        ] {
            assert!(serde_json::from_str::<Question>(text).is_err(), "{text}");
        }
        let far: Question = serde_json::from_str(r#"{"edits":[{"edit":"move","node":"1","lat":91,"lon":0}]}"#).unwrap();
        assert!(far.apply(&mut OsmData::default()).is_err());
    }
}
