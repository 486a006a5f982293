//! The rhythm and the length of each PDO, as they are learned from its frames, for rules about PDOs of which no
//! configuration is known.

use super::beats::{Beats, Reasons};
use super::pace::{Beat, Odd, Pace};
use super::tpdos::{Parameters, TPDOS};
use crate::message::{Message, PdoNumber, Service};
use crate::network::Decoded;
use crate::{NodeId, PerNode};
use canvass_traces::{Duration, Record, Timestamp};

/// The TPDOs of all nodes.
#[derive(Default)]
pub struct Streams {
    nodes: PerNode<Option<Box<[Stream; TPDOS]>>>,
    /// The rhythm of all RPDOs that a node receives.
    received: PerNode<Beats>,
    /// Each RPDO of a node.
    rpdos: PerNode<Option<Box<[Stream; TPDOS]>>>,
    sync: Beats,
    /// The TPDOs that had been silent when they began anew: at most one entry for each TPDO.
    cut: Vec<Cut>,
}

/// An event after which the frames of a TPDO may come in another way.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reset {
    /// An NMT command that changes the state of the node.
    Command,
    /// A boot-up.
    BootUp,
    /// A write to the parameters of the TPDO.
    Parameters,
    /// Frames are missing in the capture, or its clock has stepped.
    Gap,
}

/// The TPDOs that begin anew.
#[derive(Clone, Copy, Debug)]
pub struct Restart {
    /// The node; all nodes if it is 0.
    pub node: u8,
    /// The TPDO, by its number from 1; `None` for all TPDOs of the node.
    pub number: Option<u16>,
    /// The reason.
    pub reset: Reset,
}

/// A TPDO that had been silent when it began anew.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// The node, which had to send the TPDO until then.
    pub node: NodeId,
    /// The number from 1.
    pub number: u16,
    /// The TPDO before it began anew.
    pub stream: Stream,
    /// The parameters of the TPDO at that time.
    pub parameters: Parameters,
    /// Time of the last message of the node before: until then the node certainly lived.
    pub until: Timestamp,
    /// The reason for which the TPDO began anew.
    pub reset: Reset,
    /// Other messages that may have been silent at that time.
    pub reasons: Reasons,
}

impl Restart {
    /// Whether a TPDO begins anew.
    fn concerns(&self, number: u16) -> bool {
        self.number.is_none_or(|only| only == number)
    }
}

impl Cut {
    /// Length of the silence.
    fn silence(&self) -> Duration {
        self.stream.last.map_or(Duration::ZERO, |last| self.until.since(last))
    }
}

/// One TPDO.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stream {
    /// Time of the last frame; `None` if none came since the last NMT command, boot-up or change of parameters.
    pub last: Option<Timestamp>,
    /// The CAN-ID of the last frame.
    pub can_id: u16,
    /// The learned period in nanoseconds; 0 if there is none.
    period: u64,
    /// Number of intervals that had the period.
    regular: u32,
    /// Weight of the intervals that differ from the period: each adds two, and each regular interval takes one off.
    off: u8,
    /// Number of frames with the data of the frame before, while the period was kept: a timer sends them, as no event
    /// has changed the data.
    unchanged: u32,
    /// The data of the last two frames, the later one last.
    data: [u64; 2],
    /// Follows the number of SYNC messages from one frame to the next.
    pace: Pace,
    /// Number of consecutive periods in which an additional frame came.
    additional: u8,
    length: u8,
    /// Number of consecutive frames with the length `length`.
    same_length: u32,
    /// The length of the last frame.
    last_length: u8,
    /// The last two intervals, the later one last.
    before: [u64; 2],
    /// Number of consecutive times that the period was divided as the period before it.
    divided: u8,
    /// The longest interval in nanoseconds.
    longest: u64,
    /// Whether a remote frame has asked for the TPDO.
    pub polled: bool,
    /// Number of times that a regular TPDO came again after a silence of many periods.
    pub pauses: u8,
    /// The period before the last silence of many periods, in nanoseconds; 0 if the period since then is known.
    paused: u64,
    /// Time of the frame before that silence.
    paused_at: Option<Timestamp>,
}

/// The data of a frame, compared with the frames before it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Change {
    /// The data of the frame before.
    None,
    /// The data of the frame before that one: the frame between has other data.
    Back,
    /// Other data.
    Other,
}

