use crate::NodeId;
use crate::findings::effect::{Effect, SETTLE};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::message::{Message, PdoNumber, Service};
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
/// A frame has the CAN-ID of a CANopen message of this bus, but is a remote frame where CANopen has none, or has 29 bits.
/// Remote frames that ask for a TPDO or for the state of a node are none of these. Frames of 29 bits are not reported
/// where another protocol uses them, too.
///
/// # Why
/// No receiver takes the frame for the message, so that the message is missing.
///
/// # What to do
/// Look at the driver of the sender: the bits RTR and IDE of a transmit buffer keep their last value in some CAN
/// controllers.
#[rule(id = "bus/frame-kind", severity = Warning, rank = Participants, services = [Unknown], leads_to = EFFECTS)]
struct FrameKind {
    /// The frames so far, by CAN-ID and kind.
    found: Vec<Found>,
    /// Whether there are frames of another protocol.
    is_mixed: bool,
}

/// Frames of one CAN-ID.
struct Found {
    can_id: u16,
    count: u64,
    first: Seen,
    last: Seen,
    /// The message before the first frame.
    before: Option<Seen>,
}

/// Maximum number of CAN-IDs with such frames.
const MOST: usize = 64;

/// The CAN-ID of 11 bits that the frame would have as a message; `None` for a data frame of 11 bits and for CAN FD.
fn meant(frame: &Frame) -> Option<u16> {
    let is_classical = !frame.is_fd() && !frame.is_xl() && !frame.is_error();
    let is_other = frame.is_remote() || frame.id().is_extended();
    u16::try_from(frame.id().raw()).ok().filter(|id| is_classical && is_other && *id < 0x800)
}

/// Whether a frame is a remote frame, and whether it has 29 bits.
fn kind(frame: &Frame) -> (bool, bool) {
    (frame.is_remote(), frame.id().is_extended())
}

/// The node of a CAN-ID of the predefined connection set, without PDOs.
fn node_of(id: u16) -> Option<NodeId> {
    let is_of_node = matches!(id, 0x081..=0x0FF | 0x581..=0x5FF | 0x601..=0x67F | 0x701..=0x77F);
    NodeId::new((id & 0x7F) as u8).filter(|_| is_of_node)
}

/// The service that a CAN-ID of the predefined connection set has.
const fn predefined(id: u16) -> Option<Service> {
    Some(match id {
        nmt::CAN_ID => Service::Nmt,
        0x001 => Service::Srdo,
        0x071..=0x076 => Service::FlyingMaster,
        sync::CAN_ID => Service::Sync,
        0x081..=0x0FF => Service::Emcy,
        time::CAN_ID => Service::Time,
        0x581..=0x5FF | 0x601..=0x67F => Service::Sdo,
        0x701..=0x77F => Service::Heartbeat,
        MASTER_CAN_ID | SLAVE_CAN_ID => Service::Lss,
        _ => return None,
    })
}

impl Found {
    /// The service of the CAN-ID on this bus.
    fn service(&self, scene: &Scene<'_>) -> Option<Service> {
        let shown = self.before.as_ref().map(|before| before.decoded.service);
        let is_there = |node: NodeId| scene.facts.node(node).first_seen.is_some();
        let is_used = node_of(self.can_id).map_or(scene.facts.present > 0, is_there);
        shown.or_else(|| predefined(self.can_id).filter(|_| is_used))
    }

    fn tell(&self, service: Service, sink: &mut Sink<'_>) {
        // The master sends NMT commands, also if they name a node.
        let shown = self.before.as_ref().and_then(|before| before.decoded.node);
        let node = shown.or_else(|| node_of(self.can_id)).filter(|_| service != Service::Nmt);
        let (is_remote, is_extended) = kind(&self.first.record.frame);
        let report = Report::at(self.first.time()).until(self.last.time()).node(node).times(self.count);
        let report = report.detail(u64::from(self.can_id) << 2 | u64::from(is_remote) << 1 | u64::from(is_extended));
        let report = report.evidence(self.before.as_ref().map(Seen::evidence)).evidence(self.first.evidence());
        sink.report(report, || {
            let kind = match (is_remote, is_extended) {
                (true, true) => "a remote frame of 29 bits",
                (true, false) => "a remote frame",
                _ => "a frame of 29 bits",
            };
            format!("{kind} {:03X}h, the CAN-ID of {service}", self.can_id)
        });
    }
}

impl FrameKind {
    fn see(&mut self, can_id: u16, context: &Context<'_>) {
        let before = context.scene.latest.get(can_id).filter(|before| before.decoded.service != Service::Unknown);
        let asks = |before: &Seen| {
            matches!(
                before.decoded.message,
                Message::PdoRequest(_)
                    | Message::Pdo(PdoNumber::Transmit(_))
                    | Message::Mpdo(PdoNumber::Transmit(_), _)
            )
        };
        let kind = kind(&context.record.frame);
        // A TPDO may be asked for while it is switched off.
        if kind == (true, false) && before.is_some_and(asks) {
            return;
        }
        let is_same = |found: &&mut Found| found.can_id == can_id && self::kind(&found.first.record.frame) == kind;
        if let Some(found) = self.found.iter_mut().find(is_same) {
            (found.count, found.last) = (found.count + 1, context.seen());
        } else if self.found.len() < MOST {
            let (first, last, before) = (context.seen(), context.seen(), before.cloned());
            self.found.push(Found { can_id, count: 1, first, last, before });
        }
    }
}

impl Rule for FrameKind {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        if !matches!(context.message(), Message::UnexpectedRemote | Message::Foreign) {
            return;
        }
        match meant(&context.record.frame) {
            Some(can_id) => self.see(can_id, context),
            None => self.is_mixed = true,
        }
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for found in &self.found {
            let is_foreign = self.is_mixed && found.first.record.frame.id().is_extended();
            if let Some(service) = found.service(scene).filter(|_| !is_foreign) {
                found.tell(service, sink);
            }
        }
    }
}
