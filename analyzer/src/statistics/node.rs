//! Statistics of one node.

use super::histogram::Histogram;
use super::peak::Peak;
use crate::message::{Message, Service};
use crate::network::sdo::{ChannelIndex, Direction, Outcome, Transfer, Violation};
use crate::network::{Bus, Cause, Decoded, Event, OpenErrors};
use crate::object;
use crate::room::Room;
use crate::wire::emcy::{Emcy, EmcyCode, ErrorRegister};
use crate::wire::error_control::State;
use crate::wire::sdo::Request;
use canvass_traces::Timestamp;

/// Statistics of one node.
#[derive(Clone, Debug, Default)]
pub struct NodeStatistics {
    /// Number of frames from and to the node, by service in the order of [`Service::ALL`].
    pub frames: [u64; Service::ALL.len()],
    /// Number of bits of these frames.
    pub bits: u64,
    /// Time of the first frame.
    pub first: Timestamp,
    /// Time of the last frame.
    pub last: Timestamp,
    /// Whether the node has sent a frame itself; else it was only addressed.
    pub present: bool,
    /// Number of the node's boot-ups.
    pub boot_ups: u64,
    /// The node's NMT states over time, at most [`NodeStatistics::STATES`].
    pub states: Vec<StateChange>,
    /// Number of further changes of state.
    pub states_omitted: u64,
    /// The response times of the node's SDO servers.
    pub responses: Histogram,
    /// Number of completed SDO transfers.
    pub completed: u64,
    /// Number of aborted SDO transfers.
    pub aborted: u64,
    /// EMCY messages by code, at most [`NodeStatistics::CODES`] different codes.
    pub emcy: Vec<EmcyCount>,
    /// The node's errors from their first EMCY to their end, at most [`NodeStatistics::ERRORS`].
    pub errors: Vec<ErrorEpisode>,
    /// Number of further errors.
    pub errors_omitted: u64,
    /// The fullest window of the node's frames.
    pub peak: Peak,
    /// The node's identity, as read from the node.
    pub identity: IdentityText,
    /// The present errors, each with its index in `errors`.
    open_errors: OpenErrors<usize>,
    /// Number of SDO and guarding requests without an answer.
    pub unanswered: u64,
    /// Whether there was any frame.
    begun: bool,
    /// The unanswered SDO requests, by channel.
    asked: Vec<(ChannelIndex, Timestamp, Message)>,
}

/// A change of the NMT state.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct StateChange {
    /// Time of the change.
    pub time: Timestamp,
    /// The new state.
    pub state: State,
    /// The source of the knowledge.
    pub cause: Cause,
}

/// An error that a node has reported, and its end.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ErrorEpisode {
    /// The error code.
    pub code: EmcyCode,
    /// The error register in the error's EMCY.
    pub register: Option<ErrorRegister>,
    /// Time of the error's first EMCY.
    pub raised: Timestamp,
    /// Time and kind of the error's end; `None` if the capture shows neither an EMCY nor a restart that ends the error.
    pub ended: Option<(Timestamp, ErrorEnd)>,
}

/// The end of an error.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ErrorEnd {
    /// An EMCY with the code 00xxh.
    Reported,
    /// A boot-up of the node.
    BootUp,
}

/// The number of EMCYs with an error code.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct EmcyCount {
    /// The code; 00xxh is the end of an error.
    pub code: EmcyCode,
    /// Number of EMCYs with the code.
    pub count: u64,
    /// Time of the first EMCY.
    pub first: Timestamp,
    /// Time of the last EMCY.
    pub last: Timestamp,
}

/// The identity of a node, as read from it by SDO.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct IdentityText {
    /// 1000h: device type.
    pub device_type: Option<u32>,
    /// 1018h:1 to 4: vendor-ID, product code, revision number, serial number.
    pub numbers: [Option<u32>; 4],
    /// 1008h, 1009h, 100Ah: name, hardware version, software version. Control characters are escaped.
    pub names: [Option<String>; 3],
}

