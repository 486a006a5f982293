//! Reports for paper: `--report pdf=FILE` and `--report pdf-summary=FILE`.

use crate::running::run;
use std::fs;

/// A device with several defects.
const BUS: &str = "sim:reference-301+sdo-toggle-unchecked+vendor-id-zero+boot-up-twice+sdo-read-only-wrong-code\
    +sdo-length-unchecked";

/// The number of pages of a PDF, from its page tree.
fn pages(pdf: &[u8]) -> usize {
    let text = String::from_utf8_lossy(pdf);
    let count = text.split("/Count ").nth(1).unwrap();
    count.split(|c: char| !c.is_ascii_digit()).next().unwrap().parse().unwrap()
}

#[test]
fn a_run_is_printed_on_a_few_pages_and_an_appendix() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let printed = |number: u32| {
        let (whole, short) = (path(&format!("{number}.pdf")), path(&format!("{number}-short.pdf")));
        let reports = [format!("pdf={whole}"), format!("pdf-summary={short}")];
        let date = "2026-11-28T12:00:00+01:00";
        let args =
            ["test", BUS, "--date", date, "--note", "tester=Ann", "--report", &reports[0], "--report", &reports[1]];
        assert_eq!(run(&args).status, 1);
        (fs::read(whole).unwrap(), fs::read(short).unwrap())
    };
    let (whole, short) = printed(1);
    assert!(whole.starts_with(b"%PDF-") && short.starts_with(b"%PDF-"));
    assert!(pages(&short) <= 6 && pages(&whole) > pages(&short), "{} and {}", pages(&short), pages(&whole));
    // PDF/A-2b, as its own description says, and the same bytes again.
    let text = String::from_utf8_lossy(&whole).into_owned();
    assert!(text.contains("<pdfaid:part>2</pdfaid:part>") && text.contains("2026-11-28T11:00:00"), "no PDF/A");
    assert_eq!(printed(2), (whole, short));
}

/// A comparison and a history are printed too.
#[test]
fn other_results_are_printed() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (result, pdf) = (path("result.json"), path("compared.pdf"));
    run(&["test", BUS, "--select", "301/nmt", "--report", &format!("json={result}")]);
    for command in [&["compare", &result, &result][..], &["history", &result]] {
        let compared = run(&[command, &["--report", &format!("pdf={pdf}")]].concat());
        assert_eq!(compared.status, 0, "{}", compared.stderr);
        assert!(pages(&fs::read(&pdf).unwrap()) >= 1);
    }
}
