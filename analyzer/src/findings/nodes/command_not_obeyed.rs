use crate::PerNode;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::{Message, Service};
use crate::wire::error_control::State;
use crate::wire::nmt::Command;
use canvass_analyzer_macros::rule;
use canvass_traces::Duration;

/// a node does not reach the commanded NMT state
///
/// After an NMT command, and time to obey it, heartbeats or guarding answers of the node still show another state: two
/// of them, so that one that was already queued does not count. The NMT master does not hear its own commands: a node
/// that stays operational although all are told otherwise is only worth knowing as long as no command has named it, it
/// has not obeyed one to stop, has answered no SDO client, and sends neither TPDOs nor EMCY.
///
/// # Why
/// The master believes that the node is in another state than it is: it sends no process data, or goes on sending them.
///
/// # What to do
/// See whether the node reports an EMCY: devices refuse to start while an error is present. Check that the command
/// really names this node.
#[rule(id = "nodes/command-not-obeyed", severity = Error, services = [Nmt, Heartbeat, Guarding, BootUp])]
struct CommandNotObeyed {
    /// time to reach a state
    #[threshold(ms = 100)]
    settle: Duration,
    /// time to begin a reset
    #[threshold(ms = 2000)]
    reset: Duration,
    nodes: PerNode<Option<Pending>>,
    /// The nodes that have left operational, or started anew, when they were told to.
    obedient: PerNode<bool>,
}

struct Pending {
    command: Seen,
    expected: State,
    /// How often another state was seen.
    against: u8,
}

impl CommandNotObeyed {
    fn commanded(&mut self, command: Command, node: u8, context: &Context<'_>) {
        let expected = match command {
            Command::START => State::OPERATIONAL,
            Command::STOP => State::STOPPED,
            Command::ENTER_PRE_OPERATIONAL => State::PRE_OPERATIONAL,
            Command::RESET_NODE | Command::RESET_COMMUNICATION => State::BOOT_UP,
            _ => return,
        };
        for (_, pending) in self.nodes.named_mut(node) {
            // The same command again: the node has had its time since the first one.
            let waits = pending.as_ref().is_some_and(|pending| pending.expected == expected);
            if !waits || expected == State::BOOT_UP {
                *pending = Some(Pending { command: context.seen(), expected, against: 0 });
            }
        }
    }
}

impl Rule for CommandNotObeyed {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if let Message::Nmt(nmt) = context.message() {
            return self.commanded(nmt.command, nmt.node, context);
        }
        let (Some(node), Message::ErrorControl(message)) = (context.node(), context.message()) else { return };
        let slot = &mut self.nodes[node];
        let Some(pending) = slot else { return };
        let is_reset = pending.expected == State::BOOT_UP;
        // Without a boot-up message, pre-operational shows that the reset has taken place.
        if message.state == pending.expected
            || context.decoded.service == Service::BootUp
            || is_reset && message.state == State::PRE_OPERATIONAL
        {
            self.obedient[node] |= pending.expected != State::OPERATIONAL;
            *slot = None;
            return;
        }
        let settle = if is_reset { self.reset } else { self.settle };
        let waited = context.now().since(pending.command.time());
        if waited <= settle {
            return;
        }
        pending.against += 1;
        if pending.against >= 2 {
            let expected = pending.expected;
            let command = pending.command.evidence();
            let is_slave = self.obedient[node] || context.scene.facts.node(node).is_slave;
            let is_master = !is_slave && message.state == State::OPERATIONAL;
            let report = Report::at(pending.command.time()).node(node).detail(u64::from(expected.0));
            let report = if is_master { report.severity(Severity::Info) } else { report };
            sink.report(report.evidence(command).evidence(context.evidence()), || {
                let master = if is_master { "; it is right if this is the NMT master itself" } else { "" };
                match is_reset {
                    true => format!("{} {waited} after the command to reset it{master}", message.state),
                    false => format!("{} {waited} after the command to be {expected}{master}", message.state),
                }
            });
            *slot = None;
        }
    }

    fn interrupted(&mut self) {
        self.nodes.reset();
    }
}
