//! The sample OpenDRIVE file, damaged as the bytes say, or any bytes as OpenDRIVE: read, built and written. The first byte chooses.

#![no_main]

use lanewright::builder::{BuildOptions, Placing, build_opendrive};
use lanewright::lanelet::to_osm;
use lanewright::xodr::read;
use libfuzzer_sys::fuzz_target;

const SAMPLE: &str = include_str!("../../sample_maps/survey_right.xodr");
/// What stands in the place of a number or a word.
const VALUES: [&str; 10] = ["NaN", "-1", "0", "1e9", "1e-9", "inf", "", "start", "9999", "\"/><lane id=\"1\" type=\"driving\"/><x y=\""];

/// The seed with the value of one attribute replaced, or a piece taken out, for each four bytes.
fn damaged(seed: &str, bytes: &[u8]) -> String {
    let mut text = seed.to_owned();
    for four in bytes.chunks_exact(4).take(10) {
        let at = usize::from(u16::from_le_bytes([four[0], four[1]])) % text.len().max(1);
        let Some(begin) = text[at..].find("=\"").map(|found| at + found + 2) else { continue };
        let Some(end) = text[begin..].find('"').map(|found| begin + found) else { continue };
        match usize::from(four[2]) % 16 {
            0 => text.replace_range(begin..(end + usize::from(four[3])).min(text.len()), ""),
            _ => text.replace_range(begin..end, VALUES[usize::from(four[3]) % VALUES.len()]),
        }
    }
    text
}

fuzz_target!(|bytes: &[u8]| {
    let Some((&choice, bytes)) = bytes.split_first() else { return };
    let text = if choice % 4 > 0 { Some(damaged(SAMPLE, bytes)) } else { String::from_utf8(bytes.to_vec()).ok() };
    let Some(Ok(file)) = text.map(|text| read(&text)) else { return };
    if let Ok(built) = build_opendrive(&file, &BuildOptions::default(), Placing::default()) {
        to_osm(&built.map, &built.projector, std::io::sink()).expect("a sink takes everything");
    }
});
