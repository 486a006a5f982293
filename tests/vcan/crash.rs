//! `kill -9` on `record`: every format is readable up to the last second.

use crate::interface::{Interface, transmitted};
use crate::running::{Running, canvass, run, text};
use serde_json::Value;
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// A file name for every format that canvass writes, with the first extension of the format, and names of some
/// compressed files.
fn names() -> Vec<String> {
    let formats: Value = serde_json::from_slice(&run(&["list", "formats", "--format", "json"]).stdout).unwrap();
    let written = formats.as_array().unwrap().iter().filter(|format| format["written"] == true);
    let plain = written.map(|format| format!("a.{}", format["extensions"][0].as_str().unwrap()));
    plain.chain(["a.log.gz", "a.log.zst", "a.pcapng.gz"].map(str::to_owned)).collect()
}

#[test]
fn a_killed_recorder_leaves_readable_files() {
    let bus = Interface::new("vcrash");
    let folder = std::env::temp_dir().join("canvass-crash");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir(&folder).unwrap();
    let outputs: Vec<String> = names().iter().map(|name| folder.join(name).display().to_string()).collect();
    assert!(outputs.len() >= 10, "{outputs:?}");
    let args: Vec<&str> = ["record", bus.name()].into_iter().chain(outputs.iter().map(String::as_str)).collect();
    let mut record = Running::start(canvass(&args));
    record.says("recording");
    let mut cangen = Command::new("cangen");
    cangen.args(["-g", "5", "-L", "8", bus.name()]).stdin(Stdio::null());
    let cangen = Running::start(cangen);
    std::thread::sleep(Duration::from_secs(4));
    let killed_at = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos();
    record.kill();
    // The recorder has ended before the frames are counted, so that the count includes all frames that it could have
    // recorded.
    let sent = transmitted(bus.name());
    cangen.kill();
    for output in &outputs {
        let decoded = run(&["decode", output, "--format", "json"]);
        let lines: Vec<Value> = text(&decoded.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        // A frame every 5 ms: the last second has at most 200.
        let found = lines.len() as u64;
        assert!(found + 200 >= sent && found > 100, "{output}: {found} of {sent}; {}", text(&decoded.stderr));
        // TRC and ASC hold local or relative times.
        if !output.ends_with("asc") && !output.ends_with("trc") {
            let missing = killed_at.saturating_sub(u128::from(lines.last().unwrap()["t"].as_u64().unwrap()));
            assert!(missing < 1_000_000_000, "{output}: the last {} ms are missing", missing / 1_000_000);
        }
    }
}

/// A series of files holds all frames, and old files are deleted.
#[test]
fn rotation_loses_nothing() {
    let bus = Interface::new("vrotate");
    let folder = std::env::temp_dir().join("canvass-rotate");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir(&folder).unwrap();
    let out = folder.join("r.log");
    let args = ["record", bus.name(), out.to_str().unwrap(), "--frames", "600", "--rotate-size", "4k"];
    let mut record = Running::start(canvass(&args));
    record.says("recording");
    let cangen = Command::new("cangen").args(["-g", "1", "-n", "600", "-L", "8", bus.name()]).status().unwrap();
    assert!(cangen.success());
    assert_eq!(record.finish().status, 0);
    let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() > 2 && files[0].ends_with("r-0001.log"), "{files:?}");
    let lines: usize = files.iter().map(|path| std::fs::read_to_string(path).unwrap().lines().count()).sum();
    assert_eq!(lines, 600);
}
