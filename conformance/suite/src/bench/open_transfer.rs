//! The SDO transfer that the tester has begun and that may still be open in the server.

use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{self, BlockSegment, Payload, Request, Response};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::Frame;

/// The transfers of the tester on the default SDO channel, as far as the frames show them.
#[derive(Debug)]
pub(super) struct OpenTransfer {
    request_id: u16,
    /// The object of the initiate request that the server has not answered yet.
    asked: Option<Multiplexer>,
    /// The object of a transfer that the server has begun. It counts as open after an abort, too: only a served request
    /// proves that the server has ended it.
    open: Option<Multiplexer>,
    /// Whether the last request ends the transfer once it is confirmed.
    is_last: bool,
    /// Whether the next frames of the tester are segments of a block.
    sends_block: bool,
    /// Whether the next frames of the server are segments of a block, whose first byte is no command.
    receives_block: bool,
}

impl OpenTransfer {
    pub const fn new(node: NodeId) -> Self {
        let request_id = sdo::REQUEST_BASE + node.raw() as u16;
        Self { request_id, asked: None, open: None, is_last: false, sends_block: false, receives_block: false }
    }

    /// The object of the transfer that may still be open.
    pub fn suspect(&self) -> Option<Multiplexer> {
        self.open.or(self.asked)
    }

    /// Follows a frame that the tester sends.
    pub fn on_sent(&mut self, frame: &Frame) {
        if frame.cob_id() != Some(self.request_id) {
            return;
        }
        let is_abort = frame.bytes()[0] == super::block::ABORT;
        if self.sends_block && !is_abort {
            let is_end = BlockSegment::read(frame.data()).is_ok_and(|segment| segment.last);
            self.sends_block = !is_end;
            return;
        }
        (self.sends_block, self.receives_block) = (false, false);
        match Request::read(frame.data()) {
            Ok(Request::DownloadSegment(segment)) => self.is_last = segment.last,
            Ok(Request::EndBlockDownload { .. }) => self.is_last = true,
            Ok(Request::EndBlockUpload) => self.has_ended(),
            Ok(Request::StartBlockUpload | Request::ConfirmBlockUpload { .. }) => self.receives_block = true,
            Ok(Request::Abort(_)) | Err(_) => {}
            Ok(request) => {
                self.asked = request.multiplexer().or(self.asked);
                self.is_last = matches!(
                    request,
                    Request::InitiateDownload { payload: Payload::Expedited(_) | Payload::ExpeditedUnsized(_), .. }
                );
            }
        }
    }

    /// Follows a frame that the device sends on the default SDO channel.
    pub fn on_answer(&mut self, frame: &Frame) {
        if frame.cob_id() != Some(self.request_id - sdo::REQUEST_BASE + sdo::RESPONSE_BASE) {
            return;
        }
        if self.receives_block && frame.bytes()[0] != super::block::ABORT {
            return;
        }
        match Response::read(frame.data()) {
            Ok(Response::InitiateUpload { payload, .. }) if payload.value().is_some() => self.has_ended(),
            Ok(Response::InitiateDownload { .. } | Response::DownloadSegment { .. } | Response::EndBlockDownload)
                if self.is_last =>
            {
                self.has_ended();
            }
            Ok(Response::UploadSegment(segment)) if segment.last => self.has_ended(),
            Ok(Response::InitiateBlockDownload { .. }) => {
                self.has_begun();
                self.sends_block = true;
            }
            Ok(
                Response::InitiateUpload { .. }
                | Response::InitiateDownload { .. }
                | Response::InitiateBlockUpload { .. },
            ) => self.has_begun(),
            // A refused request begins nothing, but may leave the transfer before it open. Only a served request shows
            // that the server has ended the earlier transfer.
            Ok(Response::Abort(_)) => self.asked = None,
            _ => {}
        }
    }

    fn has_begun(&mut self) {
        self.open = self.asked.take().or(self.open);
    }

