use crate::findings::effect::Effect;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::{Message, Service};
use crate::wire::error_control::State;
use crate::wire::nmt::Command;
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};
use std::rc::Rc;

/// Effects: messages that show the state in which the node has stayed.
const EFFECTS: &[Effect] =
    &[Effect::on(&["nodes/pdo-outside-operational", "nodes/sdo-in-stopped", "nodes/no-boot-up"]).of_same_node()];

/// a node does not reach the commanded NMT state
///
/// Two heartbeats or guarding answers of the node show another NMT state than a command demands, after the time to
/// execute it; a single one may have been queued before the command. A reset also counts as not obeyed if no boot-up
/// follows and the heartbeats continue in the same state, each at its regular time. All commands that a node does not
/// obey are one finding. The NMT master does not receive its own commands. A node may be the master if it stays
/// operational after a command to all nodes, no command has named it, it has obeyed no command to leave operational,
/// has answered no SDO client, and sends neither TPDOs nor EMCY: the severity is then info.
///
/// # Why
/// The node is not in the state that the master assumes: it sends no process data, or continues to send them.
///
/// # What to do
/// Check whether the node reports an EMCY: devices refuse to start while an error is present. Check that the command
/// really names this node.
#[rule(
    id = "nodes/command-not-obeyed",
    severity = Error,
    rank = State,
    services = [Nmt, Heartbeat, Guarding, BootUp],
    leads_to = EFFECTS
)]
struct CommandNotObeyed {
    /// time to reach the commanded state
    #[threshold(ms = 100)]
    settle: Duration,
    /// time to begin a reset
    #[threshold(ms = 2000)]
    reset: Duration,
    nodes: PerNode<Watched>,
}

#[derive(Default)]
struct Watched {
    pending: Option<Pending>,
    /// Whether the node has obeyed a command to leave operational or to reset.
    obedient: bool,
    /// The last heartbeat, with its state.
    beat: Option<(Timestamp, State)>,
    disobeyed: Disobeyed,
}

struct Pending {
    /// The command, shared by all nodes that it names.
    command: Rc<Seen>,
    expected: State,
    /// Number of messages with a state other than `expected`.
    against: u8,
    /// The last heartbeat before the command, and the number of heartbeats at their regular times after it.
    before: Option<(Timestamp, State)>,
    on_time: u64,
}

/// The disobeyed commands.
#[derive(Default)]
struct Disobeyed {
    times: u64,
    resets: u64,
    /// Times of the first disobeyed resets, since the start.
    reset_at: Vec<Duration>,
    starts: u64,
    first: String,
}

impl Disobeyed {
    /// Number of resets listed with their times.
    const LISTED: usize = 8;

    /// Adds a command; returns the text about all disobeyed commands.
    fn add(&mut self, expected: State, since_start: Duration, words: String) -> String {
        self.times += 1;
        match expected {
            State::BOOT_UP => {
                self.resets += 1;
                if self.reset_at.len() < Self::LISTED {
                    self.reset_at.push(since_start);
                }
            }
            State::OPERATIONAL => self.starts += 1,
            _ => {}
        }
        if self.times == 1 {
            self.first = words;
            return self.first.clone();
        }
        let mut kinds = Vec::new();
        if self.resets > 0 {
            let at: Vec<String> = self.reset_at.iter().map(Duration::to_string).collect();
            let more = if self.resets > Self::LISTED as u64 { ", …" } else { "" };
            kinds.push(format!("{} to reset (after {}{more} of the capture)", self.resets, at.join(", ")));
        }
        if self.starts > 0 {
            kinds.push(format!("{} to start", self.starts));
        }
        let others = self.times - self.resets - self.starts;
        if others > 0 {
            kinds.push(format!("{others} to stop or to be pre-operational"));
        }
        format!("{} commands not obeyed, {}; the first: {}", self.times, kinds.join(", "), self.first)
    }
}

impl Pending {
    /// No device restarts faster than this.
    const RESTART: Duration = Duration::from_millis(5);

