//! Whether nodes are there: silences that are longer than their heartbeat, or the guarding of the master, allows.

use super::node::NodeFacts;
use crate::findings::percent::Percent;
use crate::wire::nmt::{Command, Nmt};
use crate::{NodeId, PerNode};
use canvass_traces::{Duration, Timestamp};

/// What is known of the presence of all nodes of a bus.
#[derive(Default)]
pub struct Presence {
    nodes: PerNode<Watch>,
    /// A silence that is not longer is none; `None` where nothing is expected of the node.
    alarms: PerNode<Option<Duration>>,
    /// Whether the master has told or asked the node something since it last sent something.
    addressed: PerNode<bool>,
    /// Nothing is known of before: frames may be missing there.
    since: Timestamp,
}

/// One node.
#[derive(Clone, Copy, Default)]
struct Watch {
    orders: Orders,
    guarding: Guarding,
    /// The longest time that it has taken to restart when it was reset.
    restart: Option<Duration>,
}

/// What the master has told a node since it last sent something.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Orders {
    /// How often it was reset.
    pub resets: u32,
    /// The first reset.
    pub first_reset: Option<Timestamp>,
    /// The last reset.
    pub last_reset: Option<Timestamp>,
    /// The last of all commands.
    pub last: Option<(Command, Timestamp)>,
    /// Whether another command came before the first reset: the heartbeat may begin anew with it.
    pub shifts: bool,
}

/// How the master guards a node.
#[derive(Clone, Copy, Default)]
struct Guarding {
    asked: Option<Timestamp>,
    interval: Option<Duration>,
    /// Requests since the node last sent something, before it was reset.
    unanswered: u32,
}

/// By what it is known that a node should have sent something.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Sign {
    /// Its heartbeat, with its period.
    Heartbeat(Duration),
    /// The guarding requests of the master, with their distance.
    Guarding(Duration),
}

/// The silence of a node that should have sent something.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Outage {
    /// When it last sent something.
    pub since: Timestamp,
    /// What has not come.
    pub sign: Sign,
    /// What the master told it in the meantime.
    pub orders: Orders,
}

impl Presence {
    /// A longer silence, of the period, is an outage.
    const MISSING: Percent = Percent(300);
    /// The same before a reset: a master that waits for one and a half periods resets the node sooner.
    const BEFORE_RESET: Percent = Percent(150);
    /// Resets that follow each other sooner are one: some masters reset communication and then the node.
    const RETRY: Duration = Duration::from_secs(2);
    /// How long a node that is there may take to restart, before the capture has shown how long it takes.
    const RESTART: Duration = Duration::from_secs(10);
    /// How long a node may be silent around layer setting.
    const LAYER_SETTING: Duration = Duration::from_secs(10);

    /// Whether a silence of that length may be an outage.
    #[inline]
    pub fn is_long(&self, node: NodeId, silence: Duration) -> bool {
        self.alarms[node].is_some_and(|alarm| silence > alarm)
    }

    /// The silence of a node, if it is longer than what the node was commanded in the meantime explains. `period` is that of
    /// its heartbeat, `layer_setting` when the LSS master last said something that may reset nodes.
    pub fn outage(
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
        // What follows a reset is the reset's, unless the master has to repeat it.
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
        // A command that changes the state may let the heartbeat begin anew.
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

    /// How long a node may take to restart after a reset.
    pub fn restart_limit(&self, node: NodeId) -> Duration {
        self.nodes[node].restart.map_or(Self::RESTART, |longest| longest.times(2) + Duration::from_secs(1))
    }

    /// A heartbeat has come, and the next one is due after that period.
    pub fn beat(&mut self, node: NodeId, period: Option<Duration>) {
        self.alarms[node] = period.map(|period| Self::BEFORE_RESET.of(period));
    }

    /// A node has sent something.
    #[inline]
    pub fn heard(&mut self, node: NodeId) {
        if std::mem::take(&mut self.addressed[node]) {
            let watch = &mut self.nodes[node];
            (watch.guarding.unanswered, watch.orders) = (0, Orders::default());
        }
    }

    /// A node that was there has restarted so long after it was reset.
    pub fn restarted(&mut self, node: NodeId, took: Duration) {
        let restart = &mut self.nodes[node].restart;
        *restart = (*restart).max(Some(took));
    }

    /// The master has sent a command.
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

    /// The master has asked a node for its state.
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

    /// Frames may be missing here.
    pub fn interrupted(&mut self, now: Timestamp) {
        self.since = now;
        for watch in self.nodes.values_mut() {
            (watch.orders, watch.guarding) = (Orders::default(), Guarding::default());
        }
    }
}
