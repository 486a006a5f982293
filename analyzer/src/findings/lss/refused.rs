use super::exchange::{Sender, configured, own_command, sender, words};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use canvass_macros::rule;

/// an LSS or LMT slave refuses a configuration
///
/// The slave answers configure node-ID, configure bit timing or store configuration with an error code.
///
/// # Why
/// The slave keeps its old node-ID or bit rate. A master that ignores the error code and continues with the new one no
/// longer reaches the slave.
///
/// # What to do
/// Error code 1 means that the device does not support the node-ID or bit rate, or can't store it. Error code 2 of
/// store configuration means that its memory is faulty.
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
