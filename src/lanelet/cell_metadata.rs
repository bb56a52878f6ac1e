//! `lanelet2_map_metadata.yaml` of a map that is divided into cells: which file covers which square.
//!
//! Autoware resolves the names in it against the directory of the yaml file, so that cells in a folder beside it are named with
//! the folder. Other tools write the bare names; those are found, too.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use saphyr_parser::{Event, Parser};

/// What Autoware calls the map in a map directory, a file or a folder of cells.
pub const MAP: &str = "lanelet2_map.osm";
/// What Autoware calls the list of a map's cells, beside the folder with the cells.
pub const METADATA: &str = "lanelet2_map_metadata.yaml";

/// What the list of a map's cells says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellMetadata {
    /// Width and height of every cell, metres.
    pub resolution: [f64; 2],
    /// The file of each cell, as written, and the lower left corner of its square: east and north, metres.
    pub cells: Vec<(String, [f64; 2])>,
}

/// Why Autoware cannot read the list of a map's cells.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {message}")]
pub struct MetadataError {
    /// From 1.
    pub line: usize,
    /// What is wrong.
    pub message: String,
}

impl CellMetadata {
    /// Writes the file from the width and height of a cell, metres, and what [`cells`](Self::cells) says of each; the cells lie in
    /// the folder that Autoware calls the map.
    ///
    /// # Errors
    ///
    /// Where `file` cannot be written.
    pub fn write(
        file: impl Write,
        [x, y]: [f64; 2],
        mut cells: impl Iterator<Item = (String, [f64; 2])>,
    ) -> io::Result<()> {
        let mut file = io::BufWriter::new(file);
        writeln!(file, "x_resolution: {x:?}\ny_resolution: {y:?}")?;
        cells.try_for_each(|(name, [x, y])| writeln!(file, "{MAP}/{name}: [{x:?}, {y:?}]"))?;
        file.flush()
    }

    /// Reads the text of the file.
    ///
    /// # Errors
    ///
    /// Where Autoware would not read it.
    pub fn read(text: &str) -> Result<Self, MetadataError> {
        let mut found = Self::default();
        for (line, key, values) in entries(text)? {
            let wrong = |message: String| MetadataError { line, message };
            let numbers: Vec<f64> = values.iter().filter_map(|value| number(value)).collect();
            match (key.as_str(), numbers.as_slice()) {
                ("x_resolution", [x]) if *x > 0.0 => found.resolution[0] = *x,
                ("y_resolution", [y]) if *y > 0.0 => found.resolution[1] = *y,
                ("x_resolution" | "y_resolution", _) => {
                    return Err(wrong(format!("`{key}` is not a length in metres")));
                }
                (_, &[x, y]) if values.len() == 2 => found.cells.push((key, [x, y])),
                _ => return Err(wrong(format!("`{key}` has no corner of its cell, such as [100.0, 200.0]"))),
            }
        }
        match found.resolution.iter().position(|length| *length == 0.0) {
            Some(at) => {
                let message = format!("`{}` is missing", ["x_resolution", "y_resolution"][at]);
                Err(MetadataError { line: 1, message })
            }
            None => Ok(found),
        }
    }

    /// The file that an entry names: as Autoware finds it, or in the folder of the cells. `None` where there is none.
    pub fn file(beside: &Path, cells: &Path, name: &str) -> Option<PathBuf> {
        let bare = Path::new(name).file_name()?;
        [beside.join(name), cells.join(bare)].into_iter().find(|file| file.is_file())
    }
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|number: &f64| number.is_finite())
}

/// The keys of the outermost level with their lines and values.
fn entries(text: &str) -> Result<Vec<(usize, String, Vec<String>)>, MetadataError> {
    let (mut found, mut depth) = (Vec::new(), 0_usize);
    let mut open: Option<(usize, String, Vec<String>)> = None;
    for event in Parser::new_from_str(text.trim_start_matches('\u{feff}')) {
        let (event, span) = event.map_err(|error| MetadataError {
            line: error.marker().line(),
            message: format!("this is not YAML: {}", error.info()),
        })?;
        match event {
            Event::MappingStart(..) | Event::SequenceStart(..) => depth += 1,
            Event::MappingEnd | Event::SequenceEnd => {
                depth = depth.saturating_sub(1);
                found.extend(open.take_if(|_| depth == 1));
            }
            Event::Scalar(value, ..) => match &mut open {
                Some((_, _, values)) => {
                    values.push(value.into_owned());
                    found.extend(open.take_if(|_| depth == 1));
                }
                None if depth == 1 => open = Some((span.start.line(), value.into_owned(), Vec::new())),
                None => {
                    let message = "expected the key of a cell or a resolution".to_owned();
                    return Err(MetadataError { line: span.start.line(), message });
                }
            },
            _ => {}
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_and_resolves_from_the_yaml_file() {
        let cells = vec![("-100_0.osm".to_owned(), [-100.0, 0.0]), ("0_0.osm".to_owned(), [0.0, 0.0])];
        let mut text = Vec::new();
        CellMetadata::write(&mut text, [100.0, 100.0], cells.into_iter()).unwrap();
        let text = String::from_utf8(text).unwrap();
        assert_eq!(
            text,
            "x_resolution: 100.0\ny_resolution: 100.0\nlanelet2_map.osm/-100_0.osm: [-100.0, 0.0]\n\
             lanelet2_map.osm/0_0.osm: [0.0, 0.0]\n"
        );
        let read = CellMetadata::read(&text).unwrap();
        assert_eq!(read.resolution, [100.0, 100.0]);
        assert_eq!(read.cells[0], ("lanelet2_map.osm/-100_0.osm".to_owned(), [-100.0, 0.0]));
    }

    #[test]
    fn bare_names_quotes_and_comments_are_read() {
        let text = "# cells\nx_resolution: 50\ny_resolution: 20.5\n\"1.osm\": [58700.0, 42500.0] # one\n2.osm:\n  - 1\n  - 2\n";
        let read = CellMetadata::read(text).unwrap();
        assert_eq!(read.resolution, [50.0, 20.5]);
        assert_eq!(read.cells, [("1.osm".to_owned(), [58700.0, 42500.0]), ("2.osm".to_owned(), [1.0, 2.0])]);
    }

    #[test]
    fn errors_say_what_and_where() {
        let says = |text: &str| CellMetadata::read(text).unwrap_err().to_string();
        assert_eq!(says("x_resolution: 100.0\n0_0.osm: [0.0, 0.0]\n"), "line 1: `y_resolution` is missing");
        assert_eq!(says("x_resolution: wide\n"), "line 1: `x_resolution` is not a length in metres");
        assert_eq!(
            says("x_resolution: 1\ny_resolution: 1\n0_0.osm: 3\n"),
            "line 3: `0_0.osm` has no corner of its cell, such as [100.0, 200.0]"
        );
        assert!(says("a: [1").contains(": this is not YAML"), "{}", says("a: [1"));
        assert!(says("").contains("missing"));
    }
}
