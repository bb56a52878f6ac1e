//! Reads a large file in parts at the same time, with the same result as in one pass.
//!
//! A part begins where an element of the map seems to. Whether one does is known when the part before has been read: it
//! must end between two children of the root. Where one does not (a comment, a text in quotes, an unknown element around
//! it), the file is read in one pass.

use std::ops::Range;

use rayon::prelude::*;

use super::parser::{Parser, Place};
use crate::osm::OsmData;
use crate::osm::limits::element_begins;
use crate::parallel::InSmallParts;

/// Length of a part, bytes: enough for reading to outweigh the joining, small enough to keep many threads busy. It does
/// not depend on the number of threads, so nor does the result.
const LENGTH: usize = if cfg!(test) { 1 << 12 } else { 1 << 18 };

/// The places where a whole document begins and ends.
pub(super) const DOCUMENT: [Place; 2] = [Place { depth: 0, seen_root: false }, Place { depth: 0, seen_root: true }];

/// What the parts of a text say, in order, which begins and ends at these places; `None` where it is too short, or must be read
/// in one pass.
pub(super) fn parse(file: u32, name: &str, text: &str, [begin, end]: [Place; 2]) -> Option<Vec<OsmData>> {
    let parts = split(text, LENGTH);
    if parts.len() < 2 {
        return None;
    }
    let last = parts.len() - 1;
    let read = |(i, range): (usize, &Range<usize>)| {
        let mut data = OsmData::default();
        let from = if i == 0 { begin } else { Place::IN_ROOT };
        let to = if i == last { end } else { Place::IN_ROOT };
        let reached = Parser { data: &mut data, file, name, text }.run(range.clone(), from).ok()?;
        (reached == to).then_some(data)
    };
    parts.par_iter().in_small_parts().enumerate().map(read).collect()
}

/// Cuts a text before what seem to be nodes, ways and relations, into parts of at least this many bytes.
fn split(text: &str, length: usize) -> Vec<Range<usize>> {
    let mut parts = Vec::new();
    let mut from = 0;
    while let Some(to) = text.as_bytes().get(from + length..).and_then(|rest| element_begins(rest).next()) {
        parts.push(from..from + length + to);
        from += length + to;
    }
    parts.push(from..text.len());
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::osm::read_bytes;

    /// A document longer than some parts, with this text somewhere in the middle.
    fn document(middle: &str) -> String {
        let nodes = |from: i64| {
            let node = |id| format!("  <node id=\"{id}\" lat=\"1.5\" lon=\"2\"><tag k=\"k\" v=\"\u{e9}\"/></node>\n");
            (from..from + 300).map(node).collect::<String>()
        };
        let ways = "<way id=\"1\"><nd ref=\"x\"/><nd ref=\"300\"/></way>\n<way id=\"1\"><nd ref=\"5\"/></way>";
        format!("<?xml version=\"1.0\"?>\n<osm generator=\"g\">{}{middle}{}{ways}\n</osm>\n", nodes(1), nodes(250))
    }

    fn in_one_pass(text: &str) -> OsmData {
        let mut data = OsmData::default();
        let mut parser = Parser { data: &mut data, file: 0, name: "test", text };
        parser.run(0..text.len(), Place::default()).unwrap();
        data.index([0; 3]);
        data.oddities.sort_by_key(|oddity| oddity.span.start);
        data
    }

    #[test]
    fn parts_say_what_the_whole_says() {
        let text = document("<MetaInfo format_version=\"2\"/>");
        assert!(parse(0, "test", &text, DOCUMENT).is_some_and(|parts| parts.len() > 3));
        let (mut data, whole) = (OsmData::default(), in_one_pass(&text));
        read_bytes(&mut data, "test", text.into_bytes()).unwrap();
        assert_eq!(data.oddities.len(), 53);
        data.sources.clear();
        assert_eq!(format!("{:?}", data.oddities), format!("{:?}", whole.oddities));
        assert_eq!(format!("{:?}", data.nodes), format!("{:?}", whole.nodes));
        assert_eq!(format!("{:?}", data.ways), format!("{:?}", whole.ways));
        assert_eq!((data.meta, data.generator), (whole.meta, whole.generator));
    }

    #[test]
    fn what_only_looks_like_an_element_is_read_in_one_pass() {
        let nodes = "<node id=\"7\" lat=\"0\" lon=\"0\"/>\n".repeat(1_000);
        for (before, behind) in [("<!--", "-->"), ("<unknown>", "</unknown>"), ("<tag k='", "'/>")] {
            let text = document(&format!("{before}{nodes}{behind}"));
            assert!(parse(0, "test", &text, DOCUMENT).is_none(), "{before}");
            let mut data = OsmData::default();
            read_bytes(&mut data, "test", text.into_bytes()).unwrap();
            assert_eq!(data.nodes.len(), 600, "{before}");
        }
    }

    #[test]
    fn what_is_broken_stays_broken() {
        for middle in ["</way>", "</osm>", "<way>"] {
            let text = document(middle);
            let mut data = OsmData::default();
            assert!(read_bytes(&mut data, "test", text.into_bytes()).is_err(), "{middle}");
        }
    }
}
