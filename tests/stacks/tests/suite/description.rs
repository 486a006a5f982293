//! The device descriptions given to the suite match the devices.

use super::{BIT_RATE, Peer};
use canvass_analyzer::dictionary::{Access, DeviceDescription};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{AbortCode, Payload, REQUEST_BASE, RESPONSE_BASE, Request, Response};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::{Bus, SimulatedBus};
use canvass_stacks::{canopen_rs, zencan};
use canvass_traces::Duration;

fn answer(bus: &mut SimulatedBus, node: NodeId, request: &Request) -> Option<Response> {
    bus.send(&request.to_frame(REQUEST_BASE + u16::from(node.raw()))).unwrap();
    let deadline = bus.now() + Duration::from_millis(20);
    while let Some(record) = bus.receive(deadline).unwrap() {
        if record.frame.cob_id() == Some(RESPONSE_BASE + u16::from(node.raw())) {
            return Response::read(record.frame.data()).ok();
        }
    }
    None
}

/// Every described object exists with the length of its type and its default, and no other object exists.
fn is_true(peer: Peer, unreadable: &[Multiplexer]) {
    let description = DeviceDescription::read(peer.eds.as_bytes()).unwrap();
    let node = peer.node;
    let mut bus = SimulatedBus::new(BIT_RATE);
    bus.attach(peer.machine);
    bus.receive(bus.now() + Duration::from_millis(50)).unwrap();
    let mut wrong = Vec::new();
    for (at, entry) in description.dictionary.entries() {
        let expected = entry.start_value(node).and_then(|value| value.encode(entry.data_type).ok());
        let found = answer(&mut bus, node, &Request::upload(at));
        let is_right = match &found {
            Some(Response::InitiateUpload { payload: Payload::Segmented(size), .. }) => {
                // The suite reads segmented values; this test checks only the announced size.
                let is_right = expected.as_ref().map_or(0, Vec::len) == *size as usize;
                bus.send(&Request::abort(at, AbortCode::GENERAL).to_frame(REQUEST_BASE + u16::from(node.raw())))
                    .unwrap();
                bus.receive(bus.now() + Duration::from_millis(5)).unwrap();
                is_right
            }
            Some(Response::InitiateUpload { payload: Payload::Expedited(value), .. }) => {
                expected.as_deref() == Some(value.data())
            }
            Some(Response::Abort { .. }) => entry.access == Access::Wo || unreadable.contains(&at),
            _ => false,
        };
        if !is_right {
            wrong.push(format!("{at}: described as {expected:?}, found {found:?}"));
        }
    }
    for index in (0x1000..0x1D00).chain(0x1F00..0x2300).chain(0x5000..0x5020).chain(0x6000..0x6500) {
        let at = Multiplexer::new(index, 0);
        if description.dictionary.object(at.index).is_none() {
            let found = answer(&mut bus, node, &Request::upload(at));
            if !matches!(found, Some(Response::Abort { .. })) {
                wrong.push(format!("{at}: not described, found {found:?}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn of_canopen_rs() {
    is_true(Peer::new(canopen_rs::CanopenRs::new(), canopen_rs::EDS, canopen_rs::NODE), &[]);
}

/// 1010h:00 exists, but the server can't read it.
#[test]
fn of_zencan() {
    is_true(Peer::new(zencan::Zencan::new(), zencan::EDS, zencan::NODE), &[Multiplexer::new(0x1010, 0)]);
}
