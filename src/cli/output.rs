//! What the user sees: results on standard output, progress and errors on standard error.

use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::api::files;
use crate::report::failure::Failure;
use crate::report::{TextStyle, visible, visible_lines, visible_patch};
use indicatif::{ProgressBar, ProgressStyle};

/// Widest text: lines longer than this are hard to read, however wide the terminal is.
const MAX_WIDTH: usize = 110;

/// Whether the user wants results alone.
static QUIET: AtomicBool = AtomicBool::new(false);

/// From now on there is no progress, and nothing is said of what was done.
pub fn keep_quiet(quiet: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
}

/// Whether the user wants results alone.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// The style of reports on standard output.
pub fn stdout_style() -> TextStyle {
    style(io::stdout().is_terminal())
}

fn style(terminal: bool) -> TextStyle {
    // https://no-color.org: set and not empty.
    let unwanted = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty())
        || std::env::var_os("TERM").is_some_and(|v| v == "dumb");
    let plain = TextStyle::default();
    let width = match terminal_size::terminal_size() {
        Some((terminal_size::Width(columns), _)) if terminal => usize::from(columns).min(MAX_WIDTH),
        _ => plain.width,
    };
    TextStyle { color: terminal && !unwanted, width }
}

/// Writes a text to standard output. Whatever stands in it, it steers no terminal, and no machine that runs CI.
pub fn print(text: &str) -> Result<(), Failure> {
    print_with(|out| out.write_all(visible_lines(text).as_bytes()))
}

/// Writes a patch to standard output: as it is but for what would steer a terminal.
pub fn print_patch(patch: &str) -> Result<(), Failure> {
    if io::stdout().is_terminal() {
        print(patch)
    } else {
        print_with(|out| out.write_all(visible_patch(patch).as_bytes()))
    }
}

/// A path in a line of output.
pub fn shown(path: &Path) -> String {
    visible(&path.to_string_lossy()).into_owned()
}

/// Makes room on a terminal for the next report.
pub fn clear() -> Result<(), Failure> {
    const CLEAR_SCREEN: &str = "\u{1b}[2J\u{1b}[H";
    if io::stdout().is_terminal() { print_with(|out| out.write_all(CLEAR_SCREEN.as_bytes())) } else { Ok(()) }
}

/// Writes what a format of [`crate::report`] makes to standard output, which shows no text of a map as it is. Whoever reads may stop at any time (`| head`), which is no failure.
pub fn print_with(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
    let mut out = BufWriter::new(io::stdout().lock());
    match write(&mut out).and_then(|()| out.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {
            // What is left in the buffer has no reader.
            let _ = out.into_parts();
            Ok(())
        }
        result => result.map_err(|error| Failure::new(format!("cannot write to standard output: {error}"))),
    }
}

/// Writes what is told beside an output: on standard output, unless that is the output itself.
pub fn print_beside(of: Option<&Path>, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
    if !of.is_some_and(files::is_stdout) {
        return print_with(write);
    }
    // There is nobody to tell if that fails.
    let _ = write(&mut io::stderr().lock());
    Ok(())
}

/// Says what became of an output: on standard output, unless that is the output itself; nothing with `--quiet`.
pub fn tell(of: &Path, text: &str) -> Result<(), Failure> {
    if is_quiet() {
        return Ok(());
    }
    if files::is_stdout(of) {
        complain(text);
        return Ok(());
    }
    print(text)
}

/// Writes to standard error; there is nobody to tell if that fails.
pub fn complain(text: &str) {
    let _ = io::stderr().lock().write_all(visible_lines(text).as_bytes());
}

/// Says why a run failed.
pub fn tell_failure(failure: &Failure) {
    let _ = io::stderr().lock().write_all(failure.render(style(io::stderr().is_terminal())).as_bytes());
}

/// A line on the terminal that says what is going on; silent where standard error is no terminal.
pub struct Progress(ProgressBar);

impl Progress {
    /// Begins with the first thing that is done.
    pub fn start(doing: &str) -> Self {
        if is_quiet() || !io::stderr().is_terminal() {
            return Self(ProgressBar::hidden());
        }
        let bar = ProgressBar::new_spinner().with_message(visible(doing).into_owned());
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(120));
        Self(bar)
    }

    /// Says what is done next.
    pub fn next(&self, doing: &str) {
        self.0.set_message(visible(doing).into_owned());
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
