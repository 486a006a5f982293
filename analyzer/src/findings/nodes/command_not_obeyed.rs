use crate::findings::effect::Effect;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::{Message, Service};
use crate::wire::error_control::State;
use crate::wire::nmt::Command;
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};
use std::rc::Rc;

/// Rules whose findings follow from this one: the node acts by the state that it has not left.
const EFFECTS: &[Effect] =
    &[Effect::on(&["nodes/pdo-outside-operational", "nodes/sdo-in-stopped", "nodes/no-boot-up"]).of_same_node()];

/// a node does not reach the commanded NMT state
///
/// Two heartbeats or guarding answers of the node show another NMT state than a command demands, until the time to
/// execute it is over, the next command comes or the capture ends; a single one may have been queued before the
/// command. A state that is reached later than usual is not reported, because no standard limits the time. A reset also
/// counts as not obeyed if no boot-up follows and the heartbeats continue in the same state, each at its regular time.
/// All commands that a node does not obey are one finding. The NMT master does not receive its own commands. A node may
/// be the master if it stays in its state after a command to all nodes, no command has named it, it has obeyed no
/// command to leave operational, has answered no SDO client, and sends neither TPDOs nor EMCY: the severity is then
/// info. If it is the only such node, and other nodes obey, it is the master, and is not reported.
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
    /// time to reach the commanded state, if another command follows or the capture ends
    #[threshold(ms = 500)]
    settle: Duration,
    /// time to reach the commanded state
    #[threshold(ms = 5000)]
    patience: Duration,
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
    /// Whether the node has obeyed a command to all nodes.
    obeyed_all: bool,
    /// The last heartbeat, with its state.
    beat: Option<(Timestamp, State)>,
    disobeyed: Disobeyed,
    /// The reports about a node that may be the master, until the end of the capture shows whether the node is the
    /// master.
    doubtful: Vec<Doubt>,
}

/// A command that a node that may be the master did not obey.
struct Doubt {
    command: Rc<Seen>,
    against: Seen,
    times: u64,
    words: String,
}

struct Pending {
    /// The command, shared by all nodes that it names.
    command: Rc<Seen>,
    expected: State,
    /// Number of messages with a state other than `expected`, and the latest of them.
    against: u8,
    latest: Option<(Seen, State)>,
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
    /// Messages within this time after a command may have been queued before it.
    const QUEUED: Duration = Duration::from_millis(100);
    /// No device restarts faster than this.
    const RESTART: Duration = Duration::from_millis(5);

    /// Whether the command names all nodes.
    fn is_to_all(&self) -> bool {
        self.command.decoded.node.is_none()
    }

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
    /// Maximum number of commands that are kept of a node that may be the master.
    const DOUBTS: usize = 32;

    fn commanded(&mut self, command: Command, node: u8, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(expected) = command.state() else { return };
        let command = Rc::new(context.seen());
        let settle = self.settle;
        for (id, watched) in self.nodes.named_mut(node) {
            // A repeated command gives the node no new time: the time runs from the first command.
            let waits = watched.pending.as_ref().is_some_and(|pending| pending.expected == expected);
            if waits && expected != State::BOOT_UP {
                continue;
            }
            watched.give_up(id, settle, context.scene, sink);
            // An unseen node may just have been switched on.
            watched.pending = (expected != State::BOOT_UP || watched.beat.is_some()).then(|| Pending {
                command: Rc::clone(&command),
                expected,
                against: 0,
                latest: None,
                before: watched.beat,
                on_time: 0,
            });
        }
    }

