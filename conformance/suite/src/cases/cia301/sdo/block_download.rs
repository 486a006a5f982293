//! Block download (CiA 301, 7.2.4.3.8 to 7.2.4.3.11).

use super::by_hand::MISSING;
use super::segmented_download::is_refused_length;
use crate::bench::Bench;
use crate::bench::objects::Scratch;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Allowed, Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{self, AbortCode, BlockSegment, Request, Response};
use canvass_bus::client::block_download::{DownloadManner, Mischief};
use canvass_bus::observation::Observation;

/// A scratch object. Its current value is written once, so that the bench puts it back.
fn subject(bench: &mut Bench<'_>) -> Result<Scratch, Stop> {
    let scratch = bench.scratch(&[4, 2])?;
    bench.write(scratch.multiplexer, &scratch.value)?;
    Ok(scratch)
}

/// A writable string, and a value for it of `length` bytes or of the only length that the device accepts.
fn long_subject(bench: &mut Bench<'_>, length: usize) -> Result<(Multiplexer, Vec<u8>), Stop> {
    let multiplexer = bench.long_scratch()?;
    let value = text(length);
    let attempt = bench.download(multiplexer, &value)?;
    // If strings have a fixed length, the value has the length of the current one.
    let is_fixed = is_refused_length(attempt.abort());
    let value = if is_fixed { text(bench.read(multiplexer)?.len()) } else { value };
    Ok((multiplexer, value))
}

fn text(length: usize) -> Vec<u8> {
    (0..length).map(|n| b'a' + (n % 26) as u8).collect()
}

fn has_value(bench: &mut Bench<'_>, multiplexer: Multiplexer, right: &[u8]) -> Judged {
    bench.expect_value(multiplexer, right, format!("{multiplexer} has the value that was written in blocks"))?;
    bench.expect_tidy()
}

/// A string of three segments or more that leaves at least one segment of its only block unused. If the device does not
/// fix the length, the string has at most six segments.
fn one_block(bench: &mut Bench<'_>) -> Result<(Multiplexer, Vec<u8>), Stop> {
    const LENGTH: usize = 40;
    let (multiplexer, value) = long_subject(bench, LENGTH)?;
    let (_, client) = bench.block_download(multiplexer, &value, DownloadManner::right(&value))?;
    let most = usize::from(client.block_size).saturating_sub(1);
    let segments = if value.len() == LENGTH { most.min(6) } else { value.len().div_ceil(7) };
    if segments < 3 || segments > most {
        let actual = format!("blocks of {} segments for {} bytes", client.block_size, value.len());
        return Err(Stop::NotApplicable(Reason::new("a string fits into one block", "4 segments or more", actual)));
    }
    if value.len() != LENGTH {
        return Ok((multiplexer, value));
    }
    long_subject(bench, 7 * segments - 2)
}

/// Writes a string with an error in its only block and requires that the server recovers: it confirms the segments that
/// came in order, and accepts the rest when it is repeated. `confirmed` lists the segments that the server may name in
/// its confirmation; 0 stands for the last segment.
fn made_good(bench: &mut Bench<'_>, mischief: Mischief, confirmed: &[u8]) -> Judged {
    let (multiplexer, value) = one_block(bench)?;
    let last = u8::try_from(value.len().div_ceil(7)).unwrap_or(u8::MAX);
    let confirmed: Vec<u8> = confirmed.iter().map(|&segment| if segment == 0 { last } else { segment }).collect();
    let manner = DownloadManner { mischief, ..DownloadManner::right(&value) };
    let (attempt, client) = bench.block_download(multiplexer, &value, manner)?;
    if client.block_size <= last {
        let reason = Reason::new(
            "the block accepts all segments",
            "one segment more than before",
            client.block_size.to_string(),
        );
        return Err(Stop::Inconclusive(reason));
    }
    attempt.expect_confirmation()?;
    let first = client.confirmations.first().copied().unwrap_or_default();
    bench.check(demand(confirmed.contains(&first), || {
        let expected = confirmed.iter().map(|&segment| Observation::Number(u64::from(segment))).collect();
        Breach::new(multiplexer, "the server confirms the last segment that arrived in order")
            .expected(Allowed::OneOf(expected))
            .found(Observation::Number(u64::from(first)))
            .told(format!("segment {first}"))
    }))?;
    has_value(bench, multiplexer, &value)
}

