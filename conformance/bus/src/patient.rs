//! A bus that waits while it is interrupted: an adapter is unplugged and plugged in again, a connection breaks and is
//! reopened, an interface goes down and comes up.

use super::{Bus, BusError, Health};
use canvass_traces::{Direction, Duration, Frame, Record, Timestamp};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Limits of waiting for an interrupted bus.
#[derive(Clone, Debug)]
pub struct Endurance {
    /// Maximum duration of one interruption.
    pub patience: Duration,
    /// The time at which the use of the bus ends; `None` if it never ends. Later actions, such as restoring a device,
    /// wait for an interrupted bus for at most five more seconds.
    pub ends: Option<Instant>,
    /// Whether the user has ended the use of the bus, which has the same effect as the time `ends`.
    pub cancelled: Arc<AtomicBool>,
}

/// Maximum time after the end of the use for which the bus still waits during interruptions.
const LAST: std::time::Duration = std::time::Duration::from_secs(5);

/// Interval between two checks whether the interruption is over.
const LOOK: std::time::Duration = std::time::Duration::from_millis(10);

/// A bus that waits during interruptions. Frames sent just before an interruption, and frames during it, may be lost:
/// [`Health`] counts each interruption.
pub struct PatientBus<'a> {
    bus: &'a mut dyn Bus,
    endurance: Endurance,
    /// Time of the first attempt to send during the current interruption.
    waits_since: Option<Instant>,
    /// Time at which the bus noticed that the user had ended the use.
    cancelled_at: Option<Instant>,
    /// Whether any other node has sent a frame.
    has_heard: bool,
}

impl<'a> PatientBus<'a> {
    pub const fn new(bus: &'a mut dyn Bus, endurance: Endurance) -> Self {
        Self { bus, endurance, waits_since: None, cancelled_at: None, has_heard: false }
    }

    /// Whether the bus may take the frame later. If no other node was ever heard and none acknowledges, there is
    /// probably no other node.
    const fn may_end(&self, refused: &BusError) -> bool {
        refused.is_interruption() && (self.has_heard || !refused.is_full())
    }

    /// Waits a moment. `refused` is the error with which the bus refused a frame.
    fn wait(&mut self, refused: Option<&BusError>) -> Result<(), BusError> {
        let since = *self.waits_since.get_or_insert_with(Instant::now);
        if self.is_over(since) {
            return Err(self.not_back(since, refused));
        }
        std::thread::sleep(LOOK);
        Ok(())
    }

    /// Whether the bus no longer waits for the end of the interruption; the waiting began at `since`.
    fn is_over(&mut self, since: Instant) -> bool {
        let now = Instant::now();
        if self.endurance.cancelled.load(Ordering::Relaxed) {
            self.cancelled_at.get_or_insert(now);
        }
        let ends = [self.endurance.ends, self.cancelled_at].into_iter().flatten().min();
        ends.is_some_and(|ends| now >= ends + LAST) || now.duration_since(since) >= self.endurance.patience.into()
    }

    /// The time at which waiting began, if the bus no longer waits in the current interruption.
    fn given_up(&mut self) -> Option<Instant> {
        let since = self.waits_since.filter(|_| self.bus.is_interrupted())?;
        self.is_over(since).then_some(since)
    }

    fn not_back(&self, since: Instant, refused: Option<&BusError>) -> BusError {
        let trouble = self.bus.health().trouble.or_else(|| refused.map(ToString::to_string));
        let trouble = trouble.unwrap_or_else(|| "the bus was interrupted".to_owned());
        let waited = Duration::from_millis(u64::try_from(since.elapsed().as_millis()).unwrap_or(u64::MAX));
        BusError::Interrupted { trouble, waited }
    }
}

