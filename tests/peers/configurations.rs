//! python-canopen reads the DCFs of canvass, and gives devices the configurations in them: both agree with the device.

use crate::python::PYTHON;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::process::{Child, Command, Output, Stdio};

const CANVASS: &str = env!("CARGO_BIN_EXE_canvass");
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peers/configurations.py");

fn run(program: &str, args: &[&str]) -> Output {
    let output = Command::new(program).args(args).stdin(Stdio::null()).output();
    output.unwrap_or_else(|error| panic!("{program}: {error}; cargo xtask peers installs what these tests need"))
}

fn printed(program: &str, args: &[&str]) -> String {
    let output = run(program, args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The objects of a device, as a run of cases reads them before its first case.
fn dictionary(model: &str, node: &str) -> BTreeMap<String, String> {
    let bus = format!("sim:{model}");
    let args = ["test", &bus, "--node", node, "--select", "301/boot-up/reset-node", "--format", "json"];
    let tested: Value = serde_json::from_slice(&run(CANVASS, &args).stdout).unwrap();
    let row = |row: &Value| {
        let number = |name: &str| row[name].as_u64().unwrap();
        let at = format!("{:04X}:{:02X}", number("index"), number("sub"));
        (at, row["data"].as_str().unwrap().to_uppercase())
    };
    tested["dictionary"].as_array().unwrap().iter().map(row).collect()
}

#[test]
fn python_canopen_reads_the_values_that_the_devices_have() {
    let models: Vec<Value> = serde_json::from_str(&printed(CANVASS, &["list", "models", "--format", "json"])).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut compared = 0;
    for model in models {
        let id = model["id"].as_str().unwrap();
        // One model has no node-ID as delivered.
        let node = model["node"].as_u64().unwrap_or(63).to_string();
        let file = folder.path().join(format!("{id}.dcf")).display().to_string();
        printed(CANVASS, &["dcf", "read", &format!("sim:{id}"), "--node", &node, "-o", &file]);
        let objects = dictionary(id, &node);
        for line in printed(PYTHON, &[SCRIPT, "values", &file, &node]).lines() {
            let (at, bytes) = line.split_once(' ').unwrap();
            assert_eq!(objects.get(at).map(String::as_str), Some(bytes), "{id}, {at}");
            compared += 1;
        }
    }
    assert!(compared > 600, "only {compared} values");
}

/// A device in a process, which is ended with this value.
struct Device(Child, String);

impl Device {
    fn new(model: &str) -> Self {
        let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let mut command = Command::new(CANVASS);
        command.args(["simulate", model, &format!("slcan:listen://{address}")]);
        let mut child = command.stdin(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        BufReader::new(child.stderr.take().unwrap()).read_line(&mut String::new()).unwrap();
        Self(child, address.to_string())
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Models that take the whole configuration in the order in which python-canopen writes it, each with its node-ID and
/// an entry with another value.
const MODELS: [(&str, &str, &str, &str); 5] = [
    ("reference-301", "10", "[1800sub5]", "200"),
    ("kuebler-sendix-58x8", "63", "[1801sub2]", "5"),
    ("kuebler-sendix-f58", "63", "[1017]", "777"),
    ("kuebler-c100", "4", "[1017]", "500"),
    ("lika-ax58", "1", "[1800sub2]", "3"),
];

#[test]
fn what_python_canopen_writes_is_the_configuration() {
    let folder = tempfile::tempdir().unwrap();
    for (model, node, section, value) in MODELS {
        let file = folder.path().join(format!("{model}.dcf")).display().to_string();
        printed(CANVASS, &["dcf", "read", &format!("sim:{model}"), "--node", node, "-o", &file]);
        let text = std::fs::read_to_string(&file).unwrap();
        let from = text.find(&format!("{section}\r\n")).unwrap();
        let from = from + text[from..].find("ParameterValue=").unwrap();
        let to = from + text[from..].find("\r\n").unwrap();
        std::fs::write(&file, format!("{}ParameterValue={value}{}", &text[..from], &text[to..])).unwrap();
        let device = Device::new(model);
        let bus = format!("slcan:tcp://{}", device.1);
        printed(CANVASS, &["nmt", &bus, "pre-operational", node, "--wait", "50ms"]);
        // A device that still starts does not answer.
        let differs = (0..20).any(|_| run(CANVASS, &["dcf", "diff", &file, &bus]).status.code() == Some(1));
        assert!(differs, "{model}: the value is another");
        printed(PYTHON, &[SCRIPT, "write", &file, node, &format!("socket://{}", device.1)]);
        let compared = run(CANVASS, &["dcf", "diff", &file, &bus]);
        assert_eq!(compared.status.code(), Some(0), "{model}: {}", String::from_utf8_lossy(&compared.stdout));
    }
}