/// An unusual event of a TPDO.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum StreamEvent {
    /// Nothing is unusual.
    #[default]
    Usual,
    /// The frame has another length than the many frames before it.
    Length {
        /// The length of the frames before.
        before: u8,
        /// Number of these frames.
        times: u32,
    },
    /// The TPDO comes again after a silence of many periods; its period is learned anew.
    Resumed {
        /// Time of the frame before.
        since: Timestamp,
        /// The period.
        period: Duration,
    },
    /// The TPDO has had the same period since the silence as before it.
    Returned,
    /// The first frame of the PDO in the capture.
    New,
    /// The PDO comes much later than its period allows.
    Late {
        /// Time of the frame before.
        since: Timestamp,
        /// The period.
        period: Duration,
    },
    /// The frame ends a period in which an additional frame with other data came.
    Additional {
        /// The period.
        period: Duration,
        /// Number of consecutive periods with an additional frame.
        times: u8,
    },
    /// The number of SYNC messages since the last frame is not the learned one.
    OutOfStep(Odd),
    /// After a frame that was out of step, the learned number of SYNC messages has returned.
    InStep,
    /// The period of the TPDO is divided into the same two parts again and again.
    Divided {
        /// The first part.
        first: Duration,
        /// The second part.
        second: Duration,
    },
}

impl Stream {
    /// Number of intervals from which a period is certain.
    const STEADY: u32 = 30;
    /// Number of frames with unchanged data that prove a timer.
    const UNCHANGED: u32 = 10;
    /// A silence of more than this number of periods is no delay.
    const SILENCE: u64 = 10;
    /// A shorter silence is no pause, however short the period.
    const PAUSE: u64 = 1_000_000_000;
    /// Number of intervals that show whether the period after a pause is the period before it.
    const RETURNED: u32 = 10;
    /// Number of frames that make a length usual.
    const USUAL_LENGTH: u32 = 10;
    /// Number of intervals with the period from which a divided one is unusual.
    const USUAL: u32 = 20;
    /// Number of intervals from which a single late frame is unusual.
    const PUNCTUAL: u32 = 50;
    /// Number of divisions that prove two senders.
    const DIVIDED: u8 = 8;
    /// Weight of differing intervals that shows another period.
    const OTHER: u8 = 8;

    /// Handles a frame.
    fn beat(&mut self, now: Timestamp, syncs: u32, can_id: u16, payload: &[u8]) -> StreamEvent {
        let is_new = std::mem::replace(&mut self.can_id, can_id) == 0;
        let length = self.length(payload.len() as u8);
        self.last_length = payload.len() as u8;
        let mut bytes = [0; 8];
        let data = payload.get(..8).unwrap_or(payload);
        bytes[..data.len()].copy_from_slice(data);
        let data = u64::from_le_bytes(bytes);
        let change = self.change(data);
        let pace = self.pace.beat(syncs, change == Change::None);
        let Some(last) = self.last.replace(now) else { return if is_new { StreamEvent::New } else { length } };
        let interval = now.since(last).nanos();
        let rhythm = self.interval(interval, change, last);
        self.longest = self.longest.max(interval);
        self.before = [self.before[1], interval];
        match (rhythm, pace) {
            (StreamEvent::Usual, Beat::Odd(odd)) => StreamEvent::OutOfStep(odd),
            (StreamEvent::Usual, Beat::Kept) => StreamEvent::InStep,
            (StreamEvent::Usual, Beat::Usual) => length,
            _ => rhythm,
        }
    }

    /// Compares the data with the data of the last two frames.
    fn change(&mut self, data: u64) -> Change {
        let [earlier, before] = self.data;
        self.data = [before, data];
        match data {
            _ if data == before => Change::None,
            _ if data == earlier => Change::Back,
            _ => Change::Other,
        }
    }

    fn length(&mut self, length: u8) -> StreamEvent {
        if length == self.length {
            self.same_length = self.same_length.saturating_add(1);
            return StreamEvent::Usual;
        }
        let (before, times) = (self.length, self.same_length);
        if times < Self::USUAL_LENGTH || length == self.last_length {
            // The other length becomes usual once it has come twice in a row.
            (self.length, self.same_length) = (length, 1);
        }
        if times < Self::USUAL_LENGTH { StreamEvent::Usual } else { StreamEvent::Length { before, times } }
    }

    fn interval(&mut self, interval: u64, change: Change, last: Timestamp) -> StreamEvent {
        let period = self.period;
        if interval > period * Self::SILENCE && self.is_timed() {
            self.off = 0;
            return if interval > Self::PAUSE { self.resumed(interval, last) } else { StreamEvent::Usual };
        }
        if self.divides(interval) {
            self.divided = self.divided.saturating_add(1);
            let event = StreamEvent::Divided { first: Duration(self.before[1]), second: Duration(interval) };
            return if self.divided >= Self::DIVIDED { event } else { StreamEvent::Usual };
        }
        if near(interval, period, period / 8 + 2_000_000) {
            (self.divided, self.additional) = (0, 0);
            self.regular = self.regular.saturating_add(1);
            self.unchanged += u32::from(change == Change::None && self.unchanged < Self::UNCHANGED);
            self.off = self.off.saturating_sub(1);
            if self.paused != 0 && self.regular >= Self::RETURNED {
                return self.returned();
            }
        } else if change == Change::Back && self.completes(interval) {
            return self.additional();
        } else {
            let event = self.late(interval, last);
            self.off += 2;
            if self.off >= Self::OTHER || self.regular == 0 {
                (self.period, self.regular, self.off, self.unchanged, self.divided) = (interval, 0, 0, 0, 0);
            }
            return event;
        }
        StreamEvent::Usual
    }

