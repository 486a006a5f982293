use crate::findings::effect::{Effect, SOON};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Severity};
use crate::message::{Message, PdoNumber};
use crate::network::Node;
use crate::{Multiplexer, NodeId, PerNode};
use canvass_macros::rule;

/// EMCY codes about a PDO or SYNC of wrong length.
const OF_LENGTH: &[u64] = &[0x8210, 0x8220, 0x8240, 0x8250];

/// Effects: error messages of the receiver.
const EFFECTS: &[Effect] = &[Effect::on(&["emcy/raised"]).with_codes(OF_LENGTH).spanning(SOON)];

/// the length of a PDO differs from its mapping
///
/// The mapping in the SDO traffic or the device description has more or fewer bytes than the PDO. A received PDO may be
/// longer than the mapping of the receiving node. Some devices pad a TPDO to 8 bytes with zeros: a TPDO that is always
/// padded is not reported. If only the description shows the mapping, and the PDO never fits it, another mapping was
/// set before the capture began: the severity is then info.
///
/// # Why
/// A consumer that checks the length discards the PDO and sends EMCY 8210h. A consumer that does not check it uses the
/// wrong values.
///
/// # What to do
/// Read 1A00h (or 1600h) of the node and compare it with the mapping that the other side expects. If the mapping was
/// changed before the capture began, the description's default does not apply.
#[rule(id = "pdo/length", severity = Error, rank = DeviceError, services = [Pdo], leads_to = EFFECTS)]
struct Length {
    /// By node, a bit for each PDO that once had the length of its mapping.
    fitted: PerNode<u64>,
}

/// The bit of a PDO; 0 for PDOs beyond the 32nd.
const fn bit(number: PdoNumber) -> u64 {
    match number {
        PdoNumber::Transmit(number @ 1..=32) => 1 << (number - 1),
        PdoNumber::Receive(number @ 1..=32) => 1 << (number + 31),
        _ => 0,
    }
}

impl Length {
    /// Whether a TPDO of 8 bytes has only zeros after its mapping, and never had the length of the mapping.
    fn fills_up(&self, node: NodeId, number: PdoNumber, mapped: usize, context: &Context<'_>) -> bool {
        let fitted = self.fitted[node] & bit(number) != 0;
        !fitted && context.record.frame.bytes().iter().skip(mapped).all(|&byte| byte == 0)
    }
}

impl Rule for Length {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let (Some(node), Message::Pdo(number)) = (context.node(), context.message()) else { return };
        let Some(known) = context.scene.bus.node(node) else { return };
        let Some(layout) = known.known_layout(*number) else { return };
        let (mapped, found) = (layout.length(), context.record.frame.len());
        let fits = match number {
            PdoNumber::Transmit(tpdo) => {
                let pads = known.device.as_ref().is_some_and(|device| device.manual.settings.pads(*tpdo));
                mapped == found || found == 8 && mapped < 8 && (pads || self.fills_up(node, *number, mapped, context))
            }
            PdoNumber::Receive(_) => mapped <= found,
        };
        if fits {
            self.fitted[node] |= if mapped == found { bit(*number) } else { 0 };
        } else {
            self.tell((node, *number), (mapped, found), context, sink);
        }
    }
}

impl Length {
    #[cold]
    fn tell(
        &self,
        (node, number): (NodeId, PdoNumber),
        (mapped, found): (usize, usize),
        context: &Context<'_>,
        sink: &mut Sink<'_>,
    ) {
        // The mapping in force is certain only if the capture shows it.
        let certain = |known: &Node| known.certain(node, Multiplexer::new(number.mapping_index(), 0)).is_some();
        let shown = context.scene.bus.node(node).is_some_and(certain);
        let default = !shown && self.fitted[node] & bit(number) == 0;
        let detail = u64::from(number.communication_index()) << 8 | found as u64;
        let report = Report::at(context.now()).node(node).detail(detail).evidence(context.evidence());
        let report = if default { report.severity(Severity::Info) } else { report };
        sink.report(report, || {
            let whose = if default { "the mapping of its description" } else { "its mapping" };
            format!("{number} has {found} bytes, {whose} fills {mapped}")
        });
    }
}
