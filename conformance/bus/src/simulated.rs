//! A bus in memory with a clock of its own.
//!
//! Time is virtual: it advances from one event to the next, so a wait of five seconds takes only the computing time of
//! its events, and every run is the same. A frame lasts as long as its bits take. When the bus is free, the lowest
//! identifier among the participants' next frames is sent; each participant has one frame in arbitration at a time,
//! like a CAN controller with a FIFO. A participant does not understand frames of another bit rate.

use super::{Bus, BusError};
use crate::Machine;
use canvass_traces::{ChannelId, Direction, Duration, Frame, INTERMISSION, Record, Timestamp, bit_length};
use std::collections::VecDeque;

/// Shortest interval between two timeouts of a machine: no controller's main loop is faster.
const SOONEST: Duration = Duration::from_micros(100);

/// Simulated participants, the tester, and the wire between them.
pub struct SimulatedBus {
    now: Timestamp,
    bit_rate: u32,
    /// The time from which the next frame may begin.
    free_from: Timestamp,
    participants: Vec<Participant>,
    /// The tester's waiting frames, oldest first.
    outgoing: VecDeque<Frame>,
    on_wire: Option<OnWire>,
    /// The earliest timeout of all participants.
    next_timeout: Timestamp,
    /// Whether any participant has a frame in arbitration.
    contended: bool,
}

struct Participant {
    machine: Box<dyn Machine>,
    /// The participant's frame in arbitration.
    pending: Option<Frame>,
    /// The next timeout; [`Timestamp::MAX`] if there is none.
    timeout: Timestamp,
    /// The participant's own bit rate in bit/s, if it has one.
    own_bit_rate: Option<u32>,
    /// The bit rate that the bus had before the tester changed it.
    adopted: Option<u32>,
}

#[derive(Clone, Copy)]
struct OnWire {
    frame: Frame,
    sender: Sender,
    end: Timestamp,
    /// The bit rate in bit/s.
    bit_rate: u32,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Sender {
    Tester,
    Participant(usize),
}

impl SimulatedBus {
    /// An empty bus with a bit rate in bit/s (at least 1), switched on at time 0.
    pub fn new(bit_rate: u32) -> Self {
        Self {
            now: Timestamp::ZERO,
            bit_rate: bit_rate.max(1),
            free_from: Timestamp::ZERO,
            participants: Vec::new(),
            outgoing: VecDeque::with_capacity(64),
            on_wire: None,
            next_timeout: Timestamp::MAX,
            contended: false,
        }
    }

    /// A copy of the bus in the same state, if each participant can be copied ([`Machine::duplicate`]).
    pub fn duplicate(&self) -> Option<Self> {
        let participants = self.participants.iter().map(Participant::duplicate).collect::<Option<_>>()?;
        let (outgoing, on_wire) = (self.outgoing.clone(), self.on_wire);
        Some(Self { participants, outgoing, on_wire, ..*self })
    }

    /// Connects a participant. If identifiers in arbitration are equal, the earlier participant wins.
    pub fn attach(&mut self, machine: Box<dyn Machine>) {
        let timeout = machine.poll_timeout().unwrap_or(Timestamp::MAX);
        let bit_rate = machine.bit_rate();
        self.participants.push(Participant { machine, pending: None, timeout, own_bit_rate: bit_rate, adopted: None });
        self.next_timeout = self.next_timeout.min(timeout);
    }

    /// Switches a participant off and on, by its index. A frame that it is already sending is completed.
    pub fn power_cycle(&mut self, participant: usize) {
        if let Some(participant) = self.participants.get_mut(participant) {
            participant.machine.power_cycle(self.now);
            participant.settle(self.now);
        }
        self.survey();
    }

    /// Takes up a participant that was changed from outside, by its index: its next frame and timeout may be others.
    pub fn take_up(&mut self, participant: usize) {
        if let Some(participant) = self.participants.get_mut(participant) {
            participant.settle(self.now);
        }
        self.survey();
    }

    /// The time of the next event, if there is one.
    pub fn next_time(&self) -> Option<Timestamp> {
        self.next_event().map(|next| next.time().max(self.now))
    }