    /// Whether the last two intervals together make one period, so that the frame between them is additional. Two equal
    /// intervals do not count: a sender that has doubled its rate causes them.
    fn completes(&self, interval: u64) -> bool {
        let before = self.before[1];
        let (short, long) = (interval.min(before), interval.max(before));
        let close = self.period / 16 + 1_000_000;
        self.is_timed()
            && !self.pace.is_certain()
            && near(interval + before, self.period, close)
            && long - short > self.period / 8
    }

    /// Counts a period with an additional frame.
    #[cold]
    fn additional(&mut self) -> StreamEvent {
        // The interval before has counted as a sign of another period, which it was not.
        self.off = self.off.saturating_sub(2);
        self.additional = self.additional.saturating_add(1);
        StreamEvent::Additional { period: Duration(self.period), times: self.additional }
    }

    /// Reports a frame that is late after many punctual ones.
    fn late(&self, interval: u64, since: Timestamp) -> StreamEvent {
        let is_late = self.regular >= Self::PUNCTUAL
            && self.is_timed()
            && !self.pace.is_certain()
            && self.longest * 2 < self.period * 3
            && interval * 5 > self.period * 9;
        if is_late { StreamEvent::Late { since, period: Duration(self.period) } } else { StreamEvent::Usual }
    }

    /// Ends a pause. A device that left its period may send on events from now on, so the period must be proven anew.
    #[cold]
    fn resumed(&mut self, interval: u64, since: Timestamp) -> StreamEvent {
        let period = std::mem::replace(&mut self.period, interval);
        (self.regular, self.off, self.unchanged, self.divided) = (0, 0, 0, 0);
        (self.pauses, self.paused, self.paused_at) = (self.pauses.saturating_add(1), period, Some(since));
        StreamEvent::Resumed { since, period: Duration(period) }
    }

    /// Compares the period after a pause with the period before it.
    #[cold]
    fn returned(&mut self) -> StreamEvent {
        let before = std::mem::take(&mut self.paused);
        let is_same = near(before, self.period, before / 8 + 2_000_000);
        if is_same { StreamEvent::Returned } else { StreamEvent::Usual }
    }

    /// Whether the last two intervals together are the period, and the period is divided as it was before. Equal halves
    /// do not count: a sender that has doubled its rate causes them.
    fn divides(&self, interval: u64) -> bool {
        let [earlier, before] = self.before;
        let close = self.period / 16 + 1_000_000;
        let (short, long) = (interval.min(before), interval.max(before));
        self.regular >= Self::USUAL
            && near(interval + before, self.period, close)
            && near(interval, earlier, close)
            && short * 100 < self.period * 45
            && long - short > 2 * close
    }

    /// Whether a timer sends the TPDO: its period is certain, and was kept while its data did not change.
    fn is_timed(&self) -> bool {
        self.regular >= Self::STEADY && self.unchanged >= Self::UNCHANGED && !self.polled
    }

    /// The length that its frames have.
    pub fn usual_length(&self) -> u8 {
        self.length
    }

    /// Whether an interval was as long as the event timer allows, so that the device sends by its event timer. A device
    /// may have lost an event timer that it was given, for example by a reset.
    pub fn obeys(&self, timer: Duration) -> bool {
        4 * self.longest >= 3 * timer.nanos()
    }

    /// Time of the frame before the last long silence, if the period since then is not known yet.
    pub fn resumed_since(&self) -> Option<Timestamp> {
        self.paused_at.filter(|_| self.paused != 0)
    }

    /// The period, if a timer sends the TPDO.
    pub fn period(&self) -> Option<Duration> {
        self.is_timed().then_some(Duration(self.period))
    }
}

const fn near(a: u64, b: u64, close: u64) -> bool {
    a.abs_diff(b) <= close
}

