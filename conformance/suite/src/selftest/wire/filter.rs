//! The filter between a device and the bus, which makes one error in the device's frames.

use super::mutant::{Change, FieldChange, FrameChange, Mutant, When};
use super::primitive::{Primitive, Recognition};
use canvass_analyzer::wire::Field;
use canvass_analyzer::wire::layer_setting::{MASTER_CAN_ID, Protocol};
use canvass_analyzer::wire::nmt::{self, Nmt};
use canvass_analyzer::wire::{Wire, sdo};
use canvass_bus::Machine;
use canvass_device::Device;
use canvass_traces::{CanId, Duration, Frame, Timestamp};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// Delay of a late frame: longer than the tester waits for any SDO response.
pub const LATE: Duration = Duration::from_millis(1_500);

/// Share of the period after which an early frame is sent, in percent.
const EARLY_PERCENT: u64 = 60;

/// The primitives that the filter has seen, and the number of its changes.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// For each primitive in [`Primitive::all`], whether it was sent.
    pub sent: Vec<bool>,
    /// Number of frames that were changed.
    pub changed: u64,
}

/// A device with a filter.
#[derive(Clone)]
pub struct Filter {
    base: Device,
    mutant: Option<Mutant>,
    primitives: Arc<[Primitive]>,
    recognition: Recognition,
    tally: Arc<Mutex<Tally>>,
    history: History,
    /// Frames to be sent, each not before its time. A frame with [`Timestamp::MAX`] waits for the next frame of the
    /// device.
    held: VecDeque<(Timestamp, Frame)>,
}

/// The earlier messages of the mutant's sort.
#[derive(Clone, Debug, Default)]
struct History {
    count: u64,
    /// The previous message, before its change, with its time.
    before: Option<(Timestamp, Frame)>,
    /// The latest message about another object than `before`.
    other: Option<Frame>,
    /// Whether no message of the sort was sent since the last reset.
    was_reset: bool,
    /// Whether the next message has already been sent, early.
    is_ahead: bool,
}

impl Filter {
    /// A filter that turns a right device into the mutant; without a mutant it only observes.
    pub fn new(base: Device, protocol: Protocol, mutant: Option<Mutant>, primitives: Arc<[Primitive]>) -> Self {
        let tally = Tally { sent: vec![false; primitives.len()], changed: 0 };
        Self {
            base,
            mutant,
            primitives,
            recognition: Recognition::new(protocol),
            tally: Arc::new(Mutex::new(tally)),
            history: History::default(),
            held: VecDeque::new(),
        }
    }

    /// The tally, which the filter continues to update.
    pub fn tally(&self) -> Arc<Mutex<Tally>> {
        Arc::clone(&self.tally)
    }

    fn node(&self) -> u16 {
        self.base.node().map_or(0, |node| u16::from(node.raw()))
    }

