//! The commands for live buses: on the simulated bus, and in two processes with an SLCAN connection between them.

use crate::proxy::Proxy;
use crate::running::{Run, command, run};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};

const ENCODER: &str = "sim:kuebler-sendix-58x8";

/// A simulated device behind TCP, which is killed at the end of the test.
pub struct Device {
    child: Child,
    pub bus: String,
}

impl Device {
    fn start(more: &[&str]) -> Self {
        Self::of("kuebler-sendix-58x8", more)
    }

    /// A device of this model, with its node-ID as delivered.
    pub fn of(model: &str, more: &[&str]) -> Self {
        let (device, node) = (0..20).find_map(|_| Self::on_a_free_port(model, more)).expect("a port stays free");
        // The device answers once it has booted.
        let answers = || run(&["sdo", "read", &device.bus, &node, "1000", "--timeout", "300ms"]).status == 0;
        assert!((0..20).any(|_| answers()), "the simulated device boots");
        device
    }

    /// Starts a device; `None` if another program took the port between the choice and the device's start.
    fn on_a_free_port(model: &str, more: &[&str]) -> Option<(Self, String)> {
        // The port is free again when this listener is dropped.
        let address = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let listen = format!("slcan:listen://{address}");
        let mut child = command(&[&["simulate", model, &listen], more].concat())
            .stdin(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stderr.take().unwrap()).read_line(&mut line).unwrap();
        let device = Self { child, bus: format!("slcan:tcp://{address}") };
        let Some(rest) = line.split(" as node ").nth(1) else {
            assert!(line.contains("in use"), "{line}");
            return None;
        };
        Some((device, rest.split(' ').next().unwrap_or_default().to_owned()))
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn json(run: &Run) -> Value {
    serde_json::from_str(&run.stdout).unwrap_or_else(|error| panic!("{error}: {}{}", run.stdout, run.stderr))
}

#[test]
fn objects_are_read_and_written_by_address_and_name() {
    let read = run(&["sdo", "read", ENCODER, "63", "position value"]);
    assert_eq!(read.stdout, "6004h:00 Position value = 19642 steps (863.173828°)\n", "{}", read.stderr);
    let read = run(&["sdo", "read", ENCODER, "63", "1018:01", "--format", "json"]);
    let object = json(&read);
    assert_eq!((&object["schema"], &object["value"]), (&"canvass/sdo/1".into(), &0x13.into()), "{object}");
    let written = run(&["sdo", "write", ENCODER, "63", "1017", "1000"]);
    assert_eq!((written.status, &*written.stdout), (0, "1017h:00 Producer heartbeat time = 1000 ms written\n"));
    let refused = run(&["sdo", "read", ENCODER, "63", "5000"]);
    assert_eq!(refused.status, 1);
    assert!(refused.stderr.contains("abort 0602 0000h"), "{}", refused.stderr);
    let silent = run(&["sdo", "read", &format!("{ENCODER}:63"), "5", "1000"]);
    assert_eq!((silent.status, silent.stderr.contains("node 5 does not answer")), (3, true));
    for (object, value, says) in
        [("1017", "70000", "does not fit"), ("9999", "1", "--type"), ("nonsense", "1", "named")]
    {
        let wrong = run(&["sdo", "write", ENCODER, "63", object, value]);
        assert_eq!((wrong.status, wrong.stderr.contains(says)), (2, true), "{}", wrong.stderr);
    }
}

#[test]
fn scan_says_who_is_there() {
    let scan = json(&run(&["scan", ENCODER, "--format", "json"]));
    assert_eq!(scan["nodes"].as_array().unwrap().len(), 1, "{scan}");
    let node = &scan["nodes"][0];
    assert_eq!((&node["node"], &node["profile"]), (&63.into(), &406.into()), "{scan}");
    assert_eq!((&node["model"], &node["model_exact"]), (&"kuebler-sendix-58x8".into(), &true.into()), "{scan}");
}

/// A scan recognises every configured model by its identity. The Sendix 58x8 and F58 have the same identity, and so
/// have C100 and D125.
#[test]
fn scan_knows_the_models() {
    let models = json(&run(&["list", "models", "--format", "json"]));
    let mut known = Vec::new();
    for model in models.as_array().unwrap() {
        let id = model["id"].as_str().unwrap();
        let scan = json(&run(&["scan", &format!("sim:{id}"), "--format", "json", "--no-lss", "--listen", "10ms"]));
        let Some(node) = scan["nodes"].get(0) else { continue };
        assert!(node["models"].as_array().unwrap().contains(&id.into()), "{id}: {scan}");
        assert_eq!(node["model_exact"], true, "{id}: {scan}");
        known.push((id.to_owned(), node["models"].as_array().unwrap().len()));
    }
    let several: Vec<&str> = known.iter().filter(|model| model.1 > 1).map(|model| &*model.0).collect();
    assert_eq!(
        (known.len(), several),
        (10, vec!["kuebler-sendix-58x8", "kuebler-sendix-f58", "kuebler-c100", "kuebler-d125"])
    );
}

/// A device description is sufficient to simulate a device; it accepts every motion, and its stored values outlive the
/// program.
#[test]
fn a_device_of_a_description_keeps_its_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (eds, memory, csv) = (path("my.eds"), path("memory.toml"), path("course.csv"));
    let reference = concat!(env!("CARGO_MANIFEST_DIR"), "/conformance/device/models/reference-406.eds");
    std::fs::copy(reference, &eds).unwrap();
    std::fs::write(&csv, "0,0\n1,5\n").unwrap();
    let simulate = |more: &[&str]| {
        let fixed = ["simulate", &eds, "sim:reference-301", "--node", "9", "--for", "1s", "--memory", &memory];
        run(&[&fixed, more].concat())
    };
    for motion in ["60", "-0.5", "rpm=60", "still", "sine=2,10", "ramp=600,5", &format!("csv={csv}")] {
        let done = simulate(&["--motion", motion]);
        assert_eq!((done.status, done.stderr.contains("as node 9")), (0, true), "{motion}: {}", done.stderr);
    }
    assert!(std::fs::read_to_string(&memory).unwrap().contains("model = "));
    assert_eq!(simulate(&["--motion", "fast"]).status, 2);
    std::fs::write(&memory, "model = \"another\"\noffset = 0\n").unwrap();
    let foreign = simulate(&[]);
    assert_eq!((foreign.status, foreign.stderr.contains("another")), (2, true), "{}", foreign.stderr);
}

#[test]
fn lss_asks_and_configures() {
    let address = json(&run(&["lss", "inquire", ENCODER, "--format", "json"]));
    assert_eq!((&address["vendor_id"], &address["node"]), (&0x13.into(), &63.into()), "{address}");
    let number = |key: &str| address[key].as_u64().unwrap();
    let selected = format!("19:{}:{}:{}", number("product_code"), number("revision_number"), number("serial_number"));
    let configured = run(&["lss", "configure", ENCODER, "--address", &selected, "--node-id", "5"]);
    assert_eq!(
        (configured.status, &*configured.stdout),
        (0, "configure node-ID: successful\n"),
        "{}",
        configured.stderr
    );
    let other = run(&["lss", "configure", ENCODER, "--address", "1:2:3:4", "--node-id", "5"]);
    assert_eq!((other.status, other.stderr.contains("no device answers")), (3, true), "{}", other.stderr);
    assert_eq!(run(&["lss", "fastscan", ENCODER]).status, 3, "it has a node-ID");
}

/// LMT, which older devices have in place of LSS, has the same commands but another table of bit rates.
#[test]
fn a_device_with_lmt_is_given_no_bit_rate_of_lss() {
    const LMT: &str = "sim:tr-lmp30";
    let inquired = run(&["lss", "inquire", LMT]);
    assert_eq!((inquired.status, &*inquired.stdout), (3, ""), "{}", inquired.stderr);
    let says = "no device answers to LSS, but a device answers to LMT (CiA DS-205): manufacturer name \"TR-ELEC\", product name";
    assert!(inquired.stderr.contains(says), "{}", inquired.stderr);
    let refused = run(&["lss", "configure", LMT, "--node-id", "5", "--bit-rate", "50k", "--store"]);
    assert_eq!((refused.status, &*refused.stdout), (2, ""), "{}", refused.stderr);
    for says in
        ["manufacturer name \"TR-ELEC\"", "row 6 means 50 kbit/s in LSS and 20 kbit/s in LMT; nothing was configured"]
    {
        assert!(refused.stderr.contains(says), "{}", refused.stderr);
    }
    // The node-ID means the same in LSS and LMT. Devices with LSS, or with neither, are treated as before.
    let configured = run(&["lss", "configure", LMT, "--node-id", "5"]);
    assert_eq!(
        (configured.status, &*configured.stdout),
        (0, "configure node-ID: successful\n"),
        "{}",
        configured.stderr
    );
    let configured = run(&["lss", "configure", ENCODER, "--bit-rate", "250k"]);
    assert_eq!(configured.status, 0, "{}", configured.stderr);
    assert!(configured.stdout.contains("configure bit timing: successful"), "{}", configured.stdout);
    for (action, more) in [("inquire", &[][..]), ("configure", &["--bit-rate", "250k"])] {
        let silent = run(&[&["lss", action, "sim:tr-c65"], more].concat());
        assert_eq!(silent.status, 3, "{action}");
        assert!(
            silent.stderr.contains("no device answers to \"") && !silent.stderr.contains("LMT"),
            "{}",
            silent.stderr
        );
    }
}

/// The master of LMT reads names and serial number, and sets node-ID and bit rate by the table of LMT, in which row 5 is
/// 50 kbit/s.
#[test]
fn lmt_asks_identifies_and_configures() {
    const LMT: &str = "sim:tr-lmp30";
    let inquired = json(&run(&["lmt", "inquire", LMT, "--format", "json"]));
    assert_eq!((&inquired["product_name"], &inquired["serial_number"]), (&"LMP30".into(), &"32200044002100".into()));
    let names = ["lmt", "identify", LMT, "--manufacturer", "TR-ELEC", "--product", "LMP30"];
    assert_eq!(run(&names).status, 0);
    assert_eq!(run(&[&names[..], &["--serial", "32200044002101..32200044002200"]].concat()).status, 3);
    let device = Device::of("tr-lmp30", &[]);
    let proxy = Proxy::start(device.bus.strip_prefix("slcan:tcp://").unwrap().parse().unwrap()).unwrap();
    let configured = run(&["lmt", "configure", &proxy.bus(), "--node-id", "5", "--bit-rate", "50k"]);
    assert_eq!(configured.status, 0, "{}", configured.stderr);
    assert!(configured.stdout.contains("configure bit timing: successful"), "{}", configured.stdout);
    let sent = proxy.frames("t7E58");
    assert!(sent.contains(&"1105000000000000".to_owned()) && sent.contains(&"1300050000000000".to_owned()), "{sent:?}");
    let other = run(&["lmt", "configure", LMT, "--slave", "TR-ELEC:LMP30:1", "--node-id", "5"]);
    assert_eq!((other.status, &*other.stdout), (3, ""), "{}", other.stderr);
    assert_eq!(run(&["lmt", "configure", ENCODER, "--bit-rate", "50k"]).status, 3, "it has LSS");
}

/// A device with LMT gets no request that changes its settings, and is left in operation mode.
#[test]
fn what_a_device_with_lmt_is_sent_changes_nothing() {
    let device = Device::of("tr-lmp30", &[]);
    let proxy = Proxy::start(device.bus.strip_prefix("slcan:tcp://").unwrap().parse().unwrap()).unwrap();
    let refused = run(&["lss", "configure", &proxy.bus(), "--node-id", "5", "--bit-rate", "50k", "--store"]);
    assert_eq!(refused.status, 2, "{}", refused.stderr);
    let sent = proxy.frames("t7E58");
    assert_eq!(
        sent,
        ["0401000000000000", "2400000000000000", "2500000000000000", "2600000000000000", "0400000000000000"]
    );
}

/// Without this check, a device that wrongly takes part in Fastscan would get one node-ID after the other, up to 127.
#[test]
fn fastscan_ends_with_a_device_that_it_has_seen() {
    const FAULTY: &str = "sim:reference-301+fastscan-answered-when-configured";
    let assigned = run(&["lss", "fastscan", FAULTY, "--assign", "55", "--store"]);
    assert_eq!((assigned.status, assigned.stdout.matches("configure node-ID: successful").count()), (1, 1));
    assert!(assigned.stderr.contains("was given node-ID 55 and answers Fastscan again"), "{}", assigned.stderr);
    let scan = json(&run(&["scan", FAULTY, "--format", "json"]));
    assert_eq!((&scan["unconfigured"], &scan["fastscan_configured"]), (&().into(), &10.into()), "{scan}");
    let text = run(&["scan", FAULTY]).stdout;
    assert!(text.contains("node 10 takes part in Fastscan") && !text.contains("without node-ID"), "{text}");
}

#[test]
fn nmt_commands_and_what_comes_back() {
    let reset = run(&["nmt", ENCODER, "reset-node", "63"]);
    assert!(reset.stdout.contains("reset node, node 63") && reset.stdout.contains("boot-up"), "{}", reset.stdout);
    assert!(run(&["nmt", ENCODER, "stop", "all"]).stdout.contains("000  02 00"));
    assert_eq!(run(&["nmt", ENCODER, "stop", "128"]).status, 2);
}

#[test]
fn monitor_has_the_options_of_decode() {
    let monitor = run(&["monitor", ENCODER, "--for", "2", "--format", "json", "--node", "63"]);
    let line = json(&monitor);
    assert_eq!((&line["schema"], &line["service"]), (&"canvass/decode/1".into(), &"boot-up".into()), "{line}");
    let events = run(&["monitor", ENCODER, "--for", "2", "--events"]);
    assert!(events.stdout.contains("boot-up"), "{}{}", events.stdout, events.stderr);
    assert_eq!(run(&["monitor", ENCODER]).status, 2, "virtual time has no end");
}

#[test]
fn record_writes_every_format() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.log", "a.pcapng", "a.mcap", "a.asc", "a.trc", "a.csv", "a.log.gz"] {
        let path = folder.path().join(name);
        let path = path.to_str().unwrap();
        let record = run(&["record", ENCODER, path, "--for", "2"]);
        assert_eq!(record.status, 0, "{name}: {}", record.stderr);
        assert!(record.stderr.contains("1 frames recorded, 0 lost"), "{}", record.stderr);
        assert_eq!(run(&["decode", path]).stdout.lines().count(), 1, "{name}");
        assert_eq!(run(&["record", ENCODER, path, "--for", "2"]).status, 2, "{name} exists");
    }
}

