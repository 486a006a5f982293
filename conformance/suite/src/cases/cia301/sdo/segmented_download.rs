//! Segmented download (CiA 301, 7.2.4.3.3 and 7.2.4.3.4). The client chooses the protocol, so the server must accept
//! segments even for short objects.

use super::by_hand::{MISSING, begin_download, confirmed_segment, in_segments, segment};
use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, tried};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::{AbortCode, Payload, Request, Response};

/// The server confirms each message of a segmented download, also for an object of up to four bytes, and the value can
/// be read back.
#[case(id = "301/sdo/download/segmented", clause = "CiA 301 7.2.4.3.4", confidence = Cited, level = Must,
       needs = [ScratchObject, SegmentedDownload], catches = [SdoUnusedBytesNotZero, SdoShortResponse, SdoSegmentedShortRefused], cct = "2.14")]
fn segmented(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[2, 4, 1])?;
    let attempt = bench.download_segmented(scratch.multiplexer, &scratch.other)?;
    attempt.expect_confirmation()?;
    let duty = format!("{} has the value that was written in segments", scratch.multiplexer);
    bench.expect_value(scratch.multiplexer, &scratch.other, duty)?;
    bench.expect_tidy()
}

/// A segmented download with more bytes than announced is refused with abort 0607 0012h, and the object keeps its
/// value.
#[case(id = "301/sdo/download/segments-too-long", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       needs = [ScratchObject, SegmentedDownload], catches = [SdoLengthUnchecked])]
fn segments_too_long(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[2, 4, 1])?;
    begin_download(bench, &scratch)?;
    let mut longer = scratch.other.clone();
    longer.push(0);
    let what = format!("download segment of {} bytes after {} had been announced", longer.len(), scratch.value.len());
    let reply = bench.exchange(&segment(false, &longer, true)?, what)?;
    bench.check(reply.refused(Situation::TooLong))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)
}

/// A segmented download with fewer bytes than announced is refused with abort 0607 0013h, and the object keeps its
/// value.
#[case(id = "301/sdo/download/segments-too-short", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       needs = [ScratchObject, SegmentedDownload], catches = [SdoShortLengthUnchecked])]
fn segments_too_short(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[2, 4])?;
    begin_download(bench, &scratch)?;
    let shorter = scratch.other.get(..1).unwrap_or_default();
    let what = format!("last download segment after 1 of {} bytes", scratch.value.len());
    let reply = bench.exchange(&segment(false, shorter, true)?, what)?;
    bench.check(reply.refused(Situation::TooShort))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)
}

/// The server does not answer an abort of the client during a download, and the object keeps its value.
#[case(id = "301/sdo/download/client-abort", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       needs = [ScratchObject, SegmentedDownload], catches = [SdoAbortAnswered, SdoSegmentsWrittenAtOnce])]
fn client_abort(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2])?;
    begin_download(bench, &scratch)?;
    confirmed_segment(bench, false, scratch.other.get(..1).unwrap_or_default(), false)?;
    let abort = Request::abort(scratch.multiplexer, AbortCode::GENERAL);
    let reply = bench.send_unanswered(&abort, "abort of the client in a download")?;
    bench.check(reply.expect_silence())?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)
}

/// The confirmation of a download segment has the toggle bit of the segment, which alternates beginning with 0.
#[case(id = "301/sdo/download/confirmation-toggle", clause = "CiA 301 7.2.4.3.4", confidence = Cited, level = Must,
       needs = [ScratchObject, SegmentedDownload],
       catches = [SdoDownloadSegmentUnconfirmed, SdoConfirmationToggleStuck])]
fn confirmation_toggle(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2])?;
    begin_download(bench, &scratch)?;
    let last = scratch.other.len().saturating_sub(1);
    for (n, byte) in scratch.other.iter().enumerate() {
        let toggle = n % 2 == 1;
        let what = format!("download segment {} with toggle {}", n + 1, u8::from(toggle));
        let reply = bench.exchange(&segment(toggle, &[*byte], n == last)?, what)?;
        reply.expect("a confirmation with the same toggle bit", |r| *r == Response::DownloadSegment { toggle })?;
    }
    let duty = format!("{} has the value that was sent byte by byte", scratch.multiplexer);
    bench.expect_value(scratch.multiplexer, &scratch.other, duty)?;
    bench.expect_tidy()
}

/// The server accepts a segmented download that does not announce its size, and checks the length at its end.
#[case(id = "301/sdo/download/size-not-announced", clause = "CiA 301 7.2.4.3.3", confidence = Cited, level = Should,
       needs = [ScratchObject, SegmentedDownload], catches = [SdoSegmentedSizeRequired])]
