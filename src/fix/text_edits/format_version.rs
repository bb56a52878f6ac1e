//! Writes the version of the format into the head of each file.

use quick_xml::events::Event;
use quick_xml::reader::Reader;

use super::TextEdits;
use crate::diagnostic::SourceSpan;
use crate::osm::element::Element;

/// The element that says it, a child of the root.
const META_INFO: &str = "MetaInfo";

impl TextEdits<'_> {
    /// Writes `format_version` wherever a file has a `MetaInfo`, and puts one before all elements where it has none.
    pub(super) fn set_format_version(&mut self, version: &str) -> Option<()> {
        let osm = self.osm;
        for (file, source) in (0..).zip(&osm.sources) {
            let places = places(&source.text, osm.meta.is_some())?;
            for (start, end) in places {
                let span = SourceSpan { file, start: start as u64, end: end as u64 };
                if start == end {
                    let mut meta = Element::without_id(META_INFO, "\n  ");
                    meta.set_attribute("format_version", version);
                    meta.set_attribute("map_version", "1");
                    self.journal.push((span.clone(), self.edited.insert(span, Some(meta))));
                } else {
                    self.element_at(&span)?.set_attribute("format_version", version);
                }
            }
        }
        Some(())
    }
}

/// Where each `MetaInfo` of a text begins and ends; where it has none, the end of the root's start tag, twice. It is looked for behind
/// the first node, way or relation only if `anywhere`.
fn places(text: &str, anywhere: bool) -> Option<Vec<(usize, usize)>> {
    let mut reader = Reader::from_str(text);
    let (mut depth, mut root, mut found) = (0_usize, None, Vec::new());
    loop {
        let start = usize::try_from(reader.buffer_position()).ok()?;
        let event = reader.read_event().ok()?;
        let end = usize::try_from(reader.buffer_position()).ok()?;
        match event {
            Event::Start(_) if depth == 0 => (root, depth) = (Some(end), 1),
            Event::Empty(_) if depth == 0 => return None,
            Event::Start(tag) if depth == 1 => {
                let is_meta = tag.name().as_ref() == META_INFO;
                if !is_meta && !anywhere {
                    break;
                }
                reader.read_to_end(tag.name()).ok()?;
                if is_meta {
                    found.push((start, usize::try_from(reader.buffer_position()).ok()?));
                }
            }
            Event::Empty(tag) if depth == 1 && tag.name().as_ref() == META_INFO => found.push((start, end)),
            Event::End(_) | Event::Eof => break,
            _ => {}
        }
    }
    if found.is_empty() {
        let root = root?;
        found.push((root, root));
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_stands_where_it_is_or_comes_first() {
        let of = |text: &str, anywhere| -> Option<Vec<String>> {
            Some(places(text, anywhere)?.into_iter().map(|(from, to)| text[from..to].to_owned()).collect())
        };
        let some = |texts: &[&str]| Some(texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>());
        let meta = "<MetaInfo map_version='1'/>";
        assert_eq!(
            of(&format!("<?xml version=\"1.0\"?><!-- <MetaInfo/> --><osm>{meta}<node/></osm>"), false),
            some(&[meta])
        );
        let long = "<MetaInfo><a/></MetaInfo>";
        assert_eq!(of(&format!("<osm><node><tag/></node>{long}{meta}</osm>"), true), some(&[long, meta]));
        assert_eq!(of("<osm><node><MetaInfo/></node></osm>", true), some(&[""]));
        assert_eq!(places("<osm a='>'><node/></osm>", false), Some(vec![(11, 11)]));
        assert_eq!(places("<osm/>", false), None);
    }
}
