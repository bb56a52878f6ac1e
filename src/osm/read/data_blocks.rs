//! Reads what a file of any format says, block by block, without the text.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::blocks::Blocks;
use crate::osm::pbf::{self, PbfBlocks};
use crate::osm::{OsmData, ReadError};

/// Blocks of a file of XML.
const BLOCKS: u64 = 256;

/// What a file says, in blocks: XML, plain or gzip, or PBF. None is in memory longer than it is asked for.
pub enum DataBlocks {
    /// XML.
    Xml(Box<Blocks>),
    /// PBF.
    Pbf(PbfBlocks),
}

impl DataBlocks {
    /// Begins to read a file.
    ///
    /// # Errors
    ///
    /// If the file cannot be read.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let failed = |source| ReadError::Io { path: path.to_path_buf(), source };
        let mut file = File::open(path).map_err(failed)?;
        let mut head = Vec::new();
        Read::by_ref(&mut file).take(32).read_to_end(&mut head).map_err(failed)?;
        if !pbf::is_pbf(&head) {
            return Blocks::open(path, BLOCKS).map(|blocks| Self::Xml(Box::new(blocks)));
        }
        file.seek(SeekFrom::Start(0)).map_err(failed)?;
        Ok(Self::Pbf(PbfBlocks::new(path.display().to_string(), file)))
    }

    /// What the next block says; `None` at the end of the file. No id is indexed.
    ///
    /// # Errors
    ///
    /// If the file cannot be read further, or what it says is no OpenStreetMap data.
    pub fn next_block(&mut self) -> Result<Option<OsmData>, ReadError> {
        match self {
            Self::Xml(blocks) => Ok(blocks.next_block()?.map(|block| block.data)),
            Self::Pbf(blocks) => blocks.next_block(),
        }
    }
}
