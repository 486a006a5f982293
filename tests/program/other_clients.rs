//! A controller polls the device during the test: three SLCAN connections, and a hub that makes one bus of them.

use crate::running::{Run, command, finished};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::process::{Child, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Forwards each frame of one connection to the others, and answers commands as an adapter does.
struct Hub {
    address: SocketAddr,
}

impl Hub {
    fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let ends: Arc<Mutex<Vec<TcpStream>>> = Arc::default();
        std::thread::spawn(move || {
            for (number, stream) in listener.incoming().flatten().enumerate() {
                stream.set_nodelay(true).unwrap();
                ends.lock().unwrap().push(stream.try_clone().unwrap());
                let ends = Arc::clone(&ends);
                std::thread::spawn(move || serve(number, stream, &ends));
            }
        });
        Self { address }
    }

    fn bus(&self) -> String {
        format!("slcan:tcp://{}", self.address)
    }
}

fn serve(number: usize, mut stream: TcpStream, ends: &Mutex<Vec<TcpStream>>) {
    let (mut line, mut bytes) = (Vec::new(), [0; 4096]);
    while let Ok(read @ 1..) = stream.read(&mut bytes) {
        for &byte in &bytes[..read] {
            line.push(byte);
            if byte != b'\r' {
                continue;
            }
            let line = std::mem::take(&mut line);
            let is_frame = matches!(line[0], b't' | b'T' | b'r' | b'R');
            // A connection may have been closed.
            for (other, end) in ends.lock().unwrap().iter_mut().enumerate() {
                let heard = if other == number { if is_frame { b"z\r" } else { &b"\r"[..] } } else { &line[..] };
                let _ = (is_frame || other == number).then(|| end.write_all(heard));
            }
        }
    }
}

/// A client that reads three objects in turn, one every 20 ms, and ignores the answers.
struct Controller(Arc<AtomicBool>);

impl Controller {
    fn start(hub: &Hub) -> Self {
        let mut stream = TcpStream::connect(hub.address).unwrap();
        stream.set_nodelay(true).unwrap();
        let mut answers = stream.try_clone().unwrap();
        std::thread::spawn(move || while answers.read(&mut [0; 4096]).is_ok_and(|read| read > 0) {});
        let ends = Arc::new(AtomicBool::new(false));
        let asked = Arc::clone(&ends);
        std::thread::spawn(move || {
            for object in ["001000", "011000", "181001"].iter().cycle() {
                let request = format!("t63F840{object}00000000\r");
                if asked.load(Ordering::Relaxed) || stream.write_all(request.as_bytes()).is_err() {
                    break;
                }
                std::thread::sleep(Duration::from_millis(20));
            }
        });
        Self(ends)
    }
}

impl Drop for Controller {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

struct Device(Child);

impl Device {
    fn start(model: &str, hub: &Hub) -> Self {
        let mut command = command(&["simulate", model, &hub.bus(), "--node", "63"]);
        let child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let device = Self(child);
        // The device has started when it answers.
        let mut stream = TcpStream::connect(hub.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_millis(100))).unwrap();
        let (mut heard, mut bytes) = (Vec::new(), [0; 4096]);
        for _ in 0..600 {
            stream.write_all(b"t63F84000100000000000\r").unwrap();
            std::thread::sleep(Duration::from_millis(100));
            if let Ok(read) = stream.read(&mut bytes) {
                heard.extend_from_slice(&bytes[..read]);
            }
            if heard.windows(7).any(|part| part == b"t5BF843") {
                return device;
            }
        }
        panic!("the simulated device does not answer: {}", String::from_utf8_lossy(&heard));
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A run while the controller polls the device, with more arguments.
fn tested(model: &str, more: &[&str]) -> Run {
    let hub = Hub::start();
    let _device = Device::start(model, &hub);
    let _controller = Controller::start(&hub);
    let bus = hub.bus();
    let args = ["test", &bus, "--node", "63", "--device", model, "--journal", "none", "--format", "json"];
    finished(command(&[&args, more].concat()).stdin(Stdio::null()).output().unwrap())
}

/// The cases with this verdict, each with its reason.
fn ending(document: &serde_json::Value, verdict: &str) -> Vec<String> {
    let ending = document["cases"].as_array().unwrap().iter().filter(|case| case["verdict"] == verdict);
    ending.map(|case| format!("{} {}", case["id"], case["reason"])).collect()
}

/// Runs the whole suite in parts at the same time, each on a bus of its own.
fn whole_suite(model: &'static str) {
    const PARTS: usize = 8;
    let runs: Vec<_> = (1..=PARTS)
        .map(|part| {
            let shard = format!("{part}/{PARTS}");
            std::thread::spawn(move || tested(model, &["--allow", "all", "--shard", &shard]))
        })
        .collect();
    let mut cases = 0;
    for run in runs.into_iter().map(|run| run.join().unwrap()) {
        let document: serde_json::Value =
            serde_json::from_str(&run.stdout).unwrap_or_else(|_| panic!("{}", run.stderr));
        assert_eq!([ending(&document, "fail"), ending(&document, "error")].concat(), Vec::<String>::new(), "{model}");
        let (passed, undecided) = (ending(&document, "pass").len(), ending(&document, "inconclusive"));
        assert!(undecided.len() * 10 <= passed, "{model}: {passed} passed, {undecided:#?}");
        let others = &document["other_clients"];
        assert_eq!((&others[0]["kind"], &others[0]["id"]), (&"sdo-read".into(), &0x63F.into()), "{others}");
        assert!(document["notices"].to_string().contains("another SDO client reads its objects ("), "{model}");
        cases += document["cases"].as_array().unwrap().len();
    }
    assert!(cases > 500, "{cases}");
}

#[test]
fn a_device_that_is_polled_fails_nothing() {
    whole_suite("reference-301");
}

#[test]
fn an_encoder_that_is_polled_fails_nothing() {
    whole_suite("kuebler-sendix-58x8");
}

/// While a controller runs, the device is not reset, unless the user allows it.
#[test]
fn a_device_that_others_use_is_left_alone() {
    let run = tested("reference-301", &["--select", "301/nmt"]);
    assert_eq!((run.status, run.stdout.as_str()), (3, ""), "{}", run.stderr);
    for part in
        ["other clients use node 63", "another SDO client reads its objects (", "CAN-ID 63F", "--allow other-clients"]
    {
        assert!(run.stderr.contains(part), "{part}: {}", run.stderr);
    }
}