impl Streams {
    /// Handles a frame of a service with PDOs, or SYNC.
    #[inline]
    pub(super) fn frame(&mut self, record: &Record, decoded: &Decoded) -> StreamEvent {
        let (now, syncs) = (record.timestamp, self.sync.count());
        match (decoded.message, decoded.node) {
            (Message::Pdo(PdoNumber::Transmit(number)), Some(node)) => match self.slot(node, number) {
                Some(stream) => stream.beat(now, syncs, record.frame.cob_id().unwrap_or(0), record.frame.data()),
                None => StreamEvent::Usual,
            },
            (Message::Pdo(PdoNumber::Receive(number)), Some(node)) => {
                self.received[node].beat(now);
                let rows = self.rpdos[node].get_or_insert_default();
                match usize::from(number).checked_sub(1).and_then(|at| rows.get_mut(at)) {
                    Some(stream) => stream.beat(now, syncs, record.frame.cob_id().unwrap_or(0), record.frame.data()),
                    None => StreamEvent::Usual,
                }
            }
            (Message::PdoRequest(PdoNumber::Transmit(number)), Some(node)) => {
                if let Some(stream) = self.slot(node, number) {
                    stream.polled = true;
                }
                StreamEvent::Usual
            }
            _ if decoded.service == Service::Sync => {
                self.sync.beat(now);
                StreamEvent::Usual
            }
            _ => StreamEvent::Usual,
        }
    }

    fn slot(&mut self, node: NodeId, number: u16) -> Option<&mut Stream> {
        self.nodes[node].get_or_insert_default().get_mut(usize::from(number).checked_sub(1)?)
    }

    /// All TPDOs: node, number from 1.
    pub fn all(&self) -> impl Iterator<Item = (NodeId, u16, &Stream)> {
        let known = self.nodes.iter().filter_map(|(node, rows)| Some((node, rows.as_deref()?)));
        known.flat_map(|(node, rows)| (1..).zip(rows).map(move |(number, row)| (node, number, row)))
    }

    /// All RPDOs: node, number from 1.
    pub fn received(&self) -> impl Iterator<Item = (NodeId, u16, &Stream)> {
        let known = self.rpdos.iter().filter_map(|(node, rows)| Some((node, rows.as_deref()?)));
        known.flat_map(|(node, rows)| (1..).zip(rows).map(move |(number, row)| (node, number, row)))
    }

    /// One TPDO, by its number from 1.
    pub fn get(&self, node: NodeId, number: u16) -> Option<&Stream> {
        self.nodes[node].as_deref()?.get(usize::from(number).checked_sub(1)?)
    }

    /// The TPDOs that had been silent when they began anew, each with its longest silence.
    pub fn cut(&self) -> &[Cut] {
        &self.cut
    }

    /// The messages whose pauses may explain the silence of a node's TPDOs.
    pub fn reasons(&self, node: NodeId) -> Reasons {
        Reasons { sync: self.sync, received: self.received[node] }
    }

    /// Keeps the silent TPDOs of a node that will begin anew; `until` is the time of the node's last message.
    #[cold]
    pub(super) fn cut_off<'p>(
        &mut self,
        node: NodeId,
        restart: Restart,
        until: Timestamp,
        parameters: impl Fn(u16) -> &'p Parameters,
    ) {
        let reasons = self.reasons(node);
        let Self { nodes, cut, .. } = self;
        let rows = (1..).zip(nodes[node].iter().flat_map(|rows| rows.iter()));
        for (number, stream) in rows.filter(|(number, _)| restart.concerns(*number)) {
            let parameters = *parameters(number);
            let Some(period) = parameters.event_timer.or_else(|| stream.period()) else { continue };
            let new = Cut { node, number, stream: *stream, parameters, until, reset: restart.reset, reasons };
            if new.silence() > period.times(2) {
                keep_longest(cut, new);
            }
        }
    }

    /// Makes TPDOs begin anew: they may stop, or have other parameters.
    #[cold]
    pub(super) fn restart(&mut self, restart: Restart) {
        if restart.number.is_none() {
            let rows = self.rpdos.named_mut(restart.node).flat_map(|(_, rows)| rows.iter_mut());
            let all = rows.flat_map(|rows| rows.iter_mut());
            all.for_each(|row| *row = Stream { can_id: row.can_id, ..Stream::default() });
        }
        for (_, rows) in self.nodes.named_mut(restart.node) {
            let rows = (1..).zip(rows.iter_mut().flat_map(|rows| rows.iter_mut()));
            for (_, row) in rows.filter(|(number, _)| restart.concerns(*number)) {
                let Stream { can_id, polled, pauses, .. } = *row;
                *row = Stream { can_id, polled, pauses, ..Stream::default() };
            }
        }
    }

    /// Tells that frames may be missing here.
    pub(super) fn interrupted(&mut self) {
        let rows = self.nodes.values_mut().chain(self.rpdos.values_mut()).flatten();
        rows.flat_map(|rows| rows.iter_mut()).for_each(|row| (row.last, row.pace) = (None, Pace::default()));
    }
}

/// Keeps one silence of each TPDO, so that the memory is bounded.
fn keep_longest(all: &mut Vec<Cut>, new: Cut) {
    match all.iter_mut().find(|old| (old.node, old.number) == (new.node, new.number)) {
        Some(old) if old.silence() >= new.silence() => {}
        Some(old) => *old = new,
        None => all.push(new),
    }
}
