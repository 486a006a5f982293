//! Captures, descriptions and names with markup stay text.

use crate::opened::Opened;
use canvass_webdriver::Screen;

const MARKUP: &str = "<img src=x onerror=alert(1)>";

#[test]
fn names_and_contents_stay_text() {
    let opened = Opened::empty(Screen::Desk);
    let channel = "<script>fetch('http://127.0.0.1:9')</script>";
    let log = format!(
        "(1700000000.000000) {channel} 705#00\n(1700000001.000000) {channel} 605#40{MARKUP}\n\
                       (1700000002.000000) {channel} 085#1111111111111111\n"
    );
    let eds = format!(
        "[FileInfo]\nFileName={MARKUP}\n[DeviceInfo]\nVendorName={MARKUP}\nProductName={MARKUP}\n\
                       [MandatoryObjects]\nSupportedObjects=1\n1=0x1000\n[1000]\nParameterName={MARKUP}\nDataType=7\nAccessType=ro\n"
    );
    let files = [opened.file(&format!("{}.log", MARKUP.replace('/', "")), log), opened.file("<b>.eds", eds)];
    opened.take(&files);
    opened.browser.wait("document.querySelector('#view-diagnosis iframe')");
    for view in ["diagnosis", "trace", "signals", "eds", "results", "try", "export"] {
        opened.view(view);
        opened.browser.wait(&format!("!document.getElementById('view-{view}').hidden"));
        let injected = opened
            .browser
            .number("return document.querySelectorAll('img, b, body script:not([id]):not(:last-child)').length");
        assert_eq!(injected, 0.0, "{view}");
    }
    opened.view("trace");
    assert!(opened.rows()[0].contains("<script>"), "as text");
    opened.browser.is_quiet();
}
