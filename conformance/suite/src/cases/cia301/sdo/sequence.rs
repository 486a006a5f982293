//! Requests one after the other, at the same time, given up, and never finished (CiA 301, 7.2.4).

use crate::bench::objects::Scratch;
use crate::bench::{Bench, percentile};
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{self, AbortCode, Payload, Request, Response, Segment};
use canvass_traces::{Duration, Timestamp};

const DEVICE_TYPE: Multiplexer = Multiplexer::new(0x1000, 0);
const ERROR_REGISTER: Multiplexer = Multiplexer::new(0x1001, 0);

/// Starts a segmented upload of an object of at least two segments.
fn begin_upload(bench: &mut Bench<'_>) -> Result<Multiplexer, Stop> {
    let Some(name) = bench.long_object(8)? else {
        let reason = Reason::new("an object is read in segments", "more than 7 bytes", "none found");
        return Err(Stop::NotApplicable(reason));
    };
    let reply = bench.exchange(&Request::upload(name), format!("upload of {name}"))?;
    let is_start = |response: &Response| {
        matches!(response, Response::InitiateUpload { payload: Payload::Segmented(_) | Payload::SegmentedUnsized, .. })
    };
    reply.expect("the start of a segmented upload", is_start).or_inconclusive()?;
    Ok(name)
}

/// Starts a segmented download to a scratch object.
fn begin_download(bench: &mut Bench<'_>) -> Result<Scratch, Stop> {
    let scratch = bench.scratch(&[4, 2])?;
    bench.write(scratch.multiplexer, &scratch.value)?;
    let payload = Payload::Segmented(u32::try_from(scratch.value.len()).unwrap_or(u32::MAX));
    let multiplexer = scratch.multiplexer;
    let request = Request::InitiateDownload { multiplexer, payload };
    let reply = bench.exchange(&request, format!("segmented download to {multiplexer}"))?;
    reply
        .expect("confirmation", |response| *response == Response::InitiateDownload { multiplexer })
        .or_inconclusive()?;
    Ok(scratch)
}

fn first_segment(bench: &mut Bench<'_>, scratch: &Scratch) -> Result<(), Stop> {
    let part = scratch.other.get(..1).unwrap_or_default();
    if let Some(segment) = Segment::new(false, part, false) {
        let reply = bench.exchange(&Request::DownloadSegment(segment), "first download segment")?;
        let is_right = |response: &Response| *response == Response::DownloadSegment { toggle: false };
        reply.expect("its confirmation", is_right).or_inconclusive()?;
    }
    Ok(())
}

/// A download that is given up for another request ends; the request is served, and the object keeps its value.
#[case(id = "301/sdo/transfer/abandoned-download", clause = "CiA 301 7.2.4", confidence = Attested, level = Must,
       needs = [ScratchObject], catches = [SdoBusyAfterAbandonedDownload, SdoSegmentsWrittenAtOnce])]
fn abandoned_download(bench: &mut Bench<'_>) -> Judged {
    let scratch = begin_download(bench)?;
    first_segment(bench, &scratch)?;
    let mut attempt = bench.upload(DEVICE_TYPE)?;
    attempt.what = format!("{} in the middle of a download", attempt.what);
    attempt.value()?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)
}

/// Two requests without a pause between them: each answer belongs to one of them and names its object with its value.
///
/// A server may have room for one request only; the first or the second may then go unanswered.
#[case(id = "301/sdo/transfer/back-to-back", clause = "CiA 301 7.2.4", confidence = Attested, level = Must,
       catches = [SdoBackToBackMixed])]
fn back_to_back(bench: &mut Bench<'_>) -> Judged {
    let right = [(DEVICE_TYPE, bench.read(DEVICE_TYPE)?), (ERROR_REGISTER, bench.read(ERROR_REGISTER)?)];
    bench.drain()?;
    for (multiplexer, _) in &right {
        bench.send_request(&Request::upload(*multiplexer))?;
    }
    let response_id = sdo::RESPONSE_BASE + u16::from(bench.node().raw());
    let heard = bench.listen(bench.timing().silence)?;
    let answers: Vec<_> = heard.into_iter().filter(|record| record.frame.cob_id() == Some(response_id)).collect();
    demand(!answers.is_empty(), || {
        Reason::new("of two requests back to back at least one is answered", "one or two answers", "none")
    })?;
    for answer in answers {
        let response = Response::read(answer.data()).ok();
        let is_right = match response {
            Some(Response::InitiateUpload { multiplexer, payload }) => {
                right.iter().any(|(asked, value)| *asked == multiplexer && payload.value() == Some(value))
            }
            Some(Response::Abort(abort)) => right.iter().any(|(asked, _)| *asked == abort.multiplexer),
            _ => false,
        };
        demand(is_right, || {
            let duty = "each answer to two requests back to back is that of one of them";
            Reason::new(duty, "the object with its own value", answer.frame.to_string())
        })?;
    }
    bench.upload(DEVICE_TYPE)?.value()?;
    Ok(())
}

/// An abort of the client ends the transfer: a further segment is refused with abort 0504 0001h.
#[case(id = "301/sdo/abort/ends-transfer", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Must,
       needs = [SegmentedUpload], catches = [SdoAbortIgnored, SdoCommandWrongCode])]
fn ends_transfer(bench: &mut Bench<'_>) -> Judged {
    let name = begin_upload(bench)?;
    bench.send_request(&Request::abort(name, AbortCode::GENERAL))?;
    let what = "request for a segment after the client's abort";
    let reply = bench.exchange(&Request::UploadSegment { toggle: false }, what)?;
    bench.check(reply.refused(Situation::UnknownCommand))
}

