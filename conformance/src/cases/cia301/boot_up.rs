//! Boot-up: how a device says that its initialisation is over (CiA 301, 7.2.8.2.3.1).

use crate::bench::Bench;
use crate::bench::nmt::Start;
use crate::case;
use crate::client::sdo::Bytes;
use crate::verdict::{Judged, Reason, demand};
use canvass_analyzer::wire::nmt::Command;
use canvass_traces::{Duration, Record};

/// So long after the first boot-up message a second one still belongs to the same start.
const SECOND_BOOT_UP: Duration = Duration::from_millis(1_000);

/// After reset node the device sends exactly one boot-up message: one byte, 00h, on 700h + node-ID.
#[case(id = "301/boot-up/reset-node", clause = "CiA 301 7.2.8.2.3.1", confidence = Attested, level = Must,
       catches = [BootUpMissing, BootUpTwice, BootUpWrongData], cct = "9.1")]
fn reset_node(bench: &mut Bench<'_>) -> Judged {
    exactly_one_boot_up(bench, Command::RESET_NODE)
}

/// After reset communication the device sends exactly one boot-up message: one byte, 00h, on 700h + node-ID.
#[case(id = "301/boot-up/reset-communication", clause = "CiA 301 7.2.8.2.3.1", confidence = Attested, level = Must,
       catches = [BootUpMissing, BootUpTwice, BootUpWrongData], cct = "10.1")]
fn reset_communication(bench: &mut Bench<'_>) -> Judged {
    exactly_one_boot_up(bench, Command::RESET_COMMUNICATION)
}

fn exactly_one_boot_up(bench: &mut Bench<'_>, command: Command) -> Judged {
    let start = bench.record_start(command, SECOND_BOOT_UP)?;
    let duty = || format!("{command} ends in exactly one boot-up message");
    demand(start.boot_ups.len() == 1, || Reason::new(duty(), "one frame with the data 00", seen(bench, &start)))?;
    demand(start.boot_ups.iter().all(|record| bench.is_boot_up(&record.frame)), || {
        Reason::new(duty(), "one byte", seen(bench, &start))
    })
}

/// From a reset command to its boot-up message the device is silent: initialisation knows no communication.
#[case(id = "301/boot-up/silent-before", clause = "CiA 301 7.3.2.2", confidence = Attested, level = Must,
       catches = [BootUpWrongData])]
fn silent_before(bench: &mut Bench<'_>) -> Judged {
    let start = bench.record_start(Command::RESET_NODE, Duration::ZERO)?;
    demand(start.before.is_empty(), || {
        let duty = "the device sends nothing between reset node and its boot-up message";
        Reason::new(duty, "silence", frames(&start.before))
    })
}

fn seen(bench: &Bench<'_>, start: &Start) -> String {
    let strange: Vec<Record> = start.before.iter().filter(|r| bench.is_error_control(&r.frame)).cloned().collect();
    match (start.boot_ups.as_slice(), strange.as_slice()) {
        ([], []) => format!("none within {}", bench.timing().boot_up),
        ([], strange) => format!("none, but {}", frames(strange)),
        (boot_ups, _) => frames(boot_ups),
    }
}

fn frames(records: &[Record]) -> String {
    const SHOWN: usize = 3;
    let shown: Vec<String> =
        records.iter().take(SHOWN).map(|r| format!("{} with {}", r.frame.id(), Bytes(r.data()))).collect();
    let more = records.len().saturating_sub(SHOWN);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{more}", shown.join(", "))
}
