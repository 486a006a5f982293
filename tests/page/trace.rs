//! The view of all frames with their meanings.

use crate::captures::{faulty, machine};
use crate::opened::Opened;
use canvass_webdriver::Screen;

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
    opened.browser.wait("document.querySelector('.list .row[aria-selected=true] .place')?.textContent == document.getElementById('frames').getAttribute('aria-rowcount') - 1");
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
    assert!(mistake.starts_with("service=sdo and\n               ^ expected a test"), "{mistake}");
    opened.browser.fill("#filter", " not abort");
    opened.browser.wait(
        "document.getElementById('filter-mistake').hidden && / of /.test(document.querySelector('#view-trace .shown').textContent)",
    );
    opened.browser.wait(
        "[...document.querySelectorAll('.list-body .row .service')].every((cell) => ['', 'sdo'].includes(cell.textContent))",
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

#[test]
fn what_can_stand_in_a_filter_is_offered() {
    let opened = Opened::with(Screen::Desk, "machine.log", faulty().on("can0"));
    opened.view("trace");
    opened.rows();
    opened.browser.fill("#filter", "not service=sd");
    opened.browser.wait("[...document.querySelectorAll('.words li')].map((word) => word.textContent).join() === 'sdo'");
    opened.browser.press("#filter", DOWN);
    opened.browser.press("#filter", ENTER);
    opened.browser.wait(
        "document.getElementById('filter').value === 'not service=sdo' && document.querySelector('.words').hidden",
    );
    opened.browser.fill("#filter", " and channel=");
    opened.browser.wait("document.querySelector('.words li')?.textContent === 'can0'");
    opened.browser.is_quiet();
}

#[test]
fn columns_are_chosen_and_the_address_keeps_them() {
    let opened = Opened::with(Screen::Desk, "machine.log", machine(20).on("can0"));
    opened.view("trace");
    let cells = |opened: &Opened| opened.rows()[1].split('|').count();
    let before = cells(&opened);
    opened.browser.run("document.querySelector('#view-trace .menu').open = true");
    opened.browser.click("#view-trace .menu label:nth-of-type(2) input");
    assert_eq!(cells(&opened), before + 1, "the time since the frame before");
    opened.browser.click("#view-trace .menu label:nth-of-type(5) input");
    assert_eq!(cells(&opened), before);
    assert!(opened.browser.text("return location.hash").contains("hide=absolute%2Cchannel"));
    opened.browser.is_quiet();
}

/// The details cover the lower part of a phone's screen, where the row may have been.
#[test]
fn on_a_phone_the_chosen_row_stays_in_sight() {
    let opened = Opened::with(Screen::Phone, "machine.log", machine(20).on("can0"));
    let browser = &opened.browser;
    opened.view("trace");
    browser.wait("document.querySelector('.list .row:not(.head) .text')?.textContent");
    browser.fill("#jump", &format!("15{ENTER}"));
    browser.wait("document.querySelector('#details h2')");
    browser.wait(
        "(() => {
            const row = document.querySelector('.list .row[aria-selected=true]:not([hidden])');
            const list = document.getElementById('frames').getBoundingClientRect();
            return row && row.getBoundingClientRect().bottom <= list.bottom && list.bottom <= innerHeight;
        })()",
    );
}

#[test]
fn list_plots_and_timeline_point_at_the_same_time() {
    let opened = Opened::with(Screen::Desk, "machine.log", machine(20).on("can0"));
    let browser = &opened.browser;
    let left = "return Number.parseFloat(document.querySelector('.lanes .cursor').style.left)";
    browser.wait("document.querySelector('#view-diagnosis iframe')");
    browser.within("#view-diagnosis iframe", |browser| browser.drag(".lanes .area", 0.5, 0.5, false));
    browser.wait("/^Cursor at /.test(document.querySelector('#view-diagnosis .bar .shown').textContent)");
    opened.view("trace");
    browser.wait("document.querySelector('.list .row[aria-selected=true] .time')?.textContent > '5'");
    let time =
        browser.number("return Number(document.querySelector('.list .row[aria-selected=true] .time').textContent)");
    assert!((8.0..12.0).contains(&time), "the middle of 20 s: {time}");
    // The list continues from this frame, and the other views follow.
    browser.fill("#jump", &format!("15{ENTER}"));
    browser.wait("Number(document.querySelector('.list .row[aria-selected=true] .time')?.textContent) >= 15");
    opened.view("diagnosis");
    browser.within("#view-diagnosis iframe", |browser| {
        browser.wait("!document.querySelector('.lanes .cursor').hidden");
        let at = browser.number(left);
        assert!((70.0..80.0).contains(&at), "three quarters: {at} %");
    });
    opened.view("signals");
    browser.wait("document.querySelector('#plot canvas')");
    browser.wait("Number(document.getElementById('cursor-A').value) >= 15");
    browser.drag("#plot .u-over", 0.25, 0.25, false);
    browser.wait("Number(document.getElementById('cursor-A').value) < 10");
    opened.view("trace");
    browser.wait("Number(document.querySelector('.list .row[aria-selected=true] .time')?.textContent) < 10");
    browser.is_quiet();
}
