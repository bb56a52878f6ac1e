//! Indices of roads and intersections. They index vectors with one value for each road or intersection; [`End`] indexes pairs
//! with one value for each end of a road.

use std::ops::{Index, IndexMut};

use super::End;

/// Defines the index of a vector of the network.
macro_rules! index_of {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub u32);

        impl $name {
            /// The index of a position in the vector.
            pub fn new(position: usize) -> Self {
                Self(position as u32)
            }

            /// Its position in the vector.
            pub fn position(self) -> usize {
                self.0 as usize
            }

            /// The indices of all elements of a vector of this length.
            pub fn all(len: usize) -> impl Iterator<Item = Self> + Clone {
                (0..len as u32).map(Self)
            }
        }
    };
}

index_of!(
    /// Index of a road in [`RoadNetwork::roads`](super::RoadNetwork::roads).
    RoadIx
);
index_of!(
    /// Index of an intersection in [`RoadNetwork::intersections`](super::RoadNetwork::intersections).
    IntersectionIx
);

/// Implements indexing of these shapes by this type.
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
