//! Frames with the CAN-ID of SDO requests that are not SDO requests (CiA 301, 7.2.4.3).

use crate::bench::Bench;
use crate::bench::sdo::DEVICE_TYPE;
use crate::case;
use crate::verdict::{Breach, Check, Judged, Reason, Stop, tried};
use canvass_analyzer::Service;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{self, Request};
use canvass_bus::observation::Observation;
use canvass_traces::{CanId, Frame};

fn request_id(bench: &Bench<'_>) -> u32 {
    u32::from(sdo::REQUEST_BASE) + u32::from(bench.node().raw())
}

/// The answer of the SDO server to a frame, if any.
fn answer_to(bench: &mut Bench<'_>, frame: Option<Frame>) -> Result<Option<Frame>, Stop> {
    bench.drain()?;
    if let Some(frame) = frame {
        bench.send(&frame)?;
    }
    let response = sdo::RESPONSE_BASE + u16::from(bench.node().raw());
    let heard = bench.listen(bench.silence())?;
    Ok(heard.into_iter().map(|record| record.frame).find(|frame| frame.cob_id() == Some(response)))
}

fn unanswered(answer: Option<Frame>, duty: &'static str) -> Check {
    let Some(answer) = answer else { return Ok(()) };
    let breach = Breach::new(Service::Sdo, duty).expected(Observation::Silence).found(Observation::Frame(answer));
    Err(Box::new(breach.told(answer.to_string())))
}

/// The server does not answer a remote frame with the CAN-ID of SDO requests: it is no request.
#[case(id = "301/sdo/frame/remote", clause = "CiA 301 7.2.4.3", confidence = Known, level = Should,
       catches = [SdoRemoteAnswered])]
fn remote(bench: &mut Bench<'_>) -> Judged {
    let frame = Frame::remote(CanId::standard_masked(request_id(bench)), 8);
    let answer = answer_to(bench, frame)?;
    bench.check(unanswered(answer, "a remote frame on the CAN-ID of SDO requests is not answered"))?;
    bench.expect_served("after a remote frame")
}

/// The server does not answer a 29-bit frame whose lower 11 bits are the CAN-ID of SDO requests: it is no request.
#[case(id = "301/sdo/frame/extended", clause = "CiA 301 7.3.3", confidence = Cited, level = Must,
       catches = [SdoExtendedAnswered, ExtendedFrameObeyed])]
fn extended(bench: &mut Bench<'_>) -> Judged {
    let request = Request::upload(DEVICE_TYPE).to_frame(0);
    let frame = Frame::new(CanId::extended_masked(request_id(bench)), request.data());
    let answer = answer_to(bench, frame)?;
    bench.check(unanswered(answer, "a 29-bit frame that looks like an SDO request is not answered"))?;
    bench.expect_served("after a 29-bit frame")
}

/// The server answers the next correct request after a request of fewer than eight bytes.
///
/// The standard does not define the handling of a short request: CANopenNode ignores it, lely-core refuses it, other
/// stacks execute it if it is long enough. The case notes the behaviour of the device.
#[case(id = "301/sdo/frame/short", clause = "CiA 301 7.2.4.3", confidence = Known, level = Should,
       catches = [SdoShortRequestWedges])]
fn short(bench: &mut Bench<'_>) -> Judged {
    let whole = Request::upload(DEVICE_TYPE).to_frame(0);
    let mut answered = Vec::new();
    for length in 0..8 {
        let data = whole.data().get(..length).unwrap_or_default();
        let frame = Frame::new(CanId::standard_masked(request_id(bench)), data);
        if answer_to(bench, frame)?.is_some() {
            answered.push(length.to_string());
        }
        bench.expect_served(&format!("after a request of {length} bytes"))?;
    }
    bench.note(match answered.is_empty() {
        true => "requests of fewer than eight bytes are ignored".to_owned(),
        false => format!("answered requests by length in bytes: {}", answered.join(", ")),
    });
    Ok(())
}

/// The server does not answer a request to the SDO server of another node.
#[case(id = "301/sdo/frame/other-node", clause = "CiA 301 7.3.3", confidence = Cited, level = Must,
       catches = [SdoOtherNodeAnswered])]
fn other_node(bench: &mut Bench<'_>) -> Judged {
    let Some(other) = bench.vacant_neighbour() else {
        let reason = Reason::new("a neighbouring node-ID is free", "one", "none");
        return Err(Stop::NotApplicable(reason));
    };
    // Silence proves something only if the server is present.
    tried(usize::from(bench.answers()?), "an answer to its own request")?;
    let request = Request::upload(DEVICE_TYPE).to_frame(sdo::REQUEST_BASE + u16::from(other));
    let both = [sdo::RESPONSE_BASE + u16::from(other), sdo::RESPONSE_BASE + u16::from(bench.node().raw())];
    bench.drain()?;
    bench.send(&request)?;
    let answer = bench.wait_for(bench.silence(), |record| {
        record.frame.cob_id().is_some_and(|id| both.contains(&id)).then_some(record.frame)
    })?;
    bench.check(unanswered(answer, "a request to another node is not answered"))
}
