//! Block upload (CiA 301, 7.2.4.3.12 to 7.2.4.3.16).

use super::by_hand::MISSING;
use crate::bench::Bench;
use crate::bench::sdo::DEVICE_TYPE;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::{AbortCode, Request, Response};
use canvass_bus::client::block_upload::UploadManner;
use canvass_bus::observation::Observation;

/// An object of several segments, and its value from a segmented upload.
fn subject(bench: &mut Bench<'_>) -> Result<(Multiplexer, Vec<u8>), Stop> {
    let Some(multiplexer) = bench.long_object(15)? else {
        let reason = Reason::new("an object fills several segments", "more than 14 bytes", "none found");
        return Err(Stop::NotApplicable(reason));
    };
    let value = bench.read(multiplexer)?;
    Ok((multiplexer, value))
}

/// Objects of one byte, of four bytes, and of several segments.
fn subjects(bench: &mut Bench<'_>) -> Result<Vec<Multiplexer>, Stop> {
    let mut found = bench.long_objects(5, 3)?;
    for short in [DEVICE_TYPE, Multiplexer::new(object::ERROR_REGISTER, 0), Multiplexer::new(object::IDENTITY, 1)] {
        if bench.has(short)? {
            found.push(short);
        }
    }
    Ok(found)
}

/// Uploads an object in blocks and requires the value from another upload.
fn gives(bench: &mut Bench<'_>, multiplexer: Multiplexer, right: &[u8], manner: UploadManner) -> Judged {
    let may_switch = manner.threshold > 0;
    let (attempt, client) = bench.block_upload(multiplexer, manner)?;
    if right.len() <= 4 && attempt.abort() == Some(AbortCode::COMMAND_SPECIFIER) {
        bench.note(format!("{multiplexer}, which is short, can't be read in blocks"));
        return Ok(());
    }
    let value = attempt.value()?;
    bench.check(demand(value == right, || {
        let breach = Breach::new(multiplexer, "a block upload returns the same value as a normal upload");
        breach.expected(Observation::Value(right.to_vec())).found(Observation::Value(value))
    }))?;
    bench.check(demand(may_switch || !client.switched, || {
        let breach =
            Breach::new(multiplexer, "a block upload without a protocol switch threshold stays a block upload");
        breach.expected("blocks").found(Observation::named("a switch to a normal upload"))
    }))
}

/// Uploads several objects in blocks.
fn all_give(bench: &mut Bench<'_>, manner: &UploadManner) -> Judged {
    let objects = subjects(bench)?;
    bench.each(objects, |bench, multiplexer| {
        let right = bench.read(multiplexer)?;
        gives(bench, multiplexer, &right, manner.clone())
    })?;
    bench.expect_tidy()
}

/// Uploads a value of several segments in blocks.
fn same_value(bench: &mut Bench<'_>, manner: UploadManner) -> Judged {
    let (multiplexer, right) = subject(bench)?;
    gives(bench, multiplexer, &right, manner)?;
    bench.expect_tidy()
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

/// A block upload without CRC returns the value: segments are numbered from 1, the last segment is marked, the number
/// of unused bytes and the announced size are correct, and the CRC is 0. The same holds after a block upload of another
/// object with CRC.
#[case(id = "301/sdo/block-upload/complete", clause = "CiA 301 7.2.4.3.15", confidence = Cited, level = Must,
       needs = [BlockUpload], catches = [SdoBlockLastLengthWrong, SdoBlockAnnouncedSizeWrong, SdoBlockEndUnmarked,
                                          SdoBlockCrcUnasked],
       cct = "2.19")]
fn complete(bench: &mut Bench<'_>) -> Judged {
    // The previous transfer had a CRC, whose remains must not affect a transfer without CRC.
    bench.block_upload(DEVICE_TYPE, UploadManner::default())?;
    all_give(bench, &UploadManner { crc: false, ..UploadManner::default() })
}

/// The end of a block upload with CRC carries the CRC-16 of the data (polynomial 1021h, start value 0).
#[case(id = "301/sdo/block-upload/crc", clause = "CiA 301 7.2.4.3.16", confidence = Cited, level = Must,
       needs = [BlockUpload], catches = [SdoBlockCrcStartWrong, SdoBlockCrcSwapped], cct = "2.23")]
fn crc(bench: &mut Bench<'_>) -> Judged {
    all_give(bench, &UploadManner::default())
}

/// Block uploads return strings of 1 to 8, 13 to 15 and 888 to 890 bytes byte for byte; these lengths lie around the
/// ends of segments and of the longest block.
#[case(id = "301/sdo/block-upload/lengths", clause = "CiA 301 7.2.4.3.15", confidence = Cited, level = Must,
       needs = [BlockUpload, LongScratch], catches = [SdoBlockLastLengthWrong, SdoBlockCrcStartWrong,
                                                       SdoBlockSevenEndsEmpty])]
