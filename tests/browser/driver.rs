//! A browser at the end of a wire: Chromium through its driver, in the WebDriver protocol, as far as the tests need it.

use std::cell::RefCell;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use crate::common::needs::skip;

/// Where Debian's package `chromium` puts the browser.
const CHROMIUM: &str = "/usr/bin/chromium";
/// The same for `chromium-driver`.
const DRIVER: &str = "/usr/bin/chromedriver";
/// A page that is not ready after this long is broken, even on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// How often the driver is started until it says its port.
const STARTS: usize = 5;

/// One window. Closed, with its driver, when dropped.
pub struct Browser {
    driver: Child,
    port: u16,
    session: String,
    /// Address of the server whose pages are shown; what they ask of it is no complaint.
    home: RefCell<Option<String>>,
    _profile: tempfile::TempDir,
}

/// A driver with its port; `None` if it ends without one.
fn start_driver() -> Option<(Child, u16)> {
    let mut driver = Command::new(DRIVER)
        .arg("--port=0")
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the driver starts");
    let mut lines = BufReader::new(driver.stdout.take().unwrap()).lines();
    let said = lines
        .by_ref()
        .map_while(Result::ok)
        .find_map(|line| line.split_once("started successfully on port ")?.1.trim_end_matches('.').parse().ok());
    match said {
        Some(port) => Some((driver, port)),
        None => {
            _ = driver.wait();
            None
        }
    }
}

impl Browser {
    /// Starts a browser with a window of this size; `None`, noted as skipped, where there is none on this machine.
    pub fn start(width: u32, height: u32) -> Option<Self> {
        if !Path::new(CHROMIUM).exists() || !Path::new(DRIVER).exists() {
            return skip("no browser here; apt-get install chromium chromium-driver");
        }
        let profile = tempfile::tempdir().unwrap();
        // The port that is free for one kind of address may be taken for the other; then the driver ends at once.
        let (driver, port) = (0..STARTS).find_map(|_| start_driver()).expect("the driver says its port");
        let mut browser = Self { driver, port, session: String::new(), home: RefCell::default(), _profile: profile };
        let data = format!("--user-data-dir={}", browser._profile.path().display());
        let size = format!("--window-size={width},{height}");
        let capabilities = json!({ "capabilities": { "alwaysMatch": {
            "goog:chromeOptions": { "binary": CHROMIUM, "args": [
                "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars",
                "--disable-background-networking", "--disable-component-update", "--disable-sync", data, size,
            ] },
            "goog:loggingPrefs": { "browser": "ALL", "performance": "ALL" },
        } } });
        let answer = browser.call("POST", "", &capabilities);
        browser.session = answer["sessionId"].as_str().unwrap_or_else(|| panic!("no session: {answer}")).to_owned();
        Some(browser)
    }

    /// One call of the protocol; the answer's `value`.
    fn call(&self, method: &str, path: &str, body: &Value) -> Value {
        let value = self.send(method, path, body).unwrap_or_else(|error| panic!("{method} {path}: {error}"));
        assert!(value.get("error").is_none(), "{method} {path}: {value}");
        value
    }

