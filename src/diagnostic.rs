//! What is wrong, where, and what to do about it. Knows no rule and no output format.

mod division;
pub mod fingerprint;

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::geometry::Point;
use crate::projection::LonLat;
use crate::text::Text;
pub use crate::text::{SourceSpan, nearest};
pub use division::{CutPlace, Division, LaneletCut, WayCut};

/// How bad the consequence is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// A review hint.
    Info,
    /// Degraded behaviour, or a requirement broken.
    Warning,
    /// The map does not load, Autoware crashes, or a rule of the road is unsafe or without effect.
    Error,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Info => "info",
            Self::Warning => "warning",
            Self::Error => "error",
        })
    }
}

/// What a finding speaks about. Ids are those of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind", content = "id")]
pub enum Subject {
    /// The map as a whole.
    Map,
    /// A Lanelet2 point: a node of the file.
    Point(i64),
    /// A Lanelet2 linestring: a way without `area=yes`.
    LineString(i64),
    /// A Lanelet2 polygon: a way with `area=yes`.
    Polygon(i64),
    /// A relation with `type=lanelet`.
    Lanelet(i64),
    /// A relation with `type=regulatory_element`.
    RegulatoryElement(i64),
    /// An element of the file that has no part in Lanelet2, or an OpenStreetMap node that is built from.
    Node(i64),
    /// See [`Subject::Node`].
    Way(i64),
    /// See [`Subject::Node`]; also an area, a relation with `type=multipolygon`.
    Relation(i64),
}

impl Subject {
    /// The word for the kind of primitive, as messages use it.
    pub fn kind(self) -> &'static str {
        match self {
            Self::Map => "map",
            Self::Point(_) => "point",
            Self::LineString(_) => "linestring",
            Self::Polygon(_) => "polygon",
            Self::Lanelet(_) => "lanelet",
            Self::RegulatoryElement(_) => "regulatory element",
            Self::Node(_) => "node",
            Self::Way(_) => "way",
            Self::Relation(_) => "relation",
        }
    }

    /// The id in the file; `None` for the map as a whole.
    pub fn id(self) -> Option<i64> {
        match self {
            Self::Map => None,
            Self::Point(id)
            | Self::LineString(id)
            | Self::Polygon(id)
            | Self::Lanelet(id)
            | Self::RegulatoryElement(id)
            | Self::Node(id)
            | Self::Way(id)
            | Self::Relation(id) => Some(id),
        }
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.id() {
            None => f.write_str(self.kind()),
            Some(id) => write!(f, "{} {id}", self.kind()),
        }
    }
}

/// Where to look, in local metres.
#[derive(Clone, Debug, PartialEq, Default)]
pub enum Place {
    /// Nowhere in particular; the subject's own geometry is drawn.
    #[default]
    Unknown,
    /// One spot.
    Point(Point),
    /// Along a line.
    Line(Vec<Point>),
    /// An area; the ring is not closed.
    Polygon(Vec<Point>),
}

/// What was measured, and the limit it was held against.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measure {
    /// The measured value.
    pub value: f64,
    /// The threshold of the rule.
    pub limit: f64,
    /// `m`, `m2`, `deg`, `%`, `1`.
    pub unit: &'static str,
}

/// Another primitive that has a part in a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Related {
    /// The primitive.
    pub subject: Subject,
    /// Its part in the finding, in a word or two: `yield`, `stop line`, `intersection area`.
    pub part: &'static str,
}

/// A finding that somebody lets be, for a reason: its fix was rejected in a review.
#[derive(Clone, Debug, PartialEq)]
pub struct Accepted {
    /// What was found.
    pub found: Diagnostic,
    /// In the words of whoever rejected the fix.
    pub reason: String,
}

/// One machine-made change to the map. Each variant's sentence names its fields.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "edit")]
#[expect(missing_docs, reason = "the names of fields say it")]
pub enum Edit {
    /// Set a tag, whatever it was.
    SetTag { on: Subject, key: Text, value: Text },
    /// Remove a tag.
    RemoveTag { on: Subject, key: Text },
    /// Add a member to a relation.
    AddMember { on: Subject, role: Text, member: Subject },
    /// Remove every member with this role and target from a relation.
    RemoveMember { on: Subject, role: Text, member: Subject },
    /// Give a member another role.
    SetRole { on: Subject, member: Subject, from: Text, to: Text },
    /// Replace point `from` by point `to` wherever it is used.
    MergePoints { from: i64, to: i64 },
    /// Insert a point into a way before the given position.
    InsertVertex { way: Subject, position: usize, point: i64 },
    /// Remove the vertex at the given position of a way.
    RemoveVertex { way: Subject, position: usize },
    /// Let a way run over these points and no others.
    SetVertices { way: Subject, points: Vec<i64> },
    /// Turn a way around: its first vertex becomes its last.
    ReverseWay { way: Subject },
    /// Use another way as a bound of a lanelet.
    ReplaceWay { lanelet: i64, from: i64, to: i64 },
    /// Put a point at latitude and longitude.
    SetPlace { point: i64, place: LonLat },
    /// Put a point on the straight from one point to another, at this share (0..=1) of the way.
    PlaceBetween { point: i64, from: i64, to: i64, share: f64 },
    /// Of elements that have one id, remove the nth (from 0, in file order) and leave all references as they are.
    RemoveRepeat { on: Subject, nth: usize },
    /// Give the nth element of this id (from 0, in file order) one that is free, and say so in these that refer to it; in
    /// all where none are named.
    Renumber { on: Subject, nth: usize, referrers: Option<Vec<Subject>> },
    /// Remove an element that nothing needs any more, with every reference to it.
    Remove { subject: Subject },
    /// Create a relation with a fresh id and let the lanelets refer to it.
    CreateRegulatoryElement { subtype: Text, members: Vec<(Text, Subject)>, referrers: Vec<i64> },
    /// Draw a stop line with a fresh id over these points, and let an element name it as its `ref_line`.
    CreateStopLine { points: Vec<i64>, element: Subject },
    /// Draw a stop line with a fresh id over these points, and a `road_marking` element for it to which the lanelets refer.
    CreateMarking { points: Vec<i64>, lanelets: Vec<i64> },
    /// Draw an `intersection_area` with a fresh id over these points, and new ones between them, and name it in the tags of these lanelets.
    CreateArea { points: Vec<i64>, corners: Vec<AreaCorner>, lanelets: Vec<i64> },
    /// Create the lanelet of the other direction with a fresh id: between the same bounds, one-way, with the same tags but for
    /// where it turns, and of the regulatory elements with these.
    CreateOpposite { lanelet: i64, elements: Vec<i64> },
    /// Write the `format_version` of `MetaInfo` into each file.
    SetFormatVersion { version: Text },
    /// Cut ways and the lanelets between them at the same places of a road.
    Divide(Division),
}

