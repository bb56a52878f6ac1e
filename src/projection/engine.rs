//! The planes that places are projected onto, and the way there and back for many places at once.

use std::cell::RefCell;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::LonLat;
use super::mercator::Mercator;
use super::patch::{Patch, Square, square_of};
use crate::geometry::{Point, Vector};

/// A plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Frame {
    /// UTM; northings go below zero in the south.
    Utm {
        /// 1..=60.
        zone: u8,
    },
    /// Transverse Mercator.
    Mercator {
        /// Its zero, on the central meridian.
        origin: LonLat,
        /// Scale on the central meridian.
        scale_factor: f32,
    },
}

/// Points that one thread takes at a time: a few tenths of a millisecond of work.
const CHUNK: usize = 1 << 11;

/// The squares of one frame; `None` where no polynomial fits.
type Patches = (Option<Frame>, FxHashMap<Square, Option<Patch>>);

/// More squares than this are not worth keeping: a large city covers a dozen.
const PATCHES_MOST: usize = 1024;

thread_local! {
    static PATCHES: RefCell<Patches> = RefCell::default();
}

impl Frame {
    /// The plane itself, without the polynomials.
    pub(super) fn mercator(self) -> Mercator {
        match self {
            Self::Utm { zone } => Mercator::utm(zone),
            // Widened without rounding, as C++ does.
            Self::Mercator { origin, scale_factor } => Mercator::around(origin.lon, f64::from(scale_factor)),
        }
    }

    /// What this frame says of the place that is to be zero.
    pub(super) fn offset(self, origin: LonLat) -> Option<Vector> {
        let at = self.forward(&[origin]).pop()??;
        // The central meridian is straight, so the east of its points is exactly 0.
        Some(if matches!(self, Self::Mercator { .. }) { Vector::new(0.0, at.y) } else { at.coords })
    }

    /// East and north of each place.
    pub(super) fn forward(self, places: &[LonLat]) -> Vec<Option<Point>> {
        let plane = self.mercator();
        in_chunks(places, |chunk| chunk.iter().map(|place| plane.forward(*place)).collect())
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
        let plane = self.mercator();
        // Most points lie in the square of the one before.
        let mut here: Option<(Square, Option<Patch>)> = None;
        let place = |&point: &Point| {
            let square = square_of(point)?;
            if here.as_ref().is_none_or(|(here, _)| *here != square) {
                let patch = patches.entry(square).or_insert_with(|| Patch::new(square, |point| plane.inverse(point)));
                here = Some((square, patch.clone()));
            }
            let place = here.as_ref().and_then(|(_, patch)| Some(patch.as_ref()?.inverse(point)));
            place.filter(|place| !on_border(place)).or_else(|| plane.inverse(point))
        };
        points.iter().map(place).collect()
    }
}

fn in_chunks<T: Sync, R: Send>(items: &[T], run: impl Fn(&[T]) -> Vec<R> + Sync + Send) -> Vec<R> {
    if items.len() <= CHUNK {
        return run(items);
    }
    let parts: Vec<Vec<R>> = items.par_chunks(CHUNK).map(run).collect();
    parts.into_iter().flatten().collect()
}

/// Whether a place lies where zones and bands may end, so nearly that the last digits decide on which side.
fn on_border(place: &LonLat) -> bool {
    /// Degrees: a tenth of a millimetre.
    const NEAR: f64 = 1e-9;
    [place.lon, place.lat].iter().any(|degrees| (degrees - degrees.round()).abs() < NEAR)
}
