//! As much of the WebDriver protocol as the tests need.
//!
//! Why none of the published clients: fantoccini 0.22, without TLS, brings 58 crates that nothing else in this workspace
//! needs (an asynchronous runtime, hyper, `time`, URLs with their tables); thirtyfour 0.36 brings 46 and then has no HTTP
//! client at all. The tests are blocking and need Chromium's own commands (DevTools) anyway.

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A browser window with one page.
pub struct Browser {
    driver: Child,
    port: u16,
    session: String,
    _profile: tempfile::TempDir,
}

/// A window as large as a desk has, or a phone.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Screen {
    Desk,
    Phone,
}

/// The key that W3C WebDriver gives elements.
const ELEMENT: &str = "element-6066-11e4-a52e-4f735466cecf";

impl Browser {
    /// Opens a file in a browser that knows nothing of any other.
    pub fn open(page: &Path, screen: Screen) -> Self {
        Self::prepared(&url(page), screen, |_| {})
    }

    /// Opens an address, once a browser was made ready for it.
    pub fn prepared(address: &str, screen: Screen, prepare: impl FnOnce(&Self)) -> Self {
        let mut driver = Command::new("chromedriver")
            .arg("--port=0")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("chromedriver: cargo xtask ci installs it");
        let port = port(&mut driver);
        let profile = tempfile::tempdir().unwrap();
        let mut browser = Self { driver, port, session: String::new(), _profile: profile };
        let mut options = json!({ "args": [
            "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-dev-shm-usage",
            "--disable-background-networking", "--disable-component-update", "--force-prefers-reduced-motion", "--disable-sync", "--window-size=1280,900",
            format!("--user-data-dir={}", browser._profile.path().display()),
        ] });
        if screen == Screen::Phone {
            options["mobileEmulation"] =
                json!({ "deviceMetrics": { "width": 390, "height": 800, "pixelRatio": 2, "touch": true } });
        }
        let capabilities = json!({ "capabilities": { "alwaysMatch": {
            "goog:chromeOptions": options,
            "goog:loggingPrefs": { "browser": "ALL", "performance": "ALL" },
        } } });
        let session = browser.request("POST", "/session", &capabilities);
        browser.session = session["sessionId"].as_str().unwrap().to_owned();
        // What a new window does is no matter of the page.
        browser.post("url", &json!({ "url": "about:blank" }));
        browser.post("se/log", &json!({ "type": "performance" }));
        browser.post("se/log", &json!({ "type": "browser" }));
        prepare(&browser);
        browser.go(address);
        browser
    }

    /// Goes to an address.
    pub fn go(&self, address: &str) {
        self.post("url", &json!({ "url": address }));
    }

    /// A command of the browser's own protocol.
    pub fn command(&self, name: &str, parameters: &Value) -> Value {
        self.post("goog/cdp/execute", &json!({ "cmd": name, "params": parameters }))
    }

    /// What is to be seen, as PNG in base64.
    pub fn picture(&self) -> String {
        self.request("GET", &format!("/session/{}/screenshot", self.session), &json!({})).as_str().unwrap().to_owned()
    }

    /// The memory of its own that the process of the page takes now, in kB: what it shares with others, as the browser's own
    /// code, does not count. Of several pages that of the largest.
    pub fn memory(&self) -> std::io::Result<u64> {
        let mut most = 0;
        for process in descendants(self.driver.id())? {
            let file = |name: &str| std::fs::read_to_string(format!("/proc/{process}/{name}"));
            let shows = file("cmdline").is_ok_and(|words| words.contains("--type=renderer"));
            let status = file("status").unwrap_or_default();
            let own = status.lines().find_map(|line| line.strip_prefix("RssAnon:")?.trim().strip_suffix("kB"));
            most = most.max(own.filter(|_| shows).map_or(0, |own| own.trim().parse().unwrap_or(0)));
        }
        Ok(most)
    }

    /// Runs a function's body in the page, and gives what it returns.
    pub fn run(&self, script: &str) -> Value {
        self.post("execute/sync", &json!({ "script": script, "args": [] }))
    }

    /// The same where it returns a number.
    #[track_caller]
    pub fn number(&self, script: &str) -> f64 {
        let value = self.run(script);
        value.as_f64().unwrap_or_else(|| panic!("{script}: {value}"))
    }

