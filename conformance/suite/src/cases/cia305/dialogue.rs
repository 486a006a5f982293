//! What all LSS cases need: messages out and in, states reached and proven.

use crate::bench::Bench;
use crate::verdict::{Check, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::lss::{self, Part, Request, Response};
use canvass_traces::Frame;

/// Sends a message and waits for the slave's response.
pub fn exchange(bench: &mut Bench<'_>, request: Request) -> Result<Option<Response>, Stop> {
    exchange_frame(bench, &request.to_frame(lss::MASTER_CAN_ID))
}

/// Sends a frame, however wrong, and waits for the slave's response.
pub fn exchange_frame(bench: &mut Bench<'_>, frame: &Frame) -> Result<Option<Response>, Stop> {
    bench.drain()?;
    bench.send(frame)?;
    bench.wait_for(bench.timing().silence, |record| {
        let is_slave = record.frame.cob_id() == Some(lss::SLAVE_CAN_ID);
        is_slave.then(|| Response::read(record.frame.data()).ok()).flatten()
    })
}

pub fn shown(response: Option<Response>) -> String {
    response.map_or_else(|| "no answer".to_owned(), |response| response.to_string())
}

/// Demands a response.
pub fn expect(what: &str, expected: &str, found: Option<Response>, right: impl FnOnce(Response) -> bool) -> Check {
    demand(found.is_some_and(right), || Reason::new(format!("{what} is answered"), expected, shown(found)))
}

/// Demands silence.
pub fn expect_silence(what: &str, found: Option<Response>) -> Check {
    demand(found.is_none(), || Reason::new(format!("{what} is not answered"), "silence", shown(found)))
}

/// The node-ID that the slave gives; `None` if it is in waiting.
pub fn node_id(bench: &mut Bench<'_>) -> Result<Option<u8>, Stop> {
    Ok(match exchange(bench, Request::InquireNodeId)? {
        Some(Response::NodeId(node)) => Some(node),
        _ => None,
    })
}

/// Brings the slave into configuration and proves it by an inquiry.
pub fn configure(bench: &mut Bench<'_>) -> Result<(), Stop> {
    exchange(bench, Request::SwitchGlobal { mode: 1 })?;
    let node = exchange(bench, Request::InquireNodeId)?;
    let reason = || Reason::new("in configuration the slave answers inquiries", "its node-ID", shown(node));
    bench.check(demand(matches!(node, Some(Response::NodeId(_))), reason)).or_inconclusive()
}

/// Ends configuration. What was pending may make the device restart.
pub fn wait(bench: &mut Bench<'_>) -> Result<(), Stop> {
    bench.watch_restart();
    exchange(bench, Request::SwitchGlobal { mode: 0 }).map(|_| ())
}

/// Demands that the slave is in configuration or in waiting.
pub fn expect_configuration(bench: &mut Bench<'_>, after: &str) -> Judged {
    let node = node_id(bench)?;
    bench.check(demand(node.is_some(), || {
        Reason::new(format!("the slave is in configuration after {after}"), "an answer", "none")
    }))
}

/// As [`expect_configuration`].
pub fn expect_waiting(bench: &mut Bench<'_>, after: &str) -> Judged {
    let node = node_id(bench)?;
    bench.check(demand(node.is_none(), || {
        Reason::new(format!("the slave is in waiting after {after}"), "no answer", "its node-ID")
    }))
}

/// The LSS address by SDO: 1018h:01 to 04.
pub fn address(bench: &mut Bench<'_>) -> Result<[u32; 4], Stop> {
    let mut address = [0; 4];
    for (sub, part) in (1..).zip(&mut address) {
        *part = bench.read_number(Multiplexer::new(0x1018, sub))?;
    }
    Ok(address)
}

/// Gives the four parts in an order; returns the responses.
pub fn select(bench: &mut Bench<'_>, parts: &[(Part, u32)]) -> Result<Vec<Response>, Stop> {
    let mut heard = Vec::new();
    for &(part, value) in parts {
        heard.extend(exchange(bench, Request::SwitchSelective { part, value })?);
    }
    Ok(heard)
}

/// The four parts in their order.
pub fn parts(address: [u32; 4]) -> Vec<(Part, u32)> {
    Part::ALL.into_iter().zip(address).collect()
}