/// A command that has no place in an upload under way is refused with abort 0504 0001h.
#[case(id = "301/sdo/command/wrong-in-upload", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Should,
       needs = [SegmentedUpload], catches = [SdoWrongCommandIgnored, SdoCommandWrongCode])]
fn wrong_in_upload(bench: &mut Bench<'_>) -> Judged {
    begin_upload(bench)?;
    let Some(segment) = Segment::new(false, &[0; 7], false) else { return Ok(()) };
    let reply = bench.exchange(&Request::DownloadSegment(segment), "download segment in the middle of an upload")?;
    bench.check(reply.refused(Situation::UnknownCommand))?;
    bench.upload(DEVICE_TYPE)?.value()?;
    Ok(())
}

/// A command that has no place in a download under way is refused with abort 0504 0001h, and the object keeps its value.
#[case(id = "301/sdo/command/wrong-in-download", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Should,
       needs = [ScratchObject], catches = [SdoWrongCommandIgnored, SdoCommandWrongCode])]
fn wrong_in_download(bench: &mut Bench<'_>) -> Judged {
    let scratch = begin_download(bench)?;
    let what = "request for an upload segment in the middle of a download";
    let reply = bench.exchange(&Request::UploadSegment { toggle: false }, what)?;
    bench.check(reply.refused(Situation::UnknownCommand))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)?;
    Ok(())
}

/// Commands of a block upload without one are refused with abort 0504 0001h.
#[case(id = "301/sdo/command/stray-block-upload", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Must,
       catches = [SdoStrayBlockSilent, SdoCommandWrongCode])]
fn stray_block_upload(bench: &mut Bench<'_>) -> Judged {
    let strays = [
        (Request::StartBlockUpload, "start of a block upload without one"),
        (
            Request::ConfirmBlockUpload { sequence: 1, block_size: 127 },
            "confirmation of a block without a block upload",
        ),
        (Request::EndBlockUpload, "end of a block upload without one"),
    ];
    for (request, what) in strays {
        let answer = bench.exchange(&request, what)?;
        bench.check(answer.refused(Situation::UnknownCommand))?;
    }
    bench.upload(DEVICE_TYPE)?.value()?;
    Ok(())
}

/// The end of a block download without one is refused with abort 0504 0001h.
#[case(id = "301/sdo/command/stray-block-download", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Must,
       catches = [SdoStrayBlockSilent, SdoCommandWrongCode])]
fn stray_block_download(bench: &mut Bench<'_>) -> Judged {
    let request = Request::EndBlockDownload { unused: 0, crc: 0 };
    let reply = bench.exchange(&request, "end of a block download without one")?;
    bench.check(reply.refused(Situation::UnknownCommand))?;
    bench.upload(DEVICE_TYPE)?.value()?;
    Ok(())
}

/// So long a client may think; a server that supervises its transfers ends them by then.
const SILENCE: Duration = Duration::from_millis(3_000);

/// After a client that does not go on with a segmented transfer the next request is served. A server that ends the
/// transfer by itself says so with abort 0504 0000h.
#[case(id = "301/sdo/transfer/silent-client", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Must,
       needs = [SegmentedUpload], catches = [SdoTimeoutWedges])]
fn silent_client(bench: &mut Bench<'_>) -> Judged {
    let name = begin_upload(bench)?;
    let response_id = sdo::RESPONSE_BASE + u16::from(bench.node().raw());
    let said = bench.wait_for(SILENCE, |record| {
        let is_ours = record.frame.cob_id() == Some(response_id);
        is_ours.then(|| (record.timestamp, Response::read(record.frame.data()).ok()))
    })?;
    if let Some((_, response)) = said {
        let is_timeout = matches!(response, Some(Response::Abort(abort)) if abort.code == AbortCode::TIMEOUT);
        demand(is_timeout, || {
            let duty = format!("the server ends the unfinished upload of {name} with the reason");
            Reason::new(duty, format!("abort {}", AbortCode::TIMEOUT), format!("{response:?}"))
        })?;
    } else {
        bench.note(format!("the server does not end an unfinished transfer within {SILENCE}"));
    }
    let mut attempt = bench.upload(DEVICE_TYPE)?;
    attempt.what = format!("{} after an unfinished transfer", attempt.what);
    attempt.value()?;
    Ok(())
}

/// How many requests are timed.
const REQUESTS: usize = 600;

/// Of many requests in a row every one is answered in time. Median, 95th percentile and maximum are reported.
#[case(id = "301/sdo/timing/responses", clause = "CiA 301 7.2.4.2", confidence = Known, level = Must,
       catches = [SdoResponseLost, SdoMemoryLeak, SdoResponseSlow])]
fn responses(bench: &mut Bench<'_>) -> Judged {
    let response_id = sdo::RESPONSE_BASE + u16::from(bench.node().raw());
    let mut times = Vec::with_capacity(REQUESTS);
    for n in 1..=REQUESTS {
        bench.drain()?;
        let sent = bench.now();
        bench.send_request(&Request::upload(DEVICE_TYPE))?;
        let limit = bench.timing().sdo_response;
        let answered: Option<Timestamp> =
            bench.wait_for(limit, |record| (record.frame.cob_id() == Some(response_id)).then_some(record.timestamp))?;
        let Some(at) = answered else {
            let actual = format!("none to request {n} of {REQUESTS}");
            let duty = "every request is answered in time";
            return Err(Stop::from(Reason::new(duty, format!("a response within {limit}"), actual)));
        };
        times.push(at.since(sent));
    }
    for (name, percent) in [("median", 50), ("95 %", 95), ("maximum", 100)] {
        if let Some(time) = percentile(&mut times, percent) {
            bench.measure(format!("SDO response, {name}"), time);
        }
    }
    Ok(())
}
