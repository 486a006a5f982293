//! Inquiries (CiA 305, 6.5), and rules for all services.

use super::dialogue::{
    address, breach, configure, exchange, expect, expect_silence, node_ids, observed, parts, tell, wait,
};
use crate::bench::Bench;
use crate::case;
use crate::cases::layer_setting::expect_dialogue;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::lss::{self, Bound, Lss, Part, Request, Response};
use canvass_bus::observation::Observation;
use canvass_traces::Timestamp;

/// The slave answers inquiries in configuration, but not in waiting.
#[case(id = "305/waiting/inquiries", clause = "CiA 305 6.5", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssAnsweredWhileWaiting])]
fn in_waiting(bench: &mut Bench<'_>) -> Judged {
    let inquiries = Part::ALL.map(|part| Request::Inquire { part }).into_iter().chain([Request::InquireNodeId]);
    unanswered_in_waiting(bench, inquiries)
}

/// The slave does not answer the configuration services in waiting.
#[case(id = "305/waiting/configuration", clause = "CiA 305 6.4", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId, BitRate, Nvm], catches = [LssAnsweredWhileWaiting])]
fn configuration_in_waiting(bench: &mut Bench<'_>) -> Judged {
    let own = Request::ConfigureNodeId { node_id: bench.node().raw() };
    let bit_timing = Request::ConfigureBitTiming { table: 0, index: 5 };
    unanswered_in_waiting(bench, [own, bit_timing, Request::StoreConfiguration])
}

fn unanswered_in_waiting(bench: &mut Bench<'_>, requests: impl IntoIterator<Item = Request>) -> Judged {
    bench.each(requests, |bench, request| {
        let answer = tell(bench, request)?;
        bench.check(expect_silence(&format!("\"{request}\" in waiting"), answer))
    })?;
    // Silence proves something only if the slave is present.
    configure(bench)?;
    wait(bench)
}

/// In configuration the four inquiries return the parts of the LSS address, which are 1018h:01 to 1018h:04.
///
/// A slave that answers none of the four does not support them.
#[case(id = "305/inquiry/address", clause = "CiA 305 6.5.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssInquirySwapped])]
fn inquiry(bench: &mut Bench<'_>) -> Judged {
    let address = address(bench)?;
    configure(bench)?;
    let mut answers = Vec::new();
    for (part, right) in parts(address) {
        answers.push((part, right, exchange(bench, Request::Inquire { part })?));
    }
    wait(bench)?;
    if answers.iter().all(|(_, _, answer)| answer.is_none()) {
        let found = "in configuration it answers none of 5Ah to 5Dh";
        return Err(Stop::NotApplicable(Reason::new(
            "the slave supports the inquiries of its address",
            "5Ah to 5Dh",
            found,
        )));
    }
    bench.each(answers, |bench, (part, right, answer)| {
        let what = format!("the inquiry of the {}, as 1018h has it,", part.name());
        let expected = Observation::Number(right.into());
        bench.check(expect(&what, expected, answer, |answer| answer == Response::Part { part, value: right }))
    })
}

/// In configuration the inquiry of the node-ID returns the node-ID in use.
#[case(id = "305/inquiry/node-id", clause = "CiA 305 6.5.3", confidence = Attested, level = Must,
       needs = [Lss, LssInquiry, Alone], catches = [LssNodeIdInquiredWrong])]
fn inquiry_node_id(bench: &mut Bench<'_>) -> Judged {
    configure(bench)?;
    let answer = exchange(bench, Request::InquireNodeId)?;
    let own = bench.node().raw();
    let expected = Observation::Number(own.into());
    bench.check(expect("the inquiry of the node-ID", expected, answer, |answer| answer == Response::NodeId(own)))?;
    wait(bench)?;
    // The tester has inquired before, to see whether the slave is in configuration.
    let other = node_ids(bench, Timestamp::ZERO).into_iter().find(|node| *node != own);
    bench.check(demand(other.is_none(), || {
        let breach =
            breach("each inquiry of the node-ID returns the same node-ID").expected(Observation::Number(own.into()));
        breach.found(observed(other.map(Response::NodeId)))
    }))?;
    expect_dialogue::<Lss>(bench)
}

/// The slave does not answer command specifiers that CiA 305 does not define.
#[case(id = "305/reserved-commands", clause = "CiA 305", confidence = Unknown, level = Should,
       needs = [Lss, Alone], catches = [LssUnknownAnswered])]
