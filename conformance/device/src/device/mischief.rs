//! Faults in single frames: the firmware misreads received frames, or alters or drops sent ones.
//!
//! These faults act between the bus and the services: a real firmware has them in its drivers, in its tables, and
//! between the stack and the application.

mod layer_setting;
mod tables;

use crate::{Fault, Faults};
use canvass_analyzer::object;
use canvass_analyzer::wire::error_control::{ErrorControl, State};
use canvass_analyzer::wire::sdo::{self, AbortCode, Request, Response};
use canvass_analyzer::wire::{Wire, emcy, error_control, lss, nmt, sync};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::{CanId, Frame};

/// The state that faults in single frames need.
#[derive(Clone, Debug)]
pub(super) struct Mischief {
    faults: Faults,
    /// The object and value of the last SDO download request.
    download: Option<(Multiplexer, u32)>,
    /// Whether the SDO server is working on a download.
    writing: bool,
    /// The value of 1800h:01 when it was last read.
    cob_id: Option<u32>,
    /// The last LSS request.
    request: [u8; 8],
    /// Whether the master has switched LSS slaves to configuration.
    configuring: bool,
    /// Whether sending is blocked until the next reset.
    muted: bool,
    /// Number of heartbeats of other nodes since the last reset.
    beats: u32,
    /// Number of SYNC messages received and sent.
    syncs: u32,
    /// Whether the master has started the node.
    operational: bool,
    /// Whether another LSS slave has answered.
    yielded: bool,
    /// Whether a mapping was refused since the last reset.
    mapping_refused: bool,
    /// Number of refused downloads to absent sub-indexes.
    refusals: u32,
}

/// The effect of the faults on a received frame.
#[derive(Clone, Copy, Debug)]
pub(super) enum Incoming {
    /// The device gets this frame, and the second frame after it.
    Frames(Frame, Option<Frame>),
    /// The device does not get the frame.
    Lost,
    /// The device does not get the frame; it sends this answer.
    Answered(Frame),
}

/// A CAN-ID without predefined use, to which test cases move PDOs.
const FREE: u16 = 0x6A0;

impl Mischief {
    pub fn new(faults: Faults) -> Self {
        Self {
            faults,
            download: None,
            writing: false,
            cob_id: None,
            request: [0; 8],
            configuring: false,
            muted: false,
            beats: 0,
            syncs: 0,
            operational: false,
            yielded: false,
            mapping_refused: false,
            refusals: 0,
        }
    }

    /// Whether the firmware has any fault, so that each frame must be passed to [`Mischief`].
    pub(crate) fn is_active(&self) -> bool {
        !self.faults.is_empty()
    }

    const fn has(&self, fault: Fault) -> bool {
        self.faults.has(fault)
    }

    /// Handles a received frame. `address` is the LSS address.
    pub(crate) fn on_receive(&mut self, frame: &Frame, node: Option<NodeId>, address: [u32; 4]) -> Incoming {
        let id = u16::try_from(frame.id().raw()).unwrap_or(u16::MAX);
        let own = node.map_or(0, |node| u16::from(node.raw()));
        let request_id = sdo::REQUEST_BASE + own;
        if frame.id().is_extended() {
            let misread = self.has(Fault::SdoExtendedAnswered) && id == request_id;
            return pass(if misread { with_id(frame, request_id) } else { *frame });
        }
        if frame.is_remote() {
            return self.on_remote(frame, id, own);
        }
        if frame.is_error() || frame.is_fd() || frame.is_xl() {
            return pass(*frame);
        }
        match id {
            nmt::CAN_ID => self.on_nmt(frame),
            lss::MASTER_CAN_ID => self.on_lss(frame, node, address),
            sync::CAN_ID => {
                self.syncs = self.syncs.wrapping_add(1);
                if self.syncs.is_multiple_of(7) && self.has(Fault::SyncOverlooked) {
                    Incoming::Lost
                } else {
                    pass(*frame)
                }
            }
            lss::SLAVE_CAN_ID => {
                self.yielded = true;
                pass(*frame)
            }
            _ if id & 0x780 == error_control::CAN_ID_BASE => {
                self.muted |= frame.len() != 1 && self.has(Fault::HeartbeatConsumerCrashes);
                self.beats = self.beats.saturating_add(1);
                let late = self.beats > 1 && self.has(Fault::HeartbeatConsumerNotRestarted);
                if late { Incoming::Lost } else { pass(*frame) }
            }
            FREE if self.has(Fault::RpdoKeepsCanId) => Incoming::Lost,
            FREE if self.has(Fault::SdoChannelsShareTransfer) => {
                let abort = Request::abort(Multiplexer::new(0, 0), AbortCode::GENERAL);
                Incoming::Frames(abort.to_frame(request_id), Some(*frame))
            }
            _ if node.is_none() => pass(*frame),
            _ if id == 0x200 + own && self.has(Fault::RpdoIgnored) => Incoming::Lost,
            _ if id == 0x200 + own && self.has(Fault::RpdoBytesReversed) => pass(reversed(frame)),
            _ if id == request_id + 1 && self.has(Fault::SdoOtherNodeAnswered) => pass(with_id(frame, request_id)),
            _ if id == request_id => self.on_sdo(frame, own),
            _ => pass(*frame),
        }
    }

