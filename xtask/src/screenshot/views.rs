//! Pictures of each view of the page with the decoder as WebAssembly: on a desktop screen in light colours, on a phone
//! in dark colours.

use super::machine::machine;
use super::{FOLDER, ensure_small, releases};
use crate::web;
use crate::web::browser::{Opened, Screen};
use anyhow::Result;
use std::fs;

const PICTURES: &str = "docs/web";
const DESCRIPTION: &str = "conformance/device/models/kuebler-sendix-58x8.eds";
const ENTER: &str = "\u{E007}";

/// Takes the pictures.
///
/// # Errors
/// If the page can't be made, or a picture is too large.
pub fn views() -> Result<()> {
    web::build()?;
    fs::create_dir_all(PICTURES)?;
    // A description without a node-ID describes all nodes.
    let eds = format!("{FOLDER}/encoder.eds");
    fs::copy(DESCRIPTION, &eds)?;
    let capture = format!("{FOLDER}/machine.log");
    fs::write(&capture, machine()?)?;
    for (screen, colours, ending) in [(Screen::Desk, "light", ""), (Screen::Phone, "dark", "-phone")] {
        let opened = Opened::new(screen)?;
        let scheme = serde_json::json!([{ "name": "prefers-color-scheme", "value": colours }]);
        opened.0.command("Emulation.setEmulatedMedia", &serde_json::json!({ "features": scheme }));
        opened.take(&[&eds, &capture])?;
        opened.0.wait("/frames, /.test(document.getElementById('status').textContent)");
        for (view, prepare) in VIEWS {
            opened.view(view);
            prepare(&opened, screen)?;
            photograph(&opened, &format!("{PICTURES}/{view}{ending}.png"))?;
        }
    }
    Ok(())
}

type Prepare = fn(&Opened, Screen) -> Result<()>;

const VIEWS: [(&str, Prepare); 7] = [
    ("diagnosis", |opened, _| {
        shown_within(opened, "#view-diagnosis iframe", "document.querySelector('.lanes canvas')")
    }),
    ("trace", trace),
    ("signals", signals),
    ("eds", |opened, _| shown_within(opened, "#view-eds iframe", "document.querySelector('table')")),
    ("results", results),
    ("try", tried),
    ("export", |_, _| Ok(())),
];

/// Waits until a report has drawn its content.
fn shown_within(opened: &Opened, frame: &str, expression: &str) -> Result<()> {
    opened.0.wait(&format!("document.querySelector('{frame}')"));
    opened.0.within(frame, |browser| {
        browser.wait(expression);
        settle(browser);
    });
    settle(&opened.0);
    Ok(())
}

/// Waits for two frames of the screen, after which everything is drawn.
fn settle(browser: &web::browser::Browser) {
    browser.run(
        "return new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(resolve, 300))))",
    );
}

/// Shows a filter, and an aborted SDO transfer in detail.
fn trace(opened: &Opened, screen: Screen) -> Result<()> {
    opened.0.fill("#filter", "not service in pdo,sync,heartbeat");
    opened.0.wait("/^[0-9]{1,3} of /.test(document.querySelector('#view-trace .shown').textContent)");
    opened.0.fill("#search", &format!("abort{ENTER}"));
    opened.0.wait("document.querySelector('#details h2')");
    if screen == Screen::Desk {
        opened.0.wait("document.querySelector('.list .row[aria-selected=true]')");
    }
    settle(&opened.0);
    Ok(())
}

/// Shows the position of an encoder in steps and degrees, between two cursors.
fn signals(opened: &Opened, _: Screen) -> Result<()> {
    opened.0.wait("document.querySelector('#plot canvas')");
    opened.0.wait("document.querySelectorAll('.signals input').length > 1");
    opened.0.run("document.querySelectorAll('.signals input')[1].click()");
    settle(&opened.0);
    opened.0.drag("#plot .u-over", 0.3, 0.3, false);
    opened.0.drag("#plot .u-over", 0.7, 0.7, true);
    settle(&opened.0);
    Ok(())
}

/// Shows the changes of a release.
fn results(opened: &Opened, _: Screen) -> Result<()> {
    let files = releases()?;
    opened.take(&files.iter().take(2).map(String::as_str).collect::<Vec<_>>())?;
    shown_within(opened, "#view-results iframe", "document.querySelector('h1')")
}

/// Shows a fault of a simulated device, and the case that finds it.
fn tried(opened: &Opened, _: Screen) -> Result<()> {
    opened.0.wait("document.querySelector('#try-faults input[value=boot-up-twice]')");
    opened.0.click("#try-faults input[value=boot-up-twice]");
    opened.0.fill("#try-select", "301/boot-up\u{E00C}");
    opened.0.click("#try-test");
    opened.0.wait(
        "document.querySelector('#view-try iframe') && /: done/.test(document.getElementById('status').textContent)",
    );
    shown_within(opened, "#view-try iframe", "document.querySelector('h1')")
}

fn photograph(opened: &Opened, picture: &str) -> Result<()> {
    fs::write(picture, opened.0.picture())?;
    ensure_small(picture)
}
