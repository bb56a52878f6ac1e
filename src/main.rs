//! The command line program: arguments in, exit code out.

/// All threads build many small lists at the same time, and hand them to each other: the system's allocator takes a
/// tenth of the time for that.
#[cfg(feature = "allocator")]
#[global_allocator]
static ALLOCATOR: tikv_jemallocator::Jemalloc = tikv_jemallocator::Jemalloc;

/// The allocator reads its settings here when the program starts. What one stage has freed the next does not ask for in
/// the same sizes: given back after a tenth of a second, not after ten, a map takes a third less memory to build.
#[cfg(feature = "allocator")]
#[allow(unsafe_code, reason = "a name for the linker; nothing else has it")]
#[unsafe(export_name = "_rjem_malloc_conf")]
pub static ALLOCATION: &[u8] = b"dirty_decay_ms:100,muzzy_decay_ms:0\0";

fn main() -> std::process::ExitCode {
    lanewright::cli::run()
}
