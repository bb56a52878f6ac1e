//! One thing that is different about an element.

use std::fmt;

use serde::Serialize;

use crate::diagnostic::Subject;
use crate::report::visible;

/// Whether the new map has something more or less.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Sign {
    /// The new map has it, the old has not.
    Added,
    /// The other way round.
    Removed,
}

/// One difference. Lengths are metres.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "fact")]
#[expect(missing_docs, reason = "each variant's sentence names its fields")]
pub enum Fact {
    /// What an added or removed element is: its type or subtype, and its length where it has one.
    Is { what: String, length: Option<f64> },
    /// It lies elsewhere; the largest distance between old and new.
    Moved { by: f64 },
    /// It goes on farther at its ends than before, or less far where `by` is negative.
    Longer { by: f64 },
    /// It lies higher, or lower.
    Raised { by: f64 },
    /// A tag has another value.
    Tag { key: String, old: Option<String>, new: Option<String> },
    /// Its line has points that it had not, or lacks some; neither where only their order changed.
    Points { added: usize, removed: usize },
    /// A lanelet has another line as its bound.
    Bound { side: &'static str, old: i64, new: i64 },
    /// A lanelet uses its bound in the other direction.
    TurnedAround { side: &'static str },
    /// A lanelet refers to a regulatory element.
    Element { sign: Sign, id: i64 },
    /// One can drive from this lanelet into that one.
    LeadsTo { sign: Sign, id: i64 },
    /// The lanelet has right of way over that one (`yield`).
    RightOfWay { sign: Sign, over: i64 },
    /// A regulatory element has a member.
    Member { sign: Sign, role: String, member: Subject },
}

impl Fact {
    /// How far something moved.
    pub fn metres(&self) -> Option<f64> {
        if let Self::Moved { by } = self { Some(*by) } else { None }
    }
}

impl fmt::Display for Fact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Is { what, length: None } => write!(f, "{}", visible(what)),
            Self::Is { what, length: Some(length) } => write!(f, "{}, {length:.1} m", visible(what)),
            Self::Moved { by } => write!(f, "moved by up to {by:.3} m"),
            Self::Longer { by } if *by < 0.0 => write!(f, "shorter by {:.3} m", -by),
            Self::Longer { by } => write!(f, "longer by {by:.3} m"),
            Self::Raised { by } if *by < 0.0 => write!(f, "lower by up to {:.3} m", -by),
            Self::Raised { by } => write!(f, "higher by up to {by:.3} m"),
            Self::Tag { key, old, new } => {
                let value =
                    |value: &Option<String>| value.as_deref().map_or("nothing".into(), |v| format!("`{}`", visible(v)));
                write!(f, "{} from {} to {}", visible(key), value(old), value(new))
            }
            Self::Points { added: 0, removed: 0 } => f.write_str("its points in another order"),
            Self::Points { added, removed } => write!(f, "{added} points more, {removed} fewer"),
            Self::Bound { side, old, new } => write!(f, "{side} bound is linestring {new} instead of {old}"),
            Self::TurnedAround { side } => write!(f, "uses its {side} bound turned around"),
            Self::Element { sign: Sign::Added, id } => write!(f, "refers to regulatory element {id}"),
            Self::Element { sign: Sign::Removed, id } => write!(f, "no longer refers to regulatory element {id}"),
            Self::LeadsTo { sign: Sign::Added, id } => write!(f, "leads to lanelet {id}"),
            Self::LeadsTo { sign: Sign::Removed, id } => write!(f, "no longer leads to lanelet {id}"),
            Self::RightOfWay { sign: Sign::Added, over } => write!(f, "has right of way over lanelet {over}"),
            Self::RightOfWay { sign: Sign::Removed, over } => {
                write!(f, "no longer has right of way over lanelet {over}")
            }
            Self::Member { sign: Sign::Added, role, member } => write!(f, "{member} as {}", visible(role)),
            Self::Member { sign: Sign::Removed, role, member } => write!(f, "no longer {member} as {}", visible(role)),
        }
    }
}
