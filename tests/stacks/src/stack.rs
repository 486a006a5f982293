//! The adaptation of any stack to a device on the simulated bus.

use canvass_bus::Machine;
use canvass_traces::{Duration, Frame, Timestamp};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};

/// A stack with the application that its documentation requires. Times count from switching on.
pub trait Stack: Send {
    /// Switches the supply on, for the first time or again: only stored data are kept.
    fn switch_on(&mut self);

    /// Handles a frame of another participant.
    fn handle(&mut self, now: Timestamp, frame: &Frame);

    /// The next frame to send.
    fn transmit(&mut self) -> Option<Frame>;

    /// Whether the CAN controller's mailboxes were emptied since the last call of [`Stack::transmit`]: a frame that
    /// still waits for the bus is then not sent.
    fn has_emptied_mailboxes(&self) -> bool {
        false
    }

    /// The time of the next call of [`Stack::tick`].
    fn wake(&self) -> Option<Timestamp>;

    /// Called at the time of [`Stack::wake`].
    fn tick(&mut self, now: Timestamp);
}

/// A stack that panicked.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Death {
    /// The time of the panic on the clock of the bus.
    pub at: Timestamp,
    /// The frame that the stack was handling, if it was handling one.
    pub frame: Option<Frame>,
    /// The message of the panic.
    pub reason: String,
}

/// The panics of a device, oldest first. They are kept apart from the device, which belongs to the bus.
#[derive(Clone, Default, Debug)]
pub struct Memorial(Arc<Mutex<Vec<Death>>>);

impl Memorial {
    /// All panics of the device.
    pub fn deaths(&self) -> Vec<Death> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn add(&self, death: Death) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(death);
    }
}

/// A stack as a participant of the simulated bus. After a panic the device is silent until it is switched off and on,
/// or until its watchdog restarts it.
pub struct StackDevice<S> {
    stack: S,
    switched_on: Timestamp,
    /// Whether the bus still has to fetch the frames of the start.
    starting: bool,
    dead_since: Option<Timestamp>,
    watchdog: Option<Duration>,
    memorial: Memorial,
}

impl<S: Stack> StackDevice<S> {
    /// A device with this stack, switched on at time 0.
    pub fn new(stack: S) -> Self {
        let mut device = Self {
            stack,
            switched_on: Timestamp::ZERO,
            starting: true,
            dead_since: None,
            watchdog: None,
            memorial: Memorial::default(),
        };
        device.power_cycle(Timestamp::ZERO);
        device
    }

    /// Adds a watchdog, which switches the device off and on this long after a panic; most devices in the field have
    /// one.
    #[must_use]
    pub fn with_watchdog(mut self, after: Duration) -> Self {
        self.watchdog = Some(after);
        self
    }

    /// Keeps the panics in `memorial`, together with those of other devices.
    #[must_use]
    pub fn remembered_in(mut self, memorial: &Memorial) -> Self {
        self.memorial = memorial.clone();
        self
    }

    /// The place where the panics are kept.
    pub fn memorial(&self) -> Memorial {
        self.memorial.clone()
    }

    fn own(&self, now: Timestamp) -> Timestamp {
        Timestamp(now.since(self.switched_on).0)
    }

    /// Calls the stack, unless it has panicked.
    fn alive<T>(&mut self, now: Timestamp, frame: Option<&Frame>, call: impl FnOnce(&mut S) -> T) -> Option<T> {
        if self.dead_since.is_some() {
            return None;
        }
        // A stack that has panicked is not called again before it is switched on anew.
        match catch_unwind(AssertUnwindSafe(|| call(&mut self.stack))) {
            Ok(result) => Some(result),
            Err(panic) => {
                self.dead_since = Some(now);
                self.memorial.add(Death { at: now, frame: frame.copied(), reason: message(&*panic) });
                None
            }
        }
    }
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "a panic without words".to_owned())
}

