//! OpenDRIVE as an input of `build`: the file's own lanes become the map.

use std::fs::File;
use std::io::Read;

use crate::builder::{Placing, build_opendrive};
use crate::projection::{LonLat, Projector};
use crate::report::failure::Failure;
use crate::xodr::{XodrError, is_opendrive, read};

use super::built::BuiltMap;
use super::error::{Error, ErrorKind};
use super::layout::{LayoutOptions, asked, build_failure, projector};
use super::{InMemory, Input};

/// Bytes of a file by which its format is told.
const HEAD: u64 = 1 << 16;

impl Input {
    /// Whether it is OpenDRIVE, by its first bytes. One that cannot be read is none: reading it tells why.
    pub fn is_opendrive(&self) -> bool {
        match self {
            Self::Bytes(InMemory { bytes, .. }) => is_opendrive(bytes),
            Self::Path(path) => {
                let mut head = Vec::new();
                // Pipes can be read only once.
                let file = File::open(path).ok().filter(|file| file.metadata().is_ok_and(|about| about.is_file()));
                let read = file.is_some_and(|file| file.take(HEAD).read_to_end(&mut head).is_ok());
                read && is_opendrive(&head)
            }
        }
    }
}

impl BuiltMap {
    /// The map of an OpenDRIVE file.
    ///
    /// # Errors
    ///
    /// Where the file or settings cannot be read, and where it has no lane for vehicles.
    pub fn of_opendrive(input: impl Into<Input>, options: &LayoutOptions, tell: &dyn Fn(&str)) -> Result<Self, Error> {
        let input = input.into();
        let name = input.name();
        tell(&format!("reading {name}"));
        let (bytes, build) = asked(input, options)?;
        if options.dem.is_some() {
            let failure = Failure::new(format!("{name} has heights of its own")).about(&name);
            return Err(ErrorKind::Build.error(failure.help("leave --dem out")));
        }
        let text = String::from_utf8(bytes).map_err(|_| {
            let failure = Failure::new(format!("{name} is not UTF-8")).about(&name);
            ErrorKind::Read.error(failure.help("OpenDRIVE is XML in UTF-8; export it again"))
        })?;
        let file = read(&text).map_err(|error| ErrorKind::Read.error(unread(error, &name, &text)))?;
        drop(text);
        tell(&format!("building {name}"));
        let origin = options.origin.map(|[lat, lon]| LonLat { lon, lat });
        if let Some(kind) = options.projector {
            // What no place can have is told before.
            projector(kind, LonLat::default())?;
            if origin.is_none() && file.header.plane.georeference.is_none() {
                let failure = Failure::new(format!("{name} does not say where on earth it lies")).about(&name);
                return Err(ErrorKind::Build.error(failure.help("say it: --origin LAT,LON of the file's origin")));
            }
        }
        let wanted = |middle: LonLat| {
            let kind = options.projector.and_then(|kind| projector(kind, middle).ok());
            kind.unwrap_or(Projector::transverse_mercator(middle))
        };
        let wanted: &(dyn Fn(LonLat) -> Projector + Sync) = &wanted;
        let placing = Placing { origin, wanted: options.projector.map(|_| wanted) };
        let built = build_opendrive(&file, &build, placing);
        built.map(|built| Self { built }).map_err(|error| ErrorKind::Build.error(build_failure(error, &name)))
    }
}

fn unread(error: XodrError, name: &str, text: &str) -> Failure {
    Failure::new(format!("{name}: {error}")).help(error.help()).at(name, text, error.offset())
}
