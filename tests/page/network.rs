//! No script can send data out of the page, and the page works without a network.

use crate::opened::Opened;
use canvass_webdriver::{Browser, Screen};
use serde_json::json;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// All ways in which a script could reach the network, each in a promise that tells whether the browser refused it.
const TRIES: &str = "
    const element = (name, attributes) => new Promise((resolve) => {
        const made = Object.assign(document.createElement(name), attributes);
        made.onerror = () => resolve(true);
        made.onload = () => resolve(name === 'iframe' && !made.contentDocument ? true : false);
        document.addEventListener('securitypolicyviolation', () => resolve(true), { once: true });
        document.body.append(made);
    });
    const tries = {
        fetch: () => fetch(url).then(() => false, () => true),
        request: () => new Promise((resolve) => {
            const request = new XMLHttpRequest();
            request.onerror = () => resolve(true);
            request.onload = () => resolve(false);
            request.open('GET', url);
            request.send();
        }),
        socket: () => new Promise((resolve) => {
            try {
                const socket = new WebSocket(url.replace('http', 'ws'));
                socket.onerror = () => resolve(true);
                socket.onopen = () => resolve(false);
            } catch { resolve(true); }
        }),
        events: () => new Promise((resolve) => { new EventSource(url).onerror = () => resolve(true); }),
        beacon: () => { navigator.sendBeacon(url, 'x'); return true; },
        image: () => element('img', { src: url }),
        script: () => element('script', { src: url }),
        style: () => element('link', { rel: 'stylesheet', href: url }),
        frame: () => element('iframe', { src: url }),
        object: () => element('object', { data: url }),
        video: () => element('video', { src: url }),
        worker: () => new Promise((resolve) => {
            try { new Worker(url).onerror = () => resolve(true); } catch { resolve(true); }
        }),
        form: () => {
            const form = document.createElement('form');
            Object.assign(form, { action: url, method: 'post', target: '_self' });
            document.body.append(form);
            form.submit();
            return true;
        },
    };
    // Trusted Types refuse some of these ways before a request is made.
    const refused = async (act) => { try { return await act(); } catch { return true; } };
    // A request that is neither refused nor answered would reach the listening server.
    const late = () => new Promise((resolve) => setTimeout(() => resolve(true), 3000));
    return Promise.all(Object.entries(tries).map(async ([name, act]) => [name, await Promise.race([refused(act), late()])]))
        .then((all) => all.filter(([, refused]) => !refused).map(([name]) => name).join());";

#[test]
fn the_policy_refuses_every_request() {
    let opened = Opened::with(Screen::Desk, "a.log", "(1700000000.000000) can0 705#00\n");
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    server.set_nonblocking(true).unwrap();
    let script = format!("const url = 'http://{}/'; {TRIES}", server.local_addr().unwrap());
    assert_eq!(opened.browser.text(&script), "", "in the page");
    opened.browser.wait("document.querySelector('#view-diagnosis iframe')");
    opened.browser.within("#view-diagnosis iframe", |browser| {
        browser.wait("document.querySelector('h1')");
        assert_eq!(browser.text(&script), "", "in the report");
    });
    called(&server);
}

/// Checks that no request has arrived. For a navigation that the policy refuses, Chromium opens a connection in
/// advance; it may carry no bytes.
fn called(server: &TcpListener) {
    loop {
        match server.accept() {
            Ok((mut caller, _)) => {
                caller.set_read_timeout(Some(std::time::Duration::from_millis(500))).unwrap();
                let mut request = [0; 1000];
                let read = caller.read(&mut request).unwrap_or(0);
                assert_eq!(String::from_utf8_lossy(&request[..read]), "", "somebody has called");
            }
            Err(error) => return assert_eq!(error.kind(), ErrorKind::WouldBlock),
        }
    }
}

/// A server of the page's folder, until it is stopped.
struct Server {
    address: String,
    ends: Arc<AtomicBool>,
}

impl Server {
    fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let ends = Arc::new(AtomicBool::new(false));
        let ended = ends.clone();
        std::thread::spawn(move || {
            for stream in listener.incoming() {
                if ended.load(Ordering::SeqCst) {
                    return;
                }
                // A browser opens connections that it does not use.
                std::thread::spawn(move || serve(stream.unwrap()));
            }
        });
        Self { address, ends }
    }

    fn end(&self) {
        self.ends.store(true, Ordering::SeqCst);
        drop(TcpStream::connect(&self.address));
    }
}

fn serve(mut stream: TcpStream) {
    let mut request = [0; 4096];
    let read = stream.read(&mut request).unwrap_or(0);
    let text = String::from_utf8_lossy(&request[..read]).into_owned();
    let Some(name) = text.split_whitespace().nth(1).map(|path| path.trim_start_matches('/')) else { return };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/page/folder");
    let kind = match name.rsplit_once('.').map(|(_, ending)| ending) {
        Some("html") => "text/html",
        Some("js") => "text/javascript",
        Some("svg") => "image/svg+xml",
        Some("png") => "image/png",
        _ => "application/manifest+json",
    };
    let (status, body) = match std::fs::read(folder.join(name)) {
        Ok(body) => ("200 OK", body),
        Err(_) => ("404 Not Found", Vec::new()),
    };
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
        body.len()
    );
    // The browser may have closed the connection.
    let _ = stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(&body));
}

#[test]
fn installed_from_a_server_it_works_without_one() {
    let server = Server::start();
    let address = format!("http://{}/index.html", server.address);
    let browser = Browser::prepared(&address, Screen::Desk, |_| {});
    browser.wait("document.documentElement.dataset.ready === 'yes'");
    browser.run("return navigator.serviceWorker.ready.then(() => true)");
    let manifest = browser.command("Page.getAppManifest", &json!({}));
    assert_eq!(manifest["errors"], json!([]));
    assert!(manifest["data"].as_str().unwrap().contains("CANopen"), "{manifest}");
    server.end();
    browser.go("about:blank");
    browser.go(&address);
    browser.wait("document.documentElement.dataset.ready === 'yes'");
    let folder = tempfile::tempdir().unwrap();
    let capture = folder.path().join("a.log");
    std::fs::write(&capture, "(1700000000.000000) can0 705#00\n").unwrap();
    browser.fill("#files", capture.to_str().unwrap());
    browser.wait("/1 frame, /.test(document.getElementById('status').textContent)");
}
