//! All frames, with their meaning.

use crate::captures::{faulty, machine};
use crate::opened::Opened;
use crate::webdriver::Screen;

const DOWN: &str = "\u{E015}";
const END: &str = "\u{E010}";
const ENTER: &str = "\u{E007}";

#[test]
fn frames_have_their_meaning_and_are_gone_through_by_keys() {
    let opened = Opened::with(Screen::Desk, "machine.log", machine(20).on("can0"));
    opened.view("trace");
    let rows = opened.rows();
    assert!(rows.len() > 10 && rows[0].starts_with("0.000000|1|can0|"), "{rows:?}");
    opened.browser.press("#frames", DOWN);
    opened.browser.wait("document.querySelector('#details h2')");
    assert!(opened.browser.number("return document.querySelectorAll('#details .bits tbody tr').length") >= 1.0);
    opened.browser.press("#frames", END);
    opened.browser.wait("document.querySelector('.list .row[aria-selected=true] .place')?.textContent == document.getElementById('frames').getAttribute('aria-rowcount')");
    opened.browser.is_quiet();
}

#[test]
fn a_filter_chooses_frames_and_a_wrong_one_says_where() {
    let opened = Opened::with(Screen::Desk, "machine.log", faulty().on("can0"));
    opened.view("trace");
    opened.rows();
    opened.browser.fill("#filter", "service=sdo and");
    opened.browser.wait("!document.getElementById('filter-mistake').hidden");
    let mistake = opened.browser.text("return document.getElementById('filter-mistake').textContent");
    assert!(mistake.starts_with("service=sdo and\n            ^ expected"), "{mistake}");
    opened.browser.fill("#filter", " not abort");
    opened.browser.wait(
        "document.getElementById('filter-mistake').hidden && / of /.test(document.querySelector('.shown').textContent)",
    );
    opened.browser.wait(
        "[...document.querySelectorAll('.list .row .service')].every((cell) => ['', 'sdo'].includes(cell.textContent))",
    );
    assert!(opened.browser.text("return location.hash").contains("filter=service"), "the address keeps it");
    opened.browser.is_quiet();
}

#[test]
fn a_text_is_found_and_a_time_is_gone_to() {
    let opened = Opened::with(Screen::Desk, "machine.log", machine(20).on("can0"));
    opened.view("trace");
    opened.rows();
    opened.browser.fill("#jump", &format!("10{ENTER}"));
    opened.browser.wait("Number(document.querySelector('.list .row[aria-selected=true] .time')?.textContent) >= 10");
    opened.browser.fill("#search", &format!("heartbeat{ENTER}"));
    opened
        .browser
        .wait("/heartbeat/.test(document.querySelector('.list .row[aria-selected=true] .text')?.textContent)");
    opened.browser.is_quiet();
}
