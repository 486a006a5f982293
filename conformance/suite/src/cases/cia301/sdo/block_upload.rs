//! Block upload (CiA 301, 7.2.4.3.12 to 7.2.4.3.15).

use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{AbortCode, Request, Response};
use canvass_bus::client::block_upload::UploadManner;
use canvass_bus::client::sdo::Bytes;

const DEVICE_TYPE: Multiplexer = Multiplexer::new(0x1000, 0);

/// An object of several segments, and its value as a segmented upload gives it.
fn subject(bench: &mut Bench<'_>) -> Result<(Multiplexer, Vec<u8>), Stop> {
    let Some(multiplexer) = bench.long_object(15)? else {
        let reason = Reason::new("an object fills several segments", "more than 14 bytes", "none found");
        return Err(Stop::NotApplicable(reason));
    };
    let value = bench.read(multiplexer)?;
    Ok((multiplexer, value))
}

/// Reads in blocks and demands the value that a segmented upload gave.
fn same_value(bench: &mut Bench<'_>, manner: UploadManner) -> Judged {
    let (multiplexer, right) = subject(bench)?;
    let (attempt, client) = bench.block_upload(multiplexer, manner)?;
    let value = attempt.value()?;
    bench.check(demand(value == right && !client.switched, || {
        let duty = format!("the block upload of {multiplexer} gives what the segmented one gave");
        Reason::new(duty, Bytes(&right).to_string(), Bytes(&value).to_string())
    }))
}

fn initiate(multiplexer: Multiplexer, block_size: u8) -> Request {
    Request::InitiateBlockUpload { multiplexer, crc: true, block_size, threshold: 0 }
}

/// Starts a block upload by hand, up to its announcement.
fn begin(bench: &mut Bench<'_>, multiplexer: Multiplexer, block_size: u8) -> Result<(), Stop> {
    let reply = bench.exchange(&initiate(multiplexer, block_size), format!("block upload of {multiplexer}"))?;
    let is_start = |response: &Response| matches!(response, Response::InitiateBlockUpload { .. });
    reply.expect("the start of a block upload", is_start).or_inconclusive()
}

/// A block upload without CRC delivers the value: segments numbered from 1, the last one marked, the unused bytes counted,
/// the size as announced.
#[case(id = "301/sdo/block-upload/complete", clause = "CiA 301 7.2.4.3.13", confidence = Known, level = Must,
       needs = [BlockUpload], catches = [SdoBlockLastLengthWrong, SdoBlockAnnouncedSizeWrong, SdoBlockEndUnmarked],
       cct = "2.19")]
fn complete(bench: &mut Bench<'_>) -> Judged {
    same_value(bench, UploadManner { crc: false, ..UploadManner::default() })
}

/// With CRC the end of a block upload carries the CRC-16 of the data: polynomial 1021h, start value 0.
#[case(id = "301/sdo/block-upload/crc", clause = "CiA 301 7.2.4.3.16", confidence = Attested, level = Must,
       needs = [BlockUpload], catches = [SdoBlockCrcStartWrong, SdoBlockCrcSwapped], cct = "2.23")]
fn crc(bench: &mut Bench<'_>) -> Judged {
    same_value(bench, UploadManner::default())
}

/// Blocks have as many segments as the client asks for: one, two, then as many as it likes; each begins with number 1.
#[case(id = "301/sdo/block-upload/block-size", clause = "CiA 301 7.2.4.3.14", confidence = Known, level = Must,
       needs = [BlockUpload], catches = [SdoBlockNewSizeIgnored, SdoBlockNumbersContinue])]
fn block_size(bench: &mut Bench<'_>) -> Judged {
    same_value(bench, UploadManner { block_sizes: vec![1, 2, 127], ..UploadManner::default() })
}

/// Block sizes of 0 and above 127 are refused with abort 0504 0002h.
#[case(id = "301/sdo/block-upload/wrong-block-size", clause = "CiA 301 7.2.4.3.13", confidence = Known, level = Must,
       needs = [BlockUpload], catches = [SdoBlockSizeUnchecked, SdoBlockSizeWrongCode], cct = "2.26")]
fn wrong_block_size(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, _) = subject(bench)?;
    for size in [0, 128, 255] {
        let what = format!("block upload with blocks of {size} segments");
        let reply = bench.exchange(&initiate(multiplexer, size), what)?;
        bench.check(reply.refused(Situation::BlockSize))?;
    }
    bench.upload(DEVICE_TYPE)?.value()?;
    Ok(())
}

/// A confirmation that asks for blocks of 0 or more than 127 segments is refused with abort 0504 0002h.
#[case(id = "301/sdo/block-upload/wrong-next-size", clause = "CiA 301 7.2.4.3.14", confidence = Known, level = Should,
       needs = [BlockUpload], catches = [SdoBlockSizeUnchecked, SdoBlockSizeWrongCode])]
fn wrong_next_size(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, _) = subject(bench)?;
    for size in [0, 128] {
        let manner = UploadManner { block_sizes: vec![1, size], ..UploadManner::default() };
        let (mut attempt, _) = bench.block_upload(multiplexer, manner)?;
        attempt.what = format!("next block of {size} segments");
        bench.check(attempt.refused(Situation::BlockSize))?;
    }
    Ok(())
}

/// A block of which nothing is confirmed comes again.
#[case(id = "301/sdo/block-upload/all-lost", clause = "CiA 301 7.2.4.3.14", confidence = Known, level = Must,
       needs = [BlockUpload], catches = [SdoBlockConfirmationIgnored])]
