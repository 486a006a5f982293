//! The reactions of a null device to frames.

use super::NullDevice;
use crate::dice::Dice;
use canvass_analyzer::wire::error_control::{self, ErrorControl};
use canvass_analyzer::wire::layer_setting::{ConfigureCommand, MASTER_CAN_ID, SLAVE_CAN_ID};
use canvass_analyzer::wire::nmt::{self, Nmt};
use canvass_analyzer::wire::sdo::{AbortCode, REQUEST_BASE, RESPONSE_BASE, Request, Response};
use canvass_analyzer::wire::{Wire, lss};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::{CanId, Frame};
use std::collections::BTreeMap;

/// The reaction of a null device to a frame.
pub(super) enum Reaction {
    /// The right device behind the null device receives the frame.
    Passed,
    /// The right device does not receive the frame; the null device sends these frames instead.
    Answered(Vec<Frame>),
}

/// The rules of a null device, and the state that they need.
#[derive(Clone)]
pub(super) struct Answers {
    kind: NullDevice,
    node: u16,
    dice: Dice,
    /// The sequence number of the next segment, while a block is downloaded.
    block: Option<u8>,
    /// The written values, if every object has one byte.
    bytes: BTreeMap<Multiplexer, u8>,
}

/// Number of segments in each block: the maximum.
const BLOCK_SIZE: u8 = 127;

impl Answers {
    pub fn new(kind: NullDevice, node: NodeId) -> Self {
        Self { kind, node: u16::from(node.raw()), dice: Dice::new(1), block: None, bytes: BTreeMap::new() }
    }

    /// The reaction to a frame on the bus.
    pub fn react(&mut self, frame: &Frame) -> Reaction {
        let is_plain = !frame.is_remote() && !frame.is_error();
        let id = frame.cob_id().filter(|_| is_plain);
        match self.kind {
            NullDevice::Silent => Reaction::Answered(Vec::new()),
            NullDevice::Ghost | NullDevice::OneByte if id == Some(REQUEST_BASE + self.node) => self.on_object(frame),
            NullDevice::ConfirmsAll => self.confirmed(id, frame),
            NullDevice::Ghost | NullDevice::OneByte | NullDevice::MandatoryOnly => Reaction::Passed,
            _ => Reaction::Answered(id.map_or_else(Vec::new, |id| self.on_any(id, frame))),
        }
    }

    /// The frame that is sent instead of a frame of the right device; `None` if nothing is sent.
    pub fn on_send(&self, frame: Frame) -> Option<Frame> {
        match self.kind {
            NullDevice::ConfirmsAll | NullDevice::Ghost | NullDevice::MandatoryOnly => Some(frame),
            NullDevice::OneByte => Some(self.cut(frame)),
            // These null devices send even their boot-up message themselves: no frame of the right device is sent.
            _ => None,
        }
    }

    /// The answers of devices that do nothing right except starting.
    fn on_any(&mut self, id: u16, frame: &Frame) -> Vec<Frame> {
        if id == nmt::CAN_ID {
            return self.boot_up(frame).into_iter().collect();
        }
        let answer_id = match id {
            MASTER_CAN_ID => SLAVE_CAN_ID,
            _ if id == REQUEST_BASE + self.node => RESPONSE_BASE + self.node,
            // The RPDOs of the predefined connection set are answered by the TPDOs with their numbers.
            0x201..=0x57F if id & 0x80 == 0 && id & 0x7F == self.node => id - 0x80,
            _ => return Vec::new(),
        };
        self.answer(answer_id, frame).into_iter().collect()
    }

    fn answer(&mut self, id: u16, request: &Frame) -> Option<Frame> {
        match self.kind {
            NullDevice::Echo => Some(with_id(request, id)),
            NullDevice::AlwaysSame => {
                let usual = Response::upload(Multiplexer::new(canvass_analyzer::object::DEVICE_TYPE, 0), &[0; 4]);
                Some(usual.to_frame(id))
            }
            NullDevice::Random => Some(Frame::full(CanId::standard_masked(id.into()), self.dice.next().to_le_bytes())),
            NullDevice::RefusesAll => self.refusal(id, request),
            _ => None,
        }
    }

    fn refusal(&self, id: u16, request: &Frame) -> Option<Frame> {
        if id == SLAVE_CAN_ID {
            return configured(request, 1);
        }
        if id != RESPONSE_BASE + self.node {
            return None;
        }
        match Request::read(request.data()).ok()? {
            Request::Abort(_) => None,
            request => {
                let object = request.multiplexer().unwrap_or(Multiplexer::new(0, 0));
                Some(Response::abort(object, AbortCode::GENERAL).to_frame(id))
            }
        }
    }

