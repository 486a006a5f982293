//! Segments whose toggle bit is wrong (CiA 301, 7.2.4.3.2 and 7.2.4.3.5).
//!
//! The server ignores the content of a segment that repeats its toggle bit, and may abort the transfer. So the cases
//! find out which of the two the server does, and judge the consequence: an aborted transfer is over and has changed
//! nothing, another transfer continues as if the segment had not come.

use super::by_hand::{begin_download, begin_upload, confirmed_segment, finish_upload, long_object, segment};
use crate::bench::Bench;
use crate::bench::objects::Scratch;
use crate::bench::sdo::Reply;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Judged, Precondition, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{Abort, AbortCode, Request, Response};
use canvass_bus::client::Violation;
use canvass_bus::observation::Observation;

/// Requires that the server, after it has ignored a segment, accepts the rest of the download with the right toggle
/// bit.
fn goes_on(bench: &mut Bench<'_>, scratch: &Scratch, toggle: bool, rest: &[u8]) -> Judged {
    let reply = bench.exchange(&segment(toggle, rest, true)?, "segment with the right toggle bit after a wrong one")?;
    reply.expect("its confirmation", |response| *response == Response::DownloadSegment { toggle })?;
    let duty = "a download continues after a segment that is ignored";
    bench.expect_value(scratch.multiplexer, &scratch.other, duty)
}

/// The first download segment has toggle bit 0. The server ignores a first segment with toggle bit 1, or refuses it
/// with abort 0503 0000h; the object keeps its value, and if the server did not abort, the transfer can continue.
#[case(id = "301/sdo/download/segment-toggle", clause = "CiA 301 7.2.4.3.4", confidence = Cited, level = Must,
       needs = [ScratchObject, SegmentedDownload], catches = [SdoToggleUnchecked, SdoToggleWrongCode])]
fn segment_toggle(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[2, 4, 1])?;
    begin_download(bench, &scratch)?;
    let reply = bench.exchange(&segment(true, &scratch.other, true)?, "first download segment with toggle 1")?;
    bench.check(reply.refused(Situation::RepeatedToggle))?;
    if reply.response.is_none() {
        return goes_on(bench, &scratch, false, &scratch.other);
    }
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)?;
    bench.expect_tidy()
}

/// The server ignores the content of a download segment that repeats the toggle bit of the previous segment, and the
/// transfer can continue. It may instead refuse the segment with abort 0503 0000h; the object then keeps its value.
#[case(id = "301/sdo/download/second-toggle", clause = "CiA 301 7.2.4.3.2", confidence = Cited, level = Must,
       needs = [ScratchObject, SegmentedDownload], catches = [SdoToggleUnchecked, SdoToggleWrongCode])]
fn second_toggle(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2])?;
    begin_download(bench, &scratch)?;
    let (first, rest) = scratch.other.split_at(1);
    confirmed_segment(bench, false, first, false)?;
    let reply = bench.exchange(&segment(false, rest, true)?, "second download segment with toggle 0 again")?;
    // The content is ignored; the server may confirm the previous segment once more.
    let is_confirmed = reply.response == Some(Response::DownloadSegment { toggle: false });
    if is_confirmed || reply.response.is_none() {
        return goes_on(bench, &scratch, true, rest);
    }
    bench.check(reply.refused(Situation::RepeatedToggle))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)?;
    bench.expect_tidy()
}

/// Requests the first segment with toggle bit 1. `None` if the server ignored the request and the transfer has
/// continued.
fn wrong_first(bench: &mut Bench<'_>) -> Result<(Multiplexer, Option<Reply>), Stop> {
    let multiplexer = long_object(bench)?;
    let right = bench.read(multiplexer)?;
    begin_upload(bench, multiplexer)?;
    let what = "request for the first segment with toggle 1";
    let reply = bench.exchange(&Request::UploadSegment { toggle: true }, what)?;
    if reply.response.is_none() {
        finish_upload(bench, multiplexer, Vec::new(), false, &right)?;
        return Ok((multiplexer, None));
    }
    Ok((multiplexer, Some(reply)))
}

