//! From what was found to the frames: every link of every report, one cursor, and what stays when something else changes.

use crate::captures::{faulty, machine};
use crate::opened::Opened;
use canvass_webdriver::{Browser, Screen};
use std::process::Command;

const ENTER: &str = "\u{E007}";
const DOWN: &str = "\u{E015}";
const SPACE: &str = "\u{E00D}";

/// Follows every link of the shown report; returns those whose target is not on the screen afterwards, and the number of
/// links.
fn followed(browser: &Browser) -> (Vec<String>, usize) {
    let told = browser.run(
        "const links = [...document.querySelectorAll('a[href^=\"#\"]')].map((link) => link.getAttribute('href'));
         const missed = [];
         for (const href of new Set(links)) {
           [...document.querySelectorAll('a[href^=\"#\"]')].find((link) => link.getAttribute('href') === href)?.click();
           const target = document.getElementById(decodeURIComponent(href.slice(1)));
           const { top, bottom, height } = target?.getBoundingClientRect() ?? { top: -1, bottom: -1, height: 0 };
           if (!target || (height > 0 && (bottom < 0 || top > innerHeight)) || !target.checkVisibility()) missed.push(href);
         }
         return [missed, links.length]",
    );
    let missed = told[0].as_array().unwrap().iter().map(ToString::to_string).collect();
    (missed, told[1].as_u64().unwrap() as usize)
}

fn selected_time(browser: &Browser) -> f64 {
    browser.number("return Number(document.querySelector('.list .row[aria-selected=true] .time')?.textContent)")
}

#[test]
fn every_link_of_every_report_leads_to_its_target() {
    let opened = Opened::with(Screen::Desk, "machine.log", faulty().on("can0"));
    let browser = &opened.browser;
    let all_lead = |selector: &str, least: usize| {
        browser.wait(&format!("document.querySelector('{selector}')"));
        browser.within(selector, |browser| {
            browser.wait("document.readyState === 'complete' && !document.querySelector('#frame-rows:empty')");
            let (missed, links) = followed(browser);
            assert!(missed.is_empty() && links >= least, "{selector}: of {links} links {missed:?}");
        });
    };
    all_lead("#view-diagnosis iframe", 20);
    let eds = include_str!("../../conformance/device/models/kuebler-sendix-58x8.eds");
    opened.take(&[opened.file("encoder.eds", eds)]);
    opened.view("eds");
    all_lead("#view-eds iframe", 3);
    let tested = |name: &str, faults: &str| {
        let bus = format!("sim:reference-301{faults}");
        let program = Command::new(env!("CARGO_BIN_EXE_canvass"))
            .args(["test", &bus, "--select", "301/boot-up", "--format", "json"])
            .output();
        opened.file(name, program.unwrap().stdout)
    };
    opened.take(&[tested("1.0.json", ""), tested("1.1.json", "+boot-up-twice")]);
    opened.view("results");
    all_lead("#view-results iframe", 2);
    opened.view("try");
    browser.wait("document.querySelector('#try-faults input[value=boot-up-twice]')");
    browser.click("#try-faults input[value=boot-up-twice]");
    browser.fill("#try-select", "301/boot-up\u{E00C}");
    browser.click("#try-test");
    browser.wait("/: done/.test(document.getElementById('status').textContent)");
    all_lead("#view-try iframe", 5);
    browser.is_quiet();
}

/// Finding, its evidence, the frame in the trace, its time in the plot: each with one click.
#[test]
fn from_a_finding_to_its_frame() {
    let opened = Opened::with(Screen::Desk, "machine.log", faulty().on("can0"));
    let browser = &opened.browser;
    browser.wait("document.querySelector('#view-diagnosis iframe')");
    let mut at = 0.0;
    browser.within("#view-diagnosis iframe", |browser| {
        browser.wait("document.querySelector('#frame-rows tr')");
        browser.run("document.querySelector('.finding[data-severity=error] a.frame').click()");
        browser.wait("document.activeElement?.id.startsWith('frame-')");
        at = browser.number("return Number(document.activeElement.firstChild.textContent)");
    });
    browser.wait("/^Cursor at /.test(document.querySelector('#view-diagnosis .bar .shown').textContent)");
    browser.click("#view-diagnosis .bar .shown button");
    browser.wait("document.querySelector('#details h2')");
    assert!((selected_time(browser) - at).abs() < 1e-5, "{} and {at}", selected_time(browser));
    opened.view("signals");
    browser.wait("document.getElementById('cursor-A')?.value");
    assert!((browser.number("return Number(document.getElementById('cursor-A').value)") - at).abs() < 1e-5);
    // The time of a finding sets the cursor, too.
    opened.view("diagnosis");
    browser.within("#view-diagnosis iframe", |browser| {
        browser.run("document.querySelector('.finding:last-of-type button[data-from]').click()");
        browser.wait("!document.querySelector('.lanes .cursor').hidden");
    });
    browser.is_quiet();
}

