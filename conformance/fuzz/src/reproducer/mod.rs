//! The reproducers of a violation: a log that can be replayed, a Rust test, and a test for pytest.
//!
//! A regression file contains several such logs, one after the other. Each begins with a line that begins with
//! [`HEAD`]:
//!
//! ```text
//! # canvass fuzz: PROP-02 toggle bit, seed 7, canvass 0.1.0
//! (0000000000.000000) can0 601#2100200008000000
//! (0000000000.100000) can0 601#1000000000000000
//! ```
//!
//! `canplayer` and readers of candump logs read only the frames of such a file.

mod candump;
mod check;
mod player;
mod pytest;
mod rust_test;

pub use candump::{candump, log, sequence};
pub use check::Check;
pub use player::{Played, play};
pub use pytest::pytest;
pub use rust_test::rust_test;

use super::campaign::{self, Found, FuzzError};
use super::live::Live;
use super::stand::{TestStand, of_address};
use super::stimulus::Then;
use super::{Knowledge, Sequence, Start, Violation};
use canvass_analyzer::NodeId;
use canvass_bus::BusError;
use canvass_device::address::BusAddress;
use canvass_traces::{Capture, Damage, Direction, Frame, OpenError, ReadOptions, Source, Timestamp};

/// The beginning of the line before each log of a regression file.
pub const HEAD: &str = "# canvass fuzz:";