    /// Whether a heartbeat comes exactly as it would have come without the reset: then the node has not restarted. If
    /// the reset coincides with a heartbeat, a restarted timer is late by the duration of the restart.
    fn goes_on(&mut self, now: Timestamp, state: State, period: Option<Duration>) -> bool {
        let (Some((before, old)), Some(period)) = (self.before, period.filter(|period| *period > Duration::ZERO))
        else {
            return false;
        };
        let tenth = period.nanos() / 10;
        let phase = self.command.time().since(before).nanos();
        let due = period.nanos() * (self.on_time + 1);
        let off = now.since(before).nanos().abs_diff(due);
        let together = phase < tenth || phase + tenth > period.nanos();
        let tolerated = if together { (tenth / 2).min(Self::RESTART.nanos()) } else { tenth / 2 };
        if old != state || off > tolerated {
            self.before = None;
            return false;
        }
        self.on_time += 1;
        true
    }
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
        let command = Rc::new(context.seen());
        for (_, watched) in self.nodes.named_mut(node) {
            // A repeated command gives no new time: the node has had its time since the first one.
            let waits = watched.pending.as_ref().is_some_and(|pending| pending.expected == expected);
            // An unseen node may just have been switched on.
            if expected == State::BOOT_UP && watched.beat.is_none() {
                watched.pending = None;
            } else if !waits || expected == State::BOOT_UP {
                let (command, before) = (Rc::clone(&command), watched.beat);
                watched.pending = Some(Pending { command, expected, against: 0, before, on_time: 0 });
            }
        }
    }

    /// Handles a state shown by error control.
    fn shown(&mut self, node: NodeId, state: State, context: &Context<'_>, sink: &mut Sink<'_>) {
        let watched = &mut self.nodes[node];
        let Some(pending) = &mut watched.pending else { return };
        let is_reset = pending.expected == State::BOOT_UP;
        let period = context.scene.facts.heartbeats.of(node).period();
        let goes_on = is_reset && pending.goes_on(context.now(), state, period);
        // Without a boot-up message, pre-operational shows that the reset has taken place.
        if state == pending.expected
            || context.decoded.service == Service::BootUp
            || is_reset && state == State::PRE_OPERATIONAL && !goes_on
        {
            watched.obedient |= pending.expected != State::OPERATIONAL;
            watched.pending = None;
            return;
        }
        let settle = if is_reset { self.reset } else { self.settle };
        let waited = context.now().since(pending.command.time());
        if waited <= settle && !(goes_on && pending.on_time > 1) {
            return;
        }
        pending.against += 1;
        let needed = if is_reset && state == State::PRE_OPERATIONAL { pending.on_time } else { pending.against.into() };
        if needed >= 2 && waited > settle {
            self.tell(node, state, context, sink);
        }
    }

    fn tell(&mut self, node: NodeId, state: State, context: &Context<'_>, sink: &mut Sink<'_>) {
        let watched = &mut self.nodes[node];
        let Some(pending) = watched.pending.take() else { return };
        let is_slave = watched.obedient || context.scene.facts.node(node).is_slave;
        if !is_slave && state != State::OPERATIONAL && pending.expected == State::BOOT_UP {
            return;
        }
        let is_master = !is_slave && state == State::OPERATIONAL;
        let at = pending.command.time();
        let waited = context.now().since(at);
        let master = if is_master { "; correct if this is the NMT master itself" } else { "" };
        let words = match pending.expected {
            State::BOOT_UP => format!("{state} {waited} after the command to reset it, and no boot-up{master}"),
            expected => format!("{state} {waited} after the command to be {expected}{master}"),
        };
        let words = watched.disobeyed.add(pending.expected, at.since(context.scene.start), words);
        let report = Report::at(at).until(context.now()).node(node).measure(watched.disobeyed.times);
        let report = if is_master { report.severity(Severity::Info) } else { report };
        sink.report(report.evidence(pending.command.evidence()).evidence(context.evidence()), || words);
    }
}

impl Rule for CommandNotObeyed {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if let Message::Nmt(nmt) = context.message() {
            return self.commanded(nmt.command, nmt.node, context);
        }
        let Some(node) = context.node() else { return };
        let state = match context.message() {
            _ if context.decoded.service == Service::BootUp => State::BOOT_UP,
            Message::ErrorControl(message) => message.state,
            _ => return,
        };
        self.shown(node, state, context, sink);
        self.nodes[node].beat = Some((context.now(), state));
    }

    fn interrupted(&mut self) {
        for watched in self.nodes.values_mut() {
            (watched.pending, watched.beat) = (None, None);
        }
    }
}