#[test]
fn a_filter_keeps_the_chosen_frame() {
    let opened = Opened::with(Screen::Desk, "machine.log", faulty().on("can0"));
    let browser = &opened.browser;
    opened.view("trace");
    opened.rows();
    browser.fill("#search", &format!("abort{ENTER}"));
    browser.wait("/abort/.test(document.querySelector('#details h2')?.textContent)");
    let (time, details) = (selected_time(browser), "return document.querySelector('#details h2').textContent");
    let chosen = browser.text(details);
    browser.fill("#filter", "service=sdo");
    browser.wait(
        "/ of /.test(document.querySelector('#view-trace .shown[role=status]:last-of-type')?.textContent ?? ' of ')",
    );
    browser.wait("[...document.querySelectorAll('.list-body .row .service')].every((cell) => ['', 'sdo'].includes(cell.textContent))");
    browser.wait("document.querySelector('.list .row[aria-selected=true]:not([hidden])')");
    assert_eq!((selected_time(browser), browser.text(details)), (time, chosen.clone()));
    // It does not pass: nothing is highlighted, the details stay, and the arrow goes on from its place.
    browser.run("document.getElementById('filter').value = ''");
    browser.fill("#filter", "service=pdo");
    browser.wait("/does not pass the filter/.test(document.querySelector('.outcome').textContent)");
    assert!(browser.number("return document.querySelectorAll('.list .row[aria-selected=true]').length") < 0.5);
    assert_eq!(browser.text(details), chosen);
    browser.press("#frames", DOWN);
    browser.wait("document.querySelector('.list .row[aria-selected=true] .time')?.textContent");
    let next = selected_time(browser);
    assert!(next >= time && next < time + 0.1, "{time} and {next}");
    browser.is_quiet();
}

#[test]
fn a_search_stays_in_the_filter_and_goes_on_from_the_beginning() {
    let opened = Opened::with(Screen::Desk, "machine.log", machine(20).on("can0"));
    let browser = &opened.browser;
    opened.view("trace");
    opened.rows();
    let outcome = "document.querySelector('.outcome').textContent";
    // Data as it is shown, and as it is written in logs.
    let first = browser.text("return document.querySelector('.list-body .row .data').textContent");
    browser.fill("#search", &format!("{first}{ENTER}"));
    browser.wait("document.querySelector('#details h2')");
    browser.fill("#filter", "service=heartbeat");
    browser.wait("document.querySelector('.list-body .row .service')?.textContent === 'heartbeat'");
    browser.run("document.getElementById('search').value = ''");
    browser.fill("#search", &format!("upload{ENTER}"));
    browser.wait(&format!("{outcome} === 'in no frame that passes the filter'"));
    browser.fill("#search", "x");
    browser.wait(&format!("{outcome} === ''"));
    browser.run("document.getElementById('search').value = ''");
    browser.press("#frames", "\u{E010}");
    browser.fill("#search", &format!("heartbeat{ENTER}"));
    browser.wait(&format!("{outcome} === 'on from the beginning'"));
    browser.is_quiet();
}

