//! The rhythm and the length of each TPDO, as they are learned from its frames, for rules about PDOs of which no
//! configuration is known.

use super::tpdos::TPDOS;
use crate::message::{Message, PdoNumber, Service};
use crate::network::Decoded;
use crate::{NodeId, PerNode};
use canvass_traces::{Duration, Record, Timestamp};

/// The TPDOs of all nodes.
#[derive(Default)]
pub struct Streams {
    nodes: PerNode<Option<Box<[Stream; TPDOS]>>>,
    /// Time of the last RPDO to each node, and the number of RPDOs.
    received: PerNode<Option<(Timestamp, u32)>>,
    /// Time of the last SYNC.
    pub sync: Option<Timestamp>,
}

/// One TPDO.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stream {
    /// Time of the last frame; `None` if none came since the last NMT command, boot-up or change of parameters.
    pub last: Option<Timestamp>,
    /// The learned period in nanoseconds; 0 if there is none.
    period: u64,
    /// Number of intervals that had the period.
    regular: u32,
    /// Weight of the intervals that differ from the period: two for each, and one less for each regular one.
    off: u8,
    /// Number of frames with the data of the frame before, while the period was kept: a timer sends them, as no event
    /// has changed the data.
    unchanged: u32,
    data: u64,
    length: u8,
    /// Number of consecutive frames with the length `length`.
    same_length: u32,
    /// The length of the last frame.
    last_length: u8,
    /// The last two intervals, the later one last.
    before: [u64; 2],
    /// Number of consecutive times that the period was divided as the period before it.
    divided: u8,
    /// Whether a remote frame has asked for the TPDO.
    pub polled: bool,
}

/// What a TPDO shows that is unusual.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum StreamEvent {
    /// Nothing.
    #[default]
    Usual,
    /// It has another length than its many frames before.
    Length {
        /// The length of the frames before.
        before: u8,
        /// Number of these frames.
        times: u32,
    },
    /// It comes again after a silence of many periods.
    Resumed {
        /// Time of the frame before.
        since: Timestamp,
        /// The period.
        period: Duration,
    },
    /// Its period is divided into the same two parts again and again.
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
    /// A silence of more periods than this is no delay.
    const SILENCE: u64 = 10;
    /// Number of frames that make a length usual.
    const USUAL: u32 = 20;
    /// Number of divisions that prove two senders.
    const DIVIDED: u8 = 8;
    /// Weight of differing intervals that shows another period.
    const OTHER: u8 = 8;

    /// Handles a frame.
    fn beat(&mut self, now: Timestamp, payload: &[u8]) -> StreamEvent {
        let length = self.length(payload.len() as u8);
        self.last_length = payload.len() as u8;
        let mut bytes = [0; 8];
        let data = payload.get(..8).unwrap_or(payload);
        bytes[..data.len()].copy_from_slice(data);
        let data = u64::from_le_bytes(bytes);
        let is_same = std::mem::replace(&mut self.data, data) == data;
        let Some(last) = self.last.replace(now) else { return length };
        let interval = now.since(last).nanos();
        let rhythm = self.interval(interval, is_same, last);
        self.before = [self.before[1], interval];
        if rhythm == StreamEvent::Usual { length } else { rhythm }
    }

    fn length(&mut self, length: u8) -> StreamEvent {
        if length == self.length {
            self.same_length = self.same_length.saturating_add(1);
            return StreamEvent::Usual;
        }
        let (before, times) = (self.length, self.same_length);
        if times < Self::USUAL || length == self.last_length {
            // The other length becomes usual once it has come twice in a row.
            (self.length, self.same_length) = (length, 1);
        }
        if times < Self::USUAL { StreamEvent::Usual } else { StreamEvent::Length { before, times } }
    }

    fn interval(&mut self, interval: u64, is_same: bool, last: Timestamp) -> StreamEvent {
        let period = self.period;
        if self.is_timed() && interval > period * Self::SILENCE {
            self.off = 0;
            return StreamEvent::Resumed { since: last, period: Duration(period) };
        }
        if self.divides(interval) {
            self.divided = self.divided.saturating_add(1);
            let event = StreamEvent::Divided { first: Duration(self.before[1]), second: Duration(interval) };
            return if self.divided >= Self::DIVIDED { event } else { StreamEvent::Usual };
        }
        if near(interval, period, period / 8 + 2_000_000) {
            self.divided = 0;
            self.regular = self.regular.saturating_add(1);
            self.unchanged += u32::from(is_same && self.unchanged < Self::UNCHANGED);
            self.off = self.off.saturating_sub(1);
        } else {
            self.off += 2;
            if self.off >= Self::OTHER || self.regular == 0 {
                (self.period, self.regular, self.off, self.unchanged, self.divided) = (interval, 0, 0, 0, 0);
            }
        }
        StreamEvent::Usual
    }

    /// Whether the last two intervals together are the period, and the period is divided as it was before. Equal
    /// halves are none: one sender that has doubled its rate sends them.
    fn divides(&self, interval: u64) -> bool {
        let [earlier, before] = self.before;
        let close = self.period / 16 + 1_000_000;
        let (short, long) = (interval.min(before), interval.max(before));
        self.regular >= Self::USUAL
            && near(interval + before, self.period, close)
            && near(interval, earlier, close)
            && short * 100 < self.period * 38
            && long - short > 2 * close
    }

    /// Whether a timer sends the TPDO: its period is certain, and was kept while its data did not change.
    fn is_timed(&self) -> bool {
        self.regular >= Self::STEADY && self.unchanged >= Self::UNCHANGED && !self.polled
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
        let now = record.timestamp;
        match (decoded.message, decoded.node) {
            (Message::Pdo(PdoNumber::Transmit(number)), Some(node)) => match self.slot(node, number) {
                Some(stream) => stream.beat(now, record.frame.data()),
                None => StreamEvent::Usual,
            },
            (Message::Pdo(PdoNumber::Receive(_)), Some(node)) => {
                let received = &mut self.received[node];
                *received = Some((now, received.map_or(0, |received| received.1).saturating_add(1)));
                StreamEvent::Usual
            }
            (Message::PdoRequest(PdoNumber::Transmit(number)), Some(node)) => {
                if let Some(stream) = self.slot(node, number) {
                    stream.polled = true;
                }
                StreamEvent::Usual
            }
            _ if decoded.service == Service::Sync => {
                self.sync = Some(now);
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

    /// Time of the last RPDO to a node that receives RPDOs again and again.
    pub fn received(&self, node: NodeId) -> Option<Timestamp> {
        const OFTEN: u32 = 20;
        self.received[node].filter(|received| received.1 >= OFTEN).map(|received| received.0)
    }

    /// Begins anew with the TPDOs of a node, or of all nodes if it is 0: they may stop, or have other parameters.
    #[cold]
    pub(super) fn restart(&mut self, node: u8) {
        for (_, rows) in self.nodes.named_mut(node) {
            let rows = rows.iter_mut().flat_map(|rows| rows.iter_mut());
            rows.for_each(|row| *row = Stream { polled: row.polled, ..Stream::default() });
        }
    }

    /// Tells that frames may be missing here.
    pub(super) fn interrupted(&mut self) {
        let rows = self.nodes.values_mut().flatten().flat_map(|rows| rows.iter_mut());
        rows.for_each(|row| row.last = None);
    }
}
