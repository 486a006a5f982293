//! A page of a million frames.

use crate::captures::{Log, Page, machine};
use canvass_webdriver::{Browser, Screen};
use std::time::{Duration, Instant};

const FRAMES: u64 = 1_000_000;

/// An hour of traffic with eight more nodes and errors everywhere.
fn hour() -> Log {
    let seconds = 3_600;
    let mut log = machine(seconds);
    for node in 10..18_u64 {
        for us in (100_000 + node * 1_117..seconds * 1_000_000).step_by(60_000) {
            log.at(us, &format!("{:03X}#{:016X}", 0x180 + node, us * node));
        }
        for us in (500_000 + node * 1_013..seconds * 1_000_000).step_by(300_000) {
            log.at(us, &format!("{:03X}#05", 0x700 + node));
        }
        // Errors that come and go, answers that are aborted, restarts.
        for us in (30_000_000 * (node - 9)..seconds * 1_000_000).step_by(97_000_000) {
            let code = 0x10 + us / 97_000_000;
            log.at(us, &format!("{:03X}#{code:02X}FF010000000000", 0x80 + node));
            log.at(us + 40_000, &format!("{:03X}#0000000000000000", 0x80 + node));
            log.sdo(
                us + 71_000,
                node as u8,
                &format!("40{code:02X}600000000000"),
                &format!("80{code:02X}600000000206"),
                900,
            );
            log.at(us + 2_000_000, &format!("{:03X}#00", 0x700 + node));
        }
    }
    log
}

#[test]
fn a_million_frames_are_no_burden() {
    let mut log = hour();
    let text = log.on("can0");
    let frames = text.lines().count() as u64;
    assert!(frames >= FRAMES, "{frames}");
    let page = Page::of(text, "hour.log");
    let size = std::fs::metadata(&page.path).unwrap().len();
    assert!(size < 20_000_000, "{size} bytes");
    let begin = Instant::now();
    let browser = Browser::open(&page.path, Screen::Desk);
    browser.wait("document.querySelectorAll('.plot canvas').length >= 2 && document.querySelectorAll('#frame-rows tr').length > 100");
    let (opened, loaded) =
        (begin.elapsed(), browser.number("return performance.getEntriesByType('navigation')[0].loadEventEnd"));
    assert!(loaded > 0.0 && loaded < 3_000.0, "{loaded} ms to load");
    assert!(opened < Duration::from_secs(20), "with the start of the browser {opened:?}");
    assert!(browser.number("return canvass.data.findings.length") > 20.0);
    assert!(browser.number("return canvass.data.frames.length") > 1_000.0);
    // Zooming and scrolling stay fast.
    let redraw = browser.number(
        "return (async () => { \
           const begin = performance.now(); \
           for (let n = 0; n < 10; n++) { \
             canvass.view.zoom(0.7); \
             await new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))); \
           } \
           return (performance.now() - begin) / 10; \
         })()",
    );
    assert!(redraw < 200.0, "{redraw} ms to show another time");
    browser.is_quiet();
}
