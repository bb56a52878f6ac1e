//! `view`: a map, its review, or how it comes to be, as a page in the browser that follows its files.

mod args;
mod build_view;
mod downloads;
mod edits;
mod http;
mod map_view;
mod review_view;
mod server;
mod subscriptions;

use std::path::PathBuf;
use std::sync::Arc;

use crate::report::failure::Failure;

use super::args::CLEAN;
use super::output;
use super::watch::Watched;
pub use args::ViewArgs;
use server::{Handler, Server};
use subscriptions::Subscriptions;

/// Serves the page until somebody ends it.
pub fn run(args: ViewArgs) -> Result<u8, Failure> {
    let more = args.config.config.iter().map(PathBuf::from);
    let watched = Watched::new(&args.map, more);
    let (open, subscriptions) = (args.open, Arc::new(Subscriptions::default()));
    let server = Server::bind(args.port, &subscriptions)?;
    let handler: Arc<dyn Handler> = if args.build {
        build_view::BuildSessions::start(args, watched, Arc::clone(&subscriptions))?
    } else if args.review {
        review_view::ReviewSession::start(args, watched, Arc::clone(&subscriptions))?
    } else {
        Arc::new(map_view::Reports::start(args, watched, Arc::clone(&subscriptions))?)
    };
    let url = server.url(&*handler);
    output::print(&format!("{url}  (Ctrl-C ends)\n"))?;
    if open {
        Server::open(&url);
    }
    server.serve(&handler, &subscriptions);
    Ok(CLEAN)
}
