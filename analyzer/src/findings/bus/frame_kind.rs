use crate::findings::effect::{Effect, SETTLE};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::{Message, Service};
use crate::wire::lss::{MASTER_CAN_ID, SLAVE_CAN_ID};
use crate::wire::{nmt, sync, time};
use canvass_macros::rule;
use canvass_traces::Frame;

/// Effects: the message that the frame should have been is missing.
const EFFECTS: &[Effect] = &[
    Effect::on(&["nodes/", "pdo/", "sdo/", "lss/", "srdo/"]).of_same_node().spanning(SETTLE),
    Effect::on(&["pdo/sync-missing", "pdo/sync-pdo-missing"]).spanning(SETTLE),
];

/// a message comes as a remote frame, or with 29 bits
///
/// A frame has the CAN-ID of a CANopen message that the capture has shown before, or one that never has another use, but
/// is a remote frame where CANopen has none, or has 29 bits. Remote frames that ask for a TPDO or for the state of a node are none of these.
///
/// # Why
/// No receiver takes the frame for the message, so that the message is missing.
///
/// # What to do
/// Look at the driver of the sender: the bits RTR and IDE of a transmit buffer keep their last value in some CAN
/// controllers. If another protocol uses 29 bits on these wires, its low numbers may be a coincidence.
#[rule(id = "bus/frame-kind", severity = Warning, rank = Participants, services = [Unknown], leads_to = EFFECTS)]
struct FrameKind;

/// The CAN-ID of 11 bits that the frame would have as a message; `None` for a data frame of 11 bits and for CAN FD.
fn meant(frame: &Frame) -> Option<u16> {
    let is_classical = !frame.is_fd() && !frame.is_xl() && !frame.is_error();
    let is_other = frame.is_remote() || frame.id().is_extended();
    u16::try_from(frame.id().raw()).ok().filter(|id| is_classical && is_other && *id < 0x800)
}

/// The service that always has the CAN-ID, on a bus with nodes.
fn always(id: u16, context: &Context<'_>) -> Option<Service> {
    let service = match id {
        nmt::CAN_ID => Service::Nmt,
        0x001 => Service::Srdo,
        sync::CAN_ID => Service::Sync,
        time::CAN_ID => Service::Time,
        MASTER_CAN_ID | SLAVE_CAN_ID => Service::Lss,
        _ => return None,
    };
    (context.scene.facts.present > 0).then_some(service)
}

impl Rule for FrameKind {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if !matches!(context.message(), Message::UnexpectedRemote | Message::Foreign) {
            return;
        }
        let Some(id) = meant(&context.record.frame) else { return };
        let before = context.scene.latest.get(id).filter(|before| before.decoded.service != Service::Unknown);
        let Some(service) = before.map(|before| before.decoded.service).or_else(|| always(id, context)) else { return };
        let is_remote = context.record.frame.is_remote();
        // The master sends NMT commands, also if they name a node.
        let node = before.and_then(|before| before.decoded.node).filter(|_| service != Service::Nmt);
        let report = Report::at(context.now()).node(node).detail(u64::from(id) << 1 | u64::from(is_remote));
        sink.report(report.evidence(before.map(Seen::evidence)).evidence(context.evidence()), || {
            let kind = if is_remote { "remote frame" } else { "frame of 29 bits" };
            format!("a {kind} {id:03X}h, the CAN-ID of {service}")
        });
    }
}
