//! The command line program: arguments in, exit code out.

mod cli;

/// All threads build many small lists at the same time, and hand them to each other: the system's allocator takes a
/// tenth of the time for that.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> std::process::ExitCode {
    cli::run()
}
