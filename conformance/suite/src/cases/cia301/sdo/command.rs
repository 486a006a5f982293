//! Command specifiers, aborts and restarts (CiA 301, 7.2.4.3.17).

use super::by_hand::{begin_upload, long_object};
use crate::bench::Bench;
use crate::bench::sdo::{DEVICE_TYPE, Reply};
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Check, Judged, Precondition, demand, tried};
use canvass_analyzer::object;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::{AbortCode, Payload, Request, Response, Segment};
use canvass_analyzer::{Multiplexer, Service};
use canvass_bus::client::Violation;
use canvass_bus::observation::Observation;

/// Command specifier 7, which CiA 301 does not define, followed by an object as in an initiate message.
const UNKNOWN: Request = Request::Unknown { command: 0xE0, tail: [0x18, 0x10, 1, 0, 0, 0, 0] };

/// An unknown command specifier is answered with abort 0504 0001h, which does not name the object of an earlier
/// request.
#[case(id = "301/sdo/command/unknown", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Should,
       catches = [SdoUnknownCommandSilent, SdoCommandWrongCode, SdoStaleMultiplexer], cct = "2.7")]
fn unknown(bench: &mut Bench<'_>) -> Judged {
    bench.read(DEVICE_TYPE)?;
    let reply = bench.exchange(&UNKNOWN, "request with the unknown command specifier 7")?;
    bench.check(reply.refused(Situation::UnknownCommand))?;
    bench.check(names_no_earlier(&reply, DEVICE_TYPE))?;
    bench.expect_served("after an unknown command specifier")?;
    bench.expect_tidy()
}

/// Requires that the abort of an unreadable request names the object in the request, or none, but not the object of an
/// earlier transfer.
fn names_no_earlier(reply: &Reply, earlier: Multiplexer) -> Check {
    let named = match reply.response {
        Some(Response::Abort(abort)) => Some(abort.multiplexer),
        _ => None,
    };
    demand(named != Some(earlier), || {
        Breach::new(Service::Sdo, "an abort does not name the object of an earlier request")
            .expected("the object of the request, or 0000h:00")
            .found(Observation::Violation(Violation::Multiplexer(earlier)))
            .told(reply.actual())
    })
}

/// An unknown command specifier in the first request after boot-up is answered with abort 0504 0001h, and the server
/// still works.
///
/// Some servers keep the object of the last transfer and have none yet; a few of them never answer again.
#[case(id = "301/sdo/command/unknown-first", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Should,
       catches = [SdoFirstUnknownCommandSilent, SdoUnknownCommandSilent])]
fn unknown_first(bench: &mut Bench<'_>) -> Judged {
    bench.reset(Command::RESET_NODE)?;
    let reply = bench.exchange(&UNKNOWN, "first request after boot-up, with the unknown command specifier 7,")?;
    bench.check(reply.refused(Situation::UnknownCommand))?;
    bench.expect_served("after an unknown command specifier as the first request")?;
    bench.expect_tidy()
}

/// Download and upload segments without a transfer are answered with abort 0504 0001h.
#[case(id = "301/sdo/command/segment-without-transfer", clause = "CiA 301 7.2.4.3.17", confidence = Cited,
       level = Should, catches = [SdoStraySegmentSilent, SdoRefusedSegmentServed])]
fn segment_without_transfer(bench: &mut Bench<'_>) -> Judged {
    bench.read(DEVICE_TYPE)?;
    let download = Segment::new(false, &[0; 7], true).map(Request::DownloadSegment);
    let strays = [
        (download, "download segment without a transfer"),
        (Some(Request::UploadSegment { toggle: false }), "request for an upload segment without a transfer"),
    ];
    for (request, what) in strays {
        if let Some(request) = request {
            let answer = bench.exchange(&request, what)?;
            bench.check(answer.refused(Situation::UnknownCommand))?;
        }
    }
    bench.expect_served("after segments without a transfer")?;
    bench.expect_tidy()
}

/// The server does not answer an abort of the client, with or without a transfer in progress: the service is
/// unconfirmed.
#[case(id = "301/sdo/abort/unanswered", clause = "CiA 301 7.2.4.3.1", confidence = Cited, level = Must,
       catches = [SdoAbortAnswered])]
