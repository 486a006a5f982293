//! NMT commands in the middle of an SDO transfer.

use super::sdo::by_hand::{begin_upload, long_object};
use crate::bench::Bench;
use crate::bench::sdo::DEVICE_TYPE;
use crate::case;
use crate::verdict::{Breach, Check, Judged, Precondition, Stop, demand};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::{self, AbortCode, Request, Response};
use canvass_analyzer::{Multiplexer, Service};
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::{Record, Timestamp};

/// The request for the next segment of the upload that the cases interrupt.
const NEXT: Request = Request::UploadSegment { toggle: false };

/// Begins a segmented upload, stops the device, asks for a segment in vain, and makes the device pre-operational again.
/// Returns the object and its value.
fn stop_in_upload(bench: &mut Bench<'_>) -> Result<(Multiplexer, Vec<u8>), Stop> {
    let multiplexer = long_object(bench)?;
    let right = bench.read(multiplexer)?;
    begin_upload(bench, multiplexer)?;
    bench.command(Command::STOP)?;
    bench.listen(bench.timing().reaction)?;
    let reply = bench.send_unanswered(&NEXT, "request for a segment in stopped")?;
    bench.check(reply.expect_silence())?;
    bench.command(Command::ENTER_PRE_OPERATIONAL)?;
    // The server must not have kept the request, to answer it now.
    let response_id = sdo::RESPONSE_BASE + u16::from(bench.node().raw());
    let heard = bench.listen(bench.silence())?;
    let late = heard.into_iter().map(|record| record.frame).find(|frame| frame.cob_id() == Some(response_id));
    bench.check(late.map_or(Ok(()), |frame| {
        let breach = Breach::new(
            Service::Sdo,
            "a request that was sent in stopped stays unanswered after the device has left stopped",
        );
        Err(Box::new(breach.expected(Observation::Silence).found(Observation::Frame(frame))))
    }))?;
    Ok((multiplexer, right))
}

/// Stop remote node ends the SDO service during a segmented upload: the device does not answer the next segment
/// request, not even after it has left stopped, and a new upload returns the whole value.
#[case(id = "301/state/stopped/running-upload", clause = "CiA 301 7.3.2.2.5", confidence = Cited, level = Must,
       needs = [SegmentedUpload], catches = [SdoAnsweredWhenStopped])]
fn stopped(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, right) = stop_in_upload(bench)?;
    bench.expect_again(multiplexer, &right, "a new upload returns the whole value")
}

/// Stop remote node ends a segmented upload: a request for its next segment is refused with abort 0504 0001h, or not
/// answered. The standard does not list stop remote node among the events that end a transfer.
#[case(id = "301/state/stopped/upload-ends", clause = "CiA 301 7.2.4.3.5", confidence = Cited, level = Open,
       needs = [SegmentedUpload], catches = [SdoTransferSurvivesStop])]
fn upload_ends(bench: &mut Bench<'_>) -> Judged {
    let (multiplexer, _) = stop_in_upload(bench)?;
    let reply = bench.exchange(&NEXT, "request for a segment of the interrupted upload")?;
    bench.check(demand(reply.abort().is_some() || reply.response.is_none(), || {
        let breach = Breach::new(multiplexer, "stop has ended the upload").expected("abort 0504 0001h or no answer");
        breach.found(reply.observation()).told(reply.actual())
    }))
}

/// Reset communication ends a block download: the device starts, the object has its power-on value, and a new transfer
/// works.
#[case(id = "301/boot-up/running-download", clause = "CiA 301 7.3.2.2.1", confidence = Cited, level = Must,
       needs = [BlockDownload], catches = [SdoTransferSurvivesReset, SdoBlockDownloadRefused])]
fn reset(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[4, 2])?;
    let multiplexer = scratch.multiplexer;
    let size = u32::try_from(scratch.other.len()).ok();
    let request = Request::InitiateBlockDownload { multiplexer, crc: true, size };
    let reply = bench.exchange(&request, format!("block download to {multiplexer}"))?;
    reply
        .expect("the start of a block download", |response| matches!(response, Response::InitiateBlockDownload { .. }))
        .or_inconclusive()?;
    let arrived = bench.now() + bench.timing().reaction;
    bench.command(Command::RESET_COMMUNICATION)?;
    let boot_up = bench.wait_for_boot_up()?;
    demand(boot_up.is_some() || bench.answers()?, || {
        Breach::new(Subject::Device, "the device starts after a reset in the middle of a transfer")
            .expected(Observation::BootUp)
            .found(Observation::Silence)
    })?;
    bench.listen(bench.timing().reaction)?;
    bench.check(nothing_since(bench, arrived, boot_up))?;
    bench.upload(DEVICE_TYPE)?.under("after a reset in the middle of a transfer").value()?;
    bench.expect_unchanged(multiplexer, &scratch.value)
}

/// Requires that the server sends nothing about a transfer that a reset has ended. After the boot-up message, any
/// message about the transfer is a breach. Before it, only an abort for a timeout is a breach, because it shows that
/// the server continued the transfer: the server may abort the transfer before it resets.
fn nothing_since(bench: &Bench<'_>, arrived: Timestamp, booted: Option<Timestamp>) -> Check {
    let [requests, responses] =
        [sdo::REQUEST_BASE, sdo::RESPONSE_BASE].map(|base| base + u16::from(bench.node().raw()));
    let since = bench.evidence().frames().map(|exhibit| &exhibit.record).filter(|record| record.timestamp > arrived);
    // If the boot-up message is missing, the tester has sent a request meanwhile.
    let unasked = since.take_while(|record| record.frame.cob_id() != Some(requests));
    let mut said = unasked.filter(|record| record.frame.cob_id() == Some(responses));
    let response = said.find(|record| survives(record, booted)).map(|record| record.frame);
    demand(response.is_none(), || {
        let found = response.map_or(Observation::Silence, Observation::Frame);
        let breach = Breach::new(Service::Sdo, "a reset ends a transfer, and no message of it follows");
        breach.expected(Observation::Silence).found(found)
    })
}

/// Whether a frame of the server after the reset shows that the transfer still exists.
fn survives(record: &Record, booted: Option<Timestamp>) -> bool {
    let response = Response::read(record.frame.data());
    let is_late = matches!(response, Ok(Response::Abort(abort)) if abort.code == AbortCode::TIMEOUT);
    is_late || booted.is_some_and(|booted| record.timestamp > booted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_traces::{ChannelId, Duration};

    fn after(millis: u64) -> Timestamp {
        Timestamp::ZERO + Duration::from_millis(millis)
    }

    fn abort(code: AbortCode, millis: u64) -> Record {
        let frame = Response::abort(Multiplexer::new(0x2010, 0), code).to_frame(0x58B);
        Record::new(after(millis), ChannelId::default(), frame)
    }

    #[test]
    fn an_abort_before_the_boot_up_is_the_devices_own_matter() {
        let booted = Some(after(500));
        assert!(!survives(&abort(AbortCode::GENERAL, 200), booted));
        assert!(!survives(&abort(AbortCode::GENERAL, 200), None));
        assert!(survives(&abort(AbortCode::GENERAL, 600), booted));
    }

    #[test]
    fn a_time_out_shows_that_the_transfer_went_on() {
        assert!(survives(&abort(AbortCode::TIMEOUT, 200), Some(after(500))));
        assert!(survives(&abort(AbortCode::TIMEOUT, 200), None));
    }
}
