//! Room for OpenDRIVE: the lanes of a survey become lanelets between the file's own borders; what makes them intersections is the code
//! that serves all maps.

mod area_needed;
mod contacts;
mod crosswalks;
mod hung_lights;
mod junctions;
mod lane_use;
mod lanes;
mod lights;
mod lines;
mod marks;
mod nodes;
mod plane;
mod ranks;
mod runs;
mod sampling;
mod scene;
mod shapes;
mod signal_use;
mod signals;
mod stop_lines;
mod stretches;
mod too_many_points;
mod unlinked;
mod wrong_ends;

use crate::diagnostic::{Finding, Severity};
use crate::geometry::Point;
use crate::projection::{LonLat, Projector};
use crate::settings::{Settings, Side};
use crate::xodr::{JunctionKind, OpenDrive};

use super::assemble::Assembled;
use super::map::map_builder::{MapBuilder, MapPart};
use super::options::BuildOptions;
use super::tags::road_class::DrivingSide;

use plane::Plane;
use scene::Scene;
pub use scene::{FileLane, note};
use stretches::{CutRoad, Stretch};

/// Where a file lies that does not say it, and the projector that the user wants.
#[derive(Clone, Copy, Default)]
pub struct Placing<'a> {
    /// Where the file's origin lies.
    pub origin: Option<LonLat>,
    /// The projector that the user wants, given a place in the middle of the file.
    pub wanted: Option<&'a (dyn Fn(LonLat) -> Projector + Sync)>,
}

/// Builds the map of a file; also gives its projector, and where its lanelets stand in the file.
pub fn assemble_opendrive(
    file: &OpenDrive,
    options: &BuildOptions,
    placing: Placing,
) -> (Assembled, Projector, Vec<FileLane>) {
    let starts = file.roads.iter().flat_map(|road| road.plan.records()).map(|record| record.origin);
    let wanted = placing.wanted.map(|wanted| wanted as &dyn Fn(LonLat) -> Projector);
    let plane = Plane::new(file, &starts.collect::<Vec<Point>>(), placing.origin, wanted);
    let kind = |junction: &str| file.junctions.iter().find(|it| it.id == junction).map(|it| it.kind);
    let of_junction = file.roads.iter().map(|road| road.junction.as_ref().and_then(|junction| kind(junction)));
    let connecting: Vec<bool> = of_junction.map(|kind| kind == Some(JunctionKind::Common)).collect();
    let mut too_many = Vec::new();
    let with_room = too_many_points::roads_with_room(file, &mut too_many);
    let drawable =
        |index: usize| with_room[index] && !file.roads[index].plan.is_empty() && file.roads[index].length > 0.0;
    let cut: Vec<CutRoad> = (0..file.roads.len())
        .map(|index| if drawable(index) { stretches::cut(file, index, connecting[index]) } else { CutRoad::default() })
        .collect();
    let first: Vec<usize> = cut
        .iter()
        .scan(0, |count, road| {
            let first = *count;
            *count += road.stretches.len();
            Some(first)
        })
        .collect();
    let stretches: Vec<&Stretch> = cut.iter().flat_map(|road| &road.stretches).collect();
    let scene = Scene { file, plane: &plane, cut: &cut, first: &first, stretches, connecting: &connecting };
    let mut assembly = MapBuilder::new(options.contested.clone());
    let mut drawn = lanes::draw(&mut assembly, &scene, &options.beside);
    let mut whole = Assembled { roads: file.roads.len(), ..Assembled::default() };
    whole.notes = file.oddities.iter().map(|it| note("opendrive-odd", it.line, it.message.clone())).collect();
    whole.notes.append(&mut too_many);
    if plane.from_origin {
        let message =
            "the places are no metres of UTM: they are taken for metres from lat_0 and lon_0 of the georeference";
        whole.notes.push(note("opendrive-odd", file.header.line, message.to_owned()).graded(Severity::Warning));
    }
    if plane.offset_turned {
        let message =
            "the header's offset leads off the part of the earth that the georeference is for: it is subtracted";
        whole.notes.push(note("opendrive-odd", file.header.line, message.to_owned()).graded(Severity::Warning));
    }
    if file.header.plane.on_geoid {
        let message = "heights are above the geoid that the georeference names; they stay as they are".to_owned();
        whole.notes.push(note("opendrive-heights", file.header.line, message).graded(Severity::Info));
    }
    whole.notes.append(&mut drawn.notes);
    let left_hand = file.roads.iter().filter(|road| road.left_hand).count() * 2 > file.roads.len();
    let side = if left_hand { DrivingSide::Left } else { DrivingSide::Right };
    let furniture = signals::furniture(&scene, &drawn);
    let made = junctions::draw(&mut assembly, &scene, &drawn, &furniture, side);
    let mut signs = lights::Drawing::new(&scene, &drawn, &furniture);
    signs.draw(&mut assembly, |lane| made.in_area.contains(&lane), &made.lit);
    whole.areas = made.areas;
    whole.notes.extend(made.notes.into_iter().chain(signs.notes));
    whole.notes.extend(crosswalks::draw(&mut assembly, &scene, &drawn, &furniture));
    whole.settings = Settings { intersection: made.settings, loose_ends: made.loose_ends, ..Settings::default() };
    whole.settings.driving_side = Some(if left_hand { Side::Left } else { Side::Right });
    whole.map = assembly.finish(MapPart::default());
    (whole, plane.projector, drawn.in_file(&scene))
}

/// The notes that are guesses: values that the file does not say.
pub fn guesses(notes: &[Finding]) -> usize {
    notes.iter().filter(|note| note.severity == Some(Severity::Info)).count()
}
