use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::Message;
use canvass_macros::rule;
use canvass_traces::Duration;

/// a synchronous PDO comes outside the synchronous window
///
/// The SDO traffic of the capture shows the synchronous window length (1007h) of a node and that a TPDO of it is
/// synchronous (transmission type 0 to 240), and the PDO comes later than that after SYNC. The time that the PDO itself
/// takes on the bus is not counted.
///
/// # Why
/// Consumers whose window is over drop the PDO or take it for the next cycle; and the node should not have sent it any
/// more.
///
/// # What to do
/// See what was on the bus between SYNC and the PDO: PDOs with lower CAN-IDs that fill the window, or nothing, so that
/// the device is too slow. Lengthen 1007h, spread the PDOs over cycles, or give this one a lower CAN-ID.
#[rule(id = "pdo/sync-window", severity = Error, rank = Detail, services = [Sync], also = KnownTpdos)]
struct SyncWindow {
    /// tolerance for the recorder's clock
    #[threshold(us = 200)]
    tolerance: Duration,
    sync: Option<Seen>,
}

impl Rule for SyncWindow {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if matches!(context.message(), Message::Sync(_)) {
            self.sync = Some(context.seen());
            return;
        }
        let (Some((node, number, parameters)), Some(sync)) = (context.tpdo(), &self.sync) else { return };
        if !matches!(parameters.transmission_type, Some(0..=240)) || !context.scene.has_times() {
            return;
        }
        let Some(window) = context.scene.facts.tpdos.sync_window(node) else { return };
        let after = context.now().since(sync.time());
        let allowed = window + context.scene.longest_frame() + self.tolerance + context.scene.slack();
        if after > allowed {
            let report = Report::at(context.now()).node(node).detail(u64::from(number)).measure(after.nanos());
            sink.report(report.evidence(sync.evidence()).evidence(context.evidence()), || {
                format!(
                    "TPDO {number} came {after} after SYNC, but the synchronous window of the node (1007h) is \
                 {window}"
                )
            });
        }
    }

    fn interrupted(&mut self) {
        self.sync = None;
    }
}
