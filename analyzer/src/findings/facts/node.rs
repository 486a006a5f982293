//! Facts about one node.

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
    /// The last NMT command to the node or to all nodes.
    pub command: Option<(Command, Timestamp)>,
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
    /// The last boot-up.
    pub last_boot_up: Option<Timestamp>,
    /// Whether the node is known to be an NMT slave: a command named it, it has answered an SDO client, or it sends
    /// TPDOs or EMCY. The NMT master does not hear its own commands to all nodes.
    pub is_slave: bool,
    /// Whether the node has got another node-ID since its reset.
    pub has_moved: bool,
}

impl NodeFacts {
    /// Time for which some devices are silent while they write their memory.
    pub const STORING: Duration = Duration::from_secs(5);

    /// Whether the node may be silent because it writes its memory.
    pub fn is_storing(&self, now: Timestamp) -> bool {
        Self::is_recent(self.last_store, now, Self::STORING)
    }

    /// Whether the node may be silent because of a reset: the reset is recent, or the node has been silent since.
    pub fn is_resetting(&self, now: Timestamp) -> bool {
        let lately = self.pending_reset.is_some_and(|reset| now.since(reset) <= Duration::from_secs(5));
        lately || self.is_silent_since_reset()
    }

    /// Whether no boot-up has followed the last reset, nor any message that was not queued then.
    pub fn is_silent_since_reset(&self) -> bool {
        const QUEUED: Duration = Duration::from_millis(50);
        self.pending_reset.is_some_and(|reset| self.last_seen.is_none_or(|seen| seen <= reset + QUEUED))
    }

    /// Whether `then` is at most `span` before `now`.
    pub fn is_recent(then: Option<Timestamp>, now: Timestamp, span: Duration) -> bool {
        then.is_some_and(|then| now.since(then) <= span)
    }
}
