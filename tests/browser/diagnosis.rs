//! The page of `canvass diagnose`.

use crate::captures::{Page, faulty, machine};
use canvass_webdriver::{Browser, Screen};

fn open() -> (Browser, Page) {
    let page = Page::of(faulty().on("can0"), "machine.log");
    let browser = Browser::open(&page.path, Screen::Desk);
    browser.wait("canvass.plots.size >= 2 && document.querySelectorAll('.plot canvas').length >= 2");
    (browser, page)
}

/// The range of seconds that the plots show. Panics if two plots show different ranges.
#[track_caller]
fn shown(browser: &Browser) -> (f64, f64) {
    let ranges = browser.run(
        "const { min, max } = canvass.view.now; \
         return [[min / 1e6, max / 1e6], ...[...canvass.plots].map((plot) => [plot.range().min, plot.range().max])]",
    );
    let ranges = ranges.as_array().unwrap();
    assert!(ranges.len() >= 3, "timeline, load and a signal: {ranges:?}");
    let of = |at: usize, end: usize| ranges[at][end].as_f64().unwrap();
    for at in 1..ranges.len() {
        for end in [0, 1] {
            assert!((of(0, end) - of(at, end)).abs() < 1e-9, "not the same time everywhere: {ranges:?}");
        }
    }
    (of(0, 0), of(0, 1))
}

#[test]
fn it_renders_without_a_word_or_a_request() {
    let (browser, _page) = open();
    for id in ["summary", "timeline", "load", "signals", "responses", "nodes", "findings", "frames"] {
        assert_eq!(browser.number(&format!("return document.querySelectorAll('h2#{id}').length")), 1.0, "{id}");
    }
    // The plots contain pixels, not only empty space.
    let inked = "return [...document.querySelectorAll('canvas')].map((canvas) => canvas.getContext('2d') \
                 .getImageData(0, 0, canvas.width, canvas.height).data.filter((value, n) => n % 4 === 3 && value > 0).length)";
    for pixels in browser.run(inked).as_array().unwrap() {
        assert!(pixels.as_f64().unwrap() > 500.0, "an empty plot");
    }
    assert!(browser.number("return document.querySelectorAll('.histogram rect.bar').length") >= 2.0);
    assert!(
        browser.number("return document.querySelector('.histogram rect.bar').getBoundingClientRect().height") > 1.0
    );
    assert!(browser.number("return document.querySelectorAll('.pin').length") >= 3.0);
    assert_eq!(
        browser.number("return document.querySelectorAll('.finding').length"),
        browser.number("return canvass.data.findings.length")
    );
    assert!(browser.text("return document.querySelector('h1').textContent").contains("machine.log"));
    assert!(browser.print().len() > 20_000, "a PDF");
    browser.is_quiet();
}

/// The states of a node in the timeline, with their seconds.
fn lane(browser: &Browser, node: u8) -> Vec<(f64, f64, String)> {
    let spans = browser.run(&format!(
        "const row = canvass.timeline.rows.find((row) => row.id === {node}); \
         return canvass.timeline.segments(row).map(({{ from, to, state }}) => [from / 1e6, to / 1e6, state])"
    ));
    let span = |span: &serde_json::Value| {
        (span[0].as_f64().unwrap(), span[1].as_f64().unwrap(), span[2].as_str().unwrap().to_owned())
    };
    spans.as_array().unwrap().iter().map(span).collect()
}

