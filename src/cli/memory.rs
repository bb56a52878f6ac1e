//! How long the allocator keeps what was freed before it gives it back to the system.

#[cfg(feature = "allocator")]
use tikv_jemalloc_ctl::{Access, AsName};

/// While streets are laid out, which takes less for a city: what one stage frees the next one takes again, and the system need
/// not clear other memory for it.
pub const KEPT_LONG_MS: isize = 1000;
/// While a map is built, and whenever nothing else is said (`ALLOCATION` in `main.rs`): it takes more memory than anything
/// else, and what one of its stages has freed the next does not ask for in the same sizes.
pub const KEPT_BRIEFLY_MS: isize = 100;

/// Lets the allocator keep what was freed for so many milliseconds.
#[cfg(feature = "allocator")]
pub fn keep(milliseconds: isize) {
    // For threads to come, and for those that are there. Where it cannot be set, all goes on as before.
    let _ = "arenas.dirty_decay_ms\0".name().write(milliseconds);
    let arenas: u32 = "arenas.narenas\0".name().read().unwrap_or_default();
    for arena in 0..arenas {
        let _ = format!("arena.{arena}.dirty_decay_ms\0").as_str().name().write(milliseconds);
    }
}

/// Gives back at once what was freed: also what belongs to threads that have ended, which nobody would give back otherwise.
pub fn give_back() {
    keep(0);
    keep(KEPT_BRIEFLY_MS);
}

/// There is no such allocator.
#[cfg(not(feature = "allocator"))]
pub fn keep(_milliseconds: isize) {}
