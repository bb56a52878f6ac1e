//! A document of `rules/`, parsed: what is required, how bad each fault is, what a user may tune, and why.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::diagnostic::Severity;

/// How far a program can judge a requirement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Check {
    /// All of it.
    Automatic,
    /// A part of it; the document says which and why.
    Partial,
    /// Nothing of it: needs eyes.
    Manual,
}

impl std::fmt::Display for Check {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Self::Automatic => "automatic",
            Self::Partial => "partial",
            Self::Manual => "manual",
        })
    }
}

/// One way to break a requirement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// How bad it is, unless the rule grades a single finding by its size.
    pub severity: Severity,
    /// What is wrong, in one sentence.
    pub meaning: String,
    /// How a map maker mends it, in one sentence; shown as help under every finding.
    pub help: String,
    /// Whether `fix` mends it: `safe`, `needs review`, or `never:` and why. Every fault of a map has it.
    #[serde(default, skip_serializing)]
    pub fix: Option<String>,
    /// What a fix that needs review takes for granted, in one sentence.
    #[serde(default, skip_serializing)]
    pub assumes: Option<String>,
    /// Codes under which the validator of TIER IV reports the same; empty if it does not.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub peer: Vec<String>,
}

/// One number, or list, that a user may tune.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameter {
    /// Its value unless the user says otherwise.
    pub default: toml::Value,
    /// `m`, `m2`, `deg`, `1`.
    pub unit: String,
    /// What it is and why it is as large as it is.
    pub meaning: String,
}

/// The block that opens a document.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Block {
    id: String,
    title: String,
    subtitle: Option<String>,
    category: String,
    check: Check,
    why: Option<String>,
    source: String,
    edition: String,
    #[serde(default)]
    parameters: BTreeMap<String, Parameter>,
    #[serde(default)]
    faults: toml::Table,
}

/// A requirement as its document says it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Requirement {
    /// `vm-03-08`, or the name of a family of checks that no standard asks for: `load`.
    pub id: String,
    /// As the standard's own list has it; of a family of ours, what it is about.
    pub title: String,
    /// What it asks for in plain words, where the title does not tell.
    pub subtitle: Option<String>,
    /// The chapter of the standard; `map health: …` for what no standard asks for.
    pub category: String,
    /// How far a program can judge it.
    pub check: Check,
    /// Why not all of it; `None` where `check` is automatic.
    pub why: Option<String>,
    /// Where the requirement is.
    pub source: String,
    /// Which edition of the source was read.
    pub edition: String,
    /// By name.
    pub parameters: BTreeMap<String, Parameter>,
    /// Slug and fault, in the document's order.
    pub faults: Vec<(String, Fault)>,
    /// Everything behind the block, Markdown.
    pub prose: String,
    /// The pictures that the prose shows: name without ending, and SVG.
    #[serde(skip)]
    pub pictures: Vec<(String, &'static str)>,
}

/// Why a document could not be parsed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DocumentError {
    /// It does not open with a block.
    #[error("rules/{file}.md: expected a ```toml block first, closed by ```")]
    NoBlock {
        /// Its name without ending.
        file: String,
    },
    /// The block is not what it should be.
    #[error("rules/{file}.md: {message}")]
    Block {
        /// Its name without ending.
        file: String,
        /// What the parser says.
        message: String,
    },
    /// A chapter that every document has is missing.
    #[error("rules/{file}.md: no chapter `## {chapter}`")]
    NoChapter {
        /// Its name without ending.
        file: String,
        /// The heading.
        chapter: &'static str,
    },
}

/// The chapters that every document has, in their order.
pub const CHAPTERS: [&str; 4] = ["Required", "Why", "How to mend", "Good and bad"];