fn size_not_announced(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2])?;
    let multiplexer = scratch.multiplexer;
    bench.write(multiplexer, &scratch.value)?;
    let request = Request::InitiateDownload { multiplexer, payload: Payload::SegmentedUnsized };
    let reply = bench.exchange(&request, format!("segmented download without stated size to {multiplexer}"))?;
    reply.expect("confirmation", |response| *response == Response::InitiateDownload { multiplexer })?;
    let reply = bench.exchange(&segment(false, &scratch.other, true)?, "the only download segment")?;
    reply.expect("its confirmation", |response| *response == Response::DownloadSegment { toggle: false })?;
    bench.expect_value(multiplexer, &scratch.other, format!("{multiplexer} has the value that was written"))
}

/// A segmented download that announces a size that the object can't have is refused with abort 0607 0012h or 0607
/// 0013h, at its start or at its end, and the object keeps its value.
#[case(id = "301/sdo/download/announced-size-wrong", clause = "CiA 301 7.2.4.3.17", confidence = Cited,
       level = Must, needs = [ScratchObject, SegmentedDownload], catches = [SdoLengthUnchecked, SdoLengthWrongCode])]
fn announced_size_wrong(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2, 1])?;
    let multiplexer = scratch.multiplexer;
    bench.write(multiplexer, &scratch.value)?;
    let mut longer = scratch.other.clone();
    longer.extend([0; 2]);
    let attempt = bench.download_segmented(multiplexer, &longer)?;
    bench.check(attempt.refused(Situation::TooLong))?;
    bench.expect_unchanged(multiplexer, &scratch.value)
}

/// The server answers a segment without data in the middle of a download, by a confirmation or an abort.
#[case(id = "301/sdo/download/empty-segment", clause = "CiA 301 7.2.4.3.4", confidence = Cited, level = Should,
       needs = [ScratchObject, SegmentedDownload], catches = [SdoDownloadSegmentUnconfirmed, SdoEmptySegmentSilent])]
fn empty_segment(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2])?;
    begin_download(bench, &scratch)?;
    let reply = bench.exchange(&segment(false, &[], false)?, "download segment without data")?;
    bench.check(reply.expect("a confirmation or an abort", |response| {
        matches!(response, Response::DownloadSegment { toggle: false } | Response::Abort(_))
    }))?;
    bench.send_request(&Request::abort(scratch.multiplexer, AbortCode::GENERAL))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)
}

/// A segmented download to a read-only object is refused with abort 0601 0002h, at its start or with its last segment,
/// and the object keeps its value.
#[case(id = "301/sdo/download/segmented-read-only", clause = "CiA 301 7.2.4.3.17", confidence = Cited,
       level = Must, needs = [SegmentedDownload], catches = [SdoReadOnlySegmentedAccepted, SdoReadOnlyWrongCode])]
fn segmented_read_only(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = Multiplexer::new(object::DEVICE_TYPE, 0);
    let before = bench.read(multiplexer)?;
    let reply = in_segments(bench, multiplexer, 4)?;
    bench.check(reply.refused(Situation::ReadOnly))?;
    bench.expect_unchanged(multiplexer, &before)
}

/// A segmented download to an object or sub-index that does not exist is refused with abort 0602 0000h or 0609 0011h,
/// at its start or with its last segment.
#[case(id = "301/sdo/download/segmented-missing", clause = "CiA 301 7.2.4.3.17", confidence = Cited,
       level = Must, needs = [SegmentedDownload],
       catches = [SdoWrongCodeForNoObject, SdoWrongCodeForNoSubIndex, SdoNoObjectSilent],
       answers = [MissingObject, MissingEntry])]
fn segmented_missing(bench: &mut Bench<'_>) -> Judged {
    for (multiplexer, situation) in MISSING {
        let reply = in_segments(bench, multiplexer, 8)?;
        bench.check(reply.refused(situation))?;
    }
    bench.expect_tidy()
}

/// Strings of 1 to 8 and 13 to 15 bytes can be written by segmented download and read back byte for byte; these lengths
/// lie around the ends of segments.
#[case(id = "301/sdo/download/segment-ends", clause = "CiA 301 7.2.4.3.4", confidence = Cited, level = Must,
       needs = [LongScratch], catches = [SdoDownloadSegmentUnconfirmed, SdoSegmentLengthWrong, SdoUploadEndMissing])]
fn segment_ends(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = bench.long_scratch()?;
    let mut taken = 0;
    bench.each([1_u8, 2, 3, 4, 5, 6, 7, 8, 13, 14, 15], |bench, length| {
        let value: Vec<u8> = (0..length).map(|n| b'A' + n).collect();
        let attempt = bench.download_segmented(multiplexer, &value)?;
        if is_refused_length(attempt.abort()) {
            return Ok(());
        }
        taken += 1;
        attempt.expect_confirmation()?;
        bench.expect_value(multiplexer, &value, format!("{multiplexer} has the {length} bytes that were written"))
    })?;
    tried(taken, "a length that the object accepts")?;
    bench.expect_tidy()
}

/// Whether the server refuses the length of a string, whose maximum the description does not give.
pub(super) const fn is_refused_length(abort: Option<AbortCode>) -> bool {
    matches!(abort, Some(AbortCode::LENGTH | AbortCode::LENGTH_TOO_HIGH | AbortCode::LENGTH_TOO_LOW))
}