/// Writes one object of each length in blocks, and requires that the server accepts each.
fn taken(bench: &mut Bench<'_>, manner: fn(&[u8]) -> DownloadManner) -> Judged {
    let mut scratches = bench.scratch_objects()?;
    scratches.sort_by_key(|scratch| scratch.value.len());
    scratches.dedup_by_key(|scratch| scratch.value.len());
    bench.each(scratches, |bench, scratch| {
        let (attempt, _) = bench.block_download(scratch.multiplexer, &scratch.other, manner(&scratch.other))?;
        attempt.expect_confirmation()?;
        has_value(bench, scratch.multiplexer, &scratch.other)
    })
}

/// The server accepts a block download without CRC, and the value can be read back.
#[case(id = "301/sdo/block-download/complete", clause = "CiA 301 7.2.4.3.9", confidence = Cited, level = Must,
       needs = [BlockDownload], cct = "2.21",
       catches = [SdoBlockPaddingKept, SdoBlockEndSilent, SdoBlockSizeZeroOffered, SdoBlockCountOffByOne])]
fn complete(bench: &mut Bench<'_>) -> Judged {
    taken(bench, |value| DownloadManner { crc: false, ..DownloadManner::right(value) })
}

/// The server accepts a block download without CRC after a block download with CRC: each transfer states whether it has
/// a CRC.
#[case(id = "301/sdo/block-download/crc-not-kept", clause = "CiA 301 7.2.4.3.9", confidence = Cited, level = Must,
       needs = [BlockDownload], catches = [SdoBlockCrcKept])]
fn crc_not_kept(bench: &mut Bench<'_>) -> Judged {
    let scratch = subject(bench)?;
    let with_crc = DownloadManner::right(&scratch.value);
    let (first, _) = bench.block_download(scratch.multiplexer, &scratch.value, with_crc)?;
    first.expect_confirmation().or_inconclusive()?;
    // The CRC of zeros is 0, like the CRC field of a transfer without CRC, so the other value must differ from 0.
    let without_crc = DownloadManner { crc: false, ..DownloadManner::right(&scratch.other) };
    let (mut second, _) = bench.block_download(scratch.multiplexer, &scratch.other, without_crc)?;
    second.what = format!("{} without CRC after one with CRC", second.what);
    second.expect_confirmation()?;
    has_value(bench, scratch.multiplexer, &scratch.other)
}

/// The server accepts a block download with the correct CRC, and the value can be read back.
#[case(id = "301/sdo/block-download/crc", clause = "CiA 301 7.2.4.3.16", confidence = Cited, level = Must,
       needs = [BlockDownload], catches = [SdoBlockPaddingKept, SdoBlockEndSilent, SdoBlockCrcOfFilling], cct = "2.25")]
fn crc(bench: &mut Bench<'_>) -> Judged {
    taken(bench, DownloadManner::right)
}

/// The server accepts a block download that does not announce its size.
#[case(id = "301/sdo/block-download/size-not-announced", clause = "CiA 301 7.2.4.3.9", confidence = Cited,
       level = Should, needs = [BlockDownload], catches = [SdoBlockPaddingKept])]
fn size_not_announced(bench: &mut Bench<'_>) -> Judged {
    taken(bench, |value| DownloadManner { announce: None, ..DownloadManner::right(value) })
}

/// A block download with a wrong CRC is refused with abort 0504 0004h, and the object keeps its value.
#[case(id = "301/sdo/block-download/wrong-crc", clause = "CiA 301 7.2.4.3.8", confidence = Cited, level = Must,
       needs = [BlockDownload, BlockCrc],
       catches = [SdoBlockCrcIgnored, SdoBlockCrcWrongCode, SdoBlockWrittenBeforeCheck])]
fn wrong_crc(bench: &mut Bench<'_>) -> Judged {
    let scratch = subject(bench)?;
    let manner = DownloadManner { crc_error: 1, ..DownloadManner::right(&scratch.other) };
    let (mut attempt, _) = bench.block_download(scratch.multiplexer, &scratch.other, manner)?;
    attempt.what = format!("{} with a wrong CRC", attempt.what);
    bench.check(attempt.refused(Situation::WrongChecksum))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)?;
    bench.expect_tidy()
}

