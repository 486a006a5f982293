use crate::findings::Context;
use crate::findings::effect::{Effect, SOON};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::message::{Message, Service};
use crate::object;
use crate::text::EmcyText;
use crate::wire::emcy::Emcy;
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// Effects of an error on its device.
const EFFECTS: &[Effect] = &[
    Effect::on(&["nodes/state-lost"]).of_same_node().during(SOON, SOON),
    Effect::on(&["emcy/never-cleared"]).of_same_node().of_same_kind(),
];

/// a node reports an error
///
/// A node sends an EMCY with an error code. Each code has its own finding, which says how long the error lasted if its
/// end was reported. If the end (code 00xxh) comes with an error register other than 0, only the errors whose bits are
/// cleared have ended. Some devices clear an error when 1001h is read; the finding says so.
///
/// # Why
/// The device itself reports an error, of its own or of its bus.
///
/// # What to do
/// The error code and the manufacturer-specific bytes tell the cause; 1003h holds the history. Check the frames on the
/// bus just before the EMCY.
#[rule(
    id = "emcy/raised",
    severity = Error,
    rank = DeviceError,
    services = [Emcy],
    also = EndedTransfers,
    leads_to = EFFECTS
)]
struct Raised {
    /// Time at which the error register of a node was last read.
    register_read: PerNode<Option<Timestamp>>,
}

/// Time limit for taking the end of an error as a reaction to the reading of 1001h, by which some devices acknowledge
/// errors.
const ACKNOWLEDGED: Duration = Duration::from_millis(200);

impl Rule for Raised {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        match (context.decoded.service, context.message()) {
            (Service::Sdo, Message::SdoResponse(_)) => {
                let register = context.decoded.object.is_some_and(|object| object.index.0 == object::ERROR_REGISTER);
                if register {
                    self.register_read[node] = Some(context.now());
                }
            }
            (_, Message::Emcy(emcy)) => self.emcy(node, emcy, context, sink),
            _ => {}
        }
    }
}

impl Raised {
    fn emcy(&mut self, node: NodeId, emcy: &Emcy, context: &Context<'_>, sink: &mut Sink<'_>) {
        if let Some(code) = emcy.code().filter(|code| !code.is_reset()) {
            let report = Report::at(context.now()).node(node).detail(u64::from(code.0)).kind(u64::from(code.0));
            sink.report(report.evidence(context.evidence()), || {
                format!("EMCY {}", EmcyText::of(emcy, node, context.scene.bus))
            });
        }
        let by_reading = self.register_read[node].is_some_and(|read| context.now().since(read) <= ACKNOWLEDGED);
        for (code, raised) in &context.news().ended_errors {
            let raised = raised.seen();
            let lasted = context.now().since(raised.time());
            let report = Report::at(context.now()).node(node).detail(u64::from(code.0)).kind(u64::from(code.0)).amend();
            let report = report.measure(lasted.nanos()).evidence(raised.evidence()).evidence(context.evidence());
            sink.report(report, || {
                let text = match &raised.decoded.message {
                    Message::Emcy(emcy) => EmcyText::of(emcy, node, context.scene.bus).to_string(),
                    _ => code.to_string(),
                };
                let how = if by_reading { ", and its end was reported as 1001h was read" } else { "" };
                format!("EMCY {text}; it lasted {lasted}{how}")
            });
        }
    }
}
