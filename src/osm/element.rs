//! One element of a file as text that can be edited: what is not edited keeps every byte.

use std::collections::BTreeMap;
use std::ops::Range;

use quick_xml::XmlVersion;
use quick_xml::escape::escape;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::{ElementKind, attribute, fixed};

/// Decimals of latitude and longitude: a micrometre.
const DECIMALS: usize = 11;
/// The indentation of children relative to their element, where no child shows it.
const INDENT: &str = "  ";

/// A child of an element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Child {
    /// `<tag k= v=/>`, by its key.
    Tag(String),
    /// `<nd ref=/>`.
    Vertex(i64),
    /// `<member type= ref= role=/>`.
    Member(ElementKind, i64, String),
    /// A comment, or what we do not know.
    Other,
}

#[derive(Clone, Debug)]
struct Item {
    /// The blanks and line ends before this item.
    lead: String,
    text: String,
    child: Child,
    /// For a vertex that was read: its number among the vertices.
    vertex: Option<usize>,
    /// Where it was read (bytes from the start of the element).
    read: Option<Range<usize>>,
}

/// An element that is being edited.
#[derive(Clone, Debug)]
pub struct Element {
    /// The start tag without its `>` or `/>`.
    head: String,
    items: Vec<Item>,
    /// From behind the last child to the end, where there is an end tag.
    tail: Option<String>,
    name: String,
    /// Line end and blanks before the element.
    margin: String,
}

impl Element {
    /// Reads an element from its text; `margin` is what is before it, from the end of the line above. `None` if the text
    /// is no element.
    pub fn parse(text: &str, margin: &str) -> Option<Self> {
        let mut reader = Reader::from_str(text);
        let mut element: Option<Self> = None;
        let (mut depth, mut item_start, mut lead_start, mut vertices) = (0, 0, 0, 0);
        let mut child = Child::Other;
        loop {
            let start = usize::try_from(reader.buffer_position()).ok()?;
            let event = reader.read_event().ok()?;
            let end = usize::try_from(reader.buffer_position()).ok()?;
            let (opens, closes) = match &event {
                Event::Start(tag) | Event::Empty(tag) => {
                    let empty = matches!(event, Event::Empty(_));
                    if depth == 0 {
                        let cut = if empty { "/>" } else { ">" };
                        let head = text.get(start..end)?.strip_suffix(cut)?.trim_end().to_owned();
                        let name = tag.name().as_ref().to_owned();
                        element = Some(Self { head, items: Vec::new(), tail: None, name, margin: margin.to_owned() });
                        lead_start = end;
                        if empty {
                            return element;
                        }
                    } else if depth == 1 {
                        (item_start, child) = (start, read_child(tag));
                    }
                    (true, empty)
                }
                Event::End(_) if depth == 1 => {
                    let mut element = element?;
                    element.tail = Some(text.get(lead_start..end)?.to_owned());
                    return Some(element);
                }
                Event::End(_) => (false, true),
                Event::Comment(_) | Event::CData(_) | Event::PI(_) if depth == 1 => {
                    (item_start, child) = (start, Child::Other);
                    (true, true)
                }
                Event::Eof => return None,
                _ => (false, false),
            };
            depth += usize::from(opens);
            if closes {
                depth = usize::checked_sub(depth, 1)?;
                if depth == 1 {
                    let lead = text.get(lead_start..item_start)?.to_owned();
                    let vertex = matches!(child, Child::Vertex(_)).then_some(vertices);
                    vertices += usize::from(vertex.is_some());
                    let text = text.get(item_start..end)?.to_owned();
                    let child = std::mem::replace(&mut child, Child::Other);
                    element.as_mut()?.items.push(Item { lead, text, child, vertex, read: Some(item_start..end) });
                    lead_start = end;
                }
            }
        }
    }

    /// A new element without children.
    pub fn new(name: &str, id: i64, margin: &str) -> Self {
        let head = format!("<{name} id=\"{id}\" version=\"1\"");
        Self { head, items: Vec::new(), tail: None, name: name.to_owned(), margin: margin.to_owned() }
    }

    /// A new element without id and children, on a line of its own.
    pub fn without_id(name: &str, margin: &str) -> Self {
        let head = format!("{margin}<{name}");
        Self { head, items: Vec::new(), tail: None, name: name.to_owned(), margin: margin.to_owned() }
    }

    /// Adds a vertex to a new way.
    pub fn add_vertex(&mut self, point: i64) {
        let child = Child::Vertex(point);
        self.insert(self.items.len(), child.clone(), child_text(&child));
    }