    /// The same where it returns a text.
    #[track_caller]
    pub fn text(&self, script: &str) -> String {
        let value = self.run(script);
        value.as_str().unwrap_or_else(|| panic!("{script}: {value}")).to_owned()
    }

    /// Waits until an expression holds: what a page does next, it does soon.
    #[track_caller]
    pub fn wait(&self, expression: &str) {
        self.wait_for(expression, Duration::from_secs(20));
    }

    /// The same of what takes longer.
    #[track_caller]
    pub fn wait_for(&self, expression: &str, longest: Duration) {
        let begin = Instant::now();
        while self.run(&format!("return Boolean({expression})")) != Value::Bool(true) {
            assert!(begin.elapsed() < longest, "{expression} does not come true");
        }
    }

    /// Clicks on what a selector finds first, as a person does: it must be visible, and nothing may cover it.
    pub fn click(&self, selector: &str) {
        let selector_text = serde_json::to_string(selector).unwrap();
        self.run(&format!("document.querySelector({selector_text}).scrollIntoView({{ block: 'center' }})"));
        let element = self.find(selector);
        self.post(&format!("element/{element}/click"), &json!({}));
    }

    /// Types into what a selector finds first.
    pub fn fill(&self, selector: &str, text: &str) {
        let element = self.find(selector);
        self.post(&format!("element/{element}/value"), &json!({ "text": text }));
    }

    /// Drags the mouse across an element, from one part of its width to another, once it is there.
    pub fn drag(&self, selector: &str, from: f64, to: f64, with_shift: bool) {
        self.wait(&format!("document.querySelector('{selector}')"));
        self.run(&format!(
            "document.querySelector('{selector}').scrollIntoView({{ block: 'center', behavior: 'instant' }})"
        ));
        let width = self.number(&format!("return document.querySelector('{selector}').getBoundingClientRect().width"));
        // From its middle: counted from the window's corner, a frame within the page would be somewhere else.
        let origin = json!({ ELEMENT: self.find(selector) });
        let moved = |part: f64| json!({ "type": "pointerMove", "duration": 50, "origin": origin, "x": (width * (part - 0.5)) as i64, "y": 0 });
        let pause = json!({ "type": "pause" });
        let key = |kind: &str| if with_shift { json!({ "type": kind, "value": "\u{E008}" }) } else { pause.clone() };
        let keys = json!([pause, key("keyDown"), pause, pause, pause, pause, key("keyUp")]);
        let steps = json!([
            moved(from), pause, { "type": "pointerDown", "button": 0 }, moved((from + to) / 2.0), moved(to),
            { "type": "pointerUp", "button": 0 }, pause,
        ]);
        self.post(
            "actions",
            &json!({ "actions": [
            { "type": "key", "id": "keyboard", "actions": keys },
            { "type": "pointer", "id": "mouse", "parameters": { "pointerType": "mouse" }, "actions": steps },
        ] }),
        );
    }

    /// Presses a key in what a selector finds first.
    pub fn press(&self, selector: &str, key: &str) {
        self.run(&format!("document.querySelector('{selector}').focus({{ preventScroll: true }})"));
        self.post(
            "actions",
            &json!({ "actions": [{ "type": "key", "id": "keyboard", "actions": [
            { "type": "keyDown", "value": key }, { "type": "keyUp", "value": key },
        ] }] }),
        );
    }

    /// Does something in the frame that a selector finds first.
    pub fn within(&self, selector: &str, act: impl FnOnce(&Self)) {
        let frame = self.find(selector);
        self.post("frame", &json!({ "id": { ELEMENT: frame } }));
        act(self);
        self.post("frame", &json!({ "id": null }));
    }

    /// The page as it would be printed.
    pub fn print(&self) -> String {
        self.post("print", &json!({})).as_str().unwrap().to_owned()
    }