impl<S: Stack> Machine for StackDevice<S> {
    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        let own = self.own(now);
        self.alive(now, Some(frame), |stack| stack.handle(own, frame));
    }

    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame> {
        self.alive(now, None, Stack::transmit).flatten()
    }

    fn poll_timeout(&self) -> Option<Timestamp> {
        match self.dead_since {
            Some(died) => self.watchdog.map(|after| died + after),
            None if self.starting => Some(self.switched_on),
            None => self.stack.wake().map(|own| self.switched_on + own.since(Timestamp::ZERO)),
        }
    }

    fn handle_timeout(&mut self, now: Timestamp) {
        match (self.dead_since, self.watchdog) {
            (Some(died), Some(after)) if now >= died + after => self.power_cycle(now),
            _ => {
                self.starting = false;
                let own = self.own(now);
                self.alive(now, None, |stack| stack.tick(own));
            }
        }
    }

    fn withdraws(&self, _: &Frame) -> bool {
        self.dead_since.is_none() && self.stack.has_emptied_mailboxes()
    }

    fn power_cycle(&mut self, now: Timestamp) {
        self.switched_on = now;
        self.starting = true;
        self.dead_since = None;
        self.alive(now, None, Stack::switch_on);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_bus::{Bus, SimulatedBus};
    use canvass_traces::CanId;

    /// A stack that sends its name when it is switched on, repeats all frames, and panics at remote frames.
    #[derive(Default)]
    struct Parrot(Vec<Frame>);

    impl Stack for Parrot {
        fn switch_on(&mut self) {
            self.0 = vec![frame(0x705, &[0])];
        }

        fn handle(&mut self, _: Timestamp, heard: &Frame) {
            assert!(!heard.is_remote(), "no remote frames");
            self.0.push(*heard);
        }

        fn transmit(&mut self) -> Option<Frame> {
            self.0.pop()
        }

        fn wake(&self) -> Option<Timestamp> {
            None
        }

        fn tick(&mut self, _: Timestamp) {}
    }

    fn frame(id: u32, data: &[u8]) -> Frame {
        Frame::new(CanId::standard(id).unwrap(), data).unwrap()
    }

    fn heard(bus: &mut SimulatedBus) -> Vec<String> {
        let deadline = bus.now() + Duration::from_millis(100);
        std::iter::from_fn(|| bus.receive(deadline).unwrap()).map(|record| record.frame.to_string()).collect()
    }

    #[test]
    fn a_stack_that_panics_is_silent_and_its_reason_is_kept() {
        let device = StackDevice::new(Parrot::default());
        let memorial = device.memorial();
        let mut bus = SimulatedBus::new(1_000_000);
        bus.attach(Box::new(device));
        assert_eq!(heard(&mut bus), ["705#00"]);
        let remote = Frame::remote(CanId::standard(0x705).unwrap(), 1).unwrap();
        bus.send(&frame(1, &[1])).unwrap();
        bus.send(&remote).unwrap();
        bus.send(&frame(2, &[2])).unwrap();
        assert_eq!(heard(&mut bus), ["001#01", "001#01", "705#R1", "002#02"]);
        let deaths = memorial.deaths();
        assert_eq!((deaths.len(), deaths[0].frame, &*deaths[0].reason), (1, Some(remote), "no remote frames"));
        bus.power_cycle(0);
        assert_eq!(heard(&mut bus), ["705#00"]);
    }

    #[test]
    fn a_watchdog_restarts_it() {
        let mut bus = SimulatedBus::new(1_000_000);
        bus.attach(Box::new(StackDevice::new(Parrot::default()).with_watchdog(Duration::from_millis(50))));
        heard(&mut bus);
        bus.send(&Frame::remote(CanId::standard(0x705).unwrap(), 0).unwrap()).unwrap();
        assert_eq!(heard(&mut bus).last().map(String::as_str), Some("705#00"));
    }
}
