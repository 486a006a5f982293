//! SIGKILL at any moment of a run: its journal restores the device.

use crate::interface::Interface;
use crate::running::{Running, canvass, run, simulate, text};
use serde_json::Value;
use std::time::Duration;

/// Number of killed runs, distributed over the interfaces. Fifty killed runs take ten minutes here; over a serial line
/// they are faster, and every test run includes them (tests/program/killed.rs).
const KILLS: u64 = 15;
const INTERFACES: [&str; 5] = ["vkill0", "vkill1", "vkill2", "vkill3", "vkill4"];

/// Objects with values that are not stored.
const AT_WORK: [(&str, &str); 3] = [("1017", "1000"), ("1800:05", "500"), ("2041", "321")];

const DEVICE: [&str; 4] = ["--node", "10", "--device", "reference-301"];

/// The dictionary as another run finds it before its first case, without objects that change by themselves.
fn dictionary(bus: &str) -> Vec<Value> {
    let args = ["--select", "301/identity/vendor-id", "--format", "json", "--journal", "none"];
    let tested = run(&[&["test", bus], &DEVICE[..], &args].concat());
    let report: Value =
        serde_json::from_slice(&tested.stdout).unwrap_or_else(|error| panic!("{error}: {}", text(&tested.stderr)));
    let steady = |row: &&Value| !matches!(row["index"].as_u64(), Some(0x1001 | 0x1003 | 0x1013 | 0x2020));
    report["dictionary"].as_array().unwrap().iter().filter(steady).cloned().collect()
}

/// The time after the first case at which a run is killed: different for every kill, the same in every run of this
/// test.
fn moment(kill: u64) -> Duration {
    let chance = kill.wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(31).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    Duration::from_millis((chance >> 33) % 15_000)
}

/// Kills one run after the other on one device; returns the number of runs that had begun a case.
fn kill(interface: &'static str, first: u64) -> u64 {
    let bus = Interface::new(interface);
    let _device = simulate("reference-301", bus.name(), &[]);
    for (object, value) in AT_WORK {
        let written = run(&["sdo", "write", bus.name(), "10", object, value, "--device", "reference-301"]);
        assert!(written.status.success(), "{object}: {}", text(&written.stderr));
    }
    let before = dictionary(bus.name());
    let journal = std::env::temp_dir().join(format!("canvass-{interface}.journal"));
    let journal_path = journal.to_str().unwrap();
    let _ = std::fs::remove_file(&journal);
    let mut restored = 0;
    for number in (first..KILLS).step_by(INTERFACES.len()) {
        let allow = ["--allow", "nvm,node-id,other-nodes,factory-defaults,preset", "--journal", journal_path];
        let mut tester = Running::start(canvass(&[&["test", bus.name()], &DEVICE[..], &allow].concat()));
        // The time counts from the first case: on a busy machine the steps before it take seconds.
        while !journal.exists() && !tester.has_ended() {
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(moment(number));
        tester.kill();
        if journal.exists() {
            restored += 1;
            let told = std::fs::read_to_string(&journal).unwrap();
            let put_back = run(&["restore", bus.name(), "--journal", journal_path]);
            assert!(put_back.status.success(), "kill {number}: {}\n{told}", text(&put_back.stderr));
        }
        let after = dictionary(bus.name());
        let changed: Vec<&Value> = after.iter().filter(|row| !before.contains(row)).collect();
        assert!(changed.is_empty() && after.len() == before.len(), "kill {number}: {changed:?}");
    }
    restored
}

#[test]
fn the_journal_of_a_killed_run_puts_the_device_back() {
    let restored: u64 = std::thread::scope(|scope| {
        let start = |(bus, first)| scope.spawn(move || kill(bus, first));
        let threads: Vec<_> = INTERFACES.into_iter().zip(0..).map(start).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).sum()
    });
    assert!(restored > KILLS / 2, "only {restored} runs had begun a case");
}
