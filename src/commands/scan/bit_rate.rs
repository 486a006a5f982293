//! `--bit-rate auto`: finds the bit rate of a bus by listening at one after the other, without sending or acknowledging
//! anything.

use crate::interrupt::Interrupt;
use canvass_analyzer::wire::layer_setting::Dialect;
use canvass_analyzer::wire::lss::Lss;
use canvass_bus::{Bus, BusError};
use canvass_traces::Duration;
use std::fmt::Write as _;

/// Number of frames that prove a bit rate. A controller takes no frame whose checksum is wrong, so one alone is a
/// coincidence only where others fail.
const PROOF: u32 = 2;

/// What was heard at a bit rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heard {
    /// In bit/s.
    pub bit_rate: u32,
    /// Frames that were right.
    pub frames: u32,
    /// Error frames: somebody sends at another bit rate.
    pub errors: u32,
}

impl Heard {
    const fn proves(&self) -> bool {
        self.frames >= PROOF || self.frames > 0 && self.errors == 0
    }
}

/// What the search has heard: the last entry is the bit rate of the bus, if it was found.
#[derive(Debug, Default)]
pub struct Search {
    heard: Vec<Heard>,
    /// Bit rates that the adapter lacks.
    lacking: Vec<u32>,
}

impl Search {
    /// The bit rate of the bus.
    pub fn found(&self) -> Option<&Heard> {
        self.heard.last().filter(|heard| heard.proves())
    }

    /// Why no bit rate was found, and what to do.
    pub fn failure(&self) -> String {
        if self.heard.is_empty() {
            return "the search for the bit rate was ended before anything was heard".to_owned();
        }
        let mut text = "no frame was received at ".to_owned();
        // Writing to a string does not fail.
        let _ = write!(text, "{}", rates(self.heard.iter().map(|heard| heard.bit_rate)));
        if !self.lacking.is_empty() {
            let _ = write!(text, " (the adapter lacks {})", rates(self.lacking.iter().copied()));
        }
        let errors: u32 = self.heard.iter().map(|heard| heard.errors).sum();
        text += match errors {
            0 => {
                ": nobody sends, or the bus is not connected. Switch a device on meanwhile: its boot-up message shows the \
                 bit rate; --listen sets how long to wait at each"
            }
            _ => {
                ", though there are error frames: somebody sends at a bit rate that CANopen does not have, or the wiring \
                 disturbs the bus (termination, CAN_H and CAN_L)"
            }
        };
        text
    }
}

/// Bit rates in words: `1000, 500 and 250 kbit/s`.
fn rates(rates: impl Iterator<Item = u32>) -> String {
    let words: Vec<String> = rates.map(|rate| (rate / 1_000).to_string()).collect();
    match words.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} and {last} kbit/s", others.join(", ")),
        _ => format!("{} kbit/s", words.concat()),
    }
}

/// The order of the search: the bit rate in use, then those of CANopen by how often they are met.
fn order(own: Option<u32>) -> Vec<u32> {
    const USUAL: [u32; 3] = [250_000, 500_000, 125_000];
    let table = (0..=u8::MAX).filter_map(Lss::bit_rate);
    let mut order = Vec::new();
    for rate in own.into_iter().chain(USUAL).chain(table) {
        if !order.contains(&rate) {
            order.push(rate);
        }
    }
    order
}

/// Listens for `span` at one bit rate after the other until one is proven, and then takes part in the bus at that bit
/// rate; otherwise, and after an error, at the one that was in use.
///
/// # Errors
/// [`BusError::NeverSilent`] if this end of the bus can't only listen, or another error of the bus.
pub fn search(bus: &mut dyn Bus, span: Duration, interrupt: &Interrupt) -> Result<Search, BusError> {
    let own = bus.bit_rate();
    let searched = listen_at_each(bus, order(own), span, interrupt);
    let found = searched.as_ref().ok().and_then(Search::found).map(|heard| heard.bit_rate);
    let ended = found.or(own).map_or(Ok(()), |rate| bus.set_bit_rate(rate));
    let search = searched?;
    ended.map(|()| search)
}

fn listen_at_each(
    bus: &mut dyn Bus,
    rates: Vec<u32>,
    span: Duration,
    interrupt: &Interrupt,
) -> Result<Search, BusError> {
    let (mut search, mut refused) = (Search::default(), None);
    for rate in rates {
        if interrupt.came() || search.found().is_some() {
            break;
        }
        match bus.listen_at(rate) {
            Ok(()) => search.heard.push(listen(bus, rate, span, interrupt)?),
            Err(error) => {
                search.lacking.push(rate);
                refused = Some(error);
            }
        }
    }
    // An end that can listen at no bit rate lacks more than a bit rate.
    match refused {
        Some(error) if search.heard.is_empty() => Err(error),
        _ => Ok(search),
    }
}