#[test]
fn a_device_behind_slcan() {
    let device = Device::start(&["--motion", "60"]);
    let read = run(&["sdo", "read", &device.bus, "63", "1008", "--device", "kuebler-sendix-58x8"]);
    assert!(read.stdout.contains("Kuebler Sendix Encoder"), "{}{}", read.stdout, read.stderr);
    let scan = json(&run(&["scan", &device.bus, "--format", "json", "--no-lss"]));
    assert_eq!(scan["nodes"][0]["node"], 63, "{scan}");
    let args =
        ["test", &device.bus, "--device", "kuebler-sendix-58x8", "--select", "301/sdo/upload", "--format", "json"];
    let tested = run(&args);
    let report = json(&tested);
    assert_eq!(report["summary"]["fail"], 0, "{report:#}");
    assert!(report["host"]["receive_max_ns"].is_u64(), "a live bus has its host's reaction times: {report:#}");
}

#[test]
fn a_faulty_device_behind_slcan_fails() {
    let device = Device::start(&["--fault", "sdo-toggle-unchecked"]);
    let case = "301/sdo/download/segment-toggle";
    let args = ["test", &device.bus, "--device", "kuebler-sendix-58x8", "--select", case, "--format", "json"];
    let report = json(&run(&args));
    let verdict = report["cases"][0]["verdict"].as_str().unwrap();
    // If this machine is too slow to judge, the verdict says so.
    assert!(verdict == "fail" || report["cases"][0]["reason"]["duty"] == "the tester's machine keeps up", "{report:#}");
}