    /// The text, edited.
    pub fn render(&self) -> String {
        let mut text = self.head.clone();
        if self.items.is_empty() {
            return text + "/>";
        }
        text.push('>');
        for item in &self.items {
            text += &item.lead;
            text += &item.text;
        }
        match &self.tail {
            Some(tail) => text += tail,
            None => text += &format!("{}</{}>", self.margin, self.name),
        }
        text
    }

    /// The changes of children that make the text from which it was read into its own, in order: ranges (bytes), and what comes there.
    /// `None` where it was read without an end tag.
    pub fn changes_of(&self, text: &str) -> Option<Vec<(Range<usize>, String)>> {
        let mut end = text.len() - self.tail.as_ref()?.len();
        let mut gone: BTreeMap<usize, Range<usize>> = BTreeMap::new();
        for Item { lead, read, .. } in Self::parse(text, "")?.items {
            let read = read?;
            end = end.min(read.start - lead.len());
            gone.insert(read.start, read.start - lead.len()..read.end);
        }
        let mut changes: Vec<(Range<usize>, String)> = Vec::new();
        for (item, next) in self.items.iter().zip(self.items.iter().skip(1).map(Some).chain([None])) {
            let Item { lead, text: new, .. } = item;
            match (&item.read, next.filter(|next| next.vertex.is_some()).and_then(|next| next.read.as_ref())) {
                (Some(read), _) => {
                    gone.remove(&read.start);
                    end = read.end;
                    let is_other = text.get(read.clone()) != Some(new);
                    changes.extend(is_other.then(|| (read.clone(), new.clone())));
                }
                // A vertex comes right before the next one.
                (None, Some(next)) => changes.push((next.start..next.start, format!("{new}{lead}"))),
                (None, None) => changes.push((end..end, format!("{lead}{new}"))),
            }
        }
        changes.extend(gone.into_values().map(|range| (range, String::new())));
        changes.sort_by_key(|(at, _)| (at.start, at.end));
        // Programs may make the changes in any order: what comes at one place comes at once.
        changes.dedup_by(|(at, later), (before, text)| {
            let is_same = before.start == at.start;
            if is_same {
                before.end = at.end;
                text.push_str(later);
            }
            is_same
        });
        Some(changes)
    }

    fn lead(&self) -> String {
        self.items.first().map_or_else(|| format!("{}{INDENT}", self.margin), |item| item.lead.clone())
    }

    fn insert(&mut self, at: usize, child: Child, text: String) {
        let lead = self.lead();
        self.items.insert(at, Item { lead, text, child, vertex: None, read: None });
    }

    /// Sets an attribute where it is, else behind the others.
    pub fn set_attribute(&mut self, name: &str, value: &str) {
        let value = escape(value);
        match attribute(&self.head, name) {
            Some((from, to)) => self.head.replace_range(from..to, &value),
            None => self.head += &format!(" {name}=\"{value}\""),
        }
    }

    /// Sets latitude and longitude, degrees.
    pub fn set_place(&mut self, lat: f64, lon: f64) {
        for (name, value) in [("lat", lat), ("lon", lon)] {
            self.set_attribute(name, &fixed(value, DECIMALS));
        }
    }

    /// Sets a tag where it is, else behind all children.
    pub fn set_tag(&mut self, key: &str, value: &str) {
        let text = format!("<tag k=\"{}\" v=\"{}\"/>", escape(key), escape(value));
        let tag = Child::Tag(key.to_owned());
        // The last one counts where a key repeats.
        match self.items.iter_mut().rfind(|item| item.child == tag) {
            Some(old) => old.text = text,
            None => self.insert(self.items.len(), tag, text),
        }
    }

    /// Removes children; whether there was one.
    pub fn remove(&mut self, which: impl Fn(&Child) -> bool) -> bool {
        let before = self.items.len();
        self.items.retain(|item| !which(&item.child));
        self.items.len() < before
    }

    /// Adds a member behind the others.
    pub fn add_member(&mut self, kind: ElementKind, id: i64, role: &str) {
        let behind = self.items.iter().rposition(|item| matches!(item.child, Child::Member(..)));
        let child = Child::Member(kind, id, role.to_owned());
        self.insert(behind.map_or(0, |at| at + 1), child.clone(), child_text(&child));
    }

    /// The roles in which it names an element, each once.
    pub fn roles_of(&self, (kind, id): (ElementKind, i64)) -> Vec<String> {
        let mut roles = Vec::new();
        for item in &self.items {
            if let Child::Member(one, named, role) = &item.child
                && (*one, *named) == (kind, id)
                && !roles.contains(role)
            {
                roles.push(role.clone());
            }
        }
        roles
    }

