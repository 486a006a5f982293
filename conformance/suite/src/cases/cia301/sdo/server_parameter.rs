//! SDO server parameters (1200h and the following).

use crate::bench::Bench;
use crate::bench::sdo::DEVICE_TYPE;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Judged, Reason, Stop, demand, observed_response};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::{self, Request, Response};
use canvass_bus::observation::Observation;

const fn second(sub: u8) -> Multiplexer {
    Multiplexer::new(object::FURTHER_SDO_SERVER_PARAMETER, sub)
}

/// CAN-IDs of a second SDO channel that nothing else uses.
const TO_SERVER: u32 = 0x6A0;
const TO_CLIENT: u32 = 0x6A1;
const INVALID: u32 = 1 << 31;

/// 1200h holds the CAN-IDs of the default SDO channel: 600h + node-ID and 580h + node-ID.
#[case(id = "301/sdo/server/cob-ids", clause = "CiA 301 7.5.2.33", confidence = Cited, level = Must,
       needs = [ServerParameter], catches = [SdoServerIdWrong], cct = "2.12")]
fn cob_ids(bench: &mut Bench<'_>) -> Judged {
    let node = u32::from(bench.node().raw());
    bench.each([(1, sdo::REQUEST_BASE), (2, sdo::RESPONSE_BASE)], |bench, (sub, base)| {
        let (multiplexer, right) = (Multiplexer::new(object::SDO_SERVER_PARAMETER, sub), u32::from(base) + node);
        let duty = format!("{multiplexer} holds the CAN-ID of the default channel");
        bench.expect_value(multiplexer, &right.to_le_bytes(), duty)
    })
}

/// The CAN-IDs of the default SDO channel can't be changed: the device refuses each write.
#[case(id = "301/sdo/server/fixed", clause = "CiA 301 7.5.2.33", confidence = Cited, level = Must,
       needs = [ServerParameter], catches = [SdoReadOnlyWritable])]
fn fixed(bench: &mut Bench<'_>) -> Judged {
    bench.each([1, 2], |bench, sub| {
        let multiplexer = Multiplexer::new(object::SDO_SERVER_PARAMETER, sub);
        let before = bench.read(multiplexer)?;
        let attempt = bench.download(multiplexer, &TO_SERVER.to_le_bytes())?;
        bench.check(attempt.refused(Situation::ValidCobIdChanged))?;
        bench.expect_unchanged(multiplexer, &before)
    })
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

/// Sends a request on each channel without a pause between them, and returns the answers.
fn ask_both(bench: &mut Bench<'_>, first: &Request, other: &Request) -> Result<[Option<Response>; 2], Stop> {
    bench.drain()?;
    bench.send(&other.to_frame(TO_SERVER as u16))?;
    bench.send_request(first)?;
    let ids = [sdo::RESPONSE_BASE + u16::from(bench.node().raw()), TO_CLIENT as u16];
    let mut answers = [None, None];
    // The server answers one request after the other.
    bench.wait_for(bench.timing().sdo_response.times(2), |record| {
        for (id, answer) in ids.iter().zip(&mut answers) {
            if record.frame.cob_id() == Some(*id) && answer.is_none() {
                *answer = Response::read(record.frame.data()).ok();
            }
        }
        answers.iter().all(Option::is_some).then_some(())
    })?;
    Ok(answers)
}

/// A second SDO channel works beside the first, even during a segmented transfer on the first.
#[case(id = "301/sdo/second-server/parallel", clause = "CiA 301 7.2.4.3.5", confidence = Cited, level = Must,
       needs = [SecondServer, SegmentedUpload], catches = [SdoChannelsShareTransfer, RpdoKeepsCanId], cct = "2.28")]
fn parallel(bench: &mut Bench<'_>) -> Judged {
    open(bench)?;
    let Some(name) = bench.long_object(8)? else {
        let reason =
            Reason::new("the device has an object that is read in segments", "more than 7 bytes", "none found");
        return Err(Stop::NotApplicable(reason));
    };
    bench.exchange(&Request::upload(name), format!("upload of {name} on the first channel"))?;
    let [first, second] = ask_both(bench, &Request::UploadSegment { toggle: false }, &Request::upload(DEVICE_TYPE))?;
    let is_right = matches!(second, Some(Response::InitiateUpload { multiplexer, .. }) if multiplexer == DEVICE_TYPE);
    bench.check(demand(is_right, || {
        let found = second.as_ref().map_or(Observation::Silence, observed_response);
        Breach::new(DEVICE_TYPE, "the second SDO channel answers").expected("the device type").found(found)
    }))?;
    bench.check(demand(matches!(first, Some(Response::UploadSegment(_))), || {
        let found = first.as_ref().map_or(Observation::Silence, observed_response);
        let breach = Breach::new(name, "an upload on the first channel continues beside a request on the second");
        breach.expected("an upload segment").found(found)
    }))?;
    close(bench)
}

/// Bits 0 to 29 of the COB-IDs of a valid second SDO channel can't be changed: the device refuses each write.
#[case(id = "301/sdo/second-server/valid", clause = "CiA 301 7.5.2.33", confidence = Cited, level = Must,
       needs = [SecondServer], catches = [SdoChannelIdChangeWhileValid])]
fn valid(bench: &mut Bench<'_>) -> Judged {
    open(bench)?;
    let before = bench.read(second(1))?;
    let attempt = bench.download(second(1), &(TO_SERVER + 2).to_le_bytes())?;
    bench.check(attempt.refused(Situation::ValidCobIdChanged))?;
    bench.expect_unchanged(second(1), &before)?;
    close(bench)
}

/// The device refuses restricted CAN-IDs for a second SDO channel.
#[case(id = "301/sdo/second-server/restricted", clause = "CiA 301 7.3.5", confidence = Cited, level = Must,
       needs = [SecondServer], catches = [RestrictedCanIdAccepted], cct = "8.10")]
fn restricted(bench: &mut Bench<'_>) -> Judged {
    close(bench)?;
    for can_id in [0x001_u32, 0x101, 0x6E0, 0x701] {
        let attempt = bench.download(second(1), &can_id.to_le_bytes())?;
        bench.check(attempt.refused(Situation::RestrictedCanId))?;
    }
    Ok(())
}

/// Reset communication closes a second SDO channel that was not stored.
#[case(id = "301/sdo/second-server/reset", clause = "CiA 301 7.5.2.33", confidence = Cited, level = Must,
       needs = [SecondServer], catches = [NmtResetCommunicationKeepsParameters], cct = "2.29")]
fn reset(bench: &mut Bench<'_>) -> Judged {
    if bench.stores_by_itself()? {
        let reason = Reason::new("the device stores on command only", "bit 1 of 1010h:01 clear", "set");
        return Err(Stop::NotApplicable(reason));
    }
    let before = bench.read(second(1))?;
    open(bench)?;
    bench.reset(Command::RESET_COMMUNICATION)?;
    bench.expect_unchanged(second(1), &before)
}