impl Requirement {
    /// Parses the text of `rules/{file}.md`. The id must be the file's name; every chapter of [`CHAPTERS`] must be there.
    ///
    /// # Errors
    ///
    /// If the document has another id, lacks a chapter, or its `toml` block cannot be read.
    pub fn parse(file: &str, text: &str) -> Result<Self, DocumentError> {
        let bad = |message: String| DocumentError::Block { file: file.to_owned(), message };
        let (block, prose) = text
            .strip_prefix("```toml\n")
            .and_then(|rest| rest.split_once("\n```\n"))
            .ok_or_else(|| DocumentError::NoBlock { file: file.to_owned() })?;
        let block: Block = toml::from_str(block).map_err(|error| bad(error.to_string()))?;
        if block.id != file {
            return Err(bad(format!("id is `{}`; it must be the name of the file", block.id)));
        }
        if (block.check == Check::Automatic) != block.why.is_none() {
            return Err(bad("`why` says what a program cannot judge: needed unless check = \"automatic\"".to_owned()));
        }
        for chapter in CHAPTERS {
            if !prose.contains(&format!("\n## {chapter}\n")) {
                return Err(DocumentError::NoChapter { file: file.to_owned(), chapter });
            }
        }
        // A table keeps the document's order; a map of structs would not.
        let faults = block
            .faults
            .into_iter()
            .map(|(slug, value)| match value.try_into() {
                Ok(fault) => Ok((slug, fault)),
                Err(error) => Err(bad(format!("[faults.{slug}]: {error}"))),
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            id: block.id,
            title: block.title,
            subtitle: block.subtitle,
            category: block.category,
            check: block.check,
            why: block.why,
            source: block.source,
            edition: block.edition,
            parameters: block.parameters,
            faults,
            prose: prose.trim().to_owned(),
            pictures: Vec::new(),
        })
    }

    /// Whether it is one of Autoware's requirements; else it is a family of checks that no standard asks for.
    pub fn is_of_the_standard(&self) -> bool {
        self.id.starts_with("vm-")
    }

    /// Title and subtitle in one line.
    pub fn full_title(&self) -> String {
        self.subtitle.as_ref().map_or_else(|| self.title.clone(), |subtitle| format!("{}: {subtitle}", self.title))
    }

    /// The fault of this slug.
    pub fn fault(&self, slug: &str) -> Option<&Fault> {
        self.faults.iter().find(|(name, _)| name == slug).map(|(_, fault)| fault)
    }

    /// The defaults of all parameters, as a rule's `Params` are read from.
    pub fn defaults(&self) -> toml::Table {
        self.parameters.iter().map(|(name, parameter)| (name.clone(), parameter.default.clone())).collect()
    }

    /// The text of one chapter of the prose, without its heading.
    pub fn chapter(&self, name: &str) -> Option<&str> {
        let heading = format!("## {name}\n");
        let start = self.prose.find(&heading)? + heading.len();
        let rest = &self.prose[start..];
        let end = rest.find("\n## ").unwrap_or(rest.len());
        Some(rest[..end].trim())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOCUMENT: &str = r#"```toml
id = "x-1"
title = "A title"
category = "tests"
check = "automatic"
source = "nowhere"
edition = "1"

[parameters.reach]
default = 0.5
unit = "m"
meaning = "How far."

[faults.zebra]
severity = "error"
meaning = "Bad."
help = "Mend it."

[faults.apple]
severity = "info"
meaning = "Odd."
help = "Look."
peer = ["X.Y-001"]
```

# x-1

## Required
This.

## Why
That.

## How to mend
So.

## Good and bad
Look.
"#;

    #[test]
    fn a_document_is_read_in_its_order() {
        let requirement = Requirement::parse("x-1", DOCUMENT).unwrap();
        let slugs: Vec<&str> = requirement.faults.iter().map(|(slug, _)| slug.as_str()).collect();
        assert_eq!(slugs, ["zebra", "apple"]);
        assert_eq!(requirement.fault("apple").unwrap().peer, ["X.Y-001"]);
        assert_eq!(requirement.defaults()["reach"].as_float(), Some(0.5));
        assert_eq!(requirement.chapter("Why"), Some("That."));
        assert_eq!(requirement.chapter("Good and bad"), Some("Look."));
    }

    #[test]
    fn what_is_missing_is_said() {
        let without = |what: &str| Requirement::parse("x-1", &DOCUMENT.replace(what, "")).unwrap_err().to_string();
        assert!(without("```toml\n").contains("expected a ```toml block"));
        assert!(without("## Why\n").contains("no chapter `## Why`"));
        assert!(without("severity = \"error\"\n").contains("[faults.zebra]"));
        assert!(Requirement::parse("y-2", DOCUMENT).unwrap_err().to_string().contains("name of the file"));
        let partial = DOCUMENT.replace("\"automatic\"", "\"partial\"");
        assert!(Requirement::parse("x-1", &partial).unwrap_err().to_string().contains("`why`"));
    }
}
