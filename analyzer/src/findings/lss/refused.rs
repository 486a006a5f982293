use super::exchange::{Sender, configured, own_command, sender, words};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use canvass_macros::rule;

/// an LSS or LMT slave refuses a configuration
///
/// The answer to configure node-ID, configure bit timing or store has an error code.
///
/// # Why
/// The slave keeps its old node-ID or bit rate. A master that goes on all the same loses it.
///
/// # What to do
/// Code 1 is a node-ID or bit rate that the device does not have, or that it can't store; 2 of a store is a fault of
/// its memory.
#[rule(id = "lss/refused", severity = Error, rank = Detail, services = [Lss, Lmt])]
struct Refused {
    request: Option<Seen>,
}

impl Rule for Refused {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if sender(context.message()) == Some(Sender::Master) {
            self.request = Some(context.seen());
        }
        let Some((_, error @ 1..)) = configured(context.message()) else { return };
        let report = Report::at(context.now()).detail(u64::from(own_command(context)) << 8 | u64::from(error));
        let report = report.evidence(self.request.as_ref().map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || words(context.message()));
    }

    fn interrupted(&mut self) {
        self.request = None;
    }
}
