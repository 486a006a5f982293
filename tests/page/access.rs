//! Accessibility of the page: the rules of axe-core, in every view, light and dark.

use crate::captures::machine;
use crate::opened::Opened;
use canvass_webdriver::{Browser, Screen};
use serde_json::json;

const EDS: &str = include_str!("../../conformance/device/models/kuebler-sendix-58x8.eds");
const RESULT: &str = r#"{"schema":"canvass/test/1","bus":"sim:x","node":5,"summary":{"pass":1,"fail":1},"cases":[
    {"id":"301/a","requirement":"It is so.","clause":"7.2","level":"must","verdict":"fail",
     "reason":{"duty":"d","expected":"this","actual":"that"},"breaches":[],"notes":[],"measurements":[],
     "evidence":[{"t":1,"channel":"sim","id":1797,"direction":"rx","data":"00","text":"boot-up"}]},
    {"id":"301/b","requirement":"It is so.","clause":"7.2","level":"must","verdict":"pass","reason":null}]}"#;

#[test]
fn no_view_breaks_a_rule() {
    let opened = Opened::empty(Screen::Desk);
    let mut traffic = machine(20);
    let files = [("machine.log", traffic.on("can0")), ("encoder.eds", EDS), ("r.json", RESULT)];
    opened.take(&files.map(|(name, content)| opened.file(name, content)));
    opened.browser.wait("/frames, /.test(document.getElementById('status').textContent)");
    let source = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("web/page/node_modules/axe-core/axe.min.js");
    opened.browser.run(&std::fs::read_to_string(source).unwrap());
    for colours in ["light", "dark"] {
        opened.browser.run(&format!(
            "const theme = document.getElementById('theme'); theme.value = '{colours}'; theme.dispatchEvent(new Event('change'))"
        ));
        for view in ["diagnosis", "trace", "signals", "eds", "results", "try", "export"] {
            opened.view(view);
            prepare(&opened.browser, view);
            let broken = opened.browser.run(
                "return axe.run(document, { iframes: false, resultTypes: ['violations'] }).then(({ violations }) => \
                 violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html, failureSummary }) => `${html} ${failureSummary}`).join(', ')}`))",
            );
            assert_eq!(broken, json!([]), "{view}, {colours}");
        }
    }
}

/// Brings a view into the state after its first use.
fn prepare(browser: &Browser, view: &str) {
    match view {
        "trace" => {
            browser.wait("document.querySelector('.list-body .row .text')?.textContent");
            browser.press("#frames", "\u{E015}");
            browser.wait("document.querySelector('#details h2')");
            browser.run("document.querySelector('#view-trace .menu').open = true");
        }
        "signals" => browser.wait("document.querySelector('#plot canvas')"),
        "results" => {
            browser.run("document.querySelector('.entry').open = true");
            browser.wait("document.querySelector('.entry dl')");
        }
        "try" => browser.wait("document.querySelector('#try-faults input')"),
        _ => {}
    }
}