/// A new vertex of an area, on the straight line between two points.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AreaCorner {
    /// The place among the other points of the area before which it comes.
    pub before: usize,
    /// The points beside it.
    pub ends: [i64; 2],
    /// How far it is from the first to the second, 0 to 1.
    pub share: f64,
}

/// How to mend a finding by machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fix {
    /// What it does, in one line.
    pub title: String,
    /// Whether it can be applied without a look.
    pub safe: bool,
    /// The edits, in order.
    pub edits: Vec<Edit>,
}

/// One place where a map breaks a requirement, as the rule says it. Knows neither number nor severity.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The fault's slug inside its rule, such as `lane-node-missing`.
    pub fault: &'static str,
    /// The primitive to look at first.
    pub subject: Subject,
    /// The others, each with its part.
    pub related: Vec<Related>,
    /// What to draw.
    pub place: Place,
    /// Value and threshold, where the rule measures.
    pub measure: Option<Measure>,
    /// What is wrong, in one line that stands alone.
    pub message: String,
    /// The edits that mend it, where a program can.
    pub fix: Option<Fix>,
    /// How to mend it in words, where that of the fault does not fit.
    pub help: Option<&'static str>,
    /// A severity other than the fault's own, where the rule grades by size.
    pub severity: Option<Severity>,
    /// Where the subject stands in the file, needed only where the map does not hold it.
    pub span: Option<SourceSpan>,
    /// Code under which the existing validator reports it, in the profile that imitates it.
    pub peer: Option<Text>,
}

impl Finding {
    /// A finding with the parts that every one has; the rest is added by the methods below.
    pub fn new(fault: &'static str, subject: Subject, message: impl Into<String>) -> Self {
        Self {
            fault,
            subject,
            related: Vec::new(),
            place: Place::Unknown,
            measure: None,
            message: message.into(),
            fix: None,
            help: None,
            severity: None,
            span: None,
            peer: None,
        }
    }

    /// Adds a primitive that has a part in it.
    #[must_use]
    pub fn with(mut self, subject: Subject, part: &'static str) -> Self {
        self.related.push(Related { subject, part });
        self
    }

    /// Says where to look.
    #[must_use]
    pub fn at(mut self, place: Place) -> Self {
        self.place = place;
        self
    }

    /// Says what was measured and the limit.
    #[must_use]
    pub fn measured(mut self, value: f64, limit: f64, unit: &'static str) -> Self {
        self.measure = Some(Measure { value, limit, unit });
        self
    }

    /// Says how a program mends it.
    #[must_use]
    pub fn fixed_by(mut self, title: impl Into<String>, safe: bool, edits: Vec<Edit>) -> Self {
        self.fix = Some(Fix { title: title.into(), safe, edits });
        self
    }

    /// Says how to mend it in words, where that of the fault does not fit.
    #[must_use]
    pub fn advised(mut self, help: &'static str) -> Self {
        self.help = Some(help);
        self
    }

    /// Says where the subject stands in the file, for a subject that the map does not hold.
    #[must_use]
    pub fn standing_at(mut self, span: Option<SourceSpan>) -> Self {
        self.span = span;
        self
    }

    /// Grades it other than the fault's own severity.
    #[must_use]
    pub fn graded(mut self, severity: Severity) -> Self {
        self.severity = Some(severity);
        self
    }
}

/// A finding with everything a report shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// Rule and slug: `vm-03-08/lane-node-missing`, `load/missing-ref`.
    pub code: String,
    /// After the user's configuration.
    pub severity: Severity,
    /// What the rule said.
    pub finding: Finding,
    /// How to mend it, in words, from the rule's document.
    pub help: Option<String>,
    /// Where the subject stands in the file.
    pub span: Option<SourceSpan>,
    /// Middle of the place, or of the subject's geometry.
    pub lonlat: Option<LonLat>,
    /// The same in local metres.
    pub local: Option<Point>,
}

impl Diagnostic {
    /// A diagnostic without help and without a place.
    pub fn new(code: impl Into<String>, severity: Severity, finding: Finding) -> Self {
        Self { code: code.into(), severity, finding, help: None, span: None, lonlat: None, local: None }
    }
}