    fn has_ended(&mut self) {
        self.asked = None;
        self.open = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scripted::frame;

    /// The object of the transfer that may be open after these frames of the tester (600h + node-ID) and the server
    /// (580h + node-ID).
    fn suspect(frames: &[&str]) -> Option<Multiplexer> {
        let mut transfer = OpenTransfer::new(NodeId::new(63).unwrap());
        for text in frames {
            match frame(text) {
                sent if text.starts_with("63F") => transfer.on_sent(&sent),
                answer => transfer.on_answer(&answer),
            }
        }
        transfer.suspect()
    }

    const BEGUN: [&str; 2] = ["63F#2117100002000000", "5BF#6017100000000000"];
    const HEARTBEAT_TIME: Option<Multiplexer> = Some(Multiplexer::new(0x1017, 0));

    #[test]
    fn a_transfer_is_open_until_its_end_is_confirmed() {
        let after = |more: &[&str]| suspect(&[&BEGUN, more].concat());
        assert_eq!(after(&[]), HEARTBEAT_TIME);
        assert_eq!(after(&["63F#0001000000000000", "5BF#2000000000000000"]), HEARTBEAT_TIME, "more segments follow");
        assert_eq!(after(&["63F#0B64000000000000"]), HEARTBEAT_TIME, "the last segment is not confirmed");
        assert_eq!(after(&["63F#0B64000000000000", "5BF#2000000000000000"]), None);
        assert_eq!(after(&["5BF#8017100000000405"]), HEARTBEAT_TIME, "the server may only refuse a request");
        assert_eq!(after(&["63F#8017100000000008"]), HEARTBEAT_TIME, "an abort of the client is not confirmed");
        assert_eq!(after(&["63F#8017100000000008", "63F#4000100000000000", "5BF#4300100096010200"]), None);
    }

    /// A server that is busy refuses a new request and keeps the transfer.
    #[test]
    fn a_refused_request_does_not_end_the_transfer_before_it() {
        let refused = |answer| suspect(&[BEGUN[0], BEGUN[1], "63F#4000100000000000", answer]);
        assert_eq!(refused("5BF#8000000021000008"), HEARTBEAT_TIME);
        assert_eq!(refused("5BF#8000100021000008"), HEARTBEAT_TIME);
        assert_eq!(refused("5BF#8017100021000008"), HEARTBEAT_TIME);
        assert_eq!(refused("5BF#4300100096010200"), None);
    }

    /// Segments of blocks are neither requests nor answers.
    #[test]
    fn segments_of_blocks_are_no_commands() {
        let name = Some(Multiplexer::new(0x1008, 0));
        let upload = ["63F#A408100014000000", "5BF#C608100014000000", "63F#A300000000000000", "5BF#8141424344454647"];
        assert_eq!(suspect(&upload), name, "81h is the last segment with number 1");
        assert_eq!(suspect(&[&upload[..], &["63F#A201140000000000", "5BF#C100000000000000"]].concat()), name);
        let end = ["63F#A201140000000000", "5BF#C100000000000000", "63F#A100000000000000"];
        assert_eq!(suspect(&[&upload[..], &end].concat()), None);
        let download = ["63F#C217100002000000", "5BF#A41710007F000000", "63F#2300100000000000"];
        assert_eq!(suspect(&download), HEARTBEAT_TIME, "23h is a segment with number 35");
        let end = ["63F#8100000000000000", "5BF#A2017F0000000000", "63F#D500000000000000", "5BF#A100000000000000"];
        assert_eq!(suspect(&[&download[..], &end].concat()), None);
    }

    #[test]
    fn a_request_without_an_answer_may_have_opened_a_transfer() {
        assert_eq!(suspect(&["63F#4008100000000000"]), Some(Multiplexer::new(0x1008, 0)));
        assert_eq!(suspect(&["63F#4008100000000000", "5BF#8008100000000206"]), None);
        assert_eq!(suspect(&["63E#4008100000000000"]), None, "it is sent to another node");
    }
}
