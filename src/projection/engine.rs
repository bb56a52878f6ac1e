//! PROJ: one transformation per thread and frame, made when first needed.
//!
//! Frames are given as pipelines with their own ellipsoid, never as EPSG codes: those need PROJ's database, and
//! `PROJ_DATA` of a foreign installation (conda, QGIS, ROS) would put a wrong one in its place.

use std::cell::RefCell;

use proj::Proj;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::geometry::{Point, Vector};
use crate::parallel::InSmallParts;

use super::LonLat;
use super::chebyshev_inverse::{Patch, Square, square_of};

/// A plane that PROJ knows how to reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Frame {
    /// UTM; northings go below zero in the south.
    Utm {
        /// 1..=60.
        zone: u8,
    },
    /// Transverse Mercator, northings from the equator.
    Mercator {
        /// The central meridian, degrees.
        meridian: f64,
        /// Scale on the central meridian.
        scale_factor: f32,
    },
}

/// Points that one thread takes at a time: half a millisecond of work.
const CHUNK: usize = 1 << 11;

/// More frames than this in one thread are not worth keeping: a map needs one, or two at a zone's border.
const KEPT: usize = 8;

/// The squares of one frame; `None` where PROJ itself is to be asked.
type Patches = (Option<Frame>, FxHashMap<Square, Option<Patch>>);

/// More squares than this are not worth keeping: a large city covers a dozen.
const PATCHES_MOST: usize = 1024;

thread_local! {
    static MADE: RefCell<Vec<(Frame, Option<Proj>)>> = const { RefCell::new(Vec::new()) };
    static PATCHES: RefCell<Patches> = RefCell::default();
}

/// PROJ opens its database for the first transformation that it makes in a process, which takes as long as a small city does to
/// be projected: time for that while there is nothing to project yet.
pub fn warm_up() {
    let _ = Frame::Utm { zone: 31 }.forward(&[LonLat { lon: 3.0, lat: 0.0 }]);
}

impl Frame {
    fn definition(self) -> String {
        let plane = match self {
            Self::Utm { zone } => format!("+proj=utm +zone={zone}"),
            Self::Mercator { meridian, scale_factor } => {
                // Widened without rounding, as C++ does.
                let k = f64::from(scale_factor);
                format!("+proj=tmerc +lon_0={meridian} +lat_0=0 +k={k}")
            }
        };
        format!("+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step {plane} +ellps=WGS84")
    }

    /// What this frame says of the place that is to be zero.
    pub(super) fn offset(self, origin: LonLat) -> Option<Vector> {
        let at = self.forward(&[origin]).pop()??;
        // The central meridian is straight, so the east of its points is exactly 0.
        Some(if matches!(self, Self::Mercator { .. }) { Vector::new(0.0, at.y) } else { at.coords })
    }

    /// East and north of each place.
    pub(super) fn forward(self, places: &[LonLat]) -> Vec<Option<Point>> {
        let run = |chunk: &[LonLat]| {
            let pairs = chunk.iter().map(|p| (p.lon, p.lat)).collect();
            let done = self.transform(pairs, false);
            done.into_iter().map(|pair| pair.map(|(x, y)| Point::new(x, y))).collect::<Vec<_>>()
        };
        in_chunks(places, run)
    }

    /// The place of each point, by [`Patch`]es where those fit. It does not depend on the other points.
    pub(super) fn inverse(self, points: &[Point]) -> Vec<Option<LonLat>> {
        in_chunks(points, |chunk| PATCHES.with_borrow_mut(|patches| self.inverse_in(patches, chunk)))
    }

    fn inverse_in(self, (frame, patches): &mut Patches, points: &[Point]) -> Vec<Option<LonLat>> {
        if *frame != Some(self) || patches.len() > PATCHES_MOST {
            patches.clear();
            *frame = Some(self);
        }
        let place = |&point: &Point| {
            let square = square_of(point)?;
            let patch = patches.entry(square);
            let patch = patch.or_insert_with(|| Patch::new(square, |places| self.inverse_by_proj(places)));
            let place = patch.as_ref().map(|patch| patch.inverse(point));
            match place.filter(|place| !on_border(place)) {
                Some(place) => Some(place),
                None => self.inverse_by_proj(&[point]).pop()?,
            }
        };
        points.iter().map(place).collect()
    }

