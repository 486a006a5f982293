use crate::findings::Context;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::message::Message;
use crate::wire::error_control::State;
use crate::wire::nmt::Command;
use canvass_macros::rule;
use canvass_traces::Duration;

/// a stopped node answers SDO requests
///
/// An SDO server still answers when the grace time after the NMT command that stopped its node is over.
///
/// # Why
/// A stopped node supports only NMT and error control (CiA 301). A device that answers may not have stopped at all.
///
/// # What to do
/// Check in its heartbeats whether the node has stopped. If it has, the device's firmware is faulty.
#[rule(id = "nodes/sdo-in-stopped", severity = Warning, rank = Detail, services = [Sdo])]
struct SdoInStopped {
    /// grace time for transfers under way
    #[threshold(ms = 50)]
    grace: Duration,
}

impl Rule for SdoInStopped {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let (Some(node), Message::SdoResponse(_)) = (context.node(), context.message()) else { return };
        let stopped = context.scene.bus.node(node).and_then(|node| node.state).map(|state| state.0);
        if stopped != Some(State::STOPPED) {
            return;
        }
        let command = context.scene.facts.node(node).command;
        let since = command.filter(|command| command.0 == Command::STOP).map(|command| command.1);
        if since.is_some_and(|since| context.now().since(since) > self.grace) {
            let report = Report::at(context.now()).node(node).evidence(context.evidence());
            sink.report(report, || "an SDO answer of a stopped node".to_owned());
        }
    }
}