/// A node has no supply for eight seconds, and two resets of it are in vain: it sends nothing in that time, and boots
/// afterwards. The consumer of its heartbeat reports the loss, and an arrow leads to this report.
#[test]
fn a_silent_node_is_drawn_as_silent() {
    let mut log = machine(40);
    log.sdo(60_000, 3, "2316100196000900", "6016100100000000", 900);
    log.at(1_500, "709#00").at(100_500, "000#0109");
    for us in (140_000..40_000_000).step_by(100_000).filter(|us| !(12_000_000..20_500_000).contains(us)) {
        let state = if (20_500_000..22_000_000).contains(&us) { "7F" } else { "05" };
        log.at(us + 71, &format!("709#{state}"));
    }
    log.at(12_151_000, "083#3081110000000000").at(20_700_123, "083#0000000000000000");
    log.at(15_000_000, "000#8109").at(18_000_000, "000#8109").at(20_300_000, "709#00").at(22_000_000, "000#0109");
    let page = Page::of(log.on("can0"), "silent.log");
    let browser = Browser::open(&page.path, Screen::Desk);
    browser.wait("canvass.timeline && document.querySelectorAll('.pin').length > 0");
    let lane = lane(&browser, 9);
    let states: Vec<&str> = lane.iter().map(|span| span.2.as_str()).filter(|state| *state != "not known").collect();
    assert_eq!(states, ["pre-operational", "operational", "silent", "pre-operational", "operational"], "{lane:?}");
    let silent = lane.iter().find(|span| span.2 == "silent").unwrap();
    assert!((silent.0 - 11.94).abs() < 0.01 && (silent.1 - 20.3).abs() < 0.01, "{silent:?}");
    let legend = browser.text("return document.getElementById('states').textContent");
    assert!(legend.contains("silent") && !legend.contains("reset"), "{legend}");
    // Arrows lead from the loss to the consumer that notices it, never back in time.
    let arrows = browser.run(
        "return canvass.timeline.arrows().map(({ from, to, cause, effect }) => \
         [canvass.data.findings[cause - 1].title, canvass.data.findings[effect - 1].title, from.x, to.x])",
    );
    let arrows = arrows.as_array().unwrap();
    assert!(arrows.iter().any(|arrow| arrow[0] == "a node drops out"), "{arrows:?}");
    assert!(arrows.iter().all(|arrow| arrow[2].as_f64() <= arrow[3].as_f64()), "{arrows:?}");
    browser.is_quiet();
}

#[test]
fn plots_zoom_and_pan_together() {
    let (browser, _page) = open();
    let (first, last) = shown(&browser);
    assert!(first < 0.0 && last > 39.9);
    browser.drag("#signal-plots .u-over", 0.25, 0.5, false);
    let (zoomed_first, zoomed_last) = shown(&browser);
    assert!((zoomed_first - 10.0).abs() < 0.5 && (zoomed_last - 20.0).abs() < 0.5, "{zoomed_first} to {zoomed_last}");
    browser.drag("#load-plots .u-over", 0.5, 0.25, true);
    let (moved_first, moved_last) = shown(&browser);
    assert!((moved_first - zoomed_first - 2.5).abs() < 0.3, "{moved_first}");
    assert!((moved_last - moved_first - (zoomed_last - zoomed_first)).abs() < 1e-6, "moving does not zoom");
    browser.drag("#lanes .area", 0.4, 0.6, false);
    let (lane_first, lane_last) = shown(&browser);
    assert!(lane_last - lane_first < (moved_last - moved_first) * 0.25);
    browser.press("#signal-plots .plot [role=img]", "-");
    let (out_first, out_last) = shown(&browser);
    assert!(out_last - out_first > (lane_last - lane_first) * 1.9);
    browser.press("#lanes .area", "\u{E014}");
    assert!(shown(&browser).0 > out_first, "the right arrow goes on");
    browser.click("[data-view=all]");
    assert_eq!(shown(&browser), (first, last));
    browser.click("[data-view=in]");
    let (in_first, in_last) = shown(&browser);
    assert!((in_last - in_first) < (last - first) * 0.51);
    browser.press("#lanes .area", "0");
    assert_eq!(shown(&browser), (first, last));
    browser.is_quiet();
}