/// On a bus in real time, a violation is found, repeated after a reset and shortened, and the device is left as it was.
#[test]
fn a_violation_behind_slcan_is_confirmed_and_small() {
    let device = Device::start(&["--fault", "sdo-toggle-unchecked"]);
    let args =
        ["fuzz", &device.bus, "--device", "kuebler-sendix-58x8", "--target", "sdo", "--seed", "3", "--for", "100s"];
    let fuzzed = run(&[&args[..], &["--stop-at-first", "--shrink-budget", "40", "--format", "json"]].concat());
    let report = json(&fuzzed);
    assert_eq!(fuzzed.status, 1, "{report:#}");
    let violation = &report["violations"][0];
    // If this machine is too slow to confirm the violation, the report says so.
    if violation["confirmed"] == true {
        assert!(violation["rule"].as_str().unwrap().contains("toggle"), "{violation:#}");
        assert!(violation["frames"].as_array().unwrap().len() <= 8, "{violation:#}");
    }
    assert!(!violation["evidence"].as_array().unwrap().is_empty(), "{violation:#}");
    assert_eq!(run(&["sdo", "read", &device.bus, "63", "1000"]).status, 0, "the device is well");
}

#[test]
fn buses_that_are_not_there() {
    for (bus, says) in [
        ("slcan:/dev/no-such-port", "/dev/no-such-port"),
        ("slcan:tcp://127.0.0.1:1", "no program listens there"),
        ("no-such-can0", "no-such-can0"),
    ] {
        let tested = run(&["test", bus, "--node", "5"]);
        assert_eq!(tested.status, 3, "{bus}: {}", tested.stderr);
        // If the kernel has no CAN, the program reports this first.
        assert!(tested.stderr.contains(says) || tested.stderr.contains("no CAN in this kernel"), "{}", tested.stderr);
    }
    assert_eq!(run(&["test", "slcan:/dev/x@300k", "--node", "5"]).status, 3);
}

#[test]
fn the_doctor_answers() {
    let doctor = json(&run(&["doctor", "--format", "json"]));
    let what: Vec<&str> =
        doctor["findings"].as_array().unwrap().iter().map(|finding| finding["what"].as_str().unwrap()).collect();
    assert!(what.contains(&"SocketCAN") && what.contains(&"wake-up"), "{what:?}");
    let socketcan =
        doctor["findings"].as_array().unwrap().iter().find(|finding| finding["what"] == "SocketCAN").unwrap();
    if socketcan["good"] == false {
        // The text names what is missing.
        let text = socketcan["text"].as_str().unwrap();
        let reasons = ["CONFIG_CAN", "/proc/modules", "/lib/modules/", "modprobe can-raw", "permission", "only Linux"];
        assert!(reasons.iter().any(|reason| text.contains(reason)), "{text}");
    }
}
