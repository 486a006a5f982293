use super::boot_up_without_command::is_explained;
use crate::PerNode;
use crate::findings::Context;
use crate::findings::effect::Effect;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

#[derive(Clone, Copy, Default)]
struct Restarts {
    begin: Option<Timestamp>,
    count: u64,
}

/// Effects of a node that restarts again and again: each restart without a command, and its effects.
const EFFECTS: &[Effect] = &super::restart::effects(Effect::on(&["nodes/boot-up-without-command"]).of_same_node());

/// a node restarts again and again
///
/// A node sends several boot-ups within a short time that no command explains.
///
/// # Why
/// The node never starts to work. Its supply collapses under load, its watchdog fires, or it can't send on the bus and
/// restarts its controller.
///
/// # What to do
/// Measure the supply at the device while it starts. If the supply is good, check bit rate and termination, and look
/// for a second device with the same node-ID.
#[rule(id = "nodes/repeated-resets", severity = Error, rank = Restart, services = [BootUp], leads_to = EFFECTS)]
struct RepeatedResets {
    /// least number of boot-ups
    #[threshold(count = 3, min = 1)]
    times: u64,
    /// time within which the resets come
    #[threshold(ms = 60_000)]
    within: Duration,
    nodes: PerNode<Restarts>,
}

impl Rule for RepeatedResets {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        let restarts = &mut self.nodes[node];
        if context.scene.facts.node(node).last_seen.is_none() || !context.scene.has_times() {
            return;
        }
        if context.scene.facts.node(node).repeats_boot_up(context.now()) {
            return;
        }
        if is_explained(context, node, context.scene.facts.node(node)) {
            *restarts = Restarts::default();
            return;
        }
        let begin = *restarts.begin.get_or_insert(context.now());
        if context.now().since(begin) > self.within {
            *restarts = Restarts { begin: Some(context.now()), count: 0 };
        }
        restarts.count += 1;
        let count = restarts.count;
        if count >= self.times {
            let begin = restarts.begin.unwrap_or_default();
            sink.report(Report::at(context.now()).node(node).measure(count).evidence(context.evidence()), || {
                format!("{count} boot-ups within {} without a command", context.now().since(begin))
            });
        }
    }
}
