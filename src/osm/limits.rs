//! How much input may take, so that neither a small file that unpacks to a large one nor one that never ends fills the memory.

use std::fs;
use std::io::{self, Read};
use std::sync::OnceLock;

use super::ReadError;

/// Bytes from the begin of an element to that of the next. The longest relation of OpenStreetMap, with 32,000 members, takes 2 MB.
pub const LONGEST_ELEMENT: usize = 64 << 20;

/// Most bytes of input where the machine does not say how much memory it has: the XML of a country.
const USUAL: u64 = 8 << 30;

/// To check a map takes about four times as much memory as its text.
const SHARE: u64 = 4;

/// Bytes that are looked at together.
const BLOCK: usize = 1 << 20;

/// A packed file may be so many times larger unpacked: of OpenStreetMap's XML and of maps gzip makes a tenth.
const UNPACKED_TIMES: u64 = 40;
/// A small one may take so many bytes.
const LEAST_UNPACKED: u64 = 32 << 20;

static MOST: OnceLock<u64> = OnceLock::new();
/// What somebody has asked for.
static ASKED: OnceLock<u64> = OnceLock::new();

/// Sets how many bytes the files of a map may take in memory, for the whole program. What was set or asked for before stays.
pub fn limit_input(bytes: u64) {
    let _ = MOST.set(bytes);
    let _ = ASKED.set(bytes);
}

/// How many bytes the files of a map may take in memory, unpacked: what was set, or else a quarter of the memory.
pub fn most_input() -> u64 {
    *MOST.get_or_init(|| memory().map_or(USUAL, |bytes| bytes / SHARE))
}

/// How many bytes a packed file may take unpacked: so many that a real one stays far below. What was set for the whole program goes before.
pub fn most_unpacked(packed: usize) -> u64 {
    ASKED.get().copied().unwrap_or_else(|| (UNPACKED_TIMES * packed as u64).max(LEAST_UNPACKED))
}

/// How many bytes may be passed through block by block: what was set, or else the XML of a country.
pub fn most_passed_through() -> u64 {
    MOST.get().copied().unwrap_or(USUAL)
}

/// Bytes of memory that this process may use, where Linux tells.
fn memory() -> Option<u64> {
    let number = |path: &str| fs::read_to_string(path).ok()?.trim().parse::<u64>().ok();
    let machine = fs::read_to_string("/proc/meminfo").ok().and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
        Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
    });
    let group = ["/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"].map(number);
    group.into_iter().flatten().chain(machine).min()
}

/// Reads to the end, or until more than `most` bytes or one element too long were read. Only where `guard` says so of the
/// first bytes, elements are looked for.
pub fn read_within(
    mut from: impl Read,
    name: &str,
    most: u64,
    guard: impl Fn(&[u8]) -> bool,
    failed: impl Fn(io::Error) -> ReadError,
) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Vec::new();
    let mut elements = Elements::default();
    loop {
        let before = bytes.len();
        from.by_ref().take(BLOCK as u64).read_to_end(&mut bytes).map_err(&failed)?;
        if bytes.len() as u64 > most {
            return Err(ReadError::TooLarge { name: name.to_owned(), most });
        }
        if guard(&bytes) {
            elements.pass(bytes.get(before..).unwrap_or_default(), name)?;
        }
        if bytes.len() - before < BLOCK {
            return Ok(bytes);
        }
    }
}

/// Holds the elements of a text to their longest length.
pub fn hold(text: &[u8], name: &str) -> Result<(), ReadError> {
    let mut elements = Elements::default();
    text.chunks(BLOCK).try_for_each(|part| elements.pass(part, name))
}

/// Where in a text the last element begins, while parts of it go by.
#[derive(Default)]
struct Elements {
    passed: usize,
    last: usize,
}

impl Elements {
    /// Looks for the last begin in a part; one that is cut by its edge is missed, which makes an element a little longer.
    fn pass(&mut self, part: &[u8], name: &str) -> Result<(), ReadError> {
        if let Some(at) = element_begins(part).next_back() {
            self.last = self.passed + at;
        }
        self.passed += part.len();
        if self.passed - self.last > LONGEST_ELEMENT {
            let (name, offset) = (name.to_owned(), self.last);
            return Err(ReadError::LongElement { name, offset, most: LONGEST_ELEMENT });
        }
        Ok(())
    }
}

/// Where elements seem to begin in a text, in order.
pub(super) fn element_begins(text: &[u8]) -> impl DoubleEndedIterator<Item = usize> {
    let tags = text.iter().enumerate().filter(|(_, byte)| **byte == b'<').map(|(at, _)| at);
    tags.filter(|at| text.get(*at..).is_some_and(begins))
}

/// Whether a text opens with an element.
fn begins(text: &[u8]) -> bool {
    let named = |tag: &&[u8]| {
        text.strip_prefix(*tag).and_then(<[u8]>::first).is_some_and(|b| b.is_ascii_whitespace() || b"/>".contains(b))
    };
    [&b"<node"[..], b"<way", b"<relation"].iter().any(named)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: impl Read, most: u64) -> Result<usize, ReadError> {
        let failed = |source| ReadError::Io { path: "test".into(), source };
        read_within(text, "test", most, |_| true, failed).map(|bytes| bytes.len())
    }

    #[test]
    fn what_is_too_long_is_not_read_to_its_end() {
        let blanks = io::repeat(b' ');
        let long = read(io::Cursor::new(b"<osm> <node id=\"").chain(blanks), u64::MAX);
        assert!(matches!(long, Err(ReadError::LongElement { offset: 6, .. })), "{long:?}");
        let large = read(io::repeat(b'<').take(1 << 40), 10_000_000);
        assert!(matches!(large, Err(ReadError::TooLarge { most: 10_000_000, .. })), "{large:?}");
        let elements = "<node id=\"1\"/>\n".repeat(LONGEST_ELEMENT / 10);
        assert_eq!(read(elements.as_bytes(), u64::MAX).unwrap(), elements.len());
        hold(elements.as_bytes(), "test").unwrap();
        assert!(hold(&vec![b' '; LONGEST_ELEMENT + 1], "test").is_err());
    }

    #[test]
    fn elements_are_known_by_their_names() {
        for text in ["<node id='1'", "<way\n", "<relation/>", "<node>"] {
            assert!(begins(text.as_bytes()), "{text}");
        }
        for text in ["<nodes ", "<nd ", "<osm>", "node ", "<node"] {
            assert!(!begins(text.as_bytes()), "{text}");
        }
    }
}
