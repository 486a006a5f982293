//! Facts about one node.

use crate::wire::error_control::State;
use crate::wire::nmt::Command;
use canvass_traces::{Duration, Timestamp};

/// The facts about a node.
#[derive(Clone, Copy, Debug, Default)]
pub struct NodeFacts {
    /// Time of the node's first message.
    pub first_seen: Option<Timestamp>,
    /// Time of the node's last message.
    pub last_seen: Option<Timestamp>,
    /// The CAN-ID of the node's last message.
    pub last_id: Option<u16>,
    /// Whether the last heartbeat, guarding answer, boot-up or start command shows the node in operational.
    pub operational: bool,
    /// Time at which error control last showed the node in operational.
    pub last_operational: Option<Timestamp>,
    /// The last NMT command to the node or to all nodes.
    pub command: Option<(Command, Timestamp)>,
    /// Whether the node has shown the state of `command`, and whether it has shown another one since.
    pub obedience: Obedience,
    /// The last reset by NMT command without a boot-up yet.
    pub pending_reset: Option<Timestamp>,
    /// The longest silence since `pending_reset`: a node without a pause has not restarted.
    pub longest_pause: Duration,
    /// Time of the last download by an SDO client.
    pub last_download: Option<Timestamp>,
    /// Time of the last request to store or restore parameters, or of its answer. Some devices are silent for seconds
    /// around this time.
    pub last_store: Option<Timestamp>,
    /// Time at which the node's program was last started or stopped (1F50h, 1F51h).
    pub last_program_control: Option<Timestamp>,
    /// The first boot-up.
    pub first_boot_up: Option<Timestamp>,
    /// The last boot-up.
    pub last_boot_up: Option<Timestamp>,
    /// Whether the last boot-up only repeated the boot-up before it.
    pub repeated_boot_up: bool,
    /// Whether the node has sent a single boot-up at a start, so that a second one is another start.
    pub boots_once: bool,
    /// Whether the node is known to be an NMT slave: a command named it, it has answered an SDO client, or it sends
    /// TPDOs or EMCY. The NMT master does not hear its own commands to all nodes.
    pub is_slave: bool,
    /// Whether the node has got another node-ID since its reset.
    pub has_moved: bool,
}

/// The effect of the last NMT command on a node, as error control shows it.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Obedience {
    /// The commanded state was not shown yet.
    #[default]
    Open,
    /// The node is in the commanded state.
    Reached,
    /// The node was in the commanded state and has left it by itself.
    Left,
}

impl NodeFacts {
    /// Time within which some devices send their boot-up message a second time.
    const TWICE: Duration = Duration::from_millis(500);

    /// Time for which some devices are silent while they write their memory.
    pub const STORING: Duration = Duration::from_secs(5);

    /// Whether the node may be silent because it writes its memory.
    pub fn is_storing(&self, now: Timestamp) -> bool {
        Self::is_recent(self.last_store, now, Self::STORING)
    }

    /// Whether the node may be silent because of a reset: the reset is recent, or the node has been silent since.
    pub(crate) fn is_resetting(&self, now: Timestamp) -> bool {
        let lately = self.pending_reset.is_some_and(|reset| now.since(reset) <= Duration::from_secs(5));
        lately || self.is_silent_since_reset()
    }

    /// Whether no boot-up has followed the last reset, nor any message that was not queued then.
    pub(crate) fn is_silent_since_reset(&self) -> bool {
        const QUEUED: Duration = Duration::from_millis(50);
        self.pending_reset.is_some_and(|reset| self.last_seen.is_none_or(|seen| seen <= reset + QUEUED))
    }

    /// Whether the node has not been seen yet, or was reset and has been silent since: it can't answer.
    pub(crate) fn is_absent(&self) -> bool {
        self.first_seen.is_none() || self.is_silent_since_reset()
    }

    /// Whether a boot-up now only repeats the last boot-up: some devices send two boot-ups at each start.
    pub(crate) fn repeats_boot_up(&self, now: Timestamp) -> bool {
        let same_start = Self::is_recent(self.last_boot_up, now, Self::TWICE) && self.pending_reset.is_none();
        same_start && !self.repeated_boot_up && !self.boots_once
    }

    /// Notes a boot-up.
    pub(super) fn booted(&mut self, now: Timestamp) {
        let repeats = self.repeats_boot_up(now);
        // A node that starts again and again sends a third boot-up as soon after the second as the second after the
        // first.
        let is_third = self.repeated_boot_up
            && self.pending_reset.is_none()
            && Self::is_recent(self.last_boot_up, now, Self::TWICE);
        self.boots_once |= !repeats && self.last_boot_up.is_some() && !self.repeated_boot_up || is_third;
        self.first_boot_up = self.first_boot_up.or(Some(now));
        (self.last_boot_up, self.repeated_boot_up) = (Some(now), repeats);
        (self.pending_reset, self.has_moved) = (None, false);
    }

    /// Notes a state that error control shows.
    pub(super) fn shown(&mut self, state: State, now: Timestamp) {
        self.operational = state == State::OPERATIONAL;
        if self.operational {
            self.last_operational = Some(now);
        }
        let Some(commanded) = self.command.and_then(|(command, _)| command.state()) else { return };
        self.obedience = match self.obedience {
            _ if state == commanded => Obedience::Reached,
            Obedience::Open => Obedience::Open,
            Obedience::Reached | Obedience::Left => Obedience::Left,
        };
    }

    /// Whether `then` is at most `span` before `now`.
    pub(crate) fn is_recent(then: Option<Timestamp>, now: Timestamp, span: Duration) -> bool {
        then.is_some_and(|then| now.since(then) <= span)
    }
}