fn listen(bus: &mut dyn Bus, bit_rate: u32, span: Duration, interrupt: &Interrupt) -> Result<Heard, BusError> {
    /// How soon Ctrl-C is noticed.
    const SLICE: Duration = Duration::from_millis(50);
    let mut heard = Heard { bit_rate, frames: 0, errors: 0 };
    let begin = bus.now();
    let end = begin + span;
    while bus.now() < end && heard.frames < PROOF && !interrupt.came() {
        let Some(record) = bus.receive(end.min(bus.now() + SLICE))? else { continue };
        // What was received at the bit rate before waits in the adapter.
        if record.timestamp < begin {
            continue;
        }
        match record.frame.is_error() {
            true => heard.errors += 1,
            false => heard.frames += 1,
        }
    }
    Ok(heard)
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_analyzer::NodeId;
    use canvass_bus::{Health, SimulatedBus};
    use canvass_device::models::Model;
    use canvass_device::{Device, Faults};
    use canvass_traces::{Frame, Record, Timestamp};

    /// A bus with an encoder that sends heartbeats at this bit rate, met at another one.
    fn bus(bit_rate: u32, met_at: u32) -> SimulatedBus {
        let model = Model::by_id("reference-301").unwrap();
        let mut device = Device::new(model, NodeId::new(10), Faults::default(), 1);
        device.set_bit_rate(bit_rate);
        let mut bus = SimulatedBus::new(bit_rate);
        bus.attach(Box::new(device));
        let write = canvass_traces::parse_frame("60A#2B17100064000000").unwrap().frame;
        bus.receive(Timestamp::ZERO + Duration::from_secs(1)).unwrap();
        bus.send(&write).unwrap();
        while bus.receive(bus.now() + Duration::from_millis(20)).unwrap().is_some() {}
        bus.set_bit_rate(met_at).unwrap();
        bus
    }

    #[test]
    fn the_bit_rate_is_that_at_which_frames_come() {
        let interrupt = Interrupt::default();
        for (bit_rate, met_at) in [(125_000, 500_000), (500_000, 500_000), (1_000_000, 250_000), (10_000, 250_000)] {
            let mut bus = bus(bit_rate, met_at);
            let found = search(&mut bus, Duration::from_millis(1_200), &interrupt).unwrap();
            assert_eq!(found.found().map(|heard| heard.bit_rate), Some(bit_rate));
            assert_eq!(bus.bit_rate(), Some(bit_rate));
        }
    }

    #[test]
    fn a_silent_bus_keeps_its_bit_rate() {
        let mut bus = SimulatedBus::new(500_000);
        let silent = search(&mut bus, Duration::from_millis(100), &Interrupt::default()).unwrap();
        assert!(silent.found().is_none() && bus.bit_rate() == Some(500_000));
        let told = silent.failure();
        assert!(
            told.starts_with("no frame was received at 500, 250, 125, 1000, 800, 50, 20 and 10 kbit/s: nobody"),
            "{told}"
        );
    }

    #[test]
    fn a_search_that_is_ended_says_so() {
        let interrupt = Interrupt::default();
        interrupt.request();
        let ended = search(&mut bus(125_000, 500_000), Duration::from_millis(100), &interrupt).unwrap();
        assert!(ended.found().is_none() && ended.failure().contains("was ended"), "{}", ended.failure());
    }

    #[test]
    fn one_frame_among_errors_proves_nothing() {
        let heard = |frames, errors| Heard { bit_rate: 250_000, frames, errors }.proves();
        assert!(heard(1, 0) && heard(2, 7) && !heard(1, 1) && !heard(0, 0));
    }

    /// A bus whose other end decides.
    struct Fixed;

    impl Bus for Fixed {
        fn now(&self) -> Timestamp {
            Timestamp::ZERO
        }
        fn send(&mut self, _: &Frame) -> Result<(), BusError> {
            Ok(())
        }
        fn receive(&mut self, _: Timestamp) -> Result<Option<Record>, BusError> {
            Ok(None)
        }
        fn bit_rate(&self) -> Option<u32> {
            None
        }
        fn health(&self) -> Health {
            Health::default()
        }
    }

    #[test]
    fn a_bus_that_always_acknowledges_is_not_listened_to() {
        let error = search(&mut Fixed, Duration::from_millis(100), &Interrupt::default()).unwrap_err();
        assert!(matches!(error, BusError::NeverSilent), "{error}");
    }
}
