//! Sequences of requests: successive, simultaneous, aborted and unfinished ones (CiA 301, 7.2.4).

use super::by_hand::{begin_download, begin_upload, confirmed_segment, long_object};
use crate::bench::sdo::DEVICE_TYPE;
use crate::bench::{Bench, percentile};
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Judged, demand, observed_response};
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{self, AbortCode, Request, Response, Segment};
use canvass_analyzer::{Multiplexer, Service};
use canvass_bus::observation::Observation;
use canvass_traces::{Duration, Record, Timestamp};

const ERROR_REGISTER: Multiplexer = Multiplexer::new(object::ERROR_REGISTER, 0);

/// A new download ends a download in progress: the server answers its request, and the object of the first download
/// keeps its value.
#[case(id = "301/sdo/transfer/abandoned-download", clause = "CiA 301 7.2.4.3.2", confidence = Cited, level = Must,
       needs = [ScratchObject, SegmentedDownload],
       catches = [SdoOpenDownloadSurvivesReset, SdoBusyAfterAbandonedDownload, SdoSegmentsWrittenAtOnce])]
fn abandoned_download(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2])?;
    begin_download(bench, &scratch)?;
    confirmed_segment(bench, false, scratch.other.get(..1).unwrap_or_default(), false)?;
    let again = bench.download(scratch.multiplexer, &scratch.value)?;
    bench.check(again.under("in the middle of a segmented download").expect_confirmation())?;
    begin_download(bench, &scratch)?;
    confirmed_segment(bench, false, scratch.other.get(..1).unwrap_or_default(), false)?;
    let elsewhere = bench.download(DEVICE_TYPE, &[0; 4])?;
    bench.check(elsewhere.under("in the middle of a second segmented download").refused(Situation::ReadOnly))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)?;
    bench.expect_tidy()
}

/// The server answers an upload during a segmented download. The standard leaves the behaviour open: it names only a
/// new download and an abort as the early end of a download.
#[case(id = "301/sdo/transfer/upload-in-download", clause = "CiA 301 7.2.4.3.2", confidence = Cited, level = Open,
       needs = [ScratchObject, SegmentedDownload], catches = [SdoBusyAfterAbandonedDownload])]
fn upload_in_download(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2])?;
    begin_download(bench, &scratch)?;
    confirmed_segment(bench, false, scratch.other.get(..1).unwrap_or_default(), false)?;
    bench.expect_served("in the middle of a segmented download")
}

/// After two requests without a pause, each response belongs to one of them and carries its object and its value.
///
/// A server may have room for one request only, and may then leave the first or the second one unanswered.
#[case(id = "301/sdo/transfer/back-to-back", clause = "CiA 301 7.2.4.3.6", confidence = Cited, level = Should,
       catches = [SdoBackToBackMixed])]
fn back_to_back(bench: &mut Bench<'_>) -> Judged {
    let right = [(DEVICE_TYPE, bench.read(DEVICE_TYPE)?), (ERROR_REGISTER, bench.read(ERROR_REGISTER)?)];
    bench.drain()?;
    for (multiplexer, _) in &right {
        bench.send_request(&Request::upload(*multiplexer))?;
    }
    // The server answers one request after the other.
    let heard = bench.listen(bench.timing().sdo_response.times(2))?;
    let response_id = response_id(bench);
    let answers: Vec<Record> = heard.into_iter().filter(|record| record.frame.cob_id() == Some(response_id)).collect();
    demand(!answers.is_empty(), || {
        Breach::new(Service::Sdo, "at least one of two back-to-back requests is answered")
            .expected("one or two answers")
    })?;
    for answer in answers {
        let response = Response::read(answer.data()).ok();
        let is_right = match response {
            Some(Response::InitiateUpload { multiplexer, payload }) => right.iter().any(|(asked, value)| {
                *asked == multiplexer && payload.value().is_some_and(|given| given.starts_with(value))
            }),
            Some(Response::Abort(abort)) => right.iter().any(|(asked, _)| *asked == abort.multiplexer),
            _ => false,
        };
        bench.check(demand(is_right, || {
            Breach::new(
                Service::Sdo,
                "each answer to two back-to-back requests names the object of one of them and has its value",
            )
            .expected("the object with its own value")
            .found(Observation::named("an answer that belongs to neither of two requests"))
            .told(answer.frame.to_string())
        }))?;
    }
    bench.expect_served("after two back-to-back requests")
}

/// The CAN-ID of the server's responses.
fn response_id(bench: &Bench<'_>) -> u16 {
    sdo::RESPONSE_BASE + u16::from(bench.node().raw())
}

/// An abort of the client ends the transfer: a further segment is refused with abort 0504 0001h.
#[case(id = "301/sdo/abort/ends-transfer", clause = "CiA 301 7.2.4.3.5", confidence = Cited, level = Must,
       needs = [SegmentedUpload], catches = [SdoAbortIgnored, SdoCommandWrongCode])]
fn ends_transfer(bench: &mut Bench<'_>) -> Judged {
    let name = long_object(bench)?;
    begin_upload(bench, name)?;
    bench.send_request(&Request::abort(name, AbortCode::GENERAL))?;
    let what = "request for a segment after the client's abort";
    let reply = bench.exchange(&Request::UploadSegment { toggle: false }, what)?;
    bench.check(reply.refused(Situation::UnknownCommand))?;
    bench.expect_served("after the client's abort")?;
    bench.expect_tidy()
}

/// A command that is not allowed during an upload is refused with abort 0504 0001h, and the object keeps its value.
#[case(id = "301/sdo/command/wrong-in-upload", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Should,
       needs = [SegmentedUpload], catches = [SdoWrongCommandIgnored, SdoCommandWrongCode, SdoSegmentWrittenInUpload,
                                         SdoRefusedSegmentServed])]