/// The first segment of an upload is requested with toggle bit 0. The server ignores a first request with toggle bit 1,
/// and the transfer can continue, or refuses it with abort 0503 0000h.
#[case(id = "301/sdo/upload/first-toggle", clause = "CiA 301 7.2.4.3.7", confidence = Cited, level = Must,
       needs = [SegmentedUpload], catches = [SdoToggleUnchecked, SdoToggleWrongCode], cct = "2.17")]
fn first_toggle(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, reply) = wrong_first(bench)?;
    if let Some(reply) = reply {
        bench.check(reply.refused(Situation::RepeatedToggle))?;
    }
    bench.upload(multiplexer)?.value()?;
    bench.expect_tidy()
}

/// A segment request that repeats the toggle bit does not advance the upload: the server ignores it or sends the same
/// segment again, and the transfer can continue; or the server refuses it with abort 0503 0000h.
#[case(id = "301/sdo/upload/repeated-toggle", clause = "CiA 301 7.2.4.3.5", confidence = Cited, level = Must,
       needs = [SegmentedUpload], catches = [SdoToggleUnchecked])]
fn repeated_toggle(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = long_object(bench)?;
    let right = bench.read(multiplexer)?;
    begin_upload(bench, multiplexer)?;
    let request = Request::UploadSegment { toggle: false };
    let first = bench.exchange(&request, "request for the first segment")?;
    first.expect("an upload segment", |response| matches!(response, Response::UploadSegment(_))).or_inconclusive()?;
    let Some(Response::UploadSegment(segment)) = first.response else { return Ok(()) };
    let again = bench.exchange(&request, "request for the second segment with toggle 0 again")?;
    if again.response.is_none() || again.response == first.response {
        return finish_upload(bench, multiplexer, segment.data().to_vec(), true, &right);
    }
    bench.check(again.refused(Situation::RepeatedToggle))?;
    bench.expect_again(multiplexer, &right, "a new upload returns the whole value")?;
    bench.expect_tidy()
}

/// The abort of a toggle error ends the transfer: a further segment request is refused with abort 0504 0001h, and a new
/// upload works.
#[case(id = "301/sdo/upload/over-after-abort", clause = "CiA 301 7.2.4.3.5", confidence = Cited, level = Must,
       needs = [SegmentedUpload], catches = [SdoStraySegmentSilent, SdoToggleUnchecked])]
fn over_after_abort(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, Some(reply)) = wrong_first(bench)? else {
        bench.note("the server ignores a wrong toggle bit: the transfer continues");
        return bench.expect_tidy();
    };
    bench.check(reply.refused(Situation::RepeatedToggle))?;
    let what = "request for a segment after the abort";
    let reply = bench.exchange(&Request::UploadSegment { toggle: false }, what)?;
    bench.check(reply.refused(Situation::UnknownCommand))?;
    bench.upload(multiplexer)?.value()?;
    bench.expect_tidy()
}

/// The abort of a segment names the object of the transfer. If the server ignores a wrong toggle bit, the case sends a
/// download segment during the upload instead.
#[case(id = "301/sdo/upload/abort-names-object", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       needs = [SegmentedUpload], catches = [SdoAbortMultiplexerZero])]
fn abort_names_object(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, reply) = wrong_first(bench)?;
    let reply = match reply {
        Some(reply) => reply,
        None => {
            begin_upload(bench, multiplexer)?;
            bench.exchange(&segment(false, &[0; 7], false)?, "download segment in the middle of an upload")?
        }
    };
    let Some(Response::Abort(Abort { multiplexer: named, code })) = reply.response else {
        let breach = Breach::new(multiplexer, "a segment that is not allowed in the upload is refused");
        let breach = breach.expected("an abort").found(reply.observation()).told(reply.actual());
        return Err(Box::new(breach)).or_inconclusive();
    };
    bench.check(demand(named == multiplexer || code == AbortCode::TIMEOUT, || {
        Breach::new(multiplexer, "the abort names the object of the transfer")
            .expected(format!("an abort that names {multiplexer}"))
            .found(Observation::Violation(Violation::Multiplexer(named)))
            .told(reply.actual())
    }))
}