    fn on_remote(&mut self, frame: &Frame, id: u16, own: u16) -> Incoming {
        if id == sdo::REQUEST_BASE + own && self.has(Fault::SdoRemoteAnswered) {
            // The firmware reads an old buffer: zeros, which are a download segment without a transfer.
            return pass(Frame::full(frame.id(), [0; 8]));
        }
        if id == error_control::CAN_ID_BASE + own && self.has(Fault::GuardingAnsweredUnsupported) {
            return Incoming::Answered(ErrorControl::heartbeat(State::PRE_OPERATIONAL).to_frame(id));
        }
        let deaf = self.has(Fault::TpdoRemoteIgnored) || self.has(Fault::RtrBitClearable);
        if id == 0x180 + own && deaf { Incoming::Lost } else { pass(*frame) }
    }

    fn on_nmt(&mut self, frame: &Frame) -> Incoming {
        if matches!(frame.data(), [0x81 | 0x82, ..]) {
            self.muted = false;
            self.beats = 0;
            self.mapping_refused = false;
        }
        self.operational = matches!(frame.data(), [0x01, ..]);
        match frame.data() {
            [_, _, command, node, ..] if self.has(Fault::NmtLongFrameMisread) => {
                pass(Frame::new(frame.id(), &[*command, *node]).unwrap_or(*frame))
            }
            _ => pass(*frame),
        }
    }

