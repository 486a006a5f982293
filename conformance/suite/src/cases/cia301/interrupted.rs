//! NMT commands in the middle of an SDO transfer: it dies in silence, and the next one begins afresh.

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::{Payload, Request, Response};

const DEVICE_TYPE: Multiplexer = Multiplexer::new(0x1000, 0);

/// Stop in the middle of a segmented upload ends it: the next segment is not answered, and after the start a new upload
/// gives the whole value.
#[case(id = "301/state/stopped/running-upload", clause = "CiA 301 7.3.2.2.5", confidence = Known, level = Must,
       needs = [SegmentedUpload], catches = [SdoAnsweredWhenStopped, SdoTransferSurvivesStop])]
fn stopped(bench: &mut Bench<'_>) -> Judged {
    let Some(multiplexer) = bench.long_object(8)? else {
        let reason = Reason::new("an object is read in segments", "more than 7 bytes", "none found");
        return Err(Stop::NotApplicable(reason));
    };
    let right = bench.read(multiplexer)?;
    let reply = bench.exchange(&Request::upload(multiplexer), format!("upload of {multiplexer}"))?;
    let is_start = |response: &Response| {
        matches!(response, Response::InitiateUpload { payload: Payload::Segmented(_) | Payload::SegmentedUnsized, .. })
    };
    reply.expect("the start of a segmented upload", is_start).or_inconclusive()?;
    bench.command(Command::STOP)?;
    bench.listen(bench.timing().reaction)?;
    let segment = Request::UploadSegment { toggle: false };
    bench.send_unanswered(&segment, "request for a segment in stopped")?.expect_silence()?;
    bench.command(Command::ENTER_PRE_OPERATIONAL)?;
    bench.listen(bench.timing().reaction)?;
    let reply = bench.exchange(&segment, "request for a segment of the upload from before")?;
    demand(reply.abort().is_some() || reply.response.is_none(), || {
        Reason::new("stop has ended the upload", "abort 0504 0001h or silence", reply.actual())
    })?;
    let value = bench.upload(multiplexer)?.value()?;
    bench.check(demand(value == right, || {
        Reason::new("a new upload gives the whole value", "the value of before", "another one")
    }))
}

/// Reset communication in the middle of a block download ends it: the device boots, the object has its value of
/// power-on, and a new transfer works.
#[case(id = "301/boot-up/running-download", clause = "CiA 301 7.3.2.1", confidence = Attested, level = Must,
       needs = [BlockDownload], catches = [SdoTransferSurvivesReset])]
fn reset(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2])?;
    let multiplexer = scratch.multiplexer;
    let size = u32::try_from(scratch.other.len()).ok();
    let request = Request::InitiateBlockDownload { multiplexer, crc: true, size };
    let reply = bench.exchange(&request, format!("block download to {multiplexer}"))?;
    reply
        .expect("the start of a block download", |response| matches!(response, Response::InitiateBlockDownload { .. }))
        .or_inconclusive()?;
    bench.command(Command::RESET_COMMUNICATION)?;
    let boot_up = bench.wait_for_boot_up()?;
    demand(boot_up.is_some() || bench.answers()?, || {
        Reason::new("the device starts after a reset in the middle of a transfer", "a boot-up message", "none")
    })?;
    bench.listen(bench.timing().reaction)?;
    let value = bench.upload(DEVICE_TYPE)?;
    value.value()?;
    bench.expect_unchanged(multiplexer, &scratch.value)
}