    /// Handles a state shown by error control.
    fn shown(&mut self, node: NodeId, state: State, context: &Context<'_>, sink: &mut Sink<'_>) {
        let watched = &mut self.nodes[node];
        let Some(pending) = &mut watched.pending else { return };
        // A node that appears long after the command was absent when the command came.
        let is_new = context.scene.facts.node(node).last_seen.is_none();
        if is_new && context.now().since(pending.command.time()) > self.patience {
            watched.pending = None;
            return;
        }
        let is_reset = pending.expected == State::BOOT_UP;
        let period = context.scene.facts.heartbeats.of(node).period();
        let goes_on = is_reset && pending.goes_on(context.now(), state, period);
        // Without a boot-up message, pre-operational shows that the reset has taken place.
        if state == pending.expected
            || context.decoded.service == Service::BootUp
            || is_reset && state == State::PRE_OPERATIONAL && !goes_on
        {
            let before = pending.before.is_none_or(|(_, before)| before != state);
            watched.obeyed_all |= pending.is_to_all() && before;
            watched.obedient |= pending.expected != State::OPERATIONAL;
            watched.pending = None;
            return;
        }
        let (settle, limit) = if is_reset { (self.reset, self.reset) } else { (Pending::QUEUED, self.patience) };
        let waited = context.now().since(pending.command.time());
        if waited <= settle && !(goes_on && pending.on_time > 1) {
            return;
        }
        pending.against = pending.against.saturating_add(1);
        pending.latest = Some((context.seen(), state));
        let needed = if is_reset && state == State::PRE_OPERATIONAL { pending.on_time } else { pending.against.into() };
        if needed >= 2 && waited > limit {
            watched.tell(node, context.scene, sink);
        }
    }
}

impl Watched {
    /// Judges a command that is not pending any more, as another one follows or the capture ends.
    fn give_up(&mut self, node: NodeId, settle: Duration, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let Some(pending) = &self.pending else { return };
        let late = |latest: &(Seen, State)| latest.0.time().since(pending.command.time()) > settle;
        let is_late = pending.latest.as_ref().is_some_and(late);
        if pending.expected != State::BOOT_UP && pending.against >= 2 && is_late {
            self.tell(node, scene, sink);
        }
        self.pending = None;
    }

    fn tell(&mut self, node: NodeId, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let Some(pending) = self.pending.take() else { return };
        let Some((against, state)) = pending.latest else { return };
        let is_slave = self.obedient || scene.facts.node(node).is_slave;
        if !is_slave && state != State::OPERATIONAL && pending.expected == State::BOOT_UP {
            return;
        }
        let is_master = !is_slave && (state == State::OPERATIONAL || pending.expected == State::STOPPED);
        let at = pending.command.time();
        let waited = against.time().since(at);
        let words = match pending.expected {
            State::BOOT_UP => format!("{state} {waited} after the command to reset it, and no boot-up"),
            expected => format!("{state} {waited} after the command to be {expected}"),
        };
        let words = if is_master { format!("{words}; correct if this is the NMT master itself") } else { words };
        let words = self.disobeyed.add(pending.expected, at.since(scene.start), words);
        let told = Doubt { command: pending.command, against, times: self.disobeyed.times, words };
        if !is_master {
            told.report(node, None, sink);
        } else if self.doubtful.len() < CommandNotObeyed::DOUBTS {
            self.doubtful.push(told);
        }
    }
}

impl Doubt {
    fn report(self, node: NodeId, severity: Option<Severity>, sink: &mut Sink<'_>) {
        let report = Report::at(self.command.time()).until(self.against.time()).node(node).measure(self.times);
        let report = severity.map_or(report, |severity| report.severity(severity));
        sink.report(report.evidence(self.command.evidence()).evidence(self.against.evidence()), || self.words);
    }
}

impl Rule for CommandNotObeyed {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if let Message::Nmt(nmt) = context.message() {
            return self.commanded(nmt.command, nmt.node, context, sink);
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

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, watched) in self.nodes.iter_mut() {
            watched.give_up(node, self.settle, scene, sink);
        }
        // The master is the only node that does not hear a command which the others obey.
        let is_doubtful = |watched: &Watched| !watched.doubtful.is_empty();
        let doubtful = self.nodes.iter().filter(|(_, watched)| is_doubtful(watched)).count();
        let others_obey = self.nodes.iter().any(|(_, watched)| watched.obeyed_all && !is_doubtful(watched));
        if doubtful == 1 && others_obey {
            return;
        }
        for (node, watched) in self.nodes.iter_mut() {
            for doubt in watched.doubtful.drain(..) {
                doubt.report(node, Some(Severity::Info), sink);
            }
        }
    }
}
