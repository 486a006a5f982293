use super::is_cob_id;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Severity};
use crate::network::sdo::{Direction, Outcome};
use crate::object;
use crate::wire::sdo;
use crate::{CobId, Multiplexer, NodeId};
use canvass_macros::rule;

/// a COB-ID has a CAN-ID that CiA 301 restricts
///
/// An SDO download has set a COB-ID of SYNC, TIME, EMCY, SDO or a PDO to a CAN-ID that CiA 301 restricts (000h to 07Fh,
/// 101h to 180h, 581h to 5FFh, 601h to 67Fh, 6E0h to 6FFh, 701h to 7FFh), and the device has accepted it. If an upload
/// shows such a COB-ID, or a COB-ID of the first SDO server (1200h) other than the default, the finding is a warning:
/// the value can't be correct, and the frames of the device are decoded according to CiA 301. A COB-ID that reads as 0
/// is not reported: it means that there is no COB-ID, for which 80000000h is the correct value.
///
/// # Why
/// These CAN-IDs belong to NMT, default SDOs, error control and LSS. Other nodes take process data with such a CAN-ID
/// for commands or answers.
///
/// # What to do
/// Choose another CAN-ID in the configuration. The device should have refused this CAN-ID with abort 0609 0030h. If a
/// device reports a wrong COB-ID, its firmware is faulty: tools that use the COB-ID can't reach the device.
#[rule(id = "bus/restricted-cob-id", severity = Error, rank = State, also = EndedTransfers)]
struct RestrictedCobId;

/// The severity and the text of a COB-ID's fault; `None` if the COB-ID is right.
fn fault(object: Multiplexer, cob_id: CobId, direction: Direction, node: Option<NodeId>) -> Option<(Severity, String)> {
    let written = direction == Direction::Download;
    if object.index.0 == object::SDO_SERVER_PARAMETER {
        let base = if object.sub.0 == 1 { sdo::REQUEST_BASE } else { sdo::RESPONSE_BASE };
        let fixed = u32::from(base) + u32::from(node?.raw());
        let wrong = !written && cob_id.0 != fixed;
        return wrong
            .then(|| (Severity::Warning, format!("{object} reads {cob_id}, but CiA 301 fixes it to {fixed:08X}h")));
    }
    // In 1005h and 1012h bit 31 does not switch the message off.
    let used = cob_id.is_valid() || matches!(object.index.0, object::COB_ID_SYNC | object::COB_ID_TIME);
    let can_id = cob_id.can_id();
    match (written, cob_id.0) {
        _ if !used || !cob_id.is_restricted() => None,
        (true, _) => {
            Some((Severity::Error, format!("{object} was set to {cob_id}: CAN-ID {can_id:03X}h is restricted")))
        }
        (false, 0) => {
            Some((Severity::Info, format!("{object} reads {cob_id}, which is no COB-ID: 80000000h means off")))
        }
        (false, _) => Some((Severity::Warning, format!("{object} reads {cob_id}: CAN-ID {can_id:03X}h is restricted"))),
    }
}

impl Rule for RestrictedCobId {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(transfer) = context.decoded.channel.and_then(|channel| context.scene.bus.transfer(channel)) else {
            return;
        };
        let object = transfer.multiplexer;
        let Some(&value) = transfer.data().first_chunk::<4>() else { return };
        if transfer.outcome != Outcome::Complete || !is_cob_id(object.index.0, object.sub.0) {
            return;
        }
        let cob_id = CobId(u32::from_le_bytes(value));
        if let Some((severity, message)) = fault(object, cob_id, transfer.direction, context.node()) {
            let detail = u64::from(object.index.0) << 16 | u64::from(cob_id.can_id());
            let report = Report::at(context.now()).node(context.node()).detail(detail).severity(severity);
            sink.report(report.evidence(context.evidence()), || message);
        }
    }
}
