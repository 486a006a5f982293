//! SDO server parameters (1200h and the following).

use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::{self, AbortCode, Request, Response};

const fn second(sub: u8) -> Multiplexer {
    Multiplexer::new(0x1201, sub)
}

/// CAN-IDs of a second SDO channel that nothing else uses.
const TO_SERVER: u32 = 0x6A0;
const TO_CLIENT: u32 = 0x6A1;
const INVALID: u32 = 1 << 31;

/// 1200h names the CAN-IDs of the default SDO channel: 600h and 580h + node-ID.
#[case(id = "301/sdo/server/cob-ids", clause = "CiA 301 7.5.2.33", confidence = Derived, level = Must,
       needs = [ServerParameter], catches = [SdoServerIdWrong], cct = "2.12")]
fn cob_ids(bench: &mut Bench<'_>) -> Judged {
    let node = u32::from(bench.node().raw());
    for (sub, base) in [(1, sdo::REQUEST_BASE), (2, sdo::RESPONSE_BASE)] {
        let (multiplexer, right) = (Multiplexer::new(0x1200, sub), u32::from(base) + node);
        let value = bench.read_number(multiplexer)?;
        demand(value == right, || {
            let duty = format!("{multiplexer} names the CAN-ID of the default channel");
            Reason::new(duty, format!("{right:03X}h"), format!("{value:08X}h"))
        })?;
    }
    Ok(())
}

/// The CAN-IDs of the default SDO channel can't be changed: abort 0601 0002h or 0609 0030h.
#[case(id = "301/sdo/server/fixed", clause = "CiA 301 7.5.2.33", confidence = Derived, level = Must,
       needs = [ServerParameter], catches = [SdoReadOnlyWritable])]
fn fixed(bench: &mut Bench<'_>) -> Judged {
    for sub in [1, 2] {
        let multiplexer = Multiplexer::new(0x1200, sub);
        let before = bench.read(multiplexer)?;
        let attempt = bench.download(multiplexer, &TO_SERVER.to_le_bytes())?;
        let strict = [AbortCode::READ_ONLY, AbortCode::INVALID_VALUE, AbortCode::UNSUPPORTED_ACCESS];
        bench.check(attempt.refused_with(&strict, &[AbortCode::GENERAL]))?;
        bench.expect_unchanged(multiplexer, &before)?;
    }
    Ok(())
}

/// Opens the second channel.
fn open(bench: &mut Bench<'_>) -> Result<(), Stop> {
    for (sub, id) in [(1, TO_SERVER), (2, TO_CLIENT)] {
        bench.write(second(sub), &(INVALID | id).to_le_bytes())?;
    }
    for (sub, id) in [(1, TO_SERVER), (2, TO_CLIENT)] {
        bench.write(second(sub), &id.to_le_bytes())?;
    }
    Ok(())
}

fn close(bench: &mut Bench<'_>) -> Result<(), Stop> {
    for (sub, id) in [(1, TO_SERVER), (2, TO_CLIENT)] {
        bench.write(second(sub), &(INVALID | id).to_le_bytes())?;
    }
    Ok(())
}

/// Sends a request on the second channel and waits for its response.
fn ask_second(bench: &mut Bench<'_>, request: &Request) -> Result<Option<Response>, Stop> {
    bench.send(&request.to_frame(TO_SERVER as u16))?;
    bench.wait_for(bench.timing().sdo_response, |record| {
        let is_ours = record.frame.cob_id().is_some_and(|id| u32::from(id) == TO_CLIENT);
        is_ours.then(|| Response::read(record.frame.data()).ok()).flatten()
    })
}

/// A second SDO channel works beside the first, also in the middle of a segmented transfer there.
#[case(id = "301/sdo/second-server/parallel", clause = "CiA 301 7.5.2.33", confidence = Derived, level = Must,
       needs = [SecondServer, SegmentedUpload], catches = [SdoChannelsShareTransfer, RpdoKeepsCanId], cct = "2.28")]
fn parallel(bench: &mut Bench<'_>) -> Judged {
    open(bench)?;
    let Some(name) = bench.long_object(8)? else {
        let reason = Reason::new("an object is read in segments", "more than 7 bytes", "none found");
        return Err(Stop::NotApplicable(reason));
    };
    bench.exchange(&Request::upload(name), format!("upload of {name} on the first channel"))?;
    let device_type = Multiplexer::new(0x1000, 0);
    let answer = ask_second(bench, &Request::upload(device_type))?;
    let is_right = matches!(answer, Some(Response::InitiateUpload { multiplexer, .. }) if multiplexer == device_type);
    demand(is_right, || {
        let actual = answer.map_or_else(|| "no answer".to_owned(), |answer| format!("{answer:?}"));
        Reason::new("the second SDO channel answers", "the device type", actual)
    })?;
    let reply = bench.exchange(&Request::UploadSegment { toggle: false }, "next segment on the first channel")?;
    reply.expect("an upload segment", |response| matches!(response, Response::UploadSegment(_)))?;
    close(bench)?;
    Ok(())
}

/// The CAN-IDs of a second channel that is valid can't be changed: abort 0609 0030h.
#[case(id = "301/sdo/second-server/valid", clause = "CiA 301 7.5.2.33", confidence = Derived, level = Must,
       needs = [SecondServer], catches = [SdoChannelIdChangeWhileValid])]
fn valid(bench: &mut Bench<'_>) -> Judged {
    open(bench)?;
    let before = bench.read(second(1))?;
    let attempt = bench.download(second(1), &(TO_SERVER + 2).to_le_bytes())?;
    bench.check(attempt.refused(Situation::InvalidValue))?;
    bench.expect_unchanged(second(1), &before)?;
    close(bench)?;
    Ok(())
}

/// Restricted CAN-IDs are refused for a second channel with abort 0609 0030h.
#[case(id = "301/sdo/second-server/restricted", clause = "CiA 301 7.3.5", confidence = Attested, level = Must,
       needs = [SecondServer], catches = [RestrictedCanIdAccepted], cct = "8.10")]
fn restricted(bench: &mut Bench<'_>) -> Judged {
    for can_id in [0x001_u32, 0x101, 0x6E0, 0x701] {
        let attempt = bench.download(second(1), &can_id.to_le_bytes())?;
        bench.check(attempt.refused(Situation::InvalidValue))?;
    }
    Ok(())
}

/// Reset communication closes a second channel that was not stored.
#[case(id = "301/sdo/second-server/reset", clause = "CiA 301 7.5.2.33", confidence = Derived, level = Must,
       needs = [SecondServer], catches = [NmtResetCommunicationKeepsParameters], cct = "2.29")]
fn reset(bench: &mut Bench<'_>) -> Judged {
    let before = bench.read(second(1))?;
    open(bench)?;
    bench.reset(Command::RESET_COMMUNICATION)?;
    bench.expect_unchanged(second(1), &before)
}
