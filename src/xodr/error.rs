//! Why a text is no OpenDRIVE file that can be read, and what is odd in one that can.

/// Why a text cannot be read at all.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum XodrError {
    /// XML that is broken at a byte.
    #[error("{message}")]
    Broken {
        /// Byte offset.
        offset: usize,
        /// What is wrong.
        message: String,
    },
    /// It ends in the middle of an element.
    #[error("the file ends in the middle of an element")]
    CutOff {
        /// Byte offset.
        offset: usize,
    },
    /// It has more elements, or deeper ones, than any real file.
    #[error("more elements, or deeper ones, than a road network has")]
    TooMuch {
        /// Byte offset.
        offset: usize,
    },
    /// Its root is not `OpenDRIVE`.
    #[error("there is no <OpenDRIVE> element")]
    NoRoot,
}

impl XodrError {
    /// Where it broke, a byte offset.
    pub fn offset(&self) -> usize {
        match self {
            Self::Broken { offset, .. } | Self::CutOff { offset } | Self::TooMuch { offset } => *offset,
            Self::NoRoot => 0,
        }
    }

    /// A way out, in one line.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Broken { .. } | Self::CutOff { .. } => {
                "the file is damaged or cut off here; export or download it again"
            }
            Self::TooMuch { .. } => "the file is damaged, or made to fill the memory; export or download it again",
            Self::NoRoot => "expected OpenDRIVE XML, whose root element is <OpenDRIVE>",
        }
    }
}

/// Something that breaks the standard; the rest of the file is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Oddity {
    /// Line of the element, from 1.
    pub line: usize,
    /// What is wrong and what was done instead, one sentence.
    pub message: String,
}
