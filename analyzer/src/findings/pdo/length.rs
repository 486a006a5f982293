use crate::findings::rule::{Definition, Metadata, Rule};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Severity};
use crate::message::{Message, PdoNumber, Service};

pub const RULE: Definition =
    Definition { metadata: &METADATA, services: &[Service::Pdo], make: Some(|_| Box::new(Length)) };

static METADATA: Metadata = Metadata {
    id: "pdo/length",
    severity: Severity::Error,
    title: "a PDO is not as long as its mapping says",
    what: "The mapping, as the SDO traffic or the device description shows it, fills more or fewer bytes than the PDO \
           has. A received PDO may be longer than the mapping of the node that receives it.",
    why: "A consumer that checks the length drops the PDO and sends EMCY 8210h; one that does not takes other values \
          for its own.",
    advice: "Read 1A00h (or 1600h) of the node and compare it with what the other side expects. If the mapping was \
             changed before the capture began, the description's default is not in force.",
    thresholds: &[],
};

struct Length;

impl Rule for Length {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let (Some(node), Message::Pdo(number)) = (context.node(), context.message()) else { return };
        let Some(layout) = context.scene.bus.node(node).and_then(|node| node.known_layout(*number)) else { return };
        let (mapped, found) = (layout.length(), context.record.frame.len());
        let fits = match number {
            PdoNumber::Transmit(_) => mapped == found,
            PdoNumber::Receive(_) => mapped <= found,
        };
        if !fits {
            let detail = u64::from(number.communication_index()) << 8 | found as u64;
            let report = Report::at(context.now()).node(node).detail(detail).evidence(context.evidence());
            sink.report(report, || format!("{number} has {found} bytes, its mapping fills {mapped}"));
        }
    }
}