fn lengths(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = bench.long_scratch()?;
    bench.each([1_usize, 2, 3, 4, 5, 6, 7, 8, 13, 14, 15, 888, 889, 890], |bench, length| {
        let value: Vec<u8> = (0..length).map(|n| b'a' + (n % 26) as u8).collect();
        if bench.download(multiplexer, &value)?.abort().is_some() {
            // The description does not give the maximum length of a string.
            return Ok(());
        }
        let right = bench.read(multiplexer)?;
        for block_size in [127, 1] {
            gives(
                bench,
                multiplexer,
                &right,
                UploadManner { block_sizes: vec![block_size], ..UploadManner::default() },
            )?;
        }
        Ok(())
    })?;
    bench.expect_tidy()
}

/// Each block has the number of segments that the client requests (1, then 2, then 127), and begins with sequence
/// number 1.
#[case(id = "301/sdo/block-upload/block-size", clause = "CiA 301 7.2.4.3.14", confidence = Cited, level = Must,
       needs = [BlockUpload], catches = [SdoBlockNewSizeIgnored, SdoBlockNumbersContinue])]
fn block_size(bench: &mut Bench<'_>) -> Judged {
    same_value(bench, UploadManner { block_sizes: vec![1, 2, 127], ..UploadManner::default() })
}

/// Block sizes of 0 and above 127 are refused with abort 0504 0002h.
#[case(id = "301/sdo/block-upload/wrong-block-size", clause = "CiA 301 7.2.4.3.13", confidence = Cited, level = Should,
       needs = [BlockUpload], catches = [SdoBlockSizeUnchecked, SdoBlockSizeWrongCode], cct = "2.26")]
fn wrong_block_size(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, _) = subject(bench)?;
    for size in [0, 128, 255] {
        let what = format!("block upload with blocks of {size} segments");
        let reply = bench.exchange(&initiate(multiplexer, size), what)?;
        bench.check(reply.refused(Situation::BlockSize))?;
        if reply.abort().is_none() {
            bench.send_request(&Request::abort(multiplexer, AbortCode::GENERAL))?;
        }
    }
    bench.expect_served("after block uploads with wrong block sizes")?;
    bench.expect_tidy()
}

/// A confirmation that requests blocks of 0 or more than 127 segments is refused with abort 0504 0002h.
#[case(id = "301/sdo/block-upload/wrong-next-size", clause = "CiA 301 7.2.4.3.14", confidence = Cited, level = Should,
       needs = [BlockUpload], catches = [SdoBlockSizeUnchecked, SdoBlockSizeWrongCode])]
fn wrong_next_size(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, _) = subject(bench)?;
    for size in [0, 128] {
        let manner = UploadManner { block_sizes: vec![1, size], ..UploadManner::default() };
        let (mut attempt, _) = bench.block_upload(multiplexer, manner)?;
        attempt.what = format!("next block of {size} segments");
        bench.check(attempt.refused(Situation::BlockSize))?;
    }
    bench.expect_tidy()
}

/// The server repeats a block of which the client confirms no segment.
#[case(id = "301/sdo/block-upload/all-lost", clause = "CiA 301 7.2.4.3.14", confidence = Cited, level = Must,
       needs = [BlockUpload], catches = [SdoBlockConfirmationIgnored])]
fn all_lost(bench: &mut Bench<'_>) -> Judged {
    same_value(bench, UploadManner { block_sizes: vec![2], lose_after: Some((0, 0)), ..UploadManner::default() })
}

/// When the client does not confirm all segments of a block, the next block begins with the first segment that was not
/// confirmed.
#[case(id = "301/sdo/block-upload/part-lost", clause = "CiA 301 7.2.4.1", confidence = Cited, level = Must,
       needs = [BlockUpload], catches = [SdoBlockRepeatsAll, SdoBlockConfirmationIgnored])]
fn part_lost(bench: &mut Bench<'_>) -> Judged {
    same_value(bench, UploadManner { block_sizes: vec![3], lose_after: Some((0, 1)), ..UploadManner::default() })
}

/// A confirmation of segments that were not sent is refused with abort 0504 0003h.
#[case(id = "301/sdo/block-upload/too-much-confirmed", clause = "CiA 301 7.2.4.3.14", confidence = Cited,
       level = Should, needs = [BlockUpload], catches = [SdoBlockConfirmationUnchecked], cct = "2.27")]
fn too_much_confirmed(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, _) = subject(bench)?;
    let manner = UploadManner { block_sizes: vec![1], confirm: Some((0, 5)), ..UploadManner::default() };
    let (mut attempt, _) = bench.block_upload(multiplexer, manner)?;
    attempt.what = "confirmation of segment 5 of a block of one".to_owned();
    bench.check(attempt.refused(Situation::SequenceNumber))?;
    bench.expect_tidy()
}

/// The server returns a value that is shorter than the protocol switch threshold by a block upload or by a normal
/// upload, with the same result.
#[case(id = "301/sdo/block-upload/switch", clause = "CiA 301 7.2.4.3.13", confidence = Cited, level = Must,
       needs = [BlockUpload], catches = [SdoBlockSwitchTruncates])]
