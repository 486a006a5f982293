//! The object dictionary against the device's description.

use crate::bench::Bench;
use crate::case;
use crate::client::Outcome;
use crate::client::sdo::Bytes;
use crate::verdict::{Judged, Reason, Verdict, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::DataType;
use canvass_analyzer::wire::sdo::AbortCode;

/// Every object that the description calls readable can be read, and has the length of its data type.
///
/// An object that has nothing to give at the moment may answer with abort 0800 0020h to 0800 0024h, as an empty error
/// history does.
#[case(id = "301/dictionary/described", clause = "CiA 301 7.4", confidence = Known, level = Must,
       needs = [Description], catches = [ErrorRegisterMissing, IdentityRevisionMissing, SdoSegmentLengthWrong,
                  ErrorControlMissing, OperatingStatusMissing, AlarmsMissing, PositionSixteenBit,
                  OperatingParametersThirtyTwoBit], cct = "4.1")]
fn described(bench: &mut Bench<'_>) -> Judged {
    for (multiplexer, data_type) in readable(bench) {
        let attempt = bench.upload(multiplexer)?;
        match &attempt.outcome {
            Outcome::Uploaded(value) => {
                let length = data_type.bytes();
                demand(length.is_none_or(|length| length == value.len()), || {
                    let expected = format!("{} bytes, as {data_type} has", length.unwrap_or_default());
                    let duty = format!("{multiplexer} has the length of its data type");
                    Reason::new(duty, expected, Bytes(value).to_string())
                })?;
            }
            Outcome::Aborted(abort) if is_momentary(abort.code) => {}
            other => {
                let duty = format!("{multiplexer} can be read, as the description says");
                return Err(Verdict::Fail(Reason::new(duty, "the value", other.to_string())));
            }
        }
    }
    Ok(Verdict::Pass)
}

/// Sub-indexes above the highest that sub-index 0 names do not exist: abort 0609 0011h.
#[case(id = "301/dictionary/highest-sub-index", clause = "CiA 301 7.4.8", confidence = Known, level = Must,
       catches = [SdoWrongCodeForNoSubIndex])]
fn highest_sub_index(bench: &mut Bench<'_>) -> Judged {
    let mut verdict = Verdict::Pass;
    for index in [0x1018, 0x1800, 0x1A00, 0x1400, 0x1600, 0x1029, 0x1016] {
        let Outcome::Uploaded(highest) = bench.upload(Multiplexer::new(index, 0))?.outcome else { continue };
        let Some(beyond) = highest.first().and_then(|highest| highest.checked_add(1)).filter(|&sub| sub < 0xFF) else {
            continue;
        };
        // Mapping objects count the valid entries: those behind them may exist.
        if matches!(index, 0x1600 | 0x1A00) {
            continue;
        }
        let attempt = bench.upload(Multiplexer::new(index, beyond))?;
        verdict = verdict.and(attempt.expect_abort(&[AbortCode::NO_SUB_INDEX], &[AbortCode::GENERAL])?);
    }
    Ok(verdict)
}

fn readable(bench: &Bench<'_>) -> Vec<(Multiplexer, DataType)> {
    let Some(description) = &bench.target().description else { return Vec::new() };
    let entries = description.dictionary.entries();
    let wanted = entries.filter(|(_, entry)| entry.access.is_readable() && !entry.flags.refuses_read_on_scan());
    wanted.map(|(multiplexer, entry)| (multiplexer, entry.data_type)).collect()
}

/// The object exists, but can't give its value now.
const fn is_momentary(code: AbortCode) -> bool {
    matches!(code.0, 0x0800_0020..=0x0800_0024)
}
