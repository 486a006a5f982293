//! Frames on the CAN-ID of SDO requests that are no SDO requests (CiA 301, 7.2.4.3).

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{self, Request};
use canvass_traces::{CanId, Frame, Record};

const DEVICE_TYPE: Multiplexer = Multiplexer::new(0x1000, 0);

fn request_id(bench: &Bench<'_>) -> u32 {
    u32::from(sdo::REQUEST_BASE) + u32::from(bench.node().raw())
}

/// What the SDO server sends after a frame.
fn answers_to(bench: &mut Bench<'_>, frame: Option<Frame>) -> Result<Vec<Record>, Stop> {
    bench.drain()?;
    if let Some(frame) = frame {
        bench.send(&frame)?;
    }
    let response = sdo::RESPONSE_BASE + u16::from(bench.node().raw());
    let heard = bench.listen(bench.timing().silence)?;
    Ok(heard.into_iter().filter(|record| record.frame.cob_id() == Some(response)).collect())
}

/// A server that was asked wrongly must still serve who asks rightly.
fn still_serves(bench: &mut Bench<'_>, after: &str) -> Judged {
    let mut attempt = bench.upload(DEVICE_TYPE)?;
    attempt.what = format!("{} after {after}", attempt.what);
    attempt.value()?;
    Ok(())
}

/// A remote frame with the CAN-ID of SDO requests is no request: it is not answered.
#[case(id = "301/sdo/frame/remote", clause = "CiA 301 7.2.4.3", confidence = Known, level = Must,
       catches = [SdoRemoteAnswered])]
fn remote(bench: &mut Bench<'_>) -> Judged {
    let frame = Frame::remote(CanId::standard_masked(request_id(bench)), 8);
    let answers = answers_to(bench, frame)?;
    demand(answers.is_empty(), || {
        let actual = answers.first().map(|record| record.frame.to_string()).unwrap_or_default();
        Reason::new("a remote frame on the CAN-ID of SDO requests is not answered", "silence", actual)
    })?;
    still_serves(bench, "a remote frame")
}

/// A 29-bit frame whose identifier ends like the CAN-ID of SDO requests is no request: it is not answered.
#[case(id = "301/sdo/frame/extended", clause = "CiA 301 7.2.4.3", confidence = Known, level = Must,
       catches = [SdoExtendedAnswered, ExtendedFrameObeyed])]
fn extended(bench: &mut Bench<'_>) -> Judged {
    let request = Request::upload(DEVICE_TYPE).to_frame(0);
    let frame = Frame::new(CanId::extended_masked(request_id(bench)), request.data());
    let answers = answers_to(bench, frame)?;
    demand(answers.is_empty(), || {
        let actual = answers.first().map(|record| record.frame.to_string()).unwrap_or_default();
        Reason::new("a 29-bit frame that looks like an SDO request is not answered", "silence", actual)
    })?;
    still_serves(bench, "a 29-bit frame")
}

/// Requests of fewer than eight bytes do no harm: the server answers the next right one.
///
/// What is to happen to the short ones themselves is not said: CANopenNode ignores them, lely-core refuses them,
/// others serve those that are long enough. What this device does is noted.
#[case(id = "301/sdo/frame/short", clause = "CiA 301 7.2.4.3", confidence = Known, level = Must,
       catches = [SdoShortRequestWedges])]
fn short(bench: &mut Bench<'_>) -> Judged {
    let whole = Request::upload(DEVICE_TYPE).to_frame(0);
    let mut answered = Vec::new();
    for length in 0..8 {
        let data = whole.data().get(..length).unwrap_or_default();
        let frame = Frame::new(CanId::standard_masked(request_id(bench)), data);
        if !answers_to(bench, frame)?.is_empty() {
            answered.push(length.to_string());
        }
        still_serves(bench, &format!("a request of {length} bytes"))?;
    }
    bench.note(match answered.is_empty() {
        true => "requests of fewer than eight bytes are ignored".to_owned(),
        false => format!("requests of so many bytes are answered: {}", answered.join(", ")),
    });
    Ok(())
}

/// A request to another node's SDO server is not answered.
#[case(id = "301/sdo/frame/other-node", clause = "CiA 301 7.2.4.3", confidence = Known, level = Must,
       catches = [SdoOtherNodeAnswered])]
fn other_node(bench: &mut Bench<'_>) -> Judged {
    let Some(other) = bench.vacant_neighbour() else {
        let reason = Reason::new("a node-ID beside that of the device is free", "one", "none");
        return Err(Stop::NotApplicable(reason));
    };
    let request = Request::upload(DEVICE_TYPE).to_frame(sdo::REQUEST_BASE + u16::from(other));
    let both = [sdo::RESPONSE_BASE + u16::from(other), sdo::RESPONSE_BASE + u16::from(bench.node().raw())];
    bench.drain()?;
    bench.send(&request)?;
    let answer = bench.wait_for(bench.timing().silence, |record| {
        record.frame.cob_id().is_some_and(|id| both.contains(&id)).then_some(record.frame)
    })?;
    bench.check(demand(answer.is_none(), || {
        let actual = answer.map(|frame| frame.to_string()).unwrap_or_default();
        Reason::new(format!("a request to node {other} is not answered"), "silence", actual)
    }))
}