/// A block download of fewer bytes than announced is refused with abort 0607 0013h, and the object keeps its value.
#[case(id = "301/sdo/block-download/too-few-bytes", clause = "CiA 301 7.2.4.3.11", confidence = Cited, level = Must,
       needs = [BlockDownload], catches = [SdoBlockSizeMismatchAccepted])]
fn too_few_bytes(bench: &mut Bench<'_>) -> Judged {
    let scratch = subject(bench)?;
    let announce = u32::try_from(scratch.other.len()).ok();
    let shorter = scratch.other.get(..scratch.other.len() - 1).unwrap_or_default();
    let manner = DownloadManner { announce, ..DownloadManner::right(shorter) };
    let (mut attempt, _) = bench.block_download(scratch.multiplexer, shorter, manner)?;
    attempt.what = format!("{} after {} had been announced", attempt.what, scratch.other.len());
    bench.check(attempt.refused(Situation::TooShort))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)?;
    bench.expect_tidy()
}

/// A block download of more bytes than announced is refused with abort 0607 0012h, and the object keeps its value.
#[case(id = "301/sdo/block-download/too-many-bytes", clause = "CiA 301 7.2.4.3.11", confidence = Cited, level = Must,
       needs = [BlockDownload], catches = [SdoBlockSizeMismatchAccepted])]
fn too_many_bytes(bench: &mut Bench<'_>) -> Judged {
    let scratch = subject(bench)?;
    let announce = u32::try_from(scratch.other.len()).ok();
    let mut longer = scratch.other.clone();
    longer.push(0);
    let manner = DownloadManner { announce, ..DownloadManner::right(&longer) };
    let (mut attempt, _) = bench.block_download(scratch.multiplexer, &longer, manner)?;
    attempt.what = format!("{} after {} had been announced", attempt.what, scratch.other.len());
    bench.check(attempt.refused(Situation::TooLong))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)?;
    bench.expect_tidy()
}

/// A block download that announces a size that the object can't have is refused with abort 0607 0012h, at its start or
/// at its end.
#[case(id = "301/sdo/block-download/announced-size-wrong", clause = "CiA 301 7.2.4.3.9", confidence = Cited,
       level = Should, needs = [BlockDownload], catches = [SdoLengthWrongCode])]
fn announced_size_wrong(bench: &mut Bench<'_>) -> Judged {
    let scratch = subject(bench)?;
    let mut longer = scratch.other.clone();
    longer.push(0);
    let (attempt, _) = bench.block_download(scratch.multiplexer, &longer, DownloadManner::right(&longer))?;
    bench.check(attempt.refused(Situation::TooLong))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)?;
    bench.expect_tidy()
}

/// When a segment of a block is lost, the server confirms the segment before it, and accepts the remaining segments
/// when they are repeated.
#[case(id = "301/sdo/block-download/segment-lost", clause = "CiA 301 7.2.4.3.10", confidence = Cited, level = Must,
       needs = [BlockDownload, LongScratch], catches = [SdoBlockGapAccepted])]
fn segment_lost(bench: &mut Bench<'_>) -> Judged {
    made_good(bench, Mischief::Skip(2), &[1])
}

/// The server writes the data of a repeated segment once. A server that refuses the segment as out of sequence with
/// abort 0504 0003h keeps the old value.
#[case(id = "301/sdo/block-download/segment-repeated", clause = "CiA 301 7.2.4.3.10", confidence = Cited, level = Must,
       needs = [BlockDownload, LongScratch], catches = [SdoBlockRepeatedAppended])]
fn segment_repeated(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, value) = one_block(bench)?;
    let before = vec![b'-'; value.len()];
    bench.write(multiplexer, &before)?;
    let manner = DownloadManner { mischief: Mischief::Repeat(2), ..DownloadManner::right(&value) };
    let (attempt, _) = bench.block_download(multiplexer, &value, manner)?;
    if attempt.abort() == Some(AbortCode::SEQUENCE_NUMBER) {
        return bench.expect_unchanged(multiplexer, &before);
    }
    // A server may continue after the repeated segment, or stop there.
    made_good(bench, Mischief::Repeat(2), &[2, 0])
}

/// When two segments arrive in the wrong order, the server confirms the last segment in order, and accepts the
/// remaining segments when they are repeated.
#[case(id = "301/sdo/block-download/segments-swapped", clause = "CiA 301 7.2.4.3.10", confidence = Cited, level = Must,
       needs = [BlockDownload, LongScratch], catches = [SdoBlockGapAccepted])]
