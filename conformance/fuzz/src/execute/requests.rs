//! The SDO messages that the executor sends in addition to the messages of the sequences.

use crate::stimulus::Stimulus;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{AbortCode, Payload, REQUEST_BASE, RESPONSE_BASE, Request, Response};
use canvass_analyzer::{Multiplexer, NodeId, object};
use canvass_traces::Frame;

/// Requests to the default SDO server of one node, and the recognition of its answers.
#[derive(Debug)]
pub(crate) struct Requests {
    request: u16,
    /// The CAN-ID of SDO responses.
    pub response: u16,
    /// Reads 1000h.
    pub probe: Frame,
    /// Ends a transfer.
    pub abort: Frame,
}

impl Requests {
    pub fn new(node: NodeId) -> Self {
        let node = u16::from(node.raw());
        let (request, response) = (REQUEST_BASE + node, RESPONSE_BASE + node);
        let abort = Request::abort(Multiplexer::new(0, 0), AbortCode::GENERAL).to_frame(request);
        let probe = Request::upload(Multiplexer::new(object::DEVICE_TYPE, 0)).to_frame(request);
        Self { request, response, probe, abort }
    }

    /// The request to read an object.
    pub fn read(&self, at: Multiplexer) -> Frame {
        Request::upload(at).to_frame(self.request)
    }

    /// Whether the frame is the value of the object in an expedited upload.
    pub fn is_value(&self, frame: &Frame, at: Multiplexer) -> bool {
        let response = Response::read(frame.data()).ok().filter(|_| frame.cob_id() == Some(self.response));
        let Some(Response::InitiateUpload { multiplexer, payload }) = response else { return false };
        multiplexer == at && !matches!(payload, Payload::Segmented(_) | Payload::SegmentedUnsized)
    }

    /// Whether answers to two frames that follow each other at once can be distinguished, although frames take time on
    /// the bus. Answers to SDO requests name their object. Other services don't: a late answer to the first frame would
    /// be taken for an answer to the second.
    pub(crate) fn are_told_apart(&self, first: &Stimulus, second: &Stimulus) -> bool {
        let is_request =
            |stimulus: &Stimulus| !stimulus.frame.is_remote() && stimulus.frame.cob_id() == Some(self.request);
        is_request(first) && is_request(second)
    }
}
