//! Events that the bench notices in passing, whatever the case tests.

use canvass_analyzer::NodeId;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{self, Emcy};
use canvass_analyzer::wire::error_control::{self, ErrorControl};
use canvass_analyzer::wire::lss;
use canvass_analyzer::wire::sdo::{self, Request};
use canvass_traces::{Direction, Duration, Record, Timestamp};
use std::collections::BTreeSet;

/// Maximum time between two boot-up messages of the same start: only the boot-up cases judge the second message.
pub(super) const SAME_START: Duration = Duration::from_millis(500);

/// Maximum time from a guarding request to its answer. An answer that shows state 0 looks like a boot-up message; the
/// guarding cases judge it.
const GUARDED: Duration = Duration::from_millis(100);

/// Maximum number of EMCYs that are remembered, enough even for a storm.
const EMERGENCIES: usize = 16;

/// Boot-up messages that no command explains: the first of each sort in a case.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Boots {
    /// The device restarted without being told to.
    pub unasked: Option<Timestamp>,
    /// The second boot-up message of a start, if a frame was sent to the device after the first. It is a restart,
    /// unless every start of the device has two.
    pub second: Option<Timestamp>,
}

/// The passive observer.
#[derive(Debug)]
pub struct Watch {
    node: NodeId,
    awaiting_boot_up: bool,
    last_boot_up: Option<Timestamp>,
    restarted: Option<Timestamp>,
    /// The first boot-up message within [`SAME_START`] after another, if a frame was sent to the device between them.
    second_boot_up: Option<Timestamp>,
    /// Whether the tester has sent a frame since the last boot-up.
    sent_since: bool,
    /// The time of the guarding request that the device has not answered yet.
    guarded: Option<Timestamp>,
    emergencies: Vec<(Timestamp, Emcy)>,
    provoked: bool,
    others: BTreeSet<NodeId>,
    /// Node-IDs that the tester gave to the device under test: a node that uses one of them is not another node.
    given: BTreeSet<NodeId>,
    stores: u32,
    /// Whether the case has stored something.
    stored: bool,
    /// Whether the case has restored defaults.
    loaded: bool,
    /// Whether the case has configured another bit rate by LSS.
    configured_bit_rate: bool,
    /// Whether the case has commanded the device to become operational.
    started: bool,
}

impl Watch {
    pub fn new(node: NodeId) -> Self {
        Self {
            node,
            awaiting_boot_up: false,
            last_boot_up: None,
            restarted: None,
            second_boot_up: None,
            sent_since: false,
            guarded: None,
            emergencies: Vec::new(),
            provoked: false,
            others: BTreeSet::new(),
            given: BTreeSet::new(),
            stores: 0,
            stored: false,
            loaded: false,
            configured_bit_rate: false,
            started: false,
        }
    }

    /// Records a reset command: the next boot-up is no surprise.
    pub(crate) fn expect_boot_up(&mut self) {
        self.awaiting_boot_up = true;
    }

    /// Records that the device was commanded to become operational.
    pub fn start(&mut self) {
        self.started = true;
    }

    /// Whether the case has commanded the device to become operational.
    pub(crate) const fn has_started(&self) -> bool {
        self.started
    }

    /// Declares that the case provokes errors: EMCYs are no surprise.
    pub(crate) fn expect_emergencies(&mut self) {
        self.provoked = true;
    }