fn switch(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, right) = subject(bench)?;
    let manner = UploadManner { threshold: 255, ..UploadManner::default() };
    let (attempt, client) = bench.block_upload(multiplexer, manner)?;
    let value = attempt.value()?;
    bench.check(demand(value == right, || {
        let breach =
            Breach::new(multiplexer, "a block upload returns the value, whether it switches to a normal upload or not");
        breach.expected(Observation::Value(right)).found(Observation::Value(value))
    }))?;
    bench.note(match client.switched {
        true => "with a threshold of 255 the server switches to a normal upload",
        false => "the server does not switch to a normal upload",
    });
    bench.expect_tidy()
}

/// The server answers a request that follows directly after the end of a block upload.
#[case(id = "301/sdo/block-upload/next-request", clause = "CiA 301 7.2.4.3.15", confidence = Cited, level = Must,
       needs = [BlockUpload], catches = [SdoDeafAfterBlockUpload])]
fn next_request(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, _) = subject(bench)?;
    for _ in 0..3 {
        bench.block_upload(multiplexer, UploadManner::default())?.0.value().or_inconclusive()?;
        bench.expect_served("directly after a block upload")?;
    }
    Ok(())
}

/// The server answers a new transfer when the client has not confirmed the end of a block upload. The standard leaves
/// the behaviour open: only the confirmation and an abort end the service.
#[case(id = "301/sdo/block-upload/end-missing", clause = "CiA 301 7.2.4.3.12", confidence = Cited, level = Open,
       needs = [BlockUpload], catches = [SdoBusyAfterAbandonedBlock])]
fn end_missing(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, right) = subject(bench)?;
    let (attempt, _) = bench.block_upload(multiplexer, UploadManner { no_end: true, ..UploadManner::default() })?;
    attempt.value().or_inconclusive()?;
    let next = bench.upload(multiplexer)?.under("after a block upload without end").value();
    give_up(bench, multiplexer)?;
    bench.check(next.and_then(|value| {
        demand(value == right, || {
            let breach = Breach::new(multiplexer, "the object can be read after a block upload without end");
            breach.expected(Observation::Value(right)).found(Observation::Value(value))
        })
    }))
}

/// The server answers a new request during a block upload. The standard leaves the behaviour open: only the last
/// segment and an abort end the sequence.
#[case(id = "301/sdo/block-upload/restart", clause = "CiA 301 7.2.4.3.12", confidence = Cited, level = Open,
       needs = [BlockUpload], catches = [SdoBusyAfterAbandonedBlock])]
fn restart(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, _) = subject(bench)?;
    begin(bench, multiplexer, 1)?;
    bench.exchange(&Request::StartBlockUpload, "start of the block upload")?;
    let served = bench.expect_served("in the middle of a block upload");
    give_up(bench, multiplexer)?;
    served?;
    same_value(bench, UploadManner::default())
}

/// Ends a transfer that the case has left unfinished.
fn give_up(bench: &mut Bench<'_>, multiplexer: Multiplexer) -> Judged {
    bench.send_request(&Request::abort(multiplexer, AbortCode::GENERAL))?;
    bench.listen(bench.timing().reaction).map(|_| ())
}

/// An abort of the client ends a block upload in each phase, and the server does not answer it.
#[case(id = "301/sdo/block-upload/client-abort", clause = "CiA 301 7.2.4.3.12", confidence = Cited, level = Must,
       needs = [BlockUpload], catches = [SdoAbortAnswered])]
fn client_abort(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, right) = subject(bench)?;
    let abort = Request::abort(multiplexer, AbortCode::GENERAL);
    begin(bench, multiplexer, 1)?;
    let reply = bench.send_unanswered(&abort, "abort of the client before the first block")?;
    bench.check(reply.expect_silence())?;
    begin(bench, multiplexer, 1)?;
    bench.exchange(&Request::StartBlockUpload, "start of the block upload")?;
    let reply = bench.send_unanswered(&abort, "abort of the client after the first block")?;
    bench.check(reply.expect_silence())?;
    bench.expect_value(multiplexer, &right, "a normal upload works after block uploads that were aborted")?;
    bench.expect_tidy()
}

/// A block upload of an object that does not exist is refused with abort 0602 0000h, of a sub-index that does not exist
/// with abort 0609 0011h.
#[case(id = "301/sdo/block-upload/missing", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       needs = [BlockUpload], catches = [SdoWrongCodeForNoObject, SdoWrongCodeForNoSubIndex],
       answers = [MissingObject, MissingEntry])]
fn missing(bench: &mut Bench<'_>) -> Judged {
    for (multiplexer, situation) in MISSING {
        let reply = bench.exchange(&initiate(multiplexer, 127), format!("block upload of {multiplexer}"))?;
        bench.check(reply.refused(situation))?;
    }
    bench.expect_tidy()
}
