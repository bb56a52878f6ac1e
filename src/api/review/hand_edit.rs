//! Edits that a person makes of a map: what each changes, and why one cannot be made.

use std::fmt;

use serde::{Deserialize, Deserializer};

use crate::diagnostic::{Edit, Fix, Subject};
use crate::geometry::Point;
use crate::lanelet::{
    LaneletId, LaneletMap, LineStringId, PointId, PolygonId, RegulatoryElement, RegulatoryElementId, Target,
    TurnDirection,
};
use crate::osm::OsmData;
use crate::projection::Projector;
use crate::report::failure::Failure;

/// What kind of element an id names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ElementWord {
    /// A node.
    #[serde(alias = "node")]
    Point,
    /// A way without `area=yes`.
    #[serde(alias = "linestring", alias = "way")]
    Line,
    /// A way with `area=yes`.
    #[serde(alias = "area")]
    Polygon,
    /// A lanelet.
    Lanelet,
    /// A regulatory element.
    #[serde(alias = "element")]
    Rule,
}

/// One edit. Ids are texts where they come from a page, because JavaScript's numbers do not hold all of them.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "edit", rename_all = "kebab-case", deny_unknown_fields)]
pub enum HandEdit {
    /// Give an element a tag, or take it.
    Tag {
        kind: ElementWord,
        #[serde(deserialize_with = "id")]
        id: i64,
        key: String,
        value: Option<String>,
    },
    /// Say where a lanelet turns, or that it does not.
    Turn {
        #[serde(deserialize_with = "id")]
        lanelet: i64,
        turn: Option<String>,
    },
    /// Let a lanelet give way to another.
    AddYield {
        /// The one that goes first.
        #[serde(deserialize_with = "id")]
        first: i64,
        /// The one that gives way.
        #[serde(deserialize_with = "id")]
        waits: i64,
    },
    /// Take that back.
    RemoveYield {
        #[serde(deserialize_with = "id")]
        first: i64,
        #[serde(deserialize_with = "id")]
        waits: i64,
    },
    /// Let an end node of lines become another node, wherever it is used.
    Join {
        #[serde(deserialize_with = "id")]
        from: i64,
        #[serde(deserialize_with = "id")]
        to: i64,
    },
    /// Put a vertex of an area elsewhere: local metres, east and north.
    MoveVertex {
        #[serde(deserialize_with = "id")]
        area: i64,
        #[serde(deserialize_with = "id")]
        node: i64,
        to: [f64; 2],
    },
    /// Let an area run over another node in place of one of its vertices.
    ReplaceVertex {
        #[serde(deserialize_with = "id")]
        area: i64,
        #[serde(deserialize_with = "id")]
        node: i64,
        #[serde(deserialize_with = "id")]
        by: i64,
    },
}

fn id<'de, D: Deserializer<'de>>(from: D) -> Result<i64, D::Error> {
    String::deserialize(from)?.parse().map_err(serde::de::Error::custom)
}

/// Elements that lanelets go by in a right of way.
const RIGHT_OF_WAY: &str = "right_of_way";
const YIELD: &str = "yield";

