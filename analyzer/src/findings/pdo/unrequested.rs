use crate::findings::facts::TPDOS;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::message::{Message, PdoNumber};
use crate::{NodeId, PerNode};
use canvass_macros::rule;

/// a PDO comes without the request that it needs
///
/// The SDO traffic of the capture shows that a TPDO is sent on request only (transmission type FCh or FDh; CiA 301,
/// 7.5.2.37), and it comes once more than remote frames have requested it. The rule reports nothing before five requests
/// in a row were answered once each, because some loggers do not record all remote frames.
///
/// # Why
/// Either the device sends an answer twice, or a second device sends with the same CAN-ID: the consumer can't tell whose
/// value it has.
///
/// # What to do
/// Read 180xh:1 of all nodes: each CAN-ID must occur once only. If it does, the device's firmware sends the PDO on
/// events, although its transmission type forbids them.
#[rule(id = "pdo/unrequested", severity = Warning, rank = ProcessData, services = [Pdo])]
struct Unrequested {
    nodes: PerNode<[Requests; TPDOS]>,
}

/// The requests for a TPDO.
#[derive(Clone, Copy, Default)]
struct Requests {
    /// Number of requests without an answer.
    open: u8,
    /// Number of answered requests in a row.
    answered: u8,
}

impl Unrequested {
    /// Number of answered requests that show that the capture has all requests.
    const ENOUGH: u8 = 5;

    fn requests(&mut self, node: NodeId, number: u16) -> Option<&mut Requests> {
        self.nodes[node].get_mut(usize::from(number).checked_sub(1)?)
    }
}

impl Rule for Unrequested {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if let (Message::PdoRequest(PdoNumber::Transmit(number)), Some(node)) = (context.message(), context.node())
            && let Some(requests) = self.requests(node, *number)
        {
            requests.open = requests.open.saturating_add(1);
        }
        let Some((node, number, parameters)) = context.tpdo() else { return };
        let Some(requests) = self.requests(node, number) else { return };
        if requests.open > 0 {
            *requests = Requests { open: requests.open - 1, answered: requests.answered.saturating_add(1) };
            return;
        }
        let answered = std::mem::take(&mut requests.answered);
        if answered < Self::ENOUGH || !matches!(parameters.transmission_type, Some(0xFC | 0xFD)) {
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
