//! Elements of a file that is read once, on disk until it is known which tiles need them.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::osm::{Node, OsmData, Relation, Way};

/// The elements of one block of a file, in its order.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Elements {
    pub(super) nodes: Vec<Node>,
    pub(super) ways: Vec<Way>,
    pub(super) relations: Vec<Relation>,
}

impl From<OsmData> for Elements {
    fn from(OsmData { nodes, ways, relations, .. }: OsmData) -> Self {
        Self { nodes, ways, relations }
    }
}

/// Blocks of elements, written one behind the other. The file has no name, so that it is gone with the program, however that ends.
#[derive(Debug)]
pub(super) struct Spool {
    file: BufWriter<File>,
    /// How many blocks there are.
    blocks: usize,
}

impl Spool {
    /// An empty one in a folder that is there.
    pub(super) fn new(folder: &Path) -> io::Result<Self> {
        Ok(Self { file: BufWriter::new(tempfile::tempfile_in(folder)?), blocks: 0 })
    }

    /// Adds a block: its length in bytes, then its elements.
    pub(super) fn push(&mut self, elements: &Elements) -> io::Result<()> {
        let packed = postcard::to_stdvec(elements).map_err(io::Error::other)?;
        self.blocks += 1;
        self.file.write_all(&(packed.len() as u64).to_le_bytes())?;
        self.file.write_all(&packed)
    }

    /// All blocks in their order.
    pub(super) fn blocks(self) -> io::Result<impl Iterator<Item = io::Result<Elements>>> {
        let mut file = self.file.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.rewind()?;
        let mut file = BufReader::new(file);
        let mut next = move || {
            let mut length = [0; size_of::<u64>()];
            file.read_exact(&mut length)?;
            let mut packed = Vec::new();
            Read::by_ref(&mut file).take(u64::from_le_bytes(length)).read_to_end(&mut packed)?;
            postcard::from_bytes(&packed).map_err(io::Error::other)
        };
        Ok((0..self.blocks).map(move |_| next()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::osm::{ElementKind, Member, Tags};
    use crate::projection::LonLat;
    use crate::text::SourceSpan;

    #[test]
    fn blocks_come_back_in_their_order() {
        let span = SourceSpan::default();
        let tags = Tags::of(&[("highway", "crossing"), ("name", &"ä".repeat(300))]);
        let position = Some(LonLat { lon: -0.1 + 1e-17, lat: f64::MIN_POSITIVE });
        let node = |id, position| Node { id, position, tags: tags.clone(), span: span.clone() };
        let member = Member { kind: ElementKind::Way, id: i64::MIN, role: "via".into() };
        let blocks = [
            Elements { nodes: vec![node(-1, position), node(i64::MAX, None)], ways: Vec::new(), relations: Vec::new() },
            Elements { nodes: Vec::new(), ways: Vec::new(), relations: Vec::new() },
            Elements {
                nodes: Vec::new(),
                ways: vec![Way { id: 7, nodes: vec![-1, i64::MAX], tags: Tags::new(), span: span.clone() }],
                relations: vec![Relation { id: 8, members: vec![member], tags: tags.clone(), span }],
            },
        ];
        let mut spool = Spool::new(&std::env::temp_dir()).unwrap();
        blocks.iter().for_each(|block| spool.push(block).unwrap());
        let read: Vec<Elements> = spool.blocks().unwrap().map(Result::unwrap).collect();
        assert_eq!(format!("{read:?}"), format!("{blocks:?}"));
    }
}