impl HandEdit {
    /// From the words that a person types: `tag lanelet 5 speed_limit=30`, `turn 5 left`, `yield 5 add 6`, `join 11 12`,
    /// `vertex 9 11 12`.
    ///
    /// # Errors
    ///
    /// Where the words are none of these.
    pub fn parse(text: &str) -> Result<Self, Failure> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let number = |word: &str| {
            word.parse::<i64>().map_err(|_| Failure::new(format!("{word} is no id")).help("an id is a whole number"))
        };
        match words.as_slice() {
            ["tag", kind, id, tag, ..] => {
                let kind = serde_json::from_value((*kind).into()).map_err(|_| {
                    Failure::new(format!("{kind} is no kind of element"))
                        .help("point, line, polygon, lanelet, or rule for a regulatory element")
                })?;
                // A value may have blanks.
                let from = text.find(tag).unwrap_or_default();
                let (key, value) = text.get(from..).unwrap_or_default().split_once('=').unwrap_or((tag, ""));
                let value = Some(value.trim().to_owned()).filter(|value| !value.is_empty());
                Ok(Self::Tag { kind, id: number(id)?, key: key.trim().to_owned(), value })
            }
            ["turn", lanelet, turn] => {
                let turn = Some((*turn).to_owned()).filter(|turn| turn != "none");
                Ok(Self::Turn { lanelet: number(lanelet)?, turn })
            }
            ["yield", first, "add", waits] => Ok(Self::AddYield { first: number(first)?, waits: number(waits)? }),
            ["yield", first, "take", waits] => Ok(Self::RemoveYield { first: number(first)?, waits: number(waits)? }),
            ["join", from, to] => Ok(Self::Join { from: number(from)?, to: number(to)? }),
            ["vertex", area, node, by] => {
                Ok(Self::ReplaceVertex { area: number(area)?, node: number(node)?, by: number(by)? })
            }
            _ => Err(Failure::new(format!("no such edit: {text}")).help(HELP)),
        }
    }

    /// The edits that make it.
    ///
    /// # Errors
    ///
    /// Where the map lacks what it names, or is so already.
    pub fn fix(&self, map: &LaneletMap, osm: &OsmData, projector: &Projector) -> Result<Fix, Failure> {
        let edits = match self {
            Self::Tag { kind, id, key, value } => vec![tag(subject(map, *kind, *id)?, osm, key, value.as_deref())?],
            Self::Turn { lanelet, turn } => {
                if let Some(turn) = turn.as_deref().filter(|turn| TurnDirection::parse(turn).is_none()) {
                    return Err(Failure::new(format!("{turn} is no turn")).help("left, straight, right, or none"));
                }
                let on = subject(map, ElementWord::Lanelet, *lanelet)?;
                vec![tag(on, osm, "turn_direction", turn.as_deref())?]
            }
            Self::AddYield { first, waits } => add_yield(map, *first, *waits)?,
            Self::RemoveYield { first, waits } => remove_yield(map, *first, *waits)?,
            Self::Join { from, to } => vec![join(map, *from, *to)?],
            Self::MoveVertex { area, node, to } => {
                position_in(map, *area, *node)?;
                moved(osm, projector, *node, Point::new(to[0], to[1]))?
            }
            Self::ReplaceVertex { area, node, by } => {
                let (at, mut points) = position_in(map, *area, *node)?;
                if points.contains(by) {
                    return Err(Failure::new(format!("area {area} runs over node {by} already")));
                }
                subject(map, ElementWord::Point, *by)?;
                if let Some(point) = points.get_mut(at) {
                    *point = *by;
                }
                vec![Edit::SetVertices { way: Subject::Polygon(*area), points }]
            }
        };
        Ok(Fix { title: self.to_string(), safe: false, edits })
    }
}

/// What a person can type.
pub const HELP: &str = "tag KIND ID KEY=VALUE (nothing behind = removes it), turn LANELET left|straight|right|none, yield FIRST add|take \
                        WAITS, join NODE TO, vertex AREA NODE BY";

/// What an id names, if the map has it.
fn subject(map: &LaneletMap, kind: ElementWord, id: i64) -> Result<Subject, Failure> {
    let (there, subject) = match kind {
        ElementWord::Point => (map.points.contains(PointId(id)), Subject::Point(id)),
        ElementWord::Line => (map.linestrings.contains(LineStringId(id)), Subject::LineString(id)),
        ElementWord::Polygon => (map.polygons.contains(PolygonId(id)), Subject::Polygon(id)),
        ElementWord::Lanelet => (map.lanelets.contains(LaneletId(id)), Subject::Lanelet(id)),
        ElementWord::Rule => {
            (map.regulatory_elements.contains(RegulatoryElementId(id)), Subject::RegulatoryElement(id))
        }
    };
    if there { Ok(subject) } else { Err(Failure::new(format!("this map has no {subject}"))) }
}

