//! `view`: a map, or how it comes to be, as a page in the browser that follows its files.

mod edits;
mod live;
mod map;
mod save;
mod server;
mod workshop;

use std::path::PathBuf;
use std::sync::Arc;

use crate::report::failure::Failure;

use super::screen;
use super::watch::Watched;
use super::{CLEAN, ViewArgs};
use live::Live;
use server::{Desk, Server};

/// Serves the page until somebody ends it.
pub fn run(args: ViewArgs) -> Result<u8, Failure> {
    let watched = Watched::new(&args.map, args.config.config.iter().map(PathBuf::from));
    let (open, live) = (args.open, Arc::new(Live::default()));
    let server = Server::bind(args.port, &live)?;
    let desk: Arc<dyn Desk> = if args.build {
        workshop::Benches::start(args, watched, Arc::clone(&live))?
    } else {
        Arc::new(map::Reports::start(args, watched, Arc::clone(&live))?)
    };
    screen::print(&format!("{}  (Ctrl-C ends)\n", server.url()))?;
    if open {
        server.open();
    }
    server.serve(&desk, &live);
    Ok(CLEAN)
}
