use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Severity};
use crate::message::{Message, Service};
use crate::wire::Malformed as Unreadable;
use crate::wire::error_control::State;
use crate::wire::flying_master::FlyingMaster;
use canvass_macros::rule;

/// a frame has the wrong length for its service, or can't be decoded
///
/// A frame on a CAN-ID of NMT, error control, SYNC, TIME, EMCY, SDO, LSS or LMT has more or fewer bytes than the
/// standard defines for that service, or its bytes have no meaning there: an NMT command has a reserved specifier or a
/// number that is no node-ID, or a boot-up message has the toggle bit. Reserved bits of TIME have the severity info. Each
/// service and length has its own finding.
/// An EMCY without bytes is not reported: it is the boot-up message of devices before CiA 301 V4.
///
/// # Why
/// Receivers discard such frames or misinterpret them: some nodes execute a command, others don't.
///
/// # What to do
/// Find the sender: the CAN-ID shows the node; for commands and requests, check the masters and tools on this bus. If
/// no CANopen message should have that CAN-ID, another protocol uses it.
#[rule(
    id = "bus/malformed",
    severity = Warning,
    rank = Detail,
    services = [Nmt, Heartbeat, BootUp, Guarding, Sync, Time, Emcy, Sdo, Lss, Lmt, Srdo, FlyingMaster]
)]
struct Malformed;

/// Least and largest number of bytes in a message of the service.
const fn lengths(service: Service) -> (usize, usize) {
    match service {
        Service::Nmt => (2, 2),
        Service::Heartbeat | Service::BootUp | Service::Guarding => (1, 1),
        Service::Sync => (0, 1),
        Service::Time => (6, 6),
        Service::Emcy | Service::Sdo | Service::Lss | Service::Lmt => (8, 8),
        _ => (0, 8),
    }
}

impl Rule for Malformed {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let service = context.decoded.service;
        let length = context.record.frame.len();
        let (least, most) = match context.message() {
            Message::GlobalFailSafe => (0, 0),
            Message::FlyingMaster(FlyingMaster::ActiveMaster { .. }) => (2, 2),
            Message::FlyingMaster(_) => (0, 0),
            _ => lengths(service),
        };
        if is_reserved(context.message()) {
            tell_reserved(context, sink);
        }
        let is_right = (least..=most).contains(&length);
        let unreadable = match context.message() {
            Message::Malformed(_, error) => Some(*error),
            _ => None,
        };
        if is_right && unreadable.is_none() {
            return;
        }
        // A remote frame has no bytes, and an empty EMCY is the boot-up message of old devices.
        let is_empty_emcy = service == Service::BootUp && matches!(context.message(), Message::Emcy(_));
        if *context.message() == Message::GuardingRequest || is_empty_emcy {
            return;
        }
        tell(unreadable.filter(|_| is_right), (least, length), context, sink);
    }
}

/// Whether the message has a value that the standard reserves.
fn is_reserved(message: &Message) -> bool {
    match message {
        Message::Nmt(nmt) => nmt.command.name().is_none() || nmt.node > 127,
        Message::ErrorControl(message) => message.toggle && message.state == State::BOOT_UP,
        Message::Time(time) => time.reserved() != 0,
        _ => false,
    }
}

#[cold]
fn tell_reserved(context: &Context<'_>, sink: &mut Sink<'_>) {
    let is_info = matches!(context.message(), Message::Time(_));
    let node = context.node().filter(|_| matches!(context.message(), Message::ErrorControl(_)));
    let [command, number, ..] = context.record.frame.bytes();
    let detail = 1 << 32 | (context.decoded.service as u64) << 16 | u64::from(command) << 8 | u64::from(number);
    let detail = if is_info { 1 << 33 } else { detail };
    let report = Report::at(context.now()).node(node).detail(detail).evidence(context.evidence());
    let report = if is_info { report.severity(Severity::Info) } else { report };
    sink.report(report, || match context.message() {
        Message::Nmt(nmt) => format!("an NMT message that no node obeys: {nmt}"),
        Message::Time(time) => format!("TIME with reserved bits {:X}h", time.reserved()),
        _ => "a boot-up message with the toggle bit of guarding".to_owned(),
    });
}

#[cold]
fn tell(unreadable: Option<Unreadable>, (right, length): (usize, usize), context: &Context<'_>, sink: &mut Sink<'_>) {
    let service = context.decoded.service;
    // The master sends NMT commands, also if they name a node.
    let node = context.node().filter(|_| service != Service::Nmt);
    let kind = (service as u64) << 8 | length as u64;
    let report = Report::at(context.now()).node(node).detail(kind).kind(kind);
    sink.report(report.evidence(context.evidence()), || match unreadable {
        Some(error) => format!("{service} that can't be read: {error}"),
        None => format!(
            "{service} of {}, {} right",
            bytes(length),
            if right == 1 { "1 byte is".to_owned() } else { format!("{right} bytes are") }
        ),
    });
}

fn bytes(length: usize) -> String {
    if length == 1 { "1 byte".to_owned() } else { format!("{length} bytes") }
}
