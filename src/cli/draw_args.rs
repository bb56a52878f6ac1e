//! The arguments of `draw`.

use std::path::PathBuf;

use crate::api::Loaded;
use crate::lanelet::LaneletId;
use crate::lanelet::index::extent;
use crate::projection::LonLat;
use crate::report::draw::Focus;
use crate::report::failure::Failure;

use super::args::{output_file, place};
use super::check_args::SeverityArg;
use super::planner::ParameterArgs;
use clap::{Args, ValueEnum};

/// Draw a Lanelet2 map as SVG or PNG, with its findings, or its lines as GeoJSON; or the steps of `build`
#[derive(Debug, Args)]
pub struct DrawArgs {
    /// A .osm file, a directory of .osm files, or a map directory with map_projector_info.yaml; with --stage what
    /// `build` reads
    #[arg(required_unless_present = "compare")]
    pub map: Option<PathBuf>,
    /// The picture: .svg or .png; or .geojson: each line as it is painted, and the outlines of the lanelets; - for SVG on
    /// standard output
    #[arg(short, long, value_name = "FILE", value_parser = output_file)]
    pub output: PathBuf,
    /// Draw a stage of `build` instead of a map, with the points that decided
    #[arg(long, value_enum, value_delimiter = ',')]
    pub stage: Vec<StageArg>,
    /// Draw every intersection by itself, all stages that are given, into a directory with a page to look through
    #[arg(long, requires = "stage", conflicts_with_all = ["compare", "around", "at"])]
    pub each: bool,
    /// Draw two versions side by side and list the intersections that changed: two maps, or two files of streets
    #[arg(long, num_args = 2, value_names = ["OLD", "NEW"], conflicts_with = "map")]
    pub compare: Option<Vec<PathBuf>>,
    /// Draw what lies around this place
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true, conflicts_with = "around")]
    pub at: Option<(f64, f64)>,
    /// How far around the place, or the lanelet of --planner, metres
    #[arg(long, value_name = "M", default_value_t = 60.0)]
    pub radius: f64,
    /// Draw what lies around the primitive with this id; of a stage, around an OpenStreetMap node or way
    #[arg(long, value_name = "ID", allow_hyphen_values = true)]
    pub around: Option<i64>,
    /// Pixels per metre; without it, whatever fits a screen
    #[arg(long, value_name = "PX")]
    pub scale: Option<f64>,
    /// Write the ids of lanelets, intersection areas and regulatory elements, where they fit
    #[arg(long)]
    pub ids: bool,
    /// Least severity of findings that are drawn
    #[arg(long, value_enum, value_name = "SEVERITY", default_value_t = SeverityArg::Warning, conflicts_with = "no_findings")]
    pub show: SeverityArg,
    /// Leave out the findings of `check`
    #[arg(long)]
    pub no_findings: bool,
    /// Draw what Autoware's planner will do on this lanelet, without the findings: whom it watches and ignores, where it stops
    #[arg(long, value_name = "ID", allow_hyphen_values = true, conflicts_with_all = ["stage", "compare"])]
    pub planner: Vec<i64>,
    #[command(flatten)]
    pub parameters: ParameterArgs,
}

impl DrawArgs {
    /// The part of the map that the arguments ask for.
    pub fn focus(&self, loaded: &Loaded) -> Result<Focus, Failure> {
        if let Some(id) = self.around {
            return Ok(Focus::Primitive(id));
        }
        if let (None, Some(&id)) = (self.at, self.planner.first()) {
            let outline = loaded.map.lanelets.get(LaneletId(id)).map(|lanelet| loaded.map.outline(lanelet));
            let [low, high] = extent(&outline.unwrap_or_default());
            return Ok(Focus::Around(nalgebra::center(&low, &high), self.radius));
        }
        let Some((lat, lon)) = self.at else { return Ok(Focus::Whole) };
        let place = loaded.projector.forward(LonLat { lon, lat }, 0.0).ok_or_else(|| {
            Failure::new(format!("the projection {} of this map does not reach {lat},{lon}", loaded.projector.name()))
                .help("use --around ID")
        })?;
        Ok(Focus::Around(place, self.radius))
    }
}

/// The stages of `build` that can be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StageArg {
    /// Each road with its edges
    Thicken,
    /// Where the edges collide
    Collide,
    /// How far each road is cut back
    Trim,
    /// The outlines of the intersections
    Outline,
    /// Which roads lie inside an intersection, and why
    Consolidate,
    /// The cross-section of each road
    Lanes,
    /// Who drives where: the lanelets of the map
    Movements,
}

impl StageArg {
    /// The word on the command line.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}
