//! The table of words, as `words.toml` has it.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::lanelet::number::number;
use crate::text::misspelt;

/// The kinds of primitive that have tags.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum On {
    /// A node.
    Point,
    /// A way without `area=yes`.
    LineString,
    /// A way with `area=yes`.
    Polygon,
    /// A relation of `type=lanelet`.
    Lanelet,
    /// A relation of `type=regulatory_element`.
    Element,
    /// A relation of `type=multipolygon`.
    Area,
}

impl On {
    /// What such primitives are called.
    pub const fn plural(self) -> &'static str {
        match self {
            Self::Point => "nodes",
            Self::LineString => "ways",
            Self::Polygon => "ways with area=yes",
            Self::Lanelet => "lanelets",
            Self::Element => "regulatory elements",
            Self::Area => "areas",
        }
    }
}

/// What a value must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// `yes` or `no`; `true` and `false` are read alike.
    YesNo,
    /// `yes` or `no`, letter by letter: whoever reads it compares words.
    YesNoAlone,
    /// A number.
    Number,
    /// An integer.
    Id,
    /// Integers with commas between them; brackets may stand around them.
    Ids,
    /// A speed: what Lanelet2 makes of it is another rule's business.
    Speed,
}

impl Form {
    /// What it demands, to stand behind "is no" and "must be a".
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::YesNo | Self::YesNoAlone => "yes or no",
            Self::Number => "number",
            Self::Id => "id",
            Self::Ids => "list of ids",
            Self::Speed => "speed",
        }
    }

    /// What is wrong with a value, and what was meant where that is plain.
    pub(super) fn fault(self, value: &str) -> Option<Option<String>> {
        let is_id = |text: &str| text.trim().parse::<i64>().is_ok();
        match self {
            Self::YesNoAlone => match value {
                "yes" | "no" => None,
                "true" => Some(Some("yes".to_owned())),
                "false" => Some(Some("no".to_owned())),
                _ => Self::YesNo.fault(value),
            },
            Self::YesNo => match value {
                "yes" | "no" | "true" | "false" => None,
                "1" => Some(Some("yes".to_owned())),
                "0" => Some(Some("no".to_owned())),
                _ => Some(misspelt(value, ["yes", "no", "true", "false"]).map(|word| match word {
                    "true" | "yes" => "yes".to_owned(),
                    _ => "no".to_owned(),
                })),
            },
            Self::Number if number(value).is_some() => None,
            Self::Number => Some(Some(value.replace(',', ".")).filter(|point| number(point).is_some())),
            Self::Id => (!is_id(value)).then_some(None),
            Self::Ids => (!value.trim_matches(['[', ']']).split(',').all(is_id)).then_some(None),
            Self::Speed => None,
        }
    }
}

/// What is wrong with a tag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Slip {
    /// Nothing reads the key, and it is nearly this one.
    Key(&'static str),
    /// Nothing reads the value, and it is nearly this one.
    Value(&'static str),
    /// The value is not of the form that the key needs; what was meant, where that is plain.
    Form(Form, Option<String>),
    /// The value is none of the words that the key has.
    Word(&'static [String], Option<&'static str>),
    /// The key is called otherwise today.
    RenamedKey(&'static str),
    /// The value is called otherwise today.
    RenamedValue(&'static str),
    /// The key is read on these primitives, and this is none of them.
    Elsewhere(&'static [On]),
}

/// Where words stand.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Name and edition.
    pub title: String,
    /// Where to read it.
    pub url: String,
}

/// A key, or several that differ in a participant or a lamp.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Key {
    /// With `…` for a participant, `LAMP` for a lamp, `ID` for any number.
    pub name: String,
    /// The primitives that have it.
    pub on: Vec<On>,
    /// Whether nobody else has a key of this name, so that on other primitives it is a mistake and no tag of somebody's own.
    #[serde(default)]
    pub own: bool,
    /// What its value must be.
    pub form: Option<Form>,
    /// Words that somebody reads.
    #[serde(default)]
    pub values: Vec<String>,
    /// Whether these are all.
    #[serde(default)]
    pub closed: bool,
    /// What it says.
    pub meaning: String,
    /// Where it stands.
    pub source: String,
}

/// Words with their source.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct List {
    /// Where they stand.
    pub source: String,
    /// The words.
    pub words: Vec<String>,
}

/// Values of `type`, and of `subtype` beside them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Types {
    /// The primitives that have them.
    pub on: Vec<On>,
    /// Where they stand.
    pub source: String,
    /// Values of `type`.
    pub names: Vec<String>,
    /// Values of `subtype`; where they are missing, those of paint.
    pub subtypes: Option<Vec<String>>,
}

