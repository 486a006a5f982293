//! Figures of one node.

use super::histogram::Histogram;
use crate::message::{Message, Service};
use crate::network::sdo::{Direction, Outcome, Transfer};
use crate::network::{Bus, Cause, Decoded, Event};
use crate::wire::emcy::EmcyCode;
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
    /// Who it is, as was read from it.
    pub identity: IdentityText,
    /// The latest SDO request without an answer.
    asked: Option<Timestamp>,
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
    /// How many error codes are told apart.
    pub const CODES: usize = 64;
    /// How many characters of a name are kept.
    pub const NAME: usize = 64;

    /// Takes a frame of the node.
    pub(super) fn frame(&mut self, now: Timestamp, bits: u32, decoded: &Decoded, bus: &Bus) {
        if self.frames.iter().all(|count| *count == 0) {
            self.first = now;
        }
        self.last = now;
        self.frames[decoded.service as usize] += 1;
        self.bits += u64::from(bits);
        self.present |= crate::findings::is_from_node(decoded);
        match decoded.service {
            Service::BootUp => {
                self.boot_ups += 1;
                self.asked = None;
            }
            Service::Emcy => self.emcy(now, decoded),
            Service::Sdo => self.sdo(now, decoded, bus),
            _ => {}
        }
        if let Some(Event::StateChanged(_, change)) = decoded.event {
            self.state(now, change.to, change.cause);
        }
    }

    /// Notes a state.
    pub(super) fn state(&mut self, time: Timestamp, state: State, cause: Cause) {
        if self.states.len() < Self::STATES {
            self.states.push(StateChange { time, state, cause });
        } else {
            self.states_omitted += 1;
        }
    }

    fn emcy(&mut self, now: Timestamp, decoded: &Decoded) {
        let Message::Emcy(emcy) = decoded.message else { return };
        let Some(code) = emcy.code() else { return };
        if let Some(row) = self.emcy.iter_mut().find(|row| row.code == code) {
            (row.count, row.last) = (row.count + 1, now);
        } else if self.emcy.len() < Self::CODES {
            self.emcy.push(EmcyCount { code, count: 1, first: now, last: now });
        }
    }

    fn sdo(&mut self, now: Timestamp, decoded: &Decoded, bus: &Bus) {
        match decoded.message {
            Message::SdoRequest(Request::Abort(_) | Request::EndBlockUpload) => self.asked = None,
            Message::SdoRequest(_) => self.asked = Some(now),
            // Segments of a block: the last one is answered.
            Message::SdoBlockDownload(_) => self.asked = None,
            Message::SdoResponse(_) | Message::SdoBlockUpload(_) => {
                if let Some(asked) = self.asked.take() {
                    self.responses.add(now.since(asked));
                }
            }
            _ => {}
        }
        if decoded.event != Some(Event::TransferEnded) {
            return;
        }
        let Some(transfer) = decoded.channel.and_then(|channel| bus.transfer(channel)) else { return };
        match transfer.outcome {
            Outcome::Complete => {
                self.completed += 1;
                self.identify(transfer);
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
            (0x1000, 0) => self.identity.device_type = number.or(self.identity.device_type),
            (0x1018, 1..=4) => self.identity.numbers[usize::from(sub) - 1] = number,
            (0x1008..=0x100A, 0) => {
                let text = String::from_utf8_lossy(&data[..data.len().min(Self::NAME)]);
                let text = text.trim_end_matches('\0').escape_debug().to_string();
                self.identity.names[usize::from(index - 0x1008)] = Some(text);
            }
            _ => {}
        }
    }

    /// All frames.
    pub fn total(&self) -> u64 {
        self.frames.iter().sum()
    }
}
