//! What is shown now, and those who wait for the next.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde_json::json;

/// A question for news is answered after this long, news or not; it is asked again then.
const LONGEST_WAIT: Duration = Duration::from_secs(20);

#[derive(Debug, Default)]
struct State {
    /// Counts what was shown, and what failed.
    version: u64,
    /// The version of the data.
    shown: u64,
    data: Arc<Vec<u8>>,
    error: Option<String>,
    over: bool,
}

/// The data that pages fetch, in its latest version.
#[derive(Debug, Default)]
pub struct Subscriptions {
    state: Mutex<State>,
    bell: Condvar,
}

impl Subscriptions {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, with: impl FnOnce(&mut State)) {
        let mut state = self.state();
        state.version += 1;
        with(&mut state);
        self.bell.notify_all();
    }

    /// Shows other data.
    pub fn show(&self, data: Vec<u8>) {
        self.change(|state| {
            (state.data, state.error, state.shown) = (Arc::new(data), None, state.version);
        });
    }

    /// Says why there is nothing new to show; what was shown stays.
    pub fn fail(&self, error: String) {
        self.change(|state| state.error = Some(error));
    }

    /// Lets go of all who wait.
    pub fn end(&self) {
        self.change(|state| state.over = true);
    }

    /// The data and its version.
    pub fn data(&self) -> (u64, Arc<Vec<u8>>) {
        let state = self.state();
        (state.shown, Arc::clone(&state.data))
    }

    /// Waits for another version than the given one; says which it is, and what is wrong.
    pub fn changes(&self, after: u64) -> String {
        let state = self.state();
        let same = |state: &mut State| state.version == after && !state.over;
        let waited = self.bell.wait_timeout_while(state, LONGEST_WAIT, same);
        let (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        json!({ "version": state.version, "error": state.error }).to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_keeps_what_was_shown() {
        let subscriptions = Subscriptions::default();
        subscriptions.show(vec![1]);
        subscriptions.fail("torn".to_owned());
        assert_eq!(subscriptions.data(), (1, Arc::new(vec![1])));
        assert_eq!(subscriptions.changes(1), r#"{"version":2,"error":"torn"}"#);
        subscriptions.show(vec![2]);
        assert_eq!(subscriptions.changes(2), r#"{"version":3,"error":null}"#);
    }

    #[test]
    fn whoever_waits_hears_of_news() {
        let subscriptions = Arc::new(Subscriptions::default());
        let other = Arc::clone(&subscriptions);
        let waiting = std::thread::spawn(move || other.changes(0));
        subscriptions.show(Vec::new());
        assert_eq!(waiting.join().unwrap(), r#"{"version":1,"error":null}"#);
    }
}
