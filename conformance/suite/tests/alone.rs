//! A case alone and the same case in a whole run give the same verdict.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

use canvass_suite::catalogue;
use canvass_suite::selftest::alone::{AloneRow, Difference, Sample, run};

#[test]
fn verdicts_do_not_depend_on_earlier_cases() {
    let count = std::env::var("CANVASS_ALONE_COUNT").ok().and_then(|count| count.parse().ok()).unwrap_or(3);
    let rows = run(&catalogue::select(&[]).unwrap(), Sample { seed: 1, count: Some(count) }).unwrap();
    let wrong: Vec<String> =
        rows.iter().flat_map(|row| row.unexplained.iter().map(|difference| tell(row, difference))).collect();
    assert!(wrong.is_empty(), "{} differences:\n{}", wrong.len(), wrong.join("\n"));
}

fn tell(row: &AloneRow, difference: &Difference) -> String {
    let Difference { case, alone, together, order, reasons: [of_alone, of_whole] } = difference;
    format!("{}: {}: alone {alone} ({of_alone}), {order:?} {together:?} ({of_whole})", row.subject, case.id)
}
