//! The presence of nodes: detects silences that are longer than the heartbeat or the master's guarding allows.

use super::node::NodeFacts;
use crate::findings::percent::Percent;
use crate::wire::nmt::{Command, Nmt};
use crate::{NodeId, PerNode};
use canvass_traces::{Duration, Timestamp};

/// The presence of all nodes of a bus.
#[derive(Default)]
pub struct Presence {
    nodes: PerNode<Watch>,
    /// The shortest silence that may be an outage; `None` if the node need not send.
    alarms: PerNode<Option<Duration>>,
    /// Whether the master has commanded or asked the node since its last message.
    addressed: PerNode<bool>,
    /// A silence that began before this time proves nothing: frames may be missing in it.
    since: Timestamp,
}

/// The state of one node.
#[derive(Clone, Copy, Default)]
struct Watch {
    orders: Orders,
    guarding: Guarding,
    /// The longest time from a reset to the boot-up.
    restart: Option<Duration>,
}

/// The master's commands to a node since the node's last message.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Orders {
    /// Number of resets.
    pub resets: u32,
    /// The first reset.
    pub first_reset: Option<Timestamp>,
    /// The last reset.
    pub last_reset: Option<Timestamp>,
    /// The last command of any kind.
    pub last: Option<(Command, Timestamp)>,
    /// Whether another command preceded the first reset: such a command may restart the heartbeat's period.
    pub shifts: bool,
}

/// The master's guarding of a node.
#[derive(Clone, Copy, Default)]
struct Guarding {
    asked: Option<Timestamp>,
    interval: Option<Duration>,
    /// Number of requests since the node's last message, before a reset.
    unanswered: u32,
}

/// The reason why a node should have sent a message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Sign {
    /// The heartbeat of the node, with its period.
    Heartbeat(Duration),
    /// The guarding requests of the master, with their interval.
    Guarding(Duration),
}

/// The silence of a node that should have sent a message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Outage {
    /// Time of the node's last message.
    pub since: Timestamp,
    /// The missing message.
    pub sign: Sign,
    /// The master's commands during the silence.
    pub orders: Orders,
}

impl Presence {
    /// A silence that is longer than this share of the period is an outage.
    const MISSING: Percent = Percent(300);
    /// A silence before a reset that is longer than this share of the period is an outage: masters reset a node after
    /// one and a half periods of silence.
    const BEFORE_RESET: Percent = Percent(150);
    /// Resets within this time count as one: some masters reset communication and then the node.
    const RETRY: Duration = Duration::from_secs(2);
    /// Time that a present node may take to restart, until the capture has shown how long it takes.
    const RESTART: Duration = Duration::from_secs(10);
    /// Time for which a node may be silent around layer setting.
    const LAYER_SETTING: Duration = Duration::from_secs(10);

    /// Whether a silence of the length `silence` may be an outage.
    #[inline]
    pub fn is_long(&self, node: NodeId, silence: Duration) -> bool {
        self.alarms[node].is_some_and(|alarm| silence > alarm)
    }

