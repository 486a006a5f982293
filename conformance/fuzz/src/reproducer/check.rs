//! What a trace must hold so that it does not show a violation: a check without the reference models, for players and
//! tests that only send the frames of a log.

use crate::campaign::Found;
use crate::oracle::Symptom;
use canvass_analyzer::wire::lss::SLAVE_CAN_ID;
use canvass_traces::{Direction, Duration, Frame, Record, Timestamp};

/// What the frames of a device must fulfil after a sequence.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Check {
    /// The frames with this CAN-ID nowhere follow each other like these.
    Otherwise {
        /// The CAN-ID of the answers.
        can_id: u16,
        /// The last answers in the evidence, up to the wrong one.
        answers: Vec<Frame>,
    },
    /// This frame came fewer than `times` times.
    Fewer {
        /// The wrong frame.
        frame: Frame,
        /// Whether frames with other data count as well.
        any_data: bool,
        /// The number of such frames in the evidence.
        times: usize,
    },
    /// More frames with this CAN-ID came after the last frame of the sequence.
    More {
        /// The CAN-ID of the missing frame.
        can_id: u16,
        /// The number of such frames in the evidence.
        than: usize,
        /// Whether the check counts a boot-up message as one of these frames.
        boot_up: bool,
        /// The time after the last frame of the sequence within which they have to come.
        within: Duration,
    },
    /// The time before a frame with this CAN-ID is in these limits.
    Period {
        /// The CAN-ID of the periodic frame.
        can_id: u16,
        /// The number of the frame, from 1. `None`: each frame after the last frame of the sequence, and at least one.
        number: Option<usize>,
        /// The shortest time.
        least: Duration,
        /// The longest time.
        most: Duration,
    },
    /// The device starts after a reset.
    Starts,
    /// Only the reference models can tell.
    Unknown,
}

/// Rules that judge the number of frames and not their data.
const COUNTED: [&str; 2] = ["synchronous TPDO", "EMCY storm"];

/// Number of answers, up to the wrong one, by which a check recognises the situation.
const CONTEXT: usize = 4;

/// The rule by which a boot-up message is missing.
const BOOT_UP: &str = "boot-up after reset";

impl Check {
    /// The check that the device of the violation fails.
    pub fn of(found: &Found) -> Self {
        let (violation, evidence) = (&found.violation, &found.evidence[..]);
        let (can_id, is_missing) = match violation.symptom {
            Symptom::Dead => return Self::Starts,
            Symptom::Frame(frame) => (frame.id().as_standard(), false),
            Symptom::Missing(can_id) => (can_id, true),
        };
        match (violation.symptom, violation.interval.as_deref().copied(), can_id) {
            (_, Some((least, most)), Some(can_id)) => {
                let number = received(evidence, can_id).count();
                Self::Period { can_id, number: (!is_missing).then_some(number), least, most }
            }
            (Symptom::Frame(_), _, Some(can_id @ (0x580..=0x5FF | SLAVE_CAN_ID))) => {
                let mut answers: Vec<Frame> = received(evidence, can_id).map(|record| record.frame).collect();
                answers.drain(..answers.len().saturating_sub(CONTEXT));
                Self::Otherwise { can_id, answers }
            }
            (Symptom::Frame(frame), ..) => {
                let any_data = COUNTED.contains(&violation.rule);
                let times = count(evidence, &frame, any_data).max(1);
                Self::Fewer { frame, any_data, times }
            }
            (_, _, Some(can_id)) => {
                let own = evidence.iter().rfind(|record| record.direction == Direction::Tx);
                let last = own.map_or(Timestamp::ZERO, |record| record.timestamp);
                let boot_up = violation.rule == BOOT_UP;
                // Heartbeats may come later. The other answers come only to requests.
                let within = if is_error_control(can_id) { violation.at.since(last) } else { Duration(u64::MAX) };
                let than = answers(evidence, can_id, last, boot_up).count();
                Self::More { can_id, than, boot_up, within }
            }
            (_, _, None) => Self::Unknown,
        }
    }

    /// Whether the frames on the bus fulfil the check. `None`: the frames do not tell. `last`: the time of the last
    /// frame of the sequence.
    pub fn holds(&self, trace: &[Record], last: Timestamp) -> Option<bool> {
        match self {
            Self::Otherwise { can_id, answers } => {
                let came: Vec<Frame> = received(trace, *can_id).map(|record| record.frame).collect();
                Some(came.windows(answers.len().max(1)).all(|came| came != answers))
            }
            Self::Fewer { frame, any_data, times } => Some(count(trace, frame, *any_data) < *times),
            Self::More { can_id, than, boot_up, within } => {
                let in_time = |record: &&Record| record.timestamp.since(last) <= *within;
                Some(answers(trace, *can_id, last, *boot_up).filter(in_time).count() > *than)
            }
            Self::Period { can_id, number: Some(number), least, most } => {
                let times: Vec<Timestamp> = received(trace, *can_id).map(|record| record.timestamp).collect();
                let before = times.get(number.wrapping_sub(2));
                let gap = before.and_then(|before| Some(times.get(number - 1)?.since(*before)));
                Some(gap.is_none_or(|gap| (*least..=*most).contains(&gap)))
            }
            Self::Period { can_id, number: None, least, most } => {
                let mut times = received(trace, *can_id).map(|record| record.timestamp).filter(|at| *at > last);
                let Some(mut before) = times.next() else { return Some(false) };
                Some(times.all(|at| (*least..=*most).contains(&at.since(std::mem::replace(&mut before, at)))))
            }
            Self::Starts | Self::Unknown => None,
        }
    }

    /// Time to listen after the last frame of the sequence of a violation.
    pub fn patience(&self, found: &Found) -> Duration {
        let own = found.evidence.iter().rfind(|record| record.direction == Direction::Tx);
        let took = own.map_or(Duration::ZERO, |record| found.violation.at.since(record.timestamp));
        let usual = took.times(2).max(LEAST_PATIENCE);
        match self {
            Self::Period { least, most: Duration(u64::MAX), .. } => usual.max(least.times(PERIODS)),
            Self::Period { most, .. } => usual.max(most.times(PERIODS)),
            _ => usual,
        }
    }
}

/// Minimum time for which the check listens after it has sent the sequence.
const LEAST_PATIENCE: Duration = Duration::from_millis(500);

/// Number of periods to listen for.
const PERIODS: u64 = 4;

fn received(trace: &[Record], can_id: u16) -> impl Iterator<Item = &Record> {
    trace.iter().filter(move |record| record.direction != Direction::Tx && record.frame.cob_id() == Some(can_id))
}

/// The frames with this CAN-ID after the time `last`.
fn answers(trace: &[Record], can_id: u16, last: Timestamp, boot_up: bool) -> impl Iterator<Item = &Record> {
    let is_boot_up = move |record: &Record| is_error_control(can_id) && record.frame.data() == [0];
    received(trace, can_id).filter(move |record| record.timestamp > last && (boot_up || !is_boot_up(record)))
}

fn is_error_control(can_id: u16) -> bool {
    (0x701..=0x77F).contains(&can_id)
}

fn count(trace: &[Record], frame: &Frame, any_data: bool) -> usize {
    let is_it = |other: &Frame| other == frame || any_data && other.id() == frame.id();
    trace.iter().filter(|record| record.direction != Direction::Tx && is_it(&record.frame)).count()
}