    fn counted(&self, count: impl FnOnce(&mut Tally)) {
        count(&mut self.tally.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// The frame that is sent for a frame of the device, if any.
    fn filtered(&mut self, now: Timestamp, frame: Frame) -> Option<Frame> {
        // Frames that wait for the next frame of the device follow this one.
        let waiting = self.held.iter_mut().filter(|(due, _)| *due == Timestamp::MAX);
        waiting.for_each(|(due, _)| *due = now);
        let node = self.node();
        let Some((service, layout)) = self.recognition.sent(&frame, node) else { return Some(frame) };
        if let Some(place) = self.primitives.iter().position(|known| known.is(service, layout)) {
            self.counted(|tally| tally.sent[place] = true);
        }
        let Some(mutant) = self.mutant.filter(|mutant| mutant.primitive.is(service, layout)) else {
            return Some(frame);
        };
        let is_wrong = self.history.is_due(mutant.when);
        let changed = if is_wrong { self.changed(now, mutant.change, frame) } else { Some(frame) };
        self.history.remember(now, frame);
        changed
    }

    fn changed(&mut self, now: Timestamp, change: Change, frame: Frame) -> Option<Frame> {
        let changed = match change {
            Change::Field(field, change) => self.history.with_field(frame, field, change),
            Change::Frame(FrameChange::Lost) => None,
            Change::Frame(FrameChange::Doubled) => {
                self.held.push_back((now, frame));
                self.counted(|tally| tally.changed += 1);
                return Some(frame);
            }
            Change::Frame(FrameChange::Late) => {
                self.held.push_back((now + LATE, frame));
                None
            }
            Change::Frame(FrameChange::Swapped) => {
                self.held.push_back((Timestamp::MAX, frame));
                None
            }
            Change::Frame(FrameChange::Early) => return self.ahead(now, frame),
            Change::Frame(change) => reformed(frame, change),
        };
        if changed != Some(frame) {
            self.counted(|tally| tally.changed += 1);
        }
        changed
    }

    /// Sends the next periodic message before its time; for answers see [`Filter::answer_early`].
    fn ahead(&mut self, now: Timestamp, frame: Frame) -> Option<Frame> {
        if std::mem::take(&mut self.history.is_ahead) {
            return None;
        }
        let Some((before, _)) = self.history.before.filter(|_| !self.is_answer()) else { return Some(frame) };
        let soon = Duration::from_nanos(now.since(before).nanos() / 100 * EARLY_PERCENT);
        self.held.push_back((now + soon, frame));
        self.history.is_ahead = true;
        self.counted(|tally| tally.changed += 1);
        Some(frame)
    }

    fn is_answer(&self) -> bool {
        use canvass_analyzer::Service;
        self.mutant.is_some_and(|mutant| matches!(mutant.primitive.service, Service::Sdo | Service::Lss | Service::Lmt))
    }

    /// Queues the answer to an earlier request ahead of the right answer.
    fn answer_early(&mut self, now: Timestamp, request: &Frame) {
        let is_early = self.mutant.is_some_and(|mutant| mutant.change == Change::Frame(FrameChange::Early));
        let id = request.id().as_standard();
        let asks = id == Some(sdo::REQUEST_BASE + self.node()) || id == Some(MASTER_CAN_ID);
        if let Some((_, before)) = self.history.before.filter(|_| is_early && asks && self.is_answer())
            && self.mutant.is_some_and(|mutant| self.history.is_due(mutant.when))
        {
            self.held.push_back((now, before));
            self.counted(|tally| tally.changed += 1);
        }
    }
}

impl History {
    fn is_due(&self, when: When) -> bool {
        match when {
            When::First => self.count == 0,
            When::Every => true,
            When::EverySecond => self.count % 2 == 1,
            When::AfterReset => self.was_reset,
        }
    }

    fn remember(&mut self, now: Timestamp, frame: Frame) {
        let object = |frame: &Frame| frame.data().get(1..4).map(<[u8]>::to_vec);
        if let Some((_, before)) = self.before.filter(|(_, before)| object(before) != object(&frame)) {
            self.other = Some(before);
        }
        self.before = Some((now, frame));
        self.count += 1;
        self.was_reset = false;
    }

    /// The frame with a changed field; the unchanged frame if it lacks the field.
    fn with_field(&self, frame: Frame, field: Field, change: FieldChange) -> Option<Frame> {
        let Some(field) = field.within(frame.len()) else { return Some(frame) };
        let Some(now) = field.get(frame.data()) else { return Some(frame) };
        let ones = if field.bits >= 64 { u64::MAX } else { (1 << field.bits) - 1 };
        let of = |earlier: Option<Frame>| earlier.and_then(|earlier| field.get(earlier.data())).unwrap_or(now);
        let value = match change {
            FieldChange::Zero => 0,
            FieldChange::Ones => ones,
            FieldChange::Plus => now.wrapping_add(1) & ones,
            FieldChange::Minus => now.wrapping_sub(1) & ones,
            FieldChange::Flip => now ^ 1 << (field.bits.saturating_sub(1)),
            FieldChange::Before => of(self.before.map(|(_, before)| before)),
            FieldChange::Other => of(self.other),
        };
        let mut bytes = frame.data().to_vec();
        field.set(&mut bytes, value);
        Some(Frame::new(frame.id(), &bytes).unwrap_or(frame))
    }
}

/// The frame in a changed form.
fn reformed(frame: Frame, change: FrameChange) -> Option<Frame> {
    let (id, data) = (frame.id().raw(), frame.data());
    let standard = |id: u32| CanId::standard_masked(id);
    Some(match change {
        FrameChange::Shorter => Frame::new(frame.id(), data.get(..data.len().saturating_sub(1))?)?,
        FrameChange::Longer => Frame::new(frame.id(), &[data, &[0]].concat()).unwrap_or(frame),
        FrameChange::Empty => Frame::new(frame.id(), &[])?,
        FrameChange::IdPlus => Frame::new(standard(id + 1), data)?,
        FrameChange::IdMinus => Frame::new(standard(id.saturating_sub(1)), data)?,
        FrameChange::Remote => Frame::remote(frame.id(), data.len() as u8)?,
        FrameChange::Extended => Frame::new(CanId::extended(id)?, data)?,
        _ => frame,
    })
}

impl Machine for Filter {
    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        let node = self.node();
        self.recognition.heard(frame, node);
        let concerns = |nmt: Nmt| nmt.command.is_reset() && (nmt.node == 0 || u16::from(nmt.node) == node);
        if frame.cob_id() == Some(nmt::CAN_ID) && Nmt::read(frame.data()).is_ok_and(concerns) {
            self.held.clear();
            self.history.was_reset = true;
        }
        self.answer_early(now, frame);
        if !self.base.ignores(frame) {
            self.base.handle(now, frame);
        }
    }

    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame> {
        if let Some(place) = self.held.iter().position(|(due, _)| *due <= now) {
            return self.held.remove(place).map(|(_, frame)| frame);
        }
        while let Some(frame) = self.base.poll_transmit(now) {
            if let Some(frame) = self.filtered(now, frame) {
                return Some(frame);
            }
        }
        None
    }

    fn poll_timeout(&self) -> Option<Timestamp> {
        let held = self.held.iter().map(|(due, _)| *due).filter(|due| *due < Timestamp::MAX).min();
        [self.base.poll_timeout(), held].into_iter().flatten().min()
    }

    fn handle_timeout(&mut self, now: Timestamp) {
        if self.base.poll_timeout().is_some_and(|timeout| timeout <= now) {
            self.base.handle_timeout(now);
        }
    }

    fn bit_rate(&self) -> Option<u32> {
        Machine::bit_rate(&self.base)
    }

    fn power_cycle(&mut self, now: Timestamp) {
        self.held.clear();
        self.history.was_reset = true;
        Machine::power_cycle(&mut self.base, now);
    }

    fn withdraws(&self, pending: &Frame) -> bool {
        self.base.withdraws(pending)
    }
}
