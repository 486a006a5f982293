use crate::findings::facts::TPDOS;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::message::{Message, PdoNumber};
use crate::{NodeId, PerNode};
use canvass_macros::rule;

/// a PDO comes without the request that it needs
///
/// The SDO traffic of the capture shows that a TPDO is sent on request only (transmission type FCh or FDh), and it comes
/// once more than it was requested by remote frames. The rule reports nothing before the first request, because some
/// loggers do not record remote frames.
///
/// # Why
/// Either the device sends an answer twice, or a second device sends with the same CAN-ID: the consumer can't tell whose
/// value it has.
///
/// # What to do
/// Read 180xh:1 of all nodes: each CAN-ID must occur once only. If it does, the device's firmware sends the PDO on
/// events, although its transmission type forbids them.
#[rule(id = "pdo/unrequested", severity = Error, rank = ProcessData, services = [Pdo])]
struct Unrequested {
    /// By TPDO, the number of requests without an answer; `None` before the first request.
    nodes: PerNode<[Option<u8>; TPDOS]>,
}

impl Unrequested {
    fn open(&mut self, node: NodeId, number: u16) -> Option<&mut Option<u8>> {
        self.nodes[node].get_mut(usize::from(number).checked_sub(1)?)
    }
}

impl Rule for Unrequested {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if let (Message::PdoRequest(PdoNumber::Transmit(number)), Some(node)) = (context.message(), context.node())
            && let Some(open) = self.open(node, *number)
        {
            *open = Some(open.unwrap_or(0).saturating_add(1));
        }
        let Some((node, number, parameters)) = context.tpdo() else { return };
        let Some(Some(open)) = self.open(node, number) else { return };
        let is_answer = *open > 0;
        *open = open.saturating_sub(1);
        if is_answer || !matches!(parameters.transmission_type, Some(0xFC | 0xFD)) {
            return;
        }
        let report = Report::at(context.now()).node(node).detail(u64::from(number));
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || format!("TPDO {number} comes once more than it was requested"));
    }

    fn reconfigured(&mut self, node: NodeId, _: &Scene<'_>) {
        self.nodes[node] = Default::default();
    }

    fn interrupted(&mut self) {
        self.nodes = PerNode::default();
    }
}