    fn send(&self, method: &str, path: &str, body: &Value) -> std::io::Result<Value> {
        let session = if self.session.is_empty() { String::new() } else { format!("/{}", self.session) };
        let body = if method == "POST" { body.to_string() } else { String::new() };
        let mut stream = TcpStream::connect(("127.0.0.1", self.port))?;
        stream.set_read_timeout(Some(PATIENCE))?;
        write!(
            stream,
            "{method} /session{session}{path} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\
             Content-Type: application/json\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        )?;
        let mut reader = BufReader::new(stream);
        let mut length = 0;
        loop {
            let mut line = String::new();
            reader.read_line(&mut line)?;
            if let Some(value) = line.to_ascii_lowercase().strip_prefix("content-length:") {
                length = value.trim().parse().map_err(std::io::Error::other)?;
            }
            if line.trim().is_empty() {
                break;
            }
        }
        let mut bytes = vec![0; length];
        reader.read_exact(&mut bytes)?;
        let mut answer: Value = serde_json::from_slice(&bytes)?;
        Ok(answer["value"].take())
    }

    /// Runs a script before those of every page that is opened from now on.
    pub fn before_each_page(&self, script: &str) {
        let command = json!({ "cmd": "Page.addScriptToEvaluateOnNewDocument", "params": { "source": script } });
        self.call("POST", "/goog/cdp/execute", &command);
    }

    /// Opens a report from a file, at a link inside it, and waits until it is ready.
    pub fn open(&self, file: &Path, link: &str) {
        // Another link of the same file would not load it anew.
        self.call("POST", "/url", &json!({ "url": "about:blank" }));
        self.call("POST", "/url", &json!({ "url": format!("file://{}{link}", file.display()) }));
        self.wait("document.documentElement.dataset.ready && document.getElementById('map').dataset.centre");
    }

    /// Opens the page of a server, and waits until it is ready.
    pub fn visit(&self, url: &str) {
        *self.home.borrow_mut() = url.split('?').next().map(str::to_owned);
        self.call("POST", "/url", &json!({ "url": url }));
        self.wait("document.documentElement.dataset.ready && document.getElementById('map').dataset.centre");
    }

    /// What a script returns.
    pub fn run(&self, script: &str) -> Value {
        self.call("POST", "/execute/sync", &json!({ "script": script, "args": [] }))
    }

    /// The value of an expression.
    pub fn value(&self, expression: &str) -> Value {
        self.run(&format!("return {expression}"))
    }

    /// Waits until an expression is true.
    pub fn wait(&self, expression: &str) {
        let start = Instant::now();
        while self.value(&format!("Boolean({expression})")) != json!(true) {
            assert!(start.elapsed() < PATIENCE, "never true: {expression}\nconsole: {:?}", self.complaints());
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// A click of the left button at a place in the window.
    pub fn click(&self, x: f64, y: f64) {
        let (x, y) = (x.round() as i64, y.round() as i64);
        self.call(
            "POST",
            "/actions",
            &json!({ "actions": [{
            "type": "pointer", "id": "mouse", "parameters": { "pointerType": "mouse" }, "actions": [
                { "type": "pointerMove", "duration": 0, "x": x, "y": y },
                { "type": "pointerDown", "button": 0 }, { "type": "pointerUp", "button": 0 },
            ],
        }] }),
        );
    }

    /// A drag of the left button from place to place in the window, with a key held down if there is one.
    pub fn drag(&self, from: [f64; 2], to: [f64; 2], key: Option<char>) {
        let point = |[x, y]: [f64; 2]| (x.round() as i64, y.round() as i64);
        let (from, to) = (point(from), point(to));
        let middle = ((from.0 + to.0) / 2, (from.1 + to.1) / 2);
        let go = |(x, y): (i64, i64)| json!({ "type": "pointerMove", "duration": 0, "x": x, "y": y });
        let pause = || json!({ "type": "pause", "duration": 0 });
        let (down, up) = (json!({ "type": "pointerDown", "button": 0 }), json!({ "type": "pointerUp", "button": 0 }));
        let mouse = [pause(), go(from), down, go(middle), go(to), up, pause()];
        let mut devices = vec![json!({
            "type": "pointer", "id": "mouse", "parameters": { "pointerType": "mouse" }, "actions": mouse,
        })];
        if let Some(key) = key {
            let mut keys = vec![pause(); mouse.len()];
            keys[0] = json!({ "type": "keyDown", "value": key });
            keys[mouse.len() - 1] = json!({ "type": "keyUp", "value": key });
            devices.push(json!({ "type": "key", "id": "keys", "actions": keys }));
        }
        self.call("POST", "/actions", &json!({ "actions": devices }));
    }

    /// Presses keys, one after the other.
    pub fn press(&self, keys: &str) {
        let each = |key: char| [json!({ "type": "keyDown", "value": key }), json!({ "type": "keyUp", "value": key })];
        let actions: Vec<Value> = keys.chars().flat_map(each).collect();
        self.call("POST", "/actions", &json!({ "actions": [{ "type": "key", "id": "keys", "actions": actions }] }));
    }

    /// Saves what the window shows beside the other things that tests write, for people to look at.
    pub fn picture(&self, name: &str) {
        let picture = self.call("GET", "/screenshot", &Value::Null);
        let bytes = STANDARD.decode(picture.as_str().unwrap()).unwrap();
        std::fs::write(Path::new(env!("CARGO_TARGET_TMPDIR")).join(name), bytes).unwrap();
    }

    /// Errors and warnings of the console since the last call, and requests that left the page.
    pub fn complaints(&self) -> Vec<String> {
        let entries = |kind: &str| self.call("POST", "/se/log", &json!({ "type": kind })).as_array().cloned();
        let console = entries("browser").unwrap_or_default().into_iter();
        let console = console.map(|entry| entry["message"].as_str().unwrap_or_default().to_owned());
        let requests = entries("performance").unwrap_or_default().into_iter().filter_map(|entry| {
            let message: Value = serde_json::from_str(entry["message"].as_str()?).ok()?;
            let message = &message["message"];
            let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
            let (page, url) = (text(&message["params"]["documentURL"]), text(&message["params"]["request"]["url"]));
            // The browser's own first page is none of ours.
            let ours = message["method"] == "Network.requestWillBeSent" && !page.starts_with("chrome");
            let inside = ["file:", "data:", "about:"].iter().any(|scheme| url.starts_with(scheme))
                || self.home.borrow().as_ref().is_some_and(|home| url.starts_with(home.as_str()));
            (ours && !inside).then(|| format!("request: {url}"))
        });
        console.chain(requests).collect()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Ends the browser; without this it would outlive its driver.
        let _ = self.send("DELETE", "", &Value::Null);
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }
}
