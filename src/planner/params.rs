//! The parameters of Autoware's modules that decide what is read from a map.

use saphyr_parser::{Event, Parser};
use serde::Serialize;

/// Metres of path before and behind a lanelet that are looked at.
pub(super) const AROUND: [f64; 2] = [120.0, 40.0];

/// A value as a parameter file writes it.
trait Value: Sized {
    fn read(text: &str) -> Option<Self>;
}

impl Value for f64 {
    fn read(text: &str) -> Option<Self> {
        text.trim().parse().ok().filter(|number: &f64| number.is_finite())
    }
}

impl Value for bool {
    fn read(text: &str) -> Option<Self> {
        match text.trim() {
            "true" | "True" | "TRUE" => Some(true),
            "false" | "False" | "FALSE" => Some(false),
            _ => None,
        }
    }
}

macro_rules! parameters {
    ($($(#[$doc:meta])* $name:ident: $kind:ty = $default:literal, $path:literal;)*) => {
        /// Parameters by their names in Autoware's files. The defaults are those of `autoware_launch` at 662752e4 (2026-08-21).
        #[derive(Clone, Copy, Debug, PartialEq, Serialize)]
        pub struct Params {
            $($(#[$doc])* pub $name: $kind,)*
        }

        impl Default for Params {
            fn default() -> Self {
                Self { $($name: $default,)* }
            }
        }

        impl Params {
            /// The names, as Autoware's files nest them, and the values.
            pub fn table(&self) -> Vec<(&'static str, String)> {
                vec![$(($path, self.$name.to_string()),)*]
            }

            /// Sets what a file names: `None` if nothing of this name is read, `Some(false)` if the value is of another kind.
            fn set(&mut self, path: &str, text: &str) -> Option<bool> {
                match path {
                    $($path => Some(Value::read(text).map(|value| self.$name = value).is_some()),)*
                    _ => None,
                }
            }
        }
    };
}

parameters! {
    /// Metres that lanes before a watched one are followed upstream.
    attention_area_length: f64 = 200.0, "intersection.common.attention_area_length";
    /// Metres between the front of the vehicle and the first watched lane, where the map has no stop line for it.
    default_stopline_margin: f64 = 3.0, "intersection.common.default_stopline_margin";
    /// Metres by which the pass judge line lies farther before the first watched lane.
    pass_judge_line_margin: f64 = 0.0, "intersection.common.pass_judge_line_margin";
    /// Metres between two points of the path on which places are looked for.
    path_interpolation_ds: f64 = 0.1, "intersection.common.path_interpolation_ds";
    /// Hardest braking, m/s2, negative.
    max_accel: f64 = -2.8, "intersection.common.max_accel";
    /// How fast the braking sets in, m/s3, negative.
    max_jerk: f64 = -5.0, "intersection.common.max_jerk";
    /// Whether the lanes after and before those that conflict are watched against their direction, too.
    consider_wrong_direction_vehicle: bool = false, "intersection.collision_detection.consider_wrong_direction_vehicle";
    /// Whether the stop for a blocked exit lies before the first lane that conflicts, instead of the begin of the lanelet.
    use_stuck_stopline: bool = true, "intersection.stuck_vehicle.use_stuck_stopline";
    /// Metres behind the intersection that must be free.
    stuck_vehicle_detect_dist: f64 = 5.0, "intersection.stuck_vehicle.stuck_vehicle_detect_dist";
    /// Whether a blocked exit does not matter where the first lane that conflicts is private.
    disable_against_private_lane: bool = true, "intersection.stuck_vehicle.disable_against_private_lane";
    /// Whether left turns look for a blocked exit.
    stuck_left: bool = true, "intersection.stuck_vehicle.turn_direction.left";
    /// Whether right turns look for a blocked exit.
    stuck_right: bool = true, "intersection.stuck_vehicle.turn_direction.right";
    /// Whether straight lanelets look for a blocked exit.
    stuck_straight: bool = true, "intersection.stuck_vehicle.turn_direction.straight";
    /// Whether the vehicle stops where it cannot see into the watched lanes, and peeks.
    occlusion: bool = false, "intersection.occlusion.enable";
    /// Metres that lanes before a watched one are looked at for what hides them.
    occlusion_attention_area_length: f64 = 70.0, "intersection.occlusion.occlusion_attention_area_length";
    /// Metres from the first watched lane to where the vehicle peeks; negative: before it.
    peeking_offset: f64 = -0.5, "intersection.occlusion.peeking_offset";
    /// Metres before the first lane that conflicts at which a vehicle from private ground stops.
    private_stopline_margin: f64 = 3.0, "merge_from_private.stopline_margin";
    /// Seconds that it stops there.
    private_stop_duration: f64 = 1.0, "merge_from_private.stop_duration_sec";
    /// Metres that the blind side is watched upstream.
    backward_attention_length: f64 = 100.0, "blind_spot.backward_attention_length";
    /// Metres before a crosswalk without stop line.
    stop_distance_from_crosswalk: f64 = 3.5, "crosswalk.stop_position.stop_distance_from_crosswalk";
    /// Metres before the stop line of a sign.
    stop_sign_margin: f64 = 0.0, "stop_line.stop_margin";
    /// Seconds at the stop line of a sign.
    stop_sign_duration: f64 = 1.0, "stop_line.required_stop_duration_sec";
    /// Metres before the stop line of a traffic light.
    traffic_light_margin: f64 = 0.0, "traffic_light.stop_margin";
    /// Metres before a turn at which the blinker starts, at standstill, where the lanelet has no `turn_signal_distance`.
    turn_signal_search_distance: f64 = 30.0, "turn_signal_intersection_search_distance";
    /// Seconds of travel that are added to that.
    turn_signal_search_time: f64 = 3.0, "turn_signal_search_time";
    /// Metres from the rear to the front axle.
    wheel_base: f64 = 2.79, "wheel_base";
    /// Metres from the left to the right wheels.
    wheel_tread: f64 = 1.64, "wheel_tread";
    /// Metres before the front axle.
    front_overhang: f64 = 1.0, "front_overhang";
    /// Metres behind the rear axle.
    rear_overhang: f64 = 1.1, "rear_overhang";
    /// Metres beside the left wheels.
    left_overhang: f64 = 0.128, "left_overhang";
    /// Metres beside the right wheels.
    right_overhang: f64 = 0.128, "right_overhang";
}

/// Why a parameter file cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {message}")]
pub struct ParamsError {
    /// From 1.
    pub line: usize,
    /// What is wrong.
    pub message: String,
}

/// A level of a YAML document that is open.
enum Level {
    Mapping(Option<String>),
    List,
}

impl Params {
    /// Takes over what one of Autoware's parameter files says; names that have nothing to do with a map are passed over.
    ///
    /// # Errors
    ///
    /// Where the text is no parameter file, a value is of another kind or makes no sense, or nothing that is read is in it.
    pub fn read(&mut self, text: &str) -> Result<(), ParamsError> {
        let mut levels: Vec<Level> = Vec::new();
        let mut taken = 0;
        for event in Parser::new_from_str(text.trim_start_matches('\u{feff}')) {
            let (event, span) = event.map_err(|error| ParamsError {
                line: error.marker().line(),
                message: format!("this is not YAML: {}", error.info()),
            })?;
            match event {
                Event::MappingStart(..) => levels.push(Level::Mapping(None)),
                Event::SequenceStart(..) => levels.push(Level::List),
                Event::MappingEnd | Event::SequenceEnd => {
                    levels.pop();
                    close(&mut levels);
                }
                Event::Scalar(text, ..) => match levels.last_mut() {
                    Some(Level::Mapping(key @ None)) => *key = Some(text.into_owned()),
                    Some(Level::Mapping(Some(_))) => {
                        let line = span.start.line();
                        taken += usize::from(self.take(&path(&levels), &text, line)?);
                        close(&mut levels);
                    }
                    _ => {}
                },
                Event::Alias(..) => close(&mut levels),
                _ => {}
            }
        }
        match taken {
            0 => Err(ParamsError {
                line: 1,
                message: "no parameter in it is read: expected `ros__parameters:` with, for example, \
                          `intersection: {common: {attention_area_length: 200.0}}`"
                    .to_owned(),
            }),
            _ => Ok(()),
        }
    }

    /// Whether a value was taken over.
    fn take(&mut self, path: &str, text: &str, line: usize) -> Result<bool, ParamsError> {
        let wrong = |message: String| ParamsError { line, message };
        match self.set(path, text) {
            None => Ok(false),
            Some(false) => Err(wrong(format!("`{path}` cannot be `{text}`"))),
            Some(true) => match self.nonsense() {
                Some(reason) => Err(wrong(format!("`{path}` cannot be `{text}`: {reason}"))),
                None => Ok(true),
            },
        }
    }

    /// Why nothing can be computed with these values.
    fn nonsense(&self) -> Option<&'static str> {
        let lengths = [self.wheel_base, self.wheel_tread, self.front_overhang, self.rear_overhang];
        if self.path_interpolation_ds < 0.01 {
            Some("points of a path are a centimetre apart at the least")
        } else if self.max_accel >= 0.0 || self.max_jerk >= 0.0 {
            Some("braking is negative")
        } else if lengths.iter().any(|length| *length < 0.0) {
            Some("a vehicle has no negative length")
        } else if !(0.0..=10_000.0).contains(&self.attention_area_length) {
            Some("lanes are followed for 0 to 10000 m")
        } else {
            None
        }
    }

    /// Metres from the rear axle to the front of the vehicle.
    pub fn front(&self) -> f64 {
        self.wheel_base + self.front_overhang
    }

    /// How far (m) at most the modules follow lanes from what they look at.
    pub fn looks_back(&self) -> f64 {
        let path = AROUND.into_iter().fold(0.0, f64::max);
        [self.attention_area_length, self.backward_attention_length, self.occlusion_attention_area_length]
            .into_iter()
            .fold(path, f64::max)
    }

    /// How far (m) before a lanelet a vehicle can stand that stops for what begins with it.
    pub fn stopping_reach(&self) -> f64 {
        2.0 * (self.front() + self.rear_overhang) + self.default_stopline_margin
    }

    /// Half the width of the vehicle, metres.
    pub fn half_width(&self) -> f64 {
        (self.wheel_tread + self.left_overhang + self.right_overhang) / 2.0
    }
}

/// The value of the open key has been read.
fn close(levels: &mut [Level]) {
    if let Some(Level::Mapping(key)) = levels.last_mut() {
        *key = None;
    }
}

/// The open keys below `ros__parameters`, joined by points.
fn path(levels: &[Level]) -> String {
    let keys: Vec<&str> = levels
        .iter()
        .filter_map(|level| match level {
            Level::Mapping(key) => key.as_deref(),
            Level::List => None,
        })
        .collect();
    let below = keys.iter().position(|key| *key == "ros__parameters").map_or(keys.len(), |at| at + 1);
    keys.get(below..).unwrap_or_default().join(".")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_autoware_changes_what_it_names_and_leaves_the_rest() {
        let mut params = Params::default();
        let text = "/**:\n  ros__parameters:\n    intersection:\n      common:\n        attention_area_length: 80\n      debug:\n        \
                    ttc: [0]\n      occlusion:\n        enable: true\n        possible_object_bbox: [1.9, 2.5]\n    \
                    merge_from_private:\n      stopline_margin: 1.5\n";
        params.read(text).unwrap();
        let expected =
            Params { attention_area_length: 80.0, occlusion: true, private_stopline_margin: 1.5, ..Params::default() };
        assert_eq!(params, expected);
    }

    #[test]
    fn what_cannot_be_used_is_told_with_its_line() {
        let says = |text: &str| Params::default().read(text).unwrap_err().to_string();
        let wrong = "/**:\n  ros__parameters:\n    intersection:\n      common:\n        max_accel: fast\n";
        assert_eq!(says(wrong), "line 5: `intersection.common.max_accel` cannot be `fast`");
        assert!(says(&wrong.replace("fast", "2.8")).ends_with("cannot be `2.8`: braking is negative"));
        assert!(says("a: [1").contains("this is not YAML"));
        assert!(says("intersection:\n  common:\n    max_accel: -1.0\n").contains("no parameter in it is read"));
    }
}
