//! Findings held against those of an earlier report: new, the same, gone.

use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rustc_hash::{FxHashMap, FxHashSet};
use serde::Deserialize;

use super::data::{PageFinding, Status};
use super::plane::Frame;
use crate::geometry::Point;

/// Findings of one code closer than this are the same finding, though ids changed; degrees of latitude, about 2 m.
const SAME_PLACE: f64 = 2e-5;
/// More than this many bytes are no report of ours.
const LARGEST: u64 = 1 << 30;

/// What the page's data script opens with.
pub const DATA_MARK: &str = "<script type=\"application/octet-stream\" id=\"report-data\">";

/// What a comparison needs of an earlier report.
#[derive(Clone, Debug, PartialEq)]
pub struct Earlier {
    title: String,
    origin: [f64; 2],
    findings: Vec<PageFinding>,
}

/// Why a file is no earlier report.
#[derive(Debug, thiserror::Error)]
pub enum EarlierError {
    /// The data is not where reports have it.
    #[error("this is not a report that `lanewright check --report` wrote")]
    NoReport,
    /// The data cannot be read.
    #[error("the report's data is damaged: {0}")]
    Damaged(String),
}

#[derive(Deserialize)]
struct Data {
    title: String,
    frame: DataFrame,
    findings: Vec<PageFinding>,
}

#[derive(Deserialize)]
struct DataFrame {
    origin: [f64; 2],
}

impl Earlier {
    /// From the text of a report.
    ///
    /// # Errors
    ///
    /// If the text is no report, or its data is damaged.
    pub fn read(page: &str) -> Result<Self, EarlierError> {
        let damaged = |error: &dyn std::fmt::Display| EarlierError::Damaged(error.to_string());
        let (_, rest) = page.split_once(DATA_MARK).ok_or(EarlierError::NoReport)?;
        let (data, _) = rest.split_once('<').ok_or(EarlierError::NoReport)?;
        let packed = STANDARD.decode(data.trim()).map_err(|e| damaged(&e))?;
        let mut text = String::new();
        flate2::read::DeflateDecoder::new(packed.as_slice())
            .take(LARGEST)
            .read_to_string(&mut text)
            .map_err(|e| damaged(&e))?;
        let Data { title, frame, mut findings } = serde_json::from_str(&text).map_err(|e| damaged(&e))?;
        findings.retain(|f| f.status != Some(Status::Gone));
        Ok(Self { title, origin: frame.origin, findings })
    }

    /// How the earlier report calls its map.
    pub fn title(&self) -> &str {
        &self.title
    }
}

/// Marks every finding as new or the same, and adds those that are gone.
pub fn compare(findings: &mut Vec<PageFinding>, earlier: &Earlier, frame: &Frame) {
    let keys: FxHashSet<&str> = findings.iter().map(|f| f.key.as_str()).collect();
    let unmatched: Vec<&PageFinding> = earlier.findings.iter().filter(|old| !keys.contains(old.key.as_str())).collect();
    let old_keys: FxHashSet<&str> = earlier.findings.iter().map(|f| f.key.as_str()).collect();
    let mut places = Places::default();
    for (at, old) in unmatched.iter().enumerate() {
        places.add(old, at);
    }
    let mut taken = FxHashSet::default();
    for finding in findings.iter_mut() {
        let known =
            old_keys.contains(finding.key.as_str()) || places.find(finding, &taken).is_some_and(|at| taken.insert(at));
        finding.status = Some(if known { Status::Same } else { Status::New });
    }
    let left = unmatched.iter().enumerate().filter(|(at, _)| !taken.contains(at));
    let left: Vec<PageFinding> = left.map(|(_, old)| gone(old, earlier, frame)).collect();
    findings.extend(left);
}

/// An old finding moved into the new frame.
fn gone(old: &PageFinding, earlier: &Earlier, frame: &Frame) -> PageFinding {
    let shift = Point::from(earlier.origin) - frame.origin;
    let mut finding = old.clone();
    finding.status = Some(Status::Gone);
    finding.at = finding.at.map(|[x, y]| [x + shift.x, y + shift.y]);
    for pair in finding.place.iter_mut().flat_map(|(_, points)| points.chunks_exact_mut(2)) {
        if let [x, y] = pair {
            (*x, *y) = (*x + shift.x, *y + shift.y);
        }
    }
    finding
}

/// Findings by code and cell.
#[derive(Default)]
struct Places<'a> {
    cells: FxHashMap<(&'a str, i64, i64), Vec<usize>>,
}

fn cell([lat, lon]: [f64; 2]) -> (i64, i64) {
    ((lat / SAME_PLACE).floor() as i64, (lon / SAME_PLACE).floor() as i64)
}

impl<'a> Places<'a> {
    fn add(&mut self, finding: &'a PageFinding, at: usize) {
        if let Some(latlon) = finding.latlon {
            let (row, column) = cell(latlon);
            self.cells.entry((&finding.code, row, column)).or_default().push(at);
        }
    }

    /// The first not yet taken in the cell of the finding or beside it.
    fn find(&self, finding: &'a PageFinding, taken: &FxHashSet<usize>) -> Option<usize> {
        let (row, column) = cell(finding.latlon?);
        let beside = (-1..=1).flat_map(|i| (-1..=1).map(move |j| (row.saturating_add(i), column.saturating_add(j))));
        beside
            .filter_map(|(row, column)| self.cells.get(&(finding.code.as_str(), row, column)))
            .flatten()
            .copied()
            .find(|at| !taken.contains(at))
    }
}
