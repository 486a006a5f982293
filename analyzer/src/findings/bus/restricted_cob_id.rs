use super::is_cob_id;
use crate::CobId;
use crate::findings::Context;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::network::Event;
use crate::network::sdo::{Direction, Outcome};
use canvass_analyzer_macros::rule;

/// a COB-ID was set to a restricted CAN-ID
///
/// An SDO download has set a COB-ID of SYNC, TIME, EMCY, SDO or a PDO to a CAN-ID that CiA 301 restricts (000h to 07Fh,
/// 101h to 180h, 581h to 5FFh, 601h to 67Fh, 6E0h to 6FFh, 701h to 7FFh), and the device has accepted it.
///
/// # Why
/// These CAN-IDs belong to NMT, default SDOs, error control and LSS. Process data there are taken for commands or
/// answers by others.
///
/// # What to do
/// Choose another CAN-ID in the configuration. The device should have refused it with abort 0609 0030h.
#[rule(id = "bus/restricted-cob-id", severity = Error, services = [Sdo])]
struct RestrictedCobId;

impl Rule for RestrictedCobId {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if context.decoded.event != Some(Event::TransferEnded) {
            return;
        }
        let Some(transfer) = context.decoded.channel.and_then(|channel| context.scene.bus.transfer(channel)) else {
            return;
        };
        let (object, done) = (transfer.multiplexer, transfer.outcome == Outcome::Complete);
        let Some(&value) = transfer.data().first_chunk::<4>() else { return };
        let cob_id = CobId(u32::from_le_bytes(value));
        // Bit 31 of 1005h and 1012h does not say that it is off.
        let used = cob_id.is_valid() || matches!(object.index.0, 0x1005 | 0x1012);
        let default_server = object.index.0 == 0x1200;
        if transfer.direction == Direction::Download
            && done
            && used
            && !default_server
            && is_cob_id(object.index.0, object.sub.0)
            && cob_id.is_restricted()
        {
            let detail = u64::from(object.index.0) << 16 | u64::from(cob_id.can_id());
            let report = Report::at(context.now()).node(context.node()).detail(detail);
            sink.report(report.evidence(context.evidence()), || {
                format!("{object} was set to {cob_id}: CAN-ID {:03X}h is restricted", cob_id.can_id())
            });
        }
    }
}
