//! Roads, their lane sections and lanes, and where the borders of lanes lie.

use crate::text::Text;

use super::cubic::Cubics;
use super::furniture::{Object, Signal, SignalReference};
use super::plan_view::PlanView;
use super::surface::{LaneHeights, Shapes};

/// A place in the file's own metres: east, north, height.
pub type Place = [f64; 3];

/// Which end of a road.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RoadEnd {
    /// Where the station is 0.
    Start,
    /// Where the station is the road's length.
    End,
}

/// What a road is linked to at an end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RoadLink {
    /// Another road, and its end that meets this one; without it, the nearer one.
    Road(Text, Option<RoadEnd>),
    /// A junction.
    Junction(Text),
}

/// A road.
#[derive(Clone, Debug, Default)]
pub struct Road {
    /// Its id: any text.
    pub id: Text,
    /// The line on which it stands, from 1.
    pub line: usize,
    /// Metres.
    pub length: f64,
    /// The junction of which it is a connecting road.
    pub junction: Option<Text>,
    /// Whether people drive on the left.
    pub left_hand: bool,
    /// What it is linked to at its start and at its end.
    pub links: [Option<RoadLink>; 2],
    /// The reference line.
    pub plan: PlanView,
    /// Heights of the reference line, metres.
    pub elevation: Cubics,
    /// Roll of the cross-section, radians: positive falls to the right.
    pub superelevation: Cubics,
    /// What its surface adds to the plane that the roll gives.
    pub shapes: Shapes,
    /// Offset of the lanes from the reference line, metres, to the left.
    pub lane_offset: Cubics,
    /// Stations from which on a speed limit holds, with the limit, km/h; `None`: no limit is said.
    pub speeds: Vec<(f64, Option<f64>)>,
    /// The kind of road where it begins: `town`, `motorway`, ...
    pub kind: Text,
    /// In order along the road; none is empty of length but micro sections exist.
    pub sections: Vec<Section>,
    /// In order of the file.
    pub signals: Vec<Signal>,
    /// Signals of other roads that hold here, too.
    pub references: Vec<SignalReference>,
    /// In order of the file.
    pub objects: Vec<Object>,
}

/// A part of a road with the same lanes all along.
#[derive(Clone, Debug, Default)]
pub struct Section {
    /// The stations between which it lies, metres.
    pub span: [f64; 2],
    /// By falling id: from the leftmost lane to the rightmost one, without the centre lane.
    pub lanes: Vec<Lane>,
    /// The paint on the centre lane.
    pub centre_marks: Vec<RoadMark>,
}

/// A lane of a section.
#[derive(Clone, Debug, Default)]
pub struct Lane {
    /// Positive on the left of the reference line, negative on the right.
    pub id: i64,
    /// `driving`, `sidewalk`, ...
    pub kind: Text,
    /// Whether its direction is said to be the other one.
    pub reversed: bool,
    /// Whether it is driven in both directions.
    pub both_ways: bool,
    /// Its width; the parameter is the distance from the begin of the section.
    pub widths: Cubics,
    /// Offset of its outer border from the centre lane, in place of widths.
    pub borders: Cubics,
    /// What its surface adds to that of the road.
    pub heights: LaneHeights,
    /// Lanes that it continues, at its start and at its end.
    pub links: [Vec<i64>; 2],
    /// Speed limits, km/h, by the distance from the begin of the section from which on they hold.
    pub speeds: Vec<(f64, Option<f64>)>,
    /// The paint on its outer border.
    pub marks: Vec<RoadMark>,
    /// Who may drive on it, where that is said: `allow` or `deny` with the word.
    pub access: Vec<(bool, Text)>,
}

/// Paint along a border from a station on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RoadMark {
    /// Distance from the begin of the section, metres.
    pub start: f64,
    /// `solid`, `broken`, `solid broken`, `none`, `curb`, ...
    pub kind: Text,
    /// `standard`, `white`, `yellow`, ...
    pub color: Text,
    /// `bold`, or empty.
    pub weight: Text,
    /// `increase`, `decrease`, `both`, `none`, or empty.
    pub lane_change: Text,
}

/// A station at a joint belongs to both parts; this share of a part's length, at most a micrometre, tells which is meant.
const ONE_SIDED: f64 = 1e-3;
const MICROMETRE: f64 = 1e-6;

