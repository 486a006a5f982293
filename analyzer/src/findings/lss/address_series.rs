use super::exchange::{Sender, sender, words};
use super::series::{Series, Step};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use canvass_macros::rule;
use canvass_traces::Duration;

/// the requests that address an LSS or LMT slave are incomplete, or in another order
///
/// The master addresses a slave by a series of requests: 40h to 43h (switch selective; CiA 305, 6.3.3) or 46h to 4Bh (identify;
/// 6.6.2) in LSS, 01h to 03h or 05h to 08h in LMT. In this series a request is missing, stands in another place, or comes
/// twice with different values; or the master sends another request before the series is complete. The rule does not judge a
/// series that may have begun before the capture.
///
/// # Why
/// Some slaves accept the requests in one order only, others in any order that ends with the last one. The master then
/// configures no slave, or another slave than it means.
///
/// # What to do
/// Check whether a second master, such as a configuration tool, sends on 7E5h at the same time. If there is only one
/// master, its software sends the series wrongly, or the capture lacks frames.
#[rule(id = "lss/address-series", severity = Warning, rank = Detail, services = [Lss, Lmt])]
struct AddressSeries {
    series: Series,
    last: Option<Seen>,
    /// Whether requests may be missing before the next one.
    is_torn: bool,
}

impl Rule for AddressSeries {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if sender(context.message()) != Some(Sender::Master) {
            return;
        }
        let is_early = context.now().since(context.scene.start) < Duration::from_secs(1);
        let step = self.series.see(context, is_early || std::mem::take(&mut self.is_torn));
        let last = self.last.replace(context.seen());
        let (kind, what, command) = match step {
            Step::Regular | Step::Complete { .. } => return,
            Step::Again => (1_u64, "comes twice, with different values", 0),
            Step::Misplaced(command) => (2, "comes in the place of", command),
            Step::CutShort(command) => (3, "comes before the series is complete: the next request would be", command),
        };
        let report = Report::at(context.now()).detail(kind << 8 | u64::from(command));
        let report = report.evidence(last.as_ref().map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || {
            let expected = if command == 0 { String::new() } else { format!(" {command:02X}h") };
            format!("\"{}\" {what}{expected}", words(context.message()))
        });
    }

    fn interrupted(&mut self) {
        self.series.interrupted();
        (self.last, self.is_torn) = (None, true);
    }
}
