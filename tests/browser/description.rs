//! The page of `canvass eds show`.

use canvass_webdriver::{Browser, Screen};
use std::process::Command;

#[test]
fn objects_are_found_as_one_types() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("encoder.html");
    let args = ["eds", "show", "conformance/device/models/reference-406.eds", "--format", "html"];
    let shown = Command::new(env!("CARGO_BIN_EXE_canvass")).args(args).current_dir(env!("CARGO_MANIFEST_DIR")).output();
    std::fs::write(&page, shown.unwrap().stdout).unwrap();
    for screen in [Screen::Desk, Screen::Phone] {
        let browser = Browser::open(&page, screen);
        let visible = "return document.querySelectorAll('table.objects tbody:not([hidden])').length";
        assert_eq!(browser.number(visible), 92.0);
        let search = |text: &str| {
            let script = format!(
                "const filter = document.getElementById('filter'); filter.value = '{text}'; \
                 filter.dispatchEvent(new Event('input')); return document.getElementById('shown').textContent"
            );
            browser.text(&script)
        };
        assert_eq!(search("6004"), "3 of 92", "the object, and the PDOs that carry it");
        assert_eq!(search("position raw"), "2 of 92");
        // A link from a PDO leads to an object that the filter hides.
        browser.run("document.querySelector('.pdo a').click()");
        assert_eq!(search(""), "");
        assert_eq!(browser.number("return document.querySelectorAll('svg.layout').length"), 4.0);
        let fits = "return document.documentElement.scrollWidth - document.documentElement.clientWidth";
        assert!(browser.number(fits) <= 0.0);
        browser.is_quiet();
    }
}