    fn on_sdo(&mut self, frame: &Frame, own: u16) -> Incoming {
        let response_id = sdo::RESPONSE_BASE + own;
        if let Ok(Request::InitiateUpload { multiplexer }) = Request::read(frame.data())
            && let Some(response) = self.surplus(multiplexer)
        {
            return Incoming::Answered(response.to_frame(response_id));
        }
        let Ok(Request::InitiateDownload { multiplexer, payload }) = Request::read(frame.data()) else {
            self.download = None;
            return pass(*frame);
        };
        let Some(bytes) = payload.value() else { return pass(*frame) };
        let value = bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte));
        self.download = Some((multiplexer, value));
        self.writing = true;
        if let Some(code) = self.refusal(multiplexer, value) {
            return Incoming::Answered(Response::abort(multiplexer, code).to_frame(response_id));
        }
        let (index, sub) = (multiplexer.index.0, multiplexer.sub.0);
        if index == object::STORE_PARAMETERS && self.operational && self.has(Fault::StoreSilentWhenOperational) {
            return Incoming::Lost;
        }
        let ignored = index == object::CONSUMER_HEARTBEAT_TIME
            && value & 0xFFFF == 0
            && self.has(Fault::HeartbeatConsumerNotStopped)
            || index == object::COMMUNICATION_CYCLE_PERIOD && value == 0 && self.has(Fault::SyncNotStopped);
        if ignored {
            return Incoming::Answered(Response::InitiateDownload { multiplexer }.to_frame(response_id));
        }
        let other = match index {
            object::ERROR_BEHAVIOR if value == 1 && self.has(Fault::ErrorBehaviourAlwaysLeaves) => 0,
            object::CONSUMER_HEARTBEAT_TIME if sub > 0 && self.has(Fault::HeartbeatConsumerLate) => {
                value & 0xFFFF_0000 | (value << 1) & 0xFFFF
            }
            _ => return pass(*frame),
        };
        let bytes = other.to_le_bytes();
        let value = bytes.get(..bytes.len().min(payload.value().map_or(4, <[u8]>::len))).unwrap_or(&bytes);
        pass(Request::download(multiplexer, value).to_frame(sdo::REQUEST_BASE + own))
    }

    fn refusal(&self, at: Multiplexer, value: u32) -> Option<AbortCode> {
        let is_mapping = object::is_pdo_mapping(at.index.0);
        if is_mapping && at.sub.0 == 0 && value != 0 && self.has(Fault::MappingProcedureRefused) {
            return Some(AbortCode::NOT_MAPPABLE);
        }
        if is_mapping && at.sub.0 == 0 && value != 0 && self.mapping_refused {
            return Some(AbortCode::DEVICE_STATE);
        }
        if at.index.0 == object::RPDO_MAPPING_PARAMETER
            && at.sub.0 > 0
            && value >> 16 < 0x20
            && self.has(Fault::DummyRefused)
        {
            return Some(AbortCode::NOT_MAPPABLE);
        }
        let same = at == Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER, 1)
            && value >> 31 == 0
            && self.cob_id == Some(value);
        (same && self.has(Fault::SameCobIdRefused)).then_some(AbortCode::INVALID_VALUE)
    }

    /// Handles a frame before it is sent; `None` drops the frame.
    pub fn on_send(&mut self, frame: Frame, node: Option<NodeId>) -> Option<Frame> {
        let id = frame.id().as_standard().unwrap_or(u16::MAX);
        let own = node.map_or(0, |node| u16::from(node.raw()));
        if self.muted && id != lss::SLAVE_CAN_ID {
            return None;
        }
        match id {
            lss::SLAVE_CAN_ID => self.lss_response(frame),
            sync::CAN_ID if frame.is_empty() && self.has(Fault::SyncAlwaysCounts) => {
                self.syncs = self.syncs.wrapping_add(1);
                Frame::new(frame.id(), &[(self.syncs % 240) as u8 + 1])
            }
            FREE if self.has(Fault::TpdoKeepsCanId) => Some(with_id(&frame, 0x180 + own)),
            _ if id == sdo::RESPONSE_BASE + own => Some(self.sdo_response(frame)),
            _ if id == 0x280 + own && self.has(Fault::SecondTpdoMissing) => None,
            _ if id == 0x180 + own => self.tpdo(frame),
            _ if id == emcy::CAN_ID_BASE + own && self.has(Fault::HeartbeatConsumerSilent) => {
                (!frame.data().starts_with(&[0x30, 0x81])).then_some(frame)
            }
            _ => Some(frame),
        }
    }

    fn tpdo(&self, frame: Frame) -> Option<Frame> {
        if self.writing && self.has(Fault::TpdoLostAfterSdo) {
            return None;
        }
        if self.has(Fault::TpdoTooLong) {
            return Some(Frame::full(frame.id(), frame.bytes()));
        }
        Some(if self.has(Fault::TpdoBytesReversed) { reversed(&frame) } else { frame })
    }

    fn sdo_response(&mut self, frame: Frame) -> Frame {
        self.writing = false;
        let id = frame.id().as_standard().unwrap_or_default();
        match Response::read(frame.data()) {
            Ok(Response::Abort(abort)) if self.forgives(abort.multiplexer, abort.code) => {
                Response::InitiateDownload { multiplexer: abort.multiplexer }.to_frame(id)
            }
            Ok(Response::Abort(abort)) => self.refused(abort.multiplexer, abort.code, frame),
            Ok(Response::InitiateUpload { multiplexer, payload }) => {
                let Some(bytes) = payload.value() else { return frame };
                let value = bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte));
                if multiplexer == Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER, 1) {
                    self.cob_id = Some(value);
                }
                let wrong = self.planted(multiplexer, value).to_le_bytes();
                let wrong = wrong.get(..bytes.len()).unwrap_or(&wrong);
                // A segment of a block may look like this response; an unchanged value leaves the frame as it is.
                if wrong == bytes { frame } else { Response::upload(multiplexer, wrong).to_frame(id) }
            }
            _ => frame,
        }
    }

    /// Handles the refusal of a download: returns the abort message of the server, or a faulty firmware's message with
    /// another code.
    fn refused(&mut self, at: Multiplexer, code: AbortCode, frame: Frame) -> Frame {
        let is_mapping = object::is_pdo_mapping(at.index.0);
        self.mapping_refused |= is_mapping && self.download.is_some() && self.has(Fault::MappingFailureWedges);
        let is_download = self.download.is_some_and(|(asked, _)| asked == at);
        if !is_download || code != AbortCode::NO_SUB_INDEX || !self.has(Fault::SdoRefusalAlternates) {
            return frame;
        }
        self.refusals = self.refusals.wrapping_add(1);
        let code = if self.refusals.is_multiple_of(2) { AbortCode::READ_ONLY } else { code };
        Response::abort(at, code).to_frame(frame.id().as_standard().unwrap_or_default())
    }
}

const fn pass(frame: Frame) -> Incoming {
    Incoming::Frames(frame, None)
}

fn put(bytes: &mut [u8; 8], value: u32) {
    bytes[1..5].copy_from_slice(&value.to_le_bytes());
}

fn with_id(frame: &Frame, id: u16) -> Frame {
    Frame::new(CanId::standard_masked(u32::from(id)), frame.data()).unwrap_or(*frame)
}

fn reversed(frame: &Frame) -> Frame {
    let bytes: Vec<u8> = frame.data().iter().rev().copied().collect();
    Frame::new(frame.id(), &bytes).unwrap_or(*frame)
}