    /// As [`Frame::inverse`], by PROJ.
    pub(super) fn inverse_by_proj(self, points: &[Point]) -> Vec<Option<LonLat>> {
        let run = |chunk: &[Point]| {
            let pairs = chunk.iter().map(|p| (p.x, p.y)).collect();
            let done = self.transform(pairs, true);
            done.into_iter().map(|pair| pair.map(|(lon, lat)| LonLat { lon, lat })).collect::<Vec<_>>()
        };
        in_chunks(points, run)
    }

    fn transform(self, mut pairs: Vec<(f64, f64)>, back: bool) -> Vec<Option<(f64, f64)>> {
        with_proj(self, |proj| {
            let Some(proj) = proj else { return vec![None; pairs.len()] };
            let before = pairs.clone();
            let finite = |(x, y): (f64, f64)| (x.is_finite() && y.is_finite()).then_some((x, y));
            match proj.project_array(&mut pairs, back) {
                Ok(_) => pairs.into_iter().map(finite).collect(),
                // One bad point spoils the batch: take them one by one.
                Err(_) => before.into_iter().map(|p| proj.project(p, back).ok().and_then(finite)).collect(),
            }
        })
    }
}

fn in_chunks<T: Sync, R: Send>(items: &[T], run: impl Fn(&[T]) -> Vec<R> + Sync + Send) -> Vec<R> {
    if items.len() <= CHUNK {
        return run(items);
    }
    let parts: Vec<Vec<R>> = items.par_chunks(CHUNK).in_small_parts().map(run).collect();
    parts.into_iter().flatten().collect()
}

fn with_proj<R>(frame: Frame, use_it: impl FnOnce(Option<&Proj>) -> R) -> R {
    MADE.with(|made| {
        let mut made = made.borrow_mut();
        let at = match made.iter().position(|(f, _)| *f == frame) {
            Some(at) => at,
            None => {
                if made.len() == KEPT {
                    made.remove(0);
                }
                made.push((frame, Proj::new(&frame.definition()).ok()));
                made.len() - 1
            }
        };
        use_it(made[at].1.as_ref())
    })
}

/// Whether a place lies where zones and bands may end, so nearly that the last digits decide on which side.
fn on_border(place: &LonLat) -> bool {
    /// Degrees: a tenth of a millimetre.
    const AT_BORDER: f64 = 1e-9;
    // Rounded without `round`, which is a function call where processors may be old.
    let beside = |degrees: f64| degrees - (degrees + 0.5) as i64 as f64;
    [place.lon, place.lat].iter().any(|degrees| beside(degrees.abs()).abs() < AT_BORDER)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// FNV-1a over the bits of numbers.
    fn hashed(hash: u64, number: f64) -> u64 {
        let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        number.to_bits().to_le_bytes().into_iter().fold(hash, step)
    }

    /// The same number came from PROJ 9.1.1 of Debian 12 (GCC) and from PROJ 9.6.2 as it is built from source into wheels and
    /// archives (Clang). So a map does not depend on which of them made it.
    #[cfg(all(target_os = "linux", target_env = "gnu", target_arch = "x86_64"))]
    #[test]
    fn every_proj_computes_the_same_bits() {
        const EXPECTED: u64 = 0x2013_7e38_9e47_fc9d;
        let mut hash = 0x1465_0fb0_739d_0383_u64;
        for zone in 1..=60_u8 {
            let middle = -183.0 + 6.0 * f64::from(zone);
            for frame in [Frame::Utm { zone }, Frame::Mercator { meridian: middle + 0.123, scale_factor: 0.9996 }] {
                let spread = |i: u32, prime: u32, most: u32| f64::from(i.wrapping_mul(prime) % most) / f64::from(most);
                let places: Vec<LonLat> = (0..2000)
                    .map(|i| LonLat {
                        lon: middle + (spread(i, 7919, 2003) - 0.5) * 7.0,
                        lat: spread(i, 104_729, 1999) * 164.0 - 80.0,
                    })
                    .collect();
                let points: Vec<Point> = frame.forward(&places).into_iter().map(Option::unwrap).collect();
                let back: Vec<LonLat> = frame.inverse_by_proj(&points).into_iter().map(Option::unwrap).collect();
                for (point, place) in points.iter().zip(back) {
                    hash = [point.x, point.y, place.lon, place.lat].into_iter().fold(hash, hashed);
                }
            }
        }
        assert_eq!(hash, EXPECTED, "{hash:#x}: this PROJ computes other numbers; its maps differ from those of wheels");
    }
}