    /// Makes each child into another; whether one was.
    pub fn replace(&mut self, with: impl Fn(&Child) -> Option<Child>) -> bool {
        let mut any = false;
        for item in &mut self.items {
            if let Some(child) = with(&item.child) {
                (item.text, item.child) = (child_text(&child), child);
                any = true;
            }
        }
        any
    }

    /// Inserts a vertex before the one that was read as the given number, or behind all; whether there is such a place.
    pub fn insert_vertex(&mut self, position: usize, point: i64) -> bool {
        let at = self.items.iter().position(|item| item.vertex == Some(position));
        let last = self.items.iter().rposition(|item| item.vertex.is_some());
        let count = self.items.iter().filter_map(|item| item.vertex).max().map_or(0, |last| last + 1);
        let at = match (at, last) {
            (Some(at), _) => at,
            (None, Some(last)) if position == count => last + 1,
            _ => return false,
        };
        let child = Child::Vertex(point);
        self.insert(at, child.clone(), child_text(&child));
        true
    }

    /// Removes the vertex that was read as the given number; whether it was there.
    pub fn remove_vertex(&mut self, position: usize) -> bool {
        let before = self.items.len();
        self.items.retain(|item| item.vertex != Some(position));
        self.items.len() < before
    }

    /// Replaces all vertices by these, where the first one was.
    pub fn set_vertices(&mut self, points: &[i64]) {
        self.exchange(|child| matches!(child, Child::Vertex(_)), points.iter().map(|&point| Child::Vertex(point)));
    }

    /// Replaces all members by these, where the first one was.
    pub fn set_members<'m>(&mut self, members: impl Iterator<Item = (ElementKind, i64, &'m str)>) {
        let members = members.map(|(kind, id, role)| Child::Member(kind, id, role.to_owned()));
        self.exchange(|child| matches!(child, Child::Member(..)), members);
    }

    fn exchange(&mut self, which: impl Fn(&Child) -> bool, children: impl Iterator<Item = Child>) {
        let at = self.items.iter().position(|item| which(&item.child)).unwrap_or(0);
        let lead = self.lead();
        self.items.retain(|item| !which(&item.child));
        let children = children.map(|child| Item {
            lead: lead.clone(),
            text: child_text(&child),
            child,
            vertex: None,
            read: None,
        });
        self.items.splice(at..at, children);
    }

    /// Turns the order of the vertices around; blanks and line ends stay where they are.
    pub fn reverse_vertices(&mut self) {
        let mut vertices = self.items.iter_mut().filter(|item| matches!(item.child, Child::Vertex(_)));
        while let Some((first, last)) = vertices.next().zip(vertices.next_back()) {
            std::mem::swap(first, last);
            std::mem::swap(&mut first.lead, &mut last.lead);
        }
    }

    /// Leaves out vertices that repeat the one before.
    pub fn drop_repeats(&mut self) {
        let mut last = None;
        self.items.retain(|item| match item.child {
            Child::Vertex(id) => last.replace(id) != Some(id),
            _ => true,
        });
    }
}

fn read_child(tag: &BytesStart<'_>) -> Child {
    let value = |key: &str| {
        let attribute =
            tag.attributes().with_checks(false).flatten().find(|attribute| attribute.key.as_ref() == key)?;
        attribute.normalized_value(XmlVersion::Implicit1_0).ok().map(|value| value.into_owned())
    };
    let id = || value("ref").and_then(|text| text.trim().parse().ok());
    let read = match tag.name().as_ref() {
        "tag" => value("k").map(Child::Tag),
        "nd" => id().map(Child::Vertex),
        "member" => {
            let kind = match value("type").as_deref() {
                Some("node") => Some(ElementKind::Node),
                Some("way") => Some(ElementKind::Way),
                Some("relation") => Some(ElementKind::Relation),
                _ => None,
            };
            kind.zip(id()).map(|(kind, id)| Child::Member(kind, id, value("role").unwrap_or_default()))
        }
        _ => None,
    };
    read.unwrap_or(Child::Other)
}

fn child_text(child: &Child) -> String {
    match child {
        Child::Tag(key) => format!("<tag k=\"{}\" v=\"\"/>", escape(key.as_str())),
        Child::Vertex(id) => format!("<nd ref=\"{id}\"/>"),
        Child::Member(kind, id, role) => {
            format!("<member type=\"{kind}\" ref=\"{id}\" role=\"{}\"/>", escape(role.as_str()))
        }
        Child::Other => String::new(),
    }
}