#[test]
fn filters_filter() {
    let (browser, _page) = open();
    let rows = || browser.number("return document.querySelectorAll('#frame-rows tr[id]').length");
    let status = || browser.text("return document.getElementById('frames-shown').textContent");
    assert_eq!((rows(), status()), (200.0, String::new()));
    browser.fill("#frame-text", "8110h");
    assert_eq!(rows(), 1.0);
    assert!(status().starts_with("1 of "), "{}", status());
    assert!(browser.text("return document.querySelector('#frame-rows tr[id]').textContent").contains("CAN overrun"));
    browser.run("document.getElementById('frame-text').value = ''; document.getElementById('frame-text').dispatchEvent(new Event('input'))");
    browser.run(
        "const node = document.getElementById('frame-node'); node.value = '1'; node.dispatchEvent(new Event('input'))",
    );
    let foreign = "return [...document.querySelectorAll('#frame-rows tr[id]')].filter((row) => row.cells[5].textContent !== '701').length";
    assert!(rows() > 1.0);
    assert_eq!(browser.number(foreign), 0.0);
    browser.run(
        "const node = document.getElementById('frame-node'); node.value = ''; node.dispatchEvent(new Event('input'))",
    );
    browser.click("#frame-proof");
    assert_eq!(rows(), browser.number("return Object.keys(canvass.data.proofs).length"));

    let findings = || browser.number("return document.querySelectorAll('.finding:not([hidden])').length");
    let all = findings();
    browser.click(".tile.error");
    let errors =
        browser.number("return canvass.data.findings.filter((finding) => finding.severity === 'error').length");
    assert!(errors > 0.0 && errors < all);
    assert_eq!(findings(), errors);
    browser.click(".tile.error");
    browser.fill("#finding-text", "6099h");
    assert_eq!(findings(), 1.0);
    // A link to a finding that the filter hides shows the finding.
    let linked = browser.text("return document.querySelector('.foremost li:first-child a').hash");
    browser.click(".foremost li:first-child a");
    browser.wait(&format!("`#${{document.activeElement.id}}` === '{linked}' && !document.activeElement.hidden"));
    browser.is_quiet();
}

#[test]
fn a_finding_leads_to_its_frame() {
    let (browser, _page) = open();
    // The link works with any filter of frames.
    browser.fill("#frame-text", "heartbeat");
    let id = browser.text(
        "return [...document.querySelectorAll('.finding')].find((finding) => finding.textContent.includes('8110h')).id",
    );
    browser.run(&format!("document.getElementById('{id}').scrollIntoView({{ block: 'center', behavior: 'instant' }})"));
    let line = browser.text(&format!("return document.querySelector('#{id} a.frame').textContent"));
    browser.click(&format!("#{id} a.frame"));
    browser.wait("document.querySelector('tr.target')");
    let target = browser.run(
        "const row = document.querySelector('tr.target'); const box = row.getBoundingClientRect(); \
         return [`#${row.cells[1].textContent}`, document.activeElement === row, box.top > 0 && box.bottom < innerHeight, \
                 row.textContent]",
    );
    assert_eq!((target[0].as_str(), &target[1], &target[2]), (Some(line.as_str()), &true.into(), &true.into()));
    assert!(target[3].as_str().unwrap().contains("8110h"), "{target}");
    // The frame is shown among its neighbours, and a link leads back to the finding.
    assert!(browser.number("return document.querySelectorAll('#frame-rows tr[id]').length") > 20.0);
    browser.click("tr.target a.proof");
    browser.wait("document.activeElement.matches('.finding')");
    assert!(browser.text("return document.activeElement.textContent").contains("8110h"));
    // The plots move to the time of the finding.
    browser.click(".finding:focus button[data-from]");
    let (first, last) = shown(&browser);
    assert!(first < 12.0 && last > 12.0 && last - first < 20.0, "{first} to {last}");
    browser.is_quiet();
}