/// Why a file can't be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The file is no capture.
    #[error("expected a capture or a reproducer of canvass fuzz: {0}")]
    Open(#[from] OpenError),
    /// A part of the file can't be read.
    #[error("the reproducer can't be read to its end: {0}")]
    Damage(String),
    /// The file holds no frame that goes to the device.
    #[error("the capture holds no frame that could be sent to node {0}: check the node-ID")]
    Empty(NodeId),
    /// The device can't be fuzzed.
    #[error(transparent)]
    Fuzz(#[from] FuzzError),
    /// The bus can't be opened.
    #[error(transparent)]
    Bus(#[from] BusError),
}

impl From<Damage> for ReplayError {
    fn from(damage: Damage) -> Self {
        Self::Damage(damage.to_string())
    }
}

/// The violation as a log of a regression file.
pub fn regression(found: &Found, seed: u64) -> String {
    let (property, rule) = (found.violation.property, found.violation.rule);
    let version = env!("CARGO_PKG_VERSION");
    format!("{HEAD} {property} {rule}, seed {seed}, canvass {version}\n{}", log(found))
}

/// The sequences of a file: reproducers of violations, or a capture in any format. Of a capture only the frames that
/// were sent to the node are taken, not the frames of the node itself.
///
/// # Errors
/// [`ReplayError`] if it is not such a file.
pub fn read(bytes: &[u8], node: NodeId) -> Result<Vec<Sequence>, ReplayError> {
    let Some(text) = std::str::from_utf8(bytes).ok().filter(|text| text.contains(HEAD)) else {
        return one(bytes, node).map(|sequence| vec![sequence]);
    };
    let mut logs: Vec<String> = Vec::new();
    for line in text.lines() {
        if line.starts_with(HEAD) || logs.is_empty() {
            logs.push(String::new());
        }
        if let Some(log) = logs.last_mut() {
            log.push_str(line);
            log.push('\n');
        }
    }
    let has_frames = |log: &&String| log.lines().any(|line| !line.trim().is_empty() && !line.starts_with('#'));
    // A violation that shows without any frame has an empty log, which is left out.
    logs.iter().filter(has_frames).map(|log| one(log.as_bytes(), node)).collect()
}

fn one(bytes: &[u8], node: NodeId) -> Result<Sequence, ReplayError> {
    let capture = Capture::from_source("reproducer", Source::from_bytes(bytes), &ReadOptions::default())?;
    let records = capture.collect::<Result<Vec<_>, _>>()?;
    let is_marked = records.iter().any(|record| record.direction == Direction::Tx);
    let frames: Vec<(Timestamp, Frame)> = records
        .iter()
        .filter(|record| !record.frame.is_error())
        .filter(|record| if is_marked { record.direction == Direction::Tx } else { !is_from(&record.frame, node) })
        .map(|record| (record.timestamp, record.frame))
        .collect();
    if frames.is_empty() {
        return Err(ReplayError::Empty(node));
    }
    let mut sequence = sequence(&frames);
    let text = std::str::from_utf8(bytes).unwrap_or_default();
    let unconfigured = text.contains(candump::UNCONFIGURED);
    sequence.start = if unconfigured { Start::Unconfigured } else { Start::Configured };
    if let (Some(wait), Some(last)) = (candump::last_wait(text), sequence.stimuli.last_mut()) {
        last.then = Then::Pause(wait);
    }
    Ok(sequence)
}

/// Whether a data frame comes from the node, by the predefined connection set.
fn is_from(frame: &Frame, node: NodeId) -> bool {
    let Some(id) = frame.cob_id().filter(|_| !frame.is_remote()) else { return false };
    let own = id & 0x7F == u16::from(node.raw());
    id == 0x7E4 || own && matches!(id & 0x780, 0x080 | 0x180 | 0x280 | 0x380 | 0x480 | 0x580 | 0x700)
}

/// Replays a reproducer on a bus, as `canvass fuzz --replay` does. Returns the first violation, if there is one.
/// `device` is the knowledge of a device on a live bus; a simulated device is known.
///
/// # Errors
/// [`ReplayError`] if the log can't be read or the device can't be reached.
///
/// ```
/// use canvass_fuzzer::reproducer::replay;
///
/// let log = b"(0000000000.000000) can0 60A#4000100000000000\n";
/// assert_eq!(replay("sim:reference-301", None, None, log).unwrap(), None);
/// ```
pub fn replay(
    address: &str,
    node: Option<NodeId>,
    device: Option<&Knowledge>,
    log: &[u8],
) -> Result<Option<Violation>, ReplayError> {
    if let BusAddress::Simulated(devices) = address.parse()?
        && let [only] = &devices[..]
    {
        let (mut stand, knowledge) = of_address(only, node, 0)?;
        return first(&mut stand, &knowledge, log);
    }
    let mut opened = canvass_device::address::open(address)?;
    let usual = Knowledge::new(node.or(opened.node()).unwrap_or(NodeId::MIN), None, None);
    let knowledge = device.unwrap_or(&usual);
    let mut stand = Live::new(opened.bus.as_mut(), knowledge);
    first(&mut stand, knowledge, log)
}

fn first(stand: &mut dyn TestStand, knowledge: &Knowledge, log: &[u8]) -> Result<Option<Violation>, ReplayError> {
    for sequence in read(log, knowledge.node)? {
        let (violation, _) = campaign::replay(stand, knowledge.clone(), &sequence)?;
        if violation.is_some() {
            return Ok(violation);
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stimulus::Stimulus;
    use canvass_traces::{CanId, Duration};

    /// A capture written by `canvass test --record` or candump is replayed without the device's own frames.
    #[test]
    fn of_a_capture_the_requests_are_taken() {
        let log = "(1.000000) can0 701#00\n(1.100000) can0 601#4000100000000000\n(1.101000) can0 581#4300100000000000\n\
                   (1.200000) can0 701#R1\n(1.201000) can0 701#7F\n(1.300000) can0 080#\n(1.400000) can0 081#0010010000000000\n";
        let sequences = read(log.as_bytes(), NodeId::MIN).unwrap();
        let ids: Vec<u32> = sequences[0].stimuli.iter().map(|stimulus| stimulus.frame.id().raw()).collect();
        assert_eq!(ids, [0x601, 0x701, 0x080]);
        assert!(matches!(read(b"(1.0) can0 581#00\n", NodeId::MIN), Err(ReplayError::Empty(_))));
        assert!(read(b"\x00\x01nonsense", NodeId::MIN).is_err());
    }

    /// The wait after the last frame is restored from the log.
    #[test]
    fn the_wait_behind_the_last_frame_is_kept() {
        let frame = Frame::new(CanId::standard_masked(0x601), &[0x40]).unwrap();
        let pause = Then::Pause(Duration::from_millis(120));
        let written = Sequence { start: Start::Configured, stimuli: vec![Stimulus { frame, then: pause }] };
        let log = candump(&written);
        assert_eq!(log, "(0000000000.000000) can0 601#40\n# end: after 120 ms\n");
        assert_eq!(read(log.as_bytes(), NodeId::MIN).unwrap()[0].stimuli, written.stimuli);
        let endless = log.replace("120", "99999999999");
        assert_eq!(read(endless.as_bytes(), NodeId::MIN).unwrap()[0].stimuli[0].then, Then::Settle);
    }

    #[test]
    fn a_file_of_regressions_holds_many() {
        let log = "# canvass fuzz: PROP-02 a, seed 1, canvass 0.1.0\n(0000000000.000000) can0 601#40\n\
                   # canvass fuzz: PROP-10 b, seed 1, canvass 0.1.0\n# start: without node-ID\n(0000000000.000000) can0 7E5#5E\n";
        let sequences = read(log.as_bytes(), NodeId::MIN).unwrap();
        let starts: Vec<Start> = sequences.iter().map(|sequence| sequence.start).collect();
        assert_eq!(starts, [Start::Configured, Start::Unconfigured]);
    }
}
