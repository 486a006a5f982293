//! Transfers that a case performs message by message.

use crate::bench::Bench;
use crate::bench::objects::Scratch;
use crate::bench::sdo::Reply;
use crate::situation::Situation;
use crate::verdict::{Judged, Precondition, Reason, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::{Payload, Request, Response, Segment};

/// An object and a sub-index that no device has, each with its situation.
pub(super) const MISSING: [(Multiplexer, Situation); 2] = [
    (Multiplexer::new(0xFFFF, 0), Situation::MissingObject),
    (Multiplexer::new(object::DEVICE_TYPE, 1), Situation::MissingEntry),
];

/// An object whose upload takes at least two segments.
pub(in crate::cases::cia301) fn long_object(bench: &mut Bench<'_>) -> Result<Multiplexer, Stop> {
    bench.long_object(8)?.ok_or_else(|| {
        let reason =
            Reason::new("the device has an object that is read in segments", "more than 7 bytes", "none found");
        Stop::NotApplicable(reason)
    })
}

/// Starts a segmented upload.
pub(in crate::cases::cia301) fn begin_upload(bench: &mut Bench<'_>, multiplexer: Multiplexer) -> Judged {
    let reply = bench.exchange(&Request::upload(multiplexer), format!("upload of {multiplexer}"))?;
    let is_start = |response: &Response| {
        matches!(response, Response::InitiateUpload { multiplexer: named, payload } if *named == multiplexer
            && matches!(payload, Payload::Segmented(_) | Payload::SegmentedUnsized))
    };
    reply.expect("the start of a segmented upload", is_start).or_inconclusive()
}

/// Starts a segmented download to a scratch object, and announces the object's length.
pub(in crate::cases::cia301) fn begin_download(bench: &mut Bench<'_>, scratch: &Scratch) -> Judged {
    let multiplexer = scratch.multiplexer;
    bench.write(multiplexer, &scratch.value)?;
    let payload = Payload::Segmented(u32::try_from(scratch.value.len()).unwrap_or(u32::MAX));
    let request = Request::InitiateDownload { multiplexer, payload };
    let reply = bench.exchange(&request, format!("segmented download to {multiplexer}"))?;
    reply.expect("confirmation", |response| *response == Response::InitiateDownload { multiplexer }).or_inconclusive()
}

/// A download segment of up to seven bytes.
pub(super) fn segment(toggle: bool, data: &[u8], last: bool) -> Result<Request, Stop> {
    Segment::new(toggle, data, last).map(Request::DownloadSegment).ok_or_else(|| {
        Stop::Error(Reason::new("the tester builds a segment", "up to 7 bytes", format!("{}", data.len())))
    })
}

/// Sends a download segment whose confirmation the case does not test.
pub(super) fn confirmed_segment(bench: &mut Bench<'_>, toggle: bool, data: &[u8], last: bool) -> Judged {
    let reply = bench.exchange(&segment(toggle, data, last)?, "download segment")?;
    let is_right = |response: &Response| *response == Response::DownloadSegment { toggle };
    reply.expect("its confirmation", is_right).or_inconclusive()
}

/// Writes zeros in segments, and returns the answer that ends the transfer: a refusal may come at once or with the last
/// segment.
pub(super) fn in_segments(bench: &mut Bench<'_>, multiplexer: Multiplexer, bytes: u8) -> Result<Reply, Stop> {
    let request = Request::InitiateDownload { multiplexer, payload: Payload::Segmented(bytes.into()) };
    let what = format!("segmented download to {multiplexer}");
    let mut reply = bench.exchange(&request, what.clone())?;
    let is_begun = matches!(reply.response, Some(Response::InitiateDownload { .. }));
    let (mut rest, mut toggle) = (if is_begun { bytes } else { 0 }, false);
    while rest > 0 {
        let length = rest.min(7);
        rest -= length;
        let data = [0; 7];
        let next = segment(toggle, data.get(..usize::from(length)).unwrap_or(&data), rest == 0)?;
        reply = bench.exchange(&next, what.clone())?;
        if !matches!(reply.response, Some(Response::DownloadSegment { .. })) {
            break;
        }
        toggle = !toggle;
    }
    Ok(Reply { subject: multiplexer.into(), ..reply })
}

/// Requests the segments of an upload that follow the bytes `data`, and requires the whole value.
pub(super) fn finish_upload(
    bench: &mut Bench<'_>,
    multiplexer: Multiplexer,
    mut data: Vec<u8>,
    mut toggle: bool,
    right: &[u8],
) -> Judged {
    loop {
        let reply = bench.exchange(&Request::UploadSegment { toggle }, "request for the next segment of the upload")?;
        let is_next = |response: &Response| matches!(response, Response::UploadSegment(next) if next.toggle == toggle);
        reply.expect("the segment, with the toggle bit of its request", is_next)?;
        let Some(Response::UploadSegment(next)) = reply.response else { return Ok(()) };
        data.extend_from_slice(next.data());
        if next.last || data.len() > right.len() {
            break;
        }
        toggle = !toggle;
    }
    bench.expect_same(multiplexer, right, data, "the segments of an upload contain the whole value, each byte once")
}