impl Section {
    /// Metres.
    pub fn length(&self) -> f64 {
        self.span[1] - self.span[0]
    }

    /// The lane of an id.
    pub fn lane(&self, id: i64) -> Option<&Lane> {
        self.lanes.iter().find(|lane| lane.id == id)
    }

    /// Where to pick polynomials for a station, so that the ends have the limits from inside.
    fn pick(&self, station: f64) -> f64 {
        let [from, to] = self.span;
        let inside = (self.length() * ONE_SIDED).min(MICROMETRE);
        station.max(from + inside).min(to - inside)
    }

    /// The offset from the reference line of the outer border of a lane at a station, metres, to the left; 0 is the centre lane.
    pub fn offset(&self, road: &Road, border: i64, station: f64) -> f64 {
        self.offset_of_wide(road, border, station, |_| f64::NEG_INFINITY)
    }

    /// The same where lanes are taken to be no narrower than `least` says of them, metres.
    pub fn offset_of_wide(&self, road: &Road, border: i64, station: f64, least: impl Fn(i64) -> f64) -> f64 {
        let pick = self.pick(station);
        let centre = road.lane_offset.at(station, pick);
        let (own, own_pick) = (station - self.span[0], pick - self.span[0]);
        let side = border.signum() as f64;
        let mut at = centre;
        // From the centre outward: they are in order of falling ids.
        let outward = |lane: &&Lane| lane.id.signum() == border.signum() && lane.id.abs() <= border.abs();
        let inside: &mut dyn Iterator<Item = &Lane> = if border > 0 {
            &mut self.lanes.iter().rev().filter(outward)
        } else {
            &mut self.lanes.iter().filter(outward)
        };
        for lane in inside {
            let width = if !lane.widths.is_empty() {
                lane.widths.at(own, own_pick)
            } else if !lane.borders.is_empty() {
                lane.borders.at(own, own_pick).abs() - side * (at - centre)
            } else {
                0.0
            };
            at += side * width.max(least(lane.id));
        }
        at
    }

    /// The width of a lane at a station, metres.
    pub fn width(&self, road: &Road, lane: i64, station: f64) -> f64 {
        if let Some(lane) = self.lane(lane).filter(|lane| !lane.widths.is_empty()) {
            return lane.widths.at(station - self.span[0], self.pick(station) - self.span[0]);
        }
        let side = lane.signum() as f64;
        side * (self.offset(road, lane, station) - self.offset(road, inner(lane), station))
    }

    /// The height of a border at a station above the surface of the road, metres: that of a lane beside it that `counts`, else of the
    /// lane on the side of the centre.
    pub fn lift(&self, border: i64, station: f64, counts: impl Fn(i64) -> bool) -> f64 {
        let (own, behind) = if border == 0 { (-1, 1) } else { (border, border + border.signum()) };
        let at = |id: i64| {
            let lane = self.lane(id).filter(|_| counts(id))?;
            Some(lane.heights.at(station - self.span[0], id == border))
        };
        at(own)
            .or_else(|| at(behind))
            .or_else(|| Some(self.lane(own)?.heights.at(station - self.span[0], own == border)))
            .unwrap_or(0.0)
    }

    /// The paint of a border at a station; `None` where nothing is said.
    pub fn mark(&self, border: i64, station: f64) -> Option<&RoadMark> {
        let marks = match border {
            0 => &self.centre_marks,
            _ => &self.lane(border)?.marks,
        };
        let own = self.pick(station) - self.span[0];
        marks.iter().rev().find(|mark| mark.start <= own).or(marks.first())
    }
}

/// The border on the side of the centre of a lane.
pub fn inner(lane: i64) -> i64 {
    lane - lane.signum()
}

impl Road {
    /// The place at a station and an offset to the left of the reference line, both in metres.
    pub fn place(&self, station: f64, offset: f64) -> Place {
        let at = self.plan.at(station);
        let roll = self.superelevation.at(station, station);
        let (sin, cos) = at.angle.sin_cos();
        let across = offset * roll.cos();
        [
            at.point.x - sin * across,
            at.point.y + cos * across,
            self.elevation.at(station, station) + offset * roll.sin() + self.shapes.at(station, offset),
        ]
    }