fn segments_swapped(bench: &mut Bench<'_>) -> Judged {
    // Of the segments 1 3 2, two were in order, unless the server stops at the first segment that was not in order.
    made_good(bench, Mischief::Swap(2), &[1, 2])
}

/// A segment with sequence number 0 is refused with abort 0504 0003h.
#[case(id = "301/sdo/block-download/sequence-zero", clause = "CiA 301 7.2.4.3.10", confidence = Cited, level = Should,
       needs = [BlockDownload, LongScratch], catches = [SdoBlockSequenceZeroIgnored])]
fn sequence_zero(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, value) = long_subject(bench, 20)?;
    if value.len() <= 7 {
        // The only segment is the last one: with number 0 it can't be distinguished from an abort.
        let actual = format!("{} bytes", value.len());
        let reason = Reason::new("a value of more than one segment can be written", "8 bytes or more", actual);
        return Err(Stop::NotApplicable(reason));
    }
    let manner = DownloadManner { mischief: Mischief::NumberZero, ..DownloadManner::right(&value) };
    let (mut attempt, _) = bench.block_download(multiplexer, &value, manner)?;
    attempt.what = "segment with sequence number 0".to_owned();
    bench.check(attempt.refused(Situation::SequenceNumber))
}

/// When the client stops sending during a block download, the server answers the next request, and the object keeps its
/// value. The standard leaves the behaviour open: it defines no timeout, and the server may take a request for a
/// segment.
#[case(id = "301/sdo/block-download/silent-client", clause = "CiA 301 7.2.4.3.8", confidence = Cited, level = Open,
       needs = [BlockDownload], catches = [SdoTimeoutWedges])]
fn silent_client(bench: &mut Bench<'_>) -> Judged {
    let scratch = subject(bench)?;
    begin(bench, &scratch)?;
    bench.listen(bench.timing().sdo_response.times(3))?;
    interrupted(bench, &scratch, "after an unfinished block download")
}

/// The server answers a request that arrives between the data of a block download and its end, and the object keeps its
/// value. The standard leaves the behaviour open: it defines only an abort and the end of the download there.
#[case(id = "301/sdo/block-download/abandoned", clause = "CiA 301 7.2.4.3.8", confidence = Cited, level = Open,
       needs = [BlockDownload], catches = [SdoBusyAfterAbandonedBlock])]
fn abandoned(bench: &mut Bench<'_>) -> Judged {
    let scratch = subject(bench)?;
    begin(bench, &scratch)?;
    // All data has been sent, but not the end of the transfer.
    send_segment(bench, segment(1, true, &scratch.other))?;
    interrupted(bench, &scratch, "in the middle of a block download")
}

/// Starts a block download by hand.
fn begin(bench: &mut Bench<'_>, scratch: &Scratch) -> Judged {
    let multiplexer = scratch.multiplexer;
    let size = u32::try_from(scratch.other.len()).ok();
    let request = Request::InitiateBlockDownload { multiplexer, crc: true, size };
    let reply = bench.exchange(&request, format!("block download to {multiplexer}"))?;
    let is_start = |response: &Response| matches!(response, Response::InitiateBlockDownload { .. });
    reply.expect("the start of a block download", is_start).or_inconclusive()
}

fn segment(sequence: u8, last: bool, value: &[u8]) -> [u8; 8] {
    let (mut data, mut message) = ([0; 7], [0; 8]);
    data.iter_mut().zip(value).for_each(|(to, from)| *to = *from);
    BlockSegment { sequence, last, data }.emit(&mut message);
    message
}

/// Sends a segment, and waits for the confirmation of its block if it was the last.
fn send_segment(bench: &mut Bench<'_>, segment: [u8; 8]) -> Judged {
    bench.send_message(segment)?;
    if segment[0] & 0x80 == 0 {
        return bench.listen(bench.timing().reaction).map(|_| ());
    }
    let response = sdo::RESPONSE_BASE + u16::from(bench.node().raw());
    let limit = bench.timing().sdo_response;
    bench.wait_for(limit, |record| (record.frame.cob_id() == Some(response)).then_some(())).map(|_| ())
}

/// Requires that the server serves a request during the block download, and ends the download.
fn interrupted(bench: &mut Bench<'_>, scratch: &Scratch, circumstance: &str) -> Judged {
    let served = bench.expect_served(circumstance);
    bench.send_request(&Request::abort(scratch.multiplexer, AbortCode::GENERAL))?;
    bench.listen(bench.timing().reaction)?;
    bench.each([served], |_, served| served)?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)
}

