//! The queue between the receiving thread and the reader of the frames: receiving does not wait for the reader.

use super::Health;
use super::clock::SteadyClock;
use canvass_traces::{Direction, Record, Timestamp};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A limited queue of received frames, with the health of the bus.
pub(super) struct Inbox {
    state: Mutex<InboxState>,
    arrived: Condvar,
    /// Whether the receiving thread holds frames that are not in the queue yet.
    delivering: AtomicBool,
    /// Whether no frame can be sent because the transmit queue stays full, while receiving works.
    stuck: AtomicBool,
    closed: AtomicBool,
}

struct InboxState {
    records: VecDeque<Record>,
    capacity: usize,
    health: Health,
    /// The time of the last frame that was taken: times of taken frames never decrease.
    last: Timestamp,
}

/// Capacity of the queue: twelve seconds of a full bus at 1 Mbit/s; 16 MiB.
const CAPACITY: usize = 1 << 18;

/// Maximum time by which the end of a wait is delayed for the receiving thread, which the system may have suspended.
const STALL: Duration = Duration::from_millis(500);

impl Inbox {
    pub fn new() -> Self {
        let state = InboxState {
            records: VecDeque::new(),
            capacity: CAPACITY,
            health: Health::default(),
            last: Timestamp::ZERO,
        };
        let state = Mutex::new(state);
        let [delivering, stuck, closed] = [false; 3].map(AtomicBool::new);
        Self { state, arrived: Condvar::new(), delivering, stuck, closed }
    }

    fn state(&self) -> MutexGuard<'_, InboxState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds received frames. If there are too many, the oldest are dropped and counted, so that a slow reader gets
    /// recent frames.
    pub fn deliver(&self, records: &mut Vec<Record>) {
        let mut state = self.state();
        state.records.extend(records.drain(..));
        let excess = state.records.len().saturating_sub(state.capacity);
        state.records.drain(..excess);
        state.health.lost += excess as u64;
        drop(state);
        self.arrived.notify_all();
    }

    /// Records an own frame and writes it. It is recorded first, since the answer may arrive before this thread
    /// continues; a frame that can't be written is removed again.
    pub(crate) fn send<E>(
        &self,
        record: &Record,
        clock: &SteadyClock,
        write: impl FnOnce() -> Result<(), E>,
    ) -> Result<(), E> {
        self.deliver(&mut vec![record.clone()]);
        write().inspect_err(|_| self.retract(record))?;
        let took = clock.now().since(record.timestamp);
        self.note(|health| health.transmit.add(took));
        Ok(())
    }

    /// Removes an own frame that could not be sent, unless the reader has taken it already.
    pub(crate) fn retract(&self, record: &Record) {
        let mut state = self.state();
        if let Some(at) = state.records.iter().rposition(|delivered| delivered == record) {
            state.records.remove(at);
        }
    }

    /// Limits the queue to `frames` frames.
    pub fn limit(&self, frames: usize) {
        self.state().capacity = frames.clamp(1, CAPACITY);
    }

    /// Sets whether the receiving thread holds frames of the system that are not in the queue yet.
    pub(crate) fn set_delivering(&self, delivering: bool) {
        self.delivering.store(delivering, Ordering::SeqCst);
    }

    /// Changes the health of the bus.
    pub fn note(&self, note: impl FnOnce(&mut Health)) {
        note(&mut self.state().health);
    }

    /// The health of the bus.
    pub fn health(&self) -> Health {
        self.state().health.clone()
    }

    /// Begins an interruption because the transmit queue stays full; it ends when a frame is taken.
    pub(crate) fn note_stuck(&self, now: Timestamp, trouble: String) {
        if !self.stuck.swap(true, Ordering::SeqCst) {
            self.note(|health| health.went_away(now, trouble));
        }
    }

    /// Notes that the transmit queue has taken a frame.
    pub(crate) fn note_taken(&self, now: Timestamp) {
        if self.stuck.swap(false, Ordering::SeqCst) {
            self.note(|health| health.came_back(now));
        }
    }

    /// Whether the bus is interrupted now, so that sending would fail. While the transmit queue is full, only an
    /// attempt to send shows whether it has room again.
    pub fn is_interrupted(&self) -> bool {
        !self.stuck.load(Ordering::SeqCst) && self.state().health.interrupted_since.is_some()
    }

    /// Tells the receiving thread to end.
    pub fn close(&self) {
        self.closed.store(true, Ordering::SeqCst);
    }

    pub fn is_closed(&self) -> bool {
        self.closed.load(Ordering::SeqCst)
    }

