use crate::PerNode;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::{Message, Service};
use canvass_macros::rule;

/// the toggle bit of guarding does not alternate
///
/// Two consecutive guarding answers, each to its own request, have the same toggle bit, without a reset between them.
///
/// # Why
/// The master treats the answer as an old one and may declare the node lost. Usually a CAN controller answers by itself
/// from a buffer that the firmware has not updated.
///
/// # What to do
/// The device is faulty, unless two masters guard the same node: then each master evaluates only every second answer.
#[rule(id = "nodes/guarding-toggle", severity = Error, rank = State, services = [Guarding, BootUp, Nmt])]
struct GuardingToggle {
    nodes: PerNode<Option<bool>>,
    asked: PerNode<bool>,
}

impl Rule for GuardingToggle {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if context.decoded.service == Service::Nmt {
            // The effect of a reset on the toggle bit differs between devices.
            if context.begins_anew() {
                self.nodes.reset();
            }
            return;
        }
        let Some(node) = context.node() else { return };
        match context.message() {
            Message::GuardingRequest => self.asked[node] = true,
            _ if context.decoded.service == Service::BootUp => self.nodes[node] = None,
            Message::ErrorControl(message) => {
                let asked = std::mem::take(&mut self.asked[node]);
                if self.nodes[node] == Some(message.toggle) && asked {
                    let report = Report::at(context.now()).node(node);
                    let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
                    sink.report(report, || format!("toggle bit {} twice in a row", u8::from(message.toggle)));
                }
                // An answer without a visible request may be a heartbeat.
                self.nodes[node] = asked.then_some(message.toggle);
            }
            _ => {}
        }
    }

    fn interrupted(&mut self) {
        self.nodes.reset();
        self.asked.reset();
    }
}
