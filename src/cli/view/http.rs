//! Requests of browsers, read within bounds: so many connections at a time, so long a head and a body, so much time for both.

use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Connections at a time; a browser opens six, some of which wait for news. Far fewer than a process may have files open.
const MOST_CONNECTIONS: usize = 64;
/// Bytes of a request's head.
const LONGEST_HEAD: usize = 16 << 10;
/// Lines of it.
const MOST_HEADERS: usize = 64;
/// Bytes of what is posted: no question of a page is longer.
const LONGEST_BODY: usize = 8 << 20;
/// A request is there by then, head and body, or nobody waits for it any longer.
const SLOWEST: Duration = Duration::from_secs(10);
/// An answer is taken by then, piece by piece.
const SLOWEST_READER: Duration = Duration::from_secs(30);
/// Where the system has no connection to give, it is asked again after this.
const PAUSE: Duration = Duration::from_millis(50);

/// What is asked for.
#[derive(Debug)]
pub struct Request {
    /// `GET`, `POST` or another.
    pub method: String,
    /// The path, and behind a `?` the query.
    pub url: String,
    headers: Vec<(String, String)>,
    /// What is posted.
    pub body: Vec<u8>,
}

impl Request {
    /// The first header of a name.
    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(own, _)| own.eq_ignore_ascii_case(name)).map(|(_, value)| value.as_str())
    }
}

/// What is answered.
#[derive(Debug)]
pub struct Reply {
    /// Such as 200.
    pub status: u16,
    /// Names and values, in letters that a head may hold.
    pub headers: Vec<(&'static str, String)>,
    /// The content.
    pub body: Vec<u8>,
}

/// Why there is no request.
enum Unread {
    /// It is answered with this status, if anybody listens.
    Refused(u16),
    /// Whoever began it is gone, or says nothing more.
    Gone,
}

/// Accepts connections until it is ended.
#[derive(Debug)]
pub struct Listener {
    listener: TcpListener,
    ended: AtomicBool,
    open: Arc<AtomicUsize>,
}

impl Listener {
    /// Takes a port of this machine, or one that the system chooses.
    pub fn bind(port: u16) -> io::Result<Self> {
        let listener = TcpListener::bind((std::net::Ipv4Addr::LOCALHOST, port))?;
        Ok(Self { listener, ended: AtomicBool::new(false), open: Arc::default() })
    }

    /// Where it listens.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Lets [`Listener::serve`] end.
    pub fn end(&self) {
        self.ended.store(true, Ordering::SeqCst);
        // It waits for a connection.
        let _ = self.address().and_then(|address| TcpStream::connect_timeout(&address, PAUSE));
    }

