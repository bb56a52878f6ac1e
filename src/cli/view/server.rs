//! Pages for browsers on this machine, and for nobody else.

use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::report::failure::Failure;

use super::http::{Listener, Reply, Request};
use super::subscriptions::Subscriptions;

/// Exit code of a program that Ctrl-C ended in the midst of its work: 128 and the signal's number.
const INTERRUPTED: i32 = 130;

/// What a page asks of the program that serves it.
pub trait Handler: Send + Sync {
    /// The page itself.
    fn page(&self) -> String;

    /// What a request has to know to be answered, where not everybody on this machine may ask.
    fn token(&self) -> Option<&str> {
        None
    }

    /// Answers what a page posts to a path, or says why not; `None` where nothing is at that path.
    fn post(&self, _path: &str, _question: &str) -> Option<Result<Answer, String>> {
        None
    }
}

/// What a page gets for what it posted.
pub struct Answer {
    /// The answer.
    pub bytes: Vec<u8>,
    /// Its name, where it is a file to keep.
    pub name: Option<String>,
}

/// Listens on the loopback address.
pub struct Server {
    http: Arc<Listener>,
    port: u16,
    /// Before it answers, Ctrl-C ends the program as it always does.
    answers: Arc<AtomicBool>,
}

impl Server {
    /// Takes a port, or one that the system chooses. From now on Ctrl-C ends [`Server::serve`], and all who wait.
    pub fn bind(port: u16, subscriptions: &Arc<Subscriptions>) -> Result<Self, Failure> {
        let failed = |what: &dyn std::fmt::Display| {
            Failure::new(format!("cannot listen on 127.0.0.1:{port}: {what}"))
                .help("another program may have the port; without --port the system chooses a free one")
        };
        let http = Listener::bind(port).map_err(|error| failed(&error))?;
        let port = http.address().map_err(|error| failed(&error))?.port();
        let http = Arc::new(http);
        let answers = Arc::new(AtomicBool::new(false));
        let (ours, waiting, begun) = (Arc::clone(&http), Arc::clone(subscriptions), Arc::clone(&answers));
        let heard = ctrlc::set_handler(move || {
            if !begun.load(Ordering::SeqCst) {
                std::process::exit(INTERRUPTED);
            }
            waiting.end();
            ours.end();
        });
        heard.map_err(|error| Failure::new(format!("cannot wait for Ctrl-C: {error}")))?;
        Ok(Self { http, port, answers })
    }

    /// Where the page of a handler is, now that there is something to show.
    pub fn url(&self, handler: &dyn Handler) -> String {
        self.answers.store(true, Ordering::SeqCst);
        let token = handler.token().map(|token| format!("?token={token}")).unwrap_or_default();
        format!("http://127.0.0.1:{}/{token}", self.port)
    }

    /// Opens a page in the user's browser, if there is a way.
    pub fn open(url: &str) {
        let (program, before): (&str, &[&str]) = if cfg!(target_os = "macos") {
            ("open", &[])
        } else if cfg!(windows) {
            ("cmd", &["/C", "start", ""])
        } else {
            ("xdg-open", &[])
        };
        let mut command = Command::new(program);
        let quiet = command.args(before).arg(url).stdin(Stdio::null()).stdout(Stdio::null());
        // Whoever has no browser has the address.
        let _ = quiet.stderr(Stdio::null()).spawn();
    }

    /// Answers until Ctrl-C.
    pub fn serve(&self, handler: &Arc<dyn Handler>, subscriptions: &Arc<Subscriptions>) {
        let (handler, subscriptions, port) = (Arc::clone(handler), Arc::clone(subscriptions), self.port);
        let answer = move |request: &Request| match is_ours(request, port) {
            true => respond(request, &*handler, &subscriptions),
            // A page from elsewhere whose name was made to lead here.
            false => text(403, "text/plain", "only for pages of this server"),
        };
        let answer: Arc<dyn Fn(&Request) -> Reply + Send + Sync> = Arc::new(answer);
        self.http.serve(&answer);
    }
}

fn respond(request: &Request, handler: &dyn Handler, subscriptions: &Subscriptions) -> Reply {
    let (path, query) = request.url.split_once('?').unwrap_or((&request.url, ""));
    if let Some(token) = handler.token() {
        let said = match path {
            // A browser sends no header with the address that it opens.
            "/" => query.strip_prefix("token="),
            _ => request.header("Lanewright-Token"),
        };
        if said != Some(token) {
            return text(403, "text/plain", "open the address that lanewright printed, with its token");
        }
    }
    match (request.method.as_str(), path) {
        ("GET", "/") => text(200, "text/html", &handler.page()),
        ("GET", "/data") => {
            let (version, data) = subscriptions.data();
            with(bytes(200, "application/octet-stream", data.to_vec()), "Lanewright-Version", version.to_string())
        }
        ("GET", "/changes") => {
            let after = query.strip_prefix("after=").and_then(|text| text.parse().ok()).unwrap_or_default();
            text(200, "application/json", &subscriptions.changes(after))
        }
        ("POST", path) => {
            // Before the answer: what comes meanwhile is news then.
            let (version, _) = subscriptions.data();
            let question = std::str::from_utf8(&request.body).ok();
            match question.and_then(|question| handler.post(path, question)) {
                Some(Ok(Answer { bytes: answer, name })) => {
                    let reply = bytes(200, "application/octet-stream", answer);
                    let reply = with(reply, "Lanewright-Version", version.to_string());
                    match name {
                        Some(name) => with(reply, "Lanewright-Name", percent(&name)),
                        None => reply,
                    }
                }
                // Told in the page: browsers would log another status as a fault of it.
                Some(Err(why)) => with(text(200, "text/plain", &why), "Lanewright-Version", version.to_string()),
                None => text(404, "text/plain", "nothing is here"),
            }
        }
        _ => text(404, "text/plain", "nothing is here"),
    }
}

/// Whether a request names this machine as its host, and comes from no other page than ours.
fn is_ours(request: &Request, port: u16) -> bool {
    let hosts = ["127.0.0.1", "localhost"].map(|host| format!("{host}:{port}"));
    let named = request.header("Host").is_some_and(|host| hosts.iter().any(|ours| ours.eq_ignore_ascii_case(host)));
    let origin = request.header("Origin").and_then(|origin| origin.strip_prefix("http://").or(Some("")));
    named && origin.is_none_or(|origin| hosts.iter().any(|ours| ours.eq_ignore_ascii_case(origin)))
}

fn text(status: u16, kind: &str, text: &str) -> Reply {
    bytes(status, &format!("{kind}; charset=utf-8"), text.as_bytes().to_vec())
}

fn bytes(status: u16, kind: &str, body: Vec<u8>) -> Reply {
    let headers = [
        ("Content-Type", kind),
        ("Cache-Control", "no-store"),
        ("X-Content-Type-Options", "nosniff"),
        ("Cross-Origin-Resource-Policy", "same-origin"),
        ("Content-Security-Policy", "frame-ancestors 'none'"),
    ];
    Reply { status, headers: headers.map(|(name, value)| (name, value.to_owned())).to_vec(), body }
}

fn with(mut reply: Reply, name: &'static str, value: String) -> Reply {
    reply.headers.push((name, value));
    reply
}

/// A name in letters that a header may hold.
fn percent(name: &str) -> String {
    let letter = |byte: u8| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'.' | b'-' | b'_' => char::from(byte).to_string(),
        _ => format!("%{byte:02X}"),
    };
    name.bytes().map(letter).collect()
}
