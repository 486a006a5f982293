//! The page of `canvass history`.

use canvass_webdriver::{Browser, Screen};
use std::process::Command;

/// Six releases of a simulated device, in which faults come and go.
const RELEASES: [(&str, &str); 6] = [
    ("1.0", ""),
    ("1.1", "+heartbeat-period-doubled"),
    ("1.2", "+heartbeat-period-doubled+boot-up-twice"),
    ("1.3", "+boot-up-twice"),
    ("1.4", ""),
    ("1.5", "+heartbeat-period-doubled"),
];

fn canvass(args: &[&str]) {
    let ended = Command::new(env!("CARGO_BIN_EXE_canvass")).args(args).output().unwrap();
    assert!(ended.status.code().is_some_and(|status| status < 2), "{}", String::from_utf8_lossy(&ended.stderr));
}

#[test]
fn it_finds_the_first_bad_release_of_each_case() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("history.html");
    let report = format!("html={}", page.display());
    let mut args = vec!["history".to_owned(), "--report".to_owned(), report];
    for (release, faults) in RELEASES {
        let file = folder.path().join(format!("{release}.json")).display().to_string();
        let (bus, report) = (format!("sim:reference-301{faults}"), format!("json={file}"));
        canvass(&["test", &bus, "--select", "301/boot-up/reset-node,301/heartbeat/period", "--report", &report]);
        args.push(file);
    }
    canvass(&args.iter().map(String::as_str).collect::<Vec<_>>());
    let browser = Browser::open(&page, Screen::Desk);
    let first_bad =
        |case: &str| browser.text(&format!("return document.querySelector('[data-case=\"{case}\"]').dataset.firstBad"));
    assert_eq!(first_bad("301/heartbeat/period"), "1.1");
    assert_eq!(first_bad("301/boot-up/reset-node"), "1.2");
    let turned = "return document.querySelectorAll('[data-case=\"301/heartbeat/period\"] .turned').length / 2";
    assert_eq!(browser.number(turned), 2.0);
    assert!(browser.number("return document.querySelectorAll('#plots canvas').length") >= 1.0);
    browser.is_quiet();
}
