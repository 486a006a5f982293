use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::Message;
use canvass_macros::rule;
use canvass_traces::Duration;

/// a synchronous PDO comes outside the synchronous window
///
/// A synchronous TPDO (transmission type 0 to 240) comes later after SYNC than the synchronous window length (1007h) of
/// its node allows. The rule needs SDO traffic that shows the transmission type and 1007h. The time that the PDO itself
/// occupies the bus is not counted.
///
/// # Why
/// Consumers whose window is over discard the PDO or use it in the next cycle. The node should not have sent it.
///
/// # What to do
/// Check the bus between SYNC and the PDO: either PDOs with lower CAN-IDs fill the window, or the bus is idle and the
/// device is too slow. Lengthen 1007h, distribute the PDOs over several cycles, or give this PDO a lower CAN-ID.
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
