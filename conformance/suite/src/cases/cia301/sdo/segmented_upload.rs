//! Segmented upload (CiA 301, 7.2.4.3.6 and 7.2.4.3.7).

use super::expect_form;
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Reason, Verdict, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{AbortCode, Payload, Request, Response};

/// An object whose upload takes at least two segments.
fn long_object(bench: &mut Bench<'_>) -> Result<Multiplexer, Verdict> {
    bench.long_object(8)?.ok_or_else(|| {
        let reason = Reason::new("an object is read in segments", "more than 7 bytes", "none found");
        Verdict::NotApplicable(reason)
    })
}

/// Starts a segmented upload by hand.
fn begin(bench: &mut Bench<'_>, multiplexer: Multiplexer) -> Result<(), Verdict> {
    let reply = bench.exchange(&Request::upload(multiplexer), format!("upload of {multiplexer}"))?;
    reply
        .expect("the start of a segmented upload", |response| {
            matches!(response, Response::InitiateUpload { multiplexer: named, payload } if *named == multiplexer
                && matches!(payload, Payload::Segmented(_) | Payload::SegmentedUnsized))
        })
        .map(|_| ())
        .map_err(Verdict::as_inconclusive)
}

/// A segmented upload delivers as many bytes as announced; toggle bits alternate from 0; unused bytes are 0.
#[case(id = "301/sdo/upload/segmented", clause = "CiA 301 7.2.4.3.7", confidence = Known, level = Must,
       needs = [SegmentedUpload], catches = [SdoSegmentLengthWrong, SdoUnusedBytesNotZero, SdoShortResponse, SdoUploadToggleStuck, SdoUploadEndMissing, SdoAnnouncedSizeWrong], cct = "2.16")]
fn segmented(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = long_object(bench)?;
    let attempt = bench.upload(multiplexer)?;
    attempt.clone().value()?;
    expect_form(&attempt)
}

/// The first segment is asked for with toggle bit 0; a request with 1 is refused with abort 0503 0000h.
#[case(id = "301/sdo/upload/first-toggle", clause = "CiA 301 7.2.4.3.7", confidence = Known, level = Must,
       needs = [SegmentedUpload], catches = [SdoToggleUnchecked, SdoToggleWrongCode], cct = "2.17")]
fn first_toggle(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = long_object(bench)?;
    begin(bench, multiplexer)?;
    let reply =
        bench.exchange(&Request::UploadSegment { toggle: true }, "request for the first segment with toggle 1")?;
    let verdict = reply.expect_abort(&[AbortCode::TOGGLE], &[])?;
    bench.upload(multiplexer)?.value()?;
    Ok(verdict)
}

/// A request for the next segment whose toggle bit repeats is refused with abort 0503 0000h.
#[case(id = "301/sdo/upload/repeated-toggle", clause = "CiA 301 7.2.4.3.7", confidence = Known, level = Must,
       needs = [SegmentedUpload], catches = [SdoToggleUnchecked])]
fn repeated_toggle(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = long_object(bench)?;
    begin(bench, multiplexer)?;
    let request = Request::UploadSegment { toggle: false };
    bench
        .exchange(&request, "request for the first segment")?
        .expect("an upload segment", |response| matches!(response, Response::UploadSegment(_)))
        .map_err(Verdict::as_inconclusive)?;
    let reply = bench.exchange(&request, "request for the second segment with toggle 0 again")?;
    let verdict = reply.expect_abort(&[AbortCode::TOGGLE], &[])?;
    bench.upload(multiplexer)?.value()?;
    Ok(verdict)
}

/// After a toggle error the transfer is over: a further request for a segment is refused with abort 0504 0001h.
#[case(id = "301/sdo/upload/over-after-abort", clause = "CiA 301 7.2.4.3.7", confidence = Known, level = Must,
       needs = [SegmentedUpload], catches = [SdoStraySegmentSilent, SdoToggleUnchecked])]
fn over_after_abort(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = long_object(bench)?;
    begin(bench, multiplexer)?;
    let reply =
        bench.exchange(&Request::UploadSegment { toggle: true }, "request for the first segment with toggle 1")?;
    reply.expect_abort(&[AbortCode::TOGGLE], &[])?;
    let reply = bench.exchange(&Request::UploadSegment { toggle: false }, "request for a segment after the abort")?;
    let verdict = reply.expect_abort(&[AbortCode::COMMAND_SPECIFIER], &[])?;
    let value = bench.upload(multiplexer)?.value()?;
    demand(!value.is_empty(), || Reason::new("a new upload works", "the value", "nothing"))?;
    Ok(verdict)
}

/// After the last segment of an upload the transfer is over: a request for one more is refused with abort 0504 0001h.
#[case(id = "301/sdo/upload/over-after-end", clause = "CiA 301 7.2.4.3.7", confidence = Known, level = Must,
       needs = [SegmentedUpload], catches = [SdoSegmentAfterEndAnswered, SdoCommandWrongCode])]
fn over_after_end(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = long_object(bench)?;
    let value = bench.upload(multiplexer)?.value().map_err(Verdict::as_inconclusive)?;
    // The toggle bit that would be the next.
    let toggle = value.len().div_ceil(7) % 2 == 1;
    let reply = bench.exchange(&Request::UploadSegment { toggle }, "request for a segment after the last one")?;
    let verdict = reply.expect_abort(&[AbortCode::COMMAND_SPECIFIER], &[])?;
    bench.upload(multiplexer)?.value()?;
    Ok(verdict)
}

/// The abort of a segment names the object of the transfer.
#[case(id = "301/sdo/upload/abort-names-object", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Must,
       needs = [SegmentedUpload], catches = [SdoAbortMultiplexerZero])]
fn abort_names_object(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = long_object(bench)?;
    begin(bench, multiplexer)?;
    let what = "request for the first segment with toggle 1";
    let reply = bench.exchange(&Request::UploadSegment { toggle: true }, what)?;
    let Some(Response::Abort(abort)) = reply.response else {
        let reason = Reason::new(format!("the {what} is refused"), "an abort", reply.actual());
        return Err(Verdict::Inconclusive(reason));
    };
    demand(abort.multiplexer == multiplexer, || {
        let duty = "the abort names the object of the transfer";
        Reason::new(duty, multiplexer.to_string(), abort.multiplexer.to_string())
    })
}

/// An empty value is read by an announcement of 0 bytes and one empty segment, or refused with abort 0800 0024h.
#[case(id = "301/sdo/upload/empty", clause = "CiA 301 7.2.4.3.6", confidence = Known, level = Should,
       needs = [EmptyValue], catches = [SdoEmptyValueSilent])]
fn empty(bench: &mut Bench<'_>) -> Judged {
    let Some(multiplexer) = bench.empty_object()? else {
        let reason = Reason::new("an object is empty", "a string without characters", "none");
        return Err(Verdict::NotApplicable(reason));
    };
    let attempt = bench.upload(multiplexer)?;
    if attempt.abort() == Some(AbortCode::NO_DATA) {
        return Ok(Verdict::Pass);
    }
    let value = attempt.value()?;
    demand(value.is_empty(), || {
        let actual = canvass_bus::client::sdo::Bytes(&value).to_string();
        Reason::new(format!("{multiplexer} is empty, as described"), "no bytes", actual)
    })
}