    /// The duration of `n` bits.
    fn bits(n: u32, bit_rate: u32) -> Duration {
        Duration(u64::from(n) * 1_000_000_000 / u64::from(bit_rate.max(1)))
    }

    /// Calls every participant whose timeout is due at `self.now`.
    fn fire_timeouts(&mut self) {
        for participant in &mut self.participants {
            if participant.timeout <= self.now {
                participant.machine.handle_timeout(self.now);
                participant.settle(self.now);
                // Time must advance even if a machine always requests a call at once.
                participant.timeout = participant.timeout.max(self.now + SOONEST);
            }
        }
        self.survey();
    }

    /// Updates the cached timeouts and pending frames, so that a step need not check all participants.
    fn survey(&mut self) {
        (self.next_timeout, self.contended) = (Timestamp::MAX, false);
        for participant in &self.participants {
            self.next_timeout = self.next_timeout.min(participant.timeout);
            self.contended |= participant.pending.is_some();
        }
    }

    /// The sender of the identifier that wins arbitration now, if there is one.
    fn arbitrate(&self) -> Option<Sender> {
        let mut winner = self.outgoing.front().map(|frame| (priority(frame), Sender::Tester));
        for (n, participant) in self.participants.iter().enumerate() {
            if let Some(frame) = &participant.pending {
                let own = priority(frame);
                if winner.is_none_or(|(best, _)| own < best) {
                    winner = Some((own, Sender::Participant(n)));
                }
            }
        }
        winner.map(|(_, sender)| sender)
    }

    /// Puts the winner's frame on the wire.
    fn begin(&mut self, sender: Sender) {
        let frame = match sender {
            Sender::Tester => self.outgoing.pop_front(),
            Sender::Participant(n) => self.participants.get_mut(n).and_then(|p| p.take_pending(self.now)),
        };
        debug_assert!(
            frame.is_some() && self.on_wire.is_none(),
            "the winner of arbitration has a frame for the free bus"
        );
        if let Some(frame) = frame {
            let bit_rate = self.bit_rate_of(sender);
            let end = self.now + Self::bits(bit_length(&frame).unwrap_or(0), bit_rate);
            self.on_wire = Some(OnWire { frame, sender, end, bit_rate });
        }
        if sender != Sender::Tester {
            self.survey();
        }
    }

    /// Delivers a completed frame to all participants but its sender.
    fn deliver(&mut self, sent: OnWire) -> Option<Record> {
        debug_assert!(self.now <= sent.end, "a frame ends before later events");
        self.now = sent.end;
        self.free_from = sent.end + Self::bits(INTERMISSION, sent.bit_rate);
        let usual = self.bit_rate;
        for (n, participant) in self.participants.iter_mut().enumerate() {
            let understands = participant.bit_rate().unwrap_or(usual) == sent.bit_rate;
            if understands && sent.sender != Sender::Participant(n) && !participant.machine.ignores(&sent.frame) {
                participant.machine.handle(self.now, &sent.frame);
                participant.settle(self.now);
            }
        }
        self.survey();
        let direction = if sent.sender == Sender::Tester { Direction::Tx } else { Direction::Rx };
        let understood = sent.bit_rate == self.bit_rate;
        understood.then(|| Record::new(self.now, ChannelId(0), sent.frame).with_direction(direction))
    }

    fn bit_rate_of(&self, sender: Sender) -> u32 {
        let own = match sender {
            Sender::Tester => None,
            Sender::Participant(n) => self.participants.get(n).and_then(Participant::bit_rate),
        };
        own.unwrap_or(self.bit_rate)
    }

    /// Advances to the next event, at most to `deadline`; returns the record of a completed frame.
    fn step(&mut self, deadline: Timestamp) -> BusStep {
        let Some(next) = self.next_event() else { return BusStep::Idle };
        let at = next.time().max(self.now);
        if at > deadline {
            return BusStep::Idle;
        }
        self.now = at;
        match next {
            Next::Timeout(_) => self.fire_timeouts(),
            Next::FrameEnd(sent) => {
                self.on_wire = None;
                return self.deliver(sent).map_or(BusStep::Quiet, BusStep::Frame);
            }
            Next::BusFree(_) => {
                if let Some(sender) = self.arbitrate() {
                    self.begin(sender);
                }
            }
        }
        BusStep::Quiet
    }

