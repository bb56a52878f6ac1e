//! Vectors with one value for each road or intersection are indexed by these; pairs with one value for each end of a road, by the
//! end.

use std::ops::{Index, IndexMut};

use super::{End, IntersectionIx, RoadIx};

/// Lets values of this shape be indexed by this type.
macro_rules! indexed_by {
    ($index:ty, $position:expr, $($values:ty),+) => {$(
        impl<T> Index<$index> for $values {
            type Output = T;

            #[inline]
            fn index(&self, index: $index) -> &T {
                &self[$position(index)]
            }
        }

        impl<T> IndexMut<$index> for $values {
            #[inline]
            fn index_mut(&mut self, index: $index) -> &mut T {
                &mut self[$position(index)]
            }
        }
    )+};
}

indexed_by!(RoadIx, RoadIx::position, [T], Vec<T>);
indexed_by!(IntersectionIx, IntersectionIx::position, [T], Vec<T>);
indexed_by!(End, End::index, [T; 2]);
