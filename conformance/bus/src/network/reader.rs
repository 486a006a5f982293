//! The thread that reads from the other end, and connects again after the connection was lost.

use super::NetworkError;
use super::bus::{Arrived, Connect, Failure, Read, Shared};
use crate::connection::RETRY;
use crate::connection::arrival::{Arrival, Arrivals};
use crate::connection::link::is_silence;
use crate::hardware_clock::HardwareClock;
use canvass_traces::{ChannelId, Direction, Record};
use std::io;
use std::sync::Arc;

pub(super) struct Reader {
    shared: Arc<Shared>,
    connects: Box<dyn Connect + Send>,
    reads: Box<dyn Read + Send>,
    port: Option<Box<dyn io::Read + Send>>,
    hardware: HardwareClock,
    arrived: Arrived,
    records: Vec<Record>,
}

impl Reader {
    pub fn new(shared: Arc<Shared>, connects: Box<dyn Connect + Send>, reads: Box<dyn Read + Send>) -> Self {
        let (arrived, records) = (Arrived::default(), Vec::new());
        Self { shared, connects, reads, port: None, hardware: HardwareClock::default(), arrived, records }
    }

    /// Opens the connection.
    pub fn connect(&mut self) -> Result<(), NetworkError> {
        let name = || self.shared.name.clone();
        let (link, rest) = self.connects.connect().map_err(|failure| match failure {
            Failure::Io(source) => NetworkError::Open { name: name(), source },
            Failure::Refused(answer) => NetworkError::Refused { name: name(), answer },
        })?;
        self.port = Some(link.reader);
        self.hardware = HardwareClock::default();
        self.shared.way.connect(link.writer);
        self.shared.way.open();
        let now = self.shared.clock.now();
        self.shared.inbox.note(|health| health.came_back(now));
        if rest.is_empty() {
            return Ok(());
        }
        let arrival = Arrivals::of_this_thread().end(&self.shared.clock);
        self.take(&rest, arrival).unwrap_or_else(|trouble| self.lose(&trouble));
        Ok(())
    }

    /// Reads until the bus is closed.
    pub fn run(mut self) {
        let shared = Arc::clone(&self.shared);
        let (mut arrivals, mut bytes) = (Arrivals::of_this_thread(), vec![0; 1 << 16]);
        while !shared.inbox.is_closed() {
            let Some(port) = &mut self.port else {
                // The other end is not back; the next round tries again.
                std::thread::sleep(RETRY);
                let _ = self.connect();
                continue;
            };
            arrivals.begin();
            let read = match port.read(&mut bytes) {
                Ok(0) => Err("the other end closed the connection".to_owned()),
                Ok(n) => {
                    let arrival = arrivals.end(&shared.clock);
                    self.take(bytes.get(..n).unwrap_or_default(), arrival)
                }
                Err(error) if is_silence(&error) => Ok(()),
                Err(error) => Err(error.to_string()),
            };
            let failed = || shared.way.take_failure().map(|error| error.to_string());
            if let Some(trouble) = read.err().or_else(failed) {
                self.lose(&trouble);
            }
        }
    }

    /// Delivers what one read has brought.
    fn take(&mut self, bytes: &[u8], arrival: Arrival) -> Result<(), String> {
        let shared = Arc::clone(&self.shared);
        let taken = self.reads.read(bytes, &mut self.arrived);
        shared.inbox.set_delivering(true);
        let errors = self.arrived.frames.iter().filter(|stamped| stamped.frame.is_error()).count();
        let (count, lost) = (self.arrived.frames.len(), std::mem::take(&mut self.arrived.lost));
        shared.inbox.note(|health| {
            arrival.note(count, health);
            health.error_frames += errors as u64;
            health.lost += lost;
        });
        for (at, stamped) in self.arrived.frames.drain(..).enumerate() {
            let arrived = arrival.of(at);
            let time = stamped.time.map_or(arrived, |time| self.hardware.system_time(time, arrived));
            self.records.push(Record::new(time, ChannelId(0), stamped.frame).with_direction(Direction::Rx));
        }
        shared.inbox.deliver(&mut self.records);
        shared.inbox.set_delivering(false);
        taken
    }

    /// Closes the connection.
    fn lose(&mut self, trouble: &str) {
        self.port = None;
        self.shared.way.close();
        let (now, name) = (self.shared.clock.now(), &self.shared.name);
        self.shared.inbox.note(|health| health.went_away(now, format!("{name}: {trouble}")));
    }
}