/// A block download to a read-only object is refused with abort 0601 0002h, at its start or at its end, and the object
/// keeps its value.
#[case(id = "301/sdo/block-download/read-only", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       needs = [BlockDownload], catches = [SdoBlockReadOnlyAccepted, SdoReadOnlyWrongCode])]
fn read_only(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = Multiplexer::new(object::IDENTITY, 1);
    let before = bench.read(multiplexer)?;
    let (attempt, _) = bench.block_download(multiplexer, &[0; 4], DownloadManner::right(&[0; 4]))?;
    bench.check(attempt.refused(Situation::ReadOnly))?;
    bench.expect_unchanged(multiplexer, &before)?;
    bench.expect_tidy()
}

/// A block download to an object that does not exist is refused with abort 0602 0000h, to a sub-index that does not
/// exist with abort 0609 0011h: at its start or at its end.
#[case(id = "301/sdo/block-download/missing", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       needs = [BlockDownload], catches = [SdoWrongCodeForNoObject, SdoWrongCodeForNoSubIndex],
       answers = [MissingObject, MissingEntry])]
fn missing(bench: &mut Bench<'_>) -> Judged {
    for (multiplexer, situation) in MISSING {
        let (attempt, _) = bench.block_download(multiplexer, &[0; 4], DownloadManner::right(&[0; 4]))?;
        bench.check(attempt.refused(situation))?;
    }
    bench.expect_tidy()
}

/// Strings with lengths around whole blocks can be written by block download and read back byte for byte.
#[case(id = "301/sdo/block-download/block-ends", clause = "CiA 301 7.2.4.3.9", confidence = Cited, level = Must,
       needs = [BlockDownload, LongScratch],
       catches = [SdoBlockPaddingKept, SdoBlockSegmentsEchoed, WatchdogResetUnderLoad])]
fn block_ends(bench: &mut Bench<'_>) -> Judged {
    // 127 segments of 7 bytes are the longest block.
    bench.each([1, 2, 3, 4, 5, 6, 7, 8, 13, 14, 15, 888, 889, 890], |bench, length| {
        let (multiplexer, value) = (bench.long_scratch()?, text(length));
        let (attempt, _) = bench.block_download(multiplexer, &value, DownloadManner::right(&value))?;
        if is_refused_length(attempt.abort()) || attempt.abort() == Some(AbortCode::OUT_OF_MEMORY) {
            return Ok(());
        }
        attempt.expect_confirmation()?;
        has_value(bench, multiplexer, &value)
    })
}

/// An abort of the client ends a block download in each phase: before the first segment, within a block, before the
/// end. The server does not answer it, the object keeps its value, and the next transfer works.
#[case(id = "301/sdo/block-download/client-abort", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       needs = [BlockDownload], catches = [SdoFirstBlockAbortIgnored, SdoAbortAnswered, SdoBlockAbortIgnored])]
fn client_abort(bench: &mut Bench<'_>) -> Judged {
    let scratch = subject(bench)?;
    let multiplexer = scratch.multiplexer;
    let places = [
        ("before the first segment", None),
        ("in a block", Some(segment(1, false, &scratch.other))),
        ("before the end", Some(segment(1, true, &scratch.other))),
    ];
    bench.each(places, |bench, (place, segment)| {
        begin(bench, &scratch)?;
        if let Some(segment) = segment {
            send_segment(bench, segment)?;
        }
        let abort = Request::abort(multiplexer, AbortCode::GENERAL);
        let reply = bench.send_unanswered(&abort, format!("abort of the client {place} of a block download"))?;
        bench.check(reply.expect_silence())?;
        let stray = bench.exchange(&Request::UploadSegment { toggle: false }, "a segment request after the abort")?;
        bench.check(demand(stray.abort().is_some() || stray.response.is_none(), || {
            let breach = Breach::new(multiplexer, format!("the transfer is over after an abort {place}"));
            breach.expected("an abort, or no answer").found(stray.observation()).told(stray.actual())
        }))?;
        bench.expect_unchanged(multiplexer, &scratch.value)
    })?;
    bench.expect_served("after block downloads that were aborted")?;
    bench.expect_tidy()
}
