//! Reads a file block by block, so that a map that is larger than the memory can be passed through, more than once if need be.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;

use super::parser::{Parser, Place};
use super::{ended, parts};
use crate::osm::limits::{element_begins, most_passed_through};
use crate::osm::{ElementKind, OsmData, OsmText, ReadError, load, most_input, pbf};

/// A block grows up to this many bytes until it ends between two elements: a comment, or one element, can be long.
const LONGEST: usize = 1 << 27;
/// The shortest block, bytes: enough work for all threads.
const SHORT: u64 = if cfg!(test) { 1 << 10 } else { 1 << 20 };
/// The longest block, bytes, that is not cut where it could be.
const LONG: u64 = 1 << 27;

/// What a file says, in blocks.
pub struct Blocks {
    name: String,
    /// Bytes of the file.
    size: u64,
    from: Box<dyn Read>,
    /// Bytes that were read and are not yet part of a block.
    rest: Vec<u8>,
    length: usize,
    place: Place,
    /// Whether there is nothing more to read.
    at_end: bool,
    packed: bool,
    /// Bytes and line feeds of all blocks so far.
    offset: usize,
    lines: usize,
}

/// A part of a file that begins and ends between two elements.
#[derive(Debug)]
pub struct Block {
    /// The text.
    pub text: String,
    /// What it says. Positions are those in the text of the block; no id is indexed.
    pub data: OsmData,
}

impl Block {
    /// The elements in the order of the text, each with its kind and its text.
    pub fn elements(&self) -> Vec<(ElementKind, &str)> {
        let nodes = self.data.nodes.iter().map(|one| (&one.span, ElementKind::Node));
        let ways = self.data.ways.iter().map(|one| (&one.span, ElementKind::Way));
        let relations = self.data.relations.iter().map(|one| (&one.span, ElementKind::Relation));
        let mut all: Vec<_> = nodes.chain(ways).chain(relations).collect();
        all.sort_by_key(|(span, _)| span.start);
        let text = |start: u64, end: u64| self.text.get(start as usize..end as usize).unwrap_or_default();
        all.into_iter().map(|(span, kind)| (kind, text(span.start, span.end))).collect()
    }
}

impl Blocks {
    /// Begins to read a file: XML, plain or gzip, or PBF, which becomes XML first. It is read in about so many blocks, as long as
    /// they are neither too short nor too long.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, or is PBF that cannot be decoded.
    pub fn open(path: &Path, blocks: u64) -> Result<Self, ReadError> {
        let failed = |source| ReadError::Io { path: path.to_path_buf(), source };
        let name = path.display().to_string();
        let mut file = File::open(path).map_err(failed)?;
        let about = file.metadata().map_err(failed)?;
        if !about.is_file() {
            return Err(failed(std::io::Error::other("it is no file that can be read twice")));
        }
        let mut size = about.len();
        let mut head = Vec::new();
        Read::by_ref(&mut file).take(32).read_to_end(&mut head).map_err(failed)?;
        file.seek(SeekFrom::Start(0)).map_err(failed)?;
        if pbf::is_pbf(&head) {
            file = xml_of(path, &name)?;
            size = file.metadata().map_err(failed)?.len();
        }
        let packed = head.starts_with(&[0x1f, 0x8b]);
        let file = BufReader::new(file);
        let from: Box<dyn Read> = match packed {
            true => Box::new(flate2::bufread::MultiGzDecoder::new(file)),
            false => Box::new(file),
        };
        Ok(Self { packed, size, ..Self::of(name, from, size / blocks.max(1)) })
    }

    fn of(name: String, from: Box<dyn Read>, length: u64) -> Self {
        let length = length.clamp(SHORT, LONG) as usize;
        let (rest, place) = (Vec::new(), Place::default());
        Self { name, size: 0, from, rest, length, place, at_end: false, packed: false, offset: 0, lines: 0 }
    }

