//! A map in another projection, and the directory that it becomes.

use std::fs;
use std::io::Write;
use std::path::Path;

use super::config::NAME;
use super::error::{Error, ErrorKind};
use super::files::Draft;
use super::load::home;
use super::own_output::{spare_files, without_hashes, write_known};
use crate::lanelet::INFO;
use crate::report::failure::Failure;

/// Where a converted map goes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Converted<'a> {
    /// The directory, made if it is not there.
    pub directory: &'a Path,
    /// Whether maps are written over that no run has written, or that were changed since.
    pub force: bool,
    /// Names of the map's files.
    pub names: &'a [String],
}

impl Converted<'_> {
    /// Refuses to write over files that no run has written: to be asked before the work begins.
    pub fn spare(&self) -> Result<(), Error> {
        let names: Vec<&str> = self.names.iter().map(String::as_str).chain([INFO]).collect();
        if self.force { Ok(()) } else { spare_files(self.directory, &names) }
    }

    /// Writes the files with these texts, the projector's, and settings that know them again, all or none: those that are there
    /// already, or else those beside the map that was converted.
    pub fn write(&self, map: &Path, texts: &[String], info: &str) -> Result<(), Error> {
        self.spare()?;
        let read = |directory: &Path| fs::read_to_string(directory.join(NAME)).ok();
        let mut settings = without_hashes(&read(self.directory).or_else(|| read(home(map))).unwrap_or_default());
        if !settings.is_empty() && !settings.ends_with('\n') {
            settings.push('\n');
        }
        let mut write = || -> Result<(), Failure> {
            let mut draft = Draft::new(self.directory)?;
            let texts = self.names.iter().map(String::as_str).zip(texts.iter().map(String::as_str));
            for (name, text) in texts.chain([(INFO, info)]) {
                settings += &write_known(&mut draft, name, |file| file.write_all(text.as_bytes()))?;
            }
            draft.write(NAME, |file| file.write_all(settings.as_bytes()))?;
            draft.publish()
        };
        write().map_err(ErrorKind::Write.of())
    }
}
