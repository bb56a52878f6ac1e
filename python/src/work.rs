//! Work on threads of its own, while the interpreter goes on and can call it off.

use std::any::Any;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use lanewright::api::Error;
use lanewright::cancel::{self, Cancelled, Token};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

use crate::errors;

/// How often it is asked whether somebody pressed Ctrl-C.
const ASK: Duration = Duration::from_millis(50);

/// Bytes of a thread's stack: what the main thread of a program has. Only what is used takes memory.
const STACK: usize = 8 << 20;

/// What a panic of a piece of work said.
type Said = Arc<Mutex<Option<String>>>;

thread_local! {
    /// Where the panics of this thread are kept, if it does a piece of work.
    static SAID: RefCell<Option<Said>> = const { RefCell::new(None) };
}

/// Keeps what panics of our threads say for the exception, instead of writing it to standard error.
pub fn keep_panics() {
    let others = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        let kept = SAID.with(|said| said.borrow().clone());
        match kept {
            Some(said) => *said.lock().unwrap_or_else(PoisonError::into_inner) = Some(info.to_string()),
            None => others(info),
        }
    }));
}

/// How a piece of work ended.
enum End<T> {
    Done(Result<T, Error>),
    CalledOff,
    /// It panicked, and said this.
    Broken(String),
}

/// Does a piece of work on this many threads, or as many as there are processors.
///
/// All memory that its threads keep for themselves is given back at its end. Where Python wants to raise an exception, because
/// of Ctrl-C or another signal, the work is called off first.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T, Error> + Send + 'static,
) -> PyResult<T> {
    let token = Token::default();
    let (sender, mut receiver) = channel();
    let watched = token.clone();
    let worker = thread::Builder::new().name("lanewright".to_owned()).spawn(move || {
        // Nobody waits any more if the interpreter is gone.
        let _ = sender.send(pooled(threads, &watched, work));
    });
    let worker = worker.map_err(|error| errors::fault(py, &format!("no thread can be started: {error}")))?;
    let joined = |worker: JoinHandle<()>| py.detach(move || drop(worker.join()));
    loop {
        let receiver = &mut receiver;
        match py.detach(move || receiver.recv_timeout(ASK)) {
            Ok(end) => {
                joined(worker);
                return ended(py, end);
            }
            Err(RecvTimeoutError::Timeout) => {
                if let Err(raised) = py.check_signals() {
                    token.cancel();
                    joined(worker);
                    return Err(raised);
                }
            }
            Err(RecvTimeoutError::Disconnected) => {
                joined(worker);
                return Err(errors::fault(py, "a thread ended without a result"));
            }
        }
    }
}

fn ended<T>(py: Python<'_>, end: End<T>) -> PyResult<T> {
    match end {
        End::Done(result) => result.map_err(|error| errors::raised(py, error)),
        End::CalledOff => Err(PyKeyboardInterrupt::new_err("the work was called off")),
        End::Broken(said) => Err(errors::fault(py, &said)),
    }
}

/// Does a piece of work in a pool of its own, and waits until all threads of the pool have ended.
fn pooled<T: Send>(threads: Option<usize>, token: &Token, work: impl FnOnce() -> Result<T, Error> + Send) -> End<T> {
    let said = Said::default();
    let started: Mutex<Vec<JoinHandle<()>>> = Mutex::default();
    let begin = |said: &Said, token: &Token| {
        SAID.with(|own| *own.borrow_mut() = Some(said.clone()));
        cancel::watch(token);
    };
    begin(&said, token);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or_default())
        .spawn_handler(|thread| {
            let (said, token) = (said.clone(), token.clone());
            let handle = thread::Builder::new().name("lanewright".to_owned()).stack_size(STACK).spawn(move || {
                begin(&said, &token);
                thread.run();
            })?;
            started.lock().unwrap_or_else(PoisonError::into_inner).push(handle);
            Ok(())
        })
        .build();
    let end = match pool {
        Err(error) => End::Broken(format!("no threads can be started: {error}")),
        Ok(pool) => match catch_unwind(AssertUnwindSafe(|| cancel::run(token, || pool.install(work)))) {
            Ok(Ok(result)) => End::Done(result),
            Ok(Err(Cancelled)) => End::CalledOff,
            Err(payload) => End::Broken(
                said.lock().unwrap_or_else(PoisonError::into_inner).take().unwrap_or_else(|| text(&payload)),
            ),
        },
    };
    for handle in started.into_inner().unwrap_or_else(PoisonError::into_inner) {
        // What a thread had to say was said through the pool.
        let _ = handle.join();
    }
    end
}

/// What a panic carries.
fn text(payload: &Box<dyn Any + Send>) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_else(|| "a panic".to_owned())
}
