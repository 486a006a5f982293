//! The views of signals, descriptions, results, trials and exports.

use crate::captures::machine;
use crate::opened::Opened;
use canvass_webdriver::Screen;
use std::path::Path;
use std::process::Command;

const EDS: &str = include_str!("../../conformance/device/models/kuebler-sendix-58x8.eds");

#[test]
fn values_are_drawn_and_read_at_cursors() {
    let opened = Opened::with(Screen::Desk, "machine.log", machine(20).on("can0"));
    opened.view("signals");
    opened.browser.wait("document.querySelector('#plot canvas')");
    let inked = "const canvas = document.querySelector('#plot canvas'); return canvas.getContext('2d') \
                 .getImageData(0, 0, canvas.width, canvas.height).data.filter((value, n) => n % 4 === 3 && value > 0).length";
    assert!(opened.browser.number(inked) > 500.0, "an empty plot");
    opened.browser.drag("#plot .u-over", 0.25, 0.25, false);
    opened.browser.drag("#plot .u-over", 0.75, 0.75, true);
    let cells = "[...document.querySelectorAll('#readings tbody tr')].map((row) => row.lastChild.textContent)";
    opened.browser.wait(&format!("{cells}.length > 1 && {cells}.every((text) => text !== '')"));
    let between = opened.browser.number(&format!("return Number({cells}[0])"));
    assert!(between > 5.0 && between < 15.0, "half of 20 s: {between}");
    opened.browser.is_quiet();
}

#[test]
fn a_description_names_what_the_capture_shows() {
    let opened = Opened::empty(Screen::Desk);
    let log = "(1700000000.000000) can0 185#0102030405060708\n(1700000000.100000) can0 605#4004600000000000\n";
    opened.take(&[opened.file("a.log", log), opened.file("encoder.eds", EDS)]);
    opened.browser.wait("/2 frames/.test(document.getElementById('status').textContent)");
    opened.view("trace");
    let rows = opened.rows();
    assert!(rows[1].contains("Position value"), "{rows:?}");
    opened.view("eds");
    opened.browser.wait("document.querySelector('#view-eds iframe')");
    assert!(opened.browser.text("return document.querySelector('.card').textContent").contains("encoder.eds"));
    opened.browser.is_quiet();
}

#[test]
fn a_device_is_tested_and_fuzzed_in_the_page() {
    let opened = Opened::empty(Screen::Desk);
    opened.view("try");
    opened.browser.wait("document.querySelector('#try-faults input[value=boot-up-twice]')");
    opened.browser.click("#try-faults input[value=boot-up-twice]");
    opened.browser.click("#try-faults input[value=sdo-toggle-unchecked]");
    let command = opened.browser.text("return document.getElementById('try-command').textContent");
    assert_eq!(command, "canvass test sim:kuebler-sendix-58x8+boot-up-twice+sdo-toggle-unchecked");
    opened.browser.fill("#try-select", "301/boot-up\u{E00C}");
    opened.browser.click("#try-test");
    opened.browser.wait("document.querySelector('#view-try iframe')?.title.includes('') && /: done/.test(document.getElementById('status').textContent)");
    opened.browser.within("#view-try iframe", |browser| {
        browser.wait("document.querySelector('h2#failures, h2#matrix')");
        assert!(browser.text("return document.body.textContent").contains("301/boot-up/reset-node"));
    });
    opened.browser.run("document.getElementById('try-seconds').value = '1'");
    opened.browser.click("#try-fuzz");
    opened.browser.wait("/canvass fuzz .*: done/.test(document.getElementById('status').textContent)");
    opened
        .browser
        .run("[...document.querySelectorAll('#view-try button')].find((one) => /^Keep/.test(one.textContent)).click()");
    opened.view("results");
    opened.browser.wait("/exchanges/.test(document.querySelector('#view-results .card')?.textContent)");
    opened.browser.is_quiet();
}

#[test]
fn results_of_the_program_are_shown_and_compared() {
    let opened = Opened::empty(Screen::Desk);
    let tested = |name: &str, faults: &str| {
        let bus = format!("sim:reference-301{faults}");
        let ended = Command::new(env!("CARGO_BIN_EXE_canvass"))
            .args(["test", &bus, "--select", "301/boot-up", "--format", "json"])
            .output()
            .unwrap();
        opened.file(name, ended.stdout)
    };
    let (good, bad) = (tested("1.0.json", ""), tested("1.1.json", "+boot-up-twice"));
    opened.take(std::slice::from_ref(&bad));
    opened.browser.wait("document.querySelector('.entry.fail')");
    opened.browser.click(".entry.fail summary");
    opened.browser.wait("/boot-up/.test(document.querySelector('.entry.fail .evidence')?.textContent)");
    opened.take(&[good, bad]);
    opened.browser.wait("document.querySelector('#view-results iframe')");
    opened.browser.is_quiet();
}

#[test]
fn what_is_saved_is_what_the_program_prints() {
    let opened = Opened::empty(Screen::Desk);
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("traces/samples/python-can.log");
    opened.take(std::slice::from_ref(&sample));
    opened.browser.wait("/frames, /.test(document.getElementById('status').textContent)");
    opened.view("export");
    // The script keeps the bytes of a saved file instead of saving them.
    opened.browser.run(
        "window.saved = []; const make = URL.createObjectURL; \
         URL.createObjectURL = (blob) => { blob.text().then((text) => window.saved.push(text)); return make(blob); }; \
         HTMLAnchorElement.prototype.click = () => {}",
    );
    opened.browser.click("#view-export .buttons button");
    opened.browser.wait("window.saved.length === 1");
    let ours = opened.browser.text("return window.saved[0]");
    let theirs = Command::new(env!("CARGO_BIN_EXE_canvass")).arg("decode").arg(&sample).output().unwrap();
    assert_eq!(ours, String::from_utf8(theirs.stdout).unwrap());
    opened.browser.is_quiet();
}