fn wrong_in_upload(bench: &mut Bench<'_>) -> Judged {
    let name = long_object(bench)?;
    let before = bench.read(name)?;
    begin_upload(bench, name)?;
    let Some(segment) = Segment::new(false, &[0; 7], false) else { return Ok(()) };
    let reply = bench.exchange(&Request::DownloadSegment(segment), "download segment in the middle of an upload")?;
    bench.check(reply.refused(Situation::UnknownCommand))?;
    bench.expect_unchanged(name, &before)?;
    bench.expect_served("after a command that is not allowed in the transfer")?;
    bench.expect_tidy()
}

/// A command that is not allowed during a download is refused with abort 0504 0001h, and the object keeps its value.
#[case(id = "301/sdo/command/wrong-in-download", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Should,
       needs = [ScratchObject, SegmentedDownload], catches = [SdoWrongCommandIgnored, SdoCommandWrongCode])]
fn wrong_in_download(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2])?;
    begin_download(bench, &scratch)?;
    let what = "request for an upload segment in the middle of a download";
    let reply = bench.exchange(&Request::UploadSegment { toggle: false }, what)?;
    bench.check(reply.refused(Situation::UnknownCommand))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)
}

/// Commands of a block upload are refused with abort 0504 0001h when no block upload is in progress.
#[case(id = "301/sdo/command/stray-block-upload", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Should,
       catches = [SdoStrayBlockSilent, SdoCommandWrongCode])]
fn stray_block_upload(bench: &mut Bench<'_>) -> Judged {
    let strays = [
        (Request::StartBlockUpload, "start of the segments of a block upload without a block upload"),
        (
            Request::ConfirmBlockUpload { sequence: 1, block_size: 127 },
            "confirmation of a block without a block upload",
        ),
        (Request::EndBlockUpload, "end of a block upload without a block upload"),
    ];
    for (request, what) in strays {
        let answer = bench.exchange(&request, what)?;
        bench.check(answer.refused(Situation::UnknownCommand))?;
    }
    bench.expect_served("after block commands without a block transfer")?;
    bench.expect_tidy()
}

/// The end of a block download is refused with abort 0504 0001h when no block download is in progress.
#[case(id = "301/sdo/command/stray-block-download", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Should,
       catches = [SdoStrayBlockSilent, SdoCommandWrongCode])]
fn stray_block_download(bench: &mut Bench<'_>) -> Judged {
    let request = Request::EndBlockDownload { unused: 0, crc: 0 };
    let reply = bench.exchange(&request, "end of a block download without a block download")?;
    bench.check(reply.refused(Situation::UnknownCommand))?;
    bench.expect_served("after block commands without a block transfer")?;
    bench.expect_tidy()
}

/// Time for which the client stays silent; a server that supervises its transfers ends them in this time.
const SILENCE: Duration = Duration::from_millis(3_000);

/// The server answers the next request after a client has stopped in the middle of a segmented transfer. A server that
/// ends the transfer by itself reports it by abort 0504 0000h.
#[case(id = "301/sdo/transfer/silent-client", clause = "CiA 301 7.2.4.3.5", confidence = Cited, level = Must,
       needs = [SegmentedUpload], catches = [SdoTimeoutWedges])]
fn silent_client(bench: &mut Bench<'_>) -> Judged {
    let name = long_object(bench)?;
    begin_upload(bench, name)?;
    let response_id = response_id(bench);
    let said =
        bench.wait_for(SILENCE, |record| (record.frame.cob_id() == Some(response_id)).then_some(record.frame))?;
    if let Some(frame) = said {
        let response = Response::read(frame.data()).ok();
        let is_timeout = matches!(response, Some(Response::Abort(abort)) if abort.code == AbortCode::TIMEOUT);
        bench.check(demand(is_timeout, || {
            let found = response.as_ref().map_or(Observation::Frame(frame), observed_response);
            Breach::new(name, "a server that ends an unfinished upload by itself gives the reason")
                .expected(Observation::Abort(AbortCode::TIMEOUT))
                .found(found)
                .told(frame.to_string())
        }))?;
    } else {
        bench.note(format!("the server does not end an unfinished transfer within {SILENCE}"));
    }
    bench.expect_served("after an unfinished transfer")?;
    bench.expect_tidy()
}

/// Number of requests whose response time is measured.
const REQUESTS: usize = 600;

/// The server answers each of many consecutive requests in time. The case reports median, 95th percentile and maximum
/// of the response time.
#[case(id = "301/sdo/timing/responses", clause = "CiA 301 7.2.4.3.1", confidence = Cited, level = Must,
       catches = [SdoResponseLost, SdoMemoryLeak, SdoResponseSlow])]
fn responses(bench: &mut Bench<'_>) -> Judged {
    let response_id = response_id(bench);
    let mut times = Vec::with_capacity(REQUESTS);
    for n in 1..=REQUESTS {
        bench.drain()?;
        let sent = bench.now();
        bench.send_request(&Request::upload(DEVICE_TYPE))?;
        let limit = bench.timing().sdo_response;
        let answered: Option<Timestamp> =
            bench.wait_for(limit, |record| (record.frame.cob_id() == Some(response_id)).then_some(record.timestamp))?;
        let Some(at) = answered else {
            let breach = Breach::new(DEVICE_TYPE, "every request is answered in time");
            let breach = breach.expected(format!("a response within {limit}")).found(Observation::Silence);
            return Err(Box::new(breach.told(format!("none to request {n} of {REQUESTS}"))).into());
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