    /// What messages call the file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Bytes of the file, packed where it is.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// The next block; `None` at the end of the file.
    ///
    /// # Errors
    ///
    /// If the file cannot be read further, or what it says is no OpenStreetMap data. The error has no text to show.
    pub fn next_block(&mut self) -> Result<Option<Block>, ReadError> {
        let mut wanted = self.length;
        loop {
            self.fill(wanted)?;
            if self.rest.is_empty() {
                return if self.offset == 0 { Err(ReadError::Empty { name: self.name.clone() }) } else { Ok(None) };
            }
            let cut = if self.at_end { Some(self.rest.len()) } else { element_begins(&self.rest).rfind(|at| *at > 0) };
            let last_try = self.at_end || wanted >= LONGEST;
            match cut.or(last_try.then_some(self.rest.len())).map(|cut| self.block(cut, last_try)) {
                Some(Ok(block)) => return Ok(Some(block)),
                Some(Err(error)) if last_try => return Err(error),
                Some(Err(_)) | None => wanted *= 2,
            }
        }
    }

    /// Reads on until this many bytes are there, or all that there are.
    fn fill(&mut self, wanted: usize) -> Result<(), ReadError> {
        let missing = wanted.saturating_sub(self.rest.len());
        if self.at_end || missing == 0 {
            return Ok(());
        }
        self.rest.reserve_exact(missing);
        let read = self.from.by_ref().take(missing as u64).read_to_end(&mut self.rest);
        let (name, path) = (&self.name, || Path::new(&self.name).to_path_buf());
        let damaged = |message: String| ReadError::Packed { name: name.clone(), message };
        self.at_end = read.map_err(|source| match self.packed {
            true => damaged(source.to_string()),
            false => ReadError::Io { path: path(), source },
        })? < missing;
        let most = most_passed_through();
        if self.packed && (self.offset + self.rest.len()) as u64 > most {
            return Err(ReadError::TooLarge { name: name.clone(), most });
        }
        if self.offset == 0 && self.rest.starts_with(b"\xef\xbb\xbf") {
            self.rest.drain(..3);
        }
        if self.offset == 0 && self.at_end && self.rest.iter().all(u8::is_ascii_whitespace) {
            return Err(ReadError::Empty { name: self.name.clone() });
        }
        Ok(())
    }

    /// The block of so many bytes, if it ends between two elements.
    fn block(&mut self, length: usize, last_try: bool) -> Result<Block, ReadError> {
        let not_text = |valid| ReadError::NotText { name: self.name.clone(), offset: self.offset + valid };
        let bytes = self.rest.get(..length).unwrap_or(&self.rest);
        let text = std::str::from_utf8(bytes).map_err(|error| not_text(error.valid_up_to()))?;
        let data = self.parse(text).map_err(|error| self.placed(error))?;
        let (text, rest) = (text.to_owned(), self.rest.split_off(length));
        self.rest = rest;
        self.offset += length;
        // Only an error asks for the line, and only of what follows.
        self.lines += if last_try && self.at_end { 0 } else { text.bytes().filter(|byte| *byte == b'\n').count() };
        self.place = Place::IN_ROOT;
        Ok(Block { text, data })
    }

    fn parse(&self, text: &str) -> Result<OsmData, ReadError> {
        let to = if self.at_end { Place { depth: 0, seen_root: true } } else { Place::IN_ROOT };
        let mut data = OsmData::default();
        if let Some(parts) = parts::parse(0, &self.name, text, [self.place, to]) {
            parts.into_iter().for_each(|part| data.append(part));
            return Ok(data);
        }
        let mut parser = Parser { data: &mut data, file: 0, name: &self.name, text };
        let reached = parser.run(0..text.len(), self.place)?;
        match self.at_end {
            true => ended(&parser, reached)?,
            false if reached != to => return Err(parser.broken(0, "this element does not end".to_owned(), CUT)),
            false => {}
        }
        Ok(data)
    }

    /// An error with its place in the file, where it had one in the block.
    fn placed(&self, mut error: ReadError) -> ReadError {
        if let ReadError::Broken { line, offset, .. } = &mut error {
            *line += self.lines;
            *offset += self.offset;
        }
        error
    }
}

/// What may be wrong with a file of which a long piece is no whole number of elements.
const CUT: &str = "the file is damaged here; export or download it again";