impl Bus for PatientBus<'_> {
    fn now(&self) -> Timestamp {
        self.bus.now()
    }

    /// # Errors
    /// [`BusError::Interrupted`] if the bus does not come back in time; further frames are then refused at once until
    /// it is back.
    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        let mut refused = None;
        loop {
            if !self.bus.is_interrupted() {
                match self.bus.send(frame) {
                    Err(error) if self.may_end(&error) => refused = Some(error),
                    sent => {
                        self.waits_since = None;
                        return sent;
                    }
                }
            }
            self.wait(refused.as_ref())?;
        }
    }

    /// # Errors
    /// [`BusError::Interrupted`] once the bus has not come back in time, until it is back: no frame can arrive.
    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
        let given_up = self.given_up();
        let until = if given_up.is_some() { deadline.min(self.bus.now()) } else { deadline };
        let received = self.bus.receive(until)?;
        self.has_heard |= received.as_ref().is_some_and(|record| record.direction == Direction::Rx);
        match (received, given_up) {
            (None, Some(since)) => Err(self.not_back(since, None)),
            (received, _) => Ok(received),
        }
    }

    fn bit_rate(&self) -> Option<u32> {
        self.bus.bit_rate()
    }

    fn is_live(&self) -> bool {
        self.bus.is_live()
    }

    fn wait_for_client(&mut self, patience: Duration) -> Result<(), BusError> {
        self.bus.wait_for_client(patience)
    }

    fn dirty_padding(&mut self) {
        self.bus.dirty_padding();
    }

    fn health(&self) -> Health {
        self.bus.health()
    }

    fn is_interrupted(&self) -> bool {
        self.bus.is_interrupted()
    }

    fn wait_until_back(&mut self) -> Result<(), BusError> {
        while self.bus.is_interrupted() {
            self.wait(None)?;
        }
        Ok(())
    }

    fn limit_backlog(&mut self, frames: usize) {
        self.bus.limit_backlog(frames);
    }

    fn only(&mut self, cob_ids: &[(u16, u16)]) -> Result<(), BusError> {
        self.bus.only(cob_ids)
    }

    fn set_bit_rate(&mut self, bit_rate: u32) -> Result<(), BusError> {
        self.bus.set_bit_rate(bit_rate)
    }

    fn listen_at(&mut self, bit_rate: u32) -> Result<(), BusError> {
        self.bus.listen_at(bit_rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pcan::{PcanError, Status as PcanStatus};
    use crate::slcan::SlCanError;
    use canvass_traces::{CanId, ChannelId};
    use std::time;

    /// A bus that takes frames except during an interruption. It reports the interruption at once, or only by refusing
    /// a frame.
    struct Broken {
        back: Instant,
        tells: bool,
        sent: usize,
    }

    impl Bus for Broken {
        fn now(&self) -> Timestamp {
            Timestamp::ZERO
        }

        fn send(&mut self, _: &Frame) -> Result<(), BusError> {
            assert!(!self.tells || !self.is_interrupted(), "what is known to be refused is not tried");
            if Instant::now() < self.back {
                return Err(SlCanError::NotConnected { name: "tcp://there".to_owned() }.into());
            }
            self.sent += 1;
            Ok(())
        }

        fn receive(&mut self, _: Timestamp) -> Result<Option<Record>, BusError> {
            Ok(None)
        }

        fn bit_rate(&self) -> Option<u32> {
            None
        }

        fn is_interrupted(&self) -> bool {
            self.tells && Instant::now() < self.back
        }

        fn health(&self) -> Health {
            Health { trouble: Some("tcp://there was disconnected".to_owned()), ..Health::default() }
        }
    }

    fn broken(for_ms: u64, tells: bool) -> Broken {
        Broken { back: Instant::now() + time::Duration::from_millis(for_ms), tells, sent: 0 }
    }

    fn endurance(patience_ms: u64) -> Endurance {
        Endurance { patience: Duration::from_millis(patience_ms), ends: None, cancelled: Arc::default() }
    }

    fn frame() -> Frame {
        Frame::full(CanId::standard_masked(1), [0; 8])
    }

    #[test]
    fn a_frame_is_sent_once_when_the_bus_is_back() {
        for tells in [true, false] {
            let (mut bus, begun) = (broken(100, tells), Instant::now());
            let mut patient = PatientBus::new(&mut bus, endurance(10_000));
            assert!(patient.receive(Timestamp::ZERO).unwrap().is_none(), "what came before can be fetched");
            patient.send(&frame()).unwrap();
            assert!(begun.elapsed() >= time::Duration::from_millis(100));
            assert_eq!(bus.sent, 1);
        }
    }

    #[test]
    fn patience_ends_once_for_each_interruption() {
        let mut bus = broken(60_000, true);
        let mut patient = PatientBus::new(&mut bus, endurance(50));
        let error = patient.send(&frame()).unwrap_err();
        assert!(error.is_interruption());
        assert!(error.to_string().starts_with("tcp://there was disconnected; the bus was not back within "), "{error}");
        let begun = Instant::now();
        assert!((0..100).all(|_| patient.send(&frame()).is_err()));
        assert!(begun.elapsed() < time::Duration::from_millis(50), "the next ones are refused at once");
        assert!(patient.receive(Timestamp::MAX).is_err(), "and nobody waits for an answer");
    }

    #[test]
    fn after_the_end_it_is_not_waited_for() {
        let ended = Instant::now().checked_sub(LAST).unwrap();
        let begun = Instant::now();
        let over = Endurance { ends: Some(ended), ..endurance(60_000) };
        assert!(PatientBus::new(&mut broken(60_000, true), over).send(&frame()).is_err());
        let mut bus = broken(60_000, false);
        let mut cancelled = PatientBus::new(&mut bus, endurance(60_000));
        cancelled.endurance.cancelled.store(true, Ordering::Relaxed);
        cancelled.cancelled_at = Some(ended);
        assert!(cancelled.send(&frame()).is_err());
        assert!(begun.elapsed() < time::Duration::from_secs(1));
    }

    /// An adapter whose transmit queue stays full.
    struct Full {
        hears: bool,
    }

    impl Bus for Full {
        fn now(&self) -> Timestamp {
            Timestamp::ZERO
        }

        fn send(&mut self, _: &Frame) -> Result<(), BusError> {
            let channel = "PCAN_USBBUS1".parse().unwrap();
            Err(PcanError::QueueFull { channel, waited: Duration::ZERO, status: PcanStatus::OK }.into())
        }

        fn receive(&mut self, _: Timestamp) -> Result<Option<Record>, BusError> {
            let record = Record::new(Timestamp::ZERO, ChannelId(0), frame()).with_direction(Direction::Rx);
            Ok(std::mem::take(&mut self.hears).then_some(record))
        }

        fn bit_rate(&self) -> Option<u32> {
            None
        }
    }

    /// At the wrong bit rate no node acknowledges, and waiting is useless; a device that has answered before may come
    /// back.
    #[test]
    fn who_was_never_heard_is_not_waited_for() {
        for hears in [false, true] {
            let mut bus = Full { hears };
            let mut patient = PatientBus::new(&mut bus, endurance(50));
            patient.receive(Timestamp::ZERO).unwrap();
            let error = patient.send(&frame()).unwrap_err();
            assert_eq!(matches!(error, BusError::Interrupted { .. }), hears, "{error}");
        }
    }

    #[test]
    fn what_is_no_interruption_is_not_waited_for() {
        struct Refusing;
        impl Bus for Refusing {
            fn now(&self) -> Timestamp {
                Timestamp::ZERO
            }
            fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
                Err(BusError::Unsendable { frame: *frame, reason: "expected another" })
            }
            fn receive(&mut self, _: Timestamp) -> Result<Option<Record>, BusError> {
                Ok(None)
            }
            fn bit_rate(&self) -> Option<u32> {
                None
            }
        }
        let error = PatientBus::new(&mut Refusing, endurance(60_000)).send(&frame()).unwrap_err();
        assert!(matches!(error, BusError::Unsendable { .. }));
    }
}
