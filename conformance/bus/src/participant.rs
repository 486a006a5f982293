//! Connects a machine to a live bus. The time of the machine is that of the bus, counted from the machine's power-on.

use crate::Bus;
use crate::Machine;
use canvass_traces::{Direction, Duration, Record, Timestamp};

/// Statistics of a machine on a bus.
#[derive(Debug, Default)]
pub struct Participation {
    /// Number of frames sent.
    pub sent: u64,
    /// Number of frames that the bus did not take.
    pub unsent: u64,
    /// The reason why the bus did not take the last of the unsent frames, or why the bit rate could not be changed.
    pub trouble: Option<String>,
}

/// Maximum duration of a wait, after which `goes_on` is called.
const SLICE: Duration = Duration::from_millis(200);

/// Connects a machine to a bus until `goes_on` returns false; `goes_on` is called about five times a second. `observe`
/// gets every frame, including own ones.
///
/// If the bus does not take a frame, the participation continues: the interface may come back, as for a real device.
/// When the machine changes its bit rate, the bus changes its own, if it can.
///
/// # Errors
/// [`super::BusError`] if the bus can't receive any more.
pub fn participate(
    bus: &mut dyn Bus,
    machine: &mut dyn Machine,
    goes_on: &mut dyn FnMut(&Participation, Timestamp) -> bool,
    observe: &mut dyn FnMut(&Record),
) -> Result<Participation, super::BusError> {
    let mut clock = MachineClock { switched_on: bus.now(), last: Timestamp::ZERO };
    let mut done = Participation::default();
    let mut bit_rate = FollowedBitRate { of_bus: bus.bit_rate(), now: None };
    while goes_on(&done, clock.at(bus.now())) {
        let now = clock.at(bus.now());
        if machine.poll_timeout().is_some_and(|timeout| timeout <= now) {
            machine.handle_timeout(now);
        }
        bit_rate.follow(bus, machine, &mut done);
        send_all(bus, machine, now, &mut done);
        let timeout = machine.poll_timeout().map_or(Timestamp::MAX, |timeout| clock.on_bus(timeout));
        let deadline = timeout.min(bus.now() + SLICE);
        if let Some(record) = bus.receive(deadline)? {
            observe(&record);
            if record.direction != Direction::Tx && !record.frame.is_error() {
                // Reactions count from the frame's end on the bus, not from the time at which this computer received
                // it.
                let at = clock.at(record.timestamp);
                machine.handle(at, &record.frame);
                send_all(bus, machine, at, &mut done);
            }
        }
    }
    Ok(done)
}

fn send_all(bus: &mut dyn Bus, machine: &mut dyn Machine, now: Timestamp, done: &mut Participation) {
    while let Some(frame) = machine.poll_transmit(now) {
        match bus.send(&frame) {
            Ok(()) => done.sent += 1,
            Err(error) => {
                done.unsent += 1;
                done.trouble = Some(error.to_string());
            }
        }
    }
}

/// The bit rate of the machine, which the bus follows.
struct FollowedBitRate {
    /// The bit rate of the bus, if known; it applies to a machine without its own bit rate.
    of_bus: Option<u32>,
    now: Option<u32>,
}

impl FollowedBitRate {
    fn follow(&mut self, bus: &mut dyn Bus, machine: &dyn Machine, done: &mut Participation) {
        let wanted = machine.bit_rate();
        if wanted == self.now {
            return;
        }
        self.now = wanted;
        // A bus without wires has no bit rate and carries all frames.
        let Some(wanted) = wanted.or(self.of_bus).filter(|_| bus.bit_rate().is_some_and(|rate| Some(rate) != wanted))
        else {
            return;
        };
        if let Err(error) = bus.set_bit_rate(wanted) {
            done.trouble = Some(error.to_string());
        }
    }
}

/// Converts the time of the bus to the time of the machine, which never steps back.
struct MachineClock {
    switched_on: Timestamp,
    last: Timestamp,
}

impl MachineClock {
    fn at(&mut self, on_bus: Timestamp) -> Timestamp {
        self.last = self.last.max(Timestamp(on_bus.since(self.switched_on).0));
        self.last
    }

    fn on_bus(&self, time: Timestamp) -> Timestamp {
        self.switched_on + time.since(Timestamp::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SimulatedBus;

    /// A machine with a bit rate of 500 kbit/s from second 1 to second 2. Before and after, it has the bit rate of the
    /// bus.
    #[derive(Default)]
    struct Changing(u64);

    impl Machine for Changing {
        fn handle(&mut self, _: Timestamp, _: &canvass_traces::Frame) {}

        fn poll_transmit(&mut self, _: Timestamp) -> Option<canvass_traces::Frame> {
            None
        }

        fn poll_timeout(&self) -> Option<Timestamp> {
            (self.0 < 2).then(|| Timestamp((self.0 + 1) * 1_000_000_000))
        }

        fn handle_timeout(&mut self, _: Timestamp) {
            self.0 += 1;
        }

        fn bit_rate(&self) -> Option<u32> {
            (self.0 == 1).then_some(500_000)
        }
    }

    #[test]
    fn the_bus_goes_with_the_machines_bit_rate() {
        let (mut bus, mut rates) = (SimulatedBus::new(250_000), Vec::new());
        for seconds in [1, 2, 3] {
            let mut machine = Changing::default();
            let mut goes_on = |_: &Participation, now: Timestamp| now < Timestamp(seconds * 1_000_000_000 - 1);
            participate(&mut bus, &mut machine, &mut goes_on, &mut |_| {}).unwrap();
            rates.push(bus.bit_rate().unwrap());
            bus.set_bit_rate(250_000).unwrap();
        }
        assert_eq!(rates, [250_000, 500_000, 250_000]);
    }
}