    /// Answers each request in a thread of its own, because some wait for news. A connection that cannot be had, and one too many,
    /// end nothing.
    pub fn serve(&self, answer: &Arc<dyn Fn(&Request) -> Reply + Send + Sync>) {
        while !self.ended.load(Ordering::SeqCst) {
            let Ok((mut stream, _)) = self.listener.accept() else {
                // No more files may be open: those that are will be closed.
                std::thread::sleep(PAUSE);
                continue;
            };
            let Some(place) = Place::take(&self.open) else {
                write(&mut stream, &Reply { status: 503, headers: Vec::new(), body: Vec::new() });
                continue;
            };
            let answer = Arc::clone(answer);
            let work = move || {
                let _place = place;
                converse(stream, &*answer);
            };
            // Where there is no thread, the connection is closed.
            drop(std::thread::Builder::new().spawn(work));
        }
    }
}

/// One of the places for connections, free again when it is dropped.
struct Place(Arc<AtomicUsize>);

impl Place {
    fn take(open: &Arc<AtomicUsize>) -> Option<Self> {
        let more = |now: usize| (now < MOST_CONNECTIONS).then_some(now + 1);
        open.fetch_update(Ordering::SeqCst, Ordering::SeqCst, more).ok().map(|_| Self(Arc::clone(open)))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

fn converse(mut stream: TcpStream, answer: &dyn Fn(&Request) -> Reply) {
    match read(&mut stream) {
        Ok(request) => send(&mut stream, &answer(&request)),
        Err(Unread::Refused(status)) => refuse(stream, status),
        Err(Unread::Gone) => {}
    }
}

fn refuse(mut stream: TcpStream, status: u16) {
    send(&mut stream, &Reply { status, headers: Vec::new(), body: Vec::new() });
}

/// Reads the head and the body of a request.
fn read(stream: &mut TcpStream) -> Result<Request, Unread> {
    let until = Instant::now() + SLOWEST;
    let mut bytes = Vec::new();
    let (mut request, head, length) = loop {
        more(stream, &mut bytes, until)?;
        if let Some(head) = parsed(&bytes)? {
            break head;
        }
        if bytes.len() > LONGEST_HEAD {
            return Err(Unread::Refused(431));
        }
    };
    if length > LONGEST_BODY {
        return Err(Unread::Refused(413));
    }
    if request.header("Expect").is_some() && bytes.len() < head + length {
        stream.write_all(b"HTTP/1.1 100 Continue\r\n\r\n").map_err(|_| Unread::Gone)?;
    }
    while bytes.len() < head + length {
        more(stream, &mut bytes, until)?;
    }
    request.body = bytes.get(head..head + length).unwrap_or_default().to_vec();
    Ok(request)
}

/// Reads what is there, or waits for it.
fn more(stream: &mut TcpStream, bytes: &mut Vec<u8>, until: Instant) -> Result<(), Unread> {
    let mut piece = [0; 8192];
    let left = until.saturating_duration_since(Instant::now());
    if left.is_zero() || stream.set_read_timeout(Some(left)).is_err() {
        return Err(Unread::Refused(408));
    }
    match stream.read(&mut piece) {
        Ok(0) => Err(Unread::Gone),
        Ok(length) => {
            bytes.extend_from_slice(piece.get(..length).unwrap_or_default());
            Ok(())
        }
        Err(error) if error.kind() == io::ErrorKind::Interrupted => Ok(()),
        Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {
            Err(Unread::Refused(408))
        }
        Err(_) => Err(Unread::Gone),
    }
}

/// The request without its body, where its head is there; how long the head is, and how long the body.
fn parsed(bytes: &[u8]) -> Result<Option<(Request, usize, usize)>, Unread> {
    let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
    let mut request = httparse::Request::new(&mut headers);
    let head = match request.parse(bytes) {
        Ok(httparse::Status::Complete(head)) => head,
        Ok(httparse::Status::Partial) => return Ok(None),
        Err(httparse::Error::TooManyHeaders) => return Err(Unread::Refused(431)),
        Err(_) => return Err(Unread::Refused(400)),
    };
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let headers = request.headers.iter().map(|header| (header.name.to_owned(), text(header.value)));
    let read = Request {
        method: request.method.unwrap_or_default().to_owned(),
        url: request.path.unwrap_or_default().to_owned(),
        headers: headers.collect(),
        body: Vec::new(),
    };
    // Browsers say how long it is; who sends it in pieces, or says two lengths, means no good.
    let lengths = read.headers.iter().filter(|(name, _)| name.eq_ignore_ascii_case("Content-Length"));
    let lengths: Vec<Option<usize>> = lengths.map(|(_, value)| value.trim().parse().ok()).collect();
    match (read.header("Transfer-Encoding"), &lengths[..]) {
        (None, []) => Ok(Some((read, head, 0))),
        (None, [Some(length)]) => Ok(Some((read, head, *length))),
        _ => Err(Unread::Refused(400)),
    }
}

/// Sends an answer, after which the connection is closed. Whoever asked may be gone.
fn send(stream: &mut TcpStream, reply: &Reply) {
    if write(stream, reply) && reply.status != 200 {
        // What was not read would let the system take the answer back.
        let _ = stream.set_read_timeout(Some(PAUSE));
        let mut rest = [0; 8192];
        for _ in 0..LONGEST_HEAD / rest.len() * 2 {
            if !stream.read(&mut rest).is_ok_and(|length| length > 0) {
                break;
            }
        }
    }
}

/// Writes an answer; whether it went out.
fn write(stream: &mut TcpStream, reply: &Reply) -> bool {
    let word = match reply.status {
        200 => "OK",
        _ => "No",
    };
    let mut head = format!("HTTP/1.1 {} {word}\r\n", reply.status);
    for (name, value) in &reply.headers {
        head.push_str(&format!("{name}: {value}\r\n"));
    }
    head.push_str(&format!("Content-Length: {}\r\nConnection: close\r\n\r\n", reply.body.len()));
    let _ = stream.set_write_timeout(Some(SLOWEST_READER));
    let sent = stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(&reply.body));
    sent.and_then(|()| stream.shutdown(std::net::Shutdown::Write)).is_ok()
}
