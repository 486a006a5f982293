//! The page of `canvass test`.

use crate::captures::Page;
use canvass_webdriver::{Browser, Screen};

#[test]
fn it_renders_and_filters() {
    let page = Page::of_test("sim:kuebler-sendix-58x8");
    let browser = Browser::open(&page.path, Screen::Desk);
    let visible = || browser.number("return document.querySelectorAll('.finding:not([hidden])').length");
    let status = || browser.text("return document.getElementById('shown').textContent");
    let all = visible();
    assert!(all > 50.0 && status().is_empty());
    browser.fill("#filter", "segment-toggle");
    assert!(visible() >= 1.0 && visible() < 10.0);
    assert_eq!(status(), format!("{} of {all}", visible()));
    // A link to a case that the filter hides shows the case again.
    let hidden = browser.text("return document.querySelector('.finding[hidden]').id");
    browser.click(&format!(".cell[href='#{hidden}']"));
    browser.wait(&format!("document.getElementById('{hidden}').open && !document.getElementById('{hidden}').hidden"));
    browser.run(
        "const filter = document.getElementById('filter'); filter.value = ''; filter.dispatchEvent(new Event('input'))",
    );
    assert_eq!(visible(), all);
    browser.click(".tile.not_applicable");
    let kinds = "return document.querySelectorAll('.finding:not([hidden]):not([data-kind=not_applicable])').length";
    assert_eq!(browser.number(kinds), 0.0);
    assert_eq!(
        visible(),
        browser
            .text("return document.querySelector('.tile.not_applicable .count').textContent")
            .parse::<f64>()
            .unwrap()
    );
    browser.click(".tile.not_applicable");
    assert_eq!(visible(), all);
    browser.is_quiet();
}

/// A click on the count of failures shows the failed cases and no others. Each is open, with its frames and times;
/// delays are drawn as bars.
#[test]
fn a_click_on_the_failures_shows_them() {
    let page = Page::of_test("sim:kuebler-sendix-58x8+boot-up-twice");
    let browser = Browser::open(&page.path, Screen::Desk);
    let visible = || browser.number("return document.querySelectorAll('.finding:not([hidden])').length");
    let count: f64 = browser.text("return document.querySelector('.tile.fail .count').textContent").parse().unwrap();
    assert!(count >= 2.0, "{count}");
    browser.click(".tile.fail");
    assert_eq!(visible(), count);
    let failed = "return document.querySelectorAll('.finding[data-kind=fail]:not([hidden])[open]').length";
    assert_eq!(browser.number(failed), count);
    let pictures = "return document.querySelectorAll('.finding[data-kind=fail] svg.strip').length";
    assert_eq!(browser.number(pictures), count);
    let bars = "return document.querySelector('.finding svg.delays .delay').getTotalLength()";
    assert!(browser.number(bars) > 0.0);
    browser.is_quiet();
}

#[test]
fn it_fits_a_phone_and_has_the_same_colours() {
    let page = Page::of_test("sim:kuebler-sendix-58x8");
    let browser = Browser::open(&page.path, Screen::Phone);
    let widths = browser.run("return [document.documentElement.scrollWidth, innerWidth]");
    assert_eq!((&widths[0], &widths[1]), (&390.into(), &390.into()));
    let paper = || browser.text("return getComputedStyle(document.body).backgroundColor");
    let light = paper();
    browser.click(".themes label:nth-of-type(3)");
    assert_ne!(paper(), light);
    browser.is_quiet();
}
