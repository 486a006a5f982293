//! Command specifiers, aborts and restarts (CiA 301, 7.2.4.3.17).

use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::{Abort, AbortCode, Payload, Request, Response, Segment};

const DEVICE_TYPE: Multiplexer = Multiplexer::new(0x1000, 0);

/// Command specifier 7, which CiA 301 does not define, with an object behind it as an initiate message has.
const UNKNOWN: Request = Request::Unknown { command: 0xE0, tail: [0x18, 0x10, 1, 0, 0, 0, 0] };

/// An unknown command specifier is answered with abort 0504 0001h.
#[case(id = "301/sdo/command/unknown", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Must,
       catches = [SdoUnknownCommandSilent, SdoCommandWrongCode], cct = "2.7")]
fn unknown(bench: &mut Bench<'_>) -> Judged {
    bench.read(DEVICE_TYPE)?;
    let reply = bench.exchange(&UNKNOWN, "request with the unknown command specifier 7")?;
    bench.check(reply.refused(Situation::UnknownCommand))?;
    bench.upload(DEVICE_TYPE)?.value()?;
    Ok(())
}

/// An unknown command specifier as the first request after boot-up is answered with abort 0504 0001h, and the server
/// works on.
///
/// Servers that keep the object of the last transfer have none yet: some fall silent for good.
#[case(id = "301/sdo/command/unknown-first", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Must,
       catches = [SdoFirstUnknownCommandSilent, SdoUnknownCommandSilent])]
fn unknown_first(bench: &mut Bench<'_>) -> Judged {
    bench.reset(Command::RESET_NODE)?;
    let reply = bench.exchange(&UNKNOWN, "first request after boot-up, with the unknown command specifier 7,")?;
    bench.check(reply.refused(Situation::UnknownCommand))?;
    bench.upload(DEVICE_TYPE)?.value()?;
    Ok(())
}

/// Segments without a transfer, of a download as of an upload, are answered with abort 0504 0001h.
#[case(id = "301/sdo/command/segment-without-transfer", clause = "CiA 301 7.2.4.3.17", confidence = Attested,
       level = Must, catches = [SdoStraySegmentSilent])]
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
    bench.upload(DEVICE_TYPE)?.value()?;
    Ok(())
}

/// An abort of the client is not answered, neither without a transfer nor during one.
#[case(id = "301/sdo/abort/unanswered", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Must,
       catches = [SdoAbortAnswered])]
fn unanswered(bench: &mut Bench<'_>) -> Judged {
    let abort = Request::abort(DEVICE_TYPE, AbortCode::GENERAL);
    bench.send_unanswered(&abort, "abort of the client without a transfer")?.expect_silence()?;
    if let Some(name) = bench.long_object(8)? {
        bench.exchange(&Request::upload(name), format!("upload of {name}"))?;
        let abort = Request::abort(name, AbortCode::GENERAL);
        bench.send_unanswered(&abort, format!("abort of the client in the upload of {name}"))?.expect_silence()?;
    }
    bench.upload(DEVICE_TYPE)?.value()?;
    Ok(())
}

/// The abort that refuses a request names the object of that request, not that of an earlier one.
#[case(id = "301/sdo/abort/multiplexer", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Must,
       catches = [SdoStaleMultiplexer, SdoAbortMultiplexerZero])]
fn multiplexer(bench: &mut Bench<'_>) -> Judged {
    let no_object = Multiplexer::new(0xFFFF, 2);
    let no_sub_index = Multiplexer::new(0x1000, 1);
    // What a server may wrongly remember.
    bench.read(Multiplexer::new(0x1001, 0))?;
    let value = |multiplexer| Request::InitiateDownload { multiplexer, payload: Payload::of(&[0; 4]) };
    let requests = [Request::upload(no_object), Request::upload(no_sub_index), value(no_object), value(DEVICE_TYPE)];
    for request in requests {
        let asked = request.multiplexer().unwrap_or(DEVICE_TYPE);
        let reply = bench.exchange(&request, format!("refused request to {asked}"))?;
        let Some(Response::Abort(Abort { multiplexer, .. })) = reply.response else {
            let reason = Reason::new(format!("the request to {asked} is refused"), "an abort", reply.actual());
            return Err(Stop::Inconclusive(reason));
        };
        demand(multiplexer == asked, || {
            let duty = format!("the abort of the request to {asked} names that object");
            Reason::new(duty, asked.to_string(), multiplexer.to_string())
        })?;
    }
    Ok(())
}

/// A new request ends the transfer under way, and is served.
#[case(id = "301/sdo/transfer/restart", clause = "CiA 301 7.2.4", confidence = Attested, level = Must,
       needs = [SegmentedUpload], catches = [SdoBusyAfterAbandonedTransfer])]
fn restart(bench: &mut Bench<'_>) -> Judged {
    let Some(name) = bench.long_object(8)? else {
        let reason = Reason::new("an object is read in segments", "more than 7 bytes", "none found");
        return Err(Stop::NotApplicable(reason));
    };
    let start = bench.exchange(&Request::upload(name), format!("upload of {name}"))?;
    start
        .expect("the start of a segmented upload", |response| {
            matches!(
                response,
                Response::InitiateUpload { payload: Payload::Segmented(_) | Payload::SegmentedUnsized, .. }
            )
        })
        .or_inconclusive()?;
    let mut attempt = bench.upload(DEVICE_TYPE)?;
    attempt.what = format!("{} in the middle of another transfer", attempt.what);
    attempt.value()?;
    bench.upload(name)?.value()?;
    Ok(())
}

/// Every abort of the server has eight bytes and a code that CiA 301 or CAL (CiA DS-202) defines.
#[case(id = "301/sdo/abort/known-code", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Must,
       catches = [SdoUnknownAbortCode])]
fn known_code(bench: &mut Bench<'_>) -> Judged {
    let segment = Segment::new(false, &[0; 7], true).map(Request::DownloadSegment);
    let value = |multiplexer| Request::InitiateDownload { multiplexer, payload: Payload::of(&[0; 4]) };
    let refused = [
        Some(Request::upload(Multiplexer::new(0xFFFF, 0))),
        Some(Request::upload(Multiplexer::new(0x1000, 1))),
        Some(value(DEVICE_TYPE)),
        Some(value(Multiplexer::new(0x1018, 9))),
        Some(Request::UploadSegment { toggle: false }),
        segment,
        Some(UNKNOWN),
    ];
    for request in refused.into_iter().flatten() {
        let reply = bench.exchange(&request, "request that must be refused")?;
        let (Some(Response::Abort(abort)), Some(frame)) = (reply.response, reply.frame) else { continue };
        let known = abort.code.name().is_some() || abort.code.cal_name().is_some();
        demand(known && frame.len() == 8, || {
            let expected = "eight bytes with a code of CiA 301";
            Reason::new("aborts have a known form and code", expected, reply.actual())
        })?;
    }
    Ok(())
}
