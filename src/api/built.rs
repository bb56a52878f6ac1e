//! A map that was built, and the files that it becomes.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use crate::builder::{Built, build_plan, uncontested};
use crate::cells::Divided;
use crate::lanelet::{self, INFO, MAP};
use crate::projection::{VerticalDatum, write_info};
use crate::report::failure::Failure;
use crate::settings::Settings;

use super::config::NAME;
use super::divided::{division_error, grid, into_draft};
use super::error::{Error, ErrorKind};
use super::files::Draft;
use super::layout::{Layout, LayoutOptions};
use super::own_output::{SETTINGS_HEAD, spare, spare_settings, write_known};
use super::{InMemory, Input};

/// A map that was built, with what goes beside it.
#[derive(Debug)]
pub struct BuiltMap {
    /// The map, its projector, what it cannot say itself, and what was guessed.
    pub built: Built,
}

impl BuiltMap {
    /// The map that streets become.
    pub fn of(layout: Layout) -> Self {
        Self { built: build_plan(layout.plan) }
    }

    /// The map that an input becomes by way of its streets, which `lay_out` lays out: once more where elements want the same id.
    ///
    /// # Errors
    ///
    /// As `lay_out` has it.
    pub fn uncontested<E>(
        options: &LayoutOptions,
        mut lay_out: impl FnMut(&LayoutOptions) -> Result<Layout, E>,
    ) -> Result<Self, E> {
        let built = uncontested(&options.contested, |contested| {
            let options = LayoutOptions { contested: contested.clone(), ..options.clone() };
            lay_out(&options).map(|layout| build_plan(layout.plan))
        });
        built.map(|built| Self { built })
    }

    /// Writes `lanelet2_map.osm`.
    ///
    /// # Errors
    ///
    /// Where `out` fails.
    pub fn write_osm(&self, out: impl Write + Send) -> std::io::Result<()> {
        lanelet::to_osm(&self.built.map, &self.built.projector, out)
    }

    /// The text of `map_projector_info.yaml`.
    pub fn projector_info(&self) -> String {
        write_info(&self.built.projector, VerticalDatum::default())
    }

    /// The text of `lanewright.toml`.
    ///
    /// # Errors
    ///
    /// Where TOML cannot say what is known of the map, which would be a fault of ours.
    pub fn settings(&self) -> Result<String, Error> {
        settings_text(&self.built.settings)
    }

    /// Writes the three files of a map into a directory, made if it is not there, all or none.
    ///
    /// # Errors
    ///
    /// Where they cannot be written, or would take the place of settings that no build has written, or, unless `force` is given, of
    /// a map that no run has written, or that was changed since.
    pub fn write(&self, directory: &Path, force: bool) -> Result<(), Error> {
        spare(directory, force)?;
        let (info, settings) = (self.projector_info(), self.settings()?);
        let write = || -> Result<(), Failure> {
            let mut draft = Draft::new(directory)?;
            let map = write_known(&mut draft, MAP, |file| self.write_osm(file))?;
            let info = write_known(&mut draft, INFO, |file| file.write_all(info.as_bytes()))?;
            draft.write(NAME, |file| file.write_all(format!("{settings}{map}{info}").as_bytes()))?;
            draft.publish()
        };
        write().map_err(ErrorKind::Write.of())
    }

    /// Writes the files of a map that is divided into cells with sides of this length, whole metres, all or none.
    ///
    /// # Errors
    ///
    /// As [`BuiltMap::write`], and where the directory holds a map already.
    pub fn write_cells(&self, directory: &Path, size: u32) -> Result<Divided, Error> {
        spare_settings(directory)?;
        let grid = grid(size)?;
        let (info, settings) = (self.projector_info(), self.settings()?);
        let write = |failure| ErrorKind::Write.error(failure);
        let mut draft = Draft::new(directory).map_err(write)?;
        // Divided from its text, as any map is: so cells are the same whether the map was written before or not.
        let whole = draft.scratch("whole.osm").map_err(write)?;
        File::create(&whole).and_then(|file| self.write_osm(file)).map_err(|error| {
            let failure = Failure::new(format!("cannot write the map into {}: {error}", directory.display()));
            write(failure.help("nothing was changed; check the place's permissions and free space"))
        })?;
        let (files, projector) = ([whole], Some(self.built.projector));
        let divided = into_draft(&mut draft, &files, projector, grid, &|_| ())
            .map_err(|error| division_error(directory, error))?;
        let rest = || -> Result<(), Failure> {
            draft.write(INFO, |file| file.write_all(info.as_bytes()))?;
            draft.write(NAME, |file| file.write_all(settings.as_bytes()))?;
            draft.publish()
        };
        rest().map_err(write)?;
        Ok(divided)
    }

    /// The map as an input for [`check`](crate::check()) and [`fix`](crate::fix()), by this name in messages.
    ///
    /// # Errors
    ///
    /// See [`BuiltMap::settings`].
    pub fn to_input(&self, name: &str) -> Result<Input, Error> {
        let mut bytes = Vec::new();
        self.write_osm(&mut bytes)
            .map_err(|error| ErrorKind::Internal.error(Failure::new(format!("the map cannot be written: {error}"))))?;
        Ok(Input::Bytes(InMemory {
            name: name.to_owned(),
            bytes,
            projector_info: Some(self.projector_info()),
            settings: Some(self.settings()?),
        }))
    }
}

/// The text of `lanewright.toml`.
pub(super) fn settings_text(settings: &Settings) -> Result<String, Error> {
    let settings = toml::to_string(settings)
        .map_err(|error| ErrorKind::Internal.error(Failure::new(format!("the settings cannot be written: {error}"))))?;
    Ok(format!("{SETTINGS_HEAD}{settings}"))
}