/// The XML of a PBF file, in a temporary file that has no name.
fn xml_of(path: &Path, name: &str) -> Result<File, ReadError> {
    let failed = |source| ReadError::Io { path: path.to_path_buf(), source };
    let mut data = OsmData::default();
    pbf::read(&mut data, name, &load(path)?, most_input())?;
    let mut file = tempfile::tempfile().map_err(failed)?;
    let mut text = OsmText::head(&data.meta.clone().unwrap_or_default());
    data.nodes.iter().for_each(|node| text.put_node(node));
    data.ways.iter().for_each(|way| text.put_way(way));
    data.relations.iter().for_each(|relation| text.put_relation(relation));
    let texts = [text, OsmText::tail()];
    texts.iter().try_for_each(|text| file.write_all(text.as_bytes())).map_err(failed)?;
    file.seek(SeekFrom::Start(0)).map_err(failed)?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::osm::read_bytes;
    use std::io::Cursor;

    fn blocks(text: &str) -> Result<Vec<Block>, ReadError> {
        let mut blocks = Blocks::of("test".to_owned(), Box::new(Cursor::new(text.as_bytes().to_vec())), 0);
        std::iter::from_fn(|| blocks.next_block().transpose()).collect()
    }

    /// A document of several blocks, with this text in its middle.
    fn document(middle: &str) -> String {
        let node = |id| format!("  <node id=\"{id}\" lat=\"1.5\" lon=\"2\"><tag k=\"k\" v=\"\u{e9}\"/></node>\n");
        let nodes = |from: i64| (from..from + 100).map(node).collect::<String>();
        let way = "<way id=\"1\"><nd ref=\"3\"/><nd ref=\"300\"/></way>\n";
        format!("<?xml version=\"1.0\"?>\n<osm generator=\"g\">{}{middle}{}{way}</osm>\n", nodes(1), nodes(201))
    }

    #[test]
    fn blocks_say_what_the_whole_says() {
        let comment = format!("<!-- {} -->", "<node id=\"7\" lat=\"0\" lon=\"0\"/>\n".repeat(200));
        for middle in ["", "<MetaInfo format_version=\"2\"/>", &comment, "<way id=\"9\"/>"] {
            let text = document(middle);
            let mut whole = OsmData::default();
            read_bytes(&mut whole, "test", text.clone().into_bytes()).unwrap();
            let blocks = blocks(&text).unwrap();
            assert!(blocks.len() > 3, "{middle}");
            assert_eq!(blocks.iter().map(|block| block.text.as_str()).collect::<String>(), text);
            let ids = |data: &OsmData| data.nodes.iter().map(|node| node.id).collect::<Vec<_>>();
            assert_eq!(blocks.iter().flat_map(|block| ids(&block.data)).collect::<Vec<_>>(), ids(&whole));
            let meta = blocks.iter().rev().find_map(|block| block.data.meta.clone());
            assert_eq!(meta, whole.meta);
        }
    }

    #[test]
    fn elements_come_in_the_order_of_the_text() {
        let text =
            "<osm><way id='1'/><node id='2' lat='0' lon='0'/><relation id='3'/><node id='4' lat='1' lon='1'/></osm>";
        let blocks = blocks(text).unwrap();
        let all: Vec<_> = blocks.iter().flat_map(Block::elements).map(|(kind, text)| (kind, &text[..9])).collect();
        let [node, way, relation] = [ElementKind::Node, ElementKind::Way, ElementKind::Relation];
        assert_eq!(all, [(way, "<way id='"), (node, "<node id="), (relation, "<relation"), (node, "<node id=")]);
    }

    #[test]
    fn an_error_names_the_line_of_the_file() {
        let place = |error: &ReadError| error.to_string().split(' ').next().map(str::to_owned);
        let text = document("</way>");
        let whole = read_bytes(&mut OsmData::default(), "test", text.clone().into_bytes()).unwrap_err();
        assert_eq!(place(&blocks(&text).unwrap_err()), place(&whole));
        for middle in ["<way>", "<!--", "\n<node id=\"x"] {
            assert!(blocks(&document(middle)).is_err(), "{middle}");
        }
        assert!(matches!(blocks(" \n"), Err(ReadError::Empty { .. })));
        let cut = document("");
        assert!(blocks(&cut[..cut.len() - 8]).is_err());
    }
}