    fn boot_up(&self, frame: &Frame) -> Option<Frame> {
        let nmt = Nmt::read(frame.data()).ok().filter(|nmt| nmt.command.is_reset())?;
        let is_meant = nmt.node == 0 || u16::from(nmt.node) == self.node;
        is_meant.then(|| ErrorControl::BOOT_UP.to_frame(error_control::CAN_ID_BASE + self.node))
    }

    /// Passes reads and resets on; confirms every other request, and ignores every other command.
    fn confirmed(&mut self, id: Option<u16>, frame: &Frame) -> Reaction {
        let answer = match id {
            Some(nmt::CAN_ID) if Nmt::read(frame.data()).is_ok_and(|nmt| nmt.command.is_reset()) => {
                return Reaction::Passed;
            }
            Some(MASTER_CAN_ID) => configured(frame, 0),
            Some(id) if id == REQUEST_BASE + self.node => match self.confirmation(frame) {
                Some(answer) => answer,
                None => return Reaction::Passed,
            },
            _ => None,
        };
        Reaction::Answered(answer.into_iter().collect())
    }

    /// The confirmation of a write request, if it has one; the outer `None` if the request reads.
    fn confirmation(&mut self, frame: &Frame) -> Option<Option<Frame>> {
        let answer = |response: Response| Some(Some(response.to_frame(RESPONSE_BASE + self.node)));
        if let Some(sequence) = self.block {
            let [head, ..] = frame.bytes();
            let is_last = head & 0x80 != 0 || sequence >= BLOCK_SIZE;
            self.block = (!is_last).then_some(sequence + 1);
            return if is_last {
                answer(Response::ConfirmBlockDownload { sequence: head & 0x7F, block_size: BLOCK_SIZE })
            } else {
                Some(None)
            };
        }
        match Request::read(frame.data()).ok()? {
            Request::InitiateDownload { multiplexer, .. } => answer(Response::InitiateDownload { multiplexer }),
            Request::DownloadSegment(segment) => answer(Response::DownloadSegment { toggle: segment.toggle }),
            Request::InitiateBlockDownload { multiplexer, .. } => {
                let response = Response::InitiateBlockDownload { multiplexer, crc: true, block_size: BLOCK_SIZE };
                let confirmed = answer(response);
                self.block = Some(1);
                confirmed
            }
            Request::EndBlockDownload { .. } => answer(Response::EndBlockDownload),
            _ => None,
        }
    }

    /// The reaction to a request if the objects differ from the description.
    fn on_object(&mut self, frame: &Frame) -> Reaction {
        let Ok(request) = Request::read(frame.data()) else { return Reaction::Passed };
        let Some(object) = request.multiplexer() else { return Reaction::Passed };
        let response = match (self.kind, request) {
            (_, Request::Abort(_)) => return Reaction::Passed,
            (NullDevice::Ghost, _) => Response::abort(object, AbortCode::NO_OBJECT),
            (_, Request::InitiateDownload { payload, .. }) => match payload.value() {
                Some([byte]) => {
                    self.bytes.insert(object, *byte);
                    Response::InitiateDownload { multiplexer: object }
                }
                _ => Response::abort(object, AbortCode::LENGTH),
            },
            (_, Request::InitiateBlockDownload { .. } | Request::InitiateBlockUpload { .. }) => {
                Response::abort(object, AbortCode::COMMAND_SPECIFIER)
            }
            _ => return Reaction::Passed,
        };
        Reaction::Answered(vec![response.to_frame(RESPONSE_BASE + self.node)])
    }

    /// An uploaded value, cut to one byte.
    fn cut(&self, frame: Frame) -> Frame {
        match Response::read(frame.data()) {
            Ok(Response::InitiateUpload { multiplexer, payload })
                if frame.cob_id() == Some(RESPONSE_BASE + self.node) =>
            {
                let own = payload.value().and_then(|value| value.first().copied()).unwrap_or_default();
                let byte = self.bytes.get(&multiplexer).copied().unwrap_or(own);
                Response::upload(multiplexer, &[byte]).to_frame(RESPONSE_BASE + self.node)
            }
            _ => frame,
        }
    }
}

/// The answer of a slave to a configuration, with this error code.
fn configured(request: &Frame, error: u8) -> Option<Frame> {
    let [command, ..] = request.bytes();
    let command = [ConfigureCommand::NodeId, ConfigureCommand::BitTiming, ConfigureCommand::Store]
        .into_iter()
        .find(|known| *known as u8 == command)?;
    let response: lss::Response = lss::Response::Configured { command, error, specific: 0 };
    Some(response.to_frame(SLAVE_CAN_ID))
}

fn with_id(frame: &Frame, id: u16) -> Frame {
    Frame::new(CanId::standard_masked(u32::from(id)), frame.data()).unwrap_or(*frame)
}