impl NodeStatistics {
    /// Maximum number of changes of state that are kept.
    pub const STATES: usize = 1000;
    /// Maximum number of different error codes.
    pub const CODES: usize = 64;
    /// Maximum number of errors kept with their times.
    pub const ERRORS: usize = 256;
    /// Maximum number of channels of a node with an unanswered request.
    const CHANNELS: usize = 16;
    /// Maximum number of characters of a name that are kept.
    pub const NAME: usize = 64;
    /// A growing list takes up to twice the memory of its content.
    const GROWTH: usize = 2;

    /// Counts a frame of the node.
    pub(super) fn frame(&mut self, now: Timestamp, bits: u32, decoded: &Decoded, bus: &Bus, room: &Room) {
        if !std::mem::replace(&mut self.begun, true) {
            self.first = now;
        }
        self.last = now;
        self.frames[decoded.service as usize] += 1;
        self.bits += u64::from(bits);
        if decoded.is_from_node() {
            (self.present, self.unanswered) = (true, 0);
        } else {
            let asks = matches!(decoded.message, Message::SdoRequest(_) | Message::GuardingRequest);
            self.unanswered += u64::from(asks);
        }
        match decoded.service {
            Service::BootUp if !decoded.repeats_boot_up() => {
                self.boot_ups += 1;
                self.asked.clear();
                self.restarted(now);
            }
            Service::Emcy => self.emcy(now, decoded, room),
            Service::Sdo => self.sdo(now, decoded, bus, room),
            _ => {}
        }
        if let Some(Event::StateChanged(_, change)) = decoded.event {
            self.state(now, change.to, change.cause, room);
        }
    }

    /// Notes a state.
    pub(super) fn state(&mut self, time: Timestamp, state: State, cause: Cause, room: &Room) {
        if self.states.len() < Self::STATES && room.take(Self::GROWTH * size_of::<StateChange>()) {
            self.states.push(StateChange { time, state, cause });
        } else {
            self.states_omitted += 1;
        }
    }

    fn emcy(&mut self, now: Timestamp, decoded: &Decoded, room: &Room) {
        let Message::Emcy(emcy) = decoded.message else { return };
        let Some(code) = emcy.code() else { return };
        self.error(now, code, &emcy, room);
        if let Some(row) = self.emcy.iter_mut().find(|row| row.code == code) {
            (row.count, row.last) = (row.count + 1, now);
        } else if self.emcy.len() < Self::CODES && room.take(Self::GROWTH * size_of::<EmcyCount>()) {
            self.emcy.push(EmcyCount { code, count: 1, first: now, last: now });
        }
    }

    fn error(&mut self, now: Timestamp, code: EmcyCode, emcy: &Emcy, room: &Room) {
        let known = self.open_errors.iter().any(|row| row.0 == code);
        let place = self.errors.len();
        for (_, at) in self.open_errors.handle(emcy, || place) {
            if let Some(error) = self.errors.get_mut(at) {
                error.ended = Some((now, ErrorEnd::Reported));
            }
        }
        if known || code.is_reset() {
            return;
        }
        if place < Self::ERRORS && room.take(Self::GROWTH * size_of::<ErrorEpisode>()) {
            self.errors.push(ErrorEpisode { code, register: emcy.register(), raised: now, ended: None });
        } else {
            self.errors_omitted += 1;
        }
    }

    /// A restart ends errors that were not taken back.
    fn restarted(&mut self, now: Timestamp) {
        for (_, at) in self.open_errors.iter() {
            if let Some(error) = self.errors.get_mut(*at) {
                error.ended = Some((now, ErrorEnd::BootUp));
            }
        }
        self.open_errors.clear();
    }

