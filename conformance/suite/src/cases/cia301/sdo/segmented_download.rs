//! Segmented download (CiA 301, 7.2.4.3.3 and 7.2.4.3.4). The client chooses how it writes, so short objects must take
//! segments too.

use super::expect_form;
use crate::bench::Bench;
use crate::bench::objects::Scratch;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{AbortCode, Payload, Request, Response, Segment};
use canvass_bus::client::sdo::Bytes;

/// Starts a segmented download to a scratch object by hand.
fn begin(bench: &mut Bench<'_>, scratch: &Scratch, size: usize) -> Result<(), Stop> {
    let multiplexer = scratch.multiplexer;
    let payload = Payload::Segmented(u32::try_from(size).unwrap_or(u32::MAX));
    let request = Request::InitiateDownload { multiplexer, payload };
    let reply = bench.exchange(&request, format!("segmented download to {multiplexer}"))?;
    reply.expect("confirmation", |response| *response == Response::InitiateDownload { multiplexer }).or_inconclusive()
}

fn segment(toggle: bool, data: &[u8], last: bool) -> Result<Request, Stop> {
    Segment::new(toggle, data, last).map(Request::DownloadSegment).ok_or_else(|| {
        Stop::Error(Reason::new("the tester builds a segment", "up to 7 bytes", format!("{}", data.len())))
    })
}

/// A segmented download is confirmed message by message, also of an object of four bytes or fewer, and the value can be
/// read back.
#[case(id = "301/sdo/download/segmented", clause = "CiA 301 7.2.4.3.4", confidence = Known, level = Must,
       needs = [ScratchObject], catches = [SdoUnusedBytesNotZero, SdoShortResponse, SdoSegmentedShortRefused], cct = "2.14")]
fn segmented(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[2, 4, 1])?;
    let attempt = bench.download_segmented(scratch.multiplexer, &scratch.other)?;
    attempt.expect_confirmation()?;
    expect_form(&attempt)?;
    let back = bench.upload(scratch.multiplexer)?.value()?;
    bench.check(demand(back == scratch.other, || {
        let duty = format!("{} has the value that was written", scratch.multiplexer);
        Reason::new(duty, Bytes(&scratch.other).to_string(), Bytes(&back).to_string())
    }))
}

/// A download segment with the wrong toggle bit is refused with abort 0503 0000h, and the object keeps its value.
#[case(id = "301/sdo/download/segment-toggle", clause = "CiA 301 7.2.4.3.4", confidence = Known, level = Must,
       needs = [ScratchObject], catches = [SdoToggleUnchecked, SdoDownloadToggleSilent, SdoToggleWrongCode])]
fn segment_toggle(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[2, 4, 1])?;
    bench.write(scratch.multiplexer, &scratch.value)?;
    begin(bench, &scratch, scratch.value.len())?;
    let reply = bench.exchange(&segment(true, &scratch.other, true)?, "first download segment with toggle 1")?;
    bench.check(reply.refused(Situation::RepeatedToggle))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)?;
    Ok(())
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
    bench.check(reply.refused(Situation::TooLong))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)?;
    Ok(())
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
    bench.check(reply.refused(Situation::TooShort))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)?;
    Ok(())
}

/// An abort of the client in the middle of a download is not answered, and the object keeps its value.
#[case(id = "301/sdo/download/client-abort", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Must,
       needs = [ScratchObject], catches = [SdoAbortAnswered, SdoSegmentsWrittenAtOnce])]
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
    Ok(())
}

/// The toggle bit of confirmed segments is that of the segment, which alternates from 0.
#[case(id = "301/sdo/download/confirmation-toggle", clause = "CiA 301 7.2.4.3.4", confidence = Known, level = Must,
       needs = [ScratchObject], catches = [SdoConfirmationToggleStuck])]
fn confirmation_toggle(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2])?;
    bench.write(scratch.multiplexer, &scratch.value)?;
    begin(bench, &scratch, scratch.value.len())?;
    let last = scratch.other.len().saturating_sub(1);
    for (n, byte) in scratch.other.iter().enumerate() {
        let toggle = n % 2 == 1;
        let what = format!("download segment {} with toggle {}", n + 1, u8::from(toggle));
        let reply = bench.exchange(&segment(toggle, &[*byte], n == last)?, what)?;
        reply.expect("a confirmation with the same toggle bit", |r| *r == Response::DownloadSegment { toggle })?;
    }
    let back = bench.upload(scratch.multiplexer)?.value()?;
    bench.check(demand(back == scratch.other, || {
        let duty = format!("{} has the value that came byte by byte", scratch.multiplexer);
        Reason::new(duty, Bytes(&scratch.other).to_string(), Bytes(&back).to_string())
    }))
}

/// A toggle bit that repeats in the second segment is refused with abort 0503 0000h, and the object keeps its value.
#[case(id = "301/sdo/download/second-toggle", clause = "CiA 301 7.2.4.3.4", confidence = Known, level = Must,
       needs = [ScratchObject], catches = [SdoToggleUnchecked, SdoDownloadToggleSilent, SdoToggleWrongCode])]
fn second_toggle(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2])?;
    bench.write(scratch.multiplexer, &scratch.value)?;
    begin(bench, &scratch, scratch.value.len())?;
    let (first, rest) = scratch.other.split_at(1);
    bench.exchange(&segment(false, first, false)?, "first download segment")?;
    let reply = bench.exchange(&segment(false, rest, true)?, "second download segment with toggle 0 again")?;
    bench.check(reply.refused(Situation::RepeatedToggle))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)?;
    Ok(())
}

