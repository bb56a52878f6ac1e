//! The XML of an OpenDRIVE file as a tree of elements, with the line on which each begins.

use std::borrow::Cow;

use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use crate::text::Text;

use super::error::XodrError;

/// The most elements of one file: a survey of a large town has some millions.
const MOST_ELEMENTS: usize = 50_000_000;
/// The deepest nesting: the standard needs 9.
const MOST_DEPTH: usize = 200;

/// The whole file.
#[derive(Debug)]
pub struct Document {
    elements: Vec<Element>,
    line_starts: Vec<usize>,
}

/// The place of an element in a document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ix(usize);

#[derive(Debug)]
struct Element {
    name: Text,
    attributes: Vec<(Text, Text)>,
    text: Text,
    offset: usize,
    children: Vec<Ix>,
}

impl Document {
    /// Reads a text. Namespaces are left out of names; what stands before the root is passed over.
    ///
    /// # Errors
    ///
    /// Where it is not well-formed, is cut off, or has another root than `OpenDRIVE`.
    pub fn read(text: &str) -> Result<Self, XodrError> {
        // Some tools write a comment before the declaration, which XML does not allow.
        let begin = text.find("<OpenDRIVE").unwrap_or(0);
        let mut reader = Reader::from_str(text.get(begin..).unwrap_or(text));
        let mut document = Self { elements: Vec::new(), line_starts: line_starts(text) };
        let mut open: Vec<Ix> = Vec::new();
        loop {
            let start = begin + reader.buffer_position() as usize;
            let event = reader.read_event().map_err(|error| XodrError::Broken {
                offset: begin + reader.error_position() as usize,
                message: format!("not well-formed XML: {error}"),
            })?;
            match event {
                Event::Start(tag) => {
                    let ix = document.push(&tag, start, &open)?;
                    open.push(ix);
                }
                Event::Empty(tag) => _ = document.push(&tag, start, &open)?,
                Event::End(_) => {
                    open.pop();
                    if open.is_empty() {
                        return Ok(document);
                    }
                }
                Event::Text(content) => document.add_text(&open, &content),
                Event::CData(content) => document.add_text(&open, &content),
                Event::Eof if document.elements.is_empty() => return Err(XodrError::NoRoot),
                // An empty root, or one that is never closed.
                Event::Eof if open.is_empty() => return Ok(document),
                Event::Eof => return Err(XodrError::CutOff { offset: text.len() }),
                _ => {}
            }
        }
    }

    fn push(&mut self, tag: &BytesStart, offset: usize, open: &[Ix]) -> Result<Ix, XodrError> {
        let name = Text::from(local(tag.name().as_ref()));
        if open.is_empty() && name != "OpenDRIVE" {
            return Err(XodrError::NoRoot);
        }
        if self.elements.len() >= MOST_ELEMENTS || open.len() >= MOST_DEPTH {
            return Err(XodrError::TooMuch { offset });
        }
        let mut attributes = Vec::new();
        for attribute in tag.attributes().with_checks(false) {
            let attribute = attribute
                .map_err(|error| XodrError::Broken { offset, message: format!("not well-formed XML: {error}") })?;
            let value = attribute.normalized_value(XmlVersion::Implicit1_0);
            let value = value.unwrap_or_else(|_| Cow::Borrowed(&attribute.value));
            attributes.push((Text::from(local(attribute.key.as_ref())), Text::from(value.trim())));
        }
        let ix = Ix(self.elements.len());
        self.elements.push(Element { name, attributes, text: Text::default(), offset, children: Vec::new() });
        if let Some(parent) = open.last().and_then(|parent| self.elements.get_mut(parent.0)) {
            parent.children.push(ix);
        }
        Ok(ix)
    }

    fn add_text(&mut self, open: &[Ix], content: &str) {
        let words = content.trim();
        if let Some(element) = open.last().filter(|_| !words.is_empty()).and_then(|ix| self.elements.get_mut(ix.0)) {
            element.text.push_str(words);
        }
    }

    /// The element `OpenDRIVE`.
    pub fn root(&self) -> Ix {
        Ix(0)
    }

    /// Its name without namespace.
    pub fn name(&self, ix: Ix) -> &str {
        self.elements.get(ix.0).map_or("", |element| element.name.as_str())
    }

    /// The text inside it, without white space around.
    pub fn text(&self, ix: Ix) -> &str {
        self.elements.get(ix.0).map_or("", |element| element.text.as_str())
    }

    /// The value of an attribute, without white space around; `None` where there is none, or an empty one.
    pub fn get(&self, ix: Ix, key: &str) -> Option<&str> {
        let attributes = &self.elements.get(ix.0)?.attributes;
        attributes
            .iter()
            .find(|(name, _)| name == key)
            .map(|(_, value)| value.as_str())
            .filter(|value| !value.is_empty())
    }

    /// Its children, in order.
    pub fn all_children(&self, ix: Ix) -> impl Iterator<Item = Ix> + '_ {
        self.elements.get(ix.0).into_iter().flat_map(|element| element.children.iter().copied())
    }

    /// Its children of a name, in order.
    pub fn children<'a>(&'a self, ix: Ix, name: &'a str) -> impl Iterator<Item = Ix> + 'a {
        self.all_children(ix).filter(move |child| self.name(*child) == name)
    }

    /// Its first child of a name.
    pub fn child(&self, ix: Ix, name: &str) -> Option<Ix> {
        self.children(ix, name).next()
    }

    /// The elements reached by these names, one level each, in order.
    pub fn descend(&self, ix: Ix, names: &[&str]) -> Vec<Ix> {
        let mut found = vec![ix];
        for name in names {
            found = found.into_iter().flat_map(|ix| self.children(ix, name).collect::<Vec<_>>()).collect();
        }
        found
    }

    /// The line on which it begins, from 1.
    pub fn line(&self, ix: Ix) -> usize {
        let offset = self.elements.get(ix.0).map_or(0, |element| element.offset);
        self.line_starts.partition_point(|start| *start <= offset)
    }
}

/// A name without its namespace.
fn local(name: &str) -> &str {
    name.rsplit(':').next().unwrap_or(name)
}

fn line_starts(text: &str) -> Vec<usize> {
    std::iter::once(0).chain(text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i + 1)).collect()
}
