//! What one node has done.

use crate::wire::nmt::Command;
use canvass_traces::{Duration, Timestamp};

/// What a node has done so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct NodeFacts {
    /// When it first sent something.
    pub first_seen: Option<Timestamp>,
    /// When it last sent something.
    pub last_seen: Option<Timestamp>,
    /// The CAN-ID of that.
    pub last_id: Option<u16>,
    /// The last NMT command to it, alone or among all.
    pub command: Option<(Command, Timestamp)>,
    /// The last reset by NMT command that no boot-up has followed yet.
    pub pending_reset: Option<Timestamp>,
    /// The longest silence since then: a node that was not silent has not restarted.
    pub longest_pause: Duration,
    /// When an SDO client last wrote anything.
    pub last_download: Option<Timestamp>,
    /// When parameters were last asked to be stored or restored, or that was answered: some devices are silent for
    /// seconds around it.
    pub last_store: Option<Timestamp>,
    /// When its program was last started or stopped (1F50h, 1F51h).
    pub last_program_control: Option<Timestamp>,
    /// The last boot-up.
    pub last_boot_up: Option<Timestamp>,
    /// Whether it has shown to be an NMT slave: a command named it, it has answered an SDO client, or sends TPDOs or EMCY.
    /// The NMT master does not hear its own commands to all.
    pub is_slave: bool,
    /// The node-ID that it had is another one since its reset.
    pub has_moved: bool,
}

impl NodeFacts {
    /// Some devices are silent for seconds while they write their memory.
    pub const STORING: Duration = Duration::from_secs(5);

    /// Whether the node may be silent because it writes its memory.
    pub fn is_storing(&self, now: Timestamp) -> bool {
        Self::is_recent(self.last_store, now, Self::STORING)
    }

    /// Whether the node may be silent because it was reset: lately, or it has not said anything since.
    pub fn is_resetting(&self, now: Timestamp) -> bool {
        let lately = self.pending_reset.is_some_and(|reset| now.since(reset) <= Duration::from_secs(5));
        lately || self.is_silent_since_reset()
    }

    /// Whether no boot-up has followed the last reset, nor anything else than what was queued then.
    pub fn is_silent_since_reset(&self) -> bool {
        const QUEUED: Duration = Duration::from_millis(50);
        self.pending_reset.is_some_and(|reset| self.last_seen.is_none_or(|seen| seen <= reset + QUEUED))
    }

    /// Whether something that happened at `then` is at most `span` ago.
    pub fn is_recent(then: Option<Timestamp>, now: Timestamp, span: Duration) -> bool {
        then.is_some_and(|then| now.since(then) <= span)
    }
}
