//! Figures of one node.

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

/// Figures of one node.
#[derive(Clone, Debug, Default)]
pub struct NodeStatistics {
    /// Its frames, and those to it, by service: in the order of [`Service::ALL`].
    pub frames: [u64; Service::ALL.len()],
    /// The bits of these frames.
    pub bits: u64,
    /// The first of them.
    pub first: Timestamp,
    /// The last of them.
    pub last: Timestamp,
    /// Whether it has sent anything itself: else it was only addressed.
    pub present: bool,
    /// Its boot-ups.
    pub boot_ups: u64,
    /// Its NMT states over time, at most [`NodeStatistics::STATES`].
    pub states: Vec<StateChange>,
    /// How many more changes there were.
    pub states_omitted: u64,
    /// The response times of its SDO servers.
    pub responses: Histogram,
    /// SDO transfers that were completed.
    pub completed: u64,
    /// SDO transfers that were aborted.
    pub aborted: u64,
    /// EMCY by code, at most [`NodeStatistics::CODES`] different ones.
    pub emcy: Vec<EmcyCount>,
    /// Its errors from their first EMCY to their end, at most [`NodeStatistics::ERRORS`].
    pub errors: Vec<ErrorEpisode>,
    /// How many more there were.
    pub errors_omitted: u64,
    /// The fullest moment of its frames.
    pub peak: Peak,
    /// Who it is, as was read from it.
    pub identity: IdentityText,
    /// The errors that are present, each with its place in `errors`.
    open_errors: OpenErrors<usize>,
    /// SDO and guarding requests to it that it has not answered yet.
    pub unanswered: u64,
    /// Whether there was a frame at all.
    begun: bool,
    /// The latest SDO requests without an answer, by channel.
    asked: Vec<(ChannelIndex, Timestamp, Message)>,
}

/// A change of the NMT state.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct StateChange {
    /// When it was seen.
    pub time: Timestamp,
    /// The state from then on.
    pub state: State,
    /// How it is known.
    pub cause: Cause,
}

/// An error that a node has reported, and its end.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ErrorEpisode {
    /// The error code.
    pub code: EmcyCode,
    /// The error register that came with it.
    pub register: Option<ErrorRegister>,
    /// When it was first reported.
    pub raised: Timestamp,
    /// When the node has taken it back, or started anew; `None` where the capture shows neither.
    pub ended: Option<(Timestamp, ErrorEnd)>,
}

/// How an error has ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ErrorEnd {
    /// By an EMCY with the code 00xxh.
    Reported,
    /// By a boot-up of the node.
    BootUp,
}

/// How often an error code was sent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct EmcyCount {
    /// The code; 00xxh is the end of an error.
    pub code: EmcyCode,
    /// How often.
    pub count: u64,
    /// When first.
    pub first: Timestamp,
    /// When last.
    pub last: Timestamp,
}

/// Who a node is, as was read from it by SDO.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct IdentityText {
    /// 1000h.
    pub device_type: Option<u32>,
    /// 1018h:1 to 4: vendor-ID, product code, revision number, serial number.
    pub numbers: [Option<u32>; 4],
    /// 1008h, 1009h, 100Ah: name, hardware version, software version. Control characters are escaped.
    pub names: [Option<String>; 3],
}

impl NodeStatistics {
    /// How many changes of state are kept.
    pub const STATES: usize = 1000;
    /// How many error codes are distinguished.
    pub const CODES: usize = 64;
    /// How many errors are kept with their times.
    pub const ERRORS: usize = 256;
    /// How many channels of a node are waited for at a time.
    const CHANNELS: usize = 16;
    /// How many characters of a name are kept.
    pub const NAME: usize = 64;
    /// A list that grows takes up to twice the memory of what is in it.
    const GROWTH: usize = 2;

    /// Takes a frame of the node.
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

    /// A restart ends what was not taken back.
    fn restarted(&mut self, now: Timestamp) {
        for (_, at) in self.open_errors.iter() {
            if let Some(error) = self.errors.get_mut(*at) {
                error.ended = Some((now, ErrorEnd::BootUp));
            }
        }
        self.open_errors.clear();
    }

    /// A request; one that is repeated waits since the first time.
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

    /// When the request was sent that is answered or given up now.
    fn answered(&mut self, channel: Option<ChannelIndex>) -> Option<Timestamp> {
        let at = self.asked.iter().position(|asked| Some(asked.0) == channel)?;
        Some(self.asked.swap_remove(at).1)
    }

    fn sdo(&mut self, now: Timestamp, decoded: &Decoded, bus: &Bus, room: &Room) {
        match decoded.message {
            // Segments of a block: the last one is answered.
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
                // An answer about another object says nothing about the one that was asked for.
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

    /// The figures, if the node has sent something, or was asked and did not answer: who was only commanded may not
    /// exist. A node that never sent anything has no state.
    pub(super) fn shown(mut self) -> Option<Self> {
        if !self.present {
            self.states.clear();
        }
        (self.present || self.unanswered > 0).then_some(self)
    }

    /// All frames.
    pub fn total(&self) -> u64 {
        self.frames.iter().sum()
    }
}

/// A name as a device tells it: in UTF-8, or as most firmware writes it in Latin-1. Control characters are escaped, and
/// nothing else.
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