fn all_lost(bench: &mut Bench<'_>) -> Judged {
    same_value(bench, UploadManner { block_sizes: vec![2], lose_after: Some((0, 0)), ..UploadManner::default() })
}

/// After a segment that is not confirmed the next block begins with it, not with the block's first.
#[case(id = "301/sdo/block-upload/part-lost", clause = "CiA 301 7.2.4.3.14", confidence = Known, level = Must,
       needs = [BlockUpload], catches = [SdoBlockRepeatsAll, SdoBlockConfirmationIgnored])]
fn part_lost(bench: &mut Bench<'_>) -> Judged {
    same_value(bench, UploadManner { block_sizes: vec![3], lose_after: Some((0, 1)), ..UploadManner::default() })
}

/// A confirmation of segments that were not sent is refused with abort 0504 0003h.
#[case(id = "301/sdo/block-upload/too-much-confirmed", clause = "CiA 301 7.2.4.3.14", confidence = Known,
       level = Should, needs = [BlockUpload], catches = [SdoBlockConfirmationUnchecked], cct = "2.27")]
fn too_much_confirmed(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, _) = subject(bench)?;
    let manner = UploadManner { block_sizes: vec![1], confirm: Some((0, 5)), ..UploadManner::default() };
    let (mut attempt, _) = bench.block_upload(multiplexer, manner)?;
    attempt.what = "confirmation of segment 5 of a block of one".to_owned();
    bench.check(attempt.refused(Situation::SequenceNumber))
}

/// A value that is shorter than the protocol switch threshold comes by a block upload or by a normal one, and is the same.
#[case(id = "301/sdo/block-upload/switch", clause = "CiA 301 7.2.4.3.13", confidence = Known, level = Must,
       needs = [BlockUpload], catches = [SdoBlockSwitchTruncates])]
fn switch(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, right) = subject(bench)?;
    let manner = UploadManner { threshold: 255, ..UploadManner::default() };
    let (attempt, client) = bench.block_upload(multiplexer, manner)?;
    let value = attempt.value()?;
    demand(value == right, || {
        let duty = format!("the upload of {multiplexer} gives the value, switched or not");
        Reason::new(duty, Bytes(&right).to_string(), Bytes(&value).to_string())
    })?;
    bench.note(match client.switched {
        true => "with a threshold of 255 the server switches to a normal upload",
        false => "the server does not switch to a normal upload",
    });
    Ok(())
}

/// After a client that does not confirm the end of a block upload the next transfer works.
#[case(id = "301/sdo/block-upload/end-missing", clause = "CiA 301 7.2.4.3.15", confidence = Known, level = Must,
       needs = [BlockUpload], catches = [SdoBusyAfterAbandonedBlock])]
fn end_missing(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, right) = subject(bench)?;
    let (attempt, _) = bench.block_upload(multiplexer, UploadManner { no_end: true, ..UploadManner::default() })?;
    attempt.value().or_inconclusive()?;
    let mut next = bench.upload(multiplexer)?;
    next.what = format!("{} after a block upload without end", next.what);
    let value = next.value()?;
    bench.check(demand(value == right, || {
        let duty = format!("{multiplexer} can be read after a block upload without end");
        Reason::new(duty, Bytes(&right).to_string(), Bytes(&value).to_string())
    }))
}

/// A block upload that is begun again from the start gives the value; nothing is left of the one before.
#[case(id = "301/sdo/block-upload/restart", clause = "CiA 301 7.2.4.3.13", confidence = Known, level = Must,
       needs = [BlockUpload], catches = [SdoBusyAfterAbandonedBlock])]
fn restart(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, _) = subject(bench)?;
    begin(bench, multiplexer, 1)?;
    bench.exchange(&Request::StartBlockUpload, "start of the block upload")?;
    let mut other = bench.upload(DEVICE_TYPE)?;
    other.what = format!("{} in the middle of a block upload", other.what);
    other.value()?;
    same_value(bench, UploadManner::default())
}

/// An abort of the client in any phase of a block upload is not answered and ends it.
#[case(id = "301/sdo/block-upload/client-abort", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Must,
       needs = [BlockUpload], catches = [SdoAbortAnswered])]
fn client_abort(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, _) = subject(bench)?;
    let abort = Request::abort(multiplexer, AbortCode::GENERAL);
    begin(bench, multiplexer, 1)?;
    bench.send_unanswered(&abort, "abort of the client before the first block")?.expect_silence()?;
    begin(bench, multiplexer, 1)?;
    bench.exchange(&Request::StartBlockUpload, "start of the block upload")?;
    bench.send_unanswered(&abort, "abort of the client after the first block")?.expect_silence()?;
    bench.upload(multiplexer)?.value()?;
    Ok(())
}

/// A block upload of an object that does not exist is refused with abort 0602 0000h, of a sub-index with 0609 0011h.
#[case(id = "301/sdo/block-upload/missing", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Must,
       needs = [BlockUpload], catches = [SdoWrongCodeForNoObject, SdoWrongCodeForNoSubIndex])]
fn missing(bench: &mut Bench<'_>) -> Judged {
    for (multiplexer, code) in
        [(Multiplexer::new(0xFFFF, 0), AbortCode::NO_OBJECT), (Multiplexer::new(0x1000, 1), AbortCode::NO_SUB_INDEX)]
    {
        let reply = bench.exchange(&initiate(multiplexer, 127), format!("block upload of {multiplexer}"))?;
        bench.check(reply.refused_with(&[code], &[AbortCode::GENERAL]))?;
    }
    Ok(())
}