fn reserved_commands(bench: &mut Bench<'_>) -> Judged {
    const RESERVED: [u8; 12] = [0x00, 0x05, 0x10, 0x12, 0x14, 0x16, 0x18, 0x3F, 0x4D, 0x52, 0x5F, 0xFF];
    configure(bench)?;
    bench.each(RESERVED, |bench, command| {
        let answer = tell(bench, Request::Unknown { command, tail: [0; 7] })?;
        bench.check(expect_silence(&format!("the reserved command {command:02X}h"), answer))
    })?;
    wait(bench)
}

/// Every request is answered once, by a response of eight bytes with the unused bytes 0.
#[case(id = "305/form", clause = "CiA 305", confidence = Unknown, level = Should,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssShortResponse])]
fn form(bench: &mut Bench<'_>) -> Judged {
    let address = address(bench)?;
    let own = bench.node().raw();
    // A slave may send only every second response in a wrong form.
    for _ in 0..2 {
        for dialogue in of_waiting(address) {
            bench.drain()?;
            for request in &dialogue {
                bench.send(&request.to_frame(lss::MASTER_CAN_ID))?;
            }
            bench.frames_of(lss::SLAVE_CAN_ID, bench.timing().silence)?;
            wait(bench)?;
        }
        configure(bench)?;
        let inquiries = Part::ALL.map(|part| Request::Inquire { part });
        let others = [Request::InquireNodeId, Request::ConfigureNodeId { node_id: own }];
        for request in inquiries.into_iter().chain(others) {
            exchange(bench, request)?;
        }
        wait(bench)?;
    }
    expect_dialogue::<Lss>(bench)
}

/// The requests that a slave with this address answers in waiting: selection, and identification within bounds.
fn of_waiting(address: [u32; 4]) -> [Vec<Request>; 2] {
    let [vendor, product, revision, serial] = address;
    let selected = parts(address).into_iter().map(|(part, value)| Request::SwitchSelective { part, value });
    let bounds = [vendor, product, revision, revision, serial, serial];
    let identified = Bound::ALL.into_iter().zip(bounds).map(|(bound, value)| Request::IdentifyRemote { bound, value });
    [selected.collect(), identified.collect()]
}

/// The case only records whether the slave answers an LSS request with fewer than eight bytes. LSS messages have eight
/// bytes; the standard does not define the handling of other lengths.
#[case(id = "305/short-request", clause = "CiA 305", confidence = Unknown, level = Open,
       needs = [Lss, Alone], catches = [LssShortRequestAnswered])]
fn short_request(bench: &mut Bench<'_>) -> Judged {
    configure(bench)?;
    let whole = Request::Inquire { part: Part::VendorId }.to_frame(lss::MASTER_CAN_ID);
    bench.each([1, 5, 7], |bench, len| {
        bench.drain()?;
        bench.send_bytes(lss::MASTER_CAN_ID, whole.data().get(..len).unwrap_or_default())?;
        let heard = bench.frames_of(lss::SLAVE_CAN_ID, bench.timing().silence)?;
        let answer = heard.first().and_then(|record| Response::read(record.frame.data()).ok());
        bench.check(expect_silence(&format!("an inquiry of {len} bytes"), answer))
    })?;
    wait(bench)
}

/// A device without LSS according to its description answers no LSS inquiry.
#[case(id = "305/not-supported", clause = "CiA 305", confidence = Unknown, level = Should,
       needs = [Description, Alone], catches = [LssUndescribed])]
fn not_supported(bench: &mut Bench<'_>) -> Judged {
    if bench.target().description.as_ref().is_some_and(|description| description.device.lss_supported) {
        let reason = Reason::new("the description says that the device has no LSS", "LSS_Supported=0", "1");
        return Err(Stop::NotApplicable(reason));
    }
    tell(bench, Request::SwitchGlobal { mode: 1 })?;
    let inquiries = Part::ALL.map(|part| Request::Inquire { part }).into_iter().chain([Request::InquireNodeId]);
    bench.each(inquiries, |bench, request| {
        let answer = tell(bench, request)?;
        bench.check(expect_silence(&format!("\"{request}\", where the description has no LSS"), answer))
    })?;
    tell(bench, Request::SwitchGlobal { mode: 0 })?;
    Ok(())
}
