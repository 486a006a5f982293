//! Segmented upload (CiA 301, 7.2.4.3.6 and 7.2.4.3.7).

use super::expect_form;
use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{AbortCode, Payload, Request, Response};

/// An object whose upload takes at least two segments.
fn long_object(bench: &mut Bench<'_>) -> Result<Multiplexer, Stop> {
    bench.long_object(8)?.ok_or_else(|| {
        let reason = Reason::new("an object is read in segments", "more than 7 bytes", "none found");
        Stop::NotApplicable(reason)
    })
}

/// Starts a segmented upload by hand.
fn begin(bench: &mut Bench<'_>, multiplexer: Multiplexer) -> Result<(), Stop> {
    let reply = bench.exchange(&Request::upload(multiplexer), format!("upload of {multiplexer}"))?;
    reply
        .expect("the start of a segmented upload", |response| {
            matches!(response, Response::InitiateUpload { multiplexer: named, payload } if *named == multiplexer
                && matches!(payload, Payload::Segmented(_) | Payload::SegmentedUnsized))
        })
        .or_inconclusive()
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
    bench.check(reply.refused(Situation::RepeatedToggle))?;
    bench.upload(multiplexer)?.value()?;
    Ok(())
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
        .or_inconclusive()?;
    let reply = bench.exchange(&request, "request for the second segment with toggle 0 again")?;
    bench.check(reply.refused(Situation::RepeatedToggle))?;
    bench.upload(multiplexer)?.value()?;
    Ok(())
}

/// After a toggle error the transfer is over: a further request for a segment is refused with abort 0504 0001h.
#[case(id = "301/sdo/upload/over-after-abort", clause = "CiA 301 7.2.4.3.7", confidence = Known, level = Must,
       needs = [SegmentedUpload], catches = [SdoStraySegmentSilent, SdoToggleUnchecked])]
fn over_after_abort(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = long_object(bench)?;
    begin(bench, multiplexer)?;
    let reply =
        bench.exchange(&Request::UploadSegment { toggle: true }, "request for the first segment with toggle 1")?;
    bench.check(reply.refused(Situation::RepeatedToggle))?;
    let reply = bench.exchange(&Request::UploadSegment { toggle: false }, "request for a segment after the abort")?;
    bench.check(reply.refused(Situation::UnknownCommand))?;
    let value = bench.upload(multiplexer)?.value()?;
    demand(!value.is_empty(), || Reason::new("a new upload works", "the value", "nothing"))?;
    Ok(())
}

/// After the last segment of an upload the transfer is over: a request for one more is refused with abort 0504 0001h.
#[case(id = "301/sdo/upload/over-after-end", clause = "CiA 301 7.2.4.3.7", confidence = Known, level = Must,
       needs = [SegmentedUpload], catches = [SdoSegmentAfterEndAnswered, SdoCommandWrongCode])]
fn over_after_end(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = long_object(bench)?;
    let value = bench.upload(multiplexer)?.value().or_inconclusive()?;
    // The toggle bit that would be the next.
    let toggle = value.len().div_ceil(7) % 2 == 1;
    let reply = bench.exchange(&Request::UploadSegment { toggle }, "request for a segment after the last one")?;
    bench.check(reply.refused(Situation::UnknownCommand))?;
    bench.upload(multiplexer)?.value()?;
    Ok(())
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
        return Err(Stop::Inconclusive(reason));
    };
    bench.check(demand(abort.multiplexer == multiplexer, || {
        let duty = "the abort names the object of the transfer";
        Reason::new(duty, multiplexer.to_string(), abort.multiplexer.to_string())
    }))
}

/// An empty value is read by an announcement of 0 bytes and one empty segment, or refused with abort 0800 0024h.
#[case(id = "301/sdo/upload/empty", clause = "CiA 301 7.2.4.3.6", confidence = Known, level = Should,
       needs = [EmptyValue], catches = [SdoEmptyValueSilent])]
fn empty(bench: &mut Bench<'_>) -> Judged {
    let Some(multiplexer) = bench.empty_object()? else {
        let reason = Reason::new("an object is empty", "a string without characters", "none");
        return Err(Stop::NotApplicable(reason));
    };
    let attempt = bench.upload(multiplexer)?;
    if attempt.abort() == Some(AbortCode::NO_DATA) {
        return Ok(());
    }
    let value = attempt.value()?;
    bench.check(demand(value.is_empty(), || {
        let actual = canvass_bus::client::sdo::Bytes(&value).to_string();
        Reason::new(format!("{multiplexer} is empty, as described"), "no bytes", actual)
    }))
}
