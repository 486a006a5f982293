//! `cargo xtask web-bench`: measures the times of the page, compared with the program, and the memory of its tab.
//! Nothing is asserted: times depend on other work of the machine.

use super::browser::{Browser, Opened, Screen};
use crate::bench::{capture, make};
use crate::browser;
use crate::measure::RUNS;
use crate::measure::{TIME, cost, machine, release};
use crate::packages::install;
use anyhow::{Context, Result};
use std::fs;
use std::process::Stdio;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

const FRAMES: u32 = 1_000_000;
/// Number of frames in a gigabyte of the usual traffic.
const MANY: u32 = 23_100_000;
const LARGE: &str = "target/bench/large.candump";
/// Interval between two measurements of the tab's memory.
const LOOK: Duration = Duration::from_millis(100);
/// Number of rows to which the list scrolls.
const SCROLLED: u32 = 100;

/// Measures the page and the program, and prints the results.
///
/// # Errors
/// If something is missing or can't be built, or the page does not answer.
pub fn bench() -> Result<()> {
    install(&[TIME])?;
    browser::install_all()?;
    super::build()?;
    crate::bench::build()?;
    fs::create_dir_all("target/bench")?;
    let log = capture("candump");
    make("candump", FRAMES, &log)?;
    println!("machine: {}", machine());
    println!(
        "WebAssembly, compressed: {} bytes",
        fs::metadata(format!("{}/wasm/canvass_web.wasm.gz", super::FOLDER))?.len()
    );
    million(&log)?;
    make("candump", MANY, LARGE)?;
    let measured = gigabyte();
    fs::remove_file(LARGE)?;
    measured
}

/// Measures the time from the choice of the file to the page of the diagnosis, and the time until the rows of the list
/// appear after scrolling.
fn million(log: &str) -> Result<()> {
    println!("{FRAMES} frames, {} MB, best of {RUNS} runs", fs::metadata(log)?.len() / 1_000_000);
    let command = [&release("canvass"), "diagnose", "--format", "html", "--fail-on", "never", log];
    let mut program: Option<f64> = None;
    let mut page: Option<f64> = None;
    let mut read: Option<f64> = None;
    for _ in 0..RUNS {
        let began = Instant::now();
        cost(&command, Stdio::null())?;
        program = least(program, began.elapsed().as_secs_f64());
        let opened = Opened::new(Screen::Desk)?;
        // A user opens the page a moment before dropping a capture.
        opened.0.wait("performance.getEntriesByName('canvass-warm').length > 0");
        opened.take(&[log])?;
        page = least(page, diagnosed(&opened.0));
        read =
            least(read, opened.0.number("return performance.getEntriesByName('canvass-read').at(-1).duration") / 1e3);
    }
    let (program, page) = (program.unwrap_or_default(), page.unwrap_or_default());
    println!("{:44} {program:>6.2} s", "canvass diagnose --format html");
    println!("{:44} {:>6.2} s", "the page, until all frames are read", read.unwrap_or_default());
    println!("{:44} {page:>6.2} s, {:.1} times as long", "the page, until its diagnosis stands", page / program);
    let opened = Opened::new(Screen::Desk)?;
    opened.take(&[log])?;
    diagnosed(&opened.0);
    opened.view("trace");
    opened.0.wait("document.querySelector('.list .row:not(.head) .text')?.textContent");
    let [middle, longest] = scrolled(&opened.0)?;
    println!("{:44} {middle:>6.1} ms, at most {longest:.1} ms", format!("scrolling to each of {SCROLLED} rows"));
    Ok(())
}

fn least(known: Option<f64>, new: f64) -> Option<f64> {
    Some(known.map_or(new, |known| known.min(new)))
}

/// The seconds until the diagnosis, by the page's own clock.
fn diagnosed(browser: &Browser) -> f64 {
    browser.wait_for("performance.getEntriesByName('canvass-diagnosis').length > 0", Duration::from_secs(600));
    browser.number("return performance.getEntriesByName('canvass-diagnosis').at(-1).duration") / 1e3
}

/// Milliseconds from a move of the scroll bar until all rows at the new position have their texts: the median and the
/// maximum.
fn scrolled(browser: &Browser) -> Result<[f64; 2]> {
    let script = format!(
        "return (async () => {{
            const list = document.getElementById('frames');
            const times = [];
            let chance = 1;
            for (let n = 0; n < {SCROLLED}; n++) {{
                chance = (chance * 48271) % 2147483647;
                const before = list.querySelector('.list-body .row').getAttribute('aria-rowindex');
                const began = performance.now();
                list.scrollTop = Math.floor((chance / 2147483647) * (list.scrollHeight - list.clientHeight));
                const there = () => {{
                    const rows = [...list.querySelectorAll('.list-body .row')].filter((row) => !row.hidden);
                    return rows[0].getAttribute('aria-rowindex') !== before && rows.every((row) => row.lastChild.textContent !== '');
                }};
                do await new Promise((resolve) => requestAnimationFrame(resolve));
                while (!there());
                times.push(performance.now() - began);
            }}
            times.sort((a, b) => a - b);
            return [times[times.length >> 1], times.at(-1)];
        }})()"
    );
    let times = browser.run(&script);
    let time = |at: usize| times[at].as_f64().context("expected a time in milliseconds");
    Ok([time(0)?, time(1)?])
}

/// Measures the memory of the tab, and how quickly it reacts to a cancellation.
fn gigabyte() -> Result<()> {
    let opened = Opened::new(Screen::Desk)?;
    let empty = opened.0.memory()?;
    let (took, mut most) = watched(&opened.0, || {
        opened.take(&[LARGE])?;
        Ok(diagnosed(&opened.0))
    })?;
    let bytes = fs::metadata(LARGE)?.len() as f64 / 1e9;
    println!("{:44} {took:>6.1} s", format!("a log of {bytes:.2} GB, {MANY} frames"));
    let ((), later) = watched(&opened.0, || {
        opened.view("trace");
        opened.0.press("#frames", "\u{E010}");
        opened.0.wait("document.querySelector('.list .row[aria-selected=true] .text')?.textContent");
        Ok(())
    })?;
    most = most.max(later);
    println!("{:44} {:>6} MB, {} MB without a capture", "memory of the tab at most", most / 1000, empty / 1000);
    opened.take(&[LARGE])?;
    opened.0.wait("document.querySelector('#progress progress').value > 0.02");
    let began = Instant::now();
    opened.0.click("#progress button");
    opened.0.wait("/cancelled/.test(document.getElementById('status').textContent)");
    println!("{:44} {:>6.0} ms", "cancelled within", began.elapsed().as_secs_f64() * 1e3);
    Ok(())
}

/// Calls `does`, and measures the peak of the tab's memory meanwhile, in kB.
fn watched<T>(browser: &Browser, does: impl FnOnce() -> Result<T>) -> Result<(T, u64)> {
    let ended = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let looking = scope.spawn(|| {
            let mut most = 0;
            while !ended.load(Ordering::Relaxed) {
                most = most.max(browser.memory().unwrap_or(0));
                std::thread::sleep(LOOK);
            }
            most.max(browser.memory().unwrap_or(0))
        });
        let done = does();
        ended.store(true, Ordering::Relaxed);
        let most = looking.join().unwrap_or(0);
        done.map(|done| (done, most))
    })
}