    /// Nothing went wrong in the page, nothing was refused by its policy, and nothing but the page itself was asked for.
    #[track_caller]
    pub fn is_quiet(&self) {
        let said = self.post("se/log", &json!({ "type": "browser" }));
        assert_eq!(said, json!([]), "the console");
        let log = self.post("se/log", &json!({ "type": "performance" }));
        let events = log.as_array().unwrap().iter();
        let messages = events.map(|entry| serde_json::from_str::<Value>(entry["message"].as_str().unwrap()).unwrap());
        let requests: Vec<String> = messages
            .filter(|event| event["message"]["method"] == "Network.requestWillBeSent")
            .filter(|event| !event["message"]["params"]["documentURL"].as_str().unwrap().starts_with("chrome://"))
            .map(|event| event["message"]["params"]["request"]["url"].as_str().unwrap().to_owned())
            .collect();
        let own = self.text("return location.href.split('#')[0]");
        let others: Vec<_> =
            requests.iter().filter(|url| url.split('#').next() != Some(&own) && !is_within(url)).collect();
        assert!(!requests.is_empty(), "the page itself at least");
        assert!(others.is_empty(), "requests: {others:?}");
    }

    fn find(&self, selector: &str) -> String {
        let found = self.post("element", &json!({ "using": "css selector", "value": selector }));
        found[ELEMENT].as_str().unwrap().to_owned()
    }

    fn post(&self, command: &str, body: &Value) -> Value {
        self.request("POST", &format!("/session/{}/{command}", self.session), body)
    }

    #[track_caller]
    fn request(&self, method: &str, path: &str, body: &Value) -> Value {
        let body = body.to_string();
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(120))).unwrap();
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nHost: localhost:{}\r\nContent-Type: application/json\r\n\
             Content-Length: {}\r\nConnection: close\r\n\r\n{body}",
            self.port,
            body.len()
        )
        .unwrap();
        let answer: Value = serde_json::from_slice(&content(stream)).unwrap();
        let value = answer["value"].clone();
        assert!(value.get("error").is_none(), "{path} {body}: {}: {}", value["error"], value["message"]);
        value
    }
}

/// The body of an HTTP response.
fn content(stream: TcpStream) -> Vec<u8> {
    let mut reader = BufReader::new(stream);
    let mut length = 0;
    loop {
        let mut line = String::new();
        reader.read_line(&mut line).unwrap();
        let line = line.trim_end().to_ascii_lowercase();
        if line.is_empty() {
            break;
        }
        if let Some(value) = line.strip_prefix("content-length:") {
            length = value.trim().parse().unwrap();
        }
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body).unwrap();
    body
}

/// The port that chromedriver has chosen, which it tells.
fn port(driver: &mut Child) -> u16 {
    let mut lines = BufReader::new(driver.stdout.take().unwrap()).lines();
    let port = lines.by_ref().map(Result::unwrap).find_map(|line| {
        let port = line.split_once("on port ")?.1.trim_end_matches('.').parse().ok()?;
        line.contains("successfully").then_some(port)
    });
    // It may go on to speak.
    std::thread::spawn(move || lines.for_each(drop));
    port.expect("chromedriver tells its port")
}

/// A process's children, and theirs.
fn descendants(ancestor: u32) -> std::io::Result<Vec<u32>> {
    let parent = |process: u32| {
        let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
        status.lines().find_map(|line| line.strip_prefix("PPid:")?.trim().parse::<u32>().ok())
    };
    let processes = std::fs::read_dir("/proc")?.flatten().filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    let is_of = |process: &u32| {
        let line = std::iter::successors(parent(*process), |above| parent(*above).filter(|above| *above > 0));
        line.take(50).any(|above| above == ancestor)
    };
    Ok(processes.filter(is_of).collect())
}

/// Whether an address is that of something that stands in the page.
fn is_within(url: &str) -> bool {
    url.starts_with("data:image/svg+xml") || url.starts_with("blob:")
}

/// A file as an address: whatever is in its name.
pub fn url(path: &Path) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/-_.".contains(&byte);
    let path = path.to_str().unwrap().bytes();
    let escaped = path.map(|byte| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") });
    format!("file://{}", escaped.collect::<String>())
}

impl Drop for Browser {
    fn drop(&mut self) {
        if !self.session.is_empty() && !std::thread::panicking() {
            self.request("DELETE", &format!("/session/{}", self.session), &json!({}));
        }
        // Its end takes the browser with it.
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }
}