fn tag(on: Subject, osm: &OsmData, key: &str, value: Option<&str>) -> Result<Edit, Failure> {
    let is_bad = |text: &str| text.chars().any(char::is_control);
    if key.is_empty() || is_bad(key) || value.is_some_and(is_bad) {
        return Err(Failure::new("a tag has a key, and no control characters").help("write KEY=VALUE in one line"));
    }
    let id = on.id().unwrap_or_default();
    let tags = match on {
        Subject::Point(_) => osm.node(id).map(|node| &node.tags),
        Subject::LineString(_) | Subject::Polygon(_) => osm.way(id).map(|way| &way.tags),
        _ => osm.relation(id).map(|relation| &relation.tags),
    };
    let now = tags.and_then(|tags| tags.get(key));
    if now == value {
        let so = value.map_or_else(|| format!("no {key}"), |value| format!("{key}={value}"));
        return Err(Failure::new(format!("{on} has {so} already")));
    }
    Ok(match value {
        Some(value) => Edit::SetTag { on, key: key.into(), value: value.into() },
        None => Edit::RemoveTag { on, key: key.into() },
    })
}

/// The right of way of a lanelet: elements that it refers to and that name it as the one who goes first.
fn rights_of_way(map: &LaneletMap, lanelet: i64) -> impl Iterator<Item = &RegulatoryElement> {
    let elements = map.lanelets.get(LaneletId(lanelet)).into_iter().flat_map(|lanelet| &lanelet.regulatory_elements);
    elements.filter_map(|id| map.regulatory_elements.get(*id)).filter(move |element| {
        element.subtype == RIGHT_OF_WAY
            && element.role(RIGHT_OF_WAY).any(|target| target == Target::Lanelet(LaneletId(lanelet)))
    })
}

fn add_yield(map: &LaneletMap, first: i64, waits: i64) -> Result<Vec<Edit>, Failure> {
    for lanelet in [first, waits] {
        subject(map, ElementWord::Lanelet, lanelet)?;
    }
    if first == waits {
        return Err(Failure::new("a lanelet does not give way to itself"));
    }
    let member = Subject::Lanelet(waits);
    let mut elements = rights_of_way(map, first);
    let Some(element) = elements.next() else {
        let members = vec![(RIGHT_OF_WAY.into(), Subject::Lanelet(first)), (YIELD.into(), member)];
        return Ok(vec![Edit::CreateRegulatoryElement {
            subtype: RIGHT_OF_WAY.into(),
            members,
            referrers: vec![first],
        }]);
    };
    if std::iter::once(element).chain(elements).any(|one| yields(one, waits)) {
        return Err(Failure::new(format!("lanelet {waits} gives way to lanelet {first} already")));
    }
    Ok(vec![Edit::AddMember { on: Subject::RegulatoryElement(element.id.0), role: YIELD.into(), member }])
}

fn yields(element: &RegulatoryElement, lanelet: i64) -> bool {
    element.role(YIELD).any(|target| target == Target::Lanelet(LaneletId(lanelet)))
}

fn remove_yield(map: &LaneletMap, first: i64, waits: i64) -> Result<Vec<Edit>, Failure> {
    let only = Target::Lanelet(LaneletId(waits));
    let remove = |element: &RegulatoryElement| {
        let on = Subject::RegulatoryElement(element.id.0);
        // The library loads no right of way to which nobody gives way.
        match element.role(YIELD).all(|target| target == only) {
            true => Edit::Remove { subject: on },
            false => Edit::RemoveMember { on, role: YIELD.into(), member: Subject::Lanelet(waits) },
        }
    };
    let edits: Vec<Edit> = rights_of_way(map, first).filter(|element| yields(element, waits)).map(remove).collect();
    match edits.is_empty() {
        true => Err(Failure::new(format!(
            "no right_of_way of lanelet {first} names lanelet {waits} as the one who gives way"
        ))),
        false => Ok(edits),
    }
}