    /// The next record, or `None` if there was none before `deadline`. Records after `deadline` wait for the next call,
    /// so that every wait ends even on a bus that never falls silent. `pending` tells whether the system holds frames
    /// that the receiving thread has not fetched yet: a frame that arrived in time must not be missed because that
    /// thread is late.
    pub fn take(&self, clock: &SteadyClock, deadline: Timestamp, pending: impl Fn() -> bool) -> Option<Record> {
        // For a frame that arrived before this call, the delay counts from the call: the frame waited for the tester.
        let asked = clock.now();
        let mut state = self.state();
        let mut stalled = None;
        loop {
            let now = clock.now();
            if state.records.front().is_some_and(|record| is_between(record.timestamp, deadline, now)) {
                state.health.note_late_end(asked.max(deadline), now);
                return None;
            }
            if let Some(mut record) = state.records.pop_front() {
                record.timestamp = state.in_order(record.timestamp, now);
                if record.direction != Direction::Tx {
                    state.health.receive.add(now.since(record.timestamp.max(asked)));
                }
                return Some(record);
            }
            let wait = if now < deadline {
                deadline.since(now).into()
            } else {
                // The order matters: a frame that is no longer pending counts as being delivered, and it can't be
                // delivered while this thread holds the lock.
                let behind = pending() || self.delivering.load(Ordering::SeqCst);
                let since = *stalled.get_or_insert(now);
                if !behind || Duration::from(now.since(since)) > STALL {
                    state.health.note_late_end(asked.max(deadline), now);
                    return None;
                }
                Duration::from_micros(200)
            };
            state = self.arrived.wait_timeout(state, wait).unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

/// The parts of [`Bus`](crate::Bus) that are alike in all buses with an inbox, whose `shared` has the clock and the inbox.
macro_rules! receives_by_inbox {
    () => {
        fn now(&self) -> canvass_traces::Timestamp {
            self.shared.clock.now()
        }

        fn receive(
            &mut self,
            deadline: canvass_traces::Timestamp,
        ) -> Result<Option<canvass_traces::Record>, $crate::BusError> {
            Ok(self.shared.inbox.take(&self.shared.clock, deadline, || false))
        }

        fn is_live(&self) -> bool {
            true
        }

        fn health(&self) -> $crate::Health {
            self.shared.inbox.health()
        }

        fn is_interrupted(&self) -> bool {
            self.shared.inbox.is_interrupted()
        }

        fn limit_backlog(&mut self, frames: usize) {
            self.shared.inbox.limit(frames);
        }
    };
}
pub(crate) use receives_by_inbox;

impl InboxState {
    /// The time of a frame that is taken now. It is not before the time of the last frame: a frame of the tester itself
    /// may have been delivered while an older frame was still being fetched.
    fn in_order(&mut self, time: Timestamp, now: Timestamp) -> Timestamp {
        if time > now {
            // The time is wrong; it must not affect the times of later frames.
            return time;
        }
        self.last = self.last.max(time);
        self.last
    }
}

/// Whether the time is after the deadline. A time in the future is wrong and proves nothing.
fn is_between(time: Timestamp, deadline: Timestamp, now: Timestamp) -> bool {
    deadline < time && time <= now
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_traces::{CanId, ChannelId, Frame};

    fn record(clock: &SteadyClock) -> Record {
        let frame = Frame::full(CanId::standard_masked(1), [0; 8]);
        Record::new(clock.now(), ChannelId(0), frame).with_direction(Direction::Rx)
    }

    #[test]
    fn what_does_not_fit_is_counted() {
        let (inbox, clock) = (Inbox::new(), SteadyClock::start());
        let mut records = vec![record(&clock); CAPACITY + 7];
        inbox.deliver(&mut records);
        assert_eq!(inbox.health().lost, 7);
        let (mut taken, now) = (0, clock.now());
        while inbox.take(&clock, now, || false).is_some() {
            taken += 1;
        }
        assert_eq!((taken, inbox.health().receive.count()), (CAPACITY, CAPACITY as u64));
        inbox.limit(10);
        inbox.deliver(&mut vec![record(&clock); 25]);
        assert_eq!(inbox.health().lost, 7 + 15);
    }

    /// A reader that takes all frames up to the present comes to an end, even if more frames arrive.
    #[test]
    fn what_came_after_the_deadline_waits() {
        let (inbox, clock) = (Inbox::new(), SteadyClock::start());
        inbox.deliver(&mut vec![record(&clock)]);
        let deadline = clock.now();
        let mut later = record(&clock);
        later.timestamp = deadline + canvass_traces::Duration(1);
        let mut from_the_future = record(&clock);
        from_the_future.timestamp = deadline + canvass_traces::Duration::from_secs(3_600);
        inbox.deliver(&mut vec![later, from_the_future]);
        let take = |deadline| inbox.take(&clock, deadline, || false).is_some();
        assert_eq!([take(deadline), take(deadline), take(deadline)], [true, false, false]);
        let later = clock.now();
        assert_eq!([take(later), take(later), take(later)], [true, true, false]);
    }

    /// A frame that was fetched late is older than the tester's own frame, which was taken already.
    #[test]
    fn time_does_not_go_back() {
        let (inbox, clock) = (Inbox::new(), SteadyClock::start());
        let (older, own) = (record(&clock), record(&clock));
        inbox.deliver(&mut vec![own.clone()]);
        let take = || inbox.take(&clock, clock.now(), || false).unwrap().timestamp;
        assert_eq!(take(), own.timestamp);
        inbox.deliver(&mut vec![older]);
        assert_eq!(take(), own.timestamp);
    }

    #[test]
    fn a_wait_that_ends_late_is_counted() {
        let (inbox, clock) = (Inbox::new(), SteadyClock::start());
        let begun = clock.now();
        let stall = || clock.now().since(begun) < canvass_traces::Duration::from_millis(20);
        assert!(inbox.take(&clock, begun, stall).is_none());
        assert!(inbox.health().receive.longest() > Some(canvass_traces::Duration::from_millis(15)));
    }

    #[test]
    fn a_frame_that_the_receiving_thread_has_not_fetched_yet_is_waited_for() {
        let (inbox, clock) = (Inbox::new(), SteadyClock::start());
        let (fetched, in_time) = (AtomicBool::new(false), record(&clock));
        std::thread::scope(|scope| {
            scope.spawn(|| {
                std::thread::sleep(Duration::from_millis(5));
                inbox.set_delivering(true);
                fetched.store(true, Ordering::SeqCst);
                inbox.deliver(&mut vec![in_time]);
                inbox.set_delivering(false);
            });
            let deadline = clock.now();
            assert!(inbox.take(&clock, deadline, || !fetched.load(Ordering::SeqCst)).is_some());
            assert!(inbox.take(&clock, deadline, || false).is_none());
        });
    }
}
