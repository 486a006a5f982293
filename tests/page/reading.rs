//! Choosing captures while others are being read.

use crate::captures::machine;
use crate::opened::Opened;
use canvass_webdriver::Screen;
use std::slice::from_ref;

/// A script that chooses the format, as a user would.
const AS_CANDUMP: &str = "const format = document.getElementById('format'); \
     format.value = 'candump'; format.dispatchEvent(new Event('change'))";
/// A script that notes when reading begins, as reading may end before the test looks.
const NOTE_READING: &str = "window.hasBegun = false; \
     new MutationObserver(() => { window.hasBegun ||= !document.getElementById('progress').hidden; }) \
     .observe(document.getElementById('progress'), { attributes: true, attributeFilter: ['hidden'] })";
const HAS_BEGUN: &str = "window.hasBegun || !document.getElementById('progress').hidden";
/// A script that cancels the next reading, a moment after it has begun.
const CANCEL_NEXT: &str = "const progress = document.getElementById('progress'); \
     new MutationObserver((_, observer) => { if (!progress.hidden) { observer.disconnect(); \
     setTimeout(() => progress.querySelector('button').click(), 30); } }) \
     .observe(progress, { attributes: true, attributeFilter: ['hidden'] })";
const FORGET: &str = "window.hasBegun = false";
const IS_READ: &str = "/frames, /.test(document.getElementById('status').textContent) && \
     document.querySelector('#view-diagnosis iframe') && document.getElementById('progress').hidden";

/// Calls `act`, and waits until the page begins to read because of it.
fn begins(opened: &Opened, act: impl FnOnce()) {
    opened.browser.run(FORGET);
    act();
    opened.browser.wait(HAS_BEGUN);
}

fn status(opened: &Opened) -> String {
    opened.browser.text("return document.getElementById('status').textContent")
}

#[test]
fn what_was_chosen_last_is_read_to_its_end() {
    let opened = Opened::empty(Screen::Desk);
    let [large, small] = [6_000, 20].map(|seconds| opened.file(&format!("{seconds}.log"), machine(seconds).on("can0")));
    opened.take(from_ref(&small));
    opened.browser.wait(IS_READ);
    let of_small = status(&opened);
    opened.browser.run(NOTE_READING);
    begins(&opened, || opened.take(from_ref(&large)));
    // Another file is opened meanwhile.
    opened.take(from_ref(&small));
    opened.browser.wait(IS_READ);
    assert_eq!(status(&opened), of_small);
    // The same file is read in another format, again and again.
    begins(&opened, || opened.take(from_ref(&large)));
    for _ in 0..3 {
        opened.browser.run(AS_CANDUMP);
    }
    opened.browser.wait(IS_READ);
    assert_ne!(status(&opened), of_small);
    // Reading is cancelled, then another file is opened.
    opened.browser.run(CANCEL_NEXT);
    opened.take(&[large, small.clone()]);
    opened.browser.wait("/cancelled/.test(document.getElementById('status').textContent)");
    opened.take(&[small]);
    opened.browser.wait(IS_READ);
    assert_eq!(status(&opened), of_small);
    opened.browser.is_quiet();
}

/// The worker that hashes starts a moment after the page; a file chosen before that is hashed as well.
#[test]
fn a_capture_that_is_chosen_at_once_has_its_hash() {
    let opened = Opened::empty(Screen::Desk);
    opened.take(&[opened.file("machine.log", machine(3_000).on("can0"))]);
    opened.browser.wait(IS_READ);
    opened.browser.within("#view-diagnosis iframe", |browser| {
        browser.wait("/[0-9a-f]{64}/.test(document.body.textContent)");
    });
    opened.browser.is_quiet();
}

/// Pastes text, as Ctrl-V does outside of a field.
fn paste(opened: &Opened, text: &str) {
    let text = serde_json::to_string(text).unwrap();
    opened.browser.run(&format!(
        "const data = new DataTransfer(); data.setData('text/plain', {text}); \
         document.body.dispatchEvent(new ClipboardEvent('paste', {{ clipboardData: data, bubbles: true, cancelable: true }}))"
    ));
}

#[test]
fn frames_that_are_pasted_are_read() {
    let opened = Opened::empty(Screen::Desk);
    paste(&opened, "  605  [8]  40 00 10 00 00 00 00 00\n  585  [8]  43 00 10 00 92 01 02 00  <-- here\n");
    opened.browser.wait(IS_READ);
    assert!(status(&opened).contains("2 frames"), "{}", status(&opened));
    opened.view("trace");
    let rows = opened.rows();
    assert!(rows.iter().any(|row| row.contains("read answered: 1000h:00")), "{rows:?}");
    opened.browser.is_quiet();
}