#[test]
fn colours_are_the_systems_or_those_chosen() {
    let (browser, _page) = open();
    let paper = || browser.text("return getComputedStyle(document.body).backgroundColor");
    let (light, ink) = (paper(), browser.text("return canvass.color('--ink')"));
    browser.click(".themes label:nth-of-type(3)");
    let dark = paper();
    assert_ne!(light, dark);
    assert_ne!(browser.text("return canvass.color('--ink')"), ink, "plots too");
    browser.click(".themes label:nth-of-type(2)");
    assert_eq!(paper(), light);
    browser.is_quiet();
}

#[test]
fn hostile_names_stay_text() {
    const NAME: &str = "<img src=x onerror=owned()>";
    let mut log = faulty();
    // One device name arrives in segments, another in an expedited response.
    log.sdo(200_000, 3, "4008100000000000", "410810001B000000", 500);
    for (n, segment) in NAME.as_bytes().chunks(7).enumerate() {
        let bytes: String = segment.iter().map(|byte| format!("{byte:02X}")).collect();
        let (toggle, last) = (n as u8 & 1, (n + 1) * 7 >= NAME.len());
        let command = toggle << 4 | if last { (7 - segment.len() as u8) << 1 | 1 } else { 0 };
        let request = format!("{:02X}00000000000000", 0x60 | toggle << 4);
        log.sdo(210_000 + n as u64 * 2_000, 3, &request, &format!("{command:02X}{bytes:0<14}"), 500);
    }
    let text = log.on("</script><script>owned()</script>\u{202e}").to_owned();
    let page = Page::of(&text, "<b onmouseover=owned()>&lt;\u{2028}.log");
    let browser = Browser::open(&page.path, Screen::Desk);
    browser.wait("canvass.plots.size >= 2");
    assert!(page.folder().exists());
    assert_eq!(browser.number("return document.querySelectorAll('img, b, [onerror], [onmouseover]').length"), 0.0);
    let scripts = browser
        .number("return [...document.scripts].filter((script) => script.textContent.startsWith('owned')).length");
    assert_eq!(scripts, 0.0);
    assert!(
        browser
            .text("return document.querySelector('h1').textContent")
            .contains("<b onmouseover=owned()>&lt;\\u{2028}")
    );
    assert!(browser.text("return canvass.data.channels[0]").contains("</script><script>owned()</script>\\u{202E}"));
    assert!(browser.text("return document.getElementById('nodes').parentElement.textContent").contains(NAME));
    assert!(browser.text("return document.querySelector('#frame-rows').textContent").contains(NAME));
    browser.is_quiet();
}

#[test]
fn it_fits_a_phone() {
    let page = Page::of(faulty().on("can0"), "machine.log");
    let browser = Browser::open(&page.path, Screen::Phone);
    browser.wait("document.querySelectorAll('.plot canvas').length >= 2");
    let widths = browser.run("return [document.documentElement.scrollWidth, innerWidth]");
    assert_eq!(widths[0], widths[1], "the page is wider than the phone");
    assert_eq!(widths[1], 390);
    browser.is_quiet();
}

#[test]
fn a_healthy_capture_says_so() {
    let page = Page::of(crate::captures::machine(5).on("can0"), "healthy.log");
    let browser = Browser::open(&page.path, Screen::Desk);
    browser.wait("document.querySelectorAll('.plot canvas').length >= 2");
    assert_eq!(browser.number("return document.querySelectorAll('.finding').length"), 0.0);
    assert!(browser.text("return document.querySelector('.outcome').textContent").contains("Nothing wrong"));
    browser.is_quiet();
}

/// Captures without known nodes, or with all times zero.
#[test]
fn captures_of_nothing_and_without_times() {
    for log in ["(0.000000) can0 705#05\n", "(0.0) can0 12345678#00\n(0.0) can0 20000004#0000000000000000\n"] {
        let page = Page::of(log, "odd.log");
        let browser = Browser::open(&page.path, Screen::Desk);
        browser.wait("document.querySelectorAll('#frame-rows tr').length > 0");
        browser.is_quiet();
    }
}
