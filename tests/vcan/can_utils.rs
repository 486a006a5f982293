//! can-utils and canvass on the same bus.

use crate::interface::Interface;
use crate::running::{Running, canvass, run, simulate, text};
use std::process::{Command, Stdio};
use std::time::Duration;

fn tool(name: &str, args: &[&str]) -> Command {
    let mut command = Command::new(name);
    command.args(args).stdin(Stdio::null());
    command
}

/// cansend requests an object of our simulated device, and candump sees the answer.
#[test]
fn cansend_and_candump() {
    let bus = Interface::new("vsend");
    let _device = simulate("kuebler-sendix-58x8", bus.name(), &[]);
    let candump = Running::start(tool("candump", &["-n", "2", "-T", "10000", "-L", bus.name()]));
    std::thread::sleep(Duration::from_millis(500));
    assert!(tool("cansend", &[bus.name(), "63F#4000100000000000"]).status().unwrap().success());
    let seen = candump.finish().stdout;
    assert!(seen.contains("63F#4000100000000000") && seen.contains("5BF#4300100096010200"), "{seen}");
}

/// `record` records the frames of cangen exactly as candump saw them.
#[test]
fn cangen_into_record() {
    let bus = Interface::new("vgen");
    let path = std::env::temp_dir().join("canvass-vgen.log");
    let out = path.to_str().unwrap();
    let mut record = Running::start(canvass(&["record", bus.name(), out, "--frames", "500", "--force"]));
    let candump = Running::start(tool("candump", &["-n", "500", "-L", bus.name()]));
    record.says("recording");
    std::thread::sleep(Duration::from_millis(500));
    let cangen = ["-g", "1", "-n", "500", "-m", "-e", bus.name()];
    assert!(tool("cangen", &cangen).status().unwrap().success());
    let ended = record.finish();
    assert!(ended.status == 0 && ended.stderr.contains("500 frames recorded, 0 lost"), "{}", ended.stderr);
    let frames = |text: &str| -> Vec<String> {
        text.lines().map(|line| line.split_whitespace().nth(2).unwrap().to_owned()).collect()
    };
    let recorded = std::fs::read_to_string(&path).unwrap();
    assert_eq!(frames(&recorded), frames(&candump.finish().stdout));
}

/// canplayer plays a recording; `monitor` decodes it like `decode` decodes the file.
#[test]
fn canplayer_into_monitor() {
    let bus = Interface::new("vplay");
    let sample = "docs/examples/commissioning.log";
    let frames = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/examples/commissioning.log"));
    let frames = frames.unwrap().lines().filter(|line| line.starts_with('(')).count();
    let monitor = Running::start(canvass(&["monitor", bus.name(), "--format", "json", "--for", "8"]));
    std::thread::sleep(Duration::from_secs(2));
    let map = format!("{}=can0", bus.name());
    let played = Command::new("canplayer").args(["-I", sample, &map]).current_dir(env!("CARGO_MANIFEST_DIR")).output();
    assert!(played.as_ref().unwrap().status.success(), "{played:?}");
    let monitored = monitor.finish();
    let decoded = run(&["decode", sample, "--format", "json"]);
    let meanings = |text: &str| -> Vec<String> {
        let lines = text.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
        lines.map(|line| format!("{} {} {}", line["id"], line["data"], line["service"])).collect()
    };
    let found = meanings(&monitored.stdout);
    assert_eq!(found.len(), frames, "{}", monitored.stderr);
    assert_eq!(found, meanings(&text(&decoded.stdout)));
}
