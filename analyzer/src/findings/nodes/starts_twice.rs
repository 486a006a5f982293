use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use canvass_macros::rule;

/// a node sends its boot-up message twice
///
/// Within half a second after a boot-up, without a command in between, another one comes from the same node-ID. The rule
/// nodes/boot-up-without-command reports the second boot-up of a node that has sent a single one at another start.
///
/// # Why
/// CiA 301 demands one boot-up message for each start. A master that starts the node after the first message may find it
/// in pre-operational again after the second one, or count a restart.
///
/// # What to do
/// If it happens at each start, the firmware sends the message from two places, or restarts itself once: ask its maker,
/// and let the master wait half a second before it configures the node. If not, look for a second device with the same
/// node-ID that was switched on at the same time, and for a supply that dips.
#[rule(id = "nodes/starts-twice", severity = Info, rank = Detail, services = [BootUp])]
struct StartsTwice;

impl Rule for StartsTwice {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        let facts = context.scene.facts.node(node);
        let Some(first) = facts.last_boot_up.filter(|_| facts.repeats_boot_up(context.now())) else { return };
        let report = Report::at(context.now()).node(node);
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || format!("a second boot-up, {} after the first", context.now().since(first)));
    }
}