    /// Takes a frame from the bus.
    pub fn observe(&mut self, record: &Record) {
        let Some(cob_id) = record.frame.cob_id() else {
            self.on_remote(record);
            return;
        };
        if record.direction == Direction::Tx {
            self.sent_since = true;
            let memory = memory_command(cob_id, record.data(), self.node);
            self.stores += u32::from(memory.is_some());
            self.stored |= memory.is_some();
            self.loaded |= memory == Some(MemoryCommand::Load);
            let is_lss = cob_id == lss::MASTER_CAN_ID;
            self.configured_bit_rate |=
                is_lss && matches!(lss::Request::read(record.data()), Ok(lss::Request::ConfigureBitTiming { .. }));
            return;
        }
        let Some(node) = NodeId::of_cob_id(cob_id) else { return };
        let is_error_control = cob_id & 0x780 == error_control::CAN_ID_BASE;
        if node != self.node {
            // Heartbeats and boot-ups are certain signs that the node is present.
            if is_error_control && !self.given.contains(&node) {
                self.others.insert(node);
            }
        } else if is_error_control {
            let asked = self.guarded.take().filter(|asked| record.timestamp.since(*asked) <= GUARDED);
            if asked.is_some() && !self.awaiting_boot_up {
                return;
            }
            if ErrorControl::read(record.frame.data()).is_ok_and(ErrorControl::is_boot_up) {
                self.on_boot_up(record.timestamp);
            }
        } else if cob_id & 0x780 == emcy::CAN_ID_BASE
            && let Ok(emcy) = Emcy::read(record.frame.data())
        {
            self.on_emergency(record.timestamp, emcy);
        }
    }

    fn on_remote(&mut self, record: &Record) {
        let id = error_control::CAN_ID_BASE + u16::from(self.node.raw());
        if record.direction == Direction::Tx && record.frame.is_remote() && record.frame.id().as_standard() == Some(id)
        {
            self.guarded = Some(record.timestamp);
        }
    }

    fn on_boot_up(&mut self, at: Timestamp) {
        let same_start = self.last_boot_up.is_some_and(|last| at.since(last) < SAME_START);
        if !self.awaiting_boot_up && !same_start {
            self.restarted.get_or_insert(at);
        } else if !self.awaiting_boot_up && self.sent_since {
            self.second_boot_up.get_or_insert(at);
        }
        self.awaiting_boot_up = false;
        self.sent_since = false;
        self.last_boot_up = Some(at);
    }

    fn on_emergency(&mut self, at: Timestamp, emcy: Emcy) {
        let is_error = emcy.code().is_some_and(|code| !code.is_reset());
        if is_error && !self.provoked && self.emergencies.len() < EMERGENCIES {
            self.emergencies.push((at, emcy));
        }
    }

    /// The boot-up messages that no command explains.
    pub fn boots(&self) -> Boots {
        Boots { unasked: self.restarted, second: self.second_boot_up }
    }

    /// The errors that the device reported.
    pub fn emergencies(&self) -> impl Iterator<Item = &(Timestamp, Emcy)> {
        self.emergencies.iter()
    }

    /// Number of commands since the start of the run that made the device write its non-volatile memory.
    pub fn stores(&self) -> u32 {
        self.stores
    }

    /// Whether the device was commanded to write its non-volatile memory in this case.
    pub fn has_stored(&self) -> bool {
        self.stored
    }

    /// Whether the device was commanded to restore its defaults in this case: it may use them until power-off and keep
    /// other values in its memory.
    pub(crate) fn has_loaded(&self) -> bool {
        self.loaded
    }

    /// Records that a case of an earlier run may have restored defaults.
    pub(crate) fn assume_loaded(&mut self) {
        self.loaded = true;
    }

    /// Whether the case has configured another bit rate.
    pub(crate) fn has_configured_bit_rate(&self) -> bool {
        self.configured_bit_rate
    }

    /// Records that a case of an earlier run may have configured another bit rate.
    pub(crate) fn assume_configured_bit_rate(&mut self) {
        self.configured_bit_rate = true;
    }

    /// Records that another node has answered.
    pub(crate) fn add_other(&mut self, node: NodeId) {
        if !self.given.contains(&node) {
            self.others.insert(node);
        }
    }

    /// Records that the device under test may use this node-ID from now on.
    pub(crate) fn add_given(&mut self, node: NodeId) {
        self.others.remove(&node);
        self.given.insert(node);
    }

    /// Whether the device under test was given this node-ID.
    pub fn is_given(&self, node: NodeId) -> bool {
        self.given.contains(&node)
    }

    /// The other nodes that were heard since the start of the run.
    pub fn others(&self) -> &BTreeSet<NodeId> {
        &self.others
    }

