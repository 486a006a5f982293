//! The diagnosis in the page equals that of `canvass diagnose --format html`.

use crate::captures::machine;
use crate::opened::Opened;
use canvass_webdriver::Screen;

#[test]
fn a_capture_is_diagnosed_without_a_request() {
    let opened = Opened::with(Screen::Desk, "machine.log", machine(20).on("can0"));
    opened.browser.wait("document.querySelector('#view-diagnosis iframe')");
    // The frame runs its own scripts and nothing else, whatever texts it contains.
    assert_eq!(opened.browser.text("return document.querySelector('iframe').sandbox.value"), "allow-scripts");
    opened.browser.within("#view-diagnosis iframe", |browser| {
        browser.wait("document.querySelectorAll('.plot canvas').length >= 2");
        assert!(browser.text("return document.querySelector('h1').textContent").contains("machine.log"));
    });
    opened.browser.is_quiet();
}

#[test]
fn on_a_phone_nothing_is_wider_than_the_screen() {
    let opened = Opened::with(Screen::Phone, "machine.log", machine(20).on("can0"));
    for view in ["diagnosis", "trace", "signals", "eds", "results", "try", "export"] {
        opened.view(view);
        let wider = opened.browser.number("return document.documentElement.scrollWidth - innerWidth");
        assert!(wider <= 0.0, "{view}: {wider} pixels too wide");
    }
    opened.browser.is_quiet();
}
