//! A player of logs as `canplayer` is: it sends the frames at their times and waits for no answer.

use canvass_bus::{Bus, BusError};
use canvass_traces::{Direction, Duration, Frame, Record, Timestamp, parse_frame};

/// The frames on the bus while a log was played.
#[derive(Clone, Debug)]
pub struct Played {
    /// All frames, from the first own frame on.
    pub trace: Vec<Record>,
    /// The time of the last own frame.
    pub last: Timestamp,
}

impl Played {
    /// The frames from the own frame with this number on.
    pub fn since(&self, number: usize) -> &[Record] {
        let mut own = self.trace.iter().enumerate().filter(|(_, record)| record.direction == Direction::Tx);
        let from = own.nth(number).map_or(self.trace.len(), |(at, _)| at);
        if number == 0 { &self.trace } else { self.trace.get(from..).unwrap_or_default() }
    }
}

/// The frames of a candump log with their times. Comments are left out.
fn frames(log: &str) -> impl Iterator<Item = (Duration, Frame)> + '_ {
    log.lines().filter(|line| line.starts_with('(')).filter_map(|line| {
        let mut words = line.split_whitespace();
        let time = words.next()?.strip_prefix('(')?.strip_suffix(')')?;
        let (seconds, micros) = time.split_once('.')?;
        let time = Duration::from_secs(seconds.parse().ok()?) + Duration::from_micros(micros.parse().ok()?);
        Some((time, parse_frame(words.nth(1)?).ok()?.frame))
    })
}

/// Plays a log, and listens for `patience` after its last frame.
///
/// # Errors
/// [`BusError`] if the bus fails.
pub fn play(bus: &mut dyn Bus, log: &str, patience: Duration) -> Result<Played, BusError> {
    let begun = bus.now();
    let mut played = Played { trace: Vec::new(), last: begun };
    for (at, frame) in frames(log) {
        listen(bus, begun + at, &mut played)?;
        bus.send(&frame)?;
    }
    let until = bus.now() + patience;
    listen(bus, until, &mut played)?;
    Ok(played)
}

fn listen(bus: &mut dyn Bus, until: Timestamp, played: &mut Played) -> Result<(), BusError> {
    while let Some(record) = bus.receive(until)? {
        if record.direction == Direction::Tx {
            played.last = record.timestamp;
        }
        played.trace.push(record);
    }
    Ok(())
}