    /// Forgets the events that belong to one case.
    pub fn forget(&mut self) {
        self.restarted = None;
        self.second_boot_up = None;
        self.emergencies.clear();
        self.provoked = false;
        self.stored = false;
        self.loaded = false;
        self.configured_bit_rate = false;
        self.started = false;
    }
}

/// A command that makes a device write its non-volatile memory.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum MemoryCommand {
    /// "save" to 1010h, or LSS store configuration.
    Store,
    /// "load" to 1011h: the device marks in its memory that the defaults are to be loaded.
    Load,
}

/// The command of an own frame; `None` if the frame is another one.
pub(super) fn memory_command(cob_id: u16, data: &[u8], node: NodeId) -> Option<MemoryCommand> {
    if cob_id == lss::MASTER_CAN_ID {
        let stores = lss::Request::read(data) == Ok(lss::Request::StoreConfiguration);
        return stores.then_some(MemoryCommand::Store);
    }
    let Ok(Request::InitiateDownload { multiplexer, payload }) = Request::read(data) else { return None };
    if cob_id != sdo::REQUEST_BASE + u16::from(node.raw()) {
        return None;
    }
    match (multiplexer.index.0, payload.value()) {
        (object::STORE_PARAMETERS, Some(b"save")) => Some(MemoryCommand::Store),
        (object::RESTORE_DEFAULT_PARAMETERS, Some(b"load")) => Some(MemoryCommand::Load),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_traces::ChannelId;

    fn boot_up(at_ms: u64) -> Record {
        let frame = ErrorControl::BOOT_UP.to_frame(0x73F);
        Record::new(Timestamp::ZERO + Duration::from_millis(at_ms), ChannelId(0), frame)
    }

    #[test]
    fn a_boot_up_that_nobody_commanded_is_a_restart() {
        let mut watch = Watch::new(NodeId::new(63).unwrap());
        watch.expect_boot_up();
        watch.observe(&boot_up(100));
        watch.observe(&boot_up(110));
        assert_eq!(watch.boots().unasked, None, "twice in one start is another case's matter");
        watch.observe(&boot_up(2_000));
        assert_eq!(watch.boots().unasked, Some(Timestamp(2_000_000_000)));
    }

    #[test]
    fn a_node_id_that_the_tester_gave_is_no_other_node() {
        let mut watch = Watch::new(NodeId::new(62).unwrap());
        watch.add_given(NodeId::new(63).unwrap());
        watch.observe(&boot_up(1));
        assert!(watch.others().is_empty());
    }

    #[test]
    fn other_nodes_are_heard() {
        let mut watch = Watch::new(NodeId::new(62).unwrap());
        watch.observe(&boot_up(1));
        assert_eq!(watch.boots().unasked, None);
        assert!(watch.others().contains(&NodeId::new(63).unwrap()));
    }

    /// A second boot-up within half a second belongs to the same start; a later one is a restart, and the first restart
    /// counts.
    #[test]
    fn one_start_may_have_two_boot_ups() {
        let restarted = |second: u64| {
            let mut watch = Watch::new(NodeId::new(63).unwrap());
            watch.expect_boot_up();
            watch.observe(&boot_up(100));
            watch.observe(&boot_up(second));
            watch.observe(&boot_up(5_000));
            watch.boots().unasked.map(|at| at.0 / 1_000_000)
        };
        assert_eq!((restarted(599), restarted(600)), (Some(5_000), Some(600)));
        let mut watch = Watch::new(NodeId::new(63).unwrap());
        watch.observe(&boot_up(1));
        assert_eq!(watch.boots().unasked, Some(Timestamp(1_000_000)), "nobody has commanded the first either");
        watch.forget();
        assert_eq!(watch.boots().unasked, None);
    }

    fn record(text: &str, direction: Direction) -> Record {
        Record::new(Timestamp::ZERO, ChannelId(0), crate::scripted::frame(text)).with_direction(direction)
    }

    /// "save" to 1010h, "load" to 1011h and LSS store configuration count as a store if the tester sends them.
    #[test]
    fn what_makes_a_device_store() {
        let stores = |text: &str, direction: Direction| {
            let mut watch = Watch::new(NodeId::new(63).unwrap());
            watch.observe(&record(text, direction));
            assert_eq!(watch.has_stored(), watch.stores() == 1);
            watch.stores()
        };
        for stored in ["63F#2310100173617665", "63F#2310100373617665", "63F#231110016C6F6164", "7E5#1700000000000000"] {
            assert_eq!((stores(stored, Direction::Tx), stores(stored, Direction::Rx)), (1, 0), "{stored}");
        }
        for other in [
            "63E#2310100173617665",
            "63F#231010016C6F6164",
            "63F#2311100173617665",
            "63F#2317100173617665",
            "63F#4010100100000000",
            "63F#2310100173617664",
            "7E5#1100000000000000",
            "7E4#1700000000000000",
        ] {
            assert_eq!(stores(other, Direction::Tx), 0, "{other}");
        }
    }

    /// The first error control message soon after a guarding request is its answer, whatever state it shows.
    #[test]
    fn the_answer_to_guarding_is_no_restart() {
        let restarted = |asked: u64, booted: &[u64], awaits: bool| {
            let mut watch = Watch::new(NodeId::new(63).unwrap());
            if awaits {
                watch.expect_boot_up();
            }
            let request = Record::new(Timestamp(asked * 1_000_000), ChannelId(0), crate::scripted::frame("73F#R1"));
            watch.observe(&request.with_direction(Direction::Tx));
            booted.iter().for_each(|at| watch.observe(&boot_up(*at)));
            watch.boots().unasked.map(|at| at.0 / 1_000_000)
        };
        assert_eq!(restarted(1_000, &[1_100], false), None);
        assert_eq!(restarted(1_000, &[1_101], false), Some(1_101), "too late for an answer");
        assert_eq!(restarted(1_000, &[1_010, 1_020], false), Some(1_020), "only the first answers");
        assert_eq!(restarted(1_000, &[1_010, 3_000], true), Some(3_000), "the awaited start");
    }

    /// Of a storm of errors sixteen are kept. The end of an error does not count, nor does an error of another node.
    #[test]
    fn the_first_errors_are_kept() {
        let mut watch = Watch::new(NodeId::new(63).unwrap());
        for text in ["0BE#3081110000000000", "0BF#0000000000000000", "0BF#30", "1BF#3081110000000000"] {
            watch.observe(&record(text, Direction::Rx));
        }
        assert_eq!(watch.emergencies().count(), 0);
        for n in 0..20 {
            watch.observe(&record(&format!("0BF#308111{n:02X}00000000"), Direction::Rx));
        }
        let kept: Vec<u8> = watch.emergencies().map(|(_, emcy)| emcy.to_frame(0xBF).data()[3]).collect();
        assert_eq!(kept, (0..16).collect::<Vec<u8>>());
    }

    /// Only error control messages are a certain sign of another node.
    #[test]
    fn others_are_those_that_send_error_control() {
        let heard = |text: &str| {
            let mut watch = Watch::new(NodeId::new(63).unwrap());
            watch.observe(&record(text, Direction::Rx));
            watch.others().iter().map(|node| node.raw()).collect::<Vec<u8>>()
        };
        assert_eq!((heard("705#05"), heard("705#00"), heard("77F#7F")), (vec![5], vec![5], vec![127]));
        for text in ["185#00", "585#00", "085#00", "73F#05", "700#05", "7E4#00"] {
            assert!(heard(text).is_empty(), "{text}");
        }
        let mut watch = Watch::new(NodeId::new(63).unwrap());
        watch.observe(&record("705#05", Direction::Rx));
        watch.add_given(NodeId::new(5).unwrap());
        assert!(watch.others().is_empty() && watch.is_given(NodeId::new(5).unwrap()));
        watch.add_other(NodeId::new(5).unwrap());
        watch.add_other(NodeId::new(6).unwrap());
        assert_eq!(watch.others().iter().map(|node| node.raw()).collect::<Vec<u8>>(), [6]);
    }
}
