//! Segmented download (CiA 301, 7.2.4.3.3 and 7.2.4.3.4). The client chooses how it writes, so short objects must take
//! segments too.

use super::expect_form;
use crate::bench::Bench;
use crate::bench::objects::Scratch;
use crate::case;
use crate::client::sdo::Bytes;
use crate::verdict::{Judged, Reason, Verdict, demand};
use canvass_analyzer::wire::sdo::{AbortCode, Payload, Request, Response, Segment};

/// Starts a segmented download to a scratch object by hand.
fn begin(bench: &mut Bench<'_>, scratch: &Scratch, size: usize) -> Result<(), Verdict> {
    let multiplexer = scratch.multiplexer;
    let payload = Payload::Segmented(u32::try_from(size).unwrap_or(u32::MAX));
    let request = Request::InitiateDownload { multiplexer, payload };
    let reply = bench.exchange(&request, format!("segmented download to {multiplexer}"))?;
    reply
        .expect("confirmation", |response| *response == Response::InitiateDownload { multiplexer })
        .map(|_| ())
        .map_err(Verdict::as_inconclusive)
}

fn segment(toggle: bool, data: &[u8], last: bool) -> Result<Request, Verdict> {
    Segment::new(toggle, data, last).map(Request::DownloadSegment).ok_or_else(|| {
        Verdict::Error(Reason::new("the tester builds a segment", "up to 7 bytes", format!("{}", data.len())))
    })
}

/// A segmented download is confirmed message by message, also of an object of four bytes or fewer, and the value can be
/// read back.
#[case(id = "301/sdo/download/segmented", clause = "CiA 301 7.2.4.3.4", confidence = Known, level = Must,
       needs = [ScratchObject], catches = [SdoUnusedBytesNotZero, SdoShortResponse], cct = "2.14")]
fn segmented(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[2, 4, 1])?;
    let attempt = bench.download_segmented(scratch.multiplexer, &scratch.other)?;
    attempt.expect_confirmation()?;
    expect_form(&attempt)?;
    let back = bench.upload(scratch.multiplexer)?.value()?;
    demand(back == scratch.other, || {
        let duty = format!("{} has the value that was written", scratch.multiplexer);
        Reason::new(duty, Bytes(&scratch.other).to_string(), Bytes(&back).to_string())
    })
}

/// A download segment with the wrong toggle bit is refused with abort 0503 0000h, and the object keeps its value.
#[case(id = "301/sdo/download/segment-toggle", clause = "CiA 301 7.2.4.3.4", confidence = Known, level = Must,
       needs = [ScratchObject], catches = [SdoToggleUnchecked])]
fn segment_toggle(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[2, 4, 1])?;
    bench.write(scratch.multiplexer, &scratch.value)?;
    begin(bench, &scratch, scratch.value.len())?;
    let reply = bench.exchange(&segment(true, &scratch.other, true)?, "first download segment with toggle 1")?;
    let verdict = reply.expect_abort(&[AbortCode::TOGGLE], &[])?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)?;
    Ok(verdict)
}

/// More bytes in the segments than were announced are refused with abort 0607 0012h, and the object keeps its value.
#[case(id = "301/sdo/download/segments-too-long", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Must,
       needs = [ScratchObject], catches = [SdoLengthUnchecked])]
fn segments_too_long(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[2, 4, 1])?;
    bench.write(scratch.multiplexer, &scratch.value)?;
    begin(bench, &scratch, scratch.value.len())?;
    let mut longer = scratch.other.clone();
    longer.push(0);
    let what = format!("download segment of {} bytes after {} had been announced", longer.len(), scratch.value.len());
    let reply = bench.exchange(&segment(false, &longer, true)?, what)?;
    let verdict = reply.expect_abort(&[AbortCode::LENGTH_TOO_HIGH, AbortCode::LENGTH], &[AbortCode::GENERAL])?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)?;
    Ok(verdict)
}

/// Fewer bytes in the segments than were announced are refused with abort 0607 0013h, and the object keeps its value.
#[case(id = "301/sdo/download/segments-too-short", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Must,
       needs = [ScratchObject], catches = [SdoShortLengthUnchecked])]
fn segments_too_short(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[2, 4])?;
    bench.write(scratch.multiplexer, &scratch.value)?;
    begin(bench, &scratch, scratch.value.len())?;
    let shorter = scratch.other.get(..1).unwrap_or_default();
    let what = format!("last download segment after 1 of {} bytes", scratch.value.len());
    let reply = bench.exchange(&segment(false, shorter, true)?, what)?;
    let verdict = reply.expect_abort(&[AbortCode::LENGTH_TOO_LOW, AbortCode::LENGTH], &[AbortCode::GENERAL])?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)?;
    Ok(verdict)
}

/// An abort of the client in the middle of a download is not answered, and the object keeps its value.
#[case(id = "301/sdo/download/client-abort", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Must,
       needs = [ScratchObject], catches = [SdoAbortAnswered])]
fn client_abort(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2])?;
    bench.write(scratch.multiplexer, &scratch.value)?;
    begin(bench, &scratch, scratch.value.len())?;
    let first = scratch.other.get(..1).unwrap_or_default();
    bench.exchange(&segment(false, first, false)?, "first download segment")?;
    let abort = Request::abort(scratch.multiplexer, AbortCode::GENERAL);
    bench.send_unanswered(&abort, "abort of the client in a download")?.expect_silence()?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)?;
    bench.upload(scratch.multiplexer)?.value()?;
    Ok(Verdict::Pass)
}
