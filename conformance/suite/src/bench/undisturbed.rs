//! Actions that must not fail because the connection to the bus was interrupted: reading the device's values before a
//! change, and putting them back.

use super::Bench;

/// Maximum number of attempts if the connection to the bus is interrupted each time.
const MOST_TRIES: u32 = 5;

impl Bench<'_> {
    /// Runs `act`, and again if the connection to the bus was interrupted meanwhile: objects without an answer may
    /// exist all the same.
    pub(super) fn undisturbed<T>(&mut self, mut act: impl FnMut(&mut Self) -> T) -> T {
        for _ in 1..MOST_TRIES {
            let before = self.health();
            let done = act(self);
            if self.health().since(&before).interruptions == 0 {
                return done;
            }
        }
        act(self)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Options, Target};
    use super::*;
    use crate::scripted::{ScriptedBus, frame};
    use canvass_analyzer::{Multiplexer, NodeId};
    use canvass_bus::{Bus, BusError, Health};
    use canvass_traces::{Duration, Frame, Record, Timestamp};
    use std::sync::atomic::AtomicBool;

    /// A bus that is interrupted while the first request is under way.
    struct Interrupted {
        inner: ScriptedBus,
        sent: u64,
    }

    impl Bus for Interrupted {
        fn now(&self) -> Timestamp {
            self.inner.now()
        }
        fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
            self.sent += 1;
            if self.sent == 1 { Ok(()) } else { self.inner.send(frame) }
        }
        fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
            self.inner.receive(deadline)
        }
        fn bit_rate(&self) -> Option<u32> {
            None
        }
        fn health(&self) -> Health {
            Health { interruptions: self.sent.min(1), ..Health::default() }
        }
    }

    /// Without its earlier value the object could not be put back.
    #[test]
    fn a_value_that_is_about_to_be_changed_is_read_though_the_bus_was_interrupted() {
        let at = Multiplexer::new(0x1017, 0);
        let answers = |request: &Frame| match request.data() {
            [0x40, 0x17, 0x10, 0, ..] => vec![(Duration::from_millis(1), frame("5BF#4B171000E8030000"))],
            _ => Vec::new(),
        };
        let mut bus = Interrupted { inner: ScriptedBus::new(answers), sent: 0 };
        let (target, options) = (Target::unknown(NodeId::new(63).unwrap()), Options::default());
        let (cancel, mut annotate) = (AtomicBool::new(false), |_: &Record| String::new());
        let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
        bench.remember(at).unwrap();
        let kept: Vec<_> = bench.changes.take().into_iter().map(|change| (change.at, change.value)).collect();
        assert_eq!(kept, [(at, vec![0xE8, 0x03])]);
    }
}
