//! Edits as changes of the file's own text, so that a program can make them and nothing else in the file moves.

use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::Report;
use crate::diagnostic::{Edit, Fix, SourceSpan, Subject};
use crate::lanelet::locate::span_of;

/// A range of a file (bytes), and its text after the change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Replacement {
    /// What goes; empty where something is put in.
    pub span: SourceSpan,
    /// What comes.
    pub text: String,
}

/// The changes of text that make the edits of a fix, in file order. `None` where one of them needs more than the
/// elements that it names: a new id, or every place that speaks of an element.
pub fn replacements(report: &Report<'_>, fix: &Fix) -> Option<Vec<Replacement>> {
    if vertices_shift(&fix.edits) {
        return None;
    }
    let mut all = Vec::new();
    for edit in &fix.edits {
        let (element, change) = of_edit(report, edit)?;
        all.extend(change.into_iter().map(|(from, to, text)| {
            let at = |offset: usize| element.span.start + offset as u64;
            Replacement { span: SourceSpan { file: element.span.file, start: at(from), end: at(to) }, text }
        }));
    }
    all.sort_by(|a, b| a.span.cmp(&b.span));
    // Programs may make the changes in any order: what is put in at one place is put in at once.
    all.dedup_by(|later, first| {
        let same = later.span == first.span && first.span.start == first.span.end;
        if same {
            first.text.push_str(&later.text);
        }
        same
    });
    let apart = all.windows(2).all(|two| {
        let [a, b] = [&two[0].span, &two[1].span];
        a.file != b.file || a.end < b.start || (a.end == b.start && a.start < a.end)
    });
    (apart && !all.is_empty()).then_some(all)
}

/// Whether one edit changes the positions of which another speaks.
fn vertices_shift(edits: &[Edit]) -> bool {
    let ways = edits.iter().filter_map(|edit| match edit {
        Edit::InsertVertex { way, .. } | Edit::RemoveVertex { way, .. } => Some(*way),
        _ => None,
    });
    let mut ways: Vec<Subject> = ways.collect();
    let count = ways.len();
    ways.sort_unstable();
    ways.dedup();
    ways.len() < count
}

/// Offsets within the element, and the new text.
type ByteChange = (usize, usize, String);

fn of_edit<'r>(report: &Report<'r>, edit: &Edit) -> Option<(Element<'r>, Vec<ByteChange>)> {
    let element = Element::read(report, edited_element(edit)?)?;
    let changes = match edit {
        Edit::SetTag { key, value, .. } => {
            let tag = format!("<tag k=\"{}\" v=\"{}\"/>", escape(key), escape(value));
            let old: Vec<&Child> = element.tags(key).collect();
            match old[..] {
                [] => vec![element.behind_last("tag", tag)?],
                [old] => vec![(old.start, old.end, tag)],
                _ => return None,
            }
        }
        Edit::RemoveTag { key, .. } => element.tags(key).map(|tag| element.without(tag)).collect(),
        Edit::AddMember { role, member, .. } => vec![element.behind_last("member", member_text(*member, role)?)?],
        Edit::RemoveMember { role, member, .. } => {
            element.members(role, *member).map(|member| element.without(member)).collect()
        }
        Edit::SetRole { member, from, to, .. } => {
            let text = member_text(*member, to)?;
            element.members(from, *member).map(|old| (old.start, old.end, text.clone())).collect()
        }
        Edit::InsertVertex { position, point, .. } => vec![element.vertex(*position, *point)?],
        Edit::RemoveVertex { position, .. } => vec![element.without(element.named("nd").nth(*position)?)],
        Edit::ReplaceWay { from, to, .. } => {
            let (from, to) = (Subject::LineString(*from), Subject::LineString(*to));
            let bounds = ["left", "right"].into_iter().flat_map(|role| {
                let text = member_text(to, role);
                element.members(role, from).filter_map(move |old| Some((old.start, old.end, text.clone()?)))
            });
            bounds.collect()
        }
        _ => return None,
    };
    Some((element, changes))
}

/// The one element that an edit changes; `None` for an edit of several.
fn edited_element(edit: &Edit) -> Option<Subject> {
    match edit {
        Edit::SetTag { on, .. }
        | Edit::RemoveTag { on, .. }
        | Edit::AddMember { on, .. }
        | Edit::RemoveMember { on, .. }
        | Edit::SetRole { on, .. } => Some(*on),
        Edit::InsertVertex { way, .. } | Edit::RemoveVertex { way, .. } => Some(*way),
        Edit::ReplaceWay { lanelet, .. } => Some(Subject::Lanelet(*lanelet)),
        Edit::MergePoints { .. }
        | Edit::Remove { .. }
        | Edit::RemoveRepeat { .. }
        | Edit::Renumber { .. }
        | Edit::SetPlace { .. }
        | Edit::CreateRegulatoryElement { .. }
        | Edit::CreateArea { .. }
        | Edit::SetVertices { .. }
        | Edit::PlaceBetween { .. }
        | Edit::CreateStopLine { .. }
        | Edit::CreateMarking { .. }
        | Edit::ReverseWay { .. }
        | Edit::CreateOpposite { .. }
        | Edit::SetFormatVersion { .. }
        | Edit::Divide(_) => None,
    }
}

