use crate::findings::Context;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::message::Service;
use crate::network::sdo::Outcome;
use crate::object;
use crate::{CobId, Multiplexer, NodeId};
use canvass_macros::rule;
use std::collections::{BTreeMap, BTreeSet};

/// two producers are configured to one CAN-ID
///
/// SDO traffic shows that two TPDOs or EMCYs, of one node or of two, have the same CAN-ID and are both switched on.
///
/// # Why
/// When both send at the same moment, arbitration can't decide, both detect an error, and both repeat. Receivers can't
/// tell which producer sent the data.
///
/// # What to do
/// Give one of the two another CAN-ID, or switch it off (bit 31 of its COB-ID).
#[rule(
    id = "bus/overlapping-cob-id",
    severity = Error,
    rank = Participants,
    services = [BootUp],
    also = EndedTransfers
)]
struct OverlappingCobId {
    /// COB-ID of each producer, by node and object, as the trace has shown it.
    producers: BTreeMap<(NodeId, Multiplexer), u32>,
    /// The producers by CAN-ID, so that a look-up does not depend on their number.
    users: BTreeSet<(u32, NodeId, Multiplexer)>,
}

impl OverlappingCobId {
    /// Maximum number of producers: enough for 127 nodes with 32 TPDOs each.
    const MOST: usize = 4096;

    fn forget(&mut self, producer: (NodeId, Multiplexer)) {
        if let Some(can_id) = self.producers.remove(&producer) {
            self.users.remove(&(can_id, producer.0, producer.1));
        }
    }

    fn forget_all(&mut self, node: NodeId) {
        let of_node = self.producers.range((node, Multiplexer::new(0, 0))..).map(|(producer, _)| *producer);
        let of_node: Vec<_> = of_node.take_while(|producer| producer.0 == node).collect();
        of_node.into_iter().for_each(|producer| self.forget(producer));
    }

    fn user(&self, can_id: u32) -> Option<(NodeId, Multiplexer)> {
        let &(found, node, object) = self.users.range((can_id, NodeId::MIN, Multiplexer::new(0, 0))..).next()?;
        (found == can_id).then_some((node, object))
    }
}

impl Rule for OverlappingCobId {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        if context.decoded.service == Service::BootUp {
            // A reset drops the COB-IDs that were not stored.
            self.forget_all(node);
            return;
        }
        let Some(transfer) = context.decoded.channel.and_then(|channel| context.scene.bus.transfer(channel)) else {
            return;
        };
        let object = transfer.multiplexer;
        let produces = matches!((object.index.0, object.sub.0), (object::COB_ID_EMCY, 0) | (0x1800..=0x19FF, 1));
        let Some(&value) = transfer.data().first_chunk::<4>() else { return };
        if !produces || transfer.outcome != Outcome::Complete {
            return;
        }
        let cob_id = CobId(u32::from_le_bytes(value));
        self.forget((node, object));
        if !cob_id.is_valid() || self.producers.len() >= Self::MOST {
            return;
        }
        let can_id = cob_id.can_id();
        if let Some((other_node, other_object)) = self.user(can_id) {
            let report = Report::at(context.now()).node(node).detail(u64::from(can_id));
            sink.report(report.evidence(context.evidence()), || {
                format!("CAN-ID {can_id:03X}h of {object} is also that of {other_object} of node {other_node}")
            });
        }
        self.producers.insert((node, object), can_id);
        self.users.insert((can_id, node, object));
    }
}