#[test]
fn a_time_is_gone_to_as_it_is_shown_and_as_clocks_show_it() {
    let opened = Opened::with(Screen::Desk, "machine.log", machine(20).on("can0"));
    let browser = &opened.browser;
    opened.view("trace");
    opened.rows();
    let start = browser.number("return Number(document.querySelector('.list-body .row .absolute').textContent)");
    let clock = |seconds: f64| {
        let of_day = (start + seconds) as u64 % 86_400;
        format!("{:02}:{:02}:{:02}", of_day / 3600, of_day / 60 % 60, of_day % 60)
    };
    for (typed, from, to) in
        [("7,5".to_owned(), 7.5, 7.6), (format!("{:.3}", start + 12.0), 11.99, 12.1), (clock(16.0), 15.0, 16.1)]
    {
        browser.run("document.getElementById('jump').value = ''");
        browser.fill("#jump", &format!("{typed}{ENTER}"));
        browser.wait(&format!("(() => {{ const at = Number(document.querySelector('.list .row[aria-selected=true] .time')?.textContent); return at >= {from} && at <= {to}; }})()"));
    }
    browser.fill("#jump", &format!(" noon{ENTER}"));
    browser.wait("/^expected seconds/.test(document.querySelector('.outcome').textContent)");
    browser.is_quiet();
}

#[test]
fn what_is_dropped_does_not_undo_what_is_open() {
    let opened = Opened::with(Screen::Desk, "machine.log", machine(20).on("can0"));
    let browser = &opened.browser;
    let status = "document.getElementById('status').textContent";
    opened.take(&[opened.file("picture.bin", [0x89, b'P', b'N', b'G', 0, 1, 2, 3])]);
    browser.wait(&format!("/the captures before are open again/.test({status})"));
    opened.view("trace");
    assert!(opened.rows().len() > 10);
    // A description is known by its content, and two can't both be that of all nodes.
    let eds = include_str!("../../conformance/device/models/kuebler-sendix-58x8.eds");
    opened.take(&[opened.file("encoder.txt", eds)]);
    browser.wait(&format!("/frames, /.test({status})"));
    opened.view("eds");
    browser.wait("document.querySelector('#view-eds .card')");
    opened.take(&[opened.file("other.eds", eds)]);
    browser.wait(&format!("/encoder.txt describes all nodes already/.test({status})"));
    // The browser's button Back leads to the view before.
    browser.run("history.back()");
    browser.wait("!document.getElementById('view-trace').hidden");
    // Results are removed one by one.
    opened.take(&[opened.file("a.json", "{}"), opened.file("b.json", "{}")]);
    browser.wait("document.querySelectorAll('#view-results .card').length === 2");
    browser.click("#view-results .card .plain");
    browser.wait("document.querySelectorAll('#view-results .card').length === 1");
    browser.is_quiet();
}

#[test]
fn the_space_bar_keeps_the_focus_on_a_signal() {
    let opened = Opened::with(Screen::Desk, "machine.log", machine(20).on("can0"));
    let browser = &opened.browser;
    opened.view("signals");
    browser.wait("document.querySelector('#plot canvas')");
    let before = browser.number("return Number(document.querySelector('.signals input').checked)");
    browser.press(".signals input", SPACE);
    browser.wait(&format!("Number(document.querySelector('.signals input').checked) !== {before}"));
    browser.wait("document.activeElement === document.querySelector('.signals input')");
    browser.is_quiet();
}

/// A zoom of 200 % on a laptop leaves 640 by 450 points.
#[test]
fn a_low_window_has_room_for_frames_and_plot() {
    let opened = Opened::with(Screen::Zoomed, "machine.log", machine(20).on("can0"));
    let browser = &opened.browser;
    opened.view("trace");
    browser.wait("document.querySelectorAll('.list-body .row:not([hidden])').length >= 10");
    opened.view("signals");
    browser.wait("document.querySelector('#plot canvas')");
    let overlaps = browser.number(
        "const [boxes, plot] = ['.signals', '#plot'].map((one) => document.querySelector(one).getBoundingClientRect());
         return Math.max(0, Math.min(boxes.right, plot.right) - Math.max(boxes.left, plot.left))
           * Math.max(0, Math.min(boxes.bottom, plot.bottom) - Math.max(boxes.top, plot.top))",
    );
    assert!(overlaps < 1.0, "the boxes lie over the plot");
    assert!(browser.number("return document.querySelector('#plot canvas').clientHeight") > 150.0);
}
