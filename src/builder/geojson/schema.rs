//! The features of the file, as they are written and read. `docs/geometry.md` says what each property means.

use crate::builder::network::{End, RoadKey};
use crate::builder::streets::outline::OutlineCase;
use crate::builder::tags::cross_section::{Arrows, StripKind, Travel};
use crate::builder::tags::road_class::RoadClass;
use crate::osm::{Tags, Text};

use super::encoding::{arrow_names, tag_map};
use super::id::{FeatureId, FeaturePlace};

use serde::{Deserialize, Serialize};

/// A feature of one type.
#[derive(Debug, Serialize, Deserialize)]
pub struct Feature<P> {
    #[serde(rename = "type")]
    pub kind: FeatureTag,
    pub properties: P,
    pub geometry: Option<Geometry>,
}

impl<P> Feature<P> {
    pub fn new(properties: P, geometry: Option<Geometry>) -> Self {
        Self { kind: FeatureTag::Feature, properties, geometry }
    }
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub enum FeatureTag {
    Feature,
}

/// The geometries that a street can have.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "type", content = "coordinates")]
pub enum Geometry {
    LineString(Vec<FeaturePlace>),
    Polygon(Vec<Vec<FeaturePlace>>),
    MultiPolygon(Vec<Vec<Vec<FeaturePlace>>>),
}

/// The type of a feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Type {
    Road,
    Lane,
    Intersection,
}

/// A level, or a list of levels.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Levels {
    One(f64),
    Several(Vec<f64>),
}

impl Levels {
    pub fn first(&self) -> Option<f64> {
        match self {
            Self::One(level) => Some(*level),
            Self::Several(levels) => levels.first().copied(),
        }
    }
}

fn yes() -> bool {
    true
}

#[derive(Debug, Serialize, Deserialize)]
pub struct RoadShape {
    #[serde(rename = "type")]
    pub kind: Type,
    pub id: FeatureId,
    pub src: Option<FeatureId>,
    pub dst: Option<FeatureId>,
    #[serde(default)]
    pub osm_ids: Vec<i64>,
    #[serde(default = "yes")]
    pub drive: bool,
    pub layer: Option<Levels>,
    pub width: Option<f64>,
    pub length: Option<f64>,
    pub trim_start: Option<f64>,
    pub trim_end: Option<f64>,
    #[serde(default)]
    pub oblivion: bool,
    #[serde(default)]
    pub ends: Vec<EndShape>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<Text>,
    pub class: Option<RoadClass>,
    #[serde(default)]
    pub link: bool,
    #[serde(default)]
    pub roundabout: bool,
    #[serde(default = "yes")]
    pub public: bool,
    pub speed: Option<[f64; 2]>,
    pub key: Option<KeyShape>,
    #[serde(default)]
    pub centerline: Vec<FeaturePlace>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub heights: Vec<f64>,
    pub kept: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub furniture: Vec<FurnitureShape>,
    #[serde(default, with = "tag_map", skip_serializing_if = "Tags::is_empty")]
    pub tags: Tags,
}

/// The cut across one end of a road.
#[derive(Debug, Serialize, Deserialize)]
pub struct EndShape {
    pub int: Option<FeatureId>,
    pub pts: Vec<FeaturePlace>,
}

/// The key of a road: no other road has it, and it stays the same when the input changes elsewhere.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct KeyShape {
    pub way: i64,
    pub first: i64,
    pub last: i64,
    #[serde(default)]
    pub turn: u32,
}

impl From<RoadKey> for KeyShape {
    fn from(RoadKey { way, first, last, turn }: RoadKey) -> Self {
        Self { way, first, last, turn }
    }
}

