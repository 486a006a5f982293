use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene};
use crate::message::Message;
use crate::text::EmcyText;
use canvass_macros::rule;
use canvass_traces::Duration;

/// an error is still present when the capture ends
///
/// A node has reported an error by EMCY, and neither the end of the error (code 00xxh) nor a restart follows.
///
/// # Why
/// Either the error is still present, or the device does not report its end, which CiA 301 demands.
///
/// # What to do
/// Read 1001h and 1003h of the node: if 1001h is 0, the error is gone and its end was not reported.
#[rule(id = "emcy/never-cleared", severity = Warning, rank = Detail, services = [Emcy])]
struct NeverCleared;

impl Rule for NeverCleared {
    /// The present errors are known only at the end.
    fn frame(&mut self, _: &Context<'_>, _: &mut Sink<'_>) {}

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, code, raised) in scene.facts.errors.open() {
            let seen = raised.seen();
            let Message::Emcy(emcy) = &seen.decoded.message else { continue };
            let report = Report::at(seen.time())
                .node(node)
                .detail(u64::from(code.0))
                .kind(u64::from(code.0))
                .evidence(seen.evidence());
            let emcy = EmcyText::of(emcy, node, scene.bus);
            sink.report(report, || match scene.now.since(seen.time()) {
                Duration::ZERO => format!("EMCY {emcy}, with which the capture ends"),
                later => format!("EMCY {emcy}, still present {later} later at the end"),
            });
        }
    }
}
