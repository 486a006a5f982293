use crate::findings::facts::StreamEvent;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::{Message, PdoNumber};
use canvass_macros::rule;

/// a PDO changes its length
///
/// A PDO comes with another length than at least 10 frames before it. The rule judges PDOs without a known mapping, and RPDOs,
/// which may be longer than their mapping. NMT commands, boot-ups and writes to the parameters of the PDO begin anew.
/// pdo/length reports a length that the mapping forbids.
///
/// # Why
/// The length of a PDO follows from its mapping, which does not change while its node is operational (CiA 301): the
/// mapping was changed unseen, another device sends with the same CAN-ID, or the firmware has a fault. Consumers drop
/// the PDO or take other values for their own.
///
/// # What to do
/// Read 1A00h of the node and compare it with what the other side expects. If frames of both lengths come in turn, look
/// for a second sender.
#[rule(id = "pdo/length-changed", severity = Warning, rank = DeviceError, also = UnusualPdos)]
struct LengthChanged;

impl Rule for LengthChanged {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let (Some(node), StreamEvent::Length { before, times }) = (context.node(), context.news().stream) else {
            return;
        };
        let Message::Pdo(pdo) = *context.message() else { return };
        let found = context.record.frame.len();
        let layout = context.scene.bus.node(node).and_then(|known| known.known_layout(pdo));
        // The mapping of a multiplex PDO has no length.
        let layout = layout.filter(|layout| layout.length() > 0);
        let is_allowed = |mapped: usize| matches!(pdo, PdoNumber::Receive(_)) && mapped <= found;
        if layout.is_some_and(|layout| !is_allowed(layout.length())) {
            return;
        }
        let detail = match pdo {
            PdoNumber::Transmit(number) => u64::from(number) << 8 | found as u64,
            PdoNumber::Receive(number) => 1 << 32 | u64::from(number) << 8 | found as u64,
        };
        let report = Report::at(context.now()).node(node).detail(detail);
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || format!("{pdo} has {found} bytes, the {times} before it had {before}"));
    }
}
