//! Work that can be cancelled: the caller sets a token; the work checks it now and then and unwinds.
//!
//! A token is known to the threads that [`watch`] it, so that no function in between has to hand it on. Work that is called
//! off ends by unwinding with a payload of ours, which tells no panic hook and writes no message; [`run`] catches it. Where
//! no token is watched, a look costs the reading of a thread's own memory.

use std::any::Any;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Calls off the work of the threads that watch it.
#[derive(Clone, Debug, Default)]
pub struct Token(Arc<AtomicBool>);

impl Token {
    /// Calls the work off. It ends when it looks the next time.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the work was called off.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The work was called off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the work was called off")]
pub struct Cancelled;

thread_local! {
    /// The token of the work that this thread does.
    static WATCHED: RefCell<Option<Token>> = const { RefCell::new(None) };
}

/// Lets this thread watch a token from now on: for the start of the threads of a pool.
pub fn watch(token: &Token) {
    WATCHED.with(|watched| *watched.borrow_mut() = Some(token.clone()));
}

/// Runs work that this thread, and a pool whose threads [`watch`] the token, share.
///
/// # Errors
///
/// Where the token was set before the work was done.
pub fn run<T>(token: &Token, work: impl FnOnce() -> T) -> Result<T, Cancelled> {
    let before = WATCHED.with(|watched| watched.replace(Some(token.clone())));
    // Nothing that the work has touched outlives it but what it returns.
    let done = catch_unwind(AssertUnwindSafe(work));
    WATCHED.with(|watched| watched.replace(before));
    done.map_err(|payload| if payload.is::<Cancelled>() { Cancelled } else { resume_unwind(payload) })
}

/// Unwinds if the work of this thread was called off.
#[inline]
pub(crate) fn look() {
    if WATCHED.with(|watched| watched.borrow().as_ref().is_some_and(Token::is_cancelled)) {
        resume_unwind(Box::new(Cancelled));
    }
}

/// Goes on unwinding where somebody has caught, among panics, that the work was called off.
pub(crate) fn pass_on(payload: Box<dyn Any + Send>) {
    if payload.is::<Cancelled>() {
        resume_unwind(payload);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parallel::InSmallParts;
    use rayon::prelude::*;

    #[test]
    fn work_ends_where_it_looks() {
        let token = Token::default();
        let ended = run(&token, || {
            look();
            token.cancel();
            look();
            unreachable!("it was called off");
        });
        assert_eq!(ended, Err::<(), _>(Cancelled));
        look();
        assert_eq!(run(&Token::default(), || 7), Ok(7));
    }

    #[test]
    fn all_threads_of_a_pool_end_and_the_pool_goes_on() {
        let token = Token::default();
        let start = token.clone();
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(3).start_handler(move |_| watch(&start)).build().unwrap();
        let sum = |cancel_at: usize| {
            let work = || {
                (0..10_000_usize)
                    .into_par_iter()
                    .in_small_parts()
                    .map(|i| {
                        if i == cancel_at {
                            token.cancel();
                        }
                        i
                    })
                    .sum::<usize>()
            };
            run(&token, || pool.install(work))
        };
        assert_eq!(sum(usize::MAX), Ok(49_995_000));
        assert_eq!(sum(5_000), Err(Cancelled));
        assert_eq!(run(&token, || pool.install(|| 1)), Ok(1), "what does not look is done");
    }

    #[test]
    fn a_panic_stays_one() {
        let caught = catch_unwind(|| run(&Token::default(), || resume_unwind(Box::new("a fault"))));
        assert_eq!(caught.unwrap_err().downcast_ref::<&str>(), Some(&"a fault"));
    }
}
