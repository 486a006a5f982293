//! A device that does nothing right passes only the cases in the reviewed list.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

use canvass_suite::catalogue;
use canvass_suite::selftest::null::{self, NullDevice, NullRow};

#[test]
fn every_pass_on_a_null_device_is_reviewed() {
    let rows = null::run(&catalogue::select(&[]).unwrap()).unwrap();
    let wrong: Vec<String> = rows.iter().flat_map(wrong_with).collect();
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
    let right = rows.iter().find(|row| row.device == NullDevice::MandatoryOnly).unwrap();
    assert!(right.reviewed.len() > 30, "{} cases pass on a right device", right.reviewed.len());
}

fn wrong_with(row: &NullRow) -> Vec<String> {
    let unexplained = row.unexplained.iter().map(|(case, kind)| format!("{kind}: {}", case.id));
    let stale = row.stale.iter().map(|id| format!("listed, does not pass: {id}"));
    let alarms = row.alarms.iter().map(|(case, kind, reason)| format!("{kind}: {}: {reason}", case.id));
    unexplained.chain(stale).chain(alarms).map(|what| format!("{}: {what}", row.device.id())).collect()
}
