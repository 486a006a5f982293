//! Functions that change a frame in the way in which a format or a peer loses information.

use crate::recording::Seen;
use canvass_traces::{Direction, ErrorClass, Flags, Frame, Record, Timestamp};

/// The change of a frame by one loss.
pub type Kept = fn(Seen) -> Seen;

/// The frame after several losses.
pub fn kept(seen: &Seen, losses: &[Kept]) -> Seen {
    losses.iter().fold(seen.clone(), |seen, loss| loss(seen))
}

/// Keeps times to the microsecond.
pub fn micros(mut seen: Seen) -> Seen {
    seen.record.timestamp = Timestamp(seen.record.timestamp.nanos() / 1_000 * 1_000);
    seen
}

/// Replaces names of channels by numbers: `can0` becomes 1.
pub fn numbered(seen: Seen) -> Seen {
    let number: u16 = seen.channel.trim_start_matches("can").parse().unwrap();
    Seen { channel: (number + 1).to_string(), ..seen }
}

/// Names channel can0 0, which is how python-can numbers the channels in MF4.
pub fn numbered_from_0(seen: Seen) -> Seen {
    Seen { channel: seen.channel.trim_start_matches("can").into(), ..seen }
}

/// Puts all frames on one channel.
pub fn one_channel(seen: Seen) -> Seen {
    Seen { channel: "can0".into(), ..seen }
}

/// Puts all frames on one channel with the name 1.
pub fn channel_1(seen: Seen) -> Seen {
    Seen { channel: "1".into(), ..seen }
}

fn with_direction(seen: Seen, direction: Direction) -> Seen {
    Seen { record: seen.record.with_direction(direction), ..seen }
}

/// Removes directions.
pub fn no_direction(seen: Seen) -> Seen {
    with_direction(seen, Direction::Unknown)
}

/// Takes frames with unknown direction for received.
pub fn received_or_sent(seen: Seen) -> Seen {
    let direction = if seen.record.direction == Direction::Tx { Direction::Tx } else { Direction::Rx };
    with_direction(seen, direction)
}

/// Takes all frames for received.
pub fn received(seen: Seen) -> Seen {
    with_direction(seen, Direction::Rx)
}

/// Removes the directions of error frames.
pub fn no_direction_of_errors(seen: Seen) -> Seen {
    if seen.record.frame.is_error() { no_direction(seen) } else { seen }
}

/// Takes error frames for received.
pub fn received_errors(seen: Seen) -> Seen {
    if seen.record.frame.is_error() { received(seen) } else { seen }
}

fn with_error(seen: Seen, data: &[u8]) -> Seen {
    let Record { timestamp, channel, ref frame, .. } = seen.record;
    if !frame.is_error() {
        return seen;
    }
    let record = Record::new(timestamp, channel, Frame::error(ErrorClass(0x80), data).unwrap());
    seen.with_record(record)
}

/// Reduces an error frame to a bus error, with the error class of Linux.
pub fn no_error_detail(seen: Seen) -> Seen {
    with_error(seen, &[])
}

/// Reduces an error frame to a bus error, with the eight data bytes of SocketCAN's error frames.
pub fn zeros_of_errors(seen: Seen) -> Seen {
    with_error(seen, &[0; 8])
}

/// Removes BRS and ESI from CAN FD frames.
pub fn no_fd_flags(seen: Seen) -> Seen {
    let Record { timestamp, channel, ref frame, .. } = seen.record;
    if !frame.is_fd() {
        return seen;
    }
    let record = Record::fd(timestamp, channel, frame.id(), Flags::NONE, seen.record.data()).unwrap();
    seen.with_record(record)
}

/// Turns CAN FD frames of up to 8 bytes into classical frames.
pub fn no_short_fd(seen: Seen) -> Seen {
    let Record { timestamp, channel, ref frame, .. } = seen.record;
    if !frame.is_fd() || frame.len() > 8 {
        return seen;
    }
    let record = Record::new(timestamp, channel, Frame::new(frame.id(), frame.data()).unwrap());
    seen.with_record(record)
}
