use crate::NodeId;
use crate::findings::effect::Effect;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, NodeFacts, Seen};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// Effects of a restart.
const EFFECTS: &[Effect] = &super::restart::effects(Effect::never_on(&["nodes/boot-up-without-command"]));

/// a node restarts by itself
///
/// A node that was already running sends a boot-up message, and no NMT reset command, LSS service or program control
/// (1F51h) explains it. The first boot-up in a capture is not reported, because the node was switched on. If two
/// boot-ups follow one reset command, the second one is reported, unless the device sends two within half a second at
/// each of its starts. A boot-up within ten seconds after a store counts as the power cycle that makes stored parameters
/// take effect.
///
/// # Why
/// The node has restarted, because of a dip of its supply, its watchdog, or bus-off recovery. It is in pre-operational
/// with its stored parameters, and sends no process data until it is started again.
///
/// # What to do
/// Check whether several nodes restart together (supply), which messages the node sent just before (EMCY), and whether
/// the restart recurs.
#[rule(
    id = "nodes/boot-up-without-command",
    severity = Warning,
    rank = Restart,
    services = [BootUp],
    leads_to = EFFECTS
)]
struct BootUpWithoutCommand;

/// Whether a message to the node explains its boot-up.
pub(crate) fn is_explained(context: &Context<'_>, node: NodeId, facts: &NodeFacts) -> bool {
    const WHILE: Duration = Duration::from_secs(10);
    let recent = |then: Option<Timestamp>| NodeFacts::is_recent(then, context.now(), WHILE);
    // One reset explains one boot-up; layer settings and programs take effect by a reset of their own.
    let after_boot_up = |then: Option<Timestamp>| recent(then) && then > facts.last_boot_up;
    let answered = |reset: Timestamp| {
        let usual = context.now().since(reset) <= context.scene.facts.presence.restart_limit(node);
        // A node that was present at the reset and is silent since is still restarting.
        let silent = facts.last_seen.is_none_or(|seen| seen <= reset + Duration::from_secs(1));
        usual || silent && context.news().returned.is_none()
    };
    facts.pending_reset.is_some_and(answered)
        || after_boot_up(context.scene.facts.layer_setting)
        || after_boot_up(facts.last_program_control)
        || after_boot_up(facts.last_store)
        || facts.repeats_boot_up(context.now())
}

impl Rule for BootUpWithoutCommand {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        let facts = context.scene.facts.node(node);
        if facts.last_seen.is_none() || is_explained(context, node, facts) {
            return;
        }
        let report = Report::at(context.now()).node(node);
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || {
            let last = facts.last_seen.map(|seen| context.now().since(seen));
            let last = last.map(|ago| format!(", {ago} after it last sent something")).unwrap_or_default();
            format!("boot-up without a reset command{last}")
        });
    }
}