    /// Handles a request; a repeated request counts from its first sending.
    fn asked(&mut self, channel: Option<ChannelIndex>, now: Timestamp, message: Message) {
        let Some(channel) = channel else { return };
        if self.asked.iter().any(|asked| asked.0 == channel && asked.2 == message) {
            return;
        }
        self.asked.retain(|asked| asked.0 != channel);
        if self.asked.len() < Self::CHANNELS {
            self.asked.push((channel, now, message));
        }
    }

    /// The time of the request that is answered or abandoned.
    fn answered(&mut self, channel: Option<ChannelIndex>) -> Option<Timestamp> {
        let at = self.asked.iter().position(|asked| Some(asked.0) == channel)?;
        Some(self.asked.swap_remove(at).1)
    }

    fn sdo(&mut self, now: Timestamp, decoded: &Decoded, bus: &Bus, room: &Room) {
        match decoded.message {
            // Only the last segment of a block is answered.
            Message::SdoRequest(Request::Abort(_) | Request::EndBlockUpload) | Message::SdoBlockDownload(_) => {
                self.answered(decoded.channel);
            }
            message @ Message::SdoRequest(_) => self.asked(decoded.channel, now, message),
            Message::SdoResponse(_) | Message::SdoBlockUpload(_) => {
                if let Some(asked) = self.answered(decoded.channel) {
                    self.responses.add(now.since(asked), room);
                }
            }
            _ => {}
        }
        if !decoded.ends_transfer() {
            return;
        }
        let Some(transfer) = decoded.channel.and_then(|channel| bus.transfer(channel)) else { return };
        match transfer.outcome {
            Outcome::Complete => {
                self.completed += 1;
                // An answer about another object says nothing about the requested one.
                if !matches!(decoded.violation, Some(Violation::Multiplexer(_))) {
                    self.identify(transfer);
                }
            }
            Outcome::Aborted(..) => self.aborted += 1,
            _ => {}
        }
    }

    fn identify(&mut self, transfer: &Transfer) {
        if transfer.direction != Direction::Upload {
            return;
        }
        let (index, sub, data) = (transfer.multiplexer.index.0, transfer.multiplexer.sub.0, transfer.data());
        let number = data.first_chunk::<4>().map(|bytes| u32::from_le_bytes(*bytes));
        match (index, sub) {
            (object::DEVICE_TYPE, 0) => self.identity.device_type = number.or(self.identity.device_type),
            (object::IDENTITY, 1..=4) => self.identity.numbers[usize::from(sub) - 1] = number,
            (0x1008..=0x100A, 0) => {
                let text = name(&data[..data.len().min(Self::NAME)]);
                self.identity.names[usize::from(index - object::MANUFACTURER_DEVICE_NAME)] = Some(text);
            }
            _ => {}
        }
    }

    /// The statistics, if the node has sent a frame, or did not answer a request: a node that was only commanded may
    /// not exist. A node without frames has no state.
    pub(super) fn shown(mut self) -> Option<Self> {
        if !self.present {
            self.states.clear();
        }
        (self.present || self.unanswered > 0).then_some(self)
    }

    /// Number of all frames.
    pub fn total(&self) -> u64 {
        self.frames.iter().sum()
    }
}

/// A name sent by a device, in UTF-8 or, as in most firmware, in Latin-1. Only control characters are escaped.
fn name(data: &[u8]) -> String {
    let text = match std::str::from_utf8(data) {
        Ok(text) => text.to_owned(),
        Err(_) => data.iter().map(|&byte| char::from(byte)).collect(),
    };
    let mut name = String::new();
    for character in text.trim_end_matches('\0').chars() {
        match character.is_control() {
            true => name.extend(character.escape_debug()),
            false => name.push(character),
        }
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_keep_their_letters_and_quotes() {
        assert_eq!(name(b"K\xFCbler \"Sendix\" \0\0"), "K\u{fc}bler \"Sendix\" ");
        assert_eq!(name("Kübler".as_bytes()), "Kübler");
        assert_eq!(name(b"a\x1b[2Jb\n"), "a\\u{1b}[2Jb\\n");
    }
}