    /// The outage of a node, if its silence is longer than the commands meanwhile explain. `period` is the heartbeat
    /// period of the node, `layer_setting` the time of the last LSS message that may reset nodes.
    pub(crate) fn outage(
        &self,
        node: NodeId,
        now: Timestamp,
        facts: &NodeFacts,
        period: Option<Duration>,
        layer_setting: Option<Timestamp>,
    ) -> Option<Outage> {
        let watch = &self.nodes[node];
        let since = facts.last_seen?;
        if since < self.since || facts.has_moved || facts.last_program_control > facts.last_boot_up {
            return None;
        }
        let Orders { first_reset, last_reset, shifts, .. } = watch.orders;
        // The silence after a reset belongs to the reset, unless the master has to repeat it.
        let tried = first_reset.zip(last_reset).is_some_and(|(first, last)| last.since(first) >= Self::RETRY);
        let repeated = tried && first_reset.is_some_and(|reset| now.since(reset) > self.restart_limit(node));
        let end = first_reset.filter(|_| !repeated);
        let silence = end.unwrap_or(now).since(since);
        let missing = if end.is_some() { Self::BEFORE_RESET } else { Self::MISSING };
        let sign = match period {
            Some(period) => Sign::Heartbeat(period),
            None => {
                let least = if end.is_some() { 2 } else { 3 };
                Sign::Guarding(watch.guarding.interval.filter(|_| watch.guarding.unanswered >= least)?)
            }
        };
        let (Sign::Heartbeat(period) | Sign::Guarding(period)) = sign;
        // A command that changes the state may restart the heartbeat's period.
        let shift = if shifts { period } else { Duration::ZERO };
        let excuse = |then: Option<Timestamp>, length: Duration| {
            let end = then.filter(|then| *then + length > since).map(|then| then + length);
            end.map_or(Duration::ZERO, |end| end.since(since))
        };
        let excused =
            excuse(facts.last_store, NodeFacts::STORING).max(excuse(layer_setting, Self::LAYER_SETTING)).max(shift);
        let is_lost = silence > missing.of(period) + excused + Duration::from_millis(10);
        is_lost.then_some(Outage { since, sign, orders: watch.orders })
    }

    /// Time that a node may take to restart after a reset.
    pub(crate) fn restart_limit(&self, node: NodeId) -> Duration {
        self.nodes[node].restart.map_or(Self::RESTART, |longest| longest.times(2) + Duration::from_secs(1))
    }

    /// Handles a heartbeat; the next one is due after `period`.
    pub fn beat(&mut self, node: NodeId, period: Option<Duration>) {
        self.alarms[node] = period.map(|period| Self::BEFORE_RESET.of(period));
    }

    /// Handles a message of a node.
    #[inline]
    pub fn heard(&mut self, node: NodeId) {
        if std::mem::take(&mut self.addressed[node]) {
            let watch = &mut self.nodes[node];
            (watch.guarding.unanswered, watch.orders) = (0, Orders::default());
        }
    }

    /// Notes the time from a node's reset to its boot-up.
    pub fn restarted(&mut self, node: NodeId, took: Duration) {
        let restart = &mut self.nodes[node].restart;
        *restart = (*restart).max(Some(took));
    }

    /// Handles a command of the master.
    pub fn commanded(&mut self, now: Timestamp, nmt: Nmt) {
        self.addressed.named_mut(nmt.node).for_each(|(_, addressed)| *addressed = true);
        for (_, watch) in self.nodes.named_mut(nmt.node) {
            let orders = &mut watch.orders;
            orders.last = Some((nmt.command, now));
            orders.shifts |= !nmt.command.is_reset() && orders.resets == 0;
            if nmt.command.is_reset() {
                orders.resets += 1;
                orders.first_reset.get_or_insert(now);
                orders.last_reset = Some(now);
            }
        }
    }

    /// Handles a guarding request of the master.
    pub fn guarded(&mut self, now: Timestamp, node: NodeId) {
        self.addressed[node] = true;
        let (watch, alarm) = (&mut self.nodes[node], &mut self.alarms[node]);
        let guarding = &mut watch.guarding;
        if let Some(interval) = guarding.asked.replace(now).map(|asked| now.since(asked))
            && guarding.unanswered == 0
        {
            guarding.interval = Some(interval);
            *alarm = (*alarm).max(Some(Self::BEFORE_RESET.of(interval)));
        }
        guarding.unanswered += u32::from(watch.orders.resets == 0);
    }

    /// Tells that frames may be missing here.
    pub fn interrupted(&mut self, now: Timestamp) {
        self.since = now;
        for watch in self.nodes.values_mut() {
            (watch.orders, watch.guarding) = (Orders::default(), Guarding::default());
        }
    }
}