/// Roles of members.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Roles {
    /// `lanelet`, `multipolygon`, or the subtype of a regulatory element.
    pub of: String,
    /// Where they stand.
    pub source: String,
    /// The roles.
    pub words: Vec<String>,
}

/// Parts of words in groups, of each of which the parts mean the same.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Alike {
    /// The groups.
    pub words: Vec<Vec<String>>,
}

/// Parts that say nothing.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Idle {
    /// The parts.
    pub words: Vec<String>,
}

/// Other words for a known one.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Meant {
    /// The known one.
    pub word: String,
    /// What people write in its place.
    pub said: Vec<String>,
}

/// A word that is called otherwise today.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Renamed {
    /// The primitives that have it.
    pub on: Vec<On>,
    /// The key: the old word, unless that is a value.
    pub key: String,
    /// The old word, where it is a value.
    pub value: Option<String>,
    /// The new one.
    pub now: String,
    /// Where it stands.
    pub source: String,
}

/// Keys of others.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Foreign {
    /// Nothing is said of them.
    pub keys: Vec<String>,
}

/// The whole table.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Words {
    /// By the name that the words give.
    pub sources: BTreeMap<String, Source>,
    /// Whom `participant:…` names.
    pub participants: List,
    /// What `signal_color_relation:…` names.
    pub lamps: List,
    /// Keys.
    pub key: Vec<Key>,
    /// Subtypes of painted lines.
    pub paint: List,
    /// Types and subtypes.
    #[serde(rename = "type")]
    pub types: Vec<Types>,
    /// Roles.
    pub roles: Vec<Roles>,
    /// Parts of words that mean the same.
    pub alike: Alike,
    /// Parts that say nothing of a painted line's subtype.
    pub idle: Idle,
    /// Other words for known ones.
    pub meant: Vec<Meant>,
    /// Words that are called otherwise today.
    pub renamed: Vec<Renamed>,
    /// Keys of others.
    pub foreign: Foreign,
}

impl Words {
    /// Reads the table that is compiled in.
    pub(super) fn parse() -> Result<Self, toml::de::Error> {
        toml::from_str(include_str!("words.toml"))
    }

    /// The sources that words name.
    #[cfg(test)]
    pub(super) fn named_sources(&self) -> impl Iterator<Item = &str> {
        let keys = self.key.iter().map(|key| &key.source);
        let types = self.types.iter().map(|list| &list.source);
        let roles = self.roles.iter().map(|roles| &roles.source);
        let lists = [&self.participants, &self.lamps, &self.paint].into_iter().map(|list| &list.source);
        let renamed = self.renamed.iter().map(|one| &one.source);
        keys.chain(types).chain(roles).chain(renamed).chain(lists).map(String::as_str)
    }

    /// The names that a key of the table stands for; none for that of numbers.
    pub fn written_out(&self, key: &Key) -> Vec<String> {
        if key.name == "ID" {
            return Vec::new();
        }
        let mut names = vec![key.name.clone()];
        for (sign, list) in [("…", &self.participants), ("LAMP", &self.lamps)] {
            while names.iter().any(|name| name.contains(sign)) {
                let each =
                    |name: &String| list.words.iter().map(|word| name.replacen(sign, word, 1)).collect::<Vec<_>>();
                names = names.iter().flat_map(each).collect();
            }
        }
        names
    }

    /// The types of a kind of primitive.
    pub fn lists(&self, on: On) -> impl Iterator<Item = &Types> {
        self.types.iter().filter(move |list| list.on.contains(&on))
    }
}