/// The word of a member's `type`.
fn kind_of(subject: Subject) -> Option<&'static str> {
    Some(match subject {
        Subject::Map => return None,
        Subject::Point(_) | Subject::Node(_) => "node",
        Subject::LineString(_) | Subject::Polygon(_) | Subject::Way(_) => "way",
        Subject::Lanelet(_) | Subject::RegulatoryElement(_) | Subject::Relation(_) => "relation",
    })
}

fn member_text(member: Subject, role: &str) -> Option<String> {
    let (kind, id) = (kind_of(member)?, member.id()?);
    Some(format!("<member type=\"{kind}\" ref=\"{id}\" role=\"{}\"/>", escape(role)))
}

fn escape(text: &str) -> String {
    quick_xml::escape::escape(text).replace('\n', "&#10;").replace('\r', "&#13;").replace('\t', "&#9;")
}

/// An element of the file, by its text.
struct Element<'r> {
    span: SourceSpan,
    text: &'r str,
    /// Offset behind its opening tag.
    opened: usize,
    children: Vec<Child>,
}

/// A tag, node reference or member, by offsets within the element.
struct Child {
    name: String,
    start: usize,
    end: usize,
    attributes: Vec<(String, String)>,
}

impl Child {
    fn is(&self, key: &str, value: &str) -> bool {
        self.attributes.iter().any(|(k, v)| k == key && v == value)
    }
}

impl<'r> Element<'r> {
    /// `None` where the file has no such text, or an element without content.
    fn read(report: &Report<'r>, subject: Subject) -> Option<Self> {
        let span = span_of(report.map, subject)?;
        let text = report.sources.text(&span)?;
        let mut reader = Reader::from_str(text);
        let (mut depth, mut opened) = (0, None);
        let mut children: Vec<Child> = Vec::new();
        loop {
            let start = usize::try_from(reader.buffer_position()).ok()?;
            let event = reader.read_event().ok()?;
            let end = usize::try_from(reader.buffer_position()).ok()?;
            match event {
                Event::Start(_) if depth == 0 => {
                    opened = Some(end);
                    depth = 1;
                }
                Event::Start(tag) => {
                    if depth == 1 {
                        children.push(child(&tag, start, end)?);
                    }
                    depth += 1;
                }
                Event::Empty(tag) if depth == 1 => children.push(child(&tag, start, end)?),
                Event::End(_) => {
                    depth -= 1;
                    match (depth, children.last_mut()) {
                        (0, _) => break,
                        (1, Some(last)) => last.end = end,
                        _ => {}
                    }
                }
                Event::Eof => break,
                _ => {}
            }
        }
        Some(Self { span, text, opened: opened?, children })
    }

    fn named<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Child> {
        self.children.iter().filter(move |child| child.name == name)
    }

    fn tags<'a>(&'a self, key: &'a str) -> impl Iterator<Item = &'a Child> {
        self.named("tag").filter(move |tag| tag.is("k", key))
    }

    fn members<'a>(&'a self, role: &'a str, target: Subject) -> impl Iterator<Item = &'a Child> {
        let id = target.id().map_or(String::new(), |id| id.to_string());
        let kind = kind_of(target).unwrap_or_default();
        self.named("member").filter(move |one| one.is("role", role) && one.is("ref", &id) && one.is("type", kind))
    }

    /// The blanks that put a child on its own line.
    fn gap(&self, child: &Child) -> &'r str {
        let before = self.text.get(..child.start).unwrap_or_default();
        before.get(before.trim_end().len()..).unwrap_or_default()
    }

    /// A child and the blanks before it, taken out.
    fn without(&self, child: &Child) -> ByteChange {
        (child.start - self.gap(child).len(), child.end, String::new())
    }

    /// Text behind the last child of a name, or else behind the last one, or else first.
    fn behind_last(&self, name: &str, text: String) -> Option<ByteChange> {
        let last = self.named(name).last().or(self.children.last());
        match last {
            Some(last) => Some((last.end, last.end, format!("{}{text}", self.gap(last)))),
            None => Some((self.opened, self.opened, text)),
        }
    }

    fn vertex(&self, position: usize, point: i64) -> Option<ByteChange> {
        let text = format!("<nd ref=\"{point}\"/>");
        match self.named("nd").nth(position) {
            Some(next) => Some((next.start, next.start, format!("{text}{}", self.gap(next)))),
            None if position == self.named("nd").count() => self.behind_last("nd", text),
            None => None,
        }
    }
}

fn child(tag: &BytesStart<'_>, start: usize, end: usize) -> Option<Child> {
    let mut attributes = Vec::new();
    for attribute in tag.attributes().with_checks(false) {
        let attribute = attribute.ok()?;
        let value = quick_xml::escape::unescape(&attribute.value).ok()?.into_owned();
        attributes.push((attribute.key.as_ref().to_owned(), value));
    }
    Some(Child { name: tag.name().as_ref().to_owned(), start, end, attributes })
}