fn unanswered(bench: &mut Bench<'_>) -> Judged {
    let abort = Request::abort(DEVICE_TYPE, AbortCode::GENERAL);
    let reply = bench.send_unanswered(&abort, "abort of the client without a transfer")?;
    bench.check(reply.expect_silence())?;
    if let Some(name) = bench.long_object(8)? {
        bench.exchange(&Request::upload(name), format!("upload of {name}"))?;
        let abort = Request::abort(name, AbortCode::GENERAL);
        let reply = bench.send_unanswered(&abort, format!("abort of the client in the upload of {name}"))?;
        bench.check(reply.expect_silence())?;
    }
    bench.expect_served("after an abort of the client")?;
    bench.expect_tidy()
}

/// The abort that refuses a request names the object of that request, not the object of an earlier one.
#[case(id = "301/sdo/abort/multiplexer", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       catches = [SdoStaleMultiplexer, SdoAbortMultiplexerZero])]
fn multiplexer(bench: &mut Bench<'_>) -> Judged {
    let no_object = Multiplexer::new(0xFFFF, 2);
    let no_sub_index = Multiplexer::new(object::DEVICE_TYPE, 1);
    // A server may wrongly remember this object.
    bench.read(Multiplexer::new(object::ERROR_REGISTER, 0))?;
    let value = |multiplexer| Request::InitiateDownload { multiplexer, payload: Payload::of(&[0; 4]) };
    let requests = [Request::upload(no_object), Request::upload(no_sub_index), value(no_object), value(DEVICE_TYPE)];
    // Every exchange judges the object that the abort names.
    for request in requests {
        let asked = request.multiplexer().unwrap_or(DEVICE_TYPE);
        let reply = bench.exchange(&request, format!("refused request to {asked}"))?;
        reply.expect("an abort", |response| matches!(response, Response::Abort(_))).or_inconclusive()?;
    }
    bench.expect_tidy()
}

/// A new request ends the transfer in progress, and the server answers it. A new upload of the first object begins at
/// its first byte.
#[case(id = "301/sdo/transfer/restart", clause = "CiA 301 7.2.4.3.5", confidence = Cited, level = Must,
       needs = [SegmentedUpload], catches = [SdoBusyAfterAbandonedTransfer])]
fn restart(bench: &mut Bench<'_>) -> Judged {
    let name = long_object(bench)?;
    let right = bench.read(name)?;
    begin_upload(bench, name)?;
    let served = bench.expect_served("in the middle of a segmented upload");
    bench.each([served], |_, served| served)?;
    begin_upload(bench, name)?;
    bench.exchange(&Request::UploadSegment { toggle: false }, "request for the first segment")?;
    bench.expect_again(name, &right, "an upload that starts again returns the whole value")?;
    bench.expect_tidy()
}

/// Every abort of the server has eight bytes and a code that CiA 301 or CAL (CiA DS-202) defines.
#[case(id = "301/sdo/abort/known-code", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       catches = [SdoUnknownAbortCode])]
fn known_code(bench: &mut Bench<'_>) -> Judged {
    let mut aborts = 0;
    let segment = Segment::new(false, &[0; 7], true).map(Request::DownloadSegment);
    let value = |multiplexer| Request::InitiateDownload { multiplexer, payload: Payload::of(&[0; 4]) };
    let refused = [
        Some(Request::upload(Multiplexer::new(0xFFFF, 0))),
        Some(Request::upload(Multiplexer::new(object::DEVICE_TYPE, 1))),
        Some(value(DEVICE_TYPE)),
        Some(value(Multiplexer::new(object::IDENTITY, 9))),
        Some(Request::UploadSegment { toggle: false }),
        segment,
        Some(UNKNOWN),
    ];
    bench.each(refused.into_iter().flatten(), |bench, request| {
        let reply = bench.exchange(&request, "request that must be refused")?;
        let Some(Response::Abort(abort)) = reply.response else { return Ok(()) };
        aborts += 1;
        let is_known = abort.code.name().is_some() || abort.code.cal_name().is_some();
        bench.check(demand(is_known, || {
            let breach = Breach::new(reply.subject, "aborts have a code that the standard defines");
            breach.expected("a code of CiA 301").found(reply.observation()).told(reply.actual())
        }))
    })?;
    bench.expect_tidy()?;
    tried(aborts, "a request that the server aborts")
}
