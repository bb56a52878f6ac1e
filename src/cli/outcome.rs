//! What came of a verb. Where a library that it uses breaks, that is a failure like others, with a sentence.

use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook, take_hook};
use std::sync::{Mutex, Once, PoisonError};

use crate::report::failure::Failure;
use crate::report::visible;

/// What broke first since somebody asked, on whatever thread: what it said, and where.
static BROKEN: Mutex<Option<String>> = Mutex::new(None);

/// Does work and gives what comes of it; a failure if it panics. What it has written until then is drafts, which are gone.
pub fn of<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |panic| {
            BROKEN.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_with(|| said(panic));
            // For whoever looks for the fault.
            if std::env::var_os("RUST_BACKTRACE").is_some() {
                before(panic);
            }
        }));
    });
    // What was read of the map is dropped, and nothing else outlives the work.
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        let broken = BROKEN.lock().unwrap_or_else(PoisonError::into_inner).take().unwrap_or_default();
        let message = format!("the program broke on this input, and nothing was written: {}", visible(&broken));
        Err(Failure::new(message)
            .help("this is a fault of lanewright, not of yours: report it, with the input if you may"))
    })
}

fn said(panic: &PanicHookInfo) -> String {
    let payload = panic.payload();
    let words =
        payload.downcast_ref::<&str>().copied().or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    let place = panic.location().map(|at| format!(" ({}:{})", at.file(), at.line())).unwrap_or_default();
    format!("{}{place}", words.unwrap_or("no word of why"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    #[test]
    fn a_library_that_breaks_is_a_failure_with_a_sentence() {
        let library = |broken: bool| if broken { panic!("index out of bounds\u{1b}[2J") } else { Ok(7) };
        assert_eq!(of(|| library(false)).unwrap(), 7);
        let failure = of(|| library(true)).unwrap_err();
        assert!(failure.message().contains("broke on this input, and nothing was written: index out of bounds"));
        assert!(failure.message().contains("outcome.rs:") && !failure.message().contains('\u{1b}'));
        assert!(failure.way_out().is_some());
        // On a thread that helps.
        let lists = of(|| (0..100).into_par_iter().map(|at| library(at == 50)).collect::<Result<Vec<_>, _>>());
        assert!(lists.unwrap_err().message().contains("index out of bounds"));
        assert_eq!(of(|| library(false)).unwrap(), 7);
    }
}