    /// The direction of the reference line at a station, radians.
    pub fn angle(&self, station: f64) -> f64 {
        self.plan.at(station).angle
    }

    /// The section in which a station lies, by index: the last one that begins there or before.
    pub fn section_at(&self, station: f64) -> usize {
        let begins = |section: &&Section| section.span[0] <= station + 1e-9 && section.length() > 0.0;
        let found = self.sections.iter().enumerate().rfind(|(_, section)| begins(section));
        found.map_or(0, |(i, _)| i)
    }

    /// The speed limit of a lane at a station, km/h: its own, else that of the road.
    pub fn speed(&self, section: &Section, lane: &Lane, station: f64) -> Option<f64> {
        let own = lane.speeds.iter().rev().find(|(start, _)| section.span[0] + start <= station + 1e-9);
        let of_road = || self.speeds.iter().rev().find(|(start, _)| *start <= station + 1e-9);
        own.and_then(|(_, limit)| *limit).or_else(|| of_road().and_then(|(_, limit)| *limit))
    }

    /// The directions in which a lane is driven: 1 along the road, -1 against it.
    pub fn directions(&self, lane: &Lane) -> &'static [i8] {
        let along = ((lane.id < 0) != self.left_hand) != lane.reversed;
        match (along, lane.both_ways) {
            (true, false) => &[1],
            (false, false) => &[-1],
            (true, true) => &[1, -1],
            (false, true) => &[-1, 1],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::cubic::Cubic;
    use super::super::plan_view::{PlanRecord, Shape};
    use super::*;
    use crate::geometry::Point;

    fn constant(value: f64) -> Cubics {
        Cubics::new(vec![Cubic { start: 0.0, factors: [value, 0.0, 0.0, 0.0] }])
    }

    fn lane(id: i64, width: f64) -> Lane {
        Lane { id, widths: constant(width), ..Lane::default() }
    }

    fn road() -> Road {
        let record =
            PlanRecord { start: 0.0, origin: Point::origin(), heading: 0.0, length: 100.0, shape: Shape::Line };
        Road {
            length: 100.0,
            plan: PlanView::new(vec![record]),
            elevation: Cubics::new(vec![Cubic { start: 0.0, factors: [5.0, 0.1, 0.0, 0.0] }]),
            lane_offset: constant(0.5),
            sections: vec![Section {
                span: [0.0, 100.0],
                lanes: vec![lane(2, 1.0), lane(1, 3.0), lane(-1, 3.5), lane(-2, 2.0)],
                ..Section::default()
            }],
            ..Road::default()
        }
    }

    #[test]
    fn borders_add_up_from_the_lane_offset_outward() {
        let road = road();
        let offset = |border| road.sections[0].offset(&road, border, 10.0);
        assert_eq!([2, 1, 0, -1, -2].map(offset), [4.5, 3.5, 0.5, -3.0, -5.0]);
        assert_eq!(road.sections[0].width(&road, -1, 10.0), 3.5);
        assert_eq!(road.place(10.0, -3.0), [10.0, -3.0, 6.0]);
    }

    #[test]
    fn a_stated_border_takes_the_place_of_widths() {
        let mut road = road();
        road.sections[0].lanes[3] = Lane { id: -2, borders: constant(-6.0), ..Lane::default() };
        assert_eq!(road.sections[0].offset(&road, -2, 10.0), -5.5);
        assert_eq!(road.sections[0].width(&road, -2, 10.0), 2.5);
    }

    #[test]
    fn a_rolled_road_is_narrower_in_the_plane_and_falls_to_the_right() {
        let road = Road { superelevation: constant(0.1), ..road() };
        let [_, y, z] = road.place(0.0, -3.0);
        assert!((y + 3.0 * 0.1_f64.cos()).abs() < 1e-12 && (z - 5.0 + 3.0 * 0.1_f64.sin()).abs() < 1e-12);
    }

    #[test]
    fn directions_follow_the_rule_of_the_road() {
        let (mut road, right) = (road(), lane(-1, 1.0));
        assert_eq!(road.directions(&right), [1]);
        assert_eq!(road.directions(&Lane { both_ways: true, ..right.clone() }), [1, -1]);
        road.left_hand = true;
        assert_eq!(road.directions(&right), [-1]);
        assert_eq!(road.directions(&Lane { reversed: true, ..right }), [1]);
    }
}