    /// The next event. Timeouts precede frames of the same instant.
    fn next_event(&self) -> Option<Next> {
        let timeout = (self.next_timeout < Timestamp::MAX).then_some(Next::Timeout(self.next_timeout));
        let wire = match self.on_wire {
            Some(sent) => Some(Next::FrameEnd(sent)),
            None => self.someone_waits().then_some(Next::BusFree(self.free_from)),
        };
        match (timeout, wire) {
            (Some(timeout), Some(wire)) => Some(if timeout.time() <= wire.time() { timeout } else { wire }),
            (timeout, wire) => timeout.or(wire),
        }
    }

    fn someone_waits(&self) -> bool {
        self.contended || !self.outgoing.is_empty()
    }
}

enum Next {
    Timeout(Timestamp),
    FrameEnd(OnWire),
    BusFree(Timestamp),
}

impl Next {
    const fn time(&self) -> Timestamp {
        match self {
            Self::Timeout(time) | Self::BusFree(time) => *time,
            Self::FrameEnd(sent) => sent.end,
        }
    }
}

enum BusStep {
    Frame(Record),
    Quiet,
    /// There is no event before the deadline.
    Idle,
}

impl Participant {
    fn duplicate(&self) -> Option<Self> {
        Some(Self { machine: self.machine.duplicate()?, ..*self })
    }

    /// The participant's bit rate in bit/s; `None` if it has that of the bus.
    fn bit_rate(&self) -> Option<u32> {
        self.own_bit_rate.or(self.adopted)
    }

    /// Takes the machine's next frame and timeout; must follow every call of the machine.
    fn settle(&mut self, now: Timestamp) {
        if self.pending.is_some_and(|frame| self.machine.withdraws(&frame)) {
            self.pending = None;
        }
        if self.pending.is_none() {
            self.pending = self.machine.poll_transmit(now);
        }
        self.timeout = self.machine.poll_timeout().unwrap_or(Timestamp::MAX);
        self.own_bit_rate = self.machine.bit_rate();
    }

    /// Returns the frame in arbitration, and takes the machine's next frame.
    fn take_pending(&mut self, now: Timestamp) -> Option<Frame> {
        let frame = self.pending.take();
        self.settle(now);
        frame
    }
}

/// The order of arbitration: the identifier, then data before remote frames.
const fn priority(frame: &Frame) -> (canvass_traces::CanId, bool) {
    (frame.id(), frame.is_remote())
}

impl Bus for SimulatedBus {
    fn now(&self) -> Timestamp {
        self.now
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        if frame.is_error() || frame.is_fd() || frame.is_xl() {
            let reason = "expected a classical data or remote frame";
            return Err(BusError::Unsendable { frame: *frame, reason });
        }
        self.outgoing.push_back(*frame);
        Ok(())
    }

    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
        loop {
            match self.step(deadline) {
                BusStep::Frame(record) => return Ok(Some(record)),
                BusStep::Quiet => {}
                BusStep::Idle => {
                    // A wait without end must not advance time to its end, if the bus has no events.
                    if deadline < Timestamp::MAX {
                        self.now = self.now.max(deadline);
                    }
                    return Ok(None);
                }
            }
        }
    }

    fn bit_rate(&self) -> Option<u32> {
        Some(self.bit_rate)
    }

    /// Changes the tester's bit rate; participants without their own bit rate keep the old one.
    fn set_bit_rate(&mut self, bit_rate: u32) -> Result<(), BusError> {
        for participant in &mut self.participants {
            participant.adopted.get_or_insert(self.bit_rate);
        }
        self.bit_rate = bit_rate.max(1);
        Ok(())
    }

    /// The tester acknowledges nothing on a simulated bus anyway.
    fn listen_at(&mut self, bit_rate: u32) -> Result<(), BusError> {
        self.set_bit_rate(bit_rate)
    }
}