/// A segmented download that does not announce its size is taken; its length is checked at its end.
#[case(id = "301/sdo/download/size-not-announced", clause = "CiA 301 7.2.4.3.3", confidence = Known, level = Should,
       needs = [ScratchObject], catches = [SdoSegmentedSizeRequired])]
fn size_not_announced(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2])?;
    let multiplexer = scratch.multiplexer;
    bench.write(multiplexer, &scratch.value)?;
    let request = Request::InitiateDownload { multiplexer, payload: Payload::SegmentedUnsized };
    let reply = bench.exchange(&request, format!("segmented download of no stated size to {multiplexer}"))?;
    reply.expect("confirmation", |response| *response == Response::InitiateDownload { multiplexer })?;
    let reply = bench.exchange(&segment(false, &scratch.other, true)?, "the only download segment")?;
    reply.expect("its confirmation", |response| *response == Response::DownloadSegment { toggle: false })?;
    let back = bench.upload(multiplexer)?.value()?;
    bench.check(demand(back == scratch.other, || {
        let duty = format!("{multiplexer} has the value that was written");
        Reason::new(duty, Bytes(&scratch.other).to_string(), Bytes(&back).to_string())
    }))
}

/// A size that the object can't have is refused with abort 0607 0012h or 0607 0013h, with the announcement or at the end,
/// and the object keeps its value.
#[case(id = "301/sdo/download/announced-size-wrong", clause = "CiA 301 7.2.4.3.17", confidence = Attested,
       level = Must, needs = [ScratchObject], catches = [SdoLengthUnchecked, SdoLengthWrongCode])]
fn announced_size_wrong(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2, 1])?;
    let multiplexer = scratch.multiplexer;
    bench.write(multiplexer, &scratch.value)?;
    let mut longer = scratch.other.clone();
    longer.extend([0; 2]);
    let attempt = bench.download_segmented(multiplexer, &longer)?;
    bench.check(attempt.refused(Situation::TooLong))?;
    bench.expect_unchanged(multiplexer, &scratch.value)?;
    Ok(())
}

/// A segment without data in the middle of a download is confirmed or refused, but answered.
#[case(id = "301/sdo/download/empty-segment", clause = "CiA 301 7.2.4.3.4", confidence = Known, level = Should,
       needs = [ScratchObject], catches = [SdoEmptySegmentSilent])]
fn empty_segment(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2])?;
    bench.write(scratch.multiplexer, &scratch.value)?;
    begin(bench, &scratch, scratch.value.len())?;
    let reply = bench.exchange(&segment(false, &[], false)?, "download segment without data")?;
    reply.expect("a confirmation or an abort", |_| true)?;
    bench.send_request(&Request::abort(scratch.multiplexer, AbortCode::GENERAL))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)
}

/// A segmented download to an object that can only be read is refused with abort 0601 0002h at once, and the object
/// keeps its value.
#[case(id = "301/sdo/download/segmented-read-only", clause = "CiA 301 7.2.4.3.17", confidence = Attested,
       level = Must, catches = [SdoReadOnlySegmentedAccepted, SdoReadOnlyWrongCode])]
fn segmented_read_only(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = Multiplexer::new(0x1000, 0);
    let before = bench.read(multiplexer)?;
    let request = Request::InitiateDownload { multiplexer, payload: Payload::Segmented(4) };
    let reply = bench.exchange(&request, format!("segmented download to {multiplexer}"))?;
    bench.check(reply.refused(Situation::ReadOnly))?;
    bench.expect_unchanged(multiplexer, &before)?;
    Ok(())
}

/// A segmented download to an object or sub-index that does not exist is refused at once, with abort 0602 0000h or
/// 0609 0011h.
#[case(id = "301/sdo/download/segmented-missing", clause = "CiA 301 7.2.4.3.17", confidence = Attested,
       level = Must, catches = [SdoWrongCodeForNoObject, SdoWrongCodeForNoSubIndex, SdoNoObjectSilent])]
fn segmented_missing(bench: &mut Bench<'_>) -> Judged {
    for (multiplexer, code) in
        [(Multiplexer::new(0xFFFF, 0), AbortCode::NO_OBJECT), (Multiplexer::new(0x1000, 1), AbortCode::NO_SUB_INDEX)]
    {
        let request = Request::InitiateDownload { multiplexer, payload: Payload::Segmented(8) };
        let reply = bench.exchange(&request, format!("segmented download to {multiplexer}"))?;
        bench.check(reply.refused_with(&[code], &[AbortCode::GENERAL]))?;
    }
    Ok(())
}

/// Strings of 6, 7, 8, 13 and 14 bytes are written and read back to the byte: around the ends of segments.
#[case(id = "301/sdo/download/segment-ends", clause = "CiA 301 7.2.4.3.4", confidence = Known, level = Must,
       needs = [LongScratch], catches = [SdoSegmentLengthWrong, SdoUploadEndMissing])]
fn segment_ends(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = bench.long_scratch()?;
    for length in [6_u8, 7, 8, 13, 14] {
        let value: Vec<u8> = (0..length).map(|n| b'A' + n).collect();
        let attempt = bench.download(multiplexer, &value)?;
        if matches!(attempt.abort(), Some(AbortCode::LENGTH | AbortCode::LENGTH_TOO_HIGH | AbortCode::LENGTH_TOO_LOW)) {
            // The description does not say how long a string may be.
            continue;
        }
        attempt.expect_confirmation()?;
        let back = bench.upload(multiplexer)?.value()?;
        demand(back == value, || {
            let duty = format!("{multiplexer} has the {length} bytes that were written");
            Reason::new(duty, Bytes(&value).to_string(), Bytes(&back).to_string())
        })?;
    }
    Ok(())
}