fn join(map: &LaneletMap, from: i64, to: i64) -> Result<Edit, Failure> {
    for node in [from, to] {
        subject(map, ElementWord::Point, node)?;
    }
    if from == to {
        return Err(Failure::new("these are one node already"));
    }
    let is_end =
        |line: &crate::lanelet::LineString| [line.points.first(), line.points.last()].contains(&Some(&PointId(from)));
    if !map.linestrings.iter().any(is_end) {
        return Err(Failure::new(format!("node {from} is no end of a line")).help("join an end node to another node"));
    }
    Ok(Edit::MergePoints { from, to })
}

/// Where a node stands in the outline of an area, and all nodes of that.
fn position_in(map: &LaneletMap, area: i64, node: i64) -> Result<(usize, Vec<i64>), Failure> {
    let polygon =
        map.polygons.get(PolygonId(area)).ok_or_else(|| Failure::new(format!("this map has no area {area}")))?;
    let points: Vec<i64> = polygon.points.iter().map(|point| point.0).collect();
    match points.iter().position(|&point| point == node) {
        Some(at) => Ok((at, points)),
        None => Err(Failure::new(format!("node {node} is no vertex of area {area}"))),
    }
}

/// The edits that put a node elsewhere, by latitude and longitude and by local coordinates, as far as it has them.
fn moved(osm: &OsmData, projector: &Projector, node: i64, to: Point) -> Result<Vec<Edit>, Failure> {
    let there = osm.node(node).ok_or_else(|| Failure::new(format!("this map has no node {node}")))?;
    if !to.coords.iter().all(|metres| metres.is_finite()) {
        return Err(Failure::new("the new place is none"));
    }
    let on = Subject::Point(node);
    let height = there.tags.get("ele").and_then(|ele| ele.trim().parse::<f64>().ok()).unwrap_or_default();
    let place = projector.inverse_each(&[to], |_| height).pop().flatten();
    let place = place.filter(|_| there.position.is_some()).map(|place| Edit::SetPlace { point: node, place });
    let tags = [("local_x", to.x), ("local_y", to.y)].into_iter().filter(|(key, _)| there.tags.has(key));
    let tags = tags.map(|(key, metres)| Edit::SetTag { on, key: key.into(), value: format!("{metres:.4}").into() });
    let edits: Vec<Edit> = place.into_iter().chain(tags).collect();
    match edits.is_empty() {
        true => Err(Failure::new(format!("node {node} has neither a latitude nor local coordinates to change"))),
        false => Ok(edits),
    }
}

impl fmt::Display for HandEdit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tag { kind, id, key, value } => {
                let kind = match kind {
                    ElementWord::Point => "point",
                    ElementWord::Line => "linestring",
                    ElementWord::Polygon => "area",
                    ElementWord::Lanelet => "lanelet",
                    ElementWord::Rule => "regulatory element",
                };
                match value {
                    Some(value) => write!(f, "set {key}={value} on {kind} {id}"),
                    None => write!(f, "remove {key} from {kind} {id}"),
                }
            }
            Self::Turn { lanelet, turn: Some(turn) } => write!(f, "lanelet {lanelet} turns {turn}"),
            Self::Turn { lanelet, turn: None } => write!(f, "lanelet {lanelet} does not turn"),
            Self::AddYield { first, waits } => write!(f, "lanelet {waits} gives way to lanelet {first}"),
            Self::RemoveYield { first, waits } => write!(f, "lanelet {waits} does not give way to lanelet {first}"),
            Self::Join { from, to } => write!(f, "node {from} becomes node {to}"),
            Self::MoveVertex { area, node, to: [east, north] } => {
                write!(f, "vertex {node} of area {area} moves to {east:.3}, {north:.3}")
            }
            Self::ReplaceVertex { area, node, by } => write!(f, "area {area} runs over node {by} in place of {node}"),
        }
    }
}