impl From<KeyShape> for RoadKey {
    fn from(KeyShape { way, first, last, turn }: KeyShape) -> Self {
        Self { way, first, last, turn }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FurnitureKind {
    Crossing,
    Signals,
    MidBlockSignals,
    Stop,
    GiveWay,
    StopLine,
    Sidewalk,
}

/// A crossing, light or sign.
#[derive(Debug, Serialize, Deserialize)]
pub struct FurnitureShape {
    pub kind: FurnitureKind,
    pub station: f64,
    #[serde(default)]
    pub node: i64,
    /// The direction of the traffic that a light or sign faces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub travel: Option<Travel>,
    /// Whether a crossing has lights.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signals: Option<bool>,
    /// Whether a crossing is painted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub marked: Option<bool>,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct LaneShape {
    #[serde(rename = "type")]
    pub kind: Type,
    pub id: Option<FeatureId>,
    pub road: FeatureId,
    pub index: Option<u32>,
    #[serde(default = "yes")]
    pub drive: bool,
    pub layer: Option<Levels>,
    #[serde(rename = "kind", default = "drive")]
    pub strip: StripKind,
    pub travel: Option<Travel>,
    pub width: Option<f64>,
    #[serde(default)]
    pub width_guessed: bool,
    #[serde(default, with = "arrow_names", skip_serializing_if = "no_arrows")]
    pub arrows: Arrows,
    #[serde(default, skip_serializing_if = "is_untagged")]
    pub change: [Option<bool>; 2],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub bicycles: bool,
}

/// A lane that is no feature of its own.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StripShape {
    #[serde(rename = "kind", default = "drive")]
    pub strip: StripKind,
    pub travel: Travel,
    pub width: f64,
    #[serde(default)]
    pub width_guessed: bool,
    #[serde(default, with = "arrow_names", skip_serializing_if = "no_arrows")]
    pub arrows: Arrows,
    #[serde(default, skip_serializing_if = "is_untagged")]
    pub change: [Option<bool>; 2],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub bicycles: bool,
}

fn drive() -> StripKind {
    StripKind::Drive
}

fn no_arrows(arrows: &Arrows) -> bool {
    arrows.is_none()
}

fn is_untagged(change: &[Option<bool>; 2]) -> bool {
    *change == [None, None]
}

#[derive(Debug, Serialize, Deserialize)]
pub struct IntersectionShape {
    #[serde(rename = "type")]
    pub kind: Type,
    pub id: FeatureId,
    #[serde(default)]
    pub roads: Vec<FeatureId>,
    #[serde(default = "yes")]
    pub drive: bool,
    pub layer: Option<Levels>,
    pub case: Option<OutlineCase>,
    #[serde(default)]
    pub terminal: bool,
    #[serde(default)]
    pub fallback: bool,
    #[serde(default)]
    pub merged_from: Vec<i64>,
    pub map_edge: Option<bool>,
    #[serde(default)]
    pub signals: bool,
    #[serde(default)]
    pub all_way_stop: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub circle: Option<Text>,
    pub position: Option<FeaturePlace>,
    #[serde(default)]
    pub arms: Vec<ArmShape>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub passages: Option<Vec<[usize; 2]>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inner: Vec<InnerShape>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub restrictions: Vec<RestrictionShape>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub connections: Vec<ConnectionShape>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub islands: Vec<IslandShape>,
}

/// An island: ground inside an intersection on which nobody drives.
#[derive(Debug, Serialize, Deserialize)]
pub struct IslandShape {
    #[serde(default)]
    pub osm_id: i64,
    pub ring: Vec<FeaturePlace>,
}

/// One end of a road.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArmShape {
    pub road: FeatureId,
    pub end: End,
}

/// A road that became part of a merged intersection.
#[derive(Debug, Serialize, Deserialize)]
pub struct InnerShape {
    pub key: KeyShape,
    pub osm_ids: Vec<i64>,
    pub centerline: Vec<FeaturePlace>,
    pub lanes: Vec<StripShape>,
    #[serde(default)]
    pub roundabout: bool,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct RestrictionShape {
    #[serde(default)]
    pub relation: i64,
    pub from: ArmShape,
    #[serde(default)]
    pub via: Vec<FeatureId>,
    pub to: ArmShape,
    pub only: bool,
}

/// The lanes of one road that lead to lanes of another.
#[derive(Debug, Serialize, Deserialize)]
pub struct ConnectionShape {
    #[serde(default)]
    pub relation: i64,
    pub from: ArmShape,
    pub to: ArmShape,
    pub lanes: Vec<[usize; 2]>,
}

/// A type that holds positions. All positions of a file are projected at once.
pub trait Placed {
    /// Calls `visit` with every position.
    fn each_place<'a>(&'a mut self, visit: &mut dyn FnMut(&'a mut FeaturePlace));
}

impl<P: Placed> Placed for Feature<P> {
    fn each_place<'a>(&'a mut self, visit: &mut dyn FnMut(&'a mut FeaturePlace)) {
        self.properties.each_place(visit);
        match &mut self.geometry {
            None => {}
            Some(Geometry::LineString(line)) => line.iter_mut().for_each(visit),
            Some(Geometry::Polygon(rings)) => rings.iter_mut().flatten().for_each(visit),
            Some(Geometry::MultiPolygon(parts)) => parts.iter_mut().flatten().flatten().for_each(visit),
        }
    }
}

impl Placed for RoadShape {
    fn each_place<'a>(&'a mut self, visit: &mut dyn FnMut(&'a mut FeaturePlace)) {
        self.centerline.iter_mut().for_each(&mut *visit);
        self.ends.iter_mut().flat_map(|end| &mut end.pts).for_each(visit);
    }
}

impl Placed for IntersectionShape {
    fn each_place<'a>(&'a mut self, visit: &mut dyn FnMut(&'a mut FeaturePlace)) {
        self.position.iter_mut().for_each(&mut *visit);
        self.inner.iter_mut().flat_map(|inner| &mut inner.centerline).for_each(&mut *visit);
        self.islands.iter_mut().flat_map(|island| &mut island.ring).for_each(visit);
    }
}
